# SPDX-License-Identifier: Apache-2.0
"""Orbits against Kepler's solution, the mean drift by oblateness and the decay by air."""

import functools
import json
from math import factorial

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq
from scipy.special import lpmv

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.models.parts import (
    Bob,
    Drag,
    Eclipse,
    GravityGradient,
    GroundStation,
    Hub,
    Magnetometer,
    Orbit,
    Spacecraft,
    SunGravity,
    SunPressure,
    SunSensor,
    Tether,
    ThirdBody,
    Value,
)
from mehvar.models.parts.environment.sun import seconds
from tests.models.parts.table import craft_of

MU, R, J2 = 3.986004418e14, 6378137.0, 1.08262668e-3
HUB = Hub("hub", mass=100.0, inertia=(1.0, 3.0, 2.0))
TIGHT = {"rtol": 1e-12, "atol": 1e-12}


def flown(name, *parts, orbit, **options):
    return mehvar.simulate(model_of(*parts, orbit=orbit, name=name), None, inputs={}, **{**TIGHT, **options})


def model_of(*parts, **options):
    return mehvar.build(craft_of(HUB, *parts, **options))


def place(run):
    return np.array([run[f"orbit_{a}"].values for a in "xyz"]), np.array([run[f"orbit_v{a}"].values for a in "xyz"])


def test_two_bodies_are_keplers():
    a, e, i, node, perigee, first = 9e6, 0.2, 1.1, 0.4, 0.7, 0.5
    run = flown("kepler", orbit=Orbit(size=a, eccentricity=e, inclination=i, node=node, perigee=perigee, anomaly=first),
                t_end=12000.0, dt_out=600.0)  # fmt: skip

    def mean(anomaly):
        eccentric = 2 * np.arctan(np.sqrt((1 - e) / (1 + e)) * np.tan(anomaly / 2))
        return eccentric - e * np.sin(eccentric)

    position, _ = place(run)
    for t, here in zip(run["t"].values, position.T, strict=True):
        wanted = mean(first) + np.sqrt(MU / a**3) * t
        eccentric = brentq(lambda v, m=wanted: v - e * np.sin(v) - m, wanted - 1, wanted + 1, xtol=1e-14)
        flat = np.array([np.cos(eccentric) - e, np.sqrt(1 - e**2) * np.sin(eccentric), 0.0]) * a
        for axis, angle in ((2, perigee), (0, i), (2, node)):
            c, s = np.cos(angle), np.sin(angle)
            j, k = (axis + 1) % 3, (axis + 2) % 3
            flat[j], flat[k] = c * flat[j] - s * flat[k], s * flat[j] + c * flat[k]
        np.testing.assert_allclose(here, flat, atol=1e-3)


def test_the_default_state_is_in_orbit():
    """At the centre of the Earth, where other states are by default, the rates are no numbers."""
    model = model_of(orbit=Orbit(size=7e6, eccentricity=0.1))
    x = model.state(wx=0.01)
    assert (x.wx, x.orbit_x) == (0.01, pytest.approx(6.3e6))
    assert np.isfinite(model.linearize(x).A).all()


def test_a_run_ends_at_the_earth():
    """At the instant when Kepler's radius is the Earth's; an orbit that begins inside is refused."""
    a, e = 6.9e6, 0.1
    run = flown("falling", orbit=Orbit(size=a, eccentricity=e, anomaly=np.pi), t_end=6000.0)
    assert run.attrs["reason"].startswith(f"the craft is inside the Earth, whose radius is orbit_R = {R:g} m")
    eccentric = 2 * np.pi - np.arccos((1 - R / a) / e)
    wanted = (eccentric - e * np.sin(eccentric) - np.pi) / np.sqrt(MU / a**3)
    assert float(run.attrs["reason"].split("t = ")[1].split()[0]) == pytest.approx(wanted, rel=1e-5)
    with pytest.raises(MehvarError, match="inside the Earth"):
        flown("fallen", orbit=Orbit(size=a, eccentricity=e), t_end=1.0)


