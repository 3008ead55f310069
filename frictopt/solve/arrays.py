"""A program as solvers take it: a cost, sparse rows and one dense block, in cones; and what its rows say of each other."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array

from ..contact import ROUNDING, Array, Integers

_DEPENDENT = ROUNDING  # part of an equation, over its size, that others leave of it, below which they stand for it


@dataclass(frozen=True, eq=False)
class Arrays:
    """A program as solvers take it: min `cost @ x` over the x whose slacks `right - sparse @ [x, block @ x]` are in cones.

    The first `zero` slacks are zero; the others are in cones `|s[1:]| <= s[0]` of these `sizes`, the linear ones, of size 1, first.
    """

    sparse: csr_array
    block: Array
    right: Array
    cost: Array
    zero: int
    sizes: Integers

    @cached_property
    def matrix(self) -> csr_array:
        """All rows on x alone."""
        if not len(self.block):
            return self.sparse
        width = self.block.shape[1]
        return csr_array(self.sparse[:, :width].toarray() + self.sparse[:, width:] @ self.block)

    @property
    def cones(self) -> list[Integers]:
        """The rows of the cones, (n, d) for each size d."""
        starts = self.zero + np.cumsum(self.sizes) - self.sizes
        return [starts[self.sizes == size][:, None] + np.arange(size) for size in np.unique(self.sizes)]

    def violation(self, x: Array) -> float:
        """Largest violation of a row."""
        s = self.right - self.sparse @ np.concatenate([x, self.block @ x])
        outside = [(np.linalg.norm(s[cone[:, 1:]], axis=1) - s[cone[:, 0]]).max(initial=0.0) for cone in self.cones]
        return float(max([*outside, np.abs(s[: self.zero]).max(initial=0.0)]))

    def admissible(self, y: Array) -> Array:
        """The multipliers nearby that are in their cones."""
        y = y.copy()
        for cone in self.cones:
            y[cone[y[cone[:, 0]] < 0]] = 0.0
            y[cone[:, 0]] = np.maximum(y[cone[:, 0]], np.linalg.norm(y[cone[:, 1:]], axis=1))
        return y


def independent(equations: Arrays) -> Integers:
    """The equations for which no others stand; where others contradict them, too."""
    if not len(equations.right):
        return np.zeros(0, dtype=int)
    upper, order = qr(np.vstack([equations.matrix.T.toarray(), equations.right]), mode="r", pivoting=True)
    return np.sort(order[: int((np.abs(np.diagonal(upper)) > _DEPENDENT).sum())])


def shut_cones(program: Arrays) -> tuple[Integers, Integers, Integers]:
    """The cones whose first slack is zero whatever the unknowns: first rows (n,), the others (n, d), which are equations; and all rows but these."""
    count, width = len(program.right), program.block.shape[1]
    if program.sizes.max(initial=1) == 1:
        return np.zeros(0, dtype=int), np.zeros((0, 1), dtype=int), np.arange(count)
    sizes = np.r_[np.ones(width), np.abs(program.block).max(axis=1, initial=0.0)]
    every = np.abs(program.sparse) @ sizes + np.abs(program.right)
    found = [cone[every[cone[:, 0]] <= ROUNDING * every[cone[:, 1:]].max(axis=1)] for cone in program.cones if cone.shape[1] > 1]
    width = max((cone.shape[1] for cone in found), default=1)
    shut = np.concatenate([np.zeros((0, width), dtype=int), *(cone for cone in found if cone.shape[1] == width)])
    left = np.setdiff1d(np.arange(count), shut.ravel())
    return shut[:, 0], shut[:, 1:], left


def largest_of(matrix: csr_array, right: Array) -> Array:
    """The largest entry of each row, or its right side where it has none."""
    size, filled = np.zeros(len(right)), np.flatnonzero(np.diff(matrix.indptr))
    if len(filled):
        size[filled] = np.maximum.reduceat(np.abs(matrix.data), matrix.indptr[filled])
    return np.where(size > 0, size, np.where(right != 0, np.abs(right), 1.0))
