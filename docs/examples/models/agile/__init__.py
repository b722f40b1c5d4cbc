"""An agile craft: four control moment gyros in a pyramid turn it through an elliptic singularity."""
# Numbers and law: Wie, Bailey, Heiberg, J. Guid. Contr. Dyn. 24(5), 2001. Invented: mass, inertia and lag of the gyros.

import sympy as sp

from mehvar import TIME, Output, Quantity, Scenario
from mehvar.parts import ControlMomentGyro, Hub, Spacecraft

PYRAMID = [((4, 0, 3), (0, 1, 0)), ((0, 4, 3), (-1, 0, 0)), ((-4, 0, 3), (0, -1, 0)), ((0, -4, 3), (1, 0, 0))]


def steer(law, inertia, angles):
    """Turn the hub by gimbal rates of the singularity-robust inverse, which exist at every set of angles."""
    h, k, c = law.parameter("h", 1000.0, "N m s"), law.parameter("k", 9.0, "1/s^2"), law.parameter("c", 5.4, "1/s")
    fast, most, pace = (law.parameter(n, v, "rad/s") for n, v in (("fast", 0.1745), ("most", 2.0), ("pace", 1.571)))
    (_, *q), w = law.attitude, sp.Matrix(law.rates)
    axes = [(sp.Matrix(s), sp.Matrix(g).cross(sp.Matrix(s)) / 5) for g, s in PYRAMID]
    momentum = sum((sp.cos(angles[i]) * s + sp.sin(angles[i]) * n for i, (s, n) in enumerate(axes)), sp.zeros(3, 1))
    effect = law.define("A", momentum.jacobian(angles))
    square = law.define("AA", effect * effect.T)
    measure = law.define("det", square.det())
    law.report(Output(Quantity("measure", "1", "singularity measure"), sp.sqrt(measure)))
    e1, e2, e3 = (sp.sin(pace * TIME.symbol + n * sp.pi / 2) / 100 for n in range(3))
    dither = sp.Matrix([[1, e3, e2], [e3, 1, e1], [e2, e1, 1]])
    robust = law.define("P", square + sp.exp(-10 * measure) / 100 * dither)
    wanted = [inertia[i] / h * (sp.Max(-c * fast, sp.Min(c * fast, 2 * k * q[i])) + c * w[i]) for i in range(3)]
    change = law.define("change", sp.Matrix(wanted) - w.cross(momentum), "1/s")
    rates = law.define("rate", effect.T * robust.adjugate() * change / robust.det(), "rad/s")
    return {f"gyro{i}": rate / sp.Max(1, *(abs(r) / most for r in rates)) for i, rate in enumerate(rates, 1)}


def system():
    """Put the system together, with a turn of 47 degrees about x."""
    craft = Spacecraft("agile", "four control moment gyros in a pyramid", motion="attitude", period=0.05)
    inertia = [craft.parameter(f"J{a}", j, "kg m^2") for a, j in (("x", 21400.0), ("y", 20100.0), ("z", 5000.0))]
    craft.add(Hub("hub", mass=5000.0, inertia=inertia))
    rotor = {"inertia": 1.6, "speed": 625.0, "gimbal_inertia": 2.0, "across": 1.5, "lag": 0.02}
    gyros = [craft.add(ControlMomentGyro(f"gyro{i}", g, s, **rotor)) for i, (g, s) in enumerate(PYRAMID, 1)]
    craft.law("steer", lambda law: steer(law, inertia, [g.gimbal_angle for g in gyros]), "singularity-robust steering")
    return craft.system((Scenario("turn", "a turn about x", 15.0, 0.05, {"roll_0": -0.823}, {}, {}),))
