# SPDX-License-Identifier: Apache-2.0
"""The satellite as a `System`, from derivation, laws and tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from ..mechanics import quaternion_of_turns
from ..system import (
    Condition,
    Controller,
    Derivation,
    Expr,
    Function,
    Group,
    Metric,
    ModelError,
    Quantity,
    Scenario,
    System,
    whole_periods,
)
from ..tables import read_parameters, read_scenarios
from . import controllers, structure
from .controllers import REFERENCES, Shared
from .drive import Drive
from .dynamics import (
    ANGLES,
    AXES,
    RATES,
    Chart,
    angles,
    attitude,
    energy,
    euler_rotation,
    gradient_torque,
    inertia_matrix,
    inertial_momentum,
    motion_of_the_whole,
    rates,
    total_inertia,
    wheel_speeds,
)
from .environment import body_field, coil_torque, environment_torque, sensor, wheel_torque
from .estimator import HALF, estimate
from .geometry import geometry
from .instruments import BIAS, FIELD, SUN, drift, instruments
from .laws.attitude import Motion, attitude_law, feedback, pointing, sliding
from .laws.detumbling import b_dot
from .laws.gyro import Rate, without_bias
from .laws.sun import sun_pointing
from .linear import show_linear_model, show_sampled_model
from .orbit import LATITUDE, Orbit, circular, keplerian
from .wheels import Wheels, along_any, along_axes, has_lengths, off_balance, spanning

_HERE = Path(__file__).parent
_SOURCE = (
    "Fani Saberi, Ahmadi Dastgerdi: Design and implementation of a model-reference adaptive controller for three-axis "
    "satellite attitude with an ARM microcontroller"
)
_TITLES = {
    "wheels": "reaction wheels along any axes",
    "wheels unbalanced": "unbalanced reaction wheels along any axes",
    "orbit": "an elliptic orbit",
    "torquers": "magnetic torquers",
    "inertia": "products of inertia",
    "sensors": "instruments",
    "laws": "more laws",
}
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
    orbit: Orbit
    placed: Chart
    states: Group
    drive: Drive

    @property
    def like_the_paper(self) -> bool:
        """True if the equations of motion equal the paper's."""
        return not {"inertia", "wheels", "orbit"} & structure.beyond(self.choices).keys()


def system(
    chart: str = "euler",
    inertia: str = "principal",
    wheels: str = "axes",
    orbit: str = "circular",
    torquers: str = "none",
    sensors: str = "states",
    laws: str = "paper",
) -> System:
    """Derive the satellite.

    Parameters
    ----------
    chart : {"euler", "quaternion"}
        Coordinates of the attitude: 3-2-1 angles, or a unit quaternion, scalar first, with the angles as outputs.
    inertia : {"principal", "full"}
        Three moments about principal axes, or a tensor with products of inertia.
    wheels : {"axes", "any", "unbalanced"}
        Three wheels along the body axes, or one along each column of `wheel_axes`, balanced or unbalanced.
    orbit : {"circular", "keplerian"}
        The paper's, or an ellipse by true anomaly with eclipse, a tilted dipole and the mean drift by J2.
    torquers : {"none", "three"}
        Magnetic torquers, which unload the wheels under every law and detumble under `b-dot`.
    sensors : {"states", "instruments"}
        Laws measure the state with noise, or use a gyro with random-walk bias, a magnetometer and a Sun sensor.
    laws : {"paper", "more"}
        The paper's laws, or also quaternion feedback and a sliding mode.

    Returns
    -------
    System
        Ready for code generation.

    Raises
    ------
    ModelError
        For instruments without the laws that read them.
    """
    if sensors == "instruments" and (torquers, laws) != ("three", "more"):
        raise ModelError(
            f"sensors = 'instruments' with torquers = {torquers!r} and laws = {laws!r}: needs torquers = 'three', "
            "which use the magnetometer, and laws = 'more', which estimate the gyro's bias"
        )
    choices = {
        "chart": chart, "inertia": inertia, "wheels": wheels, "orbit": orbit, "torquers": torquers, "sensors": sensors,
        "laws": laws,
    }  # fmt: skip
    d = Derivation()
    craft = _craft(choices, d)
    rhs, field = _rhs(craft, d)
    if craft.like_the_paper:
        show_linear_model(craft.p, craft.orbit, craft.wheels, d)
    show_sampled_model(craft.p, d)
    limited, measured = craft.drive.actuator(craft.p, d), sensor(craft.states, chart, craft.p, d)
    if sensors == "instruments":
        sun = craft.orbit.light * craft.placed.rotation * sp.Matrix(craft.orbit.sun)
        measured = instruments(measured, craft.states, field, tuple(sun), craft.p)
    all_laws = _laws(craft, field, d)
    outputs = _outputs(craft, d)
    scenarios, metrics = _scenarios(craft, outputs, all_laws)
    constraints = _constraints(craft, d)
    return System(
        name="satellite",
        title=_title(choices),
        source=_SOURCE,
        structure={"chart": chart, **structure.beyond(choices)},
        states=craft.states,
        inputs=craft.drive.inputs,
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
        controllers=all_laws,
        scenarios=scenarios,
        metrics=metrics,
        actuator=limited,
        sensor=measured,
        random_step=drift(craft.states, craft.p) if sensors == "instruments" else None,
        projection=_projection(craft.states) if chart == "quaternion" else (),
        geometry=geometry(craft.placed.rotation, craft.wheels.axes * craft.wheels.torques),
    )


