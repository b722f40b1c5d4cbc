# SPDX-License-Identifier: Apache-2.0
"""Evaluation of a law on a board, sample by sample, with recovery from failures of board, line and host."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError

from ..model.parameters import Resolved
from .image.build import Program
from .journal import Journal, Tuning
from .line.link import Answer, Link, LinkError, RestartError
from .tuning import Requests, tuned_parameters

_CHECKPOINT = 25
"""Samples between two reads of the board's memory, from which a reset board continues.

Reads add 4 % of exchanges, and a reset repeats at most 24 samples. With half the value these are 8 % and 12 samples.
"""
RESTARTS = 5
"""Largest number of resets at one sample. A disturbance causes one or two; five mean a defect."""

Reply = TypeVar("Reply")
Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]


class BoardLaw:
    """Law of a closed loop, evaluated on a board; give it to `simulate` as `law`.

    A board that lost its memory gets the last known memory and all later samples again. Its results do not change.

    Parameters
    ----------
    link : Link
        Connected.
    firmware : Program
        Program of the board.
    resolved : Resolved
        Parameters of the run.
    every : int
        Samples between two comparisons of the memory; 1 records it at each sample.
    journal : Journal, optional
        Samples evaluated before the host was stopped; they are not evaluated again.
    after : callable, optional
        Called after each sample that the board evaluated.
    requests : Requests, optional
        Requests for parameters while the law runs; needs a journal.
    restarts : int
        Number of restarts at one sample after which the run ends.
    """

    real = "float"

    def __init__(
        self,
        link: Link,
        firmware: Program,
        resolved: Resolved,
        every: int = 1,
        journal: Journal | None = None,
        after: Callable[[], None] | None = None,
        requests: Requests | None = None,
        restarts: int = RESTARTS,
    ) -> None:
        self.u: list[Floats] = []
        self.z: dict[int, Floats] = {}
        self.ticks: list[int] = []
        self.restored, self._restarts = 0, restarts
        self._link, self._firmware, self._every = link, firmware, every
        self._parameters = {0: resolved}
        self._memory = bool(firmware.law.memory)
        self._journal, self._requests, self._after = journal, requests, after
        self._numbers: list[Floats] = []
        self._start = np.empty(0, np.float32)
        self._checkpoint: tuple[int, Floats] = (0, self._start)

    def __call__(self, x: Doubles, r: Doubles, v: Doubles, z: Doubles) -> tuple[Doubles, Doubles]:
        """Return the board's input for the next sample."""
        numbers = np.concatenate([x, r, v] if self._memory else [x, r]).astype(np.float32)
        k = len(self._numbers)
        if k == 0:
            self._start = z.astype(np.float32)
            self.rewind()
        self._numbers.append(numbers)
        self._tune(k)
        u = None if self._journal is None else self._journal.answer(k, numbers)
        if u is None:
            u = self._evaluate(k)
        self.u.append(u)
        return u.astype(np.float64), self.z[k].astype(np.float64) if k in self.z else z

    def rewind(self) -> None:
        """Restore the memory at the run's start."""
        self._checkpoint = (0, self._start)

    def prepare(self) -> None:
        """Set parameters and the memory of the last checkpoint."""
        self._link.reset()
        self._set(self._latest(self._checkpoint[0]))
        self._link.set("z", self._checkpoint[1])

    def finish(self) -> None:
        """Write the final memory to the journal."""
        k = len(self._numbers)
        if self._journal is not None and self._memory and k > self._journal.length:
            self._journal.append_memory(self._at(k, lambda: self._link.get("z"), restore=False))

    def _set(self, resolved: Resolved) -> None:
        for group, values in (("p", resolved.p), ("c", resolved.c), ("s", resolved.s)):
            self._link.set(group, values)

    def _tune(self, k: int) -> None:
        """Apply the parameters requested before sample k, from the journal or new ones."""
        journal = self._journal
        if journal is None or self._requests is None:
            return
        for tuning in journal.tunings:
            if tuning.sample == k and not tuning.refusal:
                self._parameters[k] = tuned_parameters(self._firmware, self._latest(k), tuning.values)
        for request in self._requests.due(k) if k >= journal.length else ():
            try:
                self._parameters[k] = tuned_parameters(self._firmware, self._latest(k), request.values)
                refusal = ""
            except InputError as error:
                refusal = str(error)
            journal.append_tuning(Tuning(k, request.values, request.line, refusal))

    def _latest(self, k: int) -> Resolved:
        """Return the parameters at sample k."""
        return self._parameters[max(at for at in self._parameters if at <= k)]

    def _evaluate(self, k: int) -> Floats:
        """Return the law's input at sample k, and record what a restart at a later sample needs."""
        first = k == 0 or (self._journal is not None and self._journal.length == k)
        if k == 0 and self._journal is not None:
            self._journal.append_memory(self._start)
        answer = self._at(k, lambda: self._step(k), first)
        self.ticks.append(answer.ticks)
        if k % self._every == 0 or (k + 1) % _CHECKPOINT == 0:
            self._look(k)
        if self._journal is not None:
            self._journal.append(self._numbers[k], answer.u)
            if self._memory and (k + 1) % _CHECKPOINT == 0:
                self._journal.append_memory(self.z[k])
        if self._after is not None:
            self._after()
        return answer.u

    def _look(self, k: int) -> None:
        """Read the memory after sample k."""
        if not self._memory:
            return
        self.z[k] = self._at(k + 1, lambda: self._link.get("z"), restore=False)
        if (k + 1) % _CHECKPOINT == 0:
            self._checkpoint = (k + 1, self.z[k])

    def _at(self, k: int, request: Callable[[], Reply], restore: bool) -> Reply:
        """Send a request that needs the state before sample k; first restore it after a restart, or if asked."""
        for _ in range(self._restarts):
            try:
                if restore:
                    self._restore(k)
                return request()
            except RestartError:
                self.restored += 1
                self._link.connect()
                restore = True
        raise LinkError(f"the board lost its memory {self._restarts} times at sample {k}: allow more with --restarts N")

    def _restore(self, k: int) -> None:
        """Restore the board's state before sample k."""
        self.prepare()
        for past in range(self._checkpoint[0], k):
            self._step(past)

    def _step(self, k: int) -> Answer:
        """Evaluate sample k, after setting its new parameters."""
        if k in self._parameters and k > 0:
            self._set(self._parameters[k])
        return self._link.step(self._numbers[k])
