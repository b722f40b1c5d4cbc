"""Gemini XI on a tether with its Agena: a slow rotation keeps the tether taut, thrust makes the rotation faster."""
# Tether of 100 feet, 38 and then 55 degrees per minute: Lang, Nolting: Operations with tethered space vehicles. Gemini
# Summary Conference, NASA SP-138, 1967. Masses are those at launch. Inertia, mounts, stiffness and thrust are invented.

import sympy as sp

from mehvar import TIME, Scenario
from mehvar.parts import Hub, Spacecraft, Tether, Thruster


def spin(law):
    """Push across the tether for a while."""
    begin, time = law.parameter("begin", 600.0, "s"), law.parameter("time", 30.0, "s")
    on = sp.And(TIME.symbol >= begin, TIME.symbol < begin + time)
    return {"jet": sp.Piecewise((law.parameter("thrust", 25.0, "N"), on), (0, True))}


def system():
    """Put the system together; at the start the tether is slack by 0.5 m, and neither body turns."""
    craft = Spacecraft("gemini", "Gemini XI and its Agena on a tether", period=1.0)
    craft.add(Hub("hub", mass=3798.0, inertia=(1600.0, 6700.0, 6700.0)))
    body = {"mass": 3175.0, "inertia": (1500.0, 10000.0, 10000.0), "mount": (-3.5, 0, 0), "start": (36.18, 0, 0)}
    line = {"length": 30.48, "stiffness": 200.0, "damping": 50.0}
    craft.add(Tether("agena", at=(2.7, 0, 0), **body, **line))
    craft.add(Thruster("jet", direction=(0, -1, 0)))
    craft.law("spin", spin, "a push across the tether")
    start = {"agena_vy_0": 0.4, "agena_vz_0": 0.02}
    return craft.system((Scenario("rotation", "38 and then 55 degrees per minute", 1200.0, 2.0, start, {}, {}),))
