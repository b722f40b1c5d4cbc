# SPDX-License-Identifier: Apache-2.0
"""Numbers of a part: each field becomes one or more parameters named after the part.

A part declares a field as `Annotated[Number, scalar(...)]`, or with `place`, `vector`, `direction` or `tensor`. A
number that the user gives becomes the default of a parameter; an expression in parameters is used unchanged. A zero
in a vector or tensor is structural and enters no equation.
"""

from __future__ import annotations

import inspect
import math
from abc import ABCMeta
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Annotated, Any, TypeAlias, TypeVar, get_args, get_type_hints

import sympy as sp

from mehvar.base.errors import suggestion, value_text
from mehvar.base.intervals import Interval

from ..arrays import Tensor as Array
from ..derivation import Expr
from ..quantities import ModelError, Parameter, ParameterArray
from ..system import Condition
from .frame import AXES


@dataclass(frozen=True)
class Value:
    """A number with its unit, bounds, source and description.

    Parameters
    ----------
    default : float
        In the unit of the field.
    bounds : str
        Allowed values, as in "(0, 3]", among those of the field; all of these when empty.
    source : str
        Where the number comes from, such as a data sheet.
    """

    default: float
    bounds: str = ""
    source: str = ""


Form = TypeVar("Form")
Number: TypeAlias = float | Value | sp.Expr
Vector: TypeAlias = Sequence[Number]
Tensor: TypeAlias = Sequence[Number] | Sequence[Sequence[Number]]


_LABELS = {"scalar": ("",), "vector": (*AXES,), "direction": (*AXES,), "tensor": ("xx", "xy", "yy", "xz", "yz", "zz")}
"""Numbers of a field of each form: ends of the names of their parameters."""
_DEPTHS = {"scalar": 0, "vector": 1, "direction": 1, "tensor": 2}


@dataclass(frozen=True)
class Kind:
    """Form of a field, "scalar", "vector", "direction" or "tensor", with symbol, unit, meaning and bounds.

    `absent` is the value of a field that is None; `across` names the direction to which a direction is not parallel.
    """

    form: str
    symbol: str
    unit: str
    meaning: str
    bounds: str = "(-inf, inf)"
    absent: Expr | sp.Matrix | None = None
    across: str = ""

    def numbers(self, value: Any, where: str) -> dict[str, Any]:
        """Return the given numbers of a field by their labels; refuse another shape."""
        if self.form == "scalar":
            return {"": value}
        if self.form != "tensor":
            return dict(zip(AXES, listed(value, where, 3), strict=True))
        if not isinstance(value, Sequence) or isinstance(value, str):
            raise ModelError(f"{where} = {value_text(value)}: must be three moments, or three rows")
        if not all(isinstance(entry, Sequence) for entry in value):
            return dict(zip(("xx", "yy", "zz"), listed(value, where, 3), strict=True))
        rows = [listed(row, where, 3) for row in listed(value, where, 3)]
        for i, j in ((1, 0), (2, 0), (2, 1)):
            if rows[i][j] != rows[j][i]:
                raise ModelError(f"{where}: entry {i + 1}, {j + 1} differs from {j + 1}, {i + 1}; must be symmetric")
        return {label: rows[AXES.index(label[1])][AXES.index(label[0])] for label in _LABELS["tensor"]}

    def value(self, numbers: Mapping[str, Expr]) -> Any:
        """Return the number, the column or the symmetric matrix of numbers by their labels."""
        if self.form == "scalar":
            return numbers[""]
        if self.form != "tensor":
            return sp.Matrix([numbers[axis] for axis in AXES])
        entries = {**numbers} | {label[::-1]: number for label, number in numbers.items()}
        return sp.Matrix(3, 3, lambda i, j: entries.get(AXES[i] + AXES[j], sp.S.Zero))

    def entry(self, label: str) -> Kind:
        """Return the kind of one number: a moment of inertia is positive, a product has any sign."""
        if self.form == "scalar":
            return self
        bounds = "(0, inf)" if self.form == "tensor" and label[0] == label[1] else self.bounds
        return Kind("scalar", f"{self.symbol}{label}", self.unit, f"{self.meaning}, {label}", bounds)


def scalar(symbol: str, unit: str, meaning: str, bounds: str = "(0, inf)", absent: float | Expr | None = None) -> Kind:
    """Declare a number; a field that may be None omits its terms, or has the value `absent` in them."""
    return Kind("scalar", symbol, unit, meaning, bounds, None if absent is None else sp.sympify(absent))


