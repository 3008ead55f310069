"""Quadratic elements, straight and curved.

They are compared with uniform stress, bending, integrals over a curved body, and finer linear
meshes.
"""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshQuad, MeshTri

import frictopt as fo
from helpers.meshes import rotation
from helpers.quadratic import SECOND, arched, box, dimensions, two_boxes


@pytest.mark.parametrize("kind", SECOND)
@pytest.mark.parametrize("nu", [0.3, 0.4999])
def test_uniform_pressure_passes_between_curved_bodies(kind, nu):
    """It acts on all sides. Each pair carries its share of the area, as on linear faces, and the
    stress is uniform at all nodes. The whole model is turned."""
    d, material = dimensions(kind), fo.fem.Material(2.0, nu)
    turn = (
        rotation(0.6) if d == 2 else np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    )
    bodies, up = two_boxes(kind, material, turn=turn), turn[:, -1]
    corner = [tuple(turn @ point) for point in np.eye(d)[:-1] - np.eye(d)[-1]]
    held = [
        fo.fem.Support("lower", tuple(-up), "xyz"[:d]),
        fo.fem.Support("lower", corner[0], "y" if d == 2 else "yz"),
    ]
    held += [fo.fem.Support("lower", corner[1], "z")] if d == 3 else []
    model = fo.fem.ContactModel(
        bodies, held, {"P": [fo.fem.Pressure(name, "outline") for name in bodies]}
    )
    system = model.condense()
    fields = model.recover({"P": 1.0}, np.zeros(system.nodes if d == 2 else (system.nodes, 2)))
    rounding = max(1e-12, 1e-15 / (1 - 2 * nu))  # forces have that of the bulk modulus
    assert np.allclose(fields.p, system.width, rtol=0, atol=rounding)
    assert np.abs(fields.q).max() < rounding
    assert system.width.min() > 0.02
    uniform = [-1.0, -1.0, 0.0, -1.0, 0.0, 0.0] if d == 3 else [-1.0, -1.0, 0.0, -2 * nu]
    for name in bodies:
        # Three points hold 25 of displacement.
        assert np.abs(fields.stress[name] - np.array(uniform)[:, None]).max() < 3e-9
    rigid = np.linalg.eigvalsh(system.S) < 1e-11 * np.linalg.norm(system.S)
    assert rigid.sum() == d * (d + 1) // 2


@pytest.mark.parametrize("kind", SECOND)
def test_a_curved_face_hands_over_forces_and_moments_and_lets_bodies_turn(kind):
    """The rigid motions of the upper body need no force against the stiffness, and the reactions
    are in balance with any load on it."""
    d = dimensions(kind)
    bodies = two_boxes(kind, fo.fem.Material(), bulge=arched)
    pull = [
        fo.fem.Traction(
            "upper", "far", x=0.3, y=lambda *x: -1 + x[0], **({"z": -0.2} if d == 3 else {})
        )
    ]
    system = fo.fem.ContactModel(bodies, [fo.fem.Support("lower", "far")], {"F": pull}).condense()
    assert np.ptp(system.points[:, -1]) > 0.05
    arms = system.points
    turns = [(a, b) for a in range(d) for b in range(a)]
    motions = [np.tile(direction, (system.nodes, 1)) for direction in np.eye(d)]
    motions += [arms[:, [a]] * np.eye(d)[b] - arms[:, [b]] * np.eye(d)[a] for a, b in turns]
    load = pull[0]._forces(bodies["upper"], "space")
    far = bodies["upper"].mesh.p
    works = [*load.sum(axis=1), *(far[a] @ load[b] - far[b] @ load[a] for a, b in turns)]
    q, p = system.bonded["F"]
    reaction = np.r_[np.ravel(q, order="F"), p]
    for motion, work in zip(motions, works, strict=True):
        z = np.einsum("nra,na->rn", system.frames, motion).ravel()
        assert np.abs(system.S @ z).max() < 1e-11 * np.abs(system.S).max()
        assert reaction @ z == pytest.approx(-work, abs=1e-11)


