"""Contact faces of a job whose nodes do not match, as arguments of `condense`."""

from __future__ import annotations

import warnings
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, identity
from scipy.spatial import cKDTree
from skfem import Mesh

from ..base import Array, Integers, choice, shown
from ..errors import ModelError, ModelWarning
from ..fem.coincidence import coordinate_errors
from ..fem.elasticity import Kinematics, facet_nodes
from ..fem.faces import facets_around, ordered_nodes
from ..fem.mortar import Face, FaceNames, Joint, joined
from ..fem.normals import Planes, normals_of_faces
from .element_types import SHAPES
from .labelled import LabelledMatrix


class JoinedFaces(LabelledMatrix):
    """Base of `MatrixJob`: faces that are joined by the mortar method, and their corner nodes."""

    def mortar(
        self,
        first: str | ArrayLike,
        second: str | ArrayLike,
        *,
        gap: Literal["measured"] | None = None,
    ) -> dict[str, Any]:
        """Arguments of `condense` that join two faces whose nodes need not match.

        They are `pairs`, `normals`, `projection`, `gap` and `width`, by the method that
        `ContactModel` uses; see `Contact` for the choice of body 1, and for a first face that
        reaches beyond the second one.

        Parameters
        ----------
        first, second
            The nodes of the faces of body 1 and of body 2, see `nodes`.
        gap
            None: the faces touch. "measured": their distance is the initial gap.

        Raises
        ------
        ModelError
            Faces that overlap, do not touch or do not face each other; see also `pairs`.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.readers.read_calculix("tests/data/flat")
        >>> face = job.mortar("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
        >>> loads = {"P": job.force("N_TOP", pressure=1.0)}
        >>> fo.condense(job.K, loads, **face, unknowns=job.unknowns, points=job.points)
        ContactSystem(nodes=26, x=-5 .. 5, loads=['P'], gap=False)
        """
        if gap is not None:
            choice("gap", gap, ("measured",))
        one = self._corners(first)
        two = self._corners(second)
        self._check_midsides(np.r_[one, two])
        deck = self._known
        of_plane: Kinematics = "axisymmetric" if deck.is_axisymmetric else "plane_strain"
        return _mortar_arguments(
            self.mesh,
            self._between(one, deck.numbers),
            self._between(two, deck.numbers),
            coordinate_errors(self.points, deck.corners),
            of_plane if self._directions == 2 else "space",
            f"faces {shown(first)} and {shown(second)}",
            measured=gap == "measured",
        )

    def _corners(self, where: str | ArrayLike) -> Integers:
        return np.setdiff1d(self.nodes(where), self._known.midsides, assume_unique=True)

    def _check_midsides(self, corners: Integers) -> None:
        """Check that midside nodes of contact faces between these corners follow the corners."""
        deck = self._known
        for kind, _, nodes in deck.unclear:
            common = np.intersect1d(corners, nodes)
            if len(common):
                family = "C3D" if self._directions == 3 else "CPE"
                known = ", ".join(name for name in SHAPES if name.startswith(family))
                raise ModelError(
                    f"faces: node {deck.numbers[common[0]]} is one of an element {kind}, whose "
                    f"midside nodes are unknown; mesh this body with {known} "
                    "in the code that writes the matrix"
                )
        if not len(deck.midsides):
            return
        mesh, origin = self._whole
        on_faces = origin[facet_nodes(mesh, self._between(corners))].indices
        rows = np.intersect1d(on_faces, deck.midsides)
        unknowns = self.unknowns[rows]
        not_in_matrix = rows[(unknowns < -1).any(axis=1)]
        unexplained = np.setdiff1d(not_in_matrix, deck.constraints.ends[:, 0] // 6)
        if len(unexplained):
            raise ModelError(
                f"faces: node {deck.numbers[unexplained[0]]}, a midside node of a contact face, "
                "has no row in the matrix; retain such nodes"
            )
        free = rows[(unknowns >= 0).any(axis=1)]
        if len(free):
            raise ModelError(
                f"faces: node {deck.numbers[free[0]]}, a midside node of a contact face, does not "
                "follow its corners; use job.with_linear_faces()"
            )


def _mortar_arguments(
    mesh: Mesh,
    facets_1: Integers,
    facets_2: Integers,
    errors: Array,
    kinematics: Kinematics,
    argument: str,
    *,
    measured: bool,
) -> dict[str, Any]:
    """Arguments of `condense` that join some facets of an outline of a mesh to other facets.

    The mesh has the facets of both bodies. The coordinates have errors (nodes, d). If
    `measured` is False, the faces touch. Error messages call the faces `argument`.
    """
    points = mesh.p.T
    corners_1 = facets_around(mesh, facets_1)
    corners_2 = facets_around(mesh, facets_2)
    nodes = np.unique(corners_1)
    if kinematics != "space":
        nodes = ordered_nodes(mesh, facets_1, f"{argument}: the first one")
    joint = joined(
        Face(corners_1, points, errors),
        Face(corners_2, points, errors),
        nodes,
        normals_of_faces([corners_1], points, errors, Planes(mesh.dim()))[0][nodes],
        None if measured else (lambda places: np.zeros(len(places))),
        FaceNames(argument, "the first face", "the second face"),
        kinematics,
    )
    if joint.beyond > 0:
        size = "area" if kinematics == "space" else "length"
        warnings.warn(
            f"{argument}: of the first face, the {size} {joint.beyond:.3g} "
            f"({joint.share_beyond:.1%}) has no opposite part of the second face and is free",
            ModelWarning,
            stacklevel=4,  # the line that calls `MatrixJob.mortar`
        )
    return _with_heirs(joint, points)


def _with_heirs(joint: Joint, points: Array) -> dict[str, Any]:
    """The arguments, in which the nearest pair represents each node beyond the edge of body 2.

    It gets the mean of the relative motions `u_k - sum_j P_kj u_j`, weighted by their widths.
    """
    kept = np.flatnonzero(joint.inside)
    heir = cKDTree(points[joint.nodes[kept]]).query(points[joint.nodes])[1]
    widths = np.bincount(heir, joint.widths)
    entries = joint.widths / widths[heir], (heir, np.arange(len(heir)))
    means = csr_matrix(entries, shape=(len(kept), len(heir)))

    own = identity(joint.projection.shape[1], format="csr")
    relative = means @ (own[joint.nodes] - joint.projection)
    nodes = joint.nodes[kept]
    projection = csr_matrix(own[nodes] - relative)
    projection.eliminate_zeros()
    return {
        "pairs": nodes,
        "normals": joint.normals[kept],
        "projection": projection,
        "gap": means @ joint.gap,
        "width": widths,
    }
