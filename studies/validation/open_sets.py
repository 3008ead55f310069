"""Largest load factor with given nodes open at the corners of a cycle.

A plain linear program of scipy has all slips and gaps as unknowns.
"""

from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import linprog

import frictopt as fo


def largest_with_open(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, opened: Any, most: float
) -> tuple[float, Any, Any] | None:
    """The largest load factor up to `most`, with slips and gaps (K, N) at the corners.

    The nodes `opened` (K, N) are open. A node that is closed at two consecutive corners has the
    same slip at both corners. None if no state obeys the contact law.
    """
    n = system.nodes
    corners = len(cycle.corners)
    f = np.broadcast_to(friction, n)
    S = system.S / system.stiffness_scale
    force = float(np.abs(system.reaction(cycle.mean)).sum()) or 1.0
    gap = system.gap * system.stiffness_scale / force
    cyclic = most * np.hstack(cycle.corner_reactions(system)) / force
    constant = np.concatenate(system.reaction(cycle.mean)) / force - S @ np.r_[np.zeros(n), gap]

    # The unknowns are the load factor over `most`, then slips and total gaps corner by corner.
    size = 1 + 2 * n * corners
    equal: list[tuple[Any, float]] = []
    less: list[tuple[Any, float]] = []
    for k in range(corners):
        at_corner = slice(1 + 2 * n * k, 1 + 2 * n * (k + 1))
        forces = np.zeros((2 * n, size))
        forces[:, 0] = cyclic[k]
        forces[:, at_corner] = S
        moved = np.eye(size)[at_corner]
        before = np.eye(size)[1 + 2 * n * ((k - 1) % corners) :][:n]
        for i in range(n):
            q, q0 = forces[i], float(constant[i])
            p, p0 = forces[n + i], float(constant[n + i])
            if opened[k, i]:
                equal += [(q, -q0), (p, -p0)]
                less.append((-moved[n + i], 0.0))
                continue
            equal.append((moved[n + i], 0.0))
            less += [(q - f[i] * p, f[i] * p0 - q0), (-q - f[i] * p, f[i] * p0 + q0), (-p, p0)]
            if corners > 1 and not opened[k - 1, i]:
                equal.append((moved[i] - before[i], 0.0))

    left, right = zip(*less, strict=True)
    equal_left, equal_right = zip(*equal, strict=True)
    cost = np.r_[-1.0, np.zeros(size - 1)]
    bounds = [(0.0, 1.0)] + [(None, None)] * (size - 1)
    # The friction may be as small as the default tolerances.
    tolerances = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    answer = linprog(cost, left, right, equal_left, equal_right, bounds, options=tolerances)
    if answer.status != 0:
        return None
    motions = answer.x[1:].reshape(corners, 2, n) * force / system.stiffness_scale
    return most * float(answer.x[0]), motions[:, 0], np.maximum(motions[:, 1], 0.0)


def every_set(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, most: float
) -> list[tuple[float, Any, Any]]:
    """Answers of `largest_with_open` for all sets of open nodes, largest load factor first."""
    shape = len(cycle.corners), system.nodes
    answers = []
    for chosen in product((False, True), repeat=shape[0] * shape[1]):
        opened = np.array(chosen).reshape(shape)
        answer = largest_with_open(system, cycle, friction, opened, most)
        if answer is not None:
            answers.append(answer)
    return sorted(answers, key=lambda answer: -answer[0])
