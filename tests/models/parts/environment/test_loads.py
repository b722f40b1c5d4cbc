# SPDX-License-Identifier: Apache-2.0
"""Loads of the environment against a second text in NumPy, and what each must keep."""

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.generate import prepared
from mehvar.models.check import check
from mehvar.models.parts import (
    Bob,
    Dipole,
    Drag,
    GravityGradient,
    Hub,
    Magnetorquer,
    Orbit,
    SunPressure,
    Wheel,
)
from mehvar.models.quantities import ModelError
from mehvar.physics.balances import Balances
from tests.models.parts.table import craft_of

CENTRE, ARM, NORMAL = np.array([0.01, -0.02, 0.03]), np.array([0.3, 0.1, -0.2]), np.array([2.0, 1.0, -2.0]) / 3
TENSOR = np.array([[10.0, 0.1, 0.2], [0.1, 12.0, 0.3], [0.2, 0.3, 15.0]])
HUB = Hub("hub", mass=100.0, inertia=TENSOR.tolist(), centre=CENTRE.tolist())
MU, R, SPIN, MF, TILT = 3.986004418e14, 6378137.0, 7.292115e-5, 7.9e15, 0.17
SUN = np.array([np.cos(0.2) * np.cos(0.3), np.cos(0.2) * np.sin(0.3), np.sin(0.2)])
ORBIT = Orbit("J2", ascension=0.3, declination=0.2, density=1e-11)
TIME = 1234.5


class Flight:
    """A craft on an orbit at random states."""

    def __init__(self, *parts, hub=HUB):
        self.system = craft_of(hub, *parts, orbit=ORBIT).system()
        check(self.system)
        ready = prepared(self.system)
        self.names = [q.name for q in ready.states]
        graphs = {g.name: g.graph for g in generate_functions(ready)}
        self.p, self.graphs = [float(q.default) for q in ready.parameters], graphs
        self.u = np.array([0.7 for _ in ready.inputs])

    def states(self, count=4):
        """Yield random states in low orbits, with turn, position and velocity."""
        rng = np.random.default_rng(5)
        for _ in range(count):
            x = dict(zip(self.names, rng.normal(size=len(self.names)), strict=True))
            turn = Rotation.random(random_state=rng)
            place, velocity = 7e6 * turn.apply([1.0, 0, 0]) * (1 + 0.02 * rng.normal()), 7.5e3 * rng.normal(size=3)
            turn = Rotation.random(random_state=rng)
            x |= dict(zip(("q1", "q2", "q3", "q0"), turn.as_quat(), strict=True))
            x |= {f"orbit_{a}": v for a, v in zip("xyz", place, strict=True)}
            x |= {f"orbit_v{a}": v for a, v in zip("xyz", velocity, strict=True)}
            x |= {"clock": TIME} if "clock" in x else {}
            if "tank_ex" in x:
                e, spin = (np.array([x[f"tank_{letter}{a}"] for a in "xyz"]) for letter in "eu")
                e /= np.linalg.norm(e)
                x |= {f"tank_e{a}": v for a, v in zip("xyz", e, strict=True)}
                x |= {f"tank_u{a}": v for a, v in zip("xyz", spin - e * (e @ spin), strict=True)}
            yield np.array([x[n] for n in self.names]), turn.inv(), place, velocity

    def call(self, name, x):
        graph = self.graphs[name]
        of = {"arg_x": x, "arg_u": self.u, "arg_p": self.p}
        return np.array(graph.call({k: ca.DM(v) for k, v in of.items() if k in graph.name_in()})[graph.name_out(0)])

    def moment(self, x):
        """Return the moment of all loads about the centre of mass."""
        return self.call("loads", x).ravel()[3:]

    def pushed(self, x, inertial):
        """Return the force on the craft beyond gravity in inertial axes, without the J2 part."""
        rates = dict(zip(self.names, self.call("rhs", x).ravel(), strict=True))
        felt = np.array([rates[f"orbit_v{a}"] for a in "xyz"])
        return 100.0 * (felt - gravity(inertial))


def gravity(place):
    """Return the slope of the potential with J2, by its derivative in closed form."""
    (x, y, z), r = place, np.linalg.norm(place)
    share = 1.5 * 1.08262668e-3 * (R / r) ** 2
    ratio = 5 * z**2 / r**2
    return -MU / r**3 * np.array([x * (1 + share * (1 - ratio)), y * (1 + share * (1 - ratio)),
                                  z * (1 + share * (3 - ratio))])  # fmt: skip


