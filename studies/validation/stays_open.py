"""Load factors that are safe with nodes that stay open, for all sets of open nodes.

Plain linear programs of scipy have the slips of the closed nodes as unknowns. These programs share
no code with the search of open nodes.
"""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import linprog

import frictopt as fo


def interval_of_set(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, opened: Any
) -> tuple[float, float] | None:
    """The least and the largest safe load factor with these nodes open.

    None if no load factor is safe, or if the closed nodes do not hold the open nodes.
    """
    n = system.nodes
    S = system.S / system.stiffness_scale
    force = float(np.abs(np.concatenate(system.reaction(cycle.mean))).sum()) or 1.0
    gap = system.gap * system.stiffness_scale / force
    f = np.broadcast_to(friction, n)
    closed = np.flatnonzero(~opened)
    free = np.flatnonzero(np.tile(opened, 2))
    # A motion that nothing holds has no stiffness but the rounding of the condensed matrix.
    if len(free) and np.linalg.cond(S[np.ix_(free, free)]) > 1e12:
        return None
    mean = np.concatenate(system.reaction(cycle.mean)) / force
    # The columns are the load factor, the slips of the closed nodes, and 1.
    rows = []
    for corner in np.hstack(cycle.corner_reactions(system)) / force:
        constant = mean - S[:, n + closed] @ gap[closed]
        forces = np.column_stack([corner, S[:, closed], constant])
        if len(free):
            motion = -np.linalg.solve(S[np.ix_(free, free)], forces[free])
            forces = forces + S[:, free] @ motion
            gaps = motion[len(free) // 2 :].copy()
            gaps[:, -1] += gap[opened]
            rows.append(gaps)
        q, p = forces[closed], forces[n + closed]
        rows += [f[closed, None] * p - q, f[closed, None] * p + q, p]
    inequalities = np.vstack(rows)
    ends = []
    for sense in (1.0, -1.0):
        cost = np.r_[sense, np.zeros(len(closed))]
        answer = linprog(
            cost,
            -inequalities[:, :-1],
            inequalities[:, -1],
            bounds=[(0, None)] + [(None, None)] * len(closed),
            # The default of 1e-7 hides the limits of contacts of little friction.
            options={"primal_feasibility_tolerance": 1e-10},
        )
        if answer.status not in (0, 3):
            return None
        ends.append(np.inf if answer.status == 3 else float(answer.x[0]))
    return ends[0], ends[1]


def intervals(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any
) -> Iterator[tuple[float, float]]:
    """The intervals of all sets except the set of all nodes."""
    for opened in product((False, True), repeat=system.nodes):
        if not all(opened):
            found = interval_of_set(system, cycle, friction, np.array(opened))
            if found is not None:
                yield found


def intervals_in_space(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float
) -> Iterator[tuple[float, float]]:
    """The safe load factors of all sets of open nodes, each by a program of its own."""
    for opened in product((False, True), repeat=system.nodes):
        try:
            limit = fo.shakedown_limit(system, cycle, friction, open_nodes=opened, progress=False)
        except fo.FrictoptError:
            # The closed nodes do not hold the open nodes, or rounding hides the answer.
            continue
        if not np.isnan(limit.load_factor):
            yield limit.least, limit.load_factor


def reach(known: list[tuple[float, float]], load_factor: float, alike: float = 1e-7) -> float:
    """The load factor up to which all load factors from `load_factor` on are safe with some set."""
    for least, largest in sorted(known):
        if least <= load_factor * (1 + alike) + alike:
            load_factor = max(load_factor, largest)
    return load_factor
