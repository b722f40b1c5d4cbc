# SPDX-License-Identifier: Apache-2.0
"""The Lyapunov laws: their derivative identities, published values, and the way to physical inputs."""

import casadi as ca
import numpy as np
import pytest
import sympy as sp

from mehvar.codegen.functions.lower import to_casadi
from mehvar.models.slosh.laws.controllers import collect
from mehvar.models.slosh.plant.reduced import demand
from mehvar.models.slosh.states import DEMAND, rate
from mehvar.models.system import ModelError
from tests.models.slosh.variants import CONVENTIONS, Slosh, slosh, with_values

LAWS = ("lyapunov-v1", "lyapunov-v2")


def law_of(model: Slosh, name: str):
    return next(law for law in model.system.controllers if law.name == name)


def gains(model: Slosh, name: str, rng: np.random.Generator) -> np.ndarray:
    """Return law parameters of like size, so that no term hides behind another."""
    group = law_of(model, name).parameters
    values = {q.name: rng.uniform(0.5, 2.0) for q in group}
    return with_values(group, values | {n: v * 1e-3 for n, v in values.items() if n in ("r9", "r10")})


def named(model: Slosh, name: str, wanted: list[str]) -> ca.Function:
    """Return (x, p, c) -> definitions of the derivation by name."""
    system = model.system
    groups = (system.states, system.parameters, law_of(model, name).parameters)
    vectors = [ca.SX.sym(g.name, len(g)) for g in groups]
    symbols = {s: v[i] for g, v in zip(groups, vectors, strict=True) for i, s in enumerate(g.symbols)}
    result = to_casadi([sp.Symbol(n, real=True) for n in wanted], symbols, system.definitions)
    return ca.Function("named", vectors, [ca.vertcat(*result)])


def along(value, x: np.ndarray, flow: np.ndarray) -> float:
    """Differentiate along a direction by central differences of sixth order."""
    h = 2e-3
    steps = [(value(x + k * h * flow) - value(x - k * h * flow)) / (2 * h * k) for k in (1, 2, 3)]
    return float(1.5 * steps[0] - 0.6 * steps[1] + 0.1 * steps[2])


def coefficients(model: Slosh, name: str, x: np.ndarray, p: np.ndarray, c: np.ndarray):
    """Return A, B, C, f and g of (29)."""
    tag = name[-2:]
    definitions = {s.name for s in model.system.definitions}
    entries = [f"f{i + 1}{j + 1}_{tag}" for i in range(3) for j in range(i + 1)]
    known = ["A", "B", "C", "g1", "g2", "g3"]
    wanted = [f"{n}_{tag}" for n in known] + [e for e in entries if e in definitions]
    values = dict(zip(wanted, np.array(named(model, name, wanted)(x, p, c)).ravel(), strict=True))
    f = np.zeros((3, 3))
    for i in range(3):
        for j in range(i + 1):
            f[i, j] = f[j, i] = values.get(f"f{i + 1}{j + 1}_{tag}", 0.0)
    A, B, C, *g = (values[f"{n}_{tag}"] for n in known)
    return A, B, C, f, np.array(g)


@pytest.mark.parametrize("inertia", CONVENTIONS)
@pytest.mark.parametrize("name", LAWS)
def test_derivative_has_the_form_29_for_any_input(inertia, name):
    """V' along the reduced model, under the inputs of the other law, by differences."""
    model, rng = slosh("2", inertia), np.random.default_rng(30)
    other = LAWS[1 - LAWS.index(name)]
    loop = model.functions[f"{other.replace('-', '_')}_loop_reduced"]
    value = model.functions[f"{name.replace('-', '_')}_value"]
    for _ in range(5):
        x, _, p = model.sample(rng)
        c, c2 = gains(model, name, rng), gains(model, other, rng)
        u = model.functions[f"{other.replace('-', '_')}_demand"](x, p, c2)[:5]
        A, B, C, f, g = coefficients(model, name, x, p, c)
        expected = A + B * u[0] + C * u[1] + (f @ u[2:] + g) @ x[3:6]
        result = along(lambda y, c=c, p=p: value(y, p, c)[0], x, loop(x, np.zeros(0), p, c2))
        assert result == pytest.approx(expected, rel=1e-9, abs=1e-9 * abs(value(x, p, c)[0]))


