# SPDX-License-Identifier: Apache-2.0
import math
from dataclasses import replace

import numpy as np
import pytest

from mehvar.codegen.generate import installed_tree
from mehvar.pictures.style import style
from mehvar.reproduction.claims import ClaimVerdict
from mehvar.reproduction.deviations import deviations, table_claims
from mehvar.reproduction.ledgers import paper_ledgers
from mehvar.reproduction.paper import load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.reproduction.statements import StatementVerdict, statement_verdicts
from mehvar.runtime.model.catalogue import known_models
from mehvar.runtime.model.model import load
from mehvar.runtime.run.metrics import Deviation, metrics
from papers.triangle import shapes as shapes
from papers.triangle import surfaces as surfaces
from papers.triangle.chart import law_direction, target_shape
from tests.derived import REPRODUCED
from tests.mehvar.images import numbered_and_told, unlabelled
from tests.papers.shared import missing, paper_claims, paper_runs
from tests.reference import cartesian_triangle as cartesian

NOTED = {"1", "2", "3", "7", "8", "12"}


@pytest.fixture(scope="module")
def runs():
    return paper_runs("triangle")


@pytest.fixture(scope="module")
def claims():
    return {claim.number: claim for claim in paper_claims("triangle")}


@pytest.fixture(scope="module")
def numbers(runs):
    return deviations(runs)


def test_every_paper_belongs_to_a_model():
    assert "triangle" in REPRODUCED
    assert set(REPRODUCED) <= set(known_models())
    paper = load_reproduction("triangle")
    assert "Makarem" in paper.captions.citation
    assert paper.captions.readings


def test_claims_of_the_triangle_hold_and_the_notes_are_where_they_are_due(claims):
    assert list(claims) == [str(number) for number in range(1, 14)]
    found = {number: claim.verdict for number, claim in claims.items()}
    assert found == {number: ClaimVerdict.PART if number in NOTED else ClaimVerdict.HOLDS for number in claims}
    assert all(bool(claim.note) == (number in NOTED) for number, claim in claims.items())
    assert all(claim.checks and claim.expected and claim.measured for claim in claims.values())


def test_the_readings_in_use_are_those_under_which_the_comparison_holds(claims):
    """The paper compares the laws by times that agree and by calmer inputs: no other reading tried has both."""
    holding = {number: {r.name for r in claims[number].readings if r.holds} for number in ("2", "3", "7")}
    assert holding["2"] == set()
    assert holding["3"] == {r.name for r in claims["3"].readings if r.name != "gain as printed"}
    assert len(holding["3"]) == 5
    assert holding["7"] == {"only sgn s is smoothed"}


def test_every_sentence_table_and_figure_has_an_entry_with_a_verdict(claims, runs):
    paper = load_reproduction("triangle")
    (ledger,) = paper_ledgers(installed_tree(), "triangle")
    verdicts = {entry["number"]: entry["verdict"] for entry in ledger["entries"]}
    assert list(missing(paper.statements, claims, verdicts, [figure.number for figure in paper.figures])) == []
    everything = [*claims.values(), *table_claims(runs.model.manifest, deviations(runs))]
    statements = statement_verdicts(paper.statements, everything, verdicts)
    open_ones = {statement.text.text for statement in statements if statement.verdict is StatementVerdict.OPEN}
    refuted = {statement.text.text for statement in statements if statement.verdict is StatementVerdict.REFUTED}
    assert not open_ones | refuted
    for section, least in (("abstract", 7), ("conclusions", 14), ("figure", 11), ("table", 1)):
        assert sum(statement.text.place.startswith(section) for statement in statements) >= least


class Altered(Runs):
    """Runs with one parameter changed, unless the claim sets it itself."""

    def __init__(self, model, **changes):
        super().__init__(model)
        self.changes = changes

    def __call__(self, controller, scenario, initial=None, **settings):
        read = {name: v for name, v in self.changes.items() if name.removesuffix("_0") not in (initial or {})}
        return super().__call__(controller, scenario, initial, **{**read, **settings})


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        ({"mu_rate_max": 0.1}, {"3", "4"}),
        ({"theta_0": 1.5}, {"2", "3", "4", "6"}),
        ({"disturbance": 0.01}, {"1", "2", "9"}),
    ],
)
@pytest.mark.share(3)
def test_a_changed_model_breaks_claims(change, broken):
    altered = Altered(load("triangle"), **change)
    failed = {c.number for c in load_reproduction("triangle").claims(altered) if c.verdict is ClaimVerdict.FAILS}
    assert broken <= failed


def test_every_expected_number_of_the_scenarios_is_reproduced(runs, numbers):
    manifest = runs.model.manifest
    asked = sum(len(metrics) for s in manifest.scenarios.values() for metrics in s.expect.values())
    assert len(numbers) == asked == 45
    assert all(c.holds for c in numbers)
    rows = table_claims(manifest, numbers)
    assert [claim.number for claim in rows] == ["T1", "T2", "T3", "T4", "T5"]
    assert {claim.verdict for claim in rows} == {ClaimVerdict.HOLDS}


def test_a_number_off_by_more_than_allowed_is_named(runs, numbers):
    wrong = [replace(c, measured=1.03 * c.measured) if c.metric.name == "travel" else c for c in numbers]
    rows = table_claims(runs.model.manifest, wrong)
    assert {claim.verdict for claim in rows} == {ClaimVerdict.FAILS}
    assert rows[0].note == "travel: 2.781 instead of 2.7"
    assert "8 within" in rows[0].measured