def place(symbol: str, meaning: str) -> Kind:
    """Declare a point in hub axes, m."""
    return Kind("vector", symbol, "m", meaning)


def vector(symbol: str, unit: str, meaning: str, absent: float | None = None) -> Kind:
    """Declare three numbers in hub axes; those of a field that is None are `absent`."""
    return Kind("vector", symbol, unit, meaning, absent=None if absent is None else sp.Matrix([absent] * 3))


def direction(symbol: str, meaning: str, across: str = "") -> Kind:
    """Declare a direction in hub axes, of any length; `across` names the field to which it must not be parallel."""
    return Kind("direction", symbol, "1", meaning, across=across)


def tensor(symbol: str, meaning: str) -> Kind:
    """Declare an inertia, kg m^2: three principal moments, or rows of a symmetric matrix."""
    return Kind("tensor", symbol, "kg m^2", meaning)


@dataclass(frozen=True)
class Rows:
    """Declaration of a field that is a list of records with fields of their own, at least one, such as modes."""

    of: type


def kinds(part: object) -> dict[str, Kind]:
    """Return the declared fields of a part or a class of parts, by name; `units` of a part prevail."""
    units = {} if isinstance(part, type) else getattr(part, "units", {})
    return {name: replace(kind, unit=units.get(name, kind.unit)) for name, kind in _declared(part, Kind).items()}


def records(part: object) -> dict[str, type]:
    """Return the fields of a part or a class of parts that are lists of records, with their class."""
    return {name: rows.of for name, rows in _declared(part, Rows).items()}


def _declared(part: object, form: type[Form]) -> dict[str, Form]:
    return {name: a for name, hint in _hints(part).items() for a in get_args(hint) if isinstance(a, form)}


def _hints(part: object) -> dict[str, Any]:
    words = {"Annotated": Annotated, **globals()}  # for a part that is defined where no module is, as by exec
    return get_type_hints(part if isinstance(part, type) else type(part), localns=words, include_extras=True)


def _is_optional(hint: Any) -> bool:
    """Return True for the hint of a field that may be None, as in Annotated[Number | None, scalar(...)]."""
    return type(None) in get_args(get_args(hint)[0])


class Complete(ABCMeta):
    """Metaclass of parts and their pieces, which refuses a call without a needed field, or with an unknown one."""

    def __call__(cls, *args: Any, **given: Any) -> Any:
        """Return an instance.

        Raises
        ------
        ModelError
            With the missing field and its unit, the unknown field, or the missing method.
        """
        if methods := sorted(cls.__abstractmethods__):
            raise ModelError(f"{cls.__name__} is not a complete part: it lacks the method {methods[0]}; write it")
        signature = inspect.signature(cls.__init__)  # type: ignore[misc]  # that of this class
        declared = list(signature.parameters.values())[1:]
        usual = next((p.default for p in declared if p.name == "name" and p.default is not p.empty), None)
        where = given.get("name", next((of for of, p in zip(args, declared, strict=False) if p.name == "name"), usual))
        try:
            have = signature.bind_partial(None, *args, **given).arguments
        except TypeError as error:
            unknown = next((name for name in given if name not in signature.parameters), None)
            if unknown is None:
                raise ModelError(f"{where or cls.__name__}: {error}") from error
            near = suggestion(unknown, signature.parameters)
            raise ModelError(f"{where or cls.__name__}: {unknown!r} is not a field of {cls.__name__}{near}") from error
        fields, hints = kinds(cls), _hints(cls)
        for name in fields.keys() & have.keys():
            if not isinstance(have[name], str):  # a part may read a text, such as a date
                check_numbers(fields[name], have[name], f"{where or cls.__name__}.{name}")
        for p in declared:
            kind, value = fields.get(p.name), have.get(p.name, p.default)
            nothing = kind is not None and value is None and not _is_optional(hints[p.name])
            if nothing or (value is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)):
                what = f": {kind.meaning}{'' if kind.unit == '1' else f', {kind.unit}'}" if kind else ""
                raise ModelError(f"{where or cls.__name__}.{p.name} is missing; write it into the call{what}")
        part = super().__call__(*args, **given)
        for name in records(cls):
            if not getattr(part, name):
                raise ModelError(f"{where}.{name}: must have at least one {name.removesuffix('s')}")
        return part


