# SPDX-License-Identifier: Apache-2.0
"""Balances, symmetries and limits that a wrong term in the equations of motion breaks."""

import re

import casadi as ca
import numpy as np
import pytest

from mehvar.models.system import Parameter
from tests.models.slosh.variants import CONVENTIONS, Slosh, slosh
from tests.reference import reference_slosh as reference

SAMPLES = 8


def along_flow(model: Slosh, name: str, x: np.ndarray, u: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Differentiate energy or momentum along the right-hand side, exactly."""
    graph = model.functions.graph(name)
    state, parameters = ca.SX.sym("x", len(x)), ca.SX.sym("p", len(p))
    slope = ca.Function(
        "slope", [state, parameters], [ca.jacobian(ca.vertcat(*graph.call([state, parameters])), state)]
    )
    return np.array(slope(x, p)) @ model.functions["rhs"](x, u, p)


def dissipated(model: Slosh, x: np.ndarray, p: np.ndarray) -> float:
    craft, motion = reference.spacecraft(p), model.motion(x)
    if model.convention == "ball":
        slips = motion.qd - np.cross(motion.W, motion.q)
        return sum(bob.eps * (slip @ slip) for bob, slip in zip(craft.pendulums, slips, strict=True))
    return sum(bob.eps * (rates @ rates) for bob, rates in zip(craft.pendulums, motion.qd, strict=True))


@pytest.fixture(params=CONVENTIONS)
def model(request):
    return slosh("2", request.param)


def test_power_balance(model):
    rng = np.random.default_rng(10)
    for _ in range(SAMPLES):
        x, u, p = model.sample(rng)
        thrust, moment = reference.loads(reference.spacecraft(p), u)
        loss = dissipated(model, x, p)
        assert loss > 0
        expected = thrust @ x[:3] + moment @ x[3:6] - loss
        (result,) = along_flow(model, "energy", x, u, p)
        assert result == pytest.approx(expected, rel=1e-11, abs=1e-9 * np.linalg.norm(thrust) * np.linalg.norm(x[:3]))


def test_linear_and_angular_momentum(model):
    rng = np.random.default_rng(11)
    for _ in range(SAMPLES):
        x, u, p = model.sample(rng)
        thrust, moment = reference.loads(reference.spacecraft(p), u)
        momentum = model.functions["momentum"](x, p)
        change = along_flow(model, "momentum", x, u, p)
        V, W, linear, angular = x[:3], x[3:6], momentum[:3], momentum[3:]
        scale = np.linalg.norm(change)
        np.testing.assert_allclose(change[:3] + np.cross(W, linear), thrust, atol=1e-11 * scale)
        np.testing.assert_allclose(change[3:] + np.cross(W, angular) + np.cross(V, linear), moment, atol=1e-11 * scale)


def test_accelerations_do_not_depend_on_the_velocity(model):
    rng = np.random.default_rng(12)
    x, u, p = model.sample(rng)
    shifted = x.copy()
    shifted[:3] += [2000.0, -300.0, 70.0]
    np.testing.assert_allclose(model.accelerations(shifted, u, p), model.accelerations(x, u, p), rtol=1e-9, atol=1e-9)


def mirror_defect(model: Slosh, x: np.ndarray, u: np.ndarray, p: np.ndarray) -> float:
    y, v = mirror(model, x, u)
    image, _ = mirror(model, model.functions["rhs"](x, u, p), u)
    return float(np.max(np.abs(model.functions["rhs"](y, v, p) - image)))


def mirror(model: Slosh, x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turn y into -y, in a state or its rate."""
    flips = {"vy", "wx", "wz", "att1", "att3"}
    for k in range(1, model.count + 1):
        flips |= {f"theta{k}", f"theta{k}_dot", f"s{k}y", f"sigma{k}y"}
    sign = np.array([-1.0 if q.name in flips else 1.0 for q in model.system.states])
    return sign * x, u * np.array([-1, 1, -1, 1, -1])


@pytest.mark.parametrize("inertia", ["hinge", "ball"])
def test_mirror(inertia):
    model = slosh("2", inertia)
    x, u, p = model.sample(np.random.default_rng(13))
    assert mirror_defect(model, x, u, p) < 1e-9


def test_the_papers_rotors_break_the_mirror():
    model = slosh("2", "paper")
    x, u, p = model.sample(np.random.default_rng(13))
    assert mirror_defect(model, x, u, p) > 1e-3


def test_permutation_of_pendulums(model):
    x, u, p = model.sample(np.random.default_rng(14))
    names = [q.name for q in model.system.states]
    swap = {"1": "2", "2": "1"}

    def other(name: str) -> str:
        return re.sub(r"(?<=[a-zI])[12](?![0-9])", lambda m: swap[m[0]], name)

    order = [names.index(other(n)) if re.match(r"phi|theta|s\d|sigma", n) else k for k, n in enumerate(names)]
    parameters = [q.name for q in model.system.parameters]
    own = [parameters.index(other(n)) if re.fullmatch(r"(m|l|h|I|eps)[12]", n) else k for k, n in enumerate(parameters)]
    result = model.functions["rhs"](x[order], u, p[own])
    np.testing.assert_allclose(result[order], model.functions["rhs"](x, u, p), rtol=1e-11, atol=1e-9)


def bob_places(model: Slosh, k: int) -> list[int]:
    """Return the places of pendulum k in the state."""
    pattern = rf"(phi|theta){k}(_dot)?|(s|sigma){k}[xyz]"
    return [i for i, q in enumerate(model.system.states) if re.fullmatch(pattern, q.name)]


@pytest.mark.parametrize("inertia", CONVENTIONS)
def test_a_pendulum_may_be_split_in_two(inertia):
    one, two = slosh("1", inertia), slosh("2", inertia)
    x, u, p = one.sample(np.random.default_rng(15))
    y = np.zeros(len(two.system.states))
    y[:9] = x[:9]
    for k in (1, 2):
        y[bob_places(two, k)] = x[bob_places(one, 1)]
    m, length, h, inertia_, eps = p[-5:]
    half = np.array([m / 2, length, h, inertia_ / 2, eps / 2])
    expected = one.functions["rhs"](x, u, p)
    result = two.functions["rhs"](y, u, np.concatenate([p[:-5], half, half]))
    np.testing.assert_allclose(result[:9], expected[:9], rtol=1e-11, atol=1e-9)
    for k in (1, 2):
        np.testing.assert_allclose(result[bob_places(two, k)], expected[bob_places(one, 1)], rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("inertia", CONVENTIONS)
def test_a_pendulum_without_mass_has_no_effect(inertia):
    one, two = slosh("1", inertia), slosh("2", inertia)
    x, u, p = two.sample(np.random.default_rng(16))
    for name in ("m2", "I2", "eps2"):
        p[two.position(name)] *= 1e-13
    y = np.concatenate([x[:9], x[bob_places(two, 1)]])
    expected = one.functions["rhs"](y, u, p[:-5])
    result = two.functions["rhs"](x, u, p)
    np.testing.assert_allclose(result[:9], expected[:9], rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(result[bob_places(two, 1)], expected[9:], rtol=1e-9, atol=1e-8)


def same_bob(model: Slosh, x: np.ndarray) -> np.ndarray:
    """Return the state with phi1 -> -phi1, theta1 -> theta1 + pi: the same place of bob 1."""
    y = x.copy()
    y[model.index("phi1")] *= -1
    y[model.index("theta1")] += np.pi
    y[model.index("phi1_dot")] *= -1
    return y


def chart_defect(model: Slosh, x: np.ndarray, u: np.ndarray, p: np.ndarray) -> float:
    result, expected = (model.accelerations(y, u, p) for y in (same_bob(model, x), x))
    expected[6] *= -1
    return float(np.max(np.abs(result - expected)))


def test_both_angles_of_the_same_place_give_the_same_motion():
    x, u, p = slosh("2", "hinge").sample(np.random.default_rng(17))
    assert chart_defect(slosh("2", "hinge"), x, u, p) < 1e-9
    assert chart_defect(slosh("2", "paper"), x, u, p) > 1e-3
    p[[slosh().position("I1"), slosh().position("eps1")]] = 0
    assert chart_defect(slosh("2", "paper"), x, u, p) < 1e-9


def test_short_pendulums_at_rest_make_a_rigid_body(model):
    x, u, p = model.sample(np.random.default_rng(18))
    x[3:6] = 0
    for k in (1, 2):
        places = bob_places(model, k)
        if model.convention == "ball":
            x[places] = [-1, 0, 0, 0, 0, 0]
        else:
            x[places] = 0
        p[model.position(f"l{k}")] = 1e-7
        p[model.position(f"I{k}")] = 1e-9
    craft = reference.spacecraft(p)
    thrust, moment = reference.loads(craft, u)
    masses = np.array([craft.m, craft.m0, *(bob.m for bob in craft.pendulums)])
    places = np.array([-craft.b, -craft.h0, *(bob.h for bob in craft.pendulums)])
    centre, total = masses @ places / masses.sum(), masses.sum()
    about = masses @ (places - centre) ** 2
    J = craft.J + craft.I0 + np.array([0, about, about])
    alpha = (moment - np.cross([centre, 0, 0], thrust)) / J
    a = thrust / total - np.cross(alpha, [centre, 0, 0])
    result = model.accelerations(x, u, p)
    np.testing.assert_allclose(result[:3], a, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(result[3:6], alpha, rtol=1e-5, atol=1e-5)


def at_rest(model: Slosh, **values: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a state with the arms across x and at rest, and parameters of a hull that does not move."""
    heavy = {"m": 1e12, "m0": 1e12, "J_x": 1e12, "J_y": 1e12, "J_z": 1e12, "F": 0.0}
    x = np.zeros(len(model.system.states))
    if model.convention == "ball":
        for k in (1, 2):
            x[model.index(f"s{k}z")] = 1.0
    else:
        for k in (1, 2):
            x[model.index(f"phi{k}")] = np.pi / 2
    return x, model.parameters(**heavy | values)


@pytest.mark.parametrize("length", [0.1, 0.2, 0.4])
def test_damping_acts_through_its_moment_arm(model, length):
    """A well-known simulator left the lever out of its pendulums' damping for eight years.

    The moment eps phi' slows an arm by eps/(m l^2 + I), so lengthening the arm weakens it; a force without lever would
    not know l, or would scale with l alone.
    """
    x, p = at_rest(model, l1=length)
    name = "sigma1x" if model.convention == "ball" else "phi1_dot"
    x[model.index(name)] = 0.7
    own = model.functions["rhs"](x, np.zeros(5), p)[model.index(name)]
    m, inertia, eps = (p[model.position(name)] for name in ("m1", "I1", "eps1"))
    assert own == pytest.approx(-eps * 0.7 / (m * length**2 + inertia), rel=1e-9)


def test_damping_turns_the_hull_with_the_moment_that_slows_the_bob(model):
    """The reaction is a couple: it acts on the hull through the arm, not as a force at the pivot alone."""
    rng = np.random.default_rng(19)
    x, u, p = model.sample(rng)
    light = p.copy()
    light[[model.position("eps1"), model.position("eps2")]] = 0
    momentum = [along_flow(model, "momentum", x, u, values) for values in (p, light)]
    np.testing.assert_allclose(momentum[0], momentum[1], rtol=1e-9, atol=1e-7)
    assert np.max(np.abs(model.accelerations(x, u, p) - model.accelerations(x, u, light))) > 1e-3


def test_damping_only_takes_energy(model):
    x, _, p = model.sample(np.random.default_rng(20))
    p[model.position("F")] = 0
    (change,) = along_flow(model, "energy", x, np.zeros(5), p)
    assert change < 0


UNIT = re.compile(r"([A-Za-z]+)(?:\^(-?\d+))?")


def scale(unit: str, factors: dict[str, float]) -> float:
    """Return how the number of a quantity changes with its units."""
    head, *tails = unit.split("/")
    total = 1.0
    for sign, part in ((1, head), *((-1, t) for t in tails)):
        for name, power in UNIT.findall(part):
            exponent = sign * int(power or 1)
            total *= factors[name] ** exponent
    return total


def test_units_are_consistent(model):
    kg, m, s = 1.7, 0.6, 2.3
    factors = {"kg": kg, "m": m, "s": s, "rad": 1.0, "N": kg * m / s**2}
    x, u, p = model.sample(np.random.default_rng(21))
    system = model.system
    groups = (system.states, system.inputs, system.parameters)
    x2, u2, p2 = (
        v * np.array([scale(q.unit, factors) for q in group]) for v, group in zip((x, u, p), groups, strict=True)
    )
    rates = np.array([scale(q.unit, factors) / s for q in system.states])
    np.testing.assert_allclose(
        model.functions["rhs"](x2, u2, p2) / rates, model.functions["rhs"](x, u, p), rtol=1e-10, atol=1e-9
    )


def test_every_parameter_leaves_a_trace(model):
    """One per cent more of any plant parameter changes the right-hand side or what the gimbals let through."""
    x, u, p = model.sample(np.random.default_rng(22))
    command = u.copy()
    command[3:] = [1.4, -1.3]
    functions = model.functions
    limited = p.copy()
    limited[[model.position("delta1_max"), model.position("delta2_max")]] = [0.2, 0.4]

    def signature(values: np.ndarray) -> np.ndarray:
        acting = functions["actuate"](x, command, values)
        return np.concatenate([functions["rhs"](x, acting, values), acting])

    plain = signature(limited)
    for k, q in enumerate(model.system.parameters):
        assert isinstance(q, Parameter)
        changed = limited.copy()
        changed[k] *= 1.01
        assert np.max(np.abs(signature(changed) - plain)) > 1e-9, q.name
