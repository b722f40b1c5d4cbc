"""A ball that bounces on the ground and keeps a part of its speed at each impact."""

from pathlib import Path

import sympy as sp

from mehvar import Controller, Event, Group, Quantity, System, read_parameters, read_scenarios

HERE = Path(__file__).parent
STRUCTURE = {}
X = Group(
    "x", (Quantity("height", "m", "height above the ground", "h"), Quantity("speed", "m/s", "speed upwards", "v"))
)
U = Group("u", (Quantity("lift", "m/s^2", "acceleration upwards", "a"),))


def system():
    """Put the system together."""
    tables = read_parameters(HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(HERE / "scenarios.toml")
    p, s = Group("p", tables["plant"].quantities), Group("s", tables["start"].quantities)
    none = Group("c", ())
    return System(
        name="bounce",
        title="a ball that bounces",
        source="an example",
        structure={},
        states=X,
        inputs=U,
        references=Group("r", ()),
        outputs=Group("y", (Quantity("energy", "m^2/s^2", "energy over mass"),)),
        parameters=p,
        scenario_parameters=s,
        rhs=(X.speed, U.lift - p.g),
        output=(p.g * X.height + X.speed**2 / 2,),
        steps=(),
        limits=(),
        initial=(s.height_0, sp.S.Zero),
        reference=(),
        constraints=(),
        functions=(),
        controllers=(Controller("fall", "no force but the weight", none, (sp.S.Zero,)),),
        scenarios=scenarios,
        metrics=metrics,
        events=(Event("impact", X.height, "falling", {X.speed: -p.e * X.speed}, title="the ball hits the ground"),),
    )
