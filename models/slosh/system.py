# SPDX-License-Identifier: Apache-2.0
"""The spacecraft with sloshing fuel as a `System`: derivation, laws and tables put together."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from models.slosh import ball, pendulum
from models.slosh.attitude import Attitude, by_angles, by_quaternion
from models.slosh.bobs import Bobs, Start, angle_bobs, ball_bobs, parts, pendulum_equations
from models.slosh.bobs import accelerations as pendulum_accelerations
from models.slosh.controllers import Law, lyapunov_v1, lyapunov_v2
from models.slosh.equations import (
    applied_wrench,
    hull_energy,
    hull_momentum,
    hull_wrench,
    show_equations,
    velocity_accelerations,
    whole,
)
from models.slosh.hull import velocity_rates
from models.slosh.reduced import generic_accelerations, longitudinal, reduced_velocity, show_reduced
from models.slosh.thrust import Inputs, gimbal_limits, to_physical
from models.slosh.variables import (
    ATTITUDE,
    DEMAND,
    GIMBALS,
    INPUTS,
    RATE,
    VELOCITY,
    Pendulum,
    angle_rate_quantities,
    arm_rate_quantities,
    pendulum_parameters,
    point_allowed,
    rate,
    velocity,
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
    "inertia": ("paper", "hinge", "ball"),
    "attitude": ("angles", "quaternion"),
}
"""Structural choices and their values; the first is the default."""

_HERE = Path(__file__).parent
_SOURCE = (
    "Navabi, Davoodi: Spacecraft slosh control (in Persian), Modares Mechanical Engineering 19(9), 2019, 2121-2128"
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
    inertia: str
    pendulums: tuple[Pendulum, ...]
    attitude: Attitude
    bobs: Bobs
    axial: Expr
    linear: tuple[Expr, ...]
    angular: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]

    @property
    def states(self) -> Group:
        """The state."""
        return Group("x", (*VELOCITY, *RATE, *self.attitude.states, *self.bobs.states))


def system(pendulums: str = "2", inertia: str = "paper", attitude: str = "angles") -> System:
    """Derive the spacecraft.

    Parameters
    ----------
    pendulums : str
        How many, "1" to "64"; the default is the paper's.
    inertia : {"paper", "hinge", "ball"}
        Bobs as rotors geared to the angles, as published; rigid on hinges; or on ball joints, without angles.
    attitude : {"angles", "quaternion"}
        Three angles, small or 3-2-1 as the run chooses, or a quaternion.

    Returns
    -------
    System
        Ready for code generation.
    """
    tables = read_parameters(_HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    if (pendulums, inertia) != ("2", "paper"):
        scenarios = tuple(dataclasses.replace(scenario, expect={}) for scenario in scenarios)
    if pendulums == "1":
        metrics = tuple(metric for metric in metrics if not {"phi2", "theta2"}.intersection(metric.of))
    p, bobs = plant_parameters(tables, int(pendulums), inertia)
    starts = [pendulum_parameters(k, tables[f"start{min(k, 2)}"]) for k in range(1, int(pendulums) + 1)]
    scenario = Group("s", (*tables["scenario"].quantities, *(q for group in starts for q in group)))
    d = Derivation()
    _show(p, inertia, d)
    placed = by_angles(scenario) if attitude == "angles" else by_quaternion(scenario, d)
    model = _derive(p, bobs, inertia, placed, scenario, d)
    demanded = {name: _derive_law(name, model, tables, d) for name in _LAWS}
    inputs = {name: _physical(law, name[-2:], model, d) for name, (law, _) in demanded.items()}
    functions = _functions(model, demanded, inputs, d)
    actuator = gimbal_limits(p, model.bobs.dynamics, d)
    choices = (_PLANT, _ATTITUDE) if attitude == "angles" else (_PLANT,)
    laws = {name: law for name, (law, _) in demanded.items()}
    rates, residual = residuals(p, bobs, inertia)
    return System(
        name="slosh",
        title="spacecraft with sloshing fuel, steered by its thrust",
        source=_SOURCE,
        structure={"pendulums": pendulums, "inertia": inertia, "attitude": attitude},
        states=model.states,
        inputs=INPUTS,
        references=_REFERENCES,
        outputs=Group("y", tuple(quantity for quantity, _ in _outputs(model))),
        parameters=p,
        scenario_parameters=scenario,
        rhs=_full(model, next(iter(placed.rates))),
        output=tuple(expr for _, expr in _outputs(model)),
        steps=tuple(d.steps),
        limits=(),
        initial=(*scenario.symbols[:6], *placed.start, *model.bobs.start),
        reference=(),
        constraints=_constraints(p, scenario),
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
        rates=rates,
        residual=residual,
    )


def plant_parameters(tables: Mapping[str, Group], count: int, inertia: str) -> tuple[Group, tuple[Pendulum, ...]]:
    """Return the plant's parameters with those of each pendulum.

    Parameters
    ----------
    tables : mapping of str to Group
        Groups of parameters.toml.
    count : int
        Number of pendulums.
    inertia : str
        On ball joints I_i = 0 is allowed: a point bob.
    """
    groups = [pendulum_parameters(k, tables[f"pendulum{min(k, 2)}"]) for k in range(1, count + 1)]
    if inertia == "ball":
        groups = [tuple(point_allowed(q) if q.name.startswith("I") else q for q in group) for group in groups]
    p = Group("p", (*tables["plant"].quantities, *(q for group in groups for q in group)))
    return p, tuple(Pendulum(str(k), *(q.symbol for q in group)) for k, group in enumerate(groups, 1))


def residuals(p: Group, bobs: Sequence[Pendulum], inertia: str) -> tuple[dict[str, sp.Symbol], tuple[Expr, ...]]:
    """Return the derived equations of motion as residuals that the true rates of the states make zero.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    bobs : sequence of Pendulum
        Parameters of each pendulum.
    inertia : str
        Convention of their inertia.

    Returns
    -------
    rates : dict of str to Symbol
        For each velocity state, the symbol of its rate.
    residuals : tuple of Expr
        As many, linear in these symbols: (9)-(16), left less right sides.
    """
    part, copies = parts(inertia, bobs)
    own = [sp.Symbol(f"{q.name}_rate", real=True) for q in (*VELOCITY, *RATE)]
    unknown, rows = pendulum_equations(inertia, bobs)
    accelerations = velocity_accelerations(dict(zip((*velocity, *rate), own, strict=True)))
    named = [copy | pendulum_accelerations(inertia, k) for k, copy in enumerate(copies, 1)]
    left = whole(hull_wrench(p), (*part.force, *part.moment), named)
    balance = [side - applied for side, applied in zip(left, applied_wrench(p), strict=True)]
    states = [q.name for q in (*VELOCITY, *RATE)]
    for k in range(1, len(bobs) + 1):
        moving = arm_rate_quantities(k) if inertia == "ball" else angle_rate_quantities(k)
        states += [q.name for q in moving]
    found = tuple(entry.xreplace(accelerations) for entry in (*balance, *rows))
    return dict(zip(states, (*own, *unknown), strict=True)), found


def _show(p: Group, inertia: str, d: Derivation) -> None:
    """Write the published side of the derivation down, (5)-(26), in generic symbols."""
    if inertia == "ball":
        part = ball.contribution()
        show_equations(p, part, [("(15), (16)", row) for row in ball.tangential_rows()], d)
        arm = [
            (rf"\dot\sigma_{{i,{axis}}}", "(25), (26)", e) for axis, e in zip("xyz", ball.arm_equation(), strict=True)
        ]
        show_reduced(arm, d)
        return
    part = pendulum.contribution(inertia)
    show_equations(p, part, list(zip(("(15)", "(16)"), part.rows, strict=True)), d)
    first, second = generic_accelerations(inertia)
    show_reduced([(r"\ddot\varphi_i", "(25)", first), (r"\ddot\theta_i", "(26)", second)], d)


def _derive(
    p: Group, pendulums: tuple[Pendulum, ...], inertia: str, placed: Attitude, scenario: Group, d: Derivation
) -> _Model:
    starts = [
        Start(
            *(
                getattr(scenario, f"{name.format(bob.name)}_0")
                for name in ("phi{}", "theta{}", "phi{}_dot", "theta{}_dot")
            )
        )
        for bob in pendulums
    ]
    if inertia == "ball":
        bobs = ball_bobs(p, pendulums, starts, (scenario.wx_0, scenario.wy_0, scenario.wz_0), d)
    else:
        bobs = angle_bobs(p, pendulums, inertia, starts, d)
    linear, angular, acceleration = velocity_rates(bobs.dynamics.unknown, bobs.dynamics.hull)
    axial = longitudinal(p, pendulums, d)
    return _Model(p, inertia, pendulums, placed, bobs, axial, linear, angular, acceleration)


def _full(model: _Model, kinematics: str) -> tuple[Expr, ...]:
    """Return x' of the full model."""
    return (*model.linear, *model.angular, *model.attitude.rates[kinematics], *model.bobs.rates)


