"""Back to the bodies: the displacements and stresses that belong to a state of the contact, and views of them."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu
from skfem import BilinearForm

from ..base import (
    COUNTS,
    Array,
    Plotted,
    Shown,
    choice,
    finite_number,
    first_of,
    frozen,
    place,
    shown,
    whole_number,
)
from ..base.libraries import library
from ..errors import ModelError, ModelWarning
from . import schur
from .assembly import Assembly
from .bodies import Body
from .condense import eliminated, fronts
from .elasticity import MOMENTS, Kinematics, basis_of, element_means
from .loads import Expansion
from .sector import on_seam
from .supports import Seam

_COMPONENTS = ("xx", "yy", "xy", "zz", "xz", "yz")  # the first four in the plane
_ARMS = {
    "triangle": [1, 2],
    "quad": [1, 3],
    "tetra": [1, 2, 3],
    "hexahedron": [1, 3, 4],
}  # in the order of VTK, next to the first node
_VTK = [_COMPONENTS.index(name) for name in ("xx", "yy", "zz", "xy", "yz", "xz")]


@runtime_checkable
class Steady(Protocol):
    """A steady state, by what it answers."""

    def states(self) -> Any:
        """Its states over the cycle."""

    def fretting_table(self) -> Any:
        """What frets in it."""


@dataclass(frozen=True, eq=False, repr=False)
class BodyFields(Shown, Plotted):
    """Displacements, strains and stresses in the bodies at one state of the contact.

    Stresses and strains are discontinuous from element to element; nodal ones are their projections
    onto the displacements' own functions (least squares). At sharp corners of a contact they are a
    property of the mesh.

    Attributes
    ----------
    displacement
        Body name -> (d, nodes) displacements x, y (and z in space), length.
    stress, strain
        Body name -> nodal values, rows xx, yy, xy (of the tensor), zz, and in space xz and yz, see
        `stress_of`. In the plane zz is normal to it, or the hoop direction of an axisymmetric body.
        Stress tension positive.
    bodies
        Body name -> body.
    q, p
        Reactions of body 2 on body 1 in this field, `K u - F` at the nodes of body 1: those of the
        state; (N,), the shear (N, 2) in space.
    slip, gap
        Slip, in the shape of q, and gap (N,) of the state.
    units
        Names of the units of the model; None: not known.

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
    slip: Array
    gap: Array
    bodies: Mapping[str, Body]
    units: str | None
    _frames: Array
    _sides: tuple[csr_matrix, csr_matrix]

    def _answer(self) -> Mapping[str, object]:
        of, values = max(
            ((name, von_mises(rows)) for name, rows in self.stress.items()),
            key=lambda one: float(one[1].max()),
        )
        at = place(self.bodies[of].mesh.p[:, values.argmax()])
        return {
            "bodies": list(self.displacement),
            "nodes": len(self.p),
            "largest_von_mises": f"{values.max():.6g} in {of} at {at}",
        }

    def stress_of(self, body: str, component: str) -> Array:
        """(nodes,) nodal values of a stress in a body: "xx", "yy", "zz", "xy", in space "yz", "xz", or "von Mises", force per area, tension positive.

        Raises
        ------
        ModelError
            An unknown body or component.

        Examples
        --------
        >>> import frictopt as fo
        >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
        >>> fields = model.recover({"P": 1.0}, slip=[0.0] * 5)
        >>> f"{fields.stress_of('punch', 'yy').min():.3f}", f"{fields.stress_of('block', 'von Mises').max():.3f}"
        ('-4.333', '2.297')
        """
        self._body(body)
        rows = self.stress[body]
        known = (*_COMPONENTS[: len(rows)], "von Mises")
        return frozen([*rows, von_mises(rows)][known.index(choice("component", component, known))])

    def at_contact(self, side: int) -> tuple[Array, Array]:
        """Stress and strain along the contact at its nodes, in body 1 (`side=1`) or at their places in body 2 (`side=2`).

        (N,) along the tangent; in space the (N, 2, 2) components along the two tangents.

        Raises
        ------
        ModelError
            A side that is neither 1 nor 2.
        """
        d, tangents = self._frames.shape[1], self._frames[:, :-1]
        found = (
            np.einsum("nia,nab,njb->nij", tangents, tensors[:, :d, :d], tangents)
            for tensors in self.tensors_at_contact(side)
        )
        stress, strain = (frozen(one[:, 0, 0] if d == 2 else one) for one in found)
        return stress, strain

    def tensors_at_contact(self, side: int) -> tuple[Array, Array]:
        """(N, 3, 3) stress and strain in x, y, z at the nodes of the contact, in body 1 (`side=1`) or at their places in body 2 (`side=2`).

        Raises
        ------
        ModelError
            A side that is neither 1 nor 2.
        """
        projection = self._sides[whole_number("side", side, least=1, most=2) - 1]
        order = [[_COMPONENTS.index("".join(sorted(a + b))) for b in "xyz"] for a in "xyz"]

        def tensors(fields: Mapping[str, Array]) -> Array:
            rows = np.concatenate(list(fields.values()), axis=1)
            return frozen((projection @ np.pad(rows, ((0, 6 - len(rows)), (0, 0))).T)[:, order])

        return tensors(self.stress), tensors(self.strain)

    def plot_deformed(self, ax: Any = None, *, scale: float | None = None) -> Any:
        """Draw the bodies under their displacements, `scale` times enlarged (None: the largest is a tenth of the model), and as they were.

        See `plot` for the argument and what may be raised.
        """
        factor = None if scale is None else finite_number("scale", scale, least=0.0)
        pictures = self._pictures()
        return pictures.draw(self, ax, pictures.deformed, enlarged=factor)

    def save(self, path: str | Path, body: str) -> None:
        """Write the fields of one body to a file of meshio, such as `.vtu`: displacement, stress, strain (xx, yy, zz, xy, yz, xz), von_mises.

        `write_paraview` writes all bodies and the contact.

        Raises
        ------
        ModelError
            An unknown body, or a file that cannot be written.
        """
        meshio, whole = library(), self._in_meshio(body)
        try:
            whole.write(path)
        except (OSError, TypeError, ValueError, meshio.WriteError, meshio.ReadError) as error:
            raise ModelError(
                f"path: {shown(path)} cannot be written ({error}); give a file that ends in .vtu, in a folder that exists"
            ) from error

    def _in_meshio(self, body: str) -> Any:
        """The mesh of one body in space with its fields, of meshio."""
        mesh = in_meshio(self._body(body).mesh)
        d = len(self.displacement[body])
        data = {"displacement": np.pad(self.displacement[body].T, ((0, 0), (0, 3 - d)))}
        for name, field in (("stress", self.stress[body]), ("strain", self.strain[body])):
            data[name] = np.pad(field, ((0, 6 - len(field)), (0, 0)))[_VTK].T
        mesh.point_data.update(data, von_mises=von_mises(self.stress[body]))
        return mesh

    def _body(self, name: str) -> Body:
        return self.bodies[choice("body", name, self.bodies)]


