"""Results of many transients in space.

They are compared with the plane, closed forms of one node, and finite differences.
"""

from copy import copy

import numpy as np
import pytest

import frictopt as fo
from frictopt.study.ascent import _tangents, increment_map
from frictopt.study.starts import smooth_modes
from frictopt.transients.march import path_of
from helpers.paths import settled
from helpers.spatial import cycle, random_contact, single
from helpers.systems import CYCLE, FIRST_PAIR, system
from studies.validation.fuzz.embedded import embedded

pytestmark = pytest.mark.usefixtures("few_starts")

PAIR = system(*FIRST_PAIR)
SOLID, _ = embedded(PAIR, np.random.default_rng(13))


@pytest.mark.parametrize(("seed", "ratio"), [(0, 1.2), (1, 0.9), (2, 1.2)])
def test_the_derivative_of_a_cycle_of_increments_is_that_of_differences(seed, ratio):
    rng = np.random.default_rng(seed)
    contact = random_contact(rng, 4)
    load_factor = ratio * fo.shakedown_limit(contact, cycle(), 0.5).load_factor
    path = path_of(
        contact, cycle(), 0.5, load_factor, 0.3 * rng.normal(size=(4, 2)), steps=5
    ).start()
    state, path = settled(path)
    assert state.outcome is fo.Outcome.CYCLIC_SLIP and np.isinf(state.step_error)
    one = increment_map(path)
    assert one.locked.any() and not one.locked.all()
    for slip in np.eye(12)[:8]:
        ends = []
        for size in (1e-6, -1e-6):
            other = copy(path)
            u = path.state.u + size * slip
            other.state = path.state._replace(u=u, r=path.bonded + contact.S @ u)
            ends.append(other.cycle_on(1))
        u, work = (
            (getattr(ends[0], name) - getattr(ends[1], name)) / 2e-6 for name in ("u", "work")
        )
        assert one.derivative @ slip == pytest.approx(u[-1], abs=1e-7)
        assert one.work_gradient @ slip == pytest.approx(work.sum(), abs=1e-7)


def test_tangents_touch_the_bound_where_the_shear_points():
    q = np.array([[[3.0, 0.0], [4.0, 0.0]]])
    ways = np.array(_tangents(q))
    assert (ways * q).sum(axis=2).max(axis=0).tolist() == [[5.0, 0.0]]
    assert np.linalg.norm(ways, axis=2) == pytest.approx(np.ones((4, 1, 2)))
    assert ways.sum(axis=0) == pytest.approx(np.zeros((1, 2, 2)))


def test_a_node_that_is_assembled_slips_by_what_friction_lacks():
    """With unit stiffness, shear (3, 4) and bound 2 it slips against the shear by 5 - 2."""
    node = single(friction_bound=4.0)
    loads = fo.LoadCycle({"P": 1.0, "X": 3.0, "Y": 4.0}, [{"X": 1.0}, {"X": -1.0}])
    assert fo.starts.assembled_slip(node, loads, 0.5) == pytest.approx(
        -3.0 * np.array([[0.6, 0.8]]), abs=1e-5
    )
    assert fo.starts.assembled_slip(node, loads, 2.0) == pytest.approx(np.zeros((1, 2)))


def test_the_range_is_that_of_the_plane():
    """In the plane the exact path and increments give it. In space slips across the plane have no
    part in the least and the most work."""
    question = CYCLE, 0.6, 0.65
    # Of twelve increments the search makes five.
    ways = ((PAIR, {}), (PAIR, {"steps": 12}), (SOLID, {"steps": 6}))
    plane, many, space = (fo.dissipation_range(contact, *question, **how) for contact, how in ways)
    for found in (many, space):
        assert found.most == pytest.approx(plane.most, rel=0.03)
        assert found.least == plane.least == 0.0
        assert 0 < found.most_state.step_error < 0.1 and found.residual <= 1e-9
    assert (
        {state.steps for state in many.steady_states}
        == {12}
        == {many.least_state.steps, many.most_state.steps}
    )
    reached = fo.steady_state(SOLID, CYCLE, 0.6, 0.65, initial_slip=space.worst_start, steps=6)
    assert reached.dissipation == space.most and "local extreme" in set(space.to_frame()["end"])


def test_random_slips_are_smooth_and_rough_without_a_slide():
    grid = np.stack(
        np.meshgrid(np.linspace(0, 3, 12), np.linspace(-1, 1, 12), [1e-17]), axis=-1
    ).reshape(-1, 3)
    contact = fo.ContactSystem(np.eye(3 * 144), grid, {"P": np.ones(3 * 144)})
    starts = fo.starts.random_slips(contact, [0.1, 2.0], 3)
    assert len(starts) == 12 and smooth_modes(contact).shape == (144, 27)
    for start in starts:
        assert start.slip.shape == (144, 2)
        assert start.slip.mean(axis=0) == pytest.approx(np.zeros(2), abs=1e-12)
        assert np.sqrt((start.slip**2).mean()) == pytest.approx(float(start.name.split()[1]))
        field = start.slip.reshape(12, 12, 2)
        assert (np.abs(np.diff(field, axis=0)).mean() < 0.9 * np.abs(start.slip).mean()) == (
            start.family == "smooth"
        )


def test_no_cycle_in_space_slips_less_than_is_proven():
    """The states at the corners of cycles from random starts are compared with the weighted sum,
    and with the least sum of slips."""
    found = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        contact, loads = random_contact(rng, 3), cycle(2 + seed % 2)
        limit = fo.shakedown_limit(contact, loads, 0.5)
        for ratio in (1.01, 1.5):
            least = limit.least_slip(ratio * limit.load_factor)
            path = fo.march(
                contact,
                loads,
                0.5,
                least.load_factor,
                cycles=2,
                initial_slip=rng.normal(size=(3, 2)),
                steps=4,
            )
            last = slice(-4 * len(loads.corners) + 3, None, 4)
            slip, gap = path.slip[last], path.gap[last]
            assert least.of(slip, gap) >= least.bound * (1 - 1e-9) and least.residual <= 1e-9
            if not gap.any():
                apart = np.linalg.norm(slip[:, None] - slip[None], axis=-1).max(axis=(0, 1))
                assert least.weight @ apart >= least.bound and apart.sum() >= least.total > 0
                found += 1
    assert found > 6


def test_the_least_slip_is_that_of_the_plane():
    plane, space = (
        fo.shakedown_limit(contact, CYCLE, 0.6).least_slip(1.0) for contact in (PAIR, SOLID)
    )
    assert (space.bound, space.total) == pytest.approx((plane.bound, plane.total), rel=1e-7)
    assert space.weight == pytest.approx(plane.weight, rel=1e-6)
    table = space.to_frame()
    named = [f"g{way} at {name}" for name in CYCLE.corner_names for way in (1, 2)]
    assert table.columns.tolist() == [*"node x y z weight alone".split(), *named]
    assert table["alone"].to_numpy() == pytest.approx(
        plane.to_frame()["alone"].to_numpy(), rel=1e-6
    )
