"""Answers in which nodes open and close in each cycle, against transients.

The plain programs keep every node closed or open for the whole cycle. In uncoupled contacts
frictopt lets nodes open and close in each cycle, too. Such a contact shakes down from every start
or from none, so a few transients show which of the two holds.
"""

import numpy as np

import frictopt as fo
from studies.validation.fuzz.known import Known, Wrong
from studies.validation.moving_areas import ends, expected

# Relative distance from the limit within which transients are not compared with it.
_APART = 0.01
# Number of transients: the first one starts without slip, the others from random slips.
_STARTS = 3
# If all load factors are safe, this multiple of the limit of closed nodes is tried.
_FAR = 10.0


def rests(known: Known, load_factor: float) -> bool | None:
    """Whether transients shake down at a load factor; None if they do not agree or end early."""
    outcomes = set(ends(known.args, load_factor, _STARTS, known.case.seed, known.length))
    if outcomes == {fo.Outcome.SHAKEDOWN.name}:
        return True
    all_slip = outcomes <= {fo.Outcome.CYCLIC_SLIP.name, fo.Outcome.RATCHETING.name}
    return False if all_slip else None


def limit_that_moves(known: Known, limit: fo.results.ShakedownLimit) -> tuple[float, bool]:
    """Compare a limit with nodes that open and close with transients.

    The limit must be at least the limit of closed nodes. Transients must shake down at safe load
    factors, and slip beyond them. A limit of 0 is compared only with the limit of closed nodes,
    because transients cannot resolve the slip at tiny loads.
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
        followed = rests(known, load_factor)
        if followed is not None and followed != rest:
            raise Wrong(f"rests at {load_factor:.9g}: {followed}; the limit is {largest!r}")
        compared = compared and followed is not None
    return limit.residual, compared


def safe_slip_that_moves(known: Known, safe: fo.results.SafeSlip) -> tuple[float, bool]:
    """Check that a slip is safe exactly if transients shake down.

    Load factors close to an end of the safe load factors are not compared.
    """
    limit, load_factor = known.answered_limit, known.load_factor
    for end in (limit.least, limit.load_factor):
        if abs(load_factor - end) < _APART * abs(end):
            return safe.residual, False
    rest = rests(known, load_factor)
    if rest is not None and rest != safe.exists:
        raise Wrong(f"exists = {safe.exists} at {load_factor:.9g}, and transients rest: {rest}")
    return safe.residual, rest is not None
