# SPDX-License-Identifier: Apache-2.0
"""`mehvar board` as a user meets it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mehvar.runtime import load
from mehvar.runtime.board.image.build import program
from mehvar.runtime.board.line.link import Link
from mehvar.runtime.board.targets import ProcessPort
from tests.mehvar.browser import chromium, prefer
from tests.mehvar.cli.test_app import refused, run
from tests.mehvar.pages import violations
from tests.tools import needs

RUN = ("board", "run", "triangle", "--controller", "path", "--target", "sil", "--samples", "30")


def test_a_run_prints_its_numbers_as_json():
    done = run(*RUN, "--format", "json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert list(found)[:2] == ["max_ulp", "instructions_per_step"]
    assert (found["max_ulp"], found["samples"], found["delay"]) == (0, 30, 0)
    assert found["equivalence"]["inputs"]["compared"] == 90


def test_an_emulated_board_is_built_counted_and_reported(tmp_path):
    done = run(
        "board", "report", "satellite", "--controller", "pd", "--samples", "40", "--set", "roll_0_deg=3",
        "--out", str(tmp_path / "r"),
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads((tmp_path / "r" / "board.json").read_text())
    assert found["max_ulp"] == 0
    assert found["instructions_per_step"] > 200
    assert found["delay"] == 1
    assert found["image"]["double_routines"] == []
    assert found["board_against_simulation_without_delay"]["max_state"] > 0
    page = (tmp_path / "r" / "index.html").read_text()
    assert "bit for bit" in page
    assert "scenario paper, roll_0_deg = 3, delay of 1 sample(s)" in page
    assert "the closed loop, with the law on the board" in page.lower()
    assert "largest torque about x" in page
    words = re.sub(r"<[^>]*>", " ", re.sub(r"<(script|style).*?</\1>", "", page, flags=re.DOTALL))
    assert "×10⁻" in words
    assert not re.search(r"\de[-+]\d", words)
    assert set(found["metrics"]["max_torque_x"]) == {"board", "host_double", "host_without_delay"}
    with chromium() as browser:
        prefer(browser, prefers_color_scheme="dark")
        browser.get((tmp_path / "r" / "index.html").as_uri())
        assert violations(browser) == []


@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.soak
def test_the_delay_that_is_given_is_the_one_of_the_run(delay):
    done = run(
        "board", "run", "satellite", "--controller", "pd", "--target", "sil", "--samples", "20",
        "--set", f"delay={delay}", "--format", "json",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["delay"] == delay
    assert (found["board_against_simulation_without_delay"] is None) == (delay == 0)


@pytest.mark.soak
def test_what_build_exports_can_be_built(tmp_path):
    out = tmp_path / "firmware"
    done = run("board", "build", "triangle", "--controller", "path", "--out", str(out))
    assert done.returncode == 0, done.stderr
    image = (out / "firmware.elf").read_bytes()
    (out / "firmware.elf").unlink()
    subprocess.run(["bash", "build.sh"], cwd=out, check=True)
    assert len((out / "firmware.elf").read_bytes()) == pytest.approx(len(image), rel=0.01)
    assert (out / "firmware.bin").stat().st_size > 4000


PAGE = (Path(__file__).parents[3] / "docs" / "tutorials" / "board.md").read_text()
MAKE, CMAKE = (re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)[0] for kind in ("make", "cmake"))
"""As they are printed."""


OWN_NAMES = """\
typedef unsigned mask;
static int K, AND, real;
void board_init(void) { (void)K, (void)AND, (void)real; }
void app_start(void) {}
void link_send(void) {}
"""


@pytest.fixture
def vendor(tmp_path):
    """A project of somebody's own: its board's functions and its main loop, and what `board build` exported."""
    made = run(
        "board", "build", "triangle", "--controller", "path", "--target", "sil", "--out", str(tmp_path / "firmware")
    )
    assert made.returncode == 0, made.stderr
    own = [(tmp_path / "firmware" / name).read_text() for name in ("boards/posix.c", "main.c")]
    (tmp_path / "vendor.c").write_text("\n".join([OWN_NAMES, *own]))
    shutil.rmtree(tmp_path / "firmware" / "boards")
    (tmp_path / "firmware" / "main.c").unlink()
    (tmp_path / "Makefile").write_text(MAKE)
    (tmp_path / "CMakeLists.txt").write_text(CMAKE)
    return tmp_path


BUILDS = {
    "make": [["make", "-s", "vendor"]],
    "cmake": [
        ["cmake", "-S", ".", "-B", ".", "-DCMAKE_BUILD_TYPE=Release"],
        ["cmake", "--build", ".", "--target", "vendor"],
    ],
}


@pytest.mark.parametrize("tool", [pytest.param(tool, marks=needs(tool)) for tool in BUILDS])
@pytest.mark.share(2)
def test_a_vendors_project_takes_law_and_link(vendor, tool):
    """The program that it builds gives the same answers as ours."""
    if tool == "cmake":
        (vendor / "Makefile").unlink()
    for command in BUILDS[tool]:
        subprocess.run(command, cwd=vendor, check=True, stdout=subprocess.DEVNULL)
    found = []
    for path in (vendor / "vendor", vendor / "firmware" / "firmware.elf"):
        port = ProcessPort(path)
        try:
            link = Link(port, program(load("triangle"), "path").layout)
            link.connect()
            link.set("z", np.empty(0))
            found.append(link.selftest(50).crc)
        finally:
            port.close()
    assert found[0] == found[1]


@needs("cmake", "arm-none-eabi-gcc")
def test_the_cmake_fragment_cross_compiles(vendor):
    (vendor / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.16)\nproject(v C)\ninclude(firmware/mehvar.cmake)\n"
    )
    flags = "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -O2 -Werror -Wall -Wdouble-promotion"
    options = ["-DCMAKE_SYSTEM_NAME=Generic", "-DCMAKE_C_COMPILER=arm-none-eabi-gcc", f"-DCMAKE_C_FLAGS={flags}"]
    options.append("-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY")
    for command in (["cmake", "-S", ".", "-B", "arm", *options], ["cmake", "--build", "arm"]):
        subprocess.run(command, cwd=vendor, check=True, stdout=subprocess.DEVNULL)
    assert (vendor / "arm" / "libmehvar.a").stat().st_size > 4000


def test_mistakes_are_named():
    assert "unknown model" in refused("board", "run", "sattelite", "--controller", "mrac")
    assert "did you mean stm32f4" in refused("board", "build", "satellite", "--controller", "pd", "--board", "stm32")
    assert "format = 'xml'" in refused(*RUN, "--format", "xml")
    assert "must be given with --inline-parameters; without it every parameter can be set" in refused(
        *RUN, "--tunable", "R"
    )
    assert "backend = 'python'" in refused(*RUN, "--set", "backend=python")
    assert "must be sil, unicorn, qemu, or a serial port" in refused(*RUN[:-4], "--target", "/dev/nowhere")


def test_a_folder_that_cannot_be_written_is_named_before_anything_runs(tmp_path):
    taken = tmp_path / "file"
    taken.write_text("")
    for command in ("build", "report"):
        said = refused("board", command, "triangle", "--controller", "path", "--out", str(taken / "r"))
        assert "(from --out): must be a folder that can be made" in said


def test_flash_says_that_nobody_has_tried():
    done = run("board", "flash", "triangle", "--controller", "path", "--dry-run")
    assert done.returncode == 0
    assert "not tested on silicon" in done.stdout
    assert "openocd" in done.stdout
