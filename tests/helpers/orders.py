"""Largest load factor of a state of rest whose nodes open and close in a given order.

A plain linear program of scipy has all slips and gaps as unknowns.
"""

from itertools import pairwise, permutations, product

import numpy as np
from scipy.optimize import linprog


def every_order(nodes):
    """All orders in which each node opens or closes at most once.

    An order has the nodes that are open at the first corner, and one node at each event.
    """
    for at_first, at_last in product(product([False, True], repeat=nodes), repeat=2):
        changes = [i for i in range(nodes) if at_first[i] != at_last[i]]
        start = frozenset(i for i in range(nodes) if at_first[i])
        for order in permutations(changes):
            yield start, [frozenset({i}) for i in order]


def there_and_back(events):
    """The events of a load that goes to and fro, as events of both segments of its cycle."""
    return [(0, nodes) for nodes in events] + [(1, nodes) for nodes in reversed(events)]


def largest_round_a_cycle(contact, cycle, friction, start, events, most=30.0, at=None, margin=None):
    """The largest load factor up to `most` of a state of rest with events in a cycle.

    A plain linear program of scipy has all slips and gaps as unknowns. None: there is no state.
    `start` are the nodes open at the first corner. `events` are pairs of a segment and the nodes
    that open or close there. A node keeps its slip while it is closed. With `at`, the load factor
    is given, and the result shows whether a state of rest exists, or is the largest margin in the
    units `margin` (force, length).
    """
    n, S, corners = contact.nodes, contact.S, len(cycle.corners)
    fixed = [np.concatenate(contact.reaction(loads)) for loads in cycle.unscaled]
    fixed = [load - S[:, n:] @ contact.gap for load in fixed] * (corners if len(fixed) == 1 else 1)
    scaled = list(np.hstack(cycle.corner_reactions(contact)))
    instants, opened, count = [], frozenset(start), 0
    for segment in range(corners):
        instants.append((segment, None, opened, opened))
        for nodes in [nodes for of, nodes in events if of == segment]:
            instants.append((segment, count, opened, opened ^ nodes))
            opened, count = opened ^ nodes, count + 1
    assert opened == start
    friction = np.broadcast_to(friction, n)
    size, spare = 2 + count + 2 * n * len(instants), -1
    unit = np.eye(size)
    force, length = margin or (0.0, 0.0)
    equal, less = [], []

    def motion(m):
        return unit[1 + count + 2 * n * m : 1 + count + 2 * n * (m + 1)]

    def varies(segment):
        following = (segment + 1) % corners
        return scaled[following] - scaled[segment], fixed[following] - fixed[segment]

    for m, (segment, event, before, after) in enumerate(instants):
        u, later = motion(m), motion((m + 1) % len(instants))
        r = S @ u + np.outer(scaled[segment], unit[0])
        if event is not None:
            change, of_fixed = varies(segment)
            if at is not None:
                change = of_fixed + at * change
            elif of_fixed.any():
                assert not change.any()
                change = of_fixed
            r += np.outer(change, unit[1 + event])
        for i in range(n):
            q, p, w = r[i], r[n + i], u[n + i]
            if i in before or i in after:
                equal += [(q, -fixed[segment][i]), (p, -fixed[segment][n + i])]
            else:
                most_shear = friction[i] * fixed[segment][n + i]
                held = friction[i] * p - force * unit[spare]
                for sign in (1, -1):
                    less.append((sign * q - held, most_shear - sign * fixed[segment][i]))
            if i in before and i in after:
                less.append((length * unit[spare] - w, 0.0))
            else:
                equal.append((w, 0.0))
            if i not in after:
                equal.append((later[i] - u[i], 0.0))
    for segment in range(corners):
        places = [1 + event for of, event, *_ in instants if of == segment and event is not None]
        by_part = at is not None or varies(segment)[1].any()
        for one, other in pairwise([None, *places, "end"]):
            row = np.zeros(size) if one is None else unit[one].copy()
            if other != "end":
                less.append((row - unit[other], 0.0))
            elif one is not None:
                less.append((row, 1.0) if by_part else (row - unit[0], 0.0))
    (left, right), rows = zip(*less, strict=True), list(zip(*equal, strict=True)) or [None, None]
    exact = {"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9}
    aim, cap = (0, 0.0) if margin is None else (spare, 1.0)
    bounds = [(0, most) if at is None else (at, at)] + [(None, None)] * (size - 2) + [(None, cap)]
    answer = linprog(-unit[aim], left, right, *rows, bounds, options=exact)
    return float(answer.x[aim]) if answer.status == 0 else None
