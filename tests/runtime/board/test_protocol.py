# SPDX-License-Identifier: Apache-2.0
"""The host's end and the firmware's own text, a line that misbehaves between them, against a twin on a perfect line.

Whatever the line does, whoever else speaks, whenever the board starts anew: what the board computed is what its twin
computed, and its outputs are the twin's.
"""

from __future__ import annotations

import ctypes
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from mehvar.runtime.board.image.build import program, sources
from mehvar.runtime.board.line.frames import Decoder, Frame, encode
from mehvar.runtime.board.line.link import HELLO, NAK, REPLY, STATS, STEP, Flags, Link, LinkError, RestartError
from mehvar.runtime.compiling.library import load_library
from tests.runtime.board.conftest import load

HERE = Path(__file__).parent
MODEL, LAW = "satellite", "mrac"
TWO_SAMPLES = 1000
"""ms, of the satellite."""
WRONG_SIZE, NO_SESSION, OUT_OF_TURN = 2, 4, 5


class Board:
    """The firmware in this process."""

    name = "process"

    def __init__(self, library: ctypes.CDLL, sizes: tuple[int, ...]) -> None:
        self._library, self._sizes = library, sizes
        self._back = (ctypes.c_uint8 * 8192)()
        self._pending = b""
        self._late = b""
        self.sent: list[bytes] = []
        self.fate = "whole"
        library.power_on()

    def write(self, data: bytes) -> None:
        """Put a request on the line; `fate` says what becomes of it and of its reply, once."""
        fate, self.fate = self.fate, "whole"
        self.sent.append(data)
        if fate == "lost":
            return
        reply = self.exchange(data if fate != "damaged" else data[: len(data) // 2] + data[len(data) // 2 + 1 :])
        if fate == "twice":
            reply += self.exchange(data)
        self._pending += self._late + (b"" if fate == "reply lost" else reply)
        self._late = reply if fate == "echo" else b""  # comes once more, before the reply to the next request

    def read(self, timeout: float) -> bytes:  # an answer is there or never comes
        pending, self._pending = self._pending, b""
        return pending

    def close(self) -> None:
        pass

    def exchange(self, data: bytes) -> bytes:
        line = (ctypes.c_uint8 * len(data)).from_buffer_copy(data)
        count = self._library.exchange(line, ctypes.c_long(len(data)), self._back)
        return bytes(self._back[:count])

    def elapse(self, ms: int) -> None:
        self._library.elapse(ctypes.c_long(ms))

    def power_on(self) -> None:
        self._library.power_on()

    def outputs(self) -> bytes:
        u = np.zeros(self._sizes[1], np.float32)
        self._library.outputs(u.ctypes.data_as(ctypes.c_void_p))
        return u.tobytes()

    def group(self, which: str) -> bytes:
        numbers = np.zeros(1024, np.float32)
        count = self._library.group(ctypes.c_long("zpcs".index(which)), numbers.ctypes.data_as(ctypes.c_void_p))
        return numbers[:count].tobytes()


FATES = st.sampled_from(["whole", "whole", "whole", "lost", "reply lost", "twice", "echo", "damaged"])
NUMBERS = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).uniform(-0.2, 0.2, 256).astype("<f4"))


@pytest.fixture(scope="module")
def libraries(tmp_path_factory: pytest.TempPathFactory) -> tuple[ctypes.CDLL, ctypes.CDLL]:
    texts = sources(program(load(MODEL), LAW), None)
    texts |= {name: (HERE / name).read_text() for name in ("process.c", "process.h")}
    units = [f"{MODEL}.c", "app.c", "link.c", "server.c", "process.c"]
    one = load_library("board_process", texts, units, ("-O1", "-I.", "-DMEHVAR_FLOAT"))
    copy = shutil.copy(one._name, tmp_path_factory.mktemp("twin") / "twin.so")  # its own memory
    return one, ctypes.CDLL(str(copy))


@pytest.mark.parametrize("kind", [HELLO, STATS])
@pytest.mark.parametrize("ahead", [1, 2, 2**31 - 1, 2**31, 2**31 + 1, 2**32 - 1])
def test_a_number_is_next_or_a_hello_less_than_half_the_circle_ahead(libraries, kind, ahead):
    board = Board(libraries[0], program(load(MODEL), LAW).layout.sizes)
    for last in (7, 2**32 - 1):
        board.power_on()
        for number, request in ((last, HELLO), ((last + ahead) % 2**32, kind)):
            (reply,) = Decoder().feed(board.exchange(encode(Frame(request, 0, 5, number, b""))))
            assert reply.number == number
        on_time = ahead == 1 or (kind == HELLO and ahead < 2**31)
        assert reply.type == (kind if on_time else NAK) | REPLY
        if not on_time:
            assert reply.payload == bytes([OUT_OF_TURN]) + last.to_bytes(4, "little")


