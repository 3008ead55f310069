"""Limits of uncoupled contacts whose areas open and close, against limits of closed contacts."""

import numpy as np
import pytest

import frictopt as fo
from studies.validation.moving_events import FRICTION, PRESS, ROLLS, cylinder

CELLS = 160


def limit(system, cycle, **options):
    return fo.shakedown_limit(system, cycle, FRICTION, progress=False, **options)


def pad():
    """A flat contact of `CELLS` nodes, with a load case that tilts it."""
    arrays = fo.reference.half_plane_contact(CELLS, 1.0, 1.0)
    system = fo.ContactSystem.from_blocks(**arrays)
    rolls = system.B.T @ system.x, system.C @ system.x
    return system.with_bonded({**system.bonded, "roll": rolls})


def test_a_rolling_cylinder_against_a_pad_that_stays_closed(compare):
    rolls = cylinder(CELLS, 1.8)
    closed = pad()
    tilts = fo.LoadCycle({"P": PRESS}, [{"Q": PRESS}] * 2, fixed=[{"roll": -0.05}, {"roll": 0.05}])
    assert len(limit(rolls, ROLLS).events) and not len(limit(closed, tilts).events)
    assert compare(lambda: limit(rolls, ROLLS), lambda: limit(closed, tilts), rounds=9) < 3.0


@pytest.mark.parametrize("scaled", [0.0, 0.1])
def test_a_closed_contact_pays_nothing_for_nodes_that_may_open(compare, scaled):
    """`open_nodes` without a node fixes the set: neither open nodes nor events are searched."""
    closed = pad()
    corner = {"Q": 0.4 * PRESS, "P": scaled * PRESS}
    cycle = fo.LoadCycle({"P": PRESS}, [corner, {case: -load for case, load in corner.items()}])
    none_open = np.zeros(closed.nodes, dtype=bool)
    assert (
        compare(
            lambda: limit(closed, cycle),
            lambda: limit(closed, cycle, open_nodes=none_open),
            rounds=15,
        )
        < 1.1
    )
