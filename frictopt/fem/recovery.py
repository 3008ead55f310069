"""Back to the bodies: the displacements and stresses that belong to a state of the contact."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementVector, LinearForm

from ..contact.checks import Array, frozen, shown, whole_number
from ..contact.show import Plotted, Shown
from ..errors import ModelError
from .bodies import Body
from .condense import eliminated
from .elasticity import ELEMENTS, Kinematics, element_means
from .interface import Interface
from .loads import Expansion
from .matrices.meshes import meshio_library
from .ordering import Integers
from .rigid import node_graph

__all__ = ["BodyFields", "Recovery", "body_fields"]

_CELLS = {3: "triangle", 4: "quad"}
_COMPONENTS = ("xx", "yy", "xy", "zz")


@dataclass(frozen=True, eq=False, repr=False)
class BodyFields(Shown, Plotted):
    """Displacements, strains and stresses in the bodies at one state of the contact.

    Stresses and strains are discontinuous from element to element; nodal ones are their projections onto the displacements' own functions (least
    squares). At sharp corners of a contact they are a property of the mesh.

    Attributes
    ----------
    displacement
        Body name -> (2, nodes) displacements x and y, length.
    stress, strain
        Body name -> (4, nodes) nodal values, rows xx, yy, xy (of the tensor), zz; zz is normal to the plane, or the hoop direction of an axisymmetric
        body. Stress tension positive.
    bodies
        Body name -> body.
    q, p
        (N,) reactions of body 2 on body 1 in this field, `K u - F` at the nodes of body 1: those of the state.

    Examples
    --------
    >>> import frictopt as fo
    >>> fields = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model().recover({"P": 1.0}, slip=[0.0] * 5)
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
    bodies: Mapping[str, Body]
    _tangents: Array
    _sides: tuple[csr_matrix, csr_matrix]

    def _answer(self) -> Mapping[str, Any]:
        return {"bodies": list(self.displacement), "nodes": len(self.q)}

    def at_contact(self, side: int) -> tuple[Array, Array]:
        """(N,) stress and strain along the tangent at the nodes of the contact, in body 1 (`side=1`) or at their places in body 2 (`side=2`).

        Raises
        ------
        ModelError
            A side that is neither 1 nor 2.
        """
        projection = self._sides[whole_number("side", side, least=1, most=2) - 1]
        x, y = self._tangents.T

        def along(fields: Mapping[str, Array]) -> Array:
            xx, yy, xy, _ = (projection @ np.concatenate(list(fields.values()), axis=1).T).T
            return frozen(x * x * xx + y * y * yy + 2 * x * y * xy)

        return along(self.stress), along(self.strain)

    def vector(self, body: str) -> tuple[Any, Array]:
        """The displacement of a body as scikit-fem has it: the basis of its vector element, and the vector of its degrees of freedom.

        Raises
        ------
        ModelError
            An unknown body.
        """
        mesh = self._body(body).mesh
        basis = Basis(mesh, ElementVector(ELEMENTS[type(mesh)]()))
        values = np.zeros(basis.N)
        values[basis.nodal_dofs] = self.displacement[body]
        return basis, values

    def save(self, path: str | Path, body: str) -> None:
        """Write the fields of one body to a file of meshio: `.vtu` opens in ParaView.

        Raises
        ------
        ModelError
            An unknown body, or a file that cannot be written.
        """
        meshio = meshio_library()
        mesh = self._body(body).mesh
        flat = np.zeros((1, mesh.p.shape[1]))
        data = {"displacement": np.concatenate([self.displacement[body], flat]).T}
        for name, field in (("stress", self.stress[body]), ("strain", self.strain[body])):
            data |= {f"{name}_{component}": row for component, row in zip(_COMPONENTS, field, strict=True)}
        whole = meshio.Mesh(np.concatenate([mesh.p, flat]).T, [(_CELLS[len(mesh.t)], mesh.t.T)], point_data=data)
        try:
            whole.write(path)
        except (OSError, TypeError, ValueError, meshio.WriteError, meshio.ReadError) as error:
            raise ModelError(
                f"path: {shown(path)} cannot be written ({error}); give a file name that ends in .vtu, in a folder that exists"
            ) from error

    def _body(self, name: str) -> Body:
        if not isinstance(name, str) or name not in self.bodies:
            raise ModelError(f"body: {shown(name)} is unknown; these fields have {sorted(self.bodies)}")
        return self.bodies[name]


