"""The search of open nodes, compared with transients and with all sets of open nodes.

A transient must stay stuck in the state of the limit. If another set of open nodes has a larger
limit, the search missed it.
"""

from functools import partial
from itertools import product

import numpy as np

import frictopt as fo
from studies.validation.fuzz.known import Known, Missed, NotApplicable, Wrong
from studies.validation.open_sets import largest_with_open

# Largest number of nodes for which all sets are tried.
_FEW = 4
# Relative difference of two limits that the tolerances of the plain program explain if friction is
# small.
_ALIKE = 1e-3
# The load factor of the transient, divided by the limit. At the limit itself nodes may be at their
# friction bounds. Above the critical friction the path then continues in several ways.
_BELOW = 1 - 1e-9


def limits_of_sets(known: Known) -> tuple[float, bool]:
    """Compare the limit with a transient from its state, and with all sets of open nodes."""
    case = known.case
    if case.system.nodes > _FEW or case.seed % 8:
        raise NotApplicable
    limit = fo.shakedown_limit(*known.args)
    if limit.state is None or not known.none < limit.load_factor < np.inf:
        return limit.residual, False
    steady = fo.steady_state(
        *known.args, _BELOW * limit.load_factor, initial_state=limit.state, most_cycles=200
    )
    if steady.outcome is not fo.Outcome.SHAKEDOWN:
        raise Wrong("its state does not rest")
    corners = case.cycle.corners
    if all(corner == corners[0] for corner in corners):
        # A static load has no search of open nodes.
        return limit.residual, True
    for opened in product((False, True), repeat=case.system.nodes):
        largest_up_to = partial(largest_with_open, *known.args, np.tile(opened, (len(corners), 1)))
        beyond = largest_up_to(2 * limit.load_factor)
        if beyond is None or beyond[0] <= limit.load_factor * (1 + _ALIKE):
            continue
        # This set has a larger limit. The set is better only if it is safe at the limit itself,
        # too.
        at_limit = largest_up_to(limit.load_factor)
        if at_limit is not None and at_limit[0] > limit.load_factor * (1 - _ALIKE):
            raise Missed(
                f"{beyond[0]!r} with {opened} open is above the limit {limit.load_factor!r}"
            )
    return limit.residual, True
