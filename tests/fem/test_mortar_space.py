"""Faces in space whose meshes do not match.

They are compared with uniform stress at random rotations, the plane, closed forms, and exchanged
bodies. Faces that do not meet are refused.
"""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from skfem import MeshHex, MeshTet

import frictopt as fo
from helpers.meshes import RUBBER, THICK, box, extruded, ring, turned, two_blocks

KINDS = [(MeshTet, MeshTet), (MeshHex, MeshHex), (MeshTet, MeshHex), (MeshHex, MeshTet)]


def cylinders(n, m, hole=1.0, exchanged=False, start=0.1):
    """A hollow pin of n edges in a plate of m, in plane strain and in space."""
    flat = {
        "pin": ring([0.3, 0.6, 1.0], n, "bore", "surface"),
        "plate": ring([hole, 1.5, 3.0], m, "hole", "rim", start),
    }
    names = {
        name: lambda x, r=r: abs(np.hypot(*x[:2]) - r) < 0.05 * r
        for name, r in {"bore": 0.3, "surface": 1.0, "hole": hole, "rim": 3.0}.items()
    }
    loads = {
        "fit": [fo.fem.Interference("fit", 0.01)],
        "p": [fo.fem.Pressure("pin", "bore", 2.0)],
        "pull": [fo.fem.Traction("pin", "bore", x=1.0)],
    }
    sides = (
        ("plate", "pin", "hole", "surface") if exchanged else ("pin", "plate", "surface", "hole")
    )
    for meshes in (flat, {name: extruded(mesh) for name, mesh in flat.items()}):
        bodies = {
            name: fo.fem.Body(mesh.with_boundaries(names), RUBBER) for name, mesh in meshes.items()
        }
        inner = 1.0 if sides[0] == "pin" else hole
        across = [
            fo.fem.Support(name, tuple(at), "z")
            for name, mesh in meshes.items()
            for at in mesh.p.T
            if len(at) == 3 and (name != sides[0] or abs(np.hypot(*at[:2]) - inner) > 0.01)
        ]
        contact = fo.fem.Contact(*sides, name="fit", gap="measured" if hole > 1 else None)
        yield fo.fem.ContactModel(
            bodies, [fo.fem.Support("plate", "rim", "xy"), *across], loads, [contact]
        ).condense()


@pytest.mark.parametrize("exchanged", [False, True])
@pytest.mark.parametrize(
    ("n", "m", "start", "hole", "near"),
    # Elements that are no parallelograms are integrated otherwise.
    [(12, 12, 0.0, 1.0, 5e-4), (28, 22, 0.1, 1.0, 2e-3), (28, 22, 0.1, 1.02, 2e-2)],
)
def test_concentric_cylinders_have_the_contact_of_the_plane(n, m, start, hole, near, exchanged):
    """The plane projects from node to edge, and space along the normal of each facet. Over a gap
    the two differ by the share of the gap in the radius."""
    plane, space = cylinders(n, m, hole, exchanged, start)
    both = (
        np.linalg.norm(plane.points[:, None] - space.points[None, :, :2], axis=2) < 1e-9
    ).astype(float)
    assert np.allclose(both @ space.width, THICK * plane.width)
    assert np.allclose(both.T @ plane.normals, space.normals[:, :2])
    turn = np.einsum("na,nta->nt", both.T @ plane.frames[:, 0], space.frames[:, :2, :2])
    for case in plane.bonded:
        (q, p), (shear, pressure) = plane.bonded[case], space.bonded[case]
        assert np.allclose(both @ pressure, THICK * p, rtol=0, atol=near * np.abs(p).max())
        assert np.allclose(
            both @ (shear * turn).sum(axis=1), THICK * q, rtol=0, atol=near * np.abs(p).max()
        )
    sagitta = hole * (1 - np.cos(np.pi / m))
    assert np.abs(space.gap - (hole - 1)).max() < (sagitta if hole > 1 else 1e-12)


@pytest.mark.parametrize("lean", [0.0, 0.4])
def test_a_gap_may_be_far_larger_than_the_facets(lean):
    """Two flat faces are 50 apart, and one of them may lean. The gap is the distance along the
    normal of body 1."""
    turn = Rotation.from_rotvec([0.0, lean, 0.0]).as_matrix()
    large = box(MeshTet, np.linspace(-90, 90, 61), np.linspace(-3, 3, 5), [-1.0, 0.0])
    bodies = {
        "upper": fo.fem.Body(two_blocks(KINDS[0])["upper"].translated([0.0, 0.0, 50.0])),
        "lower": fo.fem.Body(turned(large, turn)),
    }
    contact = fo.fem.Contact("upper", "lower", gap="measured")
    system = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("lower", "z-")],
        {"P": [fo.fem.Traction("upper", "z+", z=-1.0)]},
        [contact],
    ).condense()
    assert np.allclose(system.gap, 50 + np.tan(lean) * system.points[:, 0], rtol=0, atol=1e-11)


