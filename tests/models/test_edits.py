# SPDX-License-Identifier: Apache-2.0
"""Whatever is edited in a system, it is refused by name, or what is generated of it runs alike in C and in Python."""

import contextlib
import random
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

from mehvar.codegen.code.files import printed, texts
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.functions.verify import check_counterparts, verify
from mehvar.codegen.manifest import manifest_of
from mehvar.errors import MehvarError
from mehvar.manifest import manifest_text
from mehvar.models.check import check
from mehvar.models.system import ModelError, System
from mehvar.runtime import load, simulate
from mehvar.runtime.compiling import library
from mehvar.runtime.model.model import Model
from tests.models.edits import cart, edits, turner

SANITIZED_EVERY = 100
"""Accepted edits of which one is compiled: a compilation takes a second, and one text in a hundred shows a class."""
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


def _campaign(base: System, n: int, seed: int, folder: Path) -> int:
    """Edit a system n times; return how many edits were accepted."""
    accepted = 0
    for k, edit in zip(range(n), edits(base, random.Random(seed)), strict=False):
        refusal = _refusal(edit.system)
        if refusal:
            assert _PLACED.match(refusal), (edit.path, edit.what, refusal)
            continue
        accepted += 1
        _run(edit.system, folder / str(k), compiled=accepted % SANITIZED_EVERY == 1)
    return accepted


def _refusal(system: System) -> str:
    try:
        check(system)
    except ModelError as error:
        return str(error)
    return ""


def _run(system: System, folder: Path, compiled: bool) -> None:
    check_counterparts(system)
    verify(system)
    functions = printed(generate_functions(system))
    manifest = manifest_of(system, functions, {})
    folder.mkdir()
    for name, text in {**texts(manifest, functions), "manifest.json": manifest_text(manifest)}.items():
        (folder / name).write_text(text)
    slow = load(folder, "python")
    values = _values(slow)
    if compiled:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(library, "FLAGS", (*library.FLAGS, "-fsanitize=undefined", "-fno-sanitize-recover=all"))
            for name, value in _values(load(folder, "c")).items():
                for a, b in zip(value, values[name], strict=True):
                    np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12, err_msg=name)
    for law in manifest.controllers if manifest.scenarios else ():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with contextlib.suppress(MehvarError):  # a run may fail, and says so
                simulate(slow, law, t_end=0.2)


def _values(model: Model) -> dict[str, tuple[np.ndarray, ...]]:
    generator = np.random.default_rng(0)
    values = {}
    for name, function in model.manifest.functions.items():
        result = model.functions[name](*(generator.uniform(0.1, 1.0, a.shape) for a in function.arguments))
        values[name] = result if isinstance(result, tuple) else (result,)
    return values