class Parameters:
    """Parameters of an assembly, in the order of declaration."""

    def __init__(self, quantities: Mapping[str, Parameter] | None = None) -> None:
        self.quantities = dict(quantities or {})

    def add(
        self, name: str, value: float | Value, unit: str, meaning: str, bounds: str, array: ParameterArray | None = None
    ) -> sp.Symbol:
        """Declare a parameter and return its symbol.

        Raises
        ------
        ModelError
            If the value is no number or out of bounds, or its bounds are wider than those of the field.
        """
        given = value if isinstance(value, Value) else Value(value)
        try:
            interval: Interval = Interval.parse(given.bounds or bounds)
        except ValueError as error:
            raise ModelError(f"{name}: {error}") from error
        if interval.common(field := Interval.parse(bounds)) != interval and given.bounds != bounds:
            raise ModelError(f"{name}: bounds {interval}: must lie within {field}, {unit} ({meaning})")
        if isinstance(given.default, sp.Expr) or not _is_finite(given.default) or given.default not in interval:
            raise ModelError(
                f"{name} = {value_text(given.default)}: must be a number in {interval}, {unit} ({meaning})"
            )
        parameter = Parameter(
            name, unit, meaning, positive=interval.positive, default=float(given.default), bounds=interval,
            source=given.source, array=array,
        )  # fmt: skip
        if self.quantities.setdefault(name, parameter) != parameter:
            raise ModelError(f"parameter {name} is declared twice")
        return parameter.symbol

    def column(self, kind: Kind, name: str, values: Sequence[Number], form: str = "") -> list[Expr]:
        """Declare an array of parameters, NAME_1, NAME_2, ..., and return their symbols; `form` as of a `Tensor`."""
        array = Array(name, (len(values),), form)
        return [
            self.add(f"{name}_{k}", value, kind.unit, f"{kind.meaning}, element {k}", kind.bounds, array)
            for k, value in enumerate(values, 1)
        ]

    def of(self, part: Any, name: str) -> SimpleNamespace:
        """Return the symbols or numbers of a part's declared fields; `given_directions` has those of any length.

        Parameters
        ----------
        part : dataclass
            With fields declared by `scalar`, `place`, `direction` and `tensor`.
        name : str
            Start of the names of its parameters.
        """
        fields = kinds(part)
        read = {f: self._read(k, name, getattr(part, f), f"{name}.{f}") for f, k in fields.items()}
        for f, k in fields.items():
            if k.across:
                _check_across(f"{name}.{f}", getattr(part, f), k.across, getattr(part, k.across))
        for f in records(part):
            read[f] = [self.of(row, f"{name}_{k}") for k, row in enumerate(getattr(part, f), 1)]
        given = {f: read[f] for f, k in fields.items() if k.form == "direction" and read[f] is not None}
        return SimpleNamespace(**read | {f: unit(vector) for f, vector in given.items()}, given_directions=given)

    def _read(self, kind: Kind, name: str, value: Any, where: str) -> Any:
        """Return a field as a symbol, a column or a matrix of symbols."""
        if value is None:
            return kind.absent
        value = plain(value)
        check_numbers(kind, value, where)
        numbers = kind.numbers(value, where)
        if kind.form == "direction":
            entries = list(numbers.values())
            _check_length(entries, where)
            if (along := _axis(entries)) is not None:
                return along
        return kind.value({
            label: sp.S.Zero if label and entry == 0 else self.number(kind.entry(label), name, entry)
            for label, entry in numbers.items()
        })  # fmt: skip

    def number(self, kind: Kind, part: str, value: Number) -> Expr:
        """Declare a number of a part and return its symbol; an expression stays, with the bounds of the field."""
        name = f"{part}_{kind.symbol}"
        if not isinstance(value, sp.Expr):
            return self.add(name, value, kind.unit, kind.meaning, kind.bounds)
        if value.is_number:
            check_numbers(kind, value, name)
            Parameters().add(name, float(value), kind.unit, kind.meaning, kind.bounds)
        elif (shared := self.quantities.get(str(value))) and shared.symbol == value:
            self._narrow(shared, kind, f"{name} ({kind.meaning})")
        return value

    def _narrow(self, shared: Parameter, kind: Kind, user: str) -> None:
        """Limit a shared parameter to the bounds of a field that uses it; its symbol keeps its assumptions."""
        bounds = shared.bounds.common(Interval.parse(kind.bounds))
        if bounds is None:
            raise ModelError(
                f"{shared.name}: its bounds {shared.bounds} allow no value in {kind.bounds}, as {user} needs"
            )
        if float(shared.default) not in bounds:
            raise ModelError(
                f"{shared.name} = {shared.default!r}: must be in {bounds}, {kind.unit}, for its use as {user}"
            )
        self.quantities[shared.name] = replace(shared, bounds=bounds)


