"""The range of dissipation that a search finds.

It is compared with closed forms, published cases, samples of starts, and proven bounds of the slip.
"""

from functools import cache

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import pose
from frictopt.study.range_search import Search
from helpers.cases import few
from helpers.paths import followed
from helpers.systems import CYCLE, FIRST_PAIR, PULL, SHEAR, system
from studies.validation.closed_forms import single_node_limit

PULLED = fo.LoadCycle({"P": 1.0, "Q": 0.2}, [{"sigma": -1.0}, {"sigma": 1.0}])
ROUND = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"Q": 0.1}, {"sigma": -1.0}, {"Q": -0.1}])


@cache  # several tests ask for the same range
def found(contact, cycle, friction, ratio, **options):
    limit = fo.shakedown_limit(contact, cycle, friction).load_factor
    return limit * ratio, fo.dissipation_range(contact, cycle, friction, limit * ratio, **options)


def reached(contact, cycle, friction, load_factor, start):
    return fo.steady_state(contact, cycle, friction, load_factor, initial_slip=start).dissipation


def outside(contact, cycle, friction, load_factor, span, starts):
    """Steady dissipations of starts that lie outside of a range, and how many were followed."""
    works = []
    for start in starts:
        try:
            works.append(reached(contact, cycle, friction, load_factor, start))
        except (fo.NoContinuation, fo.SolverError):
            continue
    works = np.array(works)
    return works[(works > span.most * (1 + 1e-6)) | (works < span.least * (1 - 1e-6))], len(works)


def slips(rng, contact, count, unit):
    """Smooth and rough slips, from a hundredth of a unit of length to ten times it."""
    for number in range(count):
        slip = (
            rng.normal(size=contact.nodes)
            if number % 2
            else np.cumsum(rng.normal(size=contact.nodes))
        )
        yield unit * 10 ** rng.uniform(-2, 1) * (slip - slip.mean()) / np.abs(slip).max()


@pytest.mark.parametrize(
    ("load_factor", "least", "most"),
    [(0.5, 0.0, 0.0429281), (0.65, 0.0, 0.123305), (0.8, 0.187171, 0.227889)],
)
def test_two_nodes(load_factor, least, most):
    span = fo.dissipation_range(system(*FIRST_PAIR), CYCLE, 0.6, load_factor)
    assert span.least == pytest.approx(least, rel=1e-5)
    assert span.most == pytest.approx(most, rel=1e-5)
    assert span.residual <= 1e-9 and span.levels[-1] == pytest.approx(span.most, rel=1e-6)


def test_one_node_and_sliders_have_one_dissipation():
    one = {"A": 2.0, "B": 0.5, "q0": 0.1, "p0": 1.0, "q1": 1.0, "p1": 0.2}
    limit = single_node_limit(**one, f=0.4)
    span = fo.dissipation_range(system(**one), CYCLE, 0.4, 1.2 * limit)
    assert span.least == pytest.approx(0.061945108310, rel=1e-9) == span.most
    k, bound = np.array([1.0, 2.0, 4.0]), np.array([0.5, 0.6, 0.4])
    sliders = system(np.diag(k), np.zeros((3, 3)), 0.0, bound, -0.5 * k, 0.0)
    span = fo.dissipation_range(sliders, CYCLE, 1.0, 1.0)
    assert span.least == pytest.approx(1.12, rel=1e-9) == span.most


@pytest.mark.parametrize(
    ("cycle", "friction", "ratio"),
    few(
        [
            (ROUND, 0.5, 0.9),
            (PULLED, 0.5, 0.95),
            (SHEAR, 0.3, 1.2),
            (PULL, 0.5, 0.9),
            (PULL, 0.7, 1.2),
            (SHEAR, 0.2, 0.9),
            (PULLED, 0.4, 1.2),
        ]
    ),
)
def test_no_sampled_start_lies_outside(cycle, friction, ratio, paper_punch):
    contact = paper_punch(16)
    load_factor, span = found(contact, cycle, friction, ratio)
    out, followed = outside(
        contact,
        cycle,
        friction,
        load_factor,
        span,
        slips(np.random.default_rng(0), contact, 60, 1.0),
    )
    assert followed > 54 and not len(out)


