"""Wedging, at a node on a tilted bar and others, by all 4^N states of an increment."""

import numpy as np
import pytest

import frictopt as fo
from marching import admissible


def test_without_load_a_node_stays_where_it_slipped_from_the_critical_friction_on():
    for angle, v in [(np.pi / 3, 0.4), (2.0, -0.4)]:
        A, B, C = np.cos(angle) ** 2, np.sin(angle) * np.cos(angle), np.sin(angle) ** 2  # a bar of unit stiffness
        critical = A / abs(B)
        wedged, freed, free = (admissible(A, B, C, f * critical, 0, 0, v) for f in (1.001, 0.999, 0.3))
        assert [state.v[0] for state in wedged if state.status == (0,)] == [v]
        assert not [state for state in (*freed, *free) if state.status == (0,)]
    assert [state.v[0] for state in admissible(1, 0.5, 1, 3, 0, 0, 1.0) if state.status == (0,)] == [1.0]


@pytest.mark.parametrize(("f", "towards", "away"), [(1.9, 1, 1), (2.1, 0, 2), (3.0, 0, 2)])
def test_on_the_bound_that_presses_a_node_beyond_critical_friction_has_no_or_two_continuations(f, towards, away):
    v, p, step = 1.0, 2.0, 1e-6
    at_bound = f * p  # q = f p, about to slip backward
    for sign, expected in [(-1, towards), (1, away)]:
        q_bonded, p_bonded = at_bound - 1.0 * v, p - 0.5 * v
        after = admissible(1.0, 0.5, 1.0, f, q_bonded - sign * step, p_bonded, v)  # f dp^w - dq^w = sign * step
        near = [state for state in after if abs(state.v[0] - v) < 100 * step and state.w[0] < 100 * step]
        assert len(near) == expected


def test_below_critical_friction_one_state_of_each_increment_is_admissible_and_the_referee_agrees():
    rng = np.random.default_rng(7)
    seen = set()
    for nodes in (1, 2, 2, 3):
        root = rng.normal(size=(2 * nodes, 2 * nodes))
        S = root @ root.T / (2 * nodes) + np.eye(2 * nodes)
        A, B, C = S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:]
        system, v = fo.ContactSystem.from_blocks(A, B, C, np.arange(nodes), {"any": (np.zeros(nodes), np.ones(nodes))}), np.zeros(nodes)
        for _ in range(40):
            q, p = rng.normal(size=nodes), rng.normal(0.5, 1, size=nodes)
            states = admissible(A, B, C, 0.25, q, p, v)
            assert len(states) == 1
            (state,) = states
            seen |= set(state.status)
            verdict = fo.reference.referee(system, (q, p), 0.25, v=state.v, w=state.w, q=state.q, p=state.p, previous_slip=v, force_scale=1.0)
            assert verdict.residual < 1e-12
            v = state.v
    assert seen == {0, 1, -1, None}
