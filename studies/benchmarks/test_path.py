"""Transients on the paper's scene: the exact path against Lemke's method, and steady states.

Lemke's method (quantecon) takes increments. The steady states have random and hard starts.
"""

import os
import resource
import subprocess
import sys
import time

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.transients.exact import ExactPath
from studies.validation.error_vs_time.lemke import Lemke

FRICTION = 0.7


@pytest.fixture(scope="module", params=[40, 124])
def contact(request):
    return fo.scenes.PunchOnHalfPlane(elements=request.param).condense()


def exact(contact, cycle, load_factor):
    """Work of friction in the second cycle, by the exact path."""
    path = ExactPath(contact, cycle, FRICTION, load_factor).start()
    return path.cycle_on(2).works[1]


def lemke(contact, cycle, load_factor):
    """A function of the number of increments in a cycle.

    It returns the work of friction in the second cycle by Lemke's method.
    """
    pytest.importorskip("quantecon")
    path = ExactPath(contact, cycle, FRICTION, load_factor)
    rival, loads = Lemke(contact, FRICTION, path.force), [path.bonded, path.mean, *path.corners * 2]
    return lambda steps: rival.cycle_work(np.zeros(contact.nodes), loads, steps // 2, 2)


def test_two_cycles_above_the_limit_against_lemke(compare, contact, cycle):
    load_factor = 1.4 * fo.shakedown_limit(contact, cycle, FRICTION).load_factor
    rival, work = lemke(contact, cycle, load_factor), exact(contact, cycle, load_factor)
    for steps in (40, 160, 640):
        start = time.perf_counter()
        error = abs(rival(steps) / work - 1)
        spent = 1e3 * (time.perf_counter() - start)
        print(
            f"\n    N = {contact.nodes}, Lemke, {steps} increments a cycle: error of W {error:.1e}, {spent:.1f} ms",
            end="",
        )
    assert compare(lambda: exact(contact, cycle, load_factor), lambda: rival(80)) < (
        0.5 if contact.nodes > 100 else 1.0
    )


def test_steady_states_from_random_starts(benchmark, contact, cycle):
    """Whole transients to their proven steady states.

    There are 5 load factors. Starts are random sums of the Chebyshev modes 1 to 6, with several
    amplitudes.
    """
    limit = fo.shakedown_limit(contact, cycle, FRICTION).load_factor
    modes = np.polynomial.chebyshev.chebvander(contact.x, 6)[:, 1:]
    rng = np.random.default_rng(0)
    ratios, amplitudes = (
        np.repeat([0.5, 0.9, 1.05, 1.5, 3.0], 20),
        rng.choice([0.01, 0.1, 0.3, 1.0, 3.0], size=100),
    )
    runs = [
        (ratio * limit, amplitude * modes @ rng.normal(size=6))
        for ratio, amplitude in zip(ratios, amplitudes, strict=True)
    ]

    def follow():
        return [
            fo.steady_state(contact, cycle, FRICTION, factor, initial_slip=start)
            for factor, start in runs
        ]

    with threadpool_limits(1):
        follow()
        benchmark.pedantic(follow, rounds=3)
    mean = benchmark.stats.stats.median / len(runs)
    print(
        f"\n    N = {contact.nodes}: {1e3 * mean:.2f} ms a transient on average, {np.mean([s.cycles for s in follow()]):.1f} cycles"
    )
    assert mean < (0.06 if contact.nodes > 100 else 0.005)


def test_hard_starts_against_products_with_the_stiffness(compare, cycle):
    """Whole transients from unit modes, N = 125, at load factors of 0.9 to 1.5 lambda_2.

    The rival is one product of the stiffness with the motions for each event.
    """
    contact = fo.scenes.PunchOnHalfPlane(elements=124).condense()
    limit = fo.shakedown_limit(contact, cycle, FRICTION).load_factor
    starts, u = (
        np.polynomial.chebyshev.chebvander(contact.x, 6)[:, 1:].T,
        np.ones(2 * contact.nodes),
    )

    def follow():
        return [
            fo.steady_state(contact, cycle, FRICTION, share * limit, initial_slip=start)
            for share in (0.9, 1.05, 1.2, 1.5)
            for start in starts
        ]

    events = sum(steady.events for steady in follow())

    def multiply():
        for _ in range(events):
            contact.S @ u

    print(f"\n    {events} events", end="")
    assert compare(follow, multiply, rounds=5) < 6.0


def test_compilation_in_new_processes(record_property, tmp_path):
    """Time of a first path on a new machine, relative to one with stored machine code."""
    code = "from frictopt.transients.exact.kernel import compiled; compiled()"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "OPENBLAS_NUM_THREADS": "1"}
    times = []
    for _ in range(4):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", code], check=True, env=environment)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    fresh, kept = times[0], min(times[1:])
    record_property("ratio", fresh / kept)
    print(f"\n    fresh {fresh:.2f} s, kept {kept:.2f} s, ratio {fresh / kept:.1f}")
    assert fresh / kept < 11.0
