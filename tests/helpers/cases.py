"""The cases that a test tries.

Each run tries a third of them, or fewer if a case is expensive. These are the first cases, or with
`pytest --hypothesis-seed=N` others that N draws. With ALL_CASES=1 in the environment a run tries
all, as in the weekly job.
"""

import os
from random import Random

ALL_CASES = os.environ.get("ALL_CASES") == "1"
# The value of --hypothesis-seed, set by tests/conftest.py.
SEED = None


def few(cases, least=2, share=3):
    """A share of a number of cases, or some cases of a list, but `least` of them at least.

    The share is one of `share`. With ALL_CASES it is all cases.
    """
    number = cases if isinstance(cases, int) else len(cases)
    kept = number if ALL_CASES else min(number, max(least, -(-number // share)))
    if isinstance(cases, int):
        return kept
    if SEED is None:
        return cases[:kept]
    return [cases[i] for i in sorted(Random(SEED).sample(range(number), kept))]
