"""Largest load factor of a state of rest whose nodes open and close in a given order.

A plain linear program of scipy has all slips and gaps as unknowns.
"""

from itertools import pairwise, permutations, product

import numpy as np
from scipy.optimize import linprog


def largest_in_order(contact, cycle, friction, start, events, most, margin=None):
    """The largest load factor up to `most` of a state of rest; None if there is no state.

    The nodes `start` are open at the first corner, and given nodes open or close at each event.
    Each node has one slip while it is closed. If `margin` has the units (force, length), the result
    is the largest margin at the load factor `most`.
    """
    n, S, between = contact.nodes, contact.S, [frozenset(start)]
    for event in events:
        between.append(between[-1] ^ event)
    before, after = [between[0], *between], [*between, between[-1]]
    r0 = np.concatenate(contact.reaction(cycle.mean)) - S[:, n:] @ contact.gap
    first, last = np.hstack(cycle.corner_reactions(contact))
    count = len(before)
    lam, slip, own = (
        0,
        slice(1, 1 + n),
        [slice(1 + n + 2 * n * m, 1 + n + 2 * n * (m + 1)) for m in range(count)],
    )
    way = [1 + n + 2 * n * count + m for m in range(count - 2)]
    size, spare = 2 + n + 2 * n * count + len(way), -1
    force, length = margin or (0.0, 0.0)
    equal, less = [], []
    for m in range(count):
        r, u = np.zeros((2 * n, size)), np.eye(size)[own[m]]
        r[:, own[m]], r[:, lam] = S, last if m == count - 1 else first
        if 0 < m < count - 1:
            r[:, way[m - 1]] = last - first
        for i in range(n):
            q, p, v, w = r[i], r[n + i], u[i], u[n + i]
            closed = (i not in before[m]) + (i not in after[m])
            if closed < 2:
                equal += [(q, -r0[i]), (p, -r0[n + i])]
            else:
                held = friction * p - force * np.eye(size)[spare]
                less += [(sign * q - held, friction * r0[n + i] - sign * r0[i]) for sign in (1, -1)]
            if closed:
                equal += [(w, 0.0), (v - np.eye(size)[slip][i], 0.0)]
            else:
                less.append((length * np.eye(size)[spare] - w, 0.0))
    stages = [None, *way, lam]
    less += [
        (np.eye(size)[one] * (one is not None) - np.eye(size)[other], 0.0)
        if one is not None
        else (-np.eye(size)[other], 0.0)
        for one, other in pairwise(stages)
    ]
    (left, right), rows = zip(*less, strict=True), list(zip(*equal, strict=True)) or [None, None]
    exact = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    aim, least, cap = (lam, 0.0, 0.0) if margin is None else (spare, most, 1.0)
    bounds = [(least, most)] + [(None, None)] * (size - 2) + [(None, cap)]
    answer = linprog(-np.eye(size)[aim], left, right, *rows, bounds, options=exact)
    return float(answer.x[aim]) if answer.status == 0 else None


def every_order(nodes):
    """All orders in which each node opens or closes at most once.

    An order has the nodes that are open at the first corner, and one node at each event.
    """
    for at_first, at_last in product(product([False, True], repeat=nodes), repeat=2):
        changes = [i for i in range(nodes) if at_first[i] != at_last[i]]
        start = frozenset(i for i in range(nodes) if at_first[i])
        for order in permutations(changes):
            yield start, [frozenset({i}) for i in order]


def largest_round_a_cycle(contact, cycle, friction, start, events, most=30.0, at=None):
    """The largest load factor up to `most` of a state of rest with events in a cycle.

    A plain linear program of scipy has all slips and gaps as unknowns. None: there is no state.
    `start` are the nodes open at the first corner. `events` are pairs of a segment and the nodes
    that open or close there. A node keeps its slip while it is closed. With `at`, the load factor
    is given, and the result shows whether a state of rest exists.
    """
    n, S, corners = contact.nodes, contact.S, len(cycle.corners)
    fixed = [np.concatenate(contact.reaction(loads)) for loads in cycle.unscaled]
    fixed = [load - S[:, n:] @ contact.gap for load in fixed] * (corners if len(fixed) == 1 else 1)
    scaled = list(np.hstack(cycle.corner_reactions(contact)))
    instants, opened, count = [], frozenset(start), 0
    for leg in range(corners):
        instants.append((leg, None, opened, opened))
        for nodes in [nodes for of, nodes in events if of == leg]:
            instants.append((leg, count, opened, opened ^ nodes))
            opened, count = opened ^ nodes, count + 1
    assert opened == start
    size = 1 + count + 2 * n * len(instants)
    unit = np.eye(size)
    equal, less = [], []

    def motion(m):
        return unit[1 + count + 2 * n * m : 1 + count + 2 * n * (m + 1)]

    def varies(leg):
        following = (leg + 1) % corners
        return scaled[following] - scaled[leg], fixed[following] - fixed[leg]

    for m, (leg, event, before, after) in enumerate(instants):
        u, later = motion(m), motion((m + 1) % len(instants))
        r = S @ u + np.outer(scaled[leg], unit[0])
        if event is not None:
            change, of_fixed = varies(leg)
            if at is not None:
                change = of_fixed + at * change
            elif of_fixed.any():
                assert not change.any()
                change = of_fixed
            r += np.outer(change, unit[1 + event])
        for i in range(n):
            q, p, w = r[i], r[n + i], u[n + i]
            if i in before or i in after:
                equal += [(q, -fixed[leg][i]), (p, -fixed[leg][n + i])]
            else:
                held = friction[i] * fixed[leg][n + i]
                for sign in (1, -1):
                    less.append((sign * q - friction[i] * p, held - sign * fixed[leg][i]))
            if i in before and i in after:
                less.append((-w, 0.0))
            else:
                equal.append((w, 0.0))
            if i not in after:
                equal.append((later[i] - u[i], 0.0))
    for leg in range(corners):
        places = [1 + event for of, event, *_ in instants if of == leg and event is not None]
        by_part = at is not None or varies(leg)[1].any()
        for one, other in pairwise([None, *places, "end"]):
            row = np.zeros(size) if one is None else unit[one].copy()
            if other != "end":
                less.append((row - unit[other], 0.0))
            elif one is not None:
                less.append((row, 1.0) if by_part else (row - unit[0], 0.0))
    (left, right), rows = zip(*less, strict=True), list(zip(*equal, strict=True)) or [None, None]
    exact = {"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9}
    bounds = [(0, most) if at is None else (at, at)] + [(None, None)] * (size - 1)
    answer = linprog(-unit[0], left, right, *rows, bounds, options=exact)
    return float(answer.x[0]) if answer.status == 0 else None
