"""Increments in three dimensions: the referee, the cone programs, the plane, and closed forms of one node."""

import re

import numpy as np
import pytest

import frictopt as fo
from spatial import random_contact


def random_increment(rng, most_friction=1.0):
    nodes = int(rng.integers(1, 13))
    contact = random_contact(rng, nodes, 0.5)
    if rng.uniform() < 0.5:
        contact = contact.with_gap(0.3 * rng.uniform(size=nodes) * (rng.uniform(size=nodes) < 0.4))
    load = contact.reaction({"mean": 1.0, "a": rng.normal(), "b": rng.normal()})
    return contact, rng.uniform(0.05, most_friction, size=nodes), 0.3 * rng.normal(size=(nodes, 2)), load


def test_the_cone_programs_give_the_same_states():
    rng = np.random.default_rng(3)
    compared = 0
    for _ in range(12):
        contact, f, slip, load = random_increment(rng, 0.6)
        one = fo.increments.NewtonIncrement(contact, f).solve(slip, load)
        try:
            other = fo.increments.FrozenBoundIncrement(contact, f).solve(slip, load)
        except fo.SolverError:
            continue  # the sweeps need not settle
        assert np.abs(one.slip - other.slip).max() < 1e-8 and np.abs(one.q - other.q).max() < 1e-8 and other.problem.is_dpp()
        compared += 1
    assert compared >= 10


def test_a_contact_that_nothing_holds_down_has_no_state():
    free = fo.ContactSystem(np.zeros((3, 3)), [[0, 0, 0]], {"P": [0, 0, 1]})
    told = "friction increment: the load lifts body 1 (at 1 of 1 nodes) off"
    for engine in (fo.increments.NewtonIncrement, fo.increments.FrozenBoundIncrement):
        with pytest.raises(fo.NoContinuation, match=re.escape(told)):
            engine(free, 0.5).solve([[0.0, 0.0]], ([[0.0, 0.0]], [-1.0]))


@pytest.mark.parametrize(("angle", "push", "slides"), [(0.0, 1.49, False), (0.0, 1.51, True), (0.7, 4.0, True)])
def test_a_body_that_its_loads_slide_away_is_named_with_what_pushes_and_what_holds(angle, push, slides):
    """Three nodes on a free body that is pressed with P = 3: friction 0.5 holds a shear of 1.5 in any direction."""
    n, chain = 3, np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    free = fo.ContactSystem(np.kron(np.diag([2.0, 1.0, 3.0]), chain), np.eye(3), {"P": np.ones(3 * n)})
    q = push / n * np.tile([np.cos(angle), np.sin(angle)], (n, 1))
    increments = fo.increments.NewtonIncrement(free, 0.5)
    if not slides:
        assert np.abs(increments.solve(np.zeros((n, 2)), (q, np.ones(n))).slip).max() == 0
        return
    along = ", ".join(f"{part + 0.0:g}" for part in np.round([-np.cos(angle), -np.sin(angle), 0.0], 6))
    told = f"body 1 (at 3 of 3 nodes) slides as a whole along ({along}); the load drives it with {push:.4g}, and friction can hold f P = 1.5 at most"
    with pytest.raises(fo.NoContinuation, match=re.escape(told)):
        increments.solve(np.zeros((n, 2)), (q, np.ones(n)))
