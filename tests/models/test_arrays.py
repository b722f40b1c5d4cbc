# SPDX-License-Identifier: Apache-2.0
"""Arrays of parameters: tables against SciPy in every backend, matrices, and what is refused of either."""

import dataclasses
import json

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator

import mehvar
from mehvar.base.errors import InputError
from mehvar.codegen.diff import compare
from mehvar.codegen.equations.document import Document
from mehvar.codegen.equations.graph import equations_json
from mehvar.codegen.workspace import ROOMS, installed_tree
from mehvar.models.arrays.constraints import with_arrays
from mehvar.models.quantities import ModelError
from mehvar.models.system import Controller, Function, Group, Interval, System
from mehvar.models.tables import read_parameters
from mehvar.runtime import load, simulate
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.test_clock import pushed, written
from tests.reference.scipy_loop import by_scipy

AT, UP = [0.0, 1.0, 2.5, 3.0, 5.0, 6.0, 8.0], [-1.0, 0.5, 2.0]
PUSH = [0.0, 2.0, 2.0, 2.0, -1.0, -1.5, 0.5]
GRID = [
    [1.0, 2.0, -1.0],
    [0.0, 0.5, 0.5],
    [3.0, 1.0, 1.0],
    [2.0, 2.0, 2.0],
    [0.0, -1.0, 1.0],
    [1.0, 1.0, 0.0],
    [2, 5, 7],
]
ROW = 'bounds = "(-inf, inf)", source = "paper 1", description = "d"'
TOML = f"""
[plant]
at = {{ unit = "m", form = "increasing", default = {AT}, {ROW} }}
up = {{ unit = "m", form = "increasing", default = {UP}, {ROW} }}
push = {{ unit = "m/s", over = ["at"], form = "FORM", outside = "OUTSIDE", default = {PUSH}, {ROW} }}
lift = {{ unit = "m/s", over = ["at", "up"], form = "linear", default = {GRID}, {ROW} }}
J = {{ unit = "kg", form = "positive definite", default = [[3, 1, 0], [1, 2, -1], [0, -1, 2]], {ROW} }}
w = {{ unit = "m", default = [1, 2, 3], {ROW} }}
"""


def read(tmp_path, text):
    path = tmp_path / "parameters.toml"
    path.write_text(text, encoding="utf-8")
    return read_parameters(path)


def tabled(tmp_path, form, outside) -> System:
    """A place x' = push(x) + lift(x, 0.1 x) + a, in tables over the place."""
    x, c = Group("x", (quantity("v", "m"),)), Group("c", (parameter("k", "m/s", 0.3),))
    plant = read(tmp_path, TOML.replace("FORM", form).replace("OUTSIDE", outside))["plant"]
    p = Group("p", (*plant, parameter("Ts", "s", 0.1, POSITIVE)))
    u, energy = Group("u", (quantity("a", "m/s"),)), (p.w.T * p.J * p.w)[0]
    return dataclasses.replace(
        pushed(), name="tabled", states=x, inputs=u, parameters=p, rhs=(u.a + p.push(x.v) + p.lift(x.v, x.v / 10),),
        functions=(Function("spin", (p,), ((quantity("E", "kg m^2"), energy),), "energy"),),
        controllers=(Controller("on", "", c, (c.k,)), Controller("steps", "", c, (c.k,), period="Ts")),
    )  # fmt: skip


@pytest.fixture(scope="module", params=[("linear", "hold"), ("cubic", "hold"), ("linear", "line"), ("cubic", "line")])
def case(request, tmp_path_factory):
    form, outside = request.param
    path = tmp_path_factory.mktemp("tabled")
    return form, outside, written(with_arrays(tabled(path, form, outside)), path)


def expected(form, outside):
    """The rate without the input, by SciPy."""
    curve = PchipInterpolator(AT, PUSH) if form == "cubic" else RegularGridInterpolator([AT], PUSH)
    slope = PchipInterpolator(AT, PUSH).derivative() if form == "cubic" else lambda v: 2.0 if v < 1 else 1.0
    grid = RegularGridInterpolator((AT, UP), GRID)

    def rate(v):
        inside = np.clip(v, AT[0], AT[-1])
        beyond = (v - inside) * slope(inside) if outside == "line" else 0.0
        return float(np.squeeze(curve([inside]))) + beyond + float(grid((inside, np.clip(v / 10, UP[0], UP[-1])))[()])

    return rate


