# SPDX-License-Identifier: Apache-2.0
import math
from pathlib import Path

import numpy as np
import pytest

from mehvar.codegen.generate import Tree
from mehvar.pictures.files import save
from mehvar.pictures.style import style
from mehvar.reproduction.claims import ClaimVerdict
from mehvar.reproduction.deviations import deviations, table_claims
from mehvar.reproduction.ledgers import paper_ledgers
from mehvar.reproduction.paper import load_reproduction, run_picture
from mehvar.reproduction.runs import Runs
from mehvar.reproduction.statements import coverage, statement_verdicts
from mehvar.runtime.model.model import load
from mehvar.runtime.run.results import to_dataset
from papers.satellite import coarse
from papers.satellite import rows as table
from papers.satellite.rows import AXES, PRINTED_B
from papers.satellite.survival import COVARIANCES, survival
from tests.mehvar.images import numbered_and_told, unlabelled
from tests.papers.shared import missing, paper_claims, paper_runs

pytestmark = pytest.mark.soak  # `make run` decides the claims too
NOTED = {"3", "5", "7", "11", "17"}
FOR_A_VARIANT = {"1", "2", "6", "16", "19"}
UNDER_A_READING = {"13", "15"}
NOT_AS_PRINTED = {"10", "14"}
FAILING = {"12"}
DRAWINGS = (1, 2, 3)
ON_BOARD = (10, 11)
PANELS = {4: 6, 5: 6, 6: 1, 7: 1, 8: 1, 9: 3, 12: 9, 13: 6, 14: 6, 15: 3, 16: 8, 17: 4, 18: 2}


@pytest.fixture(scope="module")
def runs():
    return paper_runs("satellite")


@pytest.fixture(scope="module")
def claims():
    return {claim.number: claim for claim in paper_claims("satellite")}


def test_paper_says_whose_it_is_and_how_it_was_read():
    paper = load_reproduction("satellite")
    assert "Fani Saberi" in paper.captions.citation
    assert any("the pictures are not" in text for text in paper.captions.readings)


def test_claims_hold_but_for_those_that_are_known_not_to(claims):
    rows = [f"R{k}" for k in range(1, len(table.TABLE.row) + 1)]
    assert list(claims) == [*map(str, range(1, 20)), *rows]
    special = dict.fromkeys(NOTED, ClaimVerdict.PART) | dict.fromkeys(FAILING, ClaimVerdict.REFUTED)
    special |= dict.fromkeys(FOR_A_VARIANT, ClaimVerdict.VARIANT)
    special |= dict.fromkeys(UNDER_A_READING, ClaimVerdict.READING)
    special |= dict.fromkeys(NOT_AS_PRINTED, ClaimVerdict.PRINTED)
    assert {n: c.verdict for n, c in claims.items()} == {n: special.get(n, ClaimVerdict.HOLDS) for n in claims}
    assert {n for n, c in claims.items() if c.note} == NOTED | FAILING | UNDER_A_READING | NOT_AS_PRINTED


def test_printed_b0_and_zeros_fail_and_printed_b1_hold(claims):
    checks = {check.what: check.holds for check in claims["12"].checks}
    assert len(checks) == 9
    assert {holds for what, holds in checks.items() if what.endswith("b1")} == {True}
    assert {holds for what, holds in checks.items() if not what.endswith("b1")} == {False}


@pytest.mark.parametrize(
    ("number", "holding", "tried"),
    [
        ("10", {"coarse simulator, pole 0.5"}, 7),
        ("12", set(), 5),
        ("13", {"1e-3 for 1e-5", "slow reference"}, 4),
        ("14", {"coarse simulator, pole 0.5"}, 6),
        ("15", {"estimated and not used", "law (32), pole 0.5"}, 3),
    ],
)
def test_readings_under_which_a_claim_holds(claims, number, holding, tried):
    readings = claims[number].readings
    assert len(readings) == tried
    assert {reading.name for reading in readings if reading.holds} == holding


def test_readings_of_law_32_are_judged_by_its_torques_too(claims):
    for number in ("10", "14"):
        for checks in (claims[number].checks, *(reading.checks for reading in claims[number].readings)):
            essential = [check.what for check in checks if check.essential]
            assert len(essential) == 2
            assert "ring" in essential[1]


def test_with_pole_0_5_law_32_survives_and_its_torque_still_alternates(runs):
    for delay, least in ((0, 41), (1, 40)):
        cell = survival(runs.model, None, 0.5, delay)
        alone = table.measure(runs("mrac-literal", "printed", delay=delay, C2_pole=0.5, F0=1e3)).ring
        assert cell.done.sum() == least
        assert cell.calm(0.5).sum() < 20
        assert cell.ring[COVARIANCES.searchsorted(999.9)] == pytest.approx(alone, rel=1e-3)
    assert survival(runs.model, "semi-implicit", 0.5).calm(0.5).all()


