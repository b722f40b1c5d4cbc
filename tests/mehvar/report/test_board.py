# SPDX-License-Identifier: Apache-2.0
from mehvar.report import board
from mehvar.runtime.model.model import load


def test_without_the_extra_the_board_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(board, "_NEEDED", ("no_such_package",))
    found = board.run_board(load("satellite"), "mrac")
    assert 'pip install "mehvar[board]"' in found.missing
    assert found.figure is None
