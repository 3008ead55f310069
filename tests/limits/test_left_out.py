"""Corners of a path that a scene does not need are left out.

The answer is the same as with all corners kept.
"""

import pytest

import frictopt as fo
from helpers.corners import left_out


def test_a_corner_on_the_straight_segment_is_no_stop(punch, paper_cycle):
    """The result agrees with the cycle of the turning points, and with increments that stop at
    every corner."""
    contact = punch(16)
    sampled = fo.LoadCycle(
        {"P": 1.0}, [{"sigma": s} for s in (-1.0, -0.3, -0.3, 0.2, 1.0, 1.0, 0.7, -0.1)]
    )
    turns = fo.LoadCycle({"P": 1.0}, [{"sigma": s} for s in (-1.0, 1.0, -0.1)])
    lean, same, stops = (
        fo.steady_state(contact, cycle, 0.7, 2.6, steps=steps)
        for cycle, steps in ((sampled, None), (turns, None), (sampled, 8))
    )
    note = lean.record.left_out[-1]
    assert note.startswith("corners: 5 of 8 are on") and note.endswith("are ignored")
    assert same.record.left_out == ()
    assert lean.dissipation > 0
    assert lean.slip == pytest.approx(same.slip, abs=1e-9)
    assert lean.dissipation_per_node == pytest.approx(same.dissipation_per_node, abs=1e-9)
    assert lean.outcome is stops.outcome
    assert lean.dissipation == pytest.approx(stops.dissipation, rel=5 * stops.step_error)


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1.0, 1e7, 1e15])
def test_the_unit_of_a_load_case_does_not_change_where_a_load_turns(unit):
    """A displacement goes to and fro beside a stress that only grows, in any unit."""
    cycle = fo.LoadCycle(
        {}, [{"sigma": 1e9 * k / 8, "d": unit * (-1) ** k if 0 < k < 8 else 0.0} for k in range(9)]
    )
    assert left_out(cycle) == 0
    straight = fo.LoadCycle({}, [{"sigma": 1e9 * k, "d": unit * k} for k in (0.0, 0.3, 0.7, 1.0)])
    assert left_out(straight) == 2


@pytest.mark.parametrize(
    ("amplitudes", "count"),
    [
        ([0.0], 0),
        ([1.0, 1.0], 0),
        ([0.0, 0.8, 0.5, 1.0], 0),
        ([0.0, 0.5, 1.0, 1.0, 0.5, 0.0], 3),
        ([0.0, 1.0, 2.0, 3.0], 2),
        ([2.0, 1.0, 1.0, 1.0, 2.0], 2),
    ],
)
def test_where_a_load_turns(amplitudes, count):
    one = fo.LoadCycle({}, [{"a": a} for a in amplitudes])
    two = fo.LoadCycle({}, [{"a": 0.3 * a, "b": -0.7 * a} for a in amplitudes])
    for cycle in (one, two):
        assert left_out(cycle) == count
