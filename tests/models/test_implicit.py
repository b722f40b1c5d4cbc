# SPDX-License-Identifier: Apache-2.0
"""Mass matrices: rates that are solved for, algebraic states against closed forms, and what is refused by name."""

import contextlib
import dataclasses
import random
import re
import threading

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.base.errors import InputError
from mehvar.codegen.functions.verify import VerificationError, verify
from mehvar.models.check import check
from mehvar.models.forms import with_mass
from mehvar.models.forms.elimination import SingularError, factors
from mehvar.models.quantities import ModelError
from mehvar.models.system import Controller, Group, System
from mehvar.runtime import load, simulate
from mehvar.runtime.batch.blocks import IMPOSSIBLE
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.board.image.build import program
from mehvar.web.export import export_web
from tests.models.edits import POSITIVE, cart, parameter, quantity, turner
from tests.models.test_clock import pushed, written


def random_matrix(n, symmetric, rng):
    matrix = rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.5)
    matrix = matrix + matrix.T if symmetric else matrix
    return matrix + n * np.eye(n)[:, :: 1 if symmetric else -1]  # pivots on the diagonal, or none there


@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("n", [1, 2, 5, 8])
@pytest.mark.share(2)
def test_factors_solve(n, symmetric):
    rng = np.random.default_rng(n)
    numbers, right = random_matrix(n, symmetric, rng), rng.normal(size=n)
    matrix = sp.Matrix(
        n, n, lambda i, j: sp.Symbol(f"m_{sorted((i, j)) if symmetric else (i, j)}") if numbers[i, j] else 0
    )
    values = {matrix[i, j]: numbers[i, j] for i in range(n) for j in range(n) if numbers[i, j]}

    def define(*row):
        symbol = sp.Symbol(str(row[:-1]))
        values[symbol] = float(row[-1].subs(values))
        return symbol

    x = factors(matrix, define).solution([sp.Float(number) for number in right], define)
    np.testing.assert_allclose(numbers @ [values[symbol] for symbol in x], right, atol=1e-12)


def test_zeros_cost_nothing():
    """An arrow with its point first would fill in; it is taken last."""
    n, names = 6, []
    arrow = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"m_{i}{j}") if i == j or 0 in (i, j) else 0)
    result = factors(arrow, lambda *row: names.append(row) or row[-1])
    assert result.pivots.index((0, 0)) >= n - 2
    assert (len(result.lower), len(result.upper)) == (n - 1, 2 * n - 1)


@pytest.mark.parametrize("matrix", [[[1, 1], [1, 1]], [[0, 0], [0, 1]], [[1, 1, 0], [2, 3, 0], [4, 5, 0]]])
def test_a_singular_matrix_has_no_factors(matrix):
    with pytest.raises(SingularError):
        factors(sp.Matrix(matrix), lambda *row: row[-1])


def motor(mass=None) -> System:
    """A motor whose current has no inductance: J w' = k i - b w, 0 = v - R i - k w - z i^3."""
    x, u = Group("x", (quantity("i", "A"), quantity("w", "rad/s"))), Group("u", (quantity("v", "V"),))
    rows = (("J", "kg m^2", 0.01), ("k", "N m/A", 0.05), ("b", "N m s", 0.001), ("R", "Ohm", 2.0), ("z", "V/A^3", 0.0))
    p = Group("p", (*(parameter(*row) for row in rows), parameter("Ts", "s", 0.1, POSITIVE)))
    s, c = Group("s", (parameter("i_0", "A", 6.0),)), Group("c", (parameter("V", "V", 12.0),))
    return dataclasses.replace(
        pushed(), name="motor", states=x, inputs=u, parameters=p, scenario_parameters=s, initial=(s.i_0, sp.S.Zero),
        mass=sp.diag(0, p.J) if mass is None else mass(p),
        rhs=(u.v - p.R * x.i - p.k * x.w - p.z * x.i**3, p.k * x.i - p.b * x.w),
        outputs=Group("y", (quantity("heat", "W"),)), output=(p.R * x.i**2,),
        controllers=(Controller("on", "", c, (c.V,)), Controller("steps", "", c, (c.V,), period="Ts")),
    )  # fmt: skip


