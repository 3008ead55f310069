#!/usr/bin/env bash
# scikit-fem integrates prisms wrongly: its quadrature of the reference wedge has half the volume.
#
# Guess: the weights sum to 1/2, the volume of a right triangle with legs of 1 times a height of 1,
# and a form on `MeshWedge1` has the value of the same body as `MeshHex`.
# Seen: the weights sum to 1/4 at every order, and the mean of a coordinate of the triangle is 1/2
# instead of 1/3. So a body has half its volume as wedges, and no factor mends stiffness or mass.
# Versions: scikit-fem 12.0.2, numpy 2.3.5, Python 3.11; 2026-11-27.
# Output: a line for each order, "order 1: volume 0.25, mean 0.5" to order 4; "cube of hexahedra 1,
# of wedges 0.5"; then "as described".
. "$(dirname "$0")/common.sh"
packages scikit-fem==12.0.2 numpy==2.3.5

cat > "$folder/volumes.py" <<'PYTHON'
import numpy as np
import skfem
from skfem.quadrature import get_quadrature
from skfem.refdom import RefWedge

for order in (1, 2, 3, 4):
    points, weights = get_quadrature(RefWedge, order)
    volume = weights.sum()
    mean = weights @ points[0] / volume
    print(f"order {order}: volume {volume:.6g}, mean {mean:.6g}")


@skfem.Functional
def one(w):
    return 1.0 + 0.0 * w.x[0]


# The unit cube as one hexahedron, and as two prisms that share a diagonal of its base.
hexahedron = skfem.MeshHex()
square = np.array([[0, 1, 1, 0], [0, 0, 1, 1]], dtype=float)
corners = np.vstack([np.tile(square, 2), np.repeat([0.0, 1.0], 4)])
prisms = np.array([[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]).T
wedges = skfem.MeshWedge1(corners, prisms)
volumes = [
    one.assemble(skfem.Basis(hexahedron, skfem.ElementHex1())),
    one.assemble(skfem.Basis(wedges, skfem.ElementWedge1())),
]
print(f"cube of hexahedra {volumes[0]:.6g}, of wedges {volumes[1]:.6g}")
PYTHON

"$folder/venv/bin/python" "$folder/volumes.py" | tee "$folder/seen"
expected="order 1: volume 0.25, mean 0.5
order 2: volume 0.25, mean 0.5
order 3: volume 0.25, mean 0.5
order 4: volume 0.25, mean 0.5
cube of hexahedra 1, of wedges 0.5"
[ "$(cat "$folder/seen")" = "$expected" ]
echo "as described"
