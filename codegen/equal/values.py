# SPDX-License-Identifier: Apache-2.0
"""Evaluation of expressions with free and defined names at a point, in particular in the finite field."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from types import MappingProxyType
from typing import Any, Generic, TypeVar

from . import field
from .field import Circle, Element, Undefined
from .pool import COMMUTATIVE, Pool

Value = TypeVar("Value")
_EXACT = frozenset(("sym", "num", "const", "add", "mul", "pow", "sin", "cos", "tan", "exp", "sinh", "cosh", "tanh"))
_ANGLES = frozenset(("atan2", "atan", "asin", "acos"))
_PERIODIC = frozenset(("sin", "cos", "tan"))
_EXPONENTIAL = frozenset(("exp", "sinh", "cosh", "tanh"))
OF_PHASES = _PERIODIC | _EXPONENTIAL | _ANGLES
"""Functions of angles and exponents, which have separate values in the field."""
_ORDER = {"strictlessthan": (1, 0), "lessthan": (1, 0), "strictgreaterthan": (0, 1), "greaterthan": (0, 1)}
_STRICT = frozenset(("strictlessthan", "strictgreaterthan"))


Lookup = Callable[[str], "tuple[World[Any], int] | None"]


class World(ABC, Generic[Value]):
    """Values of nodes at one point; a name is free or defined by an expression of this or another evaluation."""

    def __init__(self, pool: Pool, lookup: Lookup) -> None:
        self.pool = pool
        self.lookup = lookup
        self.memo: dict[int, Value | None] = {}

    def value(self, root: int) -> Value:
        """Return the value of an expression.

        Raises
        ------
        Undefined
            If it has none here.
        """
        value = self.pool.cached(self.memo, root, self._value)
        if value is None:
            raise Undefined
        return value

    def defined(self, root: int) -> Value | None:
        """Return the value of an expression; None if it has none."""
        try:
            return self.value(root)
        except Undefined:
            return None

    def _value(self, node: int) -> Value | None:
        try:
            return self.compute(node)
        except Undefined:
            return None

    @abstractmethod
    def compute(self, node: int) -> Value:
        """Return the value of a node whose operands have been evaluated."""


@dataclass(frozen=True, slots=True)
class Phase:
    """Value of an expression as an angle or exponent.

    Attributes
    ----------
    exponent : int
        Modulo `field.MODULUS`.
    pi : Fraction
        Multiple of pi.
    circle : Circle
        Contribution of inverse trigonometric functions, as a point of the circle.
    faithful : bool
        False if the exponent is arbitrary, so that equal angles may have different ones.
    """

    exponent: int
    pi: Fraction = Fraction(0)
    circle: Circle = field.ONE
    faithful: bool = True


class FieldWorld(World[Any]):
    """Evaluation in the finite field.

    Parameters
    ----------
    seed : int
        Seed of the point.
    positive : callable
        True for a free name with positive values.
    fixed : mapping
        Given values of free names.
    roots : callable
        Takes square roots.
    """

    def __init__(
        self,
        pool: Pool,
        lookup: Lookup,
        seed: int,
        positive: Callable[[str], bool],
        fixed: Mapping[str, Element] = MappingProxyType({}),
        roots: Callable[[Element], Element] = field.sqrt,
    ) -> None:
        super().__init__(pool, lookup)
        self.roots = roots
        self.seed = seed
        self.positive = positive
        self.fixed = fixed
        self._phases: dict[int, Phase] = {}
        self._exact: dict[bool, dict[int, bool]] = {True: {}, False: {}}

    def exact(self, node: int, rooted: bool = False) -> bool:
        """Return True if different values prove a difference; with `rooted`, only for all signs of the roots.

        Expressions that are equal over the reals are equal here for one choice of the signs.
        """
        return self.pool.cached(self._exact[rooted], node, lambda k: self._is_exact(k, rooted))

    def _is_exact(self, node: int, rooted: bool) -> bool:
        """Return True if a node's value in the field proves differences; it is then a function of exact operands."""
        operation, *operands = self.pool.nodes[node]
        if operation == "sym":
            target = self.lookup(operands[0])
            return target is None or target[0].exact(target[1], rooted)  # type: ignore[attr-defined]
        if operation not in _EXACT or not all(self._exact[rooted][o] for o in self.pool.operands(node)):
            return False
        if operation == "pow":
            exponent = self.pool.constant(operands[1])
            return exponent is not None and (rooted or exponent.denominator == 1)
        return operation not in _PERIODIC | _EXPONENTIAL or self.phase(operands[0]).faithful

    def compute(self, node: int) -> Any:
        """Return the value of a node."""
        operation, *operands = self.pool.nodes[node]
        if operation == "sym":
            return self._symbol(operands[0])
        if operation == "num":
            return field.number(Fraction(operands[0]))
        if operation == "const":
            return _positive("constant", operands[0])
        if operation in _PERIODIC:
            cosine, sine = self._circle(self.phase(operands[0]))
            return {"sin": sine, "cos": cosine}.get(operation) or _ratio(sine, cosine, operation)
        if operation in _EXPONENTIAL:
            return _hyperbolic(operation, field.exponential(self._exponent(self.phase(operands[0]))))
        if operation in _ANGLES:
            return field.hashed("angle", self._point(operation, operands)) % field.P
        if operation == "piecewise":
            return self._piecewise(operands)
        values = [self.memo[o] for o in operands]
        if operation == "exprcondpair":
            return tuple(values)
        if any(v is None for v in values):
            raise Undefined
        return self._strict(operation, operands, values)

    def _strict(self, operation: str, operands: Sequence[int], values: list[Any]) -> Any:
        """Return the value of an operation; functions without a value in the field are hashes of their operands."""
        if operation == "add":
            return reduce(field.add, [0, *values])
        if operation == "mul":
            return reduce(field.mul, [1, *values])
        if operation == "pow":
            exponent = self.pool.constant(operands[1])
            if exponent is None:
                return _positive("pow", *values)
            return field.rational_power(values[0], exponent, self.roots)
        if operation == "abs":
            return _positive("abs", field.mul(values[0], values[0]))
        if operation in _ORDER:
            greater, less = (values[k] for k in _ORDER[operation])
            return field.hashed(operation in _STRICT, field.sub(greater, less)) % field.P
        if operation in COMMUTATIVE:
            values.sort(key=repr)
        return field.hashed(operation, *values) % field.P

    def _piecewise(self, operands: Sequence[int]) -> Any:
        """Return an arbitrary function of all cases; each of them must have a value."""
        pairs: list[Any] = [self.memo[o] for o in operands]
        if any(pair is None or None in pair for pair in pairs):
            raise Undefined
        return field.hashed("piecewise", *pairs) % field.P

    def _symbol(self, name: str) -> Any:
        target = self.lookup(name)
        if target is not None:
            return target[0].value(target[1])
        if name in self.fixed:
            return self.fixed[name]
        free = field.hashed("symbol", self.seed, name) % field.P
        return field.mul(free, free) if self.positive(name) else free

    def phase(self, node: int) -> Phase:
        """Return the value of an expression as an angle or exponent."""
        if node not in self._phases:
            self._phases[node] = self._phase(node)
        return self._phases[node]

    def _phase(self, node: int) -> Phase:
        """Return an expression as an angle or exponent; without a rule for its operation, an arbitrary one."""
        operation, *operands = self.pool.nodes[node]
        if operation == "sym":
            target = self.lookup(operands[0])
            if target is not None:
                return target[0].phase(target[1])  # type: ignore[attr-defined, no-any-return]
            return Phase(field.hashed("exponent", self.seed, operands[0]) % field.MODULUS)
        if operation == "num":
            return Phase(_exponent(Fraction(operands[0])))
        if operation == "const" and operands[0] == "pi":
            return Phase(0, Fraction(1))
        if operation == "add":
            return _total([self.phase(o) for o in operands])
        if operation == "mul":
            return self._phase_of_product(node, operands)
        if operation == "pow":
            base, exponent = self.phase(operands[0]), self.pool.constant(operands[1])
            value = self._exponent(base) if base.circle == field.ONE else 0
            if exponent is not None and exponent.denominator == 1 and value:
                return Phase(pow(value, int(exponent), field.MODULUS), faithful=base.faithful)
        if operation in _ANGLES:
            return Phase(0, circle=self._point(operation, operands))
        return self._arbitrary(node)

    def _phase_of_product(self, node: int, operands: Sequence[int]) -> Phase:
        """Return a product as an angle or exponent; several factors without pi or turns multiply exponents."""
        constants = [c for c in map(self.pool.constant, operands) if c is not None]
        others = [o for o in operands if self.pool.constant(o) is None]
        factor = constants[0] if constants else Fraction(1)
        if len(others) == 1:
            return self._scaled(node, self.phase(others[0]), factor)
        phases = [self.phase(o) for o in others]
        if any(phase.circle != field.ONE or not phase.faithful for phase in phases):
            return self._scaled(node, self._arbitrary(self.pool.many("mul", others)), factor)
        product = _exponent(factor)
        for phase in phases:
            product = product * self._exponent(phase) % field.MODULUS
        return Phase(product)

    def _scaled(self, node: int, phase: Phase, factor: Fraction) -> Phase:
        """Return a phase times a number; a turn can be halved, but not divided by another number."""
        point = phase.circle
        if point != field.ONE:
            if factor.denominator == 2:
                point = field.halved(point, self.roots)
            elif factor.denominator != 1:
                return self._arbitrary(node)
            point = field.turned(point, factor.numerator)
        exponent = phase.exponent * _exponent(factor) % field.MODULUS
        return Phase(exponent, phase.pi * factor, point, phase.faithful)

    def _arbitrary(self, node: int) -> Phase:
        return Phase(field.hashed("phase", self.value(node)) % field.MODULUS, faithful=False)

    def _exponent(self, phase: Phase) -> int:
        if phase.circle != field.ONE:
            return field.hashed("exponent", phase.circle, phase.exponent, phase.pi) % field.MODULUS
        return (phase.exponent + _exponent(phase.pi) * field.hashed("pi")) % field.MODULUS

    def _circle(self, phase: Phase) -> Circle:
        twelfths = phase.pi * 12
        if twelfths.denominator == 1:
            turned = field.circle(phase.exponent, int(twelfths))
        else:
            turned = field.circle((phase.exponent + _exponent(phase.pi) * field.hashed("pi")) % field.MODULUS, 0)
        return field.turn(turned, phase.circle) if phase.circle != field.ONE else turned

    def _point(self, operation: str, operands: Sequence[int]) -> Circle:
        values = [self.value(o) for o in operands]
        if operation in ("asin", "acos"):
            other = self.roots(field.sub(1, field.mul(values[0], values[0])))
            return (other, values[0]) if operation == "asin" else (values[0], other)
        sine, cosine = values if operation == "atan2" else (values[0], 1)
        size = field.inverse(self.roots(field.add(field.mul(sine, sine), field.mul(cosine, cosine))))
        return field.mul(cosine, size), field.mul(sine, size)


def _positive(*parts: object) -> Element:
    root = field.hashed(*parts) % field.P
    return field.mul(root, root)


def _ratio(sine: Element, cosine: Element, operation: str) -> Element:
    return field.mul(sine, field.inverse(cosine)) if operation == "tan" else 0


def _hyperbolic(operation: str, e: Element) -> Element:
    if operation == "exp":
        return e
    half, back = field.number(Fraction(1, 2)), field.inverse(e)
    sinh, cosh = field.mul(half, field.sub(e, back)), field.mul(half, field.add(e, back))
    return {"sinh": sinh, "cosh": cosh}.get(operation) or field.mul(sinh, field.inverse(cosh))


def _exponent(value: Fraction) -> int:
    return value.numerator * pow(value.denominator, -1, field.MODULUS) % field.MODULUS


def _total(phases: Sequence[Phase]) -> Phase:
    """Return the sum of phases; turns are added on the circle."""
    point = field.ONE
    for phase in phases:
        if phase.circle != field.ONE:
            point = field.turn(point, phase.circle)
    return Phase(
        sum(phase.exponent for phase in phases) % field.MODULUS,
        sum((phase.pi for phase in phases), Fraction(0)),
        point,
        all(phase.faithful for phase in phases),
    )
