# SPDX-License-Identifier: Apache-2.0
"""The host's end of the line against a port that says what a test wants: no board, no compiler."""

from __future__ import annotations

import dataclasses
import re
import struct
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from mehvar.base.errors import InputError
from mehvar.runtime.board.image.build import FIRMWARE
from mehvar.runtime.board.image.header import Layout
from mehvar.runtime.board.line.frames import Decoder, Frame, encode
from mehvar.runtime.board.line.link import (
    _HELLO,
    _STATS,
    _VERSION,
    HELLO,
    NAK,
    REPLY,
    STEP,
    Flags,
    Link,
    LinkError,
    RestartError,
)

HASH = bytes(range(1, 17))
SIZES = (3, 2, 1, 0, 0, 0, 3)
LAYOUT = Layout("satellite", "pd", ("a", "b", "c"), ("u", "v"), ("z",), SIZES, HASH)
Answer = Callable[[Frame], Iterator[Frame]]


class Script:
    """A port that answers each request with the frames of a function."""

    name = "script"

    def __init__(self, answer: Answer) -> None:
        self._answer, self._decoder, self._waiting = answer, Decoder(), b""
        self.requests: list[Frame] = []

    def write(self, data: bytes) -> None:
        for request in self._decoder.feed(data):
            self.requests.append(request)
            self._waiting += b"".join(map(encode, self._answer(request)))

    def read(self, timeout: float) -> bytes:
        data, self._waiting = self._waiting, b""
        return data


def link(answer: Answer, tries: int = 2) -> Link:
    return Link(Script(answer), LAYOUT, timeout=0.2, tries=tries)  # type: ignore[arg-type]


def reply(request: Frame, payload: bytes = b"", **changes: int) -> Frame:
    return dataclasses.replace(request, type=request.type | REPLY, payload=payload, **changes)


def test_an_answer_to_another_request_is_not_taken() -> None:
    def answer(request: Frame) -> Iterator[Frame]:
        yield reply(request, b"wrong", number=request.number - 1)
        yield reply(request, b"wrong", number=request.number + 1)
        yield reply(request, b"wrong", session=request.session % 0xFFFF + 1)
        yield dataclasses.replace(request, type=request.type + 1 | REPLY, payload=b"wrong")
        yield reply(request, np.array([1.5, -2.0], "<f4").tobytes())

    host = link(answer)
    np.testing.assert_array_equal(host.get("p"), [1.5, -2.0])
    assert (host.counters.stale, host.counters.requests, host.counters.resent) == (4, 1, 0)


def test_without_an_answer_the_same_request_is_sent_again() -> None:
    port = Script(lambda request: iter([reply(request, number=request.number - 1)]))
    host = Link(port, LAYOUT, timeout=0.2, tries=3)  # type: ignore[arg-type]
    with pytest.raises(LinkError, match="after 3 tries"):
        host.reset()
    assert [request.number for request in port.requests] == [1, 1, 1]
    assert (host.counters.requests, host.counters.resent, host.counters.stale) == (1, 2, 3)


@pytest.mark.parametrize(("code", "kind"), [(4, RestartError), (3, LinkError), (255, LinkError), (None, LinkError)])
def test_a_refusal_is_an_error_of_its_kind(code: int | None, kind: type[LinkError]) -> None:
    payload = b"" if code is None else bytes([code])
    with pytest.raises(kind, match="refuses request") as caught:
        link(lambda request: iter([dataclasses.replace(request, type=NAK | REPLY, payload=payload)])).reset()
    assert type(caught.value) is kind


def hello(**changes: object) -> bytes:
    values = {"version": _VERSION, "size": 4, "hash": HASH, "sizes": SIZES, "ticks": 0} | changes
    names = (b"board", b"satellite", b"pd")
    return _HELLO.pack(values["version"], values["size"], values["hash"], *values["sizes"], values["ticks"], *names)  # type: ignore[misc]


def test_the_program_that_was_asked_for_is_accepted() -> None:
    greeting = link(lambda request: iter([reply(request, hello())])).connect(1.0)
    assert (greeting.hash, tuple(greeting.sizes), greeting.model, greeting.law) == (HASH, SIZES, "satellite", "pd")


@pytest.mark.parametrize(
    "changes",
    [{"hash": HASH[:-1] + b"\0"}, {"hash": b"\0" + HASH[1:]}, {"size": 8}, {"sizes": (*SIZES[:-1], 4)}],
    ids=["hash's end", "hash's begin", "size of a number", "size of a vector"],
)
def test_another_program_is_refused(changes: dict[str, object]) -> None:
    with pytest.raises(InputError, match="build and flash it"):
        link(lambda request: iter([reply(request, hello(**changes))])).connect(1.0)


@pytest.mark.parametrize("payload", [hello(version=_VERSION + 1), hello() + b"\0", hello()[:-1]])
def test_another_protocol_is_refused(payload: bytes) -> None:
    with pytest.raises(InputError, match="another version of the protocol"):
        link(lambda request: iter([reply(request, payload)])).connect(1.0)


@pytest.mark.parametrize("extra", [-1, 1])
def test_an_answer_of_another_length_is_refused(extra: int) -> None:
    size = 4 * SIZES[1] + 4 + extra
    with pytest.raises(LinkError, match=f"has {size} bytes instead of 12"):
        link(lambda request: iter([reply(request, bytes(size))])).step(np.zeros(3))


