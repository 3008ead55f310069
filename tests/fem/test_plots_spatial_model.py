"""The picture of a model in three dimensions.

Its faces, contact, held nodes and loads are those of the model.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from mpl_toolkits.mplot3d import Axes3D, proj3d
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import frictopt as fo
from helpers.meshes import column

SCENE = fo.scenes.SquarePunch(elements=4, growth=2.0)


@pytest.fixture
def drawn(monkeypatch):
    """The axes, polygons and arrows of a picture.

    Polygons are sorted by label, the polygons of a body by its colour. Arrows are sorted by colour,
    with their beginnings and steps.
    """
    polygons, arrows, (begin, quiver) = {}, {}, (Poly3DCollection.__init__, Axes3D.quiver)

    def kept_polygons(collection, corners, *more, label=None, facecolors=(), **look):
        if label is not None:
            polygons[label] = corners
        else:
            for polygon, (color, _) in zip(corners, facecolors, strict=True):
                polygons.setdefault(color, []).append(polygon)
            look["facecolors"] = facecolors
        begin(collection, corners, *more, label=label, **look)

    def kept_arrows(axes, x, y, z, *step, color, **look):
        arrows.setdefault(color, []).append((np.column_stack([x, y, z]), np.column_stack(step)))
        return quiver(axes, x, y, z, *step, color=color, **look)

    monkeypatch.setattr(Poly3DCollection, "__init__", kept_polygons)
    monkeypatch.setattr(Axes3D, "quiver", kept_arrows)
    yield SCENE.plot(), polygons, arrows
    plt.close("all")


def area(corners):
    """Area of a plane polygon whose corners go round it."""
    return (
        float(
            np.linalg.norm(
                sum(
                    np.cross(corners[k] - corners[0], corners[k + 1] - corners[0])
                    for k in range(1, len(corners) - 1)
                )
            )
        )
        / 2
    )


def test_the_faces_cover_the_bodies_and_the_contact(drawn):
    axes, polygons, _ = drawn
    assert sum(map(area, polygons["contact"])) == pytest.approx(4.0)
    assert np.all(polygons["contact"][:, :, 2] == 0)
    areas = {"punch": 2 * 4.0 + 4 * 2 * 1.5, "block": 2 * 64.0 + 4 * 8 * 3.0}
    for name, expected in areas.items():
        (color,) = [line.get_color() for line in axes.lines if line.get_label() == name]
        assert sum(map(area, polygons[color])) == pytest.approx(expected)


def test_marks_are_held_nodes_and_arrows_go_with_the_loads(drawn):
    axes, _, arrows = drawn
    (held,) = [line for line in axes.lines if line.get_label() == "held in x, y, z"]
    assert len(held.get_data_3d()[0]) == 25 and np.all(held.get_data_3d()[2] == -3.0)
    directions = {
        "load P": [[0, 0, -1]],
        "load Qx": [[1, 0, 0]],
        "load Qy": [[0, 1, 0]],
        "load sigma": [[-1, 0, 0], [1, 0, 0]],
    }
    for label, wanted in directions.items():
        (color,) = [line.get_color() for line in axes.lines if line.get_label() == label]
        found = arrows.pop(color)
        steps = [(step / np.linalg.norm(step, axis=1)[:, None]).round(9) + 0.0 for _, step in found]
        assert sorted(np.unique(step, axis=0).tolist() for step in steps) == [
            [direction] for direction in wanted
        ]
        assert all(len(np.unique(begin, axis=0)) == 9 for begin, _ in found)
        if label == "load P":  # pressure ends on the top
            assert np.allclose((found[0][0] + found[0][1])[:, 2], 1.5)
        if label == "load sigma":  # tension begins on the sides
            assert all(np.allclose(begin[:, 0], 4 * np.sign(step[0, 0])) for begin, step in found)
    assert not arrows


def test_everything_is_inside_and_has_a_name(drawn):
    axes, _, _ = drawn
    axes.figure.draw_without_rendering()
    low, high = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()]).T
    assert np.all(low < [-4, -4, -3]) and np.all(high > [4, 4, 1.5])
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == [
        f"${name}$ (length)" for name in "xyz"
    ]
    (legend,) = axes.figure.legends
    loads = [f"load {case}" for case in ("P", "Qx", "Qy", "sigma")]
    assert [text.get_text() for text in legend.get_texts()] == [
        "punch",
        "block",
        "contact",
        "held in x, y, z",
        *loads,
    ]


def test_fields_show_the_von_mises_stress_on_the_surfaces():
    load = {
        "P": [fo.fem.Pressure("a", "top", 3.0)],
        "Q": [fo.fem.Traction("a", "top", x=lambda x, y, z: x)],
    }
    model = column(loads=load)
    axes = model.recover({"P": 1.0}, np.zeros((9, 2))).plot()
    (faces,) = axes.collections
    assert len(faces.get_array()) == 48 and np.allclose(faces.get_array(), 3.0)
    assert axes.figure.axes[1].get_ylabel() == "von Mises stress (force per area)"
    assert axes.get_zlabel() == "$z$ (length)"
    axes.figure.draw_without_rendering()
    axes = column(
        loads=load, supports=[fo.fem.Support("b", "bottom", "z"), fo.fem.Support("b", (0, 0, -1))]
    ).plot()
    axes.figure.draw_without_rendering()
    assert {"held in z", "held in x, y, z", "load P", "load Q"} <= {
        line.get_label() for line in axes.lines
    }
    plt.close("all")


def test_the_moved_body_in_front_hides_the_other_one():
    """The top of the punch has the colour of the punch, not a mixture with that of the block."""
    model = SCENE.model()
    model = replace(
        model,
        bodies={
            name: replace(body, material=fo.fem.Material(density=1.0))
            for name, body in model.bodies.items()
        },
    )
    axes = model.modes(1).plot(0)
    axes.figure.canvas.draw()
    place = proj3d.proj_transform(0.2, 0.2, 1.5, axes.get_proj())[:2]
    x, y = axes.transData.transform(place).astype(int)
    seen = np.asarray(axes.figure.canvas.buffer_rgba())[::-1][y, x][:3] / 255
    (punch,) = [line.get_color() for line in axes.lines if line.get_label() == "punch"]
    assert np.allclose(seen, to_rgb(punch), atol=0.12)
    plt.close("all")


def test_body_forces_are_named_and_given_axes_must_be_in_space():
    model = SCENE.model()
    weight = {"weight": [fo.fem.BodyForce("punch", z=-1.0)]}
    heavy = fo.fem.ContactModel(model.bodies, model.supports, weight, model.contacts)
    axes = plt.figure().add_subplot(projection="3d")
    assert heavy.plot(axes) is axes
    assert "load weight (1 x body force)" in [
        text.get_text() for text in axes.get_legend().get_texts()
    ]
    with pytest.raises(fo.ModelError, match=r"^ax: .* projection='3d'"):
        heavy.plot(plt.figure().add_subplot())
    plt.close("all")
