#!/usr/bin/env bash
# Sliding contact of OpenSees forgets its shear force at each step: friction is a saw-tooth.
#
# Guess: a node that slides on `zeroLengthContact2D` or `zeroLengthContact3D` carries friction times
# the normal force, and the work of a cycle converges as the steps get smaller.
# Seen: after a step that ends in slip, the next step begins without shear, and needs the whole
# elastic slip to reach the bound again. So the shear force rises and falls between zero and the
# bound, and with small steps the work of a cycle is about 2/3 of Coulomb's. One large step per way
# hides it, because each step then ends at the bound. `zeroLengthContactASDimplex` keeps its shear.
# Versions: openseespy 3.7.1.2, openseespylinux 3.7.1.2, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: for each element the range of the shear force over its bound on the last third of a way,
# and the work of a cycle over the one of Coulomb's law:
# "zeroLengthContact2D: shear 0.08 to 1.00, work 0.64", the same for zeroLengthContact3D, and
# "zeroLengthContactASDimplex: shear 1.00 to 1.00, work 1.00", then "as described".
. "$(dirname "$0")/common.sh"
packages openseespy==3.7.1.2 openseespylinux==3.7.1.2 numpy==2.3.5

cat > "$folder/slide.py" <<'PYTHON'
import sys

import numpy as np
import openseespy.opensees as ops

element = sys.argv[1]
dimensions = 2 if element.endswith("2D") else 3
stiffness, friction, pressing, way, steps = 1e3, 0.3, 10.0, 0.02, 200
driver = 1e5  # a spring that moves the node to and fro
bound = friction * pressing

ops.wipe()
ops.model("basic", "-ndm", dimensions, "-ndf", dimensions)
for node in (1, 2, 3):  # the node that slides, the ground, the fixed end of the spring
    ops.node(node, *[0.0] * dimensions)
for node in (2, 3):
    ops.fix(node, *[1] * dimensions)
ops.uniaxialMaterial("Elastic", 1, driver)
ops.element("zeroLength", 1, 3, 1, "-mat", 1, "-dir", 1)
law = (stiffness, stiffness, friction)
if element == "zeroLengthContact2D":
    ops.element(element, 2, 1, 2, *law, "-normal", 0, 1)
elif element == "zeroLengthContact3D":
    ops.element(element, 2, 1, 2, *law, 0.0, 3)
else:
    ops.element(element, 2, 2, 1, *law, "-orient", 0, 0, 1)

ends = [0.0, 1.0, 2.0, 3.0, 4.0, 9.0]
pushes = [0.0, 0.0, 1.0, -1.0, 1.0, 1.0]
ops.timeSeries("Path", 1, "-time", 0.0, 1.0, 9.0, "-values", 0.0, 1.0, 1.0)
ops.timeSeries("Path", 2, "-time", *ends, "-values", *pushes)
ops.pattern("Plain", 1, 1)
ops.load(1, *[0.0] * (dimensions - 1), -pressing)
ops.pattern("Plain", 2, 2)
ops.load(1, driver * way, *[0.0] * (dimensions - 1))
ops.constraints("Plain")
ops.numberer("Plain")
ops.system("FullGeneral")
ops.test("NormDispIncr", 1e-12, 100)
ops.algorithm("Newton")
ops.integrator("LoadControl", 1.0)
ops.analysis("Static")
assert ops.analyze(1) == 0  # presses
ops.integrator("LoadControl", 1.0 / steps)
place, shear = [], []
for _ in range(3 * steps):  # to one end, back to the other, and to the first again
    assert ops.analyze(1) == 0
    place.append(ops.nodeDisp(1, 1))
    push = np.interp(ops.getTime(), ends, pushes)
    shear.append(driver * (way * push - place[-1]))  # from equilibrium of the node

cycle = slice(steps - 1, None)
work = np.trapezoid(shear[cycle], place[cycle])
coulomb = 2 * bound * (np.ptp(place) - 2 * bound / stiffness)
late = np.array(shear[-steps // 3 :]) / bound
print(f"{element}: shear {late.min():.2f} to {late.max():.2f}, work {work / coulomb:.2f}")
PYTHON

for element in zeroLengthContact2D zeroLengthContact3D zeroLengthContactASDimplex; do
    "$folder/venv/bin/python" "$folder/slide.py" "$element" 2> /dev/null
done | grep shear | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
zeroLengthContact2D: shear 0.08 to 1.00, work 0.64
zeroLengthContact3D: shear 0.08 to 1.00, work 0.64
zeroLengthContactASDimplex: shear 1.00 to 1.00, work 1.00
OUTPUT
echo "as described"
