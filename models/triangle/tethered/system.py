# SPDX-License-Identifier: Apache-2.0
"""The triangle with tethers on reels as a `System`.

Tethers only pull: a triangle at rest folds. In a spin it needs no more than they can give, for three points that turn
as one at Omega pull at each other with mu_ij Omega^2 l. So the target turns too, at the rate of the spin, and the
paper's laws measure the attitude beside it: with the size of the target nothing else is different.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import sympy as sp

from ...system import TIME, Actuator, Condition, Controller, Derivation, Expr, Function, Group, Quantity, System
from ...tables import read_parameters, read_scenarios
from ..controllers import shifted_state
from ..dynamic.bodies import Bodies, bodies
from ..dynamic.laws import limits, reports, wanted_rates, with_thrust
from ..dynamic.motion import Motion, motion
from ..dynamic.plant import Gravity, gravity, kinetic, plant, potential
from ..dynamic.shape import first_state, polar, rates_of_shape, shape_and_attitude
from ..dynamic.states import DRIFT, THRUST, lengths
from ..dynamic.system import ENERGIES, LIMITS, OUTPUTS, by_mass
from ..dynamics import MU, THETA, base_triangle, rod_lengths, shape_from_lengths, target_lengths
from ..geometry import geometry
from ..task import REFERENCES, SOURCE, errors, inequality, laws
from .states import INPUTS, STATES, TENSIONS, out, reels, winding
from .tethers import Tethers, tethers, turns_slack_or_taut

_HERE = Path(__file__).parent
_MOMENTUM = Quantity("H_ref", "kg m^2/s", "angular momentum of the target's spin", "H_f")
_REFERENCES = Group("r", (*REFERENCES, _MOMENTUM))
_ELASTIC = Quantity("elastic", "J", "elastic energy of the tethers")


def tethered(masses: str) -> System:
    """Derive the triangle whose masses hang on tethers.

    Parameters
    ----------
    masses : {"equal", "general"}
        One mass for all three, or m1, m2, m3.
    """
    tables, shared, own = (
        read_parameters(folder / "parameters.toml") for folder in (_HERE.parent, _HERE.parent / "dynamic", _HERE)
    )
    p = Group("p", (*shared["orbit"], *own["tethers"], *tables[f"masses_{masses}"]))
    s = Group("s", (*tables["scenario"], *shared["scenario"], *own["scenario"]))
    d = Derivation()
    massive = bodies(p, masses, "light", d)
    d.section("Base triangle")
    base = base_triangle(massive.masses, d)
    moving = motion(massive, d)
    field = gravity(p, d)
    pull = tethers(p, d)
    acting = plant(moving, field, -sp.Matrix(pull.tensions), pull.speeds, d)
    d.section("Placing a triangle with given tethers")
    start = shape_from_lengths((s.l1_0, s.l2_0, s.l3_0), base, d, "_0")
    goal = shape_from_lengths((s.l1_f, s.l2_f, s.l3_f), base, d, "_f")
    d.section("Shape and attitude")
    stretched = shape_and_attitude(base, d)
    from_shape = rod_lengths(stretched, base, d)
    asked = rates_of_shape(from_shape, d)
    d.section("Shifted coordinates")
    shifted = shifted_state(REFERENCES, tables["laws"].area_factor, d)
    final = target_lengths(from_shape, REFERENCES.rho_ref, REFERENCES.phi_ref, REFERENCES.mu_ref, d)
    plain = laws(tables, shifted, (start[0], goal[0]), d)
    controllers = {law.name: _on_reels(law, asked, shared["rates"], d) for law in plain}
    thrusting = with_thrust(controllers["path"], moving, acting, shared["thrust"], _MOMENTUM.symbol)
    commanded, applied = limits(INPUTS, {"r": p.reel_max, "f": p.thrust_max})
    _, paper_metrics = read_scenarios(_HERE.parent / "scenarios.toml")
    _, costs = read_scenarios(_HERE.parent / "dynamic" / "scenarios.toml")
    scenarios, metrics = read_scenarios(_HERE / "scenarios.toml")
    if masses == "general":
        scenarios = tuple(map(by_mass, scenarios))
    return System(
        name="triangle",
        title="three planar masses joined by tethers on reels",
        source=SOURCE,
        structure={"masses": masses, "model": "tethered", "rods": "light"},
        states=STATES,
        inputs=INPUTS,
        references=_REFERENCES,
        outputs=Group("y", (*OUTPUTS, *TENSIONS)),
        parameters=p,
        scenario_parameters=s,
        rhs=(*acting.rhs, *reels, *(p.k_r * (w - reel) for w, reel in zip(winding, reels, strict=True))),
        output=(*polar(), MU.symbol, THETA.symbol, *errors(shifted, lengths, final), *pull.tensions),
        steps=tuple(d.steps),
        limits=(
            *LIMITS,
            Condition(sp.Min(*out), "a tether is wound up wholly: no length of it is out"),
        ),
        initial=_initial(p, s, start, massive, moving),
        reference=(*goal[:3], s.theta_f + s.spin * TIME.symbol, _spin_momentum(s, massive)),
        constraints=(inequality("initial", "0", s), inequality("final", "f", s)),
        functions=(_energy(p, moving, field, pull),),
        controllers=(*controllers.values(), thrusting),
        scenarios=scenarios,
        metrics=(*paper_metrics, *(m for m in costs if m.name != "max_force"), *metrics),
        actuator=Actuator(commanded, applied),
        geometry=geometry(massive.lumps, stretched, base, REFERENCES.theta_ref),
        events=turns_slack_or_taut(pull),
    )


def _on_reels(law: Controller, asked: Sequence[Expr], rates: Group, d: Derivation) -> Controller:
    """Return reel rates that keep the strain while the lengths move at the commanded rates."""
    parameters = Group("c", (*law.parameters, *rates))
    wanted = wanted_rates(law, asked, parameters.rate_max, "Reels", d)
    command = (natural / length * rate for natural, length, rate in zip(out, lengths, wanted, strict=True))
    return dataclasses.replace(
        law,
        parameters=parameters,
        command=(*command, *(sp.S.Zero for _ in THRUST)),
        outputs=reports(wanted),
    )


def _spin_momentum(s: Group, massive: Bodies) -> Expr:
    return s.spin * _inertia(s, massive, "f")


def _inertia(s: Group, massive: Bodies, end: str) -> Expr:
    each = (mass * getattr(s, f"l{k}_{end}") ** 2 for k, mass in enumerate(massive.reduced, 1))
    return sp.Add(*each)


def _initial(p: Group, s: Group, start: tuple[Expr, ...], massive: Bodies, moving: Motion) -> tuple[Expr, ...]:
    """Return the state of a spin with the target's angular momentum and H_0 more, reels at rest.

    Tethers are as long as such a spin needs while nothing else pulls, of tension mu_ij Omega^2 l, and `slack_0` more.
    """
    momentum = _spin_momentum(s, massive) + s.H_0
    turn = momentum / _inertia(s, massive, "0")
    lengths_0 = [getattr(s, f"l{k}_0") for k in (1, 2, 3)]
    strains = [mass * turn**2 * length / p.stiffness for mass, length in zip(massive.reduced, lengths_0, strict=True)]
    natural = (length / (1 + strain) + s.slack_0 for length, strain in zip(lengths_0, strains, strict=True))
    return (*first_state(s, start, momentum), *natural, *(sp.S.Zero for _ in reels))


def _energy(p: Group, moving: Motion, field: Gravity, pull: Tethers) -> Function:
    drift = tuple(q.symbol for q in DRIFT)
    kinds = (*ENERGIES, _ELASTIC)
    values = (kinetic(moving, drift), potential(moving, field), pull.energy)
    return Function(
        "energy",
        (STATES, p),
        tuple(zip(kinds, values, strict=True)),
        "kinetic energy, potential energy in the gravity gradient, elastic energy of the tethers",
    )
