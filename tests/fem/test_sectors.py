"""Sectors of rings against the whole.

The whole is made of turned copies of the meshes of the sector. Other tests have wrong sectors that
are refused.
"""

import re
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import special_ortho_group
from skfem import MeshQuad, MeshTet, MeshTri

import frictopt as fo
from helpers.cases import ALL_CASES
from helpers.meshes import around, extruded

STEEL, ALLOY = (
    fo.fem.Material(E=2.0, nu=0.3, density=0.5),
    fo.fem.Material(E=0.7, nu=0.2, density=0.2),
)
FRICTION = 0.2


def cuts(count):
    """Where the two cut faces of a sector of the plane lie."""
    a = 2 * np.pi / count
    return {
        "low": lambda x: (abs(x[1]) < 1e-9) & (x[0] > 0),
        "high": lambda x: (
            (abs(x[0] * np.sin(a) - x[1] * np.cos(a)) < 1e-9)
            & (x[0] * np.cos(a) + x[1] * np.sin(a) > 0)
        ),
    }


def circles(faces, count, cells):
    """Where the facets of circles, name -> radius, have their middles.

    A middle is between the chord and the circle. The number of facets in a sector is prescribed.
    """
    half = np.cos(np.pi / count / cells)
    return {
        name: lambda x, r=r: (np.hypot(*x[:2]) > r * half - 1e-9) & (np.hypot(*x[:2]) < r)
        for name, r in faces.items()
    }


def polar(kind, radii, count, cells, faces):
    """A sector of a ring, with its cut faces.

    The number of elements around and the names of circles are prescribed.
    """
    grid = kind.init_tensor(np.array(radii), np.linspace(0, 2 * np.pi / count, cells + 1))
    mesh = kind(grid.p[0] * np.array([np.cos(grid.p[1]), np.sin(grid.p[1])]), grid.t)
    return mesh.with_boundaries(cuts(count) | circles(faces, count, cells))


def joined(sectors, count, whole, turn, centre, axis, supports, loads, element="linear", **more):
    """A model of bodies, from meshes of a sector about z and the origin.

    The bodies are name -> mesh. The model is one sector or the whole ring, turned by a matrix and
    moved.
    """
    d = len(turn)
    step = Rotation.from_rotvec([0, 0, 2 * np.pi / count]).as_matrix()[:d, :d]
    bodies = {}
    for (name, mesh), material in zip(sectors.items(), (STEEL, ALLOY), strict=True):
        ring_mesh = around(mesh, count, step) if whole else mesh
        bodies[name] = fo.fem.Body(
            type(ring_mesh)(
                turn @ ring_mesh.p + np.array(centre)[:, None], ring_mesh.t
            ).with_boundaries(ring_mesh.boundaries),
            material,
            element,
        )
    tied = [] if whole else [fo.fem.Cyclic(name, "low", "high", axis, centre) for name in sectors]
    return fo.fem.ContactModel(
        bodies, [*supports, *tied], loads, [fo.fem.Contact(*sectors, "contact", "contact")], **more
    )


def waves(count, turn, centre, body, face):
    """Tractions along the radius and around the axis that repeat from sector to sector.

    The ring is turned and moved.
    """

    def traction(axis):
        def along(*x):
            local = np.tensordot(
                turn.T, np.array(x) - np.reshape(centre, (-1, *[1] * np.ndim(x[0]))), 1
            )
            radius = np.hypot(*local[:2])
            angle = count * np.arctan2(local[1], local[0])
            push, drag = 0.02 * np.cos(angle - 0.7), 0.01 * np.cos(angle - 0.2)
            forces = (
                (push * local[0] - drag * local[1]) / radius,
                (push * local[1] + drag * local[0]) / radius,
                *[0 * radius] * (len(turn) - 2),
            )
            return np.tensordot(turn, np.array(forces), 1)[axis]

        return along

    return [
        fo.fem.Traction(body, face, **{"xyz"[axis]: traction(axis) for axis in range(len(turn))})
    ]


