"""The compiled form of a cvxpy problem, with its dense equations as blocks.

The answer is put back into the problem here, and `proof` computes the bound that its multipliers
prove.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.reductions.solution import Solution
from scipy.linalg import qr, svd
from scipy.sparse import csr_array, issparse

from ..base import CONDENSATION, FLOOR, ROUNDING, Array, Integers
from .solvers import backend

# cvxpy compiles for this solver, which accepts linear rows and cones.
_SOLVER = "CLARABEL"


@dataclass(frozen=True, eq=False)
class Block:
    """Equations `z[defined] = matrix @ z[of]` of one dense matrix, which is not copied.

    `rows` and `sources` are the places of the rows of `z[defined]` and of `z[of]` in the compiled
    matrix; `sign` is the sign that cvxpy gave these rows.
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
    """A change of variables of a dense equation `row`, `z[defined] = square @ z[of]`.

    The new unknowns are x = [y, slides]. The y are the values `loaded` of the left side, in their
    units, and the slides are motions that the matrix does not resist. With the (t, m) sparse
    `values`, `z[defined] = values @ y`, and `z[of] = inverse @ values @ y + free @ slides`. The
    (t, t) inverse is large, so it is not copied.

    `by_slides` holds, for other dense equations of the same unknowns, the products of their
    matrices with `free` (t, k).
    """

    row: cp.Constraint
    inverse: Array
    values: csr_array
    free: Array
    by_slides: Mapping[cp.Constraint, Array]
    loaded: Integers

    @property
    def size(self) -> int:
        """Number of the new unknowns."""
        return len(self.loaded) + int(self.free.shape[1])

    def values_of(self, x: Array) -> Array:
        """The `z[defined]` of new unknowns."""
        return np.asarray(self.values @ x[: len(self.loaded)])

    def unknowns(self, x: Array) -> Array:
        """The `z[of]` of new unknowns."""
        slides = x[len(self.loaded) :]
        return np.asarray(self.inverse @ self.values_of(x) + self.free @ slides)

    def rows(self, chosen: Integers) -> Array:
        """The rows of the matrix with `z[of] = matrix @ x` for chosen entries."""
        return self._of_x(self.inverse[chosen], self.free[chosen])

    def moved(self, matrix: Array, by_slides: Array) -> Array:
        """The `matrix @ z[of]` as a matrix of x; `by_slides` is its product with `free`."""
        return self._of_x(matrix @ self.inverse, by_slides)

    def _of_x(self, by_forces: Array, by_slides: Array) -> Array:
        return np.hstack([(self.values.T @ by_forces.T).T, by_slides])

    def work(self, off: Array) -> Array:
        """The work of `off` on the `z[of]` due to each of the y."""
        return np.asarray(self.values.T @ (self.inverse @ off))


