# SPDX-License-Identifier: Apache-2.0
"""The one-dimensional prototype of the Cubli: it brakes its wheel, jumps up from its side, and balances.

Gajamohan, Merz, Thommen, D'Andrea: The Cubli, IROS 2012. Braking conserves the angular momentum about the pivot.
"""

from pathlib import Path

import sympy as sp

from mehvar import Controller, Event, Group, Quantity, System, read_parameters, read_scenarios

HERE = Path(__file__).parent
STRUCTURE = {}
X = Group("x", (
    Quantity("angle", "rad", "tilt of the body from the top", r"\theta_b"),
    Quantity("rate", "rad/s", "rate of the body", r"\omega_b"),
    Quantity("wheel", "rad/s", "rate of the wheel in the body", r"\omega_w"),
    Quantity("phase", "1", "mode: 0 lies and spins up, 1 jumps, 2 balances"),
))  # fmt: skip
U = Group("u", (Quantity("T", "N m", "torque of the motor", "T"),))


def system():
    """Put the system together."""
    tables = read_parameters(HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(HERE / "scenarios.toml")
    p, c = Group("p", tables["plant"].quantities), Group("c", tables["law"].quantities)
    pivot = p.I_b + p.m_w * p.l**2
    weight = (p.m_b * p.l_b + p.m_w * p.l) * p.g * sp.sin(X.angle)
    drive = U.T - p.C_w * X.wheel
    falls = weight - p.C_b * X.rate
    lies, balances = X.phase < sp.S.Half, X.phase > sp.Rational(3, 2)
    after = p.I_w * (X.rate + X.wheel) + pivot * X.rate
    return System(
        name="cubli",
        title="a cube on its edge that jumps up by braking its wheel",
        source="Gajamohan et al., IROS 2012",
        structure={},
        states=X,
        inputs=U,
        references=Group("r", ()),
        outputs=Group("y", ()),
        parameters=p,
        scenario_parameters=Group("s", ()),
        rhs=(
            sp.Piecewise((sp.S.Zero, lies), (X.rate, True)),
            sp.Piecewise((sp.S.Zero, lies), ((falls - drive) / pivot, True)),
            sp.Piecewise((drive / p.I_w, lies), (drive / p.I_w - (falls - drive) / pivot, True)),
            sp.S.Zero,
        ),
        output=(),
        steps=(),
        limits=(),
        initial=(-sp.pi / 4, sp.S.Zero, sp.S.Zero, sp.S.Zero),
        reference=(),
        constraints=(),
        functions=(),
        controllers=(
            Controller("stand_up", "spin up, then balance", c, (
                sp.Piecewise((c.spin, lies), (c.k_1 * X.angle + c.k_2 * X.rate + c.k_3 * X.wheel, balances), (0, True)),
            )),
        ),
        scenarios=scenarios,
        metrics=metrics,
        events=(
            Event("brake", X.wheel - p.jump, "rising", {
                X.rate: after / (p.I_w + pivot), X.wheel: sp.S.Zero, X.phase: sp.S.One,
            }, title="the wheel is stopped"),
            Event("catch", X.angle + p.catch, "rising", {X.phase: sp.Integer(2)}, title="the law sets in"),
            Event("land", X.angle + sp.pi / 4, "falling", {X.rate: sp.S.Zero, X.phase: sp.S.Zero}, title="it falls"),
        ),
    )  # fmt: skip
