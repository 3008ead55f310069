"""The inner parts of a condensation in three dimensions: two blocks of hexahedra against the equations with multipliers, by dense algebra."""

import re

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_matrix
from skfem import Basis, ElementHex1, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

import frictopt as fo
from frictopt.fem.condense import condensed
from frictopt.fem.given import held_nodes
from frictopt.fem.interface import Interface, openings
from frictopt.fem.rigid import node_graph


def problem(held=slice(None)):
    """A free block on one that is held below, turned in space; rows of K, loads and frames of the 9 pairs."""
    rng = np.random.default_rng(5)
    x = np.linspace(-1, 1, 3)
    bases = [Basis(MeshHex.init_tensor(x, x, z), ElementVector(ElementHex1())) for z in ([0.0, 0.7], [-1.0, 0.0])]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    K = block_diag([linear_elasticity(*lame_parameters(1.0, nu)).assemble(basis) for nu, basis in zip((0.3, 0.2), bases, strict=True)]).tocsr()
    unknowns = np.concatenate([bases[0].nodal_dofs.T, bases[0].N + bases[1].nodal_dofs.T])
    flat = np.concatenate([basis.mesh.p for basis in bases], axis=1).T
    spin = np.zeros(K.shape)
    for rows in unknowns:
        spin[np.ix_(rows, rows)] = turn
    nodes = [np.flatnonzero((flat[:, 2] == 0) & (np.arange(len(flat)) // bases[0].mesh.p.shape[1] == side)) for side in (0, 1)]
    one, two = (face[np.lexsort(flat[face].T)] for face in nodes)
    P = csr_matrix((np.ones(9), (np.arange(9), two)), shape=(9, len(flat)))
    fixed = unknowns[flat[:, 2] == -1.0][held].ravel()
    rows = np.where(np.isin(unknowns, fixed), -1, unknowns)
    interface = Interface(one, openings(one, P), np.tile(turn.T, (9, 1, 1)), held_nodes(rows))
    return csr_matrix(spin @ K.toarray() @ spin.T), rng.normal(size=(K.shape[0], 2)), interface, rows, flat @ turn.T, fixed


def reduced(K, F, interface, unknowns, points):
    return condensed(K, {"0": F[:, 0], "1": F[:, 1]}, {}, interface, unknowns, points, ["contact"] * 9, node_graph(K, unknowns), str)


def test_a_free_block_on_a_held_one():
    K, F, interface, unknowns, points, held = problem()
    S, bonded, _ = reduced(K, F, interface, unknowns, points)
    R = np.column_stack([bonded["0"], bonded["1"]])
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    G = np.zeros((27, K.shape[0]))
    for i, (row, frame) in enumerate(zip(interface.opening.toarray(), interface.frames, strict=True)):
        for node in np.flatnonzero(row):
            G[i::9, unknowns[node]] += row[node] * frame
    G = G[:, free]
    n, k = len(free), 27
    whole = np.block([[K.toarray()[np.ix_(free, free)], -G.T], [G, np.zeros((k, k))]])
    r = np.linalg.solve(whole, np.block([[np.zeros((n, k)), F[free]], [np.eye(k), np.zeros((k, 2))]]))[n:]
    assert np.allclose(S, r[:, :k], atol=1e-12) and np.allclose(R, r[:, k:], atol=1e-11)
    assert (np.linalg.eigvalsh(S) < 1e-12).sum() == 6


@pytest.mark.parametrize(
    ("held", "free"), [(slice(0), "move along x and y and z and turn about x and y and z"), (slice(1), "turn about x and y and z"), (slice(2), "")]
)
def test_rigid_motions_in_space(held, free):
    """Two nodes that are held leave the turn about the line through them."""
    K, F, interface, unknowns, points, _ = problem(held)
    if not free:
        one, two = points[(unknowns < 0).all(axis=1)]
        axis = (two - one) / np.linalg.norm(two - one)
        axis *= np.sign(axis[np.abs(axis).argmax()])
        free = f"turn about ({', '.join(f'{value:g}' for value in axis.round(6))})"
    with pytest.raises(fo.ModelError, match=re.escape(f"can still {free}; add")):
        reduced(K, F, interface, unknowns, points)


SIDES = {
    "floor": ("xz", "move along y"),
    "wall": ("x", "move along y and z and turn about x"),
    "ground": ("z", "move along x and y and turn about z"),
}


@pytest.mark.parametrize("side", SIDES)
def test_what_a_face_held_in_some_directions_leaves(side):
    """By hand: of six motions, a face with normal n held along n leaves the two shifts in it and the turn about n."""
    x = np.array([0.0, 0.5, 1.0])
    names = {"contact": lambda x: x[2] == 0, "floor": lambda x: x[2] == -1, "wall": lambda x: x[0] == 0, "ground": lambda x: x[2] == -1}
    upper = MeshHex.init_tensor(x, x, [0.0, 1.0]).with_boundaries({"contact": names["contact"]})
    lower = MeshHex.init_tensor(x, x, [-1.0, 0.0]).with_boundaries(names)
    directions, free = SIDES[side]
    bodies = {"punch": fo.Body(upper), "block": fo.Body(lower)}
    model = fo.ContactModel(bodies, [fo.Support("block", side, directions)], {"W": [fo.BodyForce("punch", z=-1.0)]})
    with pytest.raises(fo.ModelError, match=f"can still {free}; add"):
        model.condense()


def given(cells=(3, 3), graded=1.0):
    """Arguments of `condense` for a free block on one that is held below, by scikit-fem, turned in space; body 2 goes on beside body 1."""
    x, y = (np.linspace(0, 1, n + 1) ** graded for n in cells)
    meshes = MeshHex.init_tensor(x, y, [0.0, 0.4, 1.0]), MeshHex.init_tensor(np.r_[-0.5, x, 1.5], y, [-1.0, -0.5, 0.0])
    bases = [Basis(mesh, ElementVector(ElementHex1())) for mesh in meshes]
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    K = block_diag([linear_elasticity(1.0, 1.0).assemble(basis) for basis in bases]).tocsr()  # isotropic: turned points, the same matrix turned
    unknowns = np.concatenate([bases[0].nodal_dofs.T, bases[0].N + bases[1].nodal_dofs.T])
    points = np.concatenate([mesh.p for mesh in meshes], axis=1).T
    spin = np.zeros(K.shape)
    for rows in unknowns:
        spin[np.ix_(rows, rows)] = turn
    one = np.flatnonzero((points[:, 2] == 0) & (np.arange(len(points)) < meshes[0].p.shape[1]))
    two = [len(meshes[0].p.T) + np.linalg.norm(meshes[1].p.T - points[node], axis=1).argmin() for node in one]
    held = unknowns[points[:, 2] == -1].ravel()
    rest = {"K": csr_matrix(spin @ K.toarray() @ spin.T), "loads": {"P": np.ones(K.shape[0])}, "unknowns": unknowns, "held": held}
    return {**rest, "pairs": np.column_stack([one, two]), "normals": np.tile(turn @ [0, 0, 1], (len(one), 1)), "points": points @ turn.T}


@pytest.mark.parametrize(("cells", "graded"), [((3, 3), 1.0), ((4, 2), 2.5), ((1, 1), 1.0)])
def test_a_pair_that_is_wrong_is_named_whichever_it_is(cells, graded):
    good = given(cells, graded)
    pairs, normals, n = good["pairs"], good["normals"], len(good["pairs"])
    assert fo.condense(**good).nodes == n
    for i in range(n):
        others = np.arange(n) != i
        flip = np.where(others, 1.0, -1.0)[:, None]
        turned = np.where(others[:, None], pairs, pairs[:, ::-1])
        one, two = sorted(pairs[i].tolist())
        for change, message in (
            ({"normals": flip * normals}, f"normals: that of pair {i} at"),
            ({"pairs": turned}, f"normals: that of pair {i} at"),
            ({"pairs": pairs[others], "normals": normals[others]}, f"pairs: nodes {one} and {two} lie on each other at"),
        ):
            with pytest.raises(fo.ModelError, match=message):
                fo.condense(**good | change)
    again = np.random.default_rng(1).permutation(n)
    assert fo.condense(**good | {"pairs": pairs[again], "normals": normals[again]}).nodes == n


def test_a_normal_in_the_face_is_named():
    good = given()
    middle = int(np.linalg.norm(good["points"][good["pairs"][:, 0]] - good["points"][good["pairs"][:, 0]].mean(axis=0), axis=1).argmin())
    normals = good["normals"].copy()
    normals[middle] = np.cross(normals[middle], [1.0, 2.0, 3.0])
    with pytest.raises(fo.ModelError, match=f"normals: that of pair {middle} at .* does not point from body 2 into body 1"):
        fo.condense(**good | {"normals": normals})


def test_a_pair_of_two_nodes_that_are_held_may_be_left_out():
    """On a plane of symmetry both bodies are held across it."""
    good = given()
    side = np.flatnonzero(np.isclose(good["points"] @ np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0][:, 1], 0.0))
    pairs, held = good["pairs"], np.union1d(good["held"], good["unknowns"][side, 0])
    left = ~np.isin(pairs[:, 0], side)
    assert 0 < left.sum() < len(left)
    assert fo.condense(**good | {"held": held, "pairs": pairs[left], "normals": good["normals"][left]}).nodes == left.sum()
    with pytest.raises(fo.ModelError, match="follows from those of other pairs or from supports"):
        fo.condense(**good | {"held": held})
    one_side = np.union1d(good["held"], good["unknowns"][pairs[~left, 1], 0])
    assert fo.condense(**good | {"held": one_side}).nodes == len(left)
    with pytest.raises(fo.ModelError, match="lie on each other at"):
        fo.condense(**good | {"held": one_side, "pairs": pairs[left], "normals": good["normals"][left]})
