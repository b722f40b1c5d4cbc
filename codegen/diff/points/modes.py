# SPDX-License-Identifier: Apache-2.0
"""Names whose values may stay exactly on a threshold, where `<` and `<=` differ.

A moving state passes a threshold in an instant but may stay where it starts. Parameters, and modes (states that only
resets change), can stay on a threshold. A law's memory, references and held inputs can stay on one for a sample or
more, mostly at a whole number.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ...equal.branches import BRANCHING, COMPARISONS
from ...equal.meaning import Expression, Meaning
from ...equal.points import differ
from ...equal.reals import vanishes
from ...equal.verdicts import Verdict
from ...equations.document import Document, reached

if TYPE_CHECKING:
    from ..versions import Item, Versions

_POINTS = 16
"""Number of points for each value of a mode, at which the other names are drawn."""
_FEW = 4
"""Number of parameter values that are tried; one difference suffices."""
_MOST_JOINT = 32
"""Largest number of combinations of modes; beyond it, each mode is varied alone."""
_WHOLE = tuple(map(Fraction, range(4)))
"""Values of a count that are tried, for parameters inside of steps such as `floor`."""
_HELD = ("memory", "reference", "input", "command", "commanded", "applied", "time")
"""Roles of names whose values a sampled law or its user holds constant."""
_LARGEST = 10**6
"""Largest numerator and denominator of a threshold; those of random numbers are longer."""

Fixed = Mapping[str, Fraction]


class Modes:
    """Modes and states with the values that starts and resets give them; parameters and held names.

    Parameters
    ----------
    versions : Versions
        Rows of both sides.
    """

    def __init__(self, versions: Versions) -> None:
        self._equality = versions.equality
        self._pool = versions.pool
        self._free = Meaning(self._pool, lambda _: None)
        self._symbols = versions.declared
        self._may_be = versions.may_be
        constant = _constant(versions.old) & _constant(versions.new)
        self._values: dict[str, set[Fraction]] = {name: set() for name in constant}
        self._open: set[str] = set()
        """Modes that a reset sets to an expression, such as 1 - mode."""
        self._starts: dict[str, set[Fraction]] = {}
        """Initial numbers of the other states, with default parameters."""
        for item in (*versions.olds, *versions.news):
            if item.row.kind not in ("initial", "reset"):
                continue
            name = _state(item)
            value = versions.pool.constant(item.root)
            if name not in self._values:
                self._starts.setdefault(name, set()).update(self._default(item.root) if value is None else {value})
            elif value is not None:
                self._values[name].add(value)
            elif item.row.kind == "reset":
                self._open.add(name)
        self._start_points = self._starts_of(versions)

    def at_start(self, old: Expression, new: Expression) -> Verdict | None:
        """Return "undecided" if two expressions differ at a possible start of a run or after a reset there.

        The test uses default parameters, and each finite bound in turn. A side without a value counts as different,
        such as (a^2 - b^2)/(a - b) at a = b.
        """
        left, right = ((self._free, self._equality.written_out(side)) for side in (old, new))
        names = sorted({*self._free.free(left[1]), *self._free.free(right[1])})
        for start, event in self._start_points:
            for fixed in ({}, *self._at_bounds(names)):
                point = {**start, **fixed}
                if self._unlike(point, left, right):
                    place = {name: point[name] for name in names if name in fixed or not self._is_parameter(name)}
                    where = "at a bound where a run starts" if fixed else "where a run starts"
                    where = f"{where}, after the resets of {event}" if event else where
                    return Verdict(None, f"they differ at {_text(place or point)}, {where}")
        return None

    def _unlike(self, point: Fixed, left: Expression, right: Expression) -> bool:
        """Return True if only one side is defined at a point, or if both sides have different values."""
        world = self._equality.real.stepped(point)[self._free]
        one, other = (world.defined(side[1]) is None for side in (left, right))
        return one != other or differ(self._equality.real.stepped(point), left, right)

    def _at_bounds(self, names: list[str]) -> Iterator[Fixed]:
        """Yield each finite bound that a parameter may have."""
        for name in filter(self._is_parameter, names):
            for bounds in {symbol.interval for symbol in self._symbols[name]}:
                ends = (bounds.lower, bounds.lower_open), (bounds.upper, bounds.upper_open)
                values = [Fraction(str(end)) for end, is_open in ends if not is_open and math.isfinite(end)]
                yield from ({name: value} for value in values if self._may_be(name, value))

    def _starts_of(self, versions: Versions) -> list[tuple[dict[str, Fraction], str]]:
        """Return the states after each event, and the start of a run, of both sides with default parameters.

        Each point has the name of its event; a start has none.
        """
        names = self._equality.sampler.names
        usual = {name: Fraction(row[2]) for name, row in names.items() if row[2] is not None and row[2] == row[2]}
        base = {**self._equality.sampler.point(0), **usual} | dict.fromkeys({"t", "clock"} & names.keys(), Fraction(0))
        points: list[tuple[dict[str, Fraction], str]] = []
        for items, meaning in ((versions.olds, versions.before), (versions.news, versions.after)):
            rows = {kind: [item for item in items if item.row.kind == kind] for kind in ("initial", "reset")}
            start = self._set(base, rows["initial"], meaning)
            points.append((start, ""))
            resets: dict[str, list[Item]] = {}
            for item in rows["reset"]:
                resets.setdefault(item.name.rpartition(": ")[0], []).append(item)
            points += [(self._set(start, resets[event], meaning), event) for event in resets]
        return [point for number, point in enumerate(points) if point not in points[:number]]

    def _set(self, point: dict[str, Fraction], items: list[Item], meaning: Meaning) -> dict[str, Fraction]:
        """Return a point whose states have the values of starts or resets."""
        world = self._equality.real.stepped(dict(point))[self._free]
        values = {}
        for item in items:
            value = world.defined(self._equality.written_out((meaning, item.root)))
            if value is not None:
                values[_state(item)] = Fraction(str(value))
        return {**point, **values}

    def at_thresholds(self, old: Expression, new: Expression) -> Verdict | None:
        """Return a verdict if two expressions differ at a threshold on which a name may stay, else None.

        The verdict is "undecided" if it is open whether the name can have the value.
        """
        left, right = ((self._free, self._equality.written_out(side)) for side in (old, new))
        jumps = self._jumps(left) ^ self._jumps(right)
        if not jumps:
            return None
        names = sorted({*self._free.free(left[1]), *self._free.free(right[1])})
        joint = list(self._joint(names))
        for fixed in joint:
            if point := self._witness(left, right, fixed, _POINTS):
                how = f"they differ at {_text(fixed)}, which a reset sets"
                return Verdict(False, how, point={each: point[each] for each in names})
        for name in names:
            for fixed in joint or [{}]:
                for value in sorted(self._numbers(name, jumps, fixed)):
                    if self._witness(left, right, {**fixed, name: value}, _FEW):
                        return self._on_threshold(name, value)
        return None

    def _on_threshold(self, name: str, value: Fraction) -> Verdict:
        if name in self._open:
            return Verdict(None, f"they differ at {name} = {value}, which a reset may set")
        if name in self._starts:
            return Verdict(None, f"they differ at {name} = {value}, its value at the start, where it may stay")
        usual = self._equality.sampler.names[name][2] == value
        return Verdict(None, f"they differ at {name} = {value}, {'its default' if usual else 'a possible value'}")

    def _default(self, root: int) -> set[Fraction]:
        """Return the default of an expression that is a single parameter, else None."""
        operation, *operands = self._pool.nodes[root]
        default = self._equality.sampler.names.get(str(operands[0]), (None,) * 3)[2] if operation == "sym" else None
        return set() if default is None else {Fraction(default)}

    def _joint(self, names: list[str]) -> Iterator[Fixed]:
        """Yield values of modes, one mode at a time, and all combinations if there are few."""
        known = {name: sorted(self._values[name]) for name in names if self._values.get(name)}
        yield from ({name: value} for name, values in known.items() for value in values)
        joint = list(itertools.islice(itertools.product(*known.values()), _MOST_JOINT + 1))
        if len(known) > 1 and len(joint) <= _MOST_JOINT:
            yield from (dict(zip(known, values, strict=True)) for values in joint)

    def _jumps(self, side: Expression) -> set[int]:
        nodes = self._pool.nodes
        return {node for node in reached(nodes, [side[1]]) if nodes[node][0] in BRANCHING - {"abs", "max", "min"}}

    def _witness(self, old: Expression, new: Expression, fixed: Fixed, count: int) -> dict[str, Fraction] | None:
        """Return a point with given values at which two expressions differ."""
        points = ({**self._equality.sampler.point(number), **fixed} for number in range(count))
        return next((point for point in points if differ(self._equality.real.stepped(point), old, new)), None)

    def _numbers(self, name: str, jumps: set[int], fixed: Fixed) -> set[Fraction]:
        """Return the values to try for a name that is not a mode: the thresholds in both texts."""
        starts = self._starts.get(name)
        if not starts and name not in self._open and not self._is_parameter(name) and not self._is_held(name):
            return set()
        own = [node for node in jumps if name in self._free.free(node)]
        texts = {self._pool.constant(node) for jump in own for node in reached(self._pool.nodes, [jump])} - {None}
        whole = _WHOLE if any(self._pool.nodes[node][0] not in COMPARISONS for node in own) else ()
        places = {self._threshold(name, node, fixed) for node in own} - {None}
        candidates = {*texts, *places, *whole} - self._values.get(name, set())
        candidates = candidates & starts if starts else candidates
        return {value for value in candidates if value is not None and self._may_be(name, value)}

    def _threshold(self, name: str, node: int, fixed: Fixed) -> Fraction | None:
        """Return the threshold of a name in a comparison linear in it; None if the threshold can move."""
        operation, *operands = self._pool.nodes[node]
        if operation not in COMPARISONS:
            return None
        moving = {other for other in self._free.free(node) if other != name and not self._is_parameter(other)}
        places = set()
        for number in range(3):
            point: dict[str, Fraction] = {**self._equality.sampler.point(0), **fixed}
            point |= {other: self._equality.sampler.value(other, number) for other in moving - fixed.keys()}
            places.add(self._root(name, operands, point))
        return places.pop() if len(places) == 1 else None

    def _root(self, name: str, operands: list[Any], point: Fixed) -> Fraction | None:
        zero, one, two = (self._gap(operands, {**point, name: Fraction(k)}) for k in range(3))
        if zero is None or one is None or two is None or not vanishes(two - 2 * one + zero, 0) or one == zero:
            return None
        root = Fraction(str(-zero / (one - zero))).limit_denominator(_LARGEST)
        gap = self._gap(operands, {**point, name: root})
        return root if gap is not None and vanishes(gap, 0) else None

    def _gap(self, operands: list[Any], point: Fixed) -> Any:
        world = self._equality.real.at(point)[self._free]
        left, right = (world.defined(operand) for operand in operands)
        return None if left is None or right is None else left - right

    def _is_parameter(self, name: str) -> bool:
        roles = {symbol.role for symbol in self._symbols.get(name, ())}
        return bool(roles) and all(role in ("parameter", "scenario") or role.startswith("law ") for role in roles)

    def _is_held(self, name: str) -> bool:
        return any(symbol.role.split(" ")[0] in _HELD for symbol in self._symbols.get(name, ()))


def _state(item: Item) -> str:
    """Return the state whose value at the start or after an event the row defines."""
    return item.name.removesuffix("(0)") if item.row.kind == "initial" else item.name.rpartition(": ")[2][:-1]


def _text(fixed: Fixed) -> str:
    return " and ".join(f"{name} = {value}" for name, value in fixed.items())


def _constant(document: Document) -> set[str]:
    """Return the states whose rate is zero."""
    rates = {row.name.removesuffix("'"): document.nodes[row.node] for row in document.results if row.kind == "rhs"}
    states = {symbol.name for symbol in document.symbols if symbol.role == "state"}
    return {name for name in states if rates.get(name) == ("num", "0")}