def test_the_least_orbit_slips_as_little_as_is_proven(paper_punch):
    contact = paper_punch(16)
    limit = fo.shakedown_limit(contact, PULL, 0.7)
    for ratio in (1.05, 1.2, 1.5):
        load_factor, span = found(contact, PULL, 0.7, ratio)
        path = followed(contact, PULL, 0.7, load_factor, span.least_start, cycles=30)
        corners = []
        for corner in path.corners:
            path.follow_to(corner, "")
            corners.append(path.state.u[:17].copy())
        least = limit.least_slip(load_factor)
        assert least.of(corners) == pytest.approx(least.bound, rel=1e-4)


def test_a_sampled_history_has_starts_at_its_ends_and_a_few_corners_between(
    paper_punch, monkeypatch
):
    """One program for each corner and each step of a history of hundreds of steps would give tens
    of thousands of programs."""
    # Of the starts around an end a few are enough here.
    monkeypatch.setattr("frictopt.study.range_search.MOST_AROUND", 8)
    places = np.r_[0.3 * np.cos(np.arange(14)), 1.0, -1.0]
    cycle = fo.LoadCycle(
        {"P": 1.0}, [{"sigma": float(x), "Q": 0.03 * float(x) ** 2} for x in places]
    )
    _, span = found(paper_punch(8), cycle, 0.5, 1.1)
    starts = span.to_frame()["start"]
    at = {name for name in cycle.corner_names if starts.str.endswith(f", at {name}").any()}
    assert {*cycle.corner_names[-2:]} <= at and 2 < len(at) <= 12
    assert 0 < span.least <= span.most


def test_the_search_finds_more_than_the_extreme_slips(paper_punch):
    _, span = found(paper_punch(16), SHEAR, 0.3, 1.2)
    table = span.to_frame()
    begun = table.loc[table["end"] == "followed", "dissipation"]
    assert span.most > 1.1 * begun.max()
    assert span.least < begun.min()
    assert "local extreme" in set(table["end"])


def blocky(seed, n, least_nodes, frictions):
    """A dense random contact and its loads.

    Its friction is the same at all nodes or not.
    """
    rng = np.random.default_rng(seed)
    assert rng.integers(least_nodes, 13) == n and rng.choice(4) < 4
    coupling, G = rng.uniform(0.2, 1.0), rng.standard_normal((2 * n, 2 * n))
    S = G @ G.T / n + 0.3 * np.eye(2 * n)
    loads = {"P": (rng.choice([0.0, 0.3]) * rng.standard_normal(n), rng.uniform(0.3, 2.0, n))}
    loads |= {name: (rng.standard_normal(n), 0.2 * rng.standard_normal(n)) for name in "QR"}
    f = rng.uniform(*frictions) if rng.random() < 0.5 else rng.uniform(*frictions, n)
    corners = [
        {"Q": rng.standard_normal(), "R": rng.standard_normal() * rng.integers(0, 2)}
        for _ in range(rng.integers(2, 5))
    ]
    contact = fo.ContactSystem.from_blocks(
        S[:n, :n], coupling * S[n:, :n], S[n:, n:], np.arange(n), loads
    )
    return contact, fo.LoadCycle({"P": 1.0}, corners), f, rng


def around(start, rng, count):
    return [
        start + (1 + number % 2) * np.ptp(start) * rng.uniform(-1, 1, len(start))
        for number in range(count)
    ]


