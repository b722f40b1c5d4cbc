# SPDX-License-Identifier: Apache-2.0
"""The spacecraft with sloshing fuel as a `System`, from derivation, laws and tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from mehvar.base.names import identifier

from ..system import (
    Choice,
    Controller,
    Derivation,
    Expr,
    Function,
    Group,
    Output,
    Quantity,
    System,
    Variant,
    surfaces,
)
from ..tables import read_parameters, read_scenarios
from .derived import residuals, show
from .geometry import geometry
from .laws.conditions import constraints, law_constraints
from .laws.controllers import Law, lyapunov_v1, lyapunov_v2
from .laws.thrust import Inputs, gimbal_limits, to_physical
from .pendulums import Pendulums, Start, angle_pendulums, ball_pendulums, equilibrium, parts
from .plant.attitude import Attitude, by_angles, by_quaternion
from .plant.equations import hull_energy, hull_momentum, hull_wrench, whole
from .plant.reduced import longitudinal, reduced_velocity
from .states import (
    ATTITUDE,
    DEMAND,
    GIMBALS,
    INPUTS,
    RATE,
    VELOCITY,
    Pendulum,
    pendulum_parameters,
    point_allowed,
    rate,
    velocity,
)

MOST = 64
"""Largest offered number of pendulums; only the size of the equations limits it."""
STRUCTURE = {
    "pendulums": ("2", "1", *(str(k) for k in range(3, MOST + 1))),
    "inertia": ("paper", "hinge", "ball"),
    "attitude": ("angles", "quaternion"),
    "switches": ("crossed", "located"),
}
"""Structural choices with their values; the first value is the default."""

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
    """Derived parts of the model that functions, laws and variants use."""

    p: Group
    inertia: str
    pendulums: tuple[Pendulum, ...]
    attitude: Attitude
    bobs: Pendulums
    axial: Expr
    linear: tuple[Expr, ...]
    angular: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]

    @property
    def states(self) -> Group:
        """The state."""
        return Group("x", (*VELOCITY, *RATE, *self.attitude.chart.states, *self.bobs.states))


def system(
    pendulums: str = "2",
    inertia: str = "paper",
    attitude: str = "angles",
    switches: str = "crossed",
) -> System:
    """Derive the spacecraft.

    Parameters
    ----------
    pendulums : str
        How many, "1" to "64"; the default is the paper's.
    inertia : {"paper", "hinge", "ball"}
        Bobs as rotors geared to the angles, as published; rigid on hinges; or on ball joints, without angles.
    attitude : {"angles", "quaternion"}
        Three angles, small or 3-2-1 as the run chooses, or a quaternion.
    switches : {"crossed", "located"}
        "located": steps end where a law's demand reaches the thrust limit and where gimbals reach their limits.

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
    show(p, inertia, d)
    placed = by_angles(d) if attitude == "angles" else by_quaternion(d)
    model = _derive(p, bobs, inertia, placed, scenario, d)
    demanded = {name: _derive_law(name, model, tables, d) for name in _LAWS}
    inputs = {name: _physical(law, name[-2:], model, d) for name, (law, _) in demanded.items()}
    functions = _functions(model, demanded, inputs, d)
    actuator = gimbal_limits(p, model.bobs.dynamics, d)
    choices = (_PLANT, _ATTITUDE) if attitude == "angles" else (_PLANT,)
    laws = {name: law for name, (law, _) in demanded.items()}
    rates, residual = residuals(p, bobs, inertia)
    force = [symbol for symbol in d.definitions if symbol.name in ("f_x", "f_y", "f_z")]
    return System(
        name="slosh",
        title="spacecraft with sloshing fuel, steered by its thrust",
        source=_SOURCE,
        structure={
            "pendulums": pendulums,
            "inertia": inertia,
            "attitude": attitude,
            "switches": switches,
        },
        states=model.states,
        inputs=INPUTS,
        references=_REFERENCES,
        outputs=Group("y", tuple(quantity for quantity, _ in _outputs(model))),
        parameters=p,
        scenario_parameters=scenario,
        rhs=_full(model, next(iter(placed.rates))),
        output=tuple(expr for _, expr in _outputs(model)),
        steps=tuple(d.steps),
        initial=(*scenario.symbols[:6], *placed.chart.of_angles(scenario.symbols[6:9]), *model.bobs.start),
        constraints=constraints(p, scenario),
        functions=functions,
        controllers=tuple(
            Controller(
                name,
                _LAWS[name],
                c,
                inputs[name].command,
                law_constraints(name, p, c, bobs, inertia),
                outputs=_reports(law, inputs[name]),
                events=()
                if switches == "crossed"
                else surfaces("demand", (*inputs[name].command, *actuator.applied), d),
            )
            for name, (law, c) in demanded.items()
        ),
        scenarios=scenarios,
        metrics=metrics,
        actuator=actuator,
        projection=_projection(model),
        choices=choices,
        variants=_variants(model, choices, laws),
        rates=rates,
        residual=residual,
        geometry=geometry(p, bobs, inertia, placed.angles, force),
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
        Convention of inertia; on ball joints I_i = 0, a point bob, is allowed.
    """
    groups = [pendulum_parameters(k, tables[f"pendulum{min(k, 2)}"]) for k in range(1, count + 1)]
    if inertia == "ball":
        groups = [tuple(point_allowed(q) if q.name.startswith("I") else q for q in group) for group in groups]
    p = Group("p", (*tables["plant"].quantities, *(q for group in groups for q in group)))
    return p, tuple(Pendulum(str(k), *(q.symbol for q in group)) for k, group in enumerate(groups, 1))


def _derive(
    p: Group, pendulums: tuple[Pendulum, ...], inertia: str, placed: Attitude, scenario: Group, d: Derivation
) -> _Model:
    """Return plant, pendulums and longitudinal acceleration for one form of the bobs' inertia."""
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
        bobs = ball_pendulums(p, pendulums, starts, (scenario.wx_0, scenario.wy_0, scenario.wz_0), d)
    else:
        bobs = angle_pendulums(p, pendulums, inertia, starts, d)
    plant = bobs.dynamics
    part, copies = parts(inertia, pendulums)
    still = equilibrium(inertia)
    (left,) = whole((hull_wrench(p)[0].xreplace(still),), (part.force[0].xreplace(still),), copies)
    axial = longitudinal(p.F, left, d)
    return _Model(p, inertia, pendulums, placed, bobs, axial, plant.linear, plant.angular, plant.acceleration)


def _full(model: _Model, kinematics: str) -> tuple[Expr, ...]:
    """Return x' of the full model."""
    return (*model.linear, *model.angular, *model.attitude.rates[kinematics], *model.bobs.rates)


def _reduced(model: _Model, demand: Sequence[Expr], kinematics: str) -> tuple[Expr, ...]:
    """Return x' of the reduced model with inputs u1..u5."""
    linear = reduced_velocity(model.axial, demand)
    bobs = model.bobs.reduced((model.axial, *demand[:2]), demand[2:])
    return (*linear, *demand[2:], *model.attitude.rates[kinematics], *bobs)


def _variants(model: _Model, choices: Sequence[Choice], laws: Mapping[str, Law]) -> tuple[Variant, ...]:
    """Return every combination of plant and kinematics except the default.

    The reduced plant receives as u1..u5 the accelerations that the physical inputs produce; in a closed loop, as in
    the paper, those that the law demands.
    """
    produced = (*model.acceleration[1:], *model.angular)
    variants = []
    for plant in _PLANT.values:
        for kinematics in model.attitude.rates:
            values = (plant, kinematics)[: len(choices)]
            if plant == "full":
                variants.append(Variant(values, _full(model, kinematics), {}))
            else:
                loops = {name: _reduced(model, law.demand, kinematics) for name, law in laws.items()}
                variants.append(Variant(values, _reduced(model, produced, kinematics), loops))
    return tuple(variants[1:])


def _derive_law(name: str, model: _Model, tables: Mapping[str, Group], d: Derivation) -> tuple[Law, Group]:
    """Return a law, and its parameters without the weights that this form of inertia does not use."""
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
    """Return the resulting accelerations, the lateral thrust, and angles that are not states."""
    d1, d2 = (q.symbol for q in GIMBALS)
    across = sp.sqrt(sp.sin(d2) ** 2 + (sp.sin(d1) * sp.cos(d2)) ** 2)
    produced = zip(DEMAND, (*model.acceleration[1:], *model.angular), strict=True)
    extra = zip(_EXTRA, (model.acceleration[0], across), strict=True)
    angles = () if model.attitude.chart.states == ATTITUDE else zip(ATTITUDE, model.attitude.angles, strict=True)
    return (*produced, *extra, *angles, *model.bobs.outputs)


def _projection(model: _Model) -> tuple[Expr, ...]:
    """Return quaternion and directions scaled to unit length; angles need no projection."""
    chart = model.attitude.chart
    if not chart.projection() and not model.bobs.outputs:
        return ()
    return (*velocity, *rate, *(chart.projection() or chart.symbols), *model.bobs.projected)


def _functions(
    model: _Model,
    laws: Mapping[str, tuple[Law, Group]],
    inputs: Mapping[str, Inputs],
    d: Derivation,
) -> tuple[Function, ...]:
    """Return energy, momentum, the inverse of the inputs, and the functions that each law uses."""
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
    functions = [
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
        title = identifier(name)
        value = Quantity("V", "1", f"Lyapunov function of {name}")
        values = (*law.demand, inputs[name].lateral, inputs[name].excess)
        functions += [
            Function(f"{title}_value", (x, p, c), ((value, law.value),), f"Lyapunov function of {name}"),
            Function(
                f"{title}_demand",
                (x, p, c),
                tuple(zip(demanded, values, strict=True)),
                f"what {name} demands: u1..u5, lateral force, and how much of it is beyond the thrust",
                vector="demand",
            ),
        ]
    return tuple(functions)


def _reports(law: Law, inputs: Inputs) -> tuple[Output, ...]:
    """Report V and the lateral force that the law demands; a demand above F is infeasible."""
    value = Quantity("V", "1", "Lyapunov function")
    lateral, excess = _DEMANDED
    return (Output(value, law.value), Output(lateral, inputs.lateral), Output(excess, inputs.excess, at_most=0.0))


_DEMANDED = (
    Quantity("lateral_demand", "N", "demanded lateral force"),
    Quantity("lateral_excess", "N", "demanded lateral force beyond the thrust"),
)
