# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from mehvar.papers.claims import ClaimVerdict
from mehvar.papers.reproduction import load_reproduction, run_picture
from mehvar.papers.runs import Runs
from mehvar.papers.satellite import rows as table
from mehvar.papers.satellite.rows import AXES, PRINTED_B
from mehvar.pictures.files import save
from mehvar.pictures.style import style
from mehvar.runtime.model.model import load
from mehvar.runtime.run.results import to_dataset
from tests.mehvar.images import numbered_and_told, unlabelled

NOTED = {"3", "7", "11"}
FAILING = {"10", "12", "13"}
PANELS = {4: 3, 5: 3, 6: 9, 7: 3, 8: 3, 9: 6, 10: 6, 11: 6, 12: 3}


@pytest.fixture(scope="module")
def runs():
    return Runs(load("satellite"))


@pytest.fixture(scope="module")
def claims(runs):
    return {claim.number: claim for claim in load_reproduction("satellite").claims(runs)}


def test_paper_says_whose_it_is_and_how_it_was_read():
    paper = load_reproduction("satellite")
    assert "Fani Saberi" in paper.captions.citation
    assert any("missing" in text for text in paper.captions.readings)


def test_claims_hold_but_for_those_that_are_known_not_to(claims):
    rows = [f"R{k}" for k in range(1, len(table.TABLE.row) + 1)]
    assert list(claims) == [*map(str, range(1, 14)), *rows]
    special = dict.fromkeys(NOTED, ClaimVerdict.NOTE) | dict.fromkeys(FAILING, ClaimVerdict.REFUTED)
    assert {n: c.verdict for n, c in claims.items()} == {n: special.get(n, ClaimVerdict.HOLDS) for n in claims}
    assert {n for n, c in claims.items() if c.note} == NOTED | FAILING


def test_printed_b0_and_zeros_fail_and_printed_b1_hold(claims):
    checks = {check.what: check.holds for check in claims["12"].checks}
    assert len(checks) == 9
    assert {holds for what, holds in checks.items() if what.endswith("b1")} == {True}
    assert {holds for what, holds in checks.items() if not what.endswith("b1")} == {False}


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        ({"tau_m": 5.0}, {"R5", "R6", "R17"}),
        ({"I_y": 2.5}, {"R1", "R5", "R15"}),
        ({"half_period": 100.0}, {"R1", "R2", "R3", "R4"}),
        ({"forgetting": 0.98}, {"9", "R9", "R17"}),
    ],
)
def test_a_changed_model_breaks_claims(change, broken):
    class Altered(Runs):
        def __call__(self, controller, scenario, initial=None, **settings):
            known = {q.name for q in self.model.manifest.controllers[controller].parameters}
            known |= {q.name for q in (*self.model.manifest.parameters, *self.model.manifest.scenario_parameters)}
            changes = {name: value for name, value in change.items() if name in known}
            return super().__call__(controller, scenario, initial, **{**changes, **settings})

    altered = Altered(load("satellite"))
    if "I_y" in change:
        altered.model.parameters = lambda **more: load("satellite").parameters(**change, **more)
    failed = {c.number for c in load_reproduction("satellite").claims(altered) if c.verdict is ClaimVerdict.FAILS}
    assert broken <= failed


def test_every_row_has_a_name_of_its_own():
    assert len({row.name for row in table.TABLE.row}) == len(table.TABLE.row) == 18


@pytest.mark.parametrize(("factor", "holds"), [(1.0, True), (1.019, True), (1.05, False), (math.nan, False)])
def test_numbers_off_by_more_than_two_percent_are_told(factor, holds):
    expected = next(row for row in table.TABLE.row if row.name == "pd").expected
    found = table.AxisMetrics(**{**vars(expected), "rms": factor * expected.rms})
    checks = {check.what: check for check in table.compare(expected, [found])}
    assert checks.pop("RMS error").holds is holds
    assert all(check.holds for check in checks.values())
    assert checks["settling after the last switch"].measured == "never / never / never s"


def test_measure_agrees_with_its_definitions(runs):
    run = runs("mrac", "paper", delay=1)
    found, series = table.measure(run), run.variables()
    error = np.degrees(series["yaw"] - series["ym_yaw"])[400:1600]
    assert found.rms[2] == pytest.approx(np.sqrt(np.mean(error**2)))
    assert found.largest[2] == np.abs(error).max()
    off = np.degrees(np.abs(series["roll_error"][1200:1600]))
    k = int(found.settling[0] / 0.5)
    assert off[k - 1] > 1.0 >= off[k:].max()


