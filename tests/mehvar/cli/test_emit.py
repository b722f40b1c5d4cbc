# SPDX-License-Identifier: Apache-2.0
"""`mehvar board emit --link`: a package is built from what its manifest says, and computes the bits of our firmware."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from mehvar.package.files import FRAMEWORKS, KINDS, package
from mehvar.runtime.board.image.build import FIRMWARE, build, program
from mehvar.runtime.board.image.toolchains import host_toolchain
from mehvar.runtime.board.line.link import Link
from mehvar.runtime.board.targets import ProcessPort
from mehvar.runtime.compiling.compiler import write_sources
from tests.mehvar.cli.test_app import refused, run
from tests.runtime.board.conftest import load
from tests.tools import needs

ARM = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-O2", "-ffunction-sections")
LINKED = [kind for kind in KINDS if kind not in FRAMEWORKS]
CASES = [("satellite", "mrac", None), ("triangle", "path", None), ("satellite", "mrac", ("F0",))]
"""Model, law, and the parameters that can still be set where the others are constants."""
ZEPHYR = """\
cmake_minimum_required(VERSION 3.16)
project(app C)
set(CONFIG_TRIANGLE_PATH_LINK y)
macro(zephyr_include_directories)
  include_directories(${CMAKE_CURRENT_SOURCE_DIR}/${ARGV0})
endmacro()
macro(zephyr_library_named name)
  add_library(${name} STATIC)
  set(library ${name})
endmacro()
macro(zephyr_library_sources)
  target_sources(${library} PRIVATE ${ARGV})
endmacro()
add_subdirectory(law/zephyr)
"""
"""Zephyr's functions, as its manual has them."""


def emitted(folder: Path, kind: str, model: str, law: str, tunable: tuple[str, ...] | None = None) -> Path:
    write_sources(folder / "law", package(program(load(model), law, tunable=tunable), kind, link=True))
    return folder / "law"


def units(folder: Path, kind: str) -> list[Path]:
    """Return the sources of a package, as its build system would have them."""
    if kind == "cmake":
        names = re.findall(r"^  (\S+\.c)$", (folder / "CMakeLists.txt").read_text(), re.MULTILINE)
    elif kind == "zephyr":
        names = re.findall(r"\.\./(\S+\.c)", (folder / "zephyr" / "CMakeLists.txt").read_text())
    elif kind == "stm32cube":
        tree = ET.parse(next(folder.glob("*.pdsc")))
        names = [f.attrib["name"] for f in tree.iter("file") if f.attrib["category"] == "source"]
    else:
        directory = (
            json.loads((folder / "library.json").read_text())["build"]["srcDir"] if kind == "platformio" else "src"
        )
        return sorted((folder / directory).rglob("*.c"))
    return [folder / name for name in names]


def checksum(path: Path, model: str, law: str) -> int:
    """Return the output of a process's self-test."""
    port = ProcessPort(path)
    try:
        layout = program(load(model), law).layout
        link = Link(port, layout)
        link.connect()
        link.set("z", np.zeros(len(layout.memory)))
        return link.selftest(40).crc
    finally:
        port.close()


@pytest.mark.parametrize(
    ("kind", "model", "law", "tunable"),
    [*((kind, *CASES[0]) for kind in LINKED), *(("cmake", *case) for case in CASES[1:])],
    ids=str,
)
@pytest.mark.share(9)
def test_a_package_computes_our_bits_without_any_flag(tmp_path, kind, model, law, tunable):
    """With fused multiplication in reach, which gcc takes unless it is told not to."""
    folder = emitted(tmp_path, kind, model, law, tunable)
    own = [FIRMWARE / "boards" / "posix.c", FIRMWARE / "main.c"]
    for place, files in (("theirs", units(folder, kind)), ("ours", own)):
        (tmp_path / place).mkdir()
        for file in files:
            command = ["gcc", "-O2", "-march=haswell", f"-I{folder}/src", "-c", str(file)]
            subprocess.run(command, cwd=tmp_path / place, check=True)
    objects = sorted(tmp_path.glob("*/*.o"))
    assert len(objects) == (6 if tunable is None else 7)
    subprocess.run(["gcc", *objects, "-o", "vendor", "-lm"], cwd=tmp_path, check=True)
    expected = checksum(build(program(load(model), law), None, host_toolchain()).path, model, law)
    assert checksum(tmp_path / "vendor", model, law) == expected


