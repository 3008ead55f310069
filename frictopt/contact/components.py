"""The order of vectors of all nodes and load cases, places along contacts, rigid displacements."""

from collections.abc import Iterable, Sequence

import numpy as np

from ..base import SAME_POINT, Array, Loads, runs
from ..base.checks import Names
from ..errors import ModelError


def joined(q: Array, p: Array) -> Array:
    """(..., M) values ordered by component, the inverse of `parted`.

    q are tangential values, (..., N) in the plane and (..., N, 2) in space; p are normal values
    (..., N).
    """
    if q.ndim == p.ndim:
        return np.concatenate([q, p], axis=-1)
    return np.concatenate([q[..., 0], q[..., 1], p], axis=-1)


def parted(r: Array, axes: int) -> tuple[Array, Array]:
    """Tangential and normal parts of (..., M) values ordered by component.

    `axes` is 2 in the plane, 3 in space. The tangential part is (..., N) or (..., N, 2), the normal
    part (..., N).
    """
    n = r.shape[-1] // axes
    tangential = r[..., :-n]
    normal = r[..., -n:]
    if axes == 3:
        tangential = np.stack([tangential[..., :n], tangential[..., n:]], axis=-1)
    return tangential, normal


def amplitudes_of(loads: Sequence[Loads], cases: Iterable[str] | None = None) -> Array:
    """(K, cases) amplitudes of some load cases in K loads; None: of all that the loads have."""
    if cases is None:
        cases = sorted({case for load in loads for case in load})
    return np.array([[load.get(case, 0.0) for case in cases] for load in loads])


def arc_length(points: Array, frames: Array, contact: Names | None) -> Array:
    """(N,) rising coordinates of the nodes along contacts in the plane, length.

    If all nodes share a tangent up to rounding, and rise along it, the values are the coordinates
    along this tangent. Else they are arc lengths from the first node. The contacts follow each
    other, one mean spacing apart. ModelError if the coordinates do not rise.
    """
    contacts = [slice(None)] if contact is None else runs(contact)
    tangent = frames[0, 0]
    x = points @ tangent
    turns = bool((np.abs(frames - frames[0]) > SAME_POINT).any())
    falls = bool((np.diff(x) <= 0).any())
    if turns or (len(contacts) > 1 and falls):
        end = 0.0
        for number, nodes in enumerate(contacts):
            places = points[nodes]
            spacings = np.hypot(*np.diff(places, axis=0).T)
            if number > 0:
                start = end + (float(spacings.mean()) if len(spacings) else 1.0)
            else:
                start = float(tangent @ places[0])
                # A first node within rounding of the origin is at the origin.
                if abs(start) <= SAME_POINT * spacings.sum():
                    start = 0.0
            x[nodes] = start + np.r_[0.0, np.cumsum(spacings)]
            end = float(x[nodes][-1])

    falling = np.diff(x) <= 0
    if falling.any():
        i = int(falling.argmax())
        raise ModelError(
            f"x: x[{i + 1}] = {x[i + 1]:g} does not exceed x[{i}] = {x[i]:g}; order the nodes "
            "along the interface"
        )
    return np.asarray(x)


# Tangents and normals of the nodes.


def frames_of(normals: Array) -> Array:
    """(N, d, d) tangents and unit normals, from (N, d) normals of any length.

    In the plane the tangent is the normal turned by -90 degrees. In space the first tangent is x,
    or y if the normal is nearly x, minus its part along the normal. The second tangent is the cross
    product of normal and first tangent, so the normal z has the tangents x and y.
    """
    lengths = np.linalg.norm(normals, axis=1)
    if not lengths.min() > 0:
        raise ModelError(
            f"normals: zero at pair {int(lengths.argmin())}; give the direction from body 2 into "
            "body 1"
        )
    n = normals / lengths[:, None]
    if n.shape[1] == 2:
        tangents = np.column_stack([n[:, 1], -n[:, 0]])
        return np.stack([tangents, n], axis=1)

    # The direction must not be nearly parallel to the normal, or the difference below loses digits.
    nearly_x = np.abs(n[:, :1]) >= 0.9
    axis = np.where(nearly_x, np.eye(3)[1], np.eye(3)[0])
    first = axis - np.sum(axis * n, axis=1)[:, None] * n
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(n, first), n], axis=1)


def rigid_displacements(arms: Array) -> Array:
    """(n, d, m) displacements of the ends of arms (n, d) from a point, in its m unit motions.

    The point first moves along each axis. Then it turns: about z in the plane, about x, y and z in
    space.
    """
    d = arms.shape[1]
    arms_in_space = np.pad(arms, ((0, 0), (0, 3 - d)))
    columns = [np.broadcast_to(direction, arms.shape) for direction in np.eye(d)]
    columns += [np.cross(axis, arms_in_space)[:, :d] for axis in np.eye(3)[2 * (d == 2) :]]
    return np.stack(columns, axis=-1)


def null_space(matrix: Array, size: float) -> Array:
    """(k, m) orthonormal vectors that a matrix of k columns maps almost to zero.

    The matrix times each of the m vectors has the length `size` at most. If the columns are the
    lifts of rigid motions, the m vectors are the motions that open no node.
    """
    _, sizes, combinations = np.linalg.svd(np.linalg.qr(matrix, mode="r"))
    return np.asarray(combinations[np.count_nonzero(sizes > size) :].T)
