# SPDX-License-Identifier: Apache-2.0
import base64

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from mehvar.papers import load_paper, paper_models
from mehvar.plots import BLUE, GREY, VERMILLION, label, new_figure, style
from mehvar.report import board
from mehvar.report.batches import run_study
from mehvar.report.charts import BAND_HIGH, BAND_LOW, chart, text
from mehvar.report.page import typeset
from mehvar.report.series import encode, thin, track
from runtime.model import load
from runtime.statistics import interval


def floats(encoded):
    return np.frombuffer(base64.b64decode(encoded), "<f4")


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(np.float64, st.tuples(st.integers(2, 80), st.integers(1, 3)), elements=st.floats(-1e3, 1e3)))
def test_what_is_left_out_lies_on_the_lines_between_what_is_kept(columns):
    t = np.cumsum(np.linspace(1.0, 2.0, len(columns)))
    kept = thin(t, columns, 0.01)
    assert {0, len(t) - 1} <= set(kept.tolist())
    for column in columns.T:
        off = np.abs(np.interp(t, t[kept], column[kept]) - column)
        assert off.max() <= 0.01 * np.ptp(column) + 1e-9


def test_a_straight_line_needs_two_samples_and_a_gap_is_kept():
    t = np.arange(9.0)
    assert thin(t, 3 * t).tolist() == [0, 8]
    gap = np.where(t == 4, np.nan, t)
    assert {3, 4, 5} <= set(thin(t, gap).tolist())


def test_a_track_holds_every_column_at_the_same_instants():
    t = np.linspace(0, 1, 500)
    found = track(t, {"a": np.sin(9 * t), "b": t})
    kept = floats(found["t"])
    assert 10 < len(kept) < 200
    assert np.allclose(np.sin(9 * kept), floats(found["columns"]["a"]), atol=1e-6)
    assert np.allclose(kept, floats(found["columns"]["b"]))


def test_a_chart_holds_the_lines_of_the_figure():
    t = np.linspace(0, 4, 50)
    with style():
        figure = new_figure(4, 4)
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.plot(t, np.sin(t), color=BLUE, label=r"$\varphi_1$")
        upper.step(t[::5], t[::5], where="post", color=VERMILLION, ls="--", label="held")
        upper.axhline(0.5, color=GREY)
        upper.axvline(2.0, color=GREY, ls=":")
        upper.set_ylabel(label(r"$\tilde\varphi$", "angle", "rad"))
        lower.plot(t, t - 1, color=BLUE, gid=BAND_LOW)
        lower.plot(t, t + 1, color=BLUE, gid=BAND_HIGH)
        lower.set_xlabel(label("$t$", "time", "s"))
        found = chart(figure)
    first, second = found["panels"]
    assert (found["columns"], found["whole"]) == (1, True)
    assert first["label"] == "angle φ̃ [rad]"
    sine, held = first["lines"]
    assert (sine["name"], sine["color"], sine["dash"], sine["step"]) == ("φ<sub>1</sub>", "blue", [], False)
    assert (held["name"], held["color"], bool(held["dash"]), held["step"]) == ("held", "vermillion", True, True)
    x = floats(first["x"])
    assert np.allclose(floats(sine["y"]), np.sin(x), atol=1e-6)
    known = np.isfinite(floats(held["y"]))
    assert np.allclose(floats(held["y"])[known], t[::5])
    assert [level["at"] for level in first["levels"]] == [0.5]
    assert [mark["at"] for mark in first["marks"]] == [2.0]
    assert [line["band"] for line in second["lines"]] == ["low", "high"]


def test_a_figure_without_time_has_no_chart():
    with style():
        figure = new_figure(2, 2)
        figure.subplots().plot([0, 1], [0, 1])
        assert chart(figure) is None


@pytest.mark.parametrize(
    ("label_", "shown"),
    [
        ("$v_x$ [m/s]", "v<sub>x</sub> [m/s]"),
        (r"$f_\perp/F$", "f<sub>⊥</sub>/F"),
        ("$10^5$ < a", "10<sup>5</sup> &lt; a"),
    ],
)
def test_mathematics_of_labels_becomes_html(label_, shown):
    assert text(label_) == shown


@pytest.mark.parametrize(
    ("plain", "pretty"),
    [
        ("2.7e-10 rad", "2.7×10⁻¹⁰ rad"),
        ("from -1 to -0.5", "from −1 to −0.5"),
        ("paper-b, 5-6, l-1, torque_lost", "paper-b, 5-6, l-1, torque_lost"),
        ("R + 9e-11", "R + 9×10⁻¹¹"),
        ("phi_1 < v_y, delta_2", "φ<sub>1</sub> &lt; v<sub>y</sub>, δ<sub>2</sub>"),
    ],
)
def test_texts_are_set_with_minus_signs_powers_and_subscripts(plain, pretty):
    assert str(typeset(plain)) == pretty


def test_a_study_counts_successes_and_draws_its_bands_the_same_each_time(monkeypatch):
    from dataclasses import replace

    study, steps = replace(load_paper("triangle").STUDY, runs=64), []
    first, second = (run_study(load("triangle"), study, lambda done, what: steps.append(done)) for _ in range(2))
    assert steps[-1] == 1.0
    for (title, found), (_, again) in zip(first.laws, second.laws, strict=True):
        assert title in study.laws.values()
        assert (found.stored, found.successes) == (64, again.successes)
        assert (found.low, found.high) == interval(found.successes, 64)
    assert {row.name for _, row in first.metrics} == {"T_theta", "T_rho"}
    assert chart(first.figure) == chart(second.figure)
    for panel in chart(first.figure)["panels"]:
        low, high, middle = (floats(line["y"]) for line in panel["lines"])
        assert (low <= middle).all()
        assert (middle <= high).all()


@pytest.mark.parametrize("name", paper_models())
def test_every_figure_names_claims_that_exist_only(name):
    source = [number for figure in load_paper(name).figures() for number in figure.claims]
    assert source
    assert all(number.isdigit() or number[0] in "RT" for number in source)


def test_without_the_extra_the_board_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(board, "_NEEDED", ("no_such_package",))
    found = board.run_board(load("satellite"), "mrac")
    assert 'pip install "mehvar[board]"' in found.missing
    assert found.figure is None


def test_numbers_are_encoded_as_32_bit_floats():
    assert floats(encode([1.0, -2.5])).tolist() == [1.0, -2.5]