def ring_model(count, whole, element="linear", centre=(0.3, -0.2), turn=None):
    turn = np.eye(2) if turn is None else turn
    sectors = {
        "shaft": polar(MeshQuad, [0.4, 0.7, 1.0], count, 6, {"bore": 0.4, "contact": 1.0}),
        "hub": polar(MeshQuad, [1.0, 1.3, 1.8], count, 6, {"contact": 1.0, "outside": 1.8}),
    }
    loads = {
        "fit": [fo.fem.Interference("contact", 0.02)],
        "waves": waves(count, turn, centre, "hub", "outside"),
    }
    loads["squeeze"] = [fo.fem.Pressure("hub", "outside", 0.02), fo.fem.Expansion("shaft", 0.001)]
    return joined(
        sectors,
        count,
        whole,
        turn,
        centre,
        (0, 0, 1),
        [fo.fem.Support("shaft", "bore")],
        loads,
        element,
    )


def test_a_sector_of_one_element_around_has_radial_normals_on_its_cut():
    """One edge of a face does not show that it is curved; its copy in the next sector does."""
    count, centre = 12, (0.3, -0.2)
    sectors = {
        "shaft": polar(MeshQuad, [0.4, 0.7, 1.0], count, 1, {"bore": 0.4, "contact": 1.0}),
        "hub": polar(MeshQuad, [1.0, 1.3, 1.8], count, 1, {"contact": 1.0, "outside": 1.8}),
    }
    held = [fo.fem.Support("shaft", "bore")]
    load = {"P": [fo.fem.Pressure("hub", "outside", 1.0)]}
    model = joined(sectors, count, False, np.eye(2), centre, (0, 0, 1), held, load)
    system = model.condense()
    radial = np.asarray(system.points) - np.array(centre)
    assert len(radial) == 1 and np.allclose(np.abs(system.normals * radial).sum(), 1.0, atol=1e-12)


def compared(one, part, count, cycle, load_factor=1.5, slides=True, **steps):
    """Compare the condensed whole with the sector.

    The comparison covers the stiffness under the loads, the limit, gross slip if `slides`, the
    steady state, and the forces at each node, also on the seam.
    """
    whole, system = one.condense(), part.condense()
    same = np.array(
        [np.linalg.norm(whole.points - point, axis=1).argmin() for point in system.points]
    )
    assert whole.nodes == count * system.nodes
    assert np.allclose(whole.points[same], system.points, atol=1e-9)
    assert np.allclose(whole.normals[same], system.normals, atol=1e-9)
    assert np.allclose(whole.width[same], system.width, rtol=1e-9)
    assert count * system.width.sum() == pytest.approx(whole.width.sum(), rel=1e-9)
    assert np.allclose(
        count * system.compliance,
        whole.compliance,
        rtol=0,
        atol=1e-9 * np.abs(whole.compliance).max(),
    )
    for name, pair in system.bonded.items():
        for of_sector, other in zip(pair, whole.bonded[name], strict=True):
            assert np.allclose(
                of_sector, other[same], rtol=0, atol=1e-9 * np.abs(whole.bonded[name][1]).max()
            )
    limits = [fo.shakedown_limit(each, cycle, FRICTION).load_factor for each in (whole, system)]
    assert limits[0] == pytest.approx(limits[1], rel=1e-8)
    if slides:
        gross = [fo.gross_slip(each, cycle, FRICTION) for each in (whole, system)]
        # Then transients are followed, to a relative 2e-3 in space.
        fits = gross[0].self_stress is not None
        assert gross[0].bound == pytest.approx(gross[1].bound, rel=1e-8)
        assert (gross[1].self_stress is not None) is fits
        tolerance = 5e-3 if fits else 1e-8
        assert gross[0].load_factor == pytest.approx(gross[1].load_factor, rel=tolerance)
    steady = [
        fo.steady_state(each, cycle, FRICTION, load_factor * limits[0], **steps)
        for each in (whole, system)
    ]
    assert steady[0].dissipation > 0
    assert steady[0].dissipation == pytest.approx(count * steady[1].dissipation, rel=1e-9)
    assert np.allclose(
        steady[1].slip, steady[0].slip[same], rtol=0, atol=1e-9 * np.abs(steady[0].slip).max()
    )
    last = [one.states().p[-1] for one in steady]
    assert np.allclose(last[1], last[0][same], rtol=0, atol=1e-9 * np.abs(last[0]).max())
    return steady, same


