"""Results of others beside ours, at quick size, and their closed forms against other ways to the
same numbers."""

from math import pi

import numpy as np
import pytest
from scipy.integrate import quad

import frictopt as fo
from helpers.two_nodes import two_node_limits
from studies import guaranteed
from studies.published import half_planes, nodes, spheres, study

WITHIN = {  # how quantities begin -> largest difference at quick size; of all others 1e-6
    "critical friction": 2e-3,
    "friction from which": 2e-3,
    "both limits of a node": 3e-3,
    "work of friction per cycle of a node": 5e-3,
    "half-width of the": 0.05,  # a cell, 0.042 a
    "middle of the stick zone": 0.05,
    "work of friction per cycle, cylinder": 2e-3,
    "work of friction per cycle under a normal": 0.01,
    "work of friction per cycle of a cylinder": 0.04,  # 16 corners
    "work of friction per cycle of a sphere": 0.06,
    "twisting couple": 0.02,
    "radius of the stick zone": 0.05,
    "work of friction per cycle of a rod": 0.0626,  # 1 / n^2 with 4 nodes that slip
    "work of friction per cycle of a cantilever": 0.02,
    "work of friction per cycle of a lap joint": 0.07,
    "power of the distance": 0.06,
    "q / p of the stronger mode": 0.12,
    "power of the corner element": 0.1,
    "least damping": 0.01,
    "most damping": 0.01,
    "least frequency": 1e-3,
}


def test_ours_is_theirs_within_what_the_mesh_leaves(tables):
    table = tables["published"]
    for quantity, rows in table.groupby("quantity"):
        (within,) = [most for begins, most in WITHIN.items() if quantity.startswith(begins)] or [
            1e-6
        ]
        assert rows["difference"].abs().max() <= within, quantity
    assert table["residual"].max() < 1e-9 and (table["how"] != "").all()
    assert np.isfinite(table[["theirs", "ours"]]).all(axis=None)


def test_a_curve_of_theirs_goes_through_the_values_that_are_compared(tables):
    points, curves = tables["published"], tables["published_curves"]
    for quantity, curve in curves.groupby("quantity"):
        rows = points[points["quantity"] == quantity]
        assert np.interp(rows["at"], curve["at"], curve["theirs"]) == pytest.approx(
            rows["theirs"].to_numpy(), rel=2e-3, abs=1e-9
        )


def test_each_result_is_a_line_of_the_page_with_its_worst_value(tables):
    table = tables["published"].copy()
    row = table.index[table["quantity"].str.startswith("twisting couple")][0]
    table.loc[row, ["ours", "difference"]] = 9.0, 0.5
    lines = [
        line
        for line in study.STUDY.summary({"published": table}).splitlines()
        if line.startswith("|")
    ]
    assert len(lines) - 2 == len(table.groupby(["source", "quantity"]))
    (line,) = [line for line in lines if "twisting couple" in line]
    assert "| 9 | +50 % |" in line and f"= {table.loc[row, 'at']:g}, worst of 2" in line


@pytest.mark.parametrize("f", [0.1, 0.35, 0.6])
def test_the_rule_of_two_nodes_is_that_of_the_plane_of_their_slips(f):
    contact = guaranteed.pair()
    q0, p0 = contact.reaction({"mean": 1.0})
    q1, p1 = contact.reaction({"cyclic": 1.0})
    assert nodes.two_node_limits(contact, guaranteed.PAIR_LOADS, f) == pytest.approx(
        two_node_limits(contact.A, contact.B, q0, p0, q1, p1, f), rel=1e-12
    )
    if f == 0.6:
        assert nodes.two_node_limits(contact, guaranteed.PAIR_LOADS, f) == pytest.approx(
            (0.391864153760, 0.726057393108), rel=1e-11
        )


@pytest.mark.parametrize("phase", [0.0, 60.0, 135.0])
def test_the_work_of_a_node_out_of_phase_is_that_of_small_steps(phase):
    f, lam, t = 0.5, nodes._LOAD, np.linspace(0.0, 4 * pi, 16_001)
    bound, sheared = f * (1 + lam * nodes._NORMAL * np.cos(t + np.radians(phase))), lam * np.cos(t)
    v, work = 0.0, np.zeros_like(t)
    for k in range(len(t)):
        moved = float(np.clip(v, -bound[k] - sheared[k], bound[k] - sheared[k]))
        work[k], v = bound[k] * abs(moved - v), moved
    assert nodes.work_at_phase(phase) == pytest.approx(work[8_001:].sum(), rel=1e-3)
    assert nodes.limit_at_phase(phase) < lam


