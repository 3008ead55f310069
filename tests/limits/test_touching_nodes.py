"""The nodes that the search of open nodes tries.

These nodes touch, are pressed, or are opened by the mean load. The search is compared with every
set of open nodes, by linear programs of scipy.
"""

from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits.search import likely_sets
from helpers.cases import few
from helpers.separation import fuzzed, rests
from helpers.systems import all_closed, among_others
from studies.validation.open_sets import largest_with_open

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial"


# Random contacts whose best set the search missed while it opened nodes without pressure alone.
PRESSED = [13, 34, 42, 87, 88, 95, 106, 120, 127, 149, 169]
# Random contacts whose best set is next to one that the mean load opens, though some slip would
# keep all nodes closed.
SETTLED = [15, 41, 84, 101]


def better_set(contact, cycle, friction, limit):
    """The load factor of a set that is safe just below a limit and reaches furthest above it.

    The value is the limit itself if no set reaches further.
    """
    best = limit.load_factor
    for number in range(2**contact.nodes - 1):
        opened = np.array([number >> node & 1 for node in range(contact.nodes)], dtype=bool)
        every = np.tile(opened, (len(cycle.corners), 1))
        claim = largest_with_open(contact, cycle, friction, every, 3 * limit.load_factor)
        if claim is not None and claim[0] > best * (1 + 1e-5):
            set_limit = fo.shakedown_limit(contact, cycle, friction, open_nodes=opened)
            if set_limit.least <= limit.load_factor:
                best = claim[0]
    return best


@pytest.mark.parametrize("seed", few(PRESSED, 3))
def test_pressed_nodes_of_a_small_contact_are_opened(seed):
    contact, cycle, friction = fuzzed(seed)
    limit = fo.shakedown_limit(contact, cycle, friction)
    assert limit.residual < 1e-9
    assert better_set(contact, cycle, friction, limit) == limit.load_factor
    # In a contact of some more nodes the search near the closed nodes finds them, too.
    larger, of_all = among_others(contact, friction, 16)
    searched = fo.shakedown_limit(larger, cycle, of_all)
    assert not searched.best_of_all
    assert searched.load_factor == pytest.approx(limit.load_factor, rel=1e-7)


def test_pressed_nodes_are_opened_where_nodes_have_gaps():
    contact, cycle, friction = fuzzed(13)
    gap = 1e-3 * contact.bonded["mean"][1].mean() / contact.stiffness_scale
    with_gap = contact.with_gap(np.eye(contact.nodes)[0] * gap)
    best = fo.shakedown_limit(contact, cycle, friction).load_factor
    closed, opened = (
        fo.shakedown_limit(larger, cycle, of_all).load_factor
        for larger, of_all in (among_others(one, friction, 17) for one in (contact, with_gap))
    )
    assert closed < 0.9 * best
    assert opened == pytest.approx(best, rel=1e-2)


@pytest.mark.parametrize("seed", few(SETTLED, 2))
def test_the_set_of_the_mean_load_is_tried_though_a_slip_keeps_all_nodes_closed(seed):
    contact, cycle, friction = fuzzed(seed)
    contact, friction = among_others(contact, friction, 15)
    settled = fo.march(contact, cycle, friction, 0.0, cycles=1).status[-1] == 2
    closed = all_closed(contact, cycle, friction)
    assert settled.any() and closed.least == 0.0
    limit = fo.shakedown_limit(contact, cycle, friction)
    assert limit.open.any() and limit.load_factor > 1.4 * closed.load_factor
    assert rests(contact, cycle, friction, 0.999 * limit.load_factor, initial_state=limit.state)


@pytest.mark.parametrize("elements", [24, 60])
def test_a_closed_contact_of_more_nodes_asks_one_program(elements):
    contact = fo.scenes.PunchOnHalfPlane(elements=elements).condense()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    limit = fo.shakedown_limit(contact, cycle, 0.6)
    assert not limit.open.any() and len(limit.record.attempts) == 1


def test_a_quarter_of_a_flange_whose_touching_node_hardly_moves(monkeypatch):
    """Node 6 is open and touches. It has half a percent of the largest motion, because the motion
    of an open node is in the unit of its gap."""
    steel = dict.fromkeys(("upper", "lower", "bolt"), fo.fem.Material(E=210e3, nu=0.3))
    bodies = fo.fem.split_bodies(fo.readers.read_mesh(TUTORIAL / "flange.msh"), steel)
    contacts = [
        fo.fem.Contact("upper", "lower", "lower", "upper", name="flange"),
        fo.fem.Contact("bolt", "upper", "upper", "bolt", name="head"),
        fo.fem.Contact("bolt", "lower", "lower", "bolt", name="nut"),
    ]
    supports = [fo.fem.Support("lower", "bottom")]
    supports += [fo.fem.Cyclic(body, "low", "high") for body in ("upper", "lower")]
    turn = fo.fem.Traction("upper", "top", x=lambda x, y, z: -y / 33, y=lambda x, y, z: x / 33)
    loads = {"bolt": [fo.fem.BoltPreload("bolt", "section", 25e3)], "twist": [turn]}
    quarter = fo.fem.ContactModel(bodies, supports, loads, contacts).condense()
    cycle = fo.LoadCycle({"bolt": 1.0}, [{"twist": 1.0}, {"twist": -1.0}])
    limit = fo.shakedown_limit(quarter, cycle, 0.15)
    steady = fo.steady_state(
        quarter, cycle, 0.15, 0.99 * limit.load_factor, initial_state=limit.state, most_cycles=200
    )
    assert steady.outcome is fo.Outcome.SHAKEDOWN
    monkeypatch.setattr(likely_sets, "GOVERNS_TOUCHING", likely_sets._GOVERNS)
    few_nodes = fo.shakedown_limit(quarter, cycle, 0.15)
    assert few_nodes.load_factor < 0.96 * limit.load_factor
