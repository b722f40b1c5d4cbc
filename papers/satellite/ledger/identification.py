# SPDX-License-Identifier: Apache-2.0
"""The recursive least squares of the satellite's paper, (34)-(42), as printed, and their symbols.

All axes share the derived estimator; the one of roll is compared.
"""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp
from sympy import Expr

from mehvar import System
from mehvar.ledger import Case, Names, Printed, Relation, insert_definitions, printed
from mehvar.models.satellite.dynamics import angles
from mehvar.models.satellite.estimator import memory, symbols
from mehvar.models.satellite.wheels import TORQUES

from .loop import controller

_THETA = ("a1", "a2", "b0", "b1", "d")


class Estimator:
    """Symbols of (34)-(42): the derived estimator of roll, its covariance F = U D U' before and after a sample."""

    def __init__(self, system: System, names: Names) -> None:
        self._definitions = system.definitions
        self._named = {symbol.name: symbol for symbol in self._definitions}
        z = symbols("roll")
        self._memory(names)
        law = controller(system, "mrac-literal")
        p = {q.name: q for q in law.parameters}
        self.forgetting = names.free(p["forgetting"], "9/10", "99/100", text="lambda")
        torque = names.free("torque_1", -2, 2, latex="u_i(k-1)", text="u(k-1)")
        self._cut: dict[Expr, Expr] = {
            angles[0]: self.y,
            self._named["y1_used_roll"]: z["y1"],
            self._named["v_roll"]: torque,
            self._named["learns_roll"]: sp.S.One,
        }
        self.past = (z["y1"], z["y2"], torque, z["v1"])
        y_hat = self._step("y_hat_roll")
        plain = {symbol: sp.S.Zero for n, symbol in z.items() if n[0] == "U"}
        regressors = sp.Matrix([self._step(f"f{i}_roll").subs(plain) for i in range(1, 6)])
        before = sp.Matrix([z[n] for n in _THETA])
        self.y_hat = names.derived("y_hat", r"\hat y(k)", y_hat, text="y_hat(k)")
        self.Phi = names.matrix("Phi_column", r"\Phi(k)", regressors, text="Phi(k)")
        self.Phi_row = names.matrix("Phi_i", r"\Phi_i(k)", regressors.T, text="Phi_i(k)")
        self.theta = [names.free(f"{n}_now", latex=rf"{x}(k)", text=f"{n}(k)") for n, x in self._entries()]
        after = sp.Matrix([self._step(f"{n}_now_roll") for n in _THETA])
        self.Theta = names.matrix("Theta", r"\hat\Theta(k)", after, text="Theta(k)")
        self.Theta_before = names.matrix("Theta_before", r"\hat\Theta(k-1)", before, text="Theta(k-1)")
        self.kept: Case = {name: self._step(f"{n}_now_roll") for name, n in zip(self.theta, _THETA, strict=True)}
        self.epsilon = names.derived("epsilon", r"\varepsilon(k)", self._step("eps_roll"), text="epsilon(k)")
        gain = sp.Matrix([self._step(f"G{i}_roll") for i in range(1, 6)])
        self.G = names.matrix("G", "G(k)", gain, text="G(k)")
        self.F_before = names.matrix("F_before", "F(k-1)", self._covariance(z), text="F(k-1)")
        freed = {n: self._step(f"{n}_free_roll") for n in z if n[0] in "DU" and n[1:].isdecimal()}
        self.F = names.matrix("F", "F(k)", self._covariance(freed), text="F(k)")
        spread = (regressors.T * sp.Matrix(names.meaning(self.F_before)) * regressors)[0]
        shown = r"\Phi^T(k) F(k-1) \Phi(k)"
        self.spread = names.derived("spread", shown, spread, text="Phi^T(k) F(k-1) Phi(k)")
        self.unit = names.matrix("unit_5", "I", sp.eye(5), text="I")
        self._vectors(system, names)

    @staticmethod
    def _entries() -> tuple[tuple[str, str], ...]:
        return tuple((n, f"{n[0]}_{{{n[1:]}i}}") for n in _THETA)

    def _memory(self, names: Names) -> None:
        """Name what the estimator keeps: estimates, factors of F and past values, which may be anything."""
        self.y = names.free("y_i", latex="y_i(k)", text="y(k)")
        for quantity in memory("roll"):
            key = quantity.name.removesuffix("_roll")
            positive = key[0] == "D"
            if key not in ("u1", "u2"):
                shown = {"y1": "y_i(k-1)", "y2": "y_i(k-2)", "v1": "u_i(k-2)"}.get(key, "")
                text = shown.replace("_i", "") or key
                names.free(quantity, "1/10" if positive else -1, 2, latex=shown, text=text)

    def _step(self, name: str) -> Expr:
        """Follow a step of the estimator; its own steps stay shared, so that a value is worked out once."""
        return insert_definitions(self._named[name], self._definitions, self._cut)

    @staticmethod
    def _covariance(factors: dict[str, Expr] | dict[str, sp.Symbol]) -> sp.Matrix:
        upper = sp.Matrix(5, 5, lambda i, j: factors[f"U{i + 1}{j + 1}"] if i < j else sp.Integer(i == j))
        return upper * sp.diag(*(factors[f"D{i}"] for i in range(1, 6))) * upper.T

    def _vectors(self, system: System, names: Names) -> None:
        """(37) and (38): measurement and command of a law."""
        torques = sp.Matrix([q.symbol for q in system.inputs])
        self.angles = [names.table[angle].symbol for angle in angles]
        self.torques = [
            names.free(q, -2, 2, latex=f"T_{i}(k)", text=f"T_{i}(k)") for q, i in zip(TORQUES, "xyz", strict=True)
        ]
        self.seen = names.matrix("y_all", "y(k)", sp.Matrix(angles), text="y(k)")
        self.commanded = names.matrix("u_all", "u(k)", torques, text="u(k)")


