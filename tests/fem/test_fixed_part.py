"""Load cycles with a fixed part.

They are compared with programs of all corners, transients, and other forms of the same loads.
"""

import pickle
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.corners import left_out
from helpers.guaranteed import check
from helpers.oracle import Oracle
from helpers.separation import pulled_system
from helpers.spatial import random_contact, vectors
from helpers.systems import (
    all_closed,
    corner_rows,
    fixed_contact,
    linprog_limit,
    linprog_margin,
    unit_nodes,
)
from studies.validation.verify import verify

seeds = st.integers(0, 10**6)


def in_space(seed):
    """A coupled contact, its friction, and a cycle whose corners differ at load factor 0."""
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(1, 6))
    contact = random_contact(rng, nodes, coupling=rng.choice([0.0, 0.5]))
    contact = fo.ContactSystem(
        contact.S,
        contact.points,
        vectors(contact) | {name: 0.3 * rng.normal(size=3 * nodes) for name in "de"},
    )
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"a": 1.0}, {"a": -1.0}, {"b": 0.7}], [{"d": 0.6}, {}, {"e": -0.5}]
    )
    return contact, cycle, rng.uniform(0.3, 0.8, size=nodes)


@pytest.mark.parametrize("make", [fixed_contact, in_space])
@settings(max_examples=few(10))
@given(seed=seeds)
def test_both_ends_of_the_safe_load_factors_are_those_of_a_program_with_all_corners(make, seed):
    contact, cycle, f = make(seed)
    limit = fo.shakedown_limit(contact, cycle, f)
    oracle = Oracle(contact, cycle, f)
    rel = 1e-8 if make is fixed_contact else 1e-6
    assume(not limit.open.any())
    most = oracle.largest()
    if np.isnan(most):
        assert np.isnan(limit.load_factor) and "the mean load with fixed[" in limit.reason
    else:
        assert limit.load_factor == pytest.approx(most, rel=rel)
        assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8)
        assert limit.least == pytest.approx(oracle.least(), rel=10 * rel, abs=rel)
        assert limit.residual <= 1e-9
        assert (
            np.isinf(most)
            or fo.safe_slip(contact, cycle, f, 0.5 * (limit.least + limit.load_factor)).exists
        )


@settings(max_examples=few(10))
@given(seeds, st.floats(0.0, 1.4))
def test_the_margin_is_that_of_a_program_with_all_corners(seed, share):
    contact, cycle, f = fixed_contact(seed)
    limit = fo.shakedown_limit(contact, cycle, f).load_factor
    factor = share * limit if np.isfinite(limit) else share
    assume(np.mean([(f * contact.reaction(loads)[1]).mean() for loads in cycle.unscaled]) > 0.05)
    safe = fo.safe_slip(contact, cycle, f, factor)
    # The nodes of an uncoupled contact may open and close, of which the program knows nothing.
    pressed = all(contact.reaction(loads)[1].min() >= 0 for loads in cycle.at(factor))
    assume(not safe.open.any() and (contact.B.any() or pressed))
    assert safe.margin == pytest.approx(
        linprog_margin(contact, cycle, f, factor), rel=1e-7, abs=1e-8
    )


@settings(max_examples=few(8))
@given(seeds)
def test_transients_rest_on_a_safe_slip_below_the_limit_and_slip_for_ever_above(seed):
    contact, cycle, f = fixed_contact(seed)
    limit = fo.shakedown_limit(contact, cycle, f)
    assume(1e-3 < limit.load_factor < np.inf and not limit.open.any())
    below, above = limit.least + 0.98 * (limit.load_factor - limit.least), 1.02 * limit.load_factor
    state = fo.safe_slip(contact, cycle, f, below).state
    assert (
        fo.steady_state(contact, cycle, f, below, initial_state=state).outcome
        is fo.Outcome.SHAKEDOWN
    )
    steady = fo.steady_state(contact, cycle, f, above, initial_slip=limit.slip)
    assert steady.outcome is not fo.Outcome.SHAKEDOWN or steady.open.any()
    path = fo.march(contact, cycle, f, above, initial_slip=limit.slip, cycles=1)
    loads = contact.reaction(cycle.at(above)[-1])
    names = list(contact.bonded)
    assert path.amplitudes[-1] == pytest.approx(
        [cycle.at(above)[-1].get(name, 0.0) for name in names]
    )
    assert path.amplitudes @ [contact.bonded[name][1] for name in names] == pytest.approx(
        path.bonded_p
    )
    assert path.bonded_q[-1] == pytest.approx(loads[0])
    assert path.bonded_p[-1] == pytest.approx(loads[1])


