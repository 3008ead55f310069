"""References without rounding: a solver in doubles proposes a basis, which is solved in rational arithmetic and proven optimal.

Doubles are rational numbers, so the linear program and the contact law that they state have exact
answers. A square system is solved by iterative refinement: the residual is computed with Python's
fractions, without rounding, and each correction in doubles gains some ten digits, until forty are
right. That takes milliseconds where elimination in fractions takes minutes. Whether the basis is
the right one is then read off the exact solution: every other row holds and no multiplier is
negative.
"""

from fractions import Fraction
from typing import Any

import numpy as np

import frictopt as fo

Array = np.ndarray[Any, Any]

_DIGITS = Fraction(
    1, 10**40
)  # residual of a refined solution, over the size of its right-hand side
_OPEN = 2  # status of a node that is open
_ZERO = Fraction(
    1, 10**30
)  # slacks and multipliers above minus this, over their sizes, count as not negative


class NotProven(ArithmeticError):
    """The exact solution of the proposed basis breaks a condition of the optimum."""


def fractions(values: Any) -> Array:
    """Array of the rational numbers that these doubles are."""
    array = np.asarray(values, dtype=float)
    return np.array([Fraction(value) for value in array.ravel().tolist()] + [None], dtype=object)[
        :-1
    ].reshape(array.shape)


def refined(matrix: Array, right: Array) -> Array:
    """Solution of a square system of rational numbers, refined until its exact residual is below 1e-40 of the right-hand side.

    Raises
    ------
    NotProven
        The matrix is singular, or too close to it for doubles to gain a digit.
    """
    try:
        inverse = np.linalg.inv(matrix.astype(float))
    except np.linalg.LinAlgError as error:
        raise NotProven("the basis is singular") from error
    solution, residual = np.array([Fraction(0)] * len(right), dtype=object), right
    size = left = max(abs(right), default=Fraction(0))
    while left > _DIGITS * size:
        correction = inverse @ (residual / left).astype(float)
        solution = solution + fractions(correction) * left
        residual = right - matrix @ solution
        before, left = left, max(abs(residual))
        if not left < before / 2:
            raise NotProven(
                f"refinement leaves a residual of {float(left / size):.0e}; the basis is singular"
            )
    return solution


def exact_guaranteed_limit(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float, node: int, active: Array
) -> float:
    """Least load factor at which a safe slip holds a node on both its bounds.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and one coefficient of friction.
    node
        The node.
    active
        Proposed rows of the vertex, of those of `safe_rows`; with both rows of the node.

    Raises
    ------
    NotProven
        No vertex near the proposed one is the optimum.
    """
    matrix, right, cyclic, _ = safe_rows(system, cycle, friction)
    both = [
        node,
        system.nodes + node,
        # an equation is two rows, of which the vertex has the one with a multiplier that is not
        # negative
    ]
    matrix, right = np.concatenate([matrix, -matrix[both]]), np.concatenate([right, -right[both]])
    falling = np.column_stack(
        [matrix, np.concatenate([cyclic, -cyclic[both]])]
    )  # in minus the load factor
    active = np.array(active)
    multipliers = refined(
        -falling[active].T,
        np.array([Fraction(0)] * (len(active) - 1) + [Fraction(1)], dtype=object),
    )
    for number, row in enumerate(both):
        (place,) = np.flatnonzero(active == row)
        if multipliers[place] < 0:
            active[place] = 2 * system.nodes + number
    return -largest(falling, right, active)


