# SPDX-License-Identifier: Apache-2.0
"""Bobs as parts: the paper's rotors geared to the angles, rigid bobs on hinges, and bobs on ball joints."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import sympy as sp

from ..parts import Aggregates, Bob, Contribution, Coordinate, Load, Mounted, Part, Particle, point_inertia
from ..parts.frame import AXES, ZERO
from ..parts.motion import Motion, transport
from ..parts.terms import Point
from ..system import Expr, Quantity
from .states import (
    Pendulum,
    angle_quantities,
    angle_rate_quantities,
    arm_rate_quantities,
    direction_quantities,
    rate,
)


@dataclass(frozen=True)
class AngledBob(Part):
    """A bob by its angles: phi from -x, and theta from z towards y (7).

    Parameters
    ----------
    name : str
        Start of the names of its steps.
    pendulum : Pendulum
        Its parameters.
    """

    pendulum: Pendulum

    def coordinates(self) -> tuple[Coordinate, ...]:
        k = int(self.pendulum.name)
        return tuple(map(Coordinate, angle_rate_quantities(k), angle_quantities(k)))

    def _speeds(self) -> tuple[Expr, Expr]:
        phi, theta = (c.speed.symbol for c in self.coordinates())
        return phi, theta

    def _circles(self, at: Mounted) -> list[tuple[Expr, Expr]]:
        return [at.frame.circle(c.place.symbol) for c in self.coordinates() if c.place is not None]

    def _direction(self, at: Mounted) -> sp.Matrix:
        """Return the direction e from pivot to bob."""
        (c, s), (C, S) = self._circles(at)
        return sp.Matrix([-c, s * S, s * C])

    @abstractmethod
    def _turning(self, at: Mounted) -> tuple[Expr, Expr, Expr]:
        """Return the rate of the bob's inertia relative to the hull."""

    def particle(self, at: Mounted) -> Particle:
        a, ((_, s), _), (phi, theta) = self.pendulum, self._circles(at), self._speeds()
        place = sp.Matrix([a.pivot, 0, 0]) + a.length * self._direction(at)
        return Particle(a.mass, place, a.length**2 * (phi**2 + s**2 * theta**2))

    def _losses(self, at: Mounted) -> tuple[Expr, Expr]:
        """Return the moments of the dampers."""
        phi, theta = (self.pendulum.damping * speed for speed in self._speeds())
        return (
            at.define("loss_phi", phi, "damping moment of phi", "N m"),
            at.define("loss_theta", theta, "damping moment of theta", "N m"),
        )

    def aggregates(self, at: Mounted) -> Aggregates:
        a, (phi, theta), losses = self.pendulum, self._speeds(), self._losses(at)
        return Aggregates(
            inertia=a.inertia * sp.eye(3), angular=a.inertia * sp.Matrix(self._turning(at)),
            energy=a.inertia * (phi**2 + theta**2) / 2, forces=tuple(-loss for loss in losses),
        )  # fmt: skip


@dataclass(frozen=True)
class GearedBob(AngledBob):
    """A bob with the paper's inertia (5): rotors geared to phi about x and to theta about z."""

    def _turning(self, at: Mounted) -> tuple[Expr, Expr, Expr]:
        phi, theta = self._speeds()
        return phi, sp.S.Zero, theta


@dataclass(frozen=True)
class _Swing:
    """Motion of a bob on hinges.

    Attributes
    ----------
    e, e_phi, n, t : sympy.Matrix
        Direction of the arm, directions in which phi and theta move it, and azimuth.
    w_t : Expr
        Rate of the hull along the azimuth.
    p, nu, chi : Expr
        Absolute rates of the arm along e_phi and n, and its spin.
    p_chi, sway : Expr
        p chi, and the terms of t . W' without accelerations in the constraint of the spin.
    phi_loss, theta_loss : Expr
        Moments of the dampers.
    """

    e: sp.Matrix
    e_phi: sp.Matrix
    n: sp.Matrix
    t: sp.Matrix
    w_t: Expr
    p: Expr
    nu: Expr
    chi: Expr
    p_chi: Expr
    sway: Expr
    phi_loss: Expr
    theta_loss: Expr


