"""Increments of one to three nodes against the enumeration of all statuses."""

import numpy as np
import pytest

import frictopt as fo
from helpers.enumeration import admissible_states, distance, random_increment

SLIDING = {n: np.r_[np.ones(n), np.zeros(n)][:, None] for n in (2, 3)}
LIFTING = {n: np.r_[np.zeros(n), np.ones(n)][:, None] for n in (2, 3)}
FREE = {
    n: np.hstack([SLIDING[n], LIFTING[n], np.r_[np.zeros(n), np.arange(n)][:, None]])
    for n in (2, 3)
}


def cases(seed, count, most_friction, rigid=None, loads=1):
    rng = np.random.default_rng(seed)
    for case in range(count):
        nodes = 1 + case % 3 if rigid is None else 2 + case % 2
        contact, friction, _, _ = random_increment(
            rng, nodes, most_friction, rigid=None if rigid is None else rigid[nodes]
        )
        for _ in range(loads):
            _, _, slip, load = random_increment(rng, nodes, most_friction)
            yield contact, friction, slip, load


def test_exactly_one_state_is_found_below_the_critical_friction():
    """The reference is an enumeration on 120 coupled increments, with gaps, separation and closing."""
    opened = slipped = 0
    for contact, friction, slip, load in cases(0, 30, 0.6, loads=4):
        states = admissible_states(contact, friction, slip, load)
        assert len(states) == 1
        found = fo.increments.NewtonIncrement(contact, friction).solve(slip, load)
        assert distance(states, found) < 1e-9 and found.residual < 1e-9
        opened = opened + (found.gap > 0).any()
        slipped = slipped + (np.abs(found.status) == 1).any()
    assert opened > 15 and slipped > 30


def test_one_of_several_states_is_found():
    several = one = 0
    for contact, friction, slip, load in cases(3, 60, 8.0):
        states = admissible_states(contact, friction, slip, load)
        found = fo.increments.NewtonIncrement(contact, friction).solve(slip, load)
        assert distance(states, found) < 1e-9
        several, one = several + (len(states) > 1), one + (len(states) == 1)
    assert several >= 3 and one >= 30


@pytest.mark.parametrize(("rigid", "count"), [(LIFTING, 40), (FREE, 40)], ids=["lifting", "free"])
def test_bodies_that_only_their_load_holds(rigid, count):
    """Where there is a state, it is found; where there is none, none is found."""
    found = none = 0
    for contact, friction, slip, load in cases(4, count, 1.0, rigid):
        states = admissible_states(contact, friction, slip, load)
        try:
            state = fo.increments.NewtonIncrement(contact, friction).solve(slip, load)
        except (fo.NoContinuation, fo.SolverError):
            assert len(states) == 0
            none += 1
        else:
            assert distance(states, state) < 1e-9
            found += 1
    assert found > 7 and none > 1
