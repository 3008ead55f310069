#!/usr/bin/env bash
# Friction of OpenSees' elements for several contact nodes has no hysteresis: it pulls nodes back.
#
# Guess: `zeroLengthContactNTS2D` and `zeroLengthInterface2D` take lists of nodes, and each node
# that slides dissipates friction times the normal force times its way, as it does alone.
# Seen: with two or more secondary nodes the friction depends on the displacement since the start,
# and not on the direction of sliding. It falls to zero on the way back to the start, so that a
# cycle dissipates nothing and a joint is elastic. The element keeps one state for all nodes, that
# of the pair which it looks at last, and here this pair is never in contact: so no node remembers
# that it slid. With one node it dissipates, about 3/4 of Coulomb's work with these steps, because
# it forgets its shear after each step with slip (`opensees-contact-forgets-shear.sh`). Use an
# element `zeroLengthContactASDimplex` for each node.
# Versions: openseespy 3.7.1.2, openseespylinux 3.7.1.2, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: work of a cycle over the one of Coulomb's law, with one secondary node and for each of
# two and three: "zeroLengthContactNTS2D: 0.77, 0.00 0.00, 0.00 0.00 0.00" and the same for
# `zeroLengthInterface2D`; 1.00 for `zeroLengthContactASDimplex`; then "as described".
. "$(dirname "$0")/common.sh"
packages openseespy==3.7.1.2 openseespylinux==3.7.1.2 numpy==2.3.5

cat > "$folder/slide.py" <<'PYTHON'
import sys

import numpy as np
import openseespy.opensees as ops

STIFFNESS, TANGENTIAL, FRICTION, PRESSING, WAY, STEPS = 1e5, 1e4, 0.5, 10.0, 0.02, 100
DRIVER = 1e5  # springs that move the nodes to and fro


def work(element, number):
    """Work of friction in a cycle for each of several nodes, over the one of Coulomb's law."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    ops.uniaxialMaterial("Elastic", 1, DRIVER)
    for node, x in ((1, 1.0), (2, -1.0)):  # the ground
        ops.node(node, x, 0.0)
        ops.fix(node, 1, 1)
    sliding = list(range(10, 10 + number))
    for node in sliding:
        place, end = 0.5 - (node - 10) * 0.2, node + 100
        ops.node(node, place, 0.0)
        ops.node(end, place, 0.0)
        ops.fix(end, 1, 1)
        ops.element("zeroLength", end, end, node, "-mat", 1, "-dir", 1)
    law = (STIFFNESS, TANGENTIAL)
    if element == "zeroLengthContactASDimplex":
        for node in sliding:
            ops.element(element, node, node + 100, node, *law, FRICTION, "-orient", 0, 1, 0)
    else:
        lists = ["-sNdNum", number, "-mNdNum", 2]
        if element == "zeroLengthInterface2D":
            lists += ["-dof", 2, 2]
        angle = float(np.degrees(np.arctan(FRICTION)))
        ops.element(element, 1, *lists, "-Nodes", *sliding, 1, 2, *law, angle)

    ends, pushes = [0.0, 1.0, 2.0, 4.0, 6.0], [0.0, 0.0, 1.0, -1.0, 1.0]
    ops.timeSeries("Path", 1, "-time", 0.0, 1.0, 9.0, "-values", 0.0, 1.0, 1.0)
    ops.timeSeries("Path", 2, "-time", *ends, "-values", *pushes)
    for series, load in ((1, (0.0, -PRESSING)), (2, (DRIVER * WAY, 0.0))):
        ops.pattern("Plain", series, series)
        for node in sliding:
            ops.load(node, *load)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-12, 100)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static")
    assert ops.analyze(1) == 0  # presses
    ops.integrator("LoadControl", 1.0 / STEPS)
    places, shears = [], []
    for _ in range(5 * STEPS):  # to one end, back to the other, and to the first again
        assert ops.analyze(1) == 0
        place = np.array([ops.nodeDisp(node, 1) for node in sliding])
        push = np.interp(ops.getTime(), ends, pushes)
        places.append(place)
        shears.append(DRIVER * (WAY * push - place))  # from equilibrium of the nodes
    cycle = slice(STEPS - 1, None)
    seen = np.trapezoid(np.array(shears)[cycle], np.array(places)[cycle], axis=0)
    bound = FRICTION * PRESSING
    return seen / (2 * bound * (np.ptp(places, axis=0) - 2 * bound / TANGENTIAL))


results = [[f"{abs(part):.2f}" for part in work(sys.argv[1], number)] for number in (1, 2, 3)]
print(f"{sys.argv[1]}:", ", ".join(" ".join(result) for result in results))
PYTHON

for element in zeroLengthContactNTS2D zeroLengthInterface2D zeroLengthContactASDimplex; do
  "$folder/venv/bin/python" "$folder/slide.py" "$element" 2> /dev/null
done | grep '^zeroLength.*:' | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
zeroLengthContactNTS2D: 0.77, 0.00 0.00, 0.00 0.00 0.00
zeroLengthInterface2D: 0.77, 0.00 0.00, 0.00 0.00 0.00
zeroLengthContactASDimplex: 1.00, 1.00 1.00, 1.00 1.00 1.00
OUTPUT
echo "as described"
