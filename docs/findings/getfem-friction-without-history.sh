#!/usr/bin/env bash
# GetFEM's contact brick with friction has no hysteresis, unless it is given the last displacement.
#
# Guess: a block that is pushed to and fro dissipates as Coulomb's law says.
# Seen: without `alpha` and `wt`, slip is measured from the unloaded mesh. The block returns along
# the path on which it went, at the middle without shear, and a cycle dissipates nothing. With `wt`,
# the displacement of the last step, the shear in the middle is the friction bound.
# Versions: python3-getfem 5.4.2+dfsg1-3+b1 of Debian 12; 2026-11-27.
# Output: "without wt: 0.00 of the bound", "with wt: 1.00 of the bound", then "as described".
. "$(dirname "$0")/common.sh"
if ! dpkg-query --show python3-getfem > /dev/null 2>&1; then
    apt-get install --yes --quiet --no-install-recommends python3-getfem=5.4.2+dfsg1-3+b1
fi
dpkg-query --show --showformat='${Version}\n' python3-getfem | grep --fixed-strings --quiet 5.4.2

cat > "$folder/push.py" <<'PYTHON'
import getfem
import numpy as np


def middle(history):
    """Shear force over its bound as the top is back in the middle, after both ends."""
    mesh = getfem.Mesh("cartesian", np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    vectors, scalars = getfem.MeshFem(mesh, 2), getfem.MeshFem(mesh, 1)
    for fem in (vectors, scalars):
        fem.set_fem(getfem.Fem("FEM_QK(2,1)"))
    rule = getfem.MeshIm(mesh, getfem.Integ("IM_GAUSS_PARALLELEPIPED(2,4)"))
    faces = mesh.outer_faces()
    normals = np.array([mesh.normal_of_face(*face) for face in faces.T])
    mesh.set_region(1, faces[:, normals[:, 1] < -0.5])
    mesh.set_region(2, faces[:, normals[:, 1] > 0.5])
    model = getfem.Model("real")
    model.add_fem_variable("u", vectors)
    for name, value in (("lame", 0.0), ("shear", 0.5), ("r", 1.0), ("friction", 0.5)):
        model.add_initialized_data(name, [value])
    model.add_isotropic_linearized_elasticity_brick(rule, "u", "lame", "shear")
    model.add_initialized_data("top", [0.0, 0.0])
    model.add_Dirichlet_condition_with_multipliers(rule, "u", vectors, 2, "top")
    model.add_initialized_fem_data("distance", scalars, scalars.basic_dof_nodes()[1])
    model.add_filtered_fem_variable("traction", vectors, 1)
    contact = [rule, "u", "traction", "distance", "r", "friction", 1, 1]
    if history:
        model.add_initialized_data("alpha", [1.0])
        model.add_initialized_fem_data("last", vectors, np.zeros(vectors.nbdof()))
        contact += ["alpha", "last"]
    model.add_integral_contact_with_rigid_obstacle_brick(*contact)
    for x in (0.0, 5e-4, 0.0, -5e-4, 0.0):
        model.set_variable("top", [x, -1e-4])
        model.solve("max_res", 1e-12, "max_iter", 100)
        if history:
            model.set_variable("last", model.variable("u"))
    shear, normal = (
        getfem.asm("generic", rule, 0, f"traction({k})", 1, model) for k in (1, 2)
    )
    return abs(float(shear) / (0.5 * float(normal)))


getfem.util_trace_level(0)
print(f"without wt: {middle(False):.2f} of the bound")
print(f"with wt: {middle(True):.2f} of the bound")
PYTHON

env --unset=PYTHONPATH /usr/bin/python3 "$folder/push.py" 2> /dev/null | tail --lines=2 | tee "$folder/seen"
[ "$(sed --quiet 's/without wt: \(.*\) of.*/\1/p' "$folder/seen")" = "0.00" ]
[ "$(sed --quiet 's/with wt: \(.*\) of.*/\1/p' "$folder/seen")" = "1.00" ]
echo "as described"
