# SPDX-License-Identifier: Apache-2.0
"""Tests that `make test-quick` runs for a changed file."""

from types import SimpleNamespace

import pytest

from tests.quick import GATES, Minute, near


@pytest.mark.parametrize(
    ("file", "tests"),
    [
        ("runtime/run/ticks.py", ["tests/runtime/run/test_ticks.py"]),
        ("tests/runtime/run/test_ticks.py", ["tests/runtime/run/test_ticks.py"]),
        ("tests/runtime/run/test_gone.py", []),
        ("models/triangle/parameters.toml", ["tests/models/triangle/test_dynamic.py"]),
        ("runtime/native/include/mehvar/private/step.h", ["tests/runtime/native/test_math.py"]),
        ("tests/runtime/board/everywhere.py", ["tests/runtime/board/test_everywhere.py"]),
        ("docs/gone.md", []),
        ("docs/known-limits.md", ["tests/docs/test_docs.py::test_what_a_page_shows_runs[docs/known-limits.md]"]),
        ("Makefile", []),
    ],
)
def test_a_file_has_the_tests_of_its_place(file, tests):
    several = near([file])
    assert set(tests) <= {*several}
    assert bool(tests) == (len(several) > len(GATES))
    assert several[-len(GATES) :] == [*GATES]


def test_a_name_comes_before_a_folder_and_each_file_once():
    several = near(["models/slosh/parameters.toml", "runtime/run/ticks.py", "tests/runtime/run/test_ticks.py"])
    assert several[0] == "tests/runtime/run/test_ticks.py"
    assert len(several) == len({*several})


@pytest.mark.parametrize(("seconds", "stops"), [(0, True), (60, False)])
def test_no_test_begins_when_the_minute_is_over(seconds, stops):
    item = SimpleNamespace(session=SimpleNamespace(shouldstop=False))
    Minute(seconds).pytest_runtest_teardown(item)
    assert bool(item.session.shouldstop) == stops
