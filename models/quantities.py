# SPDX-License-Identifier: Apache-2.0
"""Named numbers with units, and the groups in which they travel."""

from __future__ import annotations

import functools
import itertools
import os
import re
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mehvar.base.display import table
from mehvar.base.errors import MehvarError, shown

if TYPE_CHECKING:
    import sympy as sp


class ModelError(MehvarError, ValueError):
    """A mistake in a model's text: a derivation, a parameter table or a scenario table."""


_VOCABULARY = str(Path(__file__).parent) + os.sep


def caller() -> str:
    """Return file and line of the model's text that called, as in "models/pendulum/system.py:57"."""
    frame = sys._getframe(1)
    while frame.f_back and _is_vocabulary(frame.f_code.co_filename):
        frame = frame.f_back
    return place(frame.f_code.co_filename, frame.f_lineno)


def wrong(name: str, value: object, allowed: str) -> ModelError:
    """Return the error for an argument, with file and line of the model's text that gave it."""
    return ModelError(f"{caller()}: {name} = {shown(value)}: must be {allowed}")


def place(file: str, line: int) -> str:
    """Return file and line as a message shows them: from the folder one is in, where the file is below it."""
    path = Path(file)
    return f"{path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}:{line}"


@functools.cache
def _is_vocabulary(file: str) -> bool:
    """Tell whether a file is one of ours, not a model's; the functions that a dataclass makes are in <string>."""
    if file == "<string>" or Path(file).name == "dataclasses.py":
        return True
    return file.startswith(_VOCABULARY) and os.sep not in file.removeprefix(_VOCABULARY)