def generic(values: SimpleNamespace, declared: Mapping[str, Kind]) -> tuple[SimpleNamespace, dict[str, set[sp.Symbol]]]:
    """Return values with new symbols for all numbers of given fields, also for zeros; and these symbols by field."""
    result, symbols = SimpleNamespace(**vars(values)), {}
    for name, kind in declared.items():
        if getattr(values, name, None) not in (None, kind.absent):
            numbers = {label: sp.Symbol(f"any_{name}_{label}", positive=True) for label in _LABELS[kind.form]}
            setattr(result, name, kind.value(numbers))
            symbols[name] = set(numbers.values())
    return result, symbols


def listed(value: Any, where: str, count: int) -> Sequence[Any]:
    """Return a number of entries as a list; refuse any other number of them."""
    if isinstance(value, str) or not isinstance(value, Sequence | sp.MatrixBase) or len(value) != count:
        raise ModelError(f"{where} = {value_text(value)}: must be {count} numbers")
    return [plain(entry) for entry in value]


def constant(entry: Any) -> float | None:
    """Return a given number as a float; None for an expression, and for what is refused later."""
    try:
        return float(entry.default if isinstance(entry, Value) else entry)
    except (TypeError, ValueError):
        return None


def plain(value: Any) -> Any:
    """Return an array or a number of NumPy as Python's, and any other value unchanged."""
    return value.tolist() if hasattr(value, "tolist") and not isinstance(value, sp.Basic | sp.MatrixBase) else value


def check_numbers(kind: Kind, value: Any, where: str) -> None:
    """Refuse a field with an entry that is not a finite number, such as nan, inf, a truth value or a text.

    Raises
    ------
    ModelError
        With the field, its value and what is allowed.
    """
    given = plain(value)
    if value is None or all(map(_is_finite, _leaves(given, _DEPTHS[kind.form]))):
        return
    what = "a number" if kind.form == "scalar" else "numbers"
    allowed = f"must be {what} in {kind.bounds}, {kind.unit} ({kind.meaning})"
    raise ModelError(f"{where} = {value_text(given)}: {allowed}")


def _leaves(value: Any, depth: int) -> Iterator[Any]:
    """Yield a number, the entries of a vector, or those of its rows."""
    if depth and isinstance(value, Sequence | sp.MatrixBase) and not isinstance(value, str):
        for entry in value:
            yield from _leaves(plain(entry), depth - 1)
    else:
        yield value.default if isinstance(value, Value) else value


def _is_finite(number: object) -> bool:
    """Return True for a finite number, and for an expression in parameters."""
    if isinstance(number, bool) or not isinstance(number, int | float | sp.Expr):
        return False
    try:
        return (isinstance(number, sp.Expr) and not number.is_number) or math.isfinite(float(number))
    except (TypeError, OverflowError):  # a complex number, or an integer of 400 digits
        return False


def _axis(entries: Sequence[Any]) -> sp.Matrix | None:
    """Return the unit vector of a direction along an axis; None for any other direction."""
    nonzero = [k for k in range(3) if entries[k] != 0]
    if len(nonzero) != 1 or isinstance(entries[nonzero[0]], sp.Expr | Value):
        return None
    result = sp.zeros(3, 1)
    result[nonzero[0]] = 1 if entries[nonzero[0]] > 0 else -1
    return result


def _check_length(entries: Sequence[Any], where: str) -> None:
    """Refuse a direction whose squared length is zero or infinite; one with expressions is not checked."""
    if any(isinstance(entry, sp.Expr) and not entry.is_number for entry in entries):
        return
    length = math.hypot(*(float(entry.default if isinstance(entry, Value) else entry) for entry in entries))
    if not length:
        raise ModelError(f"{where}: must not be zero")
    if not _SHORTEST <= length <= 1 / _SHORTEST:
        raise ModelError(f"{where} = {value_text(tuple(entries))}: {LENGTHS}")


def _check_across(where: str, value: Any, axis: str, other: Any) -> None:
    """Refuse a direction parallel to another; symbolic directions are not checked."""
    vectors = plain(value), plain(other)
    one, two = (sp.Matrix([x for x in map(constant, vector) if x is not None]) for vector in vectors)
    if len(one) == len(two) == 3 and one.cross(two).norm() <= _PARALLEL * one.norm() * two.norm():
        raise ModelError(f"{where} = {vectors[0]!r}: must not be along {axis} = {vectors[1]!r}")


