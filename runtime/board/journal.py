# SPDX-License-Identifier: Apache-2.0
"""Journal of a board's answers on disk, with which a stopped host can continue and a run can be repeated.

The first line is JSON and identifies the run. Records follow, each a letter and its content: `s` a sample (numbers
sent and received, in float), `t` parameters set before the next sample (the length, u32, then JSON), `z` the law's
memory at that point, `e` the end. Each record is followed by the CRC-32 of everything before it in the file.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError

from .image.header import Layout

_SAMPLE, _TUNING, _MEMORY, _END = b"s", b"t", b"z", b"e"
_LENGTH = struct.Struct("<I")  # format of lengths and CRCs

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Tuning:
    """Parameters requested during a run.

    Attributes
    ----------
    sample : int
        The first sample with them.
    values : mapping of str to float
        By name.
    request : int
        Line of the requests file with the request.
    refusal : str
        Reason why they were not set, or an empty text.
    """

    sample: int
    values: Mapping[str, float]
    request: int
    refusal: str = ""


@dataclass(frozen=True)
class Entries:
    """Contents of a journal.

    Attributes
    ----------
    identity : mapping
        Identity of the run.
    rows : array, (n, inputs + outputs)
        Numbers sent to the board and received from it, for each sample.
    tunings : tuple of Tuning
        Changes of parameters, in order.
    memories : mapping of int to array
        The law's memory before a sample.
    size : int
        Bytes of complete records.
    check : int
        CRC-32 of the last complete record, from which the next one continues.
    complete : bool
        True if the run came to its end.
    """

    identity: Mapping[str, object]
    rows: Floats
    tunings: tuple[Tuning, ...]
    memories: Mapping[int, Floats]
    size: int
    check: int
    complete: bool


def read_journal(path: Path, layout: Layout) -> Entries:
    """Return the contents of a journal without an incomplete last record.

    Raises
    ------
    InputError
        If the file is not a journal of this model and law, or is damaged.
    """
    content = path.read_bytes()
    head, newline, _ = content.partition(b"\n")
    identity = _identity(head) if newline else None
    if identity is None or identity.get("layout") != layout.hash.hex():
        raise InputError(
            f"journal = {str(path)!r}: belongs to another version of {layout.model} {layout.law}; choose another name"
        )
    at, complete, check = len(head) + 1, False, zlib.crc32(head + newline)
    inputs, outputs, numbers = layout.sizes[:3]
    rows: list[Floats] = []
    tunings: list[Tuning] = []
    memories: dict[int, Floats] = {}
    sizes = {_SAMPLE: 4 * (inputs + outputs), _MEMORY: 4 * numbers, _END: 0}
    while at < len(content):
        kind, start = content[at : at + 1], at + 1
        if kind == _TUNING and len(content) >= start + _LENGTH.size:
            size = _LENGTH.size + _LENGTH.unpack_from(content, start)[0]
        else:
            size = sizes.get(kind, 0)
        body, end = content[start : start + size], start + size
        if (kind in sizes or kind == _TUNING) and len(content) < end + _LENGTH.size:
            break
        check = zlib.crc32(kind + body, check)
        if content[end : end + _LENGTH.size] != _LENGTH.pack(check):
            raise InputError(
                f"journal = {str(path)!r}: the file is damaged at or before byte {at}, so its run cannot be identified"
            )
        if kind == _SAMPLE:
            rows.append(np.frombuffer(body, "<f4").astype(np.float32))
        elif kind == _MEMORY:
            memories[len(rows)] = np.frombuffer(body, "<f4").astype(np.float32)
        elif kind == _TUNING:
            tunings.append(Tuning(len(rows), **json.loads(body[_LENGTH.size :])))
        complete |= kind == _END
        at = end + _LENGTH.size
    table = np.stack(rows) if rows else np.empty((0, inputs + outputs), np.float32)
    return Entries(identity, table, tuple(tunings), memories, at, check, complete)


def _identity(head: bytes) -> dict[str, object] | None:
    try:
        identity = json.loads(head)
    except (ValueError, RecursionError):
        return None
    return identity if isinstance(identity, dict) else None


class Journal:
    """A journal during a run.

    Parameters
    ----------
    path : Path
        File, continued if it exists.
    identity : mapping
        Facts that identify a run; `layout` is added.

    Raises
    ------
    InputError
        If the file belongs to another run or to a completed one.
    """

    def __init__(self, path: Path, identity: Mapping[str, object], layout: Layout) -> None:
        self._path, self._inputs = path, layout.sizes[0]
        whole: dict[str, object] = {**identity, "layout": layout.hash.hex()}
        head = json.dumps(whole, sort_keys=True).encode() + b"\n"
        content = path.read_bytes() if path.exists() else b""
        if content and not content.startswith(head):
            raise InputError(f"journal = {str(path)!r}: it belongs to another run; remove it or choose another name")
        entries = read_journal(path, layout) if content else None
        if entries is not None and entries.complete:
            raise InputError(
                f"journal = {str(path)!r}: its run is complete. Compute it again by `mehvar board replay`, "
                "or choose another name for a new run"
            )
        self._rows: Floats = np.empty((0, 0), np.float32) if entries is None else entries.rows
        self.tunings: list[Tuning] = [] if entries is None else list(entries.tunings)
        self.length = len(self._rows)
        self._check = zlib.crc32(head) if entries is None else entries.check
        self._file: BinaryIO = path.open("r+b" if content else "wb")
        whole_records = content[: entries.size] if entries else head
        self._file.write(whole_records)
        self._file.truncate()
        self._file.flush()

    def answer(self, k: int, numbers: Floats) -> Floats | None:
        """Return the recorded answer to sample k, if any; refuse different numbers."""
        if k >= self.length:
            return None
        if self._rows[k, : self._inputs].tobytes() != numbers.tobytes():
            raise InputError(
                f"journal = {str(self._path)!r}: sample {k} differs from the recorded one; remove the file"
            )
        return self._rows[k, self._inputs :]

    def append(self, numbers: Floats, u: Floats) -> None:
        """Write a sample to the operating system's cache, where it survives the end of this process."""
        self._write(_SAMPLE, numbers.astype("<f4").tobytes() + u.astype("<f4").tobytes())

    def append_memory(self, z: Floats) -> None:
        """Write the law's memory after the last sample."""
        self._write(_MEMORY, z.astype("<f4").tobytes())

    def append_tuning(self, tuning: Tuning) -> None:
        """Write parameters before they are set, or refused parameters."""
        self.tunings.append(tuning)
        row = {"values": dict(tuning.values), "request": tuning.request, "refusal": tuning.refusal}
        text = json.dumps(row).encode()
        self._write(_TUNING, _LENGTH.pack(len(text)) + text)

    def close(self, complete: bool) -> None:
        """Close the file, and remove it after a complete run without tuning."""
        kept = any(not tuning.refusal for tuning in self.tunings)
        if complete and kept:
            self._write(_END, b"")
        self._file.close()
        if complete and not kept:
            self._path.unlink()

    def _write(self, kind: bytes, body: bytes) -> None:
        self._check = zlib.crc32(kind + body, self._check)
        self._file.write(kind + body + _LENGTH.pack(self._check))
        self._file.flush()
