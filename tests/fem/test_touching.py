"""Faces of two bodies that lie on each other without a contact.

They are compared with the overlaps of intervals and rectangles.
"""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem import MeshHex, MeshQuad, MeshTet, MeshTri

import frictopt as fo
from frictopt.fem.faces import Face, facet_overlaps, neighbours, normals_of
from frictopt.fem.mortar import check_touching
from helpers.cases import few
from helpers.meshes import blocks, hung, rotation, turned, uniform_loads

FEET = [(-12.0, -7.0), (-2.5, 2.5), (7.0, 12.0)]


def bridge(feet=(0, 1, 2), angle=0.0, kind=MeshQuad, gap=None):
    """A pad on three feet on a wider block, with a contact of some of the feet."""
    pad = kind.init_tensor(
        np.array([-12.0, -9.5, -7.0, -2.5, 0.0, 2.5, 7.0, 9.5, 12.0]), np.array([0.0, 1.0, 2.0])
    )
    centre = pad.p[:, pad.t].mean(axis=1)
    pad = pad.remove_elements(
        np.flatnonzero(
            (centre[1] < 1) & np.all([(centre[0] < a) | (centre[0] > b) for a, b in FEET], axis=0)
        )
    )
    feet_of = {
        f"foot {i}": lambda x, a=a, b=b: (x[1] == 0) & (a < x[0]) & (x[0] < b)
        for i, (a, b) in enumerate(FEET)
    }
    pad = pad.with_boundaries({**feet_of, "top": lambda x: x[1] == 2})
    block = kind.init_tensor(np.linspace(-15, 15, 14), np.array([-3.0, -1.0, 0.0])).with_boundaries(
        {"top": lambda x: x[1] == 0, "bottom": lambda x: x[1] == -3}
    )
    return fo.fem.ContactModel(
        {"pad": fo.fem.Body(turned(pad, angle)), "block": fo.fem.Body(turned(block, angle))},
        [fo.fem.Support("block", "bottom")],
        {"P": [fo.fem.Traction("pad", "top", y=-1.0)]},
        [fo.fem.Contact("pad", "block", f"foot {i}", "top", gap=gap) for i in feet],
    )


@pytest.mark.parametrize("kind", [MeshQuad, MeshTri])
@pytest.mark.parametrize("angle", [0.0, 0.5, -0.7])
def test_a_forgotten_foot_is_named_by_a_place_in_it(kind, angle):
    assert bridge(angle=angle, kind=kind, gap="measured").contacts
    for forgotten, (left, right) in enumerate(FEET):
        with pytest.raises(
            fo.ModelError,
            match=r"contacts: bodies 'pad' and 'block' touch around \(\S+, \S+\), without a contact",
        ) as error:
            bridge([i for i in range(3) if i != forgotten], angle, kind)
        place = [float(x) for x in re.search(r"around \((\S+), (\S+)\)", str(error.value)).groups()]
        x, y = rotation(-angle) @ place
        assert left < x < right and abs(y) < 1e-4


def test_bodies_that_meet_in_a_point_or_look_the_same_way_do_not_touch():
    square = MeshQuad.init_tensor([0.0, 1.0, 2.0], [0.0, 1.0, 2.0])
    # The last: two bodies in one place.
    for by in ([2.0, 2.0], [0.0, 2.0 + 1e-6], [3.0, 0.0], [0.0, 0.0]):
        check_touching({"one": fo.fem.Body(square), "two": fo.fem.Body(square.translated(by))}, {})
    with pytest.raises(fo.ModelError, match=r"around \(2, 1.5\)"):
        check_touching(
            {"one": fo.fem.Body(square), "two": fo.fem.Body(square.translated([2.0, 1.0]))}, {}
        )


