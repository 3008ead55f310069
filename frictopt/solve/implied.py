"""Rows that an abs or a norm beside them implies, as `p >= 0` where `abs(q) <= f p` is a row, too."""

import numpy as np
from scipy.sparse import csr_array

from ..base import ROUNDING, Array, Booleans, Integers
from .compiled import Compiled

_DIGITS = 12  # in which rows are compared that differ in their scale
_CLEAR = 0.01  # if f is less, `abs(q) <= f p` keeps p >= 0 to fewer digits, and the row stays


def implied(program: Compiled, unknowns: Integers, names: Integers, pivots: Array) -> Integers:
    """Inequalities `a z <= b` that follow from rows `t + c a z <= c b` of the unknowns t of norms.

    `names` are these rows, one for each of the `unknowns`, in which they have the factors `pivots`.
    """
    sure = _not_negative(program, unknowns)
    unknowns, names, pivots = unknowns[sure], names[sure], pivots[sure]
    bounds = csr_array(program.matrix[names])
    own = bounds.indices == np.repeat(unknowns, np.diff(bounds.indptr))
    bounds.data = np.where(own, 0.0, bounds.data)
    key, right, sizes = _keys(bounds, program.right[names])
    clear = sizes >= _CLEAR * pivots
    others = np.setdiff1d(np.arange(program.zero, program.zero + program.nonneg), names)
    other_key, other_right, other_sizes = _keys(program.matrix[others], program.right[others])
    group = np.unique(np.r_[key[clear], other_key], return_inverse=True)[1]
    least, count = np.full(len(group), np.inf), int(clear.sum())
    np.minimum.at(least, group[:count], right[clear])
    return others[(other_right >= least[group[count:]]) & (other_sizes > 0)]


def _not_negative(program: Compiled, unknowns: Integers) -> Booleans:
    """Which unknowns t the rows keep above zero that have `-t` in their heads: these rows add up to a multiple of `-t <= 0`."""
    soc, linear = np.array(program.soc, dtype=int), program.zero + program.nonneg
    heads = np.r_[program.zero : linear, linear + np.cumsum(soc) - soc]
    rows = program.matrix[heads]
    weights = csr_array(rows[:, unknowns].T)
    weights.data = np.minimum(weights.data, 0.0)
    total = csr_array(weights @ rows)
    total.data[np.abs(total.data) <= ROUNDING * np.abs(total.data).max(initial=0.0)] = 0.0
    total.eliminate_zeros()
    alone = np.diff(total.indptr) == 1
    alone[alone] = total.indices[total.indptr[:-1][alone]] == unknowns[alone]
    return np.asarray(alone & (weights @ program.right[heads] == 0))


def _keys(rows: csr_array, right: Array) -> tuple[Array, Array, Array]:
    """What rows are to two random vectors, as complex numbers, and their right sides, over their largest entries; and these."""
    entries = np.r_[np.abs(rows.data), 0.0]
    sizes = (
        np.maximum.reduceat(entries, rows.indptr[:-1]) * (np.diff(rows.indptr) > 0)
        if rows.shape[0]
        else entries[:0]
    )
    scale = np.where(sizes > 0, sizes, 1.0)
    ways = np.random.default_rng(0).normal(size=(2, rows.shape[1]))
    marks = rows @ (ways[0] + 1j * ways[1]) / scale
    return np.round(marks, _DIGITS), right / scale, sizes
