"""Tangents and normals of the nodes."""

import numpy as np

from ..base import Array
from ..errors import ModelError


def frames_of(normals: Array, directions: Array | None = None) -> Array:
    """(N, d, d) tangents and unit normals, from (N, d) normals of any length.

    In the plane the tangent is the normal turned by -90 degrees. In space the first tangent is a
    direction less its part along the normal: x, or y if the normal is nearly x, or the row of
    `directions` (N, d) if it is given and not zero. The second tangent is normal times first
    tangent, so the normal z has the tangents x and y.
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

    # Far from parallel to the normal the difference below keeps its digits.
    nearly_x = np.abs(n[:, :1]) >= 0.9
    axis = np.where(nearly_x, np.eye(3)[1], np.eye(3)[0])
    if directions is not None:
        axis = np.where(np.any(directions, axis=1, keepdims=True), directions, axis)
    first = axis - np.sum(axis * n, axis=1)[:, None] * n
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(n, first), n], axis=1)
