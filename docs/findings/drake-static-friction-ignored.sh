#!/usr/bin/env bash
# Drake's point contact ignores the static friction coefficient: a block that should stick slides.
#
# Guess: `CoulombFriction(0.6, 0.3)` holds a block at rest against a force of 0.45 of its weight.
# Seen: only the dynamic coefficient counts, with each of the contact approximations, and also with a
# time step of zero. The block starts to slide as soon as the force acts, and no warning is given. A
# block with the coefficients 0.6 and 0.6 stays.
# Versions: drake 1.51.1, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: speed after 1 s of that force with both dynamic coefficients: "LAGGED: 1.5 m/s for 0.3, 0.0
# m/s for 0.6", the same for "TAMSI", "SAP" and "SIMILAR", "no time step: 1.5 m/s for 0.3", then "as
# described".
. "$(dirname "$0")/common.sh"
packages drake==1.51.1 numpy==2.3.5
cd "$folder"

cat > slide.py <<'PYTHON'
import numpy as np
from pydrake.geometry import HalfSpace, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    ContactModel,
    CoulombFriction,
    DiscreteContactApproximation,
    ExternallyAppliedSpatialForce,
)
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder


def speed(time_step, approximation=None, dynamic=0.3):
    """Speed of a block after the force has acted for 1 s."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step)
    if approximation is not None:
        plant.set_discrete_contact_approximation(approximation)
    plant.set_contact_model(ContactModel.kPoint)
    friction = CoulombFriction(0.6, dynamic)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground", friction
    )
    block = plant.AddRigidBody("block", SpatialInertia.SolidBoxWithMass(1.0, 1.0, 1.0, 0.2))
    for foot, (x, y) in enumerate(((0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5))):
        plant.RegisterCollisionGeometry(
            block, RigidTransform([x, y, -0.09]), Sphere(0.01), f"foot {foot}", friction
        )
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -10])
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(context, block, RigidTransform([0, 0, 0.1]))
    push = ExternallyAppliedSpatialForce()
    push.body_index = block.index()
    push.p_BoBq_B = np.array([0, 0, -0.1])  # at the ground, so that the block does not tilt
    push.F_Bq_W = SpatialForce([0, 0, 0], [4.5, 0, 0])
    port = plant.get_applied_spatial_force_input_port()
    port.FixValue(context, [])
    simulator.AdvanceTo(0.5)  # the block settles first
    port.FixValue(context, [push])
    simulator.AdvanceTo(1.5)
    return plant.EvalBodySpatialVelocityInWorld(context, block).translational()[0]


for name in ("LAGGED", "TAMSI", "SAP", "SIMILAR"):
    approximation = getattr(DiscreteContactApproximation, f"k{name.capitalize()}")
    moving, resting = (abs(speed(0.001, approximation, dynamic)) for dynamic in (0.3, 0.6))
    print(f"{name}: {moving:.1f} m/s for 0.3, {resting:.1f} m/s for 0.6")
print(f"no time step: {speed(0.0):.1f} m/s for 0.3")
PYTHON

venv/bin/python slide.py 2>warnings | tee seen
diff - seen <<'OUTPUT'
LAGGED: 1.5 m/s for 0.3, 0.0 m/s for 0.6
TAMSI: 1.5 m/s for 0.3, 0.0 m/s for 0.6
SAP: 1.5 m/s for 0.3, 0.0 m/s for 0.6
SIMILAR: 1.5 m/s for 0.3, 0.0 m/s for 0.6
no time step: 1.5 m/s for 0.3
OUTPUT
echo "as described"
