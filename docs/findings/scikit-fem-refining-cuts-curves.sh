#!/usr/bin/env bash
# Refining a curved mesh of scikit-fem straightens it: a ball loses a third of its volume.
#
# Guess: `MeshTet2.refined()` and `MeshTri2.refined()` keep the curved outline, or place the new
# nodes on it.
# Seen: they refine the straight mesh of the corners, and then halve its straight edges. The result
# is still a quadratic mesh, so nothing looks wrong, but its outline is that of the coarse corners,
# and further refinement does not bring the curve back. Refining elements by number does the same.
# Versions: scikit-fem 12.0.2, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: area or volume over the exact one, before refinement and after one and two:
# "MeshTri2, a disk: 1.000 0.974 0.974", "MeshTet2, a ball: 0.985 0.703 0.703", then "as described".
. "$(dirname "$0")/common.sh"
packages scikit-fem==12.0.2 numpy==2.3.5

cat > "$folder/refine.py" <<'PYTHON'
import numpy as np
import skfem

disk = skfem.MeshTri2.init_circle(2)
ball = skfem.MeshTet2.init_ball(1)
bodies = (
    ("a disk", disk, skfem.ElementTriP1(), np.pi),
    ("a ball", ball, skfem.ElementTetP1(), 4 / 3 * np.pi),
)
for name, mesh, element, exact in bodies:
    meshes = [mesh, mesh.refined(), mesh.refined(2)]
    kind = type(mesh).__name__
    assert all(type(each).__name__ == kind for each in meshes)
    shares = [skfem.Basis(each, element, intorder=6).dx.sum() / exact for each in meshes]
    print(f"{kind}, {name}:", *(f"{share:.3f}" for share in shares))
PYTHON

"$folder/venv/bin/python" "$folder/refine.py" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
MeshTri2, a disk: 1.000 0.974 0.974
MeshTet2, a ball: 0.985 0.703 0.703
OUTPUT
echo "as described"
