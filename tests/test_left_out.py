"""What a scene does not need is left out, and the answer is the same with everything kept: corners of a path, and half of a symmetric contact."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.contact.symmetry import halve
from frictopt.transients.exact import ExactPath, cycles
from frictopt.transients.exact.stops import turning_corners
from systems import mirrored, odd


def both(contact, cycle, friction, factor, **options):
    """Steady states with what is not needed left out, and with everything kept; errors instead where there are none."""
    found = []
    for simplify in (True, False):
        try:
            found.append(fo.steady_state(contact, cycle, friction, factor, simplify=simplify, **options))
        except fo.NoContinuation as error:
            found.append(error)
    return found


def assert_same(lean, full, tolerance):
    assert lean.outcome is full.outcome and (lean.open == full.open).all() and full.record.left_out == ()
    assert (lean.unproven == 0) == (full.unproven == 0)
    slip, work = 1.0 + np.abs(full.slip).max(), 1.0 + full.dissipation
    assert lean.slip == pytest.approx(full.slip, abs=tolerance * slip)
    assert lean.dissipation_per_node == pytest.approx(full.dissipation_per_node, abs=tolerance * work)
    assert lean.dissipation == pytest.approx(full.dissipation, abs=tolerance * work)
    assert lean.first_cycle == pytest.approx(full.first_cycle, rel=1e-9, abs=1e-12 * work)


def test_the_half_has_the_stiffness_of_its_motions():
    """Energy and reactions of symmetric motions, against the whole; the middle node's gap counts half, and it cannot slip."""
    rng = np.random.default_rng(0)
    for nodes in (2, 5, 6):
        contact = mirrored(rng, nodes, gap=True)
        half = halve(contact, np.ones(nodes))
        kept = half.system.nodes
        assert kept == (nodes + 1) // 2 and half.source.tolist() == [min(i, nodes - 1 - i) for i in range(nodes)]
        w = rng.normal(size=nodes)
        v, w = odd(rng, nodes), w + w[::-1]
        own = np.r_[v[:kept], w[:kept]]
        if nodes % 2:
            own[-1] /= 2
        assert half.odd(own[:kept]) == pytest.approx(v) and half.gaps(own[kept:]) == pytest.approx(w)
        assert half.gaps(half.system.gap) == pytest.approx(contact.gap)
        assert own @ half.system.S @ own == pytest.approx(np.r_[v, w] @ contact.S @ np.r_[v, w] / 2)
        q, p = np.split(contact.S @ np.r_[v, w], 2)
        assert half.system.S @ own == pytest.approx(np.r_[half.of(q), half.of(p)])
        assert half.odd(half.of(q)) == pytest.approx(q) and half.even(half.of(p)) == pytest.approx(p)


def test_a_corner_on_the_straight_segment_is_no_stop(punch, paper_cycle):
    contact = punch(16)
    sampled = fo.LoadCycle({"P": 1.0}, [{"sigma": s} for s in (-1.0, -0.3, -0.3, 0.2, 1.0, 1.0, 0.7, -0.1)])
    lean, full = both(contact, sampled, 0.7, 2.6)
    assert_same(lean, full, 1e-9)
    assert "corners: 5 of 8" in lean.record.left_out[-1] and full.dissipation > 0
    turning = fo.steady_state(contact, paper_cycle, 0.7, 2.6)
    assert lean.dissipation == pytest.approx(turning.dissipation, rel=1e-9)


def cycle_of(states):
    """A cycle with given states at its corners."""
    return cycles.Cycle(np.zeros(9), 0, [(u, u) for u in states], states[0], states[-1], 0.0, np.zeros(9))


def test_what_is_open_is_asked_where_the_load_turns(punch, paper_cycle):
    path = ExactPath(punch(8), paper_cycle, 0.7, 1.0)
    closed, opened = np.zeros(18), np.eye(18)[12]
    for stops, corners in ((range(3), [closed, opened, closed]), ([0, 2], [closed, closed])):
        run = cycles.Run(path, stops, [0, 2])
        assert not run._open(cycle_of(corners)).any()
    assert run._open(cycle_of([closed, opened])).tolist() == [node == 3 for node in range(9)]


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


def test_a_bend_is_not_straight():
    bent = fo.LoadCycle({}, [{"a": np.cos(t), "b": np.sin(t)} for t in np.linspace(0, 2 * np.pi, 1000)])
    assert turning_corners(bent) == list(range(1000))
