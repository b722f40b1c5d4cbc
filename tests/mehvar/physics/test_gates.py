# SPDX-License-Identifier: Apache-2.0
"""Every model against the physics that it declares, its units and its parameters; and gates against known errors."""

from __future__ import annotations

import dataclasses

import pytest
import sympy as sp

from mehvar.codegen.functions.requests import requests
from mehvar.models.system import Definition, Group, Parameter
from mehvar.physics.gates import TOLERANCE, balance, dot, gates, identity, never_rises, symmetric
from mehvar.physics.machine import Machine, Points, points
from mehvar.physics.signature import idle_parameters
from tests.mehvar.physics import bodies, slosh
from tests.mehvar.physics.declared import CASES, EVERY, FURTHER, Case, gates_of, title
from tests.mehvar.physics.installed import machine
from tests.mehvar.physics.units import SAME_TORQUE, SCALES, misfit
from tests.sampling import RANGES

PURE_NUMBERS = {"mrac", "mrac_literal"}
"""Laws whose first covariance is a number that stands for 1/(N m)^2 too: units of torque must stay as they are."""
PICTURES = {"geometry"}
"""Groups that are only drawn, at sizes of the picture's own: metres of a hull and of an arrow for a newton."""


def cases_of(*cases: Case) -> list[object]:
    """Return the parameters of a test; what combines values of others is for soak."""
    return [pytest.param(case, marks=pytest.mark.soak) if case in FURTHER else case for case in cases]


every_case = pytest.mark.parametrize("case", cases_of(*EVERY), ids=title)
up_to_two_pendulums = pytest.mark.parametrize(
    "case", cases_of(*(case for case in EVERY if dict(case[1]).get("pendulums", "1") in "12")), ids=title
)


def test_only_a_number_of_pendulums_is_left_to_soak():
    few, all_values = ({(model, *row) for model, rows in cases for row in rows} for cases in (CASES, EVERY))
    assert all_values - few == {("slosh", "pendulums", "3")}


@every_case
@pytest.mark.share(9)
def test_equations_pass_their_gates(case):
    subject = subject_of(case)
    failed = {name: error for name, error in gates(gates_of(subject), subject).items() if not error <= TOLERANCE}
    assert not failed


@up_to_two_pendulums
@pytest.mark.share(12)
def test_every_parameter_matters(case):
    subject = subject_of(case)
    assert not idle_parameters(subject)


@up_to_two_pendulums
@pytest.mark.share(12)
def test_units_can_be_changed(case):
    subject = subject_of(case)
    names = [request.name for request in requests(subject.system) if request.name not in PICTURES]
    scales = {name: SAME_TORQUE if name in PURE_NUMBERS else SCALES for name in names}
    failed = {name: error for name in names if not (error := misfit(subject, name, scales[name])) <= TOLERANCE}
    assert not failed


def test_pendulum_damping_without_its_moment_arm():
    """Basilisk #1484, 2018 to 2026: the damping force D l' stood in the moment's place of l x D l'.

    With equal dampers it does no work; with unequal ones it can drive the pendulum. Its tests had D = 0, where nothing
    shows, and the momentum of the whole never shows it.
    """
    alike, unlike = sp.eye(3), sp.diag(1, 5, 1)
    for dampers in (alike, unlike):
        right = errors(damped(dampers, lambda arm, force: arm.cross(force)), dampers)
        assert max(right.values()) <= TOLERANCE

    for dampers in (alike, unlike):
        wrong = errors(damped(dampers, lambda arm, force: force), dampers)
        assert wrong["power"] > 1e-3
        assert wrong["linear momentum"] <= TOLERANCE
        assert wrong["angular momentum"] <= TOLERANCE
        assert (wrong["energy without inputs"] > 1e-3) == (dampers is unlike)

    undamped = points(damped(unlike, lambda arm, force: force), 12).moved(eps1=0.0)
    assert max(gate.error(undamped) for gate in damping_gates(unlike)) <= TOLERANCE