def bent(kind, nu, element):
    """The model of two glued boxes and its fields under bending.

    The boxes are 4 long and 1 high together, and couples bend them by the curvature 1.
    """
    d, material = dimensions(kind), fo.fem.Material(3.0, nu)
    depth = [(0.0, 0.7)] * (d - 2)
    bodies = {
        "left": fo.fem.Body(
            box(kind, (0.0, 1.0), (-0.5, 0.5), *depth, linear=True), material, element
        ),
        "right": fo.fem.Body(
            box(kind, (1.0, 4.0), (-0.5, 0.5), *depth, steps=(6, 2, 2)[:d], linear=True),
            material,
            element,
        ),
    }
    held = [
        fo.fem.Support("left", "x0", "x"),
        fo.fem.Support("left", (0.0, 0.0, 0.0)[:d], "y" if d == 2 else "yz"),
    ]
    held += [fo.fem.Support("left", (0.0, 0.5, 0.0), "z")] if d == 3 else []
    bend = {"M": [fo.fem.Traction("right", "x1", x=lambda x, y, *z: 3.0 * y)]}
    model = fo.fem.ContactModel(bodies, held, bend, [fo.fem.Contact("right", "left", "x0", "x1")])
    return model, model.recover(
        {"M": 1.0}, np.zeros((model.condense().nodes, d - 1) if d == 3 else model.condense().nodes)
    )


@pytest.mark.parametrize("kind", SECOND)
def test_pure_bending_is_exact_without_lateral_strain(kind):
    """u_x = x y, u_y = - x^2 / 2, by the elements that linear meshes become. A section stays plane,
    so that its midside nodes need not follow."""
    model, fields = bent(kind, 0.0, "quadratic")
    for name, body in model.bodies.items():
        x, y = body.mesh.p[:2]
        assert np.allclose(fields.displacement[name][:2], [x * y, -(x**2) / 2], rtol=0, atol=1e-10)
        assert np.allclose(fields.stress[name][0], 3 * y, atol=1e-9)
        assert np.abs(fields.stress[name][1:3]).max() < 1e-9
        assert np.allclose(fields.strain[name][0], y, atol=1e-9)


HUMP = 0.2


def hump(p):
    """Raise the upper side of a box to a parabola.

    The box is between heights 0 and 1, and x = -1 and 1. The parabola is 1 + HUMP (1 - x^2).
    """
    p[-1] *= 1 + HUMP * (1 - p[0] ** 2)
    return p


@pytest.mark.parametrize("kind", SECOND)
def test_loads_on_a_curved_body_have_the_totals_of_its_parabola(kind):
    """Quadratic elements represent the parabola of its outline exactly. The integrals are known in
    closed form, over a depth of 0.7 in space."""
    d = dimensions(kind)
    thick = 0.7 if d == 3 else 1.0
    body = fo.fem.Body(
        box(kind, (-1.0, 1.0), *[(0.0, 0.7)] * (d - 2), (0.0, 1.0), bulge=hump),
        fo.fem.Material(2.0, 0.3),
    )
    x, up = body.mesh.p[0], body.mesh.p[-1]
    kinematics = "space" if d == 3 else "plane_strain"
    top = "z1" if d == 3 else "y1"
    name = "xyz"[d - 1]
    c = HUMP
    area = 2 * (1 + 2 * c / 3)
    high = (2 + 8 * c / 3 + 16 * c**2 / 15) / 2  # integral of the height
    square = 2 / 3 + c * 4 / 15  # integral of x^2

    def forces(load):
        return load._forces(body, kinematics)

    # Its normal lies along (2 c x, 1) dx.
    pressed = forces(fo.fem.Pressure("body", top, lambda x, *others: x**2))
    assert pressed[-1].sum() == pytest.approx(-2 / 3 * thick, rel=1e-12)
    assert pressed[0] @ x == pytest.approx(-4 * c / 5 * thick, rel=1e-12)
    pressed = forces(fo.fem.Pressure("body", top))
    assert pressed[0] @ up - pressed[-1] @ x == pytest.approx(0.0, abs=1e-12)
    assert pressed[0] @ x == pytest.approx(-4 * c / 3 * thick, rel=1e-12)
    weight = forces(fo.fem.BodyForce("body", **{name: -3.0}))
    assert weight[-1].sum() == pytest.approx(-3 * area * thick, rel=1e-12)
    assert weight[-1] @ up == pytest.approx(-3 * high * thick, rel=1e-12)
    spin = forces(
        fo.fem.Centrifugal(
            "body", 2.0, 1.5, (0.0,) * d, axis=(0.0, 0.0, 2.0) if d == 2 else (0.0, 2.0, 0.0)
        )
    )
    assert d == 2 or np.abs(spin[1]).max() < 1e-12
    assert spin[-1].sum() == pytest.approx(4.5 * high * thick, rel=1e-12)
    assert spin[0] @ x == pytest.approx(4.5 * square * thick, rel=1e-10)
    hot = forces(fo.fem.Expansion("body", lambda x, *others: 0.01 * x**2))
    tension = 2.0 / (1 - 2 * 0.3) * 0.01  # E / (1 - 2 nu) times the strain
    assert hot[0] @ x == pytest.approx(tension * square * thick, rel=1e-10)
    assert np.abs(hot.sum(axis=1)).max() < 1e-14
    pulled = forces(fo.fem.Traction("body", "x1", x=lambda x, *others: others[-1]))
    assert pulled[0].sum() == pytest.approx(thick / 2, rel=1e-12)
    assert pulled[0] @ up == pytest.approx(thick / 3, rel=1e-12)


