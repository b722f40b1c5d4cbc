# SPDX-License-Identifier: Apache-2.0
"""The satellite as a `System`: derivation, laws and tables put together."""

from __future__ import annotations

from pathlib import Path

import sympy as sp

from ..mechanics import quaternion_of_turns
from ..system import Condition, Controller, Derivation, Expr, Function, Group, Quantity, System, whole_periods
from ..tables import read_parameters, read_scenarios
from . import controllers
from .controllers import REFERENCES, Shared
from .dynamics import (
    ANGLES,
    AXES,
    LATITUDE,
    RATES,
    TORQUES,
    WHEELS,
    Chart,
    accelerations,
    angles,
    attitude,
    energy,
    euler_rotation,
    gravity_gradient,
    inertial_momentum,
    orbit_rate,
    torques,
    total_inertia,
    wheel_speeds,
    wheels,
)
from .environment import actuator, environment_torque, sensor, wheel_torque
from .estimator import HALF, estimate
from .geometry import geometry
from .linear import show_linear_model, show_sampled_model

STRUCTURE = {"chart": ("euler", "quaternion")}
"""Structural choices and their values; the first is the default."""

_HERE = Path(__file__).parent
_SOURCE = (
    "Fani Saberi, Ahmadi Dastgerdi: Design and implementation of a model-reference adaptive controller for three-axis "
    "satellite attitude with an ARM microcontroller"
)
_INPUTS = Group("u", TORQUES)
_OUTPUTS = (
    *REFERENCES,
    *(Quantity(f"{axis}_error", "rad", f"{axis} less its reference") for axis in AXES),
    *(Quantity(f"rate_{i}", "rad/s", f"rate relative to the orbit axes about {i}", rf"\Omega_{i}") for i in "xyz"),
    *(Quantity(f"wheel_{i}", "rad/s", f"speed of wheel {i} relative to the body", rf"\Omega_{{w{i}}}") for i in "xyz"),
    *(Quantity(f"Tenv_{i}", "N m", f"dipole, drag and sunlight about {i}", f"T_{{env,{i}}}") for i in "xyz"),
)
_DEGREE = sp.pi / 180
_ROUNDED = 1 + sp.Rational(1, 10**9)
"""A wheel may hold so many times hmax: full, it is beyond hmax by the rounding of its steps, 1e-16 of it each."""


def system(chart: str = "euler") -> System:
    """Derive the satellite.

    Parameters
    ----------
    chart : {"euler", "quaternion"}
        Coordinates of the attitude: 3-2-1 angles, or a unit quaternion, scalar first, with the angles as outputs.

    Returns
    -------
    System
        Ready for code generation.
    """
    tables = read_parameters(_HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    own = tables["euler"].quantities if chart == "euler" else ()
    plant = Group("p", tables["plant"].quantities + own)
    scenario = Group("s", tables["scenario"].quantities)
    d = Derivation()
    placed = attitude(chart, plant.omega0, d)
    states = Group("x", (*placed.states, *RATES, *WHEELS, LATITUDE))
    rhs = _rhs(placed, plant, d)
    show_linear_model(plant, d)
    show_sampled_model(plant, d)
    limited, measured = actuator(plant, d), sensor(states, chart, plant, d)
    laws = _laws(tables, placed, plant, d)
    errors = tuple(angle - r for angle, r in zip(angles, REFERENCES.symbols, strict=True))
    named = {symbol.name: symbol for symbol in d.definitions}
    return System(
        name="satellite",
        title="a satellite in a circular orbit with three reaction wheels",
        source=_SOURCE,
        structure={"chart": chart},
        states=states,
        inputs=_INPUTS,
        references=REFERENCES,
        outputs=Group("y", (*_OUTPUTS, *(() if chart == "euler" else ANGLES))),
        parameters=plant,
        scenario_parameters=scenario,
        rhs=rhs,
        output=(
            *REFERENCES.symbols,
            *errors,
            *(named[q.name] for q in _OUTPUTS[6:]),
            *(() if chart == "euler" else angles),
        ),
        steps=tuple(d.steps),
        limits=_limits(chart, plant),
        initial=_initial(chart, plant, scenario),
        reference=_reference(scenario),
        constraints=_constraints(plant, scenario),
        functions=_functions(placed, states, plant),
        controllers=laws,
        scenarios=scenarios,
        metrics=metrics,
        actuator=limited,
        sensor=measured,
        projection=_projection(states) if chart == "quaternion" else (),
        geometry=geometry(placed.rotation),
    )


def _rhs(placed: Chart, plant: Group, d: Derivation) -> tuple[Expr, ...]:
    d.section("Torques")
    gradient = gravity_gradient(placed.rotation, total_inertia(plant), plant.omega0)
    gradient = sp.Matrix(
        [
            d.define(
                f"Tgg_{i}", sp.factor(gradient[k]), "(8)-(10)", f"gravity gradient about {i}", "N m", f"T_{{gg,{i}}}"
            )
            for k, i in enumerate("xyz")
        ]
    )
    outside = environment_torque(placed.rotation, plant, d)
    inside = wheel_torque(wheel_speeds(plant, d), plant, d)
    d.section("Dynamics")
    turning = accelerations(gradient + outside + inside, plant, d)
    stored = tuple(-plant.wheels * torque for torque in inside)
    return (*placed.rate, *turning, *stored, plant.omega0)


def _laws(tables: dict[str, Group], placed: Chart, plant: Group, d: Derivation) -> tuple[Controller, ...]:
    loop, learning = tables["loop"].quantities, tables["adaptive"].quantities
    mrac, literal = (Group("c", tables[name].quantities + learning + loop) for name in ("mrac", "mrac_literal"))
    gains = Group("c", tables["pd"].quantities + loop)
    d.section("Reference model")
    models = controllers.reference_models(mrac, plant, d)
    estimates = tuple(estimate(k, controllers.APPLIED.symbols[k], mrac, plant, d) for k in range(3))
    shared = Shared(models, estimates)
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
        controllers.pd("proportional and derivative (50)", placed.omega, plant, gains, shared, d),
    )


