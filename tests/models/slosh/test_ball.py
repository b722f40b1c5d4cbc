# SPDX-License-Identifier: Apache-2.0
"""Ball joints with a quaternion go anywhere, and derivatives along a direction cost as much more as pendulums do."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mehvar
from mehvar.codegen.code.tape import tape
from mehvar.codegen.functions.derivatives import directional
from mehvar.codegen.functions.function import FunctionGraph
from mehvar.codegen.generate import write
from tests.derived import variant
from tests.models.slosh.variants import CONVENTIONS, slosh

pytestmark = pytest.mark.soak  # a structure of its own: tests/models/parts assembles it

DURATION = 50.0


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    folder = tmp_path_factory.mktemp("generated") / "slosh"
    write(folder, variant("slosh", inertia="ball", attitude="quaternion"))
    return mehvar.load(str(folder))


def tumbling(model) -> np.ndarray:
    """Return a craft that turns about all axes, its arms at 4 rad/s: fast enough to go over the top."""
    x = model.state(q0=1.0, wx=0.8, wy=-1.1, wz=0.6)
    s = np.array([-np.cos(0.3), 0.0, np.sin(0.3)])
    for k in (1, 2):
        at = model.state_names.index(f"s{k}x")
        x[at : at + 3], x[at + 3 : at + 6] = s, np.cross([0.0, 4.0, 0.0], s)
    return x


def free_motion(model, tolerance: float) -> np.ndarray:
    """Return the states of the free tumble, no thrust, no damping, at every accepted step; nothing is projected."""
    p, u = model.parameters(F=0.0, eps1=0.0, eps2=0.0), np.zeros(5)
    result = solve_ivp(
        lambda t, x: model.rhs(x, u, p), (0.0, DURATION), tumbling(model), "DOP853", rtol=tolerance, atol=tolerance
    )
    assert result.success
    return result.y.T


@pytest.fixture(scope="module")
def free(model):
    return free_motion(model, 1e-12)


def column(model, x: np.ndarray, name: str, size: int = 1) -> np.ndarray:
    at = model.state_names.index(name)
    return x[..., at : at + size] if size > 1 else x[..., at]


def inertial(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Turn body components into inertial ones by unit quaternions, scalar first."""
    axis = q[:, 1:]
    return v + 2 * np.cross(axis, np.cross(axis, v) + q[:, :1] * v)


def test_arms_go_over_the_top(model, free):
    for k in (1, 2):
        along = column(model, free, f"s{k}x")
        assert along.min() < -0.97
        assert along.max() > 0.97
        assert np.count_nonzero((along[1:] > 0) & (along[:-1] <= 0)) > 20


def test_a_free_tumble_keeps_energy(model, free):
    p = model.parameters(F=0.0, eps1=0.0, eps2=0.0)
    energy = model.functions["energy"](free, p)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_a_free_tumble_keeps_its_inertial_momentum(model, free):
    p = model.parameters(F=0.0, eps1=0.0, eps2=0.0)
    momentum = inertial(column(model, free, "q0", 4), model.functions["momentum"](free, p)[:, :3])
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-9 * np.max(momentum[0]))


def test_directions_and_quaternion_stay_on_their_spheres(model, free):
    for name, size in (("q0", 4), ("s1x", 3), ("s2x", 3)):
        np.testing.assert_allclose(np.linalg.norm(column(model, free, name, size), axis=1), 1, atol=1e-9)
    for k in (1, 2):
        across = np.sum(column(model, free, f"s{k}x", 3) * column(model, free, f"sigma{k}x", 3), axis=1)
        np.testing.assert_allclose(across, 0, atol=1e-8)


def test_the_end_converges_with_the_tolerance(model, free):
    """Tumbling magnifies errors, about 1e5 times in this minute, but nothing is lost at a chart's edge."""
    off = [np.max(np.abs(free_motion(model, tolerance)[-1] - free[-1])) for tolerance in (1e-9, 1e-11)]
    assert off[0] < 1e-3
    assert off[1] < 0.05 * off[0]


