# SPDX-License-Identifier: Apache-2.0
"""Link to a board, which repeats each request until its answer; request types are in firmware/mehvar/server.h."""

from __future__ import annotations

import secrets
import struct
import time
from dataclasses import dataclass, field
from enum import IntFlag
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, MehvarError

from ..image.header import Layout
from .frames import Decoder, Frame, encode

FloatArray = NDArray[np.float32]
HELLO, RESET, STEP, GET, SET, STATS, SELFTEST, REBOOT, NAK, REPLY = 1, 2, 3, 4, 5, 6, 7, 8, 0x7F, 0x80
_REFUSALS = {
    1: "it does not know this type of request",
    2: "the payload has the wrong size",
    3: "it has no memory to start from",
    4: "it has started since, or serves another host",
    5: "its number is neither the next nor the last request number",
    6: "a number is infinite or not a number",
    7: "it runs a law for another host, until this host sends nothing for two samples",
    8: "a parameter that was compiled in has another value; build and flash it again, or make it tunable",
}
_NO_SESSION = 4
_VERSION = 2
_HELLO = struct.Struct("<BB16s7HI16s16s16s")
_STATS = (
    "steps", "duplicates", "refused", "lost", "nonfinite", "ticks_last", "ticks_least", "ticks_most",
    "stack_used", "stack_size", "frames", "crc_errors", "length_errors", "cobs_errors", "ms",
)  # fmt: skip


class LinkError(MehvarError, RuntimeError):
    """Error if the board does not answer, or its answer is invalid."""

    exit_status = 3


class ClosedError(LinkError):
    """Error if the line has closed, so that nothing can answer."""


class RestartError(LinkError):
    """Error if the board restarted or served another host, so that its memory and parameters are unknown."""


class Flags(IntFlag):
    """Flags in the board's answer to a step."""

    LOST = 1
    DUPLICATE = 2
    ABORTED = 4
    NONFINITE = 8
    FRESH = 16


class Port(Protocol):
    """A line to a board."""

    name: str

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def read(self, timeout: float) -> bytes:
        """Return received bytes; wait up to `timeout` seconds for the first."""

    def close(self) -> None:
        """Close the line and its emulator."""


@dataclass(frozen=True)
class Hello:
    """Description of a board, from its hello."""

    real_size: int
    hash: bytes
    sizes: tuple[int, ...]
    ticks_per_second: int
    board: str
    model: str
    law: str


@dataclass(frozen=True)
class Answer:
    """A board's answer to a step."""

    u: FloatArray
    ticks: int
    flags: Flags


@dataclass(frozen=True)
class SelfTest:
    """Result of a self-test: samples, CRC-32 of all inputs, slowest step in ticks, final state and input."""

    samples: int
    crc: int
    ticks: int
    x: FloatArray
    u: FloatArray


@dataclass
class Counters:
    """The host's counters of the line."""

    requests: int = 0
    resent: int = 0
    stale: int = 0
    damaged: int = 0
    flags: dict[str, int] = field(default_factory=dict)

    def as_dict(self) -> dict[str, int]:
        """Return the numbers by name."""
        own = {"requests": self.requests, "resent": self.resent, "stale": self.stale, "damaged": self.damaged}
        return own | self.flags


