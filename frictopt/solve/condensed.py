"""A cone program without the unknowns that its equations determine."""

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array, dia_array, hstack

from ..base import CONDENSATION, RESIDUAL, Array, Integers
from .arrays import Arrays, columns


class Condensed:
    """The rows `right - A y` in cones, and `objective @ y + constant`.

    Each equation of the program eliminates one of the unknowns x; y are the unknowns that are left.
    An equation that follows from other equations eliminates none. An example is a node without
    friction, which has the same equation at several corners.
    """

    def __init__(self, program: Arrays) -> None:
        width = len(program.cost)
        self._program = program
        equations = program.sparse[: program.zero]
        equations = equations[:, :width].toarray() + equations[:, width:] @ program.block
        self._equations = _independent(equations, program.right[: program.zero])
        equations = equations[self._equations]
        right = program.right[self._equations]
        zero = len(equations)
        if zero >= width:
            raise np.linalg.LinAlgError("as many equations as unknowns")
        self._pivots = qr(equations, mode="r", pivoting=True)[1][:zero] if zero else np.arange(0)
        self._remaining = np.delete(np.arange(width), self._pivots)
        # The eliminated unknowns are start + rest @ y.
        self._square = equations[:, self._pivots]
        self._start = np.linalg.solve(self._square, right)
        self._rest = np.linalg.solve(self._square, -equations[:, self._remaining])

        rows = program.sparse[program.zero :]
        dense = program.block[:, self._pivots]
        remaining = csr_array(rows[:, self._remaining])
        eliminated = (rows[:, width:], rows[:, self._pivots])
        # Stored by columns, because the equations of a step multiply its transpose.
        self.block = np.empty((len(dense) + zero, len(self._remaining)), order="F")
        self.block[: len(dense)] = program.block[:, self._remaining] + dense @ self._rest
        self.block[len(dense) :] = self._rest
        self.sparse = csr_array(hstack([remaining, *eliminated]))
        self.right = (
            program.right[program.zero :]
            - hstack(eliminated) @ np.r_[dense @ self._start, self._start]
        )
        self.objective = program.cost[self._remaining] + self._rest.T @ program.cost[self._pivots]
        self.constant = float(program.cost[self._pivots] @ self._start)

    def rows(self, y: Array) -> Array:
        """`A y`."""
        return np.asarray(self.sparse @ np.concatenate([y, self.block @ y]))

    def columns(self, z: Array) -> Array:
        """`A' z`."""
        return columns(self.sparse, self.block, z)

    def whole(self, y: Array, z: Array) -> tuple[Array, Array]:
        """The x and multipliers of the program, from the y and z of the rows in cones."""
        program = self._program
        x = np.empty(len(program.cost))
        x[self._remaining] = y
        x[self._pivots] = self._start + self._rest @ y
        multipliers = np.concatenate([np.zeros(program.zero), z])
        off = program.cost + program.columns(multipliers)
        multipliers[self._equations] = -np.linalg.solve(self._square.T, off[self._pivots])
        return x, multipliers


def _independent(equations: Array, right: Array) -> Integers:
    """Indices of equations from which all others follow; LinAlgError for a contradiction."""
    count = len(equations)
    if not count:
        return np.arange(0)
    _, triangle, order = qr(equations.T, mode="economic", pivoting=True)
    sizes = np.abs(np.diag(triangle))
    rank = int((sizes > CONDENSATION * sizes.max(initial=0.0)).sum())
    kept = np.sort(order[:rank])
    x = np.linalg.lstsq(equations[kept], right[kept])[0]
    if rank < count and np.abs(equations @ x - right).max() > RESIDUAL:
        raise np.linalg.LinAlgError("equations contradict each other")
    return kept