def robertson() -> System:
    """Robertson's reaction, whose third row is that nothing is lost; time in tens of seconds keeps numbers near one."""
    names = ("y_1", "y_2", "y_3")
    x, u = Group("x", tuple(quantity(name, "1") for name in names)), Group("u", (quantity("feed", "1/s"),))
    rows = (("k_1", "1/s", 0.04), ("k_2", "1/s", 3e7), ("k_3", "1/s", 1e4), ("Ts", "s", 1.0, POSITIVE))
    p, c = Group("p", tuple(parameter(*row) for row in rows)), Group("c", (parameter("supply", "1/s", 0.0),))
    slow, fast = p.k_1 * x.y_1 - p.k_3 * x.y_2 * x.y_3, p.k_2 * x.y_2**2
    return dataclasses.replace(
        pushed(), name="robertson", states=x, inputs=u, parameters=p, initial=(sp.S.One, sp.S.Zero, sp.S.Zero),
        mass=sp.diag(1, 1, 0), rhs=(u.feed - slow, slow - fast, x.y_1 + x.y_2 + x.y_3 - 1),
        controllers=(Controller("on", "", c, (c.supply,)), Controller("steps", "", c, (c.supply,), period="Ts")),
    )  # fmt: skip


def folder_of(system, path):
    """Check and write a system; what is checked is the text's, what is written its solved form."""
    check(system)
    verify(with_mass(system))
    return written(with_mass(system), path)


@pytest.fixture(scope="module")
def motored(tmp_path_factory):
    return folder_of(motor(), tmp_path_factory.mktemp("motor"))


@pytest.mark.parametrize(("off", "good"), [(1e-9, True), (1e-7, False)])
def test_a_start_is_held_to_its_equation_as_the_tolerances_hold_a_step(motored, off, good):
    """Relative to its size, in a run and in a batch: six million amperes are not told to 1e-11 of one."""
    values = {"V": 1.2e7, "i_0": 6e6 * (1 + off)}
    options = {"method": "rodas5p", "rtol": 1e-8, "t_end": 0.01, "dt_out": 0.01}
    runs = mehvar.batch(motored, "on", n=2, parameters=values, **options)
    assert (runs["status"].values != IMPOSSIBLE).all() == good
    with contextlib.nullcontext() if good else pytest.raises(InputError, match="initial state i"):
        simulate(motored, "on", parameters=values, **options)


def turned(t, J=0.01):
    rate = (0.05**2 / 2 + 0.001) / J
    return 0.05 * 12 / 2 / J / rate * (1 - np.exp(-rate * t))


