"""The limits of cycles of a transient in three dimensions.

They are compared with a plain run of the same increments, and with the exact path of plane
contacts.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.spatial import cycle, random_contact, single
from helpers.systems import at_corners, unit_nodes


def unguided(rng, nodes, corners):
    """Contact of a body that only friction holds, its cycle, friction, and a start.

    The start is some slip scales away.
    """
    m = 3 * nodes
    G, slide = rng.normal(size=(m, m)), np.zeros((m, 2))
    slide[:nodes, 0] = slide[nodes : 2 * nodes, 1] = nodes**-0.5
    across = np.eye(m) - slide @ slide.T
    bonded = {"P": np.r_[np.zeros(2 * nodes), rng.uniform(0.3, 2.0, nodes)]}
    bonded |= {f"c{k}": rng.normal(size=m) for k in range(corners)}
    loads = fo.LoadCycle({"P": 1.0}, [{f"c{k}": 1.0} for k in range(corners)])
    friction = float(rng.choice([0.2, 0.3, 0.5, 0.8]))
    start = rng.choice([0.0, 0.3, 1.0, 3.0]) * rng.normal(size=(nodes, 2))
    return (
        fo.ContactSystem(
            across @ (G @ G.T / m + 0.05 * np.eye(m)) @ across, rng.normal(size=(nodes, 3)), bonded
        ),
        loads,
        friction,
        start,
    )


def embedded_case(seed):
    """A random plane contact, the same contact in space, loads, friction, and a load factor.

    The slips in space are along the directions (N, 2), which come last.
    """
    rng = np.random.default_rng(seed)
    n = int(rng.choice([1, 2, 3, 5, 8]))
    G = rng.standard_normal((2 * n, 2 * n))
    S = G @ G.T / (2 * n) + 0.1 * np.eye(2 * n)
    coupling = rng.choice([0, 0.3, 1.0])
    S[:n, n:] *= coupling
    S[n:, :n] *= coupling
    G = rng.standard_normal((n, n))
    solid = np.zeros((3 * n, 3 * n))
    solid[n : 2 * n, n : 2 * n] = G @ G.T / n + 0.2 * np.eye(n)
    kept = np.r_[:n, 2 * n : 3 * n]
    solid[np.ix_(kept, kept)] = S
    bonded = {"P": (rng.standard_normal(n) * 0.1, rng.uniform(0.5, 2, n))}
    bonded |= {
        f"x{k}": (rng.standard_normal(n), rng.standard_normal(n) * rng.choice([0, 0.5]))
        for k in range(int(rng.integers(2, 5)))
    }
    friction = (
        float(rng.choice([0.2, 0.4, 0.7])) if rng.random() < 0.7 else rng.uniform(0.1, 0.8, n)
    )
    angle = rng.uniform(0, 2 * np.pi, n) if rng.random() < 0.6 else np.zeros(n)
    i = np.arange(n)
    turn = np.eye(3 * n)
    turn[i, i] = turn[n + i, n + i] = np.cos(angle)
    turn[i, n + i], turn[n + i, i] = np.sin(angle), -np.sin(angle)
    rng.standard_normal((n, 3))
    plane = fo.ContactSystem.from_blocks(S[:n, :n], S[n:, :n], S[n:, n:], i * 1.0, bonded)
    in_space = {name: turn @ np.r_[q, np.zeros(n), p] for name, (q, p) in bonded.items()}
    space = fo.ContactSystem(turn @ solid @ turn.T, np.c_[i, i * 0, i * 0], in_space)
    loads = fo.LoadCycle({"P": 1.0}, [{name: 1.0} for name in bonded if name != "P"])
    limit = fo.shakedown_limit(plane, loads, friction).load_factor
    at = (limit if np.isfinite(limit) and limit > 0 else 1.0) * float(
        rng.choice([0.5, 0.9, 1.05, 1.5])
    )
    return plane, space, loads, friction, at, np.c_[np.cos(angle), -np.sin(angle)]


def corner_slips(path):
    """Slips at the mean load and the corners."""
    return path.slip[[np.flatnonzero(path.time == k)[-1] for k in range(int(path.time[-1]) + 1)]]


@pytest.mark.parametrize("seed", [7, 9, 23, 53])
def test_the_steady_state_of_random_unguided_contacts_is_that_of_plain_following(seed):
    contact, loads, friction, start = unguided(
        np.random.default_rng(seed), 2 + seed % 2, 2 + seed // 2 % 2
    )
    at = (0.95, 0.99)[seed // 4 % 2] * fo.shakedown_limit(contact, loads, friction).load_factor
    path = fo.march(contact, loads, friction, at, initial_slip=start, steps=4, cycles=60)
    steady = fo.steady_state(contact, loads, friction, at, initial_slip=start, steps=4)
    works = path.cycle_work.sum(axis=1)
    assert works[-1] == pytest.approx(works[-2], rel=1e-7)
    assert steady.dissipation == pytest.approx(works[-1], rel=1e-6)
    ends = corner_slips(path)[:: len(loads.corners)]
    drift = np.abs(ends[-1] - ends[-2]).max()
    assert (steady.outcome is fo.Outcome.RATCHETING) == (drift > 1e-3)
    assert drift > 1e-3 or steady.slip == pytest.approx(ends[-1], abs=1e-5)


def at_share(share, contact, friction):
    """A contact and its cycle at a share of its limit."""
    limit = fo.shakedown_limit(contact, cycle(2), friction)
    return contact, cycle(2), friction, share * limit.load_factor


@pytest.mark.parametrize("seed", [2, 38, 56, 149, 128])
def test_slip_whose_last_events_are_yet_to_come_tells_how_far_off_its_work_is(seed):
    """Some nodes still slip or open in the last returns and not in the steady state, or vice versa,
    and such events change the steady state. The last seed has no such event."""
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(2, 13))
    friction = float(rng.uniform(0.1, 0.6))
    share = float(rng.choice([0.8, 0.95, 1.05, 1.2, 2.0]))
    contact = random_contact(rng, nodes)
    contact = contact.with_gap(np.where(rng.random(nodes) < 0.4, 0.3 * rng.random(nodes), 0))
    problem = at_share(share, contact, friction)
    steady = fo.steady_state(*problem, steps=8)
    works = fo.march(*problem, steps=8, cycles=120).cycle_work.sum(axis=1)
    assert works[-1] == pytest.approx(works[-20], rel=1e-9)
    assert 1e-9 < abs(steady.dissipation / works[-1] - 1) <= steady.work_error < 1e-5


@pytest.mark.parametrize(
    ("seed", "share", "steps", "most"),
    [(464, 0.95, 2, 12), (166, 2.5, 8, 12), (604, 0.95, 2, 8), (193, 0.95, 2, 8)],
)
def test_nodes_that_stop_before_the_limit_or_have_stopped_leave_no_error_untold(
    seed, share, steps, most
):
    rng = np.random.default_rng([29, seed])
    nodes = int(rng.integers(3, most + 1))
    contact = random_contact(rng, nodes, coupling=float(rng.choice([0.2, 0.5, 0.8, 1.0])))
    friction = rng.uniform(0.2, 0.8, nodes) if seed % 4 else float(rng.uniform(0.2, 0.8))
    if steps == 2:
        contact = contact.with_gap(np.where(rng.random(nodes) < 0.4, 0.3 * rng.random(nodes), 0))
    problem = at_share(share, contact, friction)
    steady = fo.steady_state(*problem, steps=steps)
    works = fo.march(*problem, steps=steps, cycles=500).cycle_work.sum(axis=1)
    assert works[-1] == pytest.approx(works[-20], rel=1e-9)
    assert abs(steady.dissipation / works[-1] - 1) <= max(1e-9, steady.work_error) < 1e-5


@pytest.mark.parametrize(
    ("seed", "steps"), [(30, 2), (30, 20), (19, 4), (19, 20), (29, 20), (4, 10), (6, 20), (64, 4)]
)
def test_the_error_of_increments_is_at_most_what_a_steady_state_tells_and_five_times_what_a_transient_does(
    seed, steps
):
    """The estimated error of increments bounds the true error.

    It bounds it by one time the estimate of a steady state, and by five times the estimate of a
    transient. The exact path of a plane contact gives the true error, also where all numbers of
    increments have the same error.
    """
    plane, solid, loads, friction, at, turned = embedded_case(seed)
    exact = fo.steady_state(plane, loads, friction, at)
    steady = fo.steady_state(solid, loads, friction, at, steps=steps)
    assert steady.outcome is exact.outcome is fo.Outcome.CYCLIC_SLIP
    assert 1e-9 < abs(exact.dissipation / steady.dissipation - 1) < steady.step_error
    plane_path = fo.march(plane, loads, friction, at, cycles=3)
    path = fo.march(solid, loads, friction, at, cycles=3, steps=steps)
    length = (
        max(float(np.abs(plane_path.bonded_p).max()), float(np.abs(plane_path.bonded_q).max()))
        / solid.stiffness_scale
    )
    assert (
        np.abs(corner_slips(path) - corner_slips(plane_path)[..., None] * turned).max() / length
        < 5 * path.step_error + 1e-9
    )


def test_increments_that_have_several_times_the_work_say_so():
    """One node is at twice its limit. Two increments from corner to corner give almost five times
    the work."""
    bonded = {"P": ([0.0], [1.0]), "Q": ([-0.963], [-0.385]), "R": ([-0.545], [-0.323])}
    node = fo.ContactSystem.from_blocks([[1.0]], [[-0.3]], [[1.0]], [0.0], bonded)
    loads = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"R": 1.0}])
    at = 2 * fo.shakedown_limit(node, loads, 0.5).load_factor
    exact = fo.steady_state(node, loads, 0.5, at)
    steady = fo.steady_state(node, loads, 0.5, at, steps=2)
    assert 4 < steady.dissipation / exact.dissipation
    assert 1 - exact.dissipation / steady.dissipation < steady.step_error


def test_other_increments_without_an_answer_leave_the_error_unknown(monkeypatch):
    loads = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    along = fo.increments.NewtonIncrement.along

    def failing(self, u, ahead):
        if len(ahead) not in (1, 4):  # increments from corner to corner, or to a state
            raise fo.SolverError("none")
        return along(self, u, ahead)

    monkeypatch.setattr(fo.increments.NewtonIncrement, "along", failing)
    assert fo.march(single(), loads, 0.5, 0.9, cycles=1, steps=4).step_error == np.inf
    assert fo.steady_state(single(), loads, 0.5, 0.9, steps=4).step_error == np.inf


def test_a_node_does_no_work_while_it_is_open():
    """It slips a little before it opens, from 0.3968 to 0.4 of the segment, and moves freely
    afterwards."""
    loads = fo.LoadCycle({"P": 1.0}, [{"P": -2.5, "X": 0.01}])
    path = fo.march(single(), loads, 0.5, 1.0, cycles=1, steps=2)
    assert abs(path.slip[-1, 0, 0]) == pytest.approx(0.01) and 0 <= path.work[-1, 0] < 1e-4


@pytest.mark.parametrize("steps", [None, 2, 7])
def test_what_a_node_does_in_an_increment_in_which_it_opens_or_closes_is_in_doubt(steps):
    """All numbers of increments have the same error: in one increment the node slides and opens, or
    comes down at another slip than before."""
    plane = unit_nodes({"P": ([0.0], [1.0]), "X": ([1.0], [0.0])})
    slides = fo.LoadCycle({"P": 0.5}, [{"P": -0.48}, {"P": -0.48, "X": 0.03}, {"P": -1.5}])
    exact = fo.steady_state(plane, slides, 2.0, 1.0)
    steady = fo.steady_state(single(), slides, 2.0, 1.0, steps=steps)
    assert exact.dissipation > 4e-4 and steady.dissipation == 0 and steady.step_error == np.inf
    comes_down = fo.LoadCycle({"P": 1.0}, [{"P": -1.02}, {"X": 1.0}])
    plane_path = fo.march(plane, comes_down, 2.0, 1.0, cycles=1)
    path = fo.march(single(), comes_down, 2.0, 1.0, cycles=1, steps=steps)
    assert plane_path.slip[-1, 0] == pytest.approx(-0.02 / 1.02)
    assert (
        np.abs(path.slip[-1, 0] - [plane_path.slip[-1, 0], 0.0]).max() / 1.02
        <= path.step_error + 1e-12
    )


def test_what_is_known_when_cycles_run_out_is_in_the_error():
    contact, loads, friction, start = unguided(np.random.default_rng(9), 3, 2)
    problem = (
        contact,
        loads,
        friction,
        0.95 * fo.shakedown_limit(contact, loads, friction).load_factor,
    )
    path = fo.march(*problem, initial_slip=start, steps=4, cycles=3)
    with pytest.raises(
        fo.NoContinuation, match=r"within . of most_cycles = 3 cycles \(the slip changes by"
    ) as caught:
        fo.steady_state(*problem, initial_slip=start, steps=4, most_cycles=3)
    assert np.array_equal(caught.value.slip, path.slip[-1])
    assert np.array_equal(caught.value.gap, path.gap[-1])
    assert caught.value.work == pytest.approx(path.cycle_work.sum(axis=1), rel=1e-12)


def test_a_node_without_friction_moves_without_an_end_and_is_at_rest_as_in_the_plane():
    loads = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    plane = unit_nodes({"P": ([0.0], [1.0]), "X": ([1.0], [0.0])})
    for contact in (single(), plane):
        steady = fo.steady_state(contact, loads, 0.0, 1.0)
        assert steady.outcome is fo.Outcome.SHAKEDOWN and steady.dissipation == 0


@pytest.mark.parametrize(("seed", "ratio"), [(39, 0.9015625), (55, 0.8875)])
def test_work_that_dies_out_slowly_is_rest_however_close_the_limit(seed, ratio):
    """In a plain run each cycle has less work than the cycle before, and finally less than a
    millionth of the work of the first cycle."""
    rng, nodes = np.random.default_rng(seed), 2 + seed % 2
    contact, loads = random_contact(rng, nodes), cycle(nodes)
    problem = contact, loads, 0.5, ratio * fo.shakedown_limit(contact, loads, 0.5).load_factor
    start = 0.5 * rng.normal(size=(nodes, 2))
    steady = fo.steady_state(*problem, initial_slip=start, steps=2)
    assert steady.outcome is fo.Outcome.SHAKEDOWN and steady.dissipation == 0
    q, p = at_corners(contact, loads, problem[3], steady.slip)
    assert (np.linalg.norm(q, axis=2) <= 0.5 * p + 1e-9).all()
    works = fo.march(*problem, cycles=600, initial_slip=start, steps=2).cycle_work.sum(axis=1)
    assert (np.diff(works) <= 1e-14).all() and works[-1] < 1e-6 * works[0]