def test_oblateness_turns_the_node():
    """At its mean rate -3/2 n J2 (R/a)^2 cos i of a circle, whose next order is J2 of it."""
    a, i = 7e6, 0.9
    period = 2 * np.pi * np.sqrt(a**3 / MU)
    run = flown("oblate", orbit=Orbit("J2", size=a, inclination=i), t_end=20 * period, dt_out=period / 50)
    r, v = place(run)
    h = np.cross(r.T, v.T)
    node = np.unwrap(np.arctan2(h[:, 0], -h[:, 1]))
    slope = np.polyfit(run["t"].values, node, 1)[0]
    assert slope == pytest.approx(-1.5 * np.sqrt(MU / a**3) * J2 * (R / a) ** 2 * np.cos(i), rel=5e-3)
    size = np.linalg.norm(r, axis=0)
    energy = (v**2).sum(axis=0) / 2 - MU / size * (1 - J2 * (R / size) ** 2 * (1.5 * (r[2] / size) ** 2 - 0.5))
    assert np.ptp(energy) / abs(energy[0]) < 1e-10


def acceleration(run):
    """Return the last but one sample's place and acceleration, the latter by differences of velocity."""
    r, v = place(run)
    h = float(run["t"][1] - run["t"][0])
    return r[:, 4], (8 * (v[:, 5] - v[:, 3]) - (v[:, 6] - v[:, 2])) / (12 * h)


@pytest.mark.parametrize(("orders", "gravity"), [((2,), "J2"), ((2, 3, 4), "J4")])
def test_harmonics_are_the_gradient_of_their_potential(orders, gravity):
    """The potential is -mu/r (1 - sum of J_n (R/r)^n P_n(sin latitude)); harmonics are large so that each counts."""
    harmonics = {2: 2e-2, 3: -1e-2, 4: 3e-2}
    given = {name: harmonics[n] for name, n in (("oblateness", 2), ("third", 3), ("fourth", 4)) if n in orders}
    orbit = Orbit(gravity, size=7.5e6, inclination=1.0, anomaly=0.8, **given)
    run = flown(f"zonal{gravity}", t_end=24.0, dt_out=3.0, orbit=orbit)
    x = sp.symbols("x y z")
    size = sp.sqrt(sum(s**2 for s in x))
    potential = MU / size * (1 - sum(harmonics[n] * (R / size) ** n * sp.legendre(n, x[2] / size) for n in orders))
    at, felt = acceleration(run)
    here = dict(zip(x, map(sp.Float, at), strict=True))
    np.testing.assert_allclose(felt, [float(potential.diff(s).subs(here)) for s in x], rtol=1e-7)


def test_a_third_body_pulls_the_craft_and_the_earth():
    """Against the difference of both accelerations, with a mass that makes it a tenth of the Earth's."""
    moon = {"mu": 5e16, "distance": 4e7, "rate": 1e-4, "inclination": 0.4, "node": 0.3, "phase": 0.7}
    run = flown("third", ThirdBody("moon", **moon), orbit=Orbit(size=9e6, inclination=1.0), t_end=8.0, dt_out=1.0)
    at, felt = acceleration(run)
    angle = moon["phase"] + moon["rate"] * 4.0
    flat = np.array([np.cos(angle), np.sin(angle) * np.cos(0.4), np.sin(angle) * np.sin(0.4)]) * moon["distance"]
    body = np.array(
        [np.cos(0.3) * flat[0] - np.sin(0.3) * flat[1], np.sin(0.3) * flat[0] + np.cos(0.3) * flat[1], flat[2]]
    )
    pull = lambda d: moon["mu"] * d / np.linalg.norm(d) ** 3  # noqa: E731
    expected = -MU * at / np.linalg.norm(at) ** 3 + pull(body - at) - pull(body)
    np.testing.assert_allclose(felt, expected, rtol=1e-8)


def test_a_third_body_does_not_turn_a_craft_or_move_its_parts():
    """It accelerates all parts alike: a bob's swing is the same with and without it."""
    bob = Bob("bob", mass=5.0, length=0.5, damping=0.0)
    runs = [
        flown(f"alike{k}", bob, *parts, orbit=Orbit(), t_end=60.0, initial={"wy": 0.1})
        for k, parts in enumerate([(), (ThirdBody("moon", mu=1e15),)])
    ]
    for name in ("wx", "wy", "bob_ux", "bob_uz"):
        np.testing.assert_allclose(runs[0][name], runs[1][name], atol=1e-9)
    assert abs(runs[0]["orbit_x"] - runs[1]["orbit_x"])[-1] > 0.1


