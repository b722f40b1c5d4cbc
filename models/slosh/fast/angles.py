# SPDX-License-Identifier: Apache-2.0
"""Efficient form of (9)-(16) for pendulums described by angles, with O(N) operations and without a large matrix.

Equations (15), (16) are solved for the angular accelerations in each pendulum's frame and inserted into the hull's
balances (arrow elimination). One symmetric 6 x 6 system remains. The conventions of inertia differ in each pendulum's
contribution: rotors geared to the angles (the paper's), or a rigid bob on hinges.

The axes of a pendulum's frame are e_x, e_t = (0, S, C) through the bob and e_n = (0, C, -S). In it s = -c e_x + s e_t
is the direction of the arm, e_phi = s e_x + c e_t that of phi and e_n that of theta. Body rates are W_n, W_t, and
w = W1 - theta'; p = phi' + W_n and nu = -(c W_t + s w) turn the arm, chi = c w - s W_t spins it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...system import Derivation, Expr, Group
from ..states import Pendulum, angle_quantities, angle_rate_quantities, rate
from .hull import ROWS, SIZE, Arm, Dynamics, Lump, Pull, balance, lump, velocity_rates
from .linear import factorise, solve


def angle_dynamics(p: Group, pendulums: Sequence[Pendulum], inertia: str, d: Derivation) -> Dynamics:
    """Define the accelerations for pendulums described by angles.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Parameters of each.
    inertia : {"paper", "hinge"}
        Convention of their inertia term.
    d : Derivation
        Receives the steps.
    """
    kind = Geared if inertia == "paper" else Hinged
    hull, arms = lump(p, pendulums, kind is Geared, d)
    bobs = [kind(a, arm, swing_of(k, d), hull, d) for k, (a, arm) in enumerate(zip(pendulums, arms, strict=True), 1)]
    whole = balance(hull, [bob.pull() for bob in bobs], d)
    factors = factorise(whole.matrix, "K", d)
    right = [applied - bias for applied, bias in zip(hull.applied, whole.bias, strict=True)]
    right = list(vector("b*", right, "right side", "", "b_*", d, labels=ROWS))
    unknown = solve(factors, right, "X", d)
    angles = [angle for bob in bobs for angle in bob.angles(unknown)]
    rates = velocity_rates(unknown, hull)
    return Dynamics(hull.centre, (hull.xy, hull.xz), False, whole, factors.leading(3), *rates, tuple(angles))


@dataclass(frozen=True)
class Swing:
    """Named quantities of one pendulum.

    Attributes
    ----------
    s, c, S, C : Expr
        Sines and cosines of phi and theta.
    phi_rate, theta_rate : Expr
        rad/s.
    wn, wt, w, p, chi : Expr
        Rates in the pendulum's frame and rates of the arm, rad/s.
    nu_chi, squared : Expr
        nu chi and p^2 + nu^2, rad^2/s^2.
    """

    s: Expr
    c: Expr
    S: Expr
    C: Expr
    phi_rate: Expr
    theta_rate: Expr
    wn: Expr
    wt: Expr
    w: Expr
    p: Expr
    chi: Expr
    nu_chi: Expr
    squared: Expr


def swing_of(k: int, d: Derivation) -> Swing:
    """Name the sines, cosines and rates of pendulum k."""
    phi, theta = (q.symbol for q in angle_quantities(k))
    phi_rate, theta_rate = (q.symbol for q in angle_rate_quantities(k))

    def name(text: str, value: Expr, title: str, unit: str, latex: str) -> sp.Symbol:
        return d.define(f"{text}{k}", value, title=f"{title} {k}", unit=unit, latex=latex)

    s = name("sin_phi", sp.sin(phi), "sine of phi", "1", rf"s_{k}")
    c = name("cos_phi", sp.cos(phi), "cosine of phi", "1", rf"c_{k}")
    S = name("sin_theta", sp.sin(theta), "sine of theta", "1", rf"S_{k}")
    C = name("cos_theta", sp.cos(theta), "cosine of theta", "1", rf"C_{k}")
    w1, w2, w3 = rate
    wn = name("Wn", w2 * C - w3 * S, "body rate across the plane of arm", "rad/s", rf"W_{{n{k}}}")
    wt = name("Wt", w2 * S + w3 * C, "body rate along the azimuth of arm", "rad/s", rf"W_{{t{k}}}")
    w = name("w_x", w1 - theta_rate, "roll rate of the plane of arm", "rad/s", rf"w_{k}")
    p = name("p", phi_rate + wn, "inertial rate of arm in its plane,", "rad/s", rf"p_{k}")
    nu = name("nu", -(c * wt + s * w), "inertial rate across its plane of arm", "rad/s", rf"\nu_{k}")
    chi = name("chi", c * w - s * wt, "spin of arm", "rad/s", rf"\chi_{k}")
    return Swing(
        s,
        c,
        S,
        C,
        phi_rate,
        theta_rate,
        wn,
        wt,
        w,
        p,
        chi,
        name("nu_chi", nu * chi, "product of rates of arm", "rad^2/s^2", rf"\nu_{k}\chi_{k}"),
        name("sigma_sq", p**2 + nu**2, "squared rate of arm", "rad^2/s^2", rf"|\sigma_{k}|^2"),
    )


class Bob(ABC):
    """A pendulum on the hull, which names its expressions.

    Parameters
    ----------
    a, arm, swing : Pendulum, Arm, Swing
        Its parameters, constants and named quantities.
    hull : Lump
        What it hangs on.
    d : Derivation
        Receives the steps.
    """

    def __init__(self, a: Pendulum, arm: Arm, swing: Swing, hull: Lump, d: Derivation) -> None:
        self.a, self.arm, self.swing, self.hull, self._d = a, arm, swing, hull, d

    def __call__(self, text: str, value: Expr, title: str = "product", unit: str = "", latex: str = "") -> Expr:
        """Define an expression whose name ends with the number of the pendulum."""
        k = self.a.name
        return self._d.define(f"{text}{k}", value, title=f"{title}, pendulum {k}", unit=unit, latex=latex)

    def defined(self, *texts: str) -> tuple[sp.Symbol, ...]:
        """Return the symbols of expressions that have been defined."""
        return tuple(sp.Symbol(f"{text}{self.a.name}", real=True) for text in texts)

    @abstractmethod
    def pull(self) -> Pull:
        """Return the pendulum's terms in the hull's equations."""

    @abstractmethod
    def angles(self, unknown: Sequence[Expr]) -> tuple[Expr, Expr]:
        """Return the angular accelerations from the hull's unknowns."""

    def in_body(self, radial: Sequence[Expr], along: Sequence[Expr], across: Sequence[Expr]) -> sp.Matrix:
        """Rotate a matrix from the pendulum's frame to body axes.

        Parameters
        ----------
        radial : sequence of Expr
            Entries x-x, x-t and x-G_t.
        along, across : sequence of Expr
            Entries t-t, t-G_t, G_t-G_t and n-n, n-G_n, G_n-G_n.
        """
        S, C = self.swing.S, self.swing.C
        S_squared, SC = self("S_sq", S**2), self("SC", S * C)
        matrix = sp.zeros(SIZE, SIZE)
        matrix[0, 0] = radial[0]
        for row, entry in ((1, radial[1]), (4, radial[2])):
            matrix[row, 0], matrix[row + 1, 0] = entry * S, entry * C
        for (row, column), t, n in zip(((1, 1), (4, 1), (4, 4)), along, across, strict=True):
            difference = self(f"tn{row}{column}_", t - n)
            mixed = difference * SC
            matrix[row, column] = n + difference * S_squared
            matrix[row + 1, column + 1] = t - difference * S_squared
            matrix[row + 1, column] = mixed
            if row > column:
                matrix[row, column + 1] = mixed
        return matrix

    def bias_in_body(self, force: Sequence[Expr], turning: Sequence[Expr], roll: Expr) -> list[Expr]:
        """Rotate force (x, t, n) and the terms of (G_t, G_n) to body axes, in the order of the unknowns."""
        S, C = self.swing.S, self.swing.C
        (ft, fn), (gt, gn) = force[1:], turning
        return [force[0], S * ft + C * fn, C * ft - S * fn, roll, S * gt + C * gn, C * gt - S * gn]

    def along_arm(self) -> tuple[Expr, Expr, list[Expr], list[Expr]]:
        """Return the terms of the arm's tension: reaction without unknowns, e G_x, and entries x-. and t-.."""
        name, a, arm, swing, hull = self, self.a, self.arm, self.swing, self.hull
        lead = name("eG1_", arm.lever * hull.g1, "centripetal acceleration of the pivot", "m/s^2")
        pull = name(
            "tension",
            -(arm.moving * swing.c * lead + a.mass * a.length * swing.squared),
            "force along the arm",
            "N",
        )
        As = name("As_", arm.moving * swing.s)
        Ass, Asc = name("Ass_", As * swing.s), name("Asc_", As * swing.c)
        eAss = name("eAss_", arm.lever * Ass)
        return lead, pull, [arm.moving - Ass, -Asc, -arm.lever * Asc], [Ass, eAss, arm.lever * eAss]

    def at_centre(self, unknown: Sequence[Expr]) -> tuple[Expr, Expr, Expr, Expr]:
        """Return a_t, a_n of C, and G_t, G_n."""
        (_, a2, a3, _, g2, g3), S, C = unknown, self.swing.S, self.swing.C
        return S * a2 + C * a3, C * a2 - S * a3, S * g2 + C * g3, C * g2 - S * g3

    def phi_acceleration(self, unknown: Sequence[Expr], along: Expr, turning: Expr, moment: Expr) -> Expr:
        """Solve the equation of phi for p' + nu chi, given its moment without the pivot's acceleration."""
        arm, swing, (lead,) = self.arm, self.swing, self.defined("eG1_")
        pivot = swing.s * (unknown[0] + lead) + swing.c * (along + arm.lever * turning)
        return -(arm.ratio * pivot + moment / arm.total)


