import numpy as np
import pytest

import frictopt as fo
from helpers.systems import CYCLE, system, unit_nodes


def test_the_exact_path_as_a_trajectory(punch, paper_cycle):
    contact = punch(16)
    start = 0.3 * np.sin(3 * contact.x)
    path = fo.march(contact, paper_cycle, 0.7, 2.2, initial_slip=start, cycles=6)
    assert path.slip.shape[1] == 17
    assert path.time[0] == 0.0
    assert path.time[-1] == 12.0
    assert (np.diff(path.time) >= 0).all()
    assert dict(zip(contact.bonded, path.amplitudes[0], strict=True)) == {
        "P": 1.0,
        "Q": 0.0,
        "sigma": 0.0,
    }
    assert path.to_frame()["time"].min() == 0.0
    # The state under the mean load: from the start, no node has slipped back beyond its bound.
    stuck = np.abs(path.q[0]) < 0.7 * path.p[0] * (1 - 1e-9)
    assert stuck.any() and np.allclose(path.slip[0][stuck], start[stuck], rtol=0, atol=1e-12)
    assert path.residual < 1e-9 and np.abs(path.energy_error).max() < 1e-10
    assert path.cycle_work.shape == (6, 17) and (path.cycle_work >= 0).all()
    steady = fo.steady_state(contact, paper_cycle, 0.7, 2.2, initial_slip=start)
    assert path.cycle_work[-1].sum() == pytest.approx(steady.dissipation, rel=1e-6)
    q, p = contact.reaction({"P": 1.0, "sigma": 2.2})
    assert np.allclose(path.bonded_q[-1], q) and np.allclose(path.bonded_p[-1], p)


def test_the_frame_has_one_row_for_each_state_and_node(punch, paper_cycle):
    path = fo.march(punch(16), paper_cycle, 0.7, 2.2, cycles=1)
    table = path.to_frame()
    assert list(table.columns) == [
        "state",
        "time",
        "node",
        "contact",
        "x",
        "slip",
        "gap",
        "q",
        "p",
        "status",
        "work",
    ]
    assert len(table) == path.slip.size
    last = table[table.state == table.state.max()]
    assert np.array_equal(last.slip, path.slip[-1]) and np.array_equal(last.x, punch(16).x)


def test_one_node_through_a_cycle_by_hand():
    """With A = 1, B = 0 and f p = 1/2 it slips at |q^w| = 1/2 while the load grows, then sticks,
    and slips back after q has changed by 1."""
    contact = system(1.0, 0.0, 0.0, 1.0, 1.0, 0.0)
    path = fo.march(contact, CYCLE, 0.5, 1.0, cycles=2)
    at = [np.flatnonzero(path.time == k)[-1] for k in range(5)]
    assert np.allclose(path.slip[at, 0], [0.0, 0.5, -0.5, 0.5, -0.5])
    assert np.allclose(path.q[at, 0], [0.0, -0.5, 0.5, -0.5, 0.5])
    assert np.allclose(path.cycle_work.sum(axis=1), [0.25 + 0.5, 1.0])
    slipping = path.time[np.flatnonzero(path.status[:, 0] == -1)]
    # Backward slip starts half-way from corner 1 to corner 2.
    assert slipping.min() == pytest.approx(1.5)


@pytest.mark.parametrize("steps", [None, 1, 3])
def test_a_node_that_slips_only_while_it_is_open_does_no_work(steps):
    """Under pressure alone it sticks. The gap drags it sideways through B while it touches nothing,
    by B w = -A v, until it closes again."""
    contact = fo.ContactSystem.from_blocks([[1.0]], [[0.3]], [[1.0]], [0.0], {"P": ([0.0], [1.0])})
    path = fo.march(
        contact, fo.LoadCycle({"P": 1.0}, [{"P": -2.0}, {}]), 0.5, 1.0, cycles=2, steps=steps
    )
    assert path.gap.max() == pytest.approx(1 / (1 - 0.3**2))
    assert path.slip.min() == pytest.approx(-0.3 / (1 - 0.3**2))
    assert not path.work.any()


def test_work_of_a_node_that_bears_a_billionth_of_the_mean_load_counts():
    """Node 0 slides by q = 0.7 at f p = 0.5 and then sticks; node 1 bears 1e9 times as much and
    does nothing else."""
    bonded = {"P": ([0.0, 0.0], [1.0, 4e9]), "X": ([0.7, 0.0], [0.0, 0.0])}
    contact = unit_nodes(bonded)
    path = fo.march(
        contact, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}]), 0.5, 1.0, cycles=2, steps=1
    )
    assert path.cycle_work[-1] == pytest.approx([2 * 0.5 * 0.4, 0.0], rel=1e-6)