@pytest.mark.parametrize("backend", ["c", "python", "casadi"])
@pytest.mark.parametrize("law", ["on", "steps"])
def test_an_algebraic_state(motored, backend, law):
    """It is what its equation says at every sample, and the motion is that of the equation without it."""
    run = simulate(motored, law, backend=backend, method="rodas5p", rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(run.x[:, 1], turned(run.t), atol=1e-8)
    np.testing.assert_allclose(run.x[:, 0], (12 - 0.05 * run.x[:, 1]) / 2, atol=1e-9)


def test_an_algebraic_state_in_lanes(motored, tmp_path):
    options = {"method": "rodas5p", "rtol": 1e-9, "atol": 1e-9}
    for law in ("on", "steps"):
        mehvar.batch(
            motored, law, n=9, seed=1, vary={"J": "uniform(0.005, 0.02)"}, out=tmp_path / f"{law}.zarr", **options
        )
        store = open_store(tmp_path / f"{law}.zarr")
        plan = plan_of(store, motored)
        assert {difference(repeat_run(plan, store, k), plan, store, k) for k in range(9)} == {""}


def test_robertsons_reaction(tmp_path):
    """Source of the numbers: Hairer & Wanner II, 2nd ed., section IV.1 has the problem; these are of the test set for
    initial value problem solvers, at 40 s."""
    folder = folder_of(robertson(), tmp_path)
    for backend in ("c", "python"):
        run = simulate(folder, "on", method="rodas5p", backend=backend, rtol=1e-9, atol=1e-12, t_end=40.0, dt_out=1.0)
        np.testing.assert_allclose(run.x[-1], [0.7158270687, 9.185534764e-6, 0.2841637457], rtol=1e-7)
        assert np.abs(run.x.sum(axis=1) - 1).max() < 1e-11


def jumping(folder, command, **fields):
    """Write a motor whose command changes sign with its angle."""
    system, c = motor(), Group("c", (parameter("V", "V", 12.0),))
    sign = sp.sign(sp.sin(system.states.w * system.parameters.Ts * 10))
    wave = Controller("steps", "", c, (c.V * command(sign),), period="Ts")
    return folder_of(dataclasses.replace(system, controllers=(wave,), **fields), folder)


def test_a_nonlinear_equation_after_a_jump_of_its_input(tmp_path):
    """A command that jumps at each sample moves the algebraic state at once."""
    folder = jumping(tmp_path, lambda sign: sign)
    options = {"method": "rodas5p", "parameters": {"z": 0.05}, "initial": {"w": 6.2}, "rtol": 1e-9, "atol": 1e-9}
    for backend in ("c", "python"):
        run = simulate(folder, "steps", backend=backend, **options)
        i, w, v = run.x[1:, 0], run.x[1:, 1], run.u[:-1, 0]
        assert np.ptp(v) == 24
        np.testing.assert_allclose(v - 2 * i - 0.05 * w - 0.05 * i**3, 0, atol=1e-7)


def test_a_jump_that_is_far_from_its_solution_is_solved(tmp_path):
    """From 1 to 1.95 times the other way, the first correction of a cubic ends where the slope is nearly zero."""
    folder = jumping(tmp_path, lambda sign: sp.Rational(1475, 1000) * sign - sp.Rational(475, 1000))
    i, options = (12 / 5) ** (1 / 3), {"method": "rodas5p", "rtol": 1e-9, "atol": 1e-9}
    run = simulate(folder, "steps", parameters={"z": 5.0, "R": 1e-3}, initial={"w": 6.2, "i": i}, **options)
    assert run.status.complete
    v, i, w = run.u[0, 0], run.x[1, 0], run.x[1, 1]
    assert v < 0
    assert v - 1e-3 * i - 0.05 * w - 5 * i**3 == pytest.approx(0, abs=1e-6)


def test_a_jump_after_which_no_value_solves_the_equation_ends_the_run(tmp_path):
    x, p = motor().states, motor().parameters
    either = motor().inputs.v - p.R * sp.sqrt(x.i**2) - p.z * x.i**3 - p.k * x.w
    folder = jumping(tmp_path, lambda sign: sign, rhs=(either, p.k * x.i - p.b * x.w))
    runs, initial = [], {"w": 6.2, "i": 5.845}

    def call():
        runs.append(simulate(folder, "steps", method="rodas5p", initial=initial))

    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    thread.join(10.0)
    assert runs
    assert not runs[0].status.complete


@pytest.mark.parametrize("method", ["rk4", "dopri5", "dop853", "rock4"])
@pytest.mark.parametrize("backend", ["c", "python"])
def test_explicit_methods_are_refused_by_name(motored, method, backend):
    with pytest.raises(InputError, match=f"method = '{method}'.* rodas5p: motor has algebraic states"):
        simulate(motored, "on", method=method, backend=backend)


def test_an_explicit_method_is_refused_in_a_batch(motored, tmp_path):
    with pytest.raises(InputError, match="motor has algebraic states"):
        mehvar.batch(motored, "on", n=2, seed=1, vary={"J": "uniform(0.005, 0.02)"}, out=tmp_path / "b.zarr")


def test_what_is_not_consistent_is_refused_by_name(motored):
    with pytest.raises(InputError, match=r"initial state i = 5.* about 6, the solution of its algebraic equation"):
        simulate(motored, "on", method="rodas5p", parameters={"i_0": 5.0})


def test_the_value_that_a_refusal_names_is_accepted(motored):
    rng = np.random.default_rng(3)
    for _ in range(20):
        values = {"z": rng.uniform(0, 5), "i_0": rng.uniform(-50, 50)}
        with pytest.raises(InputError, match="solution of its algebraic equation") as refusal:
            simulate(motored, "on", method="rodas5p", parameters=values)
        named = float(re.search(r"must be about (\S+), the", str(refusal.value))[1])
        assert values["z"] * named**3 + 2 * named == pytest.approx(12, rel=1e-7)
        assert simulate(motored, "on", method="rodas5p", z=values["z"], initial={"i": named}).status.complete


def test_an_equation_that_no_value_satisfies_is_called_that(tmp_path):
    system = motor()
    nowhere = system.inputs.v + system.parameters.R * sp.sqrt(system.states.i**2)
    curved = system.parameters.z * system.states.i**3 + system.parameters.k * system.states.w
    folder = folder_of(dataclasses.replace(system, rhs=(nowhere + curved, system.rhs[1])), tmp_path)
    with pytest.raises(InputError, match=r"initial state i = 6.*Newton's method found none from here"):
        simulate(folder, "on", method="rodas5p")


def test_runs_of_a_batch_that_are_not_consistent_are_impossible(motored, tmp_path):
    vary = {"i_0": "uniform(5, 7)"}
    mehvar.batch(motored, "on", n=5, seed=1, vary=vary, out=tmp_path / "b.zarr", method="rodas5p")
    store = open_store(tmp_path / "b.zarr")
    assert set(np.asarray(store.read("status"))) == {IMPOSSIBLE}


def test_what_takes_rows_of_rhs_for_rates_refuses_algebraic_states(motored, tmp_path):
    model = load(motored, "c")
    takers = (
        lambda: model.linearize([0.0, 0.0], [0.0], model.parameters()),
        lambda: model.linearize([0.0, 0.0], None, model.parameters(), controller="on"),
        lambda: model.as_solve_ivp(u=[0.0]),
        lambda: mehvar.export_fmu(motored, tmp_path / "motor.fmu"),
        lambda: export_web(motored, tmp_path / "page"),
        lambda: program(model, "steps"),
    )
    for taker in takers:
        with pytest.raises(InputError, match=r"motor has algebraic states, which .* cannot have"):
            taker()
    assert list(tmp_path.iterdir()) == []


def test_a_rest_is_where_the_equations_hold(motored):
    """`trim` looks for a zero of every row, which is right for both kinds."""
    model = load(motored)
    x, _, residual = mehvar.trim(model, fix={"v": 12.0}, free=["i", "w"], steady=["i", "w"])
    np.testing.assert_allclose(x, [(12 - 0.05 * x[1]) / 2, turned(1e9)], rtol=1e-9)
    assert np.abs(residual).max() < 1e-9


def refused(system, message):
    def derived():
        check(system)
        with_mass(system)

    with pytest.raises(ModelError, match=message) as error:
        derived()
    assert re.match(r".*\.py:\d+: ", str(error.value))


@pytest.mark.parametrize(
    ("mass", "message"),
    [
        (
            lambda p: sp.diag(p.J, p.J, 1),
            r"mass has the shape \(3, 3\): must have a row and a column for each of the 2",
        ),
        (lambda _: sp.zeros(2), "mass is zero"),
        (lambda p: sp.Matrix([[0, 0], [p.R, p.J]]), "the row of 'i' is zero and its column is not"),
        (lambda p: sp.Matrix([[0, p.J], [0, p.J]]), "the column of 'i' is zero and its row is not"),
        (lambda p: sp.Matrix([[1, 1], [1, 1]]) * p.J, "mass"),
        (lambda p: sp.diag(0, p.J * p.R), r"mass, row 2 of 2.* have different units"),
        (lambda p: sp.diag(0, sp.Symbol("stranger")), "'stranger' belongs to no group"),
    ],
)
def test_what_is_refused_of_a_mass(mass, message):
    refused(motor(mass), message)


def test_rates_that_are_said_twice_are_refused():
    system = motor()
    refused(dataclasses.replace(cart(), mass=sp.eye(2)), r"choices \(.*\) cannot be combined with a mass matrix")
    refused(dataclasses.replace(turner(), mass=sp.eye(2)), "a regular chart cannot be combined with a mass matrix")
    rate = sp.Symbol("w_rate", real=True)
    refused(
        dataclasses.replace(system, rates={"w": rate}, residual=(rate,)),
        "rates and residual cannot be combined with a mass matrix",
    )


def test_a_pivot_that_is_zero_is_found_in_numbers():
    """Its zeros do not tell: J - J is not zero for its places, and neither is a difference of products."""
    p = motor().parameters
    with pytest.raises((ModelError, VerificationError), match="singular"):
        verify(with_mass(motor(lambda p: sp.Matrix([[p.J, p.J], [p.J, p.J]]))))
    assert p


def test_a_system_without_a_mass_is_itself():
    assert with_mass(cart()) is not None
    system = cart()
    assert with_mass(system) is system


def test_an_edited_mass_is_refused_with_its_place_or_solves():
    """Any entry may become anything: what passes every check has rates that solve the equations as they stand."""
    draw, accepted, refusals = random.Random(5), 0, []
    for base in (motor(), motor(lambda p: sp.diag(p.J * p.k / p.R, p.J)), robertson()):
        symbols = [*base.states.symbols, *base.inputs.symbols, *base.parameters.symbols, sp.Symbol("stranger")]
        numbers = [sp.S.Zero, sp.S.One, sp.Rational(-3, 2), sp.nan, sp.oo, sp.I, sp.sign(symbols[0])]
        for _ in range(40):
            mass = sp.Matrix(base.mass)
            for _ in range(draw.choice((1, 2))):
                mass[draw.randrange(mass.rows), draw.randrange(mass.cols)] = draw.choice([*symbols, *numbers])
            system = dataclasses.replace(base, mass=mass)
            try:
                check(system)
                verify(with_mass(system))
                accepted += 1
            except (ModelError, VerificationError) as error:
                refusals.append(str(error))
    assert accepted > 5
    assert [text for text in refusals if not re.match(r".*\.py:\d+: ", text)] == []
