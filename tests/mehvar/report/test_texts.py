# SPDX-License-Identifier: Apache-2.0
"""Anybody's text is shown as it is: dollars that are no mathematics, and nothing that controls who shows it."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest
import xarray as xr

import mehvar
from mehvar.base.errors import printable
from mehvar.base.schema import SchemaError, parse
from mehvar.pictures.files import encoded
from mehvar.pictures.style import new_figure
from mehvar.report.accessor import Results
from mehvar.report.charts import text
from mehvar.report.page import page_text
from tests.fuzz.inputs import PENDULUM

TEXTS = [
    r"costs $\frac$ much", r"$\nonsense{$", "5 $ and 6 $", r"$x_$", r"\$", "$$", "a\x1b[31mred\x07",
    "nul\x00", "bell\x9b$a^$", "half a pair \ud800", "<script>&amp;</script>",
]  # fmt: skip


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return mehvar.simulate(PENDULUM, "pd", t_end=0.2, dt_out=0.1)


@pytest.mark.parametrize("words", TEXTS)
@pytest.mark.share(12)
def test_a_page_about_a_run_shows_any_title(run: xr.Dataset, words: str) -> None:
    named = run.copy()
    named.attrs["title"] = named["angle"].attrs["long_name"] = words
    shown = page_text(Results(named).page())
    assert printable(shown) == shown
    assert "<script>&amp;" not in shown


@pytest.mark.parametrize("words", TEXTS)
@pytest.mark.share(3)
def test_a_picture_shows_any_text(words: str) -> None:
    figure = new_figure(3.0, 2.0)
    ax = figure.add_subplot(title=words, xlabel=words, ylabel=words)
    ax.plot([0, 1], label=words)
    ax.legend()
    figure.suptitle(words)
    svg = encoded(figure, ".svg").decode()
    ElementTree.fromstring(svg)
    assert printable(svg) == svg
    assert encoded(figure, ".png")


def test_mathematics_of_ours_stay() -> None:
    figure = new_figure(3.0, 2.0)
    title = figure.suptitle("time $t_0$ and $\\tilde\\theta$")
    encoded(figure, ".png")
    assert title.get_text() == "time $t_0$ and $\\tilde\\theta$"
    assert text("$\\theta_0$") == "θ<sub>0</sub>"
    assert text("$\\nonsense$ <") == "$\\nonsense$ &lt;"


def test_a_schema_has_no_control_characters() -> None:
    assert parse(r'{"a": ["\\u001b", "\u00e9"]}') == {"a": [r"\u001b", "é"]}
    with pytest.raises(SchemaError, match=r"^a\[1\].b = .*must be a text without control characters"):
        parse(r'{"a": [1, {"b": "a\u001bb"}]}')