class Geared(Bob):
    """A pendulum with the paper's inertia: rotors geared to phi (about x) and theta (about z)."""

    def pull(self) -> Pull:
        """Return the terms in the hull's equations."""
        name, a, arm, swing = self, self.a, self.arm, self.swing
        lead, pull, radial, along = self.along_arm()
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
        matrix = self.in_body(radial, along, across)
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
        return Pull(matrix, self._bias(lead, pull, coupling, q, reach, turn, share))

    def _bias(
        self, lead: Expr, pull: Expr, coupling: Expr, q: Expr, reach: Expr, turn: Expr, share: Expr
    ) -> tuple[Expr, ...]:
        name, a, arm, swing, hull = self, self.a, self.arm, self.swing, self.hull
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
        bias = self.bias_in_body(
            (radial, along, across),
            (arm.lever * along - lever_force, turn * across),
            -(lever_force + phi_loss + roll),
        )
        spin_x = name("I_phi", a.inertia * swing.phi_rate, "angular momentum of the rotor of phi", "kg m^2/s")
        spin_z = name("I_theta", a.inertia * swing.theta_rate, "angular momentum of the rotor of theta", "kg m^2/s")
        bias[3] += w2 * spin_z
        bias[4] -= w2 * spin_x + roll + theta_loss
        bias[5] -= w3 * spin_x - w1 * spin_z
        return tuple(bias)

    def angles(self, unknown: Sequence[Expr]) -> tuple[Expr, Expr]:
        """Return the angular accelerations."""
        name, a, hull = self, self.a, self.hull
        named = ("q_", "g_", "th_", "eta", "zeta", "loss_phi", "loss_theta")
        q, turn, share, eta, zeta, phi_loss, theta_loss = self.defined(*named)
        at, an, gt, gn = self.at_centre(unknown)
        gt = name("G_t", gt, "G along e_t", "1/s^2")
        turned = name("Gt_eta", gt + eta, "p' + nu chi of the rigid spacecraft, less phi''", "rad/s^2")
        arm_rate = self.phi_acceleration(unknown, at, gt, a.inertia * (unknown[3] + turned) + phi_loss)
        phi = name("phi_acc", arm_rate + turned, "acceleration of phi", "rad/s^2", rf"\ddot\varphi_{a.name}")
        across = an + turn * gn - q * (unknown[3] + unknown[4]) + zeta
        theta = hull.xy - unknown[4] - share * (q * across + theta_loss / a.mass)
        return phi, name("theta_acc", theta, "acceleration of theta", "rad/s^2", rf"\ddot\theta_{a.name}")


