# SPDX-License-Identifier: Apache-2.0
"""Points decide a joint state if there are many of them, on many lines."""

from mehvar.codegen.equal.cells.evidence import Evidence, Patterns
from mehvar.codegen.equal.cells.spots import Cell

STATE = ((4, 1), (7, 0))


def decided(lines, points, names=3):
    evidence = Evidence(names)
    for evidence.line in range(lines):
        for _ in range(points):
            evidence.add(Cell(STATE, is_equal=False), {"x": 0.0})
    return evidence


def test_one_cell_that_the_field_decides_is_enough():
    evidence = Evidence(3)
    evidence.add(Cell(STATE, is_equal=True), {"x": 0.0})
    assert evidence.is_decided(STATE)
    assert evidence.is_decided(STATE[:1])
    assert not evidence.is_decided(((4, 0),))
    assert evidence.least() == 0


def test_points_are_enough_with_their_number_and_their_lines():
    assert decided(lines=16, points=4).is_decided(STATE)
    assert not decided(lines=16, points=3).is_decided(STATE)
    assert not decided(lines=15, points=9).is_decided(STATE)
    assert not decided(lines=16, points=4, names=20).is_decided(STATE)
    assert decided(lines=1, points=64, names=0).is_decided(STATE)
    assert decided(lines=16, points=5).least() == 80
    assert decided(lines=3, points=1).undecided() == STATE


def test_the_least_part_of_an_open_state_is_missing():
    evidence = Evidence(3)
    for state in (STATE, ((4, 0), (7, 1)), ((4, 1), (8, 0))):
        evidence.add(Cell(state, is_equal=True), {})
    assert evidence.missing(((4, 1), (7, 2))) == ((7, 2),)
    assert evidence.missing(((4, 0), (7, 0))) == ((4, 0), (7, 0))
    assert evidence.missing(((4, 1), (7, 0), (8, 0))) == ((7, 0), (8, 0))


def test_a_pattern_needs_points_until_its_state_is_known():
    patterns = Patterns()
    assert [patterns.need(b"a") for _ in range(5)] == [True, True, True, False, False]
    assert patterns.need(b"b")
    patterns.settle(b"b", STATE)
    assert not patterns.need(b"b")
    assert patterns.state(b"b") == STATE
