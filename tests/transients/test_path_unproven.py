"""Where the rates are not the only ones a path may go one way or another: then it says so."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

import frictopt as fo
from frictopt.transients.exact import kernel
from frictopt.transients.exact.kernel import new_active_set, new_state
from frictopt.transients.exact.rate import RateProblem, _lemke, find_rates
from helpers.cases import few
from helpers.paths import followed
from helpers.systems import mirrored, odd


@njit  # the kernel's own functions cannot be called from Python
def prove(S, f, state, force, proof):
    kernel.look(f, state, force)
    return kernel.prove(S, f, state, proof)


def strongly_coupled(rng, nodes):
    """A mirror-symmetric contact, its load cycle, and an odd slip.

    The stiffnesses of the contact differ in size.
    """
    apart = np.abs(np.subtract.outer(np.arange(nodes), np.arange(nodes)))
    spread = np.kron(np.eye(2), np.exp(-apart))
    G = rng.normal(size=(2 * nodes, 2 * nodes + 2))
    S = spread @ (G @ G.T / (2 * nodes) + 0.05 * np.eye(2 * nodes)) @ spread
    swap = np.kron(np.diag([-1.0, 1.0]), np.eye(nodes)[::-1])
    S = (S + swap @ S @ swap) / 2
    even = [part + part[::-1] for part in rng.normal(size=(3, nodes))]
    bonded = {
        name: (odd(rng, nodes), 0.2 * part)
        for name, part in zip(("mean", "one", "other"), even, strict=True)
    }
    bonded["mean"] = (0.2 * bonded["mean"][0], 1.0 + bonded["mean"][1])
    contact = fo.ContactSystem.from_blocks(
        S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:], np.arange(nodes), bonded
    )
    return (
        contact,
        fo.LoadCycle(
            {"mean": 1.0},
            [dict(zip(("one", "other"), rng.normal(size=2), strict=True)) for _ in range(4)],
        ),
        odd(rng, nodes),
    )


def leaves_the_symmetry(seed):
    """Whether a symmetric transient ends in an unsymmetric steady state, and the unproven events.

    The second value is the number of events without proof.
    """
    rng = np.random.default_rng(seed)
    contact, cycle, start = strongly_coupled(rng, int(rng.integers(2, 9)))
    try:
        steady = fo.steady_state(contact, cycle, 2.0, 2.0, initial_slip=3 * start, most_cycles=100)
    except fo.NoContinuation:
        return None
    assert f"unproven={steady.unproven})" in repr(steady)
    unsymmetric = np.abs(steady.slip + steady.slip[::-1]).max()
    return unsymmetric > 1e-6 * np.abs(steady.slip).max(), steady.unproven


def test_a_path_that_leaves_a_symmetry_says_that_its_rates_may_not_be_the_only_ones():
    seeds = (59, 144, 554, 2739, 3916, 4166, 4444, 7128, 7750)
    ends = [leaves_the_symmetry(seed) for seed in seeds]
    ends = [end for end in ends if end is not None]
    assert sum(left for left, _ in ends) > 4
    assert all(unproven > 0 for left, unproven in ends if left)


def test_ordinary_transients_are_proven(punch, paper_cycle):
    """Every event of an ordinary transient has proven rates.

    Without lift-off and below the critical friction the rates are proven to be the only ones.
    """
    contact = punch(40)
    for friction in (0.3, 0.7):
        limit = fo.shakedown_limit(contact, paper_cycle, friction).load_factor
        for factor in (0.8, 1.2):
            for start in (0.3, -2.0):
                steady = fo.steady_state(
                    contact,
                    paper_cycle,
                    friction,
                    factor * limit,
                    initial_slip=start * contact.x**3,
                )
                assert steady.unproven == 0 and steady.events > 3 and not steady.open.any()


def state_of(status, friction, gap):
    """A state with the given statuses of the nodes.

    Slipping nodes are at their bound, and open nodes have a gap.
    """
    nodes = len(status)
    r = np.r_[np.where(np.abs(status) == 1, -status * friction, 0.0), 1.0 * (status != 2)]
    state = new_state(np.r_[np.zeros(nodes), gap * (status == 2)], r, np.zeros(nodes))
    state.status[:] = status
    return state


def test_a_proof_holds_exactly_where_the_quadratic_form_is_definite():
    """The states follow each other, so that the proof grows, keeps its entries and starts anew."""
    rng, verdicts = np.random.default_rng(2), []
    for _ in range(20):
        n, contact = 6, mirrored(rng, 6)
        proof = new_active_set(n)
        friction = rng.uniform(3.0, 12.0, size=n)
        S = np.ascontiguousarray(contact.S)
        status = np.zeros(n, dtype=np.int8)
        for _ in range(15):
            status[rng.integers(n)] = rng.choice([0, 0, 1, -1, 2])
            moving = np.r_[status != 0, status == 2]
            rows = np.eye(2 * n) + np.block(
                [
                    [
                        np.zeros((n, n)),
                        np.diag(np.where(np.abs(status) == 1, status * friction, 0.0)),
                    ],
                    [np.zeros((n, 2 * n))],
                ]
            )
            form = (rows @ S)[np.ix_(moving, moving)]
            definite = not moving.any() or np.linalg.eigvalsh(form + form.T)[0] > 0
            verdicts.append(definite)
            assert (
                prove(S, friction, state_of(status, friction, 1.0), np.ones(len(friction)), proof)
                == definite
            )
    assert 50 < sum(verdicts) < 250


def test_nothing_is_proven_of_a_closed_node_without_pressure():
    S = np.ascontiguousarray(mirrored(np.random.default_rng(3), 2).S)
    for friction, pressure, gap, proven in (
        (0.2, 1.0, 0.0, True),
        (0.2, 0.0, 0.0, False),
        (0.0, 0.0, 0.0, False),
        (0.2, 0.0, 1.0, True),
    ):
        state = new_state(
            np.array([0.0, 0.0, gap, 0.0]), np.array([0.0, 0.0, pressure, 1.0]), np.zeros(2)
        )
        state.status[0] = 2 if gap else 0
        assert prove(S, np.full(2, friction), state, np.ones(2), new_active_set(2)) == proven


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