def von_mises(stress: Array) -> Array:
    """(nodes,) von Mises stress, of the components (xx, yy, xy, zz, in space xz and yz, nodes)."""
    xx, yy, _, zz = stress[:4]
    return np.asarray(
        np.sqrt(
            ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
            + 3 * (stress[[2, *range(4, len(stress))]] ** 2).sum(axis=0)
        )
    )


def in_meshio(mesh: Any) -> Any:
    """A mesh of scikit-fem as one in space of meshio, its elements right-handed: VTK counts the volume of others as negative."""
    library()
    from skfem.io.meshio import to_meshio  # here, for it imports meshio

    whole, places = to_meshio(mesh, encode_cell_data=False), mesh.elem().doflocs
    whole.points = np.pad(mesh.p.T, ((0, 0), (0, 3 - mesh.dim())))
    cells, arms = whole.cells[0].data, _ARMS[whole.cells[0].type.rstrip("0123456789")]
    left = np.linalg.det(mesh.p.T[cells[:, arms]] - mesh.p.T[cells[:, :1]]) < 0
    places = places[(cells[0][:, None] == mesh.dofs.element_dofs[:, 0]).argmax(axis=1)]
    mirrored = places[:, [1, 0, 2][: mesh.dim()]]
    cells[left] = cells[left][:, np.linalg.norm(mirrored[:, None] - places, axis=2).argmin(axis=1)]
    return whole


class Viewed(Plotted):
    """Base of models that PyVista shows."""

    def view(
        self,
        result: object = None,
        show: str = "von_mises",
        *,
        scale: float = 0.0,
        plotter: Any = None,
    ) -> Any:
        """The bodies, the faces of the contacts and a field on them as a scene of PyVista (extra `view`).

        `.show()` of what is returned opens a window, or in a notebook a view to turn with the
        mouse. `.screenshot("joint.png")` writes a picture; with `pyvista.OFF_SCREEN = True` it
        needs no screen.

        Parameters
        ----------
        result
            Fields that `recover` gave, or a steady state of the condensed model, at its last
            corner; None: the meshes, with the contacts in black.
        show
            Of the bodies "von_mises" or "displacement"; of the contacts, seen through the bodies,
            "pressure", "shear", "slip", "gap", and of a steady state "work_density", the work of
            friction per cycle and area. Of vectors the length.
        scale
            The bodies are drawn under so many times their displacements.
        plotter
            A pyvista.Plotter to draw in; None: a new one.

        Returns
        -------
        pyvista.Plotter

        Raises
        ------
        ImportError
            pyvista is not installed.
        ModelError
            A result of another kind or of another model, a field that it does not have, or no
            plotter.

        Examples
        --------
        >>> import frictopt as fo
        >>> model = fo.scenes.SquarePunch(elements=2, growth=3.0).model()
        >>> fields = model.recover({"P": 1.0, "Qx": 0.3}, slip=[[0.0, 0.0]] * 9)
        >>> view = model.view(fields, "pressure", scale=0.1)
        >>> list(view.scalar_bars.keys())
        ['pressure (force per area)']
        >>> view.close()
        """
        return self._pictures("views").view(self, result, show, scale, plotter)