@dataclass(frozen=True)
class HingedBob(AngledBob):
    """A rigid bob on two hinges: a bob on a ball joint whose spin the hinges couple to theta.

    With D = m l^2 + I, k = m l/D and D_theta = m l^2 sin^2 phi + I the hinges exert, beside their dampers, a torque T
    along the azimuth t. From the bob's angular momentum about the pivot P, and s chi' - c nu' = t . W' + sway, follow

        T = D/D_theta (I (t . W' - k c n . a_P + sway - k l c p chi) + k l s c eps theta'),
        D_theta (s nu' + c chi') = -eps theta' - m l s (n . a_P + l p chi - l c (t . W' + sway)).

    The equations of `AngledBob` are the same and take a third more operations.
    """

    def _turning(self, at: Mounted) -> tuple[Expr, Expr, Expr]:
        (_, (C, S)), (phi, theta) = self._circles(at), self._speeds()
        return -theta, C * phi, -S * phi

    def _swing(self, at: Mounted) -> _Swing:
        """Return directions and rates of the arm, each named, since the balances use them several times."""
        ((c, s), (C, S)), (phi, theta), (w1, w2, w3) = self._circles(at), self._speeds(), rate
        w_n = at.define("Wn", w2 * C - w3 * S, "rate of the hull along n", "rad/s")
        w_t = at.define("Wt", w2 * S + w3 * C, "rate of the hull along the azimuth", "rad/s")
        w = at.define("w", w1 - theta, "roll rate of the plane of the arm", "rad/s")
        p = at.define("p", phi + w_n, "rate of the arm in its plane", "rad/s")
        chi = at.define("chi", s * w_t - c * w, "spin of the arm", "rad/s")
        return _Swing(
            at.vector("e_", self._direction(at), "direction of the arm", "1"),
            at.vector("f_", sp.Matrix([s, c * S, c * C]), "direction in which phi moves it", "1"),
            sp.Matrix([0, C, -S]), sp.Matrix([0, S, C]), w_t,
            p, at.define("nu", -(c * w_t + s * w), "rate of the arm across its plane", "rad/s"), chi,
            at.define("p_chi", p * chi, "product of rates", "rad^2/s^2"),
            at.define("sway", phi * w + theta * w_n, "rate of n along t, times rates", "rad^2/s^2"),
            *self._losses(at),
        )  # fmt: skip

    def _constants(self, at: Mounted) -> tuple[Expr, Expr, Expr, Expr]:
        """Return D, k, k l, and 1/D_theta, which depends on phi."""
        a, (_, s) = self.pendulum, self._circles(at)[0]
        total = at.define("D", a.mass * a.length**2 + a.inertia, "inertia about the pivot", "kg m^2")
        k = at.define("k", a.mass * a.length / total, "mass times length over inertia", "1/m")
        whole = at.define("th", 1 / (a.mass * a.length**2 * s**2 + a.inertia), "1/D_theta", "1/(kg m^2)")
        return total, k, at.define("kl", k * a.length, "k times the length", "1"), whole

    def contribution(self, at: Mounted) -> Contribution:
        a, ((c, s), _), swing = self.pendulum, self._circles(at), self._swing(at)
        (total, k, share, whole), pivot = self._constants(at), sp.Matrix([a.pivot, 0, 0])
        over, part = at.define("over", total * whole, "D over D_theta", "1"), at.define("ckl", c * share, "k l c", "1")
        twist = over * (a.inertia * (swing.sway - part * swing.p_chi) + part * s * swing.theta_loss)
        weight = at.define("weight", over * a.inertia, "moment of T per angular acceleration", "kg m^2")
        along = at.vector("h_", -at.define("kc", k * c, "k c", "1/m") * swing.n, "force over T", "1/m")
        pressed = at.vector("g_", weight * along, "force per angular acceleration", "kg m")
        moving = at.vector("m_", at.define("mv", a.mass * share, "swinging mass", "kg") * swing.e, "its pull", "kg")
        still = at.vector("c_", transport(at.frame, ZERO, "still_turn_", pivot), "centripetal acceleration", "m/s^2")
        held = at.define("held", twist + pressed.dot(still), "T on a hub without acceleration", "N m")
        pull = a.mass * a.length * (swing.p**2 + swing.nu**2) - moving.dot(still)
        spin = at.define("kI", k * a.inertia, "k times the inertia", "kg m")
        force = (
            (k * swing.phi_loss + spin * swing.chi * swing.nu) * swing.e_phi
            + (k * s * swing.theta_loss - spin * swing.p_chi) * swing.n
            + at.define("pull", pull, "pull along the arm", "N") * swing.e - held * along
        )  # fmt: skip
        couple = swing.phi_loss * swing.n - swing.theta_loss * sp.Matrix([1, 0, 0]) - held * swing.t
        mass, mixed = moving * swing.e.T + pressed * along.T, swing.t * pressed.T
        turned = at.vector("t_", weight * swing.t, "moment per angular acceleration", "kg m^2") * swing.t.T
        fixed = at.define("mf", a.mass * a.inertia / total, "mass that stays with the pivot", "kg")
        return Contribution(
            fixed, fixed * pivot, point_inertia(fixed, pivot), loads=(Load(couple=couple),),
            matrix=sp.Matrix(sp.BlockMatrix([[mass, mixed.T], [mixed, turned]])), point=Point(pivot, sp.S.Zero, force),
        )  # fmt: skip

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        a, ((c, s), _), (phi, theta) = self.pendulum, self._circles(at), self._speeds()
        (total, k, share, whole), swing, turning = self._constants(at), self._swing(at), motion.angular
        pivot = motion.at(sp.Matrix([a.pivot, 0, 0]), f"{self.name}_aP", f"pivot of {self.name}")
        in_plane = theta * swing.w_t - swing.n.dot(turning) + share * swing.nu * swing.chi
        across = swing.n.dot(pivot) + a.length * (swing.p_chi - c * (swing.t.dot(turning) + swing.sway))
        turned = whole * (swing.theta_loss + a.mass * a.length * s * across)
        return (
            phi, theta, in_plane - swing.phi_loss / total - k * swing.e_phi.dot(pivot),
            turning[0] - phi * swing.w_t - turned,
        )  # fmt: skip


