# SPDX-License-Identifier: Apache-2.0
"""Whatever happens on the line, to the board or to the host: the trajectory keeps its bits."""

from __future__ import annotations

import random
import struct
from dataclasses import replace

import numpy as np
import pytest

from mehvar.base.errors import InputError
from mehvar.runtime.board.image.build import build, program
from mehvar.runtime.board.image.toolchains import board, host_toolchain, toolchain
from mehvar.runtime.board.journal import Journal
from mehvar.runtime.board.line.frames import Decoder, Frame, encode
from mehvar.runtime.board.line.link import Flags, Link, LinkError, RestartError
from mehvar.runtime.board.targets import MachinePort, ProcessPort
from tests.runtime.board.conftest import Bench, Noisy, Wrapped, load

RATE = 0.004


def flips(rng):
    return lambda data: bytes(b ^ 1 << rng.randrange(8) if rng.random() < RATE else b for b in data)


def losses(rng):
    return lambda data: bytes(b for b in data if rng.random() >= RATE)


def insertions(rng):
    return lambda data: b"".join(bytes([b]) + rng.randbytes(rng.random() < RATE) for b in data)


def cuts(rng):
    return lambda data: data[: rng.randrange(len(data))] if data and rng.random() < 0.2 else data


def silences(rng):
    return lambda data: b"" if rng.random() < 0.2 else data


def garbage(rng):
    return lambda data: rng.randbytes(rng.randrange(40)) + data


@pytest.mark.parametrize("damage", [flips, losses, insertions, cuts, silences, garbage])
@pytest.mark.share(2)
def test_a_bad_line_changes_nothing(bench, damage):
    rng = random.Random(7)
    link = bench.link(Noisy(bench.port, damage(rng), damage(rng)))
    assert bench.same(bench.simulate(law=bench.on_board(link)))
    assert link.counters.resent + link.counters.damaged > 5
    stats = link.stats()
    assert stats["steps"] == bench.samples
    assert stats["refused"] == 0


def test_a_long_burst_of_garbage_is_forgotten(bench):
    link = bench.started()
    bench.port.write(random.Random(3).randbytes(1500))
    assert link.step(bench.numbers(0)).u.tobytes() == bench.expected.u_cmd[0].astype("<f4").tobytes()


def test_half_a_frame_does_not_spoil_the_next(bench):
    link = bench.started()
    bench.port.write(encode(Frame(3, 0, 1, 9, bench.numbers(0).tobytes()))[:40])
    assert link.step(bench.numbers(0)).flags == 0
    assert link.stats()["steps"] == 1


class Rebooting(Wrapped):
    """Reboots the board before some of the exchanges."""

    def __init__(self, port: MachinePort, every: int) -> None:
        super().__init__(port)
        self._every, self.writes = every, 0

    def write(self, data: bytes) -> None:
        self.writes += 1
        if self.writes % self._every == 0:
            self._port.machine.power_on()
        super().write(data)


class Counted(Link):
    """Counts evaluations of the law."""

    steps = 0

    def step(self, numbers):
        self.steps += 1
        return super().step(numbers)


@pytest.mark.parametrize("every", [101, 150])
def test_a_board_that_reboots_gets_its_memory_back(every):
    bench = Bench(samples=150)
    port = Rebooting(bench.port, every)
    law = bench.on_board(bench.link(port))
    assert bench.same(bench.simulate(law=law))
    assert law.restored == port.writes // every >= 2


def test_samples_since_a_checkpoint_alone_are_repeated():
    """Also where the host reads the memory less often than it needs checkpoints."""
    bench = Bench(samples=150)
    link = Counted(Rebooting(bench.port, 101), bench.program.layout)
    link.connect()
    law = bench.on_board(link, every=1000)
    assert bench.same(bench.simulate(law=law))
    assert link.steps <= bench.samples + 25 * law.restored


def test_restarts_at_one_sample_end_a_run_at_a_number_that_can_be_set():
    """A board that restarts at every third message cannot be brought back: that takes more of them."""
    bench = Bench(samples=30)
    for restarts in (2, 3):
        link = Link(Rebooting(bench.port, 3), bench.program.layout)
        law = bench.on_board(link, restarts=restarts)
        link.connect()
        with pytest.raises(LinkError, match=f"lost its memory {restarts} times at sample"):
            bench.simulate(law=law)
        assert law.restored >= restarts


def test_a_board_of_another_version_is_refused_by_what_differs(bench):
    other = replace(bench.program.layout, sizes=(*bench.program.layout.sizes[:-1], 99))
    with pytest.raises(InputError, match=r"numbers in its vectors, not .* 99\]: another version built it"):
        Link(bench.port, other).connect()


