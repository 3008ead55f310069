"""The dissipation study at full size: what a second process gains, and what the store costs."""

import statistics
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import pytest

import frictopt as fo
from frictopt.study.store import Store
from studies import dissipation, paper

PARAMETERS = replace(dissipation.FULL, frictions=(0.7,))


@pytest.fixture(scope="module")
def study():
    (case,) = dissipation.cases_of(PARAMETERS)
    factors = [ratio * case.limit for ratio in PARAMETERS.ratios]
    starts = dissipation.starts_of(PARAMETERS, case, case.limit)

    def follow(**options):
        start = time.perf_counter()
        table = fo.dissipation_study(
            case.system, paper.LOADS, case.friction, factors, starts, **options
        )
        assert len(table) == 2160 and (table.error == "").all()
        return time.perf_counter() - start

    return follow


def by_turns(first, second, rounds=3):
    """Median times of both, run by turns after one run of each."""
    times = [(first(), second()) for _ in range(rounds + 1)][1:]
    return [statistics.median(column) for column in zip(*times, strict=True)]


def test_two_processes(study, record_property):
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        one, two = by_turns(study, lambda: study(executor=pool))
    record_property("gain", one / two)
    print(
        f"\n    2,160 transients: one process {one:.1f} s, two processes {two:.1f} s, gain {one / two:.2f}"
    )
    assert one / two >= 1.7


def test_store(study, record_property, tmp_path, monkeypatch):
    """The store's own time over that of the study: whole studies differ from each other by more."""
    spent = []

    def timed(method):
        def call(*args):
            start = time.perf_counter()
            result = method(*args)
            spent.append(time.perf_counter() - start)
            return result

        return call

    for name in ("read", "write"):
        monkeypatch.setattr(Store, name, timed(getattr(Store, name)))
    shares = []
    for number in range(3):
        spent.clear()
        seconds = study(store=tmp_path / f"{number}.sqlite")
        shares.append(sum(spent) / seconds)
    cost = statistics.median(shares)
    record_property("cost", cost)
    print(f"\n    2,160 transients in {seconds:.1f} s, of which the store takes {100 * cost:.1f} %")
    assert cost <= 0.03
