"""Tangents and normals of the nodes."""

import numpy as np

from ..base import Array
from ..errors import ModelError

_ALONG = 0.9  # share of x in a normal from which on the first tangent is taken from y


def frames_of(normals: Array, ways: Array | None = None) -> Array:
    """(N, d, d) tangents and unit normals, from (N, d) normals of any length.

    In the plane the tangent is the normal turned by -90 degrees. In space the first tangent is x
    less its part along the normal (y where the normal is nearly x), or a way (N, d) that is given
    and not zero less that part. The second one is normal times first tangent: normal z has the
    tangents x and y.
    """
    lengths = np.linalg.norm(normals, axis=1)
    if not lengths.min() > 0:
        raise ModelError(
            f"normals: zero at pair {int(lengths.argmin())}; give the direction from body 2 into "
            "body 1"
        )
    n = normals / lengths[:, None]
    if n.shape[1] == 2:
        return np.stack([np.column_stack([n[:, 1], -n[:, 0]]), n], axis=1)
    axis = np.where(np.abs(n[:, :1]) < _ALONG, np.eye(3)[0], np.eye(3)[1])
    if ways is not None:
        axis = np.where(np.any(ways, axis=1, keepdims=True), ways, axis)
    first = axis - np.sum(axis * n, axis=1)[:, None] * n
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(n, first), n], axis=1)
