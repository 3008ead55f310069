"""Contacts in three dimensions from meshes and matrices: patch, rotations, hexahedra and tetrahedra, stiff and soft bodies, another code."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad, MeshTet

import frictopt as fo
from spatial import vectors

CYCLE = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
ROUND = fo.LoadCycle({"P": 1.0}, [{"Qx": np.cos(t), "Qy": np.sin(t)} for t in np.pi / 2 * np.arange(4)])
SCENE = fo.scenes.SquarePunch(elements=4, growth=2.0)


@pytest.fixture(scope="module")
def system():
    return SCENE.condense()


def rotation():
    """A rotation about an axis of no special direction."""
    x, y, z = np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(1.1) * K + (1 - np.cos(1.1)) * K @ K


def rotated(model, R):
    """The same model turned in space, its loads with it."""
    bodies = {name: replace(body, mesh=replace(body.mesh, doflocs=R @ body.mesh.p)) for name, body in model.bodies.items()}
    loads = {}
    for name, parts in model.loads.items():
        turned = [(part, R @ [part.x, part.y, part.z]) for part in parts]
        loads[name] = [replace(part, x=x, y=y, z=z) for part, (x, y, z) in turned]
    return fo.ContactModel(bodies, model.supports, loads)


def test_the_whole_scene_may_be_turned(system):
    R = rotation()
    turned = rotated(SCENE.model(), R).condense()
    assert np.allclose(turned.frames[:, 2], R[:, 2], atol=1e-12)
    for loads in (CYCLE, ROUND):
        one, other = fo.shakedown_limit(system, loads, 0.5), fo.shakedown_limit(turned, loads, 0.5)
        assert other.load_factor == pytest.approx(one.load_factor, rel=1e-9)
        at = 1.2 * one.load_factor
        paths = [fo.march(contact, loads, 0.5, at, cycles=1, steps=4) for contact in (system, turned)]
        assert paths[1].work[-1] == pytest.approx(paths[0].work[-1], rel=1e-8, abs=1e-11 * paths[0].work[-1].sum())
        in_space = [np.einsum("nak,na->nk", contact.frames[:, :2], path.slip[-1]) for contact, path in zip((system, turned), paths, strict=True)]
        assert in_space[1] == pytest.approx(in_space[0] @ R.T, abs=1e-9 * np.abs(in_space[0]).max())


def test_bonded_reactions_balance_the_loads(system):
    n = system.nodes
    for name, whole in {"P": (0, 0, 4.0), "Qx": (-4.0, 0, 0), "Qy": (0, -4.0, 0)}.items():
        q, p = system.reaction({name: 1.0})
        assert np.r_[q.sum(axis=0), p.sum()] == pytest.approx(np.array(whole), abs=1e-11)
    assert np.abs(system.S @ np.kron(np.eye(3), np.ones((n, 1)))).max() < 1e-12 * np.abs(system.S).max()  # a free punch


def test_the_cube_of_another_code_has_its_known_limit(cube):
    job, (x, y, z) = cube, cube.points.T
    face = np.flatnonzero(np.isclose(z, 0) & (abs(x) < 1.001) & (abs(y) < 1.001))
    sides = [job.force(np.flatnonzero(np.isclose(x, 4 * side)), traction=[side, 0.0, 0.0]) for side in (1.0, -1.0)]
    loads = {"P": job.force(np.flatnonzero(np.isclose(z, 1.5)), traction=[0.0, 0.0, -1.0]), "sigma": sides[0] + sides[1]}
    system = fo.condense(job.K, loads, job.pairs(face[:9], face[9:]), [0.0, 0.0, 1.0], job.unknowns, job.points)
    assert fo.shakedown_limit(system, CYCLE, 0.5).load_factor == pytest.approx(1.413123958619, rel=1e-9)
    gap = {name: r[18:].sum() for name, r in vectors(system).items()}
    assert gap["P"] == pytest.approx(4.0)


SIDES = {"contact": lambda x: x[1] == 0, "top": lambda x: x[1] == 1, "bottom": lambda x: x[1] == -1}
PLANE = fo.Body(MeshQuad.init_tensor([0.0, 1.0], [0.0, 1.0]).with_boundaries(SIDES))
TWO_SQUARES = {"punch": PLANE, "block": fo.Body(MeshQuad.init_tensor([0.0, 1.0], [-1.0, 0.0]).with_boundaries(SIDES))}


@pytest.mark.parametrize(
    ("message", "change"),
    [
        ("bodies: 'punch' is plane, 'block' in space", {"bodies": {"punch": PLANE, "block": SCENE.model().bodies["block"]}}),
        ("kinematics: 'plane_stress' with bodies in space", {"kinematics": "plane_stress"}),
        ("Traction z: -1.0; body 'punch' is plane", {"bodies": TWO_SQUARES, "supports": [fo.Support("block", "bottom")]}),
        ("supports: directions 'z' of body 'block', which is plane", {"bodies": TWO_SQUARES, "supports": [fo.Support("block", "bottom", "z")]}),
        (r"where: \(0.0, 0.0\); give the 3 coordinates", {"supports": [fo.Support("block", (0.0, 0.0))]}),
        (r"centre: \(0.0, 0.0\); give the 3 coordinates", {"loads": {"S": [fo.Centrifugal("punch", 1.0, centre=(0.0, 0.0))]}}),
    ],
)
def test_models_that_make_no_sense_are_refused_by_name(message, change):
    model = SCENE.model()
    values = {name: getattr(model, name) for name in ("bodies", "supports", "loads")}
    with pytest.raises(fo.ModelError, match=message):
        fo.ContactModel(**values | change).condense()


@pytest.mark.parametrize("kind", [MeshHex, MeshTet])
@pytest.mark.parametrize("by", [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [3.0, 0.0, 0.0]])
def test_a_body_of_pieces_that_share_no_face_is_refused(kind, by):
    """Two cubes with nodes of their own, and two that share an edge once their nodes are merged."""
    cube = kind.init_tensor([0.0, 1.0], [0.0, 1.0], [0.0, 1.0])
    other = cube.translated(by)
    apart = kind(np.hstack([cube.p, other.p]), np.hstack([cube.t, cube.p.shape[1] + other.t]))
    with pytest.raises(fo.ModelError, match="2 parts that share no face; give one connected body"):
        fo.Body(apart)
    points, number = np.unique(apart.p, axis=1, return_inverse=True)
    merged = kind(points, number.ravel()[apart.t])
    if by == [1.0, 0.0, 0.0]:
        assert fo.Body(merged).mesh.p.shape[1] == 12
    else:
        with pytest.raises(fo.ModelError, match="share no face"):
            fo.Body(merged)
