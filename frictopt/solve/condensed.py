"""A cone program without the variables that its equations define: sparse rows, and one dense block that all of them share.

With `b = block y` and W the scaling of slacks and multipliers, a step of an interior point solves, for y, b, z, and the multipliers m of b::

    sparse' z + [block' m, -m] = [u, 0],   sparse [y, b] - W^2 z = v

so that `K [y, b] + [block' m, -m]` is known, with `K = sparse' W^-2 sparse`, which has a small block for each node, but for the few unknowns that all
nodes share, such as the load factor. Either b is put in, which leaves a dense matrix of the size of y. Or, where b has fewer parts than y, K is
inverted, which leaves one of the size of m: a third of the work (a limit of 1,296 nodes takes 0.6 of the time), until slacks and multipliers differ
so much that rounding spoils it.
"""

import numpy as np
from scipy.linalg import qr
from scipy.linalg.blas import dsyrk
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.sparse import csc_array, csr_array, hstack
from scipy.sparse.csgraph import connected_components

from ..contact import Array
from .cones import Scaling

_LONG = 0.2  # share of the unknowns from which on a row counts as dense, and of the rows from which on all nodes share an unknown
_ROWS = 250  # rows in a part of the product, of which only the lower triangle is computed
_SHIFTS = (1e-14, 1e-13, 1e-12, 1e-11)  # of the diagonal, over itself: the first with which rounding leaves the equations a factor
_SOFTEST = 1e-10  # added stiffness of a node, over its largest one, without which the inverse is all rounding
_CORRECT, _HELPS = 1e-13, 0.1  # error of the equations from which on none is corrected, and what a correction leaves of it, unless all is rounding
_SPOILT = 1e-8  # error in the end from which on the inverse is spoilt


class Condensed:
    """The rows `right - A y` of cones and `objective @ y`, with `A y = sparse [y, block y]`.

    The block has the rows that define variables of the program, and the long rows of its cones.

    Parameters
    ----------
    matrix, right, objective
        The rows `right - matrix x` of the program, and its objective.
    zero
        How many of the first rows are zero. Each but a few defines a variable that no other one of them has; the few are solved for variables of
        their own.

    Attributes
    ----------
    right, objective, constant
        Of the rows and unknowns that are left; what the objective of all is more.
    sparse, transposed, block, turned
        (rows, n + b), its transpose, (b, n), and its transpose, in the order of rows.
    shared, inverted
        How many of the unknowns, the last ones, all nodes share; whether K is inverted.

    Raises
    ------
    LinAlgError
        These few depend on each other, or have too few variables.
    """

    def __init__(self, matrix: csr_array, right: Array, objective: Array, zero: int) -> None:
        equations, rows = csc_array(matrix[:zero]), csc_array(matrix[zero:])
        alone = np.flatnonzero(np.diff(equations.indptr) == 1)
        defining, first = np.unique(equations.indices[equations.indptr[alone]], return_index=True)
        defined, wide = alone[first], np.diff(rows.indptr) > _LONG * rows.shape[0]
        self._others, narrow = np.setdiff1d(np.arange(zero), defining), np.setdiff1d(np.flatnonzero(~wide), defined)
        if len(narrow) < len(self._others):
            raise np.linalg.LinAlgError("fewer variables than equations, but for those that all nodes share")
        every = np.hstack([equations.toarray(), np.eye(zero)[:, self._others]])
        self._share = np.bincount(defining, 1 / every[defining, defined], zero)
        every[defining] *= self._share[defining, None]
        order = qr(every[np.ix_(self._others, narrow)], mode="r", pivoting=True)[1] if len(self._others) else self._others
        pivots = narrow[order[: len(self._others)]]
        every[self._others] = np.linalg.solve(every[np.ix_(self._others, pivots)], every[self._others])
        every[defining] -= every[np.ix_(defining, pivots)] @ every[self._others]
        self._defined = np.empty(zero, dtype=int)
        self._defined[defining], self._defined[self._others] = defined, pivots
        kept = np.setdiff1d(np.arange(matrix.shape[1]), self._defined)
        self._kept, self.shared = np.concatenate([kept[~wide[kept]], kept[wide[kept]]]), int(wide[kept].sum())
        define, self._mixed = -every[:, self._kept], every[:, matrix.shape[1] :]
        self._start, self._costs = right[:zero] * self._share + self._mixed @ right[self._others], objective[self._defined]
        on_kept, on_defined = csr_array(rows[:, self._kept]), rows[:, self._defined]
        long = np.diff(on_kept.indptr) > _LONG * len(self._kept)
        chosen = csr_array((np.ones(long.sum()), (np.flatnonzero(long), np.arange(long.sum()))), shape=(len(long), int(long.sum())))
        self.block: Array = np.vstack([define, on_kept[long].toarray()])
        self.turned = np.ascontiguousarray(self.block.T)
        self.sparse = csr_array(hstack([on_kept.multiply(~long[:, None]), on_defined, chosen]))
        self.transposed = csr_array(self.sparse.T)
        self.inverted = 0 < len(self.block) < len(kept) and bool(np.diff(self.transposed.indptr).all())
        self.right, self.objective = right[zero:] - on_defined @ self._start, objective[self._kept] + define.T @ self._costs
        self.constant = float(self._costs @ self._start)

    def rows(self, y: Array) -> Array:
        """`A y`."""
        return np.asarray(self.sparse @ np.concatenate([y, self.block @ y]))

    def columns(self, z: Array) -> Array:
        """`A' z`."""
        work = self.transposed @ z
        return np.asarray(work[: len(self._kept)] + work[len(self._kept) :] @ self.block)

    def whole(self, y: Array, z: Array) -> tuple[Array, Array]:
        """Variables and multipliers of the program."""
        x, zero, n = np.empty(len(self._kept) + len(self._defined)), len(self._defined), len(self._kept)
        x[self._kept], x[self._defined] = y, self._start + self.block[:zero] @ y
        work = self.transposed @ z
        m = -(self._costs + work[n : n + zero])
        multipliers = m * self._share
        multipliers[self._others] = m @ self._mixed
        return x, np.concatenate([multipliers, z])


