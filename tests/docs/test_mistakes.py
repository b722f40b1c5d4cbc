# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/reference/mistakes.md: each is refused with the answer of the page and writes nothing."""

from __future__ import annotations

import pytest

from docs.site import mistakes

ROWS = mistakes.PAGE.read_text(encoding="utf-8").split("|---|---|\n")[1].splitlines()


def test_there_are_forty() -> None:
    assert len(ROWS) == len(mistakes.COMMANDS) >= 40


@pytest.mark.parametrize(("command", "row"), list(zip(mistakes.COMMANDS, ROWS, strict=True)), ids=mistakes.COMMANDS)
def test_a_mistake_is_answered_as_the_page_says(command: str, row: str) -> None:
    assert row == mistakes.row(command), "run: python -m docs.site.mistakes"
