# SPDX-License-Identifier: Apache-2.0
"""Whatever a public function of mehvar is given, it takes it or refuses it by name: no traceback of somebody else's.

Every argument of every name in `mehvar.__all__` is given each value of one catalogue, beside arguments that are right.
"""

from __future__ import annotations

import contextlib
import inspect
import re
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
import xarray as xr

import mehvar
from mehvar.parts import Hub, Spacecraft
from mehvar.runtime.run.options import OPTIONS
from tests.models.estimation.swing import START, swing

PENDULUM = str(Path(__file__).parents[1] / "runtime" / "pendulum")
GENERATED = str(Path(mehvar.__file__).parents[1] / "generated" / "triangle")
X, Y = sp.symbols("x y", real=True)
Q = (sp.S.One, X, Y, sp.S.Zero)
MODEL = mehvar.load(PENDULUM, "python")
TRIANGLE = mehvar.load(GENERATED, "python")
CRAFT = Spacecraft("craft")
CRAFT.add(Hub("hub", mass=1.0, inertia=(1.0, 2.0, 2.5)))
POINT = {"x": [0.1, 0.2], "u": [0.0], "p": MODEL.parameters()}

ODD: Mapping[str, Any] = {
    "none": None, "true": True, "zero": 0, "minus": -1, "three": 3, "half": 2.5, "nan": float("nan"),
    "infinity": float("inf"), "huge": 10**400, "complex": 1j, "empty": "", "text": "nonsense", "digit": "1",
    "a text with NUL": "a\0b", "half a character": "\udcff", "bytes": b"a", "list": [], "of texts": ["a"],
    "of lists": [[[]]], "tuple": (), "dict": {}, "of a text": {"a": "b"}, "of a number": {1: 2}, "object": object(),
    "function": print, "array": np.array([1.0, 2.0]), "array of texts": np.array(["a"]), "iterator": iter(()),
    "dataset": xr.Dataset({}), "symbol": sp.Symbol("z"), "matrix": sp.Matrix([X]), "module": mehvar,
    "proxy": MappingProxyType({}),
}  # fmt: skip
RUN = {"model": PENDULUM, "controller": "pd", "scenario": "swing", "parameters": {"m": 1.5}, "initial": {"rate": 0.1},
       "inputs": None, "interpolation": None, "period": None, "memory": None}  # fmt: skip


def slope(problem: Any) -> object:
    """Evaluate an initial value problem at its start."""
    return problem.fun(0.0, problem.y0), problem.jac(0.0, problem.y0)


SWING = mehvar.simulate(PENDULUM, "pd", "swing", t_end=0.1)