class Link:
    """Host end of the line.

    Parameters
    ----------
    port : Port
        The line.
    layout : Layout
        Layout of the model and law that the board must run.
    timeout : float
        Seconds to wait for an answer before the request is sent again, several times the 2 x 35 ms that 400 bytes
        take at 115200 baud. A delayed step is not evaluated twice, so that a shorter time only causes traffic.
    tries : int
        Number of attempts per request: five seconds with the default timeout, long enough for a board to restart.
    """

    def __init__(self, port: Port, layout: Layout, timeout: float = 0.25, tries: int = 20) -> None:
        self.counters = Counters()
        self._port, self.layout = port, layout
        self._timeout, self._tries = timeout, tries
        self._decoder = Decoder()
        self._session = 1 + secrets.randbelow(0xFFFF)
        self._number = 0

    def connect(self, patience: float = 10.0) -> Hello:
        """Connect to the board, and check that it serves this host with the right program.

        The board then has its compiled-in parameters and no memory.

        Raises
        ------
        LinkError
            If nothing answers for `patience` seconds, or the board serves another host during this time.
        InputError
            If the board runs another model, law or version.
        """
        begin = time.monotonic()
        tries, timeout = self._tries, self._timeout
        self._tries, self._timeout = 1, min(timeout, 0.05)  # repeat quickly: the board may not listen yet
        try:
            while True:
                try:
                    return self._checked(self._request(HELLO))
                except ClosedError:
                    raise
                except LinkError as error:
                    if time.monotonic() - begin > patience:
                        hint = "check its port, baud rate and image"
                        raise LinkError(
                            f"no answer from {self._port.name} in {patience:g} s ({error}): {hint}"
                        ) from error
        finally:
            self._tries, self._timeout = tries, timeout

    def reset(self) -> None:
        """Clear memory and counters, and restore compiled-in parameters."""
        self._request(RESET)

    def step(self, numbers: FloatArray) -> Answer:
        """Evaluate the law once, even if the request is sent repeatedly.

        Raises
        ------
        RestartError
            If the board has no memory yet.
        """
        reply = self._request(STEP, numbers.astype("<f4").tobytes())
        size = 4 * self.layout.sizes[1]
        if len(reply.payload) != size + 4:
            raise LinkError(f"the answer to a step has {len(reply.payload)} bytes instead of {size + 4}")
        flags = Flags(reply.flags)
        for flag in flags:
            name = (flag.name or "").lower()
            self.counters.flags[name] = self.counters.flags.get(name, 0) + 1
        if flags & Flags.FRESH:
            raise RestartError(f"{self._port.name}: the board lost the law's memory, so the run cannot continue")
        u = np.frombuffer(reply.payload[:size], "<f4").astype(np.float32)
        return Answer(u, int.from_bytes(reply.payload[size:], "little"), flags)

    def get(self, group: str) -> FloatArray:
        """Return the memory "z" or parameters "p", "c", "s".

        Raises
        ------
        RestartError
            If the board has no memory yet.
        """
        reply = self._request(GET, bytes([_group(group)]))
        if group == "z" and reply.flags & Flags.FRESH:
            raise RestartError(f"{self._port.name}: the board has no memory of the law yet, as after a restart")
        return np.frombuffer(reply.payload, "<f4").astype(np.float32)

    def set(self, group: str, values: NDArray[np.floating]) -> None:
        """Set the memory "z" or parameters "p", "c", "s"."""
        self._request(SET, bytes([_group(group)]) + values.astype("<f4").tobytes())

    def stats(self) -> dict[str, int]:
        """Return the board's counters."""
        payload = self._request(STATS).payload
        numbers = struct.unpack_from(f"<{len(_STATS)}I", payload)
        return dict(zip(_STATS, numbers, strict=True))

    def output(self) -> FloatArray:
        """Return the inputs that the board's actuators currently apply."""
        payload = self._request(STATS).payload
        return np.frombuffer(payload[4 * len(_STATS) :], "<f4").astype(np.float32)

    def selftest(self, samples: int, timeout: float = 600.0) -> SelfTest:
        """Run law and plant on the target from the given memory and parameters; the memory is lost."""
        before, self._timeout = self._timeout, timeout
        try:
            payload = self._request(SELFTEST, samples.to_bytes(4, "little")).payload
        except KeyboardInterrupt:
            self._port.write(b"\0")  # any byte ends the test
            raise
        finally:
            self._timeout = before
        count, crc, ticks = struct.unpack_from("<3I", payload)
        if count != samples:
            done = f"after {count} of {samples} samples"
            raise LinkError(f"{self._port.name}: a byte on the line interrupted the self-test {done}")
        numbers = np.frombuffer(payload[12:], "<f4").astype(np.float32)
        states = self.layout.sizes[6]
        return SelfTest(count, crc, ticks, numbers[:states], numbers[states:])

    def reboot(self) -> None:
        """Restart the board's program without an answer."""
        self._port.write(encode(Frame(REBOOT, 0, self._session, self._next(), b"")))

    def _next(self) -> int:
        self._number += 1
        return self._number

    def _request(self, kind: int, payload: bytes = b"") -> Frame:
        """Return the answer to a request, which is sent again, with the same number, until it has one."""
        request = Frame(kind, 0, self._session, self._next(), payload)
        data = encode(request)
        self.counters.requests += 1
        for attempt in range(self._tries):
            self.counters.resent += attempt > 0
            self._port.write(data)
            reply = self._await(request)
            if reply is not None:
                return reply
        raise LinkError(f"no answer to request {kind} number {request.number} after {self._tries} tries")

    def _await(self, request: Frame) -> Frame | None:
        """Return the answer to a request; None after the timeout. Answers to earlier requests are counted."""
        end = time.monotonic() + self._timeout
        while (wait := end - time.monotonic()) > 0:
            data = self._port.read(wait)
            if not data:
                return None
            frames = list(self._decoder.feed(data))
            self.counters.damaged = self._decoder.damaged
            for frame in frames:
                if (frame.session, frame.number) == (request.session, request.number):
                    if frame.type == request.type | REPLY:
                        return frame
                    if frame.type == NAK | REPLY:
                        raise self._refusal(request, frame)
                self.counters.stale += 1
        return None

    def _refusal(self, request: Frame, reply: Frame) -> LinkError:
        code = reply.payload[0] if reply.payload else 0
        reason = _REFUSALS.get(code, f"reason {code}")
        kind = RestartError if code == _NO_SESSION else LinkError
        return kind(f"{self._port.name}: the board refuses request {request.type} number {request.number}: {reason}")

    def _checked(self, reply: Frame) -> Hello:
        """Return the board's greeting; refuse another protocol, precision, law or build."""
        if len(reply.payload) != _HELLO.size or reply.payload[0] != _VERSION:
            raise InputError(f"{self._port.name}: the board speaks another version of the protocol; flash it again")
        _, size, digest, *sizes, ticks, board, model, law = _HELLO.unpack(reply.payload)
        hello = Hello(size, digest, tuple(sizes), ticks, _text(board), _text(model), _text(law))
        expected = self.layout
        if hello.real_size != 4:
            raise InputError(
                f"{self._port.name}: the board has numbers of {hello.real_size} bytes, but 4 (float) are needed: "
                "build and flash it again"
            )
        if hello.hash == expected.hash and hello.sizes != expected.sizes:
            counts = f"{list(hello.sizes)} numbers in its vectors, not {list(expected.sizes)}"
            raise InputError(f"{self._port.name}: the board has {counts}: another version built it; build and flash it")
        if hello.hash != expected.hash:
            raise InputError(
                f"{self._port.name}: the board runs {hello.model} {hello.law} ({hello.hash.hex()[:12]}), but "
                f"{expected.model} {expected.law} ({expected.hash.hex()[:12]}) is needed: build and flash it"
            )
        return hello


def _group(name: str) -> int:
    return "zpcs".index(name)


def _text(field_: bytes) -> str:
    return field_.rstrip(b"\0").decode("ascii", "replace")
