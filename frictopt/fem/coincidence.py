"""Which points coincide: coordinates have the digits of their file.

This is the only place that says how far apart two points may be that are one. A coordinate may be
off by half a unit in the last of its digits. All coordinates of a mesh that have the same sign have
as many digits, or as many decimals, as they can be written with, whichever leaves the larger unit:
a minus may take the place of a digit in a file. Fewer than six digits are those of round numbers,
which are exact. These, and coordinates of more than twelve digits, such as those of a mesh that was
turned, may be off by a share of the size of the mesh.
"""

import numpy as np
from scipy.spatial import cKDTree
from skfem import Mesh

from ..base import COUNTS, SAME_POINT, Array, Booleans, Integers

_FEWEST, _MOST = (
    6,
    12,
)  # digits; with more, the share of the size of the mesh is larger than the last digit
_SAMPLE = 100  # coordinates that tell at once that a mesh has many digits
_WRITTEN = (
    8 * np.finfo(float).eps
)  # relative error of a decimal number, also after a change of units by a power of ten


def coordinate_errors(points: Array, corners: Integers | None = None) -> Array:
    """(nodes, d) error of each coordinate of a mesh (nodes, d).

    The corners are the nodes that were written with these digits; None: all. Nodes amid edges may
    have been computed.
    """
    written = (points if corners is None else points[corners]).ravel()
    unit = np.zeros(points.shape)
    for sign in (-1, 1):
        sizes, own = sign * written[sign * written > 0], sign * points >= 0
        largest = np.full(sizes.shape, _place(sizes.max(initial=0.0)))
        by_decimals = _unit(largest[:1], _digits(sizes, largest)).max(initial=0.0)
        by_digits = np.where(
            points[own] == 0, 0.0, _unit(_place(sign * points[own]), _digits(sizes, _place(sizes)))
        )
        unit[own] = np.maximum(unit[own], np.maximum(by_decimals, by_digits))
    # Two roundings of one number may differ by a whole unit: a little more than half of it is
    # allowed to each.
    rounding = SAME_POINT / 2 * float(np.ptp(points, axis=0).max())
    return np.asarray(np.maximum((1 + COUNTS) / 2 * unit, rounding))


def _place(sizes: Array) -> Array:
    """Power of ten of the first digit of numbers >= 0."""
    return np.asarray(np.floor(np.log10(np.maximum(sizes, np.finfo(float).tiny))))


def _unit(first: Array, digits: int | None) -> Array:
    """Unit in the last of some digits, of which the first has a power of ten; zero without a number of digits."""
    return np.zeros(first.shape) if digits is None else 10.0 ** (first - digits + 1)


def _digits(sizes: Array, first: Array) -> int | None:
    """The fewest digits with which all numbers can be written; None if they are fewer than six, or more than twelve.

    The first digit of each number is the one of a power of ten.
    """
    for digits in range(_FEWEST - 1, _MOST + 1):
        for some in (slice(_SAMPLE), slice(None)):
            scaled = sizes[some] * 10.0 ** (digits - 1 - first[some])
            if not (np.abs(scaled - np.rint(scaled)) <= _WRITTEN * scaled).all():
                break
        else:
            return digits if digits >= _FEWEST else None
    return None


def mesh_errors(mesh: Mesh) -> Array:
    """(nodes, d) error of each coordinate of a mesh."""
    return coordinate_errors(mesh.p.T, np.unique(mesh.t))


def along(directions: Array, errors: Array) -> Array:
    """(n,) error along directions (n, d), of length one, from those of the coordinates (n, d)."""
    return np.asarray(np.sum(np.abs(directions) * errors, axis=1))


def measured(distance: Array, error: Array) -> Array:
    """(n,) the distance, where it exceeds its error (n,), else zero: a whole unit of the last digit is a distance."""
    return np.where(distance > (1 - 2 * COUNTS) * error, distance, 0.0)


def one_point(apart: Array, errors: Array) -> Booleans:
    """(n,) whether points coincide that are `apart` (n, d), with the sum of the errors of both (n, d)."""
    return np.asarray((np.abs(apart) <= errors).all(axis=-1))


def coincident(points: Array, errors: Array) -> tuple[Integers, Integers]:
    """Pairs i, j of points (n, d) that coincide, i < j."""
    i, j = cKDTree(points).query_pairs(2 * float(errors.max()), p=np.inf, output_type="ndarray").T
    same = one_point(points[i] - points[j], errors[i] + errors[j])
    return i[same], j[same]
