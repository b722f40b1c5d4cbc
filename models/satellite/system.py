# SPDX-License-Identifier: Apache-2.0
"""The satellite as a `System`, from derivation, laws and tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from ..parts.charts import Chart
from ..system import (
    Condition,
    Controller,
    Derivation,
    Expr,
    Function,
    Group,
    Metric,
    Quantity,
    Scenario,
    System,
    whole_periods,
)
from ..tables import read_parameters, read_scenarios
from . import controllers, structure
from .controllers import REFERENCES, Shared
from .dynamics import (
    ANGLES,
    AXES,
    CHARTS,
    RATES,
    SPEED,
    Placed,
    angles,
    attitude,
    energy,
    euler_rotation,
    gradient_torque,
    inertial_momentum,
    motion_of_the_whole,
    total_inertia,
    wheel_speeds,
)
from .environment import environment_torque, sensor, wheel_torque
from .estimator import HALF, estimate
from .geometry import geometry
from .linear import show_linear_model, show_sampled_model
from .orbit import LATITUDE, circular_turning
from .wheels import Wheels, along_any, along_axes, any_axes

_HERE = Path(__file__).parent
_SOURCE = (
    "Fani Saberi, Ahmadi Dastgerdi: Design and implementation of a model-reference adaptive controller for three-axis "
    "satellite attitude with an ARM microcontroller"
)
_TITLES = {"wheels": "reaction wheels along any axes", "inertia": "products of inertia"}
_DEGREE = sp.pi / 180
_EARTH_RADIUS = sp.Integer(6378137)
"""Equatorial radius of the Earth, m, WGS 84."""
_EARTH_RATE = sp.Float("1.2394474623e-3")
"""sqrt(mu/R^3) in rad/s, for mu = 3.986004418e14 m^3/s^2, EGM96."""
_ROUNDED = 1 + sp.Rational(1, 10**9)
"""Limit of a wheel's momentum relative to hmax; rounding may exceed hmax by 1e-16 per step of a full wheel."""


@dataclass(frozen=True)
class _Craft:
    """Derived parts of the plant that functions, laws and conditions use."""

    choices: Mapping[str, str]
    tables: Mapping[str, Group]
    p: Group
    s: Group
    wheels: Wheels
    placed: Placed
    states: Group

    @property
    def chart(self) -> Chart:
        """Chart of the attitude."""
        return CHARTS[self.choices["chart"]]

    @property
    def like_the_paper(self) -> bool:
        """True if the equations of motion equal the paper's."""
        return not structure.beyond(self.choices)


def system(chart: str = "euler", inertia: str = "principal", wheels: str = "axes") -> System:
    """Derive the satellite.

    Parameters
    ----------
    chart : {"euler", "quaternion"}
        Coordinates of the attitude: 3-2-1 angles, or a unit quaternion, scalar first, with the angles as outputs.
    inertia : {"principal", "full"}
        Three moments about principal axes, or a tensor with products of inertia.
    wheels : {"axes", "any"}
        Three wheels along the body axes, or one along each column of `wheel_axes`.

    Returns
    -------
    System
        Ready for code generation.
    """
    choices = {"chart": chart, "inertia": inertia, "wheels": wheels}
    d = Derivation()
    craft = _craft(choices, d)
    rhs = _rhs(craft, d)
    if craft.like_the_paper:
        show_linear_model(craft.p, craft.wheels, d)
    show_sampled_model(craft.p, d)
    limited, measured = craft.wheels.actuator(craft.p, d), sensor(craft.states, chart, craft.p, d)
    laws = _laws(craft, d)
    outputs = _outputs(craft, d)
    scenarios, metrics = _scenarios(craft)
    constraints, on_sphere = _constraints(craft, d), craft.chart.projection()
    return System(
        name="satellite",
        title=_title(choices),
        source=_SOURCE,
        structure={"chart": chart, **structure.beyond(choices)},
        states=craft.states,
        inputs=craft.wheels.torques,
        references=REFERENCES,
        outputs=Group("y", tuple(q for q, _ in outputs)),
        parameters=craft.p,
        scenario_parameters=craft.s,
        rhs=rhs,
        output=tuple(expr for _, expr in outputs),
        steps=tuple(d.steps),
        limits=_limits(chart, craft.p, craft.wheels),
        initial=_initial(craft),
        reference=_reference(craft.s),
        constraints=constraints,
        functions=_functions(craft),
        controllers=laws,
        scenarios=scenarios,
        metrics=metrics,
        actuator=limited,
        sensor=measured,
        projection=(*on_sphere, *craft.states.symbols[len(on_sphere) :]) if on_sphere else (),
        geometry=geometry(craft.placed.rotation, craft.wheels.axes * sp.Matrix(craft.wheels.torques.symbols)),
    )


def _title(choices: Mapping[str, str]) -> str:
    paper = "a satellite in a circular orbit with three reaction wheels"
    others = [_TITLES[name] for name in structure.beyond(choices)]
    return f"{paper}, with {', '.join(others)}" if others else paper


