# SPDX-License-Identifier: Apache-2.0
"""Variables of an FMU: groups of variables in a fixed order, whose positions are the value references."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mehvar.base.capabilities import Place, refuse
from mehvar.base.manifest import OPEN_LOOP, Controller, Event, Parameter, Quantity
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.model import Model
from mehvar.runtime.model.parameters import resolve
from mehvar.runtime.run.calls import events_of, loop_calls

Kind = Literal["plant", "loop", "sampled"]
KINDS: tuple[Kind, ...] = ("plant", "loop", "sampled")
"""Kinds of FMU: plant alone, continuous loop, sampled loop; numbered as in native/fmu/core.h."""
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
        "time", "parameter", "input", "state", "derivative", "output", "discrete" or "local".
    start : float
        Its value at the start; not used where it follows from others.
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
        Parameters of the scenario, which the model's conditions use.
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
        """Events of the loop, one guard each."""
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
        For an unknown law or scenario, or parameters that do not fit together.
    """
    manifest = model.manifest
    law = None if controller is None else manifest.controller(controller)
    refuse(manifest, Place.FMU, law)
    case = manifest.scenario(scenario)
    kind: Kind = "plant" if law is None else "loop" if law.period is None else "sampled"
    resolved = resolve(manifest, model.functions, law or NO_LAW, case, {}, "the call")
    p, c, s = resolved.p, resolved.c, resolved.s
    x = np.asarray(model.functions["initial"](p, s))
    r = np.asarray(model.functions["reference"](0.0, p, s))
    charted = law is not None and "to_coordinates" in loop_calls(manifest, law, "", kind == "sampled")
    q = np.asarray(model.functions["to_coordinates"](x)) if charted else x
    continuous = manifest.coordinates if charted else manifest.states
    own, memory = (law.parameters, law.memory) if law else ((), ())
    groups = {
        "T": (Variable("time", "s", "time", "time"),),
        "P": _parameters("plant.", manifest.parameters, p),
        "C": _parameters("law.", own, c),
        "R": _group(manifest.references, "input", r, "reference."),
        "U": _group(manifest.inputs, {"plant": "input", "loop": "output", "sampled": "discrete"}[kind],
                    prefix="" if law is None else "u_"),
        "Q": _group(continuous, "state", q),
        "D": tuple(
            Variable(f"der({v.name})", _rate(v.unit), f"rate of {v.name}", "derivative") for v in continuous
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
    if charted:  # coordinates of the chart may have the names of states
        groups["Q"] = tuple(Variable(f"chart.{v.name}", v.unit, v.description, "state", v.start) for v in groups["Q"])
        groups["D"] = tuple(
            Variable(f"der(chart.{v.name})", _rate(v.unit), f"rate of {v.name}", "derivative") for v in continuous
        )
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


def _parameters(prefix: str, parameters: Sequence[Parameter], values: FloatArray) -> tuple[Variable, ...]:
    return tuple(
        Variable(f"{prefix}{q.name}", q.unit, q.description, "parameter", float(value), (q.lower, q.upper))
        for q, value in zip(parameters, values, strict=True)
    )


def _rate(unit: str) -> str:
    """Return the unit of the rate of a quantity: "rad/s" becomes "rad/s^2"."""
    if unit == "1":
        return "1/s"
    return f"{unit.removesuffix('/s')}/s^2" if unit.endswith("/s") else f"{unit}/s"
