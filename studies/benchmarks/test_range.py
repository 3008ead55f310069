"""The range of dissipation over all starts against the 108 starts of the study at the same load."""

import statistics
import time

import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo
from studies import dissipation

CASES = [(0.3, 0.9), (0.3, 1.05), (0.5, 0.5), (0.5, 0.9), (0.7, 0.9), (0.7, 1.5)]


@pytest.mark.parametrize(("friction", "ratio"), CASES)
def test_range_against_a_sample(compare, system, cycle, friction, ratio):
    limit = fo.shakedown_limit(system, cycle, friction).load_factor
    starts = dissipation.starts_of(
        dissipation.FULL, dissipation.Case(system, friction, limit), ratio * limit
    )
    spans, samples = [], []

    def ours():
        spans.append(fo.dissipation_range(system, cycle, friction, ratio * limit))

    def rival():
        samples.append(
            fo.dissipation_study(system, cycle, friction, [ratio * limit], starts, progress=False)
        )

    ours_over_rival = compare(ours, rival, rounds=3)
    span, works = spans[-1], samples[-1]["dissipation"]
    assert (
        len(works) == 108
        and span.most >= works.max() * (1 - 1e-9)
        and span.least <= works.min() * (1 + 1e-9)
    )
    # The ratio is usually 0.8 to 1.6: two searches, one for each end, cost about as much as 108
    # starts.
    assert ours_over_rival < 2


@pytest.mark.parametrize(("friction", "ratio"), CASES)
def test_range_in_two_seconds_of_one_thread(system, cycle, record_property, friction, ratio):
    """Other work on the machine does not count in the processor time."""
    limit, spent = fo.shakedown_limit(system, cycle, friction).load_factor, []
    with threadpool_limits(1):
        for _ in range(4):
            start = time.process_time()
            fo.dissipation_range(system, cycle, friction, ratio * limit)
            spent.append(time.process_time() - start)
    median = statistics.median(spent[1:])
    record_property("seconds", median)
    print(f"\n    {median:.2f} s")
    assert median < 2.0
