# SPDX-License-Identifier: Apache-2.0
"""Output on a terminal: colours, and a pager for long texts; neither elsewhere."""

from __future__ import annotations

import contextlib
import io
import os
import pty
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mehvar.terminal import print_folded


def on_a_terminal(lines: int, *words: str, **variables: str) -> str:
    """Return the output of a command on a terminal of some lines."""
    outer, inner = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "LINES": str(lines), "COLUMNS": "80", **variables}
    process = subprocess.Popen(
        [sys.executable, "-m", "mehvar", *words], stdin=inner, stdout=inner, stderr=inner, env=environment
    )
    os.close(inner)
    pieces = []
    while True:
        try:
            piece = os.read(outer, 65536)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        pieces.append(piece)
    os.close(outer)
    assert process.wait() == 0
    return b"".join(pieces).decode()


@pytest.mark.parametrize(("lines", "paged"), [(20, True), (2000, False)])
def test_show_is_coloured_and_paged_where_it_is_long(lines, paged, tmp_path):
    pager = tmp_path / "pager"
    pager.write_text("#!/bin/sh\necho PAGED\ncat\n")
    pager.chmod(0o755)
    text = on_a_terminal(lines, "show", "triangle", PAGER=str(pager))
    assert ("PAGED" in text) is paged
    assert "\x1b[" in text
    assert "states x" in text


def test_elsewhere_it_is_plain(tmp_path):
    variables = {**os.environ, "PAGER": "false"}
    command = [sys.executable, "-m", "mehvar", "show", "triangle"]
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=True)
    assert "\x1b[" not in done.stdout


def test_every_bar_is_the_same():
    """One that knows its length, and one that does not."""
    code = "from mehvar.terminal import progress\nimport time\n"
    for block in (
        "with progress('some') as advance:\n advance(1, 2)\n time.sleep(0.3)",
        "with progress('some'):\n time.sleep(0.3)",
    ):
        outer, inner = pty.openpty()
        process = subprocess.Popen(
            [sys.executable, "-c", code + block], stderr=inner, env={**os.environ, "TERM": "xterm"}
        )
        assert process.wait() == 0
        text = os.read(outer, 65536).decode()
        os.close(inner), os.close(outer)
        assert "some" in text
        assert "━" in text
        assert "elapsed" in text
        assert ("50 %" in text) is ("advance" in block)


@given(
    names=st.integers(1, 9), rows=st.integers(0, 4), first=st.integers(1, 14), data=st.data(), width=st.integers(1, 46)
)
@settings(deadline=None, max_examples=30, derandomize=True)
@pytest.mark.soak
def test_a_folded_table_fits_a_page_and_loses_no_cell(names, rows, first, data, width):
    """The widest cell is a Sobol index with its total, each with an interval: 46 columns."""
    sizes = data.draw(st.lists(st.integers(1, width), min_size=names, max_size=names))
    heads = ["m" * first, *(f"{chr(97 + k)}" * size for k, size in enumerate(sizes))]
    body = [["n" * first, *(f"{chr(65 + k)}" * size for k, size in enumerate(sizes))] for _ in range(rows)]
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        print_folded(heads, body)
    lines = text.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    words = " ".join(lines).split()
    parts = sum(line.startswith("m") for line in lines)
    assert words.count("m" * first) == parts
    assert words.count("n" * first) == parts * rows
    for head, cells in zip(heads[1:], zip(*(row[1:] for row in body), strict=True), strict=False):
        assert words.count(head) == 1
        assert words.count(cells[0]) == rows
