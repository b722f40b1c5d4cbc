# SPDX-License-Identifier: Apache-2.0
"""Drake: a MultibodyPlant of bodies on revolute and universal joints, a propeller for the force."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant, Propeller
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    RevoluteJoint,
    RevoluteSpring,
    RotationalInertia,
    SpatialInertia,
    UnitInertia,
    UniversalJoint,
)
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from benchmarks.craft import task
from benchmarks.craft.task import Array, Fly

JOINT = RotationMatrix(np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]]))
"""Joint frame of the pendulum: its rod is along z, which points along -x of the hub."""

LARGEST_STEP = 0.5
"""s; after a first trial step much longer than the panels' fast period Drake meets NaN instead of a shorter step."""


def frame(craft: Any, name: str, body: Any, place: Any, turn: Any = None) -> Any:
    return craft.AddFrame(FixedOffsetFrame(name, body.body_frame(), RigidTransform(turn or RotationMatrix(), place)))


def plant() -> tuple[Any, dict[str, Any]]:
    """Return the craft and its joints by mehvar's names."""
    craft, joints = MultibodyPlant(0.0), {}
    craft.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    hull = craft.AddRigidBody("hub", SpatialInertia.MakeFromCentralInertia(
        task.MASS, np.zeros(3), RotationalInertia(*np.diag(task.INERTIA))))  # fmt: skip
    for k, axis in enumerate(task.AXES, 1):
        own = SpatialInertia.MakeFromCentralInertia(
            task.WHEEL, np.zeros(3), RotationalInertia(task.ACROSS, task.ACROSS, task.SPIN)
        )
        wheel, turn = craft.AddRigidBody(f"wheel{k}", own), RotationMatrix.MakeFromOneVector(axis, 2)
        seat = frame(craft, f"seat{k}", hull, task.REACH * axis, turn)
        joints[f"wheel{k}"] = craft.AddJoint(RevoluteJoint(f"wheel{k}", seat, wheel.body_frame(), [0, 0, 1]))
        craft.AddJointActuator(f"motor{k}", joints[f"wheel{k}"])
    for k, side in enumerate(task.SIDES, 1):
        before, place = hull, side * task.EDGE
        for link in (1, 2):
            centre = np.array([0, side * task.LONG / 2, 0])
            own = SpatialInertia.MakeFromCentralInertia(task.BODY, centre, RotationalInertia(*task.PLATE))
            name = f"panel{k}_{link}"
            body, hinge = craft.AddRigidBody(name, own), frame(craft, f"hinge_{name}", before, [0, place, 0])
            joints[name] = craft.AddJoint(RevoluteJoint(name, hinge, body.body_frame(), [1, 0, 0], task.DAMPING))
            craft.AddForceElement(RevoluteSpring(joints[name], 0.0, task.STIFFNESS))
            before, place = body, side * task.LONG
    own = SpatialInertia(task.BOB, [0, 0, task.ROD], UnitInertia.PointMass([0, 0, task.ROD]))
    bob = craft.AddRigidBody("bob", own)
    joints["bob"] = craft.AddJoint(
        UniversalJoint("bob", frame(craft, "pivot", hull, task.PIVOT, JOINT), bob.body_frame())
    )
    craft.Finalize()
    return craft, joints


