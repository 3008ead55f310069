"""Answers in which nodes open and close in each cycle, against transients.

The plain programs keep every node closed or open for the whole cycle. For uncoupled contacts
frictopt finds more: nodes may also come and go. Such a contact comes to rest from every start or
from none, so that a few transients tell which of the two.
"""

import numpy as np

import frictopt as fo
from validation.fuzz.known import Known, Wrong
from validation.moving_areas import ends, expected

# Distance from the limit, as a share of it, within which transients are not asked.
_APART = 0.01
# Transients from no slip and from random slips.
_STARTS = 3
# Where no load factor is too large, this multiple of the limit of closed nodes is tried.
_FAR = 10.0


def rests(known: Known, load_factor: float) -> bool | None:
    """Whether transients come to rest at a load factor; None if they do not agree or end early."""
    found = ends(known.args, load_factor, _STARTS, known.case.seed, known.length)
    if set(found) == {fo.Outcome.SHAKEDOWN.name}:
        return True
    slips = set(found) <= {fo.Outcome.CYCLIC_SLIP.name, fo.Outcome.RATCHETING.name}
    return False if slips else None


def limit_that_moves(known: Known, limit: fo.results.ShakedownLimit) -> tuple[float, bool]:
    """At least the limit of closed nodes; rest within the safe load factors and slip beyond them.

    A limit of 0 is compared with that of closed nodes alone, because transients at a load of next
    to nothing slip by less than they can tell.
    """
    largest = limit.load_factor
    closed = known.limit if known.limit is not None else np.nan
    if closed > largest * (1 + 1e-6) + 1e-8:
        raise Wrong(f"nodes come and go at {largest!r}, and closed ones have {closed!r}")
    if largest == 0:
        return limit.residual, known.limit is not None
    compared = True
    beyond = _FAR * max(1.0, closed) if np.isfinite(closed) else _FAR
    for load_factor, rest in expected(limit, beyond):
        found = rests(known, load_factor)
        if found is not None and found != rest:
            raise Wrong(f"rests at {load_factor:.9g}: {found}; the limit is {largest!r}")
        compared = compared and found is not None
    return limit.residual, compared


def safe_slip_that_moves(known: Known, safe: fo.results.SafeSlip) -> tuple[float, bool]:
    """A slip is safe exactly if transients come to rest, away from the ends of the safe loads."""
    limit, load_factor = known.answered_limit, known.load_factor
    for end in (limit.least, limit.load_factor):
        if abs(load_factor - end) < _APART * abs(end):
            return safe.residual, False
    found = rests(known, load_factor)
    if found is not None and found != safe.exists:
        raise Wrong(f"exists = {safe.exists} at {load_factor:.9g}, and transients rest: {found}")
    return safe.residual, found is not None
