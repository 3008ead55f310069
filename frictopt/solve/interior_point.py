"""Cone programs of one dense block and many small cones, by an interior point on condensed normal equations.

A contact in space has one dense block of rows, which says what pressures a slip makes, and a small cone for each node at each corner of the load
cycle. With `min c'y` over the `s = h - A y` in cones, whose multipliers z are in cones too, and with W the scaling of s and z, a step solves::

    A' z = u,   A y - W^2 z = v   by   (A' W^-2 A) y = u + A' W^-2 v

so that whatever the number of cones there is one dense matrix, one product and one Cholesky factorisation, see `Condensed`. Their errors are
corrected in the equations on the left. The steps are those of Mehrotra on the homogeneous embedding, which also finds that there is no optimum
(Andersen, Roos & Terlaky 2003).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from ..contact import FLOOR, Array
from .condensed import Condensed, Equations
from .cones import Cones, Scaling

_STEPS = 100
_ENOUGH = 1e-11  # errors with which it ends, see `_Residuals.error`
_AGREE = 10.0  # times as much may the two objectives differ, which is a tenth of what an answer may
_MENDED = 100 * _ENOUGH  # work of the cones from which on the errors of a step, its rounding, are mended by themselves
_WAITING = 5  # steps near an optimum that do not halve the least error after which rounding is all that is left
_NEARLY = 1e-7  # errors up to which it ends where rounding leaves no further step, for others to judge, and of a proof that there is no optimum
_NO_OPTIMUM = 1e-12  # tau over kappa up to which there is no optimum, and rounding is all that the proof lacks
_STAY = 0.98  # share of the way to the boundary of the cones
_SURELY = 1e6  # times the error of a bound that it must bear: it holds for unknowns so many times as large


def interior_point(
    matrix: csr_array, right: Array, cost: Array, zero: int, nonneg: int, soc: Sequence[int], above: float = -np.inf
) -> tuple[str, Array, Array]:
    """Status, in the words of Clarabel, variables and multipliers of `min cost @ x` over the x whose slacks `right - matrix @ x` are in cones.

    The first slacks are zero, the next ones >= 0, and the rest are in cones of the sizes `soc`. It ends early where multipliers prove that the
    largest `-cost @ x` is not `above` a number.
    """
    sizes = np.array(soc, dtype=int)
    starts = nonneg + np.cumsum(sizes) - sizes
    groups = [np.arange(nonneg)[:, None], *(starts[sizes == d][:, None] + np.arange(d) for d in np.unique(sizes))]
    try:
        program = Condensed(csr_array(matrix), right, cost, zero)
        status, y, z, _ = _solved(program, Cones([group for group in groups if group.size]), above + program.constant)
    except (ArithmeticError, np.linalg.LinAlgError) as error:  # rounding; or of equations that depend on each other
        return str(error), np.zeros(len(cost)), np.zeros(len(right))
    return status, *program.whole(y, z)


@dataclass(frozen=True)
class _Point:
    """A point of the embedding: y, s, z and its two numbers tau and kappa, one of which vanishes in the end."""

    y: Array
    s: Array
    z: Array
    tau: float
    kappa: float

    def moved(self, by: "_Point", step: float) -> "_Point":
        parts = ((self.y, by.y), (self.s, by.s), (self.z, by.z), (self.tau, by.tau), (self.kappa, by.kappa))
        return _Point(*(part + step * change for part, change in parts))  # type: ignore[arg-type]


class _Residuals:
    """By how much a point misses the equations of the embedding, and the mean work of its cones."""

    def __init__(self, program: Condensed, point: _Point, degree: int) -> None:
        h, c, y, s, z, tau, kappa = program.right, program.objective, point.y, point.s, point.z, point.tau, point.kappa
        self.columns, self.rows = program.columns(z), program.rows(y) + s
        self.dual, self.primal, self.gap = self.columns + c * tau, self.rows - h * tau, kappa + c @ y + h @ z
        self.work = float(s @ z + kappa * tau) / (degree + 1)
        value, off = max(FLOOR * tau, abs(float(c @ y))) * _AGREE, float(np.abs(self.dual) @ np.maximum(np.abs(y / tau), 1.0))
        self.bound = float(h @ z) / tau
        self.proven = self.bound + _SURELY * off / tau
        self.apart = (degree + 1) * self.work / tau / value
        self.error = max(abs(float(c @ y + h @ z)) / value, off / value, float(np.abs(self.primal).max()) / max(1.0, float(np.abs(h).max())) / tau)
        with np.errstate(divide="ignore", invalid="ignore"):
            lacks = np.array([np.abs(self.columns).max(), np.abs(self.rows).max()]) / np.maximum([-h @ z, -c @ y], 0.0)
        self.lack, self.without_optimum = float(lacks.min()), ("PrimalInfeasible", "DualInfeasible")[lacks.argmin()]


def _solved(program: Condensed, cones: Cones, above: float = -np.inf) -> tuple[str, Array, Array, int]:
    """Status in Clarabel's words, y, z, and the number of steps."""
    at = _Point(np.zeros(len(program.objective)), cones.unit, cones.unit, 1.0, 1.0)
    best, least, proof, lack, since, step, newton = at, np.inf, ("", at), np.inf, 0, 0, None
    for step in range(_STEPS):
        off = _Residuals(program, at, cones.degree)
        if newton and (off.apart <= _MENDED or off.bound <= above) and off.error > _ENOUGH:
            with suppress(ArithmeticError):  # at the end of a cone
                mended = newton.mended(at, off)
                at, off = min((at, off), (mended, _Residuals(program, mended, cones.degree)), key=lambda found: found[1].error)
        proof, lack = ((off.without_optimum, at), off.lack) if off.lack < lack else (proof, lack)
        if lack <= (_ENOUGH if at.tau > _NO_OPTIMUM * at.kappa else _NEARLY):
            return proof[0], proof[1].y, proof[1].z, step
        if off.proven <= above:
            return "AlmostSolved", at.y / at.tau, at.z / at.tau, step
        since = 0 if off.error < least / 2 else since + 1
        best, least = (at, off.error) if off.error < least else (best, least)
        if least <= _ENOUGH or (since >= _WAITING and least <= _NEARLY) or not np.isfinite(off.error) or at.tau <= _NO_OPTIMUM * at.kappa:
            break
        try:
            newton = _Newton(program, cones, at, off)
        except (ArithmeticError, np.linalg.LinAlgError):
            break
        ahead = newton.direction()
        share = (1 - min(1.0, newton.longest(ahead))) ** 3
        way = newton.direction(share, ahead)
        at = at.moved(way, min(1.0, _STAY * newton.longest(way)))
    if least > _NEARLY:
        raise ArithmeticError("rounding leaves no step towards an optimum")
    return "Solved" if least <= _ENOUGH else "AlmostSolved", best.y / best.tau, best.z / best.tau, step


