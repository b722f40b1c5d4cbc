# SPDX-License-Identifier: Apache-2.0
"""Every field of a manifest and of a system is compared, or is exempt for a reason."""

import math
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import get_args

import pytest

from mehvar.base.manifest import (
    Advice,
    Choice,
    Controller,
    Event,
    Manifest,
    Metric,
    Output,
    Parameter,
    Quantity,
    Scenario,
    Shape,
)
from mehvar.codegen.diff import compare
from mehvar.codegen.diff.parameters import EXEMPT
from mehvar.models import system
from tests.codegen.diff.documents import document
from tests.codegen.diff.pairs import manifest

KINDS = (Manifest, Quantity, Parameter, Output, Advice, Choice, Controller, Scenario, Metric, Shape, Event)
PLACES = {
    Quantity: lambda m, q: replace(m, states=(q(m.states[0]), *m.states[1:])),
    Parameter: lambda m, q: replace(m, parameters=(q(m.parameters[0]), *m.parameters[1:])),
    Output: lambda m, q: _law(m, outputs=tuple(map(q, m.controllers["pd"].outputs))),
    Advice: lambda m, q: _law(m, warnings=tuple(map(q, m.controllers["pd"].warnings))),
    Choice: lambda m, q: replace(m, choices={name: q(row) for name, row in m.choices.items()}),
    Controller: lambda m, q: replace(m, controllers={name: q(row) for name, row in m.controllers.items()}),
    Scenario: lambda m, q: replace(m, scenarios={name: q(row) for name, row in m.scenarios.items()}),
    Metric: lambda m, q: replace(m, metrics={name: q(row) for name, row in m.metrics.items()}),
    Shape: lambda m, q: replace(m, geometry=tuple(map(q, m.geometry))),
    Event: lambda m, q: replace(m, events=tuple(map(q, m.events))),
    Manifest: lambda m, q: q(m),
}
WORDS = "words"
EVENT = Event("hit", "rising", True, False, "it hits")
COMPARED = {
    "System": {
        "structure": "structure", "states": "state", "inputs": "input", "references": "reference",
        "outputs": "output", "parameters": "parameter", "scenario_parameters": "scenario", "rhs": "rhs",
        "output": "output", "steps": "definition", "limits": "limit", "initial": "initial", "reference": "reference",
        "constraints": "constraint", "functions": "function", "controllers": "law", "scenarios": "manifest",
        "metrics": "manifest", "coordinates": "coordinate", "actuator": "actuator", "sensor": "sensor",
        "projection": "projection", "choices": "manifest", "variants": "variant", "rates": "rates",
        "residual": "motion", "geometry": "geometry", "events": "guard",
        "diffusion": "diffusion", "random_step": "random step", "mass": "motion", "delays": "delay",
        "parts": "notes of `mehvar.comparison.compare`",
        "name": "the models that are compared have one name", "title": WORDS, "source": WORDS,
    },
    "Controller": {
        "name": "law", "parameters": "law", "command": "law", "constraints": "constraint", "warnings": "warning",
        "period": "manifest", "delay": "manifest", "applied": "applied", "memory": "memory", "start": "memory at start",
        "update": "memory update", "outputs": "law output", "tolerates_loss": "manifest", "title": WORDS,
        "events": "guard", "in_numbers": "a check of dimensions, of which no number depends",
        "rates": "memory rate", "every": "manifest",
    },
    "Condition": {
        "margin": "limit", "message": "manifest", "shown": "numbers in a message; how many is in the manifest",
    },
    "Event": {
        "name": "guard", "guard": "guard", "direction": "guard", "reset": "reset", "ends": "guard", "title": WORDS,
    },
    "Output": {"quantity": "law output", "value": "law output", "at_most": "manifest", "at_least": "manifest"},
    "Actuator": {"commanded": "commanded", "applied": "actuator"},
    "Sensor": {"noise": "noise", "measured": "sensor", "seen": "measured"},
    "Variant": {"values": "variant", "rhs": "variant", "loops": "variant"},
    "Coordinates": {
        "states": "coordinate", "inputs": "coordinate", "rhs": "coordinate", "from_state": "from state",
        "from_input": "from input", "to_state": "to state", "to_input": "to input",
    },
    "Shape": {"name": "manifest", "kind": "manifest", "points": "geometry", "color": "manifest"},
    "Function": {
        "name": "function", "arguments": "argument", "results": "function", "description": WORDS,
        "vector": "how results are packed",
    },
}  # fmt: skip
"""For each field of the vocabulary, the kind of rows or symbols where it is compared, or why it is not."""


def _law(m, **new):
    return replace(m, controllers={name: replace(law, **new) for name, law in m.controllers.items()})


def another(value):
    """Return another value of the same kind."""
    match value:
        case bool():
            return not value
        case int() | float():
            return 0.5 if math.isinf(value) else value + 1
        case str() | None:
            return f"{value} edited"
        case tuple() if value and is_dataclass(value[0]):
            return value[1:]
        case tuple():
            return (*value, "another")
        case Path():
            return value / "another"
    return dict(list(value.items())[1:])