@settings(max_examples=few(6))
@given(seeds)
def test_the_guaranteed_limit_is_the_least_of_programs_with_a_node_on_both_bounds_at_any_two_corners(
    seed,
):
    contact, cycle, f = fixed_contact(seed, most_nodes=4)
    assume(contact.B.any())
    limit = fo.shakedown_limit(contact, cycle, f)
    assume(1e-3 < limit.load_factor < np.inf and not limit.open.any())
    least = limit.load_factor
    (left, right) = corner_rows(contact, cycle, f)
    for node, (k, other) in product(
        range(contact.nodes), permutations(range(len(cycle.corners)), 2)
    ):
        equal = [
            (*np.split(left[bound, at, node], [-1]), right[bound, at, node])
            for bound, at in ((0, k), (1, other))
        ]
        least = np.fmin(least, linprog_limit(contact, cycle, f, equal=equal, least=True)[1])
    guaranteed = fo.guaranteed_limit(contact, cycle, f)
    assert guaranteed.load_factor == pytest.approx(least, rel=1e-6)
    check(guaranteed)
    every = fo.guaranteed_limit(contact, cycle, f, simplify=False)
    # The limit is the least of all pairs of corners of the node.
    if every.node is not None:
        of_nodes = every.to_frame()["load_factor"].min()
        assert of_nodes == pytest.approx(every.load_factor, rel=1e-12)
    if guaranteed.node is not None and guaranteed.load_factor > guaranteed.least:
        assert verify(guaranteed, starts=0, moved=1).persists


@settings(max_examples=few(3))
@given(seeds)
def test_open_nodes_stay_open_at_every_corner(seed):
    rng = np.random.default_rng(seed)
    contact = pulled_system(rng, int(rng.integers(2, 6)))
    friction = float(rng.uniform(0.2, 1.0))
    n = contact.nodes
    contact = contact.with_bonded({"f": (0.2 * rng.normal(size=n), 0.1 * rng.normal(size=n))})
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"cyclic": -1.0}, {"cyclic": 1.0}, {}], [{"f": 1.0}, {}, {"f": -1.0}]
    )
    limit = fo.shakedown_limit(contact, cycle, friction)
    assume(limit.open.any() and 1e-3 < limit.load_factor < np.inf)
    assert limit.load_factor == pytest.approx(
        Oracle(contact, cycle, friction, limit.open).largest(), rel=1e-6
    )
    below = limit.least + 0.98 * (limit.load_factor - limit.least)
    state = fo.safe_slip(contact, cycle, friction, below).state
    assert (
        fo.steady_state(contact, cycle, friction, below, initial_state=state).outcome
        is fo.Outcome.SHAKEDOWN
    )


def test_a_study_has_other_keys_with_another_fixed_part(tmp_path):
    contact, cycle, f = fixed_contact(5)
    plain = fo.LoadCycle(cycle.mean, cycle.corners)
    store = tmp_path / "runs.sqlite"
    for one, told in (
        (plain, nullcontext()),
        (cycle, pytest.warns(fo.results.OtherRows, match="other contacts or load cycles")),
    ):
        with told, ThreadPoolExecutor(1) as executor:
            table = fo.dissipation_study(
                contact, one, [f], [0.1, 0.2], store=store, executor=executor, progress=False
            )
        alone = [fo.steady_state(contact, one, f, factor).dissipation for factor in (0.1, 0.2)]
        assert table["dissipation"].tolist() == pytest.approx(alone)
    assert len(fo.results.read_store(store)) == 4


def test_the_loads_of_corners_and_what_is_said_of_a_cycle():
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}, {"P": 0.5}], fixed=[{"P": -0.5}, {"R": 1.0}])
    assert cycle.at(0.5) == ({"P": 0.5, "Q": 1.0}, {"P": 1.25, "R": 1.0})
    assert repr(cycle).endswith(
        "corners=[{'Q': 2.0}, {'P': 0.5}], fixed=[{'P': -0.5}, {'R': 1.0}])"
    )
    assert pickle.loads(pickle.dumps(cycle)) == cycle
    assert hash(cycle) != hash(fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}, {"P": 0.5}]))
    assert fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}], [{}]) == fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}])


