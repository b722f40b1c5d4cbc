# SPDX-License-Identifier: Apache-2.0
"""Board and host agree to the last bit: two emulators, two compilers, three processors, every kind of law."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from runtime.board.build import build, program
from runtime.board.link import Link
from runtime.board.run import Asked, build_image, difference, run_on_board
from runtime.board.session import BoardLaw
from runtime.board.targets import ProcessPort, open_target
from runtime.board.toolchains import host_toolchain
from runtime.errors import InputError
from tests.runtime.board.conftest import load

GCC = pytest.param("gcc", marks=pytest.mark.skipif(not shutil.which("arm-none-eabi-gcc"), reason="not installed"))
QEMU = pytest.param("qemu", marks=pytest.mark.skipif(not shutil.which("qemu-system-arm"), reason="not installed"))
LAWS = [("satellite", "mrac"), ("satellite", "pd"), ("triangle", "path"), ("triangle", "sliding")]
SELF_TEST = {"samples": 5000, "crc": "7d461ad4"}


@pytest.mark.parametrize(("model", "law"), LAWS)
def test_software_in_the_loop(model, law):
    outcome = run_on_board(load(model), Asked(law, "sil", samples=600))
    assert (outcome.max_ulp, outcome.x.ulp, outcome.u.compared) == (0, 0, outcome.single.u_cmd.size)


@pytest.mark.parametrize("compiler", [GCC, "zig"])
@pytest.mark.parametrize("target", ["unicorn", QEMU])
def test_every_emulator_with_every_compiler(target, compiler):
    outcome = run_on_board(load("satellite"), Asked("mrac", target, compiler=compiler, samples=300))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)
    assert outcome.z.compared > 0
    assert outcome.selftest is not None
    assert outcome.restored == 0


@pytest.mark.skipif(not shutil.which("arm-none-eabi-gcc"), reason="not installed")
@pytest.mark.parametrize("board", ["mps2-m3", "mps2-m4f", "mps2-m7"])
def test_other_processors(board):
    outcome = run_on_board(
        load("satellite"), Asked("mrac", "unicorn", board, "gcc", samples=100, selftest=20, profiled=False)
    )
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)


@pytest.mark.parametrize("model", ["triangle", "slosh"])
def test_other_models_on_the_processor(model):
    law = {"triangle": "path", "slosh": "lyapunov-v1"}[model]
    assert run_on_board(load(model), Asked(law, "unicorn", samples=100, selftest=0)).max_ulp == 0


@pytest.mark.parametrize("target", ["sil", "unicorn", QEMU])
def test_bare_packets(target):
    outcome = run_on_board(load("satellite"), Asked("mrac", target, samples=100, raw=True))
    assert (outcome.u.compared, outcome.u.ulp, outcome.x.ulp) == (300, 0, 0)


def test_five_thousand_samples_past_the_end_of_the_scenario():
    """All torques and every number of the memory; law and plant on the target give one checksum."""
    asked = Asked("mrac", "unicorn", samples=5000, every=25, selftest=SELF_TEST["samples"], profiled=False)
    outcome = run_on_board(load("satellite"), asked)
    assert outcome.u.compared == 15000
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)
    found = {f"{outcome.selftest.crc:08x}", _self_test("sil"), SELF_TEST["crc"]}
    assert len(found) == 1


def _self_test(target: str) -> str:
    """Run law and plant on the target from the scenario's start."""
    model = load("satellite")
    image = build_image(model, Asked("mrac", target))
    port = open_target(target, image)
    try:
        link = Link(port, image.program.layout)
        link.connect()
        resolved = image.program.resolved
        for group, values in (("p", resolved.p), ("c", resolved.c), ("s", resolved.s)):
            link.set(group, values)
        start = model.functions["mrac_start"]
        x, r = (
            model.functions["initial"](resolved.p, resolved.s),
            model.functions["reference"](0.0, resolved.p, resolved.s),
        )
        link.set("z", start(x, r, resolved.p, resolved.c))
        return f"{link.selftest(SELF_TEST['samples']).crc:08x}"
    finally:
        port.close()


def test_a_run_on_the_board_is_a_run_of_simulate(bench):
    law = BoardLaw(bench.link(), bench.expected.parameters, bench.program.layout)
    run = bench.simulate(law=law)
    assert bench.same(run)
    assert run.z[1:].astype(np.float32).tobytes() == bench.expected.z[1:].astype(np.float32).tobytes()


def test_a_serial_port(tmp_path):
    """A pseudo-terminal, with the process behind it, stands for the cable."""
    import os
    import subprocess
    import tty

    made = program(load("triangle"), "path")
    master, slave = os.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    process = subprocess.Popen([build(made, None, host_toolchain()).path], stdin=master, stdout=master)
    try:
        outcome = run_on_board(load("triangle"), Asked("path", os.ttyname(slave), samples=30, selftest=0))
        assert (outcome.max_ulp, outcome.u.compared) == (0, 90)
    finally:
        process.kill()
        process.wait()
        os.close(master)
        os.close(slave)


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


def test_what_cannot_be_run_is_refused():
    model = load("satellite")
    for asked, text in (
        (Asked("mrac", "sil", "stm32f4"), "must be left out for software in the loop"),
        (Asked("mrac", "unicorn", "stm32f9"), "did you mean stm32f4"),
        (Asked("mrac", compiler="icc"), "known: zig, gcc"),
        (Asked("mrac", "sil", samples=1), "must be a whole number >= 2"),
        (Asked("mrac", "sil", raw=True, values={"F0": 2.0}), "bare link"),
        (Asked("mrac", "/dev/no-such-port"), "sil, unicorn, qemu, or a serial port"),
    ):
        with pytest.raises(InputError, match=text):
            run_on_board(model, asked)


def test_the_process_ends_with_its_line():
    port = ProcessPort(build(program(load("triangle"), "path"), None, host_toolchain()).path)
    port.close()
    assert port._process.returncode is not None
