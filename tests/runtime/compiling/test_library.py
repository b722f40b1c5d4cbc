# SPDX-License-Identifier: Apache-2.0
"""Compilation and its cache: once per content, never a damaged library, never a silent wrong compiler."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.base import cache as cache_folder
from mehvar.runtime import BuildError, InputError
from mehvar.runtime.compiling import compiler
from mehvar.runtime.compiling import library as build

ROOT = Path(mehvar.__file__).parent.parent
SEVEN = {"seven.c": "int seven(void) { return 7; }\n"}


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("MEHVAR_CACHE", str(folder))
    return folder


def seven() -> int:
    return int(build.load_library("seven", SEVEN, ["seven.c"]).seven())


def library_in(folder: Path) -> Path:
    (library,) = folder.rglob("*.so")
    return library


def entries(cache: Path) -> list[Path]:
    """Return the content of the cache, unfinished work included."""
    return list(cache.glob("*/*"))


def test_compiles_once_per_content(cache: Path) -> None:
    assert seven() == 7
    written = library_in(cache).stat().st_mtime_ns
    assert seven() == 7
    assert library_in(cache).stat().st_mtime_ns == written
    eight = {"seven.c": "int seven(void) { return 8; }\n"}
    assert build.load_library("seven", eight, ["seven.c"]).seven() == 8
    assert len(list(cache.rglob("*.so"))) == 2


def test_flags_are_part_of_the_key(cache: Path) -> None:
    build.load_library("seven", SEVEN, ["seven.c"], ["-O1"])
    build.load_library("seven", SEVEN, ["seven.c"], ["-O2"])
    assert len(list(cache.rglob("*.so"))) == 2


def test_nothing_else_is_left_in_the_cache(cache: Path) -> None:
    seven()
    (folder,) = (cache / "libraries").iterdir()
    assert sorted(path.name for path in folder.iterdir()) == [".sha256", "seven.so"]


@pytest.mark.parametrize("damage", ["truncated", "unloadable", "no digest"])
def test_damaged_library_is_built_again(
    damage: str, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seven()
    other = tmp_path / "other"
    shutil.copytree(cache, other)
    library = library_in(other)
    digest = library.with_name(".sha256")
    if damage == "truncated":
        library.write_bytes(library.read_bytes()[:5000])
    elif damage == "unloadable":
        library.write_bytes(b"not a library")
        digest.write_text(f"{hashlib.sha256(b'not a library').hexdigest()}  {library.name}\n")
    else:
        digest.unlink()
    monkeypatch.setenv("MEHVAR_CACHE", str(other))
    assert seven() == 7
    assert digest.read_text() == f"{hashlib.sha256(library.read_bytes()).hexdigest()}  {library.name}\n"


def test_a_cache_that_is_deleted_during_compilation(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a compiler, the first time that it compiles; in life by somebody at another terminal."""
    once = tmp_path / "once"
    program = tmp_path / "program"
    program.write_text(
        f'#!/bin/sh\ncase "$1" in --version) ;; *) [ -e {once} ] || {{ touch {once}; rm -rf {cache}; }} ;; esac\n'
        'exec cc "$@"\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("CC", str(program))
    assert seven() == 7
    assert once.exists()


def test_compile_error_shows_command_and_message(cache: Path) -> None:
    with pytest.raises(BuildError, match=r"(?s)-ffp-contract=off.*bad\.c.*nonsense"):
        build.load_library("bad", {"bad.c": "nonsense nonsense;\n"}, ["bad.c"])
    assert entries(cache) == []


@pytest.mark.parametrize("command", ["no-such-compiler-anywhere", "'unbalanced", f"{sys.executable} -c 1/0"])
def test_cc_that_does_not_start_is_refused(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", command)
    with pytest.raises(InputError, match=r"\$CC = .*(must start a C compiler|must be a command line)"):
        compiler.find_compiler()


def test_cc_that_writes_nothing_is_refused(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", f"{sys.executable} -c 'print(1)'")
    with pytest.raises(InputError, match=r"\$CC = .*wrote no file"):
        seven()
    assert entries(cache) == []


def test_cc_with_arguments_is_used(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cc = compiler.require_compiler()
    monkeypatch.setenv("CC", " ".join([*cc.command, "-DUNUSED=1"]))
    assert compiler.require_compiler().command[-1] == "-DUNUSED=1"
    assert seven() == 7


def test_arguments_in_cc_are_part_of_the_key(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    number = {"number.c": "int number(void) { return NUMBER; }\n"}
    cc = compiler.require_compiler()
    for n in (3, 4):
        monkeypatch.setenv("CC", " ".join([*cc.command, f"-DNUMBER={n}"]))
        assert build.load_library("number", number, ["number.c"]).number() == n


@pytest.mark.soak
def test_ziglang_is_the_last_resort(cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    cc = compiler.require_compiler()
    assert cc.command[1:] == ("-m", "ziglang", "cc")
    assert "-mcpu=baseline" in cc.flags
    assert seven() == 7


@pytest.mark.parametrize("command", [("/opt/zig/zig", "cc"), (sys.executable, "-m", "ziglang", "cc"), ("gcc",)])
def test_zig_is_told_to_behave_as_other_compilers(command: tuple[str, ...]) -> None:
    more = () if command == ("gcc",) else ("-mcpu=baseline", "-fno-sanitize=undefined")
    assert compiler.Compiler(command, "of this test", "$CC").flags == more


def test_without_any_compiler_functions_are_evaluated_by_numpy(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, folder: Path
) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    real = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "ziglang" else real(name))
    with pytest.warns(RuntimeWarning, match="no C compiler"):
        model = runtime.load(folder)
    assert model.rhs([0.1, 0.0], [0.0], model.parameters()).shape == (2,)
    with pytest.raises(InputError, match="no C compiler found: set"):
        runtime.load(folder, backend="c")


def test_cache_that_cannot_be_written(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("")
    monkeypatch.setenv("MEHVAR_CACHE", str(occupied / "cache"))
    with pytest.raises(InputError, match=r"\$MEHVAR_CACHE must be a folder that only you .*Not a directory"):
        seven()


def test_home_that_cannot_be_written(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("")
    monkeypatch.delenv("MEHVAR_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(occupied / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(cache_folder, "_OWN", [])  # a test before this one in its process may have made one
    assert seven() == 7
    (private,) = tmp_path.glob("mehvar-*")
    assert library_in(private)
    assert private.stat().st_mode & 0o077 == 0


@pytest.mark.soak
def test_two_processes_at_once(cache: Path, folder: Path) -> None:
    code = (
        "import sys\nfrom mehvar import runtime\n"
        f"m = runtime.load({str(folder)!r}, backend='c')\n"
        "sys.stdin.readline()\n"
        "print(runtime.simulate(m, 'pd').x[-1].tolist())"
    )
    command = [sys.executable, "-P", "-c", code]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": ROOT}
    processes = [subprocess.Popen(command, **pipes) for _ in range(2)]
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    answers = [process.communicate(timeout=120)[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0]
    assert answers[0] == answers[1] != ""
    assert all((path / ".sha256").is_file() for path in entries(cache))


def test_calls_release_the_interpreter_lock(pendulum: runtime.Model) -> None:
    x = np.zeros((3_000_000, 2))
    p = pendulum.parameters()
    pendulum.rhs(x[:1], [0.0], p)
    worker = threading.Thread(target=lambda: pendulum.rhs(x, [0.0], p))
    turns = 0
    worker.start()
    while worker.is_alive():
        turns += 1
    assert turns > 1000


def test_the_child_of_a_fork_does_not_wait_for_a_compilation_that_it_has_not(monkeypatch: pytest.MonkeyPatch) -> None:
    build.load_native()
    end = threading.Event()
    monkeypatch.setattr(build, "_BESIDE", [threading.Thread(target=end.wait)])
    build._BESIDE[0].start()
    with warnings.catch_warnings(action="ignore"):  # of threads and forks, which this is about
        child = os.fork()
    if child == 0:
        signal.alarm(60)
        build.load_native()
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    end.set()
    build.load_native()
    assert not build._BESIDE[0].is_alive()


@pytest.mark.parametrize(
    ("version", "copies"),
    [
        ("cc (Debian 12.2.0-14+deb12u1) 12.2.0", True),
        ("gcc-14 (Ubuntu 14.2.0-4ubuntu2) 14.2.0", True),
        ("gcc (Ubuntu 11.4.0-1ubuntu1~22.04) 11.4.0", False),
        ("Debian clang version 14.0.6", False),
    ],
)
def test_only_a_gcc_that_knows_the_flags_gets_them(version: str, copies: bool) -> None:
    assert compiler.Compiler(("cc",), version, "PATH").copies_registers is copies