@pytest.mark.parametrize("inertia", ["paper", "hinge"])
@pytest.mark.share(2)
def test_a_force_in_the_place_of_a_moment_shows_in_the_units(inertia):
    subject = machine("slosh", ("pendulums", "1"), ("inertia", inertia))
    length = subject.system.parameters.l1
    assert misfit(subject, "rhs") <= TOLERANCE
    assert (
        misfit(redefined(subject, lambda name, expr: expr / length if name == "bob1_loss_phi" else expr), "rhs") > 1e-3
    )


@pytest.mark.parametrize("symmetry", [slosh.mirror(2, "paper", "angles"), slosh.same_bob(2)], ids=lambda s: s.name)
def test_rotors_geared_to_angles_are_not_symmetric(symmetry):
    """The paper couples phi' to the roll rate and theta' to the yaw rate, which no bob on an arm does."""
    subject = machine("slosh", ("pendulums", "2"), ("inertia", "paper"))
    assert symmetric(symmetry).error(points(subject)) > 1e-3
    point_bobs = {f"I{k}": slosh.FLOOR for k in (1, 2)}
    assert symmetric(symmetry).error(points(subject).moved(**point_bobs)) <= TOLERANCE


def test_energy_that_grows_is_noticed():
    at = points(machine("slosh", ("pendulums", "1"), ("inertia", "ball"))).moved(eps1=-0.5)
    assert never_rises("energy", slosh.energy, slosh.unforced).error(at) > 1e-3


def test_a_side_may_be_a_number():
    subject = machine("triangle")
    at = points(subject)
    name = subject.system.states.quantities[0].name
    sides = [balance("still", lambda _: 1.0, lambda _: 0.0), never_rises("still", lambda _: 1, lambda at: at)]
    assert [gate.error(at) for gate in sides] == [0.0, 0.0]
    assert identity("wrong", lambda at: at[name], lambda _: 1e3).error(at) > 0.5


def test_an_idle_parameter_is_noticed():
    subject = machine("triangle")
    idle = Parameter("idle", "kg", "enters nothing", default=1.0)
    parameters = Group("p", (*subject.system.parameters.quantities, idle))
    larger = dataclasses.replace(subject.system, parameters=parameters)
    assert idle_parameters(Machine(larger, RANGES["triangle"])) == ["idle"]


def subject_of(case) -> Machine:
    model, structure = case
    return machine(model, *structure)


def redefined(subject, change) -> Machine:
    """Return a model with other definitions."""
    steps = tuple(
        dataclasses.replace(step, expr=change(step.symbol.name, step.expr)) if isinstance(step, Definition) else step
        for step in subject.system.steps
    )
    return Machine(dataclasses.replace(subject.system, steps=steps), subject.ranges)


def damped(dampers, moment) -> Machine:
    """Return one bob on hinges whose damping moment is made of its arm and of the force D l' of three dampers."""
    subject = machine("slosh", ("pendulums", "1"), ("inertia", "hinge"))
    x, p = subject.system.states, subject.system.parameters
    s, c, S, C = sp.sin(x.phi1), sp.cos(x.phi1), sp.sin(x.theta1), sp.cos(x.theta1)
    axes = {"phi": sp.Matrix([0, C, -S]), "theta": sp.Matrix([-1, 0, 0])}
    arm = p.l1 * sp.Matrix([-c, s * S, s * C])
    rate = (x.phi1_dot * axes["phi"] + x.theta1_dot * axes["theta"]).cross(arm)
    acting = moment(arm, p.eps1 * dampers * rate)
    losses = {f"bob1_loss_{name}": acting.dot(axis) for name, axis in axes.items()}
    return redefined(subject, lambda name, expr: losses.get(name, expr))


def damping_gates(dampers):
    def dissipation(at: Points):
        force = at["eps1"][:, None] * sp.matrix2numpy(dampers, float).diagonal()
        rate = at["l1"][:, None] * bodies.arm(at, 1)[1]
        return dot(force * rate, rate)

    return [
        balance("power", slosh.energy, lambda at: slosh.power(at) - dissipation(at)),
        never_rises("energy without inputs", slosh.energy, slosh.unforced),
        *slosh.momenta("rhs_euler", None, ""),
    ]


def errors(subject, dampers):
    at = points(subject, 40)
    return {gate.name: gate.error(at) for gate in damping_gates(dampers)}