@needs("arm-none-eabi-gcc", "cmake")
@pytest.mark.parametrize("kind", ["cmake", "zephyr"])
@pytest.mark.share(2)
def test_cmake_builds_a_package_for_a_microcontroller(tmp_path, kind):
    folder = emitted(tmp_path, kind, "triangle", "path")
    text = (
        ZEPHYR if kind == "zephyr" else "cmake_minimum_required(VERSION 3.16)\nproject(app C)\nadd_subdirectory(law)\n"
    )
    (tmp_path / "CMakeLists.txt").write_text(text)
    options = [
        "-DCMAKE_SYSTEM_NAME=Generic",
        "-DCMAKE_C_COMPILER=arm-none-eabi-gcc",
        f"-DCMAKE_C_FLAGS={' '.join(ARM)}",
    ]
    options.append("-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY")
    for command in (["cmake", "-S", ".", "-B", "arm", *options], ["cmake", "--build", "arm"]):
        subprocess.run(command, cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    library = next((tmp_path / "arm").rglob("libtriangle_path_link.a"))
    listing = subprocess.run(["arm-none-eabi-nm", library], capture_output=True, text=True, check=True).stdout
    assert "T mv_server_byte" in listing
    assert folder.is_dir()


@needs("arm-none-eabi-gcc")
@pytest.mark.parametrize("kind", ["platformio", "arduino", "stm32cube"])
@pytest.mark.share(3)
def test_a_microcontrollers_gcc_fuses_nothing_in_a_package(tmp_path, kind):
    folder = emitted(tmp_path, kind, "satellite", "mrac")
    for unit in units(folder, kind):
        command = [
            "arm-none-eabi-gcc",
            *ARM,
            "-Wall",
            "-Werror",
            "-Isrc",
            "-S",
            unit.relative_to(folder),
            "-o",
            "text.s",
        ]
        subprocess.run(command, cwd=folder, check=True)
        assert not re.search(r"\tvfn?m[as]\.", (folder / "text.s").read_text()), unit
    if kind == "arduino":
        properties = dict(line.split("=", 1) for line in (folder / "library.properties").read_text().splitlines())
        sketch = "void setup() { mv_server_init(); }\nvoid loop() { mv_server_byte(0); }\n"
        (tmp_path / "sketch.cpp").write_text(
            "".join(f"#include <{h}>\n" for h in properties["includes"].split(",")) + sketch
        )
        command = [
            "arm-none-eabi-g++" if shutil.which("arm-none-eabi-g++") else "g++",
            "-fsyntax-only",
            f"-I{folder}/src",
        ]
        subprocess.run([*command, tmp_path / "sketch.cpp"], check=True)


@needs("arm-none-eabi-gcc")
def test_evidence_is_given_for_an_image_of_somebody_elses(tmp_path):
    folder = emitted(tmp_path, "cmake", "satellite", "pd")
    (folder / "main.c").write_text(
        '#include "mehvar/server.h"\n#include "mehvar/board.h"\n'
        "int main(void) { mv_server_init(); for (;;) mv_server_byte((uint8_t)mv_board_read()); }\n"
    )
    sources = ["main.c", *(str(unit.relative_to(folder)) for unit in units(folder, "cmake"))]
    link = ["-Isrc", "-nostdlib", "-Wl,--gc-sections", "-Wl,-e,main", "-Wl,--unresolved-symbols=ignore-all"]
    subprocess.run(["arm-none-eabi-gcc", *ARM, *link, *sources, "-o", "user.elf"], cwd=folder, check=True)
    image, out = str(folder / "user.elf"), tmp_path / "evidence"
    asked = ("board", "evidence", "satellite", "--elf", image, "--out", str(out), "--controller")
    done = run(*asked, "pd")
    assert done.returncode == 0, done.stderr
    found = json.loads((out / "evidence.json").read_text())
    law, step, *called = found["functions"]
    assert (law["function"], step["function"]) == ("satellite_pd", "mv_app_step")
    assert {f["function"] for f in called} == {*law["calls"], *step["calls"]} - {"satellite_pd"}
    assert (law["loops"], law["recursive"], law["indirect"], law["reasons"]) == (0, False, 0, [])
    assert 100 < law["own"] < law["bound"] < step["bound"] < 4000
    assert 0 < law["stack"] < step["stack"] < 1000
    assert "satellite_pd" in (out / "evidence.md").read_text()
    asked = (*asked[:-2], str(tmp_path / "none"), "--controller")
    assert "an image with the function satellite_mrac" in refused(*asked, "mrac")
    subprocess.run(["arm-none-eabi-strip", image], check=True)
    assert "do not strip it" in refused(*asked, "pd")


def test_the_settings_are_what_keeps_the_bits(tmp_path):
    """Without them the compiler does fuse: the test above can fail."""
    if not shutil.which("arm-none-eabi-gcc"):
        pytest.skip("no arm-none-eabi-gcc: apt install gcc-arm-none-eabi")
    folder = emitted(tmp_path, "arduino", "satellite", "mrac")
    law = folder / "src" / "satellite.c"
    law.write_text(re.sub(r"#pragma GCC.*", "", law.read_text()))
    command = ["arm-none-eabi-gcc", *ARM, "-Isrc", "-S", "src/satellite.c", "-o", "text.s"]
    subprocess.run(command, cwd=folder, check=True)
    assert re.search(r"\tvfn?m[as]\.", (folder / "text.s").read_text())


OURS_TO_WRITE = {
    "mv_board_init", "mv_board_ms", "mv_board_name", "mv_board_output", "mv_board_read", "mv_board_reset",
    "mv_board_stack", "mv_board_ticks", "mv_board_ticks_per_second", "mv_board_write", "mv_board_wait",
}  # fmt: skip
"""Functions of mehvar/board.h, which a project supplies."""


@needs("arm-none-eabi-gcc")
@pytest.mark.parametrize(
    ("processor", "helpers"),
    [(ARM, set()), (("-mcpu=cortex-m3", "-mthumb", "-O2"), {"__aeabi"})],
    ids=["with an FPU", "without"],
)
@pytest.mark.parametrize(("model", "law"), [("satellite", "mrac"), ("triangle", "sliding"), ("slosh", "lyapunov-v1")])
@pytest.mark.share(6)
def test_a_package_needs_no_c_library(tmp_path, model, law, processor, helpers):
    """Without any flag and with math.h at hand: gcc itself needs memcpy and memset, and its helpers without an FPU."""
    folder = emitted(tmp_path, "arduino", model, law)
    (folder / "main.c").write_text("void mv_server_init(void);\nint main(void) { mv_server_init(); }\n")
    sources = ["main.c", *(str(unit.relative_to(folder)) for unit in units(folder, "arduino"))]
    link = ["-Isrc", "-nostdlib", "-r", "-o", "law.o"]
    subprocess.run(["arm-none-eabi-gcc", *processor, *link, *sources], cwd=folder, check=True)
    listing = subprocess.run(["arm-none-eabi-nm", "-u", folder / "law.o"], capture_output=True, text=True, check=True)
    names = {line.split()[-1] for line in listing.stdout.splitlines()} - OURS_TO_WRITE
    assert {name for name in names if name.partition("_f")[0].partition("_ui")[0] not in helpers} <= {
        "memcpy",
        "memset",
    }


@pytest.mark.parametrize(
    "compiler",
    [("gcc", "-O2", "-march=haswell"), pytest.param(("arm-none-eabi-gcc", *ARM), marks=needs("arm-none-eabi-gcc"))],
    ids=lambda compiler: compiler[0],
)
@pytest.mark.parametrize("link", [False, True], ids=["the law", "its line"])
def test_headers_leave_the_code_of_their_user_alone(tmp_path, compiler, link):
    """A function of the user's own is compiled to the same instructions with and without every public header."""
    folder = tmp_path / "law"
    write_sources(folder, package(program(load("satellite"), "mrac"), "arduino", link))
    function = "float mine(float a, float b, float c) { return a * b + c; }\n"
    headers = [
        path.relative_to(folder / "src") for path in (folder / "src").rglob("*.h") if "private" not in path.parts
    ]
    assert len(headers) > 2
    texts = []
    for included in ("", "".join(f'#include "{header}"\n' for header in headers)):
        (tmp_path / "mine.c").write_text(included + function)
        command = [*compiler, f"-I{folder}/src", "-S", "mine.c", "-o", "mine.s"]
        subprocess.run(command, cwd=tmp_path, check=True)
        assembly = (tmp_path / "mine.s").read_text()
        texts.append(assembly[assembly.index("mine:") : assembly.index("\t.size\tmine")])
    assert texts[0] == texts[1]
    assert re.search(r"\tvfn?m", texts[0]), "the compiler fuses without being told not to"


def test_the_command_writes_a_folder_and_refuses_what_it_does_not_know(tmp_path):
    out = tmp_path / "law"
    done = run("board", "emit", "triangle", "--controller", "path", "--for", "arduino", "--out", str(out))
    assert done.returncode == 0, done.stderr
    assert (out / "library.properties").is_file()
    wrong = refused(
        "board", "emit", "triangle", "--controller", "path", "--for", "ardino", "--out", str(tmp_path / "x")
    )
    assert "did you mean arduino" in wrong
    emit = ["board", "emit", "satellite", "--controller", "pd", "--for", "cmake", "--out", str(tmp_path / "x")]
    ranges = [refused(*emit, "--range", text) for text in ("nose=1:2", "hx=-1:1")]
    names = {text.partition("known: ")[2].partition("\n")[0] for text in ranges}
    assert names == {"roll, pitch, yaw, wx, wy, wz, ref_roll, ref_pitch, ref_yaw"}
    assert not (tmp_path / "x").exists()
