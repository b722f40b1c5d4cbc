# SPDX-License-Identifier: Apache-2.0
"""A law on an emulated microcontroller, as a part of the report."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mehvar.errors import InputError
from mehvar.runtime.board.run import BoardRequest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mehvar.runtime.model.model import Model

_BOARD, _SAMPLES = "mps2-m4f", 400
_NEEDED = ("unicorn", "elftools", "capstone", "serial")
MISSING = 'Not run: this needs the extra "board": pip install "mehvar[board]".'


@dataclass(frozen=True)
class OnBoard:
    """What a run on the emulated board has shown, or why there was none."""

    law: str
    missing: str = ""
    same: bool = True
    title: str = ""
    rows: Sequence[tuple[str, str, str]] = ()
    image: str = ""
    figure: Figure | None = None


def run_board(model: Model, law: str) -> OnBoard:
    """Run a law on the emulated board and compare it with the law in float on this machine."""
    if any(importlib.util.find_spec(name) is None for name in _NEEDED):
        return OnBoard(law, MISSING)
    from mehvar.report.board_facts import facts
    from mehvar.report.board_page import fact_rows, inputs_figure
    from mehvar.runtime.board.run import run_on_board

    try:
        outcome = run_on_board(model, BoardRequest(law, "unicorn", _BOARD, samples=_SAMPLES))
    except InputError as error:
        return OnBoard(law, f"Not run: {error}.")
    found = facts(outcome)
    return OnBoard(
        law,
        same=outcome.max_ulp == 0 and outcome.x.ulp == 0,
        title=f"{found['board']}, emulated by {found['target']}; {found['compiler']}",
        rows=fact_rows(found),
        image=found["image"]["sha256"],
        figure=inputs_figure(outcome),
    )
