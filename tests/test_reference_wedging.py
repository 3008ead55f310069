"""Wedging, at a node on a tilted bar and others, by all 4^N states of an increment."""

import numpy as np
import pytest

import frictopt as fo
from enumeration import admissible_states


def states_of(A, B, C, friction, q, p, slip):
    """Of one node: (number of states, 4) slips, gaps and forces."""
    contact = fo.ContactSystem.from_blocks([[A]], [[B]], [[C]], [0.0], {"load": ([q], [p])})
    return admissible_states(contact, friction, np.array([slip]), ([q], [p]))[:, :, 0]


def test_without_load_a_node_stays_where_it_slipped_from_the_critical_friction_on():
    for angle, v in [(np.pi / 3, 0.4), (2.0, -0.4)]:
        A, B, C = np.cos(angle) ** 2, np.sin(angle) * np.cos(angle), np.sin(angle) ** 2  # a bar of unit stiffness
        wedged, *others = (states_of(A, B, C, f * A / abs(B), 0.0, 0.0, v)[:, 0] for f in (1.001, 0.999, 0.3))
        assert v in wedged and not any(v in slips for slips in others)
    assert 1.0 in states_of(1.0, 0.5, 1.0, 3.0, 0.0, 0.0, 1.0)[:, 0]


@pytest.mark.parametrize(("f", "towards", "away"), [(1.9, 1, 1), (2.1, 0, 2), (3.0, 0, 2)])
def test_on_the_bound_that_presses_a_node_beyond_critical_friction_has_no_or_two_continuations(f, towards, away):
    v, p, step = 1.0, 2.0, 1e-4
    at_bound = f * p  # q = f p, about to slip backward
    for sign, expected in [(-1, towards), (1, away)]:
        q_bonded, p_bonded = at_bound - 1.0 * v, p - 0.5 * v
        after = states_of(1.0, 0.5, 1.0, f, q_bonded - sign * step, p_bonded, v)  # f dp^w - dq^w = sign * step
        assert (np.abs(after[:, :2] - [v, 0.0]).max(axis=1) < 100 * step).sum() == expected
