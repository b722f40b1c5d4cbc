# SPDX-License-Identifier: Apache-2.0
"""Mutants of a plant's equations, each with one additive term flipped, dropped or doubled.

Each term has a weight, by default 1, which is an argument of the functions. A mutant is a vector of weights, so that
thousands of mutants cost one derivation.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from mehvar.models.derivation import used_definitions
from mehvar.models.system import Coordinates, Definition, Expr, Function, Group, Quantity, System
from mehvar.physics.gates import TOLERANCE, Gate, derived_equations
from mehvar.physics.machine import Array, Machine, Points, Ranges, draw, points

CHANGES = {"flipped": -1.0, "dropped": 0.0, "doubled": 2.0}
SAME = 1e-13
"""Difference below which a mutant counts as equivalent. It is above rounding of reordered operations, about 1e-15,
and far below the gates' tolerance.
"""
_EQUIVALENCE_POINTS = 500
"""Number of points at which an equivalent mutant changes nothing, enough to reach rare branches."""


@dataclass(frozen=True)
class Term:
    """An additive term of a definition.

    Attributes
    ----------
    owner : str
        Definition or function that contains it.
    text : str
        The term.
    weight : Symbol
        Symbol by which it is multiplied.
    """

    owner: str
    text: str
    weight: sp.Symbol


@dataclass(frozen=True)
class Mutant:
    """A term and its mutation."""

    term: Term
    change: str


@dataclass
class Tally:
    """Results for the mutants of one structure.

    Attributes
    ----------
    terms, total : int
        Terms of the equations, and mutants tried.
    killers : Counter
        Number of killed mutants, by the first gate that detects them.
    equivalent : list of Mutant
        Undetected mutants that change no function at 500 random points.
    survivors : list of Mutant
        Other undetected mutants.
    verified : list of Mutant
        Survivors that the comparison with the derived equations kills.
    """

    terms: int
    total: int = 0
    killers: Counter[str] = field(default_factory=Counter)
    equivalent: list[Mutant] = field(default_factory=list)
    survivors: list[Mutant] = field(default_factory=list)
    verified: list[Mutant] = field(default_factory=list)

    @property
    def killed(self) -> int:
        """Mutants that the gates detect."""
        return self.killers.total()


def run(
    system: System, ranges: Ranges, gates_of: Callable[[Machine], list[Gate]], sample: int = 0, n: int = 6
) -> Tally:
    """Test the mutants of a system's plant.

    Parameters
    ----------
    system : System
        As derived.
    ranges : mapping of str to (float, float)
        Plausible values of its quantities.
    gates_of : callable
        Function of a machine that returns gates, which the true equations pass.
    sample : int
        Number of mutants to try, drawn with a fixed seed; 0 for all.
    n : int
        Number of points of each gate.

    Raises
    ------
    ValueError
        If the unchanged equations fail a gate.
    """
    changed, terms = weighted(system)
    return run_terms(changed, terms, ranges, gates_of, sample, n)


def run_terms(
    system: System,
    terms: Sequence[Term],
    ranges: Ranges,
    gates_of: Callable[[Machine], list[Gate]],
    sample: int = 0,
    n: int = 6,
) -> Tally:
    """Test the mutants of a system whose terms have weights already.

    Parameters
    ----------
    system : System
        With the weights as further symbols.
    terms : sequence of Term
        Terms to change.
    ranges, gates_of, sample, n
        As of `run`.

    Raises
    ------
    ValueError
        If the unchanged equations fail a gate.
    """
    subject = Machine(system, ranges, [term.weight for term in terms])
    declared, at = gates_of(subject), points(subject, n)
    further = [derived_equations()] if system.residual else []
    broken = [gate.name for gate in (*declared, *further) if gate.error(at) > TOLERANCE]
    if broken:
        raise ValueError(f"{system.name}: the unchanged equations fail {', '.join(broken)}")
    same = _Unchanged(subject)
    tally = Tally(len(terms))
    for k, change in _sample(len(terms), sample):
        mutant = Mutant(terms[k], change)
        subject.weights[k] = CHANGES[change]
        tally.total += 1
        if killer := _first(declared, at):
            tally.killers[killer] += 1
        elif same():
            tally.equivalent.append(mutant)
        else:
            tally.survivors.append(mutant)
            if _first(further, at):
                tally.verified.append(mutant)
        subject.weights[k] = 1.0
    return tally


def _sample(terms: int, sample: int) -> list[tuple[int, str]]:
    everything = [(k, change) for k in range(terms) for change in CHANGES]
    if not sample:
        return everything
    picked = np.random.default_rng(0).choice(len(everything), min(sample, len(everything)), replace=False)
    return [everything[k] for k in sorted(picked)]


def _first(gates: Iterable[Gate], at: Points) -> str:
    """Return the first gate that fails at the points."""
    return next((gate.name for gate in gates if not gate.error(at) <= TOLERANCE), "")


class _Unchanged:
    """Test for mutants that change no function of the plant at many points."""

    def __init__(self, subject: Machine) -> None:
        self.subject, rng = subject, np.random.default_rng(2)
        at = points(subject, _EQUIVALENCE_POINTS, seed=1)

        def drawn(group: Group) -> Array:
            known = group.name in at.values
            return at.values[group.name] if known else draw(subject.ranges, group, _EQUIVALENCE_POINTS, rng)

        requests = [request for request in subject.requests.values() if not request.law]
        self.calls = [(request.name, [drawn(group) for group in request.arguments]) for request in requests]
        self.before = self._all()

    def __call__(self) -> bool:
        return all(_close(new, old) for new, old in zip(self._all(), self.before, strict=True))

    def _all(self) -> list[Array]:
        return [self.subject(name, *arguments) for name, arguments in self.calls]


def _close(new: Array, old: Array) -> bool:
    return bool(np.allclose(new, old, rtol=SAME, atol=SAME, equal_nan=True))


def weighted(system: System) -> tuple[System, tuple[Term, ...]]:
    """Return the system with a weight at each additive term of its plant, and the list of terms.

    Weights are added to x', outputs, initial state, reference, the regular chart, the model's functions except those
    of laws, and all definitions that these use.
    """
    bench = Weights()
    own = {f.name for f in system.functions if "c" not in [group.name for group in f.arguments]}
    used = used_definitions(_evaluated(system, own), system.definitions)
    steps = tuple(
        dataclasses.replace(step, expr=bench.weigh(step.symbol.name, [step.expr])[0])
        if isinstance(step, Definition) and step.symbol in used
        else step
        for step in system.steps
    )
    bench.shared = {}
    changed = dataclasses.replace(
        system,
        steps=steps,
        rhs=bench.weigh("rhs", system.rhs),
        variants=tuple(
            dataclasses.replace(v, rhs=bench.weigh(f"rhs of {' '.join(v.values)}", v.rhs)) for v in system.variants
        ),
        output=bench.weigh("outputs", system.output),
        initial=bench.weigh("initial", system.initial),
        reference=bench.weigh("reference", system.reference),
        functions=tuple(_function(f, bench) if f.name in own else f for f in system.functions),
        coordinates=system.coordinates and _chart(system, system.coordinates, bench),
    )
    return changed, tuple(bench.terms)


def _evaluated(system: System, own: set[str]) -> list[Expr]:
    expressions = [*system.rhs, *system.output, *system.initial, *system.reference]
    expressions += [e for variant in system.variants for e in variant.rhs]
    expressions += [e for f in system.functions if f.name in own for _, e in f.results]
    chart = system.coordinates
    return [*expressions, *chart.rhs, *chart.from_state, *chart.to_state, *chart.from_input] if chart else expressions


def _function(function: Function, bench: Weights) -> Function:
    quantities, expressions = zip(*function.results, strict=True)
    weighed = bench.weigh(function.name, expressions)
    return dataclasses.replace(function, results=tuple(zip(quantities, weighed, strict=True)))


def _chart(system: System, chart: Coordinates, bench: Weights) -> Coordinates:
    """Add weights to the equations of a chart, except coordinates that another chart shares."""
    return dataclasses.replace(
        chart,
        rhs=bench.weigh("chart rhs", chart.rhs),
        from_state=bench.weigh("chart from_state", chart.from_state, chart.states.symbols),
        to_state=bench.weigh("chart to_state", chart.to_state, system.states.symbols),
        from_input=bench.weigh("chart from_input", chart.from_input, chart.inputs.symbols),
    )


class Weights:
    """Inserter of weights at terms, with the same weights for equal sums."""

    def __init__(self) -> None:
        self.terms: list[Term] = []
        self.shared: dict[Expr, Expr] | None = None

    def weigh(
        self,
        owner: str,
        expressions: Sequence[Expr],
        names: Sequence[sp.Symbol] = (),
        memo: dict[Expr, Expr] | None = None,
    ) -> tuple[Expr, ...]:
        """Return the expressions with weights, except those among `names`.

        A sum that is a key of `memo` has the same weights again.
        """
        if memo is None:
            memo = {} if self.shared is None else self.shared
        return tuple(e if e in names else self._top(owner, sp.sympify(e), memo) for e in expressions)

    def _top(self, owner: str, expr: Expr, memo: dict[Expr, Expr]) -> Expr:
        if expr.is_number or isinstance(expr, sp.Add):
            return self._inside(owner, expr, memo)
        key = sp.Tuple(expr)
        if key not in memo:
            memo[key] = self._term(owner, expr) * self._inside(owner, expr, memo)
        return memo[key]

    def _inside(self, owner: str, expr: Expr, memo: dict[Expr, Expr]) -> Expr:
        if not expr.args:
            return expr
        if expr not in memo:
            parts = [self._inside(owner, part, memo) for part in expr.args]
            if isinstance(expr, sp.Add):
                parts = [self._term(owner, old) * new for old, new in zip(expr.args, parts, strict=True)]
            memo[expr] = expr.func(*parts)
        return memo[expr]

    def _term(self, owner: str, expr: Expr) -> sp.Symbol:
        weight = Quantity(f"weight_{len(self.terms)}", "1", "weight of a term").symbol
        self.terms.append(Term(owner, str(expr), weight))
        return weight
