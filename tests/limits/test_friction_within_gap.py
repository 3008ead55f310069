"""Required frictions between two proven numbers: the exact ones lie between them."""

import warnings

import numpy as np
import pytest

import frictopt as fo
from helpers import spatial
from helpers.cases import few
from helpers.refused import refused
from helpers.systems import (
    CYCLE,
    NODE,
    at_corners,
    has_safe_slip,
    lifts,
    random_system,
    stress_of,
    system,
)
from studies import half_space

THREE = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}, {"a": -0.5, "b": 0.3}])
BULK = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
GAP = 0.01


def within(contact, cycle, load_factor, **options):
    """The friction within a gap, which is not wider than asked."""
    answer = fo.required_friction(contact, cycle, load_factor, gap=GAP, **options)
    assert answer.residual <= 1e-9 and not answer.open.any()
    assert (1 - GAP) * answer.required <= answer.bound < answer.required
    return answer


def encloses(answer, exact):
    assert not exact.open.any() and exact.events.empty
    least, most = exact.bound * (1 - 1e-8), exact.required * (1 + 1e-8)
    return answer.bound <= most and answer.required >= least


@pytest.mark.parametrize("seed", range(few(12, least=6)))
def test_both_frictions_are_proven_by_hand_in_the_plane(seed):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, int(rng.integers(2, 12)), loads=("mean", "a", "b"))
    load_factor = rng.uniform(0.05, 1.0)
    answer = within(contact, THREE, load_factor)
    assert has_safe_slip(contact, THREE, answer.required, load_factor)
    assert not has_safe_slip(contact, THREE, answer.bound, load_factor)
    q, p = at_corners(contact, THREE, load_factor, answer.slip)
    assert (np.abs(q) - answer.required * p).max() < 1e-9
    # No residual slip resists the mechanism, and the loads do more work than friction can.
    table, less = answer.mechanism, answer.bound
    assert np.abs(stress_of(contact, table, less)).max() < 1e-7 * np.abs(contact.A).max()
    (q0, p0), (q1, p1) = contact.reaction({"mean": 1.0}), THREE.corner_reactions(contact)
    at = table.corner, table.node
    shear, pressure = (q0 + load_factor * q1)[at], (p0 + load_factor * p1)[at]
    slips, lift = table.direction * table.share, lifts(table, less) * table.share
    assert (slips * shear + lift * pressure).sum() < 0


@pytest.mark.parametrize("seed", range(few(12, least=6)))
def test_the_exact_friction_in_space_lies_between_both(seed):
    rng = np.random.default_rng(seed)
    contact = spatial.random_contact(rng, int(rng.integers(2, 10)))
    load_factor = rng.uniform(0.05, 1.0)
    exact = fo.required_friction(contact, spatial.cycle(), load_factor)
    assert encloses(within(contact, spatial.cycle(), load_factor), exact)


def of_half_space():
    """The contact of a punch on a half-space by products, and with its stiffness."""
    products = half_space.punch_on_half_space(5)
    units = np.eye(2 * products.nodes)
    pressing = np.column_stack([products.pressing @ unit for unit in units])
    compliance = np.column_stack([products.slipping @ unit for unit in units])
    A = np.linalg.inv((compliance + compliance.T) / 2)
    B = pressing @ A
    C = pressing @ B.T + np.eye(products.nodes)
    S = np.block([[A, B.T], [B, C]])
    contact = fo.ContactSystem((S + S.T) / 2, products.points, products.bonded)
    return products, contact, half_space.CYCLE


def of_punch():
    model = fo.scenes.SquarePunch(elements=4).model()
    return model.products(), model.condense(), BULK


@pytest.mark.parametrize("contacts", [of_half_space, of_punch])
def test_products_are_enough(contacts):
    products, contact, cycle = contacts()
    load_factor = 0.9 * fo.shakedown_limit(contact, cycle, 0.4).load_factor
    exact = fo.required_friction(contact, cycle, load_factor)
    answer = within(products, cycle, load_factor)
    assert encloses(answer, exact) and len(answer.mechanism)
    assert contact.nodes == len(answer.slip)
    q, p = at_corners(contact, cycle, load_factor, answer.slip)
    assert (np.linalg.norm(q, axis=-1) - answer.required * p).max() < 1e-9 * p.max()


def test_more_load_may_need_less_friction():
    """A node that is pulled by 1 and pressed and sheared by the load needs f (L - 1) >= 0.6 L."""
    cycle = fo.LoadCycle({"P": -1.0}, [{"N": 1.0, "Q": 0.6}, {"N": 1.0, "Q": -0.6}])
    for load_factor, by_hand in ((2.0, 1.2), (5.0, 0.75)):
        answer = within(NODE, cycle, load_factor)
        assert answer.bound <= by_hand <= answer.required * (1 + 1e-9)


def test_no_friction_is_needed_if_the_shear_is_the_same_at_all_corners():
    still = system(np.eye(2), np.zeros((2, 2)), 0.3, 1.0, 0.0, 0.1)
    answer = fo.required_friction(still, CYCLE, 1.0, gap=GAP)
    assert answer.required == 0 and np.isnan(answer.bound) and answer.mechanism.empty
    assert answer.slip == pytest.approx([-0.3, -0.3]) and "none is needed" in answer.reason


def test_an_answer_within_a_gap_is_kept_and_has_no_problem(tmp_path):
    contact = random_system(np.random.default_rng(1), 5)
    answer = within(contact, CYCLE, 0.5)
    assert answer.reason.startswith("the least friction is between")
    answer.save(tmp_path / "friction.npz")
    again = fo.results.load(tmp_path / "friction.npz")
    assert (again.required, again.bound) == (answer.required, answer.bound)
    with pytest.raises(fo.ModelError, match=r"problem: .*gap=None"):
        print(answer.problem)


def test_a_gap_below_the_steps_is_not_reached_and_says_so():
    contact = random_system(np.random.default_rng(1), 5)
    with pytest.warns(fo.ModelWarning, match="required_friction: stopped with a wider gap"):
        answer = fo.required_friction(contact, CYCLE, 0.5, gap=1e-9)
    assert answer.bound < (1 - 1e-9) * answer.required and "stopped" in answer.reason
    assert encloses(answer, fo.required_friction(contact, CYCLE, 0.5))


PULLED = system(np.eye(2), np.zeros((2, 2)), 0.0, (1.0, 1.0), 0.2, (0.0, 3.0))


@refused(
    ({"events": True}, "events: a gap cannot.*gap=None"),
    ({"slip_bound": 1.0}, "slip_bound: a gap cannot.*gap=None"),
    ({"gap": 0.0}, "gap: 0.0; it must be"),
    ({"gap": 1}, "gap: 1.*below 1"),
    ({"load_factor": 1e17}, "load_factor: 1e.17 makes the cyclic loads"),
)
def test_parts_that_it_does_not_know(options):
    fo.required_friction(PULLED, CYCLE, **{"load_factor": 0.2, "gap": GAP} | options)


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (PULLED, "some friction is enough with all nodes closed; pass gap=None"),
        (system([[1.0]], [[0.0]], 0.0, 1.0, 1e-7, 0.0), "1e-06 is enough and 0 is not"),
    ],
    ids=["pulled", "hardly sheared"],
)
def test_without_two_proofs_there_is_no_answer(contact, words):
    with warnings.catch_warnings(), pytest.raises(fo.SolverError, match=words):
        warnings.simplefilter("ignore")
        fo.required_friction(contact, CYCLE, 1.0, gap=GAP)
