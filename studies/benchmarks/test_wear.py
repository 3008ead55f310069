"""Wear of a cylinder until it is worn in: processor time, and a comparison with explicit jumps.

The explicit jumps are nearly as long as stability allows.
"""

import time
from math import pi

import numpy as np
from threadpoolctl import threadpool_limits

import frictopt as fo

NODES, COEFFICIENT = 128, 1e-3
ASKED = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.5, 0.25
# Share of the longest stable jump, after which the stiffest pressure has changed its sign but not
# its size.
SHARE = 0.9


def explicit(system):
    """Number of explicit jumps to a thousandth of the work, each without initial slip."""
    steady, stiffest, works = (
        fo.steady_state(system, *ASKED),
        np.linalg.eigvalsh(system.C)[-1],
        list[float](),
    )
    while steady.dissipation > 1e-3 * max(works, default=0.0):
        works.append(steady.dissipation)
        jump = SHARE * 2 / ((COEFFICIENT * steady.sliding_distance / system.width).max() * stiffest)
        system = system.with_gap(
            system.gap + jump * COEFFICIENT * steady.dissipation_per_node / ASKED[1] / system.width
        )
        steady = fo.steady_state(system, *ASKED)
    return len(works)


def test_a_cylinder_is_worn_in_within_five_seconds_and_sooner_than_by_explicit_jumps(
    record_property,
):
    arrays = fo.reference.half_plane_contact(NODES, 1.3, 4 / pi, R=1.0)
    system = fo.ContactSystem.from_blocks(**arrays, width=np.full(NODES, 2.6 / NODES))
    # This call compiles, and imports all that later calls need.
    fo.joints.wear(system, *ASKED, coefficient=COEFFICIENT, cycles=1)
    with threadpool_limits(1):
        begin = time.process_time()
        history = fo.joints.wear(system, *ASKED, coefficient=COEFFICIENT)
        middle = time.process_time()
        jumps = explicit(system)
        ours, rival = middle - begin, time.process_time() - middle
    record_property("seconds", ours)
    record_property("ratio", ours / rival)
    print(
        f"wear: {ours:.2f} s in {len(history.depth) - 1} jumps; explicit: {rival:.2f} s in {jumps} jumps"
    )
    assert history.worn_in and ours < 5 and ours < rival
