"""The state into which a contact wears.

It is compared with closed forms, simulated wear, and the limit of the worn contact.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.worn import F, cylinder, on_edges, sphere, sphere_of_rings

CONTACT = fo.reference.LineContact(P=1.0, R=1.0, E_star=4 / np.pi, f=F)


def worn_pressure(x, Q0):
    """Pressure within the stick zone of a worn contact.

    It is the pressure by Hertz under `P - |Q0| / f`, and the pressure of a flat punch under the
    rest (Ciavarella 1998, Popov 2014).
    """
    root = np.sqrt(CONTACT.stick_half_width(Q0) ** 2 - x**2)
    return CONTACT.E_star / (2 * CONTACT.R) * root + Q0 / CONTACT.f / (np.pi * root)


@pytest.mark.parametrize(
    ("share", "depth", "place", "reach", "volume"),
    [
        (0.2, 0.023286795, 0.948683298, 1.055433428, 0.005206981),
        (0.5, 0.112733123, 0.866025404, 1.169185932, 0.072625190),
        (0.9, 0.499558852, 0.741619849, 1.516744044, 0.841107217),
    ],
)
def test_the_closed_form_of_the_cylinder_has_the_tabled_values(share, depth, place, reach, volume):
    x = np.linspace(0.0, 1.6, 1_600_001)
    h = CONTACT.worn_depth(x, share * F)
    assert h.max() == pytest.approx(depth, rel=1e-8)
    assert x[h.argmax()] == pytest.approx(place, abs=2e-4)
    assert x[h > 0].max() == pytest.approx(reach, abs=2e-6)
    assert 2 * h.sum() * 1e-6 == pytest.approx(volume, rel=1e-6)
    inner = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 20001)[1:-1]) * CONTACT.stick_half_width(
        share * F
    )
    assert np.trapezoid(worn_pressure(inner, share * F), inner) == pytest.approx(1.0, rel=1e-3)


def worn_sphere(r, share):
    """Depth worn off a sphere of radius 1 by a share of the force at which it slides, at distances
    r in radii of the contact, in the end (Popov 2014). Its stick zone has the radius c."""
    c = (1 - share) ** (1 / 3)
    d = 2 * (1 - c**3) / (3 * c)
    r = np.maximum(r, c)
    angle = np.arcsin(c / r)
    lifted = ((2 * c**2 - r**2) * angle + c * np.sqrt(r**2 - c**2)) / np.pi
    return np.maximum(c**2 + d - r**2 / 2 - lifted - 2 * d / np.pi * angle, 0.0) * (r > c)


@pytest.mark.usefixtures("no_figures_stay_open")
@pytest.mark.parametrize(("share", "stick"), [(0.2, 128), (0.5, 72), (0.9, 20)])
def test_the_cylinder_converges_to_the_closed_form(share, stick):
    """The stick zone ends on an edge of cells; half the cells, half the error."""
    errors = []
    for count in (stick // 2, stick):
        end = fo.joints.worn_in(*on_edges(count, 1.1 + 0.5 * share, share))
        x, width = end.system.x, end.system.width
        form = CONTACT.worn_depth(x, share * F)
        assert end.proven
        assert end.stick.sum() == 2 * count
        assert np.array_equal(end.stick, np.abs(x) < CONTACT.stick_half_width(share * F))
        p = end.system.reaction({"P": 1.0, "Q": 0.0})[1] + end.system.C @ (
            end.state.gap - end.system.gap
        )
        inner = np.abs(x) < 0.8 * CONTACT.stick_half_width(share * F)
        pressure = np.abs((p / width)[inner] / worn_pressure(x[inner], share * F) - 1).max()
        assert p[end.stick].sum() == pytest.approx(1.0, rel=1e-9)
        errors.append(
            [end.depth.max() / form.max() - 1, end.depth @ width / (form @ width) - 1, pressure]
        )
    drawn = {line.get_label(): line.get_ydata() for line in end.plot().get_lines()}
    assert np.array_equal(drawn["depth worn off"], end.depth)
    assert np.array_equal(np.isfinite(drawn["never slips"]), end.stick)
    coarse, fine = np.array(errors)
    assert np.all(fine < (0.012 if share > 0.2 else 0.02))
    assert np.all(fine < 0.6 * coarse)
    assert np.all(fine > 0)


def test_the_worn_cylinder_is_at_its_limit():
    """The load factor approaches the limit from above as the mesh is refined."""
    limits = []
    for count in (8, 16, 32):
        contact = on_edges(count)
        end = fo.joints.worn_in(*contact)
        limit = fo.shakedown_limit(end.system, *contact[1:3])
        assert not (limit.open & end.stick).any()
        limits.append(limit.load_factor / contact[3] - 1)
    assert 0 < limits[2] < 0.04 and np.all(np.diff(limits) < 0) and limits[2] < 0.6 * limits[1]


@pytest.mark.parametrize(
    "corners",
    [
        ({"Q": 1.0}, {"Q": -1.0}),
        ({"Q": 1.0}, {"Q": -0.4}),
        ({"Q": 0.5}, {"Q": 1.0}, {"Q": -1.0}, {"Q": 0.2}),
    ],
)
def test_simulated_wear_ends_there(corners):
    contact, cycle, f, load_factor = cylinder(32)
    cycle = fo.LoadCycle(cycle.mean, corners)
    end = fo.joints.worn_in(contact, cycle, f, load_factor)
    history = fo.joints.wear(
        contact, cycle, f, load_factor, coefficient=1e-3, tolerance=1e-3, cycles=1e6
    )
    assert history.worn_in and np.abs(history.depth[-1] - end.depth).max() < 1e-3 * end.depth.max()
    assert (
        history.steady.outcome is fo.Outcome.SHAKEDOWN
        or history.steady.dissipation < 1e-4 * history.to_frame()["work"].max()
    )


def test_a_fixed_part_of_the_cycle_counts():
    contact, cycle, f, load_factor = cylinder(16)
    scaled = fo.joints.worn_in(
        contact,
        fo.LoadCycle(cycle.mean, [{"Q": load_factor, "P": 0.3}, {"Q": -load_factor, "P": -0.3}]),
        f,
        1.0,
    )
    fixed = fo.joints.worn_in(
        contact, fo.LoadCycle(cycle.mean, cycle.corners, [{"P": 0.3}, {"P": -0.3}]), f, load_factor
    )
    assert fixed.depth.max() > 0 and np.allclose(fixed.depth, scaled.depth, rtol=1e-12, atol=0)


def test_under_a_varying_force_wear_comes_ever_closer():
    """In this state there is pressure only near the largest force. The difference falls with the
    number of cycles, tenfold in ten times as many cycles."""
    contact, cycle, f, load_factor = cylinder(24)
    cycle = fo.LoadCycle(cycle.mean, [{"Q": 1.0, "P": 0.8}, {"Q": -1.0, "P": -0.8}])
    end = fo.joints.worn_in(contact, cycle, f, load_factor)
    worn = [
        fo.joints.wear(contact, cycle, f, load_factor, coefficient=1e-3, cycles=cycles).depth[-1]
        for cycles in (1e5, 1e6, 1e7)
    ]
    apart = [np.abs(depth - end.depth).max() / end.depth.max() for depth in worn]
    assert apart[0] < 0.1 and apart[1] < 0.15 * apart[0] and apart[2] < 0.15 * apart[1]


def test_the_sphere_in_space_converges_to_the_closed_form():
    """On rings, of which the stick zone ends on an edge; half the rings, half the error."""
    errors = []
    for count in (32, 64):
        contact, cycle, f, load_factor = sphere_of_rings(count)
        end = fo.joints.worn_in(contact, cycle, f, load_factor)
        r = contact.points[:, 0]
        assert contact.tangents == 2 and end.proven and end.stick.sum() == count
        form, far = worn_sphere(r, 0.5), r[end.depth > 0].max()
        errors.append([end.depth.max() / 0.094485 - 1, end.depth @ contact.width / 0.132157733 - 1])
        assert far == pytest.approx(1.1361, rel=0.01)
        assert np.abs(end.depth - form)[r > 0.85].max() < 0.06 * form.max()
    coarse, fine = np.array(errors)
    assert np.all(fine < 0.03) and np.all(fine > 0) and np.all(fine < 0.6 * coarse)


def test_the_sphere_in_space():
    contact, cycle, f, load_factor = sphere(10, 1.3)
    end = fo.joints.worn_in(contact, cycle, f, load_factor)
    history = fo.joints.wear(
        contact, cycle, f, load_factor, coefficient=1.0, steps=1, tolerance=0.03, cycles=1e4
    )
    assert np.abs(history.depth[-1] - end.depth).max() < 0.02 * end.depth.max()


COARSE = cylinder(16)


def contact(stiffness, p, q, coupling=0.0):
    """A contact with the same stiffness along and across its face.

    The load case P presses it, and Q shears it.
    """
    A, n = np.array(stiffness), len(stiffness)
    return fo.ContactSystem.from_blocks(
        A, coupling * np.eye(n), A, np.arange(n), {"P": (np.zeros(n), p), "Q": (q, np.zeros(n))}
    )


PAIR = contact(2 * np.eye(2), [1, 1], [1, 1], coupling=0.1)
UNLIKE = fo.ContactSystem.from_blocks(
    [[2.0, -1.0], [-1.0, 2.0]], np.zeros((2, 2)), np.eye(2), [0.0, 1.0], PAIR.bonded
)
# Wear at one node relieves the next one, which has worn too much by then: 0.338 at node 0, not 1/6.
# In the other one node 2 slips the other way
# at first, and wears by 0.043.
SEESAW = contact(
    [[1.0, 0.5, 0.4], [0.5, 1.0, 0.1], [0.4, 0.1, 1.0]], [0.5, 0.9, 0.9], [1.0, 0.6, 0.9]
)
BOTH_WAYS = contact(
    [[1.1, -0.1, -0.5], [-0.1, 0.4, -0.2], [-0.5, -0.2, 1.0]], [1.2, 0.4, 0.5], [0.9, 0.4, -0.5]
)
# Sticks everywhere, and does not wear.
IN_PHASE = fo.LoadCycle({"P": 1.0}, [{"Q": 0.4, "P": 1.0}, {"Q": -0.4, "P": -1.0}])
ROUND = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"P": 1.0}, {"Q": -1.0}])


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ((PAIR, COARSE[1], F, 0.5), "system: it is coupled"),
        ((UNLIKE, COARSE[1], F, 0.5), "system: its tangential stiffness"),
        ((SEESAW, COARSE[1], F, 1.0), "system: wear at node 1 takes pressure off node 0"),
        ((COARSE[0], COARSE[1], np.linspace(0.4, 0.5, 16), 0.1), "friction: from 0.4 to 0.5"),
        (
            (BOTH_WAYS, COARSE[1], F, 1.0),
            "cycle: with no slip, the shear at node 2 changes by less",
        ),
        ((COARSE[0], IN_PHASE, F, 0.5), "cycle: with no slip, the shear at node 0 changes by less"),
        ((COARSE[0], ROUND, F, 0.1), "cycle: its loads do not stay on one line"),
        ((COARSE[0], COARSE[1], F, 0.6), "load_factor: no node sticks"),
    ],
)
def test_other_contacts_are_refused_and_referred_to_wear(asked, message):
    with pytest.raises(fo.ModelError, match=f"{message}.*use `wear`"):
        fo.joints.worn_in(*asked)
