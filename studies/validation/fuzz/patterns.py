"""The limit with separation: its state rests, it is not below the shakedown limit, and above a proven one no start comes to rest."""

from typing import Any

import numpy as np

import frictopt as fo

from .known import Known, NotAsked, Wrong

_FEW = 4  # nodes up to which it is asked, of a part of the cases
_BELOW = 1 - 1e-9  # at the limit itself nodes may stand at their bounds, where above the critical friction the path goes on in several ways
_ABOVE = (1.01, 1.3)  # load factors, over a proven limit, at which transients may not rest
_STARTS = 6


def separated(known: Known) -> tuple[float, bool]:
    """Against transients from its state, and from other starts above it, and against the plain shakedown limit."""
    case = known.case
    if case.system.nodes > _FEW or case.seed % 8:
        raise NotAsked
    limit = fo.separated_limit(*known.args)
    if known.limit is not None and limit.load_factor < known.limit * (1 - 1e-6) - 1e-8:
        raise Wrong(f"{limit.load_factor!r} is below the shakedown limit {known.limit!r}")
    if limit.state is None or not np.isfinite(limit.load_factor):
        return limit.residual, known.limit is not None
    if not _rests(known, _BELOW * limit.load_factor, initial_state=limit.state):
        raise Wrong("its state does not rest")
    rng = np.random.default_rng(case.seed)
    starts = limit.slip + (known.length + np.abs(limit.slip).max()) * rng.normal(size=(_STARTS, case.system.nodes))
    for factor in _ABOVE if limit.proven and limit.load_factor > 1e-6 else ():
        for start in starts:
            if _rests(known, factor * limit.load_factor, initial_slip=start):
                raise Wrong(f"proven, but a start rests at {factor:g} of it")
    return limit.residual, True


def _rests(known: Known, load_factor: float, **begin: Any) -> bool:
    try:
        steady = fo.steady_state(*known.args, load_factor, **begin, most_cycles=200)
    except (fo.NoContinuation, fo.SolverError):
        return False
    return steady.outcome is fo.Outcome.SHAKEDOWN