@pytest.mark.parametrize(
    ("kind", "name"),
    [(kind, f.name) for kind in KINDS for f in fields(kind)],
    ids=lambda entry: getattr(entry, "__name__", entry),
)
def test_an_edit_of_a_field_of_the_manifest_is_seen_unless_it_is_exempt(kind, name):
    """In both directions, so that what is lost one way is new the other way."""
    if name == "name":
        return
    random = {name: (Quantity("n", "1", "noise"),) for name in ("measured", "wiener", "random_step")}
    hashes = {name: {"file": "0"} for name in ("inputs_sha256", "files_sha256", "shapes_sha256")}
    more = (
        random
        | hashes
        | {
            "parts": {"hub": {"": "Hub"}},
            "geometry": (Shape("rod", "rod", 2, "blue"),),
            "events": (EVENT,),
            "delays": {"M": "k"},
        }
    )
    plain, old = document("f: x*m"), _law(replace(manifest(), **more), events=(EVENT,))
    new = PLACES[kind](old, lambda row: replace(row, **{name: another(getattr(row, name))}))
    assert new != old
    sides = [replace(plain, manifest=side) for side in (old, new)]
    for comparison in (compare(*sides), compare(*reversed(sides))):
        exempt = any(f"{base.__name__}.{name}" in EXEMPT for base in kind.__mro__)
        assert comparison.differs is not exempt, f"{kind.__name__}.{name}"
        assert bool(comparison.parameters) is not exempt
        assert "Quantity(" not in str([(change.old, change.new) for change in comparison.parameters])


@pytest.mark.parametrize(("kind", "order"), [({"resets": True}, "b, a"), ({"ends": True}, "b, a"), ({}, "")])
def test_the_order_of_events_is_seen_where_they_do_something(kind, order):
    surface = Event("a", "rising", resets=False, ends=False, title="")
    a, b = (replace(surface, name=name, **kind) for name in "ab")
    pair = (replace(document("f: x*m"), manifest=replace(manifest(), events=events)) for events in ((a, b), (b, a)))
    changes = compare(*pair).parameters
    assert [(change.what, change.new) for change in changes] == ([("order", order)] if order else [])


VECTORS = {f.name: get_args(f.type)[0] for f in fields(Manifest) if get_args(f.type)[:1] in [(Quantity,), (Parameter,)]}
ELEMENTS = {
    Quantity: Quantity("a", "m", "a length"),
    Parameter: next(iter(manifest().parameters)),
}


@pytest.mark.parametrize("vector", VECTORS)
def test_the_order_and_the_units_of_a_vector_are_seen(vector):
    """Its elements have places, in C and in arrays."""
    a, b = (replace(ELEMENTS[VECTORS[vector]], name=name) for name in ("first", "second"))
    orders = (a, b), (b, a), (a, replace(b, unit="another"))
    old, turned, other = (replace(document("f: x*m"), manifest=replace(manifest(), **{vector: o})) for o in orders)
    assert compare(old, other).parameters
    ((name, what, value),) = [(change.name, change.what, change.new) for change in compare(old, turned).parameters]
    assert name == vector
    assert what == "value" or value == "second, first"  # some vectors are compared as a whole


def test_the_first_scenario_is_told_from_the_others():
    rows = dict.fromkeys(("calm", "wild"), next(iter(manifest().scenarios.values())))
    turned = dict(reversed(rows.items()))
    pair = (replace(document("f: x*m"), manifest=replace(manifest(), scenarios=side)) for side in (rows, turned))
    assert [(c.name, c.what, c.new) for c in compare(*pair).parameters] == [("scenarios", "order", "wild, calm")]


def test_other_names_or_another_order_of_laws_are_no_change_of_their_parameters():
    """A parameter names its readers law by law, such as a_loop; they follow from the equations."""
    parameter = next(iter(manifest().parameters))
    sides = (replace(manifest(), parameters=(replace(parameter, readers=(f"{law}_loop",)),)) for law in "ab")
    pair = (replace(document("f: x*m"), manifest=side) for side in sides)
    assert compare(*pair).parameters == ()


def test_a_new_event_is_one_change_with_the_names_of_its_fields():
    pair = (replace(document("f: x*m"), manifest=replace(manifest(), events=rows)) for rows in ((), (EVENT,)))
    (change,) = compare(*pair).parameters
    assert (change.name, change.what) == (EVENT.name, "added")
    assert f"direction = {EVENT.direction}" in change.new
    assert EVENT.name not in change.new


def test_conditions_of_equations_are_told_as_equations():
    """Each constraint in words is the name of a row."""
    made = document("f: x*m\none: m\ntwo: x")
    rows = tuple(replace(row, kind="constraint") if row.name in ("one", "two") else row for row in made.results)
    pair = (replace(made, results=rows, manifest=replace(manifest(), constraints=c)) for c in ((), ("one", "two")))
    assert compare(*pair).parameters == ()


def test_a_delay_has_no_unit_of_its_input():
    plain = document("f: x*m")
    plain = replace(plain, symbols=tuple(replace(symbol, unit="m") for symbol in plain.symbols))
    pair = (replace(plain, manifest=replace(manifest(), delays={"x": name})) for name in "ab")
    (change,) = compare(*pair).parameters
    assert (change.role, change.old, change.new, change.unit) == ("delay", "a", "b", "")


def test_every_exemption_is_of_a_field_and_has_a_reason():
    known = {f"{kind.__name__}.{f.name}" for kind in KINDS for f in fields(kind)}
    assert EXEMPT.keys() <= known
    assert all(EXEMPT.values())


@pytest.mark.parametrize("kind", COMPARED)
def test_every_field_of_the_vocabulary_has_its_place(kind):
    own = {f.name for f in fields(getattr(system, kind))} - {f.name for f in fields(system.Located)}
    assert COMPARED[kind].keys() == own


@pytest.mark.parametrize("number", ["Integer(10)**400", "-Integer(10)**400/3", "Rational(1, 10**400)"])
def test_a_number_beyond_doubles_is_printed_with_its_digits(number):
    (equation,) = compare(document("f: x"), document(f"f: x + {number}")).equations
    assert "0" * 400 in equation.edits[0].new.text