def model(e: Estimator) -> Iterator[Printed]:
    """(34)-(38): the model that is identified."""
    yield (
        printed("34", "predicted output", "equation")
        .reading(
            "with the estimate of this sample, as printed",
            Relation(e.y_hat, e.Phi_row * e.Theta, corrected=e.Phi_row * e.Theta_before),
            used=False,
            why="The estimate of this sample needs the error of the prediction: a circle, with (39) and (42).",
        )
        .reading(
            "with the estimate of the sample before, Theta(k-1)",
            Relation(e.y_hat, e.Phi_row * e.Theta_before),
            why="(39) and (42) need the prediction made before the sample is known.",
        )
    )
    yield printed("35", "estimates", "definition", Relation(e.Theta, sp.Matrix(e.theta), cases=(e.kept,)))
    y1, y2, u1, u2 = e.past
    row = sp.Matrix([[-y1, -y2, u1, u2, 1]])
    yield (
        printed(
            "36",
            "regressors",
            "definition",
            note="u is the torque that acted over [k-1, k) and [k-2, k-1). With the link's delay that was commanded "
            "one sample earlier.",
        )
        .reading(
            "the row Phi_i of (34)",
            Relation(e.Phi_row, row),
            why="(34) multiplies it from the left without a transpose; (40)-(42) take its transpose.",
        )
        .reading(
            "the same Phi as in (40)-(42)",
            Relation(e.Phi, row, corrected=row.T),
            used=False,
            why="There Phi is a column: the transpose is missing here, and in (34).",
        )
    )
    yield printed("37", "outputs", "definition", Relation(e.seen, sp.Matrix(e.angles)))
    yield printed("38", "inputs", "definition", Relation(e.commanded, sp.Matrix(e.torques)))


def recursion(e: Estimator) -> Iterator[Printed]:
    """(39)-(42): recursive least squares."""
    yield printed("39", "prediction error", "definition", Relation(e.epsilon, e.y - e.y_hat))
    yield printed("40", "gain", "equation", Relation(e.G, e.F_before * e.Phi / (e.forgetting + e.spread)))
    yield printed(
        "41",
        "covariance",
        "equation",
        Relation(e.F, (e.unit - e.G * e.Phi.T) * e.F_before / e.forgetting),
        note="The model keeps factors of F, F = U D U', which stay positive in single precision; a cap on the "
        "trace of F is its addition.",
    )
    yield printed(
        "42",
        "estimates",
        "equation",
        Relation(e.Theta, e.Theta_before + e.G * e.epsilon),
        note="The model's dead zone, an addition, is left out here.",
    )
