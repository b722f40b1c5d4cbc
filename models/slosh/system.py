# SPDX-License-Identifier: Apache-2.0
"""The spacecraft with sloshing fuel as a `System`: derivation, laws and tables put together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from models.slosh.attitude import Attitude, by_angles, by_quaternion
from models.slosh.controllers import Law, lyapunov_v1, lyapunov_v2
from models.slosh.dynamics import Dynamics, angle_dynamics
from models.slosh.equations import kinetic_energy, momentum, show_equations
from models.slosh.hull import velocity_rates
from models.slosh.reduced import (
    AngleRow,
    angle_accelerations,
    angle_rows,
    longitudinal,
    reduced_velocity,
    show_reduced,
)
from models.slosh.thrust import Inputs, Plant, gimbal_limits, to_physical
from models.slosh.variables import (
    ATTITUDE,
    DEMAND,
    GIMBALS,
    INPUTS,
    RATE,
    VELOCITY,
    Pendulum,
    angle_quantities,
    angle_rate_quantities,
    pendulum_parameters,
)
from models.system import (
    Choice,
    Condition,
    Controller,
    Derivation,
    Expr,
    Function,
    Group,
    Quantity,
    System,
    Variant,
)
from models.tables import read_parameters, read_scenarios

MOST = 64
"""Largest number of pendulums offered."""
STRUCTURE = {
    "pendulums": ("2", "1", *(str(k) for k in range(3, MOST + 1))),
    "inertia": ("paper", "hinge"),
    "attitude": ("angles", "quaternion"),
}
"""Structural choices and their values; the first is the default."""

_HERE = Path(__file__).parent
_SOURCE = (
    "Navabi, Davoodi: Spacecraft slosh control (in Persian), "
    "Modares Mechanical Engineering 19(9), 2019, 2121-2128"
)
_PLANT = Choice("plant", ("full", "reduced"), "equations of motion (9)-(16), or the reduced model (20)-(26)")
_ATTITUDE = Choice("attitude", ("small", "euler"), "attitude rates equal to body rates, or 3-2-1 angles")
_REFERENCES = Group("r", ())
_LAWS = {
    "lyapunov-v1": "Lyapunov law with the pendulums' rates, (27), (29)-(33)",
    "lyapunov-v2": "Lyapunov law of velocities and attitude, (28), (34)-(36)",
}


@dataclass(frozen=True)
class _Model:
    """The derived parts that functions, laws and variants are made of."""

    p: Group
    pendulums: tuple[Pendulum, ...]
    states: Group
    attitude: Attitude
    dynamics: Dynamics
    plant: Plant
    rows: tuple[AngleRow, ...]
    axial: Expr
    linear: tuple[Expr, ...]
    angular: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]


def system(pendulums: str = "2", inertia: str = "paper", attitude: str = "angles") -> System:
    """Derive the spacecraft.

    Parameters
    ----------
    pendulums : str
        How many, "1" to "64"; the default is the paper's.
    inertia : {"paper", "hinge"}
        Inertia of the bobs: rotors geared to the angles, as published, or rigid bobs on hinges.
    attitude : {"angles", "quaternion"}
        Three angles, small or 3-2-1 as the run chooses, or a quaternion.

    Returns
    -------
    System
        Ready for code generation.
    """
    tables = read_parameters(_HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    numbers = range(1, int(pendulums) + 1)
    groups = [pendulum_parameters(k, tables[f"pendulum{min(k, 2)}"]) for k in numbers]
    p = Group("p", (*tables["plant"].quantities, *(q for group in groups for q in group)))
    bobs = tuple(
        Pendulum(str(k), *(q.symbol for q in group)) for k, group in zip(numbers, groups, strict=True)
    )
    starts = [pendulum_parameters(k, tables[f"start{min(k, 2)}"]) for k in numbers]
    scenario = Group("s", (*tables["scenario"].quantities, *(q for group in starts for q in group)))
    d = Derivation()
    show_equations(p, inertia, d)
    show_reduced(inertia, d)
    placed = by_angles(scenario) if attitude == "angles" else by_quaternion(scenario, d)
    model = _derive(p, bobs, inertia, placed, d)
    demanded = {
        "lyapunov-v1": _derive_law("v1", model, tables, d),
        "lyapunov-v2": _derive_law("v2", model, tables, d),
    }
    inputs = {name: _physical(law, name[-2:], model, d) for name, (law, _) in demanded.items()}
    functions = _functions(model, inertia, demanded, inputs, d)
    actuator = gimbal_limits(model.plant, d)
    choices = (_PLANT, _ATTITUDE) if attitude == "angles" else (_PLANT,)
    laws = {name: law for name, (law, _) in demanded.items()}
    return System(
        name="slosh",
        title="spacecraft with sloshing fuel, steered by its thrust",
        source=_SOURCE,
        structure={"pendulums": pendulums, "inertia": inertia, "attitude": attitude},
        states=model.states,
        inputs=INPUTS,
        references=_REFERENCES,
        outputs=_outputs(placed),
        parameters=p,
        scenario_parameters=scenario,
        rhs=_full(model, next(iter(placed.rates))),
        output=_output(model),
        steps=tuple(d.steps),
        limits=(),
        initial=_initial(scenario, placed, starts),
        reference=(),
        constraints=_constraints(p, scenario, starts),
        functions=functions,
        controllers=tuple(
            Controller(name, _LAWS[name], c, inputs[name].command, _law_constraints(name, c, model))
            for name, (_, c) in demanded.items()
        ),
        scenarios=scenarios,
        metrics=metrics,
        actuator=actuator,
        projection=_projection(model),
        choices=choices,
        variants=_variants(model, choices, laws),
    )


def _derive(
    p: Group, pendulums: tuple[Pendulum, ...], inertia: str, placed: Attitude, d: Derivation
) -> _Model:
    d.section("Evaluation of the equations of motion")
    dynamics = angle_dynamics(p, pendulums, inertia, d)
    linear, angular, acceleration = velocity_rates(dynamics.accelerations.unknown, dynamics.hull)
    d.section("Reduced model, pendulum by pendulum")
    rows = angle_rows(pendulums, inertia, d)
    axial = longitudinal(p, pendulums, d)
    numbers = range(1, len(pendulums) + 1)
    angles = (q for k in numbers for q in angle_quantities(k))
    speeds = (q for k in numbers for q in angle_rate_quantities(k))
    states = Group("x", (*VELOCITY, *RATE, *placed.states, *angles, *speeds))
    plant = Plant(p, dynamics.hull, dynamics.balance, dynamics.factors)
    return _Model(p, pendulums, states, placed, dynamics, plant, rows, axial, linear, angular, acceleration)


def _speeds(model: _Model) -> tuple[Expr, ...]:
    return tuple(row.speed for row in model.rows)


def _full(model: _Model, kinematics: str) -> tuple[Expr, ...]:
    """Return x' of the full model."""
    turned = model.attitude.rates[kinematics]
    return (*model.linear, *model.angular, *turned, *_speeds(model), *model.dynamics.accelerations.angles)


