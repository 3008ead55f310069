"""The program of loose nodes, which bounds the limits of many sets of open nodes at once.

A loose node has forces like a closed node, and at each corner also its own slip and gap. In a
branch some loose nodes are open, some are closed, and the others may be open or closed (theory,
"The search of the open nodes"). Branches differ only in the bounds of their unknowns: an open node
has no pressure, and a closed node no motion of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ...base import FAR, RESIDUAL, Array, Booleans, Integers
from ...solve.answer import error_of_contradiction
from ...solve.arrays import LINEAR, Arrays, Rows, rows_of
from ...solve.solvers import CUT_OFF, INFEASIBLE, OPTIMAL, SOCP, WarmProgram, run, solver_order
from ..program.assembled import at_corners, stuck
from ..program.question import Question
from ..program.rest_program import RestProgram

# Numbers of the programs of branches.

# Largest value of the goal in the programs of branches, relative to `LooseNodes.largest`.
_MOST = 100.0
# A bound counts as infinite if it is within this relative distance of the largest value.
_AT_MOST = 1e-6
# A loose node is open if its pressure is below this share of its unit. It is closed if its own
# motion is below this share of its unit. If all loose nodes are open or closed, the solution
# belongs to one set.
_DECIDED = 1e-6


@dataclass(frozen=True, eq=False)
class Branch:
    """All sets in which some loose nodes are open, some are closed, and the others may be either.

    A shakedown limit has one set of open nodes, and a design has one for each of its S scenarios.
    `bound` is a proven upper bound of the limits of all sets.
    """

    opens: Booleans  # (S, n)
    closes: Booleans  # (S, n)
    bound: float = np.inf

    @property
    def undecided(self) -> Booleans:
        """(S, n) loose nodes that are open in some sets of the branch, and closed in others."""
        return ~(self.opens | self.closes)

    def divided(self, index: int, open_first: bool) -> list[Branch]:
        """Two branches: in one the node of this flat index is open, in the other it is closed.

        The branch that is to be solved first comes last.
        """
        here = np.zeros_like(self.opens)
        here.flat[index] = True
        opened = replace(self, opens=self.opens | here)
        closed = replace(self, closes=self.closes | here)
        return [closed, opened] if open_first else [opened, closed]


class Relaxed(NamedTuple):
    """The bound of a branch, and the motions and pressures of loose nodes in its solution."""

    bound: float
    # (S, n) largest own motion and largest pressure of each loose node over the corners, in their
    # units; None if the program has no solution.
    sizes: tuple[Array, Array] | None = None


def loose(question: Question, nodes: Integers) -> RestProgram:
    """The program of the load factors of states of rest in which some nodes are loose.

    The slip is not bounded, because the slip bound does not hold for open nodes.
    """
    slips = np.zeros(len(question.r1), dtype=int)
    program = at_corners(
        replace(question, slip_bound=None), None, *own_motions([question], slips, nodes)
    )
    return stuck(program, every=True)


def own_motions(
    questions: Sequence[Question], slip_of: Integers, nodes: Integers
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Units and effects of the unknown `own`: the motions of loose nodes at each instant.

    The nodes are closed in all questions. `slip_of` (I,) is the question of each instant.
    """
    system = questions[0].system
    axes = system.tangents + 1
    entries = np.concatenate([nodes + axis * system.nodes for axis in range(axes)])
    moved = [question.forces_of(system.S[:, entries].T).T for question in questions]  # (M, axes n)
    count = len(slip_of)
    effects = np.zeros((count, len(moved[0]), count, len(entries)))
    effects[np.arange(count), :, np.arange(count)] = np.array(moved)[slip_of]
    unit = _units(questions[0])[entries] / system.own_stiffness[entries]
    return {"own": np.tile(unit, count)}, {"own": effects}


def _units(question: Question) -> Array:
    """(M,) units of the forces."""
    shear = np.tile(question.shear_unit, question.system.tangents)
    return np.concatenate([shear, question.node_unit])


