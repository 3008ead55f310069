"""Largest load factor with given nodes open at the corners of a cycle: a plain linear program in all slips and gaps, by scipy."""

from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import linprog

import frictopt as fo


def largest_with_open(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, opened: Any, most: float
) -> tuple[float, Any, Any] | None:
    """Load factor up to `most`, slips and gaps (K, N) that obey the law at the corners with the nodes `opened` (K, N) open; None if there are none.

    A node that is closed at two corners in a row has the same slip there.
    """
    n, corners = system.nodes, len(cycle.corners)
    f = np.broadcast_to(friction, n)
    S, force = (
        system.S / system.stiffness_scale,
        float(np.abs(system.reaction(cycle.mean)).sum()) or 1.0,
    )
    gap = system.gap * system.stiffness_scale / force
    cyclic, size = most * np.hstack(cycle.corner_reactions(system)) / force, 1 + 2 * n * corners
    constant = np.concatenate(system.reaction(cycle.mean)) / force - S @ np.r_[np.zeros(n), gap]
    equal: list[tuple[Any, float]] = []
    less: list[tuple[Any, float]] = []
    for k in range(corners):
        forces, moved = np.zeros((2 * n, size)), np.eye(size)[1 + 2 * n * k : 1 + 2 * n * (k + 1)]
        forces[:, 0], forces[:, 1 + 2 * n * k : 1 + 2 * n * (k + 1)] = cyclic[k], S
        before = np.eye(size)[1 + 2 * n * ((k - 1) % corners) :][:n]
        for i in range(n):
            (q, q0), (p, p0) = ((forces[row], float(constant[row])) for row in (i, n + i))
            if opened[k, i]:
                equal += [(q, -q0), (p, -p0)]
                less.append((-moved[n + i], 0.0))
                continue
            equal.append((moved[n + i], 0.0))
            less += [(q - f[i] * p, f[i] * p0 - q0), (-q - f[i] * p, f[i] * p0 + q0), (-p, p0)]
            if corners > 1 and not opened[k - 1, i]:
                equal.append((moved[i] - before[i], 0.0))
    (left, right), (rows, most_of_rows) = zip(*less, strict=True), zip(*equal, strict=True)
    bounds = [(0.0, 1.0)] + [(None, None)] * (size - 1)
    exact = {
        "primal_feasibility_tolerance": 1e-10,
        "dual_feasibility_tolerance": 1e-10,
    }  # friction may be as little as the default ones
    answer = linprog(
        np.r_[-1.0, np.zeros(size - 1)], left, right, rows, most_of_rows, bounds, options=exact
    )
    if answer.status != 0:
        return None
    u = answer.x[1:].reshape(corners, 2, n) * force / system.stiffness_scale
    return most * float(answer.x[0]), u[:, 0], np.maximum(u[:, 1], 0.0)


def every_set(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, most: float
) -> list[tuple[float, Any, Any]]:
    """The same for every set of open nodes that has one, largest load factor first."""
    shape = len(cycle.corners), system.nodes
    sets = (
        np.array(chosen).reshape(shape)
        for chosen in product((False, True), repeat=shape[0] * shape[1])
    )
    found = [largest_with_open(system, cycle, friction, opened, most) for opened in sets]
    return sorted((claim for claim in found if claim is not None), key=lambda claim: -claim[0])
