# SPDX-License-Identifier: Apache-2.0
"""Consequences of an event: guards beside it, the step behind a reset, events in a row, guards without a value."""

from pathlib import Path

import pytest
import sympy as sp

from mehvar.models.system import Controller, Event, Group, Scenario, System
from mehvar.runtime import Run, Status, simulate
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import table
from tests.models.written import written

BACKENDS = ("c", "python")
ADAPTIVE = ("dopri5", "dop853", "rock4")


def clockwork() -> System:
    """A hand that turns, and a spring whose rate an event changes."""
    x = Group("x", (quantity("angle", "1"), quantity("place", "1"), quantity("speed", "1/s"), quantity("k", "1/s")))
    u, z = Group("u", (quantity("push", "1/s"),)), sp.S.Zero
    rows = (
        ("w", "1/s", 1.0), ("goal", "1", 50.0), ("a", "1", 0.0), ("gap", "1", 0.1), ("late", "1", 0.0),
        ("edge", "1", 1e9, POSITIVE), ("change", "1", 99.0), ("k_next", "1/s", 1.0),
    )  # fmt: skip
    p, none = Group("p", tuple(parameter(*row) for row in rows)), Group("c", ())
    s = Group("s", (parameter("k_0", "1/s", 1.0),))
    return table(
        x, u, p, name="clockwork", title="a hand and a spring", scenario_parameters=s,
        rhs=(p.w + u.push, x.speed, -(x.k**2) * x.place, z), initial=(z, sp.S.One, z, s.k_0),
        events=(
            Event("here", x.angle - p.goal, "rising"),
            Event("there", sp.exp(x.angle) - sp.exp(p.goal + p.late), "rising"),
            Event("wave", sp.sin(p.a * x.angle + 1), "either"),
            Event("follower", sp.sin(p.a * x.angle + 1 - p.gap), "either"),
            Event("lost", sp.log(p.edge - x.angle) + 100, "falling"),
            Event("change", x.angle - p.change, "rising", {x.k: p.k_next}),
        ),
        controllers=(Controller("free", "", none, (z,)),),
        scenarios=(Scenario("plain", "", 10.0, 10.0, {}, {}, {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(clockwork(), tmp_path_factory.mktemp("clockwork"))


def times(run: Run, event: str) -> list[float]:
    return [t for t, name in run.events if name == event]


@pytest.mark.parametrize(("backend", "late"), [("c", 0.0), ("c", 1e-13), ("python", 0.0), ("python", 1e-13)])
def test_guards_that_cross_together_do_so_at_one_instant(folder: Path, backend: str, late: float) -> None:
    """Two texts of one crossing, told apart by rounding or within what a step is located to: none waits for a step."""
    for goal in (0.7, 1.3, 1.9, 2.3, 3.1, 3.7, 4.9, 5.3):
        run = simulate(folder, "free", backend=backend, method="dop853", goal=goal, late=late, t_end=6.0, dt_out=6.0)
        assert len(times(run, "here")) == 1
        assert times(run, "here") == times(run, "there"), goal


@pytest.mark.parametrize("backend", BACKENDS)
def test_stalls_that_are_not_in_a_row_do_not_end_a_run(folder: Path, backend: str) -> None:
    """Pairs of events that are nearer than what makes progress, with progress between the pairs."""
    run = simulate(folder, "free", backend=backend, a=3.0, gap=6e-9, dt_out=0.25)
    assert run.status is Status.DONE
    assert len(times(run, "wave")) == len(times(run, "follower")) == 9
    assert all(0 < later - t < 3e-9 for t, later in zip(times(run, "wave"), times(run, "follower"), strict=True))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("method", ["rk4", *ADAPTIVE])
def test_a_guard_without_a_value_ends_the_run(folder: Path, backend: str, method: str) -> None:
    """Else it would never cross, and nobody would know; nor has it crossed."""
    run = simulate(folder, "free", backend=backend, method=method, edge=4.1, dt_out=0.5)
    assert run.status is Status.NOT_FINITE
    assert times(run, "lost") == []
    assert 4.0 <= run.t_stop <= 4.5


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_guard_without_a_value_at_the_start_ends_the_run_there(folder: Path, backend: str) -> None:
    run = simulate(folder, "free", backend=backend, edge=4.1, initial={"angle": 5.0}, dt_out=0.5)
    assert (run.status, run.t_stop) == (Status.NOT_FINITE, 0.0)


def switched() -> System:
    """A guard that is the place of a coarse hand before the first push, and a fine number afterwards."""
    x, u = Group("x", (quantity("place", "1"), quantity("fine", "1"))), Group("u", (quantity("push", "1/s"),))
    rows = (
        ("w", "1/s", 0.01),
        ("goal", "1", 0.0),
        ("turn", "1", 0.0),
        ("full", "1/s", 1.0),
        ("Ts", "s", 1.0, POSITIVE),
    )
    p, z = Group("p", tuple(parameter(*row) for row in rows)), Group("z", (quantity("calls", "1"),))
    s = Group("s", (parameter("place_0", "1", 1e9),))
    command = p.full * sp.Min(z.calls, 1)
    return table(
        x, u, p, name="switched", title="a hand and a number", scenario_parameters=s,
        initial=(s.place_0, sp.S.Zero),
        rhs=(p.w + 0 * u.push / p.Ts * p.Ts, u.push * (x.place - p.turn)),
        events=(Event("touch", (p.full - u.push) * (x.place - p.goal) + u.push * x.fine, "rising"),),
        controllers=(
            Controller("push", "", Group("c", ()), (command,), period="Ts", memory=z, start=(sp.S.Zero,),
                       update=(z.calls + 1,)),
        ),
        scenarios=(Scenario("plain", "", 2.0, 1.0, {}, {}, {}),),
    )  # fmt: skip


def test_what_is_noise_of_a_guard_is_none_behind_a_jump_of_its_input(tmp_path: Path) -> None:
    """The hand comes to its goal at a sample; behind it the number dips by less than its noise, and rises again."""
    folder, place, spacing = written(switched(), tmp_path), 1e9 + 0.1, 2.0**-23
    for early in range(6, 26):
        run = simulate(folder, "push", w=0.1, goal=place - early * spacing, turn=place + 2e-5)
        assert times(run, "touch")[-1] == pytest.approx(1.00043, abs=2e-5), early


@pytest.mark.parametrize("method", ADAPTIVE)
def test_behind_a_reset_a_run_begins_with_a_step_of_its_own(folder: Path, method: str) -> None:
    """A spring that is a thousand times as fast there costs no more trials than one that goes on as it was."""
    options = {"method": method, "t_end": 2.0, "dt_out": 2.0, "rtol": 1e-6, "atol": 1e-6, "change": 1.0}
    slow, fast = (simulate(folder, "free", k_next=k, **options) for k in (1.0, 1e3))
    assert times(slow, "change") == times(fast, "change")
    assert slow.statistics["rejected"] == fast.statistics["rejected"]


def struck(shape) -> System:
    """A mass on a spring, struck where it passes a place: each time with another sign and a faster clock."""
    x = Group("x", (quantity("a", "1"), quantity("v", "1"), quantity("mode", "1")))
    rows = (("w", "1/s", 2.73), ("place", "1", 0.32), ("keep", "1", 1.18))
    p, u = Group("p", tuple(parameter(*row) for row in rows)), Group("u", (quantity("push", "1/s"),))
    blow = {x.v: -p.keep * x.v + p.place / 10, x.mode: (3 - x.mode) / 2}
    return table(
        x, u, p, name="struck", title="a mass on a spring", scenario_parameters=Group("s", ()),
        initial=(sp.S.Zero, 9 * (p.place + 2) / 10, sp.S.One),
        rhs=(p.w * x.v * x.mode, u.push - p.w * (x.a * (1 + x.mode / 4) + x.v / 20), sp.S.Zero),
        events=(Event("blow", shape(x.a - p.place), "either", blow),),
        controllers=(Controller("free", "", Group("c", ()), (sp.S.Zero,)),),
        scenarios=(Scenario("plain", "", 8.0, 0.1, {}, {}, {}),),
    )  # fmt: skip


@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_shape_of_a_guard_does_not_move_its_events(tmp_path: Path, method: str) -> None:
    """Flat at its zero, where secants mislead, or steep, where it is far from zero after the smallest time."""
    shapes = {
        "line": lambda gap: gap, "cube": lambda gap: gap**3, "root": lambda gap: sp.sign(gap) * sp.sqrt(sp.Abs(gap)),
        "edge": lambda gap: sp.sign(gap) + gap,
    }  # fmt: skip
    folders = {name: tmp_path / name for name in shapes}
    for name, place in folders.items():
        place.mkdir()
        written(struck(shapes[name]), place)
    for place, keep in ((0.32, 1.18), (0.42, 0.39)):
        settings = {"method": method, "place": place, "keep": keep}
        events = {name: times(simulate(at, "free", **settings), "blow") for name, at in folders.items()}
        assert len(events["line"]) > 1
        for instants in events.values():
            assert instants == pytest.approx(events["line"], abs=1e-8)