def field(place):
    pole = Rotation.from_euler("ZY", [SPIN * TIME, TILT]).apply([0.0, 0.0, 1.0])
    r = np.linalg.norm(place)
    n = place / r
    return MF / r**3 * (pole - 3 * (pole @ n) * n)


def air(place, velocity):
    wind = velocity - np.cross([0, 0, SPIN], place)
    return 1e-11 * np.exp(-(np.linalg.norm(place) - R - 6e5) / 7e4), wind


def drag_of_a_sphere(turn, place, velocity):
    density, wind = air(place, velocity)
    return -density * 2.2 * 0.5 / 2 * np.linalg.norm(wind) * turn.apply(wind)


def drag_of_a_plate(turn, place, velocity):
    density, wind = air(place, velocity)
    wind = turn.apply(wind)
    return -density * 2.2 * 0.5 / 2 * max(0.0, NORMAL @ wind) * wind


def lit(place):
    along = SUN @ place
    return float(along > 0 or np.linalg.norm(place - along * SUN) > R)


def light_on_a_plate(turn, place, velocity, normal=NORMAL):
    sun = turn.apply(SUN)
    c = max(0.0, normal @ sun)
    return -4.56e-6 * 0.5 * lit(place) * c * (0.4 * sun + 2 * (0.6 * c + 0.3 / 3) * normal)


def light_on_a_sphere(turn, place, velocity):
    """Return the mean force of plates with 4 times the area in all directions, by Gauss and equal angles."""
    heights, weights = np.polynomial.legendre.leggauss(400)
    force = np.zeros(3)
    for height, weight in zip(heights, weights, strict=True):
        for angle in np.arange(8) * np.pi / 4:
            normal = np.array([*np.sqrt(1 - height**2) * np.array([np.cos(angle), np.sin(angle)]), height])
            towards, _ = Rotation.align_vectors([turn.apply(SUN)], [[0.0, 0.0, 1.0]])
            force += 4 * weight / 16 * light_on_a_plate(turn, place, velocity, towards.apply(normal))
    return force


LIGHT = {"area": 0.5, "at": ARM.tolist()}
PLATE = {**LIGHT, "normal": (2, 1, -2)}
PUSHES = {
    "drag of a sphere": (Drag("load", **LIGHT), drag_of_a_sphere),
    "drag of a plate": (Drag("load", **PLATE), drag_of_a_plate),
    "light on a sphere": (SunPressure("load", scattered=0.3, **LIGHT), light_on_a_sphere),
    "light on a plate": (SunPressure("load", scattered=0.3, **PLATE), light_on_a_plate),
}


def test_a_sphere_has_no_part_that_is_mirrored():
    with pytest.raises(ModelError, match=r"load.mirrored applies only to a plate"):
        SunPressure("load", mirrored=0.6, **LIGHT)