def test_a_lost_run_has_no_numbers(runs):
    lost = table.measure(runs("mrac-literal", "printed", delay=1))
    assert all(np.isnan(numbers).all() for numbers in vars(lost).values())


def test_ring_is_one_for_alternation_and_small_for_a_ramp(runs):
    alternating = table.measure(runs("mrac-literal", "printed")).ring
    smooth = table.measure(runs("pd", "paper")).ring
    assert (alternating > 0.98).all()
    assert (alternating < 1.0).all()
    assert (smooth < 0.02).all()


def test_without_a_c_compiler_single_precision_gets_a_note(monkeypatch):
    class OnlyDouble(Runs):
        def __call__(self, controller, scenario, initial=None, **settings):
            assert "real" not in settings
            return super().__call__(controller, scenario, initial, **settings)

    uncompiled = OnlyDouble(load("satellite"))
    monkeypatch.setattr(type(uncompiled.model), "backend", "python")
    found = {c.number: c for c in load_reproduction("satellite").claims(uncompiled)}
    assert {found[n].verdict for n in ("6", "R15")} == {ClaimVerdict.NOTE}
    assert all(found[n].note for n in ("6", "R15"))


def test_figures_are_numbered_and_told():
    figures = load_reproduction("satellite").figures
    assert numbered_and_told(figures, range(4, 13))
    assert all("our reading" in figure.caption for figure in figures[:-1])
    assert "Not in the paper" in figures[-1].caption


@pytest.fixture(scope="module")
def drawn(runs):
    with style():
        return {figure.number: figure.draw(runs) for figure in load_reproduction("satellite").figures}


@pytest.mark.parametrize("number", PANELS)
def test_axes_of_every_figure_have_labels_with_units(drawn, number):
    assert len(drawn[number].axes) == PANELS[number]
    assert unlabelled(drawn[number]) == []


def _curves(figure):
    return [np.asarray(line.get_ydata()) for ax in figure.axes for line in ax.lines]


@pytest.mark.parametrize(("number", "law", "delay"), [(4, "mrac", 0), (7, "pd", 0), (10, "mrac", 1), (11, "pd", 1)])
def test_figures_show_angles_and_reference_models_in_degrees(runs, drawn, number, law, delay):
    series = runs(law, "paper", delay=delay).variables()
    curves = _curves(drawn[number])
    for axis in AXES:
        for name in (axis, f"ym_{axis}"):
            assert any(np.array_equal(curve, np.degrees(series[name])) for curve in curves)


@pytest.mark.parametrize(("number", "law", "delay"), [(5, "mrac", 0), (8, "pd", 0), (10, "mrac", 1), (11, "pd", 1)])
def test_figures_show_torques_without_the_switch_at_the_end(runs, drawn, number, law, delay):
    series = runs(law, "paper", delay=delay).variables()
    curves = _curves(drawn[number])
    for name in ("u_Tx", "u_Ty", "u_Tz"):
        held = np.append(series[name][:-1], series[name][-2])
        assert any(np.array_equal(curve, 1e3 * held) for curve in curves)


def test_figure_6_starts_at_the_printed_b_and_figure_9_shows_errors(runs, drawn):
    axes = drawn[6].axes
    for k in range(3):
        circles = next(line for line in axes[3 + k].lines if line.get_marker() == "o")
        assert tuple(circles.get_ydata()) == PRINTED_B[k]
        assert {line.get_ydata()[0] for line in axes[3 + k].lines} >= set(PRINTED_B[k])
    series = runs("pd", "paper").variables()
    assert any(np.array_equal(c, np.degrees(series["yaw"] - series["ym_yaw"])) for c in _curves(drawn[9]))


@pytest.mark.parametrize(
    ("law", "scenario", "settings", "told"),
    [
        ("mrac", "flight", {}, ""),
        ("pd", "paper", {"t_end": 0.5}, ""),
        ("mrac-literal", "printed", {"delay": 1}, "ended early: lost (torque)"),
    ],
)
def test_any_run_can_be_drawn(runs, tmp_path, law, scenario, settings, told):
    dataset = to_dataset(runs(law, scenario, **settings))
    figure = run_picture(dataset, runs.model.manifest)
    assert len(figure.axes) == 8
    assert told in figure.get_suptitle()
    units = {ax.get_ylabel().split("[")[1] for ax in figure.axes[1:7:2]}
    assert units == ({"N m]"} if told else {"mN m]"})
    save(figure, tmp_path / "run.png")
    assert (tmp_path / "run.png").stat().st_size > 10_000
