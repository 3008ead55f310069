"""Condensation in three dimensions: two blocks of hexahedra against the equations with multipliers, by dense algebra."""

import re

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_matrix
from skfem import Basis, ElementHex1, ElementVector, MeshHex
from skfem.models.elasticity import linear_elasticity

import frictopt as fo
from frictopt.contact.parts import joined


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


def test_a_free_block_on_a_held_one():
    good = given()
    rng, unknowns, (one, two), n = np.random.default_rng(5), good["unknowns"], good["pairs"].T, len(good["pairs"])
    F = rng.normal(size=(good["K"].shape[0], 2))
    system = fo.condense(**good | {"loads": {"a": F[:, 0], "b": F[:, 1]}})
    free = np.setdiff1d(np.arange(len(F)), good["held"])
    G = np.zeros((3 * n, len(F)))
    for i, frame in enumerate(system.frames):
        G[i::n, unknowns[one[i]]], G[i::n, unknowns[two[i]]] = frame, -frame
    G, K = G[:, free], good["K"].toarray()[np.ix_(free, free)]
    whole = np.block([[K, -G.T], [G, np.zeros((3 * n, 3 * n))]])
    r = np.linalg.solve(whole, np.block([[np.zeros((len(K), 3 * n)), F[free]], [np.eye(3 * n), np.zeros((3 * n, 2))]]))[len(K) :]
    assert np.allclose(system.S, r[:, :-2], atol=1e-11)
    assert np.allclose(np.column_stack([joined(*system.bonded[name]) for name in "ab"]), r[:, -2:], atol=1e-10)
    assert (np.linalg.eigvalsh(system.S) < 1e-12).sum() == 6


@pytest.mark.parametrize(("held", "free"), [(0, "move along x and y and z and turn about x and y and z"), (1, "turn about x and y and z"), (2, "")])
def test_rigid_motions_in_space(held, free):
    """Two nodes that are held leave the turn about the line through them."""
    good = given()
    nodes = np.flatnonzero(np.isin(good["unknowns"][:, 0], good["held"]))[:held]
    if not free:
        one, two = good["points"][nodes]
        axis = (two - one) / np.linalg.norm(two - one)
        axis *= np.sign(axis[np.abs(axis).argmax()])
        free = f"turn about ({', '.join(f'{value:g}' for value in axis.round(6))})"
    with pytest.raises(fo.ModelError, match=re.escape(f"can still {free}; add")):
        fo.condense(**good | {"held": good["unknowns"][nodes].ravel()})


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
    """On a plane of symmetry both bodies are held across it: the pair cannot slip there, but carries pressure."""
    good = given()
    side = np.flatnonzero(np.isclose(good["points"] @ np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0][:, 1], 0.0))
    pairs, held = good["pairs"], np.union1d(good["held"], good["unknowns"][side, 0])
    left = ~np.isin(pairs[:, 0], side)
    assert 0 < left.sum() < len(left)
    assert fo.condense(**good | {"held": held, "pairs": pairs[left], "normals": good["normals"][left]}).nodes == left.sum()
    assert fo.condense(**good | {"held": held}).nodes == len(left)
    still = np.union1d(held, good["unknowns"][side])
    with pytest.raises(fo.ModelError, match="follows from those of other pairs or from supports"):
        fo.condense(**good | {"held": still})
    one_side = np.union1d(good["held"], good["unknowns"][pairs[~left, 1], 0])
    assert fo.condense(**good | {"held": one_side}).nodes == len(left)
    with pytest.raises(fo.ModelError, match="lie on each other at"):
        fo.condense(**good | {"held": one_side, "pairs": pairs[left], "normals": good["normals"][left]})
