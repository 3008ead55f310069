"""What a scene does not need is left out, and the answer is the same with everything kept: corners of a path, and half of a symmetric contact."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits.mechanism import Mechanism
from frictopt.limits.mirrors import half_of, on_whole
from frictopt.limits.question import pose
from frictopt.transients.exact.path import turning_corners
from systems import mirrored, odd


def test_the_half_has_the_stiffness_of_its_motions():
    """Energy and reactions of odd slips, against the whole; the middle node cannot slip."""
    rng = np.random.default_rng(0)
    for nodes in (2, 5, 6):
        contact = mirrored(rng, nodes, gap=True)
        task = pose(contact, fo.LoadCycle({"mean": 1.0}, [{"mean": 0.1}]), 1.0)
        half, kept = half_of(task), (nodes + 1) // 2
        assert len(half.friction) == kept and half.whole is task
        v = odd(rng, nodes)
        assert v[:kept] @ half.AB[:kept] @ v[:kept] == pytest.approx(v @ contact.A @ v / 2)
        q, p = half.change(v[:kept])
        assert q == pytest.approx((contact.A @ v)[:kept]) and p == pytest.approx((contact.B @ v)[:kept])
        still = Mechanism(np.zeros((1, kept)), np.zeros((1, kept)), half.friction)
        assert on_whole(half, v[:kept], still)[1] == pytest.approx(v)


def test_a_corner_on_the_straight_segment_is_no_stop(punch, paper_cycle):
    """Against the cycle of the turning points alone, and against increments that stop everywhere."""
    contact = punch(16)
    sampled = fo.LoadCycle({"P": 1.0}, [{"sigma": s} for s in (-1.0, -0.3, -0.3, 0.2, 1.0, 1.0, 0.7, -0.1)])
    turns = fo.LoadCycle({"P": 1.0}, [{"sigma": s} for s in (-1.0, 1.0, -0.1)])
    lean, same, stops = (fo.steady_state(contact, cycle, 0.7, 2.6, steps=steps) for cycle, steps in ((sampled, None), (turns, None), (sampled, 8)))
    assert "corners: 5 of 8" in lean.record.left_out[-1] and same.record.left_out == () and lean.dissipation > 0
    assert lean.slip == pytest.approx(same.slip, abs=1e-9) and lean.dissipation_per_node == pytest.approx(same.dissipation_per_node, abs=1e-9)
    assert lean.outcome is stops.outcome and lean.dissipation == pytest.approx(stops.dissipation, rel=5 * stops.step_error)


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1.0, 1e7, 1e15])
def test_the_unit_of_a_load_case_does_not_change_where_a_load_turns(unit):
    """A displacement that goes to and fro beside a stress that only grows, in any unit."""
    cycle = fo.LoadCycle({}, [{"sigma": 1e9 * k / 8, "d": unit * (-1) ** k if 0 < k < 8 else 0.0} for k in range(9)])
    assert turning_corners(cycle) == list(range(9))
    straight = fo.LoadCycle({}, [{"sigma": 1e9 * k, "d": unit * k} for k in (0.0, 0.3, 0.7, 1.0)])
    assert turning_corners(straight) == [0, 3]


@pytest.mark.parametrize(
    ("amplitudes", "stops"),
    [
        ([0.0], [0]),
        ([1.0, 1.0], [0, 1]),
        ([0.0, 0.8, 0.5, 1.0], [0, 1, 2, 3]),
        ([0.0, 0.5, 1.0, 1.0, 0.5, 0.0], [0, 3, 5]),
        ([0.0, 1.0, 2.0, 3.0], [0, 3]),
        ([2.0, 1.0, 1.0, 1.0, 2.0], [0, 3, 4]),
    ],
)
def test_where_a_load_turns(amplitudes, stops):
    one = fo.LoadCycle({}, [{"a": a} for a in amplitudes])
    two = fo.LoadCycle({}, [{"a": 0.3 * a, "b": -0.7 * a} for a in amplitudes])
    for cycle in (one, two):
        assert turning_corners(cycle) == stops