def test_a_request_to_reboot_forgets_the_memory(bench):
    link = bench.started()
    link.reboot()
    bench.port.read(0)
    with pytest.raises(RestartError, match="has started since"):
        link.step(bench.numbers(0))
    link.connect()
    with pytest.raises(RestartError, match="lost the law's memory"):
        link.step(bench.numbers(0))
    assert not link.output().any()


class Stopped(Exception):  # noqa: N818 - stands for the end of the host's process
    """The host is killed."""


@pytest.mark.parametrize("board_forgets", [False, True])
def test_a_host_that_was_stopped_goes_on(bench, tmp_path, board_forgets):
    path, identity, layout = tmp_path / "journal", {"run": 1}, bench.program.layout
    calls = 0

    def stop() -> None:
        nonlocal calls
        calls += 1
        if calls == 23:
            raise Stopped

    journal = Journal(path, identity, layout)
    with pytest.raises(Stopped):
        bench.simulate(law=bench.on_board(journal=journal, after=stop))
    journal.close(complete=False)
    with path.open("ab") as file:
        file.write(b"s" + b"half a record")
    if board_forgets:
        bench.port.machine.power_on()
    bench.port.machine.advance(1100)  # until then the board waits for the host that was stopped
    journal = Journal(path, identity, layout)
    assert journal.length == 23
    law = bench.on_board(journal=journal)
    assert bench.same(bench.simulate(law=law))
    assert len(law.ticks) == bench.samples - 23
    journal.close(complete=True)
    assert not path.exists()


def test_a_journal_of_another_run_is_refused(tmp_path):
    path, layout = tmp_path / "journal", program(load("satellite"), "mrac").layout
    Journal(path, {"run": 1}, layout).close(complete=False)
    with pytest.raises(InputError, match="belongs to another run"):
        Journal(path, {"run": 2}, layout)


def test_another_law_is_refused(bench):
    other = program(load("satellite"), "pd").layout
    with pytest.raises(InputError, match=r"runs satellite mrac .* but satellite pd"):
        Link(bench.port, other).connect()


def test_an_image_for_another_board_is_refused():
    firmware = program(load("satellite"), "pd")
    image = build(firmware, board("stm32f4"), toolchain())
    elsewhere = type(image)(image.path, firmware, board("mps2-m4f"), image.toolchain, False)
    with pytest.raises(InputError, match="not for mps2-m4f"):
        MachinePort(elsewhere)


class Tap(Wrapped):
    """A line that keeps what the host sent, so that it can be sent again."""

    def __init__(self, port: MachinePort) -> None:
        super().__init__(port)
        self.sent: list[bytes] = []

    def write(self, data: bytes) -> None:
        self.sent.append(data)
        super().write(data)

    def replies(self, data: bytes) -> list[Frame]:
        """Put bytes on the line and return the frames that come back."""
        self._port.write(data)
        return list(Decoder().feed(self._port.read(0)))


def test_a_step_that_comes_again_is_answered_and_not_evaluated(bench):
    tap = Tap(bench.port)
    link = bench.started(tap)
    first = link.step(bench.numbers(0))
    (again,) = tap.replies(tap.sent[-1])
    assert again.flags == Flags.DUPLICATE
    assert again.payload[:12] == first.u.tobytes()
    assert link.step(bench.numbers(1)).u.tobytes() == bench.expected.u_cmd[1].astype("<f4").tobytes()
    stats = link.stats()
    assert (stats["steps"], stats["duplicates"], stats["refused"]) == (2, 1, 0)


@pytest.mark.parametrize("kind", [3, 7])
def test_what_follows_a_refused_request_is_not_answered_with_what_went_before(bench, kind):
    """A step, or a self-test, with the number of one that was refused was answered as the one before both."""
    tap = Tap(bench.port)
    link = bench.started(tap)
    right = [bench.numbers(0).tobytes(), bench.numbers(1).tobytes()] if kind == 3 else [b"\2\0\0\0", b"\3\0\0\0"]
    first = link._request(kind, right[0])
    with pytest.raises(LinkError, match="wrong size"):
        link._request(kind, right[1] + b"\0")
    (second,) = tap.replies(encode(Frame(kind, 0, link._session, link._number, right[1])))
    assert second.payload != first.payload
    if kind == 3:
        assert second.payload[:12] == bench.expected.u_cmd[1].astype("<f4").tobytes()
    else:
        assert (second.type, second.payload[0]) == (0xFF, 3), "the memory was spent on the test before"


