"""An increment of load by compiled Gauss-Seidel sweeps over the nodes.

Sweeps are quick if few nodes move; Newton's method goes on from the state that they reach. The
motions `u = [dv, w]` of an increment have t = 1 or 2 tangential parts at each node; its reactions
are `r + S (u - start)`.
"""

# Numba decides by the file of the outermost function whether its compiled code is still valid. So
# no compiled function and no constant is imported.

import numpy as np

from ..exact.compilation import entry_point, inner

# Copies of the statuses of `transient.py`, and of a tolerance; a test compares them.
STICK, SLIP, OPEN = 0, 1, 2
_ROUNDING = 1e-12


@entry_point
def reactions(S, still, u):
    """`still + S u`, computed from the motions that are not zero.

    An increment has few such motions. S is symmetric: its rows are its columns.
    """
    r = still.copy()
    for i in range(len(u)):
        if u[i] != 0.0:
            for k in range(len(r)):
                r[k] += u[i] * S[i, k]
    return r


@entry_point
def increment(S, slopes, constants, augmentation, stiffness, u, r, forces, status):
    """An increment by sweeps, alternately over all nodes and over the moving nodes.

    The sweeps end when the state obeys the law. The first arguments are explained at `sweep`;
    `augmentation` (t + 1, N) at `Law` in `newton.py`. `forces` (M,) and `status` (N,) receive the
    reactions and the statuses: slipping nodes are exactly on their bound, open nodes have no
    reactions. Returns the largest violation of the law, see `_put_on_law`; inf if a number is not
    finite.
    """
    still, residual = reactions(S, r, -u), np.inf
    for _ in range(10):
        last = sweep(S, slopes, constants, stiffness, u, r, 4, _ROUNDING, 1.0) <= _ROUNDING
        last = not _sweep_moving(S, slopes, constants, stiffness, u, r) <= _ROUNDING or last
        r[:] = reactions(S, still, u)
        residual = _put_on_law(slopes, constants, augmentation, u, r, forces, status)
        if last or residual <= _ROUNDING:
            break
        r[:] = reactions(S, still, u)
    return residual


@entry_point
def sweep(S, slopes, constants, stiffness, u, r, most, enough, relax):
    """Gauss-Seidel on the projected law of one increment: each node in turn moves to obey it.

    Nodes that stick need only a check (Jourdan, Alart & Jean 1998). S (M, M) is the stiffness;
    `slopes` and `constants` (J, N) belong to the terms of the friction bound. `stiffness` (t + 1,
    N) is positive: for the tangents at least the largest stiffness of the node in any tangential
    direction, and its normal stiffness. Slip increments and gaps u and reactions r, (M,), are
    changed in place, in at most `most` sweeps, until corrections of forces are at most `enough`.
    `relax` is the share of the missing slip by which a slip changes. If it is 1, the node then
    obeys the law; if it is a little more, fewer sweeps are needed. Returns the largest correction
    of the last sweep.
    """
    nodes, tangents, largest = slopes.shape[1], len(stiffness) - 1, np.inf
    wanted = np.empty(tangents)
    for _ in range(most):
        largest = 0.0
        for node in range(nodes):
            k = tangents * nodes + node
            lifted = u[k] - r[k] / stiffness[-1, node]
            way = _move(S, u, r, k, lifted if lifted >= 0 else 0.0)
            largest = max(largest, stiffness[-1, node] * way)

            pressed = r[k] - stiffness[-1, node] * u[k]
            bound = _bound(slopes, constants, max(pressed, 0.0), node)
            size = _pull(stiffness, u, r, node)
            for a in range(tangents):
                i = a * nodes + node
                wanted[a] = 0.0
                if size > bound:
                    held = bound / size
                    missing = held * u[i] + (1 - held) * r[i] / stiffness[a, node]
                    wanted[a] = u[i] - relax * missing
            for a in range(tangents):
                way = _move(S, u, r, a * nodes + node, wanted[a])
                largest = max(largest, stiffness[a, node] * way)
        if largest <= enough:
            break
    return largest


@inner
def _bound(slopes, constants, p, node):
    """The friction bound of a node under a normal force: the smallest term of the contact law.

    The constants count only under pressure.
    """
    bound = slopes[0, node] * p
    if p > 0:
        bound += constants[0, node]
        for j in range(1, len(slopes)):
            bound = min(bound, slopes[j, node] * p + constants[j, node])
    return bound


@inner
def _move(S, u, r, k, to):
    """Move one motion to a value, and the reactions with it; returns the distance."""
    way = to - u[k]
    u[k] = to
    if way != 0.0:
        for j in range(len(r)):
            r[j] += way * S[k, j]
    return abs(way)


@inner
def _pull(augmentation, u, r, node):
    """Size of the shear force that a node would have if it did not slip, `|q - d dv|`."""
    total, nodes = 0.0, augmentation.shape[1]
    for a in range(len(augmentation) - 1):
        i = a * nodes + node
        total += (r[i] - augmentation[a, node] * u[i]) ** 2
    return np.sqrt(total)


@inner
def _sweep_moving(S, slopes, constants, stiffness, u, r):
    """Sweeps over only those nodes that move. u is changed in place, r is not.

    Returns the largest correction of the last sweep.
    """
    axes, nodes = stiffness.shape
    moving = np.flatnonzero((u.reshape(axes, nodes) != 0.0).sum(axis=0))
    part = np.concatenate((moving, moving + nodes, moving + 2 * nodes))[: axes * len(moving)]
    block = S[part][:, part]
    u_part, r_part = u[part], r[part]
    # Relaxation by 1.4 takes a third of the sweeps.
    largest = sweep(
        block,
        slopes[:, moving],
        constants[:, moving],
        stiffness[:, moving],
        u_part,
        r_part,
        100,
        0.1 * _ROUNDING,
        1.4,
    )
    u[part] = u_part
    return largest


@inner
def _put_on_law(slopes, constants, augmentation, u, r, forces, status):
    """Write forces that obey the law, and statuses; set the motions that it forbids to zero.

    The forces are the projection of `r - augmentation u` on the law, as in `newton.py`. A motion is
    forbidden if its force is the whole of this. In the plane slip against +x has the status -1.
    Returns the largest difference between the forces and r: the violation of the law.
    """
    nodes, tangents = slopes.shape[1], len(augmentation) - 1
    residual, total = 0.0, 0.0
    for node in range(nodes):
        k = tangents * nodes + node
        pressed = r[k] - augmentation[-1, node] * u[k]
        bound = _bound(slopes, constants, pressed, node)
        size = _pull(augmentation, u, r, node)
        status[node] = STICK
        tangential, normal = 1.0, 1.0
        if pressed <= 0:
            status[node] = OPEN
            tangential, normal = 0.0, 0.0
        elif size > bound:
            backward = tangents == 1 and r[node] > augmentation[0, node] * u[node]
            status[node] = -1 if backward else SLIP
            tangential = bound / size
        for i in range(node, k + 1, nodes):
            share = normal if i == k else tangential
            forces[i] = share * (r[i] - augmentation[i // nodes, node] * u[i])
            if share == 1.0:
                u[i] = 0.0
            residual = max(residual, abs(forces[i] - r[i]))
            total += abs(forces[i]) + abs(u[i])
    return residual if total < np.inf else np.inf
