# SPDX-License-Identifier: Apache-2.0
"""The triangle as a `System`, from derivation, laws and tables."""

from __future__ import annotations

from pathlib import Path

import sympy as sp

from ..mechanics import rotate
from ..system import Condition, Coordinates, Derivation, Expr, Function, Group, ModelError, System, scalar
from ..tables import read_parameters, read_scenarios
from .controllers import shifted_state
from .dynamic.system import dynamic
from .dynamics import (
    LENGTHS,
    MU,
    PHI,
    RATES,
    RHO,
    THETA,
    W1,
    W2,
    W3,
    ZETA1,
    ZETA1_RATE,
    ZETA2,
    ZETA2_RATE,
    attitude_rate,
    base_triangle,
    polar_rate,
    rod_lengths,
    rod_rates,
    shape_from_lengths,
    stretch,
    target_lengths,
)
from .geometry import geometry
from .task import ERRORS, REFERENCES, SOURCE, errors, inequality, laws

STRUCTURE = {
    "masses": ("equal", "general"),
    "model": ("kinematic", "dynamic"),
    "rods": ("light", "uniform"),
}
"""Structural choices with their values; the first value is the default."""

_HERE = Path(__file__).parent
_STATES = Group("x", (RHO, PHI, MU, THETA))
_INPUTS = Group("u", (W1, W2, W3))
_LIMITS = (
    Condition(
        sp.Rational(1, 2) - RHO.symbol**2,
        "rho left the disc rho < sqrt(2)/2: the three masses became collinear",
    ),
    Condition(MU.symbol, "mu is no longer positive: the three masses fell together"),
)


def system(masses: str = "equal", model: str = "kinematic", rods: str = "light") -> System:
    """Derive the triangle.

    Parameters
    ----------
    masses : {"equal", "general"}
        One mass for all three, or m1, m2, m3.
    model : {"kinematic", "dynamic"}
        Rods that follow their commanded rates exactly, as in the paper, or rods that push the masses.
    rods : {"light", "uniform"}
        Rods without mass, or with mass spread evenly, for model = dynamic.

    Returns
    -------
    System
        Ready for code generation.

    Raises
    ------
    ModelError
        For rods with mass in the kinematic model.
    """
    if rods == "uniform" and model != "dynamic":
        raise ModelError(f"rods = 'uniform' with model = {model!r}: needs model = 'dynamic'")
    return dynamic(masses, rods) if model == "dynamic" else _kinematic(masses)


def _kinematic(masses: str) -> System:
    """Derive the paper's kinematic model."""
    tables = read_parameters(_HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    own = tables[f"masses_{masses}"]
    plant = Group("p", tables["plant"].quantities + own.quantities)
    scenario = Group("s", tables["scenario"].quantities)
    d = Derivation()
    d.section("Base triangle")
    each = own.symbols * 3 if masses == "equal" else own.symbols
    base = base_triangle(each, d)
    d.section("Shape, attitude and rods")
    stretched = stretch(d)
    drift = plant.disturbance
    theta_rate = attitude_rate(stretched, base, plant.H, d) + drift
    lengths = rod_lengths(stretched, base, d)
    rates = rod_rates(lengths, d)
    d.section("Placing a triangle with given rods")
    start = shape_from_lengths((scenario.l1_0, scenario.l2_0, scenario.l3_0), base, d, "_0")
    goal = shape_from_lengths((scenario.l1_f, scenario.l2_f, scenario.l3_f), base, d, "_f")
    any_triangle = shape_from_lengths(tuple(q.symbol for q in LENGTHS), base, d, "_any")
    d.section("Shifted coordinates")
    shifted = shifted_state(REFERENCES, tables["laws"].area_factor, d)
    coordinates = _coordinates(theta_rate)
    final = target_lengths(lengths, REFERENCES.rho_ref, REFERENCES.phi_ref, REFERENCES.mu_ref, d)
    controllers = laws(tables, shifted, (start[0], REFERENCES.rho_ref), d)
    return System(
        name="triangle",
        title="three planar masses joined by rods of variable length",
        source=SOURCE,
        structure={"masses": masses, "model": "kinematic", "rods": "light"},
        states=_STATES,
        inputs=_INPUTS,
        references=REFERENCES,
        outputs=Group("y", LENGTHS + RATES + ERRORS),
        parameters=plant,
        scenario_parameters=scenario,
        rhs=(*_INPUTS.symbols, polar_rate(theta_rate, d)),
        output=(*lengths, *rates, *errors(shifted, lengths, final)),
        steps=tuple(d.steps),
        limits=_LIMITS,
        initial=(*start[:3], scenario.theta_0),
        reference=(*goal[:3], scenario.theta_f),
        constraints=(inequality("initial", "0", scenario), inequality("final", "f", scenario)),
        functions=_functions(lengths, rates, any_triangle, plant, masses),
        controllers=controllers,
        scenarios=scenarios,
        metrics=metrics,
        coordinates=coordinates,
        geometry=geometry(each, stretched, base, REFERENCES.theta_ref),
    )


def _coordinates(theta_rate: Expr) -> Coordinates:
    """Return the chart zeta = rho exp(i phi), which is regular at rho = 0."""
    rho, phi = RHO.symbol, PHI.symbol
    zeta1, zeta2 = ZETA1.symbol, ZETA2.symbol
    radial, transverse = ZETA1_RATE.symbol, ZETA2_RATE.symbol
    distance = sp.sqrt(zeta1**2 + zeta2**2)
    away = distance > 0
    along = (zeta1 * radial + zeta2 * transverse) / distance
    around = (zeta1 * transverse - zeta2 * radial) / distance**2
    return Coordinates(
        states=Group("q", (ZETA1, ZETA2, MU, THETA)),
        inputs=Group("n", (ZETA1_RATE, ZETA2_RATE, W3)),
        rhs=(radial, transverse, W3.symbol, theta_rate),
        from_state=(rho * sp.cos(phi), rho * sp.sin(phi), MU.symbol, THETA.symbol),
        from_input=(*rotate((W1.symbol, rho * W2.symbol), sp.cos(phi), sp.sin(phi)), W3.symbol),
        to_state=(distance, sp.atan2(zeta2, zeta1), MU.symbol, THETA.symbol),
        to_input=(
            sp.Piecewise((along, away), (radial, True)),
            sp.Piecewise((around, away), (0, True)),
            W3.symbol,
        ),
    )


def _functions(
    lengths: tuple[Expr, ...], rates: tuple[Expr, ...], placed: tuple[Expr, ...], plant: Group, masses: str
) -> tuple[Function, ...]:
    """Return the triangle's public functions; only for unequal masses do they depend on plant parameters."""
    last = (plant,) if masses == "general" else ()
    return (
        Function(
            "lengths",
            (scalar(RHO), scalar(PHI), scalar(MU), *last),
            tuple(zip(LENGTHS, lengths, strict=True)),
            "rod lengths of a shape (20)",
        ),
        Function(
            "shape",
            (*map(scalar, LENGTHS), *last),
            tuple(zip((RHO, PHI, MU), placed, strict=False)),
            "shape with given rod lengths (19)",
        ),
        Function(
            "length_rates",
            (_STATES, _INPUTS, *last),
            tuple(zip(RATES, rates, strict=True)),
            "rod rates (22)",
            vector="u_l",
        ),
    )
