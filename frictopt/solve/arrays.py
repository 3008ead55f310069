"""A program in the form for solvers, and the polish of a rough solution to an exact one.

A program has a cost, sparse rows and one dense block of rows, and its slacks are in cones. `Rows`
lists the entries of rows, and `program_of` makes a program from them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import lstsq
from scipy.linalg.lapack import dsycon, dsytrf, dsytrf_lwork, dsytrs
from scipy.sparse import csr_array, eye_array, hstack, vstack

from ..base import ROUNDING, STALLED, Array, Integers

# Constants of the polish.

# Singular values up to this share of the largest one count as zero; along their directions the
# solution is not changed.
_NOT_UNIQUE = ROUNDING / 10
# Once the error of the equations of active rows and cones is this small, no step reduces it.
_POLISHED = 1e-3 * ROUNDING
# Largest number of Newton steps; usually three are enough.
_STEPS = 8
# Number of gaps between ratios of multiplier to slack that are tried, see `polish`.
_GAPS = 8
# Ratios are clipped to this number and its inverse.
_LEAST_RATIO = 1e-12


def columns(sparse: csr_array, block: Array, y: Array) -> Array:
    """`A.T @ y` of the matrix A whose product with x is `sparse @ [x, block @ x]`."""
    work = sparse.T @ y
    width = block.shape[1]
    return np.asarray(work[:width] + work[width:] @ block)


@dataclass(frozen=True, eq=False)
class Arrays:
    """A program: min `cost @ x` over the x with the slacks `right - sparse @ [x, block @ x]`.

    The first `zero` slacks are zero. The other slacks are in cones `|s[1:]| <= s[0]`, and `sizes`
    lists the number of rows of each cone. The linear rows, cones of size 1, come first.
    """

    sparse: csr_array
    block: Array
    right: Array
    cost: Array
    zero: int
    sizes: Integers

    @cached_property
    def linear(self) -> int:
        """The number of equations and linear rows, which are the first rows."""
        return self.zero + int((self.sizes == 1).sum())

    @cached_property
    def heads(self) -> Integers:
        """The first row of each cone, linear rows included."""
        return self.zero + np.cumsum(self.sizes) - self.sizes

    @cached_property
    def matrix(self) -> Array:
        """The matrix A of all rows, the block multiplied out: the slacks are `right - A x`."""
        return np.asarray(self.sparse @ np.vstack([np.eye(len(self.cost)), self.block]))

    @cached_property
    def cones(self) -> list[Integers]:
        """The rows of the cones: for each size d, an array (n, d) of its n cones."""
        return [
            self.heads[self.sizes == size][:, None] + np.arange(size)
            for size in np.flatnonzero(np.bincount(self.sizes))
        ]

    def columns(self, y: Array) -> Array:
        """`matrix.T @ y`, computed without `matrix`."""
        return columns(self.sparse, self.block, y)

    def slack(self, x: Array) -> Array:
        """Slacks of all rows."""
        return np.asarray(self.right - self.sparse @ np.concatenate([x, self.block @ x]))

    def violation(self, x: Array) -> float:
        """Largest violation of a row."""
        s = self.slack(x)
        outside = [
            (np.linalg.norm(s[cone[:, 1:]], axis=1) - s[cone[:, 0]]).max(initial=0.0)
            for cone in self.cones
        ]
        return float(max([*outside, np.abs(s[: self.zero]).max(initial=0.0)]))

    def off(self, x: Array, y: Array) -> float:
        """Largest violation of the optimality conditions.

        The conditions are: slacks in their cones, the balance of the multipliers, and zero work of
        the multipliers on the slacks.
        """
        if not (np.isfinite(x).all() and np.isfinite(y).all()):
            return np.inf
        balance = np.abs(self.columns(y) + self.cost).max(initial=0.0)
        return float(max(self.violation(x), balance, abs(y @ self.slack(x))))

    def lower_bound(self, x: Array, y: Array) -> tuple[float, float]:
        """The lower bound of `cost @ x` that multipliers in their cones prove, and its error.

        The multipliers balance only up to rounding. The error holds for unknowns up to the size of
        x, or up to 1.
        """
        unbalanced = np.abs(self.columns(y) + self.cost)
        return -float(self.right @ y), float(unbalanced @ np.maximum(np.abs(x), 1.0))

    @property
    def widened(self) -> "Arrays":
        """The program with `block @ x` as further unknowns, which its first equations define."""
        parts, width = self.block.shape
        if not parts:
            return self
        definitions = hstack([csr_array(self.block), -eye_array(parts)])
        return Arrays(
            sparse=csr_array(vstack([definitions, self.sparse])),
            block=np.zeros((0, width + parts)),
            right=np.r_[np.zeros(parts), self.right],
            cost=np.r_[self.cost, np.zeros(parts)],
            zero=parts + self.zero,
            sizes=self.sizes,
        )

    @cached_property
    def dual(self) -> "Arrays":
        """The dual of a program of sparse rows: its unknowns are the multipliers y.

        Its equations are `A'y + cost = 0`, whose multipliers are minus the unknowns x.
        """
        rows = len(self.right)
        in_cones = eye_array(rows, format="csr")[self.zero :]
        return Arrays(
            sparse=csr_array(vstack([self.sparse.T, -in_cones])),
            block=np.zeros((0, rows)),
            right=np.r_[-self.cost, np.zeros(rows - self.zero)],
            cost=self.right,
            zero=len(self.cost),
            sizes=self.sizes,
        )

    def admissible(self, y: Array) -> Array:
        """Multipliers near y that are in their cones."""
        y = y.copy()
        for cone in self.cones:
            y[cone[y[cone[:, 0]] < 0]] = 0.0
            y[cone[:, 0]] = np.maximum(y[cone[:, 0]], np.linalg.norm(y[cone[:, 1:]], axis=1))
        return y


def polish(program: Arrays, x: Array, y: Array) -> tuple[Array, Array]:
    """Move a solution onto its active rows and cones, by Newton's method on their equations.

    The ratio of multiplier to slack shows whether a row or cone is active: solvers leave a large
    ratio at an active row or cone, and a small ratio at an inactive one. The widest gap between the
    ratios is taken to separate active from inactive ones. If this guess is wrong, the next gaps are
    tried. The result is the point with the smallest violation of the optimality conditions. The
    caller checks its residual.
    """
    best = x, program.admissible(y)
    least = program.off(*best)
    with np.errstate(all="ignore"):  # numbers of a wrong guess may overflow, and `off` rejects it
        for share in _shares(program, x, y):
            at, slopes = _Active(program, x, y, share).solved(x, y)
            # If there are more active equations than unknowns, the multipliers are not unique, and
            # the rough ones may be as good.
            for multipliers in (slopes, y):
                solution = at, program.admissible(multipliers)
                off = program.off(*solution)
                if off < least:
                    best = solution
                    least = off
                if least <= ROUNDING:
                    return best
    return best


def _shares(program: Arrays, x: Array, y: Array) -> list[float]:
    """Ratios of multiplier to slack that separate active from inactive rows and cones.

    Each is the middle of one of the widest gaps between the ratios; the widest gap comes first.
    """
    s = program.slack(x)
    sides = [side for cone in program.cones for side in _sides(s[cone], y[cone])]
    slack, multiplier = np.hstack(sides)
    ratios = np.where(slack > 0, multiplier / np.where(slack > 0, slack, 1.0), np.inf)
    powers = np.sort(np.log10(np.clip(ratios, _LEAST_RATIO, 1 / _LEAST_RATIO)))
    widest = np.argsort(-np.diff(powers), kind="stable")[:_GAPS]
    return [float(10 ** powers[[k, k + 1]].mean()) for k in widest]


def _sides(s: Array, y: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """The slack and multiplier of each cone, (n, d), for its boundary and for its apex."""
    radius = np.linalg.norm(s[:, 1:], axis=1)
    slid = np.linalg.norm(y[:, 1:], axis=1)
    boundary = (s[:, 0] - radius, y[:, 0] + np.copysign(slid, y[:, 0]))
    apex = (s[:, 0] + radius, y[:, 0] - slid)
    return boundary, apex


def _directed(vectors: Array) -> tuple[Array, Array]:
    """Lengths and directions of vectors, (n, d); 1 and 0 for a zero vector."""
    radius = np.linalg.norm(vectors, axis=1)
    radius = np.where(radius > 0, radius, 1.0)
    return radius, vectors / radius[:, None]


class _Active:
    """The active rows and cones at a point: rows without slack, and cones on their boundary.

    Equations have no slack, and neither have cones at their apex; `rows[0]` lists all their rows.
    Each further entry of `rows`, (n, d), holds the rows of n cones on their boundary.
    """

    def __init__(self, program: Arrays, x: Array, y: Array, share: float) -> None:
        self._program = program
        s = program.slack(x)
        vanishing = [np.arange(program.zero)]
        on_boundary = list[Integers]()
        # If there are as many equations as unknowns, the equations alone determine the unknowns.
        cones = program.cones if program.zero < len(x) else []
        for cone in cones:
            (slack, slid), (tip, excess) = _sides(s[cone], y[cone])
            apex = excess > share * tip
            vanishing.append(cone[apex].ravel())
            if cone.shape[1] > 1:
                slides = (slid > share * slack) & ~apex & s[cone[:, 1:]].any(axis=1)
                on_boundary.append(cone[slides])
        self.rows = [np.concatenate(vanishing), *on_boundary]

    def _equations(self, x: Array, m: Array) -> tuple[Array, Array, Array]:
        """Values of the active rows and cones, their gradients, and a Hessian.

        The Hessian belongs to minus the sum of these values, weighted by the multipliers m.
        """
        vanishing, *on_boundary = self.rows
        matrix = self._program.matrix
        s = self._program.slack(x)
        n = len(x)
        values = [s[vanishing]]
        gradients = [-matrix[vanishing]]
        hessian = np.zeros((n, n))
        first = len(vanishing)
        for cone in on_boundary:
            radius, unit = _directed(s[cone[:, 1:]])
            sides = -matrix[cone[:, 1:]]
            along = np.einsum("ri,riz->rz", unit, sides)
            values.append(s[cone[:, 0]] - radius)
            gradients.append(-matrix[cone[:, 0]] - along)
            multipliers = m[first : first + len(cone)]
            weight = np.sqrt(np.maximum(multipliers, 0.0) / radius)
            across = (sides - unit[:, :, None] * along[:, None]) * weight[:, None, None]
            across = across.reshape(-1, n)
            hessian = hessian + across.T @ across
            first += len(cone)
        return np.concatenate(values), np.vstack(gradients), hessian

    def solved(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The x and multipliers that solve the equations of the active set, by Newton's method."""
        vanishing, *on_boundary = self.rows
        cost = self._program.cost
        m = np.concatenate([y[vanishing], *(y[cone[:, 0]] for cone in on_boundary)])
        best = x, m
        least = np.inf
        for _ in range(_STEPS):
            values, gradients, hessian = self._equations(x, m)
            balance = float(np.abs(gradients.T @ m - cost).max(initial=0.0))
            error = max(balance, float(np.abs(values).max(initial=0.0)))
            if error < least:
                best = x, m
                least = error
            elif least <= STALLED or not np.isfinite(error):
                break
            if error <= _POLISHED:
                break
            matrix = np.block([[-hessian, gradients.T], [gradients, np.zeros((len(m), len(m)))]])
            step = _least(matrix, np.r_[cost, -values])
            x = x + step[: len(x)]
            m = step[len(x) :]
        return best[0], self._multipliers(*best, len(y))

    def _multipliers(self, x: Array, m: Array, count: int) -> Array:
        """Multipliers of all rows, from the multipliers of the active set."""
        vanishing, *on_boundary = self.rows
        s = self._program.slack(x)
        multipliers = np.zeros(count)
        first = len(vanishing)
        multipliers[vanishing] = m[:first]
        for cone in on_boundary:
            size = m[first : first + len(cone)]
            multipliers[cone[:, 0]] = size
            multipliers[cone[:, 1:]] = -size[:, None] * _directed(s[cone[:, 1:]])[1]
            first += len(cone)
        return multipliers


