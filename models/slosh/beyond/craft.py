# SPDX-License-Identifier: Apache-2.0
"""The paper's system with what it leaves out put in."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from ...system import Condition, Derivation, Event, Expr, Function, Group, Quantity, System
from ...tables import read_parameters, read_scenarios
from ..laws.controllers import Law
from ..states import DEMAND, Pendulum, rate, velocity
from .derived import Sum, residuals, show, sums
from .dynamics import control_moments, craft
from .engine import ANGLES, acting, gimbal_rates
from .gravity import gradient
from .monitors import monitors
from .regulator import regulator
from .tanks import BURNT, Fuel, Present, drained, place_parameters

_HERE = Path(__file__).parent
_EMPTY = sp.Rational(9, 10)
"""Part of the fuel at whose burning a run ends: the last point of the tables, beyond which they do not go."""
_NONE = sp.Rational(1, 10**9)
"""Part of the fuel that is none: runs begin with nothing burnt."""

_REGULATED = 2
"""Tanks that the regulator is made for: its matrices are those of two pendulums."""


@dataclass(frozen=True)
class Beyond:
    """The tanks of a craft at present, before its laws are derived.

    Attributes
    ----------
    p : Present
        Parameters of the plant, masses as they are at present.
    fuel : Fuel
        What the tanks hold.
    """

    p: Present
    fuel: Fuel

    @property
    def bobs(self) -> tuple[Pendulum, ...]:
        """The pendulums at present."""
        return tuple(tank.bob for tank in self.fuel.tanks)


def beyond(p: Group, pendulums: Sequence[Pendulum], d: Derivation) -> Beyond:
    """Add the parameters of what the paper leaves out, and let the tanks drain."""
    tables = read_parameters(_HERE / "parameters.toml")
    sampling = tables["sampling"] if len(pendulums) == _REGULATED else ()
    whole = Group("p", (*p, *tables["plant"], *sampling, *place_parameters(len(pendulums), tables)))
    fuel = drained(whole, pendulums, d)
    values = {"m0": fuel.fixed.mass, "I0": fuel.fixed.inertia}
    return Beyond(Present("p", whole.quantities, values), fuel)


def completed(
    paper: System, part: Beyond, laws: Mapping[str, Law], angles: Sequence[sp.Symbol], d: Derivation
) -> System:
    """Return the paper's system on ball joints with a quaternion, with draining tanks, engine, gravity and regulator.

    Parameters
    ----------
    paper : System
        Whose laws act: they know the masses at present, and nothing else of what is added.
    part : Beyond
        The tanks.
    laws : mapping of str to Law
        What its laws were derived from.
    angles : sequence of Symbol
        Attitude angles.
    d : Derivation
        Receives the steps.
    """
    p, fuel = Group("p", part.p.quantities), part.fuel
    thrust, gravity = acting(p, d), gradient(p, d)
    whole = sums(p, fuel, gravity)
    show(p, fuel, thrust, whole, d)
    equations = craft(p, fuel, thrust, gravity, d)
    unknown = equations.accelerations(control_moments(), "Y", d)
    linear = sp.Matrix(unknown[:3]) - rate.cross(velocity)
    arms = equations.arm_rates(unknown)
    by_name = dict(zip((q.name for q in paper.states), paper.rhs, strict=True))
    names = [f"{which}{k}{axis}" for k in range(1, len(fuel.tanks) + 1) for which in ("sigma",) for axis in "xyz"]
    by_name |= dict(zip(("vx", "vy", "vz", "wx", "wy", "wz"), (*linear, *unknown[3:]), strict=True))
    by_name |= dict(zip(names, arms, strict=True))
    rates, residual = residuals(p, fuel, thrust, gravity, whole)
    tables = read_parameters(_HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    controllers = [
        dataclasses.replace(
            law,
            outputs=(
                *law.outputs,
                *monitors(
                    laws[law.name], law.parameters, law.command, law.name[-2:], equations, fuel, angles, p.flow, d
                ),
            ),
        )
        for law in paper.controllers
    ]
    if len(fuel.tanks) == _REGULATED:
        controllers.append(regulator(Group("c", tables["regulator"].quantities), p.sample, angles, d))
    states = Group("x", (*paper.states, BURNT, *ANGLES))
    added = (sp.S.Zero,) * (1 + len(ANGLES))
    projection = (*paper.projection, BURNT.symbol, *(q.symbol for q in ANGLES))
    outputs = _outputs(paper, unknown, thrust, p)
    return dataclasses.replace(
        paper,
        states=states,
        parameters=p,
        outputs=Group("y", tuple(q for q, _ in outputs)),
        output=tuple(e for _, e in outputs),
        rhs=(*by_name.values(), p.flow, *gimbal_rates(p, d)),
        limits=_limits(fuel),
        initial=(*paper.initial, *added),
        projection=projection,
        functions=tuple(_function(f, states, p, whole) for f in paper.functions),
        controllers=tuple(controllers),
        actuator=None,
        scenarios=scenarios,
        metrics=metrics,
        choices=(),
        variants=(),
        rates=rates,
        residual=residual,
        events=(
            Event(
                "empty", fuel.share - _EMPTY, "rising", ends=True, title="the tables end: the tanks are nearly empty"
            ),
        ),
        steps=tuple(d.steps),
    )


def _limits(fuel: Fuel) -> tuple[Condition, ...]:
    """Return the conditions that each tank holds fuel, and no more than at the start."""
    return (
        Condition(
            fuel.fixed.mass,
            "the fuel that does not slosh is used up: flow = {flow:g} kg/s takes more than the tables of the tanks let "
            "go, and m0 = {m0:g} kg is too little beside them",
        ),
        Condition(fuel.sloshing, "mass_part leaves the tanks no sloshing mass"),
        Condition(fuel.reach, "arm_part leaves the pendulums no length"),
        Condition(fuel.share + _NONE, "burnt is negative: the tanks would hold more than all their fuel"),
    )


def _outputs(paper: System, unknown: Sequence[Expr], thrust: sp.Matrix, p: Group) -> tuple[tuple[Quantity, Expr], ...]:
    """Return the paper's outputs with the accelerations and the thrust as they are."""
    across = sp.sqrt(thrust[1] ** 2 + thrust[2] ** 2) / p.F
    here = dict(zip((*DEMAND.quantities,), unknown[1:], strict=True))
    values = {q.name: value for q, value in here.items()} | {"ax": unknown[0], "lateral": across}
    return tuple((q, values.get(q.name, expr)) for q, expr in zip(paper.outputs, paper.output, strict=True))


def _function(f: Function, states: Group, p: Group, whole: Sum) -> Function:
    """Return a function of the paper's system as one of this."""
    groups = {"x": states, "p": p}
    results = f.results
    if f.name == "energy":
        results = ((f.results[0][0], whole.energy),)
    if f.name == "momentum":
        results = tuple((q, e) for (q, _), e in zip(f.results, (*whole.linear, *whole.angular), strict=True))
    return dataclasses.replace(f, arguments=tuple(groups.get(g.name, g) for g in f.arguments), results=results)