@dataclass(frozen=True)
class BallBob(Bob):
    """A bob on a ball joint, whose states have the names of a pendulum's direction s and its inertial rate sigma.

    Parameters
    ----------
    number : int
        Number of the pendulum; the other fields are those of a `Bob`.
    """

    number: int = 0

    def _vectors(self) -> tuple[tuple[Quantity, ...], ...]:
        return direction_quantities(self.number), arm_rate_quantities(self.number)


def ball_bob(pendulum: Pendulum) -> BallBob:
    """Return the part that represents a pendulum on a ball joint."""
    a = pendulum
    return BallBob(f"bob{a.name}", a.mass, a.length, (a.pivot, 0, 0), a.damping, a.inertia, number=int(a.name))


def slip_symbols(pendulum: Pendulum) -> tuple[sp.Symbol, ...]:
    """Return the symbols of s' that the part of a pendulum on a ball joint defines."""
    return tuple(sp.Symbol(f"{ball_bob(pendulum).name}_de{axis}", real=True) for axis in AXES)


def bob(pendulum: Pendulum, inertia: str) -> Part:
    """Return the part that represents a pendulum.

    Parameters
    ----------
    pendulum : Pendulum
        Its parameters.
    inertia : {"paper", "hinge", "ball"}
        Convention of its inertia.
    """
    if inertia == "ball":
        return ball_bob(pendulum)
    kind = GearedBob if inertia == "paper" else HingedBob
    return kind(f"bob{pendulum.name}", pendulum)
