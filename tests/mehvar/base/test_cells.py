# SPDX-License-Identifier: Apache-2.0
"""Cells of a notebook, run by a kernel: progress appears and goes by itself, pictures are shown once."""

from __future__ import annotations

from typing import Any

import pytest

nbclient = pytest.importorskip("nbclient", reason="notebooks are run by nbclient and ipykernel")
nbformat = pytest.importorskip("nbformat")

CELLS = (
    """
import time
import mehvar

def slow(t, x):
    time.sleep(0.1)
    return [0.0, 0.0, 0.0]

run = mehvar.simulate("satellite", slow, period=0.5, t_end=10.0)
""",
    "run.mehvar.plot()",
    "figure = run.mehvar.plot()",
    "run.mehvar.animate()",
)


class Client(nbclient.NotebookClient):  # type: ignore[misc]
    """Keeps what each cell has displayed, also what it has replaced since."""

    shown: list[dict[str, str]]

    def process_message(self, message: Any, cell: Any, index: int) -> Any:
        if message["msg_type"] in ("display_data", "update_display_data", "execute_result"):
            self.shown.append({"cell": str(index), **message["content"]["data"]})
        return super().process_message(message, cell, index)


@pytest.mark.soak
def test_progress_and_pictures_show_themselves(tmp_path):
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in CELLS])
    client = Client(notebook, timeout=300, resources={"metadata": {"path": tmp_path}})
    client.shown = []
    client.execute()
    bars = [data for data in client.shown if data["cell"] == "0"]
    assert bars[0]["text/plain"].startswith("simulating, 1 s")
    assert any('max="10"></progress> simulating' in data.get("text/html", "") for data in bars)
    assert bars[-1]["text/plain"] == ""
    pictures = [[output.data for output in cell.outputs if "image/png" in output.data] for cell in notebook.cells[1:3]]
    assert list(map(len, pictures)) == [1, 1]
    (animation,) = notebook.cells[-1].outputs
    assert animation.data["text/html"].startswith("<iframe")
    assert animation.data["text/plain"].startswith("<mehvar animation, ")
