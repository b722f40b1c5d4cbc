# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/reference/mistakes.md, in this process: each is refused as the page says, and writes nothing."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

import pytest

from mehvar import __main__

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "mistakes.md"
ROWS = [
    (match[1].replace("\\|", "|"), [text.replace("\\|", "|") for text in re.findall(r"`([^`]+)`", match[2])])
    for match in re.finditer(r"^\| `(mehvar [^`]+)` \| (`.*`) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
]


def test_there_are_forty():
    assert len(ROWS) >= 40
    assert len(ROWS) == len(PAGE.read_text(encoding="utf-8").split("|---|---|\n")[1].splitlines())


@pytest.mark.parametrize(("line", "answer"), ROWS, ids=[line for line, _ in ROWS])
def test_a_mistake_is_answered_as_the_page_says(line, answer, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", shlex.split(line))
    with pytest.raises(SystemExit) as end:
        __main__._run()
    printed = capsys.readouterr().err
    assert end.value.code == 2, printed
    for text in answer:
        assert re.search(".*".join(map(re.escape, text.split("..."))), printed), printed
    assert not list(tmp_path.iterdir())
