"""An interior-point method for large cone programs, with condensed normal equations.

Such a program has one dense block of rows and many small cones. A contact in space is an example:
the block holds the tractions due to slips, and there is a cone for each node at each corner. The
program is `min c'y` with `s = h - A y` in cones, and its multipliers z are in cones too. Whatever
the number of cones, a step needs one dense matrix, see `step_equations.py`.

The steps are Mehrotra's, on the homogeneous embedding, which also detects that there is no optimum
(Andersen, Roos & Terlaky 2003). s and z are scaled as by Nesterov & Todd (1997).
"""

from typing import NamedTuple

import numpy as np

from ..base import FAR, FLOOR, Array
from .arrays import Arrays
from .condensed import Condensed, Cones, Scaling
from .step_equations import Equations, begins_through_block

# Constants of the method; errors are measured as in `_Residuals.error`.

# Largest number of steps.
_STEPS = 100
# Error at which the program counts as solved.
_ENOUGH = 1e-11
# Largest error of an answer if rounding prevents further steps; the caller checks its residual.
# It is also the largest error of a proof that there is no optimum, if tau has vanished.
_NEARLY = 1e-7
# After one to `_PATIENCE` steps that do not halve the smallest error, an error of `_SLACK` times
# `_ENOUGH` is accepted.
_SLACK = 5.0
_PATIENCE = 4
# The relative difference of the two objectives may be this many times `_ENOUGH`.
_OBJECTIVES_APART = 10.0
# The rounding of a step is corrected separately if the work of the cones, `s'z`, relative to the
# objective, is below this many times `_ENOUGH`.
_MENDED = 100.0
# Ratio of tau to kappa below which there is no optimum.
_NONE = 1e-12
# Length of a step, relative to the step that reaches the boundary of the cones.
_STAY = 0.98


def interior_point(program: Arrays, above: float = -np.inf) -> tuple[str, Array, Array]:
    """Status in Clarabel's words, x and multipliers.

    The method ends early if the multipliers prove that `-cost @ x` is at most `above` for all x.
    """
    try:
        condensed = Condensed(program)
        with np.errstate(over="raise", divide="raise", invalid="raise"):  # an ArithmeticError
            above += condensed.constant
            status, y, z = _solved(condensed, Cones(program.sizes), above)
    # Rounding has stopped the steps, or equations are linearly dependent.
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        return str(error), np.zeros(len(program.cost)), np.zeros(len(program.right))
    return status, *condensed.whole(y, z)


class _Point(NamedTuple):
    """A point of the embedding: y, s, z, tau and kappa. At the end tau or kappa vanishes."""

    y: Array
    s: Array
    z: Array
    tau: float
    kappa: float

    def moved(self, way: "_Point", step: float) -> "_Point":
        return _Point(
            self.y + step * way.y,
            self.s + step * way.s,
            self.z + step * way.z,
            self.tau + step * way.tau,
            self.kappa + step * way.kappa,
        )


