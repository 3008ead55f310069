"""The search of open nodes: its state rests, and neither the nodes that the mean load opens nor any set of few nodes is far better."""

from itertools import product
from typing import Any

import numpy as np

import frictopt as fo

from ..open_patterns import largest_with_open
from .known import Known, NotAsked, Wrong

_FEW = 4  # nodes up to which it is asked, of a part of the cases
_BELOW = 1 - 1e-9  # at the limit itself nodes may stand at their bounds, where above the critical friction the path goes on in several ways


def patterns(known: Known) -> tuple[float, bool]:
    """Against transients from its state, and where nodes are open against all sets that stay open."""
    case = known.case
    if case.system.nodes > _FEW or case.seed % 8:
        raise NotAsked
    limit = fo.shakedown_limit(*known.args)
    if limit.state is None or not np.isfinite(limit.load_factor):
        return limit.residual, False
    if not _rests(known, _BELOW * limit.load_factor, initial_state=limit.state):
        raise Wrong("its state does not rest")
    if limit.open.any():
        sets = [np.tile(opened, (len(case.cycle.corners), 1)) for opened in product((False, True), repeat=case.system.nodes)]
        claims = [claim[0] for opened in sets if (claim := largest_with_open(*known.args, opened, 2 * limit.load_factor))]
        if max(claims, default=0.0) > limit.load_factor * (1 + 1e-6):
            raise Wrong(f"{max(claims)!r} with other nodes open is above the limit {limit.load_factor!r}")
    return limit.residual, True


def _rests(known: Known, load_factor: float, **begin: Any) -> bool:
    try:
        steady = fo.steady_state(*known.args, load_factor, **begin, most_cycles=200)
    except (fo.NoContinuation, fo.SolverError):
        return False
    return steady.outcome is fo.Outcome.SHAKEDOWN
