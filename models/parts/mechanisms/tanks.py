# SPDX-License-Identifier: Apache-2.0
"""Draining tanks: the outflow removes momentum, and fuel in the line to the nozzle rotates with the craft."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...quantities import ModelError, Quantity
from ...system import Condition
from ..frame import ZERO
from ..motion import Motion
from ..part import Mounted, Part
from ..terms import Aggregates, Contribution, Load, State
from ..values import Number, Parameters, Value, Vector, constant, direction, place, plain, scalar
from .bobs import Bob


@dataclass(frozen=True)
class _Lump:
    """Fuel at one point: its share of all fuel, position from O, velocity and rate relative to the hub."""

    share: Expr
    at: sp.Matrix
    velocity: sp.Matrix


@dataclass(frozen=True)
class Tank(Part):
    """A tank that feeds a nozzle. Its fuel is a point mass, of which a share may swing on a ball joint.

    Fuel leaves bob and tank in proportion to their fuel, flows along straight lines of no volume, and leaves at the
    nozzle. A flow w over the distance d exerts the force -2 w d' on the line, which damps the rates of the craft. The
    hub bears the lines and this force, also that of the fuel from the bob. The flow is steady: transients of the valve
    are neglected. A run ends when the tank is empty.

    Parameters
    ----------
    name : str
        As of a `Part`. Its state is NAME_fuel, its input NAME_flow, kg/s; those of the bob begin with NAME_bob.
    mass : number
        Fuel at the start, kg: the scenario's NAME_fuel_0.
    nozzle : three numbers
        Where the fuel leaves, m.
    thrust : three numbers, optional
        Direction of the force on the hub; any length. Leave it out if an `Engine` burns the fuel.
    exhaust : number, optional
        Exhaust velocity, m/s.
    at : three numbers
        Place of the fuel, and the pivot of the bob, m.
    flow : number, optional
        Largest flow, kg/s.
    reserve : number, optional
        Remaining fuel below which commands no longer open the valve, kg, less than `mass`; the run continues without
        thrust. An open valve closes at the next command, after at most one period: at 0.3 kg/s and 0.1 s it drains up
        to 0.03 kg below the reserve.
    share : number, optional
        Share of the fuel that swings.
    length, damping : number, optional
        As of a `Bob`; the damping is divided by the swinging mass, m^2/s.
    rest : three numbers
        As of a `Bob`.
    """

    mass: float | Value
    nozzle: Annotated[Vector, place("n", "nozzle")]
    thrust: Annotated[Vector | None, direction("t", "direction of the thrust")] = None
    exhaust: Annotated[Number | None, scalar("ve", "m/s", "velocity of what leaves")] = None
    at: Annotated[Vector, place("r", "place")] = (0, 0, 0)
    flow: Annotated[Number | None, scalar("wmax", "kg/s", "largest flow", absent=sp.oo)] = None
    reserve: Annotated[Number | None, scalar("m_min", "kg", "fuel that stays", "[0, inf)", absent=-sp.oo)] = None
    share: Annotated[Number | None, scalar("share", "1", "part of the fuel that swings", "(0, 1)", absent=0)] = None
    length: Annotated[Number | None, scalar("l", "m", "length of the rod")] = None
    damping: Annotated[Number | None, scalar("c", "m^2/s", "damping over mass", "[0, inf)", absent=0)] = None
    rest: tuple[int, int, int] = (-1, 0, 0)

    def __post_init__(self) -> None:
        if (self.thrust is None) != (self.exhaust is None):
            raise ModelError(f"{self.name}: an engine force needs both thrust and exhaust; give both, or neither")
        if (self.share is None) != (self.length is None):
            raise ModelError(f"{self.name}: a bob needs both share and length; give both, or neither")
        if self.share is None and self.damping is not None:
            raise ModelError(f"{self.name}.damping needs a bob: give share and length")
        if self.share is None and plain(self.rest) not in ((-1, 0, 0), [-1, 0, 0]):
            raise ModelError(f"{self.name}.rest needs a bob: give share and length")
        kept, full = constant(self.reserve), constant(self.mass)
        if kept is not None and full is not None and kept >= full:
            raise ModelError(f"{self.name}.reserve = {kept}: must be less than mass = {full}, or the valve never opens")
        self._bobs  # its own checks  # noqa: B018

    @property
    def fuel(self) -> sp.Symbol:
        """Symbol of the remaining fuel, kg."""
        return self._fuel.symbol

    @property
    def _fuel(self) -> Quantity:
        return Quantity(f"{self.name}_fuel", "kg", f"fuel in {self.name}", positive=True)

    @property
    def _bobs(self) -> tuple[Bob, ...]:
        """The bob, if the tank has one."""
        return () if self.share is None else (Bob(f"{self.name}_bob", mass=1.0, length=1.0, rest=self.rest),)

    def _swinging(self, at: Mounted) -> list[tuple[Bob, Mounted]]:
        """Return the bob with current mass and damping."""
        v = at.values
        mass = at.define("swinging", v.share * self.fuel, "fuel that swings", "kg")
        damping = at.define("damping", v.damping * mass, "damping of the bob", "N m s")
        values = SimpleNamespace(mass=mass, length=v.length, at=v.at, damping=damping, inertia=sp.S.Zero)
        return [(bob, Mounted(bob.name, values, at.craft)) for bob in self._bobs]

    def _lumps(self, at: Mounted) -> list[_Lump]:
        """Return the fuel as one point at rest or, with a bob, a second point that swings."""
        v = at.values
        swinging = (
            _Lump(v.share, v.at + v.length * bob.direction, v.length * bob.slip(mounted))
            for bob, mounted in self._swinging(at)
        )
        return [_Lump(1 - v.share, v.at, ZERO), *swinging]

    def inputs(self) -> tuple[Quantity, ...]:
        return (Quantity(f"{self.name}_flow", "kg/s", f"flow out of {self.name}"),)

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        full = scenario.add(
            f"{self._fuel.name}_0", self.mass, "kg", f"{self._fuel.description} at the start", "(0, inf)"
        )
        return (State(self._fuel, full), *(state for bob in self._bobs for state in bob.states(scenario)))

    def projection(self) -> Mapping[sp.Symbol, Expr]:
        return {symbol: value for bob in self._bobs for symbol, value in bob.projection().items()}

    def aggregates(self, at: Mounted) -> Aggregates:
        rest = Aggregates.body((1 - at.values.share) * self.fuel, at.values.at)
        return sum((bob.aggregates(mounted) for bob, mounted in self._swinging(at)), rest)

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        v = at.values
        return () if v.thrust is None else (Load(self.inputs()[0].symbol * v.exhaust * v.thrust, v.nozzle),)

    def contribution(self, at: Mounted) -> Contribution:
        lines = tuple(self._lines(at))
        rest = Aggregates.body((1 - at.values.share) * self.fuel, at.values.at)
        result = Contribution(rest.mass, rest.first, rest.inertia, loads=lines)
        for bob, mounted in self._swinging(at):
            own = bob.contribution(mounted)
            result = replace(result, loads=(*own.loads, *lines), followers=own.followers)
        return result

    def _lines(self, at: Mounted) -> list[Load]:
        """Return the loads of the fuel lines on the hub, which act at the middle of each line."""
        flow, nozzle, result = self.inputs()[0].symbol, at.values.nozzle, []
        for k, lump in enumerate(self._lumps(at), 1):
            reach = nozzle - lump.at
            changing = at.vector(f"reach{k}_", at.frame.rate.cross(reach) - lump.velocity, "rate of the line", "m/s")
            result.append(Load(-2 * flow * lump.share * changing, (lump.at + nozzle) / 2))
        return result

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        own = (rate for bob, mounted in self._swinging(at) for rate in bob.rates(mounted, motion))
        return (-self.inputs()[0].symbol, *own)

    def carried(self, at: Mounted, velocity: sp.Matrix) -> tuple[Load, Expr]:
        flow, w, nozzle = self.inputs()[0].symbol, at.frame.rate, at.values.nozzle
        force, couple, power = ZERO, ZERO, sp.S.Zero
        for lump in self._lumps(at):  # by a balance over a volume that ends at the nozzle, with steady lines in it
            out, leaving = flow * lump.share, velocity + w.cross(lump.at) + lump.velocity
            held, turning = out * (nozzle - lump.at), out * lump.at.cross(nozzle)
            outflow = out * (velocity + w.cross(nozzle))
            push = out * lump.velocity - outflow - w.cross(held)
            twist = -nozzle.cross(outflow) - w.cross(turning) - velocity.cross(held) - out * lump.velocity.cross(nozzle)
            force, couple = force + push, couple + twist
            lost = -out * leaving
            power += lost.dot(leaving) / 2 + velocity.dot(push - lost) + w.dot(twist - lump.at.cross(lost))
        return Load(force, ZERO, couple), power

    def applied(self, at: Mounted, commanded: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
        flow = sp.Min(sp.Max(commanded[0], 0), at.values.flow)
        return (sp.Piecewise((0, self.fuel <= at.values.reserve), (flow, True)),)

    def limits(self, at: Mounted) -> tuple[Condition, ...]:
        return (Condition(self.fuel, f"the fuel in {self.name} is used up"),)
