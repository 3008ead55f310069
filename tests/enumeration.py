"""Every admissible state of a small contact after one increment, by trying all 4^N statuses."""

from itertools import product

import numpy as np

import frictopt as fo

STICK, FORWARD, BACKWARD, OPEN = 0, 1, -1, 2


def admissible_states(contact, friction, slip, bonded, tolerance=1e-10):
    """States `(slip, gap, q, p)` that obey the contact law, each once: (number of states, 4, N).

    For each status the unknowns [dv, w, q, p] solve 4N equations: equilibrium, and two of the status for each node.
    """
    n = contact.nodes
    f = np.broadcast_to(np.asarray(friction, dtype=float), n)
    stiffness, force = contact.stiffness_scale, np.abs(bonded[1]).mean() or np.abs(bonded[0]).mean() or 1.0
    length = force / stiffness
    S = contact.S / stiffness
    statuses = np.array(list(product((STICK, FORWARD, BACKWARD, OPEN), repeat=n)))
    matrices = np.zeros((len(statuses), 4 * n, 4 * n))
    matrices[:, : 2 * n, : 2 * n] = -S
    matrices[:, : 2 * n, 2 * n :] = np.eye(2 * n)
    right = np.zeros((len(statuses), 4 * n))
    right[:, : 2 * n] = (np.concatenate(bonded) + contact.S @ np.concatenate([slip, -contact.gap])) / force
    for node in range(n):
        status = statuses[:, node]
        dv, w, q, p = node, n + node, 2 * n + node, 3 * n + node
        first, second = 2 * n + node, 3 * n + node
        matrices[status == STICK, first, dv] = 1.0
        matrices[status != STICK, first, q] = 1.0
        matrices[np.abs(status) == 1, first, p] = (status * f[node])[np.abs(status) == 1]
        matrices[status == OPEN, second, p] = 1.0
        matrices[status != OPEN, second, w] = 1.0
    regular = np.abs(np.linalg.det(matrices)) > 1e-12
    solved = np.linalg.solve(matrices[regular], right[regular, :, None])[:, :, 0].reshape(-1, 4, n)
    fits = _obeys(solved, statuses[regular], f, tolerance)
    return _distinct(solved[fits]) * np.array([length, length, force, force])[:, None] + np.array([slip, 0 * slip, 0 * slip, 0 * slip])


def _obeys(states, statuses, f, tolerance):
    dv, w, q, p = states.transpose(1, 0, 2)
    sense = np.where(statuses == OPEN, 0, statuses)
    wrong = np.maximum.reduce([-w, -p, np.abs(q) - f * p, -sense * dv * (f > 0)])
    return (wrong <= tolerance).all(axis=1)


def _distinct(states, distance=1e-7):
    kept = []
    for state in states:
        if all(np.abs(state - other).max() > distance for other in kept):
            kept.append(state)
    return np.array(kept).reshape(-1, 4, states.shape[-1])


def random_increment(rng, nodes, most_friction, floor=0.05, rigid=None):
    """A coupled contact (with the columns of `rigid` as motions that need no force), friction, slip and load: everything random, half with gaps."""
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + floor * np.eye(2 * nodes)
    if rigid is not None:
        basis, _ = np.linalg.qr(rigid)
        free = np.eye(2 * nodes) - basis @ basis.T
        S = free @ S @ free
    S = (S + S.T) / 2
    gap = np.where(rng.random(nodes) < 0.5, 0.0, rng.exponential(0.3, nodes)) * rng.integers(2)
    load = rng.normal(size=nodes), rng.normal(size=nodes) * rng.choice([0.3, 1.5]) + 1.0
    contact = fo.ContactSystem.from_blocks(S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:], np.arange(nodes), {"load": load}, gap)
    friction = rng.uniform(0, most_friction, nodes) * (rng.random(nodes) > 0.1)
    return contact, friction, rng.normal(size=nodes) * rng.choice([0.0, 0.3, 1.0]), load


def distance(states, increment):
    """Distance of a result from the nearest of the states, in any of slip, gap, q, p."""
    found = np.array([increment.slip, increment.gap, increment.q, increment.p])
    return min((float(np.abs(state - found).max()) for state in states), default=np.inf)
