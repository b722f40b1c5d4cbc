# SPDX-License-Identifier: Apache-2.0
"""Variables of an FMU, in groups of a fixed order; their positions are the value references."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mehvar.base.capabilities import Operation, refuse
from mehvar.base.manifest import OPEN_LOOP, Controller, Event, Parameter, Quantity
from mehvar.base.names import identifier
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.model import Model
from mehvar.runtime.model.parameters import resolve
from mehvar.runtime.run.calls import events_of, loop_calls

Kind = Literal["plant", "loop", "sampled"]
KINDS: tuple[Kind, ...] = ("plant", "loop", "sampled")
"""Kinds of FMU: plant alone, continuous loop, sampled loop; numbered as in native/fmu/core.h."""
_IDLE = " (without effect in this FMU)"
_STATES = 64
"""Number of random states at which a sensor's branches are tested."""
NO_LAW = Controller(name=OPEN_LOOP, title="", memory=(), period=None, parameters=(), constraints=(), warnings=())


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    Attributes
    ----------
    name, unit, description : str
        As in the manifest; parameters are called `plant.NAME` and `law.NAME`,
        references `reference.NAME`, coordinates that are not the states `chart.NAME`.
    role : str
        "time", "parameter", "constant" for a parameter without effect, "input", "state", "derivative", "output",
        "discrete" or "local".
    start : float
        Start value; unused if it follows from other variables.
    bounds : tuple of float
        Least and greatest value of a parameter.
    """

    name: str
    unit: str
    description: str
    role: str
    start: float = 0.0
    bounds: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True)
class Subject:
    """Contents of an FMU: a model, its law or None, and its variables by group.

    Attributes
    ----------
    model : Model
        Model of the generated folder.
    law : Controller or None
        The law.
    kind : str
        One of `KINDS`.
    groups : mapping of str to tuple of Variable
        T time, P, C, R, U, Q the continuous states, D their derivatives, X, Y, Z, M, G as in native/fmu/core.h.
    period : float or None
        Sample period of a sampled law, s.
    duration, step : float
        Duration and step of the scenario, s.
    s : array
        Parameters of the scenario, for the model's conditions.
    """

    model: Model
    law: Controller | None
    kind: Kind
    groups: dict[str, tuple[Variable, ...]]
    period: float | None
    duration: float
    step: float
    s: FloatArray

    @property
    def events(self) -> tuple[Event, ...]:
        """Events of the loop, each with one guard."""
        return events_of(self.model.manifest, self.law or NO_LAW, self.kind != "loop")

    @property
    def variables(self) -> tuple[Variable, ...]:
        """All variables in the order of their value references."""
        return tuple(variable for group in self.groups.values() for variable in group)

    def first(self, group: str) -> int:
        """Return the value reference of the first variable of a group."""
        names = list(self.groups)
        return sum(len(self.groups[name]) for name in names[: names.index(group)])


def subject(model: Model, controller: str | None, scenario: str | None) -> Subject:
    """Return the variables of a model with or without a law, with the start values of a scenario.

    Raises
    ------
    InputError
        If law or scenario is unknown, or parameters contradict each other.
    """
    manifest = model.manifest
    law = None if controller is None else manifest.controller(controller)
    refuse(manifest, Operation.FMU, law)
    case = manifest.scenario(scenario)
    kind: Kind = "plant" if law is None else "loop" if law.period is None else "sampled"
    resolved = resolve(manifest, model.functions, law or NO_LAW, case, {}, "the call")
    p, c, s = resolved.p, resolved.c, resolved.s
    x = np.asarray(model.functions["initial"](p, s))
    r = np.asarray(model.functions["reference"](0.0, p, s))
    charted = law is not None and "to_coordinates" in loop_calls(manifest, law, "", kind == "sampled")
    q = np.asarray(model.functions["to_coordinates"](x)) if charted else x
    continuous = manifest.coordinates if charted else manifest.states
    chart = "chart." if charted else ""  # coordinates of the chart may have the names of states
    own, memory = (law.parameters, law.memory) if law else ((), ())
    acting = _acting(model, law or NO_LAW, kind, x, p)
    groups = {
        "T": (Variable("time", "s", "time", "time"),),
        "P": _parameters("plant.", manifest.parameters, p, acting),
        "C": _parameters("law.", own, c, acting),
        "R": _group(manifest.references, "input", r, "reference."),
        "U": _group(manifest.inputs, {"plant": "input", "loop": "output", "sampled": "discrete"}[kind],
                    prefix="" if law is None else "u_"),
        "Q": _group(continuous, "state", q, chart),
        "D": tuple(
            Variable(f"der({chart}{v.name})", _rate(v.unit), f"rate of {v.name}", "derivative") for v in continuous
        ),
        "X": _group(manifest.states, "output") if charted else (),
        "Y": _group(manifest.outputs, "output"),
        "Z": _group(memory, "discrete"),
        "M": tuple(
            Variable(f"limit_{k}", "1", f"ends the run at zero: {text}", "local")
            for k, text in enumerate(manifest.limits)
        ),
        "G": tuple(
            Variable(f"guard.{event.name}", "1", f"crosses zero at an event: {event.title}", "local")
            for event in events_of(manifest, law or NO_LAW, kind != "loop")
        ),
    }  # fmt: skip
    period = float(resolved.values[law.period]) if law and law.period else None
    return Subject(model, law, kind, groups, period, case.duration, case.step, s)


def _group(
    quantities: Sequence[Quantity], role: str, start: FloatArray | None = None, prefix: str = ""
) -> tuple[Variable, ...]:
    values = np.zeros(len(quantities)) if start is None else start
    return tuple(
        Variable(f"{prefix}{q.name}", q.unit, q.description, role, float(value))
        for q, value in zip(quantities, values, strict=True)
    )


def _parameters(
    prefix: str, parameters: Sequence[Parameter], values: FloatArray, acting: frozenset[str]
) -> tuple[Variable, ...]:
    """Return the variables of parameters; one without effect is a constant, and its description says so."""
    roles = ["parameter" if q.name in acting else "constant" for q in parameters]
    return tuple(
        Variable(
            f"{prefix}{q.name}", q.unit, q.description + (_IDLE if role == "constant" else ""), role, float(value),
            (q.lower, q.upper),
        )
        for q, role, value in zip(parameters, roles, values, strict=True)
    )  # fmt: skip


def _acting(model: Model, law: Controller, kind: Kind, x: FloatArray, p: FloatArray) -> frozenset[str]:
    """Return the parameters with an effect; an FMU has no noise or delay, and a plant without law no actuator."""
    manifest = model.manifest
    calls = {identifier(f.name) for f in loop_calls(manifest, law, "", kind != "loop").values()} - {"reference"}
    calls -= {"actuate", "measure"} if law is NO_LAW else set()
    rows = (*manifest.parameters, *law.parameters)
    acting = {q.name for q in rows if not calls.isdisjoint(q.readers) or q.name == law.period}
    others = {q.name for q in rows if not (calls - {"measure"}).isdisjoint(q.readers) or q.name == law.period}
    return frozenset(others | {name for name in acting - others if _measures(model, name, x, p)})


def _measures(model: Model, name: str, x: FloatArray, p: FloatArray) -> bool:
    """Return True if a parameter affects noise-free measurements, at random states around x."""
    place = [q.name for q in model.manifest.parameters].index(name)
    row = model.manifest.parameters[place]
    states = x + np.random.default_rng(0).normal(0, 1, (_STATES, len(x)))
    values = [np.clip(value, row.lower, row.upper) for value in (0.0, 0.5, 1.0, 1.5 * p[place])]
    points = np.repeat(p[None], len(values), 0)
    points[:, place] = values
    none = np.zeros(len(model.manifest.noise))
    measured = model.functions["measure"](states[:, None], none, points)
    return not np.array_equal(measured, np.repeat(measured[:, :1], len(values), 1), equal_nan=True)


def _rate(unit: str) -> str:
    """Return the unit of the rate of a quantity: "rad/s" becomes "rad/s^2"."""
    if unit == "1":
        return "1/s"
    return f"{unit.removesuffix('/s')}/s^2" if unit.endswith("/s") else f"{unit}/s"
