# SPDX-License-Identifier: Apache-2.0
import builtins

import pytest

from mehvar.base.errors import MissingError
from mehvar.report.papers import content
from mehvar.reproduction.claims import ClaimText, ReadingText, below, decide
from mehvar.reproduction.paper import PaperFigure
from mehvar.reproduction.runs import Runs
from mehvar.runtime.board.image import toolchains
from mehvar.runtime.model.model import load


@pytest.fixture
def runs():
    return Runs(load("satellite", backend="c"))


def test_a_run_on_the_board_is_made_once_and_has_the_hosts_bits(runs):
    outcome = runs.board("pd", "paper", samples=40)
    assert runs.board("pd", "paper", samples=40) is outcome
    assert (outcome.max_ulp, outcome.x.ulp, outcome.board.t[-1]) == (0, 0, 19.5)
    assert outcome.u.compared == 3 * 40
    assert outcome.board.u_cmd.tobytes() == outcome.single.u_cmd.tobytes()


def test_settings_reach_the_board(runs):
    undelayed = runs.board("pd", "paper", samples=20, delay=0)
    assert undelayed.board.options["delay"] == 0
    damped = runs.board("pd", "paper", samples=20, Kd_x=5.0)
    assert damped.board.parameters.values["Kd_x"] == 5.0


def test_a_whole_scenario_is_run_unless_it_is_too_long(monkeypatch):
    monkeypatch.setattr("mehvar.reproduction.runs._MOST_SAMPLES", 30)
    assert len(Runs(load("triangle", backend="c")).board("path").board.t) == 30


def test_a_figure_from_a_board_that_cannot_be_says_why(runs, monkeypatch):
    monkeypatch.setattr(toolchains, "_gcc", lambda: None)
    monkeypatch.setattr(toolchains, "_zig", lambda: None)
    with pytest.raises(MissingError, match=r"no compiler for ARM: pip install"):
        runs.board("pd")
    figure = PaperFigure(1, "On the board", "", lambda runs: runs.board("pd").board)
    picture = content._drawn("model", figure, [], runs, 1)
    assert picture.png.startswith(b"\x89PNG")
    assert picture.chart is None


def test_the_emulator_and_the_compiler_are_named_when_missing(runs, monkeypatch):
    original = builtins.__import__

    def without(name, *arguments, **more):
        if "unicorn" in name or name.endswith("board.run"):
            raise ModuleNotFoundError("no unicorn", name="unicorn")
        return original(name, *arguments, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingError, match=r"unicorn: pip install"):
        runs.board("pd")
    with pytest.raises(MissingError, match="C compiler"):
        Runs(load("satellite", backend="python")).board("pd")


def test_a_reading_whose_run_is_lost_shows_no_numbers():
    """The path law's commands held for a second end at collinear masses at 7.5 s."""

    def turns(**settings):
        def checks(runs, expected):
            return [below("sign changes", 100, runs.under(t_end=20.0).metrics("path", "paper", **settings)["flips"])]

        return checks

    text = ClaimText("1", "t", reading=(ReadingText("held", "h"), ReadingText("continuous", "c")))
    readings = {"1": {"held": turns(hold=1.0), "continuous": turns()}}
    (claim,) = decide([text], {"1": turns()}, Runs(load("triangle", backend="c")), readings)
    held, continuous = claim.readings
    assert not held.holds
    assert [check.what for check in held.checks] == ["the runs reach their ends", "sign changes"]
    assert "collinear" in held.checks[0].measured
    assert held.checks[1].measured == "not measured"
    assert continuous.holds
    assert [check.what for check in continuous.checks] == ["sign changes"]