_PARALLEL = 1e-9
"""Sine below which an angle counts as zero; above the rounding of numbers with ten digits."""
_SHORTEST = 1e-150
"""Shortest direction, and the inverse of the longest: squares of others are no numbers with all digits."""
LENGTHS = f"must have a length from {_SHORTEST:g} to {1 / _SHORTEST:g}"


def unit(vector: sp.Matrix) -> sp.Matrix:
    """Return a vector scaled to length one."""
    return vector / sp.sqrt(vector.dot(vector))


def conditions(part: object, name: str, values: SimpleNamespace) -> tuple[Condition, ...]:
    """Return the conditions on symbolic values of a part: bounds, lengths and angles of directions, real inertias."""
    result: list[Condition] = []
    declared, directions = kinds(part), values.given_directions
    for field in records(part):
        for k, (row, of) in enumerate(zip(getattr(part, field), getattr(values, field), strict=True), 1):
            result += conditions(row, f"{name}_{k}", of)
    for field, kind in declared.items():
        value = getattr(values, field, None)
        if value is None:
            continue
        where = f"{name}.{field}, with"
        if kind.form == "tensor":
            text = f"{where} {parameters_text(value.free_symbols)}, {NO_BODY}"
            result += (Condition(margin, text) for margin in of_a_body(value))
        elif kind.form == "direction" and (given := directions.get(field)):
            text = f"{where} {parameters_text(given.free_symbols)}: {LENGTHS}"
            result += (Condition(margin, text) for margin in of_a_direction(given))
        elif kind.form == "scalar" and not value.is_Symbol:
            text = f"{name}.{field} = {value}, with {parameters_text(value.free_symbols)}: must be in {kind.bounds}"
            result += (Condition(margin, text) for margin in _within(value, Interval.parse(kind.bounds)))
    for field, kind in declared.items():
        if kind.across:
            one, other = directions[field], directions[kind.across]
            symbols, normal = one.free_symbols | other.free_symbols, unit(one).cross(unit(other))
            text = f"{name}.{field}, with {parameters_text(symbols)}: must not be along {kind.across}"
            result.append(Condition(normal.dot(normal) - sp.Float(_PARALLEL**2), text))
    return tuple(condition for condition in result if condition.margin.free_symbols)


def parameters_text(symbols: Iterable[sp.Symbol]) -> str:
    """Return the text that shows values of parameters in a message."""
    return ", ".join(f"{name} = {{{name}:g}}" for name in sorted(map(str, symbols)))


NO_BODY = "is the inertia of no body: no moment may exceed the sum of the other two, in any axes"


def _within(value: Expr, bounds: Interval) -> Iterator[Expr]:
    """Yield margins that are positive if a value is in an interval."""
    for end, sign, beyond in ((bounds.lower, 1, bounds.lower_open), (bounds.upper, -1, bounds.upper_open)):
        if math.isfinite(end):
            margin = sign * (value - (int(end) if end.is_integer() else end))
            yield margin if beyond else sp.Piecewise((1, margin >= 0), (-1, True))


def of_a_direction(vector: sp.Matrix) -> tuple[Expr, Expr]:
    """Return margins that are positive if the length of a vector has all digits."""
    square, least = vector.dot(vector), sp.Float(_SHORTEST**2)
    return square - least, 1 / least - square


def of_a_body(inertia: sp.Matrix) -> list[Expr]:
    """Return margins that are positive if J is the inertia of a real body, whose second moments are tr(J)/2 - J.

    A flat body, with one second moment of zero, is allowed by a small tolerance.
    """
    size = inertia.trace()
    moments = size / 2 * sp.eye(3) - inertia + _FLAT * size * sp.eye(3)
    if inertia.is_diagonal():
        return [moments[k, k] for k in range(3)]
    pairs = [moments.extract([i, j], [i, j]).det() for i, j in ((0, 1), (0, 2), (1, 2))]
    return [*(moments[k, k] for k in range(3)), *pairs, moments.det()]


_FLAT = sp.Rational(1, 10**9)
"""Tolerance relative to the trace, far above rounding and far below any real contribution."""


def directions(part: Any) -> list[str]:
    """Return the names of a part's direction fields."""
    return [name for name, kind in kinds(part).items() if kind.form == "direction"]