def test_the_same_sentence_has_the_same_verdict_wherever_it_stands():
    texts = {text.place: text for text in load_reproduction("satellite").statements.statement}
    pairs = [
        ("section 6, 11", "conclusions 7"), ("abstract 11", "conclusions 6"), ("section 6, 9", "conclusions 2"),
        ("section 4, 2", "conclusions 1"),
    ]  # fmt: skip
    for one, other in pairs:
        assert (texts[one].claims, texts[one].equations) == (texts[other].claims, texts[other].equations)


def test_the_estimator_finds_the_gain_and_not_each_coefficient(claims):
    failing = {check.what for check in claims["5"].checks if not check.holds}
    assert any("b0 alone" in what for what in failing)
    assert not any("b0 + b1 of roll" in what or "b0 + b1 of pitch" in what for what in failing)


def test_without_the_plants_zero_law_32_survives_every_first_covariance(runs):
    coarse, exact = (survival(runs.model, step, 0.001) for step in ("semi-implicit", None))
    assert coarse.clean.all()
    assert coarse.rms.max() < 0.055
    assert 10 < exact.done.sum() < 30
    assert not survival(runs.model, "semi-implicit", 0.001, delay=1).done.any()


@pytest.mark.parametrize(("step", "after"), [("semi-implicit", 1), ("explicit", 2)])
def test_a_torque_moves_the_coarse_satellite_by_its_pulse_transfer(runs, step, after):
    still = {"omega0": 0.0, "wheels": 0.0, "roll_0_deg": 0.0, "pitch_0_deg": 0.0, "yaw_0_deg": 0.0}
    run = runs("pd", "paper", **still)
    loop = coarse.Loop(runs.model, run, step, 0, run.parameters.c[None])
    loop.step(0.0)
    torque = loop.applied[0]
    for k in range(1, after):
        assert not loop.x[0, :3].any()
        loop.step(k * loop.period)
    moved = 0.25 / np.array([2.13, 3.04, 3.09]) * torque
    assert loop.x[0, :3] == pytest.approx(moved, rel=1e-12)


def test_the_error_without_the_offset_in_the_law(runs):
    unused = table.measure(runs("mrac", "printed", delay=1, compensate_d=0)).rms
    assert unused == pytest.approx([0.66, 0.68, 0.16], abs=0.005)
    assert table.measure(runs("mrac", "printed", delay=1)).rms == pytest.approx([0.10, 0.11, 0.13], abs=0.005)


def test_an_offset_that_is_not_estimated_stays_zero_and_learns_nothing(runs):
    run = runs("mrac", "printed", delay=1, estimate_d=0)
    series = run.variables()
    for axis in AXES:
        assert not series[f"d_{axis}"].any()
        assert not series[f"D5_{axis}"].any()
        assert np.ptp(series[f"b0_{axis}"]) > 0.1


def test_every_statement_has_an_entry_and_every_claim_a_statement(runs, claims):
    paper = load_reproduction("satellite")
    (ledger,) = paper_ledgers(Tree(Path(__file__).parents[3]), "satellite")
    verdicts = {entry["number"]: entry["verdict"] for entry in ledger["entries"]}
    every = [*claims.values(), *table_claims(runs.model.manifest, deviations(runs))]
    numbers = [figure.number for figure in paper.figures]
    assert list(missing(paper.statements, [claim.number for claim in every], verdicts, numbers)) == []
    statements = statement_verdicts(paper.statements, every, verdicts)
    rows = {row.kind: (row.printed, row.judged, row.shown) for row in coverage(
        paper.statements, statements, verdicts, numbers)}  # fmt: skip
    assert rows["equations"] == (50, 50, 50)
    assert (rows["tables"], rows["figures"]) == ((1, 1, 1), (11, 9, 11))
    assert rows["entries on the conclusions"] == (None, 7, 7)
    assert set(verdicts) == {number for text in paper.statements.statement for number in text.equations}


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        ({"tau_m": 5.0}, {"R5", "R6", "R17"}),
        ({"I_y": 2.5}, {"R1", "R5", "R15"}),
        ({"half_period": 100.0}, {"R1", "R2", "R3", "R4"}),
        ({"forgetting": 0.98}, {"9", "R9", "R17"}),
    ],
)
@pytest.mark.soak
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


def test_without_a_c_compiler_single_precision_is_undecided(monkeypatch):
    class OnlyDouble(Runs):
        def __call__(self, controller, scenario, initial=None, **settings):
            assert "real" not in settings
            return super().__call__(controller, scenario, initial, **settings)

    uncompiled = OnlyDouble(load("satellite"))
    monkeypatch.setattr(type(uncompiled.model), "backend", "python")
    found = {c.number: c for c in load_reproduction("satellite").claims(uncompiled)}
    assert {found[n].verdict for n in ("6", "R15")} == {ClaimVerdict.OPEN}
    assert all(found[n].note for n in ("6", "R15"))


def test_figures_are_numbered_and_told():
    figures = load_reproduction("satellite").figures
    assert numbered_and_told(figures, range(1, 19))
    assert all("our reading" in figure.caption for figure in figures[:11])
    assert not any("our reading" in figure.caption for figure in figures[11:])


