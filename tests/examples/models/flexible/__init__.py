"""A rigid body with a full inertia tensor and two bending modes, in hybrid coordinates."""

from pathlib import Path

import sympy as sp

from mehvar import Controller, Function, Group, Quantity, System, read_parameters, read_scenarios

HERE = Path(__file__).parent
STRUCTURE = {}
AXES, MODES = "xyz", (1, 2)
X = Group(
    "x",
    (
        *(Quantity(f"w{axis}", "rad/s", f"rate about {axis}") for axis in AXES),
        *(Quantity(f"eta_{k}", "kg^(1/2) m", f"mode {k}") for k in MODES),
        *(Quantity(f"eta_dot_{k}", "kg^(1/2) m/s", f"rate of mode {k}") for k in MODES),
    ),
)
U = Group("u", tuple(Quantity(f"tau_{axis}", "N m", f"torque about {axis}") for axis in AXES))


def system():
    """Put the system together."""
    tables = read_parameters(HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(HERE / "scenarios.toml")
    p, c = Group("p", tables["plant"].quantities), Group("c", tables["damp"].quantities)
    w, eta, eta_dot = (sp.Matrix(X.symbols[a:b]) for a, b in ((0, 3), (3, 5), (5, 7)))
    s = Group("s", tables["scenario"].quantities)
    momentum = p.I * w + p.delta * eta_dot
    spring = sp.Matrix([p.omega[k] ** 2 * eta[k] + 2 * p.zeta[k] * p.omega[k] * eta_dot[k] for k in range(2)])
    mass = sp.diag(p.I, sp.eye(4))
    mass[:3, 5:], mass[5:, :3] = p.delta, p.delta.T
    energy = (w.T * p.I * w / 2 + w.T * p.delta * eta_dot + eta_dot.T * eta_dot / 2)[0]
    energy += sum((p.omega[k] * eta[k]) ** 2 for k in range(2)) / 2
    return System(
        name="flexible",
        title="a satellite with two bending modes",
        source="an example",
        structure={},
        states=X,
        inputs=U,
        references=Group("r", ()),
        outputs=Group("y", (Quantity("h", "N m s", "size of the angular momentum"),)),
        parameters=p,
        scenario_parameters=s,
        mass=mass,
        rhs=(*(sp.Matrix(U.symbols) - w.cross(momentum)), *eta_dot, *-spring),
        output=(sp.sqrt(momentum.dot(momentum)),),
        steps=(),
        limits=(),
        initial=(*s.w_0, *[sp.S.Zero] * 4),
        reference=(),
        constraints=(),
        functions=(Function("energy", (X, p), ((Quantity("E", "J", "energy"), energy),), "energy"),),
        controllers=(Controller("damp", "a torque against the rates", c, tuple(-c.gain * w)),),
        scenarios=scenarios,
        metrics=metrics,
    )
