# SPDX-License-Identifier: Apache-2.0
"""Check of names: unique, and valid in C, Python and result files."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import sympy as sp

from mehvar.base.manifest import OPEN_LOOP
from mehvar.base.names import ARGUMENTS, RESULT_NAMES, WORK, identifier

from ..clock import CLOCK, plant_of_time
from ..quantities import TIME, Group, ModelError, Quantity
from ..system import System
from .vectors import law_groups, system_groups

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_OF_C = frozenset("""
    auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    linux unix real np
""".split())  # fmt: skip  # noqa: SIM905
"""Words reserved by C, its compilers and generated functions. No argument may have one as its name."""
_CALLABLE = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", re.ASCII)
_TAKEN = ("jac", "hess", "null")
"""Names that CasADi refuses for functions."""
_GENERATED = frozenset("""
    rhs outputs geometry limits initial reference constraints to_coordinates from_coordinates project actuate measure
    mass_diagonal measure_jvp diffuse jump input_delays guards resets
    jvp jac_x jac_u jac_p jvp_p outputs_jac outputs_jac_p outputs_jvp outputs_jvp_p actuate_jvp
""".split())  # fmt: skip  # noqa: SIM905
"""Names of functions that every system has. No law and no other function may use one."""
_LOCAL = re.compile(r"[mt]_[a-z2-7]{5}(_\d+)?")
"""Names of local variables in generated functions."""


@dataclass(frozen=True)
class _Use:
    """A name with its owner and, if different, the owner's place."""

    name: str
    kind: str
    symbol: sp.Symbol | None
    origin: str = ""

    def __str__(self) -> str:
        return f"{self.kind} {self.name!r}" + (f" at {self.origin}" if self.origin else "")


def check_names(system: System) -> None:
    """Refuse names that occur twice, or are invalid in generated code or on the command line."""
    _check_words(system)
    common = _common(system)
    taken = _unique(common, {}, system.origin)
    for law in system.controllers:
        uses = (_Use(q.name, kind, q.symbol) for kind, group in law_groups(law) for q in group)
        _unique(uses, dict(taken), law.origin)
    _check_outputs(system, taken)
    _check_variables(system)
    _check_callables(system)
    check_text(system.title, f"{system.origin}: title")
    for kind, group in _groups(system):
        _check_spelling(kind, group, system.origin)
        for quantity in group:
            check_text(quantity.description, f"{system.origin}: description of {kind} {quantity.name!r}")
    for function in system.functions:
        check_text(function.description, f"{function.origin}: description of function {function.name!r}")
    _check_letters(system)
    _check_arguments(system)


def _check_words(system: System) -> None:
    """Refuse models and laws named like a word of the command line in the same position."""
    if system.name == WORK:
        raise ModelError(
            f"{system.origin}: the model is called {WORK!r}, which stands for the current "
            "sources in `mehvar diff`: rename it"
        )
    for law in system.controllers:
        if law.name == OPEN_LOOP:
            raise ModelError(
                f"{law.origin}: the law is called {OPEN_LOOP!r}, which stands for a run without a law: rename it"
            )


def check_name(name: str, what: str) -> None:
    """Refuse names of result variables that are invalid in C or Python."""
    if not _NAME.fullmatch(name):
        raise ModelError(f"{what} {name!r}: {_FORM}")


def role(system: System, symbol: sp.Symbol) -> str:
    """Return the role of a symbol, such as "parameter of law 'pd'", or an empty text."""
    return next((kind for kind, group in _groups(system) if symbol in group.symbols), "")


def _groups(system: System) -> list[tuple[str, Group]]:
    return [
        *system_groups(system),
        *(pair for law in system.controllers for pair in law_groups(law)),
        ("output", system.outputs),
    ]