@pytest.mark.parametrize("backend", ["c", "python", "casadi"])
@pytest.mark.share(4)
def test_tables_against_scipy(case, backend):
    form, outside, folder = case
    model, rate = load(folder, backend), expected(form, outside)
    p = model.parameters()
    for v in [*np.linspace(-2, 12, 57), *AT]:
        assert model.rhs([v], [0.0], p)[0] == pytest.approx(rate(v), abs=1e-13)
    for v in np.linspace(-2, 12, 58) + 1e-3:  # not at a point, where a line has two slopes
        slope = (rate(v + 1e-6) - rate(v - 1e-6)) / 2e-6
        assert model.jac_x([v], [0.0], p)[0, 0] == pytest.approx(slope, abs=1e-6)
    assert np.isfinite(model.functions["jac_p"]([2.7], [0.0], p)).all()  # between equal values too


@pytest.mark.share(4)
def test_runs_and_lanes_through_tables(case, tmp_path):
    from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
    from mehvar.runtime.batch.store.store import open_store

    folder = case[2]
    native = simulate(folder, "on", t_end=6.0)
    with by_scipy():
        plain = simulate(folder, "on", t_end=6.0)
    np.testing.assert_allclose(native.x, plain.x, atol=1e-6)
    for law in ("on", "steps"):
        vary = {"push_2": "uniform(1, 3)", "at_3": "uniform(2, 2.9)"}
        mehvar.batch(folder, law, n=9, seed=1, vary=vary, out=tmp_path / f"{law}.zarr")
        store = open_store(tmp_path / f"{law}.zarr")
        plan = plan_of(store, folder)
        assert {difference(repeat_run(plan, store, k), plan, store, k) for k in range(9)} == {""}


@pytest.mark.share(4)
def test_points_that_do_not_increase_and_a_matrix_that_is_not_definite_are_refused_in_a_run(case):
    folder = case[2]
    with pytest.raises(InputError, match=r"the points at must increase: at_2 = 1, at_3 = 0\.5"):
        simulate(folder, "on", parameters={"at_3": 0.5})
    with pytest.raises(InputError, match="the matrix J must be positive definite"):
        simulate(folder, "on", parameters={"J_1_2": 5.0})


def test_a_symmetric_matrix_has_one_parameter_for_two_elements(case):
    model = load(case[2])
    names = [name for name in model.parameter_names if name.startswith("J_")]
    assert names == ["J_1_1", "J_1_2", "J_1_3", "J_2_2", "J_2_3", "J_3_3"]
    matrix, vector = np.array([[3, 1, 0], [1, 2, -1], [0, -1, 2]]), np.array([1, 2, 3])
    assert model.functions["spin"](model.parameters()) == pytest.approx(vector @ matrix @ vector)


@pytest.mark.share(4)
def test_an_array_of_parameters_is_set_as_an_array(case):
    folder, inertia = case[2], np.array([[4.0, 0.5, 0.1], [0.5, 3.0, 0.2], [0.1, 0.2, 2.5]])
    elements = {f"J_{i + 1}_{j + 1}": inertia[i, j] for i in range(3) for j in range(i, 3)}
    model = load(folder)
    np.testing.assert_array_equal(model.parameters(J=inertia), model.parameters(**elements))
    push = np.arange(7.0)
    whole = simulate(folder, "on", push=push, t_end=1.0)
    single = simulate(folder, "on", parameters={f"push_{k + 1}": push[k] for k in range(7)}, t_end=1.0)
    assert whole.parameters.values == single.parameters.values
    store = mehvar.batch(folder, "on", n=2, parameters={"push": push}, t_end=1.0, vary={"k": "uniform(0.2, 0.4)"})
    assert json.loads(store.attrs["campaign"])["parameters"]["push_3"] == 2.0
    for wrong, message in (
        ({"J": inertia[:2]}, "J = .*: must be an array with the elements J_1_1, J_1_2"),
        ({"J": inertia + np.eye(3)[[1, 2, 2]]}, "J = .*: must be symmetric: J_2_1 and J_1_2 differ"),
        ({"w": [1.0, 2.0]}, "w = .*: must be an array with the elements w_1, w_2, w_3"),
        ({"w": [1.0, 2.0, "x"]}, "w_"),
    ):
        with pytest.raises(InputError, match=message):
            simulate(folder, "on", parameters=wrong)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[0.0, 1.0, 2.5", "[0.0, 2.5, 2.5"), r"parameters.toml:3: \[plant.at\]: default = .*: must increase"),
        (("[0.0, 1.0, 2.5", "[0.0, nan, 2.5"), "must increase"),
        (('over = ["at"]', 'over = ["a"]'), r"over = \['a'\]: 'a' must be an array .* \(did you mean 'at'\?\)"),
        (('over = ["at"]', 'over = ["at", "up"]'), "must be 1 names, one for each axis"),
        (('over = ["at"]', 'over = ["w"]'), "'w' must be an array in .* with form = 'increasing'"),
        (
            ("[0.0, 2.0, 2.0, 2.0, -1.0,", "[0.0, 2.0, 2.0, -1.0,"),
            "default has 6 values along 'at', which has 7 points",
        ),
        (
            ("[0.0, 2.0, 2.0, 2.0, -1.0,", "[inf, 2.0, 2.0, 2.0, -1.0,"),
            r"default of push_1 = inf is outside its bounds",
        ),
        (('"FORM"', '"spline"'), "form = 'spline': must be 'linear' or 'cubic'"),
        (('"linear", default = [[', '"cubic", default = [['), "form = 'cubic': must be 'linear'"),
        (('"OUTSIDE"', '"zero"'), "outside = 'zero': must be 'hold' or 'line'"),
        (("[[3, 1, 0]", "[[3, 1, 2]"), "is 2 and"),
        (("[[3, 1, 0]", "[[0, 1, 0]"), "must be positive definite"),
        (("[[3, 1, 0]", "[[3, 1]"), "rows of numbers of equal length"),
        (("[[3, 1, 0], [1,", "[[1,"), "leave it out, since default has the shape"),
        (("default = [1, 2, 3]", "default = []"), "must be numbers"),
        (("default = [1, 2, 3]", 'default = [1, "x"]'), "default"),
        (("default = [1, 2, 3]", 'default = 1, outside = "hold"'), "outside = 'hold' has no effect"),
        (("default = [1, 2, 3]", 'default = [1, 2], outside = "hold"'), "outside = 'hold': must be left out"),
        (("default = [1, 2, 3]", 'default = [1, 2], form = "cubic"'), "form = 'cubic': must be left out or one of"),
    ],
)
def test_what_is_refused_of_an_array(tmp_path, change, message):
    assert change[0] in TOML
    text = TOML.replace(*change, 1).replace("FORM", "linear").replace("OUTSIDE", "hold")
    with pytest.raises(ModelError, match=message):
        read(tmp_path, text)


