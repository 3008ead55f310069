"""Bolts that are tightened: a cut through a shank, whose faces a given force pulls together."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix, hstack
from skfem import Mesh

from ..base import Array, Integers, choice, finite_number, flag
from ..errors import ModelError
from .bodies import Body
from .elasticity import Kinematics, boundary_forces, facet_nodes, parts_of, points_from
from .loads import Part

_FLAT = (
    1e-3  # share of its extent by which a section may be out of its plane: decks have few digits
)


@dataclass(frozen=True)
class BoltPreload(Part):
    """The force that a bolt is tightened with: the tension in a plane section of its shank.

    The model cuts the body there, by nodes of their own on both faces, and equal and opposite
    tractions pull the faces together. Along the axis, the normal of the section, all nodes of one
    face move by the same distance relative to the other face, and this distance is free; across the
    axis they do not move relative to each other. So the tension is this force, times the amplitude
    of its load case, under every load: other loads bend and shear the bolt, but do not stretch it.
    This is the pretension section of other codes before its length is locked.

    A bolt that is locked keeps the distance by which the faces have come together, and its tension
    changes with the loads: a pull along it goes through the bolt in part, and takes less off the
    contact. The amplitude of its load case multiplies this distance; amplitude 1 gives the force in
    the glued bodies under no other load. `frictopt.tightened` finds the amplitude that gives the
    force under the mean load, with the contact as it is. `SteadyState.bolt_table` has the tension
    over a cycle. Statics takes any tension for possible, so `gross_slip` follows transients.
    Theory, eq. (25).

    Parameters
    ----------
    body
        Name of the body in its model.
    section
        Name of a boundary of its mesh: facets inside the body, in one plane across the shank, that
        cut the body in two. In gmsh it is a physical surface between two volumes of the same
        physical group. A contact or a support holds what lies on either side along the axis.
    force
        Tension, force; per depth in the plane, of the whole circumference if axisymmetric; half of
        it where symmetry halves the bolt. Above 0 if the bolt is locked.
    locked
        Whether its length is kept once it is tightened. It is then the only load of its load case,
        and stands in no other one.

    Raises
    ------
    ModelError
        A body or a section that is no text, a force that is not a finite number, of a locked bolt
        not above 0. In a model: facets on the outline or out of one plane, a section that does not
        cut the body in two, or has nodes in another section, in a contact, or held along the axis;
        an end that nothing holds; a locked bolt with other loads in its load case, or in two load
        cases.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.BoltPreload("bolt", "section", 20e3)
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
        """Nodal forces of a uniform tension on both faces of a body that is cut."""
        facets = body.boundary(self.section, "section")
        both = boundary_forces(
            body.mesh, facets, lambda points, _: np.ones((1, *points.shape[1:])), kinematics
        ).sum()
        return boundary_forces(
            body.mesh, facets, lambda _, normals: 2 * self.force / both * normals, kinematics
        )


@dataclass(frozen=True, eq=False)
class Cut:
    """The bolt, the (n,) nodes on either face, and the axis (d,) of the bolt, which points from the near face into the far part."""

    bolt: BoltPreload
    near: Integers
    far: Integers
    axis: Array


def bolts_of(loads: Mapping[str, Sequence[object]]) -> list[BoltPreload]:
    """The bolts of some load cases, one for each section."""
    found: dict[tuple[str, str], BoltPreload] = {}
    for case, parts in loads.items():
        for bolt in parts:
            if not isinstance(bolt, BoltPreload):
                continue
            before = found.setdefault((bolt.body, bolt.section), bolt)
            if (before.locked or bolt.locked) and (before is not bolt or len(parts) > 1):
                also = "with other loads" if before is bolt else "in another load case too"
                raise ModelError(
                    f"loads[{case!r}]: the locked bolt {bolt.body!r}, section {bolt.section!r}, {also}; give it a load case of its own"
                )
    return [*found.values()]


def by_their_forces(
    loads: Mapping[str, Sequence[object]], bonded: Mapping[str, Array], L: Array
) -> tuple[dict[str, Array], Array, dict[str, tuple[float, float]]]:
    """Bonded reactions and compliance when locked bolts are shortened to their forces in the glued bodies, not by 1; forces and shortenings."""
    unit, bolts = np.ones(len(L)), {}
    for k, (name, (bolt, *_)) in enumerate(loads.items()):
        if isinstance(bolt, BoltPreload) and bolt.locked:
            unit[k] = -bolt.force / L[k, k]
            bolts[name] = bolt.force, float(unit[k])
    return (
        {name: part * r for part, (name, r) in zip(unit, bonded.items(), strict=True)},
        L * np.outer(unit, unit),
        bolts,
    )


