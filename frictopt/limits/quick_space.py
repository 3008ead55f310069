"""The cone program of a quick limit in space.

Its unknowns are the load factor and the residual shear forces of the closed nodes, which do no work
on slides that nothing resists. The slack of a row is `of_forces @ forces + constant`. The forces
are the shear forces and normal forces of the closed nodes, and the gaps of the open nodes, at a
corner.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array, csr_array, dia_array, hstack, vstack

from ..base import CONDENSATION, Array
from ..errors import SolverError
from ..solve.arrays import Arrays
from ..solve.chain import kind_of
from ..solve.interior_point import SETTINGS
from ..solve.solvers import CUT_OFF, INFEASIBLE, NONE, OPTIMAL, run, solver_order
from ..solve.unresisted import unresisted
from .answered import Mechanism
from .programs import listed_corners
from .question import Question

# The search needs fewer digits than an answer, and `ConeProgram.solve` checks the bound itself.
_SETTINGS = replace(SETTINGS, enough=1e-8, surely=1.0)


class ConeProgram:
    """The program of a set of open nodes in space, in units.

    `p >= 0` has rows if friction is below `low_friction`. SolverError for a slip bound, for closed
    nodes without friction, and for free slides that change gaps: they need other rows or unknowns.
    """

    def __init__(self, question: Question, low_friction: float) -> None:
        closed = np.flatnonzero(~question.open_nodes)
        if question.slip_bound is not None or not question.friction[closed].all():
            raise SolverError("quick limit: slip bounds and nodes without friction need other rows")
        nodes = question.system.nodes
        self._question = question
        self._corners = listed_corners(question)
        self._slips = np.r_[closed, nodes + closed]
        # The entries of the forces in the reactions of all nodes; gaps follow.
        self._places = np.r_[self._slips, 2 * nodes + closed]
        self._shear_unit = question.shear_unit[self._slips % nodes]
        self._low = question.friction[closed] < low_friction
        slides = self._set_slips()
        linear, cones, constant = self._rows()
        self._of_forces = linear, cones
        self._arrays = self._program(slides, constant)
        self.cost = self._arrays.cost
        self._solver = solver_order(None, kind_of(self._arrays))[0]

    def _set_slips(self) -> Array:
        """The slides that nothing resists. Sets the slips due to the unknown shear forces."""
        question = self._question
        stiffness = np.sqrt(question.system.own_stiffness)
        along, across = stiffness[self._slips], stiffness[-question.system.nodes :]
        square = question.A[np.ix_(self._slips, self._slips)]
        slides, compliance = unresisted(square, question.B[:, self._slips], along, across)
        opening = np.abs(question.W[:, self._slips] @ slides).max(axis=0, initial=0.0)
        if (opening > CONDENSATION * np.abs(slides).max(axis=0, initial=0.0)).any():
            raise SolverError("quick limit: slides that change gaps need further unknowns")
        self._slips_by_unknown = compliance * self._shear_unit
        return slides

    def _rows(self) -> tuple[csr_array, csr_array, Array]:
        """How the slacks of linear rows and of cones follow from forces; constants of the cones."""
        question = self._question
        count = len(self._slips) // 2
        closed = self._slips[:count]
        gaps = len(question.W)
        units = np.r_[question.node_unit[closed][self._low], np.full(gaps, question.clearance)]
        chosen = np.r_[2 * count + np.flatnonzero(self._low), 3 * count + np.arange(gaps)]
        shape = (len(chosen), 3 * count + gaps)
        linear = csr_array((1 / units, (np.arange(len(chosen)), chosen)), shape=shape)

        cones = list[csr_array]()
        constants = list[Array]()
        for term in question.law.terms:
            has_term = np.flatnonzero(np.isin(closed, term.nodes))
            at = closed[has_term]
            weights = np.column_stack([term.slope[at], np.ones((len(at), 2))])
            weights = weights / question.shear_unit[at, None]
            entries = np.column_stack([2 * count + has_term, has_term, count + has_term])
            rows = np.arange(entries.size)
            matrix = (weights.ravel(), (rows, entries.ravel()))
            cones.append(csr_array(matrix, shape=(entries.size, shape[1])))
            bound = term.constant[at] / question.shear_unit[at]
            constants.append(np.column_stack([bound, np.zeros((len(at), 2))]).ravel())
        return linear, csr_array(vstack(cones)), np.concatenate(constants)

    def _program(self, slides: Array, constant: Array) -> Arrays:
        """A load factor >= 0 is the first row after the equations of the slides."""
        question = self._question
        shear, by_unknown = len(self._slips), self._slips_by_unknown
        dense = np.vstack([question.B[self._slips[: shear // 2]], question.W])[:, self._slips]
        block = np.hstack([np.zeros((len(dense), 1)), dense @ by_unknown])
        width = block.shape[1]
        equations = np.zeros((slides.shape[1] + 1, width + len(block)))
        equations[:-1, 1 : shear + 1] = slides.T * self._shear_unit / self._shear_unit.mean()
        equations[-1, 0] = -1.0
        own = dia_array((self._shear_unit[None], 0), shape=(shear, width - 1))
        residual = csr_array(vstack([own, csr_array((len(block), width - 1))]))
        eye = dia_array((np.ones((1, len(block))), -shear), shape=(shear + len(block), len(block)))

        parts = [csr_array(equations)]
        rights = [np.zeros(len(equations))]
        for of_forces, constants in zip(self._of_forces, (0.0, constant), strict=True):
            for k in self._corners:
                row = k if question.fixed else 0
                rates = np.r_[question.r1[k].ravel()[self._places], question.w1[k]]
                starts = np.r_[question.r0[row].ravel()[self._places], question.w0[row]]
                forces = hstack([coo_array(question.load_unit * rates[:, None]), residual, eye])
                parts.append(csr_array(-(of_forces @ csr_array(forces))))
                rights.append(of_forces @ starts + constants)
        linear, cones = (len(self._corners) * part.shape[0] for part in self._of_forces)
        return Arrays(
            sparse=csr_array(vstack(parts)),
            block=block,
            right=np.concatenate(rights),
            cost=-np.eye(1, width)[0],
            zero=slides.shape[1],
            sizes=np.repeat([1, 3], [1 + linear, cones // 3]),
        )

    def solve(self, cost: Array, above: float = -np.inf) -> tuple[str, Array, Array]:
        """Status, x, and the multipliers of the rows in cones.

        The solver may stop, and the status is `CUT_OFF`, if the multipliers prove that the largest
        `-cost @ x` is at most `above`. SolverError if they do not prove what the solver says:
        solvers also call a point an optimum, or a program infeasible, if rounding ends their steps.
        """
        program = replace(self._arrays, cost=cost)
        outcome, x, y = run(program, self._solver, above, _SETTINGS)
        if outcome == OPTIMAL:
            value = -float(cost @ x)
            least_cost, error = program.lower_bound(x, y)
            bound = error - least_cost
            # Largest distance from the bound, in the unit of the load or relative to the limit.
            proven = 1e-4
            if bound <= above:
                outcome = CUT_OFF
            elif bound - value > proven * max(1.0, abs(value)):
                raise SolverError(f"quick limit: {value:.3g} has the bound {bound:.3g}")
        elif outcome in (INFEASIBLE, NONE) and not _proves_infeasible(program, y):
            raise SolverError("quick limit: no multipliers prove that no slip is safe")
        return outcome, x, y[program.zero + 1 :]

    def state(self, x: Array) -> tuple[float, Array]:
        """The load factor and the slip of a solution."""
        question = self._question
        slip = np.zeros(2 * question.system.nodes)
        slip[self._slips] = self._slips_by_unknown @ x[1:]
        load_factor = max(float(x[0]) * question.load_unit, 0.0)
        return load_factor, question.slip_at_mean_load(slip.reshape(2, -1).T)

    def motion(self, y: Array) -> Mechanism:
        """The mechanism of the multipliers, see `Program.motion`."""
        question = self._question
        moves = np.zeros((len(question.r1), 3 * question.system.nodes))
        press = np.zeros_like(moves)
        opened = 2 * question.system.nodes + np.flatnonzero(question.open_nodes)
        start = 0
        for of_forces in self._of_forces:
            for k in self._corners:
                end = start + of_forces.shape[0]
                by_force = question.load_unit * (of_forces.T @ y[start:end])
                moves[k, self._places] += by_force[: len(self._places)]
                press[k, opened] += by_force[len(self._places) :]
                start = end
        return Mechanism.of(question, moves.reshape(question.r1.shape), press)


def _proves_infeasible(program: Arrays, y: Array) -> bool:
    """Whether the multipliers prove that no unknowns up to a thousand units are feasible."""
    units = 1000.0
    unbalanced = np.abs(program.columns(y)).sum()
    return bool(-(program.right @ y) > units * unbalanced)
