# SPDX-License-Identifier: Apache-2.0
"""Board and host agree to the last bit: two emulators, two compilers, three processors, every kind of law."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
import zlib
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError, MissingError
from mehvar.parts import Hub, Spacecraft, Tank
from mehvar.runtime.board import targets
from mehvar.runtime.board.image import toolchains
from mehvar.runtime.board.image.build import build, program, sources
from mehvar.runtime.board.image.toolchains import host_toolchain
from mehvar.runtime.board.line.link import Link, LinkError
from mehvar.runtime.board.run import BoardRequest, build_image, difference, run_on_board
from mehvar.runtime.board.session import BoardLaw
from mehvar.runtime.board.targets import ProcessPort, SerialPort, open_target
from tests.runtime.board.conftest import Bench, load
from tests.tools import needs

GCC = pytest.param("gcc", marks=needs("arm-none-eabi-gcc"))
NEEDS_QEMU = needs("qemu-system-arm")
QEMU = pytest.param("qemu", marks=NEEDS_QEMU)
LAWS = [("satellite", "mrac"), ("triangle", "path"), ("triangle", "sliding")]
LONG = 2000


@pytest.mark.parametrize(("model", "law"), LAWS)
@pytest.mark.share(3)
def test_software_in_the_loop(model, law):
    outcome = run_on_board(load(model), BoardRequest(law, "sil", samples=600))
    assert (outcome.max_ulp, outcome.x.ulp, outcome.u.compared) == (0, 0, outcome.single.u_cmd.size)


def test_the_period_that_is_asked_for_is_the_one_of_loop_watch_and_self_test():
    outcome = run_on_board(load("triangle"), BoardRequest("path", "sil", samples=20, options={"hold": 0.005}))
    assert outcome.max_ulp == 0
    assert outcome.board.t[1] == 0.005
    assert "MV_BOARD_PERIOD_MS = 5" in sources(outcome.image.program, None)["mehvar/board_model.h"]
    usual = run_on_board(load("triangle"), BoardRequest("path", "sil", samples=2))
    assert usual.selftest.crc != outcome.selftest.crc


@pytest.fixture(scope="module")
def expected_crc() -> str:
    """Law and plant for as many samples in a process of this machine."""
    outcome = run_on_board(load("satellite"), BoardRequest("mrac", "sil", samples=3, selftest=LONG))
    return f"{outcome.selftest.crc:08x}"


@pytest.mark.parametrize(
    ("target", "samples", "compiler"),
    [
        pytest.param("unicorn", LONG, "gcc", marks=needs("arm-none-eabi-gcc")),
        pytest.param("qemu", 300, "zig", marks=[NEEDS_QEMU, pytest.mark.soak]),
        pytest.param("unicorn", LONG, "zig", marks=pytest.mark.soak),
        pytest.param("qemu", 300, "gcc", marks=[NEEDS_QEMU, needs("arm-none-eabi-gcc"), pytest.mark.soak]),
    ],
)
def test_every_emulator_with_every_compiler(target, samples, compiler, expected_crc):
    """2000 samples, which go on past the scenario's end: in closed loop with the host and on the target alone.

    QEMU's line is slow, so there only the target goes all the way; benchmarks/board.py has the long loop too.
    """
    request = BoardRequest("mrac", target, compiler=compiler, samples=samples, every=25, selftest=LONG, profiled=False)
    outcome = run_on_board(load("satellite"), request)
    assert outcome.u.compared == 3 * samples
    assert (outcome.max_ulp, outcome.x.ulp, outcome.restored) == (0, 0, 0)
    assert outcome.z.compared > 0
    assert f"{outcome.selftest.crc:08x}" == expected_crc
    assert outcome.stats["stack_used"] <= outcome.bound.bytes


@needs("arm-none-eabi-gcc")
@pytest.mark.parametrize("board", ["mps2-m3", "mps2-m7"])
@pytest.mark.share(2)
def test_other_processors(board):
    outcome = run_on_board(
        load("satellite"), BoardRequest("mrac", "unicorn", board, "gcc", samples=100, selftest=20, profiled=False)
    )
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)


@pytest.mark.parametrize(
    ("model", "law", "board"),
    [
        ("triangle", "path", "stm32f4"),
        # whose bits on processors of this kind test_everywhere.py has too
        pytest.param("slosh", "lyapunov-v1", "mps2-m7", marks=pytest.mark.soak),
    ],
)
def test_other_models_on_the_processor(model, law, board):
    outcome = run_on_board(load(model), BoardRequest(law, "unicorn", board, samples=100, selftest=4, profiled=False))
    assert outcome.max_ulp == 0
    assert outcome.stats["stack_used"] <= outcome.bound.bytes


@pytest.fixture(scope="module")
def draining():
    """A craft of parts whose law burns a kilogram of fuel in 33 s."""
    craft = Spacecraft("draining", motion="attitude", period=0.5)
    craft.add(Hub("hub", mass=10.0, inertia=(1.0, 1.2, 0.9)))
    craft.add(Tank("tank", 1.0, nozzle=(-0.5, 0.05, 0), thrust=(1, 0, 0), exhaust=20.0, at=(0.1, 0.1, 0)))
    craft.law("burn", lambda law: {"tank": law.parameter("flow", 0.03, "kg/s")}, "a constant flow")
    return mehvar.build(craft)


@pytest.mark.parametrize("target", ["unicorn", QEMU])
def test_a_tank_that_a_law_on_the_board_drains_ends_its_run(draining, target):
    outcome = run_on_board(draining, BoardRequest("burn", target, samples=120, profiled=False))
    for run in (outcome.board, outcome.single):
        assert run.reason == "the fuel in tank is used up (at t = 33.3333 s)"
        assert run.t[-1] == run.t_stop == pytest.approx(1 / float(np.float32(0.03)), rel=1e-9)
        assert run.x[-1, draining.state_names.index("tank_fuel")] == pytest.approx(0, abs=1e-9)
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)


@pytest.mark.parametrize("target", ["sil", "unicorn", QEMU])
def test_bare_packets(target):
    outcome = run_on_board(load("satellite"), BoardRequest("mrac", target, samples=100, raw=True))
    assert (outcome.u.compared, outcome.u.ulp, outcome.x.ulp) == (300, 0, 0)


@pytest.mark.share(2)
@pytest.mark.parametrize("compiler", [GCC, "zig"])
def test_constants_in_the_laws_text_save_instructions_and_keep_every_bit(compiler):
    plain, folded = (
        run_on_board(load("satellite"), BoardRequest("mrac", compiler=compiler, samples=60, tunable=tunable))
        for tunable in (None, ())
    )
    assert folded.max_ulp == 0
    assert folded.board.u.tobytes() == plain.board.u.tobytes()
    assert folded.selftest.crc == plain.selftest.crc
    assert folded.profile.most < 0.92 * plain.profile.most  # measured: 0.90 gcc, 0.86 zig
    assert folded.elf.flash < plain.elf.flash


@pytest.mark.parametrize("law", ["mrac", "mrac-literal", "pd"])
@pytest.mark.parametrize("tunable", [(), ("noise",)])
@pytest.mark.share(3)
def test_folded_text_keeps_every_bit_of_the_memory_where_numbers_are_lost(law, tunable):
    """Memory is written early and taken back: lost, huge and tiny numbers in any place, at any sample."""
    model, random = load("satellite"), np.random.default_rng(20)
    plain, folded = (Ask(model, law, names) for names in (None, tunable))
    layout = plain.layout
    try:
        for k in range(400):
            numbers = (10.0 ** random.uniform(-6, 0) * random.normal(size=len(layout.inputs))).astype(np.float32)
            if k % 3 == 2:
                bad = np.float32(random.choice([np.nan, np.inf, 1e31, -3e38, 1e-44, 2e19]))
                numbers[random.integers(len(numbers))] = bad
            answers = [asked.step(numbers) for asked in (plain, folded)]
            assert answers[0] == answers[1], k
            assert plain.memory() == folded.memory(), k
    finally:
        plain.close()
        folded.close()


class Ask:
    """A law in a process, asked sample by sample."""

    def __init__(self, model, law, tunable):
        self.program = program(model, law, tunable=tunable)
        self.layout = self.program.layout
        self._port = open_target("sil", build(self.program, None, host_toolchain()))
        self._link = Link(self._port, self.layout)
        self._link.connect()
        self._link.set("z", np.zeros(len(self.layout.memory), np.float32))

    def step(self, numbers):
        return self._link.step(numbers).u.tobytes()

    def memory(self):
        return self._link.get("z").tobytes()

    def close(self):
        self._port.close()


@pytest.mark.parametrize(("model", "law"), LAWS[1:])
def test_a_law_without_memory_is_folded_too(model, law):
    outcome = run_on_board(load(model), BoardRequest(law, "sil", samples=100, tunable=()))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)


def test_a_tunable_parameter_can_be_set_and_a_constant_cannot():
    bench = Bench(tunable=("F0", "dead_zone"))
    expected = bench.simulate(real="float", parameters={"F0": 3.0, "dead_zone": 1e-4})
    assert expected.u_cmd.tobytes() != bench.expected.u_cmd.tobytes()
    law = BoardLaw(bench.link(), bench.program, expected.parameters)
    run = bench.simulate(law=law, parameters={"F0": 3.0, "dead_zone": 1e-4})
    assert run.u_cmd.tobytes() == expected.u_cmd.tobytes()
    other = bench.simulate(real="float", parameters={"forgetting": 0.99})
    bench.port.machine.advance(1100)  # until then the board waits for the host of the run before
    with pytest.raises(LinkError, match="compiled in has another value"):
        bench.simulate(law=BoardLaw(bench.link(), bench.program, other.parameters))


def test_a_run_on_the_board_is_a_run_of_simulate(bench):
    run = bench.simulate(law=bench.on_board())
    assert bench.same(run)
    assert run.z[1:].astype(np.float32).tobytes() == bench.expected.z[1:].astype(np.float32).tobytes()


def test_a_serial_port(tmp_path):
    """A pseudo-terminal, with the process behind it, stands for the cable."""
    import tty

    firmware = program(load("triangle"), "path")
    master, slave = os.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    process = subprocess.Popen([build(firmware, None, host_toolchain()).path], stdin=master, stdout=master)
    try:
        outcome = run_on_board(load("triangle"), BoardRequest("path", os.ttyname(slave), samples=30, selftest=0))
        assert (outcome.max_ulp, outcome.u.compared) == (0, 90)
        assert outcome.elf is outcome.bound is None, "nobody knows what image is behind the cable"
    finally:
        process.kill()
        process.wait()
        os.close(master)
        os.close(slave)


@NEEDS_QEMU
def test_an_emulated_board_behind_a_serial_port(tmp_path):
    """QEMU makes a pseudo-terminal; the host opens it as it opens the cable of a board."""
    model, log = load("satellite"), tmp_path / "log"
    command = targets.qemu_command(build_image(model, BoardRequest("mrac", "qemu")), "pty")
    with log.open("wb") as messages:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=messages, stderr=messages)
    try:
        while not (terminal := re.search(r"redirected to (/dev/\S+)", log.read_text())):
            assert process.poll() is None
        outcome = run_on_board(model, BoardRequest("mrac", terminal[1], samples=60, selftest=0))
        assert (outcome.max_ulp, outcome.x.ulp, outcome.u.compared) == (0, 0, 180)
    finally:
        process.kill()
        process.wait()


def test_an_emulator_that_ends_at_once_leaves_nothing(tmp_path, monkeypatch):
    (tmp_path / "qemu-system-arm").write_text("#!/bin/sh\necho no such machine >&2\nexit 1\n")
    (tmp_path / "qemu-system-arm").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(LinkError, match="qemu netduinoplus2 has ended: no such machine"):
        run_on_board(load("satellite"), BoardRequest("mrac", "qemu", samples=3))
    assert [path.name for path in tmp_path.iterdir()] == ["qemu-system-arm"]


@pytest.mark.parametrize("text", ["exit 1", "exit 0"])
def test_a_compiler_that_does_not_start_is_as_good_as_none(tmp_path, monkeypatch, text):
    for name in ("arm-none-eabi-gcc", "aarch64-linux-gnu-gcc", "qemu-aarch64-static"):
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    toolchains._gcc.cache_clear()
    try:
        for request in (BoardRequest("mrac", "unicorn", compiler="gcc"), BoardRequest("mrac", "sil", "aarch64", "gcc")):
            with pytest.raises(MissingError, match="gcc is not installed: apt-get install"):
                build_image(load("satellite"), request)
    finally:
        toolchains._gcc.cache_clear()


def test_a_difference_is_found():
    a = np.array([[1.0, -0.0], [np.nan, 2.0]], np.float32)
    same = difference(a, a + np.array([[0, 0.0], [0, 0]], np.float32))
    assert (same.ulp, same.first) == (0, None)
    b = a.copy()
    b[1, 1] = np.nextafter(np.float32(2), np.float32(3))
    assert (difference(a, b).ulp, difference(a, b).first) == (1, 1)
    b[0, 0] = np.float32(-1)
    assert difference(a, b).ulp > 10**9
    assert difference(a[:1], a).ulp == 1
    assert difference(a, np.nan_to_num(a)).size == np.inf


def test_a_parameter_beyond_float_is_refused_by_name():
    request = BoardRequest("path", "sil", samples=3, parameters={"H": 1e39})
    with pytest.raises(InputError, match=r"H = 1e\+39 \(from --set\): must be at most 3.40282e\+38"):
        run_on_board(load("triangle"), request)


def test_what_cannot_be_run_is_refused():
    model = load("satellite")
    for request, text in (
        (BoardRequest("mrac", "sil", "stm32f4"), "unknown board .stm32f4. of software in the loop.*known: aarch64"),
        (BoardRequest("mrac", "unicorn", "stm32f9"), "did you mean stm32f4"),
        (BoardRequest("mrac", compiler="icc"), "known: zig, gcc"),
        (BoardRequest("mrac", tunable=("F_0",)), "unknown tunable 'F_0'.*did you mean F0"),
        (BoardRequest("mrac", "sil", samples=1), "must be a whole number >= 2"),
        (BoardRequest("mrac", "sil", raw=True, parameters={"F0": 2.0}), "bare link"),
        (BoardRequest("mrac", "sil", journal=Path("/no/such/folder/journal")), "journal = .*No such file"),
        (BoardRequest("mrac", "/dev/no-such-port"), "sil, unicorn, qemu, or a serial port"),
    ):
        with pytest.raises(InputError, match=text):
            run_on_board(model, request)


@pytest.mark.parametrize(("number", "text"), [(13, "no permission: .* dialout"), (2, "no such port"), (16, "another")])
def test_a_port_that_cannot_be_opened_says_why(monkeypatch, number, text):
    """Stands for the operating system, which refuses nothing to root."""
    import serial

    def refuse(*_args, **_named):
        raise serial.SerialException(number, "could not open port")

    monkeypatch.setattr(serial, "serial_for_url", refuse)
    with pytest.raises(InputError, match=f"target = '/dev/ttyUSB0': .*{text}"):
        SerialPort("/dev/ttyUSB0")


def test_a_port_that_is_pulled_out_is_a_link_error():
    master, slave = os.openpty()
    port = SerialPort(os.ttyname(slave))
    with pytest.raises(InputError, match="can be opened"):
        SerialPort(os.ttyname(slave))  # two hosts on one line would take each other's answers
    os.close(slave)
    os.close(master)
    with pytest.raises(LinkError, match="has closed"):
        port.read(0.1)


def test_the_process_ends_with_its_line():
    port = ProcessPort(build(program(load("triangle"), "path"), None, host_toolchain()).path)
    port._process.kill()
    port._process.wait()
    for use in (partial(port.read, 60.0), partial(port.write, b"\0")):
        with pytest.raises(LinkError, match="has ended"):
            use()
    port.close()
    assert port._process.returncode is not None


@pytest.mark.parametrize("target", ["sil", "unicorn", pytest.param("qemu", marks=needs("qemu-system-arm"))])
@pytest.mark.share(3)
def test_the_literal_law_diverges_with_the_same_bits(target):
    """To the end of its own: its torque passes what the model takes for lost, at sample 104 of float.

    Between two samples at 50.4 s its pitch passes 85 degrees, and comes back, so the limit of the pitch is set wider.
    """
    wider = {"pitch_lost": 1.57}  # rad, before the singularity at pi / 2
    request = BoardRequest("mrac-literal", target, samples=200, every=5, selftest=0, profiled=False, parameters=wider)
    outcome = run_on_board(load("satellite"), request)
    assert outcome.board.reason.startswith("lost (torque)")
    assert len(outcome.board.u_cmd) == 105
    assert np.abs(outcome.board.u_cmd[104]).max() > 1e5
    assert (outcome.u.compared, outcome.x.compared) == (3 * 105, 10 * 105)
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)


@pytest.mark.parametrize(("model", "law", "delay"), [("triangle", "path", 0), ("satellite", "mrac", 1)])
def test_a_self_test_begins_as_a_run_and_sums_up_what_the_law_said(model, law, delay):
    """A period of the plant is that of the host's run, rounded to single; the sum is zlib's CRC-32 of the inputs."""
    outcome = run_on_board(load(model), BoardRequest(law, "sil", samples=3, selftest=1))
    test = outcome.selftest
    assert outcome.single.options["delay"] == delay
    np.testing.assert_allclose(test.x, outcome.single.x[1], rtol=1e-5, atol=1e-6)
    assert test.crc == zlib.crc32(test.u.astype("<f4").tobytes())
    np.testing.assert_allclose(test.u, outcome.board.u_cmd[0], rtol=1e-6)