def test_a_normal_force_that_hardly_varies_is_a_constant_one_and_one_that_varies_much_leaves_less_work():
    cylinder = fo.reference.LineContact(P=pi / 4, R=1.0, E_star=1.0, f=0.4)
    for share in (0.3, 0.7):
        gross = 0.4 * cylinder.P
        assert half_planes.work_of_both(1e-5, share) == pytest.approx(
            cylinder.dissipation(share * gross) / gross**2, rel=1e-6
        )
        works = [half_planes.work_of_both(swing, share) for swing in (0.05, 0.1, 0.2)]
        assert sorted(works, reverse=True) == works


@pytest.mark.parametrize(("swing", "share"), [(0.1, 0.5), (0.35, 0.5), (0.15, 0.8)])
def test_the_area_of_the_loop_is_that_of_its_two_branches(swing, share):
    """Shear over displacement, from the loads of the stick zone along the way."""
    P, f = pi / 4, 0.4
    force = np.linspace(P * (1 - swing), P * (1 + swing), 200_001)
    sheared = share * f * P * np.linspace(-1.0, 1.0, len(force))

    def D(load):
        return -load * np.log(load) / pi

    up = f * (D(force) - 2 * D((force + force[0]) / 2 - (sheared - sheared[0]) / (2 * f)))
    down = f * (D(force) - 2 * D((force + force[-1]) / 2 - (sheared[-1] - sheared) / (2 * f)))
    loop = np.trapezoid(sheared, up) + np.trapezoid(sheared, down)
    assert half_planes.work_of_both(swing, share) == pytest.approx(loop / (f * P) ** 2, rel=1e-6)


@pytest.mark.parametrize(("swing", "share"), [(0.1, 0.5), (0.3, 0.5)])
def test_springs_have_the_work_of_the_closed_form_where_the_loads_are_in_phase_and_more_out_of_it(
    swing, share
):
    in_phase = half_planes.work_of_springs(swing, share, 0.0, 400)
    assert in_phase == pytest.approx(half_planes.work_of_both(swing, share), rel=3e-3)
    assert (
        half_planes.work_of_springs(swing, share, 60.0, 400) > 1.5 * in_phase
        if swing == 0.3
        else True
    )


def test_a_twisted_sphere_slides_at_the_couple_of_its_pressure_and_is_as_stiff_as_what_still_sticks():
    assert spheres.torque(0.0) == pytest.approx(3 * pi / 16, rel=1e-9)
    for stick in (
        0.3,
        0.7,
        0.999,
        # what is added turns the zone that sticks as a rigid disc, each body by half (Reissner and
        # Sagoci)
    ):
        more, less = stick - 1e-4, stick + 1e-4
        couple = (spheres.torque(more) - spheres.torque(less)) * spheres._FRICTION * spheres._P
        assert couple == pytest.approx(
            16 / 3 * spheres._G * stick**3 * (spheres.twist(more) - spheres.twist(less)) / 2,
            rel=1e-4,
        )


@pytest.mark.parametrize("flat", [0.0, 0.3, 0.8])
def test_the_force_on_a_punch_is_the_integral_over_its_slope(flat):
    """`x (x - flat) / sqrt(1 - x^2)` with x = sin(t); without a flat it is the cylinder."""
    force, _ = quad(lambda t: np.sin(t) * (np.sin(t) - flat), np.arcsin(flat), pi / 2)
    assert half_planes.force_on_rounded(1.0, flat) == pytest.approx(force, rel=1e-9)
    assert half_planes.force_on_rounded(2.0, 2 * flat) == pytest.approx(4 * force, rel=1e-9)


def test_a_pair_wedges_from_the_friction_on_at_which_a_slip_holds_itself():
    least = nodes.least_wedged(guaranteed.pair())
    for friction, wedged in ((0.999 * least, False), (1.001 * least, True)):
        limit = fo.shakedown_limit(
            guaranteed.pair(), guaranteed.PAIR_LOADS, friction, open_nodes=[False, False]
        )
        assert np.isinf(limit.load_factor) == wedged
    assert nodes.one_wedged(guaranteed.pair()) < least