@dataclass(frozen=True)
class Located:
    """Base of a model's parts: it records file and line, and turns numbers into expressions.

    Attributes
    ----------
    origin : str
        File and line that made it.
    """

    origin: str = field(default_factory=caller, init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        for entry in fields(self):
            if "Expr" in str(entry.type):
                object.__setattr__(self, entry.name, _expressions(getattr(self, entry.name)))


def _expressions(value: Any) -> Any:
    """Return a value with SymPy's numbers in place of Python's."""
    if isinstance(value, Real) and not isinstance(value, bool):
        import sympy as sp  # tables of numbers are read without it

        return sp.sympify(value)
    if type(value) is tuple:
        return tuple(map(_expressions, value))
    if isinstance(value, Mapping):
        return {key: _expressions(entry) for key, entry in value.items()}
    return value


@dataclass(frozen=True)
class Quantity:
    """A named number with a unit.

    Parameters
    ----------
    name : str
        ASCII identifier, the same in C, Python and result files.
    unit : str
        SI unit, radians inside; "1" for a dimensionless number.
    description : str
        One line for people.
    latex : str, optional
        How the paper writes it; SymPy's guess from the name when empty.
    positive : bool, optional
        SymPy may assume that the value is positive.
    family, index : str and int, optional
        For a quantity that exists once for each of several equal parts: what it is called without its number, and the
        number. Comparisons use it to say "for every i".
    """

    name: str
    unit: str
    description: str
    latex: str = ""
    positive: bool = False
    family: str = field(default="", kw_only=True)
    index: int = field(default=0, kw_only=True)

    @functools.cached_property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of this quantity."""
        import sympy as sp  # tables of numbers are read without it

        _advise()
        return sp.Symbol(self.name, positive=True) if self.positive else sp.Symbol(self.name, real=True)


@functools.cache
def _advise() -> None:
    """Add the functions to use to SymPy's error where Python's `min`, `max` or `if` compares symbols.

    `check.no_branching` refuses them with file and line while a model is derived; this is for all other places.
    """
    from sympy.core.relational import Relational

    plain = Relational.__bool__

    def truth(relation: Relational) -> bool:
        try:
            return bool(plain(relation))
        except TypeError as error:
            error.add_note("In a model, write sympy.Min, Max, Abs or Piecewise in place of min, max, abs and if.")
            raise

    Relational.__bool__ = truth


@dataclass(frozen=True)
class Interval:
    """Allowed values of a parameter, written "(0, inf)" or "[0, 1]" in a table."""

    lower: float
    upper: float
    lower_open: bool
    upper_open: bool

    def __contains__(self, value: float) -> bool:
        above = value > self.lower if self.lower_open else value >= self.lower
        below = value < self.upper if self.upper_open else value <= self.upper
        return above and below

    def __str__(self) -> str:
        return f"{'(['[not self.lower_open]}{self.lower:g}, {self.upper:g}{')]'[not self.upper_open]}"

    @property
    def positive(self) -> bool:
        """True if every allowed value is above zero."""
        return self.lower > 0 or (self.lower == 0 and self.lower_open)

    @classmethod
    def parse(cls, text: str) -> Interval:
        """Read "(0, inf)" or "[0, 1]".

        Raises
        ------
        ValueError
            If the text is not an interval or is empty.
        """
        match = _INTERVAL.match(text)
        if not match:
            raise ValueError(f"bounds {text!r} are not an interval like '(0, inf)' or '[0, 1]'")
        left, lower, upper, right = match.groups()
        try:
            interval = cls(float(lower), float(upper), left == "(", right == ")")
        except ValueError:
            raise ValueError(f"bounds {text!r} hold something that is not a number") from None
        if not interval.lower < interval.upper:
            raise ValueError(f"bounds {text!r} are empty")
        return interval


_INTERVAL = re.compile(r"^([(\[])\s*([^,\s_]+)\s*,\s*([^,\s_]+)\s*([)\]])$", re.ASCII)
REALS = Interval(-float("inf"), float("inf"), True, True)
"""Every finite number."""


@dataclass(frozen=True)
class ParameterArray(ABC):
    """Parameters that stand in a table as one entry; the kinds are in `arrays`.

    Parameters
    ----------
    name : str
        What their group has them under together.
    shape : tuple of int
        One number for a vector, rows and columns for a matrix.
    """

    name: str
    shape: tuple[int, ...]

    def places(self) -> Iterator[tuple[int, ...]]:
        """Yield the indices of the elements in their order, from one on."""
        yield from itertools.product(*(range(1, size + 1) for size in self.shape))

    @abstractmethod
    def of(self, group: Group) -> Any:
        """Return their symbols in expressions."""


@dataclass(frozen=True)
class Parameter(Quantity):
    """A number that the user may change: an input of the generated functions, never a constant in them.

    Parameters
    ----------
    name, unit, description, latex, positive, family, index
        As of a `Quantity`; it is positive where its bounds are.
    default : float or str, optional
        The value, or a formula in other parameters of the same group.
    bounds : Interval or str
        Allowed values, as in "(0, inf)".
    source : str
        Where the number comes from, such as a publication with its table.
    array : ParameterArray, optional
        What it is an element of.
    """

    default: float | str = 0.0
    bounds: Interval = REALS
    source: str = ""
    array: ParameterArray | None = None

    if TYPE_CHECKING:  # bounds may also be given as text

        def __init__(
            self, name: str, unit: str, description: str, latex: str = "", positive: bool = False,
            default: float | str = 0.0, bounds: Interval | str = REALS, source: str = "",
            array: ParameterArray | None = None, *, family: str = "", index: int = 0,
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        if isinstance(self.bounds, str):
            try:
                object.__setattr__(self, "bounds", Interval.parse(self.bounds))
            except ValueError as error:
                raise ModelError(f"{caller()}: parameter {self.name!r}: {error}") from None
        if isinstance(self.bounds, Interval) and isinstance(self.bounds.lower, Real) and self.bounds.positive:
            object.__setattr__(self, "positive", True)


@dataclass(frozen=True, repr=False)
class Group:
    """Quantities that travel together as one vector, such as the state or the plant's parameters.

    Parameters
    ----------
    name : str
        Name of the vector in generated code, such as x.
    quantities : tuple of Quantity
        In their order in the vector.

    `group.rho` is the symbol of the element rho; of an array of parameters its matrix, or its table to be called.
    """

    name: str
    quantities: tuple[Quantity, ...]

    def __repr__(self) -> str:
        return f"<group {self.name}: {', '.join(f'{q.name} [{q.unit}]' for q in self.quantities)}>"

    def _repr_html_(self) -> str:
        columns = {"name": "name", "unit": "unit", "meaning": "description"}
        if any(isinstance(q, Parameter) for q in self.quantities):
            columns |= {"default": "default", "allowed": "bounds", "source": "source"}
        rows = [[getattr(q, entry, "") for entry in columns.values()] for q in self.quantities]
        return table(self.name, tuple(columns), rows)

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """The SymPy symbols in order."""
        return tuple(q.symbol for q in self.quantities)

    def elements(self, array: str) -> dict[tuple[int, ...], sp.Symbol]:
        """Return the symbols of the elements of an array by their indices, from one on."""
        members = [q for q in self.quantities if isinstance(q, Parameter) and q.array and q.array.name == array]
        whole = members[0].array if members else None
        return {} if whole is None else {k: q.symbol for k, q in zip(whole.places(), members, strict=True)}

    def __getattr__(self, name: str) -> Any:
        for quantity in object.__getattribute__(self, "quantities"):
            if quantity.name == name:
                return quantity.symbol
            array = getattr(quantity, "array", None)
            if array is not None and array.name == name:
                return array.of(self)
        raise AttributeError(f"group {self.name!r} has no quantity {name!r}")


TIME = Quantity("t", "s", "time")
"""Time: `TIME.symbol` stands in references, in laws, and in all of the plant that is a function of the state."""

_EDGE = 10**15
"""Its inverse is the relative advance of an edge, 5 spacings of a double: time, period, their quotient and this factor
are each rounded by at most half a spacing. Half as much would just cover that; a tick is early by
mistake only where it and the edge have denominators beyond 10^7 times 10^7."""


def whole_periods(period: sp.Expr) -> sp.Expr:
    """Return how many whole periods have passed at time t, for references that switch.

    The whole part of t / period alone is one short at a tick that falls on an edge where the division rounds down:
    0.3 / 0.1 is below 3. This is right at every tick.

    Parameters
    ----------
    period : Expr
        Longer than zero, s.
    """
    import sympy as sp

    return sp.floor(TIME.symbol / period * sp.Rational(_EDGE + 1, _EDGE))


def scalar(quantity: Quantity) -> Group:
    """Wrap one quantity as a scalar argument.

    Parameters
    ----------
    quantity : Quantity
        What the argument is.
    """
    if not isinstance(quantity, Quantity):
        raise wrong("quantity", quantity, "a Quantity")
    return Group(quantity.name, (quantity,))


EMPTY = Group("", ())
"""A group without quantities."""

LARGEST = 10**30
"""Beyond it a number is neither a measurement nor a command, in whatever unit: `Abs(x) < LARGEST` asks whether x is
finite. It and its sums are finite in single precision, up to 3e38."""