class Compiled:
    """A problem `min cost @ z` over the z whose slacks are in cones, as cvxpy compiles it.

    The slacks are `right - matrix @ z`. The first `zero` of them are zero, the next `nonneg` are
    >= 0, and cones `|s[1:]| <= s[0]` of the sizes `soc` follow. The values of a variable begin in z
    at `columns[its id]`.

    Equations `x == Constant @ y` of two variables are `blocks`. To keep dense matrices out of
    cvxpy, it compiles `x == 0` and `y == 0` in place of them; these are the first `sparse_zero`
    rows. `read` reads the values of the parameters, and compiles a large problem anew for them.
    """

    def __init__(self, problem: cp.Problem) -> None:
        self.problem = problem
        self._dense = _dense_rows(problem)
        dense_ids = {row.id for row in self._dense}
        others = [row for row in problem.constraints if row.id not in dense_ids]
        self._parts = [
            part == 0 for row in self._dense for part in (row.args[0], row.args[1].args[1])
        ]
        self._skeleton = cp.Problem(problem.objective, [*self._parts, *others])
        unknowns = sum(variable.size for variable in self._skeleton.variables())
        entries = sum(parameter.size for parameter in self._skeleton.parameters())
        # cvxpy keeps a column for each pair of unknown and entry of a parameter. Above this number
        # of pairs its tables are larger than the dense matrices, and it is faster to compile the
        # problem anew for other values of the parameters.
        most_pairs = 3_000_000
        self._reads_constants = unknowns * entries > most_pairs
        self._values: list[Array] | None = None
        for variable in problem.variables():
            # cvxpy copies values to unknowns that it adds, and raises an error for NaN.
            if variable.value is not None and not np.isfinite(variable.value).all():
                variable.save_value(None)
        self.read()
        self.blocks = list(self._blocks())
        self.sparse_zero = sum(part.size for part in self._parts)

    def _blocks(self) -> Iterator[Block]:
        """The dense equations, with the places of their sides in the compiled matrix."""
        end = 0
        for row, x, y in zip(self._dense, self._parts[::2], self._parts[1::2], strict=True):
            rows = slice(end, end + x.size)
            sources = slice(rows.stop, rows.stop + y.size)
            end = sources.stop
            yield Block(
                row,
                matrix=np.asarray(row.args[1].args[0].value),
                defined=self.matrix[rows].indices.astype(int),
                of=self.matrix[sources].indices.astype(int),
                rows=rows,
                sources=sources,
                sign=float(self.matrix.data[self.matrix.indptr[rows.start]]),
            )

    def read(self) -> None:
        """Read the values of all parameters, if they differ from those that were read last."""
        values = [
            parameter.value.toarray() if issparse(parameter.value) else np.array(parameter.value)
            for parameter in self._skeleton.parameters()
        ]
        if self._values is not None and all(map(np.array_equal, values, self._values)):
            return
        self._values = None  # until cvxpy has compiled them without an error
        data, self._chain, self._inverse = self._skeleton.get_problem_data(
            _SOLVER,
            enforce_dpp=not self._reads_constants,
            ignore_dpp=self._reads_constants,
            canon_backend=backend(self._skeleton),
            solver_opts={},
        )
        self._values = values
        self.matrix = csr_array(data["A"])
        self.matrix.eliminate_zeros()
        self.right = np.asarray(data["b"])
        self.cost = np.asarray(data["c"])
        self.zero = int(data["dims"].zero)
        self.nonneg = int(data["dims"].nonneg)
        self.soc = [int(size) for size in data["dims"].soc]
        self.columns = data["param_prob"].var_id_to_col

    @property
    def sizes(self) -> Integers:
        """Sizes of the cones, the linear ones, of size 1, first."""
        return np.concatenate([np.ones(self.nonneg, dtype=int), np.array(self.soc, dtype=int)])

    def place(self, variable: cp.Variable) -> slice:
        """The place of the values of a variable in z."""
        first = int(self.columns[variable.id])
        return slice(first, first + variable.size)

    def in_order(self, values: Mapping[cp.Variable, Any]) -> Array:
        """Values of variables, one number or one for each entry, in the order of z; 0 without."""
        z = np.zeros(len(self.cost))
        for variable, value in values.items():
            if variable.id in self.columns:
                entries = np.broadcast_to(value, variable.shape)
                z[self.place(variable)] = np.ravel(entries, order="F")
        return z

    def whole(self, y: Array) -> Array:
        """Complete multipliers in place; those of the rows of `z[of]` follow from their blocks."""
        for block in self.blocks:
            y[block.sources] = -(block.matrix.T @ y[block.rows])
        return y

    def violation(self, z: Array, units: Array) -> float:
        """Largest violation of a row by the values z, relative to the sizes of its terms.

        In these sizes each unknown has at least its unit.
        """
        terms = np.abs(self.matrix) @ np.maximum(np.abs(z), units) + np.abs(self.right)
        return self._largest(z, self.right, terms, np.zeros_like(terms))

    def leaving(self, z: Array, sizes: Array, rounding: float) -> float:
        """Largest violation of a row by a direction, beyond rounding, relative to its terms.

        The values of the direction are sums of terms of these `sizes`, and `rounding` is the
        rounding of such a sum relative to the sizes.
        """
        terms = np.abs(self.matrix)
        rounded = rounding * (terms @ sizes)
        return self._largest(z, np.zeros_like(self.right), terms @ np.abs(z), rounded)

    def _largest(self, z: Array, right: Array, terms: Array, rounding: Array) -> float:
        """Largest violation of a row for this right side, as in `violation` and `leaving`."""
        s = right - self.matrix @ z
        for block in self.blocks:
            # Dense equations hold by substitution; the check of the contact law finds their errors.
            s[block.rows] = 0.0
            s[block.sources] = 0.0
        zero = self.zero
        heads = zero + np.cumsum(self.sizes) - self.sizes
        tails = s.copy()
        tails[heads] = 0.0
        off_cones = np.sqrt(np.add.reduceat(tails**2, heads)) - s[heads]
        off = np.r_[np.abs(s[:zero]), off_cones]
        terms = np.r_[terms[:zero], np.add.reduceat(terms, heads)]
        rounding = np.r_[rounding[:zero], np.add.reduceat(rounding, heads)]
        return float(np.max((off - rounding) / np.where(terms > 0, terms, 1.0), initial=0.0))

    def outside(self, y: Array) -> Array:
        """Distances of the multipliers of each row or cone from the dual cone.

        The distance of a cone is at its first row.
        """
        linear = slice(self.zero, self.zero + self.nonneg)
        heads = linear.stop + np.cumsum([0, *self.soc])[:-1]
        excess = np.zeros(len(y))
        excess[linear] = -y[linear]
        if len(heads):
            tails = y.copy()
            tails[: linear.stop] = 0.0
            tails[heads] = 0.0
            excess[heads] = np.sqrt(np.add.reduceat(tails**2, heads)) - y[heads]
        return np.maximum(excess, 0.0)

    def save(self, z: Array, y: Array) -> None:
        """Put an answer into the variables and the multipliers of the rows of the problem."""
        solution = SimpleNamespace(
            x=z,
            z=y,
            status="Solved",
            obj_val=float(self.cost @ z),
            obj_val_dual=0.0,
            solve_time=0.0,
            iterations=0,
        )
        self._skeleton.unpack_results(solution, self._chain, self._inverse)
        for row, part in zip(self._dense, self._parts[::2], strict=True):
            row.save_dual_value(part.dual_value)
        values = {variable.id: variable.value for variable in self.problem.variables()}
        duals = {
            part.id: part.value for row in self.problem.constraints for part in row.dual_variables
        }
        value = float(self.problem.objective.value)
        self.problem.unpack(Solution(cp.OPTIMAL, value, values, duals, {}))

    def save_multipliers(self, y: Array) -> dict[int, float]:
        """Put multipliers into the rows of the problem; return the largest of each by its id."""
        self.save(np.zeros(len(self.cost)), y)
        return {
            row.id: max(float(np.abs(part.value).max(initial=0.0)) for part in row.dual_variables)
            for row in self.problem.constraints
        }


