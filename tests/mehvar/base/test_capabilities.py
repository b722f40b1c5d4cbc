# SPDX-License-Identifier: Apache-2.0
"""Every place refuses the features that the table withholds from it, by name, and runs take the others."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import pytest
import sympy as sp

import mehvar
from mehvar.base import capabilities as table
from mehvar.base.capabilities import FEATURES, Feature, Operation
from mehvar.models.system import TIME, Controller, Diffusion, Event, Group, Parameter, Quantity, RandomStep, System
from mehvar.runtime import load, simulate
from mehvar.runtime.board.image.build import program
from mehvar.runtime.model.tools.control import law_system, plant_system
from mehvar.web.export import export_web
from tests.models.written import written

V, F, U = Quantity("v", "m/s", "speed"), Quantity("f", "m/s^2", "acceleration"), Quantity("u", "m/s^2", "thrust")
K, TS = Parameter("k", "1/s", "friction", default=0.5), Parameter("Ts", "s", "period", default=0.1, bounds="(0, inf)")
SIGMA = Parameter("sigma", "m/s^(3/2)", "density of the noise", default=0.1)
GAIN = Parameter("gain", "1/s", "gain", default=1.0)
WIENER, STEP = Quantity("W", "s^(1/2)", "noise"), Quantity("kick", "1", "random number")
C, SUM = Group("c", (GAIN,)), Group("z", (Quantity("sum", "m", "sum of the speed"),))
STEPS = Controller("steps", "a sampled law", C, (-GAIN.symbol * V.symbol,), period="Ts")
SMOOTH = Controller("smooth", "a continuous law", C, (-GAIN.symbol * V.symbol,))


def block(*more: Parameter, **fields: object) -> System:
    """A block on a plane with friction."""
    given = {
        "states": Group("x", (V,)), "inputs": Group("u", (U,)), "rhs": (U.symbol - K.symbol * V.symbol,),
        "parameters": Group("p", (K, TS, *more)), "controllers": (STEPS, SMOOTH),
    }  # fmt: skip
    return System(name="block", **(given | fields))


SYSTEMS: dict[Feature, Callable[[], System]] = {
    table.ALGEBRAIC: lambda: block(
        states=Group("x", (V, F)), mass=sp.diag(1, 0),
        rhs=(F.symbol, U.symbol - K.symbol * V.symbol - F.symbol),
    ),
    table.EVENTS: lambda: block(events=(Event("half", TIME.symbol - 5 * TS.symbol),)),
    table.PROCESS_NOISE: lambda: block(
        SIGMA, diffusion=Diffusion(Group("w", (WIENER,)), (SIGMA.symbol * WIENER.symbol,))
    ),
    table.RANDOM_STEPS: lambda: block(
        random_step=RandomStep(Group("e", (STEP,)), (V.symbol * (1 + STEP.symbol / 10),))
    ),
    table.DELAYS: lambda: block(
        Parameter("late", "1", "samples", default=2.0, bounds="[0, 9]"), delays={"u": "late"}
    ),
    table.INTEGRATED: lambda: block(
        controllers=(STEPS, dataclasses.replace(
            SMOOTH, memory=SUM, start=(sp.S.Zero,), rates=(V.symbol,),
            command=(-GAIN.symbol * (V.symbol + GAIN.symbol * SUM.quantities[0].symbol),),
        ))
    ),
}  # fmt: skip
PLACES: dict[Operation, Callable[[Path, Path], object]] = {
    Operation.EXPLICIT: lambda folder, _: simulate(folder, "steps", method="dop853", t_end=1.0),
    Operation.IMPLICIT: lambda folder, _: simulate(folder, "steps", method="rodas5p", t_end=1.0),
    Operation.STOCHASTIC: lambda folder, _: simulate(folder, "steps", method="platen", t_end=1.0),
    Operation.CONTINUOUS: lambda folder, _: simulate(folder, "smooth", method=method_of(folder), t_end=1.0),
    Operation.HELD: lambda folder, _: simulate(folder, "smooth", hold=0.1, method=method_of(folder), t_end=1.0),
    Operation.BOARD: lambda folder, _: program(load(folder), "smooth"),
    Operation.FMU: lambda folder, out: mehvar.export_fmu(folder, out / "block.fmu", controller="smooth"),
    Operation.PAGE: lambda folder, out: export_web(folder, out / "page"),
    Operation.LINEARIZE: lambda folder, _: (model := load(folder)).linearize(
        [0.0] * len(model.state_names), [0.0], model.parameters()
    ),
    Operation.IVP: lambda folder, _: load(folder).as_solve_ivp(u=[0.0]),
    Operation.NLSYS: lambda folder, _: nonlinear(load(folder)),
}
RUNS = (Operation.EXPLICIT, Operation.IMPLICIT, Operation.STOCHASTIC, Operation.CONTINUOUS, Operation.HELD)
CELLS = [(feature, place) for feature in FEATURES for place in Operation if feature in SYSTEMS]


def method_of(folder: Path) -> str:
    manifest = load(folder).manifest
    return "rodas5p" if manifest.algebraic else "euler" if manifest.wiener else "dop853"


def nonlinear(model: mehvar.Model) -> None:
    """Make the law, or the plant where the law has no states of its own."""
    if not (law := model.manifest.controllers["smooth"]).memory:
        plant_system(model.manifest, model.functions, model.parameters())
    law_system(model.manifest, model.functions, law, model.parameters(), [1.0])


@pytest.fixture(scope="module")
def folders(tmp_path_factory) -> dict[Feature, Path]:
    return {feature: written(make(), tmp_path_factory.mktemp("block")) for feature, make in SYSTEMS.items()}


@pytest.mark.parametrize(
    ("feature", "place"), [cell for cell in CELLS if cell[1] in cell[0].refused], ids=lambda part: part.name
)
def test_a_place_refuses_a_feature_by_name(folders, tmp_path, feature, place):
    with pytest.raises(mehvar.InputError, match=feature.name) as refusal:
        PLACES[place](folders[feature], tmp_path)
    assert "block" in str(refusal.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("feature", "place"),
    [
        (feature, place)
        for feature, place in CELLS
        if place in RUNS and place not in feature.refused
        if (place is Operation.STOCHASTIC) == (feature is table.PROCESS_NOISE) or place not in RUNS[:3]
    ],
    ids=lambda part: part.name,
)
def test_a_run_takes_the_others(folders, tmp_path, feature, place):
    assert PLACES[place](folders[feature], tmp_path).status.complete


def test_every_refused_feature_is_tried():
    assert {feature for feature in FEATURES if feature.refused} == set(SYSTEMS)


def test_rows_name_fields_of_the_vocabulary():
    fields = {field.name for kind in (System, Controller) for field in dataclasses.fields(kind)}
    assert fields >= {name for feature in FEATURES for name in feature.fields}