@pytest.mark.parametrize("inertia", CONVENTIONS)
@pytest.mark.parametrize("name", LAWS)
def test_law_leaves_squares_only(inertia, name):
    """V' = A - w1 B^2 - w2 C^2 - w3 W1^2 - w4 W2^2 - w5 W3^2 along the closed reduced loop."""
    model, rng = slosh("2", inertia), np.random.default_rng(31)
    text = name.replace("-", "_")
    loop, value = model.functions[f"{text}_loop_reduced"], model.functions[f"{text}_value"]
    group = law_of(model, name).parameters
    for _ in range(5):
        x, _, p = model.sample(rng)
        c = gains(model, name, rng)
        w = np.array([c[[q.name for q in group].index(f"w{k}")] for k in range(1, 6)])
        A, B, C, _, _ = coefficients(model, name, x, p, c)
        squares = w @ np.array([B**2, C**2, *x[3:6] ** 2])
        result = along(lambda y, c=c, p=p: value(y, p, c)[0], x, loop(x, np.zeros(0), p, c))
        assert result == pytest.approx(A - squares, rel=1e-9, abs=1e-9 * abs(value(x, p, c)[0]))
        if name == "lyapunov-v2":
            assert A == 0
            assert result < 0


def test_matrix_of_the_law_is_symmetric_as_derived():
    model, rng = slosh(), np.random.default_rng(32)
    x, _, p = model.sample(rng)
    c = gains(model, "lyapunov-v1", rng)
    _, _, _, f, _ = coefficients(model, "lyapunov-v1", x, p, c)
    assert np.all(np.linalg.eigvalsh(f) > 0)


def test_a_value_that_omega_prime_enters_alone_is_refused():
    with pytest.raises(ModelError, match="it is not of the form"):
        collect(sp.Symbol("x", real=True) * demand[2] + rate[0] * demand[3])


def start(model: Slosh) -> np.ndarray:
    p, s = model.p, with_values(model.system.scenario_parameters, {})
    return model.functions["initial"](p, s)


def test_demand_at_the_start_of_the_papers_run():
    model = slosh()
    x = start(model)
    v2 = model.functions["lyapunov_v2_demand"](x, model.p, model.law("lyapunov-v2"))
    np.testing.assert_allclose(v2[:5], [-0.6, -0.2, -0.17453293, -0.06993317, 0.17489293], atol=5e-9)
    v1 = model.functions["lyapunov_v1_demand"](x, model.p, model.law("lyapunov-v1"))
    assert np.max(np.abs(v1[2:5] - v2[2:5])) < 5e-7
    np.testing.assert_allclose(v1[:2], v2[:2], atol=1e-12)


def test_initial_state_of_the_ball_joint_is_the_same_place():
    angles, joint = start(slosh()), start(slosh("2", "ball"))
    for k, (phi, theta) in enumerate(((angles[9], angles[10]), (angles[11], angles[12]))):
        s = joint[9 + 6 * k : 12 + 6 * k]
        expected = [-np.cos(phi), np.sin(phi) * np.sin(theta), np.sin(phi) * np.cos(theta)]
        np.testing.assert_allclose(s, expected, atol=1e-15)
        np.testing.assert_allclose(joint[12 + 6 * k : 15 + 6 * k], 0, atol=1e-15)