def test_a_controlled_run_over_the_top_keeps_its_tolerance(model):
    """From where the demand no longer exceeds the thrust: the kink of the first tenth of a second is not located."""
    tumble = dict(zip(model.state_names, map(float, tumbling(model)), strict=True))

    def run(initial: dict[str, float], tolerance: float, t_end: float):
        return mehvar.simulate(
            str(model.manifest.folder),
            controller="lyapunov-v2",
            initial=initial,
            parameters={"eps1": 0.0, "eps2": 0.0, "w1": 1e-3, "w2": 1e-3},
            t_end=t_end,
            rtol=tolerance,
            atol=tolerance,
        )

    soon = run(tumble, 1e-12, 0.5)
    initial = {name: float(soon[name][-1]) for name in model.state_names}
    loose, tight = run(initial, 1e-9, DURATION), run(initial, 1e-12, DURATION)
    assert loose.attrs["status"] == tight.attrs["status"] == "done"
    assert float(soon.lateral_excess.max()) > 0
    assert float(tight.lateral_excess.max()) == 0
    assert float(tight.phi1.max()) > 3.0
    assert float(tight.phi1.min()) < 0.1
    for name in model.state_names:
        np.testing.assert_allclose(loose[name], tight[name], atol=1e-6)
    for k in (1, 2):
        length = sum(tight[f"s{k}{axis}"] ** 2 for axis in "xyz")
        np.testing.assert_allclose(length, 1, atol=1e-14)


@pytest.mark.soak
def test_located_switches_keep_the_tolerance(tmp_path):
    """The whole tumble, the kink of the first tenth of a second included: without surfaces 5e-5 with 1e-9."""
    folder = tmp_path / "slosh"
    write(folder, variant("slosh", inertia="ball", attitude="quaternion", switches="located"))
    model = mehvar.load(str(folder))
    start = dict(zip(model.state_names, map(float, tumbling(model)), strict=True))

    def states(tolerance: float) -> np.ndarray:
        run = mehvar.simulate(
            str(folder), controller="lyapunov-v2", initial=start, t_end=DURATION, rtol=tolerance, atol=tolerance,
            parameters={"eps1": 0.0, "eps2": 0.0, "w1": 1e-3, "w2": 1e-3},
        )  # fmt: skip
        assert run.attrs["status"] == "done"
        assert '"demand_' in run.attrs["events"]
        return np.array([run[name].values for name in model.state_names])

    tight = states(1e-13)
    errors = [np.max(np.abs(states(tolerance)[:, -1] - tight[:, -1])) for tolerance in (1e-8, 1e-9, 1e-10, 1e-11)]
    assert errors[1] < 1e-5
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-2 * errors[0]


@pytest.mark.parametrize("inertia", CONVENTIONS)
@pytest.mark.share(3)
def test_a_derivative_along_a_direction_costs_no_more_for_later_pendulums(inertia):
    counts = {n: operations(str(n), inertia) for n in (2, 4, 8)}
    sooner, later = (counts[4] - counts[2]) / 2, (counts[8] - counts[4]) / 4
    assert 0.85 * sooner < later < 1.01 * sooner
    assert counts[8] < 4 * tape(slosh("8", inertia).functions.graph("rhs")).operations


def operations(pendulums: str, inertia: str) -> int:
    model = slosh(pendulums, inertia)
    system = model.system
    arguments = tuple((g.name, len(g)) for g in (system.states, system.inputs, system.parameters))
    size = len(system.states)
    rhs = FunctionGraph("rhs", "", arguments, (("dx", size),), model.functions.graph("rhs"))
    return tape(directional(rhs, "xu", "jac").graph).operations


def test_the_count_is_that_of_the_generated_code():
    recorded = mehvar.load("slosh").manifest.functions["jvp"]
    assert operations("2", "paper") == pytest.approx(recorded.operations, rel=0.05)
