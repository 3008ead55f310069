"""Pictures of loads and contacts, and of the behaviour of nodes.

They show the right numbers, on axes with the right labels.
"""

import gc
import io
import itertools
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PathCollection, QuadMesh
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import frictopt as fo
from frictopt.contact import triangles
from helpers.cases import few
from helpers.spatial import cycle, random_contact
from helpers.systems import CYCLE, random_system

pytestmark = pytest.mark.usefixtures("no_figures_stay_open")

F = 0.5
PLANE = replace(
    random_system(np.random.default_rng(3), 5),
    contact=["left", "left", "right", "right", "right"],
    width=[0.5, 1.0, 1.0, 2.0, 1.0],
)
SPACE = random_contact(np.random.default_rng(4), 6)


def slipping(contact, loads, **options):
    return fo.steady_state(
        contact, loads, F, 1.5 * fo.shakedown_limit(contact, loads, F).load_factor, **options
    ).states()


def area_of_colours(ax):
    """The area of a map that is filled with colours."""
    (image,) = ax.images
    left, right, low, high = image.get_extent()
    return (right - left) * (high - low) * np.mean(image.get_alpha())


def at(mesh, edges, place):
    return int(np.searchsorted(edges, place)) - 1


@pytest.mark.parametrize("in_space", [False, True])
def test_the_status_of_each_node_stands_at_its_place_and_time(in_space):
    states = slipping(SPACE, cycle(), steps=4) if in_space else slipping(PLANE, CYCLE)
    ax = states.plot_status()
    meshes = [one for one in ax.collections if isinstance(one, QuadMesh)]
    assert len(meshes) == (1 if in_space else 2)
    places = np.arange(6) if in_space else PLANE.x
    code = {"stick": 0, "slip": 1, "slip+": 1, "slip-": 2, "open": 3}
    table = states.to_frame()
    middles = (states.time[1:] + states.time[:-1]) / 2
    seen = 0
    for interval, middle in enumerate(middles):
        if states.time[interval + 1] - states.time[interval] < 1e-9:
            continue
        # An increment is that of its end, an event holds until the next one.
        row = table[table.state == interval + (1 if in_space else 0)]
        for node, place in enumerate(places):
            for mesh in meshes:
                grid, values = mesh.get_coordinates(), mesh.get_array()
                column, line = at(mesh, grid[0, :, 0], place), at(mesh, grid[:, 0, 1], middle)
                if 0 <= column < values.shape[1]:
                    assert values[line, column] == code[row.status.iloc[node]]
                    seen += 1
    assert seen == len(places) * np.count_nonzero(np.diff(states.time) >= 1e-9)
    loads = (
        "1: a = +1, 2: a = -1, 3: b = +0.7, c = +0.2"
        if in_space
        else "1: cyclic = -1, 2: cyclic = +1"
    )
    assert ax.get_ylabel() == f"corners visited\n(0: mean load, {loads})"
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert words == [
        word
        for word in ("stick", "slip +", "slip -", "slip", "open")
        if word.replace(" ", "") in set(table.status)
    ]


def test_a_contact_at_rest_shows_no_slip_and_no_rounding():
    punch = fo.scenes.PunchOnHalfPlane(elements=20).condense()
    strain = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    steady = fo.steady_state(punch, strain, 0.7, load_factor=1.3)
    assert steady.outcome.name == "SHAKEDOWN" and steady.slip.any()
    drawn = [line.get_ydata() for line in steady.plot()[0].get_lines() if line.get_marker() == "."]
    assert len(drawn) == 1 and not np.any(drawn)


@pytest.mark.parametrize("in_space", [False, True])
def test_numbers_of_small_slips_do_not_run_into_each_other(in_space):
    contact, loads, options = (SPACE, cycle(), {"steps": 4}) if in_space else (PLANE, CYCLE, {})
    stiffer = np.abs(slipping(contact, loads, **options).slip).max() / 1e-4
    figure = slipping(replace(contact, S=stiffer * contact.S), loads, **options).plot()[0].figure
    figure.canvas.draw()
    for axes in figure.axes:
        low, high = axes.get_xlim()
        texts = [
            text
            for text in axes.get_xticklabels()
            if text.get_text() and low <= text.get_position()[0] <= high
        ]
        boxes = [text.get_window_extent() for text in texts]
        assert all(one.x1 < next_one.x0 for one, next_one in itertools.pairwise(boxes))


