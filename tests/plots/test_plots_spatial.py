"""Pictures of contacts in three dimensions show what the results say, node by node."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.quiver import Quiver

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
    assert marks(ax)[0].get_clim() == (0, 1)
    names = ("position along the first tangent", "$x$") if contact is TURNED else ("$x$", "$y$")
    assert (ax.get_xlabel(), ax.get_ylabel()) == tuple(f"{name} (length)" for name in names)


@ALL
@pytest.mark.parametrize(("ratio", "exists"), [(0.5, True), (1.5, False)])
def test_a_safe_slip_shows_the_corner_with_the_least_reserve(contact, axes, ratio, exists):
    factor = ratio * fo.shakedown_limit(contact, cycle(), F).load_factor
    safe = fo.safe_slip(contact, cycle(), F, factor)
    ax = safe.plot()
    at = [reaction(contact, cycle(), factor, corner, safe.slip) for corner in range(3)]
    (bar,) = [one for one in ax.figure.axes if one is not ax]
    corner = cycle().corner_names.index(bar.get_ylabel().split(" at ")[1])
    reserves = [(F * p - q).min() for q, p in at]
    assert reserves[corner] == pytest.approx(min(reserves), abs=1e-8)
    q, p = at[corner]
    check_face(ax, contact, axes, np.where(p > 1e-9, q / (F * p), np.nan), safe.slip)
    title = "safe slip at" if exists else "no slip is safe; the least unsafe one at"
    assert safe.exists is exists
    assert ax.get_title().startswith(title)
    assert f"= {factor:.4g}$" in ax.get_title()
    assert marks(ax)[0].get_clim()[1] >= np.nanmax(np.where(p > 1e-9, q / (F * p), np.nan)) - 1e-9


def test_the_corner_with_the_least_reserve_is_that_of_the_least_f_p_less_q():
    """The corner with the least reserve has the least f p - |q|.

    It is not the corner of the least p - |q|, of the largest ratio, of the least shear in one
    direction, or of the node with the largest reserve.
    """
    # The shear 0.4 is along the second tangent, all others along the first.
    reserves = {
        0: [0.5 - 0.4, 1.0 - 0.5],
        1: [0.5 - 0.3, 1.0 - 0.85],
    }
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


@pytest.mark.parametrize("contact", [FLAT, CURVED], ids=["flat", "curved"])
def test_a_trajectory_shows_loops_along_both_tangents_and_both_slips(contact):
    path = fo.march(
        contact,
        cycle(),
        F,
        1.2 * fo.shakedown_limit(contact, cycle(), F).load_factor,
        cycles=2,
        steps=4,
    )
    *sides, below = path.plot()
    work = path.to_frame().query(f"state == {len(path.time) - 1}")["work"]
    nodes = sorted(range(6), key=lambda node: -work.iloc[node])[:3]
    table = path.to_frame()
    for axis, ax in enumerate(sides, start=1):
        for number, node in enumerate(nodes):
            rows, line = table[table["node"] == node], ax.get_lines()[2 * number]
            assert np.array_equal(line.get_data(), rows[[f"slip{axis}", f"q{axis}"]].to_numpy().T)
            assert np.array_equal(
                ax.get_lines()[2 * number + 1].get_xydata(),
                rows[[f"slip{axis}", f"q{axis}"]].tail(1),
            )
            lower = below.get_lines()[4 * (axis - 1) + number]
            assert np.array_equal(lower.get_data(), rows[["time", f"slip{axis}"]].to_numpy().T)
            assert lower.get_color() == line.get_color()
            assert (
                line.get_label()
                == f"node {node} at ({', '.join(f'{place:.3g}' for place in contact.points[node])})"
            )
        assert ax.get_xlabel() == f"slip $v_{axis}$ (length)"
        assert ax.get_ylabel() == f"shear force $q_{axis}$ (force)"
    assert [text.get_text() for text in below.get_legend().get_texts()] == [
        "$v_1$, colours as above",
        "$v_2$, colours as above",
        "cycles",
    ]
    assert [line.get_xdata()[0] for line in below.get_lines()[8:]] == [0, 3, 6]
    assert (
        below.get_xlabel()
        == "corners visited (0: mean load, 1: a = +1, 2: a = -1, 3: b = +0.7, c = +0.2)"
    )
    assert below.get_ylabel() == "slip $v_1$, $v_2$ (length)"
    assert sides[0].get_title() == "nodes with the most work of friction"
    assert sides[0].get_legend() is not None


def test_each_place_of_a_map_has_the_colour_of_its_nearest_node():
    """Colours between the nodes of a grid follow no diagonals."""
    steps = np.arange(4.0)
    places = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    p = np.random.default_rng(6).uniform(0.5, 1.0, size=16)
    loads = {"P": np.concatenate([np.zeros(32), p]), "Q": np.repeat([0.1, 0.0, 0.0], 16)}
    contact = fo.ContactSystem(np.eye(48), np.pad(places, ((0, 0), (0, 1))), loads)
    ax = fo.onset(contact, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), F).plot()
    (image,) = ax.images
    colours = image.get_array()
    (points,) = [one for one in ax.collections if one.get_array() is not None]
    at_nodes = points.get_array()
    assert np.ptp(at_nodes) > 0.1 and image.get_extent() == [0.0, 3.0, 0.0, 3.0]
    middles = 3.0 * (np.arange(len(colours)) + 0.5) / len(colours)
    nearest = np.round(middles).astype(int)
    assert np.array_equal(colours, at_nodes.reshape(4, 4)[nearest[:, None], nearest])
    # All points and arrows are within the axes.
    ends = np.sort([ax.get_xlim(), ax.get_ylim()])
    assert (ends[:, 0] < 0.0).all() and (ends[:, 1] > 3.0).all()


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
    assert arrows.get_offsets().tolist() == [
        [0.0, 0.0],
        [2.0, 0.0],
    ]
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
    (legend,) = panels[0].figure.legends
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
    upper, lower = np.split(ends.plot(), 2)
    assert (
        [ax.get_title() for ax in upper]
        == [ax.get_title() for ax in lower]
        == [
            "lap",
            "head",
        ]
    )
    assert "most work" in lower[0].get_title("left")
    assert upper[0].get_position().y0 > lower[0].get_position().y1
    plt.close("all")


def test_contacts_that_never_slip_are_left_out_and_the_others_have_one_scale():
    """The second contact is half as large as the first one, along another normal."""
    contact = fo.ContactSystem(
        FLAT.S,
        np.r_[FLAT.points[:3], 0.5 * FLAT.points[:3]],
        FLAT.bonded,
        frames=[np.eye(3)] * 3 + [TURN] * 3,
        contact=["lap"] * 3 + ["head"] * 3,
        units="N, mm",
    )
    factor = 2 * fo.shakedown_limit(contact, cycle(), F).load_factor
    steady = fo.steady_state(contact, cycle(), F, factor, steps=2)
    both = replace(steady, slipping=np.ones(6, dtype=bool))
    panels = both.plot()
    figure = panels[0].figure
    work = f"work of friction per cycle {steady.dissipation:.4g} (N mm)"
    assert figure.get_suptitle().endswith(work) and "no slip" not in figure.get_suptitle()
    assert [ax.get_title() for ax in panels] == ["lap", "head"]
    scales = [ax.get_window_extent().width / np.ptp(ax.get_xlim()) for ax in panels]
    assert scales[0] == pytest.approx(scales[1], rel=0.25)
    boxes = [text.get_window_extent() for text in (ax.title for ax in panels)]
    assert not boxes[0].overlaps(boxes[1])
    assert not boxes[0].overlaps(figure._suptitle.get_window_extent())
    alone = replace(steady, slipping=contact.contact == "lap").plot()
    assert len(marks(alone)[0].get_offsets()) == 3
    first, second = alone.get_title().splitlines()
    assert first.startswith("lap: ") and first.endswith(work) and second == "no slip: head"
    at_rest = replace(steady, slipping=np.zeros(6, dtype=bool)).plot()
    assert len(at_rest) == 2
    with pytest.raises(fo.ModelError, match="give 2 matplotlib axes"):
        both.plot(alone)


def test_contacts_that_are_not_flat_or_above_each_other_are_refused_and_their_transients_drawn():
    for result in (fo.shakedown_limit(CURVED, cycle(), F), fo.onset(CURVED, cycle(), F)):
        with pytest.raises(fo.ModelError, match="not flat"):
            result.plot()
    z = [[0.0, 0.0, 1.0]]
    stacked = fo.ContactSystem(FLAT.S, np.r_[FLAT.points[:3], FLAT.points[:3] + z], FLAT.bonded)
    limit = fo.shakedown_limit(stacked, cycle(), F)
    for result in (limit, fo.onset(stacked, cycle(), F), fo.safe_slip(stacked, cycle(), F, 0.1)):
        with pytest.raises(fo.ModelError, match="would hide others on a map"):
            result.plot()
    fo.march(stacked, cycle(), F, limit.load_factor, cycles=1, steps=2).plot()


@pytest.mark.parametrize("side", [1.0, -1.0])  # body 1 around the face, and within
def test_a_round_face_is_unrolled_and_the_slip_of_a_screw_is_the_same_everywhere(side):
    angle = np.arange(6.0)
    height = np.array([0.0, 1.0, 0.5, 2.0, 1.5, 3.0])
    (first, second, axis) = TURN
    radial = np.outer(np.cos(angle), first) + np.outer(np.sin(angle), second)
    contact = fo.ContactSystem(
        FLAT.S, 2 * radial + np.outer(height, axis), FLAT.bonded, frames=frames_of(side * radial)
    )
    screw = np.einsum(
        "nki,ni->nk", contact.frames[:, :2], 0.3 * np.cross(axis, 2 * radial) + 0.1 * axis
    )
    points, _, arrows = marks(replace(fo.shakedown_limit(contact, cycle(), F), slip=screw).plot())
    places = np.asarray(points.get_offsets())
    assert np.allclose(places - places[0], np.column_stack([2 * side * angle, height]), atol=1e-12)
    assert np.allclose(np.column_stack([arrows.U, arrows.V]), [0.6 * side, 0.1])


def test_a_cone_is_cut_between_its_nodes_and_the_longest_slip_is_not_foreshortened():
    """A cone is cut between its nodes, and the longest slip is not foreshortened.

    Three nodes are around at the radii 1.8 and 2.2; the nodes opposite to the first tangent of the
    axis are a little aside.
    """
    lean, apart, side = np.arctan(0.4), 1e-4, np.array([-0.5, 0.5])
    angle = np.add.outer([np.pi, np.pi / 3, -np.pi / 3], apart * side).ravel()
    axis = np.array([0.0, 0.6, 0.8])
    radial = np.outer(np.cos(angle), [1.0, 0.0, 0.0]) + np.outer(
        np.sin(angle), np.cross(axis, [1.0, 0.0, 0.0])
    )
    height = np.tile(side, 3)
    normals = np.cos(lean) * radial - np.sin(lean) * axis
    contact = fo.ContactSystem(
        FLAT.S,
        (2 + 0.4 * height)[:, None] * radial + np.outer(height, axis),
        FLAT.bonded,
        frames=frames_of(normals),
    )
    slip = np.einsum(
        "nki,ni->nk", contact.frames[:, :2], 0.3 * (np.sin(lean) * radial + np.cos(lean) * axis)
    )
    ax = replace(fo.shakedown_limit(contact, cycle(), F), slip=slip).plot()
    points, _, arrows = marks(ax)
    places = np.asarray(points.get_offsets()).reshape(3, 2, 2)
    assert np.allclose(places[..., 1], side)
    assert np.allclose(np.diff(places[..., 0], axis=1), 2 * apart, rtol=1e-3)
    assert np.allclose(np.diff(np.sort(places[:, 0, 0])), 2 * 2 * np.pi / 3, rtol=1e-3)
    assert np.allclose(np.column_stack([arrows.U, arrows.V]), [0.0, 0.3 * np.cos(lean)])
    assert "longest 0.3 " in ax.get_legend().get_texts()[0].get_text()


def test_a_sphere_has_no_map():
    normals = np.r_[np.eye(3), -np.eye(3)]
    ball = fo.ContactSystem(FLAT.S, normals, FLAT.bonded, frames=frames_of(normals))
    with pytest.raises(fo.ModelError, match="not flat, and its sides face in opposite directions"):
        fo.shakedown_limit(ball, cycle(), F).plot()


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


def test_a_guaranteed_limit_names_its_node_and_the_loads_at_which_it_is_on_its_bound():
    limit = fo.guaranteed_limit(FLAT, cycle(), F)
    ax, node = limit.plot(), limit.node
    at = [reaction(FLAT, cycle(), limit.load_factor, corner, limit.slip) for corner in range(3)]
    on = [
        name
        for name, (q, p) in zip(cycle().corner_names, at, strict=True)
        if abs(q[node] - F * p[node]) < 1e-7 * p.mean()
    ]
    place = ", ".join(f"{part:.3g}" for part in FLAT.points[node])
    assert len(on) > 1
    assert ax.get_title().splitlines()[1:] == [
        f"node {node} at ({place}): on its bound at",
        "; ".join(on),
    ]
    assert node > 0 and np.allclose(marks(ax)[1].get_offsets(), FLAT.points[[node], :2], atol=1e-14)


def test_the_work_of_a_study_in_space_is_not_per_depth():
    axes = fo.plot_study(fo.dissipation_study(UNCOUPLED, cycle(2), F, [0.1, 2.0], progress=False))
    assert axes.get_ylabel().endswith("\n(force times length)")
