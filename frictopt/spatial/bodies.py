"""The parts of a contact model in space: bodies, supports, tractions and body forces."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.sparse import bmat, csr_matrix, diags, hstack
from skfem import Basis, BilinearForm, ElementHex0, ElementHex1, ElementTetP0, ElementTetP1, FacetBasis, LinearForm, MeshHex1, MeshTet1

from ..contact.checks import Array, check_text, choice, finite_number, shown
from ..errors import ModelError
from ..fem.elasticity import ELEMENT_NAMES, ElementName, Material
from ..fem.numbering import check_one_piece, linear_mesh, outline_facets
from ..fem.ordering import Integers

__all__ = ["Body3D", "BodyForce3D", "Support3D", "Traction3D"]

_ELEMENTS = {MeshHex1: ElementHex1, MeshTet1: ElementTetP1}
_UNIFORM = {MeshHex1: ElementHex0, MeshTet1: ElementTetP0}
_DIRECTIONS = ("x", "y", "z", "xy", "xz", "yz", "xyz")


@dataclass(frozen=True, eq=False)
class Body3D:
    """One elastic body in space: a scikit-fem mesh (`MeshHex` or `MeshTet`) with named boundaries, and its material.

    Parameters
    ----------
    mesh
        The mesh, lengths in any unit.
    material
        Its material.
    element
        "linear", or "mean_dilatation": hexahedra that do not lock as nu approaches 0.5 (linear tetrahedra always do).

    Raises
    ------
    ModelError
        Elements without volume or turned inside out, other elements than linear hexahedra or tetrahedra, a mesh of several parts that share no face,
        nodes that belong to no element.

    Examples
    --------
    >>> from skfem import MeshHex
    >>> import frictopt as fo
    >>> mesh = MeshHex.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0], [0.0, 1.0]).with_boundaries({"contact": lambda x: x[2] == 0})
    >>> fo.Body3D(mesh, fo.Material(E=70e9, nu=0.33)).boundary_nodes("contact", "interface").size
    6
    """

    mesh: Any
    material: Material = Material()
    element: ElementName = "linear"

    def __post_init__(self) -> None:
        choice("element", self.element, ELEMENT_NAMES)
        linear_mesh("mesh", self.mesh, _ELEMENTS, "MeshHex or a MeshTet")
        if not isinstance(self.material, Material):
            raise ModelError(f"material: a {type(self.material).__name__}; give a Material")
        if not np.isfinite(self.mesh.p).all():
            raise ModelError(f"mesh: node {int(np.argwhere(~np.isfinite(self.mesh.p))[0][1])} has coordinates that are not finite")
        volumes = self._volumes
        bad = ~((volumes > 0).all(axis=0) | (volumes < 0).all(axis=0))
        if bad.any():
            raise ModelError(f"mesh: {int(bad.sum())} elements are not convex or have no volume, first element {int(np.argmax(bad))}; repair it")
        check_one_piece(self.mesh)

    def boundary_nodes(self, name: str, argument: str) -> Integers:
        """Nodes on the boundary of that name; error messages call it `argument`."""
        return np.unique(self.mesh.facets[:, outline_facets(self.mesh, name, argument)])

    def force(self, load: "Traction3D | BodyForce3D") -> Array:
        """(3, nodes) nodal forces of a traction or a body force on this body."""
        if isinstance(load, BodyForce3D):
            return np.outer([load.x, load.y, load.z], _value.assemble(self._basis))
        if not isinstance(load, Traction3D):
            raise ModelError(f"load: {shown(load)}; give a Traction3D or a BodyForce3D")
        facets = outline_facets(self.mesh, load.boundary, "load")
        return np.outer([load.x, load.y, load.z], _value.assemble(FacetBasis(self.mesh, self._basis.elem, facets=facets)))

    def inward(self, boundary: str) -> Array:
        """(nodes, 3) normals into the body at the nodes of a boundary, the mean over its facets weighted by their size, of any length."""
        basis = FacetBasis(self.mesh, self._basis.elem, facets=outline_facets(self.mesh, boundary, "boundary"))
        return -np.column_stack([LinearForm(lambda v, w, axis=axis: w.n[axis] * v).assemble(basis) for axis in range(3)])

    def stiffness(self) -> csr_matrix:
        """Stiffness matrix; unknowns are all x displacements by node, then all y, then all z ones.

        For "mean_dilatation" the first Lame constant resists the mean of div u over an element (selective integration; Hughes 1980).
        """
        products = {(a, b): _product(a, b).assemble(self._basis) for a in range(3) for b in range(a + 1)}
        lam, mu = self.material.lame
        pointwise = 0.0 if self.element == "mean_dilatation" else lam
        blocks: list[list[Any]] = [[None] * 3 for _ in range(3)]
        for a in range(3):
            blocks[a][a] = (pointwise + 2 * mu) * products[a, a] + sum(mu * products[b, b] for b in range(3) if b != a)
            for b in range(a):
                blocks[b][a] = pointwise * products[a, b] + mu * products[a, b].T
                blocks[a][b] = blocks[b][a].T
        K = bmat(blocks, format="csr")
        if self.element == "linear":
            return K
        uniform = self._basis.with_element(_UNIFORM[type(self.mesh)]())
        volume_change = hstack([_mean_gradient(axis).assemble(self._basis, uniform) for axis in range(3)])
        return csr_matrix(K + lam * (volume_change.T @ diags(1 / self._basis.dx.sum(axis=1)) @ volume_change))

    @property
    def _basis(self) -> Any:
        return Basis(self.mesh, _ELEMENTS[type(self.mesh)]())

    @property
    def _volumes(self) -> Array:
        """Signed volume of the elements as it is at each of their corners."""
        corners, element = self.mesh.elem.refdom.p, _ELEMENTS[type(self.mesh)]()
        slopes = np.array([np.broadcast_to(element.lbasis(corners, i)[1], corners.shape) for i in range(len(self.mesh.t))])
        return np.asarray(np.linalg.det(np.einsum("aie,ibk->keab", self.mesh.p[:, self.mesh.t], slopes)))


@dataclass(frozen=True)
class Support3D:
    """A support: nodes of one body whose displacements are zero.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        Name of a boundary, or the coordinates (x, y, z) of one node.
    directions
        The displacements that are zero: "x", "y", "z", or several of them, such as "xy".

    Raises
    ------
    ModelError
        No such directions, a body that is no text, a place that is neither a text nor a point.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Support3D("block", "bottom")
    Support3D(body='block', where='bottom', directions='xyz')
    """

    body: str
    where: str | tuple[float, float, float]
    directions: Literal["x", "y", "z", "xy", "xz", "yz", "xyz"] = "xyz"

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        choice("directions", self.directions, _DIRECTIONS)
        if not isinstance(self.where, str):
            if not isinstance(self.where, tuple | list) or len(self.where) != 3:
                raise ModelError(f"where: {shown(self.where)}; give the name of a boundary or one point (x, y, z)")
            object.__setattr__(self, "where", tuple(finite_number("where", value) for value in self.where))


@dataclass(frozen=True)
class Traction3D:
    """Uniform traction (x, y, z), force per area, on a named boundary of one body.

    Raises
    ------
    ModelError
        A body or a boundary that is no text, tractions that are not finite.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Traction3D("punch", "top", z=-1e6)  # a pressure
    Traction3D(body='punch', boundary='top', x=0.0, y=0.0, z=-1000000.0)
    """

    body: str
    boundary: str
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        check_text("boundary", self.boundary, "the name of a boundary of the mesh")
        for name in ("x", "y", "z"):
            object.__setattr__(self, name, finite_number(f"traction {name}", getattr(self, name)))


@dataclass(frozen=True)
class BodyForce3D:
    """Uniform body force (x, y, z), force per volume, on one body: gravity, for instance.

    Raises
    ------
    ModelError
        A body that is no text, forces that are not finite.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.BodyForce3D("block", z=-7850 * 9.81)
    BodyForce3D(body='block', x=0.0, y=0.0, z=-77008.5)
    """

    body: str
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        for name in ("x", "y", "z"):
            object.__setattr__(self, name, finite_number(f"body force {name}", getattr(self, name)))


def _product(a: int, b: int) -> Any:
    """Derivative of u along axis a times that of v along axis b."""
    return BilinearForm(lambda u, v, _: u.grad[a] * v.grad[b])


def _mean_gradient(a: int) -> Any:
    """Derivative of u along axis a, its mean over an element where v is uniform there."""
    return BilinearForm(lambda u, v, _: u.grad[a] * v)


_value = LinearForm(lambda v, _: v)
