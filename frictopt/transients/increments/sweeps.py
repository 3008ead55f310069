"""One increment of load by Gauss-Seidel sweeps over the nodes, compiled: quick where few nodes move; Newton's method goes on from there.

The motions `u = [dv, w]` of an increment have t = 1 or 2 tangential parts at each node; its
reactions are `r + S (u - start)`.
"""

# Numba decides by the file of the outermost function whether its compiled code is still valid. So
# nothing that is compiled is imported.

import numpy as np

from ..exact.kernel import entry_point, inner

STICK, SLIP, OPEN = (
    0,
    1,
    2,
)  # copies of those in `begin.py`, and of a tolerance; a test compares them
_ROUNDING = 1e-12
_SWEEPS, _AMONG, _ROUNDS = (
    4,
    100,
    10,
)  # of an increment at most: over all nodes, then over those that move, in turn so often
_RELAX = 1.4  # of sweeps over the nodes that move: a third as many of them


@inner
def _move(S, u, r, k, to):
    """Move one motion to a value, and the reactions with it; returns the way."""
    way = to - u[k]
    u[k] = to
    if way != 0.0:
        for j in range(len(r)):
            r[j] += way * S[k, j]
    return abs(way)


@inner
def _pull(own, u, r, node):
    """Size of the shear force that a node would have if it did not slip, `|q - d dv|`."""
    total, nodes = 0.0, own.shape[1]
    for a in range(len(own) - 1):
        total += (r[a * nodes + node] - own[a, node] * u[a * nodes + node]) ** 2
    return np.sqrt(total)


@entry_point
def reactions(S, still, u):
    """`still + S u`, by the motions that are not zero: few of an increment are (S is symmetric: its rows are its columns)."""
    r = still.copy()
    for i in range(len(u)):
        if u[i] != 0.0:
            for k in range(len(r)):
                r[k] += u[i] * S[i, k]
    return r


@entry_point
def sweep(S, f, strength, own, u, r, most, enough, relax):
    """Gauss-Seidel on the projected law of one increment: the nodes one after the other, each with what it needs to obey it.

    Nodes that stick cost nothing but a look (Jourdan, Alart & Jean 1998). S is the stiffness (M,
    M), f (N,) friction, `strength` (N,) the largest shear of the surface. `own` (t + 1, N) are
    positive: for the tangents at least the largest stiffness of the node in any tangential
    direction, and its normal stiffness. Slip increments and gaps u and reactions r, (M,), are
    changed in place, in so many sweeps at `most`, until corrections of forces are `enough`. `relax`
    is the share of what a slip lacks by which it changes: with 1 the node obeys the law then, with
    a little more fewer sweeps do. Returns the largest correction of the last sweep.
    """
    nodes, tangents, largest = len(f), len(own) - 1, np.inf
    wanted = np.empty(tangents)
    for _ in range(most):
        largest = 0.0
        for node in range(nodes):
            k = tangents * nodes + node
            lifted = u[k] - r[k] / own[-1, node]
            largest = max(
                largest, own[-1, node] * _move(S, u, r, k, lifted if lifted >= 0 else 0.0)
            )
            bound, size = (
                min(f[node] * max(r[k] - own[-1, node] * u[k], 0.0), strength[node]),
                _pull(own, u, r, node),
            )
            for a in range(tangents):
                before, k = u[a * nodes + node], a * nodes + node
                wanted[a] = (
                    before
                    - relax * (bound / size * before + (1 - bound / size) * r[k] / own[a, node])
                    if size > bound
                    else 0.0
                )
            for a in range(tangents):
                largest = max(largest, own[a, node] * _move(S, u, r, a * nodes + node, wanted[a]))
        if largest <= enough:
            break
    return largest


