"""Closed-form limits against friction marched in small increments, from many starts at once."""

import numpy as np
import pytest

from frictopt.reference import two_node_limits, uncoupled_limit
from marching import last_cycle

FIRST_PAIR = ([[1, -0.4], [-0.4, 1]], [[-0.1, -0.7], [0.7, 0.1]], 0, 1, [0.8, 0.8], [0.4, 0.1], 0.6)
SECOND_PAIR = ([[1, -0.6], [-0.6, 1]], [[-0.5, -0.4], [0.4, 0.5]], 0, 1, [0.4, -0.4], [0.1, -0.1], 0.4)
ONE_APEX_NEVER_SAFE = ([[1, -0.1], [-0.1, 1]], [[0.6, 0.7], [-0.4, 0.2]], 0, 1, [0.1, 0.4], [0, 0.3], 0.4)
APEX_SAFE_FROM_THE_OUTSET = ([[1, -0.6], [-0.6, 1]], [[-0.2, -0.4], [-0.2, 0.6]], 0, 1, [0.8, -0.3], [-0.2, 0.3], 0.8)


def slip_of_last_cycle(system, load_factor, starts):
    return last_cycle(system, load_factor, starts).travel


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
