"""The load factor up to which every or some state of rest has an allowable fatigue parameter.

It is compared with closed forms, with all vertices of the safe slips at many load factors, and with
linear programs of scipy.
"""

import numpy as np
import pytest
from scipy.optimize import linprog

import frictopt as fo
from helpers.cases import few
from helpers.refused import refused
from helpers.stresses import TO_FRO, TURNING, held_node, parameters, random_contact, vertices
from helpers.systems import CYCLE, stresses_of, system


def test_the_first_crossing_counts_if_the_worst_falls_again():
    """The largest value is `load factor * (2 - 1.5 load factor)`, .667 at most and .5 at the end.

    So at .6 every state of rest is below again near the limit, which a bisection would find.
    """
    limit = fo.fatigue_limit(held_node(), TO_FRO, 0.5, 0.6)
    first = (2 - np.sqrt(4 - 6 * 0.6)) / 3
    assert limit.reached and not limit.proven
    assert limit.load_factor == pytest.approx(first, rel=1e-7)
    assert limit.slip == pytest.approx([1 - first], rel=1e-7)
    band = fo.fatigue_band(held_node(), TO_FRO, 0.5, 0.99)
    assert band.most < 0.6


def test_a_value_that_no_state_of_rest_has_leaves_the_shakedown_limit():
    limit = fo.fatigue_limit(held_node(), TO_FRO, 0.5, 0.7)
    assert not limit.reached and limit.load_factor == pytest.approx(1.0, rel=1e-9)
    assert "above this load factor there is no state of rest" in limit.reason


def test_a_slip_bound_raises_the_limit():
    """With slips up to .05 the largest value is `load factor * (.1 + load factor / 2)`."""
    limit = fo.fatigue_limit(held_node(), TO_FRO, 0.5, 0.1, slip_bound=0.05)
    assert limit.load_factor == pytest.approx(-0.1 + np.sqrt(0.01 + 0.2), rel=1e-7)


def test_the_best_state_of_two_opposed_points_in_closed_form():
    """Stresses 2 v and .8 - 2 v, and half of the load: the best slip is .2, at all load factors."""
    stresses = held_node(opposed=0.8)
    limit = fo.fatigue_limit(stresses, TO_FRO, 0.5, 0.4, every=False)
    assert limit.load_factor == pytest.approx((-0.8 + np.sqrt(0.64 + 3.2)) / 2, rel=1e-7)
    assert limit.slip == pytest.approx([0.2], rel=1e-6)
    assert limit.proven and limit.load_factor <= limit.bound <= limit.load_factor * (1 + 1e-6)


TURNS = np.pi * np.arange(720) / 720
NORMALS = np.column_stack([np.cos(TURNS), np.sin(TURNS), 0 * TURNS])


def largest(name, stress, strain):
    """A parameter with the weight .3, of one point over states (K, 3, 3), on planes (x, y)."""
    across = [np.einsum("pi,kij,pj->kp", NORMALS, tensors, NORMALS) for tensors in (stress, strain)]
    tension = across[0].max(axis=0)
    if name == "SWT":
        return max(0.0, (tension * np.ptp(across[1], axis=0) / 2).max())
    of_shear = stress if name == "Findley" else 2 * strain
    vectors = np.einsum("kij,pj->kpi", of_shear, NORMALS)
    along = vectors - np.einsum("kpi,pi->kp", vectors, NORMALS)[..., None] * NORMALS
    shear = np.linalg.norm(along[:, None] - along[None], axis=-1).max(axis=(0, 1)) / 2
    if name == "Findley":
        return (shear + 0.3 * tension).max()
    return max(0.0, (shear * (1 + 0.3 * tension)).max())


@pytest.mark.parametrize("seed", few(range(12), least=3, share=6))
def test_no_vertex_below_the_limit_has_more_and_one_above_has(seed):
    name = ("SWT", "Findley", "Fatemi_Socie")[seed % 3]
    stresses = random_contact(seed)
    shakedown = fo.shakedown_limit(stresses.system, TURNING, 0.5).load_factor

    def worst(load_factor):
        loads = TURNING.at(load_factor)
        values = []
        for slip in vertices(stresses.system, TURNING, 0.5, load_factor):
            states = np.array([stresses.tensors(corner, slip) for corner in loads])
            values += [largest(name, *states[:, :, point].swapaxes(0, 1)) for point in range(3)]
        return max(values)

    allowable = max(1.5 * worst(0.0), 0.9 * worst(0.5 * shakedown))
    limit = fo.fatigue_limit(stresses, TURNING, 0.5, allowable, name, planes=12)
    assert limit.load_factor > 0
    for share in (0.2, 0.5, 0.8, 0.95, 1 - 1e-6):
        assert worst(share * limit.load_factor) <= allowable * (1 + 1e-9)
    if limit.reached:
        assert worst(limit.load_factor) == pytest.approx(allowable, rel=1e-4)
    else:
        assert limit.load_factor == pytest.approx(shakedown, rel=1e-9)


