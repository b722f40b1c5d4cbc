# SPDX-License-Identifier: Apache-2.0
"""Section of the report on a model's laws on an emulated microcontroller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mehvar.base.errors import MissingError
from mehvar.report.page import Block, Text

if TYPE_CHECKING:
    from mehvar.reproduction.runs import Runs
    from mehvar.runtime.board.run import BoardRun

_MADE = (
    "The firmware that mehvar board build makes of each law, run on an emulated board. Every input, memory number and "
    "state is compared with the law in float on this machine. No silicon has been touched."
)


@dataclass(frozen=True)
class OnBoard:
    """Run of a law on the emulated board: True if it has the host's bits, the hash of its image, and its blocks."""

    law: str
    same: bool
    image: str
    blocks: Sequence[Block] = ()


@dataclass(frozen=True)
class Boards:
    """Runs of all laws of a model on the emulated board, or the reason why there are none."""

    laws: Sequence[OnBoard] = ()
    missing: str = ""

    @property
    def same(self) -> bool:
        """True if every law is bit-identical to the host."""
        return all(law.same for law in self.laws)

    @property
    def blocks(self) -> list[Block]:
        """Blocks of the section."""
        return [Text(self.missing or _MADE), *(block for law in self.laws for block in law.blocks)]


def run_boards(runs: Runs) -> Boards:
    """Run each law on the emulated board and compare it with the law in float on this machine."""
    try:
        return Boards([on_board(runs.board(law)) for law in runs.model.manifest.controllers])
    except MissingError as error:
        return Boards(missing=f"Not run: {error}.")


def on_board(outcome: BoardRun) -> OnBoard:
    """Return the report's entry on a law."""
    from .facts import facts
    from .page import law_blocks

    results = facts(outcome)
    return OnBoard(results["controller"], outcome.same, results["image"]["sha256"], law_blocks(outcome, results))
