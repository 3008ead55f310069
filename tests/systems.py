"""Small contact systems for the tests."""

import numpy as np
from scipy.optimize import linprog

import frictopt as fo

CYCLE = fo.LoadCycle(mean={"mean": 1.0}, corners=[{"cyclic": -1.0}, {"cyclic": 1.0}])

# Two coupled pairs for `system`: with f = 0.6 and 0.4 their guaranteed limits are well below their shakedown limits.
FIRST_PAIR = (np.array([[1, -0.4], [-0.4, 1]]), np.array([[-0.1, -0.7], [0.7, 0.1]]), 0, 1, (0.8, 0.8), (0.4, 0.1))
SECOND_PAIR = (np.array([[1, -0.6], [-0.6, 1]]), np.array([[-0.5, -0.4], [0.4, 0.5]]), 0, 1, (0.4, -0.4), (0.1, -0.1))


def system(A, B, q0, p0, q1, p1, C=None, gap=None):
    """System with the load cases "mean" (q0, p0) and "cyclic" (q1, p1); C large enough for S to be positive definite."""
    A, B = np.atleast_2d(A).astype(float), np.atleast_2d(B).astype(float)
    n = len(A)
    if C is None:
        C = np.eye(n) * (1.0 + np.abs(B @ np.linalg.pinv(A) @ B.T).sum())
    C = np.atleast_2d(C)
    pairs = {"mean": (q0, p0), "cyclic": (q1, p1)}
    return fo.ContactSystem.from_blocks(
        A, B, C, np.arange(n), {k: (np.broadcast_to(q, n), np.broadcast_to(p, n)) for k, (q, p) in pairs.items()}, gap
    )


def random_system(rng, nodes, loads=("mean", "cyclic"), coupling=0.5):
    """Coupled system with a well-conditioned S; every load case random, the mean pressing."""
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + np.eye(2 * nodes)
    A, B, C = S[:nodes, :nodes], coupling * S[nodes:, :nodes], S[nodes:, nodes:]
    bonded = {name: (rng.normal(size=nodes), 0.3 * rng.normal(size=nodes)) for name in loads}
    bonded["mean"] = (0.1 * rng.normal(size=nodes), rng.uniform(0.5, 1.5, size=nodes))
    return fo.ContactSystem.from_blocks(A, B, C, np.arange(nodes), bonded)


def odd(rng, nodes):
    """A random slip that is mirror-symmetric."""
    values = rng.normal(size=nodes)
    return (values - values[::-1]) / 2


def mirrored(rng, nodes, gap=False, coupling=1.0):
    """A random mirror-symmetric system with the load cases "mean" (pressing), "one" and "other"."""
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + 0.3 * np.eye(2 * nodes)
    image = np.kron(np.diag([-1.0, 1.0]), np.eye(nodes)[::-1])
    S = (S + image @ S @ image) / 2
    S[nodes:, :nodes] *= coupling
    even = [part + part[::-1] for part in rng.normal(size=(3, nodes))]
    bonded = {name: (odd(rng, nodes), 0.15 * part) for name, part in zip(("mean", "one", "other"), even, strict=True)}
    bonded["mean"] = (0.1 * bonded["mean"][0], 1.0 + bonded["mean"][1])
    opening = 0.3 * np.maximum(even[1], 0.0) if gap else None
    x = np.arange(nodes) - (nodes - 1) / 2
    return fo.ContactSystem.from_blocks(S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:], x, bonded, opening)


def linprog_limit(contact, cycle, friction, most=None):
    """lambda_2 from all K corners and raw slips of at most `most`, by scipy: (status, value); status 0 optimal, 2 infeasible, 3 unbounded."""
    n = contact.nodes
    f = np.broadcast_to(friction, n)
    q0, p0 = cycle.mean_reaction(contact)
    rows, right = [], []
    for q1, p1 in zip(*cycle.corner_reactions(contact), strict=True):
        rows += [
            np.column_stack([-contact.A - f[:, None] * contact.B, -q1 - f * p1]),
            np.column_stack([contact.A - f[:, None] * contact.B, q1 - f * p1]),
        ]
        right += [q0 + f * p0, f * p0 - q0]
    slips = [(None, None)] * n if most is None else [(-m, m) for m in np.broadcast_to(most, n)]
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    answer = linprog(np.r_[np.zeros(n), -1.0], np.vstack(rows), np.concatenate(right), bounds=[*slips, (0, None)], options=tight)
    return answer.status, (answer.x[-1] if answer.status == 0 else np.nan)
