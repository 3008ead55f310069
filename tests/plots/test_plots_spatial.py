"""Pictures of contacts in three dimensions show what the results say, node by node."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.quiver import Quiver
from mpl_toolkits.mplot3d.art3d import Line3DCollection

import frictopt as fo
from frictopt.contact import frames_of
from helpers.spatial import cycle, random_contact
from helpers.systems import at_corners

pytestmark = pytest.mark.usefixtures("no_figures_stay_open")

F = 0.6
TURN = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])  # two tangents and the normal
FLAT = random_contact(np.random.default_rng(4), 6)
TURNED = fo.ContactSystem(FLAT.S, FLAT.points, FLAT.bonded, frames=np.tile(TURN, (6, 1, 1)))
CURVED = fo.ContactSystem(FLAT.S, FLAT.points, FLAT.bonded, frames=[np.eye(3)] * 5 + [TURN])
LINE = fo.ContactSystem(FLAT.S, FLAT.points * [1, 0, 0], FLAT.bonded)
UNCOUPLED = random_contact(np.random.default_rng(4), 6, coupling=0.0)  # one node alone limits it
CASES = {"turned": (TURNED, TURN), "line": (LINE, np.eye(3)), "uncoupled": (UNCOUPLED, np.eye(3))}
ALL = pytest.mark.parametrize(("contact", "axes"), CASES.values(), ids=CASES)


def marks(ax):
    """The coloured points, the circles (None without) and the arrows (None without)."""
    arrows = [one for one in ax.collections if isinstance(one, Quiver)]
    points = [one for one in ax.collections if one.get_array() is not None and one not in arrows]
    circles = [
        one
        for one in ax.collections
        if len(one.get_edgecolors()) and not len(one.get_facecolors()) and len(one.get_offsets())
    ]
    assert len(points) == 1 and len(arrows) <= 1 and len(circles) <= 1
    return points[0], next(iter(circles), None), next(iter(arrows), None)


def check_face(ax, contact, axes, values, slip, to_and_fro=False):
    """Check places, colours and arrows of the nodes.

    There are no arrows if slip is None. Arrows show slips of at least 2 % of the longest slip, of
    either sense; slip to and fro has two halves of opposite sense. Places are (N, 2).
    """
    places = contact.points @ axes[:2].T
    points, _, arrows = marks(ax)
    assert np.allclose(points.get_offsets(), places, atol=1e-14)
    colours = np.ma.filled(points.get_array(), np.nan)
    assert np.allclose(colours, values, rtol=1e-9, atol=1e-14, equal_nan=True)
    assert (arrows is None) is (slip is None)
    if slip is not None:
        sizes = np.linalg.norm(slip, axis=1)
        long = sizes >= 0.02 * sizes.max()
        begins = np.tile(places[long], (1 + to_and_fro, 1))
        assert np.allclose(arrows.get_offsets(), begins, atol=1e-14)
        drawn = np.column_stack([arrows.U, arrows.V])
        if to_and_fro:
            forth, back = np.split(drawn, 2)
            assert np.array_equal(forth, -back)
            drawn = forth - back
        assert np.allclose(
            drawn * np.sign((drawn * slip[long]).sum(axis=1))[:, None], slip[long], rtol=1e-12
        )
        ax.figure.canvas.draw()
        at = arrows.get_offset_transform().transform(begins)
        shapes = [
            arrows.get_transform().transform(path.vertices) + place
            for path, place in zip(arrows.get_paths(), at, strict=True)
        ]
        assert all(ax.bbox.contains(*point) for shape in shapes for point in shape), (
            "the frame cuts an arrow"
        )
    x, y = ax.get_xlim(), ax.get_ylim()
    assert (x[0] < places[:, 0]).all()
    assert (places[:, 0] < x[1]).all()
    assert (y[0] < places[:, 1]).all()
    assert (places[:, 1] < y[1]).all()
    return places


def reaction(contact, loads, factor, corner, slip):
    """Sizes of the shear and pressures of the closed contact at a corner."""
    q, p = at_corners(contact, loads, factor, slip)
    return np.linalg.norm(q[corner], axis=1), p[corner]


@ALL
def test_a_limit_shows_the_ratio_at_the_first_corner_the_slip_and_the_nodes_of_the_mechanism(
    contact, axes
):
    limit = fo.shakedown_limit(contact, cycle(), F)
    ax = limit.plot()
    q, p = reaction(contact, cycle(), limit.load_factor, 0, limit.slip)
    places = check_face(ax, contact, axes, np.where(p > 1e-9, q / (F * p), np.nan), limit.slip)
    circled = marks(ax)[1]
    shares = limit.mechanism.groupby("node")["share"].sum()
    nodes = shares.index.to_numpy()
    assert (len(nodes) == 1) is (contact is UNCOUPLED)
    assert np.allclose(circled.get_offsets(), places[nodes], atol=1e-14)
    assert circled.get_sizes() == pytest.approx(400 * shares.to_numpy(), rel=1e-12)
    assert shares.sum() == pytest.approx(1.0)
    assert ax.get_title() == rf"shakedown limit $\lambda_2$ = {limit.load_factor:.5g}"
    assert [one.get_text() for one in ax.get_legend().get_texts()][
        -1
    ] == "limiting node; area: share"
    (bar,) = [one for one in ax.figure.axes if one is not ax]
    assert bar.get_ylabel() == f"$|q| / (f p)$ at {cycle().corner_names[0]}"
    assert marks(ax)[0].get_clim() == pytest.approx((0, 1), abs=1e-12)
    names = ("first tangent", "$x$") if contact is TURNED else ("$x$", "$y$")
    assert (ax.get_xlabel(), ax.get_ylabel()) == tuple(f"{name} (length)" for name in names)


def test_the_corner_with_the_least_reserve_is_that_of_the_least_f_p_less_q():
    """It is not the corner of the least p - |q|, of the largest ratio, of the least shear in one
    direction, or of the node with the largest reserve."""
    # The shear 0.4 is along the second tangent, all others along the first.
    reserves = {0: [0.5 - 0.4, 1.0 - 0.5], 1: [0.5 - 0.3, 1.0 - 0.85]}
    loads = {
        "mean": [0, 0, 0, 0, 5.0, 1.0],
        "first": [0, 0.5, 0.4, 0, 0, 0],
        "second": [0.3, 0.85, 0, 0, 0, 0],
    }
    two = fo.ContactSystem(np.eye(6), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], loads)
    safe = fo.safe_slip(
        two, fo.LoadCycle({"mean": 1.0}, [{"first": 1.0}, {"second": 1.0}]), [0.1, 1.0], 1.0
    )
    ax = replace(safe, slip=np.zeros((2, 2))).plot()
    assert min(reserves, key=lambda corner: min(reserves[corner])) == 0
    assert ax.figure.axes[1].get_ylabel() == "$|q| / (f p)$ at first = +1"
    assert np.allclose(marks(ax)[0].get_array(), [0.8, 0.5])


@ALL
def test_a_steady_state_shows_the_work_of_each_node(contact, axes):
    factor = 1.2 * fo.shakedown_limit(contact, cycle(), F).load_factor
    steady = fo.steady_state(contact, cycle(), F, factor, steps=4)
    ax = steady.plot()
    slips = steady.states().slip
    # The two states of the cycle that are furthest apart, for each node.
    pairs = slips[:, None] - slips[None]
    most = np.linalg.norm(pairs, axis=-1).reshape(len(slips) ** 2, -1).argmax(axis=0)
    check_face(
        ax,
        contact,
        axes,
        steady.to_frame()["dissipation"],
        pairs.reshape(-1, *slips.shape[1:])[most, np.arange(slips.shape[1])],
        to_and_fro=True,
    )
    assert marks(ax)[0].get_clim() == (0, steady.dissipation_per_node.max())
    assert steady.dissipation > 0
    work = f"{steady.dissipation:.4g} (force times length)"
    assert ax.get_title() == f"cyclic slip, work of friction per cycle {work}"
    largest = steady.fretting_table()["slip_range"].max()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        f"slip range, longest {largest:.3g} (length)"
    ]


@ALL
def test_an_onset_shows_the_bonded_contact_at_the_first_slip_of_all_and_circles_what_slips(
    contact, axes
):
    first = fo.onset(contact, cycle(), F)
    ax = first.plot()
    at = [
        reaction(contact, cycle(), first.slip.load_factor, corner, np.zeros((6, 2)))
        for corner in range(3)
    ]
    most = [(q / (F * p)).max() for q, p in at]
    corner = int(np.argmax(most))
    q, p = at[corner]
    places = check_face(ax, contact, axes, q / (F * p), None)
    assert max(most) == pytest.approx(1.0, rel=1e-9)
    assert sorted(most)[1] < 0.999
    assert (p > 0.01).all()
    assert np.allclose(marks(ax)[1].get_offsets(), places[[np.argmax(q / p)]], atol=1e-14)
    (bar,) = [one for one in ax.figure.axes if one is not ax]
    assert (
        bar.get_ylabel()
        == rf"$|q| / (f p)$ at {cycle().corner_names[corner]}, $\lambda = {first.slip.load_factor:.4g}$"
    )
    assert marks(ax)[0].get_clim() == (0, 1)
    assert ax.get_title() == "bonded contact at the onset of slip"
    assert [one.get_text() for one in ax.get_legend().get_texts()] == ["node that slips first"]


def test_open_nodes_are_rings_without_slip_and_those_that_carry_nothing_do_not_slip():
    loads = {"mean": [0, 0, 0, 0, 0, 0, 1.0, -1.0, 0.0], "shear": [1.0, 0, 0, 0, 0, 0, 0, 0, 0]}
    three = fo.ContactSystem(np.eye(9), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], loads)
    shearing = fo.LoadCycle({"mean": 1.0}, [{"shear": 1.0}, {"shear": -1.0}])
    limit = replace(
        fo.shakedown_limit(three, shearing, F), slip=np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]])
    )
    ax = limit.plot()
    (arrows,) = [one for one in ax.collections if isinstance(one, Quiver)]
    (rings,) = [one for one in ax.collections if one.get_label() == "open node"]
    assert limit.open.tolist() == [False, True, False]
    assert rings.get_offsets().tolist() == [[1.0, 0.0]]
    assert arrows.U.tolist() == [0.1, 0.5]
    assert arrows.get_offsets().tolist() == [[0.0, 0.0], [2.0, 0.0]]
    slips = fo.steady_state(three, shearing, F, 2.0, steps=2).plot()
    (rings,) = [one for one in slips.collections if one.get_label() == "open node"]
    assert rings.get_offsets().tolist() == [[1.0, 0.0]]
    bonded = three.with_bonded({"mean": [0, 0, 0, 0, 0, 0, 1.0, 1.0, 0.0]})
    assert marks(fo.onset(bonded, shearing, F).plot())[1].get_offsets().tolist() == [[0.0, 0.0]]


def test_contacts_of_several_planes_have_a_panel_each_with_one_scale_of_colours_and_slips():
    faces = np.array(["lap"] * 3 + ["head"] * 3)
    frames = [np.eye(3)] * 3 + [TURN] * 3
    several = fo.ContactSystem(
        FLAT.S,
        np.r_[FLAT.points[:3], 10 * FLAT.points[:3]],
        FLAT.bonded,
        frames=frames,
        contact=faces,
    )
    limit = fo.shakedown_limit(several, cycle(), F)
    panels = limit.plot()
    assert [ax.get_title() for ax in panels] == ["lap", "head"]
    assert panels[0].get_title("left").startswith("shakedown limit")
    found = [marks(ax) for ax in panels]
    for nodes, frame, (points, _, _) in zip(
        (slice(0, 3), slice(3, 6)), (np.eye(3), TURN), found, strict=True
    ):
        assert np.allclose(points.get_offsets(), several.points[nodes] @ frame[:2].T, atol=1e-14)
        assert points.get_clim() == (0, 1)
    assert np.allclose(
        np.concatenate([np.column_stack([arrows.U, arrows.V]) for *_, arrows in found]), limit.slip
    )
    lap, head = (arrows.scale for *_, arrows in found)
    sizes = [np.ptp(points.get_offsets(), axis=0).max() for points, *_ in found]
    assert lap / head == pytest.approx(sizes[1] / sizes[0])  # as long on paper
    legend = panels[-1].get_legend()
    longest = f"residual slip, longest {np.linalg.norm(limit.slip, axis=1).max():.3g} (length)"
    assert sorted(text.get_text() for text in legend.get_texts()) == [
        "limiting node; area: share",
        longest,
    ]
    axes = plt.subplots(1, 2)[1]
    assert list(limit.plot(axes)) == list(axes)
    with pytest.raises(fo.ModelError, match="give 2 matplotlib axes"):
        limit.plot(axes[0])
    steady = fo.steady_state(several, cycle(), F, 1.5 * limit.load_factor, steps=2)
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=2, EA=1.0, h=1.0))
    pulled = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    ends = replace(fo.dissipation_range(rod, pulled, F, 1.0), least_state=steady, most_state=steady)
    panels = ends.plot()
    assert [ax.get_title() for ax in panels] == ["lap", "head"]
    title = " ".join(panels[0].get_title("left").split())
    assert title.endswith("per cycle found state of the most work")
    works = steady.dissipation_per_node
    drawn = np.concatenate([marks(ax)[0].get_array() for ax in panels])
    assert np.allclose(drawn, works, rtol=1e-9)
    plt.close("all")


NORMALS = np.r_[np.eye(3), -np.eye(3)]
Z = [[0.0, 0.0, 1.0]]
NOT_FLAT = {
    "curved": CURVED,
    "ball": fo.ContactSystem(FLAT.S, NORMALS, FLAT.bonded, frames=frames_of(NORMALS)),
    "stacked": fo.ContactSystem(FLAT.S, np.r_[FLAT.points[:3], FLAT.points[:3] + Z], FLAT.bonded),
}


@pytest.mark.parametrize("name", NOT_FLAT)
def test_contacts_that_are_not_flat_or_above_each_other_are_shown_in_space(name):
    """Points are at their places, and arrows are the slips along the tangents."""
    contact = NOT_FLAT[name]
    limit = fo.shakedown_limit(contact, cycle(), F)
    axes = limit.plot()
    (points,) = [one for one in axes.collections if one.get_array() is not None]
    assert np.array_equal(np.transpose(points._offsets3d), contact.points)
    (arrows,) = [one for one in axes.collections if isinstance(one, Line3DCollection)]
    shafts = np.array(arrows._segments3d)[: len(arrows._segments3d) // 3]
    steps = shafts[:, 0] - shafts[:, 1]
    slips = np.einsum("nk,nki->ni", limit.slip, contact.frames[:, :2])
    sizes = np.linalg.norm(slips, axis=1)
    slips = slips[sizes >= 0.02 * sizes.max()]
    scale = np.linalg.norm(steps, axis=1).max() / sizes.max()
    assert np.allclose(steps, scale * slips, atol=1e-9 * scale * sizes.max())
    assert axes.get_zlabel() == "$z$ (length)"
    fo.onset(contact, cycle(), F).plot()
    with pytest.raises(fo.ModelError, match="projection='3d'"):
        limit.plot(plt.figure().add_subplot())


def test_a_face_that_is_not_quite_flat_is_seen_along_its_mean_normal():
    normals = np.c_[
        [[0.3, 0.0], [-0.3, 0.0], [0.0, 0.2], [0.0, -0.2], [0.1, 0.1], [-0.1, -0.1]], np.ones(6)
    ]
    contact = fo.ContactSystem(FLAT.S, FLAT.points, FLAT.bonded, frames=frames_of(normals))
    slip = np.einsum("nki,i->nk", contact.frames[:, :2], [1.0, 2.0, 0.0])
    points, _, arrows = marks(replace(fo.shakedown_limit(contact, cycle(), F), slip=slip).plot())
    seen = np.einsum("nki,nk->ni", contact.frames[:, :2], slip)[:, :2]
    assert np.allclose(points.get_offsets(), FLAT.points[:, :2])
    assert np.allclose(np.column_stack([arrows.U, arrows.V]), seen)


def test_a_guaranteed_limit_circles_its_node():
    limit = fo.guaranteed_limit(FLAT, cycle(), F)
    ax, node = limit.plot(), limit.node
    assert node > 0 and np.allclose(marks(ax)[1].get_offsets(), FLAT.points[[node], :2], atol=1e-14)
