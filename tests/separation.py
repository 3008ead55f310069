"""Every pattern of open nodes of a small contact at the corners of its cycle, each as a linear program of its own, and what rests."""

from itertools import product

import numpy as np
from scipy.optimize import linprog

import frictopt as fo
from systems import random_system


def pulled_system(rng, nodes):
    """A random contact with gaps, nodes that the mean load pulls, and cyclic loads that lift nodes off."""
    contact = random_system(rng, nodes)
    (q, p), (cyclic_q, cyclic_p) = contact.bonded["mean"], contact.bonded["cyclic"]
    p = p - np.where(rng.random(nodes) < 0.3, rng.uniform(0.5, 2.0, nodes), 0.0)
    gap = np.where(rng.random(nodes) < 0.4, 0.3 * rng.random(nodes), 0.0)
    return contact.with_gap(gap).with_bonded({"mean": (q, p), "cyclic": (cyclic_q, cyclic_p * rng.choice([1.0, 4.0]))})


def patterns(contact, cycle, friction, most):
    """Largest load factor up to `most` that obeys the law at the corners, for each pattern (K, N) of open nodes that has one, by scipy.

    Yields load factor, slips and gaps (K, N). A node that is closed at two corners in a row has the same slip there.
    """
    n, corners = contact.nodes, len(cycle.corners)
    mean, S = np.concatenate(contact.reaction(cycle.mean)), contact.S
    cyclic = np.hstack(cycle.corner_reactions(contact))
    size = 1 + 2 * n * corners
    for pattern in product((False, True), repeat=n * corners):
        opened = np.array(pattern).reshape(corners, n)
        equal, less, right_equal, right_less = [], [], [], []
        for k in range(corners):
            rows = np.zeros((2 * n, size))
            rows[:, 0], rows[:, 1 + 2 * n * k : 1 + 2 * n * (k + 1)] = cyclic[k], S
            constant = mean - S @ np.r_[np.zeros(n), contact.gap]
            (q, p), (q0, p0) = (rows[:n], rows[n:]), (constant[:n], constant[n:])
            for i in range(n):
                v, w = np.zeros(size), np.zeros(size)
                v[1 + 2 * n * k + i] = w[1 + 2 * n * k + n + i] = 1.0
                if opened[k, i]:
                    equal += [q[i], p[i]]
                    right_equal += [-q0[i], -p0[i]]
                    less.append(-w)
                    right_less.append(0.0)
                    continue
                equal.append(w)
                right_equal.append(0.0)
                less += [q[i] - friction * p[i], -q[i] - friction * p[i], -p[i]]
                right_less += [friction * p0[i] - q0[i], friction * p0[i] + q0[i], p0[i]]
                if not opened[k - 1, i]:
                    before = np.zeros(size)
                    before[1 + 2 * n * ((k - 1) % corners) + i] = 1.0
                    equal.append(v - before)
                    right_equal.append(0.0)
        bounds = [(0, most)] + [(None, None)] * (size - 1)
        answer = linprog(np.r_[-1.0, np.zeros(size - 1)], less, right_less, equal, right_equal, bounds)
        if answer.status == 0:
            u = answer.x[1:].reshape(corners, 2, n)
            yield answer.x[0], u[:, 0], np.maximum(u[:, 1], 0.0)


def rests(contact, cycle, friction, load_factor, **begin):
    """Whether a transient comes to rest; a path that ends does not."""
    try:
        return fo.steady_state(contact, cycle, friction, load_factor, **begin, most_cycles=200).outcome is fo.Outcome.SHAKEDOWN
    except fo.FrictoptError:
        return False


def resting_starts(contact, cycle, friction, load_factor, witness, count, rng):
    """How many of random starts around a slip come to rest."""
    size = np.abs(witness).max() + 0.5
    starts = witness + rng.normal(size=(count, contact.nodes)) * size * rng.choice([0.03, 0.1, 0.3, 1.0, 3.0], size=(count, 1))
    return sum(rests(contact, cycle, friction, load_factor, initial_slip=start) for start in starts)
