# SPDX-License-Identifier: Apache-2.0
"""A rigid bob on hinges: theta about -x, then phi about the turned y axis."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ...system import Derivation, Expr
from ..states import Pendulum
from .hull import Arm, Lump, Pull
from .swing import Namer, Swing, along_arm, at_centre, bias_in_body, in_body, phi_acceleration


def hinged_pull(a: Pendulum, arm: Arm, swing: Swing, hull: Lump, d: Derivation) -> Pull:
    """Return a pendulum's terms with a rigid bob on hinges: theta about -x, then phi."""
    name = Namer(a.name, swing, d)
    _, pull, radial, along = along_arm(a, arm, hull, name)
    s, c, wn, w = swing.s, swing.c, swing.wn, swing.w
    q = name("q_", a.length * s, "distance of the bob from the pivot's axis", "m")
    whole = name("th_", 1 / (a.mass * q**2 + a.inertia), "reciprocal of the inertia of theta", "1/(kg m^2)")
    weight = name("wb_", arm.total * a.inertia * whole, "inertia that turns with W_t", "kg m^2")
    kc = name("kc_", arm.ratio * c)
    side = name("side", 1 - arm.lever * kc)
    pressed = name("wkc_", weight * kc)
    across = [pressed * kc, -pressed * side, weight * side**2]
    matrix = in_body(radial, along, across, name)
    phi_loss = name("loss_phi", a.damping * swing.phi_rate, "damping moment of phi", "N m")
    theta_loss = name("loss_theta", a.damping * swing.theta_rate, "damping moment of theta", "N m")
    p_chi = name("p_chi", swing.p * swing.chi, "product of rates of the arm", "rad^2/s^2")
    swinging = a.mass * a.length * q
    crosswise = a.inertia * (arm.total * w * (swing.phi_rate - wn) + c * a.mass * a.length**2 * p_chi)
    twist = name("twist", whole * (crosswise + c * swinging * theta_loss), "moment about e_t", "N m")
    swung = arm.ratio * (a.inertia * swing.nu_chi - phi_loss)
    swung = name("F_phi", swung, "force along e_phi", "N")
    side_force = -kc * twist - arm.ratio * (s * theta_loss + a.inertia * p_chi)
    side_force = name("F_n", side_force, "force along e_n", "N")
    forward = name("F_t", s * pull + c * swung, "force along e_t", "N")
    bias = bias_in_body(
        (s * swung - c * pull, forward, side_force),
        (arm.lever * forward + phi_loss, arm.lever * side_force + twist),
        theta_loss,
        name,
    )
    return Pull(matrix, tuple(bias))


def hinged_angles(
    a: Pendulum, arm: Arm, swing: Swing, hull: Lump, unknown: Sequence[Expr], d: Derivation
) -> tuple[Expr, Expr]:
    """Return the angle accelerations once the hull's unknowns are known."""
    name = Namer(a.name, swing, d)
    k = a.name
    q, whole, p_chi, phi_loss, theta_loss = (
        sp.Symbol(f"{text}{k}", real=True) for text in ("q_", "th_", "p_chi", "loss_phi", "loss_theta")
    )
    at, an, gt, gn = at_centre(swing, unknown)
    gt = name("G_t", gt, "G along e_t", "1/s^2")
    arm_rate = phi_acceleration(a, arm, unknown, at, gt, phi_loss - a.inertia * swing.nu_chi, name)
    turned = gt - swing.w * swing.wt - swing.nu_chi
    phi = name("phi_acc", arm_rate + turned, "acceleration of phi", "rad/s^2", rf"\ddot\varphi_{k}")
    gn = name("G_n", gn, "G along e_n", "1/s^2")
    inward = swing.c * (gn - swing.w * swing.wn) + p_chi + swing.phi_rate * swing.chi
    across = a.mass * q * (an + arm.lever * gn - a.length * inward)
    turn = whole * (across + a.inertia * swing.phi_rate * swing.wt + theta_loss)
    return phi, name("theta_acc", unknown[3] - turn, "acceleration of theta", "rad/s^2", rf"\ddot\theta_{k}")
