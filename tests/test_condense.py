import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu
from skfem import MeshQuad, MeshTri

import frictopt as fo
from frictopt.fem.elasticity import Material, body_stiffness
from frictopt.fem.ordering import nested_dissection
from frictopt.fem.schur import Elimination


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), eliminated=st.integers(1, 20), kept=st.integers(1, 6))
def test_schur_complement_against_dense_algebra(seed, eliminated, kept):
    rng = np.random.default_rng(seed)
    n = eliminated + kept
    K = rng.normal(size=(n, n))
    K = K @ K.T + np.eye(n)
    F = rng.normal(size=(n, 2))
    elimination = Elimination(csr_matrix(K), kept)
    S, R = elimination.S, elimination.reactions(F)
    i, r = slice(eliminated), slice(eliminated, n)
    assert np.allclose(S, K[r, r] - K[r, i] @ np.linalg.solve(K[i, i], K[i, r]), rtol=1e-9, atol=1e-9)
    assert np.allclose(R, -(F[r] - K[r, i] @ np.linalg.solve(K[i, i], F[i])), rtol=1e-9, atol=1e-9)
    z = rng.normal(size=kept)
    u = elimination.unknowns(F[:, 0], R[:, 0], z)
    assert np.allclose(u[r], z) and np.allclose((K @ u)[i], F[i, 0], rtol=1e-9, atol=1e-9)


def test_a_singular_interior_is_refused():
    with pytest.raises(fo.ModelError, match="interior part is singular"):
        Elimination(csr_matrix(np.diag([0.0, 1.0])), 1)


def test_an_interior_held_by_the_interface_alone_is_refused():
    """Unknown 0 has no stiffness of its own, so that S does not exist, but the whole matrix factorises once its rows are exchanged."""
    K = np.array([[0.0, 1.0], [1.0, 2.0]])
    assert np.linalg.det(K) == -1.0
    with pytest.raises(fo.ModelError, match="stiffness"):
        Elimination(csr_matrix(K), 1)


@pytest.mark.parametrize(
    "mesh", [MeshQuad.init_tensor(np.linspace(0, 1, 41) ** 2, np.linspace(0, 1, 31)), MeshTri().refined(5), MeshTri.init_circle(4)]
)
def test_nested_dissection_orders_all_nodes_with_little_fill(mesh):
    K = body_stiffness(mesh, Material())
    nodes = mesh.p.shape[1]
    K = K[:nodes, :nodes] + K.diagonal().mean() * csr_matrix(np.eye(nodes))
    order = nested_dissection(K, mesh.p)
    assert np.array_equal(np.sort(order), np.arange(nodes))

    def fill(permutation):
        options = {"permc_spec": "NATURAL", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        return splu(K[permutation][:, permutation].tocsc(), **options).L.nnz

    assert fill(order) < 0.8 * fill(np.lexsort(mesh.p))


def test_coincident_nodes_do_not_stop_the_ordering():
    assert len(nested_dissection(csr_matrix(np.ones((60, 60))), np.zeros((2, 60)))) == 60


@pytest.mark.parametrize("element", ["linear", "mean_dilatation"])
@pytest.mark.parametrize("mesh", [MeshQuad.init_tensor([0.0, 0.3, 1.0], [0.0, 0.5, 0.7]), MeshTri().refined(1)])
def test_stiffness_of_uniform_strains(mesh, element):
    """Linear displacements make uniform stress; energy is half stress times strain times area, rigid motions have none."""
    material = Material(E=2.0, nu=0.2)
    lam, mu = 2.0 * 0.2 / (1.2 * 0.6), 2.0 / 2.4
    x, y = mesh.p
    area = np.ptp(x) * np.ptp(y)
    K = body_stiffness(mesh, material, element)
    cases = {
        "translation": (np.r_[0 * x + 1, 0 * x], 0.0),
        "turn": (np.r_[-y, x], 0.0),
        "stretch": (np.r_[x, 0 * y], (lam + 2 * mu) / 2 * area),
        "shear": (np.r_[y, 0 * x], mu / 2 * area),
        "both": (np.r_[x, y], 2 * (lam + mu) * area),
    }
    for u, energy in cases.values():
        assert u @ K @ u / 2 == pytest.approx(energy, abs=1e-13)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.4999])
def test_an_element_that_swells_on_one_side_and_shrinks_on_the_other_keeps_its_volume(nu):
    """Energy of u_x = x y on the square of side 2: 2 mu from the shear modulus, and 2 lambda / 3 from the volume if it is not averaged."""
    mesh, material = MeshQuad.init_tensor([-1.0, 1.0], [-1.0, 1.0]), Material(E=2.0, nu=nu)
    lam, mu = 2.0 * nu / ((1 + nu) * (1 - 2 * nu)), 2.0 / (2 * (1 + nu))
    x, y = mesh.p
    for u in (np.r_[x * y, 0 * x], np.r_[0 * x, x * y]):
        assert u @ body_stiffness(mesh, material, "mean_dilatation") @ u / 2 == pytest.approx(2 * mu, rel=1e-12)
        assert u @ body_stiffness(mesh, material, "linear") @ u / 2 == pytest.approx(2 * mu + 2 * lam / 3, rel=1e-12)


@pytest.mark.parametrize("nu", [-0.9, 0.3, 0.4999])
def test_averaging_the_dilatation_frees_no_motion(nu):
    """On a distorted mesh only the three rigid motions need no force, and what needs least needs about as much as without averaging."""
    mesh = MeshQuad.init_tensor(np.linspace(0, 1, 5), np.linspace(0, 1, 4))
    mesh = MeshQuad(mesh.p + 0.06 * np.random.default_rng(0).uniform(-1, 1, mesh.p.shape), mesh.t)
    mean, full = (np.linalg.eigvalsh(body_stiffness(mesh, Material(nu=nu), element).toarray()) for element in ("mean_dilatation", "linear"))
    assert np.abs(mean[:3]).max() < 1e-11 * mean[-1] and 0.3 < mean[3] / full[3] < 3.0


def test_triangles_have_a_uniform_dilatation_already():
    mesh = MeshTri().refined(2)
    mean, full = (body_stiffness(mesh, Material(nu=0.49), element).toarray() for element in ("mean_dilatation", "linear"))
    assert np.allclose(mean, full, rtol=0, atol=1e-12 * np.abs(full).max())


@pytest.mark.parametrize(
    ("E", "nu", "message"), [(0.0, 0.3, "E: 0.0"), (-1.0, 0.3, "E: -1"), (1.0, 0.5, "nu: 0.5"), (1.0, -1.0, "nu: -1"), (np.nan, 0.3, "E: nan")]
)
def test_impossible_materials_are_refused(E, nu, message):
    with pytest.raises(fo.ModelError, match=message):
        fo.Material(E=E, nu=nu)


def test_a_stiff_punch_takes_its_loads_to_rounding():
    """A million times as stiff as the block: the elimination is right to 4e-7, the sums of the reactions are those of the loads."""
    contact = fo.scenes.PunchOnHalfPlane(elements=24, punch_material=Material(E=1e6, nu=0.3)).condense()
    for name, q, p in (("P", 0.0, 2.0), ("sigma", 0.0, 0.0), ("Q", -2.0, 0.0)):
        assert [part.sum() for part in contact.bonded[name]] == pytest.approx([q, p], abs=1e-12)
