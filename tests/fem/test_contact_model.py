import re

import numpy as np
import pytest
from skfem import MeshHex, MeshLine, MeshQuad, MeshTri2

import frictopt as fo
from helpers.meshes import blocks, hung, ring, uniform_loads

FREE, LOADS = hung(), uniform_loads()


PUNCH, BLOCK = blocks().values()
BOTH = {"punch": PUNCH, "block": BLOCK}
GOOD = {"bodies": BOTH, "supports": FREE, "loads": LOADS}


def moved(body, by, **boundaries):
    """A body moved, with more boundaries named."""
    mesh = type(body.mesh)(body.mesh.p + np.array(by)[:, None], body.mesh.t).with_boundaries(
        body.mesh.boundaries
    )
    return fo.fem.Body(mesh.with_boundaries(boundaries) if boundaries else mesh)


def mirrored(body):
    return fo.fem.Body(
        MeshQuad(body.mesh.p * [[1.0], [-1.0]], body.mesh.t).with_boundaries(body.mesh.boundaries)
    )


CORNERED = fo.fem.Body(
    PUNCH.mesh.with_boundaries({"two sides": lambda x: (x[1] == 0) | (x[1] == 1)})
)
PINCHED = MeshQuad.init_tensor(np.arange(4.0), np.arange(4.0)).remove_elements(np.array([0, 4]))
PINCHED = fo.fem.Body(PINCHED.with_boundaries({"outline": lambda x: x[0] > -1}))
INNER = fo.fem.Body(
    PUNCH.mesh.with_boundaries({"contact": lambda x: np.isclose(x[1], 0.4)}, boundaries_only=False)
)
WALL = fo.fem.Body(
    MeshQuad.init_tensor([-3.0, -1.0], [0.0, 0.4, 1.0]).with_boundaries(
        {"wall": lambda x: x[0] == -1.0}
    )
)
FLOOR = fo.fem.Body(
    MeshQuad.init_tensor([-1.0, 1.0], [2.0, 3.0]).with_boundaries({"under": lambda x: x[1] == 2.0})
)
BAD_MODELS = {
    "at (-1, 0.5): the faces do not touch, they are 0.5 apart": {
        "bodies": {**BOTH, "punch": moved(PUNCH, [0.0, 0.5])}
    },
    "at (-1, -0.01): the bodies overlap by 0.01": {
        "bodies": {**BOTH, "punch": moved(PUNCH, [0.0, -0.01])}
    },
    "of body 'punch' around (-0.75, 0) has no opposite part of body 'block'": {
        "bodies": {**BOTH, "punch": mirrored(PUNCH)}
    },
    "the elements of the two bodies must lie on opposite sides": {
        "bodies": {**BOTH, "block": mirrored(BLOCK)}
    },
    "boundary 'two sides' is in several pieces, one at": {
        "bodies": {**BOTH, "punch": CORNERED},
        "contacts": [fo.fem.Contact("punch", "block", "two sides")],
    },
    "boundary 'outline' touches itself at (1, 1)": {
        "bodies": {**BOTH, "punch": PINCHED},
        "contacts": [fo.fem.Contact("punch", "block", "outline")],
    },
    "contact 'contact', body 'punch': boundary 'joint' is unknown; this mesh names": {
        "contacts": [fo.fem.Contact("punch", "block", "joint", name="contact")]
    },
    "; name it in the mesh, or with mesh.with_boundaries": {
        "contacts": [fo.fem.Contact("punch", "block", "joint", name="contact")]
    },
    "contacts: body: 'bolt'; give 'punch' or 'block'": {
        "contacts": [fo.fem.Contact("bolt", "block")]
    },
    "contact 'contact', at (-1, 0): gap -1; give gaps >= 0": {
        "contacts": [fo.fem.Contact("punch", "block", gap=lambda x, y: x)]
    },
    "contact 'contact': gap: the function raised": {
        "contacts": [fo.fem.Contact("punch", "block", gap=lambda x: x)]
    },
    "facets inside the body": {"bodies": {**BOTH, "punch": INNER}},
    "contacts: two contacts are called 'contact'": {
        "contacts": [fo.fem.Contact("punch", "block")] * 2
    },
    "contacts: none, with 3 bodies": {"bodies": {**BOTH, "wall": WALL}},
    "bodies['punch']: a MeshQuad1; give a Body": {"bodies": {**BOTH, "punch": PUNCH.mesh}},
    "supports: body: 'bolt'; give 'punch' or 'block'": {
        "supports": [fo.fem.Support("bolt", "top")]
    },
    "no node at (0.0, 5.0)": {"supports": [fo.fem.Support("block", (0.0, 5.0))]},
    "loads['p']: body: 'bolt'; give 'punch' or 'block'": {
        "loads": {"p": [fo.fem.Traction("bolt", "top", y=1.0)]}
    },
    "loads['p']: boundary 'roof' is unknown": {
        "loads": {"p": [fo.fem.Traction("punch", "roof", y=1.0)]}
    },
    "loads['fit']: contact: 'bore'; give 'contact'": {
        "loads": {"fit": [fo.fem.Interference("bore", 0.1)]}
    },
    "loads['p']: no load; give at least one": {"loads": {"p": []}},
}


