"""Pictures of contacts in three dimensions show what the results say, node by node."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.quiver import Quiver

import frictopt as fo
from frictopt.plots.style import GREY
from spatial import cycle, random_contact, single

F = 0.6
TURN = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])  # two tangents and the normal
FLAT = random_contact(np.random.default_rng(4), 6)
TURNED = fo.ContactSystem3D(FLAT.S, FLAT.points, FLAT.bonded, frames=np.tile(TURN, (6, 1, 1)))
CURVED = fo.ContactSystem3D(FLAT.S, FLAT.points, FLAT.bonded, frames=[np.eye(3)] * 5 + [TURN])
LINE = fo.ContactSystem3D(FLAT.S, FLAT.points * [1, 0, 0], FLAT.bonded)
UNCOUPLED = random_contact(np.random.default_rng(4), 6, coupling=0.0)  # one node alone limits it
CASES = {"flat": (FLAT, np.eye(3)), "turned": (TURNED, TURN), "line": (LINE, np.eye(3)), "uncoupled": (UNCOUPLED, np.eye(3))}
ALL = pytest.mark.parametrize(("contact", "axes"), CASES.values(), ids=CASES)


@pytest.fixture(autouse=True)
def no_figures_stay_open():
    yield
    plt.close("all")


def marks(ax):
    """The coloured points, the circles (None without) and the arrows (None without)."""
    arrows = [one for one in ax.collections if isinstance(one, Quiver)]
    points = [one for one in ax.collections if one.get_array() is not None and one not in arrows]
    circles = [one for one in ax.collections if len(one.get_edgecolors()) and not len(one.get_facecolors()) and len(one.get_offsets())]
    assert len(points) == 1 and len(arrows) <= 1 and len(circles) <= 1
    return points[0], next(iter(circles), None), next(iter(arrows), None)


def check_face(ax, contact, axes, values, slip):
    """Places, colours and arrows of the nodes; (N, 2) places."""
    places = contact.points @ axes[:2].T
    points, _, arrows = marks(ax)
    assert np.allclose(points.get_offsets(), places, atol=1e-14)
    colours = np.ma.filled(points.get_array(), np.nan)
    assert np.allclose(colours, values, rtol=1e-9, atol=1e-14, equal_nan=True)
    assert np.allclose(arrows.get_offsets(), places, atol=1e-14)
    assert np.allclose(np.column_stack([arrows.U, arrows.V]), slip, rtol=1e-12)
    x, y = ax.get_xlim(), ax.get_ylim()
    assert (x[0] < places[:, 0]).all() and (places[:, 0] < x[1]).all() and (y[0] < places[:, 1]).all() and (places[:, 1] < y[1]).all()
    return places


def reaction(contact, loads, factor, corner, slip):
    """Reactions of the closed contact, from its stiffness matrix."""
    total = {**loads.mean, **{name: factor * value for name, value in loads.corners[corner].items()}}
    bonded = sum(value * contact.bonded[name] for name, value in total.items())
    r = bonded + contact.S @ np.r_[slip[:, 0], slip[:, 1], np.zeros(len(slip))]
    q1, q2, p = np.split(r, 3)
    return np.hypot(q1, q2), p


@ALL
def test_a_limit_shows_the_ratio_at_the_first_corner_the_slip_and_the_nodes_of_the_mechanism(contact, axes):
    limit = fo.shakedown_limit(contact, cycle(), F)
    ax = limit.plot()
    q, p = reaction(contact, cycle(), limit.load_factor, 0, limit.slip)
    places = check_face(ax, contact, axes, np.where(p > 1e-9, q / (F * p), np.nan), limit.slip)
    circled = marks(ax)[1].get_offsets()
    nodes = sorted(set(limit.mechanism["node"]))
    assert (len(nodes) == 1) is (contact is UNCOUPLED) and np.allclose(circled, places[nodes], atol=1e-14)
    assert ax.get_title() == rf"shakedown limit $\lambda_2$ = {limit.load_factor:.5g}"
    assert [one.get_text() for one in ax.get_legend().get_texts()][-1] == "limiting node"
    (bar,) = [one for one in ax.figure.axes if one is not ax]
    assert bar.get_ylabel() == "$|q| / (f p)$ at the first corner" and marks(ax)[0].get_clim() == (0, 1)
    names = ("position along the first tangent", "$x$") if contact is TURNED else ("$x$", "$y$")
    assert (ax.get_xlabel(), ax.get_ylabel()) == tuple(f"{name} (length)" for name in names)


def test_a_node_without_friction_bound_is_grey_and_named():
    friction = np.r_[0.0, np.full(5, F)]
    loads = fo.LoadCycle({"mean": 1.0}, [{"y": 1.0}, {"y": -1.0}])
    shear = np.r_[0.0, np.ones(5), np.zeros(12)]
    mean = np.r_[np.zeros(12), np.ones(6)]
    contact = fo.ContactSystem3D(np.eye(18), FLAT.points, {"mean": mean, "y": shear})
    ax = fo.shakedown_limit(contact, loads, friction).plot()
    points = marks(ax)[0]
    ax.figure.draw_without_rendering()
    grey = (points.get_facecolors() == to_rgba(GREY)).all(axis=1)
    assert np.isnan(np.ma.filled(points.get_array(), np.nan)).tolist() == [True] + [False] * 5
    assert grey.tolist() == [True] + [False] * 5
    assert "node without friction bound" in [one.get_text() for one in ax.get_legend().get_texts()]


@ALL
@pytest.mark.parametrize(("ratio", "exists"), [(0.5, True), (1.5, False)])
def test_a_safe_slip_shows_the_corner_with_the_least_reserve(contact, axes, ratio, exists):
    factor = ratio * fo.shakedown_limit(contact, cycle(), F).load_factor
    safe = fo.safe_slip(contact, cycle(), F, factor)
    ax = safe.plot()
    at = [reaction(contact, cycle(), factor, corner, safe.slip) for corner in range(3)]
    (bar,) = [one for one in ax.figure.axes if one is not ax]
    corner = int(bar.get_ylabel()[-1])
    reserves = [(F * p - q).min() for q, p in at]
    assert reserves[corner] == pytest.approx(min(reserves), abs=1e-8)
    q, p = at[corner]
    check_face(ax, contact, axes, np.where(p > 1e-9, q / (F * p), np.nan), safe.slip)
    title = "safe slip at" if exists else "no slip is safe; the least unsafe one at"
    assert safe.exists is exists and ax.get_title().startswith(title) and f"= {factor:.4g}$" in ax.get_title()
    assert marks(ax)[0].get_clim()[1] >= np.nanmax(np.where(p > 1e-9, q / (F * p), np.nan)) - 1e-9


@ALL
def test_a_steady_state_shows_the_work_of_each_node(contact, axes):
    factor = 1.2 * fo.shakedown_limit(contact, cycle(), F).load_factor
    steady = fo.steady_state(contact, cycle(), F, factor, steps=4)
    ax = steady.plot()
    check_face(ax, contact, axes, steady.to_frame()["dissipation"], steady.slip)
    assert marks(ax)[0].get_clim() == (0, steady.dissipation_per_node.max()) and steady.dissipation > 0
    assert ax.get_title() == f"cyclic slip, work of friction per cycle {steady.dissipation:.4g}"


def test_one_node_that_does_not_slip_has_a_map_without_arrows():
    steady = fo.steady_state(single(), fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}]), F, 0.1)
    ax = steady.plot()
    points, circles, arrows = marks(ax)
    assert points.get_array().tolist() == [0.0] and circles is None and arrows is None and ax.get_legend() is None
    assert ax.get_title() == "shakedown, work of friction per cycle 0"


def test_without_a_limit_the_picture_says_why():
    limit = fo.shakedown_limit(single(), fo.LoadCycle({"P": 1.0}, [{"P": 0.5}]), F)
    ax = limit.plot()
    assert ax.get_title() == r"shakedown limit $\lambda_2$ is infinite" and not ax.collections
    assert ax.texts[0].get_text().replace("\n", " ") == limit.reason


def test_a_contact_that_is_not_flat_is_refused():
    with pytest.raises(fo.ModelError, match="not flat"):
        fo.shakedown_limit(CURVED, cycle(), F).plot()


@pytest.mark.parametrize("contact", [FLAT, LINE], ids=["flat", "line"])
def test_all_letters_are_in_the_picture_and_given_axes_are_used(contact):
    limit = fo.shakedown_limit(contact, cycle(), F)
    figure = limit.plot().figure
    figure.draw_without_rendering()
    for ax in figure.axes:
        box = ax.get_tightbbox()
        assert box.x0 > -1 and box.y0 > -1 and box.x1 < figure.bbox.width + 1 and box.y1 < figure.bbox.height + 1
    given = plt.subplots()[1]
    assert limit.plot(given) is given
    with pytest.raises(fo.ModelError, match=r"^ax: "):
        limit.plot(5)