CALLS: Mapping[str, tuple[Callable[..., object], dict[str, Any]]] = {
    "simulate": (mehvar.simulate, {**RUN, "t_end": 0.1, "progress": None, "law": None, "origin": "a test", "l": 1.1}),
    "batch": (
        mehvar.batch,
        {
            **RUN, "n": 1, "t_end": 0.05, "vary": {"k_p": "normal(16, 0.1)"}, "points": None, "design": None,
            "seed": 1, "sampling": None, "save": 0.01, "out": None, "resume": False,
            "success": "peak < 1", "until": None, "strict": False, "threads": 1,
            "require": {"r": "quantile(0.5, peak) < 1"}, "confidence": 0.9, "scheduler": None, "report": None,
        },
    ),
    "require": (
        mehvar.require,
        {"runs": PENDULUM, "requirements": {"r": "quantile(0.5, peak) < 1"}, "confidence": 0.9, "controller": "pd",
         "n": 1, "t_end": 0.05, "rare": False},
    ),
    "fit": (
        mehvar.fit,
        {"model": PENDULUM, "data": SWING, "free": ["m"], "controller": "pd", "scenario": "swing",
         "parameters": {"l": 1.1}, "initial": {"rate": 0.1}, "sigma": {"angle": 0.1}},
    ),
    "tune": (
        mehvar.tune,
        {"model": PENDULUM, "controller": "pd", "free": ["k_p"], "cost": "0 * final(angle)", "n": 2, "seed": 1,
         "vary": {"m": "normal(1, 0.1)"}, "parameters": {"l": 1.1}, "t_end": 0.05},
    ),
    "steer": (
        mehvar.steer,
        {"model": "satellite", "to": {"roll": 0.0, "wx": 0.0}, "t_end": 2.0, "n": 4, "limits": {"Tx": 1e3},
         "scenario": "paper", "parameters": {"I_x": 2.1}, "initial": {"roll": 0.1}},
    ),
    "margins": (
        mehvar.margins,
        {"model": PENDULUM, "controller": "pd", "scenario": "swing", "size": None, "frequencies": None, "t_end": 0.1},
    ),
    "load": (mehvar.load, {"model": PENDULUM, "backend": "python"}),
    "build": (mehvar.build, {"system": CRAFT, "backend": "python"}),
    "open_result": (mehvar.open_result, {"path": "none.nc"}),
    "save": (mehvar.save, {"dataset": None, "path": "a.csv"}),
    "diff": (mehvar.diff, {"model": "triangle", "old": GENERATED, "new": GENERATED, "structures": ()}),
    "estimated": (
        mehvar.estimated,
        {"system": swing(), "law": "pd", "start": START, "noise": {"rate": 0.01}, "kind": "extended"},
    ),
    "kirchhoff": (mehvar.kirchhoff, {"energy": X * Y, "velocity": sp.Matrix(sp.symbols("v1:4")),
                                     "rate": sp.Matrix(sp.symbols("w1:4")), "rates": {X: Y}}),
    "lagrange": (
        mehvar.lagrange, {"energy": X * Y, "dissipation": X, "coordinates": (X,), "speeds": (Y,), "rates": {X: Y}}
    ),
    "quaternion_of_turns": (mehvar.quaternion_of_turns, {"turns": ((0, X),)}),
    "quaternion_product": (mehvar.quaternion_product, {"a": Q, "b": Q}),
    "quaternion_rates": (mehvar.quaternion_rates, {"q": Q, "omega": (X, Y, X)}),
    "quaternion_rotation": (mehvar.quaternion_rotation, {"q": Q}),
    "read_parameters": (mehvar.read_parameters, {"path": Path("none.toml")}),
    "read_scenarios": (mehvar.read_scenarios, {"path": Path("none.toml")}),
    "surfaces": (mehvar.surfaces, {"name": "kink", "expressions": sp.Max(X, Y), "derivation": None}),
    "scalar": (mehvar.scalar, {"quantity": mehvar.TIME}),
    "time_derivative": (mehvar.time_derivative, {"expr": X, "rates": {X: Y}}),
    "to_casadi": (mehvar.to_casadi, {"expressions": [X], "symbols": {X: ca.SX.sym("x")}, "definitions": {}}),
    "export_fmu": (
        mehvar.export_fmu,
        {"model": GENERATED, "out": "a.fmu", "controller": None, "scenario": None, "fmi": "2.0", "kind": "cs"},
    ),
    "list_models": (mehvar.list_models, {}),
    "trim": (
        mehvar.trim,
        {"model": MODEL, "fix": {"rate": 0.0}, "free": ["angle"], "p": None, "bounds": None, "steady": None},
    ),
    "verify": (mehvar.verify, {"path": "none"}),
    "Model.to_casadi": (TRIANGLE.to_casadi, {"name": "rhs"}),
    "Model.to_jax": (MODEL.to_jax, {}),
    "Model.to_numba": (MODEL.to_numba, {}),
    "Model.as_solve_ivp": (
        lambda **more: slope(MODEL.as_solve_ivp(**more)), {"u": [0.0], "p": None, "scenario": "swing"}
    ),
    "Model.to_control": (
        MODEL.to_control, {**POINT, "u": None, "outputs": None, "r": None, "controller": "pd", "c": None, "z": None}
    ),
    "Model.to_nlsys": (MODEL.to_nlsys, {"p": None, "controller": "pd", "c": None, "part": "loop"}),
    "Model.parameters": (MODEL.parameters, {"m": 1.5}),
    "Model.law_parameters": (MODEL.law_parameters, {"controller": "pd", "k_p": 1.0}),
    "Model.state": (MODEL.state, {"rate": 1.0}),
    **{f"Model.{name}": (getattr(MODEL, name), POINT) for name in ("rhs", "jac_x", "jac_u")},
    "Model.jac_p": (
        TRIANGLE.jac_p,
        {"x": TRIANGLE.state(), "u": [0.0] * 3, "p": TRIANGLE.parameters(), "outputs": None, "r": None},
    ),
    "Model.linearize": (
        MODEL.linearize, {**POINT, "u": None, "outputs": None, "r": None, "controller": "pd", "c": None, "z": None}
    ),
    "Derivation.section": (lambda **more: mehvar.Derivation().section(**more), {"title": "a"}),
    "Derivation.show": (
        lambda **more: mehvar.Derivation().show(**more),
        {"left": "a", "expr": X, "number": "", "title": "", "unit": "m"},
    ),
    "Derivation.define": (
        lambda **more: mehvar.Derivation().define(**more),
        {"name": "a", "expr": X, "number": "", "title": "", "unit": "m", "latex": "", "positive": False},
    ),
}  # fmt: skip
"""A call of each function and method, with valid arguments."""
LOOP = {"model": PENDULUM, "t_end": 0.05}
OPEN, OWN = (
    {"controller": None, "inputs": {"torque": ([0.0, 0.02], [0.1, 0.2])}},
    {"controller": lambda _t, _x, z: ([0.0], z)},
)
SIGNALS = {"interpolation", "period"}
HELD = {"period": 0.05, "memory": [0.0]}
RECORDED = mehvar.simulate(PENDULUM, "pd", t_end=0.1)
MORE: Mapping[str, tuple[Callable[..., object], dict[str, Any], set[str]]] = {
    "simulate, open": (
        mehvar.simulate, {**LOOP, **OPEN, "interpolation": "hold", "period": 0.05}, SIGNALS | {"inputs"}
    ),
    "simulate, recorded": (mehvar.simulate, {**LOOP, "controller": None, "inputs": RECORDED}, SIGNALS),
    "simulate, own law": (mehvar.simulate, {**LOOP, **OWN, **HELD}, {"controller", "period", "memory"}),
    "batch, open": (mehvar.batch, {**LOOP, **OPEN, "n": 1, "period": 0.05}, SIGNALS | {"inputs"}),
    "batch, own law": (mehvar.batch, {**LOOP, **OWN, **HELD, "n": 1}, {"controller", "period", "memory"}),
    **{
        f"Model.to_nlsys, {part}": (MODEL.to_nlsys, {"controller": law, "part": part}, {"p", "c", "controller"})
        for part, law in (("plant", None), ("law", "pd"), ("loop", "pd"))
    },
    "Model.to_control, plant": (MODEL.to_control, {**POINT, "controller": None}, {*POINT, "outputs", "r", "c", "z"}),
    **{
        f"{call}, inside {argument}": (
            lambda inside, call=call, argument=argument, given=given, key=key: getattr(mehvar, call)(
                **{**given, argument: {key: inside}}
            ),
            {"inside": right},
            {"inside"},
        )
        for call, argument, given, key, right in (
            ("trim", "fix", {"model": MODEL, "free": ["angle"]}, "rate", 0.0),
            ("trim", "free", {"model": MODEL}, "angle", 0.1),
            ("trim", "bounds", {"model": MODEL, "free": ["angle"]}, "angle", (-1.0, 1.0)),
            ("simulate", "inputs", {**LOOP, "controller": None}, "torque", 0.1),
            ("simulate", "parameters", {**LOOP, "controller": "pd"}, "m", 0.1),
            ("simulate", "initial", {**LOOP, "controller": "pd"}, "rate", 0.1),
            ("batch", "vary", {**LOOP, "controller": "pd", "n": 1}, "k_p", "normal(16, 0.1)"),
        )
    },
}  # fmt: skip
"""Calls of another kind, and which of their arguments are tried."""
FREE = {"simulate": {"l", *OPTIONS, "progress", "law", "origin"}, "batch": set(OPTIONS),
        "require": {"controller", "n", "t_end"}, "tune": {"t_end"}, "margins": {"t_end"}, "Model.parameters": {"m"},
        "Model.law_parameters": {"k_p"}, "Model.state": {"rate"}}  # fmt: skip
