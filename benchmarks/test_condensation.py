"""Condensation at the paper's size against scipy's sparse factorisation of the same matrix."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from frictopt.fem.condense import schur_complement
from frictopt.fem.elasticity import body_stiffness
from frictopt.fem.glue import GluedBodies
from frictopt.fem.ordering import nested_dissection


@pytest.fixture(scope="module")
def glued(scene):
    """Stiffness of the glued scene, loads, free unknowns in no particular order, and number of kept ones."""
    model = scene.model()
    bodies = GluedBodies(model.punch, model.block, model.interface_nodes("punch"), model.interface_nodes("block"))
    K = sum(motion.T @ body_stiffness(bodies._bodies[name].mesh, bodies._bodies[name].material) @ motion for name, motion in bodies._motion.items())
    held = np.concatenate([bodies.unknowns(s.body, model.support_nodes(s), s.directions) for s in model.supports])
    forces = np.column_stack([model._forces(bodies, case) for case in model.loads])
    return bodies, K.tocsr(), forces, held


def condense(glued):
    bodies, K, forces, held = glued
    nodes = nested_dissection(K[: bodies._glued, : bodies._glued], bodies._points)
    order = np.r_[np.column_stack([nodes, bodies._glued + nodes]).ravel(), 2 * bodies._glued + np.arange(bodies._kept)]
    return schur_complement(K, forces, order[~np.isin(order, held)], bodies._kept)


def interior(glued):
    bodies, K, _, held = glued
    free = np.setdiff1d(np.arange(2 * bodies._glued), held)
    return K[free][:, free].tocsc(), free


@pytest.mark.parametrize("ordering", ["MMD_AT_PLUS_A", "COLAMD"])
def test_condensation_against_one_factorisation(compare, glued, ordering):
    matrix, _ = interior(glued)
    options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}} if ordering != "COLAMD" else {}
    assert compare(lambda: condense(glued), lambda: splu(matrix, permc_spec=ordering, **options), rounds=5) < 1.5


def test_whole_way_against_one_factorisation(compare, scene, glued):
    matrix, _ = interior(glued)
    options = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    assert compare(scene.condense, lambda: splu(matrix, **options), rounds=5) < 4.0


def test_condensation_against_one_right_hand_side_for_each_unknown(compare, glued):
    bodies, K, _, _ = glued
    matrix, free = interior(glued)
    kept = 2 * bodies._glued + np.arange(bodies._kept)
    K_ir, K_rr = K[free][:, kept], K[kept][:, kept].toarray()

    def rival():
        return K_rr - K_ir.T @ splu(matrix).solve(K_ir.toarray())

    S, _ = condense(glued)
    assert np.abs(rival() - S).max() < 1e-9 * np.abs(S).max()
    assert compare(lambda: condense(glued), rival, rounds=3) < 0.5
