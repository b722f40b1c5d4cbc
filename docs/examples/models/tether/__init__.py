"""Two masses on a taut tether in an elliptic orbit: libration in the plane, with the true anomaly as a state."""

from pathlib import Path

import sympy as sp

from mehvar import Controller, Derivation, Group, Quantity, System, read_parameters, read_scenarios

HERE, STRUCTURE = Path(__file__).parent, {}
X = Group("x", (
    Quantity("nu", "rad", "true anomaly", r"\nu"), Quantity("theta", "rad", "angle from the vertical", r"\theta"),
    Quantity("spin", "rad/s", "rate of the tether in fixed axes", r"\omega"),
))  # fmt: skip
U = Group("u", (Quantity("tau", "N m", "torque on the tether", r"\tau"),))


def system():
    """Put the system together."""
    tables, (scenarios, metrics) = read_parameters(HERE / "parameters.toml"), read_scenarios(HERE / "scenarios.toml")
    p, s, c = (Group(name, tables[of].quantities) for name, of in (("p", "plant"), ("s", "scenario"), ("c", "damp")))
    d = Derivation()
    radius = d.define("R", p.a * (1 - p.ecc**2) / (1 + p.ecc * sp.cos(X.nu)), title="distance of the orbit")
    momentum = d.define("h", sp.sqrt(p.mu * p.a * (1 - p.ecc**2)), title="angular momentum of the orbit, by mass")
    inertia = d.define("J", p.m_1 * p.m_2 / (p.m_1 + p.m_2) * p.l**2, title="inertia about the centre of mass")
    gradient = d.define("N", -3 * p.mu / radius**3 * inertia * sp.sin(X.theta) * sp.cos(X.theta), title="tidal torque")
    law = (-c.gain * (X.spin - momentum / radius**2),)
    start = sp.sqrt(p.mu / p.a**3 * (1 + p.ecc) / (1 - p.ecc) ** 3)  # of the orbit at perigee
    return System(
        name="tether", title="a tether in an elliptic orbit", source="an example", states=X, inputs=U,
        outputs=Group("y", (Quantity("H", "N m s", "angular momentum of the tether"),)),
        parameters=p, scenario_parameters=s, mass=sp.Matrix([[radius**2, 0, 0], [1, 1, 0], [0, 0, inertia]]),
        rhs=(momentum, X.spin, gradient + U.tau), output=(inertia * X.spin,), steps=tuple(d.steps),
        initial=(sp.S.Zero, s.theta_0, start + s.turn_0),
        controllers=(
            Controller("damp", "a torque against the libration", c, law),
            Controller("sampled", "the same, sampled", c, law, period="T_s"),
        ),
        scenarios=scenarios, metrics=metrics,
    )  # fmt: skip
