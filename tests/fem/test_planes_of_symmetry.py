"""Models of a half or a quarter, compared with the whole model.

Supports hold the parts on their planes of symmetry. Other tests have bodies that meet on their
axis.
"""

from functools import cache

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad

import frictopt as fo
from helpers.meshes import box

CYCLE = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
STIFF = fo.fem.Material(E=3.0)


def half_of(line):
    return line[line >= 0]


def punch(scene, cut, clamped=None):
    """The model of a scene, cut by its planes of symmetry.

    The plane x = 0 and, for 2, the plane y = 0 cut away all but a part. The middle node of a body
    may be held.
    """
    kind = MeshHex if len(scene._grids[0]) == 3 else MeshQuad
    lines = [
        [half_of(line) if axis < cut else line for axis, line in enumerate(grid)]
        for grid in scene._grids
    ]
    height, depth, wide = scene._grids[0][-1][-1], scene._grids[1][-1][0], scene._grids[1][0][-1]
    planes = {f"plane {axis}": lambda x, axis=axis: x[axis] == 0 for axis in range(cut)}
    upper = kind.init_tensor(*lines[0]).with_boundaries(
        {"contact": lambda x: x[-1] == 0, "top": lambda x: x[-1] == height} | planes
    )
    faces = {
        "contact": lambda x: (x[-1] == 0) & (np.abs(x[:-1]) < 1).all(axis=0),
        "bottom": lambda x: x[-1] == depth,
    }
    sides = {"right": lambda x: x[0] == wide} | ({} if cut else {"left": lambda x: x[0] == -wide})
    lower = kind.init_tensor(*lines[1]).with_boundaries(faces | sides | planes)
    held = [
        fo.fem.Support(body, f"plane {axis}", "xy"[axis])
        for body in ("punch", "block")
        for axis in range(cut)
    ]
    held += [fo.fem.Support(clamped, (0.0,) * len(lines[0]))] if clamped else []
    pulls = [fo.fem.Traction("block", side, x=1.0 if side == "right" else -1.0) for side in sides]
    down = fo.fem.Pressure("punch", "top", 1.0)
    return fo.fem.ContactModel(
        {"punch": fo.fem.Body(upper, STIFF), "block": fo.fem.Body(lower)},
        [*held, fo.fem.Support("block", "bottom")],
        {"P": [down], "sigma": pulls},
    )


PLANE = fo.scenes.PunchOnHalfPlane(elements=12, growth=1.7, block_half_width=4.0, block_depth=4.0)
SCENES = {"plane": PLANE, "space": fo.scenes.SquarePunch(elements=4, growth=2.5)}


@cache
def whole(name, friction, clamped):
    """Limit of a whole scene, and the steady state above it."""
    system = punch(SCENES[name], 0, clamped).condense()
    limit = fo.shakedown_limit(system, CYCLE, friction)
    return limit, fo.steady_state(system, CYCLE, friction, load_factor=1.5 * limit.load_factor)


@pytest.mark.parametrize(("scene", "cut"), [("plane", 1), ("space", 1), ("space", 2)])
@pytest.mark.parametrize(
    ("friction", "clamped"), [(0.4, None), (0.7, None), (0.7, "block"), (0.7, "punch")]
)
def test_a_part_is_as_good_as_the_whole(scene, cut, friction, clamped):
    part = punch(SCENES[scene], cut, clamped).condense()
    middle = np.isclose(part.points[:, 0], 0.0)
    assert middle.any()
    assert all(
        np.abs(q.reshape(part.nodes, -1)[middle, 0]).max() < 1e-15 for q, _ in part.bonded.values()
    )
    assert np.diag(part.S).min() > 0
    limit = fo.shakedown_limit(part, CYCLE, friction)
    (other, all_of_it) = whole(scene, friction, clamped)
    assert limit.load_factor == pytest.approx(other.load_factor, rel=1e-8)
    steady = fo.steady_state(part, CYCLE, friction, load_factor=1.5 * other.load_factor)
    assert 2**cut * steady.dissipation == pytest.approx(all_of_it.dissipation, rel=1e-6)
    assert not steady.slip.reshape(part.nodes, -1)[middle, 0].any()


def test_on_a_plane_of_symmetry_the_normal_lies_in_it():
    """A half disc is in a half hole: at both ends of its arc the normal of the last chord leans."""
    angles, radii = np.linspace(-np.pi / 2, np.pi / 2, 13), np.linspace(0.0, 1.0, 4)

    def arc(inner, outer, boundaries):
        mesh = MeshQuad.init_tensor(angles, inner + (outer - inner) * radii)
        mesh = MeshQuad(
            np.array([np.cos(mesh.p[0]) * mesh.p[1], np.sin(mesh.p[0]) * mesh.p[1]]), mesh.t
        )
        rims = {
            name: lambda x, r=r: np.abs(np.hypot(*x) - r) < 0.02 for name, r in boundaries.items()
        }
        return mesh.with_boundaries({**rims, "middle": lambda x: np.abs(x[0]) < 1e-9})

    bodies = {
        "pin": fo.fem.Body(arc(0.3, 1.0, {"ring": 1.0})),
        "plate": fo.fem.Body(arc(1.0, 3.0, {"ring": 1.0, "rim": 3.0})),
    }
    supports = [
        fo.fem.Support("pin", "middle", "x"),
        fo.fem.Support("plate", "middle", "x"),
        fo.fem.Support("plate", (0.0, -3.0), "y"),
    ]
    contact = fo.fem.Contact("pin", "plate", "ring", "ring")
    system = fo.fem.ContactModel(
        bodies, supports, {"fit": [fo.fem.Interference("ring", 0.01)]}, [contact]
    ).condense()
    assert np.allclose(np.abs(system.normals[[0, -1]]), [[0.0, 1.0]] * 2, rtol=0, atol=1e-15)
    assert np.ptp(system.bonded["fit"][1] / system.width) < 1e-2 * np.ptp(system.bonded["fit"][1])


