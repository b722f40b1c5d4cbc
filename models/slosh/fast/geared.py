# SPDX-License-Identifier: Apache-2.0
"""The paper's pendulum: rotors geared to phi, about x, and to theta, about z, beside a point bob."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ...system import Derivation, Expr
from ..states import Pendulum, rate
from .hull import Arm, Lump, Pull
from .swing import Namer, Swing, along_arm, at_centre, bias_in_body, in_body, phi_acceleration


def geared_pull(a: Pendulum, arm: Arm, swing: Swing, hull: Lump, d: Derivation) -> Pull:
    """Return a pendulum's terms with the paper's inertia: rotors geared to phi (about x) and to theta (about z)."""
    name = Namer(a.name, swing, d)
    lead, pull, radial, along = along_arm(a, arm, hull, name)
    q = name("q_", a.length * swing.s, "distance of the bob from the pivot's axis", "m")
    reach = name("lc_", a.length * swing.c)
    coupling = name("B_", arm.lumped * a.length, "lumped mass times length", "kg m", f"B_{a.name}")
    Bs, Bc, Bl = name("Bs_", coupling * swing.s), name("Bc_", coupling * swing.c), name("Bl_", coupling * a.length)
    turn = name("g_", arm.lever - reach, "bob from C along x", "m")
    share = name("th_", a.mass / (a.mass * q**2 + a.inertia), "m over the inertia of theta", "1/m^2")
    weight = name("wth_", share * a.inertia)
    eBc = name("eBc_", arm.lever * Bc)
    radial = [radial[0], radial[1], radial[2] - Bs]
    along = [along[0], along[1] - Bc, along[2] - 2 * eBc + Bl]
    weighted = name("wg_", weight * turn)
    base = arm.lumped * arm.lever
    across = [weight - arm.lumped, weighted - base, weighted * turn - base * arm.lever]
    matrix = in_body(radial, along, across, name)
    S, C = swing.S, swing.C
    swept, leant = name("wq_", weight * q), name("wqg_", weighted * q)
    roll = name("wqq_", swept * q)
    y, z, gy, gz = (
        name(t, v) for t, v in (("wqC_", swept * C), ("wqS_", swept * S), ("wgC_", leant * C), ("wgS_", leant * S))
    )
    matrix[3, 0] = -Bs
    matrix[3, 1], matrix[3, 2], matrix[3, 3] = -(Bc * S + y), z - Bc * C, Bl + roll
    rest = Bl - eBc
    matrix[4, 3], matrix[5, 3] = rest * S - gy + roll, rest * C + gz
    matrix[4, 1] -= y
    matrix[4, 2] += z
    matrix[4, 4] += roll - 2 * gy
    matrix[5, 4] += gz
    return Pull(matrix, _geared_bias(a, arm, hull, name, lead, pull, coupling, q, reach, turn, share))


def _geared_bias(
    a: Pendulum,
    arm: Arm,
    hull: Lump,
    name: Namer,
    lead: Expr,
    pull: Expr,
    coupling: Expr,
    q: Expr,
    reach: Expr,
    turn: Expr,
    share: Expr,
) -> tuple[Expr, ...]:
    swing = name.swing
    w1, w2, w3 = rate
    phi_loss = name("loss_phi", a.damping * swing.phi_rate, "damping moment of phi", "N m")
    theta_loss = name("loss_theta", a.damping * swing.theta_rate, "damping moment of theta", "N m")
    eta = name("eta", -(swing.w * swing.wt + swing.nu_chi), "velocity terms of phi''", "rad/s^2")
    zeta = reach * swing.w * swing.wn - a.length * (swing.p + swing.phi_rate) * swing.chi
    zeta = name("zeta", zeta + q * hull.xy, "velocity terms of the bob across its plane", "m/s^2")
    swung = name("F_phi", -(coupling * eta + arm.ratio * phi_loss), "force along e_phi", "N")
    across = name("F_n", share * (a.inertia * zeta - q * theta_loss), "force along e_n", "N")
    lever_force = name("M_n", a.length * swung + coupling * swing.s * lead, "moment about e_n", "N m")
    radial = swing.s * swung - swing.c * pull
    along = name("F_t", swing.s * pull + swing.c * swung, "force along e_t", "N")
    roll = name("M_q", q * across, "moment of the force along e_n", "N m")
    bias = bias_in_body(
        (radial, along, across),
        (arm.lever * along - lever_force, turn * across),
        -(lever_force + phi_loss + roll),
        name,
    )
    spin_x = name("I_phi", a.inertia * swing.phi_rate, "angular momentum of the rotor of phi", "kg m^2/s")
    spin_z = name("I_theta", a.inertia * swing.theta_rate, "angular momentum of the rotor of theta", "kg m^2/s")
    bias[3] += w2 * spin_z
    bias[4] -= w2 * spin_x + roll + theta_loss
    bias[5] -= w3 * spin_x - w1 * spin_z
    return tuple(bias)


def geared_angles(
    a: Pendulum, arm: Arm, swing: Swing, hull: Lump, unknown: Sequence[Expr], d: Derivation
) -> tuple[Expr, Expr]:
    """Return the angle accelerations once the hull's unknowns are known."""
    name = Namer(a.name, swing, d)
    k = a.name
    q, turn, share, eta, zeta, phi_loss, theta_loss = (
        sp.Symbol(f"{text}{k}", real=True) for text in ("q_", "g_", "th_", "eta", "zeta", "loss_phi", "loss_theta")
    )
    at, an, gt, gn = at_centre(swing, unknown)
    gt = name("G_t", gt, "G along e_t", "1/s^2")
    turned = name("Gt_eta", gt + eta, "p' + nu chi of the rigid spacecraft, less phi''", "rad/s^2")
    arm_rate = phi_acceleration(a, arm, unknown, at, gt, a.inertia * (unknown[3] + turned) + phi_loss, name)
    phi = name("phi_acc", arm_rate + turned, "acceleration of phi", "rad/s^2", rf"\ddot\varphi_{k}")
    across = an + turn * gn - q * (unknown[3] + unknown[4]) + zeta
    theta = hull.xy - unknown[4] - share * (q * across + theta_loss / a.mass)
    return phi, name("theta_acc", theta, "acceleration of theta", "rad/s^2", rf"\ddot\theta_{k}")