SUN = {
    "1950-09-20 06:00": (-1.00253335, 0.05278221, 0.02288941),
    "2006-04-02": (0.97719266, 0.19251786, 0.08346505),
    "2026-11-28 14:00+02:00": (-0.39715192, -0.82862474, -0.35919009),
}
"""Place of the Sun in au, of the mean equator and equinox of date: ERFA's epv00 turned by its pmat06."""


def test_the_sun_moves_as_in_an_ephemeris():
    """A sensor, the pressure of light and gravity have one Sun, also half a year after the start."""
    parts = SunSensor("sensor"), SunPressure("ball", area=100.0), SunGravity("sun")
    model = model_of(*parts, orbit=Orbit(size=4.2e7, epoch="2006-04-02"))
    unit, day = 1.495978707e11, 86400.0
    for k, (date, place) in enumerate(SUN.items()):
        start, size = seconds(date), np.linalg.norm(place)
        for clock in (0.0, -180 * day, 180 * day) if k == 1 else (0.0,):
            far = np.array([0, 0, 4.2e7])
            x = model.state(q0=1.0, orbit_z=4.2e7, clock=clock)
            p = model.parameters(orbit_epoch=start - clock)
            seen = model.functions["measure"](x, [], p)[:3]
            assert np.degrees(np.linalg.norm(np.cross(seen, place) / size)) < 0.015
            pressed = -4.56e-6 / size**2 * seen
            rates = dict(zip(model.state_names, model.rhs(x, [], p), strict=True))
            felt = np.array([rates[f"orbit_v{a}"] for a in "xyz"]) - pressed + MU * far / 4.2e7**3
            body = np.array(place) * unit
            pulled = 1.32712440018e20 * ((body - far) / np.linalg.norm(body - far) ** 3 - body / (size * unit) ** 3)
            np.testing.assert_allclose(felt, pulled, rtol=0, atol=3e-9)
    (epoch,) = (q for q in model.manifest.parameters if q.name == "orbit_epoch")
    assert epoch.default == seconds("2006-04-02") == 2282.5 * day
    assert epoch.source == "2006-04-02"


AIR = [(1.5e5, 2.070e-9), (2e5, 2.789e-10), (2.5e5, 7.248e-11), (3e5, 2.418e-11)]
"""From Wertz, Spacecraft Attitude Determination and Control, 1978, table L-4."""


def test_the_air_may_be_in_a_file(tmp_path):
    def row(unit, value):
        return f'{{ unit = "{unit}", default = {value}, source = "paper: Wertz 1978, table L-4" }}'

    rows = [f"[[air]]\nheight = {row('m', h)}\ndensity = {row('kg/m^3', rho)}\n" for h, rho in AIR]
    (tmp_path / "air.toml").write_text("\n".join(rows), encoding="utf-8")
    system = built(Orbit.read("orbit", tmp_path / "air.toml", size=6.6e6))
    given = {q.name: (q.default, q.source) for q in system.parameters}
    assert given["orbit_air_rho_3"] == (AIR[2][1], "paper: Wertz 1978, table L-4")
    with pytest.raises(MehvarError, match="name = 'sky': must be 'orbit', the name of every Orbit"):
        Orbit.read("sky", tmp_path / "air.toml")


@functools.cache
def airy():
    rows = [(Value(h, source="paper: Wertz 1978"), rho) for h, rho in AIR]
    return model_of(Drag("ball", area=2.0, coefficient=2.5), orbit=Orbit(air=rows, spin=0.0))


@pytest.mark.parametrize("height", [1.2e5, 1.5e5, 1.8e5, 2e5, 2.9999e5, 4e5])
def test_the_air_is_interpolated_in_its_logarithm(height):
    model = airy()
    x = model.state(q0=1.0, orbit_z=R + height, orbit_vx=7e3)
    felt = model.rhs(x, [], model.parameters())[model.state_names.index("orbit_vx")]
    h, logs = np.array(AIR)[:, 0], np.log(np.array(AIR)[:, 1])
    inside = np.interp(height, h, logs)
    inside += min(height - h[0], 0) * (logs[1] - logs[0]) / 5e4 + max(height - h[-1], 0) * (logs[-1] - logs[-2]) / 5e4
    assert felt == pytest.approx(-np.exp(inside) * 2.5 * 2.0 / 2 * 7e3**2 / 100, rel=1e-12)


