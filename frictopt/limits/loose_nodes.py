"""The program of loose nodes, which bounds the limits of many sets of open nodes at once.

A loose node has forces as a closed node, and at each corner also a slip and a gap of its own. In a
branch some loose nodes are open, some closed, and the others open or closed. The program is
compiled once for all branches (theory, "Proof for given nodes").
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import cvxpy as cp
import numpy as np

from ..base import Array, Booleans, Integers
from ..contact import contact_law
from ..errors import SolverError
from ..solve.fixable import Fixable
from .models import constant, loose, loosened, stuck, times, unknowns
from .programs import listed_corners, listed_rows
from .question import Question


@dataclass(frozen=True)
class BranchSettings:
    """Numbers of the branch and bound."""

    # Smallest relative gain of a limit that counts; a smaller one may be rounding.
    gain: float = 1e-7
    # A bound counts if it is this close to the value of its program. A worse one, too, is proven,
    # but its branch would have to be divided further.
    tolerance: float = 1e-7
    # Price of an excess of one mean friction bound, in units of the load. Any price gives a valid
    # bound; with too small a price branches without a solution are divided further.
    price: float = 1e3
    # Load factor up to which branches have bounds, relative to the limit or to the unit of the
    # load. While many nodes are loose, the load factor may grow without end.
    most: float = 100.0
    # A loose node is open if its pressure is below this share of its unit. It is closed if its own
    # motion is below this share. Then the solution is the state of one set.
    decided: float = 1e-6


BRANCHES = BranchSettings()


@dataclass(frozen=True, eq=False)
class Branch:
    """All sets in which some loose nodes are open, some closed, and the others open or closed.

    `bound` is a proven upper bound of their limits.
    """

    opens: Booleans  # (n,)
    closes: Booleans  # (n,)
    bound: float = np.inf
    # Where the solution of a linear program starts.
    basis: Any = None

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
    residual: float
    # (n,) largest own motions and largest pressures over the corners, in their units; None without
    # a solution that passes the checks.
    motion: Array | None = None
    pressure: Array | None = None
    # By how much the solution violates the rows, in mean friction bounds.
    excess: float = np.inf
    basis: Any = None


class LooseNodes:
    """The program with loose nodes, compiled once for all branches."""

    def __init__(
        self, question: Question, nodes: Integers, limit: float, solver: str | None
    ) -> None:
        system = question.system
        tangents = system.tangents
        self._solver = solver
        self._nodes = nodes
        self._corners = listed_corners(question)
        self._opens = cp.Parameter(len(nodes), nonneg=True, name="opens")
        self._closes = cp.Parameter(len(nodes), nonneg=True, name="closes")
        self._lifts = {k: cp.Variable(len(nodes), name=f"lift[{k}]") for k in self._corners}
        # The common slip is the slip at the first corner.
        self._slips = {
            k: cp.Variable(tangents * len(nodes), name=f"own_slip[{k}]") for k in self._corners[1:]
        }

        x = unknowns(system.slip_shape, range(len(question.r1)))
        f = cp.Parameter(system.nodes, nonneg=True, name="f")
        self._excess = cp.Variable(name="excess")
        force = times(self._excess, constant(question.mean_bound, "mean_bound"))
        least_gap = -times(self._excess, constant(question.clearance, "clearance"))
        law = contact_law(system, question.friction)
        program = listed_rows(
            question,
            x,
            f,
            friction=lambda x, corners: stuck(x, f, corners, force, law, least_gap),
            more={k: self._terms(question, k) for k in self._corners},
        )
        program.rows += loose(
            program.x,
            nodes.tolist(),
            self._slips,
            self._lifts,
            least_gap,
            self._opens,
            self._closes,
        )
        self._set(Branch(np.zeros(len(nodes), bool), np.zeros(len(nodes), bool)))
        slip_unit = question.shear_unit[nodes] / system.own_stiffness[nodes]
        self._lift_unit = question.node_unit[nodes] / system.own_stiffness[-system.nodes :][nodes]
        self._slip_unit = np.tile(slip_unit, tangents)
        units: dict[cp.Variable, Any] = dict.fromkeys(self._lifts.values(), self._lift_unit)
        units |= dict.fromkeys(self._slips.values(), self._slip_unit)
        units[self._excess] = 1.0
        price = BRANCHES.price * question.load_unit
        self._most = BRANCHES.most * max(limit, question.load_unit)
        goal = loosened(program.x, self._excess, price, self._most, program.rows)
        self._program = program.compiled(goal, question.load_unit, units)
        self._pressure_unit = question.node_unit[nodes]
        # In the plane HiGHS keeps one program, unless the user asks for another solver.
        self._warm: Fixable | None = None
        if tangents == 1 and solver in (None, "HIGHS"):
            self._warm = self._program.chain.fixable(self._entries)

    @property
    def _entries(self) -> list[tuple[cp.Variable, Integers]]:
        """The pressures, the gaps and the slips of loose nodes, and the excess."""
        every = np.arange(len(self._nodes))
        pressures = [(self._program.x.p[k], self._nodes) for k in self._corners]
        lifts = [(lift, every) for lift in self._lifts.values()]
        slips = [(slip, every) for slip in self._slips.values()]
        return [*pressures, *lifts, *slips, (self._excess, np.zeros(1, dtype=int))]

    def _terms(self, question: Question, k: int) -> list[cp.Expression]:
        """Terms of q, p and the gaps of open nodes at a corner, by own motions of loose nodes."""
        system = question.system
        count = system.nodes
        tangents = system.tangents
        places_of_slips = np.concatenate([self._nodes + t * count for t in range(tangents)])
        parts = [(self._lifts[k], self._nodes + tangents * count, "n")]
        if k in self._slips:
            parts.append((self._slips[k], places_of_slips, "t"))
        rows_of_gaps = np.flatnonzero(question.open_nodes) + tangents * count
        terms = list[list[cp.Expression]]()
        for unknown, columns, name in parts:
            S = question.S[:, columns]
            effects = [(S[:-count], f"A_{name}"), (S[-count:], f"B_{name}")]
            if question.compliance is not None:
                W = -(question.compliance[rows_of_gaps] @ system.S[:, columns])
                effects.append((W, f"W_{name}"))
            terms.append([constant(matrix, symbol) @ unknown for matrix, symbol in effects])
        q, *gaps = (sum(term[1:], term[0]) for term in zip(*terms, strict=True))
        if tangents > 1:
            q = cp.reshape(q, system.slip_shape, order="F")
        return [q, *gaps]

    def _set(self, branch: Branch) -> None:
        self._opens.value = branch.opens.astype(float)
        self._closes.value = branch.closes.astype(float)

    def solve(self, branch: Branch, above: float) -> Relaxed:
        """The bound of a branch; inf if no solver's answer passes the checks.

        A solver may stop once it knows that the bound is not `above` a load factor.
        """
        if self._warm is not None:
            return self._solved_warm(self._warm, branch, above)
        self._set(branch)
        try:
            answer, _ = self._program.chain.solve(
                partial(self._checked, above),
                self._solver,
                above=above,
                tolerance=BRANCHES.tolerance,
            )
        except SolverError:
            return Relaxed(np.inf, np.inf)
        return answer

    def _solved_warm(self, warm: Fixable, branch: Branch, above: float) -> Relaxed:
        """The bound of a branch in the plane, by a program that differs in bounds alone."""
        opened = np.tile(branch.opens, len(self._corners))
        closed = np.tile(branch.closes, len(self._lifts) + len(self._slips))
        fixed = np.r_[opened, closed, False]
        bound, entries, basis = warm.solve(fixed, branch.basis, above)
        if entries is None:
            return Relaxed(self._counted(bound), np.inf)
        corners = len(self._corners)
        ends = np.arange(len(self._nodes), len(entries), len(self._nodes))
        *parts, excess = np.split(entries, ends)
        pressures = parts[:corners]
        lifts = parts[corners : 2 * corners]
        slips = parts[2 * corners :]
        counted = self._counted(bound)
        relaxed = self._relaxed(counted, 0.0, pressures, lifts, slips, float(excess[0]))
        return replace(relaxed, basis=basis)

    def _checked(self, above: float) -> Relaxed:
        proof = self._program.chain.proof
        bound = self._counted(proof.bound + proof.defect)
        # A bound that ends the branch need not be close to the value of the program.
        residual = 0.0 if bound <= above else proof.gap
        return self._relaxed(
            bound,
            residual,
            [self._program.x.p[k].value[self._nodes] for k in self._corners],
            [lift.value for lift in self._lifts.values()],
            [slip.value for slip in self._slips.values()],
            float(self._excess.value),
        )

    def _counted(self, bound: float) -> float:
        """A bound; inf if it is the largest load factor of the program."""
        return np.inf if bound >= self._most * (1 - BRANCHES.gain) else bound

    def _relaxed(
        self,
        bound: float,
        residual: float,
        pressures: list[Array],
        lifts: list[Array],
        slips: list[Array],
        excess: float,
    ) -> Relaxed:
        """The bound of a branch, with the solution in units."""
        motion = np.max(lifts, axis=0) / self._lift_unit
        for slip in slips:
            sizes = np.abs(slip / self._slip_unit).reshape(-1, len(self._nodes))
            motion = np.maximum(motion, sizes.max(axis=0))
        pressure = np.max(pressures, axis=0) / self._pressure_unit
        return Relaxed(bound, residual, motion, pressure, excess)
