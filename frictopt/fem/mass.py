"""Mass of a body, and the forces that it makes in a mode of vibration."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from skfem import BilinearForm

from ..contact import Array, finite_array
from ..errors import ModelError
from .bodies import Body
from .elasticity import Kinematics, basis_of, circumference
from .loads import Part


def body_mass(name: str, body: Body, kinematics: Kinematics) -> csr_matrix:
    """(nodes, nodes) consistent mass of a body, the same along each axis; per depth in the plane, axisymmetric that of the whole circumference."""
    if body.material.density is None:
        raise ModelError(
            f"material: body {name!r} has no density, and modes need that of every body; give Material(..., density=), mass per volume, "
            "such as 7.85e-9 tonne/mm^3 beside N, mm and s"
        )
    form = BilinearForm(lambda u, v, w: circumference(w.x[0], kinematics) * u * v)
    return csr_matrix(body.material.density * form.assemble(basis_of(body.mesh)))


@dataclass(frozen=True, eq=False)
class NodalForces(Part):
    """Forces on the nodes of one body, (d, nodes): part of the load of a mode, see `Modes.load`."""

    body: str
    forces: Array

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        if np.shape(self.forces) != body.mesh.p.shape:
            hint = "give the load of a mode to the model whose modes were found, with the same bolts"
            raise ModelError(f"forces: shape {np.shape(self.forces)}, and body {self.body!r} has (d, nodes) = {body.mesh.p.shape}; {hint}")
        return finite_array("forces", self.forces)
