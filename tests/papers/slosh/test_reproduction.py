# SPDX-License-Identifier: Apache-2.0
import dataclasses

import numpy as np
import pytest

from mehvar.base.errors import MehvarError
from mehvar.pictures.files import save
from mehvar.pictures.style import style
from mehvar.reproduction.claims import ClaimVerdict
from mehvar.reproduction.paper import load_reproduction, run_picture
from mehvar.reproduction.runs import Runs
from mehvar.runtime.model.model import load
from mehvar.runtime.run.results import to_dataset
from mehvar.runtime.run.simulate import simulate
from papers.slosh import readings
from papers.slosh import rows as table
from papers.slosh.claims import turns
from papers.slosh.positivity import positive
from tests.mehvar.images import numbered_and_told, unlabelled
from tests.papers.shared import paper_claims, paper_runs

pytestmark = pytest.mark.soak  # `make run` decides the claims too
NOTED = {"6", "7", "9", "10", "12", "R1"}
READ_OTHERWISE = {"8"}
NOT_AS_PRINTED = {"11", "13", "14"}
PANELS = {1: 3, 2: 1, 3: 4, 4: 4, 5: 6, 6: 4, 7: 4, 8: 4, 9: 1, 10: 2, 11: 2}
FIRST, SECOND = table.LAWS


@pytest.fixture(scope="module")
def runs():
    return paper_runs("slosh")


@pytest.fixture(scope="module")
def claims():
    return {claim.number: claim for claim in paper_claims("slosh")}


def test_paper_says_whose_it_is_and_what_was_read_into_it():
    paper = load_reproduction("slosh")
    assert "Navabi" in paper.captions.citation
    readings = " ".join(paper.captions.readings)
    manifest = load("slosh").manifest
    every = [*manifest.parameters, *(q for law in manifest.controllers.values() for q in law.parameters)]
    assumed = {q.name for q in every if q.source.startswith("assumption: ")}
    assert len(assumed) > 15
    for name in assumed - {"J_x", "J_y", "J_z", "w2", "w3", "w4", "l2"}:
        assert name in readings


def test_claims_hold_but_for_those_that_are_known_not_to(claims):
    assert list(claims) == [*map(str, range(1, 15)), *(f"R{k}" for k in range(1, 7))]
    special = dict.fromkeys(NOTED, ClaimVerdict.PART) | dict.fromkeys(READ_OTHERWISE, ClaimVerdict.READING)
    special |= dict.fromkeys(NOT_AS_PRINTED, ClaimVerdict.PRINTED)
    assert {n: c.verdict for n, c in claims.items()} == {n: special.get(n, ClaimVerdict.HOLDS) for n in claims}
    assert {n for n, c in claims.items() if c.note} == NOTED | READ_OTHERWISE | NOT_AS_PRINTED


def test_the_order_of_the_azimuths_is_that_of_the_paper_only_with_another_inertia_and_another_damping(claims):
    assert [check.holds for check in claims["8"].checks] == [False, True, False, False, False]
    held = {reading.name for reading in claims["8"].readings if reading.holds}
    assert held == {"I_i per unit mass, strokes of the dampings", "the same, lengths as printed"}
    (inertia_alone,) = (r for r in claims["8"].readings if r.name == "I_i per unit mass")
    assert [check.holds for check in inertia_alone.checks] == [True, False, True, True, False]


def test_readings_are_the_numbers_that_they_say():
    defaults = {q.name: q.default for q in load("slosh").manifest.parameters}
    assert tuple(defaults[name] for name in ("m1", "m2")) == readings.MASSES
    for settings, name in ((readings.INERTIA_PER_MASS, "I"), (readings.DAMPING_PER_MASS, "eps")):
        assert settings == {f"{name}{k}": defaults[f"{name}{k}"] * defaults[f"m{k}"] for k in (1, 2)}


@pytest.mark.parametrize(
    ("values", "count"),
    [([0.0, 1.0], 0), ([0.0, 1.0, 0.0], 1), ([0.0, 1.0, 0.9, 1.5, 0.0, 0.2, -1.0, 1.0], 2), ([0.0, 0.1, 0.0], 0)],
)
def test_turning_points_are_those_of_swings_that_count(values, count):
    assert turns(np.array(values), 0.5) == count
    assert turns(-np.array(values), 0.5) == count


