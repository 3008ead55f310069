"""Steady states that come back after two load cycles.

Their works repeat to nine digits, and the answers name the nodes that slip in them.
"""

import numpy as np
import pytest
from scipy.linalg import block_diag

import frictopt as fo
from frictopt.transients.classify import returns_after
from helpers.paths import ASKED, ROUND, TWICE
from helpers.return_maps import Mapped, settled
from helpers.systems import unit_nodes
from studies.validation.fuzz.embedded import embedded


@pytest.mark.parametrize(
    ("contact", "options", "exact"),
    [(TWICE, {}, 1e-12), (embedded(TWICE, np.random.default_rng(0))[0], {"steps": 4}, 1e-9)],
)
def test_a_contact_of_two_nodes_comes_back_after_two_cycles(contact, options, exact):
    """The cycle written down twice is another description of the same loads: its steady state comes
    back after one cycle."""
    problem = contact, ROUND, 1.2, 1.0
    steady = fo.steady_state(*problem, **options)
    path = fo.march(*problem, cycles=30, **options)
    works = path.cycle_work
    ends = path.slip[[np.searchsorted(path.time, 3 * k + 1e-9) - 1 for k in range(27, 31)]]
    # By the transient itself.
    assert np.abs(ends[2:] - ends[:2]).max() < exact / 100
    assert np.abs(ends[1:] - ends[:-1]).max() > 0.01
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP
    assert steady.period == 2
    assert steady.cycles < 30
    assert steady.work_error < 1e-9
    assert steady.dissipation_per_node == pytest.approx((works[-1] + works[-2]) / 2, rel=exact)
    assert works[-2].sum() > 1.5 * works[-1].sum()
    assert min(np.abs(steady.slip - end).max() for end in ends) < exact / 100
    twice = fo.steady_state(
        contact, fo.LoadCycle(ROUND.mean, [*ROUND.corners, *ROUND.corners]), 1.2, 1.0, **options
    )
    assert twice.period == 1
    assert twice.dissipation == pytest.approx(2 * steady.dissipation, rel=exact)
    # An estimate from some cycles, which are twice as many here.
    assert twice.step_error == pytest.approx(steady.step_error, rel=0.1)
    if not options:
        states = steady.states()
        slip_lengths = np.abs(np.diff(states.slip, axis=0) * (states.status[:-1] != 2)).sum(axis=0)
        assert slip_lengths.min() > 0
        assert (
            steady.sliding_distance
            == pytest.approx(slip_lengths / 2, rel=1e-12)
            == twice.sliding_distance / 2
        )


def test_what_follows_from_a_state_of_period_two():
    steady = fo.steady_state(*ASKED)
    again = fo.steady_state(*ASKED, initial_state=steady.state)
    assert again.period == 2 and again.dissipation == pytest.approx(steady.dissipation, rel=1e-12)
    states = steady.states()
    assert states.time[-1] == 6.0 and states.slip[-1] == pytest.approx(states.slip[0], abs=1e-14)
    assert states.work[-1] == pytest.approx(2 * steady.dissipation_per_node, rel=1e-12)
    assert steady.fretting_table()["work"].sum() == steady.dissipation
    row = fo.dissipation_study(*ASKED[:3], [1.0], progress=False).iloc[0]
    assert (row.outcome, row.dissipation, row.slipping) == ("CYCLIC_SLIP", steady.dissipation, 2)


@pytest.mark.parametrize("least", [5, 6, 7])
def test_a_return_after_two_cycles_is_not_missed_at_the_last_moment(least):
    with pytest.raises(fo.NoContinuation, match="most_cycles"):
        fo.steady_state(*ASKED, most_cycles=least)


def test_maps_that_come_back_after_two_cycles_slowly_are_extrapolated():
    """The map applied twice has two attracting points, 2 and -1, which it approaches by a factor of
    .98 in two cycles."""

    def swaps(x):
        return -1.0 - 0.7 * (x - 2.0) if x > 0.5 else 2.0 - 1.4 * (x + 1.0)

    path = Mapped(swaps, 2.4)
    outcome, limit, run = settled(path, 200)
    assert outcome is fo.Outcome.CYCLIC_SLIP
    assert run.period == 2
    assert run.cycles < 100
    assert returns_after(path, run.last[-1]) == 2
    assert min(abs(limit - 2.0), abs(limit + 1.0)) < 1e-8
    assert abs(swaps(swaps(float(limit[0]))) - limit) < 1e-9


