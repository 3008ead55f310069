"""Bolts that are tightened.

They are compared with ties by multipliers; wrong sections are refused.
"""

import re

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad, MeshTri

import frictopt as fo
from helpers.multipliers import Assembled

CORK = fo.fem.Material(E=3.0, nu=0.0)
HEIGHTS = np.array([0.0, 0.7, 1.5, 3.0])


def bar(kind=MeshQuad, low=0, high=None, half=1.0, kinematics=None):
    """A bar from y (in space z) = 0 to 3 with the section 1.5.

    With two heights it is only the part of the bar between them.
    """
    x = (
        np.array([0.5, 0.7, 1.0]) * half
        if kinematics == "axisymmetric"
        else np.array([-1.0, 0.1, 1.0]) * half
    )
    mesh = kind.init_tensor(*[x] * (kind().dim() - 1), HEIGHTS[low:high])
    mesh = mesh.with_boundaries(
        {
            "contact": lambda x: x[-1] == 0,
            "foot": lambda x: x[-1] == 0,
            "top": lambda x: x[-1] == 3,
            "side": lambda x: x[0] == 1,
        }
    )
    return mesh.with_boundaries({"section": lambda x: x[-1] == 1.5}, boundaries_only=False)


def stands(kind=MeshQuad, loads=None, material=CORK, kinematics=None, supports=None, element=None):
    """A bar that hangs between a base and a fixed top."""
    bolt = bar(kind, kinematics=kinematics)
    up = "xyz"[kind().dim() - 1]
    levels = [np.unique(x) for x in bolt.p[:-1]]
    base = kind.init_tensor(*levels, [-1.0, -0.3, 0.0]).with_boundaries(
        {"contact": lambda x: x[-1] == 0, "bottom": lambda x: x[-1] == -1}
    )
    return fo.fem.ContactModel(
        bodies={
            "base": fo.fem.Body(base, material, element),
            "bolt": fo.fem.Body(bolt, material, element),
        },
        supports=supports or [fo.fem.Support("base", "bottom"), fo.fem.Support("bolt", "top")],
        loads=loads
        or {
            "F": [fo.fem.BoltPreload("bolt", "section", 10.0)],
            "down": [fo.fem.BodyForce("base", **{up: -0.5})],
        },
        contacts=[fo.fem.Contact("bolt", "base")],
        kinematics=kinematics,
    )


def glued(model, **loads):
    system = model.condense()
    return model.recover(
        loads, np.zeros(system.normals.shape[:1] + (2,) * (system.normals.shape[1] == 3))
    )


@pytest.mark.parametrize("kind", [MeshTri, MeshHex])
def test_the_faces_move_as_multipliers_tie_them(kind):
    """The reference has both halves of the bolt as separate bodies, and every tie as a row of a
    saddle-point system."""
    material = fo.fem.Material(E=2.0, nu=0.3)
    d = kind().dim()
    up = "xyz"[kind().dim() - 1]

    def loads(body):
        parts = [
            fo.fem.Expansion(body, lambda *x: 0.1 * x[0] + x[-1]),
            fo.fem.BodyForce(body, x=0.3, **{up: 0.2}),
            fo.fem.Traction(body, "side", x=lambda *x: x[-1]),
        ]
        return [*parts, fo.fem.Centrifugal(body, 0.1)]

    model = stands(
        kind, {"F": [fo.fem.BoltPreload("bolt", "section", 4.0), *loads("bolt")]}, material
    )
    fields = glued(model, F=1.0)
    meshes = {
        "base": model.bodies["base"].mesh,
        "lower": bar(kind, 0, 3),
        "upper": bar(kind, 2, None),
    }
    bodies = {name: fo.fem.Body(mesh, material) for name, mesh in meshes.items()}
    whole = Assembled(bodies)
    # The last unknown is how far the faces come together.
    K = np.pad(whole.K, (0, 1))
    F = np.r_[np.zeros(len(whole.K)), 4.0]
    for name in ("lower", "upper"):
        for load in loads(name):
            F[whole.first[name] + whole.bases[name].nodal_dofs] += load._forces(
                bodies[name], "plane_strain"
            )
    rows = [*np.eye(len(K))[np.r_[whole.on("base", d - 1, -1.0), whole.on("upper", d - 1, 3.0)]]]
    for one, two, height, closing in (("lower", "base", 0.0, 0.0), ("lower", "upper", 1.5, 1.0)):
        for point in meshes[one].p.T[meshes[one].p[-1] == height]:
            for axis, unknowns in enumerate(
                zip(whole.rows(one, point), whole.rows(two, point), strict=True)
            ):
                rows.append(np.zeros(len(K)))
                rows[-1][[*unknowns, -1]] = 1.0, -1.0, -closing * (axis == d - 1)
    C = np.array(rows)
    u = np.linalg.solve(
        np.block([[K, C.T], [C, np.zeros((len(C), len(C)))]]), np.r_[F, np.zeros(len(C))]
    )
    ours, mesh = fields.displacement["bolt"], fields.bodies["bolt"].mesh
    for name, which in (("lower", 0), ("upper", -1)):  # of the two nodes in the section
        for point in meshes[name].p.T:
            same = np.flatnonzero((mesh.p == point[:, None]).all(axis=0))
            assert np.allclose(ours[:, same[which]], u[whole.rows(name, point)], atol=1e-10)


