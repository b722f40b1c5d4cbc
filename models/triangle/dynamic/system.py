# SPDX-License-Identifier: Apache-2.0
"""The triangle with masses that forces move as a `System`: the paper's shape and laws read off lengths and heading."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import sympy as sp

from ...system import (
    Actuator,
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
)
from ...tables import read_parameters, read_scenarios
from ..controllers import shifted_state
from ..dynamics import (
    LENGTHS,
    MU,
    PHI,
    RATES,
    RHO,
    THETA,
    ZETA1,
    ZETA2,
    BaseTriangle,
    base_triangle,
    complement_squared,
    regular_shape,
    rod_lengths,
    rod_rates,
    shape_from_lengths,
    stretch,
    target_lengths,
    zeta,
)
from ..geometry import geometry
from ..task import ERRORS, REFERENCES, SOURCE, errors, inequality, laws
from .laws import computed_forces, limits, with_forces, with_thrust
from .motion import Motion, motion
from .plant import Gravity, Plant, gravity, kinetic, plant, potential
from .states import COSTS, DRIFT, FORCES, HEADING, INPUTS, STATES, lengths

_HERE = Path(__file__).parent
_OUTPUTS = (RHO, PHI, MU, THETA, *ERRORS)
_ACCELERATIONS = Group(
    "acceleration",
    tuple(Quantity(f"l{k}_acc", "m/s^2", f"acceleration of rod {k}", rf"\ddot l_{k}") for k in (1, 2, 3)),
)
_LIMITS = (
    Condition(
        sp.Min(*(sum(lengths) - 2 * length for length in lengths)),
        "the three masses became collinear: one rod is as long as the other two together",
    ),
)


def dynamic(masses: str) -> System:
    """Derive the triangle whose rods push its masses.

    Parameters
    ----------
    masses : {"equal", "general"}
        One mass for all three, or m1, m2, m3.
    """
    tables, own = read_parameters(_HERE.parent / "parameters.toml"), read_parameters(_HERE / "parameters.toml")
    p = Group("p", own["plant"].quantities + tables[f"masses_{masses}"].quantities)
    s = Group("s", tables["scenario"].quantities + own["scenario"].quantities)
    each = p.symbols[len(own["plant"]) :] * (3 if masses == "equal" else 1)
    d = Derivation()
    d.section("Base triangle")
    base = base_triangle(each, d)
    moving = motion(each, d)
    field = gravity(p, d)
    acting = plant(moving, field, d)
    d.section("Placing a triangle with given rods")
    start = shape_from_lengths((s.l1_0, s.l2_0, s.l3_0), base, d, "_0")
    goal = shape_from_lengths((s.l1_f, s.l2_f, s.l3_f), base, d, "_f")
    d.section("Shape and attitude of the rods")
    stretched = _stretch(base, d)
    theta = HEADING.symbol - _tilt(stretched)
    d.define(THETA.name, theta, title=THETA.description, unit="rad", latex=THETA.latex)
    from_shape = rod_lengths(stretched, base, d)
    rates = _rates(from_shape, d)
    d.section("Shifted coordinates")
    shifted = shifted_state(REFERENCES, tables["laws"].area_factor, d)
    final = target_lengths(from_shape, REFERENCES.rho_ref, REFERENCES.phi_ref, REFERENCES.mu_ref, d)
    controllers = _forceful(laws(tables, shifted, start[0], d), rates, acting, moving, own, d)
    functions = _functions(p, moving, field, acting, d)
    commanded, applied = limits(p)
    scenarios, metrics = _runs(masses)
    return System(
        name="triangle",
        title="three planar masses joined by rods that push",
        source=SOURCE,
        structure={"masses": masses, "model": "dynamic"},
        states=STATES,
        inputs=INPUTS,
        references=REFERENCES,
        outputs=Group("y", _OUTPUTS),
        parameters=p,
        scenario_parameters=s,
        rhs=acting.rhs,
        output=(*_polar(), MU.symbol, THETA.symbol, *errors(shifted, lengths, final)),
        steps=tuple(d.steps),
        limits=_LIMITS,
        initial=_initial(s, start),
        reference=(*goal[:3], s.theta_f),
        constraints=(inequality("initial", "0", s), inequality("final", "f", s)),
        functions=functions,
        controllers=controllers,
        scenarios=scenarios,
        metrics=metrics,
        actuator=Actuator(commanded, applied),
        geometry=geometry(each, stretched, base, REFERENCES.theta_ref),
    )


def _stretch(base: BaseTriangle, d: Derivation) -> sp.Matrix:
    """Define zeta and mu, which are the paper's states, by the rods; return S."""
    z1, z2, _, margin = regular_shape(lengths, base, d, "")
    n = sp.sqrt(complement_squared(margin))
    for quantity, z in ((ZETA1, z1), (ZETA2, z2)):
        d.define(quantity.name, z / n, "(19)", quantity.description, latex=quantity.latex)
    return stretch(d)


