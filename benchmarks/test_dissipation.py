"""The dissipation study at full size: what a second worker gains, and what the store costs."""

import shutil
import statistics
import time
from dataclasses import replace

import pytest

import frictopt as fo
from studies import dissipation, paper

PARAMETERS = replace(dissipation.FULL, frictions=(0.7,))


@pytest.fixture(scope="module")
def study():
    (case,) = dissipation.cases_of(PARAMETERS)
    factors = [ratio * case.limit for ratio in PARAMETERS.ratios]
    starts = dissipation.starts_of(PARAMETERS, case)

    def follow(**options):
        start = time.perf_counter()
        table = fo.dissipation_study(case.system, paper.LOADS, case.friction, factors, starts, **options)
        assert len(table) == 2160 and (table.error == "").all()
        return time.perf_counter() - start

    return follow


def by_turns(first, second, rounds=3):
    """Median times of both, run by turns after one run of each."""
    times = [(first(), second()) for _ in range(rounds + 1)][1:]
    return [statistics.median(column) for column in zip(*times, strict=True)]


def test_two_workers(study, record_property):
    one, two = by_turns(lambda: study(workers=1), lambda: study(workers=2))
    record_property("gain", one / two)
    print(f"\n    2,160 transients: one process {one:.1f} s, two workers {two:.1f} s, gain {one / two:.2f}")
    assert one / two >= 1.7


def test_store(study, record_property, tmp_path):
    def stored():
        shutil.rmtree(tmp_path / "runs", ignore_errors=True)
        return study(workers=1, store=tmp_path / "runs")

    without, kept = by_turns(lambda: study(workers=1), stored)
    record_property("cost", kept / without - 1)
    print(f"\n    2,160 transients: {without:.1f} s without a store, {kept:.1f} s with one, cost {100 * (kept / without - 1):.1f} %")
    assert kept / without <= 1.03