def cut_bodies(
    bodies: Mapping[str, Body], bolts: Sequence[BoltPreload], kinematics: Kinematics
) -> tuple[dict[str, Body], list[Cut]]:
    """The bodies with the sections of bolts cut, the nodes of the far faces last of the corners, and the cuts."""
    found, cuts = dict(bodies), []
    for bolt in bolts:
        name, section = choice("bolt: body", bolt.body, found), bolt.section
        mesh, start = found[name].mesh, f"bolt {name!r}: section {section!r}"
        if section not in (mesh.boundaries or {}):
            raise ModelError(f"{start} is unknown; this mesh names {sorted(mesh.boundaries or {})}")
        near, far, axis, mesh = _cut(mesh, section, start)
        if kinematics == "axisymmetric" and abs(axis[0]) > _FLAT:
            raise ModelError(
                f"{start} is not normal to the axis x = 0; cut an axisymmetric bolt at one y"
            )
        found[name] = copy(found[name])  # one body still, though its parts share no facets
        object.__setattr__(found[name], "mesh", mesh)
        cuts.append(Cut(bolt, near, far, axis))
    return found, cuts


def _cut(mesh: Mesh, section: str, start: str) -> tuple[Integers, Integers, Array, Mesh]:
    """Nodes of the near and the far face of a section, its axis, and the mesh cut there: both faces are the boundary of that name."""
    facets, n = np.unique(mesh.boundaries[section]), mesh.nvertices
    if not len(facets) or np.any(mesh.f2t[1, facets] < 0):
        raise ModelError(
            f"{start} has no facets, or facets on the outline of the body; name the facets of a plane through its inside"
        )
    across, corners = facet_nodes(mesh, facets), np.unique(mesh.facets[:, facets])
    arms = mesh.p[:, across] - mesh.p[:, across].mean(axis=1, keepdims=True)
    axis = np.linalg.svd(arms, full_matrices=False)[0][:, -1]
    axis = axis * np.sign(axis[np.abs(axis).argmax()])
    if np.abs(axis @ arms).max() > _FLAT * np.ptp(arms, axis=1).max():
        raise ModelError(
            f"{start} is not flat, it leaves its plane by {np.abs(axis @ arms).max():g}; name facets in one plane through the shank"
        )
    links = mesh.f2t[:, np.setdiff1d(np.flatnonzero(mesh.f2t[1] >= 0), facets)]
    part = parts_of(links, mesh.t.shape[1])
    sides = mesh.f2t[:, facets]
    heights = axis @ mesh.p[:, mesh.t].mean(axis=1)
    behind, ahead = np.take_along_axis(sides, np.argsort(heights[sides], axis=0), axis=0)
    ahead, behind = np.unique(part[ahead]), np.unique(part[behind])
    if len(ahead) != 1 or len(behind) != 1 or ahead == behind:
        raise ModelError(
            f"{start} does not cut the body in two; name all facets of one plane through the shank, from side to side"
        )
    beyond, copies = part == ahead, np.arange(n)
    copies[corners] = n + np.arange(len(corners))
    whole = replace(
        mesh, t=np.where(beyond, copies[mesh.t], mesh.t), sort_t=False, _boundaries=None
    )
    whole = replace(whole, doflocs=points_from(mesh, np.arange(mesh.t.shape[1]), whole))
    near, far = (np.zeros(mesh.p.shape[1], dtype=np.intp) for _ in range(2))
    for numbers, side in ((near, ~beyond), (far, beyond)):
        numbers[mesh.dofs.element_dofs[:, side]] = whole.dofs.element_dofs[:, side]
    faces = {
        name: np.unique(whole.t2f[np.isin(mesh.t2f, named)])
        for name, named in mesh.boundaries.items()
    }
    return near[across], far[across], axis, whole.with_boundaries(faces)


def tied_across(rows: Integers, cuts: Sequence[Cut]) -> csr_matrix:
    """The matrix (size, size) that lets the far faces of cuts follow the near ones."""
    follows = np.arange(rows.size)
    for cut in cuts:
        follows[rows[cut.far]] = rows[cut.near]
    return csr_matrix((np.ones(rows.size), (np.arange(rows.size), follows)), shape=(rows.size,) * 2)


def released(K: csr_matrix, rows: Integers, cuts: Sequence[Cut]) -> tuple[csr_matrix, csr_matrix]:
    """Matrices R and D (size, size) of `u = R y + D F`, the displacements under loads F when the faces of cuts are tied across their axes.

    With the matrix C that lets far faces follow near ones, and the motions c of far faces against
    the axes, by the amounts x, `u = C y + c x`. Those of locked bolts are given, and not among
    them. No force but that of F acts along x: `c^T (K u - F) = 0`. So y has the stiffness `R^T K
    R`, none at the far faces, and the loads `R^T F`.
    """
    size, moves = K.shape[0], [csr_matrix((K.shape[0], 0))]
    for cut in (cut for cut in cuts if not cut.bolt.locked):
        far = rows[cut.far]
        moves.append(
            csr_matrix(
                (np.tile(-cut.axis, len(far)), (far.ravel(), np.zeros(far.size, int))),
                shape=(size, 1),
            )
        )
    C, c = tied_across(rows, cuts), csr_matrix(hstack(moves))
    flexible = csr_matrix(np.linalg.inv((c.T @ K @ c).toarray()))
    return csr_matrix(C - c @ (flexible @ (c.T @ K @ C))), csr_matrix(c @ flexible @ c.T)