def test_a_system_shows_its_points_normals_and_bonded_pressure():
    place, pressure = PLANE.plot()
    assert np.array_equal(np.column_stack(place.get_lines()[0].get_data()), PLANE.points)
    drawn = [line for line in pressure.get_lines() if line.get_marker() == "."]
    values = np.concatenate([line.get_ydata() for line in drawn])
    assert np.array_equal(
        values, np.concatenate([p / PLANE.width for _, p in PLANE.bonded.values()])
    )
    assert pressure.get_ylabel() == "bonded pressure\n(force per area)"
    panels = replace(SPACE, width=np.arange(1.0, 7.0)).plot()
    assert len(panels) == len(SPACE.bonded)
    for axes, (case, (_, p)) in zip(panels, SPACE.bonded.items(), strict=True):
        (points,) = [one for one in axes.collections if isinstance(one, PathCollection)]
        assert np.array_equal(points.get_array(), p / np.arange(1.0, 7.0))
        assert axes.get_title().startswith(f"{case} = 1")
    with pytest.raises(fo.ModelError, match="projection='3d'"):
        SPACE.plot(plt.subplots()[1])


def test_a_load_cycle_shows_each_load_at_its_corners_or_times():
    loads = fo.LoadCycle({"P": 1.0}, [{"P": 0.5, "Q": -1.0}, {"Q": 1.0}])
    ax = loads.plot()
    drawn = {
        line.get_label(): line.get_ydata()
        for line in ax.get_lines()
        if not line.get_label().startswith("_")
    }
    assert list(drawn["P"]) == [1.0, 1.5, 1.0] and list(drawn["Q"]) == [1.0, -1.0, 1.0]
    assert [text.get_text() for text in ax.get_xticklabels()] == [
        "Q = +1",
        "P = +0.5, Q = -1",
        "Q = +1",
    ]
    for times, shown in (([2.0, 7.0], [1.5, 1.0]), ([2.0, 7.0, 8.0], [1.5, 1.0, 1.5])):
        timed = fo.LoadCycle(loads.mean, loads.corners, times=times).plot()
        drawn = timed.get_lines()[0]
        assert list(drawn.get_xdata()) == times
        assert list(drawn.get_ydata()) == shown
        assert timed.get_xlabel() == "time"


def test_deformed_bodies_stand_where_their_displacements_bring_them():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    fields = model.recover({"P": 1.0}, slip=np.zeros(5))
    ax = fields.plot_deformed(scale=2.0)
    ends = {line.get_label(): np.nanmin(line.get_ydata()) for line in ax.get_lines()}
    mesh = fields.bodies["punch"].mesh
    assert ends["punch"] == pytest.approx((mesh.p + 2.0 * fields.displacement["punch"])[1].min())
    largest = max(np.linalg.norm(u, axis=0).max() for u in fields.displacement.values())
    assert (
        ax.get_title() == f"displacements 2 times enlarged; the largest is {largest:.4g} (length)"
    )
    space = fo.scenes.SquarePunch(elements=2).model()
    ax = space.recover({"P": 1.0}, slip=np.zeros((9, 2))).plot_deformed()
    # The faces of all bodies are one collection, in the colours of the two bodies.
    (faces,) = [one for one in ax.collections if isinstance(one, Poly3DCollection)]
    assert len(np.unique(faces.get_facecolor(), axis=0)) == 2


