"""Closed-form limits against published instances and against linear programs written from Coulomb's law, every corner in full."""

import numpy as np
import pytest
from scipy.optimize import linprog

import frictopt as fo
from frictopt.reference import single_node_limit, two_node_limits, uncoupled_limit

CORNERS = (-1.0, 1.0)
EXACT = {"rel": 1e-9, "abs": 1e-12}
FIRST_PAIR = {"A": [[1, -0.4], [-0.4, 1]], "B": [[-0.1, -0.7], [0.7, 0.1]], "q0": 0, "p0": 1, "q1": [0.8, 0.8], "p1": [0.4, 0.1], "f": 0.6}


def law(A, B, q0, p0, q1, p1, f):
    """Rows of `G (lam, v) >= h`: friction that opposes forward and backward slip, node by node, at each corner; keyed by (sense, corner)."""
    A, B = np.atleast_2d(A).astype(float), np.atleast_2d(B).astype(float)
    q0, p0, q1, p1, f = (np.broadcast_to(np.asarray(x, dtype=float), len(A)) for x in (q0, p0, q1, p1, f))
    rows = {}
    for corner in CORNERS:
        for sense in (1, -1):  # sense * q + f p >= 0
            rows[sense, corner] = np.column_stack([corner * (sense * q1 + f * p1), sense * A + f[:, None] * B]), -(sense * q0 + f * p0)
    return rows


def solve(objective, rows, equal=()):
    """Least `objective * lam` with all rows, those at positions `equal` without slack; rows are brought to unit length first."""
    G, h = (np.concatenate(part) for part in zip(*rows.values(), strict=True))
    size = np.abs(G).max(axis=1)
    G, h = G / size[:, None], h / size
    cost = np.r_[objective, np.zeros(G.shape[1] - 1)]
    bounds = [(0, None)] + [(None, None)] * (G.shape[1] - 1)
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    equalities = {"A_eq": G[list(equal)], "b_eq": h[list(equal)]} if len(equal) else {}
    answer = linprog(cost, A_ub=-G, b_ub=-h, bounds=bounds, method="highs-ds", options=tight, **equalities)
    assert answer.status in (0, 2, 3)
    return {0: answer.fun * objective if answer.status == 0 else None, 2: np.nan, 3: np.inf}[answer.status]


def lp_shakedown(system):
    return solve(-1.0, law(**system))


def lp_guaranteed(system):
    """Least load at which some node is on its forward bound at one corner and on its backward bound at the other, at a safe slip.

    Each bound is tight at the corner that brings the node nearest to it; a node for which that is one and the same corner only lifts off there.
    """
    rows = law(**system)
    order, nodes = list(rows), len(np.atleast_2d(system["A"]))
    candidates = [lp_shakedown(system)]
    for node in range(nodes):
        ahead, back = (min(CORNERS, key=lambda corner: rows[sense, corner][0][node, 0]) for sense in (1, -1))
        if ahead != back:
            touching = [order.index((1, ahead)) * nodes + node, order.index((-1, back)) * nodes + node]
            candidates.append(solve(1.0, rows, touching))
    return np.nan if np.isnan(candidates[0]) else np.nanmin(candidates)


def onset(q0, p0, q1, p1, f):
    """The onset of the bonded contact at the two corners, whatever its stiffness."""
    q0, p0, q1, p1, f = (np.atleast_1d(part) for part in np.broadcast_arrays(q0, p0, q1, p1, f))
    one = np.eye(len(q0))
    system = fo.ContactSystem.from_blocks(one, 0 * one, one, np.arange(len(q0)), {"mean": (q0, p0), "cyclic": (q1, p1)})
    return fo.onset(system, fo.LoadCycle({"mean": 1.0}, [{"cyclic": corner} for corner in CORNERS]), f)


def random_load(rng, nodes):
    shape = None if nodes == 1 else nodes
    return {
        "q0": rng.normal(scale=0.3, size=shape),
        "p0": rng.uniform(0.2, 2, shape),
        "q1": rng.normal(size=shape),
        "p1": rng.normal(size=shape),
        "f": rng.uniform(0.1, 1, shape),
    }


def stiff(rng, nodes):
    root = rng.normal(size=(nodes, nodes))
    return root @ root.T + 0.2 * np.eye(nodes)


def random_pairs(rng, count):
    """Coupled pairs of nodes below the critical friction, found by rejection."""
    pairs = []
    while len(pairs) < count:
        system = {"A": stiff(rng, 2), "B": rng.normal(size=(2, 2)), **random_load(rng, 2)}
        mixed = [system["A"] + np.diag([s, t]) * system["f"] @ system["B"] for s in (1, -1) for t in (1, -1)]
        if all(np.linalg.det(m) > 0 and np.diag(m).min() > 0 for m in mixed):
            pairs.append(system)
    return pairs


def test_single_node_equals_the_linear_program():
    rng = np.random.default_rng(1)
    regimes = set()
    for _ in range(300):
        system = {"A": rng.uniform(0.2, 3), **random_load(rng, 1)}
        system["B"] = 0.98 * rng.uniform(-1, 1) * system["A"] / system["f"]
        limit = single_node_limit(**system)
        assert limit == pytest.approx(lp_shakedown(system), **EXACT, nan_ok=True)
        regimes.add((bool(np.isnan(limit)), bool(abs(system["q1"]) > system["f"] * abs(system["p1"]))))
    assert len(regimes) == 4


def test_two_nodes_equal_the_linear_programs():
    regimes = set()
    for system in random_pairs(np.random.default_rng(2), 150):
        limits = two_node_limits(**system)
        assert limits.lambda_2 == pytest.approx(lp_shakedown(system), **EXACT, nan_ok=True)
        assert limits.lambda_1 == pytest.approx(lp_guaranteed(system), **EXACT, nan_ok=True)
        share = limits.lambda_1 / limits.lambda_2
        regimes.add("nothing safe" if np.isnan(share) else "zero" if share == 0 else "apart" if share < 0.999 else "equal")
    assert regimes == {"nothing safe", "zero", "apart", "equal"}


@pytest.mark.parametrize("nodes", [1, 3, 6])
@pytest.mark.parametrize("coupled", [False, True])
def test_proportional_coupling_equals_the_linear_program(nodes, coupled):
    rng = np.random.default_rng(30 + nodes)
    for _ in range(25):
        load, A = random_load(rng, nodes), stiff(rng, nodes)
        d = coupled * 0.95 * rng.uniform(-1, 1, nodes) / load["f"]
        limit = uncoupled_limit(**load, d=d)
        system = {"A": A, "B": d[:, None] * A, **load}
        assert limit == pytest.approx(lp_shakedown(system), **EXACT, nan_ok=True)
        assert limit == pytest.approx(lp_guaranteed(system), **EXACT, nan_ok=True)


def test_limits_are_infinite_without_cyclic_load():
    assert uncoupled_limit(0, 1, 0, 0, 0.5) == single_node_limit(1, 0.3, 0.1, 1, 0, 0, 0.5) == np.inf
    still = two_node_limits(**{**FIRST_PAIR, "q1": 0, "p1": 0})
    assert still.lambda_1 == still.lambda_2 == np.inf


def test_a_mean_load_on_the_bound_leaves_a_limit_of_zero_not_none():
    assert onset(q0=0.3, p0=1, q1=1, p1=0, f=0.3).slip.load_factor == onset(q0=0.1 + 0.2, p0=1, q1=1, p1=0, f=0.3).slip.load_factor == 0
    assert single_node_limit(A=1, B=1, q0=0.1 + 0.2, p0=0.3, q1=1, p1=0, f=0.5) == 0
