# SPDX-License-Identifier: Apache-2.0
"""A sampled loop around the generated satellite, many runs side by side."""

from __future__ import annotations

import functools
import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.manifest import Controller, Manifest, Parameter, read_manifest
from mehvar.codegen.generate import write
from mehvar.runtime.model.functions import Functions
from mehvar.runtime.model.model import load
from tests.derived import generated, variant

Array = NDArray[np.float64]
Settings = Mapping[str, float]
Case = tuple[str, Settings]
"""A scenario and further settings."""
_OPTIONS = ("delay",)


@dataclass(frozen=True)
class Generated:
    """The generated satellite with functions and manifest, loaded at first use."""

    chart: str

    @functools.cached_property
    def folder(self) -> Path:
        """The committed files, or files of a variant in a temporary folder."""
        if self.chart == "euler":
            return generated("satellite")
        folder = Path(_scratch().name) / f"satellite_{self.chart}"
        write(folder, variant("satellite", chart=self.chart))
        return folder

    @functools.cached_property
    def functions(self) -> Functions:
        """The generated functions, compiled: an evaluation takes a tenth of one in NumPy."""
        return load(self.folder, backend="c").functions

    @functools.cached_property
    def manifest(self) -> Manifest:
        """The manifest, with the order of all vectors."""
        return read_manifest(self.folder)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name.startswith("_"):  # what pytest asks of everything while it collects, which must not derive
            raise AttributeError(name)
        return self.functions[name]

    def names(self, key: str) -> list[str]:
        """Return the names of the states, inputs, ..."""
        return [q.name for q in getattr(self.manifest, key)]

    def law(self, law: str) -> Controller:
        """Return the entry of a law in the manifest."""
        return self.manifest.controllers[law]

    def memory(self, law: str) -> list[str]:
        """Return the names of a law's memory."""
        return [q.name for q in self.law(law).memory]

    def parameters(self, settings: Settings, law: str = "pd", scenario: str = "paper") -> tuple[Array, Array, Array]:
        """Return p, c and s: defaults, then the scenario, then the settings."""
        table = self.manifest.scenarios[scenario]
        values = {**table.values, **table.controllers.get(law, {}), **settings}
        groups = (self.manifest.parameters, self.law(law).parameters, self.manifest.scenario_parameters)
        unknown = set(values) - {q.name for group in groups for q in group} - set(_OPTIONS)
        assert not unknown, unknown
        return tuple(np.array([_value(q, values, group) for q in group]) for group in groups)  # type: ignore[return-value]


def _value(q: Parameter, values: Settings, group: Sequence[Parameter]) -> float:
    if q.name in values:
        return float(values[q.name])
    if q.default is not None:
        return q.default
    source = next(other for other in group if other.name == q.formula)
    return _value(source, values, group)


@functools.cache
def satellite(chart: str = "euler") -> Generated:
    """Return the satellite in one of its charts."""
    return Generated(chart)


@functools.cache
def _scratch() -> tempfile.TemporaryDirectory[str]:
    """Return a folder that is removed at the end of the process."""
    return tempfile.TemporaryDirectory(prefix="satellite-")


@dataclass(frozen=True)
class Runs:
    """Samples of several runs: axes are sample, run, quantity. `lost` is when a run's torque or pitch passed its limit.

    `z` is the memory as the law found it; `u` the torque that acted after the sample.
    """

    t: Array
    x: Array
    u: Array
    z: Array
    r: Array
    lost: Array
    angles: Array = field(repr=False)

    def memory(self, generated: Generated, law: str, *names: str) -> Array:
        """Return memory variables by name, stacked along the last axis."""
        known = generated.memory(law)
        return np.stack([self.z[..., known.index(name)] for name in names], axis=-1)


def run(
    generated: Generated,
    law: str,
    cases: Sequence[Case],
    samples: int = 1600,
    substeps: int = 5,
    seed: int | None = None,
    corrupt: Callable[[int, Array], Array] = lambda _k, x: x,
) -> Runs:
    """Run a law for several cases at once, with Runge-Kutta 4 between the samples.

    A run counts as lost, and stays where it is, when |u| > 1e4 N m was commanded or the state is no longer finite.
    """
    with np.errstate(all="ignore"):
        return _Loop(generated, law, cases, seed, corrupt).run(samples, substeps)


class _Loop:
    def __init__(
        self,
        generated: Generated,
        law: str,
        cases: Sequence[Case],
        seed: int | None,
        corrupt: Callable[[int, Array], Array],
    ) -> None:
        vectors = [generated.parameters(settings, law, scenario) for scenario, settings in cases]
        self.p, self.c, self.s = (np.stack(group) for group in zip(*vectors, strict=True))
        self.delay = np.array([int(settings.get("delay", 0)) for _, settings in cases])
        self.generated = generated
        self.corrupt = corrupt
        self.random = np.random.default_rng(seed) if seed is not None else None
        tag = law.replace("-", "_")
        self.law, self.start = getattr(generated, tag), getattr(generated, f"{tag}_start")
        self.period = float(self.p[0, generated.names("parameters").index("Ts")])

    def measured(self, k: int, x: Array) -> Array:
        size = len(self.generated.manifest.noise)
        e = np.zeros((len(x), size)) if self.random is None else self.random.standard_normal((len(x), size))
        return self.corrupt(k, self.generated.measure(x, e, self.p))

    def run(self, samples: int, substeps: int) -> Runs:
        g, p, c, s = self.generated, self.p, self.c, self.s
        x = g.initial(p, s)
        z = self.start(self.measured(0, x), g.reference(np.zeros(len(x)), p, s), p, c)
        before = applied = np.zeros((len(x), 3))
        lost = np.full(len(x), math.inf)
        rows: list[tuple[Array, ...]] = []
        for k in range(samples):
            t = k * self.period
            r = g.reference(np.full(len(x), t), p, s)
            u_cmd, z_next = self.law(self.measured(k, x), r, applied, z, p, c)
            acting = np.where(self.delay[:, None] > 0, before, u_cmd)
            before, applied = u_cmd, g.actuate(x, acting, p)
            fails = ~(np.abs(u_cmd).max(axis=-1) <= 1e4) | ~np.isfinite(x).all(axis=-1)
            lost = np.where(fails & np.isinf(lost), t, lost)
            rows.append((x, applied, z, r))
            if np.isfinite(lost).all():
                break
            x = np.where(np.isfinite(lost)[:, None], x, self.advance(x, applied, substeps))
            z = z_next
        xs, us, zs, rs = (np.stack(column) for column in zip(*rows, strict=True))
        t = np.arange(len(xs)) * self.period
        y = g.outputs(xs, us, rs, p)
        angles = ("roll", "pitch", "yaw")
        named = {n: xs[..., i] for i, n in enumerate(g.names("states"))}
        named |= {n: y[..., i] for i, n in enumerate(g.names("outputs"))}
        return Runs(t, xs, us, zs, rs, lost, np.stack([named[a] for a in angles], axis=-1))

    def advance(self, x: Array, u: Array, substeps: int) -> Array:
        h, slope = self.period / substeps, self.generated.rhs
        for _ in range(substeps):
            k1 = slope(x, u, self.p)
            k2 = slope(x + h / 2 * k1, u, self.p)
            k3 = slope(x + h / 2 * k2, u, self.p)
            k4 = slope(x + h * k3, u, self.p)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return x
