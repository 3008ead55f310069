"""Large cone programs of one dense block and many small cones, by an interior point on condensed normal equations.

A contact in space has one dense block of rows, which says what tractions a slip makes, and a small
cone for each node at each corner of the load cycle. With `min c'y` over the `s = h - A y` in cones,
whose multipliers z are in cones too, and with W the scaling of s and z, a step solves::

    A' z = u,   A y - W^2 z = v   by   (A' W^-2 A) y = u + A' W^-2 v,   A y = sparse [y, block y]

so that whatever the number of cones there is one dense matrix of the size of y, one product and one
Cholesky factorisation. Their errors are corrected in the equations on the left. The steps are those
of Mehrotra on the homogeneous embedding, which also finds that there is no optimum (Andersen, Roos
& Terlaky 2003), with the scaling of Nesterov & Todd (1997).
"""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
from scipy.linalg import qr
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.sparse import csr_array, dia_array, hstack

from ..base import FLOOR, Array, Integers
from .arrays import Arrays

_STEPS = 100
_ENOUGH = 1e-11  # errors with which it ends, see `_Residuals.error`
_AGREE = 10.0  # times as much may the two objectives differ, which is a tenth of what an answer may
_MENDED = (
    100 * _ENOUGH
)  # work of the cones from which on the errors of a step, its rounding, are mended by themselves
# errors up to which it ends where rounding leaves no further step, for others to judge, and of a
# proof that there is no optimum
_NEARLY = 1e-7
_ENDS = (
    _ENOUGH,
    *(4 * [5 * _ENOUGH]),
    _NEARLY,
)  # errors with which it ends after so many steps that do not halve the least one, by rounding
# tau over kappa up to which there is no optimum, and rounding is all that the proof lacks
_NO_OPTIMUM = 1e-12
_STAY = 0.98  # share of the way to the boundary of the cones
# times the error of a bound that it must bear: it holds for unknowns so many times as large
_SURELY = 1e6
_LONG = 0.2  # share of the unknowns from which on a row counts as dense
_ROWS = 250  # rows in a part of the product, of which only the lower triangle is computed
_SHIFTS = (
    1e-14,
    1e-13,
    1e-12,
    1e-11,
)  # of the diagonal, over itself: the first with which rounding leaves the equations a factor
_CORRECT, _HELPS = (
    1e-13,
    0.1,
    # error of the equations from which on none is corrected, and what a correction leaves of it, unless
    # all is rounding
)


def interior_point(program: Arrays, above: float = -np.inf) -> tuple[str, Array, Array]:
    """Status in Clarabel's words, x and multipliers; it ends early where these prove that the largest `-cost @ x` is not `above` a number."""
    try:
        condensed = Condensed(program)
        with np.errstate(over="raise", divide="raise", invalid="raise"):  # an ArithmeticError
            status, y, z, _ = _solved(condensed, Cones(program.sizes), above + condensed.constant)
    except (
        ArithmeticError,
        np.linalg.LinAlgError,
    ) as error:  # rounding; or of equations that depend on each other
        return str(error), np.zeros(len(program.cost)), np.zeros(len(program.right))
    return status, *condensed.whole(y, z)


