# SPDX-License-Identifier: Apache-2.0
"""Sigma-point filter for any system: means and covariances from 2 n points, without derivatives of the equations.

The points are x +- sqrt(n d_i) u_i, with the columns u_i of U and the entries d_i of D of the covariance U D U': the
cubature rule of third degree (Arasaratnam and Haykin, IEEE Trans. Automatic Control 54 (2009) 1254). Its weights are
positive, so the covariance stays a sum of squares, and its factors follow by weighted Gram-Schmidt. Each measurement
is fitted by a linear function of the points. The residual of the fit counts as additional measurement noise, so that
Bierman's update applies. New points are computed for each measurement. Noise enters through derivatives at the mean.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from ..derivation import Expr
from .extended import ExtendedFilter
from .factors import Define, Factors


class CubatureFilter(ExtendedFilter):
    """A sigma-point filter under construction in a law."""

    def corrected(self) -> tuple[list[Expr], Factors, Expr]:
        """Return estimates, covariance factors and normalised innovation squared after all measurements."""
        sensor = self.of.sensor
        assert sensor is not None
        errors = self.at("seen", self.prior, sensor.noise).jacobian(sensor.measured, sensor.noise.symbols)
        self._check(errors)
        x, factors, terms = list[Expr](self.prior), self.factors, []
        for k, seen in enumerate(self.of.seen.symbols):
            stage, define = f"seen{k + 1}", self.stage(f"seen{k + 1}")
            roots, points = self._points(define, x, factors)
            pairs = [
                [
                    self.at(f"{stage}_{way}{i + 1}", p, sensor.noise).values([sensor.measured[k]])[0]
                    for way, p in pair.items()
                ]
                for i, pair in enumerate(points)
            ]
            mean, odd, even = _parts(define, pairs)
            n = sp.Integer(len(x))
            row = [
                define(f"f{i + 1}", sp.Piecewise((o / (sp.sqrt(n) * r), r > 0), (0, True)), "slope along a column of U")
                for i, (o, r) in enumerate(zip(odd, roots, strict=True))
            ]
            noise = sp.Add(*(e**2 for e in errors.row(k)), *(e**2 / n for e in even))
            variance = define("R", noise, "variance of the noise, and of what a line leaves")
            factors, product, over = factors.measured_by(define, row, variance)
            innovation = define("innovation", seen - mean, "innovation")
            share = define("share", innovation * over, "innovation over its variance")
            x = [
                define(f"x{i + 1}", e + share * p, "estimate") for i, (e, p) in enumerate(zip(x, product, strict=True))
            ]
            terms.append(innovation * share)
        define = self.stage("after")
        after = [define(q.name, e, f"estimate of {q.name}") for q, e in zip(self.of.states, x, strict=True)]
        return after, factors, sp.Add(*terms)

    def predicted(self, x: Sequence[Expr], factors: Factors) -> tuple[list[Expr], Factors]:
        """Return estimates and factors for the next sample."""
        acting, jump = self.acting(), self.of.random_step
        _, points = self._points(self.stage("step"), x, factors)
        pairs = [
            [self.flow(f"step{i + 1}{way}", p, acting)[0] for way, p in pair.items()] for i, pair in enumerate(points)
        ]
        means, rows = self._gathered("step", pairs)
        _, _, columns = self.driven(means, acting)
        if jump:
            pairs = [
                [self.at(f"jump{i + 1}{k}", p, jump.noise, acting).values(jump.after) for k, p in enumerate(pair)]
                for i, pair in enumerate(pairs)
            ]
            means, rows = self._gathered("jump", pairs)
        rows = [[*row, *(column[k] for column, _ in columns)] for k, row in enumerate(rows)]
        weights = [1 / sp.Integer(len(x))] * (2 * len(x)) + [q for _, q in columns]
        return means, Factors.weighted(self.stage("noise"), rows, weights)

    def _points(self, define: Define, x: Sequence[Expr], factors: Factors) -> tuple[list[Expr], list[_Pair]]:
        """Return the square roots of D, and two points on opposite sides of the mean for each column of U."""
        roots = [define(f"r{k + 1}", sp.sqrt(d), "root of an entry of D") for k, d in enumerate(factors.diagonal)]
        points: list[_Pair] = []
        for i, root in enumerate(roots):
            column = [sp.sqrt(sp.Integer(len(x))) * root * u for u in factors.upper.col(i)]
            points.append(
                {
                    way: [
                        define(f"{way}{i + 1}_{k + 1}", e + sign * c, "point")
                        for k, (e, c) in enumerate(zip(x, column, strict=True))
                    ]
                    for way, sign in (("above", 1), ("below", -1))
                }
            )
        return roots, points

    def _gathered(self, name: str, pairs: Sequence[Sequence[Sequence[Expr]]]) -> tuple[list[Expr], list[list[Expr]]]:
        """Return the means and deviations of points, one row per state."""
        parts = [
            _parts(self.stage(f"{name}_of{k + 1}"), [[p[k] for p in pair] for pair in pairs]) for k in range(len(pairs))
        ]
        return [mean for mean, _, _ in parts], [[*odd, *even] for _, odd, even in parts]


_Pair = Mapping[str, Sequence[Expr]]
"""Two sigma points, `above` and `below` the mean along a column of U."""


def _parts(define: Define, pairs: Sequence[Sequence[Expr]]) -> tuple[Expr, list[Expr], list[Expr]]:
    """Return the mean of all pairs and, for each pair, half its difference and its deviation from the mean."""
    total = sp.Add(*(value for pair in pairs for value in pair))
    mean = define("mean", total / (2 * len(pairs)), "mean over the points")
    odd = [define(f"odd{i + 1}", (a - b) / 2, "half the difference of a pair") for i, (a, b) in enumerate(pairs)]
    even = [
        define(f"even{i + 1}", (a + b) / 2 - mean, "mean of a pair, less that of all") for i, (a, b) in enumerate(pairs)
    ]
    return mean, odd, even
