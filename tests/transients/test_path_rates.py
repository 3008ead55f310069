"""The inner algebra of the exact path.

It consists of the inverse of the active set, the rate problem, and complementary pivoting.
"""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

import frictopt as fo
from frictopt.transients.exact import kernel as act
from frictopt.transients.exact.rate import RateProblem, _lemke, find_rates, rate_problem
from helpers.cases import few
from helpers.paths import followed
from helpers.systems import random_system


@njit  # the kernel's own functions cannot be called from Python
def change_statuses(S, f, status, active, wanted):
    return act.change_statuses(S, f, status, active, wanted)


def stiffness_of(S, active):
    """Stiffness of the active set as it is defined: equation by equation, unknown by unknown."""
    nodes = len(S) // 2
    n = active.size[0]
    unknown, weight = active.unknown[:n], active.weight[:n]
    rows = [
        S[i] + (factor * S[nodes + i] if factor else 0.0)
        for i, factor in zip(unknown, weight, strict=True)
    ]
    return np.array(rows).reshape(n, 2 * nodes)[:, unknown]


@settings(max_examples=few(30))
@given(seed=st.integers(0, 10**6), nodes=st.integers(1, 8))
def test_the_inverse_follows_any_sequence_of_changes(seed, nodes):
    rng = np.random.default_rng(seed)
    S = np.ascontiguousarray(random_system(rng, nodes).S)
    f = rng.uniform(0.0, 0.6, nodes)
    active, status = act.new_active_set(nodes), np.zeros(nodes, dtype=np.int8)
    for _ in range(40):
        wanted = np.where(
            rng.random(nodes) < 0.3, rng.choice([0, 1, -1, 2], size=nodes), status
        ).astype(np.int8)
        assert change_statuses(S, f, status, active, wanted) != 0.0 and (status == wanted).all()
    n = active.size[0]
    assert n == (status != 0).sum() + (status == 2).sum()
    assert np.allclose(active.inverse[:n, :n] @ stiffness_of(S, active), np.eye(n), atol=1e-9)


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


def one_node(q, p, w=0.0, A=1.0, B=0.5, C=1.0, load_rate=(0.0, 0.0), friction=3.0, status=0):
    S = np.array([[A, B], [B, C]])
    state = act.new_state(np.array([0.0, w]), np.array([q, p]), np.zeros(1))
    state.status[0] = status
    return find_rates(
        rate_problem(S, np.array([friction]), np.array(load_rate), state, np.ones(1)), state.status
    )


def test_wedging():
    """Beyond the critical friction a load has no rates, or two.

    With A = 1, B = 1/2, C = 1 backward slip softens beyond f = A/B = 2 (Klarbring 1990).
    """
    no = one_node(q=1.5, p=0.5, load_rate=(1.0, 0.0))
    assert not no.found and no.complete
    two = one_node(q=1.5, p=0.5, load_rate=(-1.0, 0.0))
    assert [int(status[0]) for status, _ in two.found] == [0, -1] and two.complete
    below = one_node(q=0.75, p=0.5, load_rate=(1.0, 0.0), friction=1.5)
    assert [int(status[0]) for status, _ in below.found] == [-1]
    assert below.found[0][1][0] == pytest.approx(-1.0 / (1.0 - 1.5 * 0.5))


@pytest.mark.parametrize(
    ("load_rate", "status"),
    [
        ((0.0, 1.0), 0),
        ((0.0, -1.0), 2),
        ((1.0, 1.0), -1),
        ((-1.0, 1.0), 1),
        ((0.3, 1.0), 0),
        ((5.0, -0.1), 2),
    ],
)
def test_a_node_without_pressure_and_gap(load_rate, status):
    found = one_node(q=0.0, p=0.0, B=0.0, friction=0.5, load_rate=load_rate).found
    assert [int(s[0]) for s, _ in found] == [status]


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
