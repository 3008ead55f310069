"""A cvxpy problem as cvxpy compiles it, with its dense equations as blocks: what its multipliers prove, and the answer put back into it."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import cvxpy as cp
import numpy as np
from cvxpy.reductions.solution import Solution
from scipy.linalg import cholesky, lu_factor, lu_solve, qr, svd
from scipy.linalg.lapack import dpotri
from scipy.sparse import csr_array, hstack

from ..base import CONDENSATION, FLOOR, RIGID, ROUNDING, Array, Integers

_FIRST, _ITERATIONS = (
    8,
    4,
)  # of an inverse iteration: vectors at first, twice as many where all are soft, and steps
_EXACT = ROUNDING / 100  # rounding of a sum, over the size of its terms
# whose order of rows and columns the arrays have; it takes linear rows and second-order cones
_SOLVER = "CLARABEL"


@dataclass(frozen=True, eq=False)
class Block:
    """Equations `z[defined] = matrix @ z[of]` of one dense matrix, which is not copied.

    `rows` and `sources` are where the rows of `z[defined]` and of `z[of]` stand in the compiled
    matrix; `sign` is the sign that cvxpy gave them.
    """

    row: cp.Constraint
    matrix: Array
    defined: Integers
    of: Integers
    rows: slice
    sources: slice
    sign: float


@dataclass(frozen=True, eq=False)
class Change:
    """A change of variables of a dense equation `row`, `z[defined] = square @ z[of]`: `z[of] = matrix @ x`, and `z[defined] = product @ x`, sparse.

    `blocks` are what other dense equations of the same unknowns are of x; `unit` (n,) is the unit
    of x. The first of x are the values `loaded` of the left side, in their units, and the rest is
    what no value resists.
    """

    row: cp.Constraint
    matrix: Array
    product: csr_array
    blocks: Mapping[cp.Constraint, Array]
    unit: Array
    loaded: Integers


class Compiled:
    """A problem `min cost @ z` over the z whose slacks `right - matrix @ z` are in cones, as cvxpy compiles it.

    Equations `x == Constant @ y` of two variables are blocks: cvxpy compiles `x == 0` and `y == 0`
    in their place, so that no dense matrix goes through it, and their rows are the first
    `sparse_zero`. Parameters are read anew by `read`, and compiled once.

    The first `zero` slacks are zero, the next `nonneg` are >= 0, and cones `|s[1:]| <= s[0]` of the
    sizes `soc` follow. The values of a variable begin in z at `columns[its id]`.
    """

    def __init__(self, problem: cp.Problem) -> None:
        self.problem = problem
        dense = {
            row.args[0].variables()[0].id: row
            for row in reversed(problem.constraints)
            if _is_dense(row)
        }  # one for each variable
        of = {variable.id for row in dense.values() for variable in row.args[1].variables()}
        self._dense = [
            row
            for row in problem.constraints
            if any(row is one and at not in of for at, one in dense.items())
        ]
        others = [row for row in problem.constraints if not any(row is one for one in self._dense)]
        self._parts = [
            part == 0 for row in self._dense for part in (row.args[0], row.args[1].args[1])
        ]
        self._skeleton = cp.Problem(problem.objective, [*self._parts, *others])
        for variable in (
            problem.variables()
        ):  # cvxpy carries values over to unknowns of its own, and refuses nan
            variable.save_value(
                variable.value
                if variable.value is not None and np.isfinite(variable.value).all()
                else None
            )
        self.read()
        self.blocks, self.sparse_zero = list[Block](), 0
        for row, (x, y) in zip(
            self._dense, zip(self._parts[::2], self._parts[1::2], strict=True), strict=True
        ):
            rows, sources = (
                slice(at, at + part.size)
                for at, part in ((self.sparse_zero, x), (self.sparse_zero + x.size, y))
            )
            defined, of = (self.matrix[part].indices.astype(int) for part in (rows, sources))
            sign, self.sparse_zero = (
                float(self.matrix.data[self.matrix.indptr[rows.start]]),
                sources.stop,
            )
            self.blocks.append(
                Block(row, np.asarray(row.args[1].args[0].value), defined, of, rows, sources, sign)
            )

    def read(self) -> None:
        """Read the values of all parameters."""
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # of the way that cvxpy takes with expressions of three dimensions
            data, self._chain, self._inverse = self._skeleton.get_problem_data(
                _SOLVER, enforce_dpp=True, solver_opts={}
            )
        self.matrix, self.right, self.cost = (
            csr_array(data["A"]),
            np.asarray(data["b"]),
            np.asarray(data["c"]),
        )
        self.matrix.eliminate_zeros()
        dims = data["dims"]
        self.zero, self.nonneg, self.soc = (
            int(dims.zero),
            int(dims.nonneg),
            [int(size) for size in dims.soc],
        )
        self.columns = data["param_prob"].var_id_to_col

    def place(self, variable: cp.Variable) -> slice:
        """Where the values of a variable stand in z."""
        first = int(self.columns[variable.id])
        return slice(first, first + variable.size)

    def whole(self, y: Array) -> Array:
        """Multipliers, of which those of the rows of `z[of]` follow from those of their blocks."""
        for block in self.blocks:
            y[block.sources] = -(block.matrix.T @ y[block.rows])
        return y

    def violation(self, z: Array, units: Array) -> float:
        """Largest violation of a row by values, over the size of its terms, those of an unknown counted from its unit on."""
        return self._largest(
            z, self.right, np.abs(self.matrix) @ np.maximum(np.abs(z), units) + np.abs(self.right)
        )

    def leaving(self, z: Array, sizes: Array) -> float:
        """How far a direction leaves a row at most, over its terms in that row, beyond rounding; its values are sums of terms of `sizes`."""
        terms = np.abs(self.matrix)
        return self._largest(
            z, np.zeros_like(self.right), terms @ np.abs(z), _EXACT * (terms @ sizes)
        )

    def _largest(self, z: Array, right: Array, size: Array, rounding: Array | float = 0.0) -> float:
        """Largest violation of a row of this right side beyond its rounding, over its size."""
        s, zero = right - self.matrix @ z, self.zero
        for block in self.blocks:
            s[block.rows], s[block.sources] = 0.0, 0.0  # put in: their errors are the referee's
        sizes, tails = (
            np.r_[np.ones(self.nonneg, dtype=int), np.array(self.soc, dtype=int)],
            s.copy(),
        )
        heads = zero + np.cumsum(sizes) - sizes
        tails[heads] = 0.0
        off = np.r_[np.abs(s[:zero]), np.sqrt(np.add.reduceat(tails**2, heads)) - s[heads]]
        size, rounding = (
            np.r_[each[:zero], np.add.reduceat(each, heads)]
            for each in (size, np.broadcast_to(rounding, size.shape))
        )
        return float(np.max((off - rounding) / np.where(size > 0, size, 1.0), initial=0.0))

    def outside(self, y: Array) -> Array:
        """How far the multipliers of each row or cone lie outside of the dual cone, for a cone at its first row."""
        heads = self.zero + self.nonneg + np.cumsum([0, *self.soc])[:-1]
        lengths, lacks = y.copy(), np.zeros(len(y))
        lengths[: self.zero + self.nonneg], lengths[heads] = 0.0, 0.0
        lacks[self.zero : self.zero + self.nonneg] = -y[self.zero : self.zero + self.nonneg]
        if len(heads):
            lacks[heads] = np.sqrt(np.add.reduceat(lengths**2, heads)) - y[heads]
        return np.maximum(lacks, 0.0)

    def save(self, z: Array, y: Array) -> None:
        """Put an answer into the variables and the multipliers of the rows of the problem."""
        told = SimpleNamespace(
            x=z,
            z=y,
            status="Solved",
            obj_val=float(self.cost @ z),
            obj_val_dual=0.0,
            solve_time=0.0,
            iterations=0,
        )
        self._skeleton.unpack_results(told, self._chain, self._inverse)
        for row, part in zip(self._dense, self._parts[::2], strict=True):
            row.save_dual_value(part.dual_value)
        values = {variable.id: variable.value for variable in self.problem.variables()}
        duals = {
            part.id: part.value for row in self.problem.constraints for part in row.dual_variables
        }
        self.problem.unpack(
            Solution(cp.OPTIMAL, float(self.problem.objective.value), values, duals, {})
        )

    def save_multipliers(self, y: Array) -> dict[int, float]:
        """Put multipliers alone into the rows of the problem; the largest of each row, by its id."""
        self.save(np.zeros(len(self.cost)), y)
        return {
            row.id: max(float(np.abs(part.value).max(initial=0.0)) for part in row.dual_variables)
            for row in self.problem.constraints
        }


@dataclass(frozen=True)
class Proof:
    """What multipliers prove of a largest objective: the value, its upper bound without the defect, and the defect.

    The defect is by how much the bound may be off because the multipliers do not quite balance, for
    all z of the size of this one, or of their unit.
    """

    value: float
    bound: float
    defect: float
    unit: float

    @property
    def gap(self) -> float:
        """Distance of the bound from the value, and the defect, over the value, or over a thousandth of its unit where that is more."""
        return (abs(self.bound - self.value) + self.defect) / max(
            abs(self.value), FLOOR * self.unit
        )


def proof(compiled: Compiled, z: Array, y: Array, units: Array, unit: float) -> Proof:
    """The bound that multipliers in their cones prove by weak duality on the program as it was compiled, in the sense of the problem's objective."""
    sense = -1.0 if isinstance(compiled.problem.objective, cp.Maximize) else 1.0
    constant = float(compiled.problem.objective.value) - sense * float(compiled.cost @ z)
    defect = float(np.abs(compiled.matrix.T @ y + compiled.cost) @ np.maximum(np.abs(z), units))
    return Proof(
        constant + sense * float(compiled.cost @ z),
        constant - sense * float(compiled.right @ y),
        defect,
        unit,
    )