@pytest.mark.parametrize(
    ("seed", "n", "seed_of_starts", "count"), few([(1027, 8, 1038, 60), (1039, 7, 777, 200)], 1)
)
def test_no_start_beside_the_worst_one_has_more_work_where_all_tried_there_have_less(
    seed, n, seed_of_starts, count
):
    """Below the limit few random starts lead to the basin of the most work: one in twenty, one in
    sixty."""
    contact, turns, f, _ = blocky(seed, n, 2, (0.1, 0.9))
    load_factor, span = found(contact, turns, f, 0.9)
    works = [
        reached(contact, turns, f, load_factor, start)
        for start in around(span.worst_start, np.random.default_rng(seed_of_starts), count)
    ]
    assert max(works) < 1.02 * span.most


def test_a_search_follows_no_start_in_vain(paper_punch):
    """Starts that one cycle brings to the same state have the work of one start. Starts that are
    given up have less work than the search looks for; the other starts have their own work."""
    contact, f = paper_punch(16), np.full(17, 0.7)
    load_factor = 1.2 * fo.shakedown_limit(contact, PULL, 0.7).load_factor
    far = 30 * (contact.x - contact.x.mean())
    search = Search(pose(contact, PULL, f), load_factor, None, lambda: None)
    one, other, none = (
        search.follow(name, slip)
        for name, slip in {"one": far, "other": 3 * far, "none": 0 * far}.items()
    )
    assert other.state is one.state and none.state is not one.state
    works = [reached(contact, PULL, f, load_factor, slip) for slip in (far, 3 * far, 0 * far)]
    np.testing.assert_allclose([one.work, other.work, none.work], works, rtol=1e-9)
    again, new = ([(str(factor), factor * slip) for factor in (1, 3)] for slip in (far, -far))
    assert [orbit.name for orbit in search.further(again)] == ["1"]
    assert [orbit.name for orbit in search.further(new)] == ["1", "3"]
    given_up = 0
    for slip in slips(np.random.default_rng(3), contact, 30, 1.0):
        work = reached(contact, PULL, f, load_factor, slip)
        orbit = search.follow("random", slip, 0.8 * one.work)
        assert (
            work < 0.8 * one.work * 1.02
            if orbit.state is None
            else orbit.work == pytest.approx(work, rel=1e-9)
        )
        given_up += orbit.state is None
    assert 3 < given_up < 27


def test_orbits_with_open_nodes_are_counted_and_searched_from(paper_punch):
    _, span = found(paper_punch(16), PULLED, 0.5, 0.95)
    assert span.most_state.open.any()
    table = span.to_frame()
    assert (table["open"] > 0).any() and table["dissipation"].max() == span.most


def test_bounded_starts_stay_within_their_bound_and_find_less(paper_punch):
    contact = paper_punch(16)
    works = []
    for bound in (0.02, 0.5, None):
        load_factor, span = found(contact, PULL, 0.7, 0.9, slip_bound=bound)
        works.append(span.most)
        if bound is not None:
            assert max(np.abs(span.worst_start).max(), np.abs(span.least_start).max()) <= bound * (
                1 + 1e-9
            )
            starts = np.random.default_rng(2).uniform(-bound, bound, (30, 17))
            assert not len(outside(contact, PULL, 0.7, load_factor, span, starts)[0])
    assert works == sorted(works) and works[0] < works[-1]
    _, above = found(contact, PULL, 0.7, 1.2, slip_bound=0.02)
    assert above.least > found(contact, PULL, 0.7, 1.2)[1].least
    assert np.abs(above.least_start).max() <= 0.02 * (1 + 1e-9)


def test_at_rest_from_every_start():
    span = fo.dissipation_range(system(*FIRST_PAIR), CYCLE, 0.6, 0.1)
    assert span.least == span.most == 0.0 and span.levels == (0.0,)


def test_no_transient_with_a_result_is_an_error():
    free = fo.ContactSystem.from_blocks(
        [[0.0]], [[0.0]], [[1.0]], [0.0], {"mean": ([0.0], [1.0]), "cyclic": ([1.0], [0.0])}
    )
    with pytest.raises(fo.NoContinuation, match="none of"):
        fo.dissipation_range(free, CYCLE, 0.3, 1.0)