def test_bad_fixed_parts_are_refused():
    messages = {
        ": 1 load for 2 corners": [{}],
        ": a dict": {"P": 1.0},
        r"\[0\]\['P'\]: nan": [{"P": np.nan}, {}],
        r"\[0\]: a float": [1.0, 2.0],
    }
    for message, fixed in messages.items():
        with pytest.raises(fo.ModelError, match="^fixed" + message):
            fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}], fixed)


def test_corners_at_which_the_load_turns_depend_on_the_load_factor():
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 0.0}, {"Q": 1.0}], [{}, {"Q": 2.0}, {}])
    assert (left_out(cycle, 1.0), left_out(cycle, 3.0)) == (0, 1)


def test_load_factor_zero_is_no_odd_value_where_a_part_is_fixed(recwarn):
    contact, cycle, f = fixed_contact(5)
    fo.steady_state(contact, cycle, f, 0.0)
    assert not recwarn.list
    with pytest.warns(fo.ModelWarning, match="load_factor: 0"):
        fo.steady_state(contact, fo.LoadCycle(cycle.mean, cycle.corners), f, 0.0)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_transient_in_space_rests_on_a_safe_slip(seed):
    contact, cycle, f = in_space(seed)
    limit = fo.shakedown_limit(contact, cycle, f)
    below = limit.least + 0.98 * (limit.load_factor - limit.least)
    state = fo.safe_slip(contact, cycle, f, below).state
    assert (
        fo.steady_state(contact, cycle, f, below, initial_state=state, steps=4).outcome
        is fo.Outcome.SHAKEDOWN
    )


def test_a_node_in_space_that_nothing_presses_at_some_corners():
    """Node 0 has no friction at a corner that leaves it without pressure, so that it carries no
    shear there. It then carries only the load factor 2, or only the load factors of the other node.
    """
    S = np.eye(6)
    loads = {
        "P": [0, 0, 0, 0, 0, 1.0],
        "X": [1.0, 0.2, 0, 0, 0, 0],
        "Q": [2.0, 0, 0, 0, 0, 0],
        "N": [0, 0, 0, 0, 1.0, 0],
    }
    pair = fo.ContactSystem(S, [[0.0, 0, 0], [1.0, 0, 0]], loads)
    free = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": 1.0}, {"X": -1.0}], [{}, {}, {"N": 9.0}])
    # 2 q1 <= 0.5 * 9 at node 0, 2 * 0.2 q1 <= 2 * 0.5 at node 1.
    assert fo.shakedown_limit(pair, free, 0.5).load_factor == pytest.approx(2.25)
    meets = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {}], [{}, {"Q": 1.0}])
    limit = all_closed(pair, meets, 0.5)  # node 0 closed
    assert (limit.load_factor, limit.least) == pytest.approx((2.0, 2.0), rel=1e-6)
    assert fo.shakedown_limit(pair, meets, 0.5).load_factor == pytest.approx(5.0)
    parted = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}], [{}, {"N": 0.0, "P": 0.5}])
    closed = all_closed(pair, parted, 0.5)
    assert closed.load_factor == 0.0
    # Node 0 stays open, and 0.2 |q1| <= 0.5 * 1.25 at node 1.
    assert fo.shakedown_limit(pair, parted, 0.5).load_factor == pytest.approx(3.125)


def test_a_corner_in_space_whose_fixed_part_alone_is_outside_of_the_hull_of_the_others_counts():
    """Friction bounds of 1.5 hold a shear of 2 only with a slip of -0.5 or less, and then hold the
    cyclic shear only up to 1."""
    node = fo.ContactSystem(
        np.eye(3), [[0.0, 0.0, 0.0]], {"P": [0.0, 0.0, 3.0], "X": [1.0, 0.0, 0.0]}
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}, {}], [{}, {}, {"X": 2.0}])
    assert fo.shakedown_limit(node, cycle, 0.5).load_factor == pytest.approx(1.0)


def test_a_corner_between_others_counts_with_its_own_fixed_part():
    """One node of stiffness 1 and friction 0.5 under a pressure of 1.

    Its slip has to be -0.4 or less, because 0.9 of shear may leave at most 0.5 at the corner
    between the others. So 0.1 is left for the cyclic shear.
    """
    node = unit_nodes({"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    cycle = fo.LoadCycle(
        {"P": 1.0}, [{"Q": -1.0}, {"Q": 0.0}, {"Q": 1.0}], fixed=[{}, {"Q": 0.9}, {}]
    )
    limit = fo.shakedown_limit(node, cycle, 0.5)
    assert limit.load_factor == pytest.approx(0.1)
    assert not limit.record.left_out
