# SPDX-License-Identifier: Apache-2.0
"""Effects of a changed model on laws, rates, eigenvalues and operation counts, from runs of both versions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mehvar.base.errors import InputError
from mehvar.base.manifest import read_manifest
from mehvar.runtime.model.functions import FloatArray, PythonBackend, displacement
from mehvar.runtime.model.model import Model

from .runs import Overlay, Runs, runs
from .spectra import Loop, loops, moved, named, rest, start, undifferentiated

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
    point: tuple[tuple[str, float], ...] = ()
    residual: float = 0.0
    eigenvalues: tuple[tuple[complex, complex], ...] = ()
    loops: tuple[Loop, ...] = ()
    operations: tuple[tuple[str, int, int], ...] = ()
    runs: Runs = field(default_factory=Runs)
    note: str = ""
    new_point: tuple[tuple[str, float], ...] = ()


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
        before, after = _loaded(old), _loaded(new)
    except (InputError, OSError, SyntaxError) as error:
        return Consequences(note=f"not computed: {error}"), None
    operations = _operations(before, after)
    if missing := _unshared(before, after, names):
        return Consequences(operations=operations, note=f"rates, eigenvalues and runs not compared: {missing}"), None
    with np.errstate(all="ignore"):  # results without bounds are reported as such
        rates, samples = _rates(before, after, names)
        old_point, new_point = _rest(before), _rest(after)
        pairs = moved(_slope(before, old_point), _slope(after, new_point))
        closed, missing = _loops(before, after, names)
        residual = float(np.max(np.abs(_rhs(before, old_point, np.zeros(len(before.input_names))))))
        closed_runs, overlay = runs(old, new, names)
    follows = Consequences(
        rates,
        samples,
        named(_new(before.state_names, names), old_point),
        residual,
        pairs,
        closed,
        operations,
        closed_runs,
        missing,
        named(after.state_names, new_point),
    )
    return follows, overlay


def _unshared(before: Model, after: Model, names: Mapping[str, str]) -> str:
    """Return the reason why the motions of both versions cannot be compared; empty if they can."""
    if before.manifest.algebraic or after.manifest.algebraic:
        return "algebraic states"
    alone = []
    for what, old, new in (
        ("state", before.state_names, after.state_names),
        ("input", before.input_names, after.input_names),
    ):
        former = _new(old, names)
        for side, mine, other in (("old", former, new), ("new", new, former)):
            if own := [name for name in mine if name not in other]:
                alone.append(f"only the {side} version has the {what}{'s' * (len(own) > 1)} {', '.join(own)}")
    return "; ".join(alone)


def _new(old: Iterable[str], names: Mapping[str, str]) -> list[str]:
    return [names.get(name, name) for name in old]


def _loops(before: Model, after: Model, names: Mapping[str, str]) -> tuple[tuple[Loop, ...], str]:
    """Return the closed loops whose eigenvalues differ, and reasons why others could not be compared."""
    closed, refused = loops(before, after, names)
    if undifferentiated((before, after)):
        refused = ("one of the versions has no derivatives of its laws", *refused)
    return closed, f"loops and margins not compared: {'; '.join(refused)}" if refused else ""


def _loaded(folder: Path) -> Model:
    """Load a model with a manifest of any version, as comparisons do not need newer fields."""
    manifest = read_manifest(folder, any_age=True)
    return Model(manifest.whole, PythonBackend(manifest))


def _operations(before: Model, after: Model) -> tuple[tuple[str, int, int], ...]:
    old, new = before.manifest.functions, after.manifest.functions
    shared = [name for name in new if name in old]
    counts = [(name, old[name].operations, new[name].operations) for name in shared]
    return tuple(row for row in counts if row[1] != row[2])


def _rhs(model: Model, x: FloatArray, u: FloatArray) -> FloatArray:
    return model.rhs(x, u, model.parameters())


def _rates(before: Model, after: Model, names: Mapping[str, str]) -> tuple[tuple[Rate, ...], int]:
    """Compare rates at random states around the first scenario's start, within the limits of both models."""
    random = np.random.default_rng(_SEED)
    size = np.maximum(np.abs(start(before)), _SMALL)
    x = random.uniform(-size, size, (SAMPLES, len(size)))
    u = random.uniform(-1.0, 1.0, (SAMPLES, len(before.input_names)))
    states, inputs = (
        [new.index(name) for name in _new(old, names)]
        for old, new in ((before.state_names, after.state_names), (before.input_names, after.input_names))
    )
    valid = np.ones(SAMPLES, dtype=bool)
    values = []
    for model, a, b in ((before, x, u), (after, x[:, np.argsort(states)], u[:, np.argsort(inputs)])):
        values.append(_rhs(model, a, b))
        valid &= np.all(np.isfinite(values[-1]), axis=-1)
        if model.manifest.limits:
            valid &= np.all(model.functions["limits"](a, b, model.parameters()) > 0, axis=-1)
    if not np.any(valid):
        return (), 0
    old, new = values[0][valid], values[1][valid][:, states]
    largest, typical = np.max(np.abs(new - old), axis=0), np.sqrt(np.mean(old**2, axis=0))
    rates = [
        Rate(
            names.get(q.name, q.name),
            f"{q.unit[:-2]}/s^2" if q.unit.endswith("/s") else f"{q.unit}/s",
            float(a),
            float(b),
        )
        for q, a, b in zip(before.manifest.states, largest, typical, strict=True)
        if a > _ROUNDING * max(b, 1e-300)
    ]
    return tuple(rates), len(old)


def _rest(model: Model) -> FloatArray:
    """Search for an equilibrium without inputs, starting at the zero state or a scenario's start."""
    p, u = model.parameters(), np.zeros(len(model.input_names))
    x = np.asarray(model.state())
    if not (np.all(np.isfinite(model.rhs(x, u, p))) and np.all(np.isfinite(model.jac_x(x, u, p)))):
        x = start(model)

    def projection(state: FloatArray) -> FloatArray:
        change = displacement(model.manifest, model.functions, state, p)
        return state + change if change.size else state

    return rest(lambda v: model.rhs(v, u, p), lambda v: model.jac_x(v, u, p), projection, x)


def _slope(model: Model, x: FloatArray) -> FloatArray:
    return model.jac_x(x, np.zeros(len(model.input_names)), model.parameters())
