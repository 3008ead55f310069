"""Starts of a study in every admissible form, and refused starts.

Wrong starts are refused before anything runs.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from helpers.refused import refused
from helpers.systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(3), 3)
STARTS = fo.starts.no_slip() + fo.starts.overloads([2.0])


def study(starts, contact=CONTACT, cycle=CYCLE, factors=(0.5,)):
    return fo.dissipation_study(contact, cycle, 0.4, factors, starts)


@pytest.mark.parametrize(
    "make",
    [tuple, iter, lambda starts: pd.Series(starts), lambda starts: np.array(starts, dtype=object)],
)
def test_starts_come_in_any_row(make):
    assert study(make(STARTS)).start.tolist() == ["none", "overload to 2"]


@pytest.mark.parametrize("make", [list, pd.DataFrame])
def test_slips_come_in_any_row(make):
    slips = [[0.0, 0.0, 0.0], [1.0, 2.0, 4.0]]
    assert study(make(slips)).amplitude.tolist() == pytest.approx([0.0, np.sqrt(7.0)])
    assert [start.slip.tolist() for start in fo.starts.given_slips(make(slips))] == slips


@refused(
    (lambda: study(fo.starts.no_slip()[0]), "starts: Start"),
    (
        lambda: study([*fo.starts.no_slip(), fo.starts.overloads([2.0])]),
        "a list among starts; .* join lists by",
    ),
    (lambda: study([[0.0, 0.0, 0.0], [0.0]]), r"starts: \[\[0.0, 0.0, 0.0\], \[0.0\]\]"),
    (lambda: study(iter([])), "starts: empty"),
    (lambda: fo.starts.Start("a", "b", seed=2**63), "seed of start 'b': 9223372036854775808"),
    (lambda: fo.starts.random_slips(CONTACT, [1.0], 2**63), "count: 9223372036854775808"),
    (
        lambda: fo.starts.random_slips(random_system(np.random.default_rng(0), 1), [1.0], 1),
        "one node",
    ),
    (lambda: fo.starts.Start("", "name"), "family"),
    (lambda: fo.starts.Start("family", "\ud800"), r"name of a start: '\\ud800'"),
    (lambda: fo.starts.Start("mine", "name", slip=[1.0], safe_multiple=1.0), "give one of them"),
)
def test_what_is_refused(make):
    make()


@pytest.mark.parametrize("ask", [fo.steady_state, fo.march])
def test_a_start_in_place_of_its_slip_is_refused_with_its_name(ask):
    start = fo.starts.random_slips(CONTACT, [0.1], 1)[0]
    with pytest.raises(fo.ModelError, match=r"initial_slip: .*; give its `\.slip`"):
        ask(CONTACT, CYCLE, 0.4, 1.0, initial_slip=start)


def test_a_force_too_small_for_the_scale_of_the_dissipation_does_not_cost_the_table():
    tiny = fo.LoadCycle({"mean": 1e-170}, [{"cyclic": 1e-170}, {"cyclic": -1e-170}])
    table = study(STARTS, replace(CONTACT, E_star=1.0), tiny)
    assert len(table) == 2 and table.dissipation_scaled.isna().all()


def test_safe_starts_are_multiples_of_the_safe_slip_and_above_the_limit_of_the_one_at_it():
    limit = fo.shakedown_limit(CONTACT, CYCLE, 0.4)
    (start,) = fo.starts.safe_slips([-2.0])
    below, above = 0.5 * limit.load_factor, 1.2 * limit.load_factor
    for load_factor, slip in (
        (below, fo.safe_slip(CONTACT, CYCLE, 0.4, below).slip),
        (above, limit.slip),
    ):
        assert start.slip_at(CONTACT, CYCLE, 0.4, load_factor) == pytest.approx(
            -2.0 * slip, rel=1e-9
        )
    assert fo.starts.no_slip()[0].slip_at(CONTACT, CYCLE, 0.4, 1.0) is None


def test_random_slips_have_their_amplitude_no_mean_and_a_seed_each(punch):
    scene = punch(16)
    starts = fo.starts.random_slips(scene, [0.1, 20.0], 4, seed=5)
    assert [start.family for start in starts] == 2 * (4 * ["smooth"] + 4 * ["rough"])
    assert [start.seed for start in starts] == list(range(5, 21))
    for start, amplitude in zip(starts, 8 * [0.1] + 8 * [20.0], strict=True):
        assert np.sqrt(np.mean(start.slip**2)) == pytest.approx(amplitude, rel=1e-12)
        assert abs(start.slip.mean()) < 1e-12 * amplitude
        left = np.polynomial.Chebyshev.fit(scene.x, start.slip, 6)(scene.x) - start.slip
        assert (np.abs(left).max() < 1e-10 * amplitude) == (start.family == "smooth")
    assert len({start.slip.tobytes() for start in starts}) == 16
    again = fo.starts.random_slips(scene, [0.1, 20.0], 4, seed=5)
    assert all((one.slip == other.slip).all() for one, other in zip(starts, again, strict=True))


@pytest.mark.parametrize(("nodes", "count"), [(4, 100_000), (1000, 30_000)])
def test_slips_that_would_fill_the_memory_are_refused(nodes, count):
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=nodes, EA=1.0, h=1.0))
    with pytest.raises(fo.ModelError, match=f"count: {count} for 2 amplitudes are {4 * count} "):
        fo.starts.random_slips(rod, [0.1, 0.2], count)
