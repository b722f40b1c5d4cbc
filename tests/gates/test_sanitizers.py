# SPDX-License-Identifier: Apache-2.0
"""Generated and runtime C under the address and undefined-behaviour sanitizers: every function, loop and batch."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar.base import cache
from mehvar.runtime import load
from mehvar.runtime.model.derived import folder_with

HERE = Path(__file__).parent
UNDEFINED = "-fno-sanitize-recover=all -fsanitize=undefined,float-cast-overflow"
FLAGS = {
    "gcc": f"{UNDEFINED} -fsanitize=address",
    "zig": f"{UNDEFINED} -fsanitize-trap=all",  # without an address sanitizer; a trap needs no library
}
PLANTED = {
    "read past the end": "double f(int n) { double *a = malloc(n * sizeof *a); double b = a[n]; free(a); return b; }",
    "overflow": "double f(int n) { return n + 2147483647; }",
    "cast": "double f(int n) { return (int)(n * 1e300); }",
}


def watched(folder: Path, compiler: str, code: list[str], optimise: str = "-O0") -> subprocess.CompletedProcess[str]:
    """Run Python with libraries that are compiled with sanitizers; what a sanitizer finds ends the process."""
    program = "gcc" if compiler == "gcc" else f'"{sys.executable}" -m ziglang cc'
    cc = folder / "cc"
    cc.write_text(f'#!/bin/sh\nunset LD_PRELOAD\nexec {program} "$@" {optimise} {FLAGS[compiler]}\n')
    cc.chmod(0o755)
    environment = {**os.environ, "CC": str(cc), "MEHVAR_CACHE": str(folder / "cache"), "PYTHONMALLOC": "malloc"}
    if compiler == "gcc":
        found = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
        environment |= {"LD_PRELOAD": found.stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0"}  # Python leaks at its end
    return subprocess.run(
        [sys.executable, *code], env=environment, capture_output=True, text=True, check=False, errors="replace"
    )


@pytest.mark.parametrize(
    ("compiler", "model"),
    [
        ("gcc", "triangle:path"),
        *(pytest.param("gcc", model, marks=pytest.mark.soak) for model in ("triangle", "satellite", "slosh")),
        *(pytest.param("zig", model, marks=pytest.mark.soak) for model in ("triangle", "satellite", "slosh")),
    ],
)
def test_no_sanitizer_finds_anything(compiler, model, tmp_path):
    optimise = "-O1" if model == "slosh" else "-O0"
    name = model.partition(":")[0]
    made = load(name).manifest  # files that are derived when first used, by a Python that bears no sanitizer
    for file in {function.file for function in made.functions.values()}:
        folder_with(made, file)
    entries = cache.cache_folder() / "derived"
    shutil.copytree(entries, tmp_path / "cache" / "derived", ignore=shutil.ignore_patterns("build-*"))  # of others
    done = watched(tmp_path, compiler, [str(HERE / "exercise.py"), model], optimise)
    assert done.returncode == 0, done.stderr[-4000:]
    assert f"{name}: " in done.stdout


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("zig", marks=pytest.mark.soak)])
@pytest.mark.parametrize("fault", PLANTED)
def test_a_planted_fault_is_found(compiler, fault, tmp_path):
    text = f"#include <stdlib.h>\n{PLANTED[fault]}\n"
    load = f"load_library('planted', {{'f.c': {text!r}}}, ['f.c']).f(3)"
    code = f"from mehvar.runtime.compiling.library import load_library; {load}"
    done = watched(tmp_path, compiler, ["-c", code])
    if compiler == "gcc":
        assert re.search("runtime error|AddressSanitizer", done.stderr), done.stderr
    assert (done.returncode != 0) == ((compiler, fault) != ("zig", "read past the end"))