class Equations:
    """The equations `A' z = u` and `A y - W^2 z = v` of a step.

    Raises
    ------
    ArithmeticError, LinAlgError
        They have no factor.
    """

    def __init__(self, program: Condensed, scaling: Scaling) -> None:
        self._program, self._scaling = program, scaling
        self._weights = csr_array(program.transposed @ scaling.inverse_square() @ program.sparse)
        self._step = _Inverted(self._weights, program) if program.inverted else _PutIn(self._weights, program.block)

    def solved(self, u: Array, v: Array, last: bool = False) -> tuple[Array, Array]:
        """The y and z, whose errors are corrected in the equations themselves.

        The inverse serves until it adds more to what the multipliers miss, which is u, than a step takes away; in a `last` correction, to the end.
        """
        program, over, times, (parts, n) = self._program, self._scaling.over, self._scaling.times, self._program.block.shape
        x, m, drawn, z = np.zeros(n + parts), np.zeros(parts), np.zeros(n), np.zeros(len(v))
        size, before = max(float(np.abs(u).max()), float(np.abs(v).max())), np.inf
        left, right, apart = np.concatenate([u, m]), v, np.zeros(parts)
        while True:
            error = max(float(np.abs(part).max(initial=0.0)) for part in (left, right, apart))
            if not _CORRECT * size < error < _HELPS * before:
                break
            before = error
            more = self._step(left + program.transposed @ over(over(right)), apart)
            z = z + over(over(program.sparse @ more[0] - right))
            x, m, drawn = x + more[0], m + more[1], drawn + more[2]
            left, right = np.concatenate([u - drawn, m]) - program.transposed @ z, v - program.sparse @ x + times(times(z))
            apart = x[n:] - program.block @ x[:n]
        if program.inverted and not last and not (error <= _SPOILT * size and np.abs(left).max() <= np.abs(u).max()):
            program.inverted, self._step = False, _PutIn(self._weights, program.block)
            return self.solved(u, v)
        return x[:n], z


class _PutIn:
    """The x = [y, b], m and `block' m` with `K x + [block' m, -m] = load` and `block y - b = apart`, by `b = block y - apart`."""

    def __init__(self, weights: csr_array, block: Array) -> None:
        n = block.shape[1]
        self._weights, self._block, across = weights, block, csr_array(weights[n:, :n])
        half, matrix = _added(weights[n:, n:] @ block, across), _added(across.T @ block, weights[:n, :n])
        for start in range(0, n, _ROWS):
            rows = slice(start, start + _ROWS)
            matrix[rows, : rows.stop] += block[:, rows].T @ half[:, : rows.stop]
        self._factor = _factor(matrix.T)

    def __call__(self, load: Array, apart: Array) -> tuple[Array, Array, Array]:
        n = self._block.shape[1]
        load = load + self._weights[:, n:] @ apart
        y = dpotrs(self._factor, load[:n] + load[n:] @ self._block)[0]
        b = self._block @ y
        m = self._weights[n:] @ np.concatenate([y, b]) - load[n:]
        return np.concatenate([y, b - apart]), m, m @ self._block