def _least(matrix: Array, right: Array) -> Array:
    """The solution of symmetric equations, the smallest one if there are several."""
    factor, order, _ = dsytrf(matrix, lwork=int(dsytrf_lwork(len(matrix))[0]))
    if dsycon(factor, order, np.abs(matrix).sum(axis=0).max())[0] > _NOT_UNIQUE:
        return np.asarray(dsytrs(factor, order, right)[0])
    return np.asarray(
        lstsq(matrix, right, cond=_NOT_UNIQUE, lapack_driver="gelsy", check_finite=False)[0]
    )


EQUATION = 0
LINEAR = 1
CONE = 2


class Rows(NamedTuple):
    """n rows or cones with one label: the unit, instant and node of each, and all their entries."""

    label: str
    kind: int  # EQUATION, LINEAR or CONE
    sizes: Integers  # (n,) 1, or the size of each cone
    at: Integers  # (entries,) number of the row of each entry, cones row by row
    quantities: Integers  # (entries,) number of the unknown, in user units, of each entry
    weights: Array  # (entries,) in user units
    constants: Array  # (rows,)
    unit: Array  # (n,)
    instants: Integers  # (n,)
    nodes: Integers  # (n,)


Term = tuple[Integers, Array]
"""One quantity for each of n rows, by its number (n,), and its weights (n,) in these rows."""