def _title(choices: Mapping[str, str]) -> str:
    paper = "a satellite in a circular orbit with three reaction wheels"
    others = [_TITLES.get(f"{name} {value}", _TITLES[name]) for name, value in structure.beyond(choices).items()]
    return f"{paper}, with {', '.join(others)}" if others else paper


def _craft(choices: Mapping[str, str], d: Derivation) -> _Craft:
    """Combine the parts of the plant in the order of their dependence."""
    tables = read_parameters(_HERE / "parameters.toml")
    chart = choices["chart"]
    own = tables["euler"].quantities if chart == "euler" else ()
    p = structure.group("p", tables, "plant", choices)
    p = Group("p", (*p.quantities, *own))
    s = structure.group("s", tables, "scenario", choices)
    orbit = circular(p, s) if choices["orbit"] == "circular" else keplerian(p, s, d)
    wheels = _wheels(choices["wheels"], p, s, d)
    placed = attitude(chart, orbit.turning, d)
    bias = BIAS if choices["sensors"] == "instruments" else ()
    states = Group("x", (*placed.states, *RATES, *wheels.states, *wheels.angles, *orbit.states, *bias))
    field: tuple[Expr, ...] = ()
    if choices["torquers"] == "three":
        names = FIELD if bias else tuple(Quantity(f"B_body_{i}", "Wb/m^2", "") for i in "xyz")
        field = tuple(q.symbol for q in names)
    return _Craft(choices, tables, p, s, wheels, orbit, placed, states, Drive(wheels, field))


def _wheels(kind: str, p: Group, s: Group, d: Derivation) -> Wheels:
    if kind == "axes":
        return along_axes(p, s)
    return (along_any if kind == "any" else off_balance)(p, s, d)


def _rhs(craft: _Craft, d: Derivation) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    """Define the rates of the state, and the magnetic field in body axes if needed."""
    plant, wheels, orbit, rotation = craft.p, craft.wheels, craft.orbit, craft.placed.rotation
    d.section("Torques")
    gradient = gradient_torque(rotation, total_inertia(plant, wheels), orbit.pull, d)
    outside = environment_torque(rotation, orbit, plant, d)
    field: tuple[Expr, ...] = ()
    if {"torquers", "sensors"} & structure.beyond(craft.choices).keys():
        field = body_field(rotation, orbit, d)
    if craft.drive.field:
        outside += coil_torque(field, d)
    speeds = wheel_speeds(wheels, d)
    inside = wheel_torque(speeds, wheels, plant, d)
    d.section("Dynamics")
    turning, stored = motion_of_the_whole(gradient + outside, inside, wheels, plant, d)
    bias = [sp.S.Zero for q in craft.states if q in BIAS]
    turned = speeds if wheels.imbalances else ()
    return (*craft.placed.rate, *turning, *stored, *turned, *orbit.rates, *bias), field


def _outputs(craft: _Craft, d: Derivation) -> tuple[tuple[Quantity, Expr], ...]:
    """Return the outputs of a run by quantity."""
    named = {symbol.name: symbol for symbol in d.definitions}
    relative = (
        Quantity(f"rate_{i}", "rad/s", f"rate relative to the orbit axes about {i}", rf"\Omega_{i}") for i in "xyz"
    )
    speeds = (
        Quantity(f"wheel_{i}", "rad/s", f"speed of wheel {i} relative to the body", rf"\Omega_{{w{i}}}")
        for i in craft.wheels.labels
    )
    outside = (Quantity(f"Tenv_{i}", "N m", f"dipole, drag and sunlight about {i}", f"T_{{env,{i}}}") for i in "xyz")
    errors = (Quantity(f"{axis}_error", "rad", f"{axis} less its reference") for axis in AXES)
    return (
        *zip(REFERENCES, REFERENCES.symbols, strict=True),
        *zip(errors, (a - r for a, r in zip(angles, REFERENCES.symbols, strict=True)), strict=True),
        *((q, named[q.name]) for q in (*relative, *speeds, *outside)),
        *(() if craft.choices["chart"] == "euler" else zip(ANGLES, angles, strict=True)),
        *(_summary(craft, d) if structure.beyond(craft.choices) else ()),
    )