class LooseNodes:
    """The programs of the branches, for their bounds.

    Parameters
    ----------
    program
        The program with the unknown `own` of `own_motions` and all rows.
    nodes
        (n,) the loose nodes.
    largest
        A large value of the goal, which is maximised. A bound far above this value counts as
        infinite. While many nodes are loose, the goal may grow without end.

    Attributes
    ----------
    shape
        (S, n): each of the S slips of the program has a set of open nodes.
    """

    def __init__(self, program: RestProgram, nodes: Integers, largest: float) -> None:
        question = program.question
        self._most = _MOST * largest
        if np.isfinite(largest):
            program.row("most", {program.goal: -1.0}, self._most)
        count, n, axes = len(program.start), len(nodes), question.system.tangents + 1
        by_instant = count, axes, n
        entries = np.concatenate([nodes + axis * question.system.nodes for axis in range(axes)])
        at = np.repeat(np.arange(count), len(entries))
        of_entry = np.tile(entries, count)
        force = program.force(at, of_entry), np.ones(len(at))
        unit = _units(question)[of_entry]
        forces = rows_of("loose", LINEAR, [[force]], np.zeros(len(at)), unit, at, of_entry)
        program.rows.append(forces)

        self._arrays = program.arrays()
        self._matrix = self._arrays.matrix
        self._unit = program.place.unit
        # A proof that a branch has no solution must hold for all values of the goal that count.
        # With little friction, such values are far above the unit of the goal.
        self._far = FAR
        if np.isfinite(largest):
            self._far = max(FAR, self._most / self._unit)
        # The places of the own motions among the unknowns. The lifts are last.
        self._own = np.arange(len(self._arrays.cost))[program.named["own"]].reshape(by_instant)
        self._set = program.response_of  # number of the set of each instant
        # At the first instant of each slip, loose nodes have no own slip: there, the common slip is
        # their slip.
        self.shape = len(program.questions), n
        self._first = [int((self._set == number).argmax()) for number in range(self.shape[0])]
        of_forces, self._node = self._rows_of_nodes(program, forces, nodes)
        # The places of the forces among the rows. The normal forces are last.
        self._forces = of_forces.reshape(by_instant)
        # A linear program is kept in HiGHS, where only its bounds change.
        is_linear = self._arrays.sizes.max(initial=1) == 1
        self._warm = WarmProgram(self._arrays) if is_linear else None

    def _rows_of_nodes(
        self, program: RestProgram, forces: Rows, nodes: Integers
    ) -> tuple[Integers, Integers]:
        """The numbers of the rows `forces`, and the loose node of each row of the contact law.

        The loose node is -1 for rows of nodes that are not loose, and for all other rows.
        """
        n = len(nodes)
        index = np.full(program.question.system.nodes, -1)
        index[nodes] = np.arange(n)
        of_forces = np.zeros(0, dtype=int)
        node_of_row = np.full(len(self._matrix), -1)
        for rows, part in program.form.stacked.parts:
            numbers = program.form.slides + np.arange(part.start, part.stop)
            if rows is forces:
                of_forces = numbers
            elif len(numbers) and rows.instants[0] >= 0:
                loose = index[rows.nodes]
                loose = np.where(loose < 0, -1, self._set[rows.instants] * n + loose)
                node_of_row[numbers] = np.repeat(loose, rows.sizes)
        return of_forces, node_of_row

    def solve(self, branch: Branch, above: float) -> Relaxed:
        """The bound of a branch; inf if no solver proves one.

        A solver may stop once it has proven that the bound is not above the value `above`.
        """
        still = np.zeros(len(self._arrays.cost), dtype=bool)
        still[self._own] = branch.closes[self._set][:, None]
        still[self._own[self._first, :-1]] = True
        zero = np.zeros(len(self._matrix), dtype=bool)
        zero[self._forces] = branch.opens[self._set][:, None]
        zero[: self._arrays.zero] = True
        outcome = ""
        if self._warm is not None:
            outcome, x, y = self._solved_warm(self._warm, still, zero, above)
        if outcome not in (OPTIMAL, CUT_OFF, INFEASIBLE):
            # The program is not linear, or HiGHS gave it up.
            outcome, x, y = self._solved(branch, still, zero)
        if outcome == INFEASIBLE:
            unbalanced = self._unbalanced(np.zeros(len(still)), y, still).sum()
            lack = -float(self._arrays.right @ y)
            error = error_of_contradiction(unbalanced, lack, self._far)
            return Relaxed(-np.inf if error <= RESIDUAL else np.inf)
        if outcome not in (OPTIMAL, CUT_OFF):
            return Relaxed(np.inf)
        unbalanced = self._unbalanced(self._arrays.cost, y, still)
        bound = float(self._arrays.right @ y + unbalanced @ np.maximum(np.abs(x), 1.0))
        bound *= self._unit
        if bound >= self._most * (1 - _AT_MOST):
            bound = np.inf
        return Relaxed(bound) if outcome == CUT_OFF else self._solution(bound, x)

    def _solution(self, bound: float, x: Array) -> Relaxed:
        """A bound, with the largest motions and pressures of loose nodes in a solution."""
        rows = self._forces[:, -1]
        pressures = np.abs(self._arrays.right[rows] - self._matrix[rows] @ x)
        motion = np.zeros(self.shape)
        pressure = np.zeros_like(motion)
        np.maximum.at(motion, self._set, np.abs(x[self._own]).max(axis=1))
        np.maximum.at(pressure, self._set, pressures)
        return Relaxed(bound, (motion, pressure))

    def _unbalanced(self, cost: Array, y: Array, still: Booleans) -> Array:
        """(X,) the errors with which the multipliers of the rows balance a cost.

        An unknown that is fixed at zero needs no balance. A lift, which is >= 0, needs balance only
        from one side.
        """
        rest = cost + self._matrix.T @ y
        lifts = self._own[:, -1]
        rest[lifts] = np.minimum(rest[lifts], 0.0)
        return np.where(still, 0.0, np.abs(rest))

    def _solved_warm(
        self, program: WarmProgram, still: Booleans, zero: Booleans, above: float
    ) -> tuple[str, Array, Array]:
        """Outcome, x and multipliers of a branch of a linear program."""
        rows, own = self._forces.ravel(), self._own.ravel()
        right = self._arrays.right[rows]
        ends = np.where(zero[rows], 0.0, np.inf)
        program.bound_rows(rows, right - ends, right + ends)
        most = np.where(still, 0.0, np.inf)
        least = -most
        least[self._own[:, -1]] = 0.0
        program.bound_columns(own, least[own], most[own])
        outcome, x, y = program.solve(-above / self._unit)
        # Multipliers of inequalities must not be negative, and rows without bounds have multipliers
        # of zero.
        y = np.where(zero, y, np.maximum(y, 0.0))
        y[rows[~zero[rows]]] = 0.0
        return outcome, x, y

    def _solved(self, branch: Branch, still: Booleans, zero: Booleans) -> tuple[str, Array, Array]:
        """Outcome, x and multipliers of a branch, which is solved anew.

        Open nodes have no force, so their rows need no cone.
        """
        arrays, matrix = self._arrays, self._matrix
        # The rows that are left: first the linear rows, then the cones.
        left = ~zero & ~np.isin(self._node, np.flatnonzero(branch.opens))
        left[self._forces] = False
        lifts = self._own[:, -1].ravel()
        above_zero = -np.eye(len(still))[lifts[~still[lifts]]]
        count, zeros = len(above_zero), int(zero.sum())
        program = Arrays(
            sparse=csr_array(np.vstack([matrix[zero], above_zero, matrix[left]])[:, ~still]),
            block=np.zeros((0, int((~still).sum()))),
            right=np.r_[arrays.right[zero], np.zeros(count), arrays.right[left]],
            cost=arrays.cost[~still],
            zero=zeros,
            sizes=np.r_[np.ones(count, dtype=int), arrays.sizes[left[arrays.heads]]],
        )
        x, y = np.zeros(len(still)), np.zeros(len(left))
        for name in solver_order(None, SOCP):
            outcome, moved, multipliers = run(program, name, -np.inf)
            if outcome in (OPTIMAL, INFEASIBLE):
                x[~still] = moved
                multipliers = program.admissible(multipliers)
                y[zero], y[left] = multipliers[:zeros], multipliers[zeros + count :]
                break
        return outcome, x, y


