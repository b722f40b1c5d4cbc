# SPDX-License-Identifier: Apache-2.0
"""A wrong value is blamed on the flag that it was given with."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.fuzz.campaign import in_process
from tests.mehvar.test_effects import COMMANDS

PLACES = ("--out", "--plot", "--journal")
"""Flags that take any text: a place."""
WRONG = ("ten", "-7", "ten=ten")
"""A word, a number that few options take, and a pair of names: each is wrong for most of them in another way."""


def lines() -> Iterator[tuple[str, tuple[str, ...], int]]:
    """Return each flag with a value of each command once: its name, a line with it, and where the value stands."""
    seen = set()
    for command, rows in COMMANDS.items():
        for row in rows.values():
            line = row[1] if isinstance(row, tuple) else ()
            for place, flag in enumerate(line[:-1]):
                if (
                    flag.startswith("-")
                    and flag not in PLACES
                    and not line[place + 1].startswith("-")
                    and (command, flag) not in seen
                ):
                    seen.add((command, flag))
                    yield f"{command} {flag}", tuple(line), place + 1


@pytest.mark.parametrize(("line", "place"), [pytest.param(line, place, id=name) for name, line, place in lines()])
@pytest.mark.share(2)
def test_a_wrong_value_is_blamed_on_its_own_flag(
    line: tuple[str, ...], place: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for wrong in WRONG:
        _, text = in_process(*line[:place], wrong, *line[place + 1 :])
        about = [part for part in text.splitlines() if f"'{wrong}'" in part or f"= {wrong} (" in part]
        assert {flag for part in about for flag in re.findall(r"\(from (-[^ )]+)", part)} <= {line[place - 1]}, text


LATE = [
    (("--set", "theta_0=1", "--t-end", "1e9"), "t_end = 1000000000.0 (from --t-end)"),
    (("--set", "dt_out=1e-7", "--t-end", "1"), "dt_out = 1e-07 (from --set)"),
    (("--set", "theta_0=1", "--t-end", "1e5"), "dt_out = 0.01 (from scenario paper)"),
    (("--set", "hold=0.003", "--t-end", "1"), "hold = 0.003 s (from --set) and dt_out = 0.01 s (from scenario paper)"),
]


@pytest.mark.parametrize(("flags", "blame"), LATE, ids=[blame for _, blame in LATE])
@pytest.mark.parametrize("command", [("simulate",), ("batch", "-n", "2", "--out", "runs.zarr")], ids=lambda c: c[0])
@pytest.mark.share(2)
def test_a_value_that_a_run_refuses_is_blamed_on_where_it_came_from(
    command: tuple[str, ...], flags: tuple[str, ...], blame: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, text = in_process(command[0], "triangle", "--controller", "path", *command[1:], *flags)
    assert status == 2
    assert blame.replace("--set", "--set" if command == ("simulate",) else "the command line") in text
