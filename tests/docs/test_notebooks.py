# SPDX-License-Identifier: Apache-2.0
"""The notebooks of the pages run from beginning to end, and show what they are for."""

import json
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
NOTEBOOKS = sorted(DOCS.rglob("*.ipynb"))
_SECONDS = 300
"""For a cell: the first run compiles, which takes ten seconds on an idle machine."""


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def codes(path):
    return [cell for cell in read(path)["cells"] if cell["cell_type"] == "code"]


def test_there_is_one():
    assert DOCS / "tutorials" / "first-run.ipynb" in NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_is_committed_without_results(path):
    """Results are megabytes, and nobody could tell whether they are those of this version."""
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in codes(path))


def test_it_opens_in_three_lines():
    first = codes(DOCS / "tutorials" / "first-run.ipynb")[0]
    lines = [line for line in first["source"] if line.strip()]
    assert len(lines) == 3
    assert lines[-1].endswith(".animate()")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
@pytest.mark.soak
def test_it_runs(path, tmp_path):
    nbclient = pytest.importorskip("nbclient", reason="notebooks are run by nbclient and ipykernel")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=_SECONDS, resources={"metadata": {"path": tmp_path}}).execute()
    kinds = [
        {kind for output in cell.outputs for kind in output.get("data", {})}
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]
    written = [
        output.text for cell in notebook.cells for output in cell.get("outputs", []) if output.get("name") == "stderr"
    ]
    assert not [text for text in written if "Error" in text]
    if path.stem == "first-run":
        animation, plot, table, region, model = kinds
        assert "text/html" in animation & table & model
        assert "text/latex" in model
        assert "image/png" in plot & region
