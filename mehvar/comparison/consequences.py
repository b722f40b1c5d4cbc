# SPDX-License-Identifier: Apache-2.0
"""Effects of a changed model on laws, rates, eigenvalues and operation counts, from runs of both versions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mehvar.base.errors import InputError
from mehvar.base.manifest import read_manifest
from mehvar.runtime.model.functions import PythonBackend
from mehvar.runtime.model.model import Model

from .runs import Overlay, Runs, runs
from .sides import Point, Side, Sides, shared
from .spectra import Loop, Pairs, loops, moved

SAMPLES = 512
"""Number of random states; the reported largest difference is exceeded at half a percent of them."""
_SEED = 20250
_SMALL = 0.1
"""Displacement of states with initial value zero, in SI units: a tenth of a radian or of a metre per second."""
_ROUNDING = 1e-9
"""Rounding error relative to a rate: another order of some thousand operations changes a rate by about 1e-13 of its
parts."""


@dataclass(frozen=True)
class Rate:
    """Change of the rate of one state.

    Attributes
    ----------
    name, unit : str
        The state and the unit of its rate.
    largest : float
        Largest difference between old and new over the sampled states.
    typical : float
        Root mean square of the old rate over the same states.
    """

    name: str
    unit: str
    largest: float
    typical: float


@dataclass(frozen=True)
class Consequences:
    """Effects of a change; each side uses its own default parameters.

    Attributes
    ----------
    rates : tuple of Rate
        States whose rates differ by more than rounding.
    samples : int
        States and inputs at which the rates were compared: random, of the size of the first scenario's start.
    point : tuple of (str, float)
        Linearisation point of the old model: at rest near zero, or near the first scenario's start, without zeros.
    residual : float
        Largest rate of the old model at that point; zero at an equilibrium.
    eigenvalues : tuple of (complex, complex)
        Eigenvalues of the old and of the new Jacobian, matched; only pairs that differ, without conjugates.
    loops : tuple of Loop
        Closed loops whose eigenvalues differ.
    operations : tuple of (str, int, int)
        Functions whose number of operations differs.
    runs : Runs
        Results of all scenarios under all laws.
    note : str
        Reason for missing results.
    new_point : tuple of (str, float)
        Linearisation point of the new model, likewise.
    """

    rates: tuple[Rate, ...] = ()
    samples: int = 0
    point: Point = ()
    residual: float = 0.0
    eigenvalues: Pairs = ()
    loops: tuple[Loop, ...] = ()
    operations: tuple[tuple[str, int, int], ...] = ()
    runs: Runs = field(default_factory=Runs)
    note: str = ""
    new_point: Point = ()


def consequences(old: Path, new: Path, names: Mapping[str, str]) -> tuple[Consequences, Overlay | None]:
    """Run both versions; return the effects and the run that differs most.

    Parameters
    ----------
    old, new : Path
        Generated folders of one model.
    names : mapping of str to str
        New names by old ones.
    """
    try:
        sides = Side(_loaded(old), names), Side(_loaded(new), {})
    except (InputError, OSError, SyntaxError) as error:
        return Consequences(note=f"not computed: {error}"), None
    counts = shared(*(side.model.manifest.functions for side in sides))
    pairs = [(name, a.operations, b.operations) for name, (a, b) in counts.items() if a.operations != b.operations]
    operations = tuple(pairs)
    if missing := _unshared(sides):
        return Consequences(operations=operations, note=f"rates, eigenvalues and runs not compared: {missing}"), None
    with np.errstate(all="ignore"):  # results without bounds are reported as such
        rates, samples = _rates(sides)
        points = [side.rest() for side in sides]
        slopes = [side.slope(point) for side, point in zip(sides, points, strict=True)]
        closed, missing = loops(sides)
        residual = float(np.max(np.abs(sides[0].rates(points[0]))))
        closed_runs, overlay = runs(old, new, names)
    follows = Consequences(
        rates,
        samples,
        sides[0].point(points[0]),
        residual,
        moved(*slopes),
        closed,
        operations,
        closed_runs,
        missing,
        sides[1].point(points[1]),
    )
    return follows, overlay


def _loaded(folder: Path) -> Model:
    """Load a model with a manifest of any version, as comparisons do not need newer fields."""
    manifest = read_manifest(folder, any_age=True)
    return Model(manifest.whole, PythonBackend(manifest))


def _unshared(sides: Sides) -> str:
    """Return the reason why the motions of both versions cannot be compared; empty if they can."""
    if any(side.model.manifest.algebraic for side in sides):
        return "algebraic states"
    alone = []
    for what in ("state", "input"):
        old, new = (getattr(side, f"{what}s") for side in sides)
        for side, mine, other in (("old", old, new), ("new", new, old)):
            if own := [name for name in mine if name not in other]:
                alone.append(f"only the {side} version has the {what}{'s' * (len(own) > 1)} {', '.join(own)}")
    return "; ".join(alone)


def _rates(sides: Sides) -> tuple[tuple[Rate, ...], int]:
    """Compare rates at random states around the first scenario's start, within the limits of both models."""
    first, second = sides
    random = np.random.default_rng(_SEED)
    size = np.maximum(np.abs(first.start), _SMALL)
    x = random.uniform(-size, size, (SAMPLES, len(size)))
    u = random.uniform(-1.0, 1.0, (SAMPLES, len(first.inputs)))
    states = [second.states.index(name) for name in first.states]
    inputs = [second.inputs.index(name) for name in first.inputs]
    valid = np.ones(SAMPLES, dtype=bool)
    values = []
    for side, a, b in ((first, x, u), (second, x[:, np.argsort(states)], u[:, np.argsort(inputs)])):
        values.append(side.rates(a, b))
        valid &= np.all(np.isfinite(values[-1]), axis=-1)
        if side.model.manifest.limits:
            valid &= np.all(side.model.functions["limits"](a, b, side.model.parameters()) > 0, axis=-1)
    if not np.any(valid):
        return (), 0
    old, new = values[0][valid], values[1][valid][:, states]
    largest, typical = np.max(np.abs(new - old), axis=0), np.sqrt(np.mean(old**2, axis=0))
    rates = [
        Rate(name, f"{q.unit[:-2]}/s^2" if q.unit.endswith("/s") else f"{q.unit}/s", float(a), float(b))
        for name, q, a, b in zip(first.states, first.model.manifest.states, largest, typical, strict=True)
        if a > _ROUNDING * max(b, 1e-300)
    ]
    return tuple(rates), len(old)