@pytest.fixture(scope="module")
def drawn(runs):
    with style():
        figures = load_reproduction("satellite").figures
        return {figure.number: figure.draw(runs) for figure in figures if figure.number not in ON_BOARD}


@pytest.mark.parametrize("number", PANELS)
def test_axes_of_every_figure_have_labels_with_units(drawn, number):
    assert len(drawn[number].axes) == PANELS[number]
    assert unlabelled(drawn[number]) == []


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (1, ("reference model", "1 / b_0", "B_S", "satellite", "estimator", "design")),
        (2, ("simulating computer", "interface", "control electronics", "72 bytes", "12 bytes", "0.5 s")),
        (3, ("computer", "interface circuit", "RS232", "ARM")),
    ],
)
def test_drawings_name_their_parts_inside_the_picture(drawn, number, words):
    (ax,) = drawn[number].axes
    texts = [text for text in ax.texts if text.get_text()]
    everything = " ".join(text.get_text() for text in texts)
    assert all(word in everything for word in words)
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    for text in texts:
        x, y = text.get_position()
        assert left <= x <= right
        assert low <= y <= high


def _curves(figure):
    return [np.asarray(line.get_ydata()) for ax in figure.axes for line in ax.lines]


@pytest.mark.parametrize(
    ("number", "law", "scenario", "delay", "axes"),
    [
        (4, "mrac", "paper", 0, AXES),
        (4, "mrac-literal", "printed", 0, AXES),
        *((6 + k, "pd", "paper", 0, (axis,)) for k, axis in enumerate(AXES)),
        (14, "pd", "paper", 1, AXES),
    ],
)
def test_figures_show_angles_and_reference_models_in_degrees(runs, drawn, number, law, scenario, delay, axes):
    series = runs(law, scenario, delay=delay).variables()
    curves = _curves(drawn[number])
    for axis in axes:
        for name in (axis, f"ym_{axis}"):
            assert any(np.array_equal(curve, np.degrees(series[name])) for curve in curves)


@pytest.mark.parametrize(
    ("number", "law", "scenario", "delay", "scale"),
    [
        (5, "mrac", "paper", 0, 1e3),
        (5, "mrac-literal", "printed", 0, 1.0),
        (9, "pd", "paper", 0, 1e3),
        (14, "pd", "paper", 1, 1e3),
    ],
)
def test_figures_show_torques_without_the_switch_at_the_end(runs, drawn, number, law, scenario, delay, scale):
    series = runs(law, scenario, delay=delay).variables()
    curves = _curves(drawn[number])
    for name in ("u_Tx", "u_Ty", "u_Tz"):
        held = np.append(series[name][:-1], series[name][-2])
        assert any(np.array_equal(curve, scale * held) for curve in curves)


def test_figure_12_starts_at_the_printed_b_and_figure_13_shows_errors(runs, drawn):
    axes = drawn[12].axes
    for k in range(3):
        circles = next(line for line in axes[3 + k].lines if line.get_marker() == "o")
        assert tuple(circles.get_ydata()) == PRINTED_B[k]
        assert {line.get_ydata()[0] for line in axes[3 + k].lines} >= set(PRINTED_B[k])
    series = runs("pd", "paper").variables()
    assert any(np.array_equal(c, np.degrees(series["yaw"] - series["ym_yaw"])) for c in _curves(drawn[13]))


def test_the_map_shows_every_run_once(drawn):
    for ax in drawn[16].axes:
        marks = [line for line in ax.lines if line.get_marker() in ("o", "x")]
        assert sum(len(line.get_xdata()) for line in marks) == 41
        assert f"{sum(len(line.get_xdata()) for line in marks[:2])} survive" in ax.get_title(loc="left")


def test_figures_10_and_11_are_recorded_from_the_board_with_the_hosts_bits(runs):
    outcome = runs.board("mrac", "paper")
    assert (outcome.max_ulp, outcome.x.ulp, outcome.u.compared) == (0, 0, 3 * 1601)
    figures = {figure.number: figure for figure in load_reproduction("satellite").figures}
    with style():
        angles, torques = (figures[number].draw(runs) for number in ON_BOARD)
    board, host = outcome.board.variables(), outcome.single.variables()
    for figure, names, scale in ((angles, AXES, 180 / np.pi), (torques, ("u_Tx", "u_Ty", "u_Tz"), 1e3)):
        assert unlabelled(figure) == []
        assert figure.axes[0].get_title(loc="left").startswith("board and host are 0 ulp apart in all")
        for ax, name in zip(figure.axes, names, strict=True):
            under = next(line for line in ax.lines if line.get_label() == "host, float")
            over = next(line for line in ax.lines if line.get_label() in AXES)
            assert np.allclose(under.get_ydata()[:-1], scale * host[name][:-1], rtol=1e-15)
            assert np.allclose(over.get_ydata()[:-1], scale * board[name][:-1], rtol=1e-15)
            assert under.get_zorder() <= over.get_zorder()


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