def test_a_curved_body_of_one_mesh_is_split_as_it_is():
    """Two halves of a humped body have the nodes of the whole."""
    whole = box(MeshTri, (-1.0, 1.0), (0.0, 1.0), bulge=hump).with_subdomains(
        {"left": lambda x: x[0] < 0, "right": lambda x: x[0] > 0}
    )
    bodies = fo.fem.split_bodies(whole, {"left": fo.fem.Material(), "right": fo.fem.Material()})
    kept = {tuple(point) for body in bodies.values() for point in body.mesh.p.T}
    assert kept == set(map(tuple, whole.p.T))
    assert {body.element for body in bodies.values()} == {"quadratic"}
    weights = [
        fo.fem.BodyForce(name, y=1.0)._forces(body, "plane_strain")[1].sum()
        for name, body in bodies.items()
    ]
    assert np.allclose(weights, 1 + 2 * HUMP / 3, rtol=1e-12)
    assert bodies["left"].boundary_nodes("right", "cut").size == 5


def off(by):
    """Two boxes of quadrilaterals, the midside nodes of the contact of the upper one moved."""
    bodies = two_boxes(MeshQuad, fo.fem.Material())
    mesh = bodies["upper"].mesh
    points = mesh.p.copy()
    face = mesh.dofs.facet_dofs[0, mesh.boundaries["contact"]]
    points[:, face] += np.array(by)[:, None]
    return bodies | {"upper": fo.fem.Body(replace(mesh, doflocs=points))}


def test_what_a_contact_of_quadratic_bodies_cannot_be_is_named():
    load = {"P": [fo.fem.Pressure("upper", "far")]}
    for by, distance in (((0.0, 0.06), "0.06"), ((0.07, 0.0), "0.07")):
        message = rf"contacts: body 'upper': the midside node at \(\S+, {by[1]:g}\) lies {distance} off the middle of its corners, which are 0.5"
        with pytest.raises(fo.ModelError, match=message):
            fo.fem.ContactModel(off(by), [fo.fem.Support("lower", "far")], load)
    fo.fem.ContactModel(off((0.0, 0.04)), [fo.fem.Support("lower", "far")], load)
    with pytest.raises(
        fo.ModelError,
        match="is a midside node of a contact face, which follows the corners; hold corners",
    ):
        fo.fem.ContactModel(
            two_boxes(MeshTri, fo.fem.Material()),
            [fo.fem.Support("lower", "far"), fo.fem.Support("upper", (0.25, 0.0), "x")],
            load,
        )
    inside_out = box(MeshTri, (0.0, 1.0), (0.0, 1.0))
    points = inside_out.p.copy()
    points[:, inside_out.dofs.facet_dofs[0, 0]] += 0.4
    with pytest.raises(
        fo.ModelError,
        match=r"elements that are not convex or have no area: .*; mesh finer, or with straight sides",
    ):
        fo.fem.Body(replace(inside_out, doflocs=points))
