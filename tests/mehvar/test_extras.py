# SPDX-License-Identifier: Apache-2.0
"""Without the package of an extra, what needs it says which command installs it."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

import mehvar
from mehvar.__main__ import _how_to_install
from mehvar.base.errors import MehvarError
from mehvar.formats.attitude import kernel
from mehvar.pictures.style import require_matplotlib
from mehvar.runtime.batch.workers import connect
from mehvar.runtime.board.targets import SerialPort
from mehvar.runtime.run.formats import checked_format

ROOT = Path(__file__).parents[2]


def _plant() -> object:
    return mehvar.load("triangle").to_nlsys()


USES: dict[str, tuple[str, Callable[[], object], str]] = {
    "plot": ("matplotlib", require_matplotlib, 'pip install "mehvar[plot]"'),
    "parquet": ("pyarrow", lambda: checked_format("run.parquet"), 'pip install "mehvar[parquet]"'),
    "control": ("control", _plant, "pip install control"),
    "jax": ("jax.numpy", lambda: mehvar.load("triangle").to_jax(), "pip install jax"),
    "numba": ("numba", lambda: mehvar.load("triangle").to_numba(), "pip install numba"),
    "cluster": ("distributed", lambda: connect("tcp://127.0.0.1:1"), 'pip install "mehvar[cluster]"'),
    "spice": ("spiceypy", lambda: kernel(None), 'pip install "mehvar[spice]"'),
    "board": ("serial", lambda: SerialPort("nothing"), 'pip install "mehvar[board]"'),
}
"""By extra: the module that is missing, a use of it, and what the message says."""


@pytest.mark.parametrize("extra", USES)
def test_a_missing_extra_is_named_with_the_command_that_installs_it(extra, monkeypatch):
    module, use, command = USES[extra]
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MehvarError) as raised:
        use()
    assert command in str(raised.value)


def test_a_missing_compiler_is_named_with_two_ways_to_one(monkeypatch):
    """The extra `cc`."""
    from mehvar.runtime.compiling import compiler

    monkeypatch.setattr(compiler, "find_compiler", lambda: None)
    with pytest.raises(MehvarError, match=r"install gcc or clang, or run: pip install .mehvar\[cc\]"):
        compiler.require_compiler()


def test_every_extra_of_a_user_is_tried():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    ours = {"all", "dev", "docs", "mutants", "validation"}  # sums of others, and what makes this project
    assert {*project["optional-dependencies"]} - ours == {*USES, "cc"}


@pytest.mark.parametrize("module", ["capstone", "elftools.elf.elffile", "serial", "unicorn"])
def test_a_module_of_an_extra_that_is_imported_unguarded_is_named_with_the_extra(module):
    assert _how_to_install(module) == ': pip install "mehvar[board]"'
