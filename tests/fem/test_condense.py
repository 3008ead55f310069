import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import LinAlgError
from scipy.sparse import csr_matrix
from skfem import MeshQuad

import frictopt as fo
from frictopt.fem.elasticity import Material, body_stiffness
from frictopt.fem.schur import eliminate, nested_dissection, solve
from helpers.cases import few
from helpers.refused import refused


@st.composite
def sparse_problems(draw):
    """A matrix, fronts in any order, and loads.

    The matrix is positive definite in the unknowns that are eliminated. Its graph is arbitrary:
    disconnected, with dense rows, or empty.
    """
    eliminated, kept = draw(st.integers(0, 25)), draw(st.integers(0, 7))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    n = eliminated + kept
    density = draw(st.sampled_from([0.0, 0.05, 0.2, 0.6]))
    A = rng.normal(size=(n, n)) * (rng.random((n, n)) < density)
    if n and draw(st.booleans()):
        A[rng.integers(n)] = 1.0
    K = A @ A.T + np.diag(10.0 ** rng.uniform(-3, 3, size=n))
    front = np.full(n, -1)
    inner = np.sort(rng.permutation(n)[:eliminated])
    front[inner] = np.unique(
        rng.integers(draw(st.integers(1, 12)), size=eliminated), return_inverse=True
    )[1]
    # What is kept may be anything.
    K[np.ix_(front < 0, front < 0)] -= np.diag(rng.uniform(0, 2e3, size=kept))
    return K, front, rng.normal(size=n)


@settings(max_examples=few(100))
@given(sparse_problems())
def test_elimination_against_dense_algebra(problem):
    K, front, F = problem
    i, r = front >= 0, front < 0
    inner, coupling = K[np.ix_(i, i)], K[np.ix_(i, r)]
    S = K[np.ix_(r, r)] - coupling.T @ np.linalg.solve(inner, coupling)
    found, _ = eliminate(csr_matrix(K), front)
    scale = np.abs(K).max(initial=1.0)
    assert found.shape == S.shape
    assert np.allclose(found, S, rtol=1e-9, atol=1e-11 * scale)
    assert np.array_equal(found, found.T)
    u = solve(eliminate(csr_matrix(inner), front[i], keep=float)[1], F[i])
    assert np.allclose(
        u, np.linalg.solve(inner, F[i]), rtol=1e-7, atol=1e-9 * np.abs(u).max(initial=1.0)
    )