class Cones:
    """Cones `|s[1:]| <= s[0]` one after the other; a cone of size 1 is a number >= 0.

    The entries of s are its parts.
    """

    def __init__(self, sizes: Integers) -> None:
        self.heads = np.cumsum(sizes) - sizes
        self.of = np.repeat(np.arange(len(sizes)), sizes)  # the cone of each part
        self.size = len(self.of)
        self.degree = len(sizes)
        self.unit = (np.arange(self.size) == self.heads[self.of]).astype(float)
        self.tail = 1.0 - self.unit  # mask of all parts but the first
        self.turned = 2 * self.unit - 1.0  # signs that reverse these parts

    def sums(self, x: Array) -> Array:
        """The sum over the parts of each cone."""
        return np.add.reduceat(x, self.heads)

    def square(self, x: Array) -> Array:
        """`x[0]^2 - |x[1:]|^2` of each cone, kept positive in spite of rounding."""
        first = x[self.heads]
        size = np.sqrt(self.sums(self.tail * x**2))
        least = np.finfo(float).eps * first**2
        return np.asarray(np.maximum((first - size) * (first + size), least))

    def product(self, a: Array, b: Array) -> Array:
        """Jordan's product `a o b`."""
        product: Array = a[self.heads][self.of] * b + b[self.heads][self.of] * a
        product[self.heads] = self.sums(a * b)
        return product

    def quotient(self, a: Array, b: Array) -> Array:
        """The x with `a o x = b`."""
        first = self.sums(self.turned * a * b) / self.square(a)
        x: Array = (b - first[self.of] * a) / a[self.heads][self.of]
        x[self.heads] = first
        return x


class Scaling:
    """The symmetric W with `W z = W^-1 s = point`, for s and z within the cones.

    For each cone W is `eta (2 v v' - J)` with some v. J is the reflection that reverses all parts
    but the first. With the first unit vector e, `w = W e / eta` describes the scaling.
    ArithmeticError if s or z is on the boundary of a cone.
    """

    def __init__(self, cones: Cones, s: Array, z: Array) -> None:
        if not min(s[cones.heads].min(), z[cones.heads].min()) > 0:
            raise ArithmeticError("rounding has put the point on the boundary of a cone")
        self._cones = cones
        s_size = np.sqrt(cones.square(s))
        z_size = np.sqrt(cones.square(z))
        s_unit = s / s_size[cones.of]
        z_unit = z / z_size[cones.of]
        # The product of unit vectors in a cone is never less than 1, except by rounding.
        middle = np.sqrt((1 + np.maximum(cones.sums(s_unit * z_unit), 1.0)) / 2)
        self._w = (s_unit + cones.turned * z_unit) / (2 * middle[cones.of])
        self._eta = np.sqrt(s_size / z_size)
        self.point = self.times(z)

    def times(self, x: Array, sense: float = 1.0) -> Array:
        """`W x`, or `W^-1 x` for the sense -1."""
        cones, w = self._cones, self._w
        first = x[cones.heads]
        along = cones.sums(cones.tail * w * x)
        w_first = w[cones.heads]
        product = x + (sense * first + along / (1 + w_first))[cones.of] * w
        product[cones.heads] = w_first * first + sense * along
        return np.asarray(product * (self._eta**sense)[cones.of])

    def over(self, x: Array) -> Array:
        """`W^-1 x`."""
        return self.times(x, -1.0)

    def inverse_square(self, sparse: csr_array) -> csr_array:
        """`sparse' W^-2 sparse`.

        For each cone W^-2 is `(2 v v' - J) / eta^2` with `v = J w`.
        """
        cones = self._cones
        over_eta = 1 / self._eta[cones.of]
        vectors = np.sqrt(2.0) * over_eta * cones.turned * self._w
        places = np.arange(cones.size)
        across = csr_array((vectors, places, np.r_[cones.heads, cones.size])) @ sparse
        reflection = dia_array((cones.turned * over_eta**2, 0), shape=(cones.size,) * 2)
        return csr_array(across.T @ across - sparse.T @ (reflection @ sparse))

    def longest(self, direction: Array) -> float:
        """The largest step from `point` in a direction that stays within the cones."""
        cones = self._cones
        size = np.sqrt(cones.square(self.point))[cones.of]
        point = self.point / size
        along = direction / size
        ahead = cones.sums(cones.turned * point * along)
        turn = (ahead + along[cones.heads]) / (point[cones.heads] + 1)
        aside = np.sqrt(cones.sums(cones.tail * (along - turn[cones.of] * point) ** 2))
        steepest = float((aside - ahead).max(initial=0.0))
        return 1 / steepest if steepest > 0 else np.inf
