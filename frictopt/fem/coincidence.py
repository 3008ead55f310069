"""Decides which points coincide; coordinates have only the digits of their file.

This is the only place that decides how far apart two coincident points may be. A coordinate has an
error of half a unit in its last digit. In a file, all coordinates of one sign have either the same
number of digits or the same number of decimals. Each of these rules gives a unit, and the larger
unit counts. Signs are treated separately, because a minus may take the place of a digit.

Numbers with fewer than six digits are round, and are exact up to rounding. Coordinates of a mesh
that was turned have more than twelve digits. In both cases the error is the rounding, a tiny share
of the size of the mesh. There is one exception: if all coordinates are numbers of single precision
with more than twelve digits, as in binary files, their error is the rounding of these numbers.
"""

import numpy as np
from scipy.spatial import cKDTree

from ..base import COUNTS, SAME_POINT, Array, Booleans, Integers

# Numbers of the search for the digits of coordinates.

# Fewest digits that count as the digits of a file. Numbers with fewer digits are round.
_MIN_DIGITS = 6
# Most digits that count. With more digits, the share of the size of the mesh is the larger error.
_MAX_DIGITS = 12
# Relative error of a decimal number, also after a change of units by a power of ten.
_ROUNDING = 8 * float(np.finfo(float).eps)


def coordinate_errors(points: Array, corners: Integers | None = None) -> Array:
    """(nodes, d) error of each coordinate of a mesh (nodes, d).

    The digits are taken from the corner nodes; None: from all nodes. Midside nodes may have been
    computed by a code, so their digits mean nothing.
    """
    written = (points if corners is None else points[corners]).ravel()
    rounding = SAME_POINT / 2 * float(np.ptp(points, axis=0).max())
    # If the numbers of one sign are round, the decimals of all numbers give the unit.
    sizes = np.abs(written)
    unit = np.full(points.shape, _by_decimals(sizes[sizes > rounding]))
    for sign in (-1, 1):
        # A coordinate of 1e-17 is a zero with the rounding of the code that computed it.
        sizes = sign * written[sign * written > rounding]
        has_sign = sign * points >= 0
        by_decimals = _by_decimals(sizes)
        # In scientific notation, each number has its own exponent and the same number of digits.
        digits = _digits(sizes, _exponent(sizes))
        by_digits = _unit(_exponent(sign * points[has_sign]), digits)
        by_digits = np.where(points[has_sign] == 0, 0.0, by_digits)
        unit[has_sign] = np.maximum(unit[has_sign], np.maximum(by_decimals, by_digits))
    if _are_single(written[np.abs(written) > rounding]):
        unit = np.abs(np.spacing(points.astype(np.float32))).astype(float)
    # Two roundings of one number may differ by a whole unit. So each rounded number is allowed an
    # error of a little more than half a unit.
    return np.maximum((1 + COUNTS) / 2 * unit, rounding)


def _by_decimals(sizes: Array) -> float:
    """Unit of the last decimal, if all numbers have the same number of decimals; otherwise 0."""
    largest = np.full(sizes.shape, _exponent(sizes.max(initial=0.0)))
    return float(_unit(largest[:1], _digits(sizes, largest)).max(initial=0.0))


def _exponent(sizes: Array) -> Array:
    """Power of ten of the first digit of numbers >= 0."""
    return np.floor(np.log10(np.maximum(sizes, np.finfo(float).tiny)))


def _unit(exponent: Array, digits: int | None) -> Array:
    """Unit of the last digit of numbers, from the exponent of the first digit; 0 without digits."""
    if digits is None:
        return np.zeros(exponent.shape)
    return 10.0 ** (exponent - digits + 1)


def _digits(sizes: Array, exponent: Array) -> int | None:
    """The least number of digits, 6 to 12, with which all numbers can be written; else None.

    The first digit of each number is the digit at its exponent.
    """
    for digits in range(_MIN_DIGITS - 1, _MAX_DIGITS + 1):
        if _have_digits(sizes, exponent, digits):
            return digits if digits >= _MIN_DIGITS else None
    return None


def _have_digits(sizes: Array, exponent: Array, digits: int) -> bool:
    """Whether all numbers can be written with so many digits."""
    scaled = sizes * 10.0 ** (digits - 1 - exponent)
    return bool((np.abs(scaled - np.rint(scaled)) <= _ROUNDING * scaled).all())


def _are_single(numbers: Array) -> bool:
    """Whether numbers have single precision, and too many digits for decimal numbers."""
    with np.errstate(over="ignore"):
        single = numbers.astype(np.float32)
    if not (single == numbers).all():
        return False
    sizes = np.abs(numbers)
    return not _have_digits(sizes, _exponent(sizes), _MAX_DIGITS)


def error_along(directions: Array, errors: Array) -> Array:
    """(n,) error along unit vectors (n, d), from the errors of the coordinates (n, d)."""
    return np.asarray(np.sum(np.abs(directions) * errors, axis=1))


def measured(distance: Array, error: Array) -> Array:
    """(n,) distance if it exceeds its error (n,), else zero.

    The error counts slightly reduced, so that a distance of one whole unit of the last digit stays.
    """
    return np.where(distance > (1 - 2 * COUNTS) * error, distance, 0.0)


def coincide(difference: Array, errors: Array) -> Booleans:
    """(n,) whether two points coincide: their difference is within the sum of their errors."""
    return np.asarray((np.abs(difference) <= errors).all(axis=-1))


def coincident(points: Array, errors: Array) -> tuple[Integers, Integers]:
    """Pairs i, j of points (n, d) that coincide, i < j."""
    i, j = cKDTree(points).query_pairs(2 * float(errors.max()), p=np.inf, output_type="ndarray").T
    same = coincide(points[i] - points[j], errors[i] + errors[j])
    return i[same], j[same]
