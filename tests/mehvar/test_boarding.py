# SPDX-License-Identifier: Apache-2.0
"""`mehvar board` as a user meets it."""

from __future__ import annotations

import json
import shutil
import subprocess

import pytest

from tests.mehvar.test_cli import refused, run

RUN = ("board", "run", "triangle", "--controller", "path", "--target", "sil", "--samples", "30")


def test_a_run_prints_its_numbers_as_json():
    done = run(*RUN, "--format", "json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert list(found)[:2] == ["max_ulp", "instructions_per_step"]
    assert (found["max_ulp"], found["samples"], found["delay"]) == (0, 30, 0)
    assert found["equivalence"]["inputs"]["compared"] == 90


def test_an_emulated_board_is_built_counted_and_reported(tmp_path):
    done = run("board", "report", "satellite", "--controller", "pd", "--samples", "40", "--out", str(tmp_path / "r"))
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads((tmp_path / "r" / "board.json").read_text())
    assert found["max_ulp"] == 0
    assert found["instructions_per_step"] > 200
    assert found["delay"] == 1
    assert found["image"]["double_routines"] == []
    assert found["board_against_simulation_without_delay"]["max_state"] > 0
    page = (tmp_path / "r" / "index.html").read_text()
    assert "bit for bit" in page
    assert "figure 11, with the law on the board" in page


def test_what_build_exports_can_be_built(tmp_path):
    out = tmp_path / "firmware"
    done = run("board", "build", "triangle", "--controller", "path", "--out", str(out))
    assert done.returncode == 0, done.stderr
    image = (out / "firmware.elf").read_bytes()
    (out / "firmware.elf").unlink()
    subprocess.run(["bash", "build.sh"], cwd=out, check=True)
    assert len((out / "firmware.elf").read_bytes()) == pytest.approx(len(image), rel=0.01)
    assert (out / "firmware.bin").stat().st_size > 4000


@pytest.mark.skipif(not shutil.which("make"), reason="not installed")
def test_the_make_fragment_compiles_law_and_link(tmp_path):
    out = tmp_path / "firmware"
    run("board", "build", "triangle", "--controller", "path", "--target", "sil", "--out", str(out))
    (tmp_path / "Makefile").write_text(
        "MEHVAR = firmware\ninclude firmware/mehvar.mk\n"
        "all:\n\t$(CC) $(MEHVAR_CFLAGS) -fsyntax-only $(MEHVAR_SOURCES)\n"
    )
    subprocess.run(["make", "-s"], cwd=tmp_path, check=True)


def test_mistakes_are_named():
    assert "unknown model" in refused("board", "run", "sattelite", "--controller", "mrac")
    assert "did you mean stm32f4" in refused("board", "build", "satellite", "--controller", "pd", "--board", "stm32")
    assert "format = 'xml'" in refused(*RUN, "--format", "xml")
    assert "backend = 'python'" in refused(*RUN, "--set", "backend=python")
    assert "must be sil, unicorn, qemu, qemu-pty, or a serial port" in refused(*RUN[:-4], "--target", "/dev/nowhere")


def test_flash_says_that_nobody_has_tried():
    done = run("board", "flash", "triangle", "--controller", "path", "--dry-run")
    assert done.returncode == 0
    assert "not tested on silicon" in done.stdout
    assert "openocd" in done.stdout
