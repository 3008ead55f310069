"""Tightened bolts: a cut through a shank, whose faces a given force pulls together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import block_diag, csr_matrix, hstack, identity
from skfem import Mesh

from ..base import SAME_POINT, Array, Booleans, Integers, choice, finite_number, flag
from ..errors import ModelError
from .bodies import Body
from .elasticity import (
    Kinematics,
    boundary_forces,
    element_parts,
    facet_nodes,
    node_areas,
    nodes_from,
)
from .loads import Part

# A section may leave its plane by this share of its extent: coordinates in decks have few digits.
_FLAT = 1e-3


@dataclass(frozen=True)
class BoltPreload(Part):
    """The force of a tightened bolt: the tension in a plane section of its shank.

    The model cuts the body at the section, with separate nodes on both faces, and equal and
    opposite tractions pull the faces together. The axis is the normal of the section. Along the
    axis, all nodes of one face move by the same distance relative to the other face, and this
    distance is free. Across the axis the two faces do not move relative to each other. So the
    tension is always the force times the amplitude of its load case. Other loads bend and shear the
    bolt, but do not change its tension. Other codes call this a pretension section whose length is
    not locked.

    After tightening, the faces of a locked bolt keep their distance, and the tension changes with
    the loads. The bolt then carries a part of a pull along its axis, and the contact loses less
    pressure. The amplitude of the load case of a locked bolt multiplies the distance by which
    tightening brings the faces together. Amplitude 1 gives the force in the glued bodies if no
    other load acts. `frictopt.joints.tightened` finds the amplitude that gives the force under the
    mean load, with the contact as it is. `SteadyState.bolt_table` has the tension over a cycle.
    Equilibrium alone does not determine the tension, so `gross_slip` follows transients. Theory,
    eq. (25).

    Parameters
    ----------
    body
        Name of the body in its model.
    section
        Name of a boundary of its mesh: facets inside the body, in one plane across the shank, that
        cut the body in two. In gmsh it is a physical surface between two volumes of the same
        physical group. A contact or a support must hold the part on either side along the axis.
    force
        Tension, force; per depth in the plane, of the whole circumference if axisymmetric; half of
        the tension if symmetry halves the bolt. Above 0 if the bolt is locked.
    locked
        Whether the bolt keeps its length once it is tightened. A locked bolt must be the only load
        of its load case, and must not be in another load case.

    Raises
    ------
    ModelError
        A body or a section that is not a string, or a force that is not a finite number, or not
        above 0 if the bolt is locked. In a model: facets on the outline or out of one plane; a
        section that does not cut the body in two, or has nodes in another section, in a contact, or
        held along the axis; a free end; a locked bolt with other loads in its load case, or in two
        load cases.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.BoltPreload("bolt", "section", 20e3)
    BoltPreload(body='bolt', section='section', force=20000.0, locked=False)
    """

    body: str
    section: str
    force: float = 1.0
    locked: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if flag("locked", self.locked):
            finite_number("force", self.force, above=0.0)

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        """Nodal forces of a uniform tension on both faces of the section of a body that is cut."""
        facets = body.boundary(self.section, "section")
        area_of_both = node_areas(body.mesh, facets, kinematics).sum()

        def tension(_: Array, normals: Array) -> Array:
            return np.asarray(2 * self.force / area_of_both * normals)

        return boundary_forces(body.mesh, facets, tension, kinematics)


@dataclass(frozen=True, eq=False)
class Cut:
    """A bolt with the (n,) nodes on either face of its section, and its axis (d,).

    The axis points from the near face into the far part.
    """

    bolt: BoltPreload
    near: Integers
    far: Integers
    axis: Array

    @property
    def along(self) -> Booleans:
        """(d,) coordinate axes along which the faces move apart, at least in part."""
        return np.abs(self.axis) > SAME_POINT


def bolts_of(loads: Mapping[str, Sequence[object]]) -> list[BoltPreload]:
    """The bolts of some load cases, one for each section."""
    bolts: dict[tuple[str, str], BoltPreload] = {}
    for case, parts in loads.items():
        for bolt in parts:
            if not isinstance(bolt, BoltPreload):
                continue
            before = bolts.setdefault((bolt.body, bolt.section), bolt)
            if (before.locked or bolt.locked) and (before is not bolt or len(parts) > 1):
                also = "with other loads" if before is bolt else "in another load case too"
                raise ModelError(
                    f"loads[{case!r}]: the locked bolt {bolt.body!r}, section {bolt.section!r}, "
                    f"{also}; give it a load case of its own"
                )
    return [*bolts.values()]


def by_their_forces(
    loads: Mapping[str, Sequence[object]], R: Array, L: Array
) -> tuple[dict[str, Array], Array, dict[str, tuple[float, float]]]:
    """Bonded reactions and compliance, scaled so that amplitude 1 of a locked bolt gives its force.

    The given reactions R (k, loads) and compliance L are for a shortening of 1. They are multiplied
    by the shortening that gives the force in the glued bodies. The third result has the force and
    this shortening of each locked bolt.
    """
    units = np.ones(len(L))
    bolts = {}
    for k, (name, (bolt, *_)) in enumerate(loads.items()):
        if isinstance(bolt, BoltPreload) and bolt.locked:
            units[k] = -bolt.force / L[k, k]
            bolts[name] = bolt.force, float(units[k])
    bonded = dict(zip(loads, (R * units).T, strict=True))
    return bonded, L * np.outer(units, units), bolts


def cut_bodies(
    bodies: Mapping[str, Body], bolts: Sequence[BoltPreload], kinematics: Kinematics
) -> tuple[dict[str, Body], list[Cut]]:
    """The bodies with the sections of bolts cut, and the cuts.

    Among the corner nodes of the cut mesh, the nodes of the far faces come last.
    """
    cut = dict(bodies)
    cuts = []
    for bolt in bolts:
        name = choice("bolt: body", bolt.body, cut)
        mesh = cut[name].mesh
        where = f"bolt {name!r}: section {bolt.section!r}"
        if bolt.section not in (mesh.boundaries or {}):
            raise ModelError(f"{where} is unknown; this mesh names {sorted(mesh.boundaries or {})}")
        near, far, axis, mesh, origin = _cut(mesh, bolt.section, where)
        if kinematics == "axisymmetric" and abs(axis[0]) > _FLAT:
            raise ModelError(
                f"{where} is not normal to the axis x = 0; cut an axisymmetric bolt at one y"
            )
        # The copy is not checked again: its two parts are one body, although they share no facets.
        whole = cut[name]
        cut[name] = whole.with_mesh(mesh)
        if whole.deck_node is not None:
            vars(cut[name]).update(deck_node=whole.deck_node[origin])
        cuts.append(Cut(bolt, near, far, axis))
    return cut, cuts


def _cut(mesh: Mesh, section: str, where: str) -> tuple[Integers, Integers, Array, Mesh, Integers]:
    """Nodes of the near and the far face of a section, its axis, and the mesh cut there.

    In the cut mesh, both faces form the boundary that has the name of the section. The last result
    is the node of the whole mesh at each node of the cut mesh.
    """
    facets = np.unique(mesh.boundaries[section])
    if not len(facets) or np.any(mesh.f2t[1, facets] < 0):
        raise ModelError(
            f"{where} has no facets, or facets on the outline of the body; name the facets of a "
            "plane through its inside"
        )
    across = facet_nodes(mesh, facets)
    axis = _axis(mesh, across, where)
    far_part = _far_part(mesh, facets, axis, where)

    # Elements of the far part have copies of the corners of the section.
    n = mesh.nvertices
    corners = np.unique(mesh.facets[:, facets])
    copies = np.arange(n)
    copies[corners] = n + np.arange(len(corners))
    t = np.where(far_part, copies[mesh.t], mesh.t)
    whole = replace(mesh, t=t, sort_t=False, _boundaries=None)
    origin = nodes_from(mesh, slice(None), whole, slice(None))
    whole = replace(whole, doflocs=np.take(mesh.p, origin, axis=1))

    boundaries = {
        name: np.unique(whole.t2f[np.isin(mesh.t2f, facets_of_name)])
        for name, facets_of_name in mesh.boundaries.items()
    }
    near, far = (nodes_from(whole, part, mesh, part)[across] for part in (~far_part, far_part))
    return near, far, axis, whole.with_boundaries(boundaries), origin


def _axis(mesh: Mesh, across: Integers, where: str) -> Array:
    """(d,) the normal of a plane section, with its largest component positive."""
    arms = mesh.p[:, across] - mesh.p[:, across].mean(axis=1, keepdims=True)
    axis = np.linalg.svd(arms, full_matrices=False)[0][:, -1]
    axis = axis * np.sign(axis[np.abs(axis).argmax()])
    off = np.abs(axis @ arms).max()
    if off > _FLAT * np.ptp(arms, axis=1).max():
        raise ModelError(
            f"{where} is not flat, it leaves its plane by {off:g}; name facets in one plane "
            "through the shank"
        )
    return np.asarray(axis)


def _far_part(mesh: Mesh, facets: Integers, axis: Array, where: str) -> Booleans:
    """(elements,) whether an element lies beyond the section along the axis."""
    part = element_parts(mesh, facets)
    sides = mesh.f2t[:, facets]
    heights = axis @ mesh.p[:, mesh.t].mean(axis=1)
    ordered = np.take_along_axis(sides, np.argsort(heights[sides], axis=0), axis=0)
    behind = np.unique(part[ordered[0]])
    ahead = np.unique(part[ordered[1]])
    if len(ahead) != 1 or len(behind) != 1 or ahead == behind:
        raise ModelError(
            f"{where} does not cut the body in two; name all facets of one plane through the "
            "shank, from side to side"
        )
    return np.asarray(part == ahead)


def joined_by_elements(meshes: Sequence[Mesh]) -> csr_matrix:
    """(nodes, nodes) links between the corners of each element, mesh after mesh."""
    links = []
    for mesh in meshes:
        first = np.repeat(mesh.t[:1], len(mesh.t), axis=0)
        entries = np.ones(mesh.t.size), (first.ravel(), mesh.t.ravel())
        links.append(csr_matrix(entries, shape=(mesh.p.shape[1],) * 2))
    return csr_matrix(block_diag(links))


def tied_across(rows: Integers, cuts: Sequence[Cut]) -> csr_matrix:
    """The matrix (size, size) that lets the far faces of cuts follow the near faces."""
    follows = np.arange(rows.size)
    for cut in cuts:
        follows[rows[cut.far]] = rows[cut.near]
    return csr_matrix(identity(rows.size, format="csr")[follows])


def released(K: csr_matrix, rows: Integers, cuts: Sequence[Cut]) -> tuple[csr_matrix, csr_matrix]:
    """Matrices R and D (size, size) of `u = R y + D F`, the displacements under loads F.

    The two faces of a cut are tied across the axis; the faces of a locked bolt are also tied along
    the axis. The matrix C makes far faces follow near faces. The columns of c move the far face of
    a free bolt against its axis, by the amounts x: `u = C y + c x`. Along x only the force F acts:
    `c^T (K u - F) = 0`. So y has the stiffness `R^T K R`, which has no stiffness at the far faces,
    and the loads `R^T F`.
    """
    size = K.shape[0]
    moves = [csr_matrix((size, 0))]
    for cut in (cut for cut in cuts if not cut.bolt.locked):
        far = rows[cut.far]
        against_axis = np.tile(-cut.axis, len(far))
        entries = far.ravel(), np.zeros(far.size, int)
        moves.append(csr_matrix((against_axis, entries), shape=(size, 1)))
    C = tied_across(rows, cuts)
    c = csr_matrix(hstack(moves))
    flexible = csr_matrix(np.linalg.inv((c.T @ K @ c).toarray()))
    return csr_matrix(C - c @ (flexible @ (c.T @ K @ C))), csr_matrix(c @ flexible @ c.T)
