"""Models in space with loads of every kind, gaps and fields.

A strip one element thick is compared with the plane, and other models with closed forms.
"""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from skfem import (
    Basis,
    ElementHex1,
    ElementQuad1,
    ElementTetP1,
    ElementTriP1,
    ElementVector,
    MeshHex,
    MeshQuad,
    MeshTet,
    MeshTri,
)
from skfem.models.elasticity import linear_elasticity

import frictopt as fo
from frictopt.fem.elasticity import body_stiffness
from helpers.meshes import RUBBER, THICK
from helpers.refused import refused
from helpers.spatial import vectors

X = np.array([-1.0, -0.4, 0.1, 1.0])
UP = np.array([0.0, 0.3, 1.0])
DOWN = np.array([-1.0, -0.6, 0.0])
# The nodes of WIDE match the nodes of X, the nodes of FINE do not.
WIDE = np.r_[-2.0, X, 2.0]
FINE = np.array([-2.0, -1.0, -0.55, 0.3, 0.8, 1.0, 2.0])
FACES = {
    "contact": lambda x: (x[1] == 0) & (abs(x[0]) < 1),
    "top": lambda x: x[1] == 1,
    "bottom": lambda x: x[1] == -1,
    "right": lambda x: x[0] == 1,
    "left": lambda x: x[0] == -1,
}
LOADS = {
    "traction": [
        fo.fem.Traction("punch", "right", x=lambda x, y, z=0: x - y, y=lambda x, y, z=0: -1 - y / 2)
    ],
    "pressure": [
        fo.fem.Pressure("punch", "right", lambda x, y, z=0: 1 + y**2),
        fo.fem.Pressure("punch", "left", 0.3),
    ],
    "weight": [fo.fem.BodyForce("punch", x=0.2, y=lambda x, y, z=0: -y)],
    "heat": [
        fo.fem.Expansion("punch", lambda x, y, z=0: 0.01 * x),
        fo.fem.Expansion("block", 0.02),
    ],
    "move": [fo.fem.Displacement("block", "bottom", x=0.1, y=lambda x, y, z=0: 0.05 * x)],
    "fit": [fo.fem.Interference("joint", 0.01)],
}


def models(element="linear", x_block=WIDE):
    """A punch on a block in plane strain, and the same one element thick in space.

    All nodes are held across the strip, except the nodes of the punch that the block holds.
    """
    found = []
    for depth in ([], [np.array([0.0, THICK])]):
        kind = MeshHex if depth else MeshQuad
        meshes = {
            "punch": kind.init_tensor(X, UP, *depth),
            "block": kind.init_tensor(x_block, DOWN, *depth),
        }
        bodies = {
            name: fo.fem.Body(mesh.with_boundaries(FACES), RUBBER, element)
            for name, mesh in meshes.items()
        }
        across = [
            fo.fem.Support(name, tuple(at), "z")
            for name, body in bodies.items()
            if depth
            for at in body.mesh.p[:, free_across(name, body.mesh)].T
        ]
        centre = (0.3, 0.1, 5.0) if depth else (0.3, 0.1)
        loads = LOADS | {"spin": [fo.fem.Centrifugal("punch", 2.0, 1.5, centre)]}
        contact = fo.fem.Contact("punch", "block", name="joint", gap=lambda x, y, z=0: 0.001 * x**2)
        found.append(
            fo.fem.ContactModel(
                bodies,
                [fo.fem.Support("block", "bottom"), fo.fem.Support("punch", "top", "y"), *across],
                loads,
                [contact],
            )
        )
    return found


def free_across(name, mesh):
    """Nodes of a strip that follow no others."""
    face = (mesh.p[1] == 0) & (abs(mesh.p[0]) <= 1)
    midside = np.arange(mesh.p.shape[1]) >= mesh.nvertices
    return ~(face & ((name == "punch") | midside))


def onto_the_plane(plane, space):
    """(4, 8) sum over the front and the back node of each node of the plane."""
    return np.isclose(plane[:, :1], space[:, 0]).astype(float)


STRIPS = pytest.mark.parametrize(
    ("element", "x_block"),
    [
        ("linear", WIDE),
        ("mean_dilatation", WIDE),
        ("quadratic", WIDE),
        ("linear", FINE),
        ("mean_dilatation", FINE),
    ],
)


@STRIPS
def test_a_strip_in_plane_strain_has_the_contact_of_the_plane(element, x_block):
    flat, solid = (model.condense() for model in models(element, x_block))
    both = onto_the_plane(flat.points, solid.points)
    for case in flat.bonded:
        (q, p), (shear, pressure) = flat.bonded[case], solid.bonded[case]
        scale = np.abs([q, p]).max()
        assert np.allclose(both @ shear[:, 0], THICK * q, rtol=0, atol=1e-12 * scale)
        assert np.allclose(both @ shear[:, 1], 0.0, atol=1e-12 * scale)
        assert np.allclose(both @ pressure, THICK * p, rtol=0, atol=1e-12 * scale)
    along = np.kron([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], both)
    assert np.allclose(
        along @ solid.S @ along.T, THICK * flat.S, rtol=0, atol=1e-12 * np.abs(flat.S).max()
    )
    assert np.allclose(solid.gap @ both.T / 2, flat.gap)
    assert np.allclose(both @ solid.width, THICK * flat.width)
    assert set(solid.contact) == {"joint"} and solid.E_star == flat.E_star