def _summary(craft: _Craft, d: Derivation) -> tuple[tuple[Quantity, Expr], ...]:
    """Return metrics for comparing actuator sets: pointing, torque, momentum."""
    d.section("Summary")
    wheels, off = craft.wheels, pointing(craft.placed.quaternion, REFERENCES.symbols, d)
    held, tumble = wheels.momentum, craft.placed.omega
    return (
        (Quantity("pointing", "rad", "angle between the attitude and the wanted one"), off),
        (Quantity("tumbling", "rad/s", "size of the rate relative to the orbit axes"), sp.sqrt(tumble.dot(tumble))),
        (Quantity("stored", "N m s", "momentum that the wheels hold together"), sp.sqrt(held.dot(held))),
        (Quantity("fullest", "N m s", "largest momentum of a wheel"), sp.Max(*(sp.Abs(h) for h in wheels.momenta))),
        (Quantity("strongest", "N m", "largest torque of a motor"), sp.Max(*(sp.Abs(u) for u in wheels.torques))),
    )


def _scenarios(
    craft: _Craft, outputs: Sequence[tuple[Quantity, Expr]], laws: Sequence[Controller]
) -> tuple[tuple[Scenario, ...], tuple[Metric, ...]]:
    """Return the paper's scenarios and metrics that a structure supports, and the comparison metrics."""
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    if not structure.beyond(craft.choices):
        return scenarios, metrics
    more, summary = read_scenarios(_HERE / "beyond.toml")
    known = {q.name for group in (craft.p, craft.s) for q in group}
    shown = {
        *(q.name for q in craft.states),
        *(q.name for q, _ in outputs),
        *(f"u_{q.name}" for q in craft.drive.inputs),
    }
    shown |= set.intersection(*({q.name for q in law.memory} for law in laws))
    return (
        tuple(dataclasses.replace(s, expect={}) for s in (*scenarios, *more) if known.issuperset(s.values)),
        tuple(
            m for m in (*metrics, *summary) if shown.issuperset(part.strip() for of in m.of for part in of.split(" - "))
        ),
    )


def _laws(craft: _Craft, field: Sequence[Expr], d: Derivation) -> tuple[Controller, ...]:
    tables, plant, placed, drive = craft.tables, craft.p, craft.placed, craft.drive
    unloading = structure.added(tables, craft.choices, "_unloading")
    loop, learning = (*tables["loop"].quantities, *unloading), tables["adaptive"].quantities
    mrac, literal = (Group("c", tables[name].quantities + learning + loop) for name in ("mrac", "mrac_literal"))
    gains = Group("c", tables["pd"].quantities + loop)
    d.section("Reference model")
    models = controllers.reference_models(mrac, plant, d)
    estimates = tuple(estimate(k, drive.torque[k], mrac, plant, d) for k in range(3))
    shared = Shared(models, estimates, drive)
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
        *(_more_laws(craft, unloading, d) if craft.choices["laws"] == "more" else ()),
        *(
            (b_dot(drive, field, Group("c", tables["torquers_three_detumble"].quantities), plant, d),)
            if drive.field
            else ()
        ),
        *((_safe_mode(craft, unloading, d),) if craft.choices["sensors"] == "instruments" else ()),
    )


def _safe_mode(craft: _Craft, unloading: Sequence[Quantity], d: Derivation) -> Controller:
    law = Group("c", (*craft.tables["sensors_instruments_sun"].quantities, *unloading))
    return sun_pointing(craft.drive, tuple(q.symbol for q in SUN), rates, inertia_matrix(craft.p), law, d)


def _more_laws(craft: _Craft, unloading: Sequence[Quantity], d: Derivation) -> Iterator[Controller]:
    """Yield the laws that use the whole attitude instead of separate axes."""
    filtered = structure.added(craft.tables, craft.choices, "_filter")
    motion = Motion(
        craft.placed.quaternion,
        REFERENCES.symbols,
        craft.placed.omega,
        rates,
        inertia_matrix(craft.p),
        craft.wheels.momentum,
    )
    for name, title, form in (
        ("quaternion", "quaternion feedback, with the whole inertia", feedback),
        ("sliding", "sliding mode with a boundary layer", sliding),
    ):
        law = Group("c", (*craft.tables[f"laws_more_{name}"].quantities, *unloading, *filtered))
        seen = Rate(motion.omega)
        if filtered:
            seen = without_bias(motion.omega, motion.quaternion, law, craft.p, name, d)
        yield attitude_law(name, title, form, motion, seen, craft.drive, law, d)