class Recovery:
    """The factorisation that gives displacements of a model back, `u = T y + D z` with the relative motions z."""

    def __init__(self, parts: Assembly) -> None:
        K, (T, front) = parts.glued.K, fronts(parts.glued)
        self._K, self._T, self._drive = K, T[:, front >= 0], T[:, front < 0]
        _, self._factors = eliminated(
            parts.glued, csr_matrix(self._T.T @ K @ self._T), self._T, front[front >= 0], keep=True
        )

    def displacements(self, force: Array, z: Array) -> tuple[Array, Array]:
        """(size,) displacements under forces, and relative motions z (d N,); and reactions (d N,)."""
        u = self._drive @ z
        for _ in range(2):  # the second time takes away the rounding of the first
            u += self._T @ schur.solve(self._factors, self._T.T @ (force - self._K @ u))
        return u, np.asarray(self._drive.T @ (self._K @ u - force))


def strain_and_stress(
    name: str,
    body: Body,
    kind: Kinematics,
    u: Array,
    loads: Sequence[tuple[float, Expansion]],
    seam: Seam | None,
) -> list[Array]:
    """(components, nodes) nodal strain and stress of a body, with its part of expansions, amplitude and load; of a sector with its seam."""
    basis, d, (lam, mu) = basis_of(body.mesh), len(u), body.material._plane_lame(kind)
    x, own = (
        np.asarray(basis.global_coordinates())[0],
        [(amplitude, part) for amplitude, part in loads if part.body == name],
    )
    fields, strain, nothing = (
        [basis.interpolate(component) for component in u],
        np.zeros((3, 3, *x.shape)),
        np.zeros_like(x),
    )
    slopes = np.array([np.asarray(field.grad) for field in fields])
    strain[:d, :d] = (slopes + slopes.swapaxes(0, 1)) / 2
    if kind == "axisymmetric":
        strain[2, 2] = np.asarray(fields[0]) / x
    volume = (
        element_means(basis, np.trace(strain))
        if body.element == "mean_dilatation"
        else np.trace(strain)
    )
    tension = lam * volume - sum(
        (amplitude * part._tension(body, kind, basis) for amplitude, part in own), nothing
    )
    stress = 2 * mu * strain + tension * np.eye(3)[:, :, None, None]
    if kind == "plane_stress":
        free = sum((amplitude * part._strain(basis) for amplitude, part in own), nothing)
        strain[2, 2] = -body.material.nu / body.material.E * (stress[0, 0] + stress[1, 1]) + free
        stress[2, 2] = 0.0
    solve = splu(mass := BilinearForm(lambda a, b, w: a * b).assemble(basis).tocsc()).solve
    entries = [
        3 * "xyz".index(pair[0]) + "xyz".index(pair[1])
        for pair in _COMPONENTS[: 4 if d == 2 else 6]
    ]
    moments = (
        [MOMENTS.assemble(basis, amount=tensor.reshape(9, *x.shape)[i]) for i in entries]
        for tensor in (strain, stress)
    )
    return [
        frozen(
            [solve(moment) for moment in own] if seam is None else on_seam(mass, own, entries, seam)
        )
        for own in moments
    ]


def warn_of_open_nodes(w: Array, r: Array, moved: float) -> None:
    """Warn of forces (d N,) at nodes that are open, beside displacements of the bodies."""
    forces = np.linalg.norm(r.reshape(-1, len(w)), axis=0)
    carries = (w > COUNTS * moved) & (forces > COUNTS * forces.max())
    if (i := first_of(carries, forces)) is not None:
        warnings.warn(
            f"recover: node {i} is open by {w[i]:g} and carries a force of {forces[i]:.3g}: these are no slip and gap of a state under these loads; "
            "the loads must be all those of the state, and what `with_gap` or `with_contact_stiffness` gave to the system belongs into the model",
            ModelWarning,
            stacklevel=3,
        )
