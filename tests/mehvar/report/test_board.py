# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from mehvar.base.errors import MissingError
from mehvar.report.board.page import inputs_figure, metric_values
from mehvar.report.board.section import run_boards
from mehvar.reproduction.runs import Runs
from mehvar.runtime.model.model import load


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr("mehvar.reproduction.runs._MOST_SAMPLES", 40)


def test_every_law_of_a_model_is_shown_with_how_much_of_it_was_run(short):
    boards = run_boards(Runs(load("satellite", "c")))
    assert [law.law for law in boards.laws] == list(load("satellite").manifest.controllers)
    assert boards.same
    for law in boards.laws:
        text, _, table = law.blocks
        assert "40 samples of 0.5 s, 19.5 of the 800 s of scenario paper" in text.text
        assert ("states of the plant", "0 ulp of 400", "exact") in table.rows


def test_a_law_that_ends_early_or_that_differs_is_said(short, monkeypatch):
    runs = Runs(load("satellite", "c"))
    outcome = runs.board("pd")
    object.__setattr__(outcome, "u", type(outcome.u)(120, 3, 1e-9, 5))
    object.__setattr__(runs.board("mrac").board, "reason", "lost")
    boards = run_boards(runs)
    assert not boards.same
    assert [law.law for law in boards.laws if not law.same] == ["pd"]


@pytest.mark.soak
def test_a_figure_has_the_board_above_and_the_host_below(short):
    outcome = Runs(load("slosh", "c")).board("lyapunov-v1")
    axes = np.reshape(inputs_figure(outcome).axes, (4, 2))
    assert [ax.get_title(loc="left") for ax in axes[:2, 0]] == ["on the board", "on this machine, in float"]
    for column, places in enumerate(([0, 1, 2], [3, 4])):
        for row, run in ((0, outcome.board), (1, outcome.single)):
            drawn = [line.get_ydata() for line in axes[row, column].get_lines() if len(line.get_ydata()) == 40]
            assert np.array_equal(drawn, run.u_cmd[:, places].T)
        assert not axes[2, column].get_lines()[0].get_ydata().any()


def test_metrics_are_those_of_the_board_and_of_the_host(short):
    values = metric_values(Runs(load("satellite", "c")).board("pd"))
    assert {"max_torque_x", "max_torque_y"} <= set(values)
    assert all(math.isfinite(value) for numbers in values.values() for value in numbers.values())
    assert set(values["max_torque_x"]) == {"board", "host_double", "host_without_delay"}


def test_without_the_extra_the_report_says_how_to_get_it(monkeypatch):
    def missing(*given, **more):
        raise MissingError('a law on a board needs unicorn: pip install "mehvar[board]"')

    runs = Runs(load("satellite", "c"))
    monkeypatch.setattr(runs, "board", missing)
    boards = run_boards(runs)
    assert boards.laws == ()
    assert 'Not run: a law on a board needs unicorn: pip install "mehvar[board]".' in boards.missing