@inner
def _sweep_moving(S, f, strength, own, u, r):
    """Sweeps over the nodes that move, among themselves: u is changed in place, r is not; returns the largest correction of the last one."""
    axes, nodes = own.shape
    moving = np.flatnonzero((u.reshape(axes, nodes) != 0.0).sum(axis=0))
    part = np.concatenate((moving, moving + nodes, moving + 2 * nodes))[
        : axes * len(moving)
    ].astype(np.uintp)  # without a sign: quicker
    stiffness = np.empty((len(part), len(part)))
    for i in range(len(part)):
        for j in range(len(part)):
            stiffness[i, j] = S[part[i], part[j]]
    few, among = u[part], r[part]
    largest = sweep(
        stiffness,
        f[moving],
        strength[moving],
        own[:, moving],
        few,
        among,
        _AMONG,
        0.1 * _ROUNDING,
        _RELAX,
    )
    u[part] = few
    return largest


@entry_point
def increment(S, f, strength, own, size, u, r, forces, status):
    """One increment by sweeps over all nodes, then over those that move, in turn until the state obeys the law.

    See `sweep`, which takes `size` for its `own`; `own` here is that of the law. `forces` (M,) and
    `status` (N,) take the reactions with slipping nodes exactly on their bound and open ones
    without any, and the statuses. Returns the largest violation of the contact law, as `off_law`
    has it; inf where a number is not finite.
    """
    still, off = reactions(S, r, -u), np.inf
    for _ in range(_ROUNDS):
        last = sweep(S, f, strength, size, u, r, _SWEEPS, _ROUNDING, 1.0) <= _ROUNDING
        last = not _sweep_moving(S, f, strength, size, u, r) <= _ROUNDING or last
        r[:] = reactions(S, still, u)
        if _take_piece(f, strength, own, u, r, status):
            r[:] = reactions(S, still, u)
        off = _put_on_law(f, strength, own, u, r, forces, status)
        if last or off <= _ROUNDING:
            break
    return off


@inner
def _take_piece(f, strength, own, u, r, status):
    """Take the piece of the law at hand: statuses, and motions that it lets vanish; returns whether one has changed."""
    nodes, tangents, changed = len(f), len(own) - 1, False
    for node in range(nodes):
        k = tangents * nodes + node
        pressed = r[k] - own[-1, node] * u[k]
        slips = _pull(own, u, r, node) > min(f[node] * max(pressed, 0.0), strength[node])
        status[node] = OPEN if pressed <= 0 else SLIP if slips else STICK
        for i in range(node, len(u), nodes):
            exact = (
                0.0
                if status[node] == STICK or (i == k and status[node] != OPEN)
                else max(u[i], 0.0)
                if i == k
                else u[i]
            )
            if exact != u[i]:
                u[i], changed = exact, True
    return changed


@inner
def _put_on_law(f, strength, own, u, r, forces, status):
    """Reactions with slipping nodes on their bound and open ones without any; returns the residual of the law and of the equilibrium."""
    nodes, tangents = len(f), len(own) - 1
    off, total = 0.0, 0.0
    for node in range(nodes):
        k, pull = tangents * nodes + node, _pull(own, u, r, node)
        bound, size, way, along = min(f[node] * r[k], strength[node]), 0.0, 0.0, 0.0
        for i in range(node, k + 1, nodes):
            forces[i] = r[i] if status[node] != OPEN else 0.0
            if i != k and status[node] == SLIP:
                forces[i] = bound * (r[i] - own[i // nodes, node] * u[i]) / pull
            if i != k:
                size, way, along = size + forces[i] ** 2, way + u[i] ** 2, along + u[i] * forces[i]
            off, total = max(off, abs(forces[i] - r[i])), total + abs(forces[i]) + abs(u[i])
        size, way, off = np.sqrt(size), np.sqrt(way), max(off, -forces[tangents * nodes + node])
        if status[node] != OPEN:
            off = max(off, size - bound)
        if status[node] == SLIP and size > 0 and way > 0:
            turned, across = 0.0, 0.0
            for i in range(node, k, nodes):
                turned += (forces[i] + size * u[i] / way) ** 2
                across += (u[i] - min(along / size, 0.0) * forces[i] / size) ** 2
            off = max(off, np.sqrt(min(turned, across)))
        if tangents == 1 and status[node] == SLIP and r[node] > own[0, node] * u[node]:
            status[node] = -1
    return off if total < np.inf else np.inf