def _reduced(model: _Model, demand: Sequence[Expr], kinematics: str) -> tuple[Expr, ...]:
    """Return x' of the reduced model for its inputs u1..u5."""
    linear = reduced_velocity(model.axial, demand)
    bobs = model.bobs.reduced((model.axial, *demand[:2]), demand[2:])
    return (*linear, *demand[2:], *model.attitude.rates[kinematics], *bobs)


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


def _derive_law(name: str, model: _Model, tables: Mapping[str, Group], d: Derivation) -> tuple[Law, Group]:
    symbols = tuple(q.symbol for q in ATTITUDE)
    angles = model.attitude.angles
    d.section(f"Law: {_LAWS[name]}")
    if name == "lyapunov-v2":
        c = Group("c", tables["laws"].quantities)
        return lyapunov_v2(c, model.axial, symbols, angles, d), c
    weights = tables["lyapunov-v1"].quantities
    c = Group("c", (*tables["laws"].quantities, *(weights[:1] if model.inertia == "ball" else weights)))
    return lyapunov_v1(c, model.axial, symbols, angles, model.bobs.terms(c, model.axial), d), c


def _physical(law: Law, tag: str, model: _Model, d: Derivation) -> Inputs:
    d.section(f"Physical inputs of the law of {tag.upper()}")
    return to_physical(model.p, model.bobs.dynamics, law.demand, tag, d)