def exact_increment(
    system: fo.ContactSystem,
    friction: float,
    slip: Array,
    bonded: tuple[Array, Array],
    status: Array,
) -> Array:
    """(N,) exact slip after an increment, from the status that each node has after it: -1, 0 or 1, and 2 where it is open.

    Raises
    ------
    NotProven
        The status contradicts its own exact state.
    """
    n, f, opened = system.nodes, Fraction(friction), status == _OPEN
    S, before = fractions(system.S), fractions(slip)
    r = fractions(np.concatenate(bonded)) + S[:, :n] @ before
    sense = np.array([Fraction(int(value)) for value in np.where(opened, 0, status)], dtype=object)
    moving, lifted = np.flatnonzero(status), n + np.flatnonzero(opened)
    free = np.concatenate([moving, lifted])
    law = np.concatenate(
        [r[moving] + f * sense[moving] * r[n + moving], r[lifted]]
    )  # vanishes: q of open nodes, q + f p or q - f p, p of open ones
    rows = np.concatenate([S[moving] + f * sense[moving, None] * S[n + moving], S[lifted]])
    change = np.array([Fraction(0)] * (2 * n), dtype=object)
    change[free] = refined(rows[:, free], -law)
    r = r + S @ change
    q, p, size = r[:n], r[n:], sum(abs(r[n:])) / n
    if (
        max(abs(q) - f * p) > _ZERO * size or min(sense * change[:n]) < 0 or min(change[n:]) < 0
    ):  # a pull breaks the bound as well
        raise NotProven("the status of the increment contradicts its own exact state")
    return np.asarray(before + change[:n], dtype=float)


def safe_rows(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float
) -> tuple[Array, Array, Array, Fraction]:
    """Rows `matrix z >= right + load_factor * cyclic` of safe slips in z, the first N - 1 slips, and the mean friction bound.

    The last slip is minus the sum of the others: a punch that only its loads hold may slide as a
    whole, which stresses nothing, and which doubles resist by their rounding alone.
    """
    f = Fraction(friction)
    q0, p0 = (fractions(values) for values in cycle.mean_reaction(system))
    corners = [
        (fractions(q), fractions(p)) for q, p in zip(*cycle.corner_reactions(system), strict=True)
    ]
    A, B = fractions(system.A), fractions(system.B)
    rows = np.concatenate([f * B + A, f * B - A])
    cyclic = np.concatenate(
        [
            np.max([-(q + f * p) for q, p in corners], axis=0),
            np.max([q - f * p for q, p in corners], axis=0),
        ]
    )
    return (
        rows[:, :-1] - rows[:, -1:],
        -np.concatenate([f * p0 + q0, f * p0 - q0]),
        cyclic,
        f * sum(p0) / len(p0),
    )


def largest(matrix: Array, right: Array, active: Array) -> float:
    """Largest last unknown of `matrix z >= right`: exact simplex steps from the vertex with the rows `active` to the optimal one.

    Raises
    ------
    NotProven
        No vertex near the proposed one is the optimum.
    """
    objective = np.array([Fraction(0)] * (matrix.shape[1] - 1) + [Fraction(1)], dtype=object)
    size = np.abs(matrix.astype(float)).max(axis=1)
    active = np.array(active)
    for _ in range(matrix.shape[1]):
        z = refined(matrix[active], right[active])
        slack = matrix @ z - right
        slack[active] = Fraction(0)
        entering = int((slack.astype(float) / size).argmin())
        multipliers = refined(-matrix[active].T, objective)
        if min(multipliers) < -_ZERO * max(multipliers):
            raise NotProven(
                f"the proposed vertex has the negative multiplier {float(min(multipliers)):.1e}"
            )
        if slack[entering] >= -_ZERO * max(abs(right)):
            return float(z[-1])
        active[_leaving(multipliers, refined(matrix[active].T, matrix[entering]))] = entering
    raise NotProven("the proposed vertex is far from the optimal one")


def _leaving(multipliers: Array, combination: Array) -> int:
    """Row that leaves the vertex for a violated one (dual simplex): the multipliers stay not negative."""
    candidates = [
        (y / share, index)
        for index, (y, share) in enumerate(zip(multipliers, combination, strict=True))
        if share > 0
    ]
    if not candidates:
        raise NotProven("no slip is safe")
    _, leaving = min(candidates)
    return leaving