def _limits(chart: str, plant: Group, wheels: Wheels) -> tuple[Condition, ...]:
    torque = Condition(
        plant.torque_lost - sp.Max(*(sp.Abs(u) for u in wheels.torques)),
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
    rate = (euler_rotation() * craft.orbit.turning_at_start).subs(here)
    if craft.drive.field:
        rate += sp.Matrix([s.tumble_x, s.tumble_y, s.tumble_z])
    turns = [(axis, first[axis]) for axis in (2, 1, 0)]
    placed = first if craft.choices["chart"] == "euler" else tuple(quaternion_of_turns(turns))
    bias = (s.bias_x_0, s.bias_y_0, s.bias_z_0) if craft.choices["sensors"] == "instruments" else ()
    return (*placed, *rate, *craft.wheels.start, *craft.wheels.angles_at_start, *craft.orbit.start, *bias)


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
    return (*_needs(craft), *_body(craft), slow, *_balance(craft), *_above_ground(craft, d))


def _above_ground(craft: _Craft, d: Derivation) -> Iterator[Condition]:
    """Yield the condition that the orbit stays above the Earth's surface."""
    p = craft.p
    if craft.choices["orbit"] == "keplerian":
        yield Condition(
            p.semi_major_axis * (1 - p.eccentricity) - p.earth_radius,
            "the perigee is inside the Earth: semi_major_axis = {semi_major_axis:g} m, less its part "
            "eccentricity = {eccentricity:g}, is not more than earth_radius = {earth_radius:g} m",
        )
        return
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


def _needs(craft: _Craft) -> Iterator[Condition]:
    """Yield quantities that must be positive because a choice divides by them: wheel axes, their volume, the field."""
    if craft.choices["wheels"] != "axes":
        yield has_lengths(craft.p)
        yield spanning(craft.wheels)
    if craft.choices["torquers"] == "three":
        message = "field_moment = {field_moment:g} Wb m: magnetic torquers need a field, so more than zero"
        yield Condition(craft.p.field_moment, message)


def _balance(craft: _Craft) -> Iterator[Condition]:
    """Yield the conditions that each wheel's mass allows its imbalance."""
    if craft.wheels.imbalances:
        wheels = zip(craft.p.static_imbalance, craft.p.dynamic_imbalance, craft.wheels.inertia, strict=True)
        sizes = tuple(wheels)
        yield Condition(
            craft.p.mass - sp.Add(*(static**2 / inertia for static, _, inertia in sizes)),
            "mass = {mass:g} kg is not more than that of the wheels, at least static_imbalance^2/wheel_inertia of each",
        )
        yield Condition(
            sp.Min(*(inertia - dynamic for _, dynamic, inertia in sizes)),
            "a wheel's dynamic_imbalance is not less than its wheel_inertia",
        )


def _body(craft: _Craft) -> Iterator[Condition]:
    """Yield the conditions that the body's second moments, tr(I)/2 - I, are positive definite."""
    total = total_inertia(craft.p, craft.wheels)
    if "inertia" in structure.beyond(craft.choices) or "wheels" in structure.beyond(craft.choices):
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
    rotation, orbit, wheels = craft.placed.rotation, craft.orbit, craft.wheels
    where = "that the orbit axes pass at latitude zero" if orbit.states == (LATITUDE,) else "of the equator"
    momentum = tuple(
        Quantity(f"H{i}", "N m s", f"angular momentum of body and wheels along inertial {i}") for i in "xyz"
    )
    return (
        Function(
            "momentum",
            (craft.states, craft.p),
            tuple(zip(momentum, inertial_momentum(rotation, orbit, wheels, craft.p), strict=True)),
            f"angular momentum in the inertial axes {where}",
            "H",
        ),
        Function(
            "energy",
            (craft.states, craft.p),
            ((Quantity("E", "J", "energy"), energy(rotation, orbit.pull, wheels, craft.p)),),
            "energy of rotation of body and wheels, and potential of the gravity gradient",
        ),
    )


def _projection(states: Group) -> tuple[Expr, ...]:
    """Return the quaternion scaled to unit length."""
    q = states.symbols[:4]
    length = sp.sqrt(sp.Add(*(part**2 for part in q)))
    return (*(part / length for part in q), *states.symbols[4:])
