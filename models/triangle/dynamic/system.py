# SPDX-License-Identifier: Apache-2.0
"""The dynamic triangle as a `System`, with the paper's laws applied to its shape."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import sympy as sp

from ...system import (
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
    MU,
    PHI,
    RHO,
    THETA,
    base_triangle,
    rod_lengths,
    shape_from_lengths,
    target_lengths,
)
from ..geometry import geometry
from ..task import ERRORS, REFERENCES, SOURCE, errors, inequality, laws
from .bodies import bodies, not_too_heavy
from .laws import computed_forces, limits, with_forces, with_thrust
from .motion import Motion, motion
from .plant import Gravity, Plant, gravity, kinetic, plant, potential
from .shape import first_state, polar, rates_of_shape, shape_and_attitude
from .states import DRIFT, FORCES, INPUTS, STATES, lengths

_HERE = Path(__file__).parent
_OUTPUTS = (RHO, PHI, MU, THETA, *ERRORS)
_ACCELERATIONS = Group(
    "acceleration",
    tuple(Quantity(f"l{k}_acc", "m/s^2", f"acceleration of rod {k}", rf"\ddot l_{k}") for k in (1, 2, 3)),
)
_ENERGIES = (
    Quantity("kinetic", "J", "kinetic energy"),
    Quantity("potential", "J", "potential energy in the gravity gradient"),
)
_IN_LINE = sp.Rational(1, 10**9)
"""Relative margin below which masses count as collinear; angles then differ from a line's by at most 1e-4. Without
this limit most collinear runs end as not finite, because the rates lose all digits.
"""
_LIMITS = (
    Condition(
        sp.Min(*(sum(lengths) - 2 * length for length in lengths)) - _IN_LINE * sum(lengths),
        "the three masses became collinear: one rod is as long as the other two together",
    ),
)


def dynamic(masses: str, rods: str) -> System:
    """Derive the triangle with masses that rod forces move.

    Parameters
    ----------
    masses : {"equal", "general"}
        One mass for all three, or m1, m2, m3.
    rods : {"light", "uniform"}
        Rods without mass, or with mass spread evenly.
    """
    tables, own = read_parameters(_HERE.parent / "parameters.toml"), read_parameters(_HERE / "parameters.toml")
    heavy = own[f"rods_uniform_{masses}"].quantities if rods == "uniform" else ()
    p = Group("p", (*own["orbit"], *own["rods"], *tables[f"masses_{masses}"], *heavy))
    s = Group("s", tables["scenario"].quantities + own["scenario"].quantities)
    d = Derivation()
    massive = bodies(p, masses, rods, d)
    d.section("Base triangle")
    base = base_triangle(massive.masses, d)
    moving = motion(massive, d)
    field = gravity(p, d)
    acting = plant(moving, field, d)
    d.section("Placing a triangle with given rods")
    start = shape_from_lengths((s.l1_0, s.l2_0, s.l3_0), base, d, "_0")
    goal = shape_from_lengths((s.l1_f, s.l2_f, s.l3_f), base, d, "_f")
    d.section("Shape and attitude of the rods")
    stretched = shape_and_attitude(base, d)
    from_shape = rod_lengths(stretched, base, d)
    commanded = rates_of_shape(from_shape, d)
    d.section("Shifted coordinates")
    shifted = shifted_state(REFERENCES, tables["laws"].area_factor, d)
    final = target_lengths(from_shape, REFERENCES.rho_ref, REFERENCES.phi_ref, REFERENCES.mu_ref, d)
    controllers = _forceful(laws(tables, shifted, (start[0], goal[0]), d), commanded, acting, moving, own, d)
    functions = _functions(p, moving, field, acting, d)
    scenarios, metrics = _runs(masses)
    return System(
        name="triangle",
        title="three planar masses joined by rods that push",
        source=SOURCE,
        structure={"masses": masses, "model": "dynamic", "rods": rods},
        states=STATES,
        inputs=INPUTS,
        references=REFERENCES,
        outputs=Group("y", _OUTPUTS),
        parameters=p,
        scenario_parameters=s,
        rhs=acting.rhs,
        output=(*polar(), MU.symbol, THETA.symbol, *errors(shifted, lengths, final)),
        steps=tuple(d.steps),
        limits=_LIMITS,
        initial=first_state(s, start),
        reference=(*goal[:3], s.theta_f),
        constraints=(
            inequality("initial", "0", s),
            inequality("final", "f", s),
            *((not_too_heavy(p),) if heavy and masses == "general" else ()),
        ),
        functions=functions,
        controllers=controllers,
        scenarios=scenarios,
        metrics=metrics,
        actuator=limits(p),
        geometry=geometry(massive.lumps, stretched, base, REFERENCES.theta_ref),
    )


def _forceful(
    plain: tuple[Controller, ...],
    commanded: tuple[Expr, ...],
    acting: Plant,
    moving: Motion,
    own: Mapping[str, Group],
    d: Derivation,
) -> tuple[Controller, ...]:
    """Return the paper's laws with computed forces, and the path law with thrust."""
    tracking = Group("c", own["tracking"].quantities + own["rates"].quantities)
    controllers = {law.name: with_forces(law, commanded, acting, tracking, d) for law in plain}
    return (*controllers.values(), with_thrust(controllers["path"], moving, acting, own["thrust"]))


def _runs(masses: str) -> tuple[tuple[Scenario, ...], tuple[Metric, ...]]:
    """Return the paper's scenarios without expected results, this model's scenarios, and all metrics."""
    paper, shared = read_scenarios(_HERE.parent / "scenarios.toml")
    further, costs = read_scenarios(_HERE / "scenarios.toml")
    runs = (*(dataclasses.replace(run, expect={}) for run in paper), *further)
    if masses == "general":
        runs = tuple(map(_by_mass, runs))
    return runs, (*shared, *costs)


def _by_mass(run: Scenario) -> Scenario:
    """Replace a scenario's single mass by three equal ones."""
    others = {name: value for name, value in run.values.items() if name != "mass"}
    each = {f"m{k}": run.values["mass"] for k in (1, 2, 3) if "mass" in run.values}
    return dataclasses.replace(run, values=others | each)


def _functions(p: Group, moving: Motion, field: Gravity, acting: Plant, d: Derivation) -> tuple[Function, ...]:
    """Return energies, and the forces of given accelerations."""
    d.section("Forces of given accelerations")
    push = computed_forces(_ACCELERATIONS.symbols, acting, "any", d)
    energies = (kinetic(moving, tuple(q.symbol for q in DRIFT)), potential(moving, field))
    return (
        Function(
            "energy",
            (STATES, p),
            tuple(zip(_ENERGIES, energies, strict=True)),
            "kinetic energy, and potential energy in the gravity gradient",
        ),
        Function(
            "forces",
            (STATES, _ACCELERATIONS, p),
            tuple(zip(FORCES, push, strict=True)),
            "forces of the rods that give their lengths accelerations, without thrust",
            vector="F",
        ),
    )