def named(**places):
    return bar().with_boundaries(
        {name: lambda x, place=place: place(*x) for name, place in places.items()},
        boundaries_only=False,
    )


def condensed_with_bolt(
    mesh=None,
    section="section",
    body="bolt",
    supports=None,
    contacts=None,
    kinematics=None,
    also=(),
):
    """The system of the stand, condensed with a preload at `section` and at the sections `also`."""
    model = stands(kinematics=kinematics)
    bodies = model.bodies if mesh is None else {**model.bodies, "bolt": fo.fem.Body(mesh, CORK)}
    loads = {"F": [fo.fem.BoltPreload(body, name) for name in (section, *also)]}
    return fo.fem.ContactModel(
        bodies, supports or model.supports, loads, contacts or model.contacts, kinematics
    ).condense()


BAD = {
    "bolt: body: 'nut'; give 'base' or 'bolt'": {"body": "nut"},
    "bolt 'bolt': section 'cut' is unknown; this mesh names ['contact', 'foot', 'section', 'side', 'top']": {
        "section": "cut"
    },
    "section 'top' has no facets, or facets on the outline": {"section": "top"},
    "section 'bent' is not flat": {
        "mesh": named(bent=lambda x, y: ((y == 1.5) & (x < 0.1)) | ((x == 0.1) & (y > 1.5))),
        "section": "bent",
    },
    "section 'half' does not cut the body in two": {
        "mesh": named(half=lambda x, y: (y == 1.5) & (x < 0.1)),
        "section": "half",
    },
    "section 'again' has no facets, or facets on the outline": {
        "mesh": named(again=lambda x, y: y == 1.5),
        "also": ["again"],
    },
    "'bolt': its section at (0.0333333, 1.5) has nodes on a cut of a sector, in a contact, in another section, or held": {
        "supports": [fo.fem.Support("base", "bottom"), fo.fem.Support("bolt", "side")]
    },
    "nothing holds the part around (0.0333333, 2.25) against the force along the axis": {
        "supports": [fo.fem.Support("base", "bottom")]
    },
    "nothing holds the part around (0.0333333, 0.15) against the force": {
        "supports": [fo.fem.Support("base", "bottom", "x"), fo.fem.Support("bolt", "top")]
    },
    "section 'upright' is not normal to the axis": {
        "mesh": bar(kinematics="axisymmetric").with_boundaries(
            {"upright": lambda x: x[0] == 0.7}, boundaries_only=False
        ),
        "section": "upright",
        "kinematics": "axisymmetric",
    },
}


@pytest.mark.parametrize("message", BAD)
def test_sections_that_are_none_are_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        condensed_with_bolt(**BAD[message])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [((1, "a"), "body: 1"), (("a", None), "section: None"), (("a", "b", np.nan), "force: nan")],
)
def test_arguments_of_a_bolt(arguments, message):
    with pytest.raises(fo.ModelError, match=message):
        fo.fem.BoltPreload(*arguments)
