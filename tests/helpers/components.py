"""Vectors of a contact as users order them: tangential values, in space by axis, then normal ones."""

import numpy as np


def joined(q, p):
    """(..., M) values from the tangential (..., N) or (..., N, 2) and the normal (..., N)."""
    tangential = [q] if q.ndim == p.ndim else [q[..., 0], q[..., 1]]
    return np.concatenate([*tangential, p], axis=-1)


def parted(r, axes):
    """Tangential and normal values of (..., M) values; `axes` is 2 in the plane, 3 in space."""
    *tangential, normal = np.split(r, axes, axis=-1)
    return (tangential[0] if axes == 2 else np.stack(tangential, axis=-1)), normal
