"""The inner algebra of the exact path.

It consists of the rate problem and complementary pivoting.
"""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from frictopt.transients.exact.rate import RateProblem, _lemke, find_rates
from helpers.cases import few
from helpers.paths import followed


@settings(max_examples=few(60))
@given(seed=st.integers(0, 10**6), n=st.integers(1, 7), skew=st.floats(0.0, 3.0))
def test_complementary_pivoting_against_all_bases(seed, n, skew):
    """The matrix is positive definite plus skew, so that there is exactly one solution."""
    rng = np.random.default_rng(seed)
    G, K = rng.normal(size=(n, n)), rng.normal(size=(n, n))
    M = G @ G.T + 0.1 * np.eye(n) + skew * (K - K.T)
    c = rng.normal(size=n)
    expected = []
    for moving in product((False, True), repeat=n):
        chosen, z = np.flatnonzero(moving), np.zeros(n)
        z[chosen] = np.linalg.solve(M[np.ix_(chosen, chosen)], -c[chosen])
        if z.min() >= -1e-12 and (M @ z + c).min() >= -1e-12:
            expected.append(z)
    assert len(expected) == 1
    for cover in (np.ones(n), rng.uniform(0.1, 1.0, n)):
        assert np.allclose(
            _lemke(M, c, cover), expected[0], rtol=1e-8, atol=1e-9 * np.abs(expected[0]).max()
        )


@pytest.mark.parametrize("pairs", [2, 9, 25])
def test_rates_that_may_not_be_the_only_ones_are_never_called_so(pairs):
    """M = -1, c = 1 for each pair: z = 0 and z = 1 are both solutions."""
    problem = RateProblem(
        -np.eye(pairs),
        np.ones(pairs),
        np.arange(pairs),
        np.ones(pairs, dtype=int),
        np.eye(pairs, pairs + 1),
        [],
        False,
        False,
    )
    solutions = find_rates(problem, np.zeros(pairs, dtype=int))
    assert len(solutions.found) == 2 or not solutions.complete


def test_events_without_proof_are_counted(punch, paper_cycle):
    """Events whose rates are not proven are counted.

    A free punch slides as a whole from a far start. Its stiffness against slip is not positive
    definite, so that no rates are proven.
    """
    contact = punch(40)
    limit = fo.shakedown_limit(contact, paper_cycle, 0.5).load_factor
    far = 30.0 * np.random.default_rng(1).standard_normal(contact.nodes)
    M = contact.A + 0.5 * np.sign(far)[:, None] * contact.B
    assert np.linalg.eigvalsh(M + M.T)[0] < 0
    path = followed(contact, paper_cycle, 0.5, 0.9 * limit, far)
    assert path.state.trace[2] > 0