_EXTRA = (
    Quantity("ax", "m/s^2", "acceleration a_x of O", "a_x"),
    Quantity("lateral", "1", "lateral part of the thrust, over F", r"f_\perp/F"),
)


def _outputs(model: _Model) -> tuple[tuple[Quantity, Expr], ...]:
    """Return the accelerations that come about, the thrust across x, and angles that are no states."""
    d1, d2 = (q.symbol for q in GIMBALS)
    across = sp.sqrt(sp.sin(d2) ** 2 + (sp.sin(d1) * sp.cos(d2)) ** 2)
    produced = zip(DEMAND, (*model.acceleration[1:], *model.angular), strict=True)
    extra = zip(_EXTRA, (model.acceleration[0], across), strict=True)
    angles = () if model.attitude.states is ATTITUDE else zip(ATTITUDE, model.attitude.angles, strict=True)
    return (*produced, *extra, *angles, *model.bobs.outputs)


def _projection(model: _Model) -> tuple[Expr, ...]:
    """Put quaternion and directions back on their spheres; angles need nothing."""
    if model.attitude.states is ATTITUDE and not model.bobs.outputs:
        return ()
    return (*velocity, *rate, *model.attitude.projected, *model.bobs.projected)


def _constraints(p: Group, scenario: Group) -> tuple[Condition, ...]:
    """Return what parameters and initial state must satisfy."""
    triangle = Condition(
        sp.Min(p.J_y + p.J_z - p.J_x, p.J_z + p.J_x - p.J_y, p.J_x + p.J_y - p.J_z),
        "J_x = {J_x:g}, J_y = {J_y:g}, J_z = {J_z:g} kg m^2 are no moments of inertia of a body: "
        "each must be smaller than the other two together",
    )
    return (triangle, *(_in_radians(q) for q in scenario if q.unit == "rad"))


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
    bound = sp.Add(*(_largest_correction(bob, model.inertia, c) for bob in model.pendulums))
    weights = "r9 = {r9:g} s^2/kg is" if model.inertia == "ball" else "r9 = {r9:g}, r10 = {r10:g} s^2/kg are"
    message = (
        f"{weights} too large beside "
        "r4 = {r4:g}, r6 = {r6:g}, r8 = {r8:g} s^2/rad^2: "
        "the matrix f of (29) may lose its inverse"
    )
    return (thrust, Condition(sp.Min(c.r4, c.r6, c.r8) - bound, message))


def _largest_correction(bob: Pendulum, inertia: str, c: Group) -> Expr:
    """Bound what one pendulum takes from the eigenvalues of f: sum of m r |c|^2/D^2, with D_theta >= I."""
    whole = bob.mass * bob.length**2 + bob.inertia
    if inertia == "ball":
        return bob.mass * c.r9 * (1 + bob.mass * bob.length * sp.Abs(bob.pivot) / whole) ** 2
    swing = bob.mass * bob.length * (bob.length + sp.Abs(bob.pivot)) + bob.inertia
    of_phi = c.r9 * (swing**2 + bob.inertia**2) / whole**2
    of_theta = c.r10 * (swing**2 + whole**2) / bob.inertia**2
    return bob.mass * (of_phi + of_theta)


def _functions(
    model: _Model,
    laws: Mapping[str, tuple[Law, Group]],
    inputs: Mapping[str, Inputs],
    d: Derivation,
) -> tuple[Function, ...]:
    """Return energy, momentum, the inversion of the inputs, and what each law looks at."""
    x, p = model.states, model.p
    part, copies = parts(model.inertia, model.pendulums)
    (kinetic,) = whole((hull_energy(p),), (part.energy,), copies)
    momenta = whole(hull_momentum(p), (*part.linear, *part.angular), copies)
    d.section("Physical inputs of a demand")
    physical = to_physical(p, model.bobs.dynamics, DEMAND.symbols, "any", d)
    energy = Quantity("energy", "J", "kinetic energy")
    components = tuple(
        Quantity(f"{kind}{axis}", unit, title)
        for kind, unit, title in (("p", "kg m/s", "linear momentum"), ("h", "kg m^2/s", "angular momentum about O"))
        for axis in "xyz"
    )
    found = [
        Function("energy", (x, p), ((energy, kinetic),), "kinetic energy (5)"),
        Function(
            "momentum",
            (x, p),
            tuple(zip(components, momenta, strict=True)),
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