class Craft:
    """The diagram: craft, motors and the force along x of the hub."""

    def __init__(self) -> None:
        builder = DiagramBuilder()
        self.plant, self.joints = plant()
        craft, hull = builder.AddSystem(self.plant), self.plant.GetBodyByName("hub")
        along = RigidTransform(RotationMatrix.MakeFromOneVector([1, 0, 0], 2), np.zeros(3))
        push = builder.AddSystem(Propeller(hull.index(), along, 1.0, 0.0))
        force, torques = (builder.AddSystem(ConstantVectorSource(v)) for v in ([task.FORCE], task.TORQUES))
        builder.Connect(force.get_output_port(), push.get_command_input_port())
        builder.Connect(torques.get_output_port(), craft.get_actuation_input_port())
        builder.Connect(craft.get_body_poses_output_port(), push.get_body_poses_input_port())
        builder.Connect(push.get_spatial_forces_output_port(), craft.get_applied_spatial_force_input_port())
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.own = self.plant.GetMyMutableContextFromRoot(self.context)
        self.hull = hull

    def set(self, start: Array) -> None:
        """Put the craft to a start."""
        values, own = dict(zip(task.STARTS, start, strict=True)), self.own
        turn, rate = task.attitude(values), np.array([values[name] for name in ("wx", "wy", "wz")])
        self.context.SetTime(0.0)
        self.plant.SetPositionsAndVelocities(own, np.eye(1, self.plant.num_multibody_states())[0])
        self.plant.SetFreeBodyPose(own, self.hull, RigidTransform(RotationMatrix(turn), np.zeros(3)))
        joints = self.joints
        velocity = self.plant.GetVelocities(own)
        velocity[:3] = turn @ rate
        self.plant.SetVelocities(own, velocity)
        for name, value in values.items():
            part, _, what = name.rpartition("_")
            if what == "speed":
                joints[part].set_angular_rate(own, value)
            elif what == "angle":
                joints[part].set_angle(own, value)
        arm = task.arm(values)
        a, b = np.arctan2(-arm[1], -arm[0]), np.arcsin(arm[2])
        joints["bob"].set_angles(own, [a, b])
        slip, ca, sa = -np.cross(rate, arm), np.cos(a), np.sin(a)
        rates = [slip @ [sa, -ca, 0] / np.cos(b), slip @ [ca * np.sin(b), sa * np.sin(b), np.cos(b)]]
        joints["bob"].set_angular_rates(own, rates)

    def final(self) -> Array:
        """Return the task's final state."""
        own, joints = self.own, self.joints
        turn = self.plant.EvalBodyPoseInWorld(own, self.hull).rotation().matrix()
        motion = self.plant.EvalBodySpatialVelocityInWorld(own, self.hull)
        panels = [(joints[f"panel{k}_1"], joints[f"panel{k}_2"]) for k in (1, 2)]
        angles = [f(own) for i, j in panels for f in (i.get_angle, j.get_angle, i.get_angular_rate, j.get_angular_rate)]
        a, b = joints["bob"].get_angles(own)
        arm = [-np.cos(a) * np.cos(b), -np.sin(a) * np.cos(b), np.sin(b)]
        speeds = [joints[f"wheel{k}"].get_angular_rate(own) / task.SPEED for k in range(1, 5)]
        both = (turn.T @ motion.rotational(), turn.T @ motion.translational())
        return np.concatenate([turn.ravel(), *both, angles, arm, speeds])


def at(accuracy: float | None, scheme: str) -> Craft:
    """Return a craft with a Runge-Kutta method; without an accuracy with Drake's own choice."""
    craft = Craft()
    if accuracy is not None:
        ResetIntegratorFromFlags(craft.simulator, scheme, LARGEST_STEP).set_target_accuracy(accuracy)
    return craft


def one(craft: Craft, start: Array) -> Array:
    craft.set(start)
    craft.simulator.Initialize()
    craft.simulator.AdvanceTo(task.SPAN)
    return craft.final()


def fly(accuracy: float | None = None, scheme: str = "runge_kutta5") -> Fly:
    """Return runs of one simulator, one after the other."""
    craft = at(accuracy, scheme)
    return lambda starts: np.array([one(craft, start) for start in starts])


def evaluations(setting: str, start: Array) -> int:
    """Return how often a run by runge_kutta5 evaluates the derivatives."""
    craft = at(float(setting), "runge_kutta5")
    one(craft, start)
    return int(craft.simulator.get_integrator().get_num_derivative_evaluations())


def rhs() -> Callable[[], object]:
    """Return one call of the time derivatives from Python, at a state that Drake must take for new."""
    craft = Craft()
    craft.set(task.starts(1)[0])
    state = craft.context.get_mutable_continuous_state_vector()
    values = state.CopyToVector()

    def call() -> object:
        craft.context.SetContinuousState(values)
        return craft.diagram.EvalTimeDerivatives(craft.context)

    return call