CYCLE = fo.LoadCycle({"fit": 1.0}, [{"waves": 1.0, "squeeze": 0.3}, {"waves": -1.0}])


@cache
def compared_rings(count, element):
    """The models of a ring of the plane and of its sector, and what `compared` gives for them."""
    one, part = (ring_model(count, whole, element) for whole in (True, False))
    return one, part, *compared(one, part, count, CYCLE)


@pytest.mark.parametrize(
    ("count", "element"), [(2, "linear"), (3, "linear"), (3, "quadratic"), (5, "linear")]
)
def test_a_sector_of_the_plane_has_the_answers_of_the_whole(count, element):
    compared_rings(count, element)


SPACE = special_ortho_group(3, seed=4).rvs()


def thick_model(count, whole, element="linear"):
    """Rings in space about an oblique axis, which slide on each other along it and around it."""
    sectors = {}
    for name, radii, faces in (
        ("bush", [0.6, 0.8, 1.0], {"bore": 0.6, "contact": 1.0}),
        ("hub", [1.0, 1.4], {"contact": 1.0, "outside": 1.4}),
    ):
        flat = polar(MeshQuad, radii, count, 3, faces)
        sectors[name] = extruded(flat).with_boundaries(
            cuts(count) | circles(faces, count, 3) | {"end": lambda x: x[2] == 0}
        )
    centre = (0.5, -0.1, 0.3)
    loads = {
        "fit": [fo.fem.Interference("contact", 0.05)],
        "waves": waves(count, SPACE, centre, "hub", "outside"),
    }
    along = dict(zip("xyz", 0.01 * SPACE[:, 2], strict=True))
    loads["squeeze"] = [
        fo.fem.Traction("hub", "outside", **along),
        fo.fem.Pressure("hub", "outside", 0.03),
    ]
    supports = [fo.fem.Support("bush", "bore"), fo.fem.Support("bush", "end")]
    return joined(
        sectors, count, whole, SPACE, centre, tuple(2 * SPACE[:, 2]), supports, loads, element
    )


@cache
def compared_in_space(count, element):
    """The same of rings in space."""
    one, part = (thick_model(count, whole, element) for whole in (True, False))
    slides = element == "linear" or ALL_CASES  # for which many transients are followed
    # At these loads slip returns to itself, so that both end in one steady state.
    load_factor = 1.5 if element == "linear" else 1.1
    return one, part, *compared(one, part, count, CYCLE, load_factor, slides=slides, steps=4)


@pytest.mark.parametrize(("count", "element"), [(3, "linear"), (4, "quadratic")])
def test_a_sector_in_space_has_the_answers_of_the_whole(count, element):
    compared_in_space(count, element)


@pytest.mark.parametrize("space", [False, True])
def test_fields_and_pictures_of_a_sector_are_those_of_the_whole(space):
    one, part, steady, same = (
        compared_in_space(3, "linear") if space else compared_rings(3, "quadratic")
    )
    whole, sector = (model.recover(state) for model, state in zip((one, part), steady, strict=True))
    for name, u in sector.displacement.items():
        near = [
            np.linalg.norm(one.bodies[name].mesh.p.T - point, axis=1).argmin()
            for point in part.bodies[name].mesh.p.T
        ]
        assert np.allclose(
            u, whole.displacement[name][:, near], rtol=0, atol=1e-9 * np.abs(u).max()
        )
        for field, other in ((sector.stress, whole.stress), (sector.strain, whole.strain)):
            assert np.allclose(
                field[name], other[name][:, near], rtol=0, atol=1e-9 * np.abs(field[name]).max()
            )
    faces = [model.grids(fields)["contact"] for model, fields in ((one, whole), (part, sector))]
    near = [np.linalg.norm(faces[0].points - point, axis=1).argmin() for point in faces[1].points]
    assert len(faces[1].points) == len(same) + 1 + space  # those on the other cut are drawn, too
    for name, values in faces[1].point_data.items():
        assert np.allclose(
            values,
            faces[0].point_data[name][near],
            rtol=0,
            atol=1e-9 * max(np.abs(values).max(), 1e-3),
        ), name