@pytest.mark.parametrize("message", BAD_MODELS)
def test_bad_models_are_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        fo.fem.ContactModel(**{**GOOD, **BAD_MODELS[message]})


UNHELD = {
    "the body at (-1, 0), with all that contacts glue to it, can still turn; add a Support": {
        "supports": FREE[:1]
    },
    "can still move along x and y and turn; add": {"supports": []},
    "can still move along x; add": {"supports": [fo.fem.Support("block", "bottom", "y")]},
    "can still move along y and turn; add": {
        "supports": [fo.fem.Support("block", (-0.5, -1.0), "x")]
    },
    "the body at (-1, 2), with all that contacts glue to it, can still move along x and y and turn": {
        "bodies": {**BOTH, "floor": FLOOR},
        "contacts": [fo.fem.Contact("punch", "block")],
    },
    "pairs: the relative motion of pair 0, of node 0 of body 1, follows from other pairs or from supports": {
        "supports": [
            *FREE,
            fo.fem.Support("punch", "left", "y"),
            fo.fem.Support("block", "left", "y"),
        ]
    },
}


@pytest.mark.parametrize("message", UNHELD)
def test_bodies_that_are_not_held_or_held_on_the_contact_are_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        fo.fem.ContactModel(**{**GOOD, **UNHELD[message]}).condense()


def test_bad_parts_are_refused():
    apart = MeshQuad.init_tensor([0.0, 1.0, 2.0, 3.0], [0.0, 1.0]).remove_elements(np.array([1]))
    hinge = MeshQuad.init_tensor([0.0, 1.0, 2.0], [0.0, 1.0, 2.0]).remove_elements(np.array([1, 2]))
    for make, message in {
        lambda: fo.fem.Body(apart): "2 parts that share no edge",
        lambda: fo.fem.Body(hinge): "2 parts that share no edge",
        lambda: fo.fem.Body(
            MeshLine()
        ): "mesh: a MeshLine1; give one of scikit-fem with elements of one shape, linear or quadratic: MeshTri1, MeshQ",
        lambda: fo.fem.Body(
            MeshTri2(), element="mean_dilatation"
        ): "element: 'mean_dilatation', but the mesh is a MeshTri2 with quadratic elements",
        lambda: fo.fem.Body(MeshQuad(), element="cubic"): "element: 'cubic'",
        lambda: fo.fem.Support("punch", "top", "yx"): "directions: 'yx'",
        lambda: fo.fem.Contact("punch", "punch"): "a face cannot touch itself",
        lambda: fo.fem.Contact(
            "punch", "block", gap=0.1
        ): "gap: 0.1; give 'measured' or a function",
    }.items():
        with pytest.raises(fo.ModelError, match=message):
            make()


