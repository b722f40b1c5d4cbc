# SPDX-License-Identifier: Apache-2.0
"""The triangle as a `System`: derivation, laws and tables put together."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import sympy as sp

from ..mechanics import rotate
from ..system import Condition, Controller, Coordinates, Derivation, Expr, Function, Group, Quantity, System, scalar
from ..tables import read_parameters, read_scenarios
from . import controllers
from .controllers import ShiftedState
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

Law = Callable[[ShiftedState, Group, Derivation], tuple[Expr, Expr]]

STRUCTURE = {"masses": ("equal", "general")}
"""Structural choices and their values; the first is the default."""

_HERE = Path(__file__).parent
_SOURCE = (
    "Makarem, Salarieh, Vossoughi, Alasty: Kinematic attitude control of three pairwise connected in-plane masses "
    "by varying the lengths of the links"
)
_STATES = Group("x", (RHO, PHI, MU, THETA))
_INPUTS = Group("u", (W1, W2, W3))
_REFERENCES = Group(
    "r",
    (
        Quantity("rho_ref", "1", "target rho", r"\rho_f"),
        Quantity("phi_ref", "rad", "target phi", r"\varphi_f"),
        Quantity("mu_ref", "m^2", "target mu", r"\mu_f", positive=True),
        Quantity("theta_ref", "rad", "target attitude", r"\theta_f"),
    ),
)
_OUTPUTS = (
    Quantity("rho_error", "1", "distance to the target in the shape disc", r"\tilde\rho"),
    Quantity("phi_error", "rad", "direction of the target in the shape disc", r"\tilde\varphi"),
    Quantity("theta_shifted", "rad", "shifted attitude", r"\tilde\theta"),
    Quantity("theta_error", "rad", "attitude less target attitude"),
    Quantity("length_error", "m", "largest difference between a rod and its final length"),
)


_LIMITS = (
    Condition(
        sp.Rational(1, 2) - RHO.symbol**2,
        "rho left the disc rho < sqrt(2)/2: the three masses became collinear",
    ),
    Condition(MU.symbol, "mu is no longer positive: the three masses fell together"),
)
_LAWS: dict[str, tuple[str, Law]] = {
    "sliding": ("sliding mode on nested circles through the target, (29)-(39)", controllers.sliding),
    "path": ("online path: an arc that encloses the attitude error, (40)-(51)", controllers.path),
}


def system(masses: str = "equal") -> System:
    """Derive the triangle.

    Parameters
    ----------
    masses : {"equal", "general"}
        One mass for all three, or m1, m2, m3.

    Returns
    -------
    System
        Ready for code generation.
    """
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
    shifted = controllers.shifted_state(_REFERENCES, tables["laws"].area_factor, d)
    coordinates = _coordinates(theta_rate)
    final = target_lengths(lengths, _REFERENCES.rho_ref, _REFERENCES.phi_ref, _REFERENCES.mu_ref, d)
    laws = tuple(_law(name, title, law, tables, shifted, start[0], d) for name, (title, law) in _LAWS.items())
    return System(
        name="triangle",
        title="three planar masses joined by rods of variable length",
        source=_SOURCE,
        structure={"masses": masses},
        states=_STATES,
        inputs=_INPUTS,
        references=_REFERENCES,
        outputs=Group("y", LENGTHS + RATES + _OUTPUTS),
        parameters=plant,
        scenario_parameters=scenario,
        rhs=(*_INPUTS.symbols, polar_rate(theta_rate, d)),
        output=(
            *lengths,
            *rates,
            shifted.rho,
            sp.atan2(shifted.sine, shifted.cosine),
            shifted.exact_theta,
            THETA.symbol - _REFERENCES.theta_ref,
            sp.Max(*(sp.Abs(length - goal_length) for length, goal_length in zip(lengths, final, strict=True))),
        ),
        steps=tuple(d.steps),
        limits=_LIMITS,
        initial=(*start[:3], scenario.theta_0),
        reference=(*goal[:3], scenario.theta_f),
        constraints=(_inequality("initial", "0", scenario), _inequality("final", "f", scenario)),
        functions=_functions(lengths, rates, any_triangle, plant, masses),
        controllers=laws,
        scenarios=scenarios,
        metrics=metrics,
        coordinates=coordinates,
        geometry=geometry(each, stretched, base, _REFERENCES.theta_ref),
    )


def _law(
    name: str,
    title: str,
    law: Law,
    tables: dict[str, Group],
    shifted: ShiftedState,
    start_rho: Expr,
    d: Derivation,
) -> Controller:
    """Derive one law in a section of its own, followed by the law of mu that both share."""
    parameters = Group("c", tables[name].quantities + tables["laws"].quantities)
    d.section(f"Law: {title}")
    shape_rate = law(shifted, parameters, d)
    inside = Condition(
        parameters.R - _REFERENCES.rho_ref,
        "R = {R:g} must be larger than rho_f, the rho of the final rods "
        "l1_f = {l1_f:g} m, l2_f = {l2_f:g} m, l3_f = {l3_f:g} m",
    )
    begins = Condition(
        parameters.R - start_rho,
        "R = {R:g} must be larger than rho of the initial rods l1_0 = {l1_0:g} m, l2_0 = {l2_0:g} m, l3_0 = {l3_0:g} m",
    )
    command = (*shape_rate, controllers.size_rate(_REFERENCES, parameters))
    return Controller(name, title, parameters, command, (inside, begins))


def _coordinates(theta_rate: Expr) -> Coordinates:
    """Return the chart zeta = rho exp(i phi), regular at the base shape rho = 0."""
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


def _inequality(which: str, suffix: str, scenario: Group) -> Condition:
    """Return the triangle inequality of three rods; the collinear case is refused too."""
    a, b, c = (getattr(scenario, f"l{k}_{suffix}") for k in (1, 2, 3))
    message = (
        f"{which} rods l1_{suffix} = {{l1_{suffix}:g}} m, l2_{suffix} = {{l2_{suffix}:g}} m, "
        f"l3_{suffix} = {{l3_{suffix}:g}} m "
        "do not form a triangle: each must be shorter than the other two together"
    )
    return Condition(sp.Min(b + c - a, c + a - b, a + b - c), message)


def _functions(
    lengths: tuple[Expr, ...], rates: tuple[Expr, ...], placed: tuple[Expr, ...], plant: Group, masses: str
) -> tuple[Function, ...]:
    """Return the triangle's public functions; they need the plant's parameters only for unequal masses."""
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
