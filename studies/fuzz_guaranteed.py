"""What is asked of the guaranteed limit of a random case: against plain linear programs, and against transients."""

import numpy as np

import frictopt as fo

from . import oracles
from .fuzz_known import Known, NotAsked, Wrong, same, transformed

__all__ = ["followed", "guaranteed", "guaranteed_transformed"]

_STARTS = 10  # below the limit
_MOVED = 5  # starts next to the witness, above the limit


def guaranteed(known: Known) -> tuple[float, bool]:
    """Against one linear program per node on the plain rows of all corners; the witness against the rows themselves."""
    limit = known.answered_guarantee
    if not (limit.upper <= limit.shakedown.load_factor or np.isnan(limit.upper)) or not (limit.lower <= limit.upper or np.isnan(limit.lower)):
        raise Wrong(f"guaranteed limit {limit.lower!r} to {limit.upper!r}, shakedown limit {limit.shakedown.load_factor!r}")
    if np.isfinite(limit.upper):
        excess = oracles.excess(*known.args, limit.upper, limit.slip)
        if excess > 1e-8:
            raise Wrong(f"the witness is not safe by {excess:.1e}")
    if limit.node is not None and limit.corners is not None:
        off = oracles.off_bounds(*known.args, limit.upper, limit.slip, limit.node, limit.corners)
        if off > 1e-8 or limit.corners[0] == limit.corners[1]:
            raise Wrong(f"node {limit.node} is off its bounds by {off:.1e} at corners {limit.corners}")
    least = None if known.limit is None or np.isnan(known.limit) else oracles.least_on_both_bounds(*known.args)
    if least is None or known.limit is None:
        return limit.residual, False
    same("guaranteed limit", limit.upper, min(known.limit, least), absolute=1e-8)
    return limit.residual, True


def guaranteed_transformed(known: Known) -> tuple[float, bool]:
    """The same guaranteed limit of the same contact, described in other ways."""
    return transformed(known, "guaranteed limit", fo.guaranteed_limit, lambda limit: float(limit.upper), known.answered_guarantee)


def followed(known: Known) -> tuple[float, bool]:
    """Just above the limit a transient from the witness persists; just below, none from a few starts does."""
    limit = known.answered_guarantee
    if not (np.isfinite(limit.upper) and limit.shakedown.load_factor > 0):
        raise NotAsked
    check = fo.verify_guaranteed(*known.args, limit=limit, starts=_STARTS, moved=0 if limit.node is None else _MOVED, seed=known.case.seed)
    if not check.dies_out:
        raise Wrong(f"persists below the limit {limit.upper:.6g}: {check.runs[check.runs['share'] < 1].to_dict('list')}")
    if limit.node is not None and not check.persists:
        near = check.runs[check.runs["start"].str.contains("witness")]
        if (near["outcome"] == "NO_CONTINUATION").all():
            raise fo.NoContinuation(f"all {len(near)} transients near the witness end before they have an outcome; lower the friction")
        raise Wrong(f"dies out above the limit {limit.upper:.6g}: {near.to_dict('list')}")
    return limit.residual, check.undecided < len(check.runs)
