"""The backbone curve of the paper's punch at thirty load factors, with least and most damping.

The processor time is measured.
"""

import time

import numpy as np
from threadpoolctl import threadpool_limits

import frictopt as fo


def test_thirty_amplitudes_with_their_range_in_a_minute_of_one_thread(
    system, cycle, record_property
):
    """Most amplitudes are between the guaranteed and the shakedown limit, where the range takes longest."""
    limit = fo.shakedown_limit(system, cycle, 0.5).load_factor
    # This call compiles the exact path.
    fo.steady_state(system, cycle, 0.5, 1.2 * limit)
    with threadpool_limits(1):
        start = time.process_time()
        curve = fo.joints.backbone_curve(
            system, cycle, 0.5, limit * np.geomspace(0.1, 2.5, 30), with_range=True
        )
        spent = time.process_time() - start
    record_property("seconds", spent)
    below = int((curve.load_factor <= curve.guaranteed_limit).sum())
    print(
        f"\n    {spent:.1f} s; {below} of them below the guaranteed limit, {int((curve.load_factor > curve.shakedown_limit).sum())} above the other"
    )
    assert (
        (curve.least_damping <= curve.damping).all()
        and (curve.damping <= curve.most_damping).all()
        and curve.most_damping[-1] > 0
    )
    assert spent < 60