def _dense_rows(problem: cp.Problem) -> list[cp.Constraint]:
    """Dense equations of a problem, at most one for each variable that they define.

    A variable that one of these equations defines is on the right side of none of them.
    """
    by_variable = dict[int, cp.Constraint]()
    for row in problem.constraints:
        if _is_dense(row):
            by_variable.setdefault(row.args[0].variables()[0].id, row)
    sources = {variable.id for row in by_variable.values() for variable in row.args[1].variables()}
    chosen = {row.id for defined, row in by_variable.items() if defined not in sources}
    return [row for row in problem.constraints if row.id in chosen]


@dataclass(frozen=True)
class Proof:
    """The bound of an objective to be maximised that multipliers prove.

    `bound` is an upper bound of the `value`, up to the error `defect`, because the multipliers
    balance only up to rounding. The error holds for all z of the size of the solution, or of their
    units.
    """

    value: float
    bound: float
    defect: float
    unit: float

    @property
    def gap(self) -> float:
        """Distance of the bound from the value plus the defect, relative to the size of the value.

        This size is at least a thousandth of the unit.
        """
        size = max(abs(self.value), FLOOR * self.unit)
        return (abs(self.bound - self.value) + self.defect) / size


def proof(compiled: Compiled, z: Array, y: Array, units: Array, unit: float) -> Proof:
    """The bound that multipliers in their cones prove by weak duality on the compiled program.

    It is an upper bound if the problem maximises and a lower one if it minimises. The problem's
    objective has its value at z.
    """
    sense = -1.0 if isinstance(compiled.problem.objective, cp.Maximize) else 1.0
    cost = float(compiled.cost @ z)
    constant = float(compiled.problem.objective.value) - sense * cost
    defect = float(np.abs(compiled.matrix.T @ y + compiled.cost) @ np.maximum(np.abs(z), units))
    bound = constant - sense * float(compiled.right @ y)
    return Proof(constant + sense * cost, bound, defect, unit)


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
    """Whether an expression is a variable, or distinct entries of a variable.

    They may stand in the order of its columns, or be chosen by a matrix of zeros and ones.
    """
    while isinstance(part, (cp.reshape, cp.atoms.affine.binary_operators.MulExpression)):
        if not isinstance(part, cp.reshape) and not _chooses(part.args[0]):
            return False
        part = part.args[-1]
    return isinstance(part, cp.Variable)


