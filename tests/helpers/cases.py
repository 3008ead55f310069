"""The number of cases that a test tries.

Each run tries a third of them, or fewer if a case is expensive. With ALL_CASES=1 in the environment
it tries all, as in the weekly job.
"""

import os

ALL_CASES = os.environ.get("ALL_CASES") == "1"


def few(cases, least=2, share=3):
    """A share of a number of cases, or the first cases of a list, but `least` of them at least.

    The share is one of `share`. With ALL_CASES it is all cases.
    """
    number = cases if isinstance(cases, int) else len(cases)
    kept = number if ALL_CASES else min(number, max(least, -(-number // share)))
    return kept if isinstance(cases, int) else cases[:kept]
