# SPDX-License-Identifier: Apache-2.0
"""A law evaluated on a board, sample by sample, whatever happens to board, line or host in between."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from mehvar.errors import InputError

from ..model.parameters import Resolved
from .image.header import Layout
from .line.link import Link, LinkError, RestartError

_CHECKPOINT = 25
"""Samples between two looks at the board's memory, from which a board that was reset goes on.

A look is one exchange more in 25; a reset costs at most 24 samples again. Half as many make it 8 % and 12 samples.
"""
_RESTORES = 5
"""A disturbance resets a board once, and once more while it is brought back; five times at one sample is a defect."""

Reply = TypeVar("Reply")
Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]


class BoardLaw:
    """The law of a closed loop, evaluated on a board; give it to `simulate` as `law`.

    A board that has lost its memory gets the last known one, is given the samples since then again, and goes on as if
    nothing had happened.

    Parameters
    ----------
    link : Link
        Connected.
    resolved : Resolved
        Parameters of the run.
    layout : Layout
        Of model and law.
    every : int
        Samples between two comparisons of the memory; 1 records it at each sample.
    journal : Journal, optional
        Samples that were evaluated before the host was stopped; they are not evaluated again.
    after : callable, optional
        Called after each sample that the board evaluated.
    """

    def __init__(
        self,
        link: Link,
        resolved: Resolved,
        layout: Layout,
        every: int = 1,
        journal: Journal | None = None,
        after: Callable[[], None] | None = None,
    ) -> None:
        self.u: list[Floats] = []
        self.z: dict[int, Floats] = {}
        self.ticks: list[int] = []
        self.restored = 0
        self._link, self._resolved, self._every = link, resolved, every
        self._memory = bool(layout.memory)
        self._journal, self._after = journal, after
        self._numbers: list[Floats] = []
        self._start = np.empty(0, np.float32)
        self._checkpoint: tuple[int, Floats] = (0, self._start)

    def __call__(self, x: Doubles, r: Doubles, v: Doubles, z: Doubles) -> tuple[Doubles, Doubles]:
        """Evaluate the law at the next sample."""
        numbers = np.concatenate([x, r, v] if self._memory else [x, r]).astype(np.float32)
        k = len(self._numbers)
        if k == 0:
            self._start = z.astype(np.float32)
            self.rewind()
        self._numbers.append(numbers)
        u = None if self._journal is None else self._journal.answer(k, numbers)
        if u is None:
            u = self._evaluate(k)
        self.u.append(u)
        return u.astype(np.float64), self.z[k].astype(np.float64) if k in self.z else z

    def rewind(self) -> None:
        """Go back to the memory that the run started from."""
        self._checkpoint = (0, self._start)

    def prepare(self) -> None:
        """Set parameters and the memory of the last checkpoint."""
        self._link.reset()
        for group, values in (("p", self._resolved.p), ("c", self._resolved.c), ("s", self._resolved.s)):
            self._link.set(group, values)
        self._link.set("z", self._checkpoint[1])

    def _evaluate(self, k: int) -> Floats:
        first = k == 0 or (self._journal is not None and self._journal.length == k)
        answer = self._at(k, lambda: self._link.step(self._numbers[k]), first)
        self.ticks.append(answer.ticks)
        if k % self._every == 0 or (k + 1) % _CHECKPOINT == 0:
            self._look(k)
        if self._journal is not None:
            self._journal.append(self._numbers[k], answer.u)
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
        """Ask the board as it is before sample k; one that has started anew is brought back there first."""
        for _ in range(_RESTORES):
            try:
                if restore:
                    self._restore(k)
                return request()
            except RestartError:
                self.restored += 1
                self._link.connect()
                restore = True
        raise LinkError(f"the board lost its memory {_RESTORES} times at sample {k}")

    def _restore(self, k: int) -> None:
        """Bring the board to where it was before sample k."""
        self.prepare()
        for past in range(self._checkpoint[0], k):
            self._link.step(self._numbers[past])


class Journal:
    """What a board has answered so far, on disk: a host that was stopped goes on from there.

    Parameters
    ----------
    path : Path
        Continued when it exists.
    identity : mapping
        What makes a run the same one.

    Raises
    ------
    InputError
        If the file belongs to another run.
    """

    def __init__(self, path: Path, identity: dict[str, object], inputs: int, outputs: int) -> None:
        self._path, self._inputs = path, inputs
        self._record = 4 * (inputs + outputs)
        head = json.dumps(identity, sort_keys=True).encode() + b"\n"
        content = path.read_bytes() if path.exists() else b""
        if content and not content.startswith(head):
            raise InputError(f"journal = {str(path)!r}: it belongs to another run; remove it or choose another name")
        body = content[len(head) :]
        self.length = len(body) // self._record
        whole = body[: self.length * self._record]
        self._rows = np.frombuffer(whole, "<f4").astype(np.float32).reshape(self.length, inputs + outputs)
        self._file: BinaryIO = path.open("r+b" if content else "wb")
        self._file.write(head + whole)
        self._file.truncate()
        self._file.flush()

    def answer(self, k: int, numbers: Floats) -> Floats | None:
        """Return the answer to sample k when there is one, after a look at whether the question was the same."""
        if k >= self.length:
            return None
        if self._rows[k, : self._inputs].tobytes() != numbers.tobytes():
            raise InputError(f"journal = {str(self._path)!r}: sample {k} was another one; remove the file")
        return self._rows[k, self._inputs :]

    def append(self, numbers: Floats, u: Floats) -> None:
        """Write a sample through to the disk's cache: it survives the end of this process."""
        self._file.write(numbers.astype("<f4").tobytes() + u.astype("<f4").tobytes())
        self._file.flush()

    def close(self, complete: bool) -> None:
        """Close the file, and remove it when the run is done."""
        self._file.close()
        if complete:
            self._path.unlink()
