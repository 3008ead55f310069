"""The program of loose nodes, which bounds the limits of many sets of open nodes at once.

A loose node has forces as a closed node, and at each corner also a slip and a gap of its own. In a
branch some loose nodes are open, some closed, and the others open or closed (theory, "The search of
the open nodes"). Branches differ in bounds alone: an open node has no pressure, and a closed one no
motion of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from ..base import RESIDUAL, Array, Booleans, Integers
from ..solve.arrays import Arrays
from ..solve.rows import LINEAR, rows_of
from ..solve.solvers import CUT_OFF, INFEASIBLE, OPTIMAL, SOCP, WarmProgram, run, solver_order
from .assembled import at_corners, stuck
from .question import Question


@dataclass(frozen=True)
class BranchSettings:
    """Numbers of the programs of branches."""

    # Load factor up to which branches have bounds, relative to the limit or to the unit of the
    # load. While many nodes are loose, the load factor may grow without end.
    most: float = 100.0
    # Relative distance from `most` below which a bound is infinite.
    at_most: float = 1e-6
    # A proof that a branch has no state holds for unknowns up to this number of units.
    far: float = 1e-3 / RESIDUAL


BRANCHES = BranchSettings()


@dataclass(frozen=True, eq=False)
class Branch:
    """All sets in which some loose nodes are open, some closed, and the others open or closed.

    `bound` is a proven upper bound of their limits.
    """

    opens: Booleans  # (n,)
    closes: Booleans  # (n,)
    bound: float = np.inf

    @property
    def undecided(self) -> Booleans:
        """(n,) loose nodes that are open in some sets and closed in other ones."""
        return ~(self.opens | self.closes)

    def divided(self, index: int, open_first: bool) -> list[Branch]:
        """The branch in which a node is open and the one in which it is closed.

        The branch that is to be solved first comes last.
        """
        here = np.arange(len(self.opens)) == index
        opened = replace(self, opens=self.opens | here)
        closed = replace(self, closes=self.closes | here)
        return [closed, opened] if open_first else [opened, closed]


@dataclass(frozen=True, eq=False)
class Relaxed:
    """The bound of a branch, and the motions and pressures of loose nodes in its solution."""

    bound: float
    # (n,) largest own motions and largest pressures over the corners, in their units; None without
    # a solution.
    motion: Array | None = None
    pressure: Array | None = None


class LooseNodes:
    """The programs of the branches, for their bounds.

    A bound of the slip is left out, because open nodes do not have it.
    """

    def __init__(self, question: Question, nodes: Integers, load_factor: float) -> None:
        """`load_factor`: the limit so far."""
        system = question.system
        n, axes, corners = len(nodes), system.tangents + 1, len(question.r1)
        entries = np.concatenate([nodes + axis * system.nodes for axis in range(axes)])
        moved = question.forces_of(system.S[:, entries].T).T  # (M, axes n)
        own = np.zeros((corners, len(moved), corners, axes * n))
        own[np.arange(corners), :, np.arange(corners)] = moved
        node_units = [*[question.shear_unit] * system.tangents, question.node_unit]
        unit = np.concatenate(node_units)[entries]
        program = at_corners(
            replace(question, slip_bound=None),
            None,
            {"own": np.tile(unit / system.own_stiffness[entries], corners)},
            {"own": own},
        )
        stuck(program, every=True)
        self._most = BRANCHES.most * max(load_factor, question.load_unit)
        program.bound("most", "load_factor", -1.0, self._most)
        at = np.repeat(np.arange(corners), len(entries))
        of_entry = np.tile(entries, corners)
        force = program.force(at, of_entry), np.ones(len(at))
        forces = rows_of(
            "loose", LINEAR, [[force]], np.zeros(len(at)), np.tile(unit, corners), at, of_entry
        )
        program.rows.append(forces)

        self._unit = question.load_unit
        self._arrays = program.arrays("load_factor", 1.0)
        self._matrix = self._arrays.matrix.toarray()
        # The own motions among the unknowns, and the forces among the rows: lifts and normal forces
        # last.
        shape = corners, axes, n
        self._own = np.arange(len(self._arrays.cost))[program.named["own"]].reshape(shape)
        self._forces = np.zeros(shape, dtype=int)
        # The loose node of each row of the contact law; -1 for other rows.
        self._node = np.full(len(self._matrix), -1)
        index = np.full(system.nodes + 1, -1)
        index[nodes] = np.arange(n)
        first = program.slides
        for rows in program.stacked.rows:
            of_rows = np.arange(first, first + len(rows.constants))
            first += len(of_rows)
            if rows is forces:
                self._forces = of_rows.reshape(shape)
            elif len(of_rows):
                self._node[of_rows] = np.repeat(index[rows.nodes], rows.sizes)
        # In the plane HiGHS keeps one program, whose bounds change.
        self._warm = self._warm_program() if system.tangents == 1 else None

    def _warm_program(self) -> WarmProgram:
        arrays = self._arrays
        least = np.full(len(arrays.right), -np.inf)
        least[: arrays.zero] = arrays.right[: arrays.zero]
        free = np.full(len(arrays.cost), np.inf)
        return WarmProgram(self._matrix, least, arrays.right, arrays.cost, -free, free)

    def solve(self, branch: Branch, above: float) -> Relaxed:
        """The bound of a branch; inf if no solver proves one.

        A solver may stop once it knows that the bound is not `above` a load factor.
        """
        # The common slip is that of the first corner.
        still = np.zeros(len(self._arrays.cost), dtype=bool)
        still[self._own[:, :, branch.closes]] = True
        still[self._own[0, :-1]] = True
        zero = np.zeros(len(self._matrix), dtype=bool)
        zero[: self._arrays.zero] = True
        zero[self._forces[:, :, branch.opens]] = True
        if self._warm is None:
            outcome, x, y = self._solved(branch, still, zero)
        else:
            outcome, x, y = self._solved_warm(self._warm, still, zero, above)
        if outcome == INFEASIBLE:
            unbalanced = self._unbalanced(np.zeros(len(still)), y, still).sum()
            impossible = unbalanced * BRANCHES.far < -float(self._arrays.right @ y)
            return Relaxed(-np.inf if impossible else np.inf)
        if outcome not in (OPTIMAL, CUT_OFF):
            return Relaxed(np.inf)
        unbalanced = self._unbalanced(self._arrays.cost, y, still)
        bound = float(self._arrays.right @ y + unbalanced @ np.maximum(np.abs(x), 1.0))
        bound *= self._unit
        if bound >= self._most * (1 - BRANCHES.at_most):
            bound = np.inf
        if outcome == CUT_OFF:
            return Relaxed(bound)
        rows = self._forces[:, -1]
        pressure = np.abs(self._arrays.right[rows] - self._matrix[rows] @ x)
        return Relaxed(bound, np.abs(x[self._own]).max(axis=(0, 1)), pressure.max(axis=0))

    def _unbalanced(self, cost: Array, y: Array, still: Booleans) -> Array:
        """(X,) by how much the multipliers of the rows do not balance a cost.

        Unknowns that are zero balance any cost, and lifts a positive one, because they are >= 0.
        """
        rest = cost + self._matrix.T @ y
        lifts = self._own[:, -1]
        rest[lifts] = np.minimum(rest[lifts], 0.0)
        return np.where(still, 0.0, np.abs(rest))

    def _solved_warm(
        self, program: WarmProgram, still: Booleans, zero: Booleans, above: float
    ) -> tuple[str, Array, Array]:
        """Outcome, x and multipliers of a branch in the plane."""
        rows, own = self._forces.ravel(), self._own.ravel()
        right = self._arrays.right[rows]
        ends = np.where(zero[rows], 0.0, np.inf)
        program.bound_rows(rows, right - ends, right + ends)
        most = np.where(still, 0.0, np.inf)
        least = -most
        least[self._own[:, -1]] = 0.0
        program.bound_columns(own, least[own], most[own])
        outcome, x, y = program.solve(-above / self._unit)
        # Multipliers of inequalities are not negative, and those of rows without bounds are zero.
        y = np.where(zero, y, np.maximum(y, 0.0))
        y[rows[~zero[rows]]] = 0.0
        return outcome, x, y

    def _solved(self, branch: Branch, still: Booleans, zero: Booleans) -> tuple[str, Array, Array]:
        """Outcome, x and multipliers of a branch in space, whose program is solved anew.

        Open nodes have no cone, which would hold one point alone.
        """
        arrays, matrix = self._arrays, self._matrix
        left = ~zero & ~np.isin(self._node, np.flatnonzero(branch.opens))
        left[self._forces] = False
        of_cones = np.arange(len(left)) >= arrays.linear
        rows = [np.flatnonzero(part) for part in (zero, left & ~of_cones, left & of_cones)]
        lifts = self._own[:, -1].ravel()
        above_zero = -np.eye(len(still))[lifts[~still[lifts]]]
        parts = [matrix[rows[0]], above_zero, matrix[rows[1]], matrix[rows[2]]]
        right = [
            arrays.right[rows[0]],
            np.zeros(len(above_zero)),
            *map(arrays.right.take, rows[1:]),
        ]
        sizes = [np.ones(len(above_zero) + len(rows[1])), np.full(len(rows[2]) // 3, 3)]
        program = Arrays(
            sparse=csr_array(np.vstack(parts)[:, ~still]),
            block=np.zeros((0, int((~still).sum()))),
            right=np.concatenate(right),
            cost=arrays.cost[~still],
            zero=len(rows[0]),
            sizes=np.concatenate(sizes).astype(int),
        )
        x, y = np.zeros(len(still)), np.zeros(len(left))
        for name in solver_order(None, SOCP):
            outcome, moved, multipliers = run(program, name, -np.inf)
            if outcome in (OPTIMAL, INFEASIBLE):
                x[~still] = moved
                multipliers = program.admissible(multipliers)
                of_lifts = slice(program.zero, program.zero + len(above_zero))
                y[np.concatenate(rows)] = np.delete(multipliers, of_lifts)
                break
        return outcome, x, y