@pytest.mark.parametrize("age", [1, 2, 5])
def test_an_old_frame_is_refused_and_changes_nothing(bench, age):
    """An estimator must not learn twice from one sample: a step of before came again and was evaluated once."""
    tap = Tap(bench.port)
    link = bench.started(tap)
    for k in range(8):
        link.step(bench.numbers(k))
    before, steps = link.get("z"), [data for data in tap.sent if len(data) > 60][-8:]
    (refusal,) = tap.replies(steps[-1 - age])
    assert (refusal.type, refusal.payload[0]) == (0xFF, 5)
    assert link.get("z").tobytes() == before.tobytes()
    assert link.step(bench.numbers(8)).u.tobytes() == bench.expected.u_cmd[8].astype("<f4").tobytes()
    assert link.stats()["refused"] == 1


def test_a_line_that_repeats_old_requests_changes_nothing(bench):
    rng = random.Random(5)

    class Echoing(Tap):
        def write(self, data: bytes) -> None:
            super().write(data)
            if rng.random() < 0.3:
                self._port.write(rng.choice(self.sent[-6:]))

    link = bench.link(Echoing(bench.port))
    assert bench.same(bench.simulate(law=bench.on_board(link)))
    assert link.stats()["steps"] == bench.samples


def test_a_request_out_of_turn_ends_the_session_with_a_reason(bench):
    link = bench.started()
    link._number += 3
    with pytest.raises(LinkError, match="neither the next nor the last request number"):
        link.step(bench.numbers(0))


def test_another_host_is_told_that_the_board_is_busy_and_changes_nothing(bench):
    link = bench.started()
    link.step(bench.numbers(0))
    other = Link(bench.port, bench.program.layout, tries=1)
    with pytest.raises(LinkError, match="runs a law for another host"):
        other.connect(patience=0.2)
    for group in "pcsz":
        with pytest.raises(RestartError, match="serves another host"):
            other.set(group, bench.expected.z[0])
    assert link.step(bench.numbers(1)).u.tobytes() == bench.expected.u_cmd[1].astype("<f4").tobytes()


def test_the_next_host_finds_nothing_of_the_one_before(bench):
    first = bench.started()
    gains = first.get("c")
    first.set("c", gains + 1)
    first.step(bench.numbers(0))
    bench.port.machine.advance(1100)
    assert bench.link().get("c").tobytes() == gains.tobytes()
    with pytest.raises(RestartError, match="serves another host"):
        first.step(bench.numbers(1))