def _craft(choices: Mapping[str, str], d: Derivation) -> _Craft:
    """Combine the parts of the plant in the order of their dependence."""
    tables = read_parameters(_HERE / "parameters.toml")
    chart = choices["chart"]
    own = tables["euler"].quantities if chart == "euler" else ()
    p = structure.group("p", tables, "plant", choices)
    p = Group("p", (*p.quantities, *own))
    s = structure.group("s", tables, "scenario", choices)
    wheels = along_axes(p, s) if choices["wheels"] == "axes" else along_any(p, s, d)
    placed = attitude(chart, p.omega0, d)
    states = Group("x", (*CHARTS[chart].states, *RATES, *wheels.states, LATITUDE))
    return _Craft(choices, tables, p, s, wheels, placed, states)


def _rhs(craft: _Craft, d: Derivation) -> tuple[Expr, ...]:
    """Define the rates of the state."""
    plant, wheels, rotation = craft.p, craft.wheels, craft.placed.rotation
    d.section("Torques")
    gradient = gradient_torque(rotation, total_inertia(plant, wheels), plant.omega0**2, d)
    outside = environment_torque(rotation, plant, d)
    inside = wheel_torque(wheel_speeds(wheels, d), wheels, plant, d)
    d.section("Dynamics")
    turning, stored = motion_of_the_whole(gradient + outside, inside, wheels, plant, d)
    return (*craft.placed.rate, *turning, *stored, plant.omega0)


def _outputs(craft: _Craft, d: Derivation) -> tuple[tuple[Quantity, Expr], ...]:
    """Return the outputs of a run by quantity."""
    named = {symbol.name: symbol for symbol in d.definitions}
    relative = (
        Quantity(f"rate_{i}", "rad/s", f"rate relative to the orbit axes about {i}", rf"\Omega_{i}") for i in "xyz"
    )
    speeds = (Quantity(f"wheel_{i}", "rad/s", SPEED.format(i), rf"\Omega_{{w{i}}}") for i in craft.wheels.labels)
    outside = (Quantity(f"Tenv_{i}", "N m", f"dipole, drag and sunlight about {i}", f"T_{{env,{i}}}") for i in "xyz")
    errors = (Quantity(f"{axis}_error", "rad", f"{axis} less its reference") for axis in AXES)
    return (
        *zip(REFERENCES, REFERENCES.symbols, strict=True),
        *zip(errors, (a - r for a, r in zip(angles, REFERENCES.symbols, strict=True)), strict=True),
        *((q, named[q.name]) for q in (*relative, *speeds, *outside)),
        *(() if craft.choices["chart"] == "euler" else zip(ANGLES, angles, strict=True)),
    )


def _scenarios(craft: _Craft) -> tuple[tuple[Scenario, ...], tuple[Metric, ...]]:
    """Return the paper's scenarios, and the metrics that a structure supports."""
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    if craft.like_the_paper:
        return scenarios, metrics
    return (
        tuple(dataclasses.replace(scenario, expect={}) for scenario in scenarios),
        tuple(metric for metric in metrics if craft.choices["wheels"] == "axes" or not _OWN.intersection(metric.of)),
    )


_OWN = {f"{name}{axis}" for name in ("h", "u_T") for axis in "xyz"}
"""Names of the momenta and torques of the paper's wheels."""


def _laws(craft: _Craft, d: Derivation) -> tuple[Controller, ...]:
    """Return the adaptive law in two versions and the paper's comparison (50), which share the reference models."""
    tables, plant, wheels = craft.tables, craft.p, craft.wheels
    loop = structure.group("c", tables, "loop", craft.choices).quantities
    mrac, literal = (Group("c", (*tables[name], *tables["adaptive"], *loop)) for name in ("mrac", "mrac_literal"))
    gains = Group("c", (*tables["pd"], *loop))
    d.section("Reference model")
    models = controllers.reference_models(mrac, plant, d)
    estimates = tuple(estimate(k, wheels.acting[k], mrac, plant, d) for k in range(3))
    shared = Shared(models, estimates, wheels)
    return (
        controllers.adaptive(
            "mrac", "adaptive, keeps the sampled zero at -1", controllers.retain, mrac, plant, shared, d
        ),
        controllers.adaptive(
            "mrac-literal",
            "adaptive, as the paper's (32): cancels the zero",
            controllers.cancel,
            literal,
            plant,
            shared,
            d,
        ),
        controllers.pd("proportional and derivative (50)", craft.placed.omega, plant, gains, shared, d),
    )