@pytest.mark.parametrize("count", [3, 4])
def test_modes_of_a_sector_are_those_of_the_whole_that_repeat(count):
    one, part = (thick_model(count, whole) for whole in (True, False))
    modes, found = part.modes(4), one.modes(25)
    same = [int(np.abs(found.frequency - frequency).argmin()) for frequency in modes.frequency]
    # Four between them do not repeat.
    assert np.allclose(found.frequency[same], modes.frequency, rtol=1e-9)
    assert same[:2] == [0, 5]
    assert np.allclose(
        count * modes.effective_mass, found.effective_mass[same], rtol=0, atol=1e-8 * found.mass
    )
    assert count * modes.mass == pytest.approx(found.mass)
    assert modes.effective_mass.max() > 0.1 * modes.mass


def standing(mesh, height):
    """The tetrahedra above triangles; those of turned copies of a face are turned copies."""
    n, (a, b, c) = mesh.p.shape[1], np.sort(mesh.t, axis=0)
    points = np.hstack([np.vstack([mesh.p, np.full(n, z)]) for z in (0.0, height)])
    return MeshTet(
        points, np.hstack([[a, b, c, c + n], [a, b, b + n, c + n], [a, a + n, b + n, c + n]])
    )


def discs(count, cells, height):
    """Sectors of a disc, which reaches the axis, and of a ring around it.

    With a height they are cylinders.
    """
    rim, hub = (
        polar(MeshTri, radii, count, cells, {}) for radii in ([0.3, 0.7, 1.0], [1.0, 1.3, 1.8])
    )
    inner = np.flatnonzero(np.hypot(*rim.p) < 0.31)
    core = np.array([inner[:-1], inner[1:], np.full(cells, rim.p.shape[1])])
    shaft = MeshTri(np.hstack([rim.p, np.zeros((2, 1))]), np.hstack([rim.t, core]))
    faces = (
        cuts(count)
        | circles({"contact": 1.0, "outside": 1.8}, count, cells)
        | {"end": lambda x: x[-1] == 0.0}
    )
    return {
        name: (standing(mesh, height) if height else mesh).with_boundaries(faces)
        for name, mesh in (("shaft", shaft), ("hub", hub))
    }


# The axis z is turned to x.
ALONG_X = np.eye(3)[[2, 0, 1]]


@pytest.mark.parametrize(("height", "turn"), [(0.0, np.eye(2)), (0.5, np.eye(3)), (0.5, ALONG_X)])
def test_a_sector_may_reach_the_axis(height, turn):
    centre = (0.2, 0.1, -0.4)[: len(turn)]
    axis = tuple(turn[:, 2]) if height else (0, 0, 1)
    loads = {
        "fit": [fo.fem.Interference("contact", 0.02)],
        "waves": waves(4, turn, centre, "hub", "outside"),
        "squeeze": [fo.fem.Expansion("shaft", 0.01)],
    }
    if height:
        loads["squeeze"] = [
            fo.fem.Traction("shaft", "end", **dict(zip("xyz", 0.002 * turn[:, 2], strict=True)))
        ]
    held = [
        fo.fem.Support(
            "hub",
            "end"
            if height
            else tuple(float(x) for x in np.array(centre) + turn @ np.eye(len(turn))[0] * 1.8),
        )
    ]
    one, part = (
        joined(discs(4, 4, height), 4, whole, turn, centre, axis, held, loads)
        for whole in (True, False)
    )
    if not height:
        arms = np.array(centre) + 1.8 * np.array([[0, 1], [-1, 0], [0, -1]])
        one = fo.fem.ContactModel(
            one.bodies,
            [*held, *(fo.fem.Support("hub", tuple(arm.tolist())) for arm in arms)],
            loads,
            one.contacts,
        )
    slides = not height or turn is ALONG_X or ALL_CASES  # many transients are followed in space
    compared(one, part, 4, CYCLE, slides=slides, **({"steps": 4} if height else {}))
    assert len(part._assembly.sector.fixed) == 1 + (height > 0)


