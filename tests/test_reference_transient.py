"""Closed-form limits against friction marched in small increments, from many starts at once."""

from itertools import product

import numpy as np
import pytest

from frictopt.reference import two_node_limits, uncoupled_limit

INCREMENTS = 6  # from corner to corner; where slip dies out does not depend on it
CYCLES = 80
FIRST_PAIR = ([[1, -0.4], [-0.4, 1]], [[-0.1, -0.7], [0.7, 0.1]], 0, 1, [0.8, 0.8], [0.4, 0.1], 0.6)
SECOND_PAIR = ([[1, -0.6], [-0.6, 1]], [[-0.5, -0.4], [0.4, 0.5]], 0, 1, [0.4, -0.4], [0.1, -0.1], 0.4)
ONE_APEX_NEVER_SAFE = ([[1, -0.1], [-0.1, 1]], [[0.6, 0.7], [-0.4, 0.2]], 0, 1, [0.1, 0.4], [0, 0.3], 0.4)
APEX_SAFE_FROM_THE_OUTSET = ([[1, -0.6], [-0.6, 1]], [[-0.2, -0.4], [-0.2, 0.6]], 0, 1, [0.8, -0.3], [-0.2, 0.3], 0.8)


def slip_of_last_cycle(system, load_factor, starts):
    """Total |dv| of each start in the last of CYCLES cycles, by full-contact increments whose status is found by trying all nine."""
    A, B = (np.array(x, dtype=float) for x in system[:2])
    q0, p0, q1, p1, f = (np.broadcast_to(np.asarray(x, dtype=float), 2) for x in system[2:])
    half = np.linspace(-1, 1, INCREMENTS + 1)
    v, total = np.array(starts, dtype=float), np.zeros(len(starts))
    for cycle in range(CYCLES):
        for s in np.r_[half[1:], half[-2::-1]]:
            new = increment(A, B, f, q0 + s * load_factor * q1, p0 + s * load_factor * p1, v)
            total += (cycle == CYCLES - 1) * np.abs(new - v).sum(axis=1)
            v = new
    return total


def increment(A, B, f, q, p, v):
    """Slips after a load (q, p) has come on: node by node stick (0), forward (q + f p = 0, dv > 0) or backward (f p - q = 0, dv < 0)."""
    result = np.full_like(v, np.nan)
    for status in product((0, 1, -1), repeat=2):
        sense = np.array(status)
        moving = sense != 0
        rows = np.where(moving[:, None], A + (sense * f)[:, None] * B, np.eye(2))
        trial = np.where(moving, -(q + sense * f * p), v) @ np.linalg.inv(rows).T
        trial = np.where(moving, trial, v)  # sticking nodes keep their slip to the last bit
        forces, bound = q + trial @ A.T, f * (p + trial @ B.T)
        legal = np.where(moving, sense * (trial - v) >= 0, np.abs(forces) <= bound + 1e-12).all(axis=1)
        result = np.where((legal & np.isnan(result[:, 0]))[:, None], trial, result)
    assert not np.isnan(result).any()
    return result


@pytest.fixture
def starts():
    return np.random.default_rng(6).uniform(-6, 6, size=(200, 2))


@pytest.mark.parametrize("system", [FIRST_PAIR, SECOND_PAIR, ONE_APEX_NEVER_SAFE])
def test_two_node_limits_bound_the_dependence_on_the_start(system, starts):
    limits = two_node_limits(*system)
    loads = 0.97 * limits.lambda_1, 0.97 * limits.lambda_2, 1.03 * limits.lambda_2
    below, between, above = ((slip_of_last_cycle(system, load, starts) > 1e-9).mean() for load in loads)
    assert below == 0
    assert 0 < between < 1
    assert above == 1


def test_starts_just_above_the_guaranteed_limit_keep_slipping_only_near_the_corner_of_the_safe_region():
    lambda_1 = two_node_limits(*FIRST_PAIR).lambda_1
    forward, backward = np.array([[0.94, -0.82]]), np.array([[1.06, 0.02]])  # rows of A + f B and A - f B of node 1
    lam = 1.005 * lambda_1
    corner = np.linalg.solve(np.vstack([forward, backward]), [-0.6 + lam * 1.04, 0.6 - lam * 0.56])
    beyond = corner + np.array([0.0, 0.01])  # where the two lines of node 1 have crossed
    at_corner, past_corner, far = slip_of_last_cycle(FIRST_PAIR, lam, [corner, beyond, [0.0, 0.0]])
    assert at_corner == pytest.approx(0, abs=1e-12)
    assert past_corner > 1e-3
    assert far == 0
    assert slip_of_last_cycle(FIRST_PAIR, 0.99 / 1.005 * lam, [beyond])[0] == pytest.approx(0, abs=1e-12)


def test_where_one_node_can_unload_the_other_no_load_is_safe_from_every_start(starts):
    limits = two_node_limits(*APEX_SAFE_FROM_THE_OUTSET)
    assert limits.lambda_1 == 0
    assert 0 < (slip_of_last_cycle(APEX_SAFE_FROM_THE_OUTSET, 0.2 * limits.lambda_2, starts) > 1e-9).mean() < 1
    assert slip_of_last_cycle(APEX_SAFE_FROM_THE_OUTSET, 1.03 * limits.lambda_2, starts).min() > 1e-9


def test_uncoupled_limit_holds_for_every_start(starts):
    A, d = np.array([[2.0, -1], [-1, 2]]), np.array([0.5, -0.8])
    load = ([0.05, -0.1], [1, 0.8], [0.5, 0.3], [0.1, -0.2], 0.4)
    limit = uncoupled_limit(*load, d=d)
    system = (A, d[:, None] * A, *load)
    assert slip_of_last_cycle(system, 0.97 * limit, starts).max() < 1e-9
    assert slip_of_last_cycle(system, 1.03 * limit, starts).min() > 1e-4
