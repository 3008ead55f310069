"""References without rounding, in rational arithmetic.

Doubles are rational numbers, so a linear program or a contact law with doubles as data has an exact
answer. A solver in doubles proposes a basis. Iterative refinement solves its square system.
Python's fractions compute the residual without rounding, and each correction in doubles gains about
ten digits, until forty digits are right. That takes milliseconds, while elimination in fractions
takes minutes. The exact solution then shows whether the basis is optimal: every other row holds,
and no multiplier is negative.
"""

from fractions import Fraction
from typing import Any

import numpy as np

import frictopt as fo

Array = np.ndarray[Any, Any]

# Residual of a refined solution, relative to the size of its right-hand side.
_DIGITS = Fraction(1, 10**40)
# Status of an open node.
_OPEN = 2
# A slack or multiplier counts as negative only below minus this share of its size.
_ZERO = Fraction(1, 10**30)


class NotProven(ArithmeticError):
    """The exact solution of the proposed basis breaks a condition of the optimum."""


def fractions(values: Any) -> Array:
    """Array of the rational numbers that equal these doubles."""
    array = np.asarray(values, dtype=float)
    result = np.empty(array.size, dtype=object)
    result[:] = [Fraction(value) for value in array.ravel().tolist()]
    return result.reshape(array.shape)


def refined(matrix: Array, right: Array) -> Array:
    """Solution of a square system of rational numbers by iterative refinement.

    The exact residual is below 1e-40 of the right-hand side.

    Raises
    ------
    NotProven
        The matrix is singular, or so close to singular that doubles gain no digit.
    """
    try:
        inverse = np.linalg.inv(matrix.astype(float))
    except np.linalg.LinAlgError as error:
        raise NotProven("the basis is singular") from error
    solution = np.array([Fraction(0)] * len(right), dtype=object)
    residual = right
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
        Proposed rows of the vertex, numbered as in `safe_rows`, with both rows of the node.

    Raises
    ------
    NotProven
        No vertex near the proposed vertex is the optimum.
    """
    matrix, right, cyclic, _ = safe_rows(system, cycle, friction)
    both = [
        node,
        system.nodes + node,
        # An equation is two rows. The vertex has the row whose multiplier is not negative.
    ]
    matrix, right = np.concatenate([matrix, -matrix[both]]), np.concatenate([right, -right[both]])
    # The last unknown is minus the load factor.
    falling = np.column_stack([matrix, np.concatenate([cyclic, -cyclic[both]])])
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
    """(N,) exact slip after an increment, from the status of each node after the increment.

    The status is -1, 0 or 1, and 2 for an open node.

    Raises
    ------
    NotProven
        The exact state contradicts the status.
    """
    n = system.nodes
    f = Fraction(friction)
    opened = status == _OPEN
    S = fractions(system.S)
    before = fractions(slip)
    r = fractions(np.concatenate(bonded)) + S[:, :n] @ before
    sense = np.array([Fraction(int(value)) for value in np.where(opened, 0, status)], dtype=object)
    moving, lifted = np.flatnonzero(status), n + np.flatnonzero(opened)
    free = np.concatenate([moving, lifted])
    # These sums vanish: q + f p or q - f p of nodes that slip, and q and p of open nodes.
    law = np.concatenate([r[moving] + f * sense[moving] * r[n + moving], r[lifted]])
    rows = np.concatenate([S[moving] + f * sense[moving, None] * S[n + moving], S[lifted]])
    change = np.array([Fraction(0)] * (2 * n), dtype=object)
    change[free] = refined(rows[:, free], -law)
    r = r + S @ change
    q = r[:n]
    p = r[n:]
    size = sum(abs(p)) / n
    # A negative pressure exceeds the friction bound as well.
    if max(abs(q) - f * p) > _ZERO * size or min(sense * change[:n]) < 0 or min(change[n:]) < 0:
        raise NotProven("the status of the increment contradicts its own exact state")
    return np.asarray(before + change[:n], dtype=float)


def safe_rows(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float
) -> tuple[Array, Array, Array, Fraction]:
    """Rows `matrix z >= right + load_factor * cyclic` of safe slips, and the mean friction bound.

    The unknowns z are the first N - 1 slips, and the last slip is minus their sum. This excludes a
    slide of the whole punch: if only loads hold the punch, a slide causes no stress, and only
    rounding resists it.
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
    """Largest last unknown of `matrix z >= right`, by exact simplex steps.

    The steps lead from the vertex with the rows `active` to the optimal vertex.

    Raises
    ------
    NotProven
        No vertex near the proposed vertex is the optimum.
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
    """Row that leaves the vertex for a violated row, so that no multiplier becomes negative.

    This is a step of the dual simplex method.
    """
    candidates = [
        (y / share, index)
        for index, (y, share) in enumerate(zip(multipliers, combination, strict=True))
        if share > 0
    ]
    if not candidates:
        raise NotProven("no slip is safe")
    _, leaving = min(candidates)
    return leaving
