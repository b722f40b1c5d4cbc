# SPDX-License-Identifier: Apache-2.0
"""Physics of the spacecraft with sloshing fuel."""

from __future__ import annotations

import functools

import numpy as np

from mehvar.models.slosh.states import RATE, VELOCITY
from mehvar.physics.gates import Change, Gate, Symmetry, balance, dot, identity, never_rises, smaller, symmetric
from mehvar.physics.machine import Array, Machine, Points
from tests.mehvar.physics import bodies, rotations
from tests.mehvar.physics.installed import machine

FLOOR = 1e-12
"""Mass and inertia of a negligible pendulum, kg and kg m^2."""


def gates_of(subject: Machine) -> list[Gate]:
    """Return the gates of a structure."""
    structure = subject.system.structure
    count, inertia = int(structure["pendulums"]), structure["inertia"]
    found = [*_balances(structure["attitude"]), *_outputs(), *_prescribed(), *_limits(count, structure)]
    if inertia != "paper":
        found.append(symmetric(mirror(count, inertia, structure["attitude"])))
    if inertia == "hinge":
        found.append(symmetric(same_bob(count)))
    if inertia == "ball":
        found += [*_constraints(count), identity("outputs: angles of the bobs", directions, _arms)]
    if structure["attitude"] == "quaternion":
        found.append(identity("outputs: attitude angles", turned_by_outputs, turned))
    return found


def _balances(attitude: str) -> list[Gate]:
    found = [
        identity("energy of the bodies", energy, bodies.energy),
        identity("momentum of the bodies", lambda at: at.call("momentum"), bodies.momentum),
        balance("power", energy, lambda at: power(at) - dissipation(at)),
        never_rises("energy without inputs", energy, unforced),
        *momenta("rhs", level if attitude == "angles" else None),
        identity("Galilean invariance", accelerations, lambda at: accelerations(_faster(at))),
    ]
    if attitude == "angles":
        found += momenta("rhs_euler", None, ", 3-2-1 angles")
    else:
        found.append(balance("unit quaternion", lambda at: dot(_q(at), _q(at)), lambda at: np.zeros(len(_q(at)))))
    return found


def momenta(flow: str, where: Change | None, suffix: str = "") -> list[Gate]:
    """Return the rates of linear and angular momentum in inertial axes."""
    return [
        balance(
            f"linear momentum{suffix}",
            lambda at: rotations.back(turned(at), at.call("momentum")[:, :3]),
            lambda at: rotations.back(turned(at), force(at)),
            flow,
            where,
        ),
        balance(
            f"angular momentum{suffix}",
            lambda at: rotations.back(turned(at), at.call("momentum")[:, 3:]),
            lambda at: rotations.back(turned(at), moment(at) - np.cross(velocity(at), at.call("momentum")[:, :3])),
            flow,
            where,
        ),
    ]


def _outputs() -> list[Gate]:
    def lateral(at: Points) -> Array:
        return np.linalg.norm(force(at)[:, 1:], axis=1) / at["F"]

    return [
        identity(
            "outputs are accelerations",
            lambda at: at.result("outputs", "ax", "ay", "az", "alpha1", "alpha2", "alpha3"),
            lambda at: accelerations(at)[:, :6],
        ),
        identity("lateral thrust", lambda at: at.result("outputs", "lateral")[:, 0], lateral),
        identity("inputs from accelerations and back", lambda at: at.call("outputs")[:, :5], _there_and_back),
        identity("turning beyond the thrust", lambda at: _demand(at)[:, 2:], _turned_beyond_thrust),
        identity("initial state", lambda at: at.call("initial"), initial),
    ]


def _demand(at: Points) -> Array:
    """Return lateral accelerations that the thrust cannot produce, with random angular accelerations."""
    return at.call("outputs")[:, :5] * np.array([40, 40, 1, 1, 1])


def _turned_beyond_thrust(at: Points) -> Array:
    u = at.machine("to_physical", at.values["x"], _demand(at), at.values["p"])
    return at.at(u=u).call("outputs")[:, 2:5]


