#!/usr/bin/env bash
# The solvers of Newton (NVIDIA Warp) combine the friction coefficients of two bodies in two ways.
#
# Guess: a model of Newton has one friction coefficient between two shapes, whichever of the solvers
# of rigid bodies takes it.
# Seen: XPBD takes the mean of both coefficients, and VBD the root of their product. A block with 0.1
# on a ground with 0.7 slides half as far again with VBD. On a ground without friction a block with
# 0.4 slows down with XPBD, as if both had 0.2, and not at all with VBD. `ShapeConfig.mu`, where the
# coefficient is given, only says "The coefficient of friction".
# Versions: newton 1.8.0, warp-lang 1.19.0, numpy 2.3.5, Python 3.11; 2026-11-28. It takes some
# minutes, because Warp compiles the solvers.
# Output: law of the coefficient of a block with 0.1 on a ground with 0.7, from its deceleration (0.4
# for the mean, 0.26 for the root): "SolverXPBD: mean", "SolverVBD: root", then "as described".
. "$(dirname "$0")/common.sh"
packages newton==1.8.0 warp-lang==1.19.0 numpy==2.3.5
cd "$folder"

cat > block.py <<'PYTHON'
import sys

import newton
import numpy as np
import warp as wp

BLOCK, GROUND, STEP, SPEED = 0.1, 0.7, 0.001, 2.0


def block(solver):
    """The friction coefficient from the deceleration of a sliding block."""
    builder = newton.ModelBuilder()
    stiff = {"ke": 1e5, "kd": 1e3, "kf": 1e4}
    builder.add_ground_plane(cfg=newton.ModelBuilder.ShapeConfig(mu=GROUND, **stiff))
    body = builder.add_body(xform=wp.transform((0, 0, 0.1), wp.quat_identity()))
    builder.add_shape_box(
        body, hx=0.5, hy=0.5, hz=0.1, cfg=newton.ModelBuilder.ShapeConfig(mu=BLOCK, **stiff)
    )
    builder.color()
    model = builder.finalize(device="cpu")
    now, then = model.state(), model.state()
    speeds = now.body_qd.numpy()
    speeds[0] = [SPEED, 0, 0, 0, 0, 0]
    now.body_qd.assign(speeds)
    now.joint_qd.assign(speeds[0])
    contacts = model.contacts()
    step = getattr(newton.solvers, solver)(model).step
    speed = []
    for _ in range(250):
        now.clear_forces()
        model.collide(now, contacts)
        step(now, then, model.control(), contacts, STEP)
        now, then = then, now
        speed.append(now.body_qd.numpy()[0, 0])
    # Between the steps 50 and 250, after the block has settled.
    return (speed[49] - speed[249]) / (200 * STEP * 9.81)


for solver in sys.argv[1:]:
    friction = block(solver)
    laws = {"mean": (BLOCK + GROUND) / 2, "root": np.sqrt(BLOCK * GROUND)}
    near = [name for name, value in laws.items() if abs(friction - value) < 0.03]
    print(f"{solver}:", *(near or [friction]))
PYTHON

for solver in SolverXPBD SolverVBD; do
  venv/bin/python block.py "$solver" 2> errors | grep '^Solver'
done | tee seen
diff - seen <<'OUTPUT'
SolverXPBD: mean
SolverVBD: root
OUTPUT
echo "as described"
