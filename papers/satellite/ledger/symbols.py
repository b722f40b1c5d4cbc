# SPDX-License-Identifier: Apache-2.0
"""The symbols of the satellite's equations of motion, (1)-(11), and what the derivation says they mean."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr

from mehvar import System
from mehvar.ledger import Case, Equation, Names, insert_definitions
from mehvar.mechanics import angle_rates, angular_velocity, frame_turn, matrix_rate, time_derivative
from mehvar.models.satellite.dynamics import (
    ANGLES,
    RATES,
    angles,
    euler_rotation,
    gravity_gradient,
    inertia_matrix,
    rates,
)
from mehvar.models.satellite.orbit import LATITUDE, circular_turning
from mehvar.models.satellite.wheels import MOMENTA

AXES = "xyz"
WITHOUT_WHEELS: Case = dict.fromkeys((q.symbol for q in MOMENTA), sp.S.Zero)
"""The paper's equations have no stored momentum."""
_ANGLES = (("phi", r"\varphi"), ("theta", r"\theta"), ("psi", r"\psi"))


class Motion:
    """Symbols of (1)-(11): angles, rates, the torque, and the torques of small motions about the orbit axes.

    The paper has one inertia, I. What the wheels add to the gravity gradient, where the model has I + I_omega, is left
    out here.
    """

    def __init__(self, system: System, names: Names) -> None:
        spin = (system.parameters.Iw_x, system.parameters.Iw_y, system.parameters.Iw_z)
        one_inertia: Case = dict.fromkeys(spin, sp.S.Zero)
        self._definitions = system.definitions
        self._shown = {step.left: step.expr.subs(one_inertia) for step in system.steps if isinstance(step, Equation)}
        self.plant = system.parameters
        p = {q.name: q for q in system.parameters}
        self.phi, self.theta, self.psi = (
            names.free(q, -1, 1, text=name) for q, (name, _) in zip(ANGLES, _ANGLES, strict=True)
        )
        self.omega_0 = names.free(p["omega0"], "1/10", 2, text="omega_0")
        self.moments = tuple(names.free(p[f"I_{i}"], 1, 4) for i in AXES)
        w = [names.free(q, -2, 2, text=f"omega_{i}") for q, i in zip(RATES, AXES, strict=True)]
        self._balance(system, names, w)
        self._turning(system, names)
        self._small(names)
        self._state_space(names)

    def step(self, name: str, cut: Case | None = None) -> Expr:
        """Follow a step of the derivation down to the names of the paper."""
        symbol = next(symbol for symbol in self._definitions if symbol.name == name)
        return insert_definitions(symbol, self._definitions, cut)

    def _balance(self, system: System, names: Names, w: Sequence[sp.Symbol]) -> None:
        """Take (1) and (2) from the derived accelerations and the function that gives the momentum."""
        torque = [names.free(f"T_{i}", -2, 2) for i in AXES]
        named = {symbol.name: symbol for symbol in self._definitions}
        cut: dict[Expr, Expr] = dict(WITHOUT_WHEELS)
        for i, applied in zip(AXES, torque, strict=True):
            cut |= {named[f"Tgg_{i}"]: applied, named[f"Tenv_{i}"]: sp.S.Zero, named[f"Tw_{i}"]: sp.S.Zero}
        accelerations = sp.Matrix([self.step(f"w{i}_rate", cut) for i in AXES])
        (momentum,) = (f for f in system.functions if f.name == "momentum")
        in_orbit = sp.Matrix([insert_definitions(expr, self._definitions) for _, expr in momentum.results])
        in_body = euler_rotation() * in_orbit.subs({LATITUDE.symbol: 0, **WITHOUT_WHEELS})
        self.I = names.matrix("I", "I", inertia_matrix(self.plant))
        self.T = names.matrix("T", "T", sp.Matrix(torque))
        self.omega = names.matrix("omega", r"\omega", sp.Matrix(w))
        self.omega_dot = names.matrix("omega_dot", r"\dot\omega", accelerations)
        self.H = names.matrix("H", "H", in_body)
        self.T_dot, self.T_ddot, self.omega_ddot = (
            _any_vector(names, name, latex)
            for name, latex in (("T_dot", r"\dot T"), ("T_ddot", r"\ddot T"), ("omega_ddot", r"\ddot\omega"))
        )

    def _turning(self, system: System, names: Names) -> None:
        """Take the kinematics, the rate of the orbit axes, and Omega from C' = -[Omega x] C."""
        rotation = euler_rotation()
        self.p, self.q, self.r = pqr = tuple(names.free(i, -2, 2) for i in "pqr")
        named = {symbol.name: symbol for symbol in self._definitions}
        cut = {named[f"rate_{i}"]: name for i, name in zip(AXES, pqr, strict=True)}
        self.rate = tuple(
            names.derived(f"{name}_dot", rf"\dot{latex}", insert_definitions(expr, self._definitions, cut))
            for (name, latex), expr in zip(_ANGLES, system.rhs[:3], strict=True)
        )
        motion = dict(zip(angles, self.rate, strict=True))
        self.C = names.matrix("C", "C", rotation)
        carried = rotation * circular_turning(self.omega_0)
        carried_rate = matrix_rate(carried, motion)
        self.omega_RI = names.matrix("omega_RIB", r"\omega_{RIB}", carried)
        self.omega_RI_dot = names.matrix("omega_RIB_dot", r"\dot\omega_{RIB}", carried_rate)
        self.Omega = names.matrix("Omega", r"\Omega", angular_velocity(rotation, motion))
        acceleration = sp.Matrix(names.meaning(self.omega_dot))
        self.Omega_dot = names.matrix("Omega_dot", r"\dot\Omega", acceleration - carried_rate)
        orbital = dict(zip(system.states.symbols, system.rhs, strict=True))
        self.omega_0_dot = names.derived(
            "omega_0_dot", r"\dot\omega_0", time_derivative(orbital[LATITUDE.symbol], orbital)
        )
        half_round = rotation * frame_turn(2, sp.pi) * circular_turning(self.omega_0)
        self.backwards: Case = {self.omega_RI: half_round}
        self.relative: Case = {name: self.step(f"rate_{i}") for name, i in zip(pqr, AXES, strict=True)}
        own = dict(zip(pqr, rates, strict=True))
        true_rates = zip(self.rate, system.rhs[:3], strict=True)
        self.inertial: Case = own | {name: insert_definitions(expr, self._definitions) for name, expr in true_rates}
        other = frame_turn(2, self.psi) * frame_turn(1, self.theta) * frame_turn(0, self.phi)
        self.other_order: Case = dict(zip(self.rate, angle_rates(other, angles, pqr), strict=True))

    def _small(self, names: Names) -> None:
        """Take the torques of small motions from the linear model; angles' rates are names of their own here."""
        self.small_rate, self.acceleration = (
            tuple(
                names.free(f"{name}_{short}1" if short == "dot" else f"{name}_{short}", -2, 2,
                           latex=rf"\{short}{latex}", text=f"{name}_{short}")
                for name, latex in _ANGLES
            )
            for short in ("dot", "ddot")
        )  # fmt: skip
        ours = sp.symbols(r"\dot\varphi \dot\theta \dot\psi \ddot\varphi \ddot\theta \ddot\psi", real=True)
        cut = dict(zip(ours, (*self.small_rate, *self.acceleration), strict=True))
        self._torques = torques = [self._shown[f"T_{i}"].subs(cut) for i in AXES]
        dropped = [self._shown.get(rf"T_{{{i},\mathrm{{dropped}}}}", sp.S.Zero).subs(cut) for i in AXES]
        pull = gravity_gradient(euler_rotation(), inertia_matrix(self.plant), self.omega_0**2)
        flat = dict.fromkeys(angles, 0)
        pull = pull.applyfunc(lambda expr: sp.Add(*(expr.diff(angle).subs(flat) * angle for angle in angles)))
        self.torque = tuple(
            names.derived(f"T_{i}1", f"T_{i}", own + other, text=f"T_{i}")
            for i, own, other in zip(AXES, torques, dropped, strict=True)
        )
        self.pull = tuple(
            names.derived(f"Tgg_{i}", f"T_{{gg,{i}}}", expr, text=f"Tgg_{i}")
            for i, expr in zip(AXES, pull, strict=True)
        )
        self.total = tuple(
            names.derived(f"T_{i}2", f"T_{i}", torque + pull, text=f"T_{i}")
            for i, torque, pull in zip(AXES, self.torque, self.pull, strict=True)
        )
        self.alone = tuple({rate: sp.S.Zero for rate in self.small_rate if rate is not own} for own in self.small_rate)

    def _state_space(self, names: Names) -> None:
        """Take the entries of A and B of (11) as the derivation shows them, and C by the angles that a law sees."""
        A, B = sp.zeros(6), sp.zeros(6, 3)
        A[:3, 3:] = sp.eye(3)
        for k in range(3):
            A[k + 3, k] = self._shown[f"A_{{{k + 4}{k + 1}}}"]
            B[k + 3, k] = self._shown[f"B_{{{k + 4}{k + 1}}}"]
        self.A_c = names.matrix("A_c", "A", A, text="A")
        self.B_c = names.matrix("B_c", "B", B, text="B")
        self.x = names.matrix("x_t", "x(t)", sp.Matrix([*angles, *self.small_rate]), text="x")
        self.x_dot = names.matrix("x_dot", r"\dot x(t)", sp.Matrix([*self.small_rate, *self.acceleration]))
        self.u_c = names.matrix("u_t", "u(t)", sp.Matrix(self._torques), text="u")
        seen = sp.Matrix(angles)
        self.C_c = names.matrix("C_c", "C", seen.jacobian([*angles, *self.small_rate]), text="C")
        self.y_c = names.matrix("y_t", "y", seen, text="y")


def _any_vector(names: Names, name: str, latex: str) -> sp.MatrixSymbol:
    """Add a vector that nothing is known of, such as the derivative of a torque."""
    parts = [names.free(f"{name}_{i}", -2, 2, latex=f"{latex}_{i}") for i in AXES]
    return names.matrix(name, latex, sp.Matrix(parts))
