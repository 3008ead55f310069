"""When cycles prove a steady state.

Maps of one slip whose limit is known take the place of a contact; other tests check the energy.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from frictopt.base import PERIODIC
from frictopt.transients.cycles import Run
from frictopt.transients.exact import ExactPath
from frictopt.transients.extrapolation import AffineLimit
from helpers.return_maps import Mapped, settled
from helpers.systems import unit_nodes


def test_slip_that_seems_to_repeat_and_stops_while_its_work_is_made_sure():
    """Its changes are below the tolerance but no rounding. The confirmation finds that the work
    does not repeat, and then is zero."""
    path = Mapped(lambda x: x / 2, PERIODIC)
    works = iter([4.0, 2.0, 3.0, 5.0, 0.0])
    cycle_on = path.cycle_on
    path.cycle_on = lambda count: replace(cycle_on(count), work=np.array([next(works)]))
    assert settled(path, 50)[0] is fo.Outcome.SHAKEDOWN and not list(works)


def test_a_slow_affine_map_is_extrapolated():
    outcome, limit, run = settled(Mapped(lambda x: 3.0 + 0.999 * (x - 3.0), 10.0), 20)
    assert outcome is fo.Outcome.CYCLIC_SLIP
    assert limit == pytest.approx(3.0, abs=1e-9)
    assert run.cycles < 12


def test_cycles_lead_to_their_limit_where_no_state_stands_beside_it():
    """Then nothing shows that the map is affine."""

    class Alone(Mapped):
        def at(self, place):
            return super().at(place) if abs(place[0] - 3.0) < 1e-12 else None

    outcome, limit, run = settled(Alone(lambda x: 3.0 + 0.7 * (x - 3.0), 10.0), 100)
    assert outcome is fo.Outcome.CYCLIC_SLIP
    assert limit == pytest.approx(3.0, abs=1e-8)
    assert not run.extrapolated


def test_the_limit_of_other_events_is_not_that_of_the_cycles():
    """Far out the map leads to 0, where it has a fixed point. On the way it bends, and the cycles
    end at 0.6."""

    def bent(x):
        return 0.8 * x if x > 1 else 0.8 + 0.5 * (x - 1) if x > 0.1 else 3.5 * x

    _, limit, _ = settled(Mapped(bent, 50.0), 100)
    assert limit == pytest.approx(0.6, abs=1e-9)


def test_events_next_to_the_limit_of_the_cycles_are_seen():
    """The cycles lead to 0 and would stay there. But within less than a millionth of 0 other states
    come back, too."""
    _, limit, _ = settled(Mapped(lambda x: 0.25 * x if x > 1.6e-6 else min(x, 4e-7), 50.0), 100)
    assert limit == pytest.approx(4e-7, rel=1e-3)


def test_events_that_lie_ahead_of_the_last_cycles_are_seen():
    """Events that the last cycles have not reached yet are found.

    Two slips decay, one slowly and one fast. Once the slow slip is more than three times the fast
    slip, a third node is dragged along and stays.
    """

    def dragging(slow, fast, dragged):
        return 0.9 * slow, 0.5 * fast, dragged + 0.1 * max(slow - 3 * fast, 0.0)

    slow, fast, expected = 1.0, 8.0, 0.0
    for _ in range(400):
        slow, fast, expected = dragging(slow, fast, expected)
    _, limit, run = settled(Mapped(dragging, [1.0, 8.0, 0.0]), 100)
    assert expected > 0.1
    assert limit == pytest.approx([0.0, 0.0, expected], abs=1e-9)
    assert run.cycles < 60


TURN = 0.97 * np.array([[np.cos(0.0873), -np.sin(0.0873)], [np.sin(0.0873), np.cos(0.0873)]])


def turning(x, y, dragged):
    """By 5 degrees a cycle; a third node is dragged along from 63 degrees on."""
    return *(TURN @ (x, y)), dragged + 0.1 * max(y - 2 * x, 0.0)


def changing(x, y, dragged):
    """A map whose first slip changes its sign in each cycle.

    A third node is dragged along once this slip is less than half of the other slip.
    """
    return -0.9 * x, 0.95 * y, dragged + 0.1 * max(min(-x, y + 2 * x), 0.0)


@pytest.mark.parametrize(
    ("cycle_map", "start"), [(turning, (1.0, 0.0, 0.0)), (changing, (1.0, 1.0, 0.0))]
)
def test_states_that_turn_round_their_limit_or_change_sides_may_meet_other_events(cycle_map, start):
    expected = start
    for _ in range(2000):
        expected = cycle_map(*expected)
    assert expected[2] > 0.01
    _, limit, _ = settled(Mapped(cycle_map, start), 2000)
    assert limit == pytest.approx(expected, abs=1e-8)


def test_a_limit_that_does_not_come_back_is_none():
    """Closer to 0 than 1e-6 other events lead away from 0, by much less than the error of the map
    elsewhere."""

    def leading(x):
        return 0.8 * x if x > 1e-6 else 4e-9 + 0.796 * x

    _, limit, _ = settled(Mapped(leading, 50.0), 300)
    assert limit == pytest.approx(4e-9 / 0.204, abs=1e-9)


@pytest.mark.parametrize("end", [1e-7, 0.0])
def test_a_transient_does_not_jump_to_a_limit_that_does_not_come_back(end):
    """At 0, the limit of the outer map, everything slides away to -3. On the way to 0 the cycles
    end at 1e-7, or their changes fall below the tolerance."""

    def leading(x):
        return 0.8 * x if x > max(10 * end, 1e-12) else end + 0.5 * (x - end) if x > 1e-12 else -3.0

    _, limit, _ = settled(Mapped(leading, 50.0), 300)
    assert limit == pytest.approx(end, abs=1e-9)


@pytest.mark.parametrize(
    "turned", [np.array([[0.0, -0.9], [0.9, 0.0]]), np.diag([-0.9, 0.5]), np.diag([0.9, 0.89])]
)
def test_affine_maps_that_turn_or_have_rates_next_to_each_other(turned):
    _, limit, _ = settled(Mapped(lambda *x: turned @ x + (1.0, 2.0), [30.0, 40.0]), 300)
    assert limit == pytest.approx(np.linalg.solve(np.eye(2) - turned, (1.0, 2.0)), abs=2e-9)


def test_a_safe_slip_beyond_the_one_where_cycles_come_to_rest_is_not_their_limit():
    """Slips up to 0.5 are safe, so that each of them is a fixed point. Cycles from outside end at
    the first of them."""

    def resting(x):
        return 0.8 * x if x > 1 else 0.5 + 0.6 * (x - 0.5) if x > 0.5 else x

    outcome, limit, _ = settled(Mapped(resting, 50.0, loads=(0.5, 0.0)), 200)
    assert outcome is fo.Outcome.SHAKEDOWN and limit == pytest.approx(0.5, abs=1e-8)


def test_a_fixed_point_that_cycles_leave_is_not_their_limit():
    def leaving(x):
        return 1.2 * x if x < 1 else 1.2 + 0.5 * (x - 1)

    _, limit, _ = settled(Mapped(leaving, 1e-3), 100)
    assert limit == pytest.approx(1.4, abs=1e-9)


def test_small_changes_that_hardly_shrink_are_no_end():
    """Changes of 1e-10 a cycle that shrink by 1e-5 of themselves sum up to 1e-5. Here no two cycles
    have the same events."""
    run = Run(Mapped(lambda x: (1 - 1e-5) * x, 1e-5, events=lambda x: hash(x)), 50)
    with pytest.raises(fo.NoContinuation, match="of most_cycles = 50"):
        run.settled()
    assert run.last[-1].change < 1.1e-10


@pytest.mark.parametrize("lost", ["half", "little", "exchanged"])
def test_work_that_is_lost_is_an_error(punch, paper_cycle, monkeypatch, lost):
    """The balance of energy sees work of friction that nobody did, and work that is not counted.

    It also sees that one node takes back the excess work of another node.
    """
    contact, friction = punch(16), 0.5
    factor = 1.3 * fo.shakedown_limit(contact, paper_cycle, friction).load_factor
    truth = fo.steady_state(contact, paper_cycle, friction, factor)
    assert truth.dissipation > 0 and truth.residual < 1e-12
    follow_to, excess = ExactPath.follow_to, 1e-3 * truth.dissipation

    def wrong(path, bonded, where):
        follow_to(path, bonded, where)
        if lost == "exchanged":
            path.state.work[[0, 8]] += (excess, -excess)
        else:
            path.state.work[:] *= {"half": 0.5, "little": 1 + 1e-5}[lost]

    monkeypatch.setattr(ExactPath, "follow_to", wrong)
    for run in (fo.steady_state, fo.march):
        with pytest.raises(fo.SolverError, match="energy"):
            run(contact, paper_cycle, friction, factor)


@pytest.mark.parametrize("other", ["rubs", "slides", "opens"])
@pytest.mark.parametrize("hard", [1.0, 1e2, 1e4, 1e5, 1e6, 1e8, 1e10])
def test_slip_that_is_small_beside_the_largest_force_is_no_shakedown(hard, other):
    """One node slips to and fro by q = +-f p at p = 1; from -f at p = 1 + hard it needs no more.
    The result does not depend on the other node."""
    friction = np.array([0.5, 0.0 if other == "slides" else 0.5])
    bonded = {
        "P": ([0.0, 0.0], [1.0, 1.0]),
        "X": ([1.0, 0.0], [0.0, 0.0]),
        "H": ([0.0, 0.0], [1.0, 0.0]),
        "N": ([0.0, 0.0], [0.0, -2.0]),
    }
    contact = unit_nodes(bonded)
    cycle = fo.LoadCycle(
        {"P": 1.0}, [{"X": 1.0}, {"X": -1.0}, {"H": hard, "N": 1.0 if other == "opens" else 0.0}]
    )
    path = fo.march(contact, cycle, friction, 1.0, cycles=4)
    try:
        steady = fo.steady_state(contact, cycle, friction, 1.0)
    except fo.NoContinuation as error:
        assert hard >= 1e8 and "more similar size" in str(error)
    else:
        assert steady.outcome is fo.Outcome.CYCLIC_SLIP
        assert steady.dissipation == pytest.approx(path.cycle_work[-1].sum(), rel=1e-6)
        assert steady.dissipation > 1.0
    assert fo.steady_state(contact, cycle, friction, 0.2).outcome is fo.Outcome.SHAKEDOWN


@pytest.mark.parametrize(
    ("soft", "force", "corner"), [(1.0, 1e-5, 1.0), (1e-3, 1e-6, 1.0), (1e6, 1e-3, 1e3)]
)
def test_slip_of_a_node_with_much_less_pressure_than_the_others_is_no_shakedown(
    soft, force, corner
):
    """Node 0 slips to and fro by q = +-f p at p = force. Node 1, without friction, opens under the
    corner that presses node 2 hard."""
    friction, k = np.array([0.5, 0.0, 0.5]), np.diag([soft, 1.0, 1.0])
    bonded = {
        "P": ([0.0, 0.0, 0.0], [force, 1.0, 1.0]),
        "X": ([force, 0.0, 0.0], [0.0, -2.0, corner]),
    }
    contact = fo.ContactSystem.from_blocks(k, np.zeros((3, 3)), k, [0.0, 1.0, 2.0], bonded)
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": 0.0}, {"X": -0.9}])
    # 2 f p times the stroke (range of q less 2 f p) / stiffness
    work = 2 * 0.5 * force * (0.9 + 1.0 - 1.0) * force / soft
    assert fo.march(contact, cycle, friction, 1.0, cycles=3).cycle_work[-1, 0] == pytest.approx(
        work, rel=1e-6
    )
    steady = fo.steady_state(contact, cycle, friction, 1.0)
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP
    assert steady.dissipation_per_node == pytest.approx([work, 0.0, 0.0], rel=1e-6)


def test_slip_under_a_load_rate_that_is_tiny_beside_that_of_another_node_is_not_missed():
    """The corner that presses node 1 by 1e12 also drives node 0 from one friction bound to the
    other."""
    bonded = {
        "P": ([0.0, 0.0], [1.0, 1.0]),
        "X": ([1.0, 0.0], [0.0, 0.0]),
        "H": ([0.0, 0.0], [0.0, 1e12]),
    }
    contact = unit_nodes(bonded)
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0, "H": 1.0}, {"X": -1.0}])
    path = fo.march(contact, cycle, 0.5, 1.0, cycles=3)
    assert path.cycle_work[-1] == pytest.approx([1.0, 0.0], rel=1e-6)


@pytest.fixture
def without_extrapolation(monkeypatch):
    monkeypatch.setattr(AffineLimit, "find", lambda *_: None)


@pytest.mark.parametrize(("ratio", "first"), [(0.5, 1e3), (0.9, 1.0), (0.99, 1e-6)])
@pytest.mark.usefixtures("without_extrapolation")
def test_the_cycles_left_follow_from_the_decay_of_their_changes(ratio, first):
    """The estimated number of remaining cycles follows from the decay of their changes.

    Changes that form a geometric sequence fall to the tolerance after a number of cycles given by a
    logarithm. Without extrapolation the run ends when the estimate has counted down.
    """
    path = Mapped(lambda x: ratio * x, first)
    run, changes_and_texts = Run(path, 5000), []
    while run.advance() is None and len(changes_and_texts) < 60:
        changes_and_texts.append((run.last[-1].change if run.last else np.nan, run.progress()))
    assert changes_and_texts[0][1] == "" and "left" not in changes_and_texts[2][1]
    for change, text in changes_and_texts[4:]:
        left = np.log(PERIODIC / change) / np.log(ratio)
        assert f"slip changes by {change:.1e} a cycle, {ratio:g} times the change before: " in text
        assert abs(int(re.search(r"about (\d+) cycles left", text)[1]) - left) <= 1


@pytest.mark.usefixtures("without_extrapolation")
def test_a_drift_has_no_end_to_count_down_to():
    path = Mapped(lambda x: x + 0.25, 0.0)
    path.system.units = "N, mm"
    run = Run(path, 50)
    for _ in range(6):
        run.advance()
    text = run.progress()
    assert (
        text == "slip changes by 2.5e-01 mm a cycle, as much as before: it drifts, or decays slowly"
    )
