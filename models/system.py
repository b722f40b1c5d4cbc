# SPDX-License-Identifier: Apache-2.0
"""The vocabulary of a model: what a system, a control law and a scenario are made of.

Everything here is a small frozen dataclass. A model builds one `System`; code generation reads it and
knows nothing else about the model.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

Expr = sp.Expr


class ModelError(ValueError):
    """A mistake in a model's text: a derivation, a parameter table or a scenario table."""


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
    """

    name: str
    unit: str
    description: str
    latex: str = ""
    positive: bool = False

    @property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of this quantity."""
        return sp.Symbol(self.name, positive=True) if self.positive else sp.Symbol(self.name, real=True)


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
        """Whether every allowed value is above zero."""
        return self.lower > 0 or (self.lower == 0 and self.lower_open)


@dataclass(frozen=True)
class Parameter(Quantity):
    """A number that the user may change: an input of the generated functions, never a constant in them.

    Parameters
    ----------
    default : float or str, optional
        The value, or a formula in other parameters of the same group.
    bounds : Interval
        Allowed values.
    source : str
        Where the number comes from: "paper ...", "assumption: ..." or "addition: ...".
    """

    default: float | str = 0.0
    bounds: Interval = field(default_factory=lambda: Interval(-float("inf"), float("inf"), True, True))
    source: str = ""


@dataclass(frozen=True)
class Definition:
    """A named step of a derivation, in the order a reader would take it.

    Parameters
    ----------
    symbol : sympy.Symbol
        The name given to the expression; later expressions refer to it.
    expr : sympy.Expr
        What it stands for.
    number : str
        Equation number of the paper, "(20)"; empty for a step of our own.
    title : str
        What it is, in a few words.
    section : str
        Heading under which it is printed.
    unit : str
        SI unit.
    latex : str
        How the symbol is printed.
    """

    symbol: sp.Symbol
    expr: Expr
    number: str
    title: str
    section: str
    unit: str
    latex: str


@dataclass(frozen=True)
class Equation:
    """A derived result that is shown and compared but not evaluated, such as a differential equation."""

    left: str
    expr: Expr
    number: str
    title: str
    section: str
    unit: str


class Derivation:
    """An ordered list of definitions and equations under section headings."""

    def __init__(self) -> None:
        self.steps: list[Definition | Equation] = []
        self._section = ""
        self._names: set[str] = set()

    @property
    def definitions(self) -> dict[sp.Symbol, Expr]:
        """The definitions made so far, by symbol."""
        return {step.symbol: step.expr for step in self.steps if isinstance(step, Definition)}

    def section(self, title: str) -> None:
        """Start a new heading."""
        self._section = title

    def define(
        self,
        name: str,
        expr: Expr | float,
        number: str = "",
        title: str = "",
        unit: str = "1",
        latex: str = "",
        positive: bool = False,
    ) -> sp.Symbol:
        """Name an expression and return its symbol for use in later steps.

        Raises
        ------
        ModelError
            If the name has been used before.
        """
        if name in self._names:
            raise ModelError(f"definition {name!r} is made twice")
        self._names.add(name)
        quantity = Quantity(name, unit, title, latex, positive)
        definition = Definition(
            quantity.symbol, sp.sympify(expr), number, title, self._section, unit, latex or sp.latex(quantity.symbol)
        )
        self.steps.append(definition)
        return quantity.symbol

    def show(self, left: str, expr: Expr, number: str = "", title: str = "", unit: str = "1") -> None:
        """Record a derived equation `left = expr` (left in LaTeX) that no function evaluates by itself."""
        self.steps.append(Equation(left, sp.sympify(expr), number, title, self._section, unit))


@dataclass(frozen=True)
class Group:
    """Quantities that travel together as one vector, such as the state or the plant's parameters."""

    name: str
    quantities: tuple[Quantity, ...]

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """The SymPy symbols in order."""
        return tuple(q.symbol for q in self.quantities)

    def __getattr__(self, name: str) -> sp.Symbol:
        for quantity in object.__getattribute__(self, "quantities"):
            if quantity.name == name:
                return quantity.symbol
        raise AttributeError(f"group {self.name!r} has no quantity {name!r}")


@dataclass(frozen=True)
class Function:
    """A model's own public function, such as rod lengths from shape.

    Parameters
    ----------
    name : str
        Name in C and Python.
    arguments : tuple of Group
        Groups of one quantity are scalars.
    results : tuple of (Quantity, Expr)
        What it returns, in order.
    vector : str
        When not empty the results come as one vector of this name instead of a tuple of scalars.
    description : str
        One line for people.
    """

    name: str
    arguments: tuple[Group, ...]
    results: tuple[tuple[Quantity, Expr], ...]
    description: str
    vector: str = ""