class _Newton:
    """Newton's directions at a point."""

    def __init__(self, program: Condensed, cones: Cones, at: _Point, off: _Residuals) -> None:
        self._program, self._cones, self._at, self._off = program, cones, at, off
        self._scaling = Scaling(cones, at.s, at.z)
        self._solve = Equations(program, self._scaling).solved
        if at.tau < at.kappa:
            self._y, self._z = self._solve(-program.objective, program.right)
        else:  # towards an optimum the same, all of which would be lost in its own rounding in the end
            y, z = self._solve(-off.dual, 2 * at.s - off.primal)
            self._y, self._z = (at.y + y) / at.tau, (at.z + z) / at.tau
        self._slope = at.kappa / at.tau + float((self._scaling.times(self._z) ** 2).sum())

    def direction(self, share: float = 0.0, ahead: _Point | None = None) -> _Point:
        """To the point whose cones all have this share of their mean work, with the curvature that the way ahead has met; by default to the end."""
        at, off, scaling, cones, program = self._at, self._off, self._scaling, self._cones, self._program
        work, number = cones.product(scaling.point, scaling.point) - share * off.work * cones.unit, at.kappa * at.tau - share * off.work
        if ahead is not None:
            work = work + cones.product(scaling.over(ahead.s), scaling.times(ahead.z))
            number += ahead.kappa * ahead.tau
        back = scaling.times(cones.quotient(scaling.point, work))
        y, z = self._solve(-(1 - share) * off.dual, back - (1 - share) * off.primal)
        tau = float((1 - share) * off.gap - number / at.tau + program.objective @ y + program.right @ z) / self._slope
        y, z = y + tau * self._y, z + tau * self._z
        s = tau * program.right - (1 - share) * off.primal - program.rows(y)  # by the rows: what the multipliers say of it has their rounding
        return _Point(y, s, z, tau, -(number + at.kappa * tau) / at.tau)

    def mended(self, at: _Point, off: _Residuals) -> _Point:
        """A later point without what it misses of rows and multipliers alone, which is not lost in the rounding of a whole step."""
        y, z = self._solve(-off.dual, -off.primal, last=True)
        way, scaling = _Point(y, -off.primal - self._program.rows(y), z, 0.0, 0.0), Scaling(self._cones, at.s, at.z)
        return at.moved(way, min(1.0, _STAY * min(scaling.longest(scaling.over(way.s)), scaling.longest(scaling.times(way.z)))))

    def longest(self, way: _Point) -> float:
        """The largest step that stays within the cones."""
        at, scaling = self._at, self._scaling
        numbers = [-value / change for value, change in ((at.tau, way.tau), (at.kappa, way.kappa)) if change < 0]
        return min(scaling.longest(scaling.over(way.s)), scaling.longest(scaling.times(way.z)), *numbers)