def _reduced(model: _Model, demand: Sequence[Expr], kinematics: str) -> tuple[Expr, ...]:
    """Return x' of the reduced model for its inputs u1..u5."""
    linear = reduced_velocity(model.axial, demand)
    angles = angle_accelerations(model.rows, (model.axial, *demand[:2]), demand[2:])
    return (*linear, *demand[2:], *model.attitude.rates[kinematics], *_speeds(model), *angles)


def _variants(model: _Model, choices: Sequence[Choice], laws: Mapping[str, Law]) -> tuple[Variant, ...]:
    """Return every combination of plant and kinematics but the default.

    The reduced plant takes the accelerations that the physical inputs bring about as u1..u5; in a closed loop it takes
    those of the law itself, as the paper does.
    """
    produced = (*model.acceleration[1:], *model.angular)
    found = []
    for plant in _PLANT.values:
        for kinematics in model.attitude.rates:
            values = (plant, kinematics)[: len(choices)]
            if plant == "full":
                found.append(Variant(values, _full(model, kinematics), {}))
            else:
                loops = {name: _reduced(model, law.demand, kinematics) for name, law in laws.items()}
                found.append(Variant(values, _reduced(model, produced, kinematics), loops))
    return tuple(found[1:])


def _derive_law(tag: str, model: _Model, tables: Mapping[str, Group], d: Derivation) -> tuple[Law, Group]:
    symbols = tuple(q.symbol for q in ATTITUDE)
    angles = model.attitude.angles
    if tag == "v1":
        d.section("Law of V1")
        c = Group("c", (*tables["laws"].quantities, *tables["lyapunov-v1"].quantities))
        return lyapunov_v1(c, model.axial, symbols, angles, model.rows, d), c
    d.section("Law of V2")
    c = Group("c", tables["laws"].quantities)
    return lyapunov_v2(c, model.axial, symbols, angles, d), c


def _physical(law: Law, tag: str, model: _Model, d: Derivation) -> Inputs:
    d.section(f"Physical inputs of the law of {tag.upper()}")
    return to_physical(model.plant, law.demand, tag, d)


_EXTRA = (
    Quantity("ax", "m/s^2", "acceleration a_x of O", "a_x"),
    Quantity("lateral", "1", "lateral part of the thrust, over F", r"f_\perp/F"),
)


def _outputs(placed: Attitude) -> Group:
    angles = () if placed.states is ATTITUDE else ATTITUDE
    return Group("y", (*DEMAND.quantities, *_EXTRA, *angles))


def _output(model: _Model) -> tuple[Expr, ...]:
    """Return the accelerations that the equations of motion give for the inputs, and the thrust across x."""
    d1, d2 = (q.symbol for q in GIMBALS)
    across = sp.sqrt(sp.sin(d2) ** 2 + (sp.sin(d1) * sp.cos(d2)) ** 2)
    angles = () if model.attitude.states is ATTITUDE else model.attitude.angles
    return (*model.acceleration[1:], *model.angular, model.acceleration[0], across, *angles)