def initial(at: Points) -> Array:
    """Return the state that a scenario describes."""
    inertia, count = at.machine.system.structure["inertia"], len(_numbers(at))
    start = {q.name: at[f"{q.name}_0"] for q in (*VELOCITY, *RATE)}
    angles = at.vector("att1_0", "att2_0", "att3_0")
    names = _attitude(at)
    start |= dict(zip(names, (rotations.quaternion(angles) if len(names) == 4 else angles).T, strict=True))
    for k in range(1, count + 1):
        own = [f"{angle}{k}{end}" for angle in ("phi", "theta") for end in ("", "_dot")]
        if inertia == "ball":
            s, slip = bodies.direction(*(at[f"{name}_0"] for name in own))
            sigma = slip + np.cross(at.vector("wx_0", "wy_0", "wz_0"), s)
            start |= {f"s{k}{axis}": s[:, i] for i, axis in enumerate("xyz")}
            start |= {f"sigma{k}{axis}": sigma[:, i] for i, axis in enumerate("xyz")}
        else:
            start |= {name: at[f"{name}_0"] for name in own}
    return np.column_stack([start[q.name] for q in at.machine.system.states if q.name in start])


def directions(at: Points) -> Array:
    """Return the directions of the bobs at the output angles."""
    angles = [at.result("outputs", f"phi{k}", f"theta{k}").T for k in _numbers(at)]
    return np.hstack([bodies.direction(phi, 0 * phi, theta, 0 * phi)[0] for phi, theta in angles])


def _arms(at: Points) -> Array:
    return np.hstack([bodies.arm(at, k)[0] for k in _numbers(at)])


def turned_by_outputs(at: Points) -> Array:
    return rotations.of_angles(at.result("outputs", "att1", "att2", "att3"))


def _there_and_back(at: Points) -> Array:
    demand = at.call("outputs")[:, :5]
    u = at.machine("to_physical", at.values["x"], demand, at.values["p"])
    return at.at(u=u).call("outputs")[:, :5]


def _prescribed() -> list[Gate]:
    """Return the gates of the reduced model, whose hull takes any wrench that its motion needs."""
    flow = "rhs_reduced"

    def hull(at: Points) -> Array:
        straight = at["F"] / (at["m"] + at["m0"] + sum(at[f"m{k}"] for k in _numbers(at)))
        return np.column_stack([straight, at.result("outputs", "ay", "az", "alpha1", "alpha2", "alpha3")])

    def wrench_power(at: Points) -> Array:
        v, w = velocity(at), rate(at)
        p, h = np.split(at.call("momentum"), 2, axis=1)
        change = at.along(lambda here: here.call("momentum"), flow)
        pushed = change[:, :3] + np.cross(w, p)
        twisted = change[:, 3:] + np.cross(w, h) + np.cross(v, p)
        return dot(v, pushed) + dot(w, twisted) - dissipation(at)

    found = [
        identity("reduced model: hull", lambda at: accelerations(at, flow)[:, :6], hull),
        balance("reduced model: power", energy, wrench_power, flow),
        identity(
            "reduced model: attitude",
            lambda at: at.result(flow, *_attitude(at)),
            lambda at: at.result("rhs", *_attitude(at)),
        ),
    ]
    return found


def _limits(count: int, structure: dict[str, str]) -> list[Gate]:
    """Return gates that compare with a rigid body, with one pendulum, and pendulums with each other."""
    weightless = {f"{name}{k}": FLOOR for name in ("m", "I", "eps") for k in range(1, count + 1)}
    rigid = identity(
        "rigid body without pendulums",
        lambda at: accelerations(at.moved(**weightless))[:, :6],
        lambda at: bodies.rigid(at, force(at), moment(at)),
    )
    if count == 1:
        return [rigid]
    first = dict(structure) | {"pendulums": "1"}
    part = machine("slosh", *first.items())
    others = {name: value for name, value in weightless.items() if _number(name) > 1}
    share = {
        f"{name}{k}": functools.partial(lambda name, at: at[name] / count, f"{name}1")
        for name in ("m", "I", "eps")
        for k in range(1, count + 1)
    }
    owned = [_own(k, structure) for k in range(1, count + 1)]
    swaps = {a: owned[(k + 1) % count][place] for k, own in enumerate(owned) for place, a in enumerate(own)}
    return [
        rigid,
        smaller("pendulums without mass", part, lambda name: "" if _number(name) > 1 else name, others),
        smaller("one pendulum as several", part, _as_first, share),
        symmetric(Symmetry("order of pendulums", swaps=swaps)),
    ]


def _own(k: int, structure: dict[str, str]) -> list[str]:
    """Return the states and parameters of pendulum k."""
    parameters = [f"{name}{k}" for name in ("m", "l", "h", "I", "eps")]
    if structure["inertia"] == "ball":
        return [*parameters, *(f"{name}{k}{axis}" for name in ("s", "sigma") for axis in "xyz")]
    return [*parameters, *(f"{name}{k}{end}" for name in ("phi", "theta") for end in ("", "_dot"))]


_PENDULUM = ("phi", "theta", "sigma", "eps", "s", "m", "l", "h", "I")