@pytest.mark.parametrize(
    ("kind", "element"),
    {
        MeshTri: ElementTriP1,
        MeshQuad: ElementQuad1,
        MeshTet: ElementTetP1,
        MeshHex: ElementHex1,
    }.items(),
)
def test_one_stiffness_for_all_meshes_is_that_of_scikit_fem(kind, element):
    mesh = kind().refined(1)
    mesh = kind(mesh.p + 0.03 * np.random.default_rng(0).uniform(-1, 1, mesh.p.shape), mesh.t)
    basis = Basis(mesh, ElementVector(element()))
    expected = linear_elasticity(*RUBBER.lame).assemble(basis)
    rows = basis.nodal_dofs.T.ravel()
    K = body_stiffness(mesh, RUBBER)
    assert np.abs(csr_matrix(expected)[rows][:, rows] - K).max() < 1e-13 * np.abs(K).max()


CYCLE = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
SCENE = fo.scenes.SquarePunch(elements=4, growth=2.0)


def test_the_cube_of_another_code_has_its_known_limit(cube):
    job, (x, y, z) = cube, cube.points.T
    face = np.flatnonzero(np.isclose(z, 0) & (abs(x) < 1.001) & (abs(y) < 1.001))
    sides = [
        job.force(np.flatnonzero(np.isclose(x, 4 * side)), traction=[side, 0.0, 0.0])
        for side in (1.0, -1.0)
    ]
    loads = {
        "P": job.force(np.flatnonzero(np.isclose(z, 1.5)), traction=[0.0, 0.0, -1.0]),
        "sigma": sides[0] + sides[1],
    }
    system = fo.condense(
        job.K, loads, job.pairs(face[:9], face[9:]), [0.0, 0.0, 1.0], job.unknowns, job.points
    )
    assert fo.shakedown_limit(system, CYCLE, 0.5).load_factor == pytest.approx(
        1.413123958619, rel=1e-9
    )
    gap = {name: r[18:].sum() for name, r in vectors(system).items()}
    assert gap["P"] == pytest.approx(4.0)


SIDES = {"contact": lambda x: x[1] == 0, "top": lambda x: x[1] == 1, "bottom": lambda x: x[1] == -1}
PLANE = fo.fem.Body(MeshQuad.init_tensor([0.0, 1.0], [0.0, 1.0]).with_boundaries(SIDES))
TWO_SQUARES = {
    "punch": PLANE,
    "block": fo.fem.Body(MeshQuad.init_tensor([0.0, 1.0], [-1.0, 0.0]).with_boundaries(SIDES)),
}


@refused(
    (
        {"bodies": {"punch": PLANE, "block": SCENE.model().bodies["block"]}},
        "bodies: 'punch' is plane, 'block' in space",
    ),
    ({"kinematics": "plane_stress"}, "kinematics: 'plane_stress' with bodies in space"),
    (
        {"bodies": TWO_SQUARES, "supports": [fo.fem.Support("block", "bottom")]},
        "Traction z: -1.0; body 'punch' is plane",
    ),
    (
        {"bodies": TWO_SQUARES, "supports": [fo.fem.Support("block", "bottom", "z")]},
        "supports: directions 'z' of body 'block', which is plane",
    ),
    (
        {"supports": [fo.fem.Support("block", (0.0, 0.0))]},
        r"where: \(0.0, 0.0\); give the 3 coordinates",
    ),
    (
        {"loads": {"S": [fo.fem.Centrifugal("punch", 1.0, centre=(0.0, 0.0))]}},
        r"centre: \(0.0, 0.0\); give the 3 coordinates",
    ),
)
def test_models_that_make_no_sense_are_refused_by_name(change):
    model = SCENE.model()
    values = {name: getattr(model, name) for name in ("bodies", "supports", "loads")}
    fo.fem.ContactModel(**values | change).condense()


@pytest.mark.parametrize("kind", [MeshHex, MeshTet])
@pytest.mark.parametrize("by", [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [3.0, 0.0, 0.0]])
def test_a_body_of_pieces_that_share_no_face_is_refused(kind, by):
    """Two cubes have their own nodes, or share an edge once their nodes are merged."""
    cube = kind.init_tensor([0.0, 1.0], [0.0, 1.0], [0.0, 1.0])
    other = cube.translated(by)
    apart = kind(np.hstack([cube.p, other.p]), np.hstack([cube.t, cube.p.shape[1] + other.t]))
    with pytest.raises(fo.ModelError, match="2 parts that share no face; give one connected body"):
        fo.fem.Body(apart)
    points, number = np.unique(apart.p, axis=1, return_inverse=True)
    merged = kind(points, number.ravel()[apart.t])
    if by == [1.0, 0.0, 0.0]:
        assert fo.fem.Body(merged).mesh.p.shape[1] == 12
    else:
        with pytest.raises(fo.ModelError, match="share no face"):
            fo.fem.Body(merged)
