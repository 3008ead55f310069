"""A cone program without the unknowns that its equations determine."""

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array, hstack

from ..base import CONDENSATION, RESIDUAL, Array, Integers
from .arrays import Arrays, columns


class Condensed:
    """The rows `right - A y` in cones, and `objective @ y + constant`.

    Each equation of the program eliminates one unknown. Equations that follow from others, as those
    of a node without friction at several corners, eliminate none.
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
        self.block[: len(dense)] = program.block[:, self._remaining]
        if zero:
            self.block[: len(dense)] += dense @ self._rest
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
        """The x and multipliers of the program."""
        program = self._program
        x = np.empty(len(program.cost))
        x[self._remaining] = y
        x[self._pivots] = self._start + self._rest @ y
        off = program.cost + columns(program.sparse[program.zero :], program.block, z)
        of_equations = np.zeros(program.zero)
        of_equations[self._equations] = -np.linalg.solve(self._square.T, off[self._pivots])
        return x, np.concatenate([of_equations, z])


def _independent(equations: Array, right: Array) -> Integers:
    """The equations from which the others follow; an error if they contradict each other."""
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