def _is_dense(row: cp.Constraint) -> bool:
    """Whether a row is `x == Constant @ y` of a full matrix."""
    if not isinstance(row, cp.constraints.Equality):
        return False
    left, right = row.args
    return bool(
        isinstance(right, cp.atoms.affine.binary_operators.MulExpression)
        and isinstance(right.args[0], cp.Constant)
        and isinstance(right.args[0].value, np.ndarray)
        and right.args[0].ndim == 2
        and all(_is_variable(part) for part in (left, right.args[1]))
    )


def _is_variable(part: cp.Expression) -> bool:
    """Whether an expression is a variable, or entries of it in the order of its columns or chosen by a matrix of zeros and ones, each once."""
    while isinstance(part, (cp.reshape, cp.atoms.affine.binary_operators.MulExpression)):
        if not isinstance(part, cp.reshape) and not _chooses(part.args[0]):
            return False
        part = part.args[-1]
    return isinstance(part, cp.Variable)


def _chooses(factor: cp.Expression) -> bool:
    if not isinstance(factor, cp.Constant) or factor.ndim != 2:
        return False
    matrix = csr_array(factor.value)
    return bool(
        (np.diff(matrix.indptr) == 1).all()
        and (matrix.data == 1).all()
        and len(np.unique(matrix.indices)) == matrix.nnz
    )


