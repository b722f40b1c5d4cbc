"""A dual-spin craft: a despun platform, a rotor whose momentum holds it, and a ball in a tube that damps nutation."""
# Likins: Attitude stability criteria for dual spin spacecraft. J. Spacecraft Rockets 4(12), 1967. Numbers are invented:
# despun, the platform nutates at h/sqrt(Jx Jy) = 1.46 rad/s, and the ball swings at 1.26 rad/s.

from mehvar.base.manifest import Metric, Scenario
from mehvar.parts import Hub, Slider, Spacecraft, Value, Wheel

STRUCTURE = {}
TUBE = {"at": (0.6, 0, 0), "axis": (0, 0, 1), "inertia": (1e-6, 1e-6, 1e-6)}


def craft():
    """Assemble the craft; the spin axis is z, and the tube lies along it beside the platform."""
    result = Spacecraft("dualspin", "a dual-spin craft with a nutation damper", motion="attitude")
    result.add(Hub("platform", mass=200.0, inertia=(80.0, 85.0, 60.0)))
    result.add(Wheel("rotor", axis=(0, 0, 1), inertia=Value(12.0, source="assumption: a third of a spun craft's")))
    result.add(Slider("ball", mass=1.0, stiffness=1.6, damping=0.4, **TUBE))
    return result


def system():
    """Put the system together, with a push that makes it nutate."""
    push = {"wx_0": 0.02, "rotor_speed_0": 10.0}
    pushed = Scenario("pushed", "nutation after a push", 600.0, 0.5, push, {}, {})
    rate = Metric("nutation", "settling", ("wx",), "s", "time after which the rate stays within 1 mrad/s", band=1e-3)
    return craft().system((pushed,), (rate,))
