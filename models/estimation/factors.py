# SPDX-License-Identifier: Apache-2.0
"""Factored covariance P = U D U', with U unit upper triangular and D diagonal.

D stays positive even in single precision, where an update of P itself can become indefinite. Sources: Bierman,
Factorization Methods for Discrete Sequential Estimation, Academic Press 1977 (a measurement); Thornton and Bierman,
in Control and Dynamic Systems 16 (1980) 177 (noise, by weighted Gram-Schmidt). Structural zeros cost no operations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from mehvar.base.units import dimension, product, unit_text

from ..derivation import Expr

Keep = Callable[[str, str, str, Expr | float], sp.Symbol]
Define = Callable[[str, Expr, str], Expr]
"""Function that names an expression; its arguments are name, expression and title."""


@dataclass(frozen=True)
class Factors:
    """The factors U and D of a covariance."""

    upper: sp.Matrix
    diagonal: tuple[Expr, ...]

    @classmethod
    def kept(cls, keep: Keep, units: Sequence[str], variances: Sequence[Expr]) -> Factors:
        """Keep the factors of a diagonal covariance in a law's memory.

        Parameters
        ----------
        keep : callable
            Adds a number to the memory, by name, unit, meaning and start.
        units : sequence of str
            Of the estimated quantities.
        variances : sequence of Expr
            Of these at the start.
        """
        of = [dimension(unit) for unit in units]
        diagonal = [
            keep(f"D{k}", unit_text(product((unit, 2))), f"covariance U D U', entry {k} of D", variance)
            for k, (unit, variance) in enumerate(zip(of, variances, strict=True), 1)
        ]
        entries = {
            (i, j): keep(
                f"U{i + 1}{j + 1}", unit_text(product((of[i], 1), (of[j], -1))), f"entry {i + 1}, {j + 1} of U", 0
            )
            for i, j in above(len(of))
        }
        return cls.of(entries, diagonal)

    @property
    def above(self) -> dict[tuple[int, int], Expr]:
        """Entries of U above the diagonal, by row and column."""
        return {(i, j): self.upper[i, j] for i, j in above(len(self.diagonal))}

    @property
    def entries(self) -> tuple[Expr, ...]:
        """Diagonal of D, then the entries of U above its diagonal."""
        return (*self.diagonal, *self.above.values())

    @classmethod
    def of(cls, entries: Mapping[tuple[int, int], Expr], diagonal: Sequence[Expr]) -> Factors:
        """Return factors from the entries of U above its diagonal, and D."""
        upper = sp.eye(len(diagonal))
        for place, entry in entries.items():
            upper[place] = entry
        return cls(upper, tuple(diagonal))

    def distance(self, define: Define, error: Sequence[Expr]) -> Expr:
        """Return e' P^-1 e for an error e."""
        white: list[Expr] = list(error)
        for i in reversed(range(len(white))):
            rest = sp.Add(*(self.upper[i, j] * white[j] for j in range(i + 1, len(white))))
            white[i] = define(f"e{i + 1}", white[i] - rest, "error, without what other entries tell of it")
        return sp.Add(*(w**2 / d for w, d in zip(white, self.diagonal, strict=True)))

    def moved(self, define: Define, transition: sp.Matrix) -> Factors:
        """Return the factors of F P F' for unit upper triangular F."""
        product = transition * self.upper
        entries = {(i, j): define(f"U{i + 1}{j + 1}", product[i, j], "entry of U") for i, j in self.above}
        return Factors.of(entries, self.diagonal)

    def widened(self, define: Define, noise: Sequence[Expr]) -> Factors:
        """Return the factors of P + Q, with Q diagonal."""
        return self.propagated(define, sp.eye(len(noise)), sp.eye(len(noise)), noise)

    def propagated(self, define: Define, transition: sp.Matrix, drive: sp.Matrix, noise: Sequence[Expr]) -> Factors:
        """Return the factors of F P F' + G Q G'.

        Parameters
        ----------
        define : callable
            Names the expressions.
        transition, drive : sympy.Matrix
            F and G.
        noise : sequence of Expr
            Diagonal of Q.
        """
        product = transition * self.upper
        rows = [[*product.row(i), *drive.row(i)] for i in range(len(self.diagonal))]
        return Factors.weighted(define, rows, (*self.diagonal, *noise))

    @staticmethod
    def weighted(define: Define, rows: Sequence[Sequence[Expr]], weights: Sequence[Expr]) -> Factors:
        """Return the factors of W Q W' for the rows of W and the diagonal `weights` of Q."""
        size = len(rows)
        rows = [[define(f"w{i + 1}_{k + 1}", e, "row") for k, e in enumerate(row)] for i, row in enumerate(rows)]
        entries: dict[tuple[int, int], Expr] = {}
        diagonal = [sp.S.Zero] * size
        for j in reversed(range(size)):
            scaled = [
                define(f"v{j + 1}_{k + 1}", weights[k] * r, "weighted row") if r != 0 else r
                for k, r in enumerate(rows[j])
            ]
            diagonal[j] = define(f"D{j + 1}", _dot(rows[j], scaled), "entry of D")
            over = define(f"o{j + 1}", 1 / diagonal[j], "one over an entry of D")
            for i in range(j):
                entry = define(f"U{i + 1}{j + 1}", _dot(rows[i], scaled) * over, "entry of U")
                entries[i, j] = entry
                rows[i] = [
                    define(f"w{i + 1}{j + 1}_{k + 1}", r - entry * other, "row") if other != 0 else r
                    for k, (r, other) in enumerate(zip(rows[i], rows[j], strict=True))
                ]
        return Factors.of(entries, diagonal)

    def measured(self, define: Define, row: Sequence[Expr], variance: Expr) -> tuple[Factors, list[Expr], Expr]:
        """Return the factors after a measurement h x, the vector P h', and the inverse variance of the innovation.

        Parameters
        ----------
        define : callable
            Names the expressions.
        row : sequence of Expr
            h.
        variance : Expr
            Of the noise.
        """
        size = len(self.diagonal)
        turned = [define(f"f{j + 1}", _dot(row, list(self.upper.col(j))), "entry of U' h'") for j in range(size)]
        return self.measured_by(define, turned, variance)

    def measured_by(self, define: Define, row: Sequence[Expr], variance: Expr) -> tuple[Factors, list[Expr], Expr]:
        """Return the result of `measured` for a measurement given as the row h U."""
        alpha, over, product = variance, define("o0", 1 / variance, "one over the variance"), list[Expr]()
        entries, diagonal = dict(self.above), list(self.diagonal)
        for j, (weight, turned) in enumerate(zip(self.diagonal, row, strict=True)):
            scaled = define(f"v{j + 1}", weight * turned, "entry of D U' h'")
            share = define(f"l{j + 1}", turned * over, "entry of U' h' over the variance so far")
            total = define(f"a{j + 1}", alpha + turned * scaled, "variance of the noise and of the first entries")
            over = define(f"o{j + 1}", 1 / total, "one over it")
            diagonal[j] = define(f"D{j + 1}", weight * alpha * over, "entry of D")
            for i in range(j):
                old = self.upper[i, j]
                entries[i, j] = define(f"U{i + 1}{j + 1}", old - share * product[i], "entry of U")
                product[i] = define(f"b{i + 1}_{j + 1}", product[i] + old * scaled, "entry of P h'")
            product.append(scaled)
            alpha = total
        return Factors.of(entries, diagonal), product, over

    def corrected(
        self, stage: Callable[[str], Define], measurements: Iterable[tuple[str, Sequence[Expr], Expr, Expr]]
    ) -> tuple[sp.Matrix, Factors, Expr]:
        """Return the correction of the estimates, the factors and the normalised innovation squared.

        Parameters
        ----------
        stage : callable
            Returns the function that names the expressions of a measurement.
        measurements : iterable of (str, sequence of Expr, Expr, Expr)
            Each with a name, h, the variance of the noise, and the difference from the value before all measurements.
        """
        correction, factors, terms = sp.zeros(len(self.diagonal), 1), self, []
        for name, row, variance, difference in measurements:
            define = stage(name)
            factors, gain, over = factors.measured(define, row, variance)
            innovation = define("innovation", difference - sp.Matrix(row).dot(correction), "innovation")
            share = define("share", innovation * over, "innovation over its variance")
            total = correction + share * sp.Matrix(gain)
            correction = sp.Matrix([define(f"x{i}", entry, "correction") for i, entry in enumerate(total, 1)])
            terms.append(innovation * share)
        return correction, factors, sp.Add(*terms)

    def chosen(self, define: Define, other: Factors, when: sp.Rel) -> Factors:
        """Return the factors `other` where a condition holds, and these factors elsewhere."""

        def choice(name: str, yes: Expr, no: Expr) -> Expr:
            return define(name, sp.Piecewise((yes, when), (no, True)), "entry after the sample")

        entries = {(i, j): choice(f"U{i + 1}{j + 1}", other.upper[i, j], e) for (i, j), e in self.above.items()}
        pairs = zip(other.diagonal, self.diagonal, strict=True)
        return Factors.of(entries, [choice(f"D{k}", *pair) for k, pair in enumerate(pairs, 1)])


def above(size: int) -> list[tuple[int, int]]:
    """Return row and column of each entry above the diagonal."""
    return [(i, j) for j in range(size) for i in range(j)]


def _dot(one: Sequence[Expr], other: Sequence[Expr]) -> Expr:
    return sp.Add(*(a * b for a, b in zip(one, other, strict=True)))
