"""Models in space, loads of every kind, gaps and fields: a strip one element thick against the plane, and closed forms."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from skfem import Basis, ElementHex1, ElementQuad1, ElementTetP1, ElementTriP1, ElementVector, MeshHex, MeshQuad, MeshTet, MeshTri
from skfem.models.elasticity import linear_elasticity

import frictopt as fo
from frictopt.fem.elasticity import body_stiffness
from meshes import RUBBER, THICK

X, UP, DOWN = np.array([-1.0, -0.4, 0.1, 1.0]), np.array([0.0, 0.3, 1.0]), np.array([-1.0, -0.6, 0.0])
WIDE, FINE = np.r_[-2.0, X, 2.0], np.array([-2.0, -1.0, -0.55, 0.3, 0.8, 1.0, 2.0])  # whose nodes match those of X, and do not
FACES = {
    "contact": lambda x: (x[1] == 0) & (abs(x[0]) < 1),
    "top": lambda x: x[1] == 1,
    "bottom": lambda x: x[1] == -1,
    "right": lambda x: x[0] == 1,
    "left": lambda x: x[0] == -1,
}
LOADS = {
    "traction": [fo.Traction("punch", "right", x=lambda x, y, z=0: x - y, y=lambda x, y, z=0: -1 - y / 2)],
    "pressure": [fo.Pressure("punch", "right", lambda x, y, z=0: 1 + y**2), fo.Pressure("punch", "left", 0.3)],
    "weight": [fo.BodyForce("punch", x=0.2, y=lambda x, y, z=0: -y)],
    "heat": [fo.Expansion("punch", lambda x, y, z=0: 0.01 * x), fo.Expansion("block", 0.02)],
    "move": [fo.Displacement("block", "bottom", x=0.1, y=lambda x, y, z=0: 0.05 * x)],
    "fit": [fo.Interference("joint", 0.01)],
}


def models(element="linear", x_block=WIDE):
    """A punch on a block in plane strain, and the same one element thick, all held across but the nodes of the punch that the block holds."""
    found = []
    for depth in ([], [np.array([0.0, THICK])]):
        kind = MeshHex if depth else MeshQuad
        meshes = {"punch": kind.init_tensor(X, UP, *depth), "block": kind.init_tensor(x_block, DOWN, *depth)}
        bodies = {name: fo.Body(mesh.with_boundaries(FACES), RUBBER, element) for name, mesh in meshes.items()}
        across = [fo.Support(name, tuple(at), "z") for name, body in bodies.items() if depth for at in body.mesh.p[:, free_across(name, body.mesh)].T]
        centre = (0.3, 0.1, 5.0) if depth else (0.3, 0.1)
        loads = LOADS | {"spin": [fo.Centrifugal("punch", 2.0, 1.5, centre)]}
        contact = fo.Contact("punch", "block", name="joint", gap=lambda x, y, z=0: 0.001 * x**2)
        found.append(fo.ContactModel(bodies, [fo.Support("block", "bottom"), fo.Support("punch", "top", "y"), *across], loads, [contact]))
    return found


def free_across(name, mesh):
    """Nodes of a strip that follow no others."""
    face, midside = (mesh.p[1] == 0) & (abs(mesh.p[0]) <= 1), np.arange(mesh.p.shape[1]) >= mesh.nvertices
    return ~(face & ((name == "punch") | midside))


def onto_the_plane(plane, space):
    """(4, 8) sum over the front and the back node of each node of the plane."""
    return np.isclose(plane[:, :1], space[:, 0]).astype(float)


STRIPS = pytest.mark.parametrize(
    ("element", "x_block"), [("linear", WIDE), ("mean_dilatation", WIDE), ("quadratic", WIDE), ("linear", FINE), ("mean_dilatation", FINE)]
)


@STRIPS
def test_a_strip_in_plane_strain_has_the_contact_of_the_plane(element, x_block):
    flat, solid = (model.condense() for model in models(element, x_block))
    both = onto_the_plane(flat.points, solid.points)
    for case in flat.bonded:
        (q, p), (shear, pressure) = flat.bonded[case], solid.bonded[case]
        scale = np.abs([q, p]).max()
        assert np.allclose(both @ shear[:, 0], THICK * q, rtol=0, atol=1e-12 * scale) and np.allclose(both @ shear[:, 1], 0.0, atol=1e-12 * scale)
        assert np.allclose(both @ pressure, THICK * p, rtol=0, atol=1e-12 * scale)
    along = np.kron([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], both)
    assert np.allclose(along @ solid.S @ along.T, THICK * flat.S, rtol=0, atol=1e-12 * np.abs(flat.S).max())
    assert np.allclose(solid.gap @ both.T / 2, flat.gap) and np.allclose(both @ solid.width, THICK * flat.width)
    assert set(solid.contact) == {"joint"} and solid.E_star == flat.E_star


@STRIPS
def test_a_strip_in_plane_strain_has_the_fields_of_the_plane(element, x_block):
    plane, space = models(element, x_block)
    flat, solid = plane.condense(), space.condense()
    both, rng = onto_the_plane(flat.points, solid.points), np.random.default_rng(0)
    v, w, loads = rng.normal(size=4), flat.gap + rng.random(4), {case: float(rng.normal()) for case in plane.loads}
    one, two = plane.recover(loads, v), space.recover(loads, np.column_stack([both.T @ v, np.zeros(8)]))
    with pytest.warns(fo.ModelWarning, match="is open by"):  # any gap will do here
        one, two = plane.recover(loads, v, w), space.recover(loads, np.column_stack([both.T @ v, np.zeros(8)]), both.T @ w)
    assert np.allclose(both @ two.q[:, 0], THICK * one.q) and np.allclose(both @ two.p, THICK * one.p)
    for body in plane.bodies:
        p, s = plane.bodies[body].mesh.p, space.bodies[body].mesh.p
        place = np.array([np.linalg.norm(p - at[:, None], axis=0).argmin() for at in s[:2].T])
        assert np.allclose(two.displacement[body][:2], one.displacement[body][:, place]) and np.allclose(two.displacement[body][2], 0.0, atol=1e-12)
        for field in ("stress", "strain"):
            thick, thin = getattr(two, field)[body], getattr(one, field)[body]
            assert thick.shape[0] == 6 and np.allclose(thick[:4], thin[:, place]) and np.allclose(thick[4:], 0.0, atol=1e-9 * np.abs(thin).max())
    for side in (1, 2):
        for thick, thin in zip(two.at_contact(side), one.at_contact(side), strict=True):
            assert thick.shape == (8, 2, 2) and np.allclose(thick[:, 0, 0], both.T @ thin)


@pytest.mark.parametrize(("kind", "element"), {MeshTri: ElementTriP1, MeshQuad: ElementQuad1, MeshTet: ElementTetP1, MeshHex: ElementHex1}.items())
def test_one_stiffness_for_all_meshes_is_that_of_scikit_fem(kind, element):
    mesh = kind().refined(1)
    mesh = kind(mesh.p + 0.03 * np.random.default_rng(0).uniform(-1, 1, mesh.p.shape), mesh.t)
    basis = Basis(mesh, ElementVector(element()))
    expected = linear_elasticity(*RUBBER.lame).assemble(basis)
    rows = basis.nodal_dofs.ravel()
    K = body_stiffness(mesh, RUBBER)
    assert np.abs(csr_matrix(expected)[rows][:, rows] - K).max() < 1e-13 * np.abs(K).max()
