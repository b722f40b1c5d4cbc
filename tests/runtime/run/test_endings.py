# SPDX-License-Identifier: Apache-2.0
"""No run is past an event that ends it, however it came there; and what is known of a run that is cut short."""

import dataclasses
import math

import pytest

import mehvar
from mehvar.base.manifest import METRIC_KINDS, OF_SECONDS
from mehvar.cli.store.stats import print_statistics
from mehvar.models.check import check
from mehvar.models.quantities import ModelError
from mehvar.models.system import Controller, Event, Group, Metric, Scenario
from mehvar.runtime import InputError, simulate
from mehvar.runtime.batch.evaluation.conditions import Criterion
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.metrics import evaluate, is_cut_short, metrics
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.results import notes_of, to_dataset
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import table
from tests.models.written import written

FAR = 1e9
X = Group("x", (quantity("place", "m"),))
U = Group("u", (quantity("push", "m/s"),))
P = Group("p", tuple(parameter(*row) for row in (
    ("w", "m/s", 1.0), ("cliff", "m", FAR), ("gate", "m", FAR), ("goal", "m", FAR), ("floor", "m", -FAR),
    ("hole", "m", FAR), ("depth", "m", 3.0), ("strong", "m/s", FAR), ("wall", "m", FAR), ("Ts", "s", 0.25, POSITIVE),
)))  # fmt: skip
C = Group("c", (parameter("k", "1/s", 0.0),))
S = Group("s", (parameter("place_0", "m", 0.0),))
UNITS = dict.fromkeys(OF_SECONDS, "s") | {"sign_changes": "1", "events": "1"}
WINDOWS = {"all": (0.0, math.inf), "late": (0.25, math.inf), "early": (0.0, 0.35), "middle": (0.2, 0.65)}
KINDS = [kind for kind in METRIC_KINDS if kind != "events"]