def _tilt(stretched: sp.Matrix) -> Expr:
    """Return the direction of rod 3 from the attitude: S d_3, as edge 3 of the base triangle points along x."""
    return sp.atan2(stretched[1, 0], stretched[0, 0])


def _rates(from_shape: tuple[Expr, ...], d: Derivation) -> tuple[Expr, ...]:
    """Return the rates of the rods (22) for rates of zeta and mu, with the rods' lengths themselves in them."""
    aside = Derivation(d.steps)
    here = dict(zip(from_shape, lengths, strict=True))
    return tuple(aside.definitions[rate].xreplace(here) for rate in rod_rates(from_shape, aside))


def _polar() -> tuple[Expr, Expr]:
    return sp.sqrt(zeta.dot(zeta)), sp.atan2(zeta[1], zeta[0])


def _initial(s: Group, start: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """Return the state in which rods and attitude are as the scenario has them; thrust has done nothing yet."""
    rho, phi, size, _ = start
    aside = Derivation()
    stretched = stretch(aside)
    shape = {zeta[0]: rho * sp.cos(phi), zeta[1]: rho * sp.sin(phi), MU.symbol: size}
    tilt = _tilt(stretched).subs(aside.definitions).subs(shape, simultaneous=True)
    lengths_0, rates_0 = ((getattr(s, f"{q.name}_0") for q in group) for group in (LENGTHS, RATES))
    return (*lengths_0, s.theta_0 + tilt, *rates_0, s.H_0, s.nu_0, *(sp.S.Zero for _ in (*DRIFT, *COSTS)))


def _forceful(
    plain: tuple[Controller, ...],
    rates: tuple[Expr, ...],
    acting: Plant,
    moving: Motion,
    own: Mapping[str, Group],
    d: Derivation,
) -> tuple[Controller, ...]:
    """Return the paper's laws with computed forces, and the path law beside thrust."""
    controllers = {law.name: with_forces(law, rates, acting, own["tracking"], d) for law in plain}
    return (*controllers.values(), with_thrust(controllers["path"], moving, acting, own["thrust"]))


def _runs(masses: str) -> tuple[tuple[Scenario, ...], tuple[Metric, ...]]:
    """Return the paper's runs, which are expected to differ here, and those of this model, with the metrics of both."""
    paper, shared = read_scenarios(_HERE.parent / "scenarios.toml")
    further, costs = read_scenarios(_HERE / "scenarios.toml")
    runs = (*(dataclasses.replace(run, expect={}) for run in paper), *further)
    if masses == "general":
        runs = tuple(dataclasses.replace(run, values=_by_mass(run.values)) for run in runs)
    return runs, (*shared, *costs)


def _by_mass(values: Mapping[str, float]) -> dict[str, float]:
    """Give each of three masses what a scenario gives the one."""
    others = {name: value for name, value in values.items() if name != "mass"}
    return others | {f"m{k}": values["mass"] for k in (1, 2, 3) if "mass" in values}


def _functions(p: Group, moving: Motion, field: Gravity, acting: Plant, d: Derivation) -> tuple[Function, ...]:
    """Return energies and the forces of given accelerations."""
    d.section("Forces of given accelerations")
    push = computed_forces(_ACCELERATIONS.symbols, acting, "any", d)
    energies = (
        (Quantity("kinetic", "J", "kinetic energy"), kinetic(moving, tuple(q.symbol for q in DRIFT))),
        (Quantity("potential", "J", "potential energy in the gravity gradient"), potential(moving, field)),
    )
    return (
        Function("energy", (STATES, p), energies, "kinetic energy, and potential energy in the gravity gradient"),
        Function(
            "forces",
            (STATES, _ACCELERATIONS, p),
            tuple(zip(FORCES, push, strict=True)),
            "forces of the rods that give their lengths accelerations, without thrust",
            vector="F",
        ),
    )