def test_bad_elements_are_refused():
    square = MeshQuad.init_tensor([0.0, 1.0, 2.0], [0.0, 1.0])
    for place, message in (
        ((3.0, 5.0), "not convex"),
        ((1.0, 0.0), "no area"),
        ((np.nan, 0.0), "not finite"),
        ((np.inf, 0.0), "not finite"),
    ):
        points = square.p.copy()
        points[:, 0] = place
        with pytest.raises(fo.ModelError, match=message):
            fo.fem.Body(MeshQuad(points, square.t, sort_t=False))
    with pytest.raises(fo.ModelError, match="not convex or have no volume"):
        fo.fem.Body(MeshHex(MeshHex().p * [[1.0], [1.0], [0.0]], MeshHex().t))
    # At a straight corner the map from the square is singular.
    straight = np.array([[0.0, 1.0, 2.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    for order in ([0, 1, 2, 3], [3, 2, 1, 0]):
        with pytest.raises(
            fo.ModelError, match="mesh: elements that are not convex or have no area: 1,"
        ):
            fo.fem.Body(MeshQuad(straight, np.array(order)[:, None]))


def test_a_punch_in_a_socket_is_accepted():
    """The elements at the interface decide which body is above, not the place of most nodes."""
    punch = blocks()["punch"]
    walls = MeshQuad.init_tensor(
        [-3.0, -2.0, -1.0, -0.5, 0.1, 1.0, 2.0, 3.0], [-1.0, 0.0, 5.0, 5.1, 5.2, 5.3]
    )
    centre = walls.p[:, walls.t].mean(axis=1)
    walls = walls.remove_elements(np.flatnonzero((np.abs(centre[0]) < 2) & (centre[1] > 0)))
    walls = walls.with_boundaries(
        {"contact": lambda x: (x[1] == 0.0) & (np.abs(x[0]) < 1), "bottom": lambda x: x[1] == -1.0}
    )
    load = {"p": [fo.fem.Traction("punch", "top", y=-1.0)]}
    system = fo.fem.ContactModel(
        {"punch": punch, "block": fo.fem.Body(walls)},
        supports=[fo.fem.Support("block", "bottom")],
        loads=load,
    ).condense()
    assert system.reaction({"p": 1.0})[1].sum() == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize("contrast", [1e-12, 1e12])
def test_a_stiff_body_1_on_a_soft_one_is_refused_and_the_reverse_is_exact(contrast):
    bodies = {
        "punch": blocks()["punch"],
        "block": fo.fem.Body(blocks()["block"].mesh, fo.fem.Material(E=contrast)),
    }
    held = [fo.fem.Support("block", "bottom"), fo.fem.Support("punch", "top")]
    load = {"tau": [fo.fem.Traction("block", "left", x=1.0)]}
    soft, stiff = ("punch", "block") if contrast > 1 else ("block", "punch")
    with pytest.raises(fo.ModelError, match=r"bodies 1 are so much stiffer.*exchange the bodies"):
        fo.fem.ContactModel(bodies, held, load, [fo.fem.Contact(stiff, soft)]).condense()
    S = fo.fem.ContactModel(bodies, held, load, [fo.fem.Contact(soft, stiff)]).condense().S
    rigid = fo.fem.Body(bodies[stiff].mesh, fo.fem.Material(E=1e3 * bodies[stiff].material.E))
    limit = (
        fo.fem.ContactModel({**bodies, stiff: rigid}, held, load, [fo.fem.Contact(soft, stiff)])
        .condense()
        .S
    )
    assert np.allclose(S, limit, rtol=0, atol=1e-10 * np.abs(S).max())


@pytest.mark.parametrize("elements", [(12, 96), (96, 12)])
def test_the_chords_of_a_coarse_circle_touch_a_fine_one(elements):
    """A shaft is in its hub. The nodes of one circle are off the chords of the other by up to R (1
    - cos(pi / n)), which is no gap; a real gap is a gap."""

    def fit(gap):
        shaft = ring([0.5, 1.0 - gap], elements[0], "bore", "seat")
        hub = ring([1.0, 2.0], elements[1], "seat", "rim")
        loads = {"P": [fo.fem.Pressure("hub", "rim", 1.0)]}
        contact = (
            [fo.fem.Contact("shaft", "hub", "seat", "seat")],
            [fo.fem.Contact("hub", "shaft", "seat", "seat")],
        )
        return [
            fo.fem.ContactModel(
                {"shaft": fo.fem.Body(shaft), "hub": fo.fem.Body(hub)},
                [fo.fem.Support("shaft", "bore")],
                loads,
                c,
            )
            for c in contact
        ]

    for model in fit(0.0):
        assert not model.condense().gap.any()
    for gap in (0.1, 1.3 * (1 - np.cos(np.pi / np.array(elements))).sum()):
        with pytest.raises(fo.ModelError, match="the faces do not touch"):
            fit(gap)


@pytest.mark.parametrize("angle", [0.0, 0.6, 2.9])
def test_the_coordinate_of_two_contacts_on_a_line_has_the_gap_between_them(angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def block(x, y):
        mesh = MeshQuad.init_tensor(np.array(x), np.array(y)).with_boundaries(
            {"face": lambda x: x[1] == 0, "far": lambda x: np.abs(x[1]) == 1}
        )
        return fo.fem.Body(MeshQuad(turn @ mesh.p, mesh.t, mesh.boundaries))

    system = fo.fem.ContactModel(
        {
            "base": block(np.arange(11.0), [-1.0, 0.0]),
            "left": block([1.0, 2.0, 3.0], [0.0, 1.0]),
            "right": block([7.0, 7.5, 8.0], [0.0, 1.0]),
        },
        [fo.fem.Support("base", "far")],
        {"P": [fo.fem.Pressure("left", "far"), fo.fem.Pressure("right", "far")]},
        [fo.fem.Contact(name, "base", "face", "face", name=name) for name in ("left", "right")],
    ).condense()
    assert system.x == pytest.approx([1.0, 2.0, 3.0, 7.0, 7.5, 8.0], abs=1e-9)