class Hinged(Bob):
    """A pendulum with a rigid bob on hinges: theta about -x, then phi."""

    def pull(self) -> Pull:
        """Return the terms in the hull's equations."""
        name, a, arm, swing = self, self.a, self.arm, self.swing
        _, pull, radial, along = self.along_arm()
        s, c, wn, w = swing.s, swing.c, swing.wn, swing.w
        q = name("q_", a.length * s, "distance of the bob from the pivot's axis", "m")
        whole = name("th_", 1 / (a.mass * q**2 + a.inertia), "reciprocal of the inertia of theta", "1/(kg m^2)")
        weight = name("wb_", arm.total * a.inertia * whole, "inertia that turns with W_t", "kg m^2")
        kc = name("kc_", arm.ratio * c)
        side = name("side", 1 - arm.lever * kc)
        pressed = name("wkc_", weight * kc)
        across = [pressed * kc, -pressed * side, weight * side**2]
        matrix = self.in_body(radial, along, across)
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
        bias = self.bias_in_body(
            (s * swung - c * pull, forward, side_force),
            (arm.lever * forward + phi_loss, arm.lever * side_force + twist),
            theta_loss,
        )
        return Pull(matrix, tuple(bias))

    def angles(self, unknown: Sequence[Expr]) -> tuple[Expr, Expr]:
        """Return the angular accelerations."""
        name, a, arm, swing = self, self.a, self.arm, self.swing
        q, whole, p_chi, phi_loss, theta_loss = self.defined("q_", "th_", "p_chi", "loss_phi", "loss_theta")
        at, an, gt, gn = self.at_centre(unknown)
        gt = name("G_t", gt, "G along e_t", "1/s^2")
        arm_rate = self.phi_acceleration(unknown, at, gt, phi_loss - a.inertia * swing.nu_chi)
        turned = gt - swing.w * swing.wt - swing.nu_chi
        phi = name("phi_acc", arm_rate + turned, "acceleration of phi", "rad/s^2", rf"\ddot\varphi_{a.name}")
        gn = name("G_n", gn, "G along e_n", "1/s^2")
        inward = swing.c * (gn - swing.w * swing.wn) + p_chi + swing.phi_rate * swing.chi
        across = a.mass * q * (an + arm.lever * gn - a.length * inward)
        turn = whole * (across + a.inertia * swing.phi_rate * swing.wt + theta_loss)
        return phi, name("theta_acc", unknown[3] - turn, "acceleration of theta", "rad/s^2", rf"\ddot\theta_{a.name}")
