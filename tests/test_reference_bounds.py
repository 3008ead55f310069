"""Limits from equilibrium alone, against linear programs on systems that have the equilibrium in question and are otherwise random."""

import numpy as np
import pytest
from scipy.optimize import linprog

from frictopt.reference import uncoupled_limit


def shakedown_lp(A, B, p0, q1, p1, f):
    """Largest `lam` for which some slip keeps `|lam s q1 + A v| <= f (p0 + lam s p1 + B v)`, `s = -1, 1`."""
    rows = [np.column_stack([s * (sense * q1 - f * p1), sense * A - f * B]) for s in (-1, 1) for sense in (-1, 1)]
    free = [(None, None)] * len(A)
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    answer = linprog(np.r_[-1, np.zeros(len(A))], np.vstack(rows), np.tile(f * p0, 4), bounds=[(0, None), *free], method="highs-ds", options=tight)
    assert answer.status == 0
    return answer.x[0]


def test_uniform_stress_has_one_limit_on_every_mirror_symmetric_mesh():
    """f p / |tau|: mirror symmetry uncouples slip and pressure, and all nodes slip at once."""
    rng = np.random.default_rng(7)
    for nodes in (2, 5, 9):
        root, share = rng.normal(size=(nodes, nodes)), rng.uniform(0.2, 2, nodes)
        f, p, tau = rng.uniform(0.1, 1, 3)
        limit = f * p / tau
        assert limit == pytest.approx(shakedown_lp(root @ root.T, np.zeros_like(root), p * share, tau * share, 0 * share, f), rel=1e-9)
        assert limit == pytest.approx(uncoupled_limit(0, p * share, tau * share, 0, f), rel=1e-12)


def free_punch(rng, nodes):
    """Stiffness of a punch without supports: uniform sliding and uniform lifting meet no force, in total or at any node."""
    centre = np.eye(nodes) - 1 / nodes
    root = centre @ rng.normal(size=(nodes, nodes))
    return root @ root.T, centre @ rng.normal(size=(nodes, nodes)) @ centre


def test_gross_slip_bounds_the_limit_of_a_free_punch():
    """f P0 / |Q1|: whatever the slip, the nodal forces add up to the applied ones."""
    rng = np.random.default_rng(8)
    shares = []
    for _ in range(30):
        nodes = int(rng.integers(2, 8))
        A, B = free_punch(rng, nodes)
        p0, q1, p1 = rng.uniform(0.2, 2, nodes), rng.normal(1, 0.5, nodes), rng.normal(scale=0.3, size=nodes)
        f = rng.uniform(0.05, 0.6)
        bound = f * p0.sum() / abs(q1.sum())
        shares.append(shakedown_lp(A, 0.2 * B, p0, q1, p1 - p1.mean(), f) / bound)
    assert max(shares) <= 1 + 1e-9
    assert max(shares) > 0.9  # the bound is no idle one


def test_gross_slip_bound_is_attained_where_shear_follows_pressure():
    rng = np.random.default_rng(9)
    A, B = free_punch(rng, 6)
    p0 = rng.uniform(0.2, 2, 6)
    assert shakedown_lp(A, B, p0, 0.7 * p0, 0 * p0, 0.35) == pytest.approx(0.35 / 0.7, rel=1e-9)
