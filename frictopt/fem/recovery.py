"""Displacements and stresses in the bodies, recovered from a state of the contact."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, runtime_checkable

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu
from skfem import MeshHex1, MeshQuad1

from ..base import (
    COUNTS,
    Array,
    Plotted,
    Shown,
    choice,
    first_of,
    frozen,
    place,
    whole_number,
)
from ..base.files import library
from ..errors import ModelWarning
from . import schur
from .bodies import Body
from .condense import eliminated, fronts
from .elasticity import (
    MOMENTS,
    Kinematics,
    assembled,
    basis_of,
    element_means,
    functions_at,
    in_space,
)
from .loads import Expansion
from .mixed import MIXED
from .rigid import Glued
from .sector import on_seam
from .supports import Seam

# Components in the rows of nodal values; in the plane, the first four.
_COMPONENTS = ("xx", "yy", "xy", "zz", "xz", "yz")
# Neighbours of the first node of an element, in the order of VTK.
_ARMS = {
    "triangle": [1, 2],
    "quad": [1, 3],
    "tetra": [1, 2, 3],
    "hexahedron": [1, 3, 4],
}
_VTK = [_COMPONENTS.index(name) for name in ("xx", "yy", "zz", "xy", "yz", "xz")]


@runtime_checkable
class Steady(Protocol):
    """The parts of a steady state that recovery needs."""

    def states(self) -> Any:
        """The states over the cycle."""

    def fretting_table(self) -> Any:
        """The table of fretting."""


@dataclass(frozen=True, eq=False, repr=False)
class BodyFields(Shown, Plotted):
    """Displacements, strains and stresses in the bodies at one state of the contact.

    Stresses and strains are discontinuous from element to element. Nodal values are their
    least-squares projections onto the shape functions of the displacements. At sharp corners of a
    contact, nodal values depend on the mesh.

    Attributes
    ----------
    displacement
        Body name -> (d, nodes) displacements x, y (and z in space), length.
    stress, strain
        Body name -> nodal values, rows xx, yy, xy (of the tensor), zz, and in space xz and yz, see
        `stress_of`. In the plane, z is the normal of the plane; in an axisymmetric body, the hoop
        direction. Tensile stress is positive.
    bodies
        Body name -> body.
    q, p
        (N,) reactions of body 2 on body 1 in this field, in space (N, 2) for q: `K u - F` at the
        nodes of body 1. They equal the reactions of the state.
    slip, gap
        Slip, in the shape of q, and gap (N,) of the state.
    units
        Names of the units of the model; None: not known.

    Examples
    --------
    >>> import frictopt as fo
    >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    >>> fields = model.recover({"P": 1.0}, slip=[0.0] * 5)
    >>> fields.stress["punch"].shape == (4, fields.displacement["punch"].shape[1])
    True
    >>> stress, strain = fields.at_contact(1)  # along the interface, of body 1
    >>> stress.shape, strain.shape
    ((5,), (5,))
    """

    displacement: Mapping[str, Array]
    stress: Mapping[str, Array]
    strain: Mapping[str, Array]
    q: Array
    p: Array
    slip: Array
    gap: Array
    bodies: Mapping[str, Body]
    units: str | None
    _frames: Array
    _sides: tuple[csr_matrix, csr_matrix]

    def _answer(self) -> Mapping[str, object]:
        stress = {name: von_mises(rows) for name, rows in self.stress.items()}
        body = max(stress, key=lambda name: float(stress[name].max()))
        at = place(self.bodies[body].mesh.p[:, stress[body].argmax()])
        return {
            "bodies": list(self.displacement),
            "nodes": len(self.p),
            "largest_von_mises": f"{stress[body].max():.6g} in {body} at {at}",
        }

    def stress_of(self, body: str, component: str) -> Array:
        """(nodes,) nodal values of a stress in a body, force per area, tension positive.

        Components are "xx", "yy", "zz", "xy", in space "yz" and "xz", and "von Mises".

        Raises
        ------
        ModelError
            An unknown body or component.

        Examples
        --------
        >>> import frictopt as fo
        >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
        >>> fields = model.recover({"P": 1.0}, slip=[0.0] * 5)
        >>> f"{fields.stress_of('punch', 'yy').min():.3f}"
        '-4.333'
        >>> f"{fields.stress_of('block', 'von Mises').max():.3f}"
        '2.297'
        """
        choice("body", body, self.bodies)
        rows = self.stress[body]
        known = (*_COMPONENTS[: len(rows)], "von Mises")
        number = known.index(choice("component", component, known))
        return frozen([*rows, von_mises(rows)][number])

    def at_contact(self, side: int) -> tuple[Array, Array]:
        """Stress and strain along the contact at its nodes.

        `side=1` returns the values in body 1, `side=2` the values in body 2 at the same places. In
        the plane both results (N,) are the components along the tangent; in space they are (N, 2,
        2), the components along the two tangents.

        Raises
        ------
        ModelError
            A side that is neither 1 nor 2.
        """
        stress, strain = self.tensors_at_contact(side)
        return self._along_tangents(stress), self._along_tangents(strain)

    def _along_tangents(self, tensors: Array) -> Array:
        d = self._frames.shape[1]
        tangents = self._frames[:, :-1]
        along = np.einsum("nia,nab,njb->nij", tangents, tensors[:, :d, :d], tangents)
        return frozen(along[:, 0, 0] if d == 2 else along)

    def tensors_at_contact(self, side: int) -> tuple[Array, Array]:
        """(N, 3, 3) stress and strain in x, y, z at the nodes of the contact.

        `side=1` returns the values in body 1, `side=2` the values in body 2 at the same places.

        Raises
        ------
        ModelError
            A side that is neither 1 nor 2.
        """
        projection = self._sides[whole_number("side", side, least=1, most=2) - 1]
        return _tensors_at(projection, self.stress), _tensors_at(projection, self.strain)

    def _in_meshio(self, body: str) -> Any:
        """The mesh of one body with its fields, as a mesh of meshio in space."""
        mesh = in_meshio(self.bodies[body].mesh)
        data = {"displacement": in_space(self.displacement[body].T)}
        for name, field in (("stress", self.stress[body]), ("strain", self.strain[body])):
            data[name] = np.pad(field, ((0, 6 - len(field)), (0, 0)))[_VTK].T
        mesh.point_data.update(data, von_mises=von_mises(self.stress[body]))
        return mesh


def _tensors_at(projection: csr_matrix, fields: Mapping[str, Array]) -> Array:
    """(N, 3, 3) tensors at places, interpolated by a matrix (N, all nodes)."""
    rows = np.concatenate(list(fields.values()), axis=1)
    return frozen(tensors_of([projection @ row for row in rows]))


def tensors_of(rows: Sequence[Array]) -> Array:
    """(N, 3, 3, ...) tensors from arrays (N, ...) of their components; in the plane four."""
    whole = [*rows, *([np.zeros_like(rows[0])] * (6 - len(rows)))]
    order = [[_COMPONENTS.index("".join(sorted(a + b))) for b in "xyz"] for a in "xyz"]
    return np.moveaxis(np.array(whole)[order], 2, 0)


def von_mises(stress: Array) -> Array:
    """(nodes,) von Mises stress, from rows xx, yy, xy, zz (in space also xz, yz) of components."""
    xx, yy, _, zz = stress[:4]
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    shear = 3 * (stress[[2, *range(4, len(stress))]] ** 2).sum(axis=0)
    return np.asarray(np.sqrt(normal + shear))


def in_meshio(mesh: Any) -> Any:
    """A mesh of scikit-fem as a mesh of meshio in space, with right-handed elements.

    VTK counts the volume of left-handed elements as negative.
    """
    library()
    # Imported here, because it imports meshio.
    from skfem.io.meshio import to_meshio

    points = mesh.p.T
    plain = mesh
    if isinstance(mesh, MIXED):
        # VTK takes hexahedra and quadrilaterals with corners that coincide, too.
        plain = (MeshQuad1 if mesh.dim() == 2 else MeshHex1)(mesh.p, mesh.t)
    whole = to_meshio(plain, encode_cell_data=False)
    whole.points = in_space(points)
    cells = whole.cells[0].data
    arms = _ARMS[whole.cells[0].type.rstrip("0123456789")]
    left_handed = np.linalg.det(points[cells[:, arms]] - points[cells[:, :1]]) < 0
    # Places of the nodes in the reference element, in the order of meshio.
    order = (cells[0][:, None] == mesh.dofs.element_dofs[:, 0]).argmax(axis=1)
    places = mesh.elem().doflocs[order]
    # With x and y exchanged, the element has the same nodes in another order.
    mirrored = places[:, [1, 0, 2][: mesh.dim()]]
    exchanged = np.linalg.norm(mirrored[:, None] - places, axis=2).argmin(axis=1)
    cells[left_handed] = cells[left_handed][:, exchanged]
    return whole


class Recovery:
    """The factorisation from which the displacements of a model are recovered.

    The displacements are `u = T y + D z`, with the relative motions z.
    """

    def __init__(self, glued: Glued) -> None:
        T, front = fronts(glued)
        free = front >= 0
        self._K = glued.K
        self._T = T[:, free]
        self._drive = T[:, front < 0]
        K = csr_matrix(self._T.T @ self._K @ self._T)
        _, self._factors = eliminated(glued, K, self._T, front[free], keep=float)

    def displacements(self, force: Array, z: Array) -> tuple[Array, Array]:
        """(size, n) displacements and (d N, n) reactions.

        Both are computed for n forces (size, n) and n relative motions z (d N, n).
        """
        u = self._drive @ z
        # The second pass removes the rounding of the first.
        for _ in range(2):
            u += self._T @ schur.solve(self._factors, self._T.T @ (force - self._K @ u))
        return u, self._drive.T @ (self._K @ u - force)


class NodalFields:
    """The nodal strain and stress of a body as linear functions of its displacements.

    They are least-squares projections onto the shape functions of the nodes. The moments of a field
    are its integrals weighted with these functions. Sparse matrices give the moments from the
    displacements.

    Parameters
    ----------
    body, kind
        The body and its kinematics.
    seam
        The seam of a sector; None if the body is not cut.
    """

    def __init__(self, body: Body, kind: Kinematics, seam: Seam | None) -> None:
        self._body = body
        self._kind = kind
        self._seam = seam
        self._basis = basis = basis_of(body.mesh)
        functions, slopes = functions_at(basis)
        # makes the (nodes, nodes) matrix of the moments of a field, from the rates of the field
        # with the displacements of the nodes
        moments = partial(assembled, body.mesh, basis.dx, functions)
        self._mass = moments(functions).tocsc()
        self._solve = splu(self._mass).solve
        self._slopes = [moments(slope) for slope in np.moveaxis(slopes, 2, 0)]
        self._volume = self._slopes
        if body.element == "mean_dilatation":
            means = element_means(basis.dx, slopes)
            self._volume = [moments(mean) for mean in np.moveaxis(means, 2, 0)]
        self._hoop = None
        if kind == "axisymmetric":
            x = np.asarray(basis.global_coordinates())[0]
            self._hoop = moments(functions / x[:, None])

    def of(self, u: Array, expansions: Sequence[tuple[Expansion, Array]]) -> tuple[Array, Array]:
        """(components, nodes, n) strain and stress under n displacements u (d, nodes, n).

        The expansions of this body are given with their (n,) amplitudes.
        """
        d = len(u)
        lam, mu = self._body.material._plane_lame(self._kind)
        slopes = np.array([[slope @ part for slope in self._slopes] for part in u])
        strain = np.zeros((3, 3, *u.shape[1:]))
        strain[:d, :d] = (slopes + slopes.swapaxes(0, 1)) / 2
        volume = sum(slope @ part for slope, part in zip(self._volume, u, strict=True))
        if self._hoop is not None:
            strain[2, 2] = self._hoop @ u[0]
            volume = volume + strain[2, 2]
        free = np.zeros(u.shape[1:])
        tension = lam * volume
        for part, amplitudes in expansions:
            taken = part._tension(self._body, self._kind, self._basis)
            tension -= np.outer(MOMENTS.assemble(self._basis, amount=taken), amplitudes)
            expansion = MOMENTS.assemble(self._basis, amount=part._strain(self._basis))
            free += np.outer(expansion, amplitudes)
        stress = 2 * mu * strain + tension * np.eye(3)[:, :, None, None]
        if self._kind == "plane_stress":
            material = self._body.material
            strain[2, 2] = -material.nu / material.E * (stress[0, 0] + stress[1, 1]) + free
            stress[2, 2] = 0.0
        return self._nodal(strain, d), self._nodal(stress, d)

    def _nodal(self, moments: Array, d: int) -> Array:
        """(components, nodes, n) nodal values of a tensor from its moments (3, 3, nodes, n)."""
        components = _COMPONENTS[: 4 if d == 2 else 6]
        i, j = np.transpose([["xyz".index(axis) for axis in pair] for pair in components])
        if self._seam is None:
            return np.array([self._solve(row) for row in moments[i, j]])
        columns = [
            on_seam(self._mass, moments[..., column], self._seam)[i, j]
            for column in range(moments.shape[3])
        ]
        return np.stack(columns, axis=2)


def warn_of_open_nodes(w: Array, r: Array, moved: float) -> None:
    """Warn of forces r (d N,) at nodes with gaps w (N,); `moved` is the largest displacement."""
    forces = np.linalg.norm(r.reshape(-1, len(w)), axis=0)
    carries = (w > COUNTS * moved) & (forces > COUNTS * forces.max())
    i = first_of(carries, forces)
    if i is not None:
        warnings.warn(
            f"recover: node {i} is open by {w[i]:g} and carries a force of {forces[i]:.3g}: "
            "slip and gap do not belong to a state under these loads; give all loads of the "
            "state; a gap or a contact stiffness must be part of the model, not added to the "
            "system",
            ModelWarning,
            stacklevel=3,
        )
