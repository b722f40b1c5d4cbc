# SPDX-License-Identifier: Apache-2.0
"""The satellite from library parts, on an orbit in inertial axes."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping

import sympy as sp

from mehvar.models.mechanics import frame_turn, quaternion_of_turns, quaternion_product, quaternion_rotation
from mehvar.models.parts import GravityGradient, Hub, Orbit, Spacecraft, Torquer, Wheel
from mehvar.models.parts.charts import RodriguesChart
from mehvar.models.system import Expr, System

from .rederived import Pair, Side, structured

ANGLES = sp.symbols("roll pitch yaw", real=True)
RATES = sp.symbols("wx wy wz", real=True)
LATITUDE = sp.Symbol("latitude", real=True)
PLACE = sp.symbols("orbit_x orbit_y orbit_z", real=True)
QUATERNION = sp.symbols("q0:4", real=True)


def assembled(shipped: System, gradient: bool = True) -> System:
    """Assemble body, wheels, gravity gradient and a torque from outside with the shipped parameters."""
    craft = Spacecraft("satellite", orbit=Orbit())
    given = (q for q in shipped.parameters if q.name.startswith(("I", "wheel")))
    p = {q.name: craft.parameter(q.name, q.default, q.unit, q.description, str(q.bounds)) for q in given}
    craft.add(Hub("body", sp.S.One, _inertia(shipped, p)))  # the mass plays no part
    share = p.get("wheels", sp.S.One)
    for label, axis, inertia in _wheels(shipped, p):
        craft.add(Wheel(f"wheel{label}", axis, inertia, share**2 * p["wheel_friction"]))
    if gradient:
        craft.add(GravityGradient())
    craft.add(Torquer("outside"))
    return craft.system()


def _inertia(shipped: System, p: dict[str, sp.Symbol]) -> object:
    if shipped.structure.get("inertia") != "full":
        return tuple(p[f"I_{i}"] for i in "xyz")
    return shipped.parameters.I.tolist()


def _wheels(shipped: System, p: dict[str, sp.Symbol]) -> list[tuple[str, tuple[Expr, ...], Expr]]:
    if shipped.structure.get("wheels") != "any":
        return [(i, tuple(map(int, sp.eye(3)[:, k])), p[f"Iw_{i}"]) for k, i in enumerate("xyz")]
    axes, inertia = shipped.parameters.wheel_axes, shipped.parameters.wheel_inertia
    return [(str(k + 1), tuple(axes[:, k]), inertia[k]) for k in range(axes.cols)]


@functools.cache
def forms(chart: str, inertia: str, wheels: str) -> Pair:
    """Return a structure beside its form from parts."""
    shipped = structured("satellite", chart=chart, inertia=inertia, wheels=wheels)
    return pair(shipped, assembled(shipped))


def pair(shipped: System, form: System) -> Pair:
    """Return the pair on the manifold of unit quaternions.

    The shipped attitude is that of the body in orbit axes; inertial axes are those of latitude zero. The shipped
    momentum of a wheel is absolute.
    """
    p = {q.name: q.symbol for q in shipped.parameters}
    place, speed = circle(p)
    euler = shipped.structure["chart"] == "euler"
    turn = quaternion_of_turns(tuple(zip((2, 1, 0), ANGLES[::-1], strict=True))) if euler else sp.Matrix(QUATERNION)
    attitude = quaternion_product(quaternion_of_turns(((1, -LATITUDE),)), turn)
    at = dict(zip(_names("orbit_", "orbit_v"), (*place, *speed), strict=True)) | {
        f"q{k}": e for k, e in enumerate(attitude)
    }
    momenta = []
    at["orbit_mu"] = p["omega0"] ** 2 * p["orbit_radius"] ** 3
    share, outside = p.get("wheels", sp.S.One), sp.Matrix(sp.symbols("Tenv_x Tenv_y Tenv_z", real=True))
    for label, axis, inertia in _wheels(shipped, p):
        unit = sp.Matrix(axis) / sp.sqrt(sp.Add(*(e**2 for e in axis)))
        h, speed = (sp.Symbol(n, real=True) for n in (f"h{label}", f"wheel{label}_speed"))
        along = unit.dot(sp.Matrix(RATES))
        motor, whole = (sp.Symbol(f"{n}{label}", real=True) for n in ("T", "Tw_"))
        at[speed.name], at[f"wheel{label}_torque"] = h / inertia - along, -share * motor
        outside += (1 - share) * whole * unit
        momenta.append((h, inertia * (speed + along)))
    at |= {f"outside{i}": e for i, e in zip("xyz", outside, strict=True)}
    c = {s.name: e for s, e in shipped.definitions.items()}
    rotation = sp.Matrix(3, 3, lambda i, j: c[f"C{i + 1}{j + 1}"])
    rodrigues = {} if euler else {f"q{k}": e for k, e in enumerate(RodriguesChart().quaternion())}
    readings = {s.name: (s, s) for s in RATES} | {h.name: (h, of) for h, of in momenta}
    readings |= _alike("turn", rotation * frame_turn(1, -LATITUDE), quaternion_rotation(QUATERNION)) | _alike(
        "place", place, PLACE
    )
    return Pair(Side(shipped, rodrigues), Side(form, at), readings)


def velocity(shipped: System) -> dict[str, tuple[Expr, Expr]]:
    """Return the velocity on the circular orbit and that on the library's."""
    p = {q.name: q.symbol for q in shipped.parameters}
    return _alike("velocity", circle(p)[1], sp.symbols("orbit_vx orbit_vy orbit_vz", real=True))


def circle(p: Mapping[str, sp.Symbol]) -> tuple[sp.Matrix, sp.Matrix]:
    """Return place and velocity on the circular orbit in inertial axes."""
    radius, inertial = p["orbit_radius"], frame_turn(1, -LATITUDE).T
    return inertial * sp.Matrix([0, 0, -radius]), inertial * sp.Matrix([p["omega0"] * radius, 0, 0])


def _alike(name: str, old: Iterable[Expr], new: Iterable[Expr]) -> dict[str, tuple[Expr, Expr]]:
    return {f"{name}{k}": each for k, each in enumerate(zip(old, new, strict=True), 1)}


def _names(*starts: str) -> list[str]:
    return [f"{start}{i}" for start in starts for i in "xyz"]
