"""How many cases a test tries: a third of them in each run, or fewer where each costs much; all of
them where the environment has ALL_CASES=1, as in the weekly job."""

import os

ALL_CASES = os.environ.get("ALL_CASES") == "1"


def few(cases, least=2, share=3):
    """One of `share` of a number of cases, or of a list the first ones, but `least` of them at
    least; with ALL_CASES all."""
    number = cases if isinstance(cases, int) else len(cases)
    kept = number if ALL_CASES else min(number, max(least, -(-number // share)))
    return kept if isinstance(cases, int) else cases[:kept]
