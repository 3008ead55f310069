#!/usr/bin/env bash
# The contact force of two alike bodies in OpenSim is 0.71 of Hertz' force.
#
# Guess: `HuntCrossleyForce`, which "uses Hertz contact theory", takes the plane-strain modulus of
# each body as its stiffness, and presses a sphere on a half space with the force of Hertz, as long
# as nothing moves.
# Seen: two bodies with the same modulus have the force times the root of 1/2, and so have two
# spheres. The bodies are springs in series whose forces grow with the power 3/2 of their shares of
# the overlap. Hertz adds their compliances instead. Only beside a rigid body is the force that of
# Hertz. OpenSim does not say so; the library below it, Simbody, documents the formula. Multiply the
# stiffness of alike bodies by the root of 2, or give one body the combined modulus and the other a
# stiffness that is larger by many powers of ten.
# Versions: opensim 4.6, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: force over that of Hertz for a sphere on a half space, for moduli with the ratio 1, 10 and
# a billion, and for two spheres: "half space: 0.707, 0.821, 1.000", "sphere: 0.707", then "as
# described".
. "$(dirname "$0")/common.sh"
packages opensim==4.6 numpy==2.3.5

cat > "$folder/press.py" <<'PYTHON'
import re
import sys

import numpy as np
import opensim as osim

RADIUS, MODULUS, OVERLAP = 0.1, 1e6, 1e-3


def force(other, stiffer=1):
    """Force at rest over Hertz' force. The other body may be stiffer than the sphere."""
    model = osim.Model()
    model.setGravity(osim.Vec3(0))
    body = osim.Body("body", 1.0, osim.Vec3(0), osim.Inertia(1, 1, 1))
    model.addBody(body)
    model.addJoint(osim.PlanarJoint("joint", model.getGround(), body))
    model.addContactGeometry(osim.ContactSphere(RADIUS, osim.Vec3(0), body, "ball"))
    ground = model.getGround()
    if other == "sphere":
        radius = RADIUS / 2
        shape = osim.ContactSphere(RADIUS, osim.Vec3(0, -RADIUS, 0), ground, "other")
    else:
        radius = RADIUS
        upright = osim.Vec3(0, 0, -np.pi / 2)
        shape = osim.ContactHalfSpace(osim.Vec3(0), upright, ground, "other")
    model.addContactGeometry(shape)
    contact = osim.HuntCrossleyForce()
    contact.setName("contact")
    contact.addGeometry("ball")
    contact.addGeometry("other")
    contact.setStiffness(MODULUS)
    model.addForce(contact)
    model.finalizeConnections()

    file = sys.argv[1]  # in which each body gets its own stiffness
    model.printToXML(file)
    with open(file) as lines:
        text = lines.read()
    pattern = r"<HuntCrossleyForce::ContactParameters>.*?</HuntCrossleyForce::ContactParameters>"
    both = re.search(pattern, text, re.DOTALL).group()
    ball = both.replace("ball other", "ball")
    old, new = (f"<stiffness>{value:.0f}</stiffness>" for value in (MODULUS, MODULUS * stiffer))
    assert old in both and "ball other" in both
    single = both.replace("ball other", "other").replace(old, new)
    with open(file, "w") as lines:
        lines.write(text.replace(both, ball + single))

    model = osim.Model(file)
    state = model.initSystem()
    joint = osim.PlanarJoint.safeDownCast(model.getJointSet().get("joint"))
    joint.get_coordinates(2).setValue(state, RADIUS - OVERLAP)
    model.realizeDynamics(state)
    contact = model.getForceSet().get("contact")
    labels, values = contact.getRecordLabels(), contact.getRecordValues(state)
    names = [labels.get(i) for i in range(labels.size())]
    upward = values.get(names.index("contact.body.force.Y"))
    together = MODULUS * stiffer / (1 + stiffer)
    return upward / (4 / 3 * together * np.sqrt(radius) * OVERLAP**1.5)


seen = ", ".join(f"{force('half space', stiffer):.3f}" for stiffer in (1, 10, 10**9))
print("half space:", seen)
print(f"sphere: {force('sphere'):.3f}")
PYTHON

cd "$folder"  # OpenSim writes a log
venv/bin/python press.py model.osim | grep -E '^(half space|sphere):' | tee seen
diff - seen <<'OUTPUT'
half space: 0.707, 0.821, 1.000
sphere: 0.707
OUTPUT
echo "as described"
