"""Cones that are products of two factors get factors of one size.

A cone `|s[1:]| <= s[0]` is the product `low * high >= |s[2:]|^2` of the factors `low = s[0] - s[1]`
and `high = s[0] + s[1]`, which are >= 0. cvxpy writes `x^2 <= t` as `|(1 - t, 2 x)| <= 1 + t`, with
the factors 2 t and 2. If x is a micrometre, given in metres, then t is 1e-12, and its digits are
lost beside the 1. So low is multiplied by a number, here 1e6, and high is divided by it: the cone
is the same.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array

from ..base import Array, Integers


class Balance:
    """The change of the slacks `right - matrix @ z` to slacks whose cones have factors of one size.

    The cones are the last rows, and begin at `heads`. Only cones whose factors have no common terms
    are changed. `unit` are the units of the unknowns; a unit of 0 is derived from the rows.
    """

    def __init__(self, matrix: csr_array, right: Array, heads: Integers, unit: Array) -> None:
        differences = abs(abs(matrix[heads]) - abs(matrix[heads + 1])).sum(axis=1)
        differences += np.abs(np.abs(right[heads]) - np.abs(right[heads + 1]))
        low = heads[differences == 0]
        high = low + 1
        self._changes = len(low) > 0
        if not self._changes:
            return
        count = len(right)
        to_factors = eye_array(count, format="lil")
        to_factors[low, high] = -1.0
        to_factors[high, low] = 1.0
        self._to_factors = csr_array(to_factors)
        sizes = csr_array(abs(self._to_factors @ matrix))
        constant = np.abs(self._to_factors @ right)

        def allowance(unit: Array) -> Array:
            """The sizes of terms that the rows allow.

            A factor may be as large as its cone needs: the squared rest of the cone, divided by the
            other factor.
            """
            terms = sizes @ unit + constant
            rest = terms.copy()
            rest[np.r_[heads, heads + 1]] = 0.0
            rest = np.add.reduceat(rest, heads)[differences == 0]
            terms[low], terms[high] = _over(rest**2, terms[high]), _over(rest**2, terms[low])
            return np.asarray(terms)

        terms = sizes @ derived_units(unit, sizes, allowance) + constant
        known = (terms[low] > 0) & (terms[high] > 0)
        ratio = np.where(known, terms[high], 1.0) / np.where(known, terms[low], 1.0)
        number = 2.0 ** np.round(np.log2(ratio) / 2)  # a power of two changes no digit
        self._scale = np.ones(count)
        self._scale[low] = number / 2
        self._scale[high] = 1 / number / 2

    def __call__(self, values: Any) -> Any:
        """Rows or right sides after the change; for multipliers, the change back.

        Both are the same operation, because the matrix of the change is symmetric.
        """
        if not self._changes:
            return values
        return self._to_factors.T @ (diags_array(self._scale) @ (self._to_factors @ values))


def derived_units(unit: Array, sizes: csr_array, allowance: Callable[[Array], Array]) -> Array:
    """Units of the unknowns; a missing unit is the largest that the rows allow, or 1.

    `sizes` are the absolute values of the entries of the rows. `allowance(unit)` returns the size
    that each row allows for its terms; some of these units may still be 0.
    """
    entries = sizes.tocoo()
    while (unit == 0).any():
        unknown = unit == 0
        most = allowance(unit)
        bounding = unknown[entries.col] & (most[entries.row] > 0) & (entries.data > 0)
        if not bounding.any():
            break
        allowed = np.full(len(unit), np.inf)
        np.minimum.at(
            allowed,
            entries.col[bounding],
            most[entries.row[bounding]] / entries.data[bounding],
        )
        unit = np.where(unknown & np.isfinite(allowed), allowed, unit)
    return np.where(unit == 0, 1.0, unit)


def _over(a: Array, b: Array) -> Array:
    """`a / b`, and 0 where b is 0."""
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)
