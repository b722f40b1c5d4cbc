# SPDX-License-Identifier: Apache-2.0
"""Tuning of a law during a run on a board, and repetition of such runs on this machine.

A request is a line in a file next to the journal, which the board's host applies between two samples.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import Controller, Manifest

from ..model.functions import CBackend, Real
from ..model.model import Model
from ..model.parameters import Resolved, number, resolve
from .image.build import Program, program
from .image.header import Layout, layout
from .journal import Tuning, read_journal

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Request:
    """A line of the requests file, with parameters from sample `at` or from the next sample on."""

    line: int
    at: int | None
    values: Mapping[str, float]


_BEGIN = '{"at": '
"""First line of the file. A file without it is the user's, and `close` must not remove it."""


class Requests:
    """Requests file of a run.

    Parameters
    ----------
    journal : Path
        Journal of the run.
    taken : sequence of Tuning
        Requests that the journal already contains.

    Raises
    ------
    InputError
        If a file of that name contains no requests.
    """

    def __init__(self, journal: Path, taken: Sequence[Tuning] = ()) -> None:
        self._path = path_of(journal)
        self._taken = {tuning.request for tuning in taken}
        self._size = -1
        self._requests: list[Request] = []
        self._read()

    def due(self, k: int) -> list[Request]:
        """Return new requests for sample k; each is returned once."""
        self._read()
        due = [request for request in self._requests if request.at is None or request.at <= k]
        self._taken |= {request.line for request in due}
        self._requests = [request for request in self._requests if request.line not in self._taken]
        return due

    def close(self) -> tuple[Request, ...]:
        """Remove the file at the end of the run, and return late requests."""
        self._read()
        self._path.unlink(missing_ok=True)
        return tuple(self._requests)

    def _read(self) -> None:
        """Read the requests from the file if its size has changed; requests that were taken stay out."""
        size = self._path.stat().st_size if self._path.exists() else 0
        if size == self._size:
            return
        self._size = size
        try:
            text = self._path.read_text(encoding="utf-8") if size else ""
            if not text.startswith(_BEGIN[: len(text)]):
                raise ValueError(text)
            rows = [(i, json.loads(line)) for i, line in enumerate(text.split("\n")[:-1])]
            self._requests = [Request(i, row["at"], row["values"]) for i, row in rows if i not in self._taken]
        except (ValueError, LookupError, TypeError, RecursionError) as error:
            raise InputError(f"{self._path} contains no tuning request: remove it, or name another journal") from error


def path_of(journal: Path) -> Path:
    """Return the requests file of a journal."""
    return journal.with_name(f"{journal.name}.tune")


def tune(
    model: Model, controller: str, journal: Path, values: Mapping[str, object], at: int | None = None
) -> dict[str, float]:
    """Request parameters from the run that writes a journal, between two of its samples.

    Only the law on the board changes, not the host's plant; parameters with formulas keep their values.

    Parameters
    ----------
    values : mapping of str to number
        By name, in SI units and radians.
    at : int, optional
        First sample with the new values; default: the next one.

    Returns
    -------
    dict of str to float
        The requested values.

    Raises
    ------
    InputError
        If a name is not a parameter of plant or law, a value is out of bounds or of the range of float, a parameter
        is the law's period, or the run ends before that sample.
    """
    law = model.manifest.controller(controller)
    if not values:
        raise InputError("nothing to tune: give at least one NAME=VALUE")
    if at is not None and at < 0:
        raise bad_value("at", at, "a whole number >= 0")
    if journal.is_file():
        _check_open(journal, layout(model.manifest, law), at)
    numbers = {name: _value(model.manifest, law, name, value) for name, value in values.items()}
    row = json.dumps({"at": at, "values": numbers}) + "\n"
    path = path_of(journal)
    try:
        with path.open("a", encoding="utf-8") as file:
            file.write(row)
    except OSError as error:
        raise InputError(f"journal = {str(journal)!r}: {path} cannot be written ({error.strerror})") from error
    return numbers


def _check_open(journal: Path, sizes: Layout, at: int | None) -> None:
    """Refuse a request that the run can no longer apply."""
    entries = read_journal(journal, sizes)
    if entries.complete:
        raise InputError(f"journal = {str(journal)!r}: its run is over; tune during a run")
    samples = entries.identity.get("samples")
    if at is not None and isinstance(samples, int) and at >= samples:
        raise bad_value("at", at, f"a sample of the run, which has {samples}: at most {samples - 1}")