@dataclass(frozen=True)
class Coordinates:
    """A chart without the singularities of the paper's, in which continuous loops are integrated.

    Parameters
    ----------
    states, inputs : Group
        The regular coordinates q and the inputs n that go with them.
    rhs : tuple of Expr
        q' as a function of q, n and the plant's parameters.
    from_state, from_input : tuple of Expr
        q as a function of the state x; n as a function of x and the input u.
    to_state, to_input : tuple of Expr
        The state x as a function of q; the input u as a function of q and n.
    """

    states: Group
    inputs: Group
    rhs: tuple[Expr, ...]
    from_state: tuple[Expr, ...]
    from_input: tuple[Expr, ...]
    to_state: tuple[Expr, ...]
    to_input: tuple[Expr, ...]


@dataclass(frozen=True)
class Condition:
    """Something that must stay positive.

    Parameters
    ----------
    margin : Expr
        Allowed while greater than zero.
    message : str
        Said when it is not; `{name}` is replaced by the value of that parameter.
    """

    margin: Expr
    message: str


@dataclass(frozen=True)
class Controller:
    """A control law as a symbolic function (measurement, reference) -> input.

    Parameters
    ----------
    name, title : str
        Identifier and one line for people.
    parameters : Group
        The law's own parameters.
    command : tuple of Expr
        Inputs of the coordinates in which loops are integrated, as a function of coordinates,
        reference, plant parameters and law parameters.
    constraints : tuple of Condition
        What plant, law and scenario parameters must satisfy before a run.
    """

    name: str
    title: str
    parameters: Group
    command: tuple[Expr, ...]
    constraints: tuple[Condition, ...] = ()


@dataclass(frozen=True)
class Metric:
    """A number that sums up a run.

    Parameters
    ----------
    name, kind, unit, description : str
        `kind` is one of settling, max, min, max_abs, travel, sign_changes, final.
    of : tuple of str
        Variables of the result.
    band : float
        Settling band or dead band, in the unit of the variables.
    """

    name: str
    kind: str
    of: tuple[str, ...]
    unit: str
    description: str
    band: float = 0.0


@dataclass(frozen=True)
class Scenario:
    """A run that the paper or we describe: values, duration and the numbers it is expected to show.

    Parameters
    ----------
    name, title : str
        Identifier and one line for people.
    duration, step : float
        Length of the run and sampling step of its result, s.
    values : mapping of str to float
        Plant and scenario parameters that differ from their defaults.
    controllers : mapping of str to mapping
        Law parameters that differ from their defaults, per law.
    expect : mapping of str to mapping
        Expected metrics per law.
    """

    name: str
    title: str
    duration: float
    step: float
    values: Mapping[str, float]
    controllers: Mapping[str, Mapping[str, float]]
    expect: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class System:
    """A mechanical system with its laws and scenarios, ready for code generation.

    Parameters
    ----------
    name, title, source : str
        Identifier, one line for people, and the publication.
    structure : mapping
        The structural choices this system was derived with.
    states, inputs, references, outputs : Group
        x, u, r and y.
    parameters, scenario_parameters : Group
        p and s.
    rhs : tuple of Expr
        x' as a function of x, u, p.
    output : tuple of Expr
        y as a function of x, u, r, p.
    steps : tuple
        The derivation, in order.
    limits : tuple of Condition
        What must hold along a run, as a function of x and p.
    initial : tuple of Expr
        x(0) as a function of p and s.
    reference : tuple of Expr
        r as a function of time and s.
    constraints : tuple of Condition
        What plant and scenario parameters must satisfy.
    functions : tuple of Function
        Further public functions.
    coordinates : Coordinates, optional
        Regular chart for continuous loops.
    """

    name: str
    title: str
    source: str
    structure: Mapping[str, Any]
    states: Group
    inputs: Group
    references: Group
    outputs: Group
    parameters: Group
    scenario_parameters: Group
    rhs: tuple[Expr, ...]
    output: tuple[Expr, ...]
    steps: tuple[Definition | Equation, ...]
    limits: tuple[Condition, ...]
    initial: tuple[Expr, ...]
    reference: tuple[Expr, ...]
    constraints: tuple[Condition, ...]
    functions: tuple[Function, ...]
    controllers: tuple[Controller, ...]
    scenarios: tuple[Scenario, ...]
    metrics: tuple[Metric, ...]
    coordinates: Coordinates | None = None

    @property
    def definitions(self) -> dict[sp.Symbol, Expr]:
        """Every definition of the derivation, by symbol."""
        return {step.symbol: step.expr for step in self.steps if isinstance(step, Definition)}


TIME = Quantity("t", "s", "time")


def scalar(quantity: Quantity) -> Group:
    """Wrap one quantity as a scalar argument."""
    return Group(quantity.name, (quantity,))


def free_symbols(expressions: Iterable[Expr], definitions: Mapping[sp.Symbol, Expr]) -> set[sp.Symbol]:
    """Return the symbols that expressions depend on, definitions followed to their ends."""
    seen: set[sp.Symbol] = set()
    stack = [s for e in expressions for s in sp.sympify(e).free_symbols]
    while stack:
        symbol = stack.pop()
        if symbol not in seen:
            seen.add(symbol)
            if symbol in definitions:
                stack.extend(definitions[symbol].free_symbols)
    return {s for s in seen if s not in definitions}
