# SPDX-License-Identifier: Apache-2.0
"""Runs for figures and claims, on this machine and on an emulated board, each computed once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mehvar.base.errors import MissingError
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.options import split_settings
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import simulate

if TYPE_CHECKING:
    from mehvar.runtime.board.run import BoardRun
    from mehvar.runtime.model.model import Model
    from mehvar.runtime.run.simulate import Run

_BOARD = "mps2-m4f"
"""Emulated board, a Cortex-M4F as in the satellite's paper, emulated 1.5 times as fast as the STM32F405."""
_MOST_SAMPLES = 4001
"""Largest number of samples on an emulated board: 80 s of a law with a period of 20 ms. Emulation of 400 (with
estimator) to 1200 samples a second takes up to ten seconds.
"""


class Runs:
    """Closed loops of one model; each is integrated once.

    Attributes
    ----------
    model : Model
        The model.
    paper : Runs
        Loops of the paper's model, beside which those of an extension run; else these loops.
    compile_seconds, run_seconds : float
        Total times for compiling or loading code, and for integration.
    """

    def __init__(self, model: Model, paper: Runs | None = None) -> None:
        self.model, self.paper = model, paper or self
        self.compile_seconds = 0.0
        self.run_seconds = 0.0
        self._runs: dict[tuple[object, ...], Run] = {}
        self._board_runs: dict[tuple[object, ...], BoardRun] = {}

    def __len__(self) -> int:
        return len(self._runs)

    def __call__(
        self, controller: str, scenario: str, initial: Mapping[str, float] | None = None, **settings: Any
    ) -> Run:
        """Return a run; `settings` are options and parameters of `mehvar.runtime.run.simulate.simulate`."""
        key = (controller, scenario, *sorted((initial or {}).items()), *sorted(settings.items()))
        if key not in self._runs:
            run = simulate(self.model, controller, scenario, initial=initial, **settings)
            self.compile_seconds += run.compile_seconds
            self.run_seconds += run.run_seconds
            self._runs[key] = run
        return self._runs[key]

    def metrics(self, controller: str, scenario: str, **settings: Any) -> dict[str, float]:
        """Return the metrics of a run by name."""
        return metrics(self(controller, scenario, **settings), self.model.manifest)

    def under(self, **settings: Any) -> Runs:
        """Return the loops with further settings, such as another reading of a paper, which a call may override."""
        return _OtherRuns(self, settings)

    def board(
        self, controller: str, scenario: str | None = None, samples: int | None = None, **settings: Any
    ) -> BoardRun:
        """Return a run with its law on an emulated board, and the same run in float and double on this machine.

        Parameters
        ----------
        controller, scenario : str
            The law, and the scenario; default: the model's first one.
        samples : int, optional
            Number of evaluations of the law; default: the whole scenario or a few seconds of emulation.
        **settings
            Options of the run and parameters; for a law designed for a delay, `delay` is one sample by default.

        Raises
        ------
        MissingError
            Without a C compiler, a compiler for ARM or the emulator.
        """
        case = self.model.manifest.scenario(scenario).name
        key = (controller, case, samples, *sorted(settings.items()))
        if key not in self._board_runs:
            self._board_runs[key] = self._on_board(controller, case, samples, settings)
        return self._board_runs[key]

    def _on_board(self, controller: str, scenario: str, samples: int | None, settings: Mapping[str, Any]) -> BoardRun:
        """Return a run on the emulated board; refuse it without a C compiler or the emulator's packages."""
        model = self.model
        if model.backend != "c":
            raise MissingError('a law on a board needs a C compiler: pip install "mehvar[cc]"')
        try:
            from mehvar.runtime.board.run import BoardRequest, run_on_board, samples_of

            parameters, options = split_settings(settings, model.manifest.choices, "board", "the figure")
            request = BoardRequest(
                controller, "unicorn", _BOARD, scenario=scenario, parameters=parameters, options=options
            )
            number = samples or min(samples_of(model, request), _MOST_SAMPLES)
            return run_on_board(model, replace(request, samples=number))
        except ModuleNotFoundError as error:
            raise MissingError(f'a law on a board needs {error.name}: pip install "mehvar[board]"') from error


class _OtherRuns(Runs):
    """Loops with further settings and the same cache."""

    def __init__(self, runs: Runs, settings: Mapping[str, Any]) -> None:
        super().__init__(runs.model, runs.paper)
        self._base, self._settings = runs, settings

    def __call__(
        self, controller: str, scenario: str, initial: Mapping[str, float] | None = None, **settings: Any
    ) -> Run:
        return self._base(controller, scenario, initial, **{**self._settings, **settings})


class WatchedRuns(_OtherRuns):
    """Loops with a record of the requested runs.

    Attributes
    ----------
    seen : list of Run
        Requested runs in the order of the calls.
    """

    def __init__(self, runs: Runs) -> None:
        super().__init__(runs, {})
        self.seen: list[Run] = []

    def __call__(
        self, controller: str, scenario: str, initial: Mapping[str, float] | None = None, **settings: Any
    ) -> Run:
        """Return a run, and record it."""
        run = super().__call__(controller, scenario, initial, **settings)
        self.seen.append(run)
        return run

    @property
    def lost(self) -> list[Run]:
        """Runs that ended early."""
        return [run for run in self.seen if run.status is not Status.DONE]