def _limits(chart: str, plant: Group) -> tuple[Condition, ...]:
    torque = Condition(
        plant.torque_lost - sp.Max(*(sp.Abs(u) for u in torques)),
        "lost (torque): a control torque passed torque_lost = {torque_lost:g} N m",
    )
    momentum = Condition(
        sp.Piecewise(
            (_ROUNDED * plant.hmax - sp.Max(*(sp.Abs(h) for h in wheels)), plant.wheels > HALF), (plant.hmax, True)
        ),
        "lost (momentum): a wheel holds more than hmax = {hmax:g} N m s",
    )
    if chart == "quaternion":
        return (torque, momentum)
    pitch = Condition(
        plant.pitch_lost - sp.Abs(angles[1]),
        "lost (pitch): |pitch| passed pitch_lost = {pitch_lost:g} rad, near the singularity of the angles",
    )
    return (pitch, torque, momentum)


def _initial(chart: str, plant: Group, s: Group) -> tuple[Expr, ...]:
    """Start at rest in the orbit axes (49)."""
    first = tuple(value * _DEGREE for value in (s.roll_0_deg, s.pitch_0_deg, s.yaw_0_deg))
    here = dict(zip(angles, first, strict=True))
    rate = orbit_rate(euler_rotation(), plant.omega0).subs(here)
    turns = [(axis, first[axis]) for axis in (2, 1, 0)]
    placed = first if chart == "euler" else tuple(quaternion_of_turns(turns))
    return (*placed, *rate, s.hx_0, s.hy_0, s.hz_0, s.latitude_0)


def _reference(s: Group) -> tuple[Expr, ...]:
    """Return square waves that begin positive."""
    side = 1 - 2 * sp.Mod(whole_periods(s.half_period), 2)
    return tuple(side * value * _DEGREE for value in (s.roll_step_deg, s.pitch_step_deg, s.yaw_step_deg))


def _constraints(plant: Group, s: Group) -> tuple[Condition, ...]:
    x, y, z = total_inertia(plant).diagonal()
    body = Condition(
        sp.Min(y + z - x, z + x - y, x + y - z),
        "I_x = {I_x:g}, I_y = {I_y:g}, I_z = {I_z:g} kg m^2 are the inertias of no body: with the wheels' "
        "Iw_x = {Iw_x:g}, Iw_y = {Iw_y:g}, Iw_z = {Iw_z:g} kg m^2 each total must be less than the other two together",
    )
    slow = Condition(
        s.half_period - plant.Ts,
        "half_period = {half_period:g} s is not longer than a sample, Ts = {Ts:g} s: the law cannot see the reference",
    )
    return (body, slow)


def _functions(placed: Chart, states: Group, plant: Group) -> tuple[Function, ...]:
    momentum = tuple(
        Quantity(f"H{i}", "N m s", f"angular momentum of body and wheels along inertial {i}") for i in "xyz"
    )
    return (
        Function(
            "momentum",
            (states, plant),
            tuple(zip(momentum, inertial_momentum(placed.rotation, plant), strict=True)),
            "angular momentum in the inertial axes that the orbit axes pass at latitude zero",
            "H",
        ),
        Function(
            "energy",
            (states, plant),
            ((Quantity("E", "J", "energy"), energy(placed.rotation, plant)),),
            "energy of rotation of body and wheels, and potential of the gravity gradient",
        ),
    )


def _projection(states: Group) -> tuple[Expr, ...]:
    """Scale the quaternion to unit length."""
    q = states.symbols[:4]
    length = sp.sqrt(sp.Add(*(part**2 for part in q)))
    return (*(part / length for part in q), *states.symbols[4:])