def test_penumbra_is_the_share_of_the_suns_disc():
    """Against a sum over the points of the disc, from full light through the penumbra to the umbra."""
    model = model_of(SunSensor("sun"), orbit=Orbit(shadow="cone", disc=0.05, size=7e6, inclination=0.0))
    rim = np.arcsin(R / 7e6)
    generator = np.random.default_rng(4)
    radius, turn = 0.05 * np.sqrt(generator.random(200_000)), 2 * np.pi * generator.random(200_000)
    for apart in rim + np.array([-0.06, -0.04, 0.0, 0.03, 0.06]):
        x = model.state(q0=1.0, orbit_x=-7e6 * np.cos(apart), orbit_y=7e6 * np.sin(apart))
        share = np.mean(np.hypot(apart + radius * np.cos(turn), radius * np.sin(turn)) > rim)
        light = np.linalg.norm(model.functions["measure"](x, [], model.parameters()))
        assert light == pytest.approx(share, abs=4e-3)


SIZE = 7e6
RATE = np.sqrt(MU / SIZE**3)


def events(run):
    """Return names and times of the events of a run."""
    rows = json.loads(run.attrs["events"])
    return list(zip(rows["name"], rows["t"], strict=True))


@pytest.mark.parametrize("shadow", ["cylinder", "cone"])
def test_eclipses_begin_and_end_at_known_angles(shadow):
    """The Sun is along x, the orbit a circle from there: the shadow begins where the discs touch."""
    orbit = Orbit(shadow=shadow, size=SIZE, **({"disc": 0.02} if shadow == "cone" else {}))
    run = flown("night", Eclipse("night"), orbit=orbit, t_end=2 * np.pi / RATE, dt_out=60.0)
    rim = np.arcsin(R / SIZE)
    edges = {"night": rim + 0.02, "night_full": rim - 0.02} if shadow == "cone" else {"night": rim}
    angles = {
        f"{name}_{end}": np.pi + s * edge for name, edge in edges.items() for end, s in (("begins", -1), ("ends", 1))
    }
    expected = sorted((angle / RATE, name) for name, angle in angles.items())
    assert [name for name, _ in events(run)] == [name for _, name in expected]
    np.testing.assert_allclose([t for _, t in events(run)], [t for t, _ in expected], rtol=0, atol=1e-6)


def test_a_contact_lasts_while_the_craft_is_above_the_mask():
    """A circle over the equator of a sphere that turns: the angle at the Earth's centre is acos(R/a cos e) - e."""
    spin, mask = 7e-5, 0.1
    station = GroundStation("base", latitude=0.0, ascension=1.0, elevation=mask, flattening=0.0)
    run = flown("pass", station, orbit=Orbit(size=SIZE, spin=spin), t_end=4000.0, dt_out=50.0)
    half = np.arccos(R / SIZE * np.cos(mask)) - mask
    wanted = [(1.0 - half) / (RATE - spin), (1.0 + half) / (RATE - spin)]
    assert [name for name, _ in events(run)] == ["base_begins", "base_ends"]
    np.testing.assert_allclose([t for _, t in events(run)], wanted, rtol=0, atol=1e-6)


def test_a_station_stands_on_the_ellipsoid():
    """The guard vanishes where the craft is in the horizon of a station at 50 degrees north."""
    latitude, height, polar = np.radians(50.0), 300.0, (1 - 1 / 298.257223563) ** 2
    model = model_of(GroundStation("base", latitude=latitude, ascension=0.5, height=height), orbit=Orbit())
    bend = R / np.sqrt(1 - (1 - polar) * np.sin(latitude) ** 2)
    east, out = np.array([-np.sin(0.5), np.cos(0.5), 0]), np.array([np.cos(0.5), np.sin(0.5), 0])
    place = (bend + height) * np.cos(latitude) * out + np.array([0, 0, (polar * bend + height) * np.sin(latitude)])
    up = np.cos(latitude) * out + np.array([0, 0, np.sin(latitude)])
    for angle in (0.0, 0.3):
        x = place + 1e6 * (np.cos(angle) * east + np.sin(angle) * up)
        state = model.state(q0=1.0, **dict(zip(("orbit_x", "orbit_y", "orbit_z"), x, strict=True)))
        guard = model.functions["guards"](state, [], model.parameters())
        np.testing.assert_allclose(guard, -1e6 * np.sin(angle), atol=1e-6)