class _Inverted:
    """The same by the inverse of K, of which the rows of the shared unknowns are left out and solved for last."""

    def __init__(self, weights: csr_array, program: Condensed) -> None:
        n, size = program.block.shape[1], weights.shape[0]
        own = n - program.shared
        self._block, self._own, self._inner, self._outer = program.block, own, np.r_[:own, n:size], slice(own, n)
        root = _root(weights[self._inner][:, self._inner])
        self._soft, last = csr_array(root.T @ root), root[own:, own:]
        half = _added(root[:own, :own] @ program.turned[:own], -root[:own, own:])
        self._factor = _factor(_added(dsyrk(1.0, half.T), last.T @ last))
        shared = weights[:, self._outer].toarray()
        self._moved = self._soft @ shared[self._inner]
        self._parts = self._lack(self._moved) - self._block[:, self._outer]
        self._held = dpotrs(self._factor, self._parts)[0]
        self._small = shared[self._outer] - shared[self._inner].T @ self._moved + self._parts.T @ self._held

    def _lack(self, inner: Array) -> Array:
        return np.asarray(self._block[:, : self._own] @ inner[: self._own] - inner[self._own :])

    def __call__(self, load: Array, apart: Array) -> tuple[Array, Array, Array]:
        inner, outer = self._inner, self._outer
        free = self._soft @ load[inner]
        lack = self._lack(free) - apart
        shared = np.linalg.solve(self._small, load[outer] - self._moved.T @ load[inner] + self._held.T @ lack)
        m = dpotrs(self._factor, lack - self._parts @ shared)[0]
        drawn, x = m @ self._block, np.empty(len(load))
        x[outer], x[inner] = shared, free - self._moved @ shared - self._soft @ np.concatenate([drawn[: self._own], -m])
        return x, m, drawn


def _root(matrix: csr_array) -> csr_array:
    """The R with `R' R` the inverse of a positive definite matrix of many small blocks, in each of which a row has no columns before its own.

    The blocks are stiffened a little, so that rounding leaves them positive definite.
    """
    _, part = connected_components(matrix, directed=False)
    sizes, order, entries = np.bincount(part), np.argsort(part, kind="stable")[::-1], matrix.tocoo()
    place, number = np.empty((2, len(part)), dtype=int)
    rows, columns, found = list[Array](), list[Array](), list[Array]()
    for d in np.unique(sizes):
        at = order[sizes[part[order]] == d].reshape(-1, d)
        number[at], place[at] = np.arange(len(at))[:, None], np.arange(d)
        own = sizes[part[entries.row]] == d
        row, column, blocks = entries.row[own], entries.col[own], np.zeros((len(at), d, d))
        blocks[number[row], place[row], place[column]] = entries.data[own]
        size, lower = np.sqrt(np.diagonal(blocks, axis1=1, axis2=2)), np.tril_indices(d)
        scaled = blocks / (size[:, :, None] * size[:, None]) + _SOFTEST * np.eye(d)
        rows.append(at[:, lower[0]].ravel())
        columns.append(at[:, lower[1]].ravel())
        found.append((np.linalg.inv(np.linalg.cholesky(scaled)) / size[:, None])[:, *lower].ravel())
    return csr_array((np.concatenate(found), (np.concatenate(rows), np.concatenate(columns))), shape=matrix.shape)


def _added(matrix: Array, more: csr_array) -> Array:
    """A matrix, to which the entries of another one are added in place."""
    entries = more.tocoo()
    matrix[entries.row, entries.col] += entries.data
    return matrix


def _factor(matrix: Array) -> Array:
    """The Cholesky factor, upper, of the upper triangle of a matrix in the order of columns."""
    diagonal = matrix.diagonal().copy()
    for shift in _SHIFTS:
        np.fill_diagonal(matrix, diagonal * (1 + shift))
        factor, failed = dpotrf(matrix)
        if not failed:
            return np.asarray(factor)
    raise ArithmeticError("the equations of a step have no factor")
