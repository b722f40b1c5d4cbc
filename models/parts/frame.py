# SPDX-License-Identifier: Apache-2.0
"""Hub axes, in which an assembly's equations are written, and the named steps of its derivation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field

import sympy as sp

from ..derivation import Derivation, Expr
from ..quantities import Quantity

AXES = "xyz"
ZERO = sp.zeros(3, 1)


@dataclass
class Frame:
    """Hub axes: motion of their origin O, and the steps of the derivation.

    Attributes
    ----------
    derivation : Derivation
        Receives the steps.
    rate : sympy.Matrix
        W, the angular velocity of the axes in their own components, rad/s; structural zeros are numbers.
    constants : set of Symbol
        Parameters, and definitions that depend only on parameters.
    names : dict
        Expressions by name; an expression that is defined again keeps its name.
    slopes : dict
        Coordinate and derivative of steps that depend on one coordinate, such as those of `circle`.
    """

    derivation: Derivation
    rate: sp.Matrix
    constants: set[sp.Symbol] = field(default_factory=set)
    names: dict[str, tuple[Expr, sp.Symbol]] = field(default_factory=dict)
    slopes: dict[sp.Symbol, tuple[sp.Symbol, Expr]] = field(default_factory=dict)

    @classmethod
    def of(cls, parameters: Iterable[sp.Symbol], rate: sp.Matrix, derivation: Derivation) -> Frame:
        """Return the axes of a system that declares its own parameters and steps."""
        constants = set(parameters)
        for symbol, expr in derivation.definitions.items():
            if expr.free_symbols <= constants:
                constants.add(symbol)
        return cls(derivation, rate, constants)

    def is_constant(self, expr: Expr) -> bool:
        """Return True if an expression depends on parameters only."""
        return bool(expr.free_symbols <= self.constants)

    def define(self, name: str, expr: Expr, title: str, unit: str = "") -> Expr:
        """Name an expression, unless it is a number, a name or a negated name."""
        if name in self.names and self.names[name][0] == expr:
            return self.names[name][1]
        factor, bare = expr.as_coeff_Mul()
        if expr.is_number or (bare.is_Symbol and abs(factor) == 1):
            return expr
        constant = self.is_constant(expr)
        symbol = self.derivation.define(name, expr, title=title, unit=unit)
        self.names[name] = expr, symbol
        if constant:
            self.constants.add(symbol)
        return symbol

    def vector(self, name: str, entries: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the components of a vector."""
        return sp.Matrix(
            [self.define(f"{name}{axis}", e, f"{title}, {axis}", unit) for axis, e in zip(AXES, entries, strict=True)]
        )

    def tensor(self, name: str, matrix: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the entries of a symmetric matrix."""
        result = sp.zeros(3, 3)
        for i in range(3):
            for j in range(i + 1):
                entry = self.define(f"{name}{AXES[j]}{AXES[i]}", matrix[i, j], f"{title}, {AXES[j]}{AXES[i]}", unit)
                result[i, j] = result[j, i] = entry
        return result

    def matrix(self, name: str, entries: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the entries of a matrix."""
        return sp.Matrix(3, 3, lambda i, j: self.define(f"{name}{AXES[i]}{AXES[j]}", entries[i, j], title, unit))

    def circle(self, angle: sp.Symbol) -> tuple[Expr, Expr]:
        """Name cosine and sine of a coordinate."""
        cosine = self.define(f"cos_{angle.name}", sp.cos(angle), f"cosine of {angle.name}", "1")
        sine = self.define(f"sin_{angle.name}", sp.sin(angle), f"sine of {angle.name}", "1")
        self.slopes[cosine], self.slopes[sine] = (angle, -sine), (angle, cosine)
        return cosine, sine

    def slope(self, expr: Expr, coordinate: sp.Symbol) -> Expr:
        """Differentiate with respect to a coordinate, including steps that depend on it."""
        result = expr.diff(coordinate)
        for symbol in expr.free_symbols & self.slopes.keys():
            of, slope = self.slopes[symbol]
            if of == coordinate:
                result += expr.diff(symbol) * slope
        return result

    def total(self, name: str, terms: Iterable[Expr], title: str, unit: str = "") -> Expr:
        """Name a sum. Terms of parameters only are summed separately, so that a run computes them once."""
        fixed: list[Expr] = []
        moving: list[Expr] = []
        for term in terms:
            for part in sp.Add.make_args(term):
                (fixed if self.is_constant(part) else moving).append(part)
        constant = sp.Add(*fixed)
        if moving and len(fixed) > 1:
            constant = self.define(f"{name}_fixed", constant, f"{title}: constant part", unit)
        return self.define(name, sp.Add(constant, *moving), title, unit)


@dataclass(frozen=True)
class Labels(ABC):
    """Names of steps that begin with a part's.

    Attributes
    ----------
    name : str
        Name of the part, and start of the names of its parameters, states and steps.
    """

    name: str

    @property
    @abstractmethod
    def frame(self) -> Frame:
        """Hub axes of the assembly."""

    def define(self, name: str, expr: Expr, title: str, unit: str = "") -> Expr:
        """Name an expression after the part."""
        return self.frame.define(f"{self.name}_{name}", expr, f"{self.name}: {title}", unit)

    def vector(self, name: str, entries: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the components of a vector of the part."""
        return self.frame.vector(f"{self.name}_{name}", entries, f"{self.name}: {title}", unit)

    def tensor(self, name: str, matrix: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the entries of a symmetric matrix of the part."""
        return self.frame.tensor(f"{self.name}_{name}", matrix, f"{self.name}: {title}", unit)

    def matrix(self, name: str, entries: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the entries of a matrix of the part."""
        return self.frame.matrix(f"{self.name}_{name}", entries, f"{self.name}: {title}", unit)

    def across(self, axis: sp.Matrix, along: sp.Matrix, title: str) -> tuple[sp.Matrix, sp.Matrix]:
        """Name the unit vectors normal to an axis, nearest to a direction and 90 degrees ahead of it."""
        normal = axis.cross(along)
        side = self.vector("side", normal / sp.sqrt(normal.dot(normal)), f"{title} at 90 degrees", "1")
        return self.vector("front", side.cross(axis), f"{title} at zero", "1"), side


def triple(start: str, unit: str, meaning: str) -> tuple[Quantity, ...]:
    """Return the components of a vector."""
    return tuple(Quantity(f"{start}{axis}", unit, f"{meaning}, {axis}") for axis in AXES)


def quaternion(start: str, meaning: str) -> tuple[Quantity, ...]:
    """Return the components of a quaternion, scalar first."""
    return tuple(Quantity(f"{start}{k}", "1", f"{meaning}, component {k}") for k in range(4))


def symbols(quantities: Iterable[Quantity]) -> sp.Matrix:
    """Return the symbols of quantities as a column."""
    return sp.Matrix([q.symbol for q in quantities])


def point_inertia(mass: Expr, place: sp.Matrix) -> sp.Matrix:
    """Return the inertia of a point mass about O, kg m^2."""
    x, y, z = place
    return mass * sp.Matrix(
        [[y * y + z * z, -x * y, -x * z], [-x * y, x * x + z * z, -y * z], [-x * z, -y * z, x * x + y * y]]
    )