def _number(name: str) -> int:
    """Return the number of a quantity's pendulum, 0 for none."""
    for stem in _PENDULUM:
        rest = name.removeprefix(stem)
        if rest != name and rest[:1].isdigit() and rest[0] != "0":
            return int(rest[0])
    return 0


def _as_first(name: str) -> str:
    k = _number(name)
    return name.replace(str(k), "1") if k else name


def mirror(count: int, inertia: str, attitude: str) -> Symmetry:
    """Return the reflection y -> -y."""
    signs = {"vy", "wx", "wz", "Mx", "Mz", "delta2"}
    signs |= {"att1", "att3"} if attitude == "angles" else {"q1", "q3"}
    for k in range(1, count + 1):
        signs |= {f"s{k}y", f"sigma{k}y"} if inertia == "ball" else {f"theta{k}", f"theta{k}_dot"}
    return Symmetry("mirror y", frozenset(signs))


def same_bob(count: int) -> Symmetry:
    """Return the other angles of the same bob: (-phi, theta + pi)."""
    signs = {f"phi{k}{end}" for k in range(1, count + 1) for end in ("", "_dot")}
    return Symmetry("other angles of a bob", frozenset(signs), shifts={f"theta{k}": np.pi for k in range(1, count + 1)})


def _constraints(count: int) -> list[Gate]:
    def held(at: Points) -> Array:
        arms = [bodies.arm(at, k) for k in range(1, count + 1)]
        return np.column_stack([dot(s, other) for s, slip in arms for other in (s, slip)])

    return [
        balance(f"arms keep their length{title}", held, lambda at: np.zeros((len(at["F"]), 2 * count)), flow)
        for title, flow in (("", "rhs"), (", reduced model", "rhs_reduced"))
    ]


def energy(at: Points) -> Array:
    return at.call("energy")[:, 0]


def power(at: Points) -> Array:
    return dot(force(at), velocity(at)) + dot(moment(at), rate(at))


def dissipation(at: Points) -> Array:
    """Return twice the Rayleigh function (8), or its counterpart for a bob without angles."""
    if at.machine.system.structure["inertia"] == "ball":
        slips = [(k, bodies.arm(at, k)[1]) for k in _numbers(at)]
        return np.sum([at[f"eps{k}"] * dot(slip, slip) for k, slip in slips], axis=0)
    return np.sum([at[f"eps{k}"] * (at[f"phi{k}_dot"] ** 2 + at[f"theta{k}_dot"] ** 2) for k in _numbers(at)], axis=0)


def force(at: Points) -> Array:
    (s1, s2), (c1, c2) = (f(at.vector("delta1", "delta2")).T for f in (np.sin, np.cos))
    return at["F"][:, None] * np.column_stack([c1 * c2, s2, -s1 * c2])


def moment(at: Points) -> Array:
    """Return the moment about O."""
    place = np.column_stack([-(at["b"] + at["d"]), np.zeros_like(at["b"]), np.zeros_like(at["b"])])
    return at.vector("Mx", "My", "Mz") + np.cross(place, force(at))


def velocity(at: Points) -> Array:
    return at.vector("vx", "vy", "vz")


def rate(at: Points) -> Array:
    return at.vector("wx", "wy", "wz")


def accelerations(at: Points, flow: str = "rhs") -> Array:
    """Return the acceleration of O in body axes, and all rates but those of velocity."""
    dx = at.call(flow)
    return np.column_stack([dx[:, :3] + np.cross(rate(at), velocity(at)), dx[:, 3:]])


def turned(at: Points) -> Array:
    """Return the matrices from inertial to body axes."""
    names = _attitude(at)
    return rotations.of_quaternion(_q(at)) if len(names) == 4 else rotations.of_angles(at.vector(*names))


def level(at: Points) -> Points:
    """Return the points at zero attitude, where the paper's small angles are exact."""
    return at.moved(att1=0.0, att2=0.0, att3=0.0)


def unforced(at: Points) -> Points:
    return at.moved(F=0.0, Mx=0.0, My=0.0, Mz=0.0)


def _faster(at: Points) -> Points:
    return at.moved(vx=at["vx"] + 2.0, vy=at["vy"] - 1.0, vz=at["vz"] + 0.5)


def _attitude(at: Points) -> tuple[str, ...]:
    quaternion = at.machine.system.structure["attitude"] == "quaternion"
    return ("q0", "q1", "q2", "q3") if quaternion else ("att1", "att2", "att3")


def _q(at: Points) -> Array:
    return at.vector("q0", "q1", "q2", "q3")


def _numbers(at: Points) -> range:
    return range(1, int(at.machine.system.structure["pendulums"]) + 1)