def beside(kind, cells, half, lean):
    """A body of 6 elements above a body of `cells`, or the half of both at x > 0.

    The lower face of the upper body is flat, or leans by its gap.
    """
    d, ends, bodies = kind().dim(), (0.0 if half else -1.0, 1.0), {}
    for name, low, n in (("upper", 0.0, 6), ("lower", -1.0, cells)):
        across = [np.linspace(*ends, (1 if half else 2) * n + 1), *[[0.0, 0.4]] * (d - 2)]
        mesh = box(kind, *across, [low, low + 0.5, low + 1])
        if name == "upper":
            mesh = kind(
                mesh.p + np.eye(d)[:, [-1]] * lean * (0.5 + mesh.p[0] ** 2) * (1 - mesh.p[-1]),
                mesh.t,
            ).with_boundaries(mesh.boundaries)
        bodies[name] = fo.fem.Body(mesh)
    up = "xyz"[d - 1]
    supports = [
        fo.fem.Support(name, up + side, "xyz"[1:d])
        for name, side in (("upper", "+"), ("lower", "-"))
    ]
    for name, height in (("upper", 1.0), ("lower", -1.0)):
        supports += (
            [fo.fem.Support(name, "x-", "x")]
            if half
            else [fo.fem.Support(name, (0.0, *[0.0] * (d - 2), height), "x")]
        )
    pulls = [fo.fem.Pressure("lower", side, -1.0) for side in (["x+"] if half else ["x+", "x-"])]
    loads = {"P": [fo.fem.Displacement("upper", up + "+", **{up: -1.0})], "Q": pulls}
    return fo.fem.ContactModel(
        bodies,
        supports,
        loads,
        [fo.fem.Contact("upper", "lower", gap="measured" if lean else None)],
    )


@pytest.mark.parametrize("lean", [0.0, 4e-3])
@pytest.mark.parametrize("cells", [4, 5, 6, 9])
@pytest.mark.parametrize("kind", [MeshQuad, MeshHex])
def test_half_of_unlike_meshes_is_pressed_and_sheared_as_a_half_of_the_whole(kind, cells, lean):
    """Mortar weights join a node on the plane of symmetry to nodes beside it; the mirror images of
    these nodes take a part away."""
    found = []
    for half in (True, False):
        system = beside(kind, cells, half, lean).condense()
        right = system.points[:, 0] > 1e-9
        order = np.flatnonzero(right)[np.lexsort(system.points[right].T)]
        found.append(
            [
                np.column_stack([np.reshape(q, (system.nodes, -1)), p])[order]
                for q, p in system.bonded.values()
            ]
        )
        assert not half or all(
            np.abs(q.reshape(system.nodes, -1)[~right, 0]).max() == 0
            for q, _ in system.bonded.values()
        )
    for half, whole in zip(*found, strict=True):
        assert np.abs(half - whole).max() < 1e-12 * np.abs(whole).max()


def test_a_plane_of_symmetry_of_unlike_meshes_moves_with_both_bodies_or_not_at_all():
    model = beside(MeshHex, 9, True, 4e-3)
    one, two = (fo.fem.Displacement(body, "x-", x=0.1) for body in ("upper", "lower"))
    with pytest.raises(
        fo.ModelError,
        match=r"loads\['apart'\]: a displacement moves both bodies at \(0, 0, 0.002\)",
    ):
        fo.fem.ContactModel(model.bodies, model.supports, {"apart": [one]}, model.contacts)
    system = fo.fem.ContactModel(
        model.bodies, model.supports, {"both": [one, two]}, model.contacts
    ).condense()
    q, p = system.bonded["both"]
    assert max(np.abs(q).max(), np.abs(p).max()) < 1e-10 * np.abs(system.S).max()


def test_nodes_beside_one_that_is_held_on_both_bodies_are_on_no_plane_of_symmetry():
    """Its body goes on behind it: what the other nodes of the pair add is no mirror image."""
    model = beside(MeshQuad, 9, False, 0.0)
    held = [fo.fem.Support(body, (0.0, 0.0), "x") for body in model.bodies]
    loads = {"one side": [fo.fem.Pressure("lower", "x+", -1.0)]}
    system = fo.fem.ContactModel(
        model.bodies, [*model.supports[:2], *held], loads, model.contacts
    ).condense()
    q, _ = system.bonded["one side"]
    assert np.abs(q[np.isclose(system.points[:, 0], 0.0)]).min() > 1e-2 * np.abs(q).max()