def test_a_filled_face_leaves_its_hole_out_and_joins_no_contacts():
    """A filled face leaves its hole out and joins no contacts.

    The face is a ring. The area of its triangles is the area of a regular polygon less the area of
    its hole.
    """
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.concatenate(
        [
            radius * np.column_stack([np.cos(angle), np.sin(angle)])
            for radius in (2.0, 2.5, 3.0, 3.5)
        ]
    )
    points = np.pad(ring, ((0, 0), (0, 1)))
    S = np.eye(3 * len(points))
    loads = {
        "P": np.repeat([0.0, 0.0, 1.0], len(points)),
        "Q": np.repeat([0.5, 0.0, 0.0], len(points)),
    }
    contact = fo.ContactSystem(S, points, loads)
    ax = fo.shakedown_limit(contact, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), F).plot()
    # The colours of the ring have its area, up to the size of a cell.
    assert area_of_colours(ax) == pytest.approx(
        24 * np.sin(2 * np.pi / 24) / 2 * (3.5**2 - 2.0**2), rel=0.02
    )
    mesh = triangles.neighbours(contact.contact, ring, np.ones(len(points), dtype=bool), None)
    corners = ring[mesh.get_masked_triangles()]
    sides = corners[:, 1:] - corners[:, :1]
    assert np.abs(np.linalg.det(sides)).sum() == pytest.approx(
        24 * np.sin(2 * np.pi / 24) * (3.5**2 - 2.0**2), rel=0.02
    )
    halves = replace(contact, contact=["a"] * 48 + ["b"] * 48)
    apart = triangles.neighbours(
        halves.contact, ring, np.ones(len(points), dtype=bool), None
    ).get_masked_triangles()
    assert ((apart < 48).all(axis=1) | (apart >= 48).all(axis=1)).all()


def test_a_fine_rim_of_a_hole_is_not_filled():
    """The fine rim of a hole is not filled.

    The nodes are on circles, and the nodes of the hole are closer than the circles are. Short
    chords of the hole are shorter than the edges beside them.
    """
    count, radii = 32, np.array([1.0, 1.5, 2.0])
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    ring = np.concatenate(
        [radius * np.column_stack([np.cos(angle), np.sin(angle)]) for radius in radii]
    )
    polygon = count * np.sin(2 * np.pi / count) / 2  # area over the square of the radius
    limits = np.array([radii[0], *((radii[1:] + radii[:-1]) / 2), radii[-1]])
    width = np.repeat(polygon * np.diff(limits**2) / count, count)
    points, n = np.pad(ring, ((0, 0), (0, 1))), len(ring)
    loads = {"P": np.repeat([0.0, 0.0, 1.0], n), "Q": np.repeat([0.5, 0.0, 0.0], n)}
    for turned in (False, True):  # a ring seen along its normal, and one that leans
        turn = (
            np.eye(3)
            if not turned
            else np.array([[0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [0.8, 0.0, 0.6]])
        )
        contact = fo.ContactSystem(
            np.eye(3 * n),
            points @ turn,
            loads,
            frames=np.repeat(turn[None], n, axis=0),
            width=width,
        )
        ax = fo.shakedown_limit(
            contact, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), F
        ).plot()
        area = polygon * (radii[-1] ** 2 - radii[0] ** 2)
        assert area_of_colours(ax) == pytest.approx(area, rel=5e-3)


@pytest.mark.parametrize("many", few([4, 6, 1, 2, 3, 5, 7, 8, 9]))
def test_pictures_of_many_contacts_do_not_wait_for_the_garbage_collector(many):
    """Spare panels of a grid must leave nothing behind that a later drawing would meet."""
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    n = 4 * many
    points = np.concatenate([square + [3.0 * k, 0.0, float(k)] for k in range(many)])
    # Seen from below, with other names of axes.
    turned = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    frames = np.repeat([turned if k % 3 == 2 else np.eye(3) for k in range(many)], 4, axis=0)
    loads = {"P": np.repeat([0.0, 0.0, 1.0], n), "Q": np.repeat([0.5, 0.0, 0.0], n)}
    names = np.repeat([f"c{k}" for k in range(many)], 4)
    contact = fo.ContactSystem(
        np.eye(3 * n), points, loads, frames=frames, contact=names, width=np.ones(n)
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    options = {"friction": F, "load_factor": 0.5, "steps": 2, "progress": False}
    results = (
        fo.wear(contact, cycle, coefficient=1e-3, cycles=2, **options),
        fo.steady_state(contact, cycle, **options),
    )
    gc.disable()
    try:
        for result in results:
            axes = result.plot()
            np.ravel(axes)[0].figure.savefig(io.BytesIO(), format="png")
    finally:
        gc.enable()
