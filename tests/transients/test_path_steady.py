import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.paths import followed
from helpers.systems import CYCLE, ONE_NODE, THREE, random_system, system
from studies.validation.closed_forms import single_node_dissipation


def limit_of(contact, friction):
    return fo.shakedown_limit(contact, CYCLE, friction).load_factor


@pytest.mark.parametrize(
    ("data", "friction", "factor", "expected"),
    [
        (ONE_NODE, 0.4, 1.2, 0.061945108310),
        (ONE_NODE, 0.4, 1.5, 0.154843877083),
        ((1.0, 0.0, 0.0, 1.0, 1.0, 0.0), 0.5, 1.2, 0.2),
        ((1.0, 0.0, 0.0, 1.0, 1.0, 0.0), 0.5, 1.5, 0.5),
        ((*THREE, np.eye(3)), 0.4, 1.02, 0.006399175523),
    ],
)
def test_published_dissipation(data, friction, factor, expected):
    contact = system(*data)
    for start in (None, 0.3 * np.ones(contact.nodes), np.linspace(-2, 1, contact.nodes)):
        steady = fo.steady_state(
            contact, CYCLE, friction, factor * limit_of(contact, friction), initial_slip=start
        )
        assert steady.outcome is fo.Outcome.CYCLIC_SLIP
        assert steady.dissipation == pytest.approx(expected, rel=1e-9, abs=5e-13)
        assert steady.dissipation_per_node.sum() == pytest.approx(steady.dissipation, rel=1e-14)


@pytest.mark.parametrize("friction", [0.3, 0.7])
def test_from_the_safe_slip_nothing_dissipates_below_the_limit_and_everything_above(
    punch, paper_cycle, friction
):
    contact = punch(40)
    limit = fo.shakedown_limit(contact, paper_cycle, friction).load_factor
    safe = fo.safe_slip(contact, paper_cycle, friction, 0.999 * limit).slip
    steady = fo.steady_state(contact, paper_cycle, friction, 0.999 * limit, initial_slip=safe)
    assert steady.outcome is fo.Outcome.SHAKEDOWN
    assert steady.dissipation == 0.0
    assert steady.first_cycle == 0.0
    assert np.array_equal(steady.slip, safe)
    rng = np.random.default_rng(0)
    for start in (None, safe, *rng.normal(size=(5, 41))):
        assert (
            fo.steady_state(
                contact, paper_cycle, friction, 1.001 * limit, initial_slip=start
            ).dissipation
            > 1e-9
        )


@pytest.mark.parametrize("seed", few(range(5)))
def test_an_overload_is_one_cycle_at_another_load_factor_before_the_others(seed):
    contact = random_system(np.random.default_rng(seed), 3)
    start = np.random.default_rng(seed).normal(size=3)
    factor = 0.8 * limit_of(contact, 0.5)
    path = followed(contact, CYCLE, 0.5, 2.5 * factor, start, cycles=1)
    corners = followed(contact, CYCLE, 0.5, factor).corners
    work = []
    for _ in range(60):
        before = path.state.work.sum()
        for corner in corners:
            path.follow_to(corner, "")
        work.append(path.state.work.sum() - before)
    steady = fo.steady_state(contact, CYCLE, 0.5, factor, initial_slip=start, overload=2.5 * factor)
    assert steady.first_cycle == pytest.approx(work[0], abs=1e-12)
    assert steady.dissipation == pytest.approx(work[-1], abs=1e-9)
    assert np.abs(steady.slip - path.state.u[:3]).max() < 1e-8


def test_nodes_that_lift_off_in_the_steady_cycle_are_told():
    """A node that is pressed by 1 at rest and pulled by 2 at the second corner opens there; its
    stuck neighbour does not open."""
    contact = system(np.eye(2), np.zeros((2, 2)), 0, (1, 1), 0, (2, 0), C=np.eye(2))
    steady = fo.steady_state(contact, CYCLE, 0.5, 1.0)
    assert steady.open.tolist() == [True, False]
    assert not fo.steady_state(contact, CYCLE, 0.5, 0.4).open.any()


def test_slip_too_small_to_tell_is_said():
    """The answer says where slip is too small to be distinguished from rest.

    Less than a part in 1e9 above the limit the cycle comes back, but its work is below the
    tolerance.
    """
    contact = system(*ONE_NODE)
    limit = fo.shakedown_limit(contact, CYCLE, 0.4)
    with pytest.raises(
        fo.NoContinuation,
        match=r"too small .* to distinguish slip from shakedown: choose a load factor further from the limit",
    ):
        fo.steady_state(
            contact,
            CYCLE,
            0.4,
            limit.load_factor * (1 + 4e-10),
            initial_slip=limit.slip,
            most_cycles=8,
        )


def test_little_friction_still_dissipates():
    """Down to 1e-12 of force times slip scale the work of slip agrees with the closed form."""
    contact = system(2.0, 0.5, 0.0, 1.0, 1.0, 0.2)
    for friction, distance in ((1e-3, 1e-6), (1e-3, 1e-2), (1e-5, 1e-4)):
        factor = fo.shakedown_limit(contact, CYCLE, friction).load_factor * (1 + distance)
        steady = fo.steady_state(contact, CYCLE, friction, factor)
        work = single_node_dissipation(2.0, 0.5, 0.0, 1.0, 1.0, 0.2, friction, factor)
        assert steady.outcome is fo.Outcome.CYCLIC_SLIP
        assert steady.dissipation == pytest.approx(work, rel=1e-8)


@pytest.mark.parametrize("run", [fo.steady_state, fo.march])
def test_a_mean_load_that_pulls_or_pushes_the_body_off_is_named(punch, run):
    cases = [
        ({"P": -1.0}, r"sum to -.*compression must be positive"),
        ({"P": 1.0, "Q": 0.9}, r"slides as a whole: .*shear force"),
    ]
    for mean, words in cases:
        with pytest.raises(fo.NoContinuation, match=words):
            run(punch(16), fo.LoadCycle(mean, [{"sigma": -1.0}, {"sigma": 1.0}]), 0.5, 0.1)


def test_a_start_whose_rounding_hides_the_loads_is_named(punch, paper_cycle):
    """A random slip of ten million slip scales leaves a rigid slide of its size. The forces are in
    the last digits of this slide."""
    contact = punch(16)
    far = 1e7 * np.random.default_rng(0).standard_normal(contact.nodes)
    for run, options in ((fo.march, {"cycles": 3}), (fo.steady_state, {"most_cycles": 50})):
        with pytest.raises(
            (fo.SolverError, fo.NoContinuation),
            match=r"initial_slip: it stresses the contact [0-9.]+e\+07 times",
        ):
            run(contact, paper_cycle, 0.3, 0.2, initial_slip=far, **options)
