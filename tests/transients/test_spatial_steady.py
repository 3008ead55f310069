"""Transients and steady states in three dimensions.

They are compared with closed forms, the plane, and limits, and the error of the increments is
estimated.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.refused import refused
from helpers.spatial import cycle, random_contact, single
from studies.validation.closed_forms import single_node_dissipation

TO_AND_FRO = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])


@pytest.mark.parametrize("load_factor", [0.3, 0.7, 1.5])
def test_one_node_dissipates_as_in_closed_form(load_factor):
    known = single_node_dissipation(
        A=1.0, B=0.0, q0=0.0, p0=1.0, q1=1.0, p1=0.0, f=0.5, load_factor=load_factor
    )
    steady = fo.steady_state(single(), TO_AND_FRO, 0.5, load_factor, steps=2)
    assert steady.dissipation == pytest.approx(known, abs=1e-12) and steady.step_error < 1e-12
    path = fo.march(single(), TO_AND_FRO, 0.5, load_factor, cycles=3, steps=2)
    assert path.cycle_work[-1].sum() == pytest.approx(known, abs=1e-12)


def sphere(cells, shear, nu=0.0):
    """Work of friction per cycle of a sphere, over the work by Mindlin and Deresiewicz.

    The shear force is about `shear` times f P.
    """
    R, E, f = 5.0, 1.0, 0.5
    system = fo.ContactSystem(
        **fo.reference.half_space_contact(cells, half_length=1.12, R=R, E=E, nu=nu)
    )
    P, G = E / (1.5 * R * (1 - nu**2)), E / (2 * (1 + nu))
    shift = 3 * f * P / 16 * 2 * (2 - nu) / G * (1 - (1 - shear) ** (2 / 3))
    path = fo.march(
        system,
        fo.LoadCycle({"approach": 1 / R}, [{"x": 1.0}, {"x": -1.0}]),
        f,
        shift,
        cycles=2,
        steps=2,
    )
    at = int(np.flatnonzero(path.time == 1)[0])
    ball = fo.reference.SphereContact(float(path.p[at].sum()), R, E, nu, f)
    # Towards +x, as the load case says.
    assert ball.half_width == pytest.approx(1.0, rel=5e-3)
    assert path.slip[at, :, 0].sum() > 0
    return path.cycle_work[-1].sum() / ball.dissipation(abs(path.q[at, :, 0].sum()))


def scatter(sizes, shear):
    """Root mean square of the error over meshes of nearly the same size.

    The edges of the meshes lie differently on the circle.
    """
    return float(np.sqrt(np.mean([(sphere(cells, shear) - 1) ** 2 for cells in sizes])))


def test_a_sphere_dissipates_as_mindlin_and_deresiewicz_say():
    coarse, fine = scatter(range(8, 12), 0.8), scatter(range(16, 20), 0.8)
    assert fine < 0.5 * coarse < 0.05


def test_small_shear_goes_with_its_third_power():
    ball = fo.reference.SphereContact(1.0, 1.0, 1.0, 0.3, 0.5)
    ratio = [ball.dissipation(0.5 * x) / x**3 for x in (1e-6, 1e-3, 0.099999, 0.100001)]
    assert ratio[0] == pytest.approx(2 * 1.7 / (1 / 2.6) * 0.25 / (36 * ball.half_width), rel=1e-5)
    assert ratio[2] == pytest.approx(ratio[3], rel=1e-5)


def walking(spring=0.0):
    """Two nodes that slide together, against a spring.

    While one node is pressed it holds, and the other node is dragged on (a walk).
    """
    A = np.array([[1.0, -1.0], [-1.0, 1.0]]) + spring * np.eye(2)
    S = np.zeros((6, 6))
    S[:2, :2] = S[2:4, 2:4] = A
    S[4:, 4:] = np.eye(2)
    bonded = {
        "P": [0, 0, 0, 0, 1, 1],
        "left": [0, 0, 0, 0, 0.9, -0.9],
        "stretch": [1, -1, 0, 0, 0, 0],
    }
    corners = [
        {"left": 1.0},
        {"left": 1.0, "stretch": 0.8},
        {"left": -1.0, "stretch": 0.8},
        {"left": -1.0},
    ]
    walker = fo.ContactSystem(
        S, [[0, 0, 0], [1, 0, 0]], {name: np.array(r, dtype=float) for name, r in bonded.items()}
    )
    return walker, fo.LoadCycle({"P": 1.0}, corners), 0.4, 1.0


def test_a_free_contact_that_is_pushed_round_ratchets():
    steady = fo.steady_state(*walking(), steps=4)
    assert steady.outcome is fo.Outcome.RATCHETING and steady.dissipation > 0
    path = fo.march(*walking(), cycles=4, steps=4)
    ends = path.slip[np.isin(path.time, [4.0, 8.0, 12.0, 16.0])]
    assert np.ptp(np.diff(ends, axis=0), axis=0).max() < 1e-9
    assert np.abs(np.diff(ends, axis=0)).max() > 0.1


TURNING = fo.LoadCycle({"mean": 1.0}, [{"a": 0.1}, {"a": 0.1}], fixed=[{"b": 0.1}, {}])


@refused(
    (
        lambda: fo.guaranteed_limit(random_contact(np.random.default_rng(4), 3), TURNING, 0.5),
        "cycle: its fixed parts differ, and the contact is in space",
    ),
    (lambda: fo.steady_state(single(), cycle(), 0.5, 1.0, steps=0), "steps: 0"),
    (
        lambda: fo.march(single(), fo.LoadCycle({"X": 0.1}, [{"Y": 1.0}]), 0.5, 1.0),
        "mean: the mean load has no normal reactions",
    ),
)
def test_what_is_not_answered_is_refused_by_name_and_says_why(ask):
    ask()