def _common(system: System) -> Iterator[_Use]:
    """Yield the names that every law sees: quantities, definitions and the time; shared quantities count once."""
    shared = {
        "coordinate": set(system.states.quantities),
        "input of the chart": set(system.inputs.quantities),
        "measured quantity": set(system.states.quantities),  # a law without `seen` reads the measured state
    }
    yield _Use(TIME.name, "time", TIME.symbol)
    for kind, group in system_groups(system):
        yield from (_Use(q.name, kind, q.symbol) for q in group if q not in shared.get(kind, ()))
    if plant_of_time(system) and CLOCK not in system.states.quantities:
        yield _Use(CLOCK.name, "the state that is the time of this plant,", CLOCK.symbol)
    for step in system.definitions_in_order:
        yield _Use(step.symbol.name, "definition", step.symbol, step.origin)


def _unique(uses: Iterable[_Use], taken: dict[str, _Use], origin: str) -> dict[str, _Use]:
    for use in uses:
        first = taken.setdefault(use.name, use)
        if first is not use:
            raise ModelError(f"{use.origin or origin}: {use} has the name of {first}; rename one of them")
    return taken


def _check_outputs(system: System, taken: dict[str, _Use]) -> None:
    """Refuse an output that shares its name with a different quantity."""
    rows = dict(zip((q.name for q in system.outputs), system.output, strict=False))
    for name, entry in rows.items():
        if name in taken and entry != taken[name].symbol:
            raise ModelError(
                f"{system.origin}: output {name!r} has the name of {taken[name]}, but a different expression; rename it"
            )


def _check_variables(system: System) -> None:
    """Refuse two result variables with one name."""
    taken: dict[str, _Use] = {}
    common = [
        *(_Use(m.name, "metric", None) for m in system.metrics),
        *(_Use(q.name, "state", None) for q in system.states),
        *(_Use(f"u_{q.name}", "variable of input", None) for q in system.inputs),
        *(_Use(q.name, "output", None) for q in system.outputs),
        _Use(TIME.name, "time", None),
    ]
    _unique(common, taken, system.origin)
    for law in system.controllers:
        reported = (_Use(output.quantity.name, f"output of law {law.name!r}", None) for output in law.outputs)
        memory = (_Use(q.name, f"memory of law {law.name!r}", None) for q in law.memory)
        uses = (*memory, *reported)
        _unique(uses, dict(taken), law.origin)
        _check_results(uses, law.origin)
    _check_results((use for use in common if use.name != TIME.name), system.origin)
    parameters = {q.name: kind for kind, group in _groups(system) if "parameter" in kind for q in group}
    for metric in system.metrics:
        if metric.name in parameters:
            raise ModelError(
                f"{system.origin}: metric {metric.name!r} has the name of a {parameters[metric.name]}: rename "
                "the metric; a batch that varies the parameter would have two variables of this name"
            )


def _check_results(uses: Iterable[_Use], origin: str) -> None:
    """Refuse a variable with the name of a variable that every result or store contains."""
    for use in uses:
        if use.name in RESULT_NAMES:
            raise ModelError(
                f"{use.origin or origin}: {use} has a name that results use: {', '.join(sorted(RESULT_NAMES))}"
            )


def _check_arguments(system: System) -> None:
    """Refuse parameters and choices with the name of a run's argument, except a law's delay named `delay`."""
    shared = (*system.parameters, *system.scenario_parameters)
    uses = [(f"parameter {q.name!r}", q.name, system.origin) for q in shared]
    uses += [(f"choice {choice.name!r}", choice.name, system.origin) for choice in system.choices]
    for law in system.controllers:
        own = (q.name for q in law.parameters if not q.name == law.delay == "delay")
        uses += [(f"parameter {name!r} of law {law.name!r}", name, law.origin) for name in own]
    for what, name, origin in uses:
        if name in ARGUMENTS:
            raise ModelError(
                f"{origin}: {what} has the name of an argument of a run; reserved are {', '.join(sorted(ARGUMENTS))}"
            )


