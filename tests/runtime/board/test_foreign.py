# SPDX-License-Identifier: Apache-2.0
"""Evidence for images of other projects: a Cortex-M7 and RISC-V, with the linker's map."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from mehvar.package.files import package
from mehvar.runtime.board.image.build import program
from mehvar.runtime.compiling.compiler import write_sources
from tests.mehvar.cli.test_app import refused, run
from tests.runtime.board.conftest import load
from tests.tools import needs

MAIN = """\
#include "satellite_pd.h"
#include <string.h>
static satellite_pd_state law;
static mv_real measured[SATELLITE_PD_NMEASURED], reference[SATELLITE_PD_NREFERENCE], command[SATELLITE_PD_NCOMMAND];
volatile unsigned n;
char text[64];
int main(void)
{
    memset(text, n, sizeof text - n);
    satellite_pd_init(&law, &satellite_pd_defaults);
    for (;;) satellite_pd_step(&law, measured, reference, command);
}
void _start(void) { main(); }
"""
M7 = ("arm-none-eabi-gcc", "-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16")
RISCV = ("riscv64-linux-gnu-gcc", "-static")


def image(folder: Path, command: tuple[str, ...]) -> Path:
    write_sources(folder, package(program(load("satellite"), "pd"), "arduino"))
    (folder / "main.c").write_text(MAIN)
    line = [*command, "-O2", "-Isrc", "-nostartfiles", "-Wl,-Map=a.map", "main.c", "src/satellite_pd.c", "-o", "a.elf"]
    subprocess.run(line, cwd=folder, check=True)
    return folder / "a.elf"


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=needs(c[0])) for c in (M7, RISCV)], ids=["Cortex-M7", "RISC-V"]
)
def test_an_image_is_inspected_with_its_map(tmp_path, command):
    elf = image(tmp_path, command)
    line = ("board", "evidence", "satellite", "--controller", "pd", "--elf", str(elf))
    done = run(*line, "--map", str(tmp_path / "a.map"), "--out", str(tmp_path / "out"))
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "out" / "evidence.json").read_text())
    law, step, *called = found["functions"]
    assert (law["function"], step["function"]) == ("satellite_pd", "satellite_pd_step")
    assert law["depth"] < step["depth"] == 1 + max(f["depth"] for f in (law, *called) if f["function"] in step["calls"])
    assert 0 < law["stack"] < step["stack"] < 1000
    assert (law["loops"], law["recursive"], law["reasons"]) == (0, False, [])
    assert 100 < law["bound"] <= law["own"] + sum(f["bound"] for f in called) * 10
    nm = [command[0].replace("gcc", "objdump"), "-d", "--disassemble=satellite_pd", elf]
    listing = subprocess.run(nm, capture_output=True, text=True, check=True).stdout
    lines = re.findall(r"^ +[0-9a-f]+:\t[0-9a-f ]+\t(?!\.word|\.short)", listing, re.MULTILINE)
    assert law["own"] == len(lines), "as the compiler's own disassembler counts"
    assert law["origin"].endswith(".o")
    assert any(m["symbol"] == "memset" for m in found["members"])
    if command is M7:
        assert step["bound"] > law["bound"]
    else:
        assert "no register counts its iterations" in step["reasons"][0]


@needs("arm-none-eabi-gcc")
def test_what_is_no_map_is_refused(tmp_path):
    elf = image(tmp_path, M7)
    line = ("board", "evidence", "satellite", "--controller", "pd", "--out", str(tmp_path / "out"))
    assert "a map of GNU ld" in refused(*line, "--elf", str(elf), "--map", str(tmp_path / "main.c"))
    assert "given together with --elf" in refused(*line, "--map", str(tmp_path / "a.map"))