GAUSS = (
    (1, 0, -29404.8, 0.0), (1, 1, -1450.9, 4652.5), (2, 1, 2982.0, -2991.6), (2, 2, 1677.0, -734.6),
    (3, 2, 1236.2, 241.9),
)  # fmt: skip
"""Some coefficients of IGRF-13, 2020, nT."""


def potential(place):
    """Return the potential of GAUSS at a place in axes of the Earth, by SciPy's functions."""
    size = np.linalg.norm(place)
    longitude, result = np.arctan2(place[1], place[0]), 0.0
    for n, m, g, h in GAUSS:
        norm = np.sqrt((2 if m else 1) * factorial(n - m) / factorial(n + m))
        legendre = (-1) ** m * lpmv(m, n, place[2] / size)
        wave = g * np.cos(m * longitude) + h * np.sin(m * longitude)
        result += 6371.2e3 * (6371.2e3 / size) ** (n + 1) * norm * legendre * wave * 1e-9
    return result


def test_the_field_of_gauss_coefficients_is_the_gradient_of_its_potential():
    model = model_of(Magnetometer("mag"), orbit=Orbit(harmonics=GAUSS, longitude=0.7))
    c, s = np.cos(0.7), np.sin(0.7)
    turn, here = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), np.array([3e6, -4e6, 5e6])
    slopes = [potential(turn @ (here + 10 * e)) - potential(turn @ (here - 10 * e)) for e in np.eye(3)]
    state = model.state(q0=1.0, **dict(zip(("orbit_x", "orbit_y", "orbit_z"), here, strict=True)))
    shown = model.functions["measure"](state, [], model.parameters())
    np.testing.assert_allclose(shown[:3], -np.array(slopes) / 20, rtol=1e-6)


NONE = [((0, 0, 1.0, 0.0),), ((1, 2, 1.0, 0.0),), ((1, 0, 1.0),), ((1, 0, 1.0, 0.0),) * 2, ((1, 0, 1.0, 5.0),)]


@pytest.mark.parametrize("rows", NONE)
def test_coefficients_that_are_none_are_refused(rows):
    with pytest.raises(MehvarError, match="orbit: harmonics"):
        Orbit(harmonics=rows)


def test_air_takes_energy():
    """A circle shrinks by da/dt = -rho C A/m sqrt(mu a), in an atmosphere at rest."""
    a, density = 6.978137e6, 1e-11
    period = 2 * np.pi * np.sqrt(a**3 / MU)
    orbit = Orbit(size=a, density=density, spin=0.0, height=a - R, thinning=1e9)
    run = flown("decay", Drag("drag", area=1.0), orbit=orbit, t_end=period, dt_out=period)
    r, v = place(run)
    semi = 1 / (2 / np.linalg.norm(r, axis=0) - (v**2).sum(axis=0) / MU)
    expected = -density * 2.2 / 100.0 * np.sqrt(MU * a) * period
    assert semi[-1] - semi[0] == pytest.approx(expected, rel=1e-4)


