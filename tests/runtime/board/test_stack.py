# SPDX-License-Identifier: Apache-2.0
"""The bound on the stack holds for what was measured, and refuses what it cannot bound."""

from __future__ import annotations

import pytest

from mehvar.runtime.board.image.build import STACK_SIZE
from mehvar.runtime.board.image.instructions import UnboundedError
from mehvar.runtime.board.image.toolchains import board
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.board.stack import stack_bound
from tests.runtime.board.conftest import linked, load
from tests.tools import needs

NEEDS_GCC = needs("arm-none-eabi-gcc")
FAULT_AND_HANDLER = {"m3": 36 + 8, "m4f": 108 + 8}


@pytest.mark.parametrize("compiler", [pytest.param("gcc", marks=NEEDS_GCC), "zig"])
@pytest.mark.parametrize("name", ["stm32f4", "mps2-m3"])
@pytest.mark.share(4)
def test_what_is_used_is_within_the_bound(compiler, name):
    """And near it, less the fault that did not happen: a bound of everything would say nothing."""
    request = BoardRequest("mrac", "unicorn", name, compiler, samples=8, selftest=8, profiled=False, every=8)
    outcome = run_on_board(load("satellite"), request)
    assert outcome.bound is not None
    used, bound = outcome.stats["stack_used"], outcome.bound.bytes
    assert used <= bound <= used + FAULT_AND_HANDLER[board(name).cpu] + 64
    assert bound <= STACK_SIZE
    assert outcome.bound.chain[0][0] == "Reset_Handler"


SOURCES = {
    "depth": "int leaf(volatile int *v) { int w[50]; for (int i = 0; i < 50; i++) w[i] = *v; return w[*v]; }"
    "int (*volatile chosen)(volatile int *) = leaf;"
    "int start(volatile int *v) { return *v ? chosen(v) + 1 : 0; }",
    "recursion": "int start(volatile int *v) { *v -= 1; if (*v) start(v); return *v; }",
    "variable": "int start(volatile int *v) { char w[*v]; for (int i = 0; i < *v; i++) ((volatile char *)w)[i] = 1;"
    "return w[*v / 2]; }",
}


@pytest.mark.parametrize("compiler", [pytest.param("gcc", marks=NEEDS_GCC), "zig"])
def test_calls_through_pointers_recursion_and_frames_of_variable_size(tmp_path, compiler):
    result = {name: _bound_of(tmp_path, text, compiler) for name, text in SOURCES.items()}
    assert result["depth"].startswith("bytes >= 200: True")
    assert "recursive: start calls start" in result["recursion"]
    assert "start has a stack frame of variable size" in result["variable"]


def _bound_of(folder, text, compiler):
    start = "volatile int n; void Default_Handler(void) { } void Reset_Handler(void) { start(&n); for (;;) n++; }"
    try:
        bound = stack_bound(linked(folder, f"{text}\n{start}\n", compiler), "m4f")
    except UnboundedError as error:
        return str(error)
    return f"bytes >= 200: {bound.bytes - 108 >= 200 and 'leaf' in dict(bound.chain)}"