def field():
    """A place that moves at a rate, between a cliff, a gate, a goal and a floor, with a hole that swallows."""
    summed = tuple(
        Metric(f"{kind}_{name}", kind, ("place",), band=0.3 * (kind in UNITS), unit=UNITS.get(kind, "m"),
               since=since, until=until, description=kind)
        for kind in KINDS
        for name, (since, until) in WINDOWS.items()
    )  # fmt: skip
    return table(
        X, U, P, name="field", title="a place that moves", outputs=Group("y", ()), output=(),
        rhs=(P.w + U.push,), scenario_parameters=S, initial=(S.place_0,),
        metrics=(*summed, Metric("falls", "events", ("swallowed",), unit="1", description="falls")),
        events=(
            Event("swallowed", X.place - P.hole, "rising", {X.place: X.place + P.depth}),
            Event("fallen", X.place - P.cliff, "rising", ends="failure"),
            Event("passed", X.place - P.gate, "rising", ends=True),
            Event("won", X.place - P.goal, "rising", ends="success"),
            Event("low", X.place - P.floor, "falling", ends="failure"),
            Event("torn", U.push - P.strong, "rising", ends="failure"),
            Event("touched", X.place - P.wall, "either", ends=True),
        ),
        controllers=(
            Controller("free", "", C, (C.k * X.place,)),
            Controller("steps", "", C, (C.k * X.place + 0 * P.Ts * P.w / P.Ts,), period="Ts"),
        ),
        scenarios=(Scenario("plain", "", 1.0, 0.1, {}, {}, {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(field(), tmp_path_factory.mktemp("field"))


every_backend = pytest.mark.parametrize("backend", ["c", "python"])
every_law = pytest.mark.parametrize(("law", "settings"), [("free", {}), ("steps", {"dt_out": 0.125})])
PAST = [
    ("fallen", {"cliff": -0.5}, Status.FAILURE, " as a failure"),
    ("passed", {"gate": -0.5}, Status.FAILURE, " as a failure"),
    ("won", {"goal": -0.5}, Status.EVENT, " as a success"),
    ("low", {"floor": 0.5}, Status.FAILURE, " as a failure"),
    ("passed", {"gate": 0.0}, Status.FAILURE, " as a failure"),
    ("passed", {"gate": 2.0, "place_0": 2.0}, Status.FAILURE, " as a failure"),
    ("won", {"goal": 0.0}, Status.EVENT, " as a success"),
    ("low", {"floor": 0.0, "w": -1.0}, Status.FAILURE, " as a failure"),
]


@every_backend
@every_law
@pytest.mark.parametrize("method", ["rk4", "dop853", "rodas5p"])
@pytest.mark.parametrize(("event", "values", "status", "how"), PAST)
@pytest.mark.share(7)
def test_a_run_that_begins_past_an_event_ends_there(folder, backend, law, settings, method, event, values, status, how):
    run = simulate(folder, law, backend=backend, method=method, parameters=values, **settings)
    assert run.status is status
    assert run.reason == f"the event {event} ends the run{how} at t = 0 s: its guard is past zero at the start"
    assert (run.t_stop, list(run.t), run.events) == (0.0, [0.0], ((0.0, event),))


@every_backend
@every_law
@pytest.mark.parametrize(("rate", "ends"), [(1.0, True), (-1.0, False), (0.0, False)])
@pytest.mark.parametrize("start", [0.0, 1.0, 1e9])
def test_from_zero_an_event_that_ends_runs_happens_at_once(folder, backend, law, settings, rate, ends, start):
    """At 1e9 the state is so coarse that it is a while until it is seen to go: in C a spacing, in Python a look."""
    values = {"cliff": start, "place_0": start, "w": rate, "floor": -2e9}
    run = simulate(folder, law, backend=backend, parameters=values, **settings)
    assert (run.status is Status.FAILURE) == ends
    assert (run.t_stop < (0.05 if start == 1e9 else 1e-9)) == ends


@every_backend
def test_either_direction_has_no_side_to_begin_on(folder, backend):
    run = simulate(folder, "free", backend=backend, parameters={"wall": -0.5})
    assert run.status is Status.DONE


@every_backend
@every_law
def test_a_reset_past_an_event_ends_the_run(folder, backend, law, settings):
    run = simulate(folder, law, backend=backend, parameters={"hole": 0.4, "cliff": 2.0}, **settings)
    assert run.status is Status.FAILURE
    assert run.t_stop == pytest.approx(0.4, abs=1e-9)
    assert [name for _, name in run.events] == ["swallowed", "fallen"]
    assert run.reason.startswith("the event fallen ends the run as a failure at t = 0.4 s")


@every_backend
def test_an_input_that_jumps_past_an_event_ends_the_run(folder, backend):
    """The push of the sample at 0.5 s; along the motion it would never have come there."""
    values = {"k": 1.0, "strong": 0.4}
    run = simulate(folder, "steps", backend=backend, parameters=values, dt_out=0.125)
    assert run.status is Status.FAILURE
    assert run.t_stop == 0.5
    assert list(run.t) == [0.0, 0.125, 0.25, 0.375, 0.5]
    assert run.u[-1, 0] > 0.4 > run.u[-2, 0]


VARY = {
    "place_0": "uniform(-0.5, 0.5)", "w": "uniform(-1, 2)", "cliff": "uniform(0, 3)", "gate": "uniform(0, 3)",
    "goal": "uniform(0.2, 3)", "floor": "uniform(-1.5, -0.2)", "hole": "uniform(0, 1)", "depth": "uniform(0.01, 0.3)",
    "strong": "uniform(0, 2)", "k": "uniform(0, 1)",
}  # fmt: skip


@pytest.mark.parametrize("method", ["rk4", "dop853"])
@pytest.mark.parametrize(("law", "settings"), [("free", {}), ("steps", {"dt_out": 0.125})])
@pytest.mark.share(4)
def test_a_batch_has_the_bits_of_its_runs_and_counts_how_they_ended(folder, tmp_path, capsys, law, settings, method):
    out = tmp_path / "runs.zarr"
    save = 0.25 if settings else 0.1
    mehvar.batch(folder, law, n=29, seed=4, vary=VARY, method=method, out=out, save=save, **settings)
    store = open_store(out)
    plan = plan_of(store, folder)
    runs = [repeat_run(plan, store, number) for number in range(29)]
    for number, run in enumerate(runs):
        text = difference(run, plan, store, number)
        assert not text or (method == "rk4" and "in error" in text), number
    endings = summarise(store).endings
    for event in ("fallen", "passed", "won", "low"):
        ended = [run.t_stop for run in runs if f"the event {event} ends the run" in run.reason]
        assert endings.get(event, (0, 0)) == (len(ended), sum(t == 0 for t in ended))
    count, done = len(runs), [run.status.complete for run in runs]
    falls = [[name for _, name in run.events].count("swallowed") for run in runs]
    for text, holds in (
        ("status == failure", [run.status is Status.FAILURE for run in runs]),
        ("status != done and t_stop < 0.1", [run.status is not Status.DONE and run.t_stop < 0.1 for run in runs]),
        ("events(swallowed) == 1", [done[k] and falls[k] == 1 for k in range(count)]),
    ):
        assert 0 < sum(holds) < count
        assert summarise(store, text).successes == sum(holds), text
    print_statistics(store)
    assert "the event fallen ended" in capsys.readouterr().out


@every_backend
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("goal", [0.03, 0.2, 0.3, 0.47, 0.9])
@pytest.mark.share(7)
def test_what_is_known_of_a_run_that_is_cut_short(folder, backend, kind, window, goal):
    """Extremes are those of its samples; settling and later values are unknown."""
    run = simulate(folder, "free", backend=backend, parameters={"goal": goal})
    metric = run.manifest.metrics[f"{kind}_{window}"]
    since, until = WINDOWS[window]
    value, series = metrics(run, run.manifest)[metric.name], {"place": run.x[:, 0]}
    assert value == pytest.approx(metrics(to_dataset(run), run.manifest)[metric.name], nan_ok=True)
    of_the_end = kind in OF_SECONDS or (kind == "final" and math.isfinite(until))
    assert is_cut_short(metric, run.t_stop) == (of_the_end and run.t_stop < until)
    if (of_the_end and run.t_stop < until) or run.t[-1] < since:
        assert math.isnan(value)
        assert metric.name in notes_of(run)
    else:
        assert value == evaluate(metric, run.t, series)
        assert metric.name not in notes_of(run)


ORIGIN = {"T": "s", "angle": "rad", "ratio": "1", "place": "m", "rate": "m/s", "final(place)": "m", "events(won)": "1"}


@pytest.mark.parametrize("text", [
    "T < 2", "T < 2 and place < 3", "place < 2 * final(place)", "place / rate < T", "not status != done",
    "abs(place - 3) <= 2 + final(place)", "1 / T < rate / place", "place / final(place) < angle", "events(won) == 2",
    "status == failure",
])  # fmt: skip
def test_conditions_compare_numbers_of_one_unit(text):
    Criterion(text).check(ORIGIN, {})


@pytest.mark.parametrize(("text", "what"), [
    ("T < place", "T is in s, place in m"),
    ("place < 2 * T", "place is in m, 2 * T in s"),
    ("angle < ratio", "angle is in rad, ratio in 1"),
    ("place + T < 3", "place is in m, T in s"),
    ("1 < place < T", "place is in m, T in s"),
    ("place * rate < place / T", "place * rate is in m^2/s, place / T in m/s"),
])  # fmt: skip
def test_numbers_of_different_units_are_refused(text, what):
    with pytest.raises(InputError, match="must be a condition on numbers with the same unit") as refusal:
        Criterion(text).check(ORIGIN, {})
    assert what in str(refusal.value)


@pytest.mark.parametrize("text", ["T == 2", "status < 3", "status == lost", "events(won) == T", "status + 1 < 2"])
def test_what_is_equal_is_a_status_or_a_count(text):
    with pytest.raises(InputError, match="must be"):
        Criterion(text).check(ORIGIN, {})


def test_what_ends_a_run_is_a_word_that_is_known():
    system = field()
    wrong = Event("fallen", X.place - P.cliff, "rising", ends="victory")
    with pytest.raises(ModelError, match="ends = 'victory': must be False, True, 'failure' or 'success'"):
        check(dataclasses.replace(system, events=(wrong,), metrics=()))


@pytest.mark.parametrize("law", ["free", "steps"])
def test_a_run_of_a_batch_that_ends_at_a_sample_has_its_row(folder, tmp_path, law):
    """The goal is a rounding before the sample, so that the step to it ends at the sample itself."""
    out, settings = tmp_path / "runs.zarr", {"t_end": 1.0, "dt_out": 0.125, "method": "rk4", "step": 0.125}
    vary = {"goal": f"choice({0.25 - 1e-14!r}, 3)"}
    mehvar.batch(folder, law, n=4, seed=1, vary=vary, out=out, save=0.125, **settings)
    store = open_store(out)
    plan = plan_of(store, folder)
    runs = [repeat_run(plan, store, number) for number in range(4)]
    assert {run.t_stop for run in runs} == {0.25, 1.0}
    assert {difference(run, plan, store, number) for number, run in enumerate(runs)} == {""}


def test_a_period_that_does_not_fit_is_told_with_its_origin(folder):
    """Nobody gave `hold`; the law has it from the default of its period."""
    with pytest.raises(
        InputError, match=r"^hold = 0.25 s \(from Ts of steps, default\) and dt_out = 0.1 s \(from scen"
    ):
        simulate(folder, "steps", origin="--set")
