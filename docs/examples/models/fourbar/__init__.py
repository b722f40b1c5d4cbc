"""Three bars on a frame, a closed loop: rates and joint forces from one mass matrix, lengths kept by the projection."""

from pathlib import Path

import sympy as sp

from mehvar import Controller, Function, Group, Quantity, System, read_parameters, read_scenarios

HERE, STRUCTURE, BARS = Path(__file__).parent, {}, ("crank", "coupler", "rocker")
X = Group("x", (
    *(Quantity(f"phi_{k}", "rad", f"angle of the {bar}", rf"\phi_{k}") for k, bar in enumerate(BARS, 1)),
    *(Quantity(f"w_{k}", "rad/s", f"rate of the {bar}", rf"\omega_{k}") for k, bar in enumerate(BARS, 1)),
    *(Quantity(f"S_{axis}", "N s", f"impulse of the force in the joint, {axis}") for axis in "xy"),
))  # fmt: skip
U, PHI, W = (
    Group("u", (Quantity("tau", "N m", "torque on the crank"),)),
    *map(sp.Matrix, (X.symbols[:3], X.symbols[3:6])),
)


def system():
    """Put the system together."""
    tables, (scenarios, metrics) = read_parameters(HERE / "parameters.toml"), read_scenarios(HERE / "scenarios.toml")
    p, s, c = (
        Group(name, tables[of].quantities) for name, of in zip("psc", ("plant", "scenario", "drive"), strict=True)
    )
    bars = [length * sp.Matrix([sp.cos(phi), sp.sin(phi)]) for length, phi in zip(p.l, PHI, strict=True)]
    gap, kinetic, potential = bars[0] + bars[1] - bars[2] - sp.Matrix([p.d, 0]), sp.S.Zero, sp.S.Zero
    for k, middle in enumerate((bars[0] / 2, bars[0] + bars[1] / 2, bars[2] / 2)):
        velocity = middle.jacobian(PHI) * W
        kinetic += p.m[k] * (velocity.dot(velocity) + p.l[k] ** 2 * W[k] ** 2 / 12) / 2
        potential += p.m[k] * p.g * middle[1]
    momentum, G = sp.Matrix([kinetic]).jacobian(W).T, gap.jacobian(PHI)
    force = sp.Matrix([U.tau, 0, 0]) + sp.Matrix([kinetic - potential]).jacobian(PHI).T
    mass = sp.diag(sp.eye(3), momentum.jacobian(W), sp.zeros(2))
    mass[3:6, 6:], mass[6:, 3:6] = G.T, G
    close = G[:, 1:].inv()  # what the other two do to keep the loop closed
    return System(
        name="fourbar", title="a four-bar linkage", source="an example", states=X, inputs=U,
        outputs=Group("y", tuple(Quantity(f"gap_{k}", "m", "of the loop") for k in "xy")),
        parameters=p, scenario_parameters=s, mass=mass,
        rhs=(*W, *(force - momentum.jacobian(PHI) * W), *(-(G * W).jacobian(PHI) * W)), output=tuple(gap),
        projection=(X.phi_1, *(PHI[1:, :] - close * gap), X.w_1, *(-close * G[:, :1] * X.w_1), X.S_x, X.S_y),
        initial=initial(p, s), scenarios=scenarios, metrics=metrics,
        functions=(Function("energy", (X, p), ((Quantity("E", "J", "energy"), kinetic + potential),), "energy"),),
        controllers=(
            Controller("drive", "a torque for the rate of the crank", c, (c.gain * (c.speed - X.w_1),)),
            Controller("sampled", "the same, sampled", c, (c.gain * (c.speed - X.w_1),), period="T_s"),
        ),
    )  # fmt: skip


def initial(p, s):
    """Return the closed loop at the angle and the rate of the crank."""
    x, y = p.d - p.l_1 * sp.cos(s.phi_0), -p.l_1 * sp.sin(s.phi_0)
    far = sp.sqrt(x**2 + y**2)
    coupler = sp.atan2(y, x) + sp.acos((far**2 + p.l_2**2 - p.l_3**2) / (2 * p.l_2 * far))
    rocker = sp.atan2(p.l_2 * sp.sin(coupler) - y, p.l_2 * sp.cos(coupler) - x)
    w_2 = p.l_1 * sp.sin(rocker - s.phi_0) / (p.l_2 * sp.sin(coupler - rocker)) * s.w_0
    w_3 = p.l_1 * sp.sin(coupler - s.phi_0) / (p.l_3 * sp.sin(coupler - rocker)) * s.w_0
    return (s.phi_0, coupler, rocker, s.w_0, w_2, w_3, sp.S.Zero, sp.S.Zero)