class Condensed:
    """The rows `right - A y` in cones and `objective @ y + constant` without the unknowns for which the equations are solved, if they can be."""

    def __init__(self, program: Arrays) -> None:
        width, zero = len(program.cost), program.zero
        if zero >= width:
            raise np.linalg.LinAlgError("as many equations as unknowns")
        equations = (
            program.sparse[:zero, :width].toarray() + program.sparse[:zero, width:] @ program.block
        )
        self._pivots = qr(equations, mode="r", pivoting=True)[1][:zero] if zero else np.arange(0)
        self._kept, self._square, self._program = (
            np.setdiff1d(np.arange(width), self._pivots),
            equations[:, self._pivots],
            program,
        )
        self._start, self._rest = (
            np.linalg.solve(self._square, part)
            for part in (program.right[:zero], -equations[:, self._kept])
        )
        rows, dense = program.sparse[zero:], program.block[:, self._pivots]
        own, others = csr_array(rows[:, self._kept]), (rows[:, width:], rows[:, self._pivots])
        long = np.diff(own.indptr) > _LONG * len(
            self._kept
        )  # such as those of nodes that balance free bodies: they would fill the sparse products
        chosen = csr_array(
            (np.ones(long.sum()), (np.flatnonzero(long), np.arange(long.sum()))),
            shape=(len(long), int(long.sum())),
        )
        self.block = np.vstack(
            [program.block[:, self._kept] + dense @ self._rest, self._rest, own[long].toarray()]
        )
        self.sparse = csr_array(hstack([own.multiply(~long[:, None]), *others, chosen]))
        self.right = program.right[zero:] - hstack(others) @ np.r_[dense @ self._start, self._start]
        self.objective = program.cost[self._kept] + self._rest.T @ program.cost[self._pivots]
        self.constant = float(program.cost[self._pivots] @ self._start)

    def rows(self, y: Array) -> Array:
        """`A y`."""
        return np.asarray(self.sparse @ np.concatenate([y, self.block @ y]))

    def columns(self, z: Array) -> Array:
        """`A' z`."""
        work = self.sparse.T @ z
        return np.asarray(work[: len(self._kept)] + work[len(self._kept) :] @ self.block)

    def whole(self, y: Array, z: Array) -> tuple[Array, Array]:
        """The x and multipliers of the program."""
        program, x = self._program, np.empty(len(self._program.cost))
        x[self._kept], x[self._pivots] = y, self._start + self._rest @ y
        work = program.sparse[program.zero :].T @ z
        off = program.cost + work[: len(x)] + work[len(x) :] @ program.block
        return x, np.concatenate([-np.linalg.solve(self._square.T, off[self._pivots]), z])


class Cones:
    """A product of cones `|s[1:]| <= s[0]` of these sizes, one after the other; a number >= 0 is one of size 1."""

    def __init__(self, sizes: Integers) -> None:
        self.heads, self.of = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(sizes)), sizes)
        self.size, self.degree, self.unit = (
            len(self.of),
            len(sizes),
            (np.arange(len(self.of)) == self.heads[self.of]).astype(float),
        )
        self.tail, self.turned = (
            1.0 - self.unit,
            2 * self.unit - 1.0,
        )  # masks: of all parts but the first; that turn these

    def sums(self, x: Array) -> Array:
        """The sum over the parts of each cone."""
        return np.asarray(np.add.reduceat(x, self.heads))

    def square(self, x: Array) -> Array:
        """`x[0]^2 - |x[1:]|^2` of each cone, without most of its rounding, which leaves no point outside."""
        first, size = x[self.heads], np.sqrt(self.sums(self.tail * x**2))
        return np.asarray(
            np.maximum((first - size) * (first + size), np.finfo(float).eps * first**2)
        )

    def product(self, one: Array, other: Array) -> Array:
        """Jordan's product `one o other`."""
        found = np.asarray(one[self.heads][self.of] * other + other[self.heads][self.of] * one)
        found[self.heads] = self.sums(one * other)
        return found

    def quotient(self, one: Array, other: Array) -> Array:
        """The x with `one o x = other`."""
        first = self.sums(self.turned * one * other) / self.square(one)
        found = np.asarray((other - first[self.of] * one) / one[self.heads][self.of])
        found[self.heads] = first
        return found