def _check_callables(system: System) -> None:
    """Refuse names of laws and functions that are invalid in code, and functions with two arguments of one name."""
    check_distinct([identifier(law.name) for law in system.controllers], f"{system.origin}: laws:")
    check_distinct([function.name for function in system.functions], f"{system.origin}: functions:")
    laws = [("law", law.name, law.origin) for law in system.controllers]
    functions = [("function", function.name, function.origin) for function in system.functions]
    for kind, name, where in laws + functions:
        if identifier(name) in _GENERATED:
            raise ModelError(f"{where}: {kind} {name!r} has the name of a function that every system has")
    for choice in system.choices:
        for word in (choice.name, *choice.values):
            _check_word(word, f"{system.origin}: choice {choice.name!r}")
    for law in system.controllers:
        if not _CALLABLE.fullmatch(law.name.replace("-", "_")) or law.name in _TAKEN:
            raise ModelError(f"{law.origin}: law {law.name!r}: {_FORM}; single '-' are allowed too")
    for function in system.functions:
        where = f"{function.origin}: function {function.name!r}"
        names = [group.name for group in function.arguments]
        quantities = [q for group in function.arguments for q in group]
        results = [function.vector] if function.vector else [q.name for q, _ in function.results]
        if not function.results or not names:
            raise ModelError(f"{where} has no {'results' if names else 'arguments'}: it must have at least one")
        check_distinct([*names, *results], f"{where}: arguments and results:")
        check_distinct([q.name for q in quantities], f"{where}: arguments' quantities:")
        for name in (*names, *results, function.name):
            _check_word(name, where)


def _check_word(name: str, where: str) -> None:
    """Refuse a name that is invalid or reserved in C, Python or generated code."""
    if (
        not _CALLABLE.fullmatch(name)
        or name in _TAKEN
        or keyword.iskeyword(name)
        or name in _OF_C
        or _LOCAL.fullmatch(name)
    ):
        raise ModelError(
            f"{where}: the name {name!r}: {_FORM}, no word of C or Python, and not of the form t_abcde, which "
            "generated code uses"
        )


_FORM = "must be letters, digits and underscores, beginning with a letter"


def check_distinct(names: Sequence[object], what: str) -> None:
    """Refuse duplicate names."""
    for k, name in enumerate(names):
        if name in names[:k]:
            raise ModelError(f"{what} {name!r} is defined twice")


def check_text(text: str, where: str) -> None:
    """Refuse texts that would close or alter the comment or docstring around them in generated code."""
    if not text.isprintable() or any(mark in text for mark in ("*/", '"""', "\\")):
        raise ModelError(f'{where} is {text!r}: must be one line without */, """ and backslashes')


def _check_letters(system: System) -> None:
    """Refuse vectors whose name is not the letter that runs use, such as x or u."""
    groups = [
        ("x", system.states),
        ("u", system.inputs),
        ("r", system.references),
        ("y", system.outputs),
        ("p", system.parameters),
        ("s", system.scenario_parameters),
        *((("seen", system.seen),) if system.seen is not system.states else ()),
        *(("c", law.parameters) for law in system.controllers),
    ]
    for letter, group in groups:
        if group.name != letter:
            raise ModelError(f"{system.origin}: the group {group.name!r} must have the name {letter!r}")


def _check_spelling(kind: str, group: Group, origin: str) -> None:
    """Refuse names that differ only in case, because constants of the generated header are in capitals."""
    names: dict[str, Quantity] = {}
    for quantity in group:
        check_name(quantity.name, f"{origin}: {kind}")
        first = names.setdefault(quantity.name.upper(), quantity)
        if first.name != quantity.name:
            raise ModelError(
                f"{origin}: {first.name!r} and {quantity.name!r} of vector {group.name!r} differ only in case: they "
                "would be one constant in the generated C. Rename one of them"
            )
        if first is not quantity:
            raise ModelError(f"{origin}: {kind} {quantity.name!r} is defined twice")
