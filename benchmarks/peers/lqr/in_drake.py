# SPDX-License-Identifier: Apache-2.0
"""Drake: a MultibodyPlant with point masses on universal joints, the law as a sampled LeafSystem, Runge-Kutta 5."""

from __future__ import annotations

import numpy as np
import task
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, RotationalInertia, SpatialInertia, UnitInertia, UniversalJoint
from pydrake.symbolic import Variable, cos
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Multiplexer, SymbolicVectorSystem

JOINT = RotationMatrix(np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]]))
"""Joint frame: z is the arm and points along -x of the hull, 90 degrees from the singularity."""


class Law(LeafSystem):
    """Hold force and moment in body axes from one sample to the next."""

    def __init__(self):
        super().__init__()
        self.state = self.DeclareVectorInputPort("state", 21)
        held = self.DeclareDiscreteState(6)
        self.DeclareStateOutputPort("wrench", held)
        self.DeclarePeriodicDiscreteUpdateEvent(task.PERIOD, 0.0, self.sample)

    def sample(self, context, values):
        u = task.law(to_state(self.state.Eval(context)))
        values.set_value(np.concatenate(task.wrench(u)))


def plant():
    """Return hull and bobs."""
    craft = MultibodyPlant(0.0)
    craft.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    mass, centre, inertia = task.hull()
    own = SpatialInertia.MakeFromCentralInertia(mass, centre, RotationalInertia(*np.diag(inertia)))
    hull = craft.AddRigidBody("hull", own)
    for k, (m, length, pivot, _) in enumerate(task.BOBS):
        bob = craft.AddRigidBody(f"bob{k}", SpatialInertia(m, [0, 0, length], UnitInertia.PointMass([0, 0, length])))
        at = RigidTransform(JOINT, [pivot, 0, 0])
        frame = craft.AddFrame(FixedOffsetFrame(f"pivot{k}", hull.body_frame(), at))
        craft.AddJoint(UniversalJoint(f"joint{k}", frame, bob.body_frame()))
    craft.Finalize()
    return craft


def forces():
    """Return the generalised forces of a held wrench and of the dampers, which differ from Drake's joint damping."""
    x = [Variable(f"x{i}") for i in range(21)]
    held = [Variable(f"u{i}") for i in range(6)]
    turn = task.matrix(np.array(x[:4]))
    force, moment = turn @ held[:3], turn @ held[3:]
    drag = []
    for k, (_, _, _, eps) in enumerate(task.BOBS):
        b, (da, db) = x[8 + 2 * k], x[17 + 2 * k : 19 + 2 * k]
        drag += [-eps * cos(b) ** 2 * da, -eps * db]
    idle = Variable("idle")  # without a state its derivatives fail
    return SymbolicVectorSystem(input=[*x, *held], state=[idle], dynamics=[0 * idle], output=[*moment, *force, *drag])


def to_plant(x):
    """Return Drake's state of a state of the task at rest."""
    arms = x[10:].reshape(2, 2, 3)[:, 0]
    angles = [(np.arctan2(-s[1], -s[0]), np.arcsin(s[2])) for s in arms]
    return np.concatenate([x[6:10], np.zeros(3), *angles, np.zeros(3), task.matrix(x[6:10]) @ x[:3], np.zeros(4)])


def to_state(y):
    """Return the state of the task."""
    back, bobs = task.matrix(y[:4]).T, []
    omega = back @ y[11:14]
    for (a, b), (da, db) in zip(y[7:11].reshape(2, 2), y[17:].reshape(2, 2), strict=True):
        ca, sa, cb, sb = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
        arm = np.array([-ca * cb, -sa * cb, sb])
        slip = da * np.array([sa * cb, -ca * cb, 0]) + db * np.array([ca * sb, sa * sb, cb])
        bobs += [arm, slip + np.cross(omega, arm)]
    return np.concatenate([back @ y[14:17], omega, y[:4], *bobs])


def make(tolerance):
    builder = DiagramBuilder()
    parts = (plant(), Law(), Multiplexer([21, 6]), forces())
    craft, law, joined, push = (builder.AddSystem(part) for part in parts)
    builder.Connect(craft.get_state_output_port(), law.get_input_port())
    builder.Connect(craft.get_state_output_port(), joined.get_input_port(0))
    builder.Connect(law.get_output_port(), joined.get_input_port(1))
    builder.Connect(joined.get_output_port(), push.get_input_port())
    builder.Connect(push.get_output_port(), craft.get_applied_generalized_force_input_port())
    simulator = Simulator(builder.Build())
    integrator = ResetIntegratorFromFlags(simulator, "runge_kutta5", task.PERIOD)
    integrator.set_target_accuracy(tolerance)
    context = simulator.get_mutable_context()
    own = craft.GetMyMutableContextFromRoot(context)

    def one(x):
        context.SetTime(0.0)
        craft.SetPositionsAndVelocities(own, to_plant(x))
        simulator.Initialize()
        simulator.AdvanceTo(task.SAMPLES * task.PERIOD)
        return to_state(craft.GetPositionsAndVelocities(own))

    return lambda starts: np.array([one(x) for x in task.initial(starts)])


if __name__ == "__main__":
    task.measure(make, 20)