def discs(n, m, exchanged=False):
    """Two flat discs of n and m edges and one radius, one on the other."""
    bodies = {}
    for name, edges, heights in (("upper", n, [0.0, 0.5]), ("lower", m, [-0.5, 0.0])):
        flat = ring([0.3, 0.65, 1.0], edges, "inner", "outer", start=0.05 * edges)
        mesh = extruded(flat)
        mesh = MeshHex(np.vstack([mesh.p[:2], heights[0] + mesh.p[2] / THICK * 0.5]), mesh.t)
        names = {
            "contact": lambda x: abs(x[2]) < 1e-9,
            "top": lambda x: x[2] > 0.4,
            "bottom": lambda x: x[2] < -0.4,
        }
        bodies[name] = fo.fem.Body(
            mesh.with_boundaries(
                {
                    k: f
                    for k, f in names.items()
                    if (k == "contact") or (k == "top") == (name == "upper")
                }
            )
        )
    contact = fo.fem.Contact("lower", "upper") if exchanged else fo.fem.Contact("upper", "lower")
    return fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("lower", "bottom")],
        {"P": [fo.fem.Traction("upper", "top", z=-1.0)]},
        [contact],
    )


@pytest.mark.parametrize("exchanged", [False, True])
def test_round_rims_miss_each_other_by_their_sag(exchanged):
    system = discs(20, 24, exchanged).condense()
    area = system.width.sum()
    polygons = [n / 2 * np.sin(2 * np.pi / n) * (1 - 0.3**2) for n in (20, 24)]
    assert area < min(polygons) * (1 + 1e-3) and area == pytest.approx(min(polygons), rel=0.02)
    assert system.bonded["P"][1].sum() == pytest.approx(polygons[0], rel=1e-12)


BODIES = {name: fo.fem.Body(mesh) for name, mesh in two_blocks((MeshHex, MeshTet)).items()}


def put(upper, lower=BODIES["lower"], **contact):
    bodies = {"upper": fo.fem.Body(upper), "lower": lower}
    fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("lower", "z-")],
        {"P": [fo.fem.Traction("upper", "z+", z=-1.0)]},
        [fo.fem.Contact("upper", "lower", **contact)],
    )


def stairs():
    """A shelf above a floor, both looking up, in one boundary."""
    mesh = MeshHex.init_tensor(
        np.linspace(-2.0, 1.0, 7), np.linspace(-1.0, 1.0, 4), np.array([-1.0, -0.5, -0.25, 0.0])
    )
    centre = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(
        np.flatnonzero((centre[0] > -1.5) & (centre[2] > -0.5) & (centre[2] < -0.25))
    )
    return fo.fem.Body(
        mesh.with_boundaries(
            {
                "contact": lambda x: (abs(x[2]) < 1e-9) | (abs(x[2] + 0.5) < 1e-9),
                "z-": lambda x: x[2] == -1.0,
            }
        )
    )


def edged():
    """A block of which the contact goes on around its edge."""
    lower = two_blocks((MeshTet, MeshTet), seed=None)["lower"]
    return fo.fem.Body(
        lower.with_boundaries({"contact": lambda x: (abs(x[2]) < 1e-9) | (abs(x[0] - 1.0) < 1e-9)})
    )


UPPER, START = BODIES["upper"].mesh, "contact 'contact'"
BAD = {
    f"{START}, at (-1, -1, -0.01): the bodies overlap by 0.01": lambda: put(
        UPPER.translated([0.0, 0.0, -0.01])
    ),
    f"{START}: the face of body 'upper' around (4": lambda: put(UPPER.translated([5.0, 0.0, 0.0])),
    f"{START}: the face of body 'upper' around (999": lambda: put(
        UPPER.translated([1e3, 0.0, 1e4]), gap="measured"
    ),
    "the faces do not touch, they are 0.02 apart": lambda: put(
        UPPER.translated([0.0, 0.0, 0.02]), edged()
    ),
    "faces body 'lower' more than once; name only the part": lambda: put(UPPER, stairs()),
}


@pytest.mark.parametrize("message", BAD)
def test_faces_that_do_not_meet_are_refused_by_name(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        BAD[message]()


def fit(radius, noise=0.0, gap="measured"):
    """A pin in a hole of some radius, both of 20 edges, and what its model warns of."""
    rng = np.random.default_rng(0)
    pin = ring([0.3, 0.6, 1.0], 20, "bore", "surface")
    plate = ring([radius, 1.5, 3.0], 20, "hole", "rim")
    plate = replace(plate, doflocs=plate.p * (1 + noise * rng.normal(size=plate.p.shape)))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = fo.fem.ContactModel(
            {"pin": fo.fem.Body(pin), "plate": fo.fem.Body(plate)},
            [fo.fem.Support("plate", "rim")],
            {"pull": [fo.fem.Traction("pin", "bore", x=1.0)]},
            [fo.fem.Contact("pin", "plate", "surface", "hole", gap=gap)],
        )
    return model.condense(), [str(one.message) for one in caught]


@pytest.mark.parametrize("noise", [0.0, 2e-13])
def test_curved_faces_that_touch_up_to_rounding_have_no_gap_to_warn_of(noise):
    measured, texts = fit(1.0, noise)
    touching, _ = fit(1.0, noise, gap=None)
    assert not texts
    assert not measured.gap.any()
    assert np.allclose(measured.S, touching.S, rtol=0, atol=1e-12 * measured.S.max())


def test_an_overlap_below_the_sag_of_the_facets_is_warned_of_with_both_lengths():
    """The circles overlap by 0.001; the sag of an edge is 1 - cos(pi / 20) = 0.0123 radii."""
    system, texts = fit(0.999)
    assert not system.gap.any()
    assert len(texts) == 1
    assert "miss curved faces by 0.025, and the widest measured gap is 0; mesh finer" in texts[0]