def test_a_table_is_called_with_one_place_for_each_axis(tmp_path):
    p = read(tmp_path, TOML.replace("FORM", "linear").replace("OUTSIDE", "hold"))["plant"]
    with pytest.raises(ModelError, match=r"places of lift .* one for each axis: at, up"):
        p.lift(sp.Symbol("x"))
    with pytest.raises(ModelError, match="place along at"):
        p.push("x")


def test_numbers_are_read_without_sympy(tmp_path):
    import subprocess
    import sys

    read(tmp_path, TOML.replace("FORM", "linear").replace("OUTSIDE", "hold"))
    code = (
        "import sys, pathlib; from mehvar.models.tables import read_parameters; "
        "read_parameters(pathlib.Path(sys.argv[1])); assert 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "parameters.toml")], check=True)


def test_a_diff_tells_of_a_table_in_one_line(tmp_path):
    """New bounds of all elements are one line, new values of two of them are one."""
    before = tabled(tmp_path, "linear", "hold")
    text = TOML.replace("FORM", "linear").replace("OUTSIDE", "hold")
    text = text.replace("[0.0, 2.0, 2.0, 2.0, -1.0", "[0.0, 2.5, 2.0, 2.0, -1.25")
    plant = read(tmp_path, text)["plant"]
    wide = Interval(-9, 9, True, True)
    wider = [dataclasses.replace(q, bounds=wide) if q.name.startswith("up_") else q for q in plant]
    after = dataclasses.replace(before, parameters=Group("p", (*wider, before.parameters.quantities[-1])))
    sides = []
    for name, system in (("old", before), ("new", after)):
        folder = tmp_path / name
        folder.mkdir()
        written(system, folder)
        sides.append(Document.parse(equations_json(system), load(folder, "python").manifest))
    told = {(c.name, c.what): (c.old, c.new) for c in compare(*sides).parameters}
    assert told == {
        ("push", "value"): ("push_2 = 2.0, push_5 = -1.0", "push_2 = 2.5, push_5 = -1.25"),
        ("up", "bounds"): ("(-inf, inf)", "(-9, 9)"),
    }


def test_generated_files_depend_on_every_module_of_the_vocabulary():
    tree = installed_tree()
    folders = [tree.root / "models", *(tree.root / "models" / room for room in ROOMS)]
    modules = {path.relative_to(tree.root).as_posix() for folder in folders for path in folder.glob("*.py")}
    comparing = {"models/paper.py", "models/notation.py"}  # they write no generated text
    assert "models/arrays/curves.py" in modules
    assert modules - tree.sources(tree.models[0]).keys() == comparing