def test_the_board_computes_what_its_twin_on_a_perfect_line_does(libraries):
    firmware = program(load(MODEL), LAW)
    layout, resolved = firmware.layout, firmware.resolved

    class Bed(RuleBasedStateMachine):
        """One host, its board, the twin, and somebody else on the line."""

        @initialize()
        def power(self) -> None:
            self.board, self.twin = (Board(library, layout.sizes) for library in libraries)
            self.link, self.perfect = (Link(port, layout, tries=4) for port in (self.board, self.twin))
            self.perfect.connect()
            self.started = False
            self.since_step = 2 * TWO_SAMPLES

        def both(self, request: str, *arguments: object) -> None:
            """Ask both boards; when ours has started anew, so does its twin."""
            try:
                reply = getattr(self.link, request)(*arguments)
            except RestartError:
                self.restart()
                return
            other = getattr(self.perfect, request)(*arguments)
            if request == "step":
                self.since_step = 0
                assert reply.u.tobytes() == other.u.tobytes()
                assert reply.u.tobytes() == self.board.outputs()

        def restart(self) -> None:
            self.wait(2 * TWO_SAMPLES)  # until then another host may be served
            self.link.connect(patience=5)
            self.perfect.reset()
            self.started = False

        @rule()
        def start(self) -> None:
            if not self.started:
                self.restart()
            self.both("set", "z", np.zeros(layout.sizes[2]))
            self.started = True

        @precondition(lambda self: self.started)
        @rule(numbers=NUMBERS, fate=FATES)
        def step(self, numbers: np.ndarray, fate: str) -> None:
            self.board.fate = fate
            self.both("step", numbers[: layout.sizes[0]])

        @precondition(lambda self: self.started)
        @rule(scale=st.floats(0.5, 2.0), fate=FATES)
        def tune(self, scale: float, fate: str) -> None:
            self.board.fate = fate
            self.both("set", "c", resolved.c * scale)

        @precondition(lambda self: self.started)
        @rule(
            group=st.sampled_from("zpcs"), bad=st.sampled_from([np.nan, np.inf, -np.inf]), place=st.integers(0, 10**6)
        )
        def no_number(self, group: str, bad: float, place: int) -> None:
            values = np.frombuffer(self.board.group(group), "<f4").copy()
            if len(values):
                values[place % len(values)] = bad
                with pytest.raises(LinkError):
                    self.link.set(group, values)
                self.perfect.stats()

        @precondition(lambda self: self.started)
        @rule(numbers=NUMBERS, short=st.integers(1, 4 * layout.sizes[0]))
        def step_of_a_wrong_size(self, numbers: np.ndarray, short: int) -> None:
            """It is refused as often as it comes, and the step that then has its number is one of its own."""
            payload = numbers[: layout.sizes[0]].tobytes()
            for _ in range(2):
                refusal = self.sends(STEP, payload[:-short], self.link._number + 1)
                assert (refusal.type, refusal.payload[0]) in ((NAK | REPLY, WRONG_SIZE), (NAK | REPLY, NO_SESSION))
            if refusal.payload[0] == NO_SESSION:
                return
            self.link._number += 1
            reply = self.sends(STEP, payload, self.link._number)
            self.since_step = 0
            expected = self.perfect.step(numbers[: layout.sizes[0]])
            assert not reply.flags & Flags.DUPLICATE
            assert reply.payload[: 4 * layout.sizes[1]] == expected.u.tobytes()
            self.sends(STEP, payload[:-short], self.link._number)
            assert self.sends(STEP, payload, self.link._number).flags & Flags.DUPLICATE

        def sends(self, kind: int, payload: bytes, number: int) -> Frame:
            (reply,) = Decoder().feed(self.board.exchange(encode(Frame(kind, 0, self.link._session, number, payload))))
            return reply

        @rule(back=st.integers(1, 6))
        def old_request(self, back: int) -> None:
            if len(self.board.sent) > back:
                for reply in Decoder().feed(self.board.exchange(self.board.sent[-1 - back])):
                    if reply.type == HELLO | REPLY and reply.session != self.link._session:
                        self.taken()  # somebody else's first request, late

        @rule(noise=st.binary(max_size=40))
        def noise(self, noise: bytes) -> None:
            self.board.exchange(noise)

        @rule(ms=st.sampled_from([1, 400, 900, 1100, 5000]))
        def wait(self, ms: int) -> None:
            for board in (self.board, self.twin):
                board.elapse(ms)
            self.since_step += ms

        @rule()
        def reboot(self) -> None:
            self.board.power_on()
            self.twin.power_on()
            self.perfect.connect()
            self.started = False
            self.since_step = 2 * TWO_SAMPLES

        @rule()
        def somebody_else(self) -> None:
            other = Link(self.board, layout, tries=1)
            try:
                other.connect(patience=0)
                other.set("c", resolved.c * 3)
            except LinkError:
                return  # our law is running
            self.taken()

        def taken(self) -> None:
            """Another host is served now, and our host will be told so."""
            assert self.since_step > TWO_SAMPLES, "the board left a law that is running"
            self.perfect.reset()
            self.started = False

        @invariant()
        def the_same(self) -> None:
            assert self.board.outputs() == self.twin.outputs()
            if self.since_step > TWO_SAMPLES + 10:  # the main loop turns every ten milliseconds
                assert not any(self.board.outputs())
            if self.started:
                for group in "zpcs":
                    assert self.board.group(group) == self.twin.group(group)

    run_state_machine_as_test(Bed, settings=settings(max_examples=60, stateful_step_count=40, deadline=None))