@settings(max_examples=few(30))
@given(seed=st.integers(0, 10**6), n=st.integers(1, 20), fronts=st.integers(1, 6))
def test_an_indefinite_part_is_refused(seed, n, fronts):
    """In the order of elimination, the leading part that ends at this unknown is not positive
    definite."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    values, vectors = np.linalg.eigh(A + A.T)
    values[0] = rng.choice(
        [-1e-9 * np.abs(values).max(), -1e-3 * np.abs(values).max(), -np.abs(values).max()]
    )
    K = vectors * np.r_[values[0], np.abs(values[1:]) + 0.1] @ vectors.T
    front = np.unique(rng.integers(fronts, size=n), return_inverse=True)[1]
    with pytest.raises(LinAlgError) as caught:
        eliminate(csr_matrix(K), front)
    order = np.argsort(front, kind="stable")
    leading = order[: np.flatnonzero(order == caught.value.args[0])[0] + 1]
    assert np.linalg.eigvalsh(K[np.ix_(leading, leading)])[0] <= 1e-9 * np.abs(K).max()


def test_an_unknown_without_stiffness_is_refused_whatever_the_others_are():
    for K in (
        np.diag([1e9, 0.0, 1.0]),
        np.array([[1e9, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 2.0]]),
    ):
        with pytest.raises(LinAlgError) as caught:
            eliminate(csr_matrix(K), np.array([0, 0, -1]))
        assert caught.value.args == (1,)


def test_a_body_that_comes_apart_is_named_with_its_node():
    """A spring to the ground pulls at a node: the stiffness of the node is negative once its
    neighbours may move."""
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = np.zeros((6, 6))
    for one, two in ((0, 2), (2, 4), (1, 3), (3, 5)):
        K[np.ix_([one, two], [one, two])] += spring
    K[[4, 5], [4, 5]] = -0.9
    rows = np.vstack([np.arange(6).reshape(3, 2), [-1, -1]])
    points = [[0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [0.0, 0.0]]
    with pytest.raises(
        fo.ModelError,
        match=r"stiffness: node [12] at \(0, [12]\) has no stiffness .*; support the bodies",
    ):
        fo.condense(
            csr_matrix(K), {"P": np.ones(6)}, [[0, 3]], [0.0, 1.0], rows, points, width=[1.0]
        )


def test_a_body_much_softer_than_its_neighbour_is_named():
    """A free punch is 1e15 times as stiff as the block. Of the stiffness at the contact, the part
    that holds the punch is rounding."""
    scene = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0, punch_material=Material(1e15))
    for ask in (scene.condense, lambda: scene.model().recover({"P": 1.0}, np.zeros(5))):
        with pytest.raises(
            fo.ModelError,
            match=r"stiffness: node \d+ of body '(punch|block)' at .* has no stiffness .* reduce the ratio",
        ):
            ask()


def test_coincident_nodes_do_not_stop_the_ordering():
    assert np.array_equal(
        nested_dissection(csr_matrix(np.ones((90, 90))), np.zeros((2, 90))), np.zeros(90)
    )


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.4999])
def test_an_element_that_swells_on_one_side_and_shrinks_on_the_other_keeps_its_volume(nu):
    """The energy of u_x = x y on the square of side 2 is 2 mu from the shear modulus, and 2 lambda
    / 3 from the volume if the dilatation is not averaged."""
    mesh = MeshQuad.init_tensor([-1.0, 1.0], [-1.0, 1.0])
    material = Material(E=2.0, nu=nu)
    lam, mu = 2.0 * nu / ((1 + nu) * (1 - 2 * nu)), 2.0 / (2 * (1 + nu))
    x, y = mesh.p
    for u in (np.c_[x * y, 0 * x].ravel(), np.c_[0 * x, x * y].ravel()):
        assert u @ body_stiffness(mesh, material, "mean_dilatation") @ u / 2 == pytest.approx(
            2 * mu, rel=1e-12
        )
        assert u @ body_stiffness(mesh, material, "linear") @ u / 2 == pytest.approx(
            2 * mu + 2 * lam / 3, rel=1e-12
        )


@pytest.mark.parametrize("nu", [-0.9, 0.3, 0.4999])
def test_averaging_the_dilatation_frees_no_motion(nu):
    """On a distorted mesh only the three rigid motions need no force. The motion with the smallest
    force needs about the same force as without averaging."""
    mesh = MeshQuad.init_tensor(np.linspace(0, 1, 5), np.linspace(0, 1, 4))
    mesh = MeshQuad(mesh.p + 0.06 * np.random.default_rng(0).uniform(-1, 1, mesh.p.shape), mesh.t)
    mean, full = (
        np.linalg.eigvalsh(body_stiffness(mesh, Material(nu=nu), element).toarray())
        for element in ("mean_dilatation", "linear")
    )
    assert np.abs(mean[:3]).max() < 1e-11 * mean[-1] and 0.3 < mean[3] / full[3] < 3.0


@refused(
    (0.0, 0.3, "E: 0.0"),
    (-1.0, 0.3, "E: -1"),
    (1.0, 0.5, "nu: 0.5"),
    (1.0, -1.0, "nu: -1"),
    (np.nan, 0.3, "E: nan"),
)
def test_impossible_materials_are_refused(E, nu):
    fo.fem.Material(E=E, nu=nu)


@pytest.mark.parametrize("stiff", [1e-6, 1e6])
def test_a_stiff_or_soft_punch_takes_its_loads_to_rounding(stiff):
    """It is a million times as stiff as the block. The elimination is right to 4e-7, and the sums
    of the reactions equal the sums of the loads."""
    contact = fo.scenes.PunchOnHalfPlane(
        elements=24, punch_material=Material(E=stiff, nu=0.3)
    ).condense()
    for name, q, p in (("P", 0.0, 2.0), ("sigma", 0.0, 0.0), ("Q", -2.0, 0.0)):
        assert [part.sum() for part in contact.bonded[name]] == pytest.approx([q, p], abs=1e-12)