def unresisted(square: Array, others: Array, along: Array, across: Array) -> tuple[Array, Array]:
    """Orthonormal vectors x (t, k) that a symmetric, positive semi-definite matrix does not resist, nor others, and its inverse on the rest (t, t).

    Each x counts in units of 1 over `along` (t,), and each of the others, (o, t), in `across` (o,),
    so that a soft unknown beside stiff ones is not taken for a free one. An x that changes one of
    the others is resisted, however little.
    """
    t = len(along)
    scaled, pressure = square / np.outer(along, along), others / np.outer(across, along)
    idle = ~(scaled.any(axis=0) | (np.abs(pressure).max(axis=0, initial=0.0) > RIGID))
    scaled[idle, idle] = (
        1.0  # what nothing feels at all is free by itself, so that the others stay exact
    )
    factor, rng, count, stiffest = (
        lu_factor(scaled + RIGID * np.eye(t)),
        np.random.default_rng(0),
        0,
        0.0,
    )
    while (
        stiffest <= RIGID and count < t
        # inverse iteration of more vectors than there are soft ones, which many small eigenvalues
        # cannot slow
    ):
        count = min(2 * count or _FIRST, t)
        soft = rng.normal(size=(t, count))
        for _ in range(_ITERATIONS):
            soft = np.linalg.qr(lu_solve(factor, soft))[0]
        values, turn = np.linalg.eigh(soft.T @ scaled @ soft)
        stiffest = values[-1]
    values, soft = values[values <= RIGID], (soft @ turn)[:, values <= RIGID]
    soft[idle] = 0.0
    held = (values > 0) & (np.abs(pressure @ soft).max(axis=0, initial=0.0) > RIGID)
    share = np.where(held, 1 / np.where(held, values, 1.0), 0.0) - 1 / (1 + values)
    root = cholesky(
        (scaled + soft @ soft.T).T, lower=True, overwrite_a=True, check_finite=False
    )  # soft vectors have the stiffness 1 + value
    inverse = np.tril(dpotri(root, lower=1, overwrite_c=1)[0])
    inverse += np.tril(inverse, -1).T + (soft * share) @ soft.T
    inverse /= np.outer(along, along)
    rigid = np.hstack([np.linalg.qr(soft[:, ~held] / along[:, None])[0], np.eye(t)[:, idle]])
    inverse -= rigid @ (rigid.T @ inverse)
    return rigid, np.asarray(inverse - (inverse @ rigid) @ rigid.T)


