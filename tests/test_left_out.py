"""What a scene does not need is left out, and the answer is the same with everything kept: paths."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from frictopt.contact.mirror import MirrorHalf, mirror_half
from frictopt.path import ExactPath, exact, steady
from frictopt.path.proof import new_proof, prove
from frictopt.path.settle import State
from frictopt.path.stops import turning_corners
from systems import mirrored, odd


@pytest.fixture
def small(monkeypatch):
    """Let contacts of any size be halved."""
    monkeypatch.setattr(exact, "_WORTH", 2)


def both(contact, cycle, friction, factor, **options):
    """Steady states with what is not needed left out, and with everything kept; errors instead where there are none."""
    found = []
    for simplify in (True, False):
        try:
            found.append(fo.steady_state(contact, cycle, friction, factor, simplify=simplify, **options))
        except fo.NoContinuation as error:
            found.append(error)
    return found


def assert_same(lean, full, tolerance):
    assert lean.outcome is full.outcome and (lean.open == full.open).all() and full.left_out == ()
    assert (lean.unproven == 0) == (full.unproven == 0)
    slip, work = 1.0 + np.abs(full.slip).max(), 1.0 + full.dissipation
    assert lean.slip == pytest.approx(full.slip, abs=tolerance * slip)
    assert lean.dissipation_per_node == pytest.approx(full.dissipation_per_node, abs=tolerance * work)
    assert lean.dissipation == pytest.approx(full.dissipation, abs=tolerance * work)
    assert lean.first_cycle == pytest.approx(full.first_cycle, rel=1e-9, abs=1e-12 * work)


@settings(max_examples=120, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(2, 8),
    f=st.sampled_from([0.0, 0.2, 0.5, 0.8, 1.2]),
    factor=st.floats(0.0, 3.0),
    gap=st.booleans(),
    amount=st.floats(0, 3),
)
def test_half_of_a_symmetric_contact_is_enough(seed, nodes, f, factor, gap, amount):
    rng = np.random.default_rng(seed)
    contact = mirrored(rng, nodes, gap=gap)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"one": rng.normal(), "other": rng.normal()} for _ in range(rng.integers(1, 5))])
    friction = f * (1 + 0.3 * np.abs(np.linspace(-1, 1, nodes)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exact, "_WORTH", 2)
        lean, full = both(contact, cycle, friction, factor, initial_slip=amount * odd(rng, nodes), most_cycles=100)
    assert type(lean) is type(full)
    if isinstance(full, fo.SteadyState):
        assert_same(lean, full, 1e-8)


def test_half_of_the_paper_scene(punch, paper_cycle, small):
    for elements, friction in ((16, 0.3), (18, 0.7), (40, 0.7)):
        contact = punch(elements)
        limit = fo.shakedown_limit(contact, paper_cycle, friction).load_factor
        for factor in (0.9, 1.3, 3.0):
            for start, overload in ((None, None), (0.3 * contact.x, 4.0 * limit)):
                lean, full = both(contact, paper_cycle, friction, factor * limit, initial_slip=start, overload=overload)
                assert_same(lean, full, 1e-9)
                kept = (contact.nodes + 1) // 2
                assert lean.left_out == (f"mirror symmetry: v is odd, {kept} of {contact.nodes} nodes were followed",)


def test_half_is_followed_only_where_it_saves_time(punch, paper_cycle):
    assert fo.steady_state(punch(40), paper_cycle, 0.7, 1.0).left_out == ()
    assert "mirror" in fo.steady_state(punch(60), paper_cycle, 0.7, 1.0).left_out[0]


def test_nothing_is_halved_where_something_is_not_symmetric(small, punch, paper_cycle):
    contact = punch(16)
    pushed = fo.LoadCycle({"P": 1.0}, [{"Q": -0.2}, {"Q": 0.2}])
    uneven = 0.7 * np.ones(contact.nodes)
    uneven[3] = 0.701
    gap = np.zeros(contact.nodes)
    gap[0] = 1e-3
    for system, cycle, friction, start in (
        (contact, pushed, 0.7, None),
        (contact, paper_cycle, uneven, None),
        (contact.with_gap(gap), paper_cycle, 0.7, None),
        (contact, paper_cycle, 0.7, 0.2 + 0.3 * contact.x),
    ):
        path = ExactPath(system, cycle, friction, 1.5, start)
        path.start()
        path.run_cycle()
        assert path.half_ways == (cycle is pushed)  # the way to the mean load is symmetric


@pytest.mark.parametrize("shear", [0.02, 0.2])
def test_a_shear_that_slips_nothing_yet_leaves_no_symmetry(small, punch, shear):
    """Under it the motion so far is none, and so symmetric; bulk stress that comes on top is symmetric too, but the whole load is not."""
    contact, cycle = punch(16), fo.LoadCycle({"P": 1.0, "Q": shear}, [{"sigma": -1.0}, {"sigma": 1.0}])
    for factor in (0.3, 2.0):
        lean, full = both(contact, cycle, 1.2, factor)
        assert_same(lean, full, 1e-9)
        assert lean.left_out == ()


def test_asymmetry_is_left_out_only_where_it_is_rounding(small, punch, paper_cycle):
    contact, rng = punch(16), np.random.default_rng(0)
    noise = rng.normal(size=contact.A.shape) / 10
    noise, q = noise + noise.T, rng.normal(size=contact.nodes) / 10
    for stiffness, load, halved in ((1e-15, 1e-14, True), (1e-11, 0.0, False), (0.0, 1e-10, False)):
        A = contact.A + stiffness * np.abs(contact.A).max() * noise
        bonded = {name: (one + load * q * np.abs(other).max(), other) for name, (one, other) in contact.bonded.items()}
        system = fo.ContactSystem(A, contact.B, contact.C, contact.x, bonded)
        lean, full = both(system, paper_cycle, 0.7, 2.5)
        assert bool(lean.left_out) == halved
        assert_same(lean, full, 1e-9)


def test_a_path_that_could_leave_the_symmetry_is_followed_as_a_whole(small):
    """Two nodes that wedge each other: with `1 - f < 0` against motions of both to one side, the symmetric rates are not the only ones."""
    A, B = np.array([[1.0, 0.3], [0.3, 1.0]]), np.array([[0.0, 0.9], [-0.9, 0.0]])
    bonded = {"mean": ([0.0, 0.0], [1.0, 1.0]), "cyclic": ([1.0, -1.0], [0.0, 0.0])}
    contact = fo.ContactSystem(A, B, 4 * np.eye(2), [-1.0, 1.0], bonded)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}, {"cyclic": -1.0}])
    for friction in (0.3, 1.0, 1.6, 2.5):
        lean, full = both(contact, cycle, friction, 3.0)
        assert type(lean) is type(full) and str(lean)[:60] == str(full)[:60]
        if isinstance(full, fo.SteadyState):
            assert_same(lean, full, 1e-9)
            assert bool(lean.left_out) == (friction < 0.7)


def test_the_half_has_the_stiffness_of_its_motions():
    """Energy and work of symmetric and of antisymmetric motions, against the whole; the inverse of each map."""
    rng = np.random.default_rng(0)
    for nodes in (2, 5, 6):
        contact = mirrored(rng, nodes, gap=True)
        half = mirror_half(contact, np.ones(nodes))
        assert isinstance(half, MirrorHalf) and half.nodes == (nodes + 1) // 2
        w = rng.normal(size=nodes)
        symmetric, leaving = (np.r_[odd(rng, nodes) + side * 0, w + w[::-1]] for side in (0, 1))
        leaving[:nodes], leaving[nodes:] = np.abs(leaving[:nodes]), odd(rng, nodes)
        for u, S in ((symmetric, half.system.S), (leaving, half.other)):
            own = np.r_[u[: half.nodes], u[nodes : nodes + half.nodes]]
            assert own @ S @ own == pytest.approx(u @ contact.S @ u / 2)
        r = contact.S @ symmetric
        own = np.r_[symmetric[: half.nodes], symmetric[nodes : nodes + half.nodes]]
        assert half.forces(r) == pytest.approx(half.system.S @ own)
        assert half.whole_forces(half.forces(r)) == pytest.approx(r) and half.whole_motion(own) == pytest.approx(symmetric)


def test_a_corner_on_the_straight_way_is_no_stop(punch, paper_cycle, small):
    contact = punch(16)
    sampled = fo.LoadCycle({"P": 1.0}, [{"sigma": s} for s in (-1.0, -0.3, -0.3, 0.2, 1.0, 1.0, 0.7, -0.1)])
    lean, full = both(contact, sampled, 0.7, 2.6)
    assert_same(lean, full, 1e-9)
    assert "corners: 5 of 8" in lean.left_out[-1] and full.dissipation > 0
    turning = fo.steady_state(contact, paper_cycle, 0.7, 2.6)
    assert lean.dissipation == pytest.approx(turning.dissipation, rel=1e-9)


def test_the_statuses_are_those_of_the_whole(punch, paper_cycle, small):
    lean, full = (fo.march(punch(16), paper_cycle, 0.7, 3.0, cycles=2, simplify=simplify) for simplify in (True, False))
    slips = np.abs(lean.status) == 1
    assert slips.any() and (lean.status[:, ::-1] == np.where(slips, -lean.status, lean.status)).all()
    for time in np.linspace(0.05, 3.95, 40):
        found = [one.status[np.searchsorted(one.time, time)] for one in (lean, full)]
        assert (found[0] == found[1]).all()


def test_what_is_open_is_asked_where_the_load_turns(punch, paper_cycle):
    path = ExactPath(punch(8), paper_cycle, 0.7, 1.0)
    closed, opened = np.zeros(18), np.eye(18)[12]
    for stops, corners in ((range(3), [closed, opened, closed]), ([0, 2], [closed, closed])):
        run = steady._Run(path, stops, [0, 2])
        assert not run._open([(u, u) for u in corners]).any()
    assert run._open([(closed, closed), (opened, opened)]).tolist() == [node == 3 for node in range(9)]


@pytest.mark.parametrize(
    ("amplitudes", "stops"),
    [
        ([0.0], [0]),
        ([1.0, 1.0], [0, 1]),
        ([0.0, 0.8, 0.5, 1.0], [0, 1, 2, 3]),
        ([0.0, 0.5, 1.0, 1.0, 0.5, 0.0], [0, 3, 5]),
        ([0.0, 1.0, 2.0, 3.0], [0, 3]),
        ([2.0, 1.0, 1.0, 1.0, 2.0], [0, 3, 4]),
    ],
)
def test_where_a_load_turns(amplitudes, stops):
    one = fo.LoadCycle({}, [{"a": a} for a in amplitudes])
    two = fo.LoadCycle({}, [{"a": 0.3 * a, "b": -0.7 * a} for a in amplitudes])
    for cycle in (one, two):
        assert turning_corners(cycle) == stops


def test_a_way_around_a_bend_is_no_straight_way():
    bent = fo.LoadCycle({}, [{"a": np.cos(t), "b": np.sin(t)} for t in np.linspace(0, 2 * np.pi, 1000)])
    assert turning_corners(bent) == list(range(1000))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), nodes=st.integers(2, 7), f=st.floats(0.1, 0.8))
def test_trajectories_are_the_same(seed, nodes, f):
    rng = np.random.default_rng(seed)
    contact, start = mirrored(rng, nodes), odd(rng, nodes)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"one": 1.0}, {"one": -1.0, "other": 0.5}])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exact, "_WORTH", 2)
        lean, full = (fo.march(contact, cycle, f, 1.5, initial_slip=start, cycles=3, simplify=simplify) for simplify in (True, False))
    assert "mirror" in lean.left_out[0] and full.left_out == ()
    for name in ("slip", "gap", "q", "p", "work"):
        at_corners = [getattr(found, name)[np.searchsorted(found.time, range(7), side="right") - 1] for found in (lean, full)]
        assert at_corners[0] == pytest.approx(at_corners[1], abs=1e-10)


def test_a_proof_holds_exactly_where_both_quadratic_forms_are_definite():
    """Against eigenvalues, over states that follow each other, so that the proof grows, keeps what it has and starts anew."""
    rng, verdicts = np.random.default_rng(2), []
    for _ in range(20):
        contact = mirrored(rng, 10)
        half, n = mirror_half(contact, np.ones(10)), 5
        proof, friction, S = new_proof(n, 2), rng.uniform(3.0, 12.0, size=n), np.ascontiguousarray(half.system.S)
        status = np.zeros(n, dtype=np.int8)
        for _ in range(15):
            status[rng.integers(n)] = rng.choice([0, 0, 1, -1, 2])
            u, r = np.zeros(2 * n), np.r_[np.zeros(n), np.ones(n)]
            r[:n] = np.where(np.abs(status) == 1, -status * friction, 0.0)
            u[n:], r[n:] = 1.0 * (status == 2), 1.0 * (status != 2)
            state = State(u, r, np.zeros(n), status, np.zeros(n), np.zeros(3, dtype=np.int64))
            moving = np.r_[status != 0, status == 2]
            rows = np.eye(2 * n) + np.block(
                [[np.zeros((n, n)), np.diag(np.where(np.abs(status) == 1, status * friction, 0.0))], [np.zeros((n, 2 * n))]]
            )
            forms = [(rows @ matrix)[np.ix_(moving, moving)] for matrix in (S, half.other)]
            definite = not moving.any() or min(np.linalg.eigvalsh(form + form.T)[0] for form in forms) > 0
            verdicts.append(definite)
            assert prove(S, half.other, friction, state, 1.0, proof) == definite
    assert 50 < sum(verdicts) < 250


def test_nothing_is_proven_of_a_closed_node_without_pressure():
    half = mirror_half(mirrored(np.random.default_rng(3), 4), np.ones(4))
    for friction, pressure, gap, proven in ((0.2, 1.0, 0.0, True), (0.2, 0.0, 0.0, False), (0.0, 0.0, 0.0, False), (0.2, 0.0, 1.0, True)):
        status = np.array([2 if gap else 0, 0], dtype=np.int8)
        state = State(
            np.array([0.0, 0.0, gap, 0.0]), np.array([0.0, 0.0, pressure, 1.0]), np.zeros(2), status, np.zeros(2), np.zeros(3, dtype=np.int64)
        )
        assert prove(np.ascontiguousarray(half.system.S), half.other, np.full(2, friction), state, 1.0, new_proof(2, 2)) == proven
