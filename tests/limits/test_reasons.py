"""Sentences of reasons that depend on a single node, each where it holds and where it does not."""

import numpy as np
import pytest

import frictopt as fo
from helpers.systems import CYCLE, all_closed, random_system, system


@pytest.mark.parametrize("pulled", [True, False])
def test_a_node_that_only_slip_presses_is_named(pulled):
    """Slip of node 0, at most f, presses node 1 by half of the slip: |0.1 lam| <= f (f / 2 + p)."""
    p, f = -0.05 if pulled else 0.05, 0.5
    pair = system(np.eye(2), [[0.0, 0.0], [-0.5, 0.0]], [0.0, 0.0], [1.0, p], [0.0, 0.1], 0.0)
    limit = all_closed(pair, CYCLE, f)
    assert limit.load_factor == pytest.approx(f * (f / 2 + p) / 0.1)
    sentence = "only residual slip presses node 1, which governs the limit"
    assert (sentence in limit.reason) == pulled


def test_a_node_that_slip_unloads_is_named():
    contact = random_system(np.random.default_rng(9), 3, coupling=1.0)
    limit = fo.guaranteed_limit(contact, CYCLE, 1.0)
    largest = np.abs(limit.slip).max()
    assert f"up to {largest:.3g} can unload it completely under the mean load" in limit.reason
    q, p = limit.reactions
    assert limit.load_factor == 0 and np.abs([q[:, limit.node], p[:, limit.node]]).max() < 1e-9


@pytest.mark.parametrize(("friction", "wedges"), [(1.9, False), (2.1, True)])
def test_a_node_that_may_wedge_itself_is_named(friction, wedges):
    """With A = 1 and B = 1/2 its critical friction is A / |B| = 2 (Klarbring 1990)."""
    node = system(np.eye(1), [[0.5]], 0.0, 1.0, 1.0, 0.0)
    limit = fo.guaranteed_limit(node, CYCLE, friction)
    assert limit.node == 0 and ("may wedge itself" in limit.reason) == wedges