class Scaling:
    """The symmetric W with `W z = W^-1 s = point`, for s and z within the cones; an ArithmeticError at the end of one.

    For each cone W is `eta (2 v v' - J)` with some v, J the reflection that turns all but the first
    part; `w = W e / eta` is its unit vector.
    """

    def __init__(self, cones: Cones, s: Array, z: Array) -> None:
        if not min(s[cones.heads].min(), z[cones.heads].min()) > 0:
            raise ArithmeticError("rounding leaves the point at the end of a cone")
        self._cones, sizes = cones, (np.sqrt(cones.square(s)), np.sqrt(cones.square(z)))
        one, other = s / sizes[0][cones.of], z / sizes[1][cones.of]
        middle = np.sqrt(
            (1 + np.maximum(cones.sums(one * other), 1.0)) / 2
        )  # of unit vectors in cones, whose product is never less
        self._w, self._eta = (
            (one + cones.turned * other) / (2 * middle[cones.of]),
            np.sqrt(sizes[0] / sizes[1]),
        )
        self.point = self.times(z)

    def times(self, x: Array, sense: float = 1.0) -> Array:
        """`W x`."""
        cones, w = self._cones, self._w
        first, along, least = x[cones.heads], cones.sums(cones.tail * w * x), w[cones.heads]
        found = x + (sense * first + along / (1 + least))[cones.of] * w
        found[cones.heads] = least * first + sense * along
        return np.asarray(found * (self._eta**sense)[cones.of])

    def over(self, x: Array) -> Array:
        """`W^-1 x`."""
        return self.times(x, -1.0)

    def inverse_square(self, sparse: csr_array) -> csr_array:
        """`sparse' W^-2 sparse`: for each cone W^-2 is `(2 v v' - J) / eta^2` with the v that w is when turned."""
        cones, by = self._cones, 1 / self._eta[self._cones.of]
        across = (
            csr_array(
                (
                    np.sqrt(2.0) * by * cones.turned * self._w,
                    np.arange(cones.size),
                    np.r_[cones.heads, cones.size],
                )
            )
            @ sparse
        )
        return csr_array(
            across.T @ across
            - sparse.T @ (dia_array((cones.turned * by**2, 0), shape=(cones.size,) * 2) @ sparse)
        )

    def longest(self, direction: Array) -> float:
        """The largest step from `point` in a direction that stays within the cones."""
        cones, size = self._cones, np.sqrt(self._cones.square(self.point))[self._cones.of]
        point, along = self.point / size, direction / size
        ahead = cones.sums(cones.turned * point * along)
        turn = (ahead + along[cones.heads]) / (point[cones.heads] + 1)
        aside = np.sqrt(cones.sums(cones.tail * (along - turn[cones.of] * point) ** 2))
        steepest = float((aside - ahead).max(initial=0.0))
        return 1 / steepest if steepest > 0 else np.inf


class Equations:
    """The equations `A' z = u` and `A y - W^2 z = v` of a step; an ArithmeticError says that they have no factor."""

    def __init__(self, program: Condensed, scaling: Scaling) -> None:
        self._program, self._scaling, block, n = (
            program,
            scaling,
            program.block,
            program.block.shape[1],
        )
        weights = scaling.inverse_square(program.sparse)
        across = weights[n:, :n]
        half, matrix = across + weights[n:, n:] @ block, weights[:n, :n] + across.T @ block
        for start in range(0, n, _ROWS):
            rows = slice(start, start + _ROWS)
            matrix[rows, : rows.stop] += block[:, rows].T @ half[:, : rows.stop]
        self._factor = _factor(matrix.T)

    def solved(self, u: Array, v: Array) -> tuple[Array, Array]:
        """The y and z, whose errors are corrected in the equations themselves."""
        program, over, times = self._program, self._scaling.over, self._scaling.times
        y, z, left, right, before, size = (
            np.zeros(len(u)),
            np.zeros(len(v)),
            u,
            v,
            np.inf,
            max(float(np.abs(u).max()), float(np.abs(v).max())),
        )
        while (
            _CORRECT * size
            < (error := max(float(np.abs(left).max()), float(np.abs(right).max())))
            < _HELPS * before
        ):
            before = error
            more = dpotrs(self._factor, left + program.columns(over(over(right))))[0]
            y, z = y + more, z + over(over(program.rows(more) - right))
            left, right = u - program.columns(z), v - program.rows(y) + times(times(z))
        return y, z


