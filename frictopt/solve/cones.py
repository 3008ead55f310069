"""Products of cones `|s[1:]| <= s[0]`, and their scaling by Nesterov & Todd (1997): the arithmetic of an interior point.

A number >= 0 is a cone of dimension 1. Vectors have the parts of all cones; those of a group of equal dimension d are (n, d) here.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import csr_array

from ..contact import Array, Integers


class Cones:
    """A product of cones, by the indices of their parts: (n, d) for each dimension d."""

    def __init__(self, groups: Sequence[Integers]) -> None:
        self.groups, self.size, self.degree = groups, sum(group.size for group in groups), sum(len(group) for group in groups)
        self.unit = self.each(lambda s: np.eye(1, s.shape[1]).repeat(len(s), axis=0), np.empty(self.size))

    def each(self, function: Callable[..., Array], *vectors: Array) -> Array:
        """What a function of the parts of vectors, (n, d) each, makes of all groups."""
        found = np.empty(self.size)
        for group in self.groups:
            found[group] = function(*(vector[group] for vector in vectors))
        return found

    def product(self, one: Array, other: Array) -> Array:
        """Jordan's product `one o other`."""
        return self.each(lambda a, b: np.column_stack([(a * b).sum(axis=1), a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:]]), one, other)

    def quotient(self, one: Array, other: Array) -> Array:
        """The x with `one o x = other`."""

        def divided(a: Array, b: Array) -> Array:
            first = (_turned(a) * b).sum(axis=1) / _square(a)
            return np.column_stack([first, (b[:, 1:] - first[:, None] * a[:, 1:]) / a[:, :1]])

        return self.each(divided, one, other)


class Scaling:
    """The symmetric W with `W z = W^-1 s = point`, for s and z within the cones.

    For each cone W is `eta (2 v v' - J)` with some v, J the reflection that turns all but the first part, and w as in `_weights`.
    """

    def __init__(self, cones: Cones, s: Array, z: Array) -> None:
        self._cones, self._weights = cones, [_weights(s[group], z[group]) for group in cones.groups]
        self.point = self.times(z)

    def times(self, x: Array) -> Array:
        """`W x`."""
        return self._applied(x, 1.0)

    def over(self, x: Array) -> Array:
        """`W^-1 x`."""
        return self._applied(x, -1.0)

    def _applied(self, x: Array, sense: float) -> Array:
        found = np.empty(self._cones.size)
        for group, (w, eta) in zip(self._cones.groups, self._weights, strict=True):
            part = x[group]
            first, along = part[:, 0], (w[:, 1:] * part[:, 1:]).sum(axis=1)
            turn = sense * first + along / (1 + w[:, 0])
            found[group] = np.column_stack([w[:, 0] * first + sense * along, part[:, 1:] + turn[:, None] * w[:, 1:]]) * eta[:, None] ** sense
        return found

    def inverse_square(self) -> csr_array:
        """`W^-2`, a block for each cone."""
        rows, columns, entries = list[Integers](), list[Integers](), list[Array]()
        for group, (w, eta) in zip(self._cones.groups, self._weights, strict=True):
            d, v = group.shape[1], _turned(w)
            rows.append(group.repeat(d, axis=1).ravel())
            columns.append(np.tile(group, d).ravel())
            entries.append(((2 * v[:, :, None] * v[:, None] - _turned(np.eye(d))) / eta[:, None, None] ** 2).ravel())
        return csr_array((np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))), shape=(self._cones.size,) * 2)

    def longest(self, direction: Array) -> float:
        """The largest step from `point` in a direction that stays within the cones."""
        steepest = 0.0
        for group in self._cones.groups:
            point, along = self.point[group], direction[group]
            size = np.sqrt(_square(point))[:, None]
            point, along = point / size, along / size
            ahead = (_turned(point) * along).sum(axis=1)
            turn = (ahead + along[:, 0]) / (point[:, 0] + 1)
            aside = np.linalg.norm(along[:, 1:] - turn[:, None] * point[:, 1:], axis=1)
            steepest = max(steepest, float((aside - ahead).max(initial=0.0)))
        return 1 / steepest if steepest > 0 else np.inf


def _weights(s: Array, z: Array) -> tuple[Array, Array]:
    """The unit vector w (n, d), and eta (n,), with `w = W e / eta`; an ArithmeticError at the end of a cone."""
    if not min(_square(s).min(), _square(z).min()) > 0:
        raise ArithmeticError("rounding leaves the point at the end of a cone")
    sizes = np.sqrt(_square(s)), np.sqrt(_square(z))
    s, z = s / sizes[0][:, None], z / sizes[1][:, None]
    middle = np.sqrt((1 + (s * z).sum(axis=1)) / 2)
    return (s + _turned(z)) / (2 * middle[:, None]), np.sqrt(sizes[0] / sizes[1])


def _turned(x: Array) -> Array:
    return np.column_stack([x[:, :1], -x[:, 1:]])


def _square(x: Array) -> Array:
    """`x[0]^2 - |x[1:]|^2`, without most of its rounding."""
    size = np.linalg.norm(x[:, 1:], axis=1)
    return np.asarray((x[:, 0] - size) * (x[:, 0] + size))
