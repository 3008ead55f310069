#!/usr/bin/env bash
# In MuJoCo a block has 0.71 of its friction along the diagonal, unless the cone is changed.
#
# Guess: a block that slides has a friction force of coefficient times weight in every direction.
# Seen: with the default option `cone="pyramidal"` this holds along the axes of the contact. Along
# the diagonals the force is smaller by the factor sqrt(1/2), so a block that a force of 0.4 of its
# weight does not move along an axis slides away along the diagonal. With `cone="elliptic"` all
# directions are alike.
# Versions: mujoco 4.0.0, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: friction force of a sliding block along the diagonal over the one along the axis, within
# 0.03: "pyramidal: 0.70", "elliptic: 1.01", then "as described".
. "$(dirname "$0")/common.sh"
packages mujoco==4.0.0 numpy==2.3.5

cat > "$folder/slide.py" <<'PYTHON'
import mujoco
import numpy as np

SCENE = """
<mujoco>
  <option timestep="0.002" gravity="0 0 -10" {cone}/>
  <worldbody>
    <geom type="plane" size="50 50 1" friction="0.5 0 0"/>
    <body pos="0 0 0.1">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1" mass="1" friction="0.5 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""


def friction(cone, angle):
    """Friction force over weight of the block under a force of 0.6 of its weight."""
    model = mujoco.MjModel.from_xml_string(SCENE.format(cone=cone))
    state = mujoco.MjData(model)
    force = 6.0 * np.array([np.cos(angle), np.sin(angle)])
    speeds = []
    for step in range(1500):
        if step == 500:  # the block has settled
            state.xfrc_applied[1, :2] = force
        mujoco.mj_step(model, state)
        speeds.append(np.hypot(*state.qvel[:2]))
    acceleration = (speeds[-1] - speeds[999]) / (500 * 0.002)
    return (6.0 - acceleration) / 10.0


for name, cone in (("pyramidal", ""), ("elliptic", 'cone="elliptic"')):
    ratio = friction(cone, np.pi / 4) / friction(cone, 0.0)
    print(f"{name}: {ratio:.2f}")
    as_described = abs(ratio - (1.0 if cone else np.sqrt(0.5))) < 0.03
    if not as_described:
        raise SystemExit(1)
PYTHON

"$folder/venv/bin/python" "$folder/slide.py"
echo "as described"
