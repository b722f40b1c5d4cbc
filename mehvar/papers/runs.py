# SPDX-License-Identifier: Apache-2.0
"""The runs behind figures and claims, each integrated once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.simulate import simulate

if TYPE_CHECKING:
    from mehvar.runtime.model.model import Model
    from mehvar.runtime.run.simulate import Run


class Runs:
    """Closed loops of one model, each integrated once.

    Attributes
    ----------
    compile_seconds, run_seconds : float
        Time spent so far to compile or load the code, and to integrate.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.compile_seconds = 0.0
        self.run_seconds = 0.0
        self._runs: dict[tuple[object, ...], Run] = {}

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
        """Return the same loops with further settings, which a call may still override: another reading of a paper."""
        return _OtherRuns(self, settings)


class _OtherRuns(Runs):
    """Loops with further settings; what is integrated is kept where the others are."""

    def __init__(self, runs: Runs, settings: Mapping[str, Any]) -> None:
        super().__init__(runs.model)
        self._base, self._settings = runs, settings

    def __call__(
        self, controller: str, scenario: str, initial: Mapping[str, float] | None = None, **settings: Any
    ) -> Run:
        return self._base(controller, scenario, initial, **{**self._settings, **settings})
