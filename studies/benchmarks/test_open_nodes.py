"""The search of open nodes, against the limit of the closed contact.

If a contact lifts off under the mean load, the search solves several programs, here 6 to 19, and
follows one to seven transients. The closed contact has one program. In small contacts all
sets of open nodes are compared.
"""

import time

import numpy as np
import pytest
from answers import space_contact
from threadpoolctl import threadpool_limits

import frictopt as fo


def spent(contact, cycle, opened):
    """Processor time of the first answer with one thread."""
    with threadpool_limits(1):
        start = time.process_time()
        limit = fo.shakedown_limit(contact, cycle, 0.6)
        end = time.process_time()
    assert limit.open.any() == opened and 0 < limit.load_factor < np.inf
    return end - start


def ratio(closed, gap, cycle, rounds, record_property):
    """Ratio of the medians over rounds by turns."""
    lifted = closed.with_gap(gap)
    times = np.median(
        [[spent(lifted, cycle, True), spent(closed, cycle, False)] for _ in range(rounds)], axis=0
    )
    record_property("ratio", times[0] / times[1])
    print(
        f"\n    lifts off {times[0]:.3f} s, closed {times[1]:.3f} s, ratio {times[0] / times[1]:.2f}"
    )
    return times[0] / times[1]


@pytest.mark.parametrize(("steep", "most"), [(2.0, 35.0), (10.0, 15.0)])
def test_the_plane_at_125_nodes(system, cycle, steep, most, record_property):
    assert ratio(system, steep * system.x**4, cycle, 9, record_property) < most


@pytest.mark.parametrize("steep", [4.0])
def test_space_at_400_nodes(cycle, steep, record_property):
    contact = fo.scenes.SquarePunch(elements=19).condense()
    assert (
        ratio(contact, steep * (contact.points[:, :2] ** 4).sum(axis=1), cycle, 3, record_property)
        < 25.0
    )


def test_small_contacts_in_space(record_property):
    """Sums over contacts of 1 to 6 nodes; each time is the least of three."""
    searches = closed = 0.0
    for seed in range(12):
        question = space_contact(seed)
        all_closed = np.zeros(question[0].nodes, dtype=bool)
        searches += least(question)
        closed += least(question, open_nodes=all_closed)
    record_property("ratio", searches / closed)
    print(f"\n    search {searches:.3f} s, closed {closed:.3f} s, ratio {searches / closed:.2f}")
    assert searches / closed < 10.0


def least(question, **options):
    """Least processor time of three limits with one thread."""
    times = []
    with threadpool_limits(1):
        for _ in range(3):
            start = time.process_time()
            fo.shakedown_limit(*question, **options)
            times.append(time.process_time() - start)
    return min(times)
