# SPDX-License-Identifier: Apache-2.0
"""Trimmed points against what one knows of them."""

from __future__ import annotations

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.parts import Hub, Spacecraft, Wheel


def test_a_satellite_that_turns_with_its_orbit():
    """Kept towards the Earth it turns once an orbit about the negative normal, whatever its wheels hold about it."""
    model = mehvar.load("satellite")
    p = model.parameters()
    names = ["roll", "pitch", "yaw", "wx", "wy", "wz"]
    x, u, residual = mehvar.trim(model, fix={"hy": 0.05}, free=names, p=p, steady=names)
    expected = model.state(hy=0.05, wy=-p[model.parameter_names.index("omega0")])
    np.testing.assert_allclose(x, expected, atol=1e-15)
    assert not u.any()
    assert np.abs(residual).max() < 1e-15


def test_pendulums_hang_along_the_thrust():
    """A nozzle that is turned turns the acceleration and the pendulums alike; a moment keeps it straight."""
    model = mehvar.load("slosh")
    steady = [name for name in model.state_names if name.startswith(("w", "phi", "theta"))]
    point = mehvar.trim(
        "slosh", {"vx": 100.0, "delta1": 0.01}, ["phi1", "theta1", "phi2", "theta2", "My", "Mz"], steady=steady
    )
    assert np.abs(point.residual).max() < 1e-11
    assert point.values["phi1"] == pytest.approx(0.01, abs=1e-9)
    assert point.values["phi2"] == pytest.approx(0.01, abs=1e-9)
    assert point.steady == tuple(steady)


def test_what_is_not_steady_is_no_result():
    """Bounds hold all the same, and the point where the rates are least is there."""
    with pytest.raises(
        mehvar.TrimError, match=r"^no steady state found: the rate of \w+ is .* at a bound: w2\. Free more"
    ) as error:
        mehvar.trim("triangle", free={"w2": 0.3}, fix={"rho": 0.3, "mu": 0.2}, bounds={"w2": (0.2, 1.0)})
    point = error.value.point
    assert 0.2 <= point.values["w2"] <= 1.0
    assert point.at_bounds == ("w2",) or point.values["w2"] == pytest.approx(0.2, abs=1e-6)
    assert np.abs(point.residual).max() > 0.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"free": ["rho_"]}, "unknown state or input 'rho_' of triangle in free: did you mean rho"),
        ({"free": ["rho"], "fix": {"rho": 1.0}}, "rho = 'fixed and free'"),
        ({"free": []}, "free = "),
        ({"free": ["rho"], "bounds": {"rho": (1.0, 0.0)}}, "a lower and a higher number"),
        ({"free": ["rho"], "bounds": {"rho": 1.0}}, "a lower and a higher number"),
        ({"free": ["rho"], "bounds": {"phi": (0.0, 1.0)}}, "phi = 'not free'"),
        ({"free": ["rho"], "steady": ["w1"]}, "unknown state 'w1' of triangle in steady"),
    ],
)
def test_what_cannot_be_meant_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        mehvar.trim("triangle", **arguments)


@pytest.fixture(scope="module")
def free_hub():
    craft = Spacecraft("freehub", "a hub with a wheel")
    craft.add(Hub("hub", mass=120.0, inertia=(12.0, 14.0, 10.0)))
    craft.add(Wheel("wheel", axis=(0, 0, 1), inertia=0.02, torque_limit=0.1))
    return mehvar.build(craft)


def test_a_trim_of_a_craft_keeps_its_quaternion_a_unit(free_hub):
    begin = {"q0": 2.0, "q1": 1.0, "q2": 0.3, "q3": 0.0}
    point = mehvar.trim(free_hub, free=begin)
    found = np.array([point.values[name] for name in begin])
    assert abs(np.linalg.norm(found) - 1) < 1e-12
    assert np.allclose(found * np.linalg.norm([*begin.values()]), [*begin.values()])


@pytest.mark.parametrize("free", [["q0", "q1", "q2", "q3"], ["wheel_speed"]])
def test_a_quaternion_of_zeros_is_no_start_of_a_trim(free_hub, free):
    with pytest.raises(InputError, match=r"q0, q1, q2, q3 = 0\.0: must be fixed, or free with a start"):
        mehvar.trim(free_hub, free=free)


def test_a_quaternion_that_is_fixed_at_another_length_is_no_trim(free_hub):
    with pytest.raises(mehvar.TrimError, match="q0 is off its manifold by -1"):
        mehvar.trim(free_hub, fix={"q0": 2.0}, free=["wheel_speed"])
