# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from mehvar.pictures.style import BLUE, GREY, VERMILLION, label, new_figure, style
from mehvar.report.charts import BAND_HIGH, BAND_LOW, chart, text
from tests.mehvar.report.test_series import floats


def test_a_chart_holds_the_lines_of_the_figure():
    t = np.linspace(0, 4, 50)
    with style():
        figure = new_figure(4, 4)
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.plot(t, np.sin(t), color=BLUE, label=r"$\varphi_1$")
        upper.step(t[::5], t[::5], where="post", color=VERMILLION, ls="--", label="held")
        upper.axhline(0.5, color=GREY, label="target")
        upper.axvline(2.0, color=GREY, ls=":")
        upper.set_ylabel(label(r"$\tilde\varphi$", "angle", "rad"))
        lower.plot(t, t - 1, color=BLUE, gid=BAND_LOW)
        lower.plot(t, t + 1, color=BLUE, gid=BAND_HIGH)
        lower.set_xlabel(label("$t$", "time", "s"))
        found = chart(figure)
    first, second = found["panels"]
    assert (found["columns"], found["rest"]) == (1, [])
    assert first["label"] == "angle φ̃ [rad]"
    sine, held = first["lines"]
    assert (sine["name"], sine["color"], sine["dash"], sine["step"]) == ("φ<sub>1</sub>", "blue", [], False)
    assert (held["name"], held["color"], bool(held["dash"]), held["step"]) == ("held", "vermillion", True, True)
    x = floats(first["x"])
    assert np.allclose(floats(sine["y"]), np.sin(x), atol=1e-6)
    known = np.isfinite(floats(held["y"]))
    assert np.allclose(floats(held["y"])[known], t[::5])
    assert [(level["at"], level["name"]) for level in first["levels"]] == [(0.5, "target")]
    assert [(mark["at"], mark["name"]) for mark in first["marks"]] == [(2.0, "")]
    assert [line["band"] for line in second["lines"]] == ["low", "high"]


def test_a_panel_that_is_not_over_time_is_a_part_of_the_picture():
    with style():
        figure = new_figure(8, 4)
        over, plane = figure.subplots(1, 2)
        over.plot([0, 1], [0, 1])
        over.set_xlabel(label("$t$", "time", "s"))
        plane.plot([0, 1], [0, 1])
        figure.draw_without_rendering()
        found = chart(figure)
    assert len(found["panels"]) == 1
    ((left, top, width, height),) = found["rest"]
    assert 0.4 < left < 0.55
    assert 0.9 < left + width <= 1
    assert 0 <= top < 0.1
    assert 0.9 < top + height <= 1


def test_panels_below_each_other_have_the_title_of_their_column():
    with style():
        figure = new_figure(8, 4)
        axes = figure.subplots(2, 2)
        for ax in axes.flat:
            ax.plot([0, 1], [0, 1])
            ax.set_xlabel(label("$t$", "time", "s"))
        axes[0, 0].set_title("left")
        axes[0, 1].set_title("right")
        found = chart(figure)
    assert [(panel["title"], panel["column"]) for panel in found["panels"]] == [
        ("left", "left"), ("right", "right"), ("", "left"), ("", "right"),
    ]  # fmt: skip


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
