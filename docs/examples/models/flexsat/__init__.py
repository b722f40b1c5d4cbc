"""A flexible satellite: a pyramid of wheels turns it while its engine burns, panels bend and the fuel sloshes."""
# Inertia and modes: Di Gennaro, IEEE Trans. Aerosp. Electron. Syst. 39(3), 2003. Fuel in a half full sphere of radius
# R = 0.4 m swings at sqrt(1.56 a/R) under an acceleration a: McIver, J. Fluid Mech. 201, 1989. The rest is invented.

from mehvar import Scenario
from mehvar.parts import Bob, Hub, Mode, Modes, Spacecraft, Thruster, Wheel

MODES = [  # frequency in rad/s, damping ratio, participation in rotations
    Mode(0.7681, 0.0056, (0, 0, 0), (6.45637, 1.27814, 2.15629)),
    Mode(1.1038, 0.0086, (0, 0, 0), (-1.25619, 0.91756, -1.67264)),
    Mode(1.8733, 0.013, (0, 0, 0), (1.11687, 2.48901, -0.83674)),
    Mode(2.5496, 0.025, (0, 0, 0), (1.23637, -2.6581, -1.12503)),
]


def turn(law, wheels):
    """Feed the attitude back to the wheels, and burn."""
    kp, kd = law.parameter("kp", 20.0, "N m"), law.parameter("kd", 150.0, "N m s")
    (_, *q), w = law.attitude, law.rates
    wanted = [-kp * a - kd * b for a, b in zip(q, w, strict=True)]
    return law.torque(wanted, wheels) | {"engine": law.parameter("thrust", 22.0, "N")}


def system():
    """Put the system together, with a turn of 34 degrees."""
    craft = Spacecraft("flexsat", "a flexible satellite with a pyramid of wheels and a tank", period=0.1)
    craft.add(Hub("hub", mass=600.0, inertia=((350, 3, 4), (3, 270, 10), (4, 10, 190))))
    pyramid = [(1, 0, 1), (0, 1, 1), (-1, 0, 1), (0, -1, 1)]
    wheels = [craft.add(Wheel(f"wheel{k}", a, 0.1, torque_limit=1.0)) for k, a in enumerate(pyramid, 1)]
    craft.add(Modes("panels", MODES))
    craft.add(Bob("tank", mass=40.0, length=0.4 / 1.56, at=(0.3, 0.0, 0.1), damping=0.2))
    craft.add(Thruster("engine", direction=(1, 0, 0), at=(-1.0, 0.002, 0.0)))
    craft.law("turn", lambda law: turn(law, wheels), "quaternion feedback while the engine burns")
    start = {"roll_0": 0.4, "pitch_0": -0.3, "yaw_0": 0.3, "tank_phi_0": 0.2}
    return craft.system((Scenario("burn", "a turn during a burn", 120.0, 0.1, start, {}, {}),))