class _Residuals:
    """A point, its errors in the equations of the embedding, and the mean work of its cones.

    `bound` is the bound of the objective that the multipliers prove if they balance exactly;
    `proven` includes their error of balance. `error` is the error of the point as a solution.
    `lack` is its error as a proof of the status `without_optimum`.
    """

    def __init__(self, program: Condensed, point: _Point, degree: int) -> None:
        self.point = point
        h, c = program.right, program.objective
        y, s, z, tau, kappa = point
        columns = program.columns(z)
        rows = program.rows(y) + s
        self.dual = columns + c * tau
        self.primal = rows - h * tau
        self.gap = kappa + c @ y + h @ z
        self.work = float(s @ z + kappa * tau) / (degree + 1)
        value = max(FLOOR * tau, abs(float(c @ y))) * _OBJECTIVES_APART
        off = float(np.abs(self.dual) @ np.maximum(np.abs(y / tau), 1.0))
        self.bound = float(h @ z) / tau
        self.proven = self.bound + FAR * off / tau
        self.apart = (degree + 1) * self.work / tau / value
        self.error = max(
            abs(float(c @ y + h @ z)) / value,
            off / value,
            float(np.abs(self.primal).max()) / max(1.0, float(np.abs(h).max())) / tau,
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            lacks = np.array([np.abs(columns).max(), np.abs(rows).max()]) / np.maximum(
                [-h @ z, -c @ y], 0.0
            )
        self.lack = float(lacks.min())
        self.without_optimum = ("PrimalInfeasible", "DualInfeasible")[lacks.argmin()]


class _Best(NamedTuple):
    """The point of least error so far, and the number of steps since the error was last halved."""

    point: _Point
    error: float = np.inf
    stalled: int = 0

    def after(self, off: _Residuals) -> "_Best":
        stalled = 0 if off.error < self.error / 2 else self.stalled + 1
        if off.error < self.error:
            return _Best(off.point, off.error, stalled)
        return _Best(self.point, self.error, stalled)


def _accepted(stalled: int) -> float:
    """The error accepted after `stalled` steps that do not halve the smallest error."""
    if stalled > _PATIENCE:
        return _NEARLY
    return _ENOUGH * (_SLACK if stalled else 1.0)


def _solved(program: Condensed, cones: Cones, above: float) -> tuple[str, Array, Array]:
    """Status in Clarabel's words, y and z."""
    # At first the work of all cones together is 1, the size of the objective. If it were 1 for each
    # cone, many more steps would be needed only to reduce it.
    work = 1 / cones.degree
    at = _Point(np.zeros(len(program.objective)), cones.unit, work * cones.unit, 1.0, work)
    best = _Best(at)
    no_optimum: _Residuals | None = None  # the best proof that there is no optimum
    newton: _Newton | None = None
    through_block = begins_through_block(program)
    for _ in range(_STEPS):
        off = _Residuals(program, at, cones.degree)
        if newton is not None:
            off = newton.corrected(off, above)
        at = off.point
        ending = at.tau <= _NONE * at.kappa
        if off.lack < (no_optimum.lack if no_optimum else np.inf):
            no_optimum = off
        if no_optimum and no_optimum.lack <= (_NEARLY if ending else _ENOUGH):
            return no_optimum.without_optimum, no_optimum.point.y, no_optimum.point.z
        if off.proven <= above:
            return "AlmostSolved", at.y / at.tau, at.z / at.tau
        best = best.after(off)
        if best.error <= _accepted(best.stalled) or ending or not np.isfinite(off.error):
            break
        newton = None  # its matrices are not needed beside the matrices of the next step
        try:
            newton = _Newton(program, cones, off, through_block)
            at = newton.stepped()
            through_block = newton.equations.through_block
        except (ArithmeticError, np.linalg.LinAlgError):
            break
    if best.error > _NEARLY:
        raise ArithmeticError("rounding leaves no step towards an optimum")
    status = "Solved" if best.error <= _ENOUGH else "AlmostSolved"
    point = best.point
    return status, point.y / point.tau, point.z / point.tau


class _Newton:
    """Newton's directions at a point."""

    def __init__(
        self, program: Condensed, cones: Cones, off: _Residuals, through_block: bool
    ) -> None:
        at = off.point
        self._program = program
        self._cones = cones
        self._at = at
        self._off = off
        self._scaling = Scaling(cones, at.s, at.z)
        self.equations = Equations(program, self._scaling, through_block)
        self._solve = self.equations.solved
        # The y and z that a direction gains for each unit of its tau.
        if at.tau < at.kappa:
            self._y, self._z = self._solve(-program.objective, program.right)
        else:
            # The same `_y` and `_z` from another right side: near an optimum the equation above
            # would lose all digits.
            y, z = self._solve(-off.dual, 2 * at.s - off.primal)
            self._y = (at.y + y) / at.tau
            self._z = (at.z + z) / at.tau
        self._slope = at.kappa / at.tau + float((self._scaling.times(self._z) ** 2).sum())

    def stepped(self) -> _Point:
        """The point after a step: Mehrotra's direction, almost to the boundary of the cones."""
        ahead = self._direction(0.0)
        share = (1 - min(1.0, self._longest(ahead))) ** 3
        way = self._direction(share, ahead)
        return self._at.moved(way, min(1.0, _STAY * self._longest(way)))

    def _direction(self, share: float, ahead: _Point | None = None) -> _Point:
        """The direction to the point at which the work of each cone is this share of the mean work.

        It takes account of the curvature along the direction `ahead`.
        """
        at, off, program = self._at, self._off, self._program
        scaling, cones = self._scaling, self._cones
        work = cones.product(scaling.point, scaling.point) - share * off.work * cones.unit
        number = at.kappa * at.tau - share * off.work
        if ahead is not None:
            work = work + cones.product(scaling.over(ahead.s), scaling.times(ahead.z))
            number += ahead.kappa * ahead.tau
        back = scaling.times(cones.quotient(scaling.point, work))
        y, z = self._solve(-(1 - share) * off.dual, back - (1 - share) * off.primal)
        misses = (1 - share) * off.gap - number / at.tau
        tau = float(misses + program.objective @ y + program.right @ z) / self._slope
        y = y + tau * self._y
        z = z + tau * self._z
        # s is computed from the rows, because computed from z it would have the rounding of z.
        s = tau * program.right - (1 - share) * off.primal - program.rows(y)
        return _Point(y, s, z, tau, -(number + at.kappa * tau) / at.tau)

    def corrected(self, off: _Residuals, above: float) -> _Residuals:
        """The residuals of a point; near the end its rows and multipliers are corrected.

        The correction has a direction of its own. As a part of a whole step it would be lost in the
        rounding.
        """
        late = off.apart <= _MENDED * _ENOUGH or off.bound <= above
        if not late or not off.error > _ENOUGH:
            return off
        try:
            mended = _Residuals(self._program, self._mended(off), self._cones.degree)
        except ArithmeticError:  # at the boundary of a cone
            return off
        return min(off, mended, key=lambda either: either.error)

    def _mended(self, off: _Residuals) -> _Point:
        """The point after a correction of the errors of its rows and multipliers."""
        at = off.point
        y, z = self._solve(-off.dual, -off.primal)
        way = _Point(y, -off.primal - self._program.rows(y), z, 0.0, 0.0)
        longest = _longest_in_cones(Scaling(self._cones, at.s, at.z), way)
        return at.moved(way, min(1.0, _STAY * longest))

    def _longest(self, way: _Point) -> float:
        """The largest step that stays within the cones and keeps tau and kappa positive."""
        at = self._at
        longest = _longest_in_cones(self._scaling, way)
        if way.tau < 0:
            longest = min(longest, -at.tau / way.tau)
        if way.kappa < 0:
            longest = min(longest, -at.kappa / way.kappa)
        return longest


def _longest_in_cones(scaling: Scaling, way: _Point) -> float:
    """The largest step of s and z that stays within the cones."""
    return min(scaling.longest(scaling.over(way.s)), scaling.longest(scaling.times(way.z)))