@pytest.mark.parametrize("seed", few(range(12)))
def test_both_limits_of_crossland_are_linear_programs_in_load_factor_and_slip(seed):
    """The parameter at a point is `a + load factor * b + c @ slip`, and so are the rows of rest."""
    stresses = random_contact(seed)
    contact = stresses.system
    unit = np.eye(3)
    values = [
        parameters(stresses, TURNING, load_factor, slip)["Crossland"].to_numpy()
        for load_factor, slip in ((0.0, 0 * unit[0]), (1.0, 0 * unit[0]), *((0.0, v) for v in unit))
    ]
    start, by_load = values[0], values[1] - values[0]
    by_slip = np.array(values[2:]).T - start[:, None]
    rows, right = [], []
    mean = contact.reaction({"P": 1.0})
    for loads in TURNING.at(1.0):
        q, p = (end - at_mean for end, at_mean in zip(contact.reaction(loads), mean, strict=True))
        for sign in (1, -1):
            slip = sign * contact.A - 0.5 * contact.B
            rows.append(np.column_stack([sign * q - 0.5 * p, slip]))
            right.append(0.5 * mean[1] - sign * mean[0])
    rows, right = np.vstack(rows), np.concatenate(right)
    points = np.column_stack([by_load, by_slip])
    bounds = [(0, None), *([(None, None)] * 3)]
    allowable = 1.2 * max(start.max(), 0.1)
    firsts = [
        linprog(
            [1, 0, 0, 0], np.vstack([rows, -point]), np.r_[right, at - allowable], bounds=bounds
        )
        for point, at in zip(points, start, strict=True)
    ]
    every = fo.fatigue_limit(stresses, TURNING, 0.5, allowable, "Crossland")
    first = min(program.x[0] for program in firsts if program.status == 0)
    assert every.proven and every.load_factor == pytest.approx(first, rel=1e-7, abs=1e-9)
    last = linprog(
        [-1, 0, 0, 0], np.vstack([rows, points]), np.r_[right, allowable - start], bounds=bounds
    )
    some = fo.fatigue_limit(stresses, TURNING, 0.5, allowable, "Crossland", every=False)
    assert some.load_factor == pytest.approx(last.x[0], rel=1e-6)
    assert some.bound >= last.x[0] * (1 - 1e-9)


def test_the_band_of_a_model_at_its_limits_has_the_allowable_value():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    stresses = model.stress_map(points=[(0.0, -0.4), (0.9, -0.4)], body="block")
    at_load = fo.fatigue_band(stresses, cycle, 0.7, 0.6, "Findley")
    allowable = float(np.sqrt(at_load.least * at_load.most))
    every, some = (
        fo.fatigue_limit(stresses, cycle, 0.7, allowable, "Findley", every=which)
        for which in (True, False)
    )
    assert every.load_factor < 0.6 < some.load_factor
    for limit, end in ((every, "most"), (some, "least")):
        band = fo.fatigue_band(stresses, cycle, 0.7, limit.load_factor, "Findley")
        assert getattr(band, end) == pytest.approx(allowable, rel=1e-6)
        assert band.at(limit.slip).max() == pytest.approx(allowable, rel=1e-6)


@pytest.mark.filterwarnings("ignore:load_factor")
def test_a_mean_load_that_exceeds_the_value_leaves_no_load_factor():
    for every, word in ((True, "some"), (False, "every")):
        limit = fo.fatigue_limit(
            held_node(opposed=0.8), TO_FRO, 0.5, 0.01, "Crossland", every=every
        )
        assert limit.load_factor == 0.0 and limit.reached
        assert f"under the mean load alone, {word} state of rest" in limit.reason


def wedging():
    """Two nodes apart: the first one wedges, the second one has a shakedown limit."""
    return stresses_of(system(np.eye(2), np.diag([2.5, 0.0]), 0.0, 1.0, 1.0, 0.0))


RISING = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": 2.0}])
FIXED = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}], fixed=[{}, {"Q": 0.1}])


@refused(
    (lambda: fo.fatigue_limit(held_node(), TO_FRO, 0.5, 0.0), "allowable: 0.0"),
    (lambda: fo.fatigue_limit(held_node(), FIXED, 0.5, 0.1), "cycle: its fixed parts differ"),
    (lambda: fo.fatigue_limit(held_node(), RISING, 0.5, 0.1, every=False), "every: False, but"),
    (lambda: fo.fatigue_limit(wedging(), CYCLE, 0.5, 0.1), "friction: it wedges"),
    (
        lambda: fo.fatigue_limit(held_node(), fo.LoadCycle({"P": 1.0}, [{"P": 1.0}]), 0.5, 0.1),
        "cycle: its shakedown limit is inf, not finite",
    ),
)
def test_bad_limits_are_refused(call):
    call()