def test_nodes_on_an_axis_askew_are_refused():
    loads = {"fit": [fo.fem.Interference("contact", 0.02)]}
    held, axis = [fo.fem.Support("hub", "end")], tuple(SPACE[:, 2])
    with pytest.raises(fo.ModelError, match=r"nodes of a sector lie on its axis, .* turn the mesh"):
        joined(discs(4, 4, 0.5), 4, False, SPACE, (0.2, 0.1, -0.4), axis, held, loads).condense()


def refused(hub=None, cut=None, supports=(), contacts=None, kinematics=None, count=3, **loads):
    """A ring of two bodies in sectors, of which some part is wrong.

    `hub` has further boundaries of that body, or is its mesh.
    """
    model = ring_model(count, False, centre=(0.0, 0.0))
    bodies = dict(model.bodies)
    cuts = [support for support in model.supports if isinstance(support, fo.fem.Cyclic)]
    if hub:
        bodies["hub"] = fo.fem.Body(
            bodies["hub"].mesh.with_boundaries(hub) if isinstance(hub, dict) else hub, ALLOY
        )
    held = [fo.fem.Support("shaft", "bore"), cuts[0], cut or cuts[1], *supports]
    return fo.fem.ContactModel(
        bodies, held, {**model.loads, **loads}, contacts or model.contacts, kinematics
    )


def uneven():
    """A hub whose nodes match those of the shaft at one cut, and not at the other one."""
    mesh = polar(MeshQuad, [1.0, 1.3, 1.8], 3, 5, {"contact": 1.0, "outside": 1.8})
    radius = np.hypot(*mesh.p)
    angle = np.interp(
        np.arctan2(*mesh.p[::-1]),
        np.linspace(0, 2 * np.pi / 3, 6),
        np.radians([0, 30, 60, 80, 100, 120]),
    )
    return MeshQuad(radius * np.array([np.cos(angle), np.sin(angle)]), mesh.t).with_boundaries(
        mesh.boundaries
    )


HUB = {"body": "hub", "low": "low", "high": "high"}
REFUSED = {
    "high: 'low' is `low` too": lambda: fo.fem.Cyclic("hub", "low", "low"),
    "axis: (0.0, 0.0, 0.0); give the direction": lambda: fo.fem.Cyclic(
        "hub", "low", "high", axis=(0, 0, 0)
    ),
    "axis: (0.0, 0.0, 1e-200); give the direction": lambda: fo.fem.Cyclic(
        "hub", "low", "high", axis=(0, 0, 1e-200)
    ),
    "low: 3": lambda: fo.fem.Cyclic("hub", 3, "high"),
    "boundary 'left' is unknown": lambda: refused(cut=fo.fem.Cyclic("hub", "left", "high")),
    "body 'rim' of Cyclic(": lambda: refused(cut=fo.fem.Cyclic("rim", "low", "high")),
    "has another Cyclic": lambda: refused(cut=fo.fem.Cyclic("shaft", "low", "high")),
    "its axis a normal of the plane": lambda: refused(cut=fo.fem.Cyclic(**HUB, axis=(1, 0, 0))),
    "give the 2 coordinates of a point": lambda: refused(
        cut=fo.fem.Cyclic(**HUB, centre=(0, 0, 0))
    ),
    "the faces 'high' and 'low' of body 'hub' are not turned copies of each other: turned by 360/3 degrees about the axis, they are up to 0.3 apart": (
        lambda: refused({"high": lambda x: cuts(3)["high"](x) & (np.hypot(*x) > 1.3)})
    ),
    "; their middles are": lambda: refused(cut=fo.fem.Cyclic(**HUB, centre=(0.1, 0.0))),
    "have different axes or angles": lambda: refused(
        polar(MeshQuad, [1.0, 1.3, 1.8], 6, 3, {"contact": 1.0})
    ),
    "an axisymmetric model": lambda: refused(kinematics="axisymmetric", count=4),
    "is held, but not the node at (1.3, 0)": lambda: refused(
        supports=[fo.fem.Support("hub", tuple(float(x) for x in 1.3 * TURN[:, 0]), "x")]
    ),
    "is held, but not the node at (1, 0)": lambda: refused(
        supports=[fo.fem.Support("hub", "high", "x"), fo.fem.Support("hub", "low", "y")]
    ),
    "differs from the turned displacement of the other face": lambda: refused(
        move=[fo.fem.Displacement("shaft", "bore", x=0.1)]
    ),
    "body 'hub' goes the long way round from 'low' to 'high', 240 of 360 degrees": lambda: refused(
        polar(MeshQuad, [1.0, 1.3, 1.8], 1.5, 8, {"contact": 1.0, "outside": 1.8})
    ),
    "loads['turn']: Centrifugal(": lambda: refused(
        turn=[fo.fem.Centrifugal("hub", 1.0, 1.0, centre=(0.1, 0.0))]
    ),
    "beside a Cyclic; a coupling cannot include nodes of other sectors": lambda: refused(
        supports=[fo.fem.RigidCoupling("hub", "outside")]
    ),
    "loads['pull']: PointForce(": lambda: refused(
        pull=[fo.fem.PointForce("hub", "outside", x=1.0)]
    ),
    "on the cut `high` of a sector, which is a copy of a node on `low`: leave nodes on `high` out": (
        lambda: refused(pull=[fo.fem.PointForce("hub", "high", x=1.0)])
    ),
    "loads['fall']: BodyForce(": lambda: refused(fall=[fo.fem.BodyForce("hub", y=-1.0)]),
    "the gap of 'shim' at (-0.5, 0.866025) is 0.01, and 0.025": lambda: refused(
        contacts=[
            fo.fem.Contact(
                "shaft", "hub", "contact", "contact", gap=lambda x, y: 0.01 * (1.5 + x), name="shim"
            )
        ]
    ),
    "'contact' reaches the cut of the sector at": lambda: refused(
        cut=fo.fem.Cyclic("hub", "high", "low"), count=2
    ),
    "'side' reaches the cut of the sector at": lambda: refused(
        uneven(), contacts=[fo.fem.Contact("hub", "shaft", name="side")]
    ),
    "'other' reaches the cut of the sector at": lambda: refused(
        polar(MeshQuad, [1.0, 1.3, 1.8], 3, 7, {"contact": 1.0, "outside": 1.8}),
        contacts=[fo.fem.Contact("hub", "shaft", name="other")],
    ),
}
TURN = Rotation.from_rotvec([0, 0, 2 * np.pi / 3]).as_matrix()[:2, :2]


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_no_sector_is_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        REFUSED[message]()


