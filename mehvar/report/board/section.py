# SPDX-License-Identifier: Apache-2.0
"""Section of the report on a model's laws on an emulated microcontroller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mehvar.base.errors import MissingError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mehvar.reproduction.runs import Runs
    from mehvar.runtime.board.run import BoardRun


@dataclass(frozen=True)
class OnBoard:
    """Run of a law on the emulated board; `extent` is the simulated part of the scenario."""

    law: str
    same: bool
    title: str
    extent: str
    rows: Sequence[tuple[str, str, str]]
    image: str
    figure: Figure


@dataclass(frozen=True)
class Boards:
    """Runs of all laws of a model on the emulated board, or the reason why there are none."""

    laws: Sequence[OnBoard] = ()
    missing: str = ""

    @property
    def same(self) -> bool:
        """True if every law is bit-identical to the host."""
        return all(law.same for law in self.laws)


def run_boards(runs: Runs) -> Boards:
    """Run each law on the emulated board and compare it with the law in float on this machine."""
    try:
        return Boards([_on_board(runs.board(law)) for law in runs.model.manifest.controllers])
    except MissingError as error:
        return Boards(missing=f"Not run: {error}.")


def _on_board(outcome: BoardRun) -> OnBoard:
    """Return the report's entry on a law; `same` is true if inputs and states are bit-identical."""
    from .facts import facts
    from .page import fact_rows, inputs_figure

    results = facts(outcome)
    return OnBoard(
        results["controller"],
        same=outcome.max_ulp == 0 and outcome.x.ulp == 0,
        title=f"{results['board']}, emulated by {results['target']}; {results['compiler']}",
        extent=_extent(outcome, results),
        rows=fact_rows(results),
        image=results["image"]["sha256"],
        figure=inputs_figure(outcome),
    )


def _extent(outcome: BoardRun, results: dict[str, Any]) -> str:
    """Return the simulated part of the scenario and the reason for an early end."""
    run = outcome.board
    whole, reached = run.scenario.duration, run.t[-1]
    part = "all" if reached >= whole else f"{reached:g} of the {whole:g} s"
    early = "" if results["status"] == "done" else f", where the run ended: {run.reason}"
    return f"{results['samples']} samples of {results['period']:g} s, {part} of scenario {run.scenario.name}{early}"
