"""How many random cases a test tries: a third in each run, all of them where the environment has
ALL_CASES=1, as in the weekly job."""

import os

ALL_CASES = os.environ.get("ALL_CASES") == "1"


def few(cases, least=2):
    """A third of a number of cases, or of a list the first third, but so many at least; with
    ALL_CASES all."""
    number = cases if isinstance(cases, int) else len(cases)
    kept = number if ALL_CASES else min(number, max(least, -(-number // 3)))
    return kept if isinstance(cases, int) else cases[:kept]