def test_a_self_test_that_was_cut_short_is_no_result() -> None:
    def answer(request: Frame) -> Iterator[Frame]:
        yield reply(request, struct.pack("<3I", 7, 1, 2) + bytes(4 * (SIZES[6] + SIZES[1])))

    assert link(answer).selftest(7).samples == 7
    with pytest.raises(LinkError, match="after 7 of 8 samples"):
        link(answer).selftest(8)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (0, "reason 0"), (1, "does not know this type"), (2, "wrong size"), (3, "no memory"), (4, "has started since"),
        (5, "neither the next"), (6, "infinite or not a number"), (7, "another host"), (8, "has another value"),
    ],
)  # fmt: skip
def test_a_refusal_says_why(code: int, words: str) -> None:
    with pytest.raises(LinkError, match=words) as caught:
        link(lambda request: iter([dataclasses.replace(request, type=NAK | REPLY, payload=bytes([code]))])).reset()
    assert caught.value.exit_status == 3
    with pytest.raises(LinkError, match="reason 0"):
        link(lambda request: iter([dataclasses.replace(request, type=NAK | REPLY, payload=b"")])).reset()


def test_a_step_returns_input_time_and_flags() -> None:
    payload = np.array([0.5, -1.5], "<f4").tobytes() + (1234).to_bytes(4, "little")
    host = link(lambda request: iter([reply(request, payload, flags=1)]))
    for _ in range(2):
        answer = host.step(np.zeros(3))
    np.testing.assert_array_equal(answer.u, np.float32([0.5, -1.5]))
    assert answer.ticks == 1234
    assert set(host.counters.as_dict().values()) == {0, 2}
    assert [count for name, count in host.counters.flags.items() if count] == [2]


def test_a_self_test_returns_states_and_inputs_apart() -> None:
    numbers = np.array([1, 2, 3, 4, 5], "<f4").tobytes()
    result = link(lambda request: iter([reply(request, struct.pack("<3I", 7, 11, 13) + numbers)])).selftest(7)
    assert (result.samples, result.crc, result.ticks) == (7, 11, 13)
    assert (result.x.tolist(), result.u.tolist()) == ([1, 2, 3], [4, 5])


def test_a_board_that_is_not_there_is_waited_for_as_long_as_asked() -> None:
    begin = time.monotonic()
    with pytest.raises(LinkError, match=r"no answer from script in 0\.3 s"):
        link(lambda _request: iter([])).connect(0.3)
    assert 0.3 <= time.monotonic() - begin < 5


def test_the_numbers_on_the_wire_are_those_of_the_firmware() -> None:
    """Types of requests, flags and bytes of payloads, as docs/reference/board-link.md has them."""
    counters = struct.pack(f"<{len(_STATS)}I", *range(1, len(_STATS) + 1)) + np.array([9.5, 8.5], "<f4").tobytes()
    answers = {2: b"", 4: b"", 5: b"", 6: counters, 7: struct.pack("<3I", 7, 0, 0) + bytes(20)}
    port = Script(lambda request: (reply(request, answers[kind]) for kind in answers if kind == request.type))
    host = Link(port, LAYOUT, timeout=0.2, tries=1)  # type: ignore[arg-type]
    host.reset()
    for group in "zpcs":
        host.get(group)
    host.set("c", np.array([1.5]))
    assert tuple(host.stats().values()) == tuple(range(1, len(_STATS) + 1))
    assert host.output().tolist() == [9.5, 8.5]
    assert host.selftest(7).samples == 7
    host.reboot()
    assert [(request.type, request.flags, request.payload) for request in port.requests] == [
        (2, 0, b""), (4, 0, b"\0"), (4, 0, b"\1"), (4, 0, b"\2"), (4, 0, b"\3"),
        (5, 0, b"\2\0\0\xc0\x3f"), (6, 0, b""), (6, 0, b""), (7, 0, b"\7\0\0\0"), (8, 0, b""),
    ]  # fmt: skip
    assert (HELLO, STEP, NAK, REPLY) == (1, 3, 0x7F, 0x80)
    assert [flag.value for flag in Flags] == [2**k for k in range(len(Flags))]


@pytest.mark.parametrize(("drawn", "session"), [(0, 1), (0xFFFE, 0xFFFF)])
def test_a_session_has_any_number_but_zero(drawn: int, session: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("secrets.randbelow", lambda end: min(drawn, end - 1))
    port = Script(lambda request: iter([reply(request)]))
    Link(port, LAYOUT).reset()  # type: ignore[arg-type]
    assert port.requests[0].session == session


def test_a_memory_of_a_board_that_has_none_is_not_taken() -> None:
    every = sum(Flags)
    host = link(
        lambda request: iter([reply(request, bytes(4), flags=every if request.payload != b"\0" else Flags.FRESH)])
    )
    assert host.get("p").tolist() == [0]
    with pytest.raises(RestartError):
        host.get("z")
    assert link(lambda request: iter([reply(request, bytes(4), flags=every - Flags.FRESH)])).get("z").tolist() == [0]


def test_both_ends_of_the_line_mean_the_same_by_a_flag():
    text = (FIRMWARE / "mehvar" / "server.h").read_text(encoding="utf-8").partition("/* flags of a reply */")[2]
    named = {name: int(number) for name, number in re.findall(r"MV_SERVER_(\w+) = (\d+)", text.partition("}")[0])}
    assert named == {flag.name: flag.value for flag in Flags}
