"""Safe regions of contacts whose nodes stay open.

A region belongs to one set of open nodes; only then is it convex.
"""

from itertools import pairwise

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from studies.validation.fuzz.cases import random_case


@pytest.mark.parametrize("seed", few([500116, 500188, 500128]))
def test_all_amplitudes_of_a_region_are_safe_where_each_load_alone_leaves_other_nodes_open(seed):
    case = random_case(seed)
    region = fo.safe_region(case.system, {"mean": 1.0}, ["a", "b"], case.friction)
    points = region.vertices[np.isfinite(region.vertices).all(axis=1)]
    for point in [*points, *((one + other) / 2 for one, other in pairwise(points))]:
        if (point > 0).any():
            assert (
                fo.shakedown_limit(case.system, region.cycle(*point), case.friction).load_factor
                >= 1 - 1e-7
            )
    # The region is that of one set of open nodes: each vertex is on the border of this set.
    for point in points:
        chosen = opened_in(region, points[0], case)
        assert fo.shakedown_limit(
            case.system, region.cycle(*point), case.friction, open_nodes=chosen
        ).load_factor == pytest.approx(1.0, rel=1e-7)


def opened_in(region, point, case):
    """The set of open nodes of a region, which its reason counts."""
    closed = np.zeros(case.system.nodes, dtype=bool)
    if region.reason == "beyond each side its mechanism slips for ever with all nodes closed":
        return closed
    assert region.reason == (
        f"with 1 of {case.system.nodes} nodes open: beyond each side its mechanism slips for ever "
        "with these nodes open and the others closed"
    )
    # With all nodes closed the region would be smaller.
    cycle = region.cycle(*point)
    assert (
        fo.shakedown_limit(case.system, cycle, case.friction, open_nodes=closed).load_factor
        < 1 - 1e-6
    )
    return fo.shakedown_limit(case.system, cycle, case.friction).open