@pytest.mark.parametrize("group", ["p", "c", "s", "z"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_no_parameter_and_no_memory(bench, group, bad):
    link = bench.started()
    before = link.get(group)
    for place in range(len(before)):
        values = before.copy()
        values[place] = bad
        with pytest.raises(LinkError, match="infinite or not a number"):
            link.set(group, values)
    assert link.get(group).tobytes() == before.tobytes()


def test_a_byte_on_the_line_ends_a_self_test(bench):
    link = bench.started()
    writes = bench.port.write

    def interrupted(data: bytes) -> None:
        writes(data + b"\x55")

    bench.port.write = interrupted
    with pytest.raises(LinkError, match=r"a byte on the line interrupted the self-test after \d+ of 100000 samples"):
        link.selftest(100_000)


def test_unknown_types_and_wrong_sizes_are_refused(bench):
    link = bench.link()
    with pytest.raises(LinkError, match="does not know"):
        link._request(99)
    for kind, payload in ((1, b"x"), (3, b"\0" * 60), (4, b"\x09"), (5, b"\1\0"), (6, b"x"), (7, b"")):
        with pytest.raises(LinkError, match="wrong size"):
            link._request(kind, payload)
    with pytest.raises(LinkError, match="no memory"):
        link._request(7, b"\1\0\0\0")


def test_a_program_that_hangs_is_started_anew_by_the_hardware(bench):
    """The main loop is made to sleep for ever, with an output that is not zero."""
    link = bench.started()
    link.step(bench.numbers(0))
    machine, idle = bench.port.machine, machine_pulses_at_rest(bench)
    assert machine.pulses() != idle
    machine.advance(900)
    assert machine.pulses() != idle, "a program that turns is left alone"
    address, _ = machine._elf.symbols["mv_server_watch"]
    machine._uc.mem_write(address & ~1, b"\x30\xbf\xfd\xe7")  # again: wfi; b again
    machine._uc.ctl_flush_tb()
    machine.advance(150)
    assert machine.pulses() != idle
    machine.advance(100)
    assert machine.pulses() == idle
    with pytest.raises(RestartError, match="has started since"):
        link.step(bench.numbers(1))


def machine_pulses_at_rest(bench: Bench) -> tuple[int, ...]:
    return (bench.port.machine._board.hertz // 2 // 20_000 // 2,) * 3


def test_outputs_are_pulses_and_none_when_nobody_asks(bench):
    link = bench.link()
    idle = machine_pulses_at_rest(bench)
    assert bench.port.machine.pulses() == idle
    bench.start(link)
    u = link.step(bench.numbers(0)).u
    half = np.float32(idle[0])
    assert bench.port.machine.pulses() == tuple(int(half + half * value) for value in u)
    bench.port.machine.advance(1100)
    assert bench.port.machine.pulses() == idle


@pytest.mark.parametrize("request_between", ["z", "p", "stats", "hello", "noise"])
def test_an_output_is_held_for_two_samples_whatever_else_comes(bench, request_between):
    """Setting the memory disarmed the watch: the last torque was held for ever."""
    link = bench.started()
    link.step(bench.numbers(0))
    assert link.output().any()
    for _ in range(11):
        bench.port.machine.advance(100)
        if request_between == "stats":
            link.stats()
        elif request_between == "hello":
            bench.port.write(encode(Frame(1, 0, 77, 1, b"")))
        elif request_between == "noise":
            bench.port.write(b"\x03ab\0")
        else:
            link.set(request_between, bench.expected.z[0] if request_between == "z" else bench.expected.parameters.p)
        bench.port.read(0)
    if request_between == "hello":  # the other host is served now, and finds nothing
        assert not bench.link().output().any()
    else:
        assert not link.output().any()
        assert link.stats()["lost"] == 1


def test_a_silent_link_holds_for_two_samples_then_outputs_nothing(bench):
    link = bench.started()
    last = link.step(bench.numbers(0)).u
    assert last.any()
    bench.port.machine.advance(990)
    assert link.output().tobytes() == last.tobytes()
    bench.port.machine.advance(60)
    assert not link.output().any()
    answer = link.step(bench.numbers(1))
    assert answer.flags == Flags.LOST
    assert answer.u.tobytes() == bench.expected.u_cmd[1].astype("<f4").tobytes()
    assert link.stats()["lost"] == 1


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e35])
@pytest.mark.parametrize("place", [0, 5, 9, 11, 14])
def test_what_is_no_number_reaches_no_actuator(bench, bad, place):
    """The next whole measurements find an estimator without a trace of it."""
    link = bench.started()
    for k in range(20):
        numbers = bench.numbers(k)
        if 8 <= k < 10:
            numbers[place] = bad
        answer = link.step(numbers)
        assert np.isfinite(answer.u).all()
        if 8 <= k < 10 and not np.isfinite(bad):
            assert answer.flags & Flags.NONFINITE
            assert not answer.u.any()
            assert not link.output().any()
    memory = link.get("z")
    assert np.isfinite(memory).all()
    assert np.abs(answer.u).max() < 0.1


@pytest.mark.parametrize("law", ["sliding", "path"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_law_without_checks_of_its_own_is_guarded_too(law, bad):
    bench = Bench("triangle", law)
    link = bench.started()
    for place in range(8):
        numbers = np.full(8, 0.3, np.float32)
        numbers[place] = bad
        answer = link.step(numbers)
        assert answer.flags & Flags.NONFINITE
        assert not answer.u.any()


def test_numbers_below_the_smallest_normal_one_are_zero(bench):
    answers = []
    for value in (1e-40, 0.0):
        bench.port.machine.advance(1100)
        link = bench.started()
        numbers = bench.numbers(0)
        numbers[[0, 3, 12]] = value
        answers.append(link.step(numbers).u.tobytes() + link.get("z").tobytes())
    assert answers[0] == answers[1]


def test_frames_without_end_are_bounded(bench):
    link = bench.link()
    bench.port.write(b"\0" + b"\x05abcd" * 400 + b"\0")
    bench.port.read(0)
    assert link.stats()["length_errors"] == 1
    bench.port.write(b"\0\x20abc\0" + struct.pack("<I", 0))
    bench.port.read(0)
    assert link.stats()["cobs_errors"] == 1


def test_a_zero_at_any_place_of_an_answer_arrives():
    """A block of 254 bytes stands for no zero, so the one zero moves past the end of the first block."""
    image = build(program(load("satellite"), "mrac"), None, host_toolchain())
    port = ProcessPort(image.path)
    try:
        link = Link(port, image.program.layout, tries=1)
        link.connect()
        size = 4 * len(image.program.layout.memory)
        assert size > 256
        for place in range(size):
            content = bytearray(b"\x3f" * size)
            content[place] = 0
            memory = np.frombuffer(bytes(content), "<f4")
            link.set("z", memory)
            kept = link.get("z")
            assert kept is not None
            assert kept.tobytes() == memory.tobytes(), place
    finally:
        port.close()