def _factor(matrix: Array) -> Array:
    """The Cholesky factor, upper, of the upper triangle of a matrix in the order of columns."""
    diagonal = matrix.diagonal().copy()
    for shift in _SHIFTS:
        np.fill_diagonal(matrix, diagonal * (1 + shift))
        factor, failed = dpotrf(matrix)
        if not failed:
            return np.asarray(factor)
    raise ArithmeticError("the equations of a step have no factor")


class _Point(NamedTuple):
    """A point of the embedding: y, s, z and its two numbers tau and kappa, one of which vanishes in the end."""

    y: Array
    s: Array
    z: Array
    tau: float
    kappa: float

    def moved(self, by: "_Point", step: float) -> "_Point":
        return _Point(*(part + step * change for part, change in zip(self, by, strict=True)))  # type: ignore[arg-type,operator]


class _Residuals:
    """By how much a point misses the equations of the embedding, and the mean work of its cones."""

    def __init__(self, program: Condensed, point: _Point, degree: int) -> None:
        h, c, y, s, z, tau, kappa = (
            program.right,
            program.objective,
            point.y,
            point.s,
            point.z,
            point.tau,
            point.kappa,
        )
        self.columns, self.rows = program.columns(z), program.rows(y) + s
        self.dual, self.primal, self.gap = (
            self.columns + c * tau,
            self.rows - h * tau,
            kappa + c @ y + h @ z,
        )
        self.work = float(s @ z + kappa * tau) / (degree + 1)
        value, off = (
            max(FLOOR * tau, abs(float(c @ y))) * _AGREE,
            float(np.abs(self.dual) @ np.maximum(np.abs(y / tau), 1.0)),
        )
        self.bound = float(h @ z) / tau
        self.proven = self.bound + _SURELY * off / tau
        self.apart = (degree + 1) * self.work / tau / value
        self.error = max(
            abs(float(c @ y + h @ z)) / value,
            off / value,
            float(np.abs(self.primal).max()) / max(1.0, float(np.abs(h).max())) / tau,
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            lacks = np.array([np.abs(self.columns).max(), np.abs(self.rows).max()]) / np.maximum(
                [-h @ z, -c @ y], 0.0
            )
        self.lack, self.without_optimum = (
            float(lacks.min()),
            ("PrimalInfeasible", "DualInfeasible")[lacks.argmin()],
        )


def _solved(
    program: Condensed, cones: Cones, above: float = -np.inf
) -> tuple[str, Array, Array, int]:
    """Status in Clarabel's words, y, z, and the number of steps."""
    at = _Point(np.zeros(len(program.objective)), cones.unit, cones.unit, 1.0, 1.0)
    best, least, proof, lack, since, step, newton = at, np.inf, ("", at), np.inf, 0, 0, None
    for step in range(_STEPS):
        off = _Residuals(program, at, cones.degree)
        if newton and (off.apart <= _MENDED or off.bound <= above) and off.error > _ENOUGH:
            with suppress(ArithmeticError):  # at the end of a cone
                mended = newton.mended(at, off)
                at, off = min(
                    (at, off),
                    (mended, _Residuals(program, mended, cones.degree)),
                    key=lambda one: (one[1].proven > above, one[1].error),
                )
        proof, lack = ((off.without_optimum, at), off.lack) if off.lack < lack else (proof, lack)
        if lack <= (_ENOUGH if at.tau > _NO_OPTIMUM * at.kappa else _NEARLY):
            return proof[0], proof[1].y, proof[1].z, step
        if off.proven <= above:
            return "AlmostSolved", at.y / at.tau, at.z / at.tau, step
        since = 0 if off.error < least / 2 else since + 1
        best, least = (at, off.error) if off.error < least else (best, least)
        if (
            least <= _ENDS[min(since, len(_ENDS) - 1)]
            or not np.isfinite(off.error)
            or at.tau <= _NO_OPTIMUM * at.kappa
        ):
            break
        try:
            newton = _Newton(program, cones, at, off)
            ahead = newton.direction()
            way = newton.direction((1 - min(1.0, newton.longest(ahead))) ** 3, ahead)
            at = at.moved(way, min(1.0, _STAY * newton.longest(way)))
        except (ArithmeticError, np.linalg.LinAlgError):
            break
    if least > _NEARLY:
        raise ArithmeticError("rounding leaves no step towards an optimum")
    return (
        "Solved" if least <= _ENOUGH else "AlmostSolved",
        best.y / best.tau,
        best.z / best.tau,
        step,
    )


class _Newton:
    """Newton's directions at a point."""

    def __init__(self, program: Condensed, cones: Cones, at: _Point, off: _Residuals) -> None:
        self._program, self._cones, self._at, self._off = program, cones, at, off
        self._scaling = Scaling(cones, at.s, at.z)
        self._solve = Equations(program, self._scaling).solved
        if at.tau < at.kappa:
            self._y, self._z = self._solve(-program.objective, program.right)
        # towards an optimum the same, all of which would be lost in its own rounding in the end
        else:
            y, z = self._solve(-off.dual, 2 * at.s - off.primal)
            self._y, self._z = (at.y + y) / at.tau, (at.z + z) / at.tau
        self._slope = at.kappa / at.tau + float((self._scaling.times(self._z) ** 2).sum())

    def direction(self, share: float = 0.0, ahead: _Point | None = None) -> _Point:
        """To the point whose cones all have this share of their mean work, with the curvature that the way ahead has met; by default to the end."""
        at, off, scaling, cones, program = (
            self._at,
            self._off,
            self._scaling,
            self._cones,
            self._program,
        )
        work, number = (
            cones.product(scaling.point, scaling.point) - share * off.work * cones.unit,
            at.kappa * at.tau - share * off.work,
        )
        if ahead is not None:
            work = work + cones.product(scaling.over(ahead.s), scaling.times(ahead.z))
            number += ahead.kappa * ahead.tau
        back = scaling.times(cones.quotient(scaling.point, work))
        y, z = self._solve(-(1 - share) * off.dual, back - (1 - share) * off.primal)
        tau = (
            float(
                (1 - share) * off.gap - number / at.tau + program.objective @ y + program.right @ z
            )
            / self._slope
        )
        y, z = y + tau * self._y, z + tau * self._z
        s = (
            tau * program.right - (1 - share) * off.primal - program.rows(y)
        )  # by the rows: what the multipliers say of it has their rounding
        return _Point(y, s, z, tau, -(number + at.kappa * tau) / at.tau)

    def mended(self, at: _Point, off: _Residuals) -> _Point:
        """A later point without what it misses of rows and multipliers alone, which is not lost in the rounding of a whole step."""
        y, z = self._solve(-off.dual, -off.primal)
        way, scaling = (
            _Point(y, -off.primal - self._program.rows(y), z, 0.0, 0.0),
            Scaling(self._cones, at.s, at.z),
        )
        return at.moved(
            way,
            min(
                1.0,
                _STAY
                * min(scaling.longest(scaling.over(way.s)), scaling.longest(scaling.times(way.z))),
            ),
        )

    def longest(self, way: _Point) -> float:
        """The largest step that stays within the cones."""
        at, scaling = self._at, self._scaling
        numbers = [
            -value / change
            for value, change in ((at.tau, way.tau), (at.kappa, way.kappa))
            if change < 0
        ]
        return min(
            scaling.longest(scaling.over(way.s)), scaling.longest(scaling.times(way.z)), *numbers
        )
