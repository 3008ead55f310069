"""Meshes of elements of several shapes, as quadrilaterals and hexahedra whose corners coincide.

If two neighbouring corners of a quadrilateral coincide, its bilinear functions are the linear
functions of a triangle. So a hexahedron with corners that coincide has the functions of a wedge, a
pyramid or a tetrahedron. Elements of all shapes then share the functions on their common facets,
and scikit-fem assembles them together. A facet that has lost its area belongs to no outline.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem
from skfem import Mesh

from ..base import Integers

# The corner of each shape at each corner of a hexahedron or quadrilateral, in the order of decks.
COLLAPSED = {
    "triangle": (0, 1, 2, 2),
    "quad": (0, 1, 2, 3),
    "tetra": (0, 1, 2, 2, 3, 3, 3, 3),
    "pyramid": (0, 1, 2, 3, 4, 4, 4, 4),
    "wedge": (0, 1, 2, 2, 3, 4, 5, 5),
    "hexahedron": (0, 1, 2, 3, 4, 5, 6, 7),
}
# Corners of scikit-fem's hexahedron, by their numbers in decks.
HEXAHEDRON = np.array([0, 4, 3, 1, 7, 5, 2, 6])


class _WithCollapsed:
    """The facets of a mesh with coincident corners."""

    t: Integers
    elem: Any

    def _init_facets(self) -> None:
        """Number the facets; facets without area come last, each belonging to only one element."""
        local = np.array(self.elem.refdom.facets)
        corners = local.shape[1]
        nodes = self.t[local].transpose(1, 0, 2).reshape(corners, -1)
        rows, distinct = canonical(nodes)
        has_area = distinct > corners // 2
        _, first, which = np.unique(
            rows[:, has_area], axis=1, return_index=True, return_inverse=True
        )
        number = np.zeros(len(has_area), dtype=np.int64)
        number[has_area] = which.ravel()
        number[~has_area] = len(first) + np.arange(np.count_nonzero(~has_area))
        with_area = nodes[:, has_area][:, first]
        self._facets = np.ascontiguousarray(np.hstack([with_area, nodes[:, ~has_area]]))
        self._t2f = number.reshape(len(local), -1)
        self._with_area = len(first)

    @property
    def f2t(self) -> Integers:
        """(2, facets) elements on both sides of each facet; -1 for the outside of the mesh.

        A facet without area has its element on both sides, so that it is no facet of the outline.
        """
        if not hasattr(self, "_f2t"):
            numbers: Any = self.t2f  # type: ignore[attr-defined]
            sides = Mesh.build_inverse(self.t, numbers)
            sides[1, self._with_area :] = sides[0, self._with_area :]
            self._f2t = sides
        return np.asarray(self._f2t)


@dataclass(repr=False)
class MeshMixedPlane(_WithCollapsed, skfem.MeshQuad1):  # type: ignore[misc]
    """Triangles and quadrilaterals: in a triangle the third corner is repeated."""


@dataclass(repr=False)
class MeshMixedPlane2(_WithCollapsed, skfem.MeshQuad2):  # type: ignore[misc]
    """Quadratic triangles and quadrilaterals."""


@dataclass(repr=False)
class MeshMixed(_WithCollapsed, skfem.MeshHex1):  # type: ignore[misc]
    """Tetrahedra, pyramids, wedges and hexahedra: the first three have repeated corners."""


@dataclass(repr=False)
class MeshMixed2(_WithCollapsed, skfem.MeshHex2):  # type: ignore[misc]
    """Quadratic tetrahedra, wedges and hexahedra."""


MIXED = (MeshMixedPlane, MeshMixed)
MIXED_QUADRATIC = (MeshMixedPlane2, MeshMixed2)


def canonical(nodes: Integers) -> tuple[Integers, Integers]:
    """Nodes (corners, m) of facets in a standard form, and the number of distinct nodes of each.

    The nodes are sorted, and a repeated node is the last one. Two facets have the same nodes if and
    only if their columns are equal.
    """
    rows = np.sort(nodes, axis=0)
    repeats = rows[1:] == rows[:-1]
    rows[:-1][repeats] = np.broadcast_to(rows[-1], repeats.shape)[repeats]
    return np.sort(rows, axis=0), len(rows) - np.count_nonzero(repeats, axis=0)


def places_among(rows: Integers, known: Integers) -> Integers:
    """(m,) index of each row of numbers (m, k) among known rows (n, k); -1 if it is not there.

    Neither the order of the numbers in a row matters, nor which number is repeated.
    """
    count = len(known)
    sorted_rows = canonical(np.concatenate([known, rows]).T)[0].T
    number = np.unique(sorted_rows, axis=0, return_inverse=True)[1].ravel()
    index = np.full(len(number), -1)
    index[number[:count]] = np.arange(count)
    return index[number[count:]]


def with_wedges(mesh: Mesh) -> Mesh:
    """The mesh; a mesh of scikit-fem's wedges becomes a `MeshMixed` with the same nodes.

    This is needed because scikit-fem 12.0 integrates over only half of its reference wedge.
    """
    if not isinstance(mesh, skfem.MeshWedge1):
        return mesh
    t = mesh.t[list(COLLAPSED["wedge"])][HEXAHEDRON]
    wedges = MeshMixed(mesh.p, t)
    place = places_among(np.array(mesh.facets.T), np.array(wedges.facets.T))
    named = {name: place[np.asarray(facets)] for name, facets in (mesh.boundaries or {}).items()}
    return wedges.with_boundaries(named).with_subdomains(mesh.subdomains or {})


def polygons(facets: Integers) -> list[Integers]:
    """Facets (m, corners) without repeated corners: triangles and quadrilaterals are separated.

    The corners of a facet stay in their cyclic order.
    """
    corners = facets.shape[1]
    differs = facets != np.roll(facets, 1, axis=1)
    if corners < 4 or differs.all():
        return [facets]
    is_triangle = ~differs.all(axis=1)
    triangles = facets[is_triangle][differs[is_triangle]].reshape(-1, corners - 1)
    return [part for part in (triangles, facets[~is_triangle]) if len(part)]