class Recovery:
    """The factorisation that gives displacements back: unknowns y of `u = lift + T y`, the relative motions z among them.

    Parameters
    ----------
    K
        Stiffness of the separate bodies.
    interface
        Pairs and directions.
    unknowns, points
        (nodes, 2) rows of K, -1 where held, and coordinates.
    """

    def __init__(self, K: csr_matrix, interface: Interface, unknowns: Integers, points: Array) -> None:
        self._K, self._kept = K, interface.kept
        self._T, self._elimination = eliminated(K, interface, unknowns, points, node_graph(K, unknowns))

    def displacements(self, force: Array, lift: Array, z: Array) -> tuple[Array, Array]:
        """(size,) displacements under forces, displacements `lift` of moved supports, and relative motions z (2N,); and reactions (2N,)."""
        right = self._T.T @ (force - self._K @ lift)
        reactions = self._elimination.reactions(right[:, None])[:, 0]
        u = lift + self._T @ self._elimination.unknowns(right, reactions, z)
        return u, np.asarray((self._T.T @ (self._K @ u - force))[-self._kept :])


def body_fields(
    bodies: Mapping[str, Body],
    kinematics: Kinematics,
    displacement: Mapping[str, Array],
    expansions: Sequence[tuple[float, Expansion]],
    r: Array,
    tangents: Array,
    sides: tuple[csr_matrix, csr_matrix],
) -> BodyFields:
    """Strains and stresses of displacements, body by body; `expansions` are free ones with their amplitudes."""
    strain, stress = {}, {}
    for name, body in bodies.items():
        own = [(amplitude, part) for amplitude, part in expansions if part.body == name]
        strain[name], stress[name] = _strain_and_stress(body, kinematics, displacement[name], own)
    n = len(r) // 2
    moved = {name: frozen(u) for name, u in displacement.items()}
    return BodyFields(moved, stress, strain, frozen(r[:n]), frozen(r[n:]), bodies, tangents, sides)


def _strain_and_stress(body: Body, kinematics: Kinematics, u: Array, expansions: Sequence[tuple[float, Expansion]]) -> tuple[Array, Array]:
    """(4, nodes) nodal strain and stress."""
    basis = Basis(body.mesh, ELEMENTS[type(body.mesh)]())
    x = np.asarray(basis.global_coordinates())[0]
    fields = [basis.interpolate(component) for component in u]
    (ux_x, ux_y), (uy_x, uy_y) = (np.asarray(field.grad) for field in fields)
    out = np.asarray(fields[0]) / x if kinematics == "axisymmetric" else np.zeros_like(x)
    lam, mu = body.material._plane_lame(kinematics)
    volume = ux_x + uy_y + out
    if body.element == "mean_dilatation":
        volume = element_means(basis, volume)
    tension = lam * volume - sum((amplitude * part._tension(body, kinematics, basis) for amplitude, part in expansions), np.zeros_like(x))
    xx, yy, xy = tension + 2 * mu * ux_x, tension + 2 * mu * uy_y, mu * (ux_y + uy_x)
    zz = np.zeros_like(x) if kinematics == "plane_stress" else tension + 2 * mu * out
    if kinematics == "plane_stress":
        free = sum((amplitude * part._strain(basis) for amplitude, part in expansions), np.zeros_like(x))
        out = -body.material.nu / body.material.E * (xx + yy) + free
    strain, stress = (ux_x, uy_y, (ux_y + uy_x) / 2, out), (xx, yy, xy, zz)
    mass = splu(BilinearForm(lambda a, b, w: a * b).assemble(basis).tocsc())
    rows = [mass.solve(np.asarray(LinearForm(lambda v, w: w.amount * v).assemble(basis, amount=part))) for part in (*strain, *stress)]
    return frozen(rows[:4]), frozen(rows[4:])