"""Names that go in by **keywords."""
RECORDS = {"Actuator", "Choice", "Condition", "Controller", "Coordinates", "Diffusion", "Event", "Function", "Group",
           "Metric", "Output", "Parameter", "Quantity", "RandomStep", "Scenario", "Sensor", "Shape",
           "System", "Variant"}  # fmt: skip
"""Classes that hold what they are given; the check of the whole system looks at it (tests/models/test_check.py)."""

ABSENT = {"open_result", "read_parameters", "read_scenarios", "save", "verify"}
"""Functions that read a file; these tests have none."""


@pytest.mark.parametrize("name", sorted({*CALLS, *MORE} - ABSENT))
def test_the_other_arguments_are_right(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, arguments = {**CALLS, **MORE}[name][:2]
    try:
        call(**arguments)
    except mehvar.InputError as error:
        assert re.search(r"needs \w+: pip install \w+$", str(error))  # noqa: PT017 - most need no package


def test_every_public_name_is_called():
    functions = {name for name in mehvar.__all__ if inspect.isfunction(getattr(mehvar, name))}
    classes = {name for name in mehvar.__all__ if inspect.isclass(getattr(mehvar, name))}
    methods = {
        f"{name}.{method}"
        for name in ("Model", "Derivation")
        for method, value in vars(getattr(mehvar, name)).items()
        if inspect.isfunction(value) and not method.startswith("_")
    }
    assert functions | methods == CALLS.keys()
    assert classes == RECORDS | {
        "Model",
        "Derivation",
        "InputError",
        "MehvarError",
        "MissingError",
        "ModelError",
        "Trim",
        "TrimError",
        "Fit",
        "Margin",
        "Steering",
        "SteeringError",
        "Tuning",
    }


@pytest.mark.parametrize("name", CALLS)
def test_every_argument_is_tried(name):
    _, arguments = CALLS[name]
    signature = inspect.signature(getattr(mehvar, name) if "." not in name else method(name)).parameters
    named = {p.name for p in signature.values() if p.kind is not p.VAR_KEYWORD and p.name != "self"}
    assert named <= arguments.keys()
    assert arguments.keys() - named <= FREE.get(name, set())


def method(name: str) -> Callable[..., object]:
    part, _, own = name.partition(".")
    return getattr(getattr(mehvar, part), own)


SLOW = ("batch", "build", "diff", "export_fmu", "fit", "steer", "tune")
"""Functions of which the suite gives an argument every eighth value, each argument others; soak gives all."""


@pytest.mark.parametrize(
    ("name", "every"),
    [
        *((name, 8 if name in SLOW else 1) for name in CALLS),
        *(pytest.param(name, 1, marks=pytest.mark.soak) for name in SLOW),
    ],
)
def test_a_value_of_any_kind_is_taken_or_refused_by_name(name, every, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, arguments = CALLS[name]
    try_all(name, call, arguments, {*arguments, *FREE.get(name, ())}, every)


@pytest.mark.parametrize("name", MORE)
def test_so_it_is_in_calls_of_other_kinds(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    try_all(name, *MORE[name])


def try_all(name: str, call: Callable[..., object], arguments: dict[str, Any], tried: set[str], every: int = 1) -> None:
    """Give each of these arguments every value, or every n-th, beside the others."""
    for place, argument in enumerate(sorted(tried)):
        for label, value in [*ODD.items()][place % every :: every]:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    call(**{**arguments, argument: value})
                except mehvar.MehvarError:
                    continue
                except Exception as error:
                    raise AssertionError(f"{name}({argument}={label}): {type(error).__name__}: {error}") from error


def odd_datasets() -> dict[str, Any]:
    """Return results with something in them that not every format has."""
    run = mehvar.simulate(PENDULUM, "pd", t_end=0.1)
    many = mehvar.batch(PENDULUM, "pd", 3, t_end=0.1, vary={"k_p": "normal(16, 0.1)"}, save=0.05)
    result: dict[str, Any] = {
        "a run": run, "a batch": many, "a run of a batch": many.isel(run=0), "an instant": run.isel(t=0),
        "no sample": run.isel(t=slice(0, 0)), "nothing": xr.Dataset(), "a dict": {}, "a variable": run["angle"],
        "another coordinate": run.assign_coords(k=("t", np.arange(len(run.t)))),
        "a table": run.assign(table=(("t", "z"), np.ones((len(run.t), 2)))),
    }  # fmt: skip
    values = [*ODD.values(), "ä", np.datetime64("2026-01-01"), np.arange(3), [1, "a"]]
    for k, value in enumerate(values):
        result[f"attribute {k}"] = run.assign_attrs(odd=value)
        result[f"unit {k}"] = with_attributes(run, units=value)
    result["no unit"] = run.assign(angle=("t", run.angle.values))
    for name in ("ä", "a b", "a/b", "", "1a", "a" * 70, "_a", "units", 3, ("a", "b"), "a\0b", "\udcff", "a\nb"):
        result[f"name {name!r}"] = run.rename(angle=name)
        result[f"attribute {name!r}"] = run.copy()
        result[f"attribute {name!r}"].attrs[name] = "text"
    n = len(run.t)
    for series in (np.array(["a"] * n), np.array([object()] * n), np.ones(n) * 1j, np.ones(n, bool), np.arange(n)):
        result[f"series of {series.dtype}"] = run.assign(extra=("t", series))
        result[f"number of {series.dtype}"] = run.assign(extra=((), series[0]))
    return result


def with_attributes(run: xr.Dataset, **attributes: Any) -> xr.Dataset:
    copy = run.copy()
    copy["angle"].attrs.update(attributes)
    return copy


@pytest.mark.parametrize("ending", [".nc", ".csv", ".parquet", ".arrow", ".mat"])
def test_any_dataset_is_written_or_refused(ending, tmp_path):
    path, written = tmp_path / f"a{ending}", []
    for label, dataset in odd_datasets().items():
        with contextlib.suppress(mehvar.MehvarError), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mehvar.save(dataset, path)
            written.append(label)
        assert path.exists() == (label in written[-1:]), label
        path.unlink(missing_ok=True)
    assert "a run" in written
    assert ("a batch" in written) == (ending == ".nc")