class Branches:
    """Branch and bound: the branches that are left, and the bound of all sets.

    Parameters
    ----------
    loose
        The programs of the branches.
    wanted
        Function that returns the value above which a set is still of interest.
    compare
        Function that computes the value for given open nodes (S, n), and returns a bound of this
        value.
    """

    def __init__(
        self,
        loose: LooseNodes,
        wanted: Callable[[], float],
        compare: Callable[[Booleans], float],
    ) -> None:
        none = np.zeros(loose.shape, dtype=bool)
        self.left = [Branch(none, none)]
        self._done = -np.inf
        self._loose = loose
        self._wanted = wanted
        self._compare = compare

    @property
    def bound(self) -> float:
        """The value that no set exceeds."""
        return max([self._done, *(branch.bound for branch in self.left)])

    def step(self) -> None:
        """Bound one branch. If some of its sets may have a value of interest, divide the branch."""
        # The branch stays in the list until it is replaced, so that an interrupt finds it there.
        self.left[-1:] = self._parts(self.left[-1])

    def _parts(self, branch: Branch) -> list[Branch]:
        """The two parts of a branch; an empty list if none of its sets is of interest any more."""
        relaxed = Relaxed(branch.bound)
        if branch.bound > self._wanted():
            relaxed = self._loose.solve(branch, self._wanted())
            branch = replace(branch, bound=min(branch.bound, relaxed.bound))
        bound = branch.bound
        if bound > self._wanted():
            undecided = branch.undecided
            opens = branch.opens
            index = int(undecided.argmax())
            decided = not undecided.any()
            if relaxed.sizes is not None:
                motion, pressure = relaxed.sizes
                opens = np.where(undecided, pressure <= motion, opens)
                between = np.where(undecided, np.minimum(motion, pressure), 0.0)
                decided = bool(between.max() <= _DECIDED)
                index = int(np.where(undecided, motion * pressure, -1.0).argmax())
            if decided:
                of_set = self._compare(opens)
                bound = bound if undecided.any() else min(bound, of_set)
            if undecided.any() and bound > self._wanted():
                return branch.divided(index, open_first=bool(opens.flat[index]))
        self._done = max(self._done, bound)
        return []