def feasible(model: Slosh, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    x, _, p = model.sample(rng)
    slow = x.copy()
    slow[3:] *= 0.3
    if model.convention == "ball":
        slow[9:] = x[9:]
        slow[12:15], slow[18:21] = 0.3 * x[12:15], 0.3 * x[18:21]
    return slow, np.array([*rng.uniform(-0.4, 0.4, 2), *rng.uniform(-0.2, 0.2, 3)]), p


@pytest.mark.parametrize("inertia", CONVENTIONS)
@pytest.mark.parametrize("pendulums", ["1", "2", "6"])
@pytest.mark.share(2)
def test_physical_inputs_bring_about_the_demand(inertia, pendulums):
    if inertia == "ball":
        pendulums = "2"
    model, rng = slosh(pendulums, inertia), np.random.default_rng(33)
    reached = 0
    for _ in range(20):
        x, wanted, p = feasible(model, rng)
        u = model.functions["to_physical"](x, wanted, p)
        produced = model.functions["outputs"](x, u, np.zeros(0), p)[:5]
        if np.max(np.abs(np.sin(u[3:]))) < 0.999:
            reached += 1
            np.testing.assert_allclose(produced, wanted, atol=1e-8)
    assert reached > 10


def test_an_infeasible_demand_keeps_the_body_rates_and_reports_the_excess():
    model = slosh()
    x, p = start(model), model.p
    wanted = np.array([3.0, -1.0, 0.1, -0.05, 0.02])
    u = model.functions["to_physical"](x, wanted, p)
    assert np.all(np.isfinite(u))
    produced = model.functions["outputs"](x, u, np.zeros(0), p)
    np.testing.assert_allclose(produced[2:5], wanted[2:], atol=1e-9)
    assert produced[0] < wanted[0] - 0.5
    names = [q.name for q in law_of(model, "lyapunov-v2").parameters]
    c = model.law("lyapunov-v2")
    lateral, excess = model.functions["lyapunov_v2_demand"](x, p, c)[5:]
    assert 0 < lateral < model.p[model.position("F")]
    assert excess == 0
    c[names.index("w1")] = 1e5
    lateral, excess = model.functions["lyapunov_v2_demand"](x, p, c)[5:]
    assert excess == pytest.approx(lateral - 2450, rel=1e-12)
    assert excess > 1000


def test_gimbal_limits_keep_the_body_rates():
    model, rng = slosh(), np.random.default_rng(34)
    limits = {"delta1_max": 0.1, "delta2_max": 0.2}
    for _ in range(10):
        x, _, _ = model.sample(rng)
        command = np.array([*rng.uniform(-500, 500, 3), *rng.uniform(-0.9, 0.9, 2)])
        free, limited = model.parameters(), model.parameters(**limits)
        acting = model.functions["actuate"](x, command, limited)
        assert abs(acting[3]) <= 0.1
        assert abs(acting[4]) <= 0.2
        wanted = model.functions["rhs"](x, command, free)[3:6]
        np.testing.assert_allclose(model.functions["rhs"](x, acting, free)[3:6], wanted, atol=1e-10)
        np.testing.assert_array_equal(model.functions["actuate"](x, command, free), command)


def test_delta1_serves_the_z_force_that_delta2_leaves():
    model = slosh()
    x = start(model)
    p = model.parameters(delta2_max=0.3)
    command = np.array([0.0, 0.0, 0.0, 0.2, 0.8])
    acting = model.functions["actuate"](x, command, p)
    assert acting[4] == 0.3
    assert np.sin(acting[3]) * np.cos(acting[4]) == pytest.approx(np.sin(0.2) * np.cos(0.8), rel=1e-12)


def margins(model: Slosh, name: str, **values: float) -> np.ndarray:
    s = with_values(model.system.scenario_parameters, {})
    group = law_of(model, name).parameters
    own = {n: v for n, v in values.items() if n in [q.name for q in group]}
    plant = {n: v for n, v in values.items() if n not in own}
    return model.functions[f"{name.replace('-', '_')}_constraints"](
        model.parameters(**plant), with_values(group, own), s
    )


def test_laws_refuse_what_they_divide_by():
    model = slosh()
    assert np.all(margins(model, "lyapunov-v1") > 0)
    assert np.all(margins(model, "lyapunov-v2") > 0)
    assert margins(model, "lyapunov-v1", F=0.0)[0] <= 0
    assert margins(model, "lyapunov-v2", F=0.0)[0] <= 0
    assert margins(model, "lyapunov-v1", r9=100.0)[1] <= 0
    assert "divides by F" in law_of(model, "lyapunov-v2").constraints[0].message


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"J_x": 900.0}, "no moments of inertia"),
        ({"phi1_0": 30.0}, "angles are given in radians"),
        ({"att3_0": -5.0 * 2}, "angles are given in radians"),
    ],
)
def test_bad_numbers_are_explained(values, said):
    model = slosh()
    plant = {n: v for n, v in values.items() if n in [q.name for q in model.system.parameters]}
    begun = {n: v for n, v in values.items() if n not in plant}
    s = with_values(model.system.scenario_parameters, begun)
    result = model.functions["constraints"](model.parameters(**plant), s)
    refused = [c.message for c, margin in zip(model.system.constraints, result, strict=True) if margin <= 0]
    assert len(refused) == 1
    assert said in refused[0]


@pytest.mark.parametrize("name", ["m", "m1", "l2", "I1"])
def test_parameters_that_must_be_positive(name):
    (parameter,) = (q for q in slosh().system.parameters if q.name == name)
    assert 0.0 not in parameter.bounds
    assert 1e-9 in parameter.bounds


def test_a_point_bob_is_allowed_on_a_ball_joint_only():
    (parameter,) = (q for q in slosh("2", "ball").system.parameters if q.name == "I1")
    assert 0.0 in parameter.bounds
    x, u, p = slosh("2", "ball").sample(np.random.default_rng(35))
    p[[slosh("2", "ball").position(n) for n in ("I1", "I2")]] = 0
    assert np.all(np.isfinite(slosh("2", "ball").functions["rhs"](x, u, p)))


def test_demand_is_the_input_of_the_reduced_model():
    model = slosh()
    x, _, p = model.sample(np.random.default_rng(36))
    c = model.law("lyapunov-v2")
    u = model.functions["lyapunov_v2_demand"](x, p, c)[: len(DEMAND)]
    dx = model.functions["lyapunov_v2_loop_reduced"](x, np.zeros(0), p, c)
    np.testing.assert_allclose(dx[1:3] + np.cross(x[3:6], x[:3])[1:], u[:2], atol=1e-12)
    np.testing.assert_allclose(dx[3:6], u[2:], atol=1e-12)
