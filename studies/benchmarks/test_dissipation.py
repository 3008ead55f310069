"""The dissipation study: the gain by a second process, and the costs of the store and of limits."""

import statistics
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

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
    """Median times of two functions, run by turns after one run of each."""
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
    """The time of the store, as a share of the time of the study.

    It is measured within a study, because times of whole studies differ by more than this.
    """
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


def test_a_study_without_limits_and_one_from_a_full_store(record_property, tmp_path):
    """Times relative to the study with limits, for a contact that lifts off.

    There are three preloads and four frictions.
    """
    contact = fo.scenes.PunchOnHalfPlane(elements=60).condense()
    contact = contact.with_gap(2.0 * contact.x**4)
    corners = [{"sigma": -1.0}, {"sigma": 1.0}]
    cycles = {f"P = {P}": fo.LoadCycle({"P": P}, corners) for P in (0.5, 1.0, 2.0)}
    frictions = [0.3, 0.5, 0.7, 0.9]

    def spent(name, **options):
        start = time.process_time()
        table = fo.dissipation_study(
            contact, cycles, frictions, [1.0], store=tmp_path / name, progress=False, **options
        )
        assert len(table) == 12 and (table.error == "").all()
        return time.process_time() - start

    with threadpool_limits(1):
        spent("warm", limits=True)
        rounds = [
            (
                spent(f"without {number}"),
                spent(f"with {number}", limits=True),
                spent(f"with {number}", limits=True),
            )
            for number in range(3)
        ]
    without, limits, full = np.min(rounds, axis=0)
    record_property("ratio", without / limits)
    record_property("full store", full / limits)
    print(
        f"\n    12 runs: without limits {without:.3f} s, with limits {limits:.3f} s, "
        f"from a full store {full:.3f} s"
    )
    assert without / limits < 1 / 12 and full / limits < 1 / 12
