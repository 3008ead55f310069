"""The exact path of a contact in the plane on one page of numpy.

It is slow, proves nothing, and lacks the rare events that need a complementarity problem. Between
two events the load changes linearly and each node keeps its status, so slip, gap and reactions
change linearly, too. At an event a node reaches its friction bound, loses its pressure, or closes.
Then statuses are searched that agree with the signs of their rates.
"""

import numpy as np

# Slack that counts as rounding, relative to the friction bound and a thousandth of the force scale.
TINY = 1e-11


def rates(S, f, status, load):
    """Rates of `[v, w]` and `[q, p]` under a rate of the load.

    `q' + status f p' = 0` if a node slips, and `q' = p' = 0` if it is open.
    """
    n, u = len(f), np.zeros(len(S))
    factor = np.r_[np.where(status == 2, 0.0, status * f), np.zeros(n)]
    moving = np.flatnonzero(np.r_[status != 0, status == 2])
    rows, right = S + factor[:, None] * np.tile(S[n:], (2, 1)), load + factor * np.tile(load[n:], 2)
    u[moving] = np.linalg.solve(rows[np.ix_(moving, moving)], -right[moving])
    return u, load + S @ u


def follow(S, f, gap, force, state, load, corner):
    """Work of friction on the straight segment from a load to a corner.

    The state `(u, r, status)` changes in place.
    """
    (u, r, status), n, time, work = state, len(f), 0.0, np.zeros(len(f))
    change = corner - load
    none_r, none_u = 1e-11 * np.abs(change).max(), 1e-11 * np.abs(change).max() / np.diag(S).mean()
    # At a corner all nodes stick, until their rates show that they slip.
    status[status != 2] = 0
    while time < 1:
        for iteration in range(200):
            du, dr = rates(S, f, status, change)
            (q, p), (dq, dp), dv, touches = (
                np.split(r, 2),
                np.split(dr, 2),
                du[:n],
                u[n:] + gap <= 1e-14 * np.abs(u).max(),
            )
            slack, falls, small = (
                np.array([f * p + q, f * p - q]),
                np.array([f * dp + dq, f * dp - dq]),
                TINY * (f * p + 1e-3 * force),
            )
            forward, backward = (slack <= small) & (falls < -none_r)
            wanted = np.where(
                (status == 0) & forward, 1, np.where((status == 0) & backward, -1, status)
            )
            wanted[(np.abs(status) == 1) & (status * dv < -none_u)] = 0
            wanted[(status != 2) & (p <= TINY * 1e-3 * force) & (dp < -none_r)] = 2
            wanted[(status == 2) & touches & (du[n:] < -none_u)] = 0
            wrong = np.flatnonzero(wanted != status)
            if not len(wrong):
                break
            wrong = wrong if iteration < 12 else wrong[:1]
            status[wrong] = wanted[wrong]
        left, rate = np.array([*slack, p, u[n:] + gap]), np.array([*falls, dp, du[n:]])
        may = np.array(
            [
                *((status == 0) & (slack > small)),
                (status != 2) & (p > TINY * 1e-3 * force),
                status == 2,
            ]
        )
        times = np.divide(
            np.maximum(left, 0.0), -rate, out=np.full((4, n), np.inf), where=may & (rate < 0)
        )
        step = min(times.min(), 1 - time)
        work += np.where(np.abs(status) == 1, f * (p + step / 2 * dp) * np.abs(step * dv), 0.0)
        u += step * du
        r += step * dr
        time = time + step if times.min() < 1 - time else 1.0
    r[:] = corner + S @ u
    return work


def cycle_work(system, cycle, friction, load_factor, slip, cycles):
    """(cycles, N) work of friction in each load cycle, from a residual slip."""
    n, mean = system.nodes, np.concatenate(system.reaction(cycle.mean))
    corners = [np.concatenate(system.reaction(loads)) for loads in cycle.at(load_factor)]
    f, force = np.full(n, friction), np.abs(mean[n:]).mean()
    u, r = np.r_[slip, -system.gap], np.repeat([0.0, force], n)
    load, state, works = r - system.S @ u, (u, r, np.zeros(n, dtype=int)), []
    for stops in [[mean], *[corners] * cycles]:
        works.append(np.zeros(n))
        for corner in stops:
            works[-1] += follow(system.S, f, system.gap, force, state, load, corner)
            load = corner
    return np.array(works[1:])
