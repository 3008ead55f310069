"""The exact path in closed form, by its law, and against a path on one page of numpy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.paths import followed, judged
from helpers.plain_path import cycle_work
from helpers.systems import CYCLE, random_system, system


@settings(max_examples=few(60))
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 6),
    corners=st.integers(1, 4),
    size=st.floats(0.0, 5.0),
    with_gap=st.booleans(),
)
def test_every_state_obeys_the_law(seed, nodes, corners, size, with_gap):
    """Every state of the exact path obeys the law of friction.

    The random systems are coupled and have separation, gaps, node-wise friction, any number of
    corners, and starts that the law does not admit.
    """
    rng = np.random.default_rng(seed)
    contact = random_system(rng, nodes, loads=("mean", "a", "b")).with_gap(
        0.3 * rng.random(nodes) * (rng.random(nodes) < 0.5) if with_gap else None
    )
    friction = rng.uniform(0.0, 0.5, nodes) * (rng.random(nodes) < 0.9)
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(corners, 2))]
    )
    path = followed(contact, cycle, friction, size, rng.normal(size=nodes), keep=True, cycles=3)
    assert judged(path) < 1e-9
    work = path.states()[4]
    assert (np.diff(work, axis=0) >= 0).all() and path.visited == 3 * corners


def test_an_initial_gap_closes_when_the_bodies_meet():
    contact = system(
        np.eye(2), np.zeros((2, 2)), 0.0, (1.0, 1.0), 0.0, (0.5, 0.5), C=np.eye(2), gap=[0.0, 1.2]
    )
    path = followed(contact, CYCLE, 0.3, 1.0, keep=True)
    assert path.state.status[1] == 2 and path.state.u[3] + 1.2 == pytest.approx(0.2)
    path.follow(path.segments)  # ends at p^w = 1.5
    assert path.state.status[1] != 2 and path.state.r[3] == pytest.approx(0.3)


def test_an_admissible_slip_stays_as_it_is(punch, paper_cycle):
    contact = punch(16)
    safe = fo.safe_slip(contact, paper_cycle, 0.7, 0.0).slip
    path = followed(contact, paper_cycle, 0.7, 1.0, safe)
    assert np.array_equal(path.state.u[:17], safe) and not path.state.work.any()


def test_wedging_has_no_or_two_continuations():
    """A = 1, B = 1/2, C = 1, f = 3 > A/|B| = 2 (Klarbring 1990). At its backward bound, a node that
    is pushed on jumps; a node that is released may stick or slip."""
    loads = {"mean": ([0.0], [1.0]), "push": ([1.0], [0.0])}
    contact = fo.ContactSystem.from_blocks([[1.0]], [[0.5]], [[1.0]], [0], loads)
    with pytest.raises(
        fo.NoContinuation,
        match=r"the segment to the corner \(push = \+5\): at 0\.6 of it no rates obey the law; nodes \[0\]",
    ):
        fo.steady_state(contact, fo.LoadCycle({"mean": 1.0}, [{"push": 5.0}]), 3.0, 1.0)
    with pytest.raises(
        fo.NoContinuation,
        match=r"two sets of rates obey the law: nodes \[0\] may take the statuses \[0\] or \[-1\]",
    ):
        fo.steady_state(
            contact, fo.LoadCycle({"mean": 1.0}, [{"push": 3.0}, {"push": 0.0}]), 3.0, 1.0
        )
    below = fo.steady_state(
        contact, fo.LoadCycle({"mean": 1.0}, [{"push": 2.0}, {"push": -2.0}]), 1.5, 1.0
    )
    assert below.outcome is fo.Outcome.CYCLIC_SLIP


def test_too_few_cycles_are_said(punch, paper_cycle):
    with pytest.raises(fo.NoContinuation, match=r"none proven within . of most_cycles = 1 cycles"):
        fo.steady_state(
            punch(16), paper_cycle, 0.7, 2.2, initial_slip=np.sin(9 * punch(16).x), most_cycles=1
        )


@pytest.mark.parametrize("elements", [16, 40])
@pytest.mark.parametrize("share", [0.9, 1.3, 2.0])
def test_works_of_the_punch_are_those_of_one_page(punch, paper_cycle, elements, share):
    contact = punch(elements)
    load_factor = share * fo.shakedown_limit(contact, paper_cycle, 0.7).load_factor
    slip = 0.3 * contact.x**3 + 0.1 * np.sin(7 * contact.x)
    work = fo.march(contact, paper_cycle, 0.7, load_factor, initial_slip=slip, cycles=3).cycle_work
    assert (
        np.abs(cycle_work(contact, paper_cycle, 0.7, load_factor, slip, 3) - work).max()
        <= 1e-10 * work.max()
    )


@pytest.mark.parametrize("seed", few(range(30)))
def test_works_of_nodes_that_open_and_close_are_those_of_one_page(seed):
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(1, 9))
    contact = random_system(rng, nodes, loads=("mean", "a", "b")).with_gap(
        0.3 * rng.random(nodes) * (rng.random(nodes) < 0.5)
    )
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(3, 2))]
    )
    friction, slip = rng.uniform(0.1, 0.5, nodes), rng.normal(size=nodes)
    work = fo.march(contact, cycle, friction, 3.0, initial_slip=slip, cycles=3).cycle_work
    assert work.max() > 0
    assert (
        np.abs(cycle_work(contact, cycle, friction, 3.0, slip, 3) - work).max()
        <= 1e-10 * work.max()
    )
