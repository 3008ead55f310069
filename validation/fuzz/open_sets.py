"""The search of open nodes: its state rests; where another set of few nodes is better, the search missed it."""

from functools import partial
from itertools import product

import numpy as np

import frictopt as fo
from validation.fuzz.known import Known, Missed, NotAsked, Wrong
from validation.open_sets import largest_with_open

_FEW = 4  # nodes up to which it is asked, of a part of the cases
# relative difference that the tolerances of the plain program explain at little friction
_ALIKE = 1e-3
# at the limit itself nodes may stand at their bounds, where above the critical friction the path
# goes on in several ways
_BELOW = 1 - 1e-9


def limits_of_sets(known: Known) -> tuple[float, bool]:
    """Against transients from its state, and against all sets that stay open."""
    case = known.case
    if case.system.nodes > _FEW or case.seed % 8:
        raise NotAsked
    limit = fo.shakedown_limit(*known.args)
    if limit.state is None or not known.none < limit.load_factor < np.inf:
        return limit.residual, False
    steady = fo.steady_state(
        *known.args, _BELOW * limit.load_factor, initial_state=limit.state, most_cycles=200
    )
    if steady.outcome is not fo.Outcome.SHAKEDOWN:
        raise Wrong("its state does not rest")
    corners, static = (
        len(case.cycle.corners),
        all(corner == case.cycle.corners[0] for corner in case.cycle.corners),
    )
    for opened in (
        product((False, True), repeat=case.system.nodes) if not static else ()
    ):  # a static load has no search
        reaches = partial(largest_with_open, *known.args, np.tile(opened, (corners, 1)))
        beyond = reaches(2 * limit.load_factor)
        if beyond is None or beyond[0] <= limit.load_factor * (1 + _ALIKE):
            continue
        if (up_to := reaches(limit.load_factor)) and up_to[0] > limit.load_factor * (
            1 - _ALIKE
        ):  # safe at the limit, too
            raise Missed(
                f"{beyond[0]!r} with {opened} open is above the limit {limit.load_factor!r}"
            )
    return limit.residual, True
