# SPDX-License-Identifier: Apache-2.0
"""Features combined in one system: it runs the same everywhere, or is refused by name."""

import dataclasses

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.models.check import check
from mehvar.models.events import Event
from mehvar.models.forms import with_mass
from mehvar.models.quantities import ModelError
from mehvar.models.system import Controller, Diffusion, Group, RandomStep, Scenario, Sensor, System
from mehvar.runtime import simulate
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import WHOLE, table
from tests.models.written import written
from tests.reference.scipy_loop import by_scipy

COUNT = dataclasses.replace(WHOLE, lower=0.0)
X = Group("x", (quantity("a", "m"), quantity("v", "m/s"), quantity("on", "1")))
U = Group("u", (quantity("push", "m/s^2"),))
P = Group("p", tuple(parameter(*row) for row in (
    ("Ts", "s", 0.1, POSITIVE), ("w", "1/s^2", 9.0), ("b", "1/s", 0.3), ("mid", "m", 0.2), ("e", "1", 0.8),
    ("lag", "1", 3.0, COUNT), ("sigma", "m/s", 0.05), ("q", "m/s^(3/2)", 0.1), ("M", "kg", 2.0), ("l", "m", 0.8),
    ("q_l", "m/s^(1/2)", 0.1),
)))  # fmt: skip
SHOWN = Group("y", tuple(quantity(f"p_{q.name}", q.unit) for q in P))
"""Outputs that use every parameter, for one that nothing uses is refused."""
C, S = Group("c", (parameter("k", "1/s", 0.5),)), Group("s", (parameter("a_0", "m", 0.8),))
RARE = Group("c", (*C.quantities, parameter("every", "1", 4.0, WHOLE)))
SEEN, NOISE, WIENER = (
    Group("seen", (quantity("shown", "m/s"),)), Group("e", (quantity("hiss", "1"),)),
    Group("w", (quantity("W", "s^(1/2)"),)),
)  # fmt: skip
HIT = Event("hit", X.a, "falling", {X.v: -P.e * X.v})
TURN = Event("turn", X.v, "rising", {X.on: 1 - X.on})
TOP = Event("top", X.v, "falling", {X.on: 1 - X.on})


def law(name="steps", seen=X.v, **fields) -> Controller:
    """A brake."""
    return Controller(name, "a brake", RARE if "every" in fields else C, (-C.k * seen,), **fields)


def hopper(**fields) -> System:
    """A mass on a spring that hits a wall, and a mode that changes the spring where the mass turns."""
    own = {
        "outputs": SHOWN, "output": P.symbols, "initial": (S.a_0, sp.S.Zero, sp.S.Zero), "events": (HIT, TOP),
        "rhs": (X.v, U.push - P.w * (1 + X.on) * (X.a - P.mid) - P.b * X.v, sp.S.Zero),
        "controllers": (law(period="Ts"), law("smooth")),
        "scenarios": (Scenario("plain", "plain", 3.0, 0.05, {}, {}, {}),),
    }  # fmt: skip
    states = fields.pop("states", X)
    return table(states, U, P, name="hopper", title="a mass at a wall", scenario_parameters=S, **(own | fields))


def circle() -> dict:
    """A vector that a mode turns at one of two rates, kept at its length, which is a parameter."""
    rate = (
        sp.sqrt(P.w) * (1 + X.on) + P.b - U.push * P.Ts / P.l
    )  # along the circle: what left it would depend on the steps
    place = Group("x", (quantity("a", "m"), quantity("v", "m"), quantity("on", "1")))
    size = sp.sqrt(X.a**2 + X.v**2)
    return {
        "states": place,
        "rhs": (-rate * X.v, rate * X.a, sp.S.Zero),
        "projection": (P.l * X.a / size, P.l * X.v / size, X.on),
        "controllers": (law(seen=sp.sqrt(P.w) * X.v, period="Ts"), law("smooth", sp.sqrt(P.w) * X.v)),
    }  # fmt: skip