def _chooses(factor: cp.Expression) -> bool:
    """Whether a factor is a constant matrix of zeros and ones that chooses entries, each once."""
    if not isinstance(factor, cp.Constant) or factor.ndim != 2:
        return False
    matrix = csr_array(factor.value)
    return bool(
        (np.diff(matrix.indptr) == 1).all()
        and (matrix.data == 1).all()
        and len(np.unique(matrix.indices)) == matrix.nnz
    )


def by_inverse(
    row: cp.Constraint,
    others: Sequence[cp.Constraint],
    free: Array,
    inverse: Array,
    unit: Array,
    sizes: Array,
) -> Change:
    """The change of a dense equation of a square matrix to its values and its null vectors.

    The values do no work on the null vectors `free` (t, k): the values of k rows follow from the
    other rows. `others` are dense equations of the same unknowns. The first of them does not change
    by the null vectors. For all others the null vectors are rotated, so that each either changes
    them or does not. `unit` (t,) are the units of the values, `sizes` (k,) those of the null
    vectors.
    """
    count = free.shape[1]
    basis, loaded = _balanced(unit[:, None] * free)
    matrices = {other: np.asarray(other.args[1].args[0].value) for other in others}
    turned = free * sizes
    feeling = np.vstack([np.zeros((0, len(unit))), *(matrices[other] for other in others[1:])])
    if count and len(feeling):
        turned = turned @ svd(feeling @ turned)[2].T
    largest = np.abs(turned).max(axis=0, initial=0.0)
    by_slides = dict[cp.Constraint, Array]()
    for other, matrix in matrices.items():
        moved = np.zeros((len(matrix), count)) if other is others[0] else matrix @ turned
        unmoved = np.abs(moved).max(axis=0, initial=0.0) <= CONDENSATION * largest
        moved[:, unmoved] = 0.0
        by_slides[other] = moved
    return Change(row, inverse, csr_array(basis.multiply(unit[:, None])), turned, by_slides, loaded)


def _balanced(free: Array) -> tuple[csr_array, Integers]:
    """Basis (t, t - k) of the values that do no work on `free` (t, k), and the rows of its units.

    Each basis vector is 1 in one of these rows, 0 in the other rows, and balanced in k further
    rows.
    """
    t, count = free.shape
    pivots = qr(free.T, mode="r", pivoting=True)[1] if count else np.arange(t)
    balancing = pivots[:count]
    loaded = np.sort(pivots[count:])
    balance = -np.linalg.solve(free[balancing].T, free[loaded].T)
    at, which = np.nonzero(np.abs(balance) > ROUNDING)
    data = np.r_[np.ones(len(loaded)), balance[at, which]]
    places = np.r_[loaded, balancing[at]], np.r_[: len(loaded), which]
    return csr_array((data, places), shape=(t, len(loaded))), loaded