def _value(manifest: Manifest, law: Controller, name: str, value: object) -> float:
    """Return a value for a run on a board; refuse names and values that no running law can take."""
    parameters = {q.name: q for q in (*manifest.parameters, *law.parameters)}
    if name not in parameters:
        raise unknown_name(f"parameter of {manifest.model} under {law.name}", name, parameters, "--set")
    if name in (law.period, law.delay):
        raise bad_value(name, value, "constant during a run: the clock of the run depends on it", "--set")
    result = number(name, value, "--set")
    if not parameters[name].allows(result):
        raise bad_value(name, result, f"in {parameters[name].allowed}", "--set")
    with np.errstate(over="ignore"):
        if not np.isfinite(np.float32(result)):
            raise bad_value(name, result, "a finite float", "--set")
    return result


def tuned_parameters(firmware: Program, before: Resolved, values: Mapping[str, float]) -> Resolved:
    """Return parameters with some changed.

    Raises
    ------
    InputError
        If the model's constraints refuse them, or they are constants of the law's code.
    """
    if firmware.tunable is not None:
        for name in values:
            if name not in firmware.tunable:
                raise unknown_name("tunable", name, firmware.tunable, "--tunable")
    model = firmware.model
    new = {**before.values, **values}
    return resolve(model.manifest, model.functions, firmware.law, firmware.scenario, new, "tuned")


class HostLaw:
    """The law on this machine with the board's parameter changes; give it to `simulate` as `law`.

    Parameters
    ----------
    resolved : Resolved
        Parameters at the start.
    tunings : sequence of Tuning
        Later requests; refused ones change nothing.
    real : {"float", "double"}
        Its number type.
    """

    def __init__(
        self, firmware: Program, resolved: Resolved, tunings: Sequence[Tuning] = (), real: Real = "float"
    ) -> None:
        self.real = real
        self._firmware, self._resolved, self._k = firmware, resolved, 0
        self._tunings = [tuning for tuning in tunings if not tuning.refusal]

    def __call__(self, x: Doubles, r: Doubles, v: Doubles, z: Doubles) -> tuple[Doubles, Doubles]:
        """Return the law's input for the next sample, and its memory."""
        for tuning in self._tunings:
            if tuning.sample == self._k:
                self._resolved = tuned_parameters(self._firmware, self._resolved, tuning.values)
        self._k += 1
        model, law = self._firmware.model, self._firmware.law
        assert isinstance(model.evaluator, CBackend)
        evaluate = partial(model.evaluator.narrow, law.name) if self.real == "float" else model.functions[law.name]
        arguments = (x, r, v, z) if law.memory else (x, r)
        results = evaluate(*arguments, self._resolved.p, self._resolved.c)
        return results if law.memory else (results, z)


@dataclass(frozen=True)
class Replay:
    """Result of a journal's repetition on this machine.

    Attributes
    ----------
    samples, memories : int
        Number of the board's answers, and of its memory values, that were compared.
    tunings : tuple of Tuning
        Applied and refused requests.
    first : int or None
        First sample with a different answer or memory; None if all are bit-identical.
    complete : bool
        True if the journal contains the end of its run.
    """

    samples: int
    memories: int
    tunings: tuple[Tuning, ...]
    first: int | None
    complete: bool


def replay(model: Model, controller: str, journal: Path) -> Replay:
    """Repeat a journal's answers in float on this machine, and compare them bit by bit.

    Raises
    ------
    InputError
        If the journal does not exist, is damaged, or belongs to another model or law.
    """
    law = model.manifest.controller(controller)
    sizes = layout(model.manifest, law)
    if not journal.is_file():
        raise InputError(f"journal = {str(journal)!r}: there is no such file")
    entries = read_journal(journal, sizes)
    identity = entries.identity
    scenario, values = identity["scenario"], identity["parameters"]
    assert isinstance(scenario, str)
    assert isinstance(values, dict)
    firmware = program(model, controller, scenario)
    resolved = resolve(model.manifest, model.functions, law, firmware.scenario, values, "journal")
    host = HostLaw(firmware, resolved, entries.tunings)
    inputs, edges = sizes.sizes[0], np.cumsum([len(model.manifest.seen), len(model.manifest.references)])
    z = np.zeros(len(sizes.memory)) if 0 not in entries.memories else entries.memories[0].astype(np.float64)
    compared, different = 0, []
    for k in range(len(entries.rows) + 1):
        if k in entries.memories:
            compared += entries.memories[k].size
            different += [] if _same(z, entries.memories[k]) else [k]
        if k < len(entries.rows):
            row = entries.rows[k]
            x, r, v = np.split(row[:inputs].astype(np.float64), edges)
            u, z = host(x, r, v, z)
            different += [] if _same(u, row[inputs:]) else [k]
    first = different[0] if different else None
    return Replay(len(entries.rows), compared, entries.tunings, first, entries.complete)


def _same(one: Doubles, other: NDArray[np.float32]) -> bool:
    return one.astype(np.float32).tobytes() == other.tobytes()
