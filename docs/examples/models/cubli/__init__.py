"""The one-dimensional prototype of the Cubli: it brakes its wheel, jumps up from its side, and balances.

Gajamohan, Merz, Thommen, D'Andrea: The Cubli, IROS 2012. Braking conserves the angular momentum about the pivot.
"""

from pathlib import Path

import sympy as sp

from mehvar import Controller, Event, Group, Quantity, System, read_parameters, read_scenarios

HERE, STRUCTURE = Path(__file__).parent, {}
X = Group("x", (
    Quantity("angle", "rad", "tilt of the body from the top", r"\theta_b"),
    Quantity("rate", "rad/s", "rate of the body", r"\omega_b"),
    Quantity("wheel", "rad/s", "rate of the wheel in the body", r"\omega_w"),
    Quantity("phase", "1", "mode: 0 lies and spins up, 1 jumps, 2 balances"),
))  # fmt: skip
U, NONE = Group("u", (Quantity("T", "N m", "torque of the motor", "T"),)), sp.S.Zero


def system():
    """Put the system together."""
    tables, (scenarios, metrics) = read_parameters(HERE / "parameters.toml"), read_scenarios(HERE / "scenarios.toml")
    p, c = Group("p", tables["plant"].quantities), Group("c", tables["law"].quantities)
    pivot, drive = p.I_b + p.m_w * p.l**2, U.T - p.C_w * X.wheel
    falls = (p.m_b * p.l_b + p.m_w * p.l) * p.g * sp.sin(X.angle) - p.C_b * X.rate
    lies, balances = X.phase < sp.S.Half, X.phase > sp.Rational(3, 2)
    turns = sp.Piecewise((NONE, lies), ((falls - drive) / pivot, True))
    stopped = (p.I_w * (X.rate + X.wheel) + pivot * X.rate) / (p.I_w + pivot)
    regulator = c.k_1 * X.angle + c.k_2 * X.rate + c.k_3 * X.wheel
    return System(
        name="cubli", title="a cube on its edge that jumps up by braking its wheel",
        source="Gajamohan et al., IROS 2012", states=X, inputs=U,
        parameters=p,
        rhs=(sp.Piecewise((NONE, lies), (X.rate, True)), turns, drive / p.I_w - turns, NONE),
        initial=(-sp.pi / 4, NONE, NONE, NONE),
        scenarios=scenarios, metrics=metrics,
        controllers=(Controller(
            "stand_up", "spin up, then balance", c, (sp.Piecewise((c.spin, lies), (regulator, balances), (0, True)),),
        ),),
        events=(
            Event("brake", X.wheel - p.jump, "rising", {X.rate: stopped, X.wheel: NONE, X.phase: sp.S.One},
                  title="the wheel is stopped"),
            Event("catch", X.angle + p.catch, "rising", {X.phase: sp.Integer(2)}, title="the law sets in"),
            Event("land", X.angle + sp.pi / 4, "falling", {X.rate: NONE, X.phase: NONE}, title="it falls"),
        ),
    )  # fmt: skip
