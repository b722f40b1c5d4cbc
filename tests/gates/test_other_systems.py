# SPDX-License-Identifier: Apache-2.0
"""All C, compiled by zig for Windows and macOS: flags, sources and libraries. Nothing of it is run."""

from __future__ import annotations

import functools
import importlib.util
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

import mehvar
from mehvar.fmu.sources import UNITS, c_sources
from mehvar.fmu.variables import subject
from mehvar.runtime.batch import kernel, sampling
from mehvar.runtime.compiling import library
from mehvar.runtime.compiling.compiler import environment
from mehvar.runtime.model import functions

MODELS = {"triangle": "path", "slosh": "lyapunov-v1", "satellite": "pd"}
SHORT = ("triangle", "satellite")
"""A law without a memory and laws with one; slosh has no other kind, and ten times the text."""
LEAST = ("triangle",)
TARGETS = {
    "x86_64-windows-gnu": b"\x64\x86",
    "x86_64-macos": b"\xcf\xfa\xed\xfe\x07\x00\x00\x01",
    "aarch64-macos": b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01",
}
"""Targets of zig, and how their objects begin: format and processor."""
_OURS_ALONE = ("-m", "-O", "-fsched", "-fschedule", "-fPIC", "-shared")
"""Starts of flags that are of this processor and this compiler, cost time only, or are left out for Windows."""

_STANDARD = (
    "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic "
    "stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype"
)
"""Headers of C11."""


@dataclass(frozen=True)
class Job:
    """A library that the runtime would compile."""

    name: str
    sources: Mapping[str, str]
    units: Sequence[str]
    flags: Sequence[str]


class RecordedError(Exception):
    """Instead of a library that would be called at once."""


@functools.cache
def every_job(*models: str) -> list[Job]:
    """Return every library: of single runs, of batches, of every file of the models, and of FMUs."""
    jobs: list[Job] = []

    def record(name: str, sources: Mapping[str, str], units: Sequence[str], flags: Sequence[str] = ()) -> None:
        jobs.append(Job(name, sources, units, flags))

    def record_and_leave(*arguments: object) -> None:
        record(*arguments)  # type: ignore[arg-type]
        raise RecordedError

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(library, "load_library", record)
        library._native.__wrapped__()
        patch.setattr(sampling, "load_library", record)
        sampling._library.__wrapped__()
        patch.setattr(functions, "load_library", record)
        patch.setattr(functions, "begin_native", lambda: None)  # it would be recorded again, by a thread
        for model in models:
            loaded = mehvar.load(model)
            backend = functions.CBackend(loaded.manifest)
            for file in sorted({function.file for function in loaded.manifest.functions.values()}):
                backend._build(file, "double")
    for model in models:
        for fmi in ("2.0", "3.0"):
            sources = c_sources(subject(mehvar.load(model), MODELS[model], None), fmi, "")
            record(f"{model} fmi {fmi}", sources, UNITS, ("-I.",))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "load_library", record_and_leave)
        for model in models:
            with pytest.raises(RecordedError):
                mehvar.batch(model, MODELS[model], 4, t_end=1.0)
    return jobs


@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason='no ziglang: pip install "mehvar[cc]"')
@pytest.mark.parametrize(
    ("target", "models"),
    [
        ("x86_64-windows-gnu", LEAST),
        # x86_64-macos has the processor of the first and the system of the second
        *(pytest.param(target, SHORT, marks=pytest.mark.soak) for target in TARGETS),
        *(pytest.param(target, ("slosh",), marks=pytest.mark.soak) for target in TARGETS),
    ],
)
def test_all_c_compiles_for_another_system(target: str, models: tuple[str, ...], tmp_path: Path) -> None:
    """To objects: for linking, zig would first compile the whole C library of Windows."""
    jobs = every_job(*models)
    assert len(jobs) > 8 * len(models)
    zig = (sys.executable, "-m", "ziglang", "cc", "-target", target, "-fno-sanitize=undefined", "-O0", "-c")
    for number, job in enumerate(jobs):
        folder = tmp_path / str(number)
        for name, text in job.sources.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
        flags = [flag for flag in (*library.FLAGS, *job.flags) if not flag.startswith(_OURS_ALONE)]
        for unit in job.units:
            command = [*zig, *flags, unit, "-o", "object"]
            done = subprocess.run(command, cwd=folder, env=environment(tmp_path), capture_output=True, text=True)
            assert done.returncode == 0, f"{job.name}, {unit}: {done.stderr}"
            assert (folder / "object").read_bytes().startswith(TARGETS[target]), job.name


def test_no_header_of_ours_has_a_name_of_the_standard() -> None:
    """A folder may come before the system's: Windows' stdlib.h includes limits.h, and would find ours."""
    standard = set(_STANDARD.split())
    ours = [path.stem for path in library.NATIVE.rglob("*.h")]
    assert len(ours) > 20
    assert not standard & {*ours}


def test_flags_and_endings_are_those_of_the_system(monkeypatch: pytest.MonkeyPatch) -> None:
    for system, ending, position in (("win32", ".dll", False), ("darwin", ".dylib", True), ("linux", ".so", True)):
        monkeypatch.setattr(sys, "platform", system)
        spec = importlib.util.spec_from_file_location(library.__name__, library.__file__)
        assert spec is not None
        assert spec.loader is not None
        other = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(other)
        assert (other.ENDING, "-fPIC" in other.FLAGS) == (ending, position)
