"""Names of nine contacts do not overlap.

The names are in a picture in the plane, and on a map.
"""

import itertools
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.text import Text
from skfem import MeshHex, MeshQuad

import frictopt as fo

FEET = [f"bolt hole {i}" for i in range(9)]
CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])


def feet(tangents):
    """Nine contacts of 2 x 2 nodes in a row on their own springs, the first one tilted in space.

    In the plane they have 2 nodes each.
    """
    n = 18 * tangents
    place = np.repeat(1.2 * np.arange(9), 2 * tangents) + np.tile([0.0, 0.6], 9 * tangents)
    points = np.column_stack(
        [place, *[np.tile([0.0, 0.0, 0.6, 0.6], 9)] * (tangents - 1), np.zeros(n)]
    )
    names, one, none = np.repeat(FEET, 2 * tangents), np.ones(n), np.zeros(n)
    loads = {
        "P": np.concatenate([*[none] * tangents, one]),
        "Q": np.concatenate([0.2 * one, *[none] * tangents]),
    }
    frames = np.tile(np.eye(tangents + 1), (n, 1, 1))
    if tangents == 2:
        frames[:4] = frames[:4] @ [[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]]
    return fo.ContactSystem(np.eye((tangents + 1) * n), points, loads, frames=frames, contact=names)


def named(axes):
    axes = np.ravel(axes)[0]
    axes.figure.canvas.draw()
    texts = [
        text for text in axes.figure.findobj(Text) if text.get_text() in FEET and text.get_visible()
    ]
    assert sorted(text.get_text() for text in texts) == FEET
    return texts


@pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
def test_names_along_a_contact_and_on_a_map_stand_beside_each_other(tangents):
    texts = named(fo.shakedown_limit(feet(tangents), CYCLE, 0.5).plot())
    boxes = []
    for text in texts:
        middle = np.mean(text.get_window_extent().get_points(), axis=0)
        angle = np.deg2rad(text.get_rotation())
        text.set_rotation(0.0)
        half = np.ptp(text.get_window_extent().get_points(), axis=0) / 2
        centre = (
            np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) @ middle
        )
        boxes.append((centre - half, centre + half))
    assert all(
        (high < least).any() or (most < low).any()
        for (low, high), (least, most) in itertools.combinations(boxes, 2)
    )
    plt.close("all")


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
def test_contacts_of_a_model_have_numbers_at_their_places_and_names_in_the_legend(space):
    kind, depth = (MeshHex, [np.linspace(0.0, 0.6, 2)]) if space else (MeshQuad, [])
    sides = {"low": lambda x: x[-1] == x[-1].min(), "top": lambda x: x[-1] == x[-1].max()}
    across = [1.2 * i + np.array([0.0, 0.6]) for i in range(9)]
    above = {
        name: kind.init_tensor(x, *depth, np.array([0.0, 0.5]))
        for name, x in zip(FEET, across, strict=True)
    }
    meshes = above | {"base": kind.init_tensor(np.unique(across), *depth, np.array([-1.0, 0.0]))}
    bodies = {name: fo.fem.Body(mesh.with_boundaries(sides)) for name, mesh in meshes.items()}
    contacts = [fo.fem.Contact(name, "base", "low", "top", name=name) for name in FEET]
    model = fo.fem.ContactModel(
        bodies, [fo.fem.Support("base", "low")], {"P": [fo.fem.Pressure(FEET[0], "top")]}, contacts
    )
    axes = model.plot()
    numbers = {text.get_text(): text for text in axes.texts}
    (legend,) = axes.figure.legends
    named = {text.get_text() for text in legend.get_texts()}
    for number, (name, x) in enumerate(zip(FEET, across, strict=True), start=1):
        text = numbers[f"{number}"]
        place = text.get_position_3d() if space else text.get_position()
        assert place == pytest.approx((x.mean(), 0.3, 0.0) if space else (x.mean(), 0.0))
        assert f"{number}: {name}" in named
    plt.close("all")


PRESSES, PUSHES = r"$\frac{$", "_a$b$c_{^%"
BODY, LEFT, RIGHT = "_steel$", "$left$", "100%_"


def marked():
    """Two contacts of two nodes, whose names and loads have signs of markup."""
    joint = feet(1)
    loads = {PRESSES: joint.bonded["P"], PUSHES: joint.bonded["Q"]}
    loads = {name: (q[:4], p[:4]) for name, (q, p) in loads.items()}
    names = [LEFT, LEFT, RIGHT, RIGHT]
    return fo.ContactSystem(np.eye(8), joint.points[:4], loads, contact=names, units="N$, m$")


def marked_model():
    square = MeshQuad().with_boundaries(SIDES)
    bodies = {
        name: fo.fem.Body(square.translated((0.0, k))) for k, name in enumerate([BODY, "b", "c"])
    }
    contacts = [
        fo.fem.Contact("b", BODY, "low", "top", name=LEFT),
        fo.fem.Contact("c", "b", "low", "top", name=RIGHT),
    ]
    loads = {PRESSES: [fo.fem.Pressure("c", "top")]}
    return fo.fem.ContactModel(bodies, [fo.fem.Support(BODY, "low")], loads, contacts)


SIDES = {"low": lambda x: x[1] == x[1].min(), "top": lambda x: x[1] == x[1].max()}
TO_AND_FRO = fo.LoadCycle({PRESSES: 1.0}, [{PUSHES: 1.0}, {PUSHES: -1.0}])
DRAWN = {
    "system": (lambda: marked().plot(), [PRESSES, PUSHES, LEFT, RIGHT, "(m$)"]),
    "limit": (lambda: fo.shakedown_limit(marked(), TO_AND_FRO, 0.5).plot(), [PUSHES, LEFT, RIGHT]),
    "onset": (lambda: fo.onset(marked(), TO_AND_FRO, 0.5).plot(), [PUSHES, LEFT]),
    "steady": (
        lambda: fo.steady_state(marked(), TO_AND_FRO, 0.5, 2.0, progress=False).plot(),
        [PUSHES, LEFT, RIGHT, "N$m$"],
    ),
    "model": (lambda: marked_model().plot(), [BODY, LEFT, RIGHT, PRESSES]),
    "study": (
        lambda: fo.plot_study(
            fo.dissipation_study(
                marked(), {LEFT: TO_AND_FRO}, 0.5, [2.0],
                fo.starts.given_slips([[0.0] * 4], family=PRESSES), progress=False,
            ),
            x="cycle",
        ),
        [LEFT, PRESSES],
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", DRAWN)
def test_names_with_signs_of_markup_are_drawn_as_they_are(kind, tmp_path):
    """The texts of an SVG file are what a reader sees; of a formula they are single letters."""
    draw, names = DRAWN[kind]
    with plt.rc_context({"svg.fonttype": "none"}):
        np.ravel(draw())[0].figure.savefig(tmp_path / "a.svg")
    plt.close("all")
    texts = ElementTree.parse(tmp_path / "a.svg").iter("{http://www.w3.org/2000/svg}text")
    seen = ["".join("".join(text.itertext()).split()) for text in texts]
    for name in names:
        assert any(name in text for text in seen)
