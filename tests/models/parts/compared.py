# SPDX-License-Identifier: Apache-2.0
"""Gates of a craft of parts: balances, and comparisons with particles and with definitions of limits and sensors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from mehvar.models.parts import Instrument, Part
from mehvar.models.quantities import Group
from mehvar.models.system import System
from mehvar.physics.gates import Gate, balance, identity
from mehvar.physics.machine import Array, Machine, Points, draw
from tests.reference.reference_parts import Particles
from tests.reference.reference_signals import Moment, acting, sampled, shown, starts

PARTICLES = "accelerations of particles"
READINGS = "energy and momentum of particles"
SIGNALS = {"actuate": "limits", "measure": "measurements", "jump": "states after a sample"}
"""Gates of what acts and what is shown, by the functions that they check."""


class Compared:
    """Gates of every craft, whose world of particles is evaluated once for all mutants.

    Parameters
    ----------
    world : Particles
        The craft as particles.
    start : bool
        True to compare states at the start too, for parts of which `starts` has them.
    """

    def __init__(self, world: Particles, start: bool = False) -> None:
        self.world, self.start = world, start
        self.memory: dict[tuple[str, bytes], Array] = {}

    def __call__(self, machine: Machine) -> list[Gate]:
        """Return the gates, the fastest first."""
        return [
            *self._events(machine.system),
            *self._signals(machine.system),
            identity(PARTICLES, lambda at: at.call("rhs"), lambda at: self._of_world(at, "rates")),
            identity(READINGS, lambda at: np.hstack([at.call("energy"), at.call("momentum")]),
                     lambda at: self._of_world(at, "readings")),
            balance("momentum", lambda at: at.call("momentum"), _supply),
            balance("energy", lambda at: at.call("energy"), lambda at: at.call("power")),
            *([identity("states at the start", lambda at: at.call("initial"), self._start)] if self.start else []),
        ]  # fmt: skip

    def _of_world(self, at: Points, what: str) -> Array:
        key = what, at.values["x"].tobytes()
        if key not in self.memory:
            self.memory[key] = np.array([self._row(at, what, k) for k in range(len(at.values["x"]))])
        return self.memory[key]

    def _row(self, at: Points, what: str, k: int) -> Any:
        system = at.machine.system
        x, u = (dict(zip([q.name for q in group], at.values[group.name][k], strict=False))
                for group in (system.states, system.inputs))  # fmt: skip
        if what == "rates":
            rates = {"clock": 1.0, **self.world.rates(x, u)}
            return [rates.get(q.name, 0.0) for q in system.states]  # biases and kept measurements have none
        return self.world.readings(x, u) if what == "readings" else self.world.found(what, x, u)

    def _start(self, at: Points) -> Array:
        system = at.machine.system
        given = {q.name: at[q.name] for q in system.scenario_parameters}
        own = {q.name: given.get(f"{q.name}_0", np.zeros(len(at.values["x"]))) for q in system.states}
        known = starts(given, self.world.parts, self.world.orbit)
        return _columns({name: known.get(name, value) for name, value in own.items()})

    def _events(self, system: System) -> Iterator[Gate]:
        if system.events:
            yield identity("guards of events", lambda at: at.call("guards"), lambda at: self._of_world(at, "guards"))
        if system.limits:
            yield identity("margins of limits", lambda at: at.call("limits"), lambda at: self._of_world(at, "margins"))
        if self.world.resets:
            yield Gate("states after events", self._reset)

    def _reset(self, at: Points) -> tuple[Array, Array]:
        """Return the state after the first event, by the system and by particles."""
        after = _states(at) | dict(zip(self.world.resets, self._of_world(at, "resets").T, strict=True))
        first = np.zeros((len(at.values["x"]), 1))
        return at.machine("resets", *(at.values[name] for name in "xup"), first), _columns(after)

    def _signals(self, system: System) -> Iterator[Gate]:
        inputs = [q.name for q in system.inputs]
        if system.actuator:
            yield self._signal("actuate", system.actuator.commanded, inputs, lambda now: self._each(acting, Part, now))
        if system.sensor:
            yield self._signal(
                "measure", system.sensor.noise, [q.name for q in system.sensor.noise],
                lambda now: self._each(shown, Instrument, now) | {n: now.x[n] for n in ("clock",) if n in now.x},
            )  # fmt: skip
        if system.random_step:
            yield self._signal(
                "jump", system.random_step.noise, [q.name for q in system.random_step.noise],
                lambda now: {**now.x, **self._each(sampled, Part, now)},
            )  # fmt: skip

    def _each(self, of: Callable[..., dict[str, Array]], kind: type[Part], now: Moment) -> dict[str, Array]:
        found = [of(part, now) for part in self.world.parts if isinstance(part, kind)]
        return {name: value for values in found for name, value in values.items()}

    def _signal(
        self, function: str, group: Group, names: list[str], wanted: Callable[[Moment], dict[str, Array]]
    ) -> Gate:
        def sides(at: Points) -> tuple[Array, Array]:
            here = _at_ends(at)
            given = draw(at.machine.ranges, group, len(here.values["x"]), np.random.default_rng(1))
            named = dict(zip(names, given.T, strict=False))
            now = Moment(_states(here), named, self._of_world(here, "sky"), self.world.period)
            return at.machine(function, here.values["x"], given, here.values["p"]), _columns(wanted(now))

        return Gate(SIGNALS[function], sides)


def _at_ends(at: Points) -> Points:
    """Return the points with every other clock of pulses at the end of a period."""
    clocks = {name: value for name, value in _states(at).items() if name.endswith("_clock")}
    return at.moved(**{n: np.where(np.arange(len(v)) % 2, np.sign(v), v) for n, v in clocks.items()})


def _states(at: Points) -> dict[str, Array]:
    return {q.name: at[q.name] for q in at.machine.system.states}


def _columns(values: dict[str, Array]) -> Array:
    return np.stack(list(values.values()), axis=-1)


def _triple(at: Points, start: str) -> Array:
    known = _states(at)
    return np.stack([known.get(f"{start}{a}", 0 * at["wx"]) for a in "xyz"], axis=-1)


def _supply(at: Points) -> Array:
    v, w, momentum = _triple(at, "v"), _triple(at, "w"), at.call("momentum")
    linear, angular = momentum[:, :3], momentum[:, 3:]
    turned = np.hstack([np.cross(w, linear), np.cross(w, angular) + np.cross(v, linear)])
    return np.asarray(at.call("loads") - turned)
