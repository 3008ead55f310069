"""Tangents and normals of the nodes."""

import numpy as np

from ..base import Array
from ..errors import ModelError


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
