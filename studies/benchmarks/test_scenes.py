"""Limits of a dovetail of 58,332 glued unknowns and 250 node pairs."""

import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo

CYCLE = fo.LoadCycle({"pull": 1.0}, [{"sway": 1.0}, {"sway": -1.0}])


@pytest.fixture(scope="module")
def contact():
    return fo.scenes.Dovetail(elements=124).condense()


@pytest.mark.parametrize(
    ("limit", "seconds"),
    [(fo.shakedown_limit, 2.0), (fo.guaranteed_limit, 5.0)],
    ids=["shakedown", "guaranteed"],
)
def test_limits(benchmark, contact, limit, seconds):
    assert contact.nodes == 250
    with threadpool_limits(1):
        benchmark.pedantic(lambda: limit(contact, CYCLE, 0.6), rounds=3)
    assert benchmark.stats.stats.median < seconds
