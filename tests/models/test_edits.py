# SPDX-License-Identifier: Apache-2.0
"""Whatever is edited in a system, it is refused by name, or what is generated of it runs alike in C and in Python."""

import random
import re
from pathlib import Path

import pytest

from mehvar.codegen.code.files import printed, texts
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.functions.verify import check_counterparts, verify
from mehvar.codegen.manifest import manifest_of
from mehvar.manifest import FILE, manifest_text
from mehvar.models.check import check
from mehvar.models.system import ModelError, System
from mehvar.runtime import load
from tests.gates.test_sanitizers import watched
from tests.models import exercise_edits
from tests.models.edits import cart, edits, turner

_PLACED = re.compile(r"\S+\.py:\d+: .+", re.DOTALL)
"""File, line, and what is wrong there."""


@pytest.mark.parametrize("base", [cart, turner])
def test_the_systems_are_in_order(base):
    check(base())


@pytest.mark.parametrize("base", [cart, turner])
def test_a_few_edits(base, tmp_path):
    accepted = _campaign(base(), 60, 0, tmp_path)
    assert 5 < accepted < 55


@pytest.mark.soak
@pytest.mark.parametrize("base", [cart, turner])
def test_ten_thousand_edits(base, tmp_path):
    accepted = _campaign(base(), 5000, 1, tmp_path)
    assert accepted > 500


@pytest.mark.parametrize("base", [cart, turner])
def test_edited_systems_in_c_under_sanitizers(base, tmp_path):
    _sanitized(base(), 2, 2, tmp_path)


@pytest.mark.soak
@pytest.mark.parametrize("base", [cart, turner])
def test_three_hundred_edited_systems_in_c_under_sanitizers(base, tmp_path):
    _sanitized(base(), 150, 3, tmp_path)


def _campaign(base: System, n: int, seed: int, folder: Path) -> int:
    """Edit a system n times; return how many edits were accepted."""
    accepted = 0
    for k, edit in zip(range(n), edits(base, random.Random(seed)), strict=False):
        refusal = _refusal(edit.system)
        if refusal:
            assert _PLACED.match(refusal), (edit.path, edit.what, refusal)
            continue
        accepted += 1
        exercise_edits.run(load(_written(edit.system, folder / str(k)), "python"))
    return accepted


def _sanitized(base: System, n: int, seed: int, folder: Path) -> None:
    """Generate n systems that an edit made, and watch their C."""
    accepted = (edit.system for edit in edits(base, random.Random(seed)) if not _refusal(edit.system))
    folders = [_written(system, folder / f"{k}") for k, system in zip(range(n), accepted, strict=False)]
    done = watched(folder, "gcc", [exercise_edits.__file__, *map(str, folders)])
    assert done.returncode == 0, done.stderr[-4000:]
    assert done.stdout == f"{n} systems\n"


def _refusal(system: System) -> str:
    try:
        check(system)
    except ModelError as error:
        return str(error)
    return ""


def _written(system: System, folder: Path) -> Path:
    check_counterparts(system)
    verify(system)
    functions = printed(generate_functions(system))
    manifest = manifest_of(system, functions, {})
    folder.mkdir()
    for name, text in {**texts(manifest, functions), FILE: manifest_text(manifest)}.items():
        (folder / name).write_text(text)
    return folder
