# SPDX-License-Identifier: Apache-2.0
"""A package as a library of the Arduino IDE: built by its builder with its core, run on an emulated ATmega2560."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from mehvar.package.files import package
from mehvar.runtime.compiling.compiler import write_sources
from tests.mehvar.package.test_laws import SAMPLES, closed_loop, firmware, table
from tests.tools import needs

HARDWARE = "/usr/share/arduino/hardware"
BUILDER = [
    *("arduino-builder", "-compile", "-fqbn", "arduino:avr:mega:cpu=atmega2560", "-core-api-version", "10819"),
    *("-hardware", HARDWARE, "-hardware", "/usr/share/arduino-builder", "-tools", "/usr/bin"),
    *("-prefs", "runtime.tools.avr-gcc.path=/usr", "-prefs", "tools.ctags.cmd.path=/usr/bin/arduino-ctags"),
    *("-prefs", "compiler.cpp.extra_flags=-DDECIMAL_DIG=9"),  # which the core has from compilers newer than gcc 5
]


@needs("arduino-builder", "avr-gcc", "simavr")
@pytest.mark.parametrize(
    ("model", "law"), [("satellite", "pd"), pytest.param("triangle", "path", marks=pytest.mark.soak)]
)
def test_a_sketch_computes_our_bits_on_eight_bits(model: str, law: str, tmp_path: Path) -> None:
    subject = firmware(model, law)
    library = f"{model}_{law}"
    write_sources(tmp_path / "libraries" / library, package(subject, "arduino"))
    measured, reference, applied, expected = zip(*closed_loop(subject), strict=True)
    sketch = tmp_path / "sketch"
    sketch.mkdir()
    tables = {"measured": measured, "reference": reference, "applied": applied}
    texts = "".join(table(name, list(rows)) for name, rows in tables.items())
    (sketch / "samples.h").write_text(f"enum {{ SAMPLES = {SAMPLES} }};\n{texts}")
    text = (Path(__file__).parent / "sketch.ino").read_text()
    (sketch / "sketch.ino").write_text(text.replace("NAME", library.upper()).replace("name", library))
    (tmp_path / "build").mkdir()
    places = ["-libraries", tmp_path / "libraries", "-build-path", tmp_path / "build", sketch / "sketch.ino"]
    done = subprocess.run([*BUILDER, *places], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    board = ["simavr", "-m", "atmega2560", "-f", "16000000", tmp_path / "build" / "sketch.ino.elf"]
    output = subprocess.run(board, capture_output=True, text=True, check=True, timeout=60, errors="replace")
    words = re.findall(r"(?<![0-9A-F])[0-9A-F]{8}(?![0-9A-F])", output.stdout + output.stderr)
    assert words == [f"{bits:08X}" for row in expected for bits in row.astype("<f4").view("<u4")]