def rows_of(
    label: str,
    kind: int,
    parts: Sequence[Sequence[Term]],
    constant: Array,
    unit: Array,
    instants: Integers | None = None,
    nodes: Integers | None = None,
) -> Rows:
    """Make n rows or cones with the same terms.

    `parts[0]` lists the terms of the first row of each cone, `parts[1]` the terms of the second
    row, and so on. `constant` (n,) is added to the first row. Without instants or nodes, their
    numbers are -1.
    """
    n, size = len(constant), len(parts)
    none = np.full(n, -1)
    instants = none if instants is None else instants
    nodes = none if nodes is None else nodes
    first = size * np.arange(n)
    constants = np.zeros(n * size)
    constants[first] = constant
    terms = [(first + part, *term) for part, of_part in enumerate(parts) for term in of_part]
    at, quantities, weights = (np.concatenate(entries) for entries in zip(*terms, strict=True))
    sizes = np.full(n, size)
    return Rows(label, kind, sizes, at, quantities, weights, constants, unit, instants, nodes)


def dense_rows(
    label: str,
    kind: int,
    matrix: Array,
    constants: Array,
    unit: Array,
) -> Rows:
    """Make n rows or cones of one size, in the units (n,), from all their weights.

    `matrix` (rows, quantities) and `constants` (rows,) list the cones row by row.
    """
    n = len(unit)
    none = np.full(n, -1)
    sizes = np.full(n, len(matrix) // n)
    at, quantities = np.nonzero(matrix)
    weights = matrix[at, quantities]
    return Rows(label, kind, sizes, at, quantities, weights, constants, unit, none, none)


class Stacked(NamedTuple):
    """The rows of a program one after the other: equations, linear rows, cones."""

    parts: list[tuple[Rows, slice]]  # the rows of each label, and where they are
    units: Array  # (R,)
    at: Integers  # (entries,) number of the row of each entry
    quantities: Integers  # (entries,)
    weights: Array  # (entries,)
    constants: Array  # (R,)
    zero: int  # number of equations
    sizes: Integers  # sizes of the linear rows and cones


def stacked(rows: Sequence[Rows]) -> Stacked:
    """All rows, in the order of the solver."""
    in_order = sorted(rows, key=lambda part: part.kind)
    counts = [len(part.constants) for part in in_order]
    ends = np.cumsum(counts)
    firsts = (ends - counts).tolist()
    return Stacked(
        list(zip(in_order, map(slice, firsts, ends.tolist()), strict=True)),
        np.concatenate([np.repeat(part.unit, part.sizes) for part in in_order]),
        np.concatenate([part.at + first for part, first in zip(in_order, firsts, strict=True)]),
        np.concatenate([part.quantities for part in in_order]),
        np.concatenate([part.weights for part in in_order]),
        np.concatenate([part.constants for part in in_order]),
        sum(len(part.constants) for part in in_order if part.kind == EQUATION),
        np.concatenate([part.sizes for part in in_order if part.kind != EQUATION]),
    )


def program_of(rows: Sequence[Rows], units: Array, cost: Array) -> Arrays:
    """The program that minimises `cost @ x` over quantities `units * x` that obey the rows."""
    _, row_units, at, quantities, weights, constants, zero, sizes = stacked(rows)
    values = -weights * units[quantities] / row_units[at]
    shape = len(row_units), len(units)
    return Arrays(
        sparse=csr_array((values, (at, quantities)), shape=shape),
        block=np.zeros((0, len(units))),
        right=constants / row_units,
        cost=cost,
        zero=zero,
        sizes=sizes,
    )
