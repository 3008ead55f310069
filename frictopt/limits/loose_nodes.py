"""The program of loose nodes, which bounds the limits of many sets of open nodes at once.

A loose node has forces as a closed node, and at each corner also a slip and a gap of its own. In a
branch some loose nodes are open, some closed, and the others open or closed (theory, "Proof for
given nodes").
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base import Array, Booleans, Integers
from ..errors import SolverError
from ..solve.rows import EQUATION, LINEAR, rows_of
from ..solve.solvers import CUT_OFF, OPTIMAL, WarmProgram
from .assembled import at_corners, stuck
from .question import Question
from .rest_program import RestProgram
from .solution import Solution, solve


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
    """The program with loose nodes, for the bounds of branches.

    At corner k a loose node has a `lift[k]` and, at all corners but the first, a slip of its own
    beside the common slip. An excess raises all rows of the contact law at a price, so that each
    branch has a solution.
    """

    def __init__(
        self, question: Question, nodes: Integers, limit: float, solver: str | None
    ) -> None:
        self._question = question
        self._nodes = nodes
        self._solver = solver
        system = question.system
        self._lift_unit = question.node_unit[nodes] / system.own_stiffness[-system.nodes :][nodes]
        slip_unit = question.shear_unit[nodes] / system.own_stiffness[nodes]
        self._slip_unit = np.tile(slip_unit, system.tangents)
        self._most = BRANCHES.most * max(limit, question.load_unit)
        # In the plane HiGHS keeps one program, whose bounds change, unless the user asks for
        # another solver.
        self._warm: tuple[RestProgram, WarmProgram, Integers] | None = None
        if system.tangents == 1 and solver in (None, "HIGHS"):
            self._warm = self._warm_program()

    def _program(self, chosen: Booleans, kind: int) -> RestProgram:
        """The program, with rows of a kind for the chosen entries, see `_fixed`."""
        question, nodes = self._question, self._nodes
        system = question.system
        corners, n = len(question.r1), len(nodes)
        tangents = system.tangents
        normal = tangents * system.nodes
        lifts = question.forces_of(system.S[:, normal + nodes].T).T  # (M, n)
        along = np.concatenate([nodes + axis * system.nodes for axis in range(tangents)])
        slips = question.forces_of(system.S[:, along].T).T  # (M, t n)
        units = {
            "margin": 1.0,
            "lift": np.tile(self._lift_unit, corners),
            "own_slip": np.tile(self._slip_unit, corners - 1),
            "total": question.load_unit,
        }
        effects = {
            "lift": np.zeros((corners, len(lifts), corners * n)),
            "own_slip": np.zeros((corners, len(lifts), (corners - 1) * tangents * n)),
        }
        for k in range(corners):
            effects["lift"][k, :, k * n : (k + 1) * n] = lifts
            if k:
                here = slice((k - 1) * tangents * n, k * tangents * n)
                effects["own_slip"][k, :, here] = slips
        program = stuck(at_corners(question, None, units, effects), margin=True, every=True)

        # The margin is minus the excess.
        program.bound("excess", "margin", -1.0, 0.0)
        program.bound("most", "load_factor", -1.0, self._most)
        count = corners * n
        every = np.full(count, -1)
        lift = program.unknown("lift") + np.arange(count), np.ones(count)
        margin = np.full(count, program.unknown("margin")), np.full(count, -question.clearance)
        unit = np.tile(self._lift_unit, corners)
        program.rows.append(
            rows_of("lift", LINEAR, [[lift, margin]], np.zeros(count), unit, every, every)
        )
        price = BRANCHES.price * question.load_unit
        terms = [("load_factor", 1.0), ("margin", price), ("total", -1.0)]
        total = [(np.array([program.unknown(name)]), np.array([weight])) for name, weight in terms]
        one, none = np.array([question.load_unit]), np.full(1, -1)
        program.rows.append(rows_of("total", LINEAR, [total], np.zeros(1), one, none, none))

        corner = np.repeat(np.arange(corners), n)
        pressures = program.force(corner, normal + np.tile(nodes, corners))
        motions = program.unknown("lift") + np.arange(len(chosen) - count)
        entries = np.r_[pressures, motions][chosen]
        units_of = np.r_[np.tile(question.node_unit[nodes], corners), unit, units["own_slip"]][
            chosen
        ]
        none = np.full(len(entries), -1)
        fixed = [[(entries, np.ones(len(entries)))]]
        program.rows.append(
            rows_of("fixed", kind, fixed, np.zeros(len(entries)), units_of, none, none)
        )
        return program

    def _fixed(self, branch: Branch) -> Booleans:
        """Which entries are zero: pressures by corner, then lifts, then own slips."""
        corners = len(self._question.r1)
        opened = np.tile(branch.opens, corners)
        slips = (corners - 1) * self._question.system.tangents
        return np.asarray(np.r_[opened, np.tile(branch.closes, corners + slips)])

    def _warm_program(self) -> tuple[RestProgram, WarmProgram, Integers]:
        """The program in which rows of all entries may be switched on, and their places."""
        nothing = np.zeros(len(self._nodes), dtype=bool)
        every = np.ones_like(self._fixed(Branch(nothing, nothing)))
        program = self._program(every, LINEAR)
        arrays = program.arrays("total", 1.0)
        count = len(arrays.right)
        first = program.slides
        for rows in program.stacked.rows:
            if rows.label == "fixed":
                break
            first += len(rows.constants)
        places = first + np.arange(len(every))
        least = np.full(count, -np.inf)
        least[: arrays.zero] = arrays.right[: arrays.zero]
        most = arrays.right.copy()
        most[places] = np.inf
        free = np.full(len(arrays.cost), np.inf)
        engine = WarmProgram(arrays.matrix, least, most, arrays.cost, -free, free)
        self._switched = np.zeros(len(every), dtype=bool)
        return program, engine, places

    def solve(self, branch: Branch, above: float) -> Relaxed:
        """The bound of a branch; inf if no solver's answer passes the checks.

        A solver may stop once it knows that the bound is not `above` a load factor.
        """
        fixed = self._fixed(branch)
        if self._warm is not None:
            return self._solved_warm(*self._warm, branch, fixed, above)

        def claimed(solution: Solution) -> Relaxed:
            bound = self._counted(sum(solution.bound))
            # A bound that ends the branch need not be close to the value of the program.
            return self._relaxed(bound, 0.0 if bound <= above else solution.gap, solution)

        program = self._program(fixed, EQUATION)
        try:
            relaxed, _ = solve(
                program,
                "total",
                1.0,
                claimed,
                self._solver,
                above=above,
                tolerance=BRANCHES.tolerance,
            )
        except SolverError:
            return Relaxed(np.inf, np.inf)
        return Relaxed(above, 0.0) if relaxed is None else relaxed

    def _solved_warm(
        self,
        program: RestProgram,
        engine: WarmProgram,
        places: Integers,
        branch: Branch,
        fixed: Booleans,
        above: float,
    ) -> Relaxed:
        """The bound of a branch in the plane, by a program that differs in bounds alone."""
        changed = np.flatnonzero(fixed != self._switched)
        ends = np.where(fixed[changed], 0.0, np.inf)
        engine.bound_rows(places[changed], -ends, ends)
        self._switched = fixed
        outcome, x, y = engine.solve(branch.basis, -above / self._question.load_unit)
        if outcome not in (OPTIMAL, CUT_OFF):
            return Relaxed(np.inf, np.inf)
        # Multipliers of inequalities are not negative, and those of rows without bounds are zero.
        signed = np.zeros(len(y), dtype=bool)
        signed[: program.slides] = True
        signed[places] = fixed
        y = np.where(signed, y, np.maximum(y, 0.0))
        y[places[~fixed]] = 0.0
        solution = Solution(program, x, y[program.slides :], "total")
        bound = self._counted(sum(solution.bound))
        if outcome == CUT_OFF:
            return Relaxed(bound, np.inf)
        return replace(self._relaxed(bound, 0.0, solution), basis=engine.basis)

    def _counted(self, bound: float) -> float:
        """A bound; inf if it is the largest load factor of the program."""
        return np.inf if bound >= self._most * (1 - BRANCHES.gain) else bound

    def _relaxed(self, bound: float, residual: float, solution: Solution) -> Relaxed:
        """The bound of a branch, with the largest motions and pressures of its loose nodes."""
        question, n = self._question, len(self._nodes)
        corners = len(question.r1)
        motion = solution.values("lift").reshape(corners, n).max(axis=0) / self._lift_unit
        if corners > 1:
            slips = solution.values("own_slip").reshape(corners - 1, -1) / self._slip_unit
            sizes = np.abs(slips).reshape(-1, n).max(axis=0)
            motion = np.maximum(motion, sizes)
        quantities, _ = solution.program.quantities(solution.x)
        forces = quantities[: solution.program.first_named].reshape(corners, -1)
        pressure = forces[:, -question.system.nodes :][:, self._nodes].max(axis=0)
        pressure = pressure / question.node_unit[self._nodes]
        excess = -float(solution.values("margin")[0])
        return Relaxed(bound, residual, motion, pressure, excess)