FORCE = P.M * (U.push - P.w * (1 + X.on) * (X.a - P.mid) - P.b * X.v)
MASS = {"mass": sp.diag(1, P.M, 1), "rhs": (X.v, FORCE, sp.S.Zero)}
SYSTEMS = {
    "nothing else": {},
    "delays": {"delays": {"push": "lag"}},
    "random steps": {"random_step": RandomStep(NOISE, (X.a, X.v + P.sigma * NOISE.hiss, X.on))},
    "rates": {"controllers": (law(period="Ts", every="every"),)},
    "seen": {
        "sensor": Sensor(NOISE, (X.v + P.sigma * NOISE.hiss,), SEEN),
        "controllers": (law(seen=SEEN.shown, period="Ts"), law("smooth", SEEN.shown)),
    },
    "projection": circle() | {"events": (TOP, TURN)},
    "mass": MASS,
    "mass and delays": MASS | {"delays": {"push": "lag"}},
}  # fmt: skip
SHAKEN = Diffusion(WIENER, (sp.S.Zero, P.q * WIENER.W, sp.S.Zero))
NOISY = {
    "delays": {"diffusion": SHAKEN, "delays": {"push": "lag"}, "events": ()},
    "projection": circle() | {
        "diffusion": Diffusion(WIENER, (sp.S.Zero, P.q_l * WIENER.W, sp.S.Zero)), "events": (),
    },
}  # fmt: skip


def folder_of(path, **fields):
    """Write a system, solved for its rates where it has a mass."""
    system = hopper(**fields)
    check(system)
    return written(with_mass(system), path)


def repeats(folder, name, path, **options):
    """Run lanes, and each alone: the same bits."""
    mehvar.batch(folder, name, n=9, seed=1, vary={"b": "uniform(0.1, 0.5)"}, out=path / f"{name}.zarr", **options)
    store = open_store(path / f"{name}.zarr")
    plan = plan_of(store, folder)
    assert {difference(repeat_run(plan, store, k), plan, store, k) for k in range(9)} == {""}


def laws_of(part):
    """The laws of which a run can be made: inputs that are delayed, and random steps, are of samples."""
    names = [one.name for one in part.get("controllers", hopper().controllers)]
    return [name for name in names if name == "steps" or not part.keys() & {"delays", "random_step"}]


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.share(8)
def test_events_beside(tmp_path, name):
    part = SYSTEMS[name]
    folder = folder_of(tmp_path, **part)
    for one in laws_of(part):
        for method in ("dop853", "rk4", "rodas5p") if one == "steps" else ("dop853",):
            c = simulate(folder, one, method=method)
            with by_scipy():
                python = simulate(folder, one, method=method)
            assert [event for _, event in c.events] == [event for _, event in python.events]
            assert len(c.events) > 2
            np.testing.assert_allclose([t for t, _ in c.events], [t for t, _ in python.events], atol=1e-7)
            np.testing.assert_allclose(c.x, python.x, atol=1e-6)
        repeats(folder, one, tmp_path)


def test_a_mass_is_that_of_the_equations_solved_by_hand(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    runs = [simulate(folder_of(tmp_path / n, **part), "steps") for n, part in (("a", {}), ("b", MASS))]
    np.testing.assert_allclose(runs[0].x, runs[1].x, atol=1e-8)


def test_a_delay_of_no_sample_is_none(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    none = simulate(folder_of(tmp_path / "a"), "steps")
    zero = simulate(folder_of(tmp_path / "b", **SYSTEMS["delays"]), "steps", parameters={"lag": 0.0})
    np.testing.assert_array_equal(none.x, zero.x)


@pytest.mark.parametrize("name", NOISY)
@pytest.mark.parametrize("method", ["euler", "platen"])
@pytest.mark.share(4)
def test_process_noise_beside(tmp_path, name, method):
    folder = folder_of(tmp_path, **NOISY[name])
    for one in laws_of(NOISY[name]):
        c = simulate(folder, one, method=method, step=0.01, run=2)
        with by_scipy():
            python = simulate(folder, one, method=method, step=0.01, run=2)
        np.testing.assert_allclose(c.x, python.x, rtol=1e-9, atol=1e-12)
        assert not np.allclose(c.x, simulate(folder, one, method=method, step=0.01, run=3).x)
        repeats(folder, one, tmp_path, method=method, step=0.01)


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ({"diffusion": SHAKEN}, r"events \(hit, top\) cannot be combined with process noise"),
        ({"mass": sp.diag(1, 0, 1)}, r"events \(hit, top\) cannot be combined with algebraic states"),
        (
            {"controllers": (law("smooth", memory=Group("z", (quantity("sum", "m"),)), start=(X.a,), rates=(X.v,)),)},
            r"events \(hit, top\) cannot be combined with a continuous law with states of its own",
        ),
    ],
)
def test_events_that_were_not_built_are_refused(part, message):
    with pytest.raises(ModelError, match=message):
        check(hopper(**part))