def test_displacements_of_supports_may_repeat():
    """A bore that is moved around the axis: the ring turns as it is, and nothing is strained."""
    turned_by = fo.fem.Displacement(
        "shaft", "bore", x=lambda x, y: -0.1 * y, y=lambda x, y: 0.1 * x
    )
    model = refused(turn=[turned_by])
    q, p = model.condense().bonded["turn"]
    assert max(np.abs(q).max(), np.abs(p).max()) < 1e-12
    moved = model.recover({"turn": 1.0}, 0 * q).displacement["hub"]
    assert np.allclose(
        moved, 0.1 * np.array([[0.0, -1.0], [1.0, 0.0]]) @ model.bodies["hub"].mesh.p, atol=1e-12
    )


def test_either_cut_face_may_be_named_first():
    assert "sector      1 of 3" in str(refused())
    assert np.array_equal(
        refused().condense().S, refused(cut=fo.fem.Cyclic("hub", "high", "low")).condense().S
    )


def test_a_ring_that_nothing_holds_turns():
    model = refused()
    with pytest.raises(fo.ModelError, match="can still turn"):
        fo.fem.ContactModel(
            model.bodies,
            [support for support in model.supports if isinstance(support, fo.fem.Cyclic)],
            model.loads,
            model.contacts,
        ).condense()
    with pytest.raises(fo.ModelError, match="can still move along z and turn about z"):
        part = joined(
            discs(4, 4, 0.5),
            4,
            False,
            np.eye(3),
            (0, 0, 0),
            (0, 0, 1),
            [],
            {"fit": [fo.fem.Interference("contact", 0.02)]},
        )
        part.condense()


def test_a_picture_of_a_model_marks_its_cuts_and_what_is_held():
    lines = {line.get_label(): line for line in thick_model(3, False).plot().get_lines()}
    assert lines["cut of a sector"].get_marker() == "o"
    assert lines["held in x, y, z"].get_marker() == "s"
