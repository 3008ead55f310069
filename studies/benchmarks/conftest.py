"""Median time of a call divided by the median time of its rival, both run by turns with one thread."""

import statistics
import time
from pathlib import Path

import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo


def pytest_collection_modifyitems(items):
    """Let measurements take longer than tests before they count as endless."""
    for item in items:
        if item.path.parent == Path(__file__).parent:
            item.add_marker(pytest.mark.timeout(1200))


@pytest.fixture(scope="session")
def scene():
    return fo.scenes.PunchOnHalfPlane()


@pytest.fixture(scope="session")
def system(scene):
    return scene.condense()


@pytest.fixture(scope="session")
def cycle():
    return fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])


@pytest.fixture
def compare(benchmark, record_property):
    """Time `ours` and `rival` by turns, and return the ratio of the medians.

    The benchmark shows the ratio.
    """

    def run(ours, rival, rounds=9):
        times = {ours: [], rival: []}
        with threadpool_limits(1):
            for function in (ours, rival) * 2:
                function()
            for _ in range(rounds):
                for function, spent in times.items():
                    start = time.perf_counter()
                    function()
                    spent.append(time.perf_counter() - start)
            benchmark.pedantic(ours, rounds=3)
        medians = [statistics.median(spent) for spent in times.values()]
        ratio = medians[0] / medians[1]
        benchmark.extra_info.update(ours=medians[0], rival=medians[1], ratio=ratio)
        record_property("ratio", ratio)
        print(
            f"\n    ours {1e3 * medians[0]:.1f} ms, rival {1e3 * medians[1]:.1f} ms, ratio {ratio:.2f}"
        )
        return ratio

    return run
