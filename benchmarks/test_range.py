"""The range of dissipation found over all starts against the transients of the study's 108 starts at the same load."""

import pytest

import frictopt as fo
from studies import dissipation

CASES = [(0.3, 0.9), (0.3, 1.05), (0.5, 0.5), (0.5, 0.9), (0.7, 0.9), (0.7, 1.5)]


@pytest.mark.parametrize(("friction", "ratio"), CASES)
def test_range_against_a_sample(compare, system, cycle, friction, ratio):
    limit = fo.shakedown_limit(system, cycle, friction).load_factor
    starts = dissipation.starts_of(dissipation.FULL, dissipation.Case(system, friction, limit))
    spans, samples = [], []

    def ours():
        spans.append(fo.dissipation_range(system, cycle, friction, ratio * limit))

    def rival():
        samples.append(fo.dissipation_study(system, cycle, friction, [ratio * limit], starts, progress=False))

    ours_over_rival = compare(ours, rival, rounds=3)
    span, works = spans[-1], samples[-1]["dissipation"]
    assert len(works) == 108 and span.most >= works.max() * (1 - 1e-9) and span.least <= works.min() * (1 + 1e-9)
    assert ours_over_rival < 1


@pytest.mark.parametrize(("friction", "ratio"), CASES)
def test_range_in_two_seconds(benchmark, system, cycle, friction, ratio):
    limit = fo.shakedown_limit(system, cycle, friction).load_factor
    benchmark.pedantic(lambda: fo.dissipation_range(system, cycle, friction, ratio * limit), rounds=5, warmup_rounds=1)
    assert benchmark.stats.stats.median < 2.0