@pytest.mark.parametrize("case", PUSHES)
@pytest.mark.share(3)
def test_force_and_moment_of_a_surface(case):
    part, force = PUSHES[case]
    flight, sizes = Flight(part), []
    for x, turn, place, velocity in flight.states(8):
        expected = force(turn, place, velocity)
        sizes.append(np.linalg.norm(expected))
        # gravity is 1000 N on this craft, of which a double keeps 1e-13
        np.testing.assert_allclose(flight.pushed(x, place), turn.inv().apply(expected), rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(flight.moment(x), np.cross(ARM - CENTRE, expected), rtol=1e-11, atol=1e-18)
    assert max(sizes) > 0


@pytest.mark.parametrize("kind", ["residual", "commanded"])
def test_moment_of_a_dipole(kind):
    axis = np.array([0.2, -0.1, 0.4])
    part = Dipole("load", moment=axis.tolist())
    if kind == "commanded":
        part, axis = Magnetorquer("load", axis=axis.tolist()), 0.7 * axis / np.linalg.norm(axis)
    flight = Flight(part)
    for x, turn, place, _ in flight.states():
        expected = np.cross(axis, turn.apply(field(place)))
        np.testing.assert_allclose(flight.moment(x), expected, rtol=1e-12, atol=1e-20)


def test_gravity_gradient_is_what_the_masses_feel():
    """Against the sum over point masses that have mass and inertia of the hub, in Newton's own field."""
    values, vectors = np.linalg.eigh(TENSOR)
    second = np.sqrt((values.sum() / 2 - values) / 100.0 * 3)
    arms = [sign * second[k] * vectors[:, k] for k in range(3) for sign in (1, -1)]
    flight = Flight(GravityGradient())
    for x, turn, place, _ in flight.states():
        moment, force = np.zeros(3), np.zeros(3)
        n, r = turn.apply(place) / np.linalg.norm(place), np.linalg.norm(place)
        for arm in arms:
            pull = MU / r**3 * (3 * (n @ arm) * n - arm) * 100 / 6  # the field's slope; what is left is arm/r, 1e-7
            moment += np.cross(arm, pull)
            square = (arm @ arm * n + 2 * (n @ arm) * arm - 5 * (n @ arm) ** 2 * n) * 1.5 * MU / r**4 * 100 / 6
            force += square
        np.testing.assert_allclose(flight.moment(x), moment, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(flight.pushed(x, place), turn.inv().apply(force), rtol=1e-5, atol=2e-10)


def test_gravity_gradient_of_a_ball_vanishes():
    flight = Flight(GravityGradient(), hub=Hub("hub", mass=100.0, inertia=(5.0, 5.0, 5.0), centre=CENTRE.tolist()))
    for x, *_ in flight.states():
        assert abs(flight.moment(x)).max() < 1e-19


def test_angular_momentum_about_the_earth_and_energy_are_kept():
    """Orbit and craft together: the force of the gradient takes what its torque gives; with two-body gravity."""
    wheel = Wheel("wheel", axis=(1, 2, 1), inertia=0.2)
    ready = prepared(craft_of(HUB, wheel, GravityGradient(), orbit=Orbit()).system())
    graphs = {g.name: g.graph for g in generate_functions(ready)}
    x, u = ca.SX.sym("x", len(ready.states)), ca.DM.zeros(len(ready.inputs))
    # a light Earth, so near that the gradient is no small part of gravity
    p = [2.0 if q.name == "orbit_mu" else float(q.default) for q in ready.parameters]
    at = {q.name: x[k] for k, q in enumerate(ready.states)}
    place, velocity = (ca.vertcat(*(at[f"orbit_{s}{a}"] for a in "xyz")) for s in ("", "v"))
    q, vector = at["q0"], ca.vertcat(at["q1"], at["q2"], at["q3"])
    own = graphs["momentum"](x, p)[3:]
    turned = own + 2 * ca.cross(vector, ca.cross(vector, own) + q * own)
    whole = 100.0 * ca.cross(place, velocity) + turned
    axis = np.array([1.0, 2.0, 1.0]) / np.sqrt(6)
    inertia = TENSOR + 0.2 * np.outer(axis, axis)
    r = ca.norm_2(place)
    up = (place + 2 * ca.cross(-vector, ca.cross(-vector, place) + q * place)) / r
    tide = -(np.trace(inertia) - 3 * ca.dot(up, inertia @ up)) / r**3
    energy = 50.0 * ca.dot(velocity, velocity) + graphs["energy"](x, p) - 200.0 / r + tide
    rates = graphs["rhs"](x, u, p)
    kept = ca.vertcat(whole, energy)
    change = ca.Function("change", [x], [ca.jtimes(kept, x, rates), ca.vertcat(turned, tide)])
    rng, names = np.random.default_rng(7), [q.name for q in ready.states]
    for _ in range(4):
        state = rng.normal(size=len(names))
        q = [names.index(f"q{k}") for k in range(4)]
        state[q] /= np.linalg.norm(state[q])
        total, size = (np.array(v).ravel() for v in change(state))
        assert abs(total).max() < 1e-12 * abs(size).max()


def test_balances_with_all_loads():
    """Energy and angular momentum relative to the centre of mass."""
    parts = (
        HUB, Wheel("wheel", axis=(0.3, -0.5, 0.7), inertia=0.2),
        Bob("tank", mass=20.0, length=0.3, at=(0.1, 0.2, 0.5), damping=0.1),
        GravityGradient(), Dipole("residual", moment=(0.1, 0.2, 0.3)), Magnetorquer("coil", axis=(1, 0, 0)),
        *(part.__class__(**{**vars(part), "name": f"load{k}"}) for k, (part, _) in enumerate(PUSHES.values())),
    )  # fmt: skip
    balances, flight = Balances(craft_of(*parts, orbit=ORBIT).system()), Flight(*parts[1:])
    u = dict(zip(balances.u_names, flight.u, strict=True))
    for x, *_ in flight.states():
        assert max(balances.errors(dict(zip(balances.x_names, x, strict=True)), u)) < 1e-12