def test_a_map_that_turns_to_and_fro_around_its_fixed_point_has_period_one():
    path = Mapped(lambda x: 3.0 - 0.99 * (x - 3.0), 10.0)
    outcome, limit, run = settled(path, 200)
    assert outcome is fo.Outcome.CYCLIC_SLIP
    assert limit == pytest.approx(3.0, abs=1e-8)
    assert run.cycles < 60
    assert run.period == 2 and returns_after(path, run.last[-1]) == 1


def punched(ratio):
    scene = fo.scenes.PunchOnHalfPlane(elements=24).condense()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    return scene, cycle, 0.5, ratio * fo.shakedown_limit(scene, cycle, 0.5).load_factor


@pytest.mark.parametrize("ratio", [1.01, 1.2, 2.0])
def test_nodes_slip_whose_slip_range_is_no_rounding(ratio):
    """The states of the cycle decide, whatever the works of the other nodes are."""
    problem = punched(ratio)
    steady = fo.steady_state(*problem)
    moved = steady.fretting_table()["slip_range"].to_numpy()
    assert np.array_equal(steady.slipping, moved > 1e-6 * moved.max())
    assert 0 < steady.slipping.sum() < len(moved)
    assert fo.dissipation_study(*problem[:3], [problem[3]], progress=False)[
        "slipping"
    ].tolist() == [steady.slipping.sum()]
    assert not fo.steady_state(*problem[:3], 0.5 * problem[3] / ratio).slipping.any()


def test_a_node_without_friction_slides_but_does_not_slip():
    pair = unit_nodes({"P": ([0, 0], [1, 1]), "Q": ([1, 1], [0, 0])})
    steady = fo.steady_state(
        pair, fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}, {"Q": -2.0}]), [0.0, 0.5], 1.0
    )
    assert steady.slipping.tolist() == [False, True]


def with_little_work(seed, excess=1e-8):
    """Four nodes that come to rest, a fifth that slips to and fro, and the work of the fifth.

    Some of the four nodes come to rest slowly. The fifth node is uncoupled and slips by 2 * excess.
    """
    rng, n, f = np.random.default_rng(seed), 4, 0.5
    G = rng.standard_normal((2 * n, 2 * n))
    S = G @ G.T / n + 0.1 * np.eye(2 * n)
    A, B, C = S[:n, :n], 0.5 * S[n:, :n], S[n:, n:]
    P = (0.2 * rng.standard_normal(n), rng.uniform(0.3, 2.0, n))
    Q = (rng.standard_normal(n), 0.3 * rng.standard_normal(n))
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    size = (
        rng.uniform(0.5, 1.0)
        * fo.shakedown_limit(
            fo.ContactSystem.from_blocks(A, B, C, np.arange(n), {"P": P, "Q": Q}), cycle, f
        ).load_factor
    )
    loads = {
        "P": (np.r_[P[0], 0.0], np.r_[P[1], 1.0]),
        "Q": (np.r_[size * Q[0], f + excess], np.r_[size * Q[1], 0.0]),
    }
    system = fo.ContactSystem.from_blocks(
        block_diag(A, 1.0), block_diag(B, 0.0), block_diag(C, 1.0), np.arange(n + 1), loads
    )
    return (system, cycle, f, 1.0), np.r_[rng.standard_normal(n), 0.0], 4 * f * excess


@pytest.mark.parametrize("seed", [341, 145, 374, 8, 158])
def test_a_little_work_is_not_that_of_slips_that_still_die_out(seed):
    """The excess is known to 1e-8 of itself, and the state to its rounding. Both leave an error of
    2e-7 of the work."""
    problem, start, work = with_little_work(seed)
    steady = fo.steady_state(*problem, initial_slip=start)
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP
    assert steady.dissipation == pytest.approx(work, rel=4e-7, abs=0)
    assert steady.slipping.tolist() == [False] * 4 + [True]
