"""Contacts in three dimensions: what they accept, their files, the referee, the onset, and the questions that they refuse."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.contact.coulomb import reach
from spatial import cycle, single

NODE = single()


def test_a_file_tells_the_plane_from_space(tmp_path):
    NODE.save(tmp_path / "space.npz")
    fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0])}).save(tmp_path / "plane.npz")
    assert [fo.ContactSystem.load(tmp_path / f"{name}.npz").tangents for name in ("plane", "space")] == [1, 2]
    (tmp_path / "space.npz").write_bytes((tmp_path / "space.npz").read_bytes()[:-40])
    with pytest.raises(fo.ModelError, match="not a contact system"):
        fo.ContactSystem.load(tmp_path / "space.npz")


STATE = {"v": [[-0.3, 0.0]], "w": [0.0], "q": [[0.5, 0.0]], "p": [1.0]}


@pytest.mark.parametrize(
    ("line", "size", "change"),
    [
        ("equilibrium", 0.1, {"v": [[-0.2, 0.0]]}),
        ("bound", 0.3, {"v": [[0.0, 0.0]], "q": [[0.8, 0.0]]}),
        ("direction", 0.3, {"v": [[-0.3, 0.0]], "previous_slip": [[-0.6, 0.0]]}),  # it slips along +x, and friction pushes it on
        ("direction", 0.1, {"previous_slip": [[-0.3, 0.1]]}),  # friction on its bound, but across the slip
        ("contact", 0.2, {"w": [-0.2], "p": [0.8]}),
    ],
)
def test_the_referee_sees_each_violation(line, size, change):
    bonded = NODE.reaction({"P": 1.0, "X": 0.8})
    assert fo.reference.referee(NODE, bonded, 0.5, **STATE, previous_slip=[[0.0, 0.0]]).residual < 1e-15
    verdict = fo.reference.referee(NODE, bonded, 0.5, **({"previous_slip": [[0.0, 0.0]]} | STATE | change))
    assert getattr(verdict, line) == pytest.approx(size)


@pytest.mark.parametrize(("place", "step", "across", "allowed"), [(1e3, 1e-9, 0.0, 1e-12), (1.0, 1e-8, 2e-15, 3e-15), (0.0, 1e-5, 1e-12, 1.1e-12)])
def test_a_small_slip_is_not_blamed_for_rounding_across_it(place, step, across, allowed):
    before = place * (1 + np.pi / 10)
    v = before + np.array([[0.6 * step - 0.8 * across, 0.8 * step + 0.6 * across]])
    q = np.array([[-0.3, -0.4]])
    verdict = fo.reference.referee(NODE, (q - v, [1.0]), 0.5, v=v, w=[0.0], q=q, p=[1.0], previous_slip=[[before, before]], force_scale=1.0)
    assert verdict.direction < allowed and verdict.bound < 1e-15


@pytest.mark.parametrize("step", [1e-8, 1e-3, 1.0, 1e3])
@pytest.mark.parametrize("angle", [1e-3, 1.0, 2.0, 3.1])
def test_slip_in_a_wrong_direction_counts_by_what_mends_it(step, angle):
    """The state is mended by no slip, by turning q, or by turning the slip; the last two cost the same angle."""
    slip = step * np.array([np.cos(angle), np.sin(angle)])
    q = np.array([[-0.5, 0.0]])
    verdict = fo.reference.referee(NODE, (q - slip, [1.0]), 0.5, v=[slip], w=[0.0], q=q, p=[1.0], previous_slip=[[0.0, 0.0]], force_scale=1.0)
    turned, across = 2 * 0.5 * np.sin(angle / 2), step * np.sin(min(angle, np.pi / 2))
    assert verdict.direction == pytest.approx(min(step, turned, across), rel=1e-6)


def test_onset_of_a_mean_load_beyond_the_circle_is_zero():
    first = fo.onset(NODE, fo.LoadCycle({"P": 1.0, "X": 0.6}, [{"Y": 1.0}]), 0.5)
    assert first.slip.load_factor == 0.0 and first.mean_slips == (0,)


WALKING = fo.LoadCycle({"P": 1.0}, [{"X": 0.1}, {"X": 0.1}], fixed=[{"Y": 0.1}, {}])


@pytest.mark.parametrize(
    ("ask", "why"),
    [
        (lambda: fo.guaranteed_limit(NODE, WALKING, 0.5), "cycle: a part of it is fixed, of a contact in space"),
        (lambda: fo.march(NODE, cycle(), 0.5, 1.0, engine="path"), "engine: 'path'.*the friction circle is curved"),
        (lambda: fo.steady_state(NODE, cycle(), 0.5, 1.0, steps=0), "steps: 0"),
        (lambda: fo.march(NODE, cycle(), 0.5, 1.0, engine="milp"), "engine: 'milp'.*the friction circle is curved"),
        (lambda: fo.march(NODE, fo.LoadCycle({"X": 0.1}, [{"Y": 1.0}]), 0.5, 1.0), "mean: the mean load has no normal reactions"),
    ],
)
def test_what_is_not_answered_is_refused_by_name_and_says_why(ask, why):
    with pytest.raises(fo.ModelError, match=why):
        ask()


@pytest.mark.parametrize(
    ("q0", "g0", "q1", "g1", "largest"),
    [
        (0.2, 1.0, 0.5, -1.0, 0.8 / 1.5),  # the circle shrinks faster than the shear grows
        (0.0, 1.0, 0.5, 0.0, 2.0),
        (0.5, 1.0, -0.5, 0.0, 3.0),
        (0.5, 1.0, -0.5, 0.2, 5.0),
        (0.5, 1.0, 0.3, 0.3, np.inf),
        (1.0, 1.0, 0.5, -0.5, 0.0),
        (1.0, 1.0, -0.5, 0.0, 4.0),
        (0.0, 2.0, 0.0, -4.0, 0.5),
    ],
)
def test_how_far_a_circle_holds(q0, g0, q1, g1, largest):
    turn = np.array([0.6, 0.8])
    assert reach(q0 * turn, np.array(g0), q1 * turn, np.array(g1)) == pytest.approx(largest, abs=1e-12)