@pytest.mark.parametrize("degrees", [0, 30, 55, 65, 80])
def test_facets_face_each_other_up_to_sixty_degrees(degrees):
    """Two edges cross in the middle: the projection of one edge covers the cosine of the other."""
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))]) / 2
    edge, ends = np.array([[0, 1]]), np.array([[-0.5, 0.0], [0.5, 0.0]])
    faces = (Face(edge, points, 0 * points) for points in (ends, np.array([along, -along])))
    overlaps = facet_overlaps(*faces)
    shared = np.cos(np.radians(degrees)) if degrees <= 60 else 0.0
    assert overlaps.weights.sum() == pytest.approx(shared, rel=1e-12)


@settings(max_examples=few(30))
@given(
    seed=st.integers(0, 10**6),
    kind=st.sampled_from([MeshQuad, MeshTri, MeshHex, MeshTet]),
    apart=st.booleans(),
)
def test_random_boxes_touch_where_their_faces_overlap(seed, kind, apart):
    """Two boxes are one above the other, cut at random places. They touch if the gap is zero and
    the faces overlap in every direction."""
    rng = np.random.default_rng(seed)
    d = 2 if kind in (MeshQuad, MeshTri) else 3
    spans = [
        np.sort(rng.choice(np.linspace(0, 2, 5), 2, replace=False)) for _ in range(2 * (d - 1))
    ]
    cuts = [np.unique(np.r_[span, rng.uniform(*span, size=rng.integers(3))]) for span in spans]
    upper = kind.init_tensor(*cuts[: d - 1], np.array([0.0, 0.4, 1.0]) + 0.1 * apart)
    lower = kind.init_tensor(*cuts[d - 1 :], np.array([-1.0, 0.0]))
    turn = np.linalg.qr(rng.normal(size=(d, d)))[0]
    turn[0] *= np.linalg.det(turn)
    bodies = {
        name: fo.fem.Body(kind(turn @ mesh.p, mesh.t))
        for name, mesh in (("upper", upper), ("lower", lower))
    }
    overlaps = all(
        min(a[1], b[1]) > max(a[0], b[0])
        for a, b in zip(spans[: d - 1], spans[d - 1 :], strict=True)
    )
    if overlaps and not apart:
        with pytest.raises(fo.ModelError, match="bodies 'upper' and 'lower' touch"):
            check_touching(bodies, {})
    else:
        check_touching(bodies, {})


def test_facets_far_away_have_normals_as_exact_as_their_corners():
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    corners = 1e-5 * np.array(
        [[[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [1.2, 1.0, 0.0], [0.0, 1.0, 0.0]]]
    ) @ turn.T + [100.0, -200.0, 300.0]
    normal = turn[:, 2] * np.linalg.det(turn)
    assert np.allclose(normals_of(corners), normal, atol=1e-7)
    assert np.allclose(normals_of(corners[:, :3]), normal, atol=1e-7)


@pytest.mark.parametrize("axes", [2, 3])
def test_neighbours_of_unlike_sizes_are_all_that_are_within_reach(axes):
    rng = np.random.default_rng(axes)
    places, others = rng.normal(size=(60, axes)), rng.normal(size=(80, axes))
    reach, radii = (10.0 ** rng.uniform(-3, 0.5, count) for count in (60, 80))
    found = np.array(neighbours(places, reach, others, radii)).T
    near = np.linalg.norm(places[:, None] - others, axis=-1) <= reach[:, None] + radii
    assert sorted(found.tolist()) == np.argwhere(near).tolist()


def test_a_facet_beside_a_contact_is_a_part_of_it_or_refused():
    """It has a node of the contact, and lies on the other body."""
    bodies = blocks()
    part = bodies["punch"].mesh.with_boundaries({"part": lambda x: (x[1] == 0) & (x[0] < 0.1)})
    with pytest.raises(fo.ModelError, match="bodies 'punch' and 'block' touch around"):
        fo.fem.ContactModel(
            {**bodies, "punch": fo.fem.Body(part)},
            hung(),
            uniform_loads(),
            [fo.fem.Contact("punch", "block", "part")],
        )
