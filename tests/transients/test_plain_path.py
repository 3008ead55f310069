"""The compiled path against a path on one page of numpy, `plain_path.py`.

The two share no code.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.plain_path import cycle_work
from helpers.systems import random_system


@pytest.mark.parametrize("elements", [16, 40])
@pytest.mark.parametrize("share", [0.9, 1.3, 2.0])
def test_works_of_the_punch_are_those_of_one_page(punch, paper_cycle, elements, share):
    contact = punch(elements)
    load_factor = share * fo.shakedown_limit(contact, paper_cycle, 0.7).load_factor
    slip = 0.3 * contact.x**3 + 0.1 * np.sin(7 * contact.x)
    work = fo.march(contact, paper_cycle, 0.7, load_factor, initial_slip=slip, cycles=3).cycle_work
    assert (
        np.abs(cycle_work(contact, paper_cycle, 0.7, load_factor, slip, 3) - work).max()
        <= 1e-10 * work.max()
    )


@pytest.mark.parametrize("seed", few(range(30)))
def test_works_of_nodes_that_open_and_close_are_those_of_one_page(seed):
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(1, 9))
    contact = random_system(rng, nodes, loads=("mean", "a", "b")).with_gap(
        0.3 * rng.random(nodes) * (rng.random(nodes) < 0.5)
    )
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(3, 2))]
    )
    friction, slip = rng.uniform(0.1, 0.5, nodes), rng.normal(size=nodes)
    work = fo.march(contact, cycle, friction, 3.0, initial_slip=slip, cycles=3).cycle_work
    assert work.max() > 0
    assert (
        np.abs(cycle_work(contact, cycle, friction, 3.0, slip, 3) - work).max()
        <= 1e-10 * work.max()
    )
