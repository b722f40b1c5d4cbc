# SPDX-License-Identifier: Apache-2.0
"""Control task of all triangle models: target, errors and laws."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import sympy as sp

from ..system import Condition, Controller, Derivation, Expr, Group, Quantity
from . import controllers
from .controllers import ShiftedState
from .dynamics import THETA

Law = Callable[[ShiftedState, Group, Derivation], tuple[Expr, Expr]]

SOURCE = (
    "Makarem, Salarieh, Vossoughi, Alasty: Kinematic attitude control of three pairwise connected in-plane masses "
    "by varying the lengths of the links"
)
REFERENCES = Group(
    "r",
    (
        Quantity("rho_ref", "1", "target rho", r"\rho_f"),
        Quantity("phi_ref", "rad", "target phi", r"\varphi_f"),
        Quantity("mu_ref", "m^2", "target mu", r"\mu_f", positive=True),
        Quantity("theta_ref", "rad", "target attitude", r"\theta_f"),
    ),
)
ERRORS = (
    Quantity("rho_error", "1", "distance to the target in the shape disc", r"\tilde\rho"),
    Quantity("phi_error", "rad", "direction of the target in the shape disc", r"\tilde\varphi"),
    Quantity("theta_shifted", "rad", "shifted attitude", r"\tilde\theta"),
    Quantity("theta_error", "rad", "attitude less target attitude"),
    Quantity("length_error", "m", "largest difference between a rod and its final length"),
)
_LAWS: dict[str, tuple[str, Law]] = {
    "sliding": ("sliding mode on nested circles through the target, (29)-(39)", controllers.sliding),
    "path": ("online path: an arc that encloses the attitude error, (40)-(51)", controllers.path),
}


def errors(shifted: ShiftedState, lengths: Sequence[Expr], final: Sequence[Expr]) -> tuple[Expr, ...]:
    """Return the errors of a state; `lengths` are its rods and `final` the target's, m."""
    return (
        shifted.rho,
        sp.atan2(shifted.sine, shifted.cosine),
        shifted.exact_theta,
        THETA.symbol - REFERENCES.theta_ref,
        sp.Max(*(sp.Abs(length - goal_length) for length, goal_length in zip(lengths, final, strict=True))),
    )


def laws(
    tables: Mapping[str, Group], shifted: ShiftedState, ends: tuple[Expr, Expr], d: Derivation
) -> tuple[Controller, ...]:
    """Derive the paper's laws as rates of zeta and mu; `ends` are rho at start and target."""
    return tuple(_law(name, title, law, tables, shifted, ends, d) for name, (title, law) in _LAWS.items())


def _law(
    name: str,
    title: str,
    law: Law,
    tables: Mapping[str, Group],
    shifted: ShiftedState,
    ends: tuple[Expr, Expr],
    d: Derivation,
) -> Controller:
    """Derive one law in its own section, followed by the common law of mu."""
    parameters = Group("c", tables[name].quantities + tables["laws"].quantities)
    d.section(f"Law: {title}")
    shape_rate = law(shifted, parameters, d)
    inside = Condition(
        parameters.R - ends[1],
        "R = {R:g} must be larger than rho_f, the rho of the final rods "
        "l1_f = {l1_f:g} m, l2_f = {l2_f:g} m, l3_f = {l3_f:g} m",
    )
    begins = Condition(
        parameters.R - ends[0],
        "R = {R:g} must be larger than rho of the initial rods l1_0 = {l1_0:g} m, l2_0 = {l2_0:g} m, l3_0 = {l3_0:g} m",
    )
    command = (*shape_rate, controllers.size_rate(REFERENCES, parameters))
    return Controller(name, title, parameters, command, (inside, begins))


def inequality(which: str, suffix: str, scenario: Group) -> Condition:
    """Return the triangle inequality of three rods, which also excludes collinear masses."""
    a, b, c = (getattr(scenario, f"l{k}_{suffix}") for k in (1, 2, 3))
    message = (
        f"{which} rods l1_{suffix} = {{l1_{suffix}:g}} m, l2_{suffix} = {{l2_{suffix}:g}} m, "
        f"l3_{suffix} = {{l3_{suffix}:g}} m "
        "do not form a triangle: each must be shorter than the other two together"
    )
    return Condition(sp.Min(b + c - a, c + a - b, a + b - c), message)
