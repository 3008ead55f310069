"""Questions from several threads leave warnings, BLAS threads, numpy and signals as they were."""

import signal
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import threadpoolctl

import frictopt as fo
from helpers.systems import CYCLE, random_system


def state():
    libraries = threadpoolctl.threadpool_info()
    return (
        list(warnings.filters),
        warnings.showwarning,
        np.geterr(),
        [library["num_threads"] for library in libraries],
        [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)],
    )


def ask(seed):
    system = random_system(np.random.default_rng(seed), 3)
    limit = fo.shakedown_limit(system, CYCLE, 0.5, progress=False)
    fo.dissipation_study(system, CYCLE, 0.5, [0.5], progress=False)
    return limit.load_factor


def test_questions_from_eight_threads_leave_the_process_as_it_is():
    alone = [ask(seed) for seed in range(16)]
    before = state()
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(ask, range(16))) == alone
    assert state() == before


def test_odd_contacts_warn_from_eight_threads_as_from_one():
    system = random_system(np.random.default_rng(3), 3)

    def odd(number):
        fo.shakedown_limit(system, CYCLE, 30.0 + number, progress=False)

    with warnings.catch_warnings(record=True) as alone:
        warnings.simplefilter("always")
        for number in range(20):
            odd(number)
    with warnings.catch_warnings(record=True) as together:
        warnings.simplefilter("always")
        with ThreadPoolExecutor(8) as pool:
            list(pool.map(odd, range(20)))
    texts = [sorted(str(warning.message) for warning in some) for some in (alone, together)]
    assert texts[0] == texts[1] and len(texts[0]) == 20
