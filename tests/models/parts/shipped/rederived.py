# SPDX-License-Identifier: Apache-2.0
"""A shipped system beside the same plant assembled from parts: exact comparison, and operations."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import sympy as sp

from mehvar.codegen.code.files import printed_functions
from mehvar.codegen.diff import Document
from mehvar.codegen.diff.report import ModelStatus
from mehvar.codegen.equal import points
from mehvar.codegen.equal.meaning import Expression, Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.sampler import PointSampler
from mehvar.codegen.equations.graph import equations_json
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.generate import installed_tree
from mehvar.codegen.ledger.sides import Sides
from mehvar.codegen.workspace import load_model
from mehvar.comparison.compare import compare_documents
from mehvar.models.derivation import Definition, used_definitions
from mehvar.models.quantities import Quantity
from mehvar.models.system import Expr, Group, System
from tests.derived import system

POINTS = 20
"""Number of points with 50 digits."""
_PREFIX = "parts_"
"""Start of the names of the assembled form in the shipped system: both name steps after axes."""


def structured(model: str, /, **structure: str) -> System:
    """Return a shipped structure, of which each test names the values that differ from the default."""
    choices = load_model(installed_tree(), model).STRUCTURE
    return system(model, **{name: value for name, value in structure.items() if value != choices[name][0]})


def operations(of: System, name: str = "rhs") -> int:
    """Return the operations of a call that depend on state or input, and those on the input alone."""
    functions = {f.name: f for f in printed_functions([f for f in generate_functions(of) if f.name == name])}
    return sum(functions[n].operations for n in (f"{name}_prepared", f"{name}_hold") if n in functions)


def bare(of: System) -> System:
    """Return a system with its rates alone."""
    empty, used = Group("y", ()), used_definitions(of.rhs, of.definitions)
    return dataclasses.replace(
        of, steps=tuple(s for s in of.definitions_in_order if s.symbol in used), initial=(sp.S.One,) * len(of.states),
        variants=(), choices=(),
        outputs=empty, output=(), functions=(), controllers=(), scenarios=(), metrics=(), geometry=(), limits=(),
        events=(), constraints=(), actuator=None, sensor=None, random_step=None, references=Group("r", ()),
        reference=(), residual=(), rates={}, coordinates=None,
    )  # fmt: skip


def mutant(of: System, name: str, factor: int) -> System:
    """Return a system with a factor at one of its definitions."""
    steps = [
        dataclasses.replace(s, expr=factor * s.expr) if s.symbol.name == name else s for s in of.definitions_in_order
    ]
    assert tuple(steps) != of.definitions_in_order
    return dataclasses.replace(of, steps=tuple(steps))


@dataclass(frozen=True)
class Side:
    """A system whose names are functions of others.

    Attributes
    ----------
    system : System
        Its equations.
    at : mapping of str to Expr
        Its states, inputs and parameters on the chart; the others keep their names.
    """

    system: System
    at: Mapping[str, Expr] = field(default_factory=dict)

    def rate(self, of: Expr) -> Expr:
        """Return the derivative of a reading along the motion."""
        known = dict(zip(self.system.states.symbols, self.system.rhs, strict=True))
        return sp.Add(*(of.diff(s) * known[s] for s in sorted(of.free_symbols, key=str) if s in known))

    def meaning(self, sides: Sides, chart: Meaning) -> Meaning:
        """Return the meanings of its names over those of the chart."""
        system, nodes = self.system, dict[str, Expression]()
        declared = (q for group in (system.states, system.inputs, system.parameters) for q in group)
        given = {q.name: self.at.get(q.name, q.symbol) for q in declared}
        own = {s.name: e for s, e in system.definitions.items()}

        def target(name: str) -> Expression | None:
            if name not in nodes and name in given:
                nodes[name] = chart, sides.entries(given[name])[0]
            elif name not in nodes and name in own:
                nodes[name] = result, sides.entries(own[name])[0]
            return nodes.get(name)

        result = Meaning(sides.pool, target)
        return result


def differ(of: System, old: Expr, new: Expr, bounds: Mapping[str, tuple[Fraction, Fraction]]) -> list[bool]:
    """Return whether two expressions of a system differ, with 50 digits at each of some points within bounds."""
    pool = Pool()
    sides = Sides(pool)
    meaning = Side(of).meaning(sides, Meaning(pool, lambda _: None))
    sampler = PointSampler({name: (*both, None) for name, both in bounds.items()}, frozenset())
    first, second = ((meaning, sides.entries(e)[0]) for e in (old, new))
    return [points.differ(at, first, second) for at in points.RealPoints(sampler).where([first, second], POINTS)]


@dataclass(frozen=True)
class Pair:
    """A shipped system and its assembled form.

    Attributes
    ----------
    shipped, assembled : Side
        The first on a chart, the second over the names of the first.
    readings : mapping of str to (Expr, Expr)
        Functions of the states of either side, which must be equal and have equal derivatives.
    """

    shipped: Side
    assembled: Side
    readings: Mapping[str, tuple[Expr, Expr]]

    def differences(self) -> list[str]:
        """Return the readings that differ as functions on the chart, and those whose derivatives do."""
        both = self.shipped, self.assembled
        rates = {f"{name}'": (both[0].rate(pair[0]), both[1].rate(pair[1])) for name, pair in self.readings.items()}
        return dataclasses.replace(self, readings={**self.readings, **rates}).values()

    def values(self) -> list[str]:
        """Return the readings that differ as functions on the chart: by the judge of `diff`, in a finite field."""
        pool, both = Pool(), (self.shipped.system, self.assembled.system)
        sides = Sides(pool)
        old = self.shipped.meaning(sides, Meaning(pool, lambda _: None))
        new = self.assembled.meaning(sides, old)
        positive = {q.name for system in both for q in (*system.states, *system.parameters) if q.positive}
        field = points.FieldPoints(pool, positive.__contains__)
        nodes = {name: [sides.entries(e)[0] for e in pair] for name, pair in self.readings.items()}
        return [name for name, (a, b) in nodes.items() if not field.same((old, a), (new, b))]

    def rederived(self) -> System:
        """Return the shipped system with the assembled rates of the states that are readings."""
        system, (names, steps) = self.shipped.system, self._renamed()
        rates = {of: self.assembled.rate(by).xreplace(names) for of, by in self.readings.values()}
        rhs = tuple(rates.get(s, e) for s, e in zip(system.states.symbols, system.rhs, strict=True))
        return dataclasses.replace(system, steps=(*system.steps, *steps), rhs=rhs)

    def _renamed(self) -> tuple[dict[sp.Symbol, sp.Symbol], list[Definition]]:
        """Return the names of the assembled form in the shipped system, and its steps under these names."""
        own, at = self.assembled.system, self.assembled.at
        names = {s: _renamed(s) for s in (*own.definitions, *own.states.symbols, *own.inputs.symbols)}
        names |= {s: _renamed(s) for s in own.parameters.symbols if s.name in at}
        steps = [_step(new, at.get(s.name, s)) for s, new in names.items() if s not in own.definitions]
        return names, steps + [_step(names[s], e.xreplace(names)) for s, e in own.definitions.items()]

    def verdict(self) -> ModelStatus:
        """Return what `mehvar diff` says of the shipped system beside its assembled form."""
        systems = self.on_chart() if self.shipped.at else (self.shipped.system, self.rederived())
        old, new = (Document.parse(equations_json(system)) for system in systems)
        return compare_documents(old, new).status

    def on_chart(self) -> tuple[System, System]:
        """Return both forms as systems whose states are those of the chart, and whose outputs are the rates."""
        old, at = bare(self.shipped.system), self.shipped.at
        known = {s for group in (old.states, old.inputs, old.parameters) for s in group.symbols}
        free = sorted(set().union(*(e.free_symbols for e in at.values())) - known, key=str)
        chart = (Quantity(s.name, "1", "of the chart", positive=bool(s.is_positive)) for s in free)
        states = Group("x", (*(q for q in old.states if q.name not in at), *chart))
        outputs = Group("y", tuple(Quantity(f"{name}_rate", "1", "rate") for name in self.readings))
        placed = [_step(q.symbol, at[q.name]) for q in old.states if q.name in at]
        rates = [self.shipped.rate(of) for of, _ in self.readings.values()]
        still = (sp.S.Zero,) * len(states)
        first = dataclasses.replace(
            old, states=states, rhs=still, initial=(sp.S.One,) * len(states), projection=(), outputs=outputs,
            output=tuple(rates), steps=(*placed, *old.steps),
        )  # fmt: skip
        names, steps = self._renamed()
        other = tuple(self.assembled.rate(by).xreplace(names) for _, by in self.readings.values())
        return first, dataclasses.replace(first, steps=(*first.steps, *steps), output=other)


def _renamed(symbol: sp.Symbol) -> sp.Symbol:
    return Quantity(_PREFIX + symbol.name, "", "").symbol


def _step(symbol: sp.Symbol, expr: Expr) -> Definition:
    return Definition(symbol, sp.sympify(expr), "", "assembled", "Assembled", "1", symbol.name)
