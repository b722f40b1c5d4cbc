# SPDX-License-Identifier: Apache-2.0
"""Loads of the environment: gravity gradient, magnetic torque on dipoles, air drag and sunlight.

The air's velocity is that of the craft's centre of mass; the craft's rotation is neglected.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...quantities import ModelError, Quantity
from ..frame import point_inertia
from ..hub import Pulsed
from ..mechanisms.tethers import Rod
from ..part import Mounted, Part, clipped
from ..terms import Load
from ..values import Number, Vector, direction, place, scalar, vector
from .orbit import sky


@dataclass(frozen=True)
class GravityGradient(Part):
    """Torque and force of the gravity gradient on the whole craft as a rigid body, without bodies on rods or tethers.

    With J the inertia about the centre of mass, n the direction from the Earth and k = mu/r^3 the torque is
    3 k n x J n, and the force 3 k/(2 r) ((5 n.J n - tr J) n - 2 J n): both follow from the potential k (3 n.J n - tr
    J)/2. (Hughes, Spacecraft Attitude Dynamics, 1986, 8.1.)

    Parameters
    ----------
    name : str
        As of a `Part`.
    """

    name: str = "gradient"

    def doubles(self, other: Part) -> bool:
        return isinstance(other, GravityGradient)

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        if beside := [part.name for part, _ in at.craft.parts if isinstance(part, Rod)]:
            raise ModelError(
                f"{at.name}: the GravityGradient acts on one rigid body, but {', '.join(beside)} moves beside the hub: "
                "leave one of both out"
            )
        here, whole = sky(at), at.craft.whole()
        mass = at.define("m", whole.mass, "mass", "kg")
        centre = at.vector("c", whole.first / mass, "centre of mass", "m")
        inertia = whole.inertia - point_inertia(mass, centre)
        inertia = at.tensor("J", inertia, "inertia about the centre of mass", "kg m^2")
        up = here.up
        turned = at.vector("Jn", inertia * up, "inertia times the direction from the Earth", "kg m^2")
        along = at.define("nJn", up.dot(turned), "moment of inertia along that direction", "kg m^2")
        force = 3 * here.pull / (2 * here.radius) * ((5 * along - inertia.trace()) * up - 2 * turned)
        return (Load(at.vector("F", force, "force", "N"), centre, 3 * here.pull * up.cross(turned)),)


@dataclass(frozen=True)
class Dipole(Part):
    """A residual magnetic dipole in the Earth's field.

    Parameters
    ----------
    name : str
        As of a `Part`.
    moment : three numbers
        In the axes of the hub, A m^2.
    """

    moment: Annotated[Vector, vector("m", "A m^2", "magnetic dipole")]

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        return (Load(couple=at.values.moment.cross(sky(at).field)),)


@dataclass(frozen=True)
class Magnetorquer(Pulsed):
    """A coil or rod whose dipole a law commands; its torque is that of the Earth's field.

    Parameters
    ----------
    name : str
        As of a `Part`; its input is NAME_dipole, in A m^2.
    axis : three numbers
        Axis of its dipole, of any length.
    limit : number, optional
        Largest dipole, A m^2.
    duty : number, optional
        Share of each sample period in which it acts, from the begin on. In the rest it is off, so that a magnetometer
        measures without it; default: it is always on.
    """

    axis: Annotated[Vector, direction("a", "axis")]
    limit: Annotated[Number | None, scalar("mmax", "A m^2", "largest dipole", absent=sp.oo)] = None
    duty: Annotated[Number | None, scalar("duty", "1", "share of a period in which it acts", "(0, 1]")] = None

    @property
    def pulses(self) -> bool:
        return self.duty is not None

    def share(self, at: Mounted) -> Expr:
        share: Expr = at.values.duty
        return share

    def inputs(self) -> tuple[Quantity, ...]:
        return (Quantity(f"{self.name}_dipole", "A m^2", f"magnetic dipole of {self.name}"),)

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        dipole = sp.Piecewise((self.inputs()[0].symbol, self.on(at)), (0, True))
        return (Load(couple=dipole * at.values.axis.cross(sky(at).field)),)

    def mean_loads(self, at: Mounted) -> tuple[Load, ...]:
        share = at.values.duty if self.pulses else sp.S.One
        return (Load(couple=share * self.inputs()[0].symbol * at.values.axis.cross(sky(at).field)),)

    def applied(self, at: Mounted, commanded: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
        return (clipped(commanded[0], at.values.limit),)


@dataclass(frozen=True)
class Drag(Part):
    """Drag on a sphere or on one side of a flat plate: -rho C A |v| v/2, with the projected area of a plate.

    Parameters
    ----------
    name : str
        As of a `Part`.
    area : number
        m^2.
    at : three numbers
        Centre of pressure, m.
    normal : three numbers, optional
        Outward normal of the plate, any length; a sphere without.
    coefficient : number
        Drag coefficient.
    """

    area: Annotated[Number, scalar("A", "m^2", "area")]
    at: Annotated[Vector, place("r", "centre of pressure")] = (0, 0, 0)
    normal: Annotated[Vector | None, direction("n", "outward normal")] = None
    coefficient: Annotated[Number, scalar("Cd", "1", "drag coefficient", "[0, inf)")] = 2.2

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        v, here = at.values, sky(at)
        wind = here.wind
        speed = at.define("speed", sp.sqrt(wind.dot(wind)), "speed through the air", "m/s")
        faced = speed if v.normal is None else sp.Max(0, v.normal.dot(wind))
        return (Load(at.vector("F", -here.density * v.coefficient * v.area / 2 * faced * wind, "drag", "N"), v.at),)


@dataclass(frozen=True)
class SunPressure(Part):
    """Pressure of sunlight on a sphere or on one side of a flat plate.

    A plate reflects the share rho of the light specularly and the share delta diffusely. With the cosine c of the
    angle of incidence the force is -P A c ((1 - rho) s + 2 (rho c + delta/3) n). (Wertz, Spacecraft Attitude
    Determination and Control, 1978, 17.2.) Integrated over a sphere it is -P A (1 + 4 delta/9) s.

    Parameters
    ----------
    name : str
        As of a `Part`.
    area : number
        m^2.
    at : three numbers
        Centre of pressure, m.
    normal : three numbers, optional
        Outward normal of the plate, any length; a sphere without.
    mirrored : number, optional
        Share of light that a plate reflects specularly; default: 0.6.
    scattered : number
        Share of light that is reflected diffusely.
    """

    area: Annotated[Number, scalar("A", "m^2", "area")]
    at: Annotated[Vector, place("r", "centre of pressure")] = (0, 0, 0)
    normal: Annotated[Vector | None, direction("n", "outward normal")] = None
    mirrored: Annotated[Number | None, scalar("rho", "1", "part of the light that is mirrored", "[0, 1]")] = None
    scattered: Annotated[Number, scalar("delta", "1", "part of the light that is scattered", "[0, 1]")] = 0.0

    def __post_init__(self) -> None:
        if self.normal is not None and self.mirrored is None:
            object.__setattr__(self, "mirrored", 0.6)  # of solar cells and foil, as that of the satellite's surface
        if self.normal is None and self.mirrored is not None:
            raise ModelError(f"{self.name}.mirrored applies only to a plate: give a normal, or leave mirrored out")

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        v, here = at.values, sky(at)
        pressure = here.sunlight * here.light * v.area
        if v.normal is None:
            force = -pressure * (1 + sp.Rational(4, 9) * v.scattered) * here.sun
        else:
            cosine = at.define("c", sp.Max(0, v.normal.dot(here.sun)), "cosine of the angle of the light", "1")
            shares = (1 - v.mirrored) * here.sun + 2 * (v.mirrored * cosine + v.scattered / 3) * v.normal
            force = -pressure * cosine * shares
        return (Load(at.vector("F", force, "pressure of sunlight", "N"), v.at),)