@pytest.mark.parametrize(
    ("metric", "expected", "measured", "holds"),
    [
        ("T_rho", 20.0, 20.19, True),
        ("T_rho", 20.0, 20.21, False),
        ("T_rho", math.inf, math.inf, True),
        ("T_rho", math.inf, 34.0, False),
        ("T_rho", 34.0, math.inf, False),
        ("travel", 2.0, 1.961, True),
        ("travel", 2.0, 1.959, False),
        ("travel", 2.0, math.nan, False),
        ("flips", 20.0, 21.0, True),
        ("flips", 20.0, 18.0, False),
    ],
)
def test_comparison_allows_one_percent_of_times_two_of_amplitudes_and_one_count(
    runs, metric, expected, measured, holds
):
    assert Deviation("paper", "path", runs.model.manifest.metrics[metric], expected, measured).holds is holds


def test_a_run_is_integrated_once(runs):
    first = runs("path", "paper")
    number, seconds = len(runs), runs.run_seconds
    assert runs("path", "paper") is first
    assert (len(runs), runs.run_seconds) == (number, seconds)
    assert runs("path", "paper", disturbance=0.001) is not first
    assert runs.metrics("path", "paper") == metrics(first, runs.model.manifest)


@pytest.mark.parametrize("theta", [0.0, 2.0, -3.0])
@pytest.mark.parametrize("lengths", [(0.2, 0.2, 0.3), (0.3, 0.4, 0.5), (0.5, 0.28, 0.25)])
def test_drawn_triangles_have_their_rods_and_their_attitude(lengths, theta):
    expected = cartesian.place(*lengths, theta=theta, masses=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(shapes.vertices(lengths, theta), expected @ [1, 1j], atol=1e-12)


def test_figures_are_numbered_and_told(runs):
    figures = load_reproduction("triangle").figures
    assert numbered_and_told(figures, range(1, 12))


@pytest.mark.parametrize("number", range(2, 12))
def test_axes_of_every_figure_have_labels_with_units(runs, number):
    with style():
        figure = load_reproduction("triangle").figures[number - 1].draw(runs)
    assert len(figure.axes) == {9: 4, 10: 4, 11: 5}.get(number, 1)
    assert unlabelled(figure) == []


def test_figure_1_shows_masses_rods_and_attitude(runs):
    with style():
        ax = load_reproduction("triangle").figures[0].draw(runs).axes[0]
    assert {"1", "2", "3", "$l_1$", "$l_2$", "$l_3$", "θ"} <= {text.get_text() for text in ax.texts}


def test_figure_7_shows_solutions_of_equation_42(runs):
    ratio = np.geomspace(1e-2, 1e3, 50)
    xi = surfaces.law_xi(runs, ratio)
    np.testing.assert_allclose((np.pi - xi - np.sin(xi)) / (1 + np.cos(xi)), ratio, rtol=1e-8)


def test_figure_8_shows_an_arc_that_touches_the_circle_and_one_that_encloses_the_attitude(runs):
    with style():
        ax = load_reproduction("triangle").figures[7].draw(runs).axes[0]
    lines = {line.get_label(): line.get_xdata() + 1j * line.get_ydata() for line in ax.lines}
    touching = next(arc for name, arc in lines.items() if "touches" in name)
    leaving = next(arc for name, arc in lines.items() if "leaves" in name)
    assert abs(touching).max() == pytest.approx(0.65, abs=1e-4)
    assert abs(leaving).max() == pytest.approx(0.933, abs=1e-3)
    series, target = runs("path", "paper").variables(), target_shape(runs.model, runs("path", "paper"))
    for arc in (touching, leaving):
        assert arc[0] == pytest.approx(series["rho"][0] * np.exp(1j * series["phi"][0]))
        assert arc[-1] == pytest.approx(target)
    w = target - leaving
    turned = np.sum((np.conj(w[:-1]) * w[1:]).imag)
    assert -turned == pytest.approx(series["theta_shifted"][0], rel=1e-3)


@pytest.mark.parametrize("theta", [0.02, 0.5, -1.5])
def test_figures_5_and_6_show_where_the_sliding_law_changes_sides(runs, theta):
    run = runs("sliding", "paper-b", s_min=1e-9, theta_min=1e-9)
    target, eta = target_shape(runs.model, run), run.parameters.values["eta_rho"]
    circle = abs(target) + 0.65 * np.exp(1j * np.linspace(0, 6, 13))
    surface = surfaces.surface_scale(run, theta) * circle
    inside, outside = (
        (law_direction(runs.model, run, side * surface, theta, target) * side * abs(surface)).real
        for side in (1 - 1e-6, 1 + 1e-6)
    )
    np.testing.assert_allclose(inside - outside, 2 * eta, rtol=1e-3)


def test_figures_9_and_11_show_the_runs(runs):
    with style():
        calm, disturbed = (load_reproduction("triangle").figures[n - 1].draw(runs) for n in (9, 11))
    run = runs("sliding", "paper").variables()
    drawn = [line.get_ydata() for ax in calm.axes for line in ax.lines]
    for name in ("l1", "l2", "l3", "u_l1", "u_l2", "u_l3", "theta"):
        assert any(np.array_equal(series, run[name]) for series in drawn)
    titles = [ax.get_title(loc="left") for ax in disturbed.axes]
    assert [title[:3] for title in titles] == ["(a)", "(b)", "(c)", "(d)", "(e)"]
    moved = runs("path", "paper", disturbance=0.001).variables()
    assert np.array_equal(disturbed.axes[0].lines[0].get_ydata(), moved["l1"])
