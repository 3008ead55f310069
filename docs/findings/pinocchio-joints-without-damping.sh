#!/usr/bin/env bash
# Pinocchio reads damping and friction of joints from a URDF file, and its dynamics leave both out.
#
# Guess: a joint with `<dynamics damping="0.5" friction="0.2"/>` slows down in `aba`, and `rnea`
# gives the torque that keeps its speed, or the reader warns.
# Seen: both are in the model, as `model.damping` and `model.upperDryFrictionLimit`. The
# acceleration of the moving joint is zero, and so is the torque. The documentation of these members
# does not say which functions use them. MuJoCo reads the same file, and its joint slows down. So
# subtract damping times speed, and the friction, from the torque that is given to `aba`.
# Versions: pin 4.1.0, mujoco 4.0.0, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: speed in rad/s of a wheel with the moment of inertia 1 and the speed 2, 1 s later: "by
# hand: 1.06", "Pinocchio: 2.00, torque 0.00 with damping 0.5 and friction 0.2 in the model",
# "MuJoCo: 1.06", then "as described".
. "$(dirname "$0")/common.sh"
packages pin==4.1.0 mujoco==4.0.0 numpy==2.3.5

cat > "$folder/wheel.urdf" <<'URDF'
<robot name="wheel">
  <link name="ground"/>
  <link name="wheel">
    <inertial>
      <mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>
  </link>
  <joint name="axle" type="continuous">
    <parent link="ground"/>
    <child link="wheel"/>
    <axis xyz="0 0 1"/>
    <dynamics damping="0.5" friction="0.2"/>
  </joint>
</robot>
URDF

cat > "$folder/turn.py" <<'PYTHON'
import sys

import mujoco
import numpy as np
import pinocchio

SPEED, DAMPING, FRICTION, TIME, STEPS = 2.0, 0.5, 0.2, 1.0, 10_000

held = FRICTION / DAMPING  # the speed approaches minus this until it is zero
print(f"by hand: {(SPEED + held) * np.exp(-DAMPING * TIME) - held:.2f}")

model = pinocchio.buildModelFromUrdf(sys.argv[1])
data = model.createData()
place, speed, free = pinocchio.neutral(model), np.array([SPEED]), np.zeros(1)
for _ in range(STEPS):
    speed += TIME / STEPS * pinocchio.aba(model, data, place, speed, free)
    place = pinocchio.integrate(model, place, speed * TIME / STEPS)
torque = pinocchio.rnea(model, data, place, speed, free)[0]
kept = f"damping {model.damping[0]} and friction {model.upperDryFrictionLimit[0]} in the model"
print(f"Pinocchio: {speed[0]:.2f}, torque {abs(torque):.2f} with {kept}")

model = mujoco.MjModel.from_xml_path(sys.argv[1])
model.opt.timestep = TIME / STEPS
data = mujoco.MjData(model)
data.qvel[0] = SPEED
for _ in range(STEPS):
    mujoco.mj_step(model, data)
print(f"MuJoCo: {data.qvel[0]:.2f}")
PYTHON

"$folder/venv/bin/python" "$folder/turn.py" "$folder/wheel.urdf" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
by hand: 1.06
Pinocchio: 2.00, torque 0.00 with damping 0.5 and friction 0.2 in the model
MuJoCo: 1.06
OUTPUT
echo "as described"