def _initial(scenario: Group, placed: Attitude, starts: Sequence[Sequence[Quantity]]) -> tuple[Expr, ...]:
    hull = scenario.symbols[:6]
    angles = (q.symbol for group in starts for q in group[:2])
    speeds = (q.symbol for group in starts for q in group[2:])
    return (*hull, *placed.start, *angles, *speeds)


def _projection(model: _Model) -> tuple[Expr, ...]:
    """Put a quaternion back on its sphere; angles need nothing."""
    if model.attitude.states is ATTITUDE:
        return ()
    before, after = 6, 6 + len(model.attitude.states)
    symbols = model.states.symbols
    return (*symbols[:before], *model.attitude.projected, *symbols[after:])


def _constraints(p: Group, scenario: Group, starts: Sequence[Sequence[Quantity]]) -> tuple[Condition, ...]:
    """Return what parameters and initial state must satisfy."""
    triangle = Condition(
        sp.Min(p.J_y + p.J_z - p.J_x, p.J_z + p.J_x - p.J_y, p.J_x + p.J_y - p.J_z),
        "J_x = {J_x:g}, J_y = {J_y:g}, J_z = {J_z:g} kg m^2 are no moments of inertia of a body: "
        "each must be smaller than the other two together",
    )
    angles = [q for q in scenario if q.name.startswith("att")] + [q for group in starts for q in group[:2]]
    return (triangle, *(_in_radians(q) for q in angles))


def _in_radians(angle: Quantity) -> Condition:
    name = angle.name
    return Condition(
        2 * sp.pi - sp.Abs(angle.symbol),
        f"{name} = {{{name}:g}} rad is more than a full turn; angles are given in radians (30 degrees are 0.5236 rad)",
    )


def _law_constraints(name: str, c: Group, model: _Model) -> tuple[Condition, ...]:
    thrust = Condition(
        model.p.F, f"F = {{F:g}} N: {name} steers by the direction of the thrust and divides by F; it must be positive"
    )
    if name == "lyapunov-v2":
        return (thrust,)
    bound = sp.Add(*(_largest_correction(bob, c) for bob in model.pendulums))
    message = (
        "r9 = {r9:g}, r10 = {r10:g} s^2/kg are too large beside r4 = {r4:g}, r6 = {r6:g}, r8 = {r8:g} s^2/rad^2: "
        "the matrix f of (29) may lose its inverse"
    )
    return (thrust, Condition(sp.Min(c.r4, c.r6, c.r8) - bound, message))


def _largest_correction(bob: Pendulum, c: Group) -> Expr:
    """Bound what one pendulum takes from the eigenvalues of f: sum of m r |c|^2/D^2, with D_theta >= I."""
    swing = bob.mass * bob.length * (bob.length + sp.Abs(bob.pivot)) + bob.inertia
    whole = bob.mass * bob.length**2 + bob.inertia
    of_phi = c.r9 * (swing**2 + bob.inertia**2) / whole**2
    of_theta = c.r10 * (swing**2 + whole**2) / bob.inertia**2
    return bob.mass * (of_phi + of_theta)


def _functions(
    model: _Model,
    inertia: str,
    laws: Mapping[str, tuple[Law, Group]],
    inputs: Mapping[str, Inputs],
    d: Derivation,
) -> tuple[Function, ...]:
    """Return energy, momentum, the inversion of the inputs, and what each law looks at."""
    d.section("Physical inputs of a demand")
    physical = to_physical(model.plant, DEMAND.symbols, "any", d)
    x, p = model.states, model.p
    energy = Quantity("energy", "J", "kinetic energy")
    parts = tuple(
        Quantity(f"{kind}{axis}", unit, title)
        for kind, unit, title in (("p", "kg m/s", "linear momentum"), ("h", "kg m^2/s", "angular momentum about O"))
        for axis in "xyz"
    )
    found = [
        Function("energy", (x, p), ((energy, kinetic_energy(p, model.pendulums, inertia)),), "kinetic energy (5)"),
        Function(
            "momentum",
            (x, p),
            tuple(zip(parts, momentum(p, model.pendulums, inertia), strict=True)),
            "linear momentum and angular momentum about O, in body axes",
            vector="momentum",
        ),
        Function(
            "to_physical",
            (x, DEMAND, p),
            tuple(zip(INPUTS, physical.command, strict=True)),
            "moments and gimbal angles that bring about a_y, a_z and Omega'",
            vector="u",
        ),
    ]
    demanded = (*DEMAND.quantities, *_DEMANDED)
    for name, (law, c) in laws.items():
        title = name.replace("-", "_")
        value = Quantity("V", "1", f"Lyapunov function of {name}")
        wanted = (*law.demand, inputs[name].lateral, inputs[name].excess)
        found += [
            Function(f"{title}_value", (x, p, c), ((value, law.value),), f"Lyapunov function of {name}"),
            Function(
                f"{title}_demand",
                (x, p, c),
                tuple(zip(demanded, wanted, strict=True)),
                f"what {name} demands: u1..u5, lateral force, and how much of it is beyond the thrust",
                vector="demand",
            ),
        ]
    return tuple(found)


_DEMANDED = (
    Quantity("lateral_demand", "N", "demanded lateral force"),
    Quantity("lateral_excess", "N", "demanded lateral force beyond the thrust"),
)