def test_libration_in_pitch():
    """A craft that points to the Earth librates at n sqrt(3 (Jx - Jz)/Jy), with x along the motion and z down."""
    a = 7e6
    n = np.sqrt(MU / a**3)
    hub = Hub("hub", mass=100.0, inertia=(3.0, 3.5, 1.0))
    craft = craft_of(hub, GravityGradient(), orbit=Orbit(size=a, inclination=np.pi / 2))
    expected = n * np.sqrt(3 * (3.0 - 1.0) / 3.5)
    # over the node on the x axis with the motion along z: the body's y axis is against the orbit's normal, -y
    start = {"wy_0": -n, "pitch_0": -np.pi / 2 + 1e-3}
    run = mehvar.simulate(mehvar.build(craft), None, inputs={}, parameters=start, t_end=2 * np.pi / expected,
                          dt_out=2 * np.pi / expected / 4, **TIGHT)  # fmt: skip
    r, _ = place(run)
    turned = np.unwrap(2 * np.arctan2(run["q2"].values, run["q0"].values), period=2 * np.pi)
    down = np.unwrap(np.arctan2(r[2], -r[0]))
    off = turned - turned[0] - (down - down[0])
    off = off if abs(off).max() < 0.1 else turned - turned[0] + (down - down[0])
    np.testing.assert_allclose(off / 1e-3, [0, -1, -2, -1, 0], atol=2e-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Orbit("kepler"), "orbit: gravity = 'kepler': must be one of two-body, J2, J4"),
        (lambda: Orbit(shadow="soft"), "orbit: shadow = 'soft': must be one of cylinder, cone"),
        (lambda: Orbit(epoch="now"), "orbit: epoch = 'now': must be a date such as 2026-11-28 12:00, or a number, s"),
        (lambda: Orbit(epoch="1949-12-31"), "orbit: epoch = '1949-12-31': must be from 1950 to 2050"),
        (lambda: built(Orbit(epoch=-2e9)), "orbit_epoch = .*: must be a number in .-1577923200"),
        (lambda: Orbit(epoch=0.0, ascension=0.3), "orbit: ascension has no effect beside epoch"),
        (lambda: Orbit(air=AIR, height=5e5), "orbit: height has no effect beside air"),
        (lambda: Orbit(oblateness=0.5), "orbit: oblateness has no effect without gravity = .J2. or .J4.: give both"),
        (lambda: Orbit("J2", fourth=0.1), "orbit: fourth has no effect without gravity = .J4.: give both or neither"),
        (lambda: Orbit(disc=0.01), "orbit: disc has no effect without shadow = .cone."),
        (lambda: Orbit(harmonics=GAUSS, tilt=0.1), "orbit: tilt has no effect beside harmonics"),
        (lambda: Orbit(reference=6e6), "orbit: reference has no effect without harmonics"),
        (lambda: doubled(GravityGradient(), GravityGradient("second")), "GravityGradient 'second' would double 'grad"),
        (lambda: doubled(SunGravity(), SunGravity("second")), "SunGravity 'second' would double 'sun'"),
        (lambda: doubled(ThirdBody("moon"), ThirdBody("second")), "'second' would double 'moon', .*leave one of both"),
        (lambda: Orbit(air=[(1e5, 1.0)]), "orbit: air: must be two rows or more with increasing heights"),
        (lambda: Orbit(air=AIR[::-1]), "orbit: air: must be two rows or more with increasing heights"),
        (lambda: Orbit(air="thin"), "orbit: air = 'thin': must be rows of height, m, and density"),
        (lambda: built(Orbit(air=[(1e5, 1e-9), (2e5, 0.0)])), "orbit_air_rho_2 = 0.0: must be a number in"),
        (lambda: lonely(ThirdBody("moon")), "moon needs an orbit"),
        (lambda: Spacecraft("craft", orbit="two-body"), "orbit = 'two-body': must be an Orbit"),
        (lambda: Spacecraft("craft", orbit=Orbit(), motion="plane"), "must be an Orbit, of a craft with motion"),
        (lambda: lonely(GravityGradient()), r"gradient needs an orbit: write Spacecraft\(..., orbit=Orbit\(\)\)"),
        (
            lambda: tidal(),
            "gradient: the GravityGradient acts on one rigid body, but far moves beside the hub: leave one of both",
        ),
        (lambda: lonely(Orbit()), "an orbit cannot be added as a part"),
    ],
)
def test_wrong_orbits_are_refused(make, words):
    with pytest.raises(MehvarError, match=words):
        make()


def built(orbit):
    return craft_of(HUB, Drag("ball", area=2.0), SunPressure("sail", area=2.0), orbit=orbit).system()


def tidal():
    line = {"length": 1e4, "stiffness": 0.5, "start": (1e4, 0.0, 0.0)}
    far = Tether("far", mass=26.0, inertia=(1.0, 1.0, 1.0), **line)
    return craft_of(HUB, GravityGradient(), far, orbit=Orbit()).system()


def doubled(*parts):
    craft_of(*parts, orbit=Orbit())


def lonely(part):
    return craft_of(HUB, part).system()
