"""Directions of the pairs of nodes, their sides, and their order and widths along contacts in the plane."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix

from ..contact.checks import Array, place
from ..contact.course import runs
from ..contact.tolerances import CONDENSATION
from ..errors import ModelError
from .interface import Interface
from .ordering import Integers

_ASIDE = 1e3 * CONDENSATION  # share of its distance by which the neighbourhood of a node may lie on the wrong side: rounding of the coordinates
_LIES = 0.5  # least share of a normal in a plane of symmetry: it may lean by half the angle of an edge beside it
_ALONG = 0.9  # share of x in a normal from which on the first tangent is taken from y


def frames_of(normals: Array) -> Array:
    """(N, d, d) tangents and unit normals, from (N, d) normals of any length.

    In the plane the tangent is the normal turned by -90 degrees. In space the first tangent is x less its part along the normal (y where the normal
    is nearly x), and the second one is normal times first tangent: normal z has the tangents x and y.
    """
    lengths = np.linalg.norm(normals, axis=1)
    if not lengths.min() > 0:
        raise ModelError(f"normals: zero at pair {int(lengths.argmin())}; give the direction from body 2 into body 1")
    n = normals / lengths[:, None]
    if n.shape[1] == 2:
        return np.stack([np.column_stack([n[:, 1], -n[:, 0]]), n], axis=1)
    axis = np.where(np.abs(n[:, :1]) < _ALONG, np.eye(3)[0], np.eye(3)[1])
    first = axis - np.sum(axis * n, axis=1)[:, None] * n
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(n, first), n], axis=1)


def guided(opening: csr_matrix, unknowns: Integers, normals: Array) -> tuple[Array, Integers]:
    """(N, d) normals of the pairs `sum_j M_ij u_j`, and the nodes that supports keep from following others.

    On a plane of symmetry, and on the axis of axisymmetric bodies, supports hold all nodes of a pair alike: it cannot slip across the plane. Its
    normal, of facets on one side alone, lies in the plane, and its nodes may follow others as they do elsewhere.
    """
    held, sizes = unknowns < 0, np.diff(opening.indptr)[:, None]
    counts = (opening != 0) @ held.astype(np.intp)
    within = np.where(counts > 0, 0.0, normals)
    lies = np.linalg.norm(within, axis=1) > _LIES * np.linalg.norm(normals, axis=1)
    alike = ((counts == 0) | (counts == sizes)).all(axis=1) & lies
    others = np.isin(np.arange(len(unknowns)), opening[~alike].indices)
    return np.where(alike[:, None], within, normals), np.flatnonzero(held.any(axis=1) & others)


def check_course(points: Array, frames: Array, names: Sequence[str]) -> None:
    """Check that the pairs of each contact follow each other along their tangents, and that normals of neighbours do not flip.

    Raises
    ------
    ModelError
        They do not.
    """
    for run in runs(names):
        t, n, p = frames[run, 0], frames[run, 1], points[run]
        step = np.diff(p, axis=0)
        flips = np.sum(n[1:] * n[:-1], axis=1) <= 0
        if flips.any():
            i = run.start + int(flips.argmax())
            raise ModelError(
                f"normals: they turn by 90 degrees or more from pair {i} at {place(points[i])} to pair {i + 1} at {place(points[i + 1])}; "
                "let all point from body 2 into body 1, and make a contact of its own of each side of a sharp corner"
            )
        back = np.minimum(np.sum(t[1:] * step, axis=1), np.sum(t[:-1] * step, axis=1)) <= 0
        if back.any():
            i = run.start + int(back.argmax())
            hint = "reverse the pairs (or the normals, and exchange the bodies)" if back.all() else "order the pairs along the contact"
            raise ModelError(
                f"pairs: from pair {i} at {place(points[i])} to pair {i + 1} at {place(points[i + 1])} they go against the tangent, "
                f"which is the normal turned by -90 degrees; {hint}"
            )


def check_sides(graph: csr_matrix, interface: Interface, points: Array, names: Sequence[str]) -> None:
    """Check that the normals point into body 1: the nodes next to the contact lie ahead in body 1, behind in body 2.

    At a re-entrant corner one of the two bodies may seem to lie on the wrong side, but not both.

    Raises
    ------
    ModelError
        They point the other way.
    """
    pattern = (graph > 0).astype(np.float64)
    neighbours = np.asarray(pattern.sum(axis=1))
    inward = np.where(neighbours > 0, (pattern @ points) / np.maximum(neighbours, 1) - points, 0.0)
    normals = interface.frames[:, -1]
    one = np.sum(normals * inward[interface.nodes], axis=1)
    ahead = np.sum(normals * (interface.opening @ inward), axis=1)
    for run in runs(names):
        if ahead[run].sum() < 0:
            i = run.start
            raise ModelError(
                f"normals: those of contact {names[i]!r} point from body 1 into body 2, the first at {place(points[interface.nodes[i]])}; turn them "
                "round, or exchange the columns of the pairs, and in the plane reverse the order of the pairs"
            )
    near = _ASIDE * np.linalg.norm(interface.opening @ inward, axis=1)
    around = pattern[interface.nodes].tocoo()
    heights = np.abs(np.sum(normals[around.row] * (points[around.col] - points[interface.nodes[around.row]]), axis=1))
    seen = np.bincount(around.row, heights, minlength=len(near)) > near  # springs along the face alone tell nothing
    wrong = seen & (ahead <= near) & (np.maximum(one, ahead - one) <= near) & (near > 0)
    if wrong.any():
        i = int(wrong.argmax())
        raise ModelError(
            f"normals: that of pair {i} at {place(points[interface.nodes[i]])} does not point from body 2 into body 1, as their elements lie there; "
            "turn it, or exchange the two nodes of the pair"
        )


def half_widths(points: Array, names: Sequence[str]) -> Array | None:
    """(N,) half the distances to the neighbours on the same contact; None if a contact has a single pair."""
    width = np.zeros(len(points))
    for run in runs(names):
        half = np.hypot(*np.diff(points[run], axis=0).T) / 2
        width[run] += np.r_[half, 0.0] + np.r_[0.0, half]
    return width if width.min() > 0 else None