def by_inverse(
    row: cp.Constraint,
    others: Sequence[cp.Constraint],
    free: Array,
    inverse: Array,
    unit: Array,
    sizes: Array,
) -> Change:
    """The change of variables of a dense equation of a square matrix, whose unknowns are its values, and what it does not resist.

    The values balance each other on `free` (t, k): those of k rows follow from the others. The
    first of the `others`, dense equations of the same unknowns, does not feel the free vectors;
    what the rest may feel of them is turned so that each is felt, or not at all. `unit` (t,) are
    the units of the values, `sizes` (k,) those of the free vectors.
    """
    each, count = unit[:, None], free.shape[1]
    resting = each * free
    pivots = qr(resting.T, mode="r", pivoting=True)[1] if count else np.arange(len(each))
    balancing, loaded = pivots[:count], np.sort(pivots[count:])
    basis = np.zeros(
        (len(each), len(loaded))
    )  # unit values, balanced by those at as many rows as there are free vectors
    basis[loaded, np.arange(len(loaded))] = 1.0
    basis[balancing] = -np.linalg.solve(resting[balancing].T, resting[loaded].T)
    basis[np.abs(basis) <= ROUNDING] = 0.0
    values = csr_array(each * basis)
    held, turned = (values.T @ inverse).T, free * sizes
    matrices = {other: np.asarray(other.args[1].args[0].value) for other in others}
    feeling = np.vstack([np.zeros((0, len(each))), *(matrices[other] for other in others[1:])])
    if count and len(feeling):
        turned = turned @ svd(feeling @ turned)[2].T
    blocks = dict[cp.Constraint, Array]()
    for other, matrix in matrices.items():
        moved = np.zeros((len(matrix), count)) if other is others[0] else matrix @ turned
        moved[
            :,
            np.abs(moved).max(axis=0, initial=0.0)
            <= CONDENSATION * np.abs(turned).max(axis=0, initial=0.0),
        ] = 0.0
        blocks[other] = np.hstack([matrix @ held, moved])
    product = csr_array(hstack([values, csr_array((len(each), count))]))
    return Change(
        row, np.hstack([held, turned]), product, blocks, np.ones(product.shape[1]), loaded
    )