def _limits(chart: str, plant: Group, wheels: Wheels) -> tuple[Condition, ...]:
    """Return the limits on torque and wheels; those on the pitch are for charts with a singularity."""
    torque = Condition(
        plant.torque_lost - sp.Max(*(sp.Abs(u) for u in wheels.torques.symbols)),
        "lost (torque): a control torque passed torque_lost = {torque_lost:g} N m",
    )
    left = _ROUNDED * plant.hmax - sp.Max(*(sp.Abs(h) for h in wheels.momenta))
    if wheels.share.free_symbols:
        left = sp.Piecewise((left, wheels.share > HALF), (plant.hmax, True))
    momentum = Condition(
        left,
        "lost (momentum): a wheel holds more than hmax = {hmax:g} N m s",
    )
    if chart == "quaternion":
        return (torque, momentum)
    pitch = Condition(
        plant.pitch_lost - sp.Abs(angles[1]),
        "lost (pitch): |pitch| passed pitch_lost = {pitch_lost:g} rad, near the singularity of the angles",
    )
    return (pitch, torque, momentum)


def _initial(craft: _Craft) -> tuple[Expr, ...]:
    """Return the initial state: at rest in the orbit axes (49), or with a rate as an extension."""
    s = craft.s
    first = tuple(value * _DEGREE for value in (s.roll_0_deg, s.pitch_0_deg, s.yaw_0_deg))
    here = dict(zip(angles, first, strict=True))
    rate = (euler_rotation() * circular_turning(craft.p.omega0)).subs(here)
    return (*craft.chart.of_angles(first), *rate, *craft.wheels.start, s.latitude_0)


def _reference(s: Group) -> tuple[Expr, ...]:
    """Return reference square waves that start with a positive half wave."""
    side = 1 - 2 * sp.Mod(whole_periods(s.half_period), 2)
    return tuple(side * value * _DEGREE for value in (s.roll_step_deg, s.pitch_step_deg, s.yaw_step_deg))


def _constraints(craft: _Craft, d: Derivation) -> tuple[Condition, ...]:
    plant, s = craft.p, craft.s
    slow = Condition(
        s.half_period - plant.Ts,
        "half_period = {half_period:g} s is not longer than a sample, Ts = {Ts:g} s: the law cannot see the reference",
    )
    axes = any_axes(plant, craft.wheels) if craft.choices["wheels"] == "any" else ()
    return (*axes, *_body(craft), slow, *_above_ground(plant, d))


def _above_ground(p: Group, d: Derivation) -> Iterator[Condition]:
    """Yield the condition that the orbit stays above the Earth's surface."""
    d.section("The Earth")
    radius = d.define("R_E", _EARTH_RADIUS, title="equatorial radius of the Earth, WGS 84", unit="m", latex="R_E")
    rate = d.define("n_E", _EARTH_RATE, title="rate of an orbit along its surface", unit="rad/s", latex="n_E")
    yield Condition(
        p.orbit_radius - radius,
        f"orbit_radius = {{orbit_radius:g}} m: an orbit inside the Earth, whose radius is {float(_EARTH_RADIUS):g} m",
    )
    yield Condition(
        rate - p.omega0,
        f"omega0 = {{omega0:g}} rad/s: an orbit inside the Earth, at whose surface it is {float(_EARTH_RATE):g} rad/s",
    )


def _body(craft: _Craft) -> Iterator[Condition]:
    """Yield the conditions that the body's second moments, tr(I)/2 - I, are positive definite."""
    total = total_inertia(craft.p, craft.wheels)
    if not craft.like_the_paper:
        moments = sp.eye(3) * total.trace() - 2 * total
        message = "the inertia is that of no body: a principal moment exceeds the other two together"
        for k in (1, 2, 3):  # Sylvester's criterion; SymPy's Min of the three takes minutes
            yield Condition(moments[:k, :k].det(method="berkowitz"), message)
        return
    x, y, z = total.diagonal()
    yield Condition(
        sp.Min(y + z - x, z + x - y, x + y - z),
        "I_x = {I_x:g}, I_y = {I_y:g}, I_z = {I_z:g} kg m^2 are the inertias of no body: with the wheels' "
        "Iw_x = {Iw_x:g}, Iw_y = {Iw_y:g}, Iw_z = {Iw_z:g} kg m^2 each total must be less than the other two together",
    )


def _functions(craft: _Craft) -> tuple[Function, ...]:
    """Return the functions for angular momentum and energy, by which a run can be checked."""
    rotation, wheels = craft.placed.rotation, craft.wheels
    momentum = tuple(
        Quantity(f"H{i}", "N m s", f"angular momentum of body and wheels along inertial {i}") for i in "xyz"
    )
    return (
        Function(
            "momentum",
            (craft.states, craft.p),
            tuple(zip(momentum, inertial_momentum(rotation, wheels, craft.p), strict=True)),
            "angular momentum in the inertial axes that the orbit axes pass at latitude zero",
            "H",
        ),
        Function(
            "energy",
            (craft.states, craft.p),
            ((Quantity("E", "J", "energy"), energy(rotation, wheels, craft.p)),),
            "energy of rotation of body and wheels, and potential of the gravity gradient",
        ),
    )