def test_no_gain_makes_up_for_a_weight_of_the_attitude_that_is_too_small(claims):
    assert [reading.holds for reading in claims["13"].readings] == [False, False, False, True, True]


def test_v1_is_positive_where_f_is(runs):
    """The bound on the weights that is checked before a run keeps f positive; weights beyond it need not."""
    fine, beyond = (positive(runs, r9=r9, r10=r9) for r9 in (1e-5, 100.0))
    assert all(check.holds for check in fine)
    assert [check.holds for check in beyond] == [False, True, False]
    with pytest.raises(MehvarError, match="may lose its inverse"):
        simulate(runs.model, FIRST, "paper", r9=100.0, r10=100.0)


def test_the_printed_order_of_the_weights_is_the_reverse_of_what_v1_needs(claims):
    assert [check.holds for check in claims["14"].checks] == [False, True, False]
    assert all(reading.holds for reading in claims["14"].readings)


def test_only_the_printed_sign_is_refuted_not_the_derived_one(claims):
    printed, derived = claims["11"].checks
    assert (printed.holds, derived.holds) == (False, True)


@pytest.mark.parametrize(
    ("changes", "broken"),
    [
        ({"w1": 2e4}, {"1", "R1", "R4"}),
        pytest.param({"w3": 8e4}, {"2", "R3"}, marks=pytest.mark.soak),
        pytest.param({"eps1": 1.0}, {"6", "R2", "R4"}, marks=pytest.mark.soak),
        pytest.param({"m1": 52.0}, {"R1", "R6"}, marks=pytest.mark.soak),
        pytest.param({"r9": 1e-6}, {"6", "R1"}, marks=pytest.mark.soak),
        ({"J_x": 450.0}, {"R2", "R3", "R5"}),
    ],
)
def test_a_changed_model_breaks_claims(changes, broken):
    class Altered(Runs):
        def __call__(self, controller, scenario, initial=None, **settings):
            law = self.model.manifest.controllers[controller].parameters
            known = {q.name for q in (*self.model.manifest.parameters, *law)}
            own = {name: value for name, value in changes.items() if name in known}
            return super().__call__(controller, scenario, initial, **{**own, **settings})

    paper = load_reproduction("slosh")
    as_read = tuple(dataclasses.replace(text, reading=()) for text in paper.texts)
    found = dataclasses.replace(paper, texts=as_read).claims(Altered(load("slosh")))
    assert broken <= {c.number for c in found if c.verdict is ClaimVerdict.FAILS}


def test_every_column_of_the_table_has_its_run():
    expected = {name: numbers for group in table.TABLE.group for name, numbers in group.numbers.items()}
    assert {len(numbers) for numbers in expected.values()} == {len(table.TABLE.run)} == {6}
    manifest = load("slosh").manifest
    assert set(expected) - set(manifest.metrics) == set(table._INPUTS)
    for k, law in ((2, FIRST), (3, SECOND)):
        for name, value in manifest.scenarios["paper"].expect[law].items():
            column = expected[name.removeprefix("max_") if "max_lat" not in name else name][k]
            in_degrees = manifest.metrics[name].unit == "rad"
            assert np.degrees(value) == pytest.approx(column, rel=2e-3) if in_degrees else value == column


def test_numbers_off_by_more_than_one_percent_are_told():
    assert table.near([99.1, 200.0], [100.0, 200.0])
    assert not table.near([98.9, 200.0], [100.0, 200.0])
    assert not table.near([float("nan"), 200.0], [100.0, 200.0])
    assert not table.near([float("inf"), 200.0], [100.0, 200.0])


def test_delta1_peaks_between_whole_seconds_under_v1_only(runs):
    first = runs(FIRST, "paper", plant="reduced")
    at_seconds, peak = (table.largest_inputs(first, every)["delta1"] for every in (10, 1))
    assert peak / at_seconds == pytest.approx(1.0167, abs=5e-4)
    assert first.t[np.abs(first.variables()["u_delta1"]).argmax()] == pytest.approx(0.8)
    second = runs(SECOND, "paper", plant="reduced")
    assert table.largest_inputs(second, 1)["delta1"] == pytest.approx(table.largest_inputs(second, 10)["delta1"], 1e-4)


def test_axial_acceleration_is_that_of_19(runs):
    assert table.axial(runs(FIRST, "paper")) == pytest.approx(2450 / 1510)


def test_figures_are_numbered_and_told():
    paper = load_reproduction("slosh")
    assert numbered_and_told(paper.figures, range(1, 12))
    assert all("computed anew" in figure.caption for figure in paper.figures[:8])
    assert "Not in the paper" in paper.figures[-1].caption
    diagrams, drawings = (tuple(f"{kind} {k}" for k in range(1, n + 1)) for kind, n in (("Diagram", 8), ("Figure", 2)))
    labels = tuple(figure.label for figure in paper.figures)
    assert labels == (*diagrams, *drawings, "")
    assert paper.statements.printed.figures == len(diagrams + drawings)


@pytest.fixture(scope="module")
def drawn(runs):
    with style():
        return {figure.number: figure.draw(runs) for figure in load_reproduction("slosh").figures}


@pytest.mark.parametrize("number", PANELS)
def test_axes_of_every_figure_have_labels_with_units(drawn, number):
    assert len(drawn[number].axes) == PANELS[number]
    assert unlabelled(drawn[number]) == []


@pytest.mark.parametrize(
    ("number", "names"),
    [
        (1, ("vx", "vy", "vz")),
        (2, ("att1", "att2", "att3")),
        (3, ("phi1", "phi2")),
        (4, ("theta1", "theta2")),
        (5, ("u_Mx", "u_My", "u_Mz")),
        (6, ("u_delta1", "u_delta2")),
    ],
)
@pytest.mark.parametrize("plant", ["full", "reduced"])
def test_diagrams_show_the_run_under_v1(runs, drawn, number, names, plant):
    series = runs(FIRST, "paper", plant=plant).variables()
    for name in names:
        values = series[name] if name.startswith(("v", "u_M")) else np.degrees(series[name])
        assert any(_starts(values, curve) for curve in _curves(drawn[number]))


@pytest.mark.parametrize(("number", "angle"), [(7, "phi"), (8, "theta")])
def test_differences_are_those_of_v2_less_v1(runs, drawn, number, angle):
    for plant in ("full", "reduced"):
        first, second = (runs(law, "paper", plant=plant).variables() for law in table.LAWS)
        for k in (1, 2):
            off = np.degrees(second[f"{angle}{k}"] - first[f"{angle}{k}"])
            assert any(_starts(off, curve) for curve in _curves(drawn[number]))


def _curves(figure):
    return [np.asarray(line.get_ydata()) for ax in figure.axes for line in ax.lines]


def _starts(values, curve):
    """Return whether a curve of more than a second is the beginning of a series."""
    return 10 < len(curve) <= len(values) and np.array_equal(curve, values[: len(curve)])


def test_any_run_can_be_drawn(runs, tmp_path):
    for number, settings in enumerate(({}, {"plant": "reduced", "t_end": 5.0}, {"attitude": "euler", "t_end": 0.1})):
        figure = run_picture(to_dataset(runs(SECOND, "paper", **settings)), runs.model.manifest)
        assert len(figure.axes) == 8
        save(figure, tmp_path / f"{number}.png")
        assert (tmp_path / f"{number}.png").stat().st_size > 10_000


def test_all_pendulums_are_drawn_and_the_first_six_named(runs):
    dataset = to_dataset(runs(FIRST, "paper", t_end=2.0))
    more = {f"{angle}{k}": dataset[f"{angle}2"] for k in range(3, 8) for angle in ("phi", "theta")}
    figure = run_picture(dataset.assign(more), runs.model.manifest)
    for ax in figure.axes[4:6]:
        assert sum(len(line.get_xdata()) == 21 for line in ax.lines) == 7
        assert len(ax.get_legend().get_texts()) == 6
