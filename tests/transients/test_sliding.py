"""Gross sliding in space is named before a transient begins.

The forces of equilibrium are found by a cone program.
"""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.contact.components import frames_of
from frictopt.transients.statics import check_sliding, rigid_motions
from helpers.cases import few
from helpers.components import joined

MOTIONS = [[0, 1, 2, 3, 4, 5], [0, 1, 2], [0, 2], [2], [0, 1, 5], [0, 1, 2, 5]]


def contact(rng, motions):
    """A random contact with rough faces, and loads that press and shear it.

    Body 1 has some of the six rigid motions.
    """
    n = int(rng.integers(3, 8))
    points = rng.uniform(-1, 1, (n, 3)) * [1, 1, 0.2]
    normals = rng.uniform(-0.4, 0.4, (n, 3)) + [0, 0, 1]
    frames = frames_of(normals)
    shifts = [np.tile(axis, (n, 1)) for axis in np.eye(3)]
    turns = [np.cross(axis, points) for axis in np.eye(3)]
    rigid = np.column_stack(
        [np.einsum("nak,nk->an", frames, motion).ravel() for motion in [*shifts, *turns]]
    )[:, motions]
    root = rng.normal(size=(3 * n, 3 * n))
    off = np.eye(3 * n) - rigid @ np.linalg.pinv(rigid)
    press = np.einsum("nak,k->an", frames, [0, 0, 1.0]).ravel()
    bonded = {"P": press, "Q": rng.normal(size=3 * n) + press * rng.uniform(-1, 1)}
    return fo.ContactSystem(
        off @ (root @ root.T + np.eye(3 * n)) @ off, points, bonded, frames=frames
    ), rigid


def balance(system, rigid, friction, load):
    """Status of the cone program for the smallest contact forces in balance with a load.

    The balance is taken in the rigid motions.
    """
    q, p = cp.Variable((system.nodes, 2)), cp.Variable(system.nodes, nonneg=True)
    forces = cp.hstack([q[:, 0], q[:, 1], p])
    problem = cp.Problem(
        cp.Minimize(cp.norm(forces)),
        [cp.norm(q, axis=1) <= cp.multiply(friction, p), rigid.T @ forces == rigid.T @ load],
    )
    problem.solve(solver=cp.CLARABEL)
    return problem.status


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
@pytest.mark.parametrize("seed", few(range(30)))
def test_a_load_is_named_where_no_forces_balance_it_and_only_there(seed):
    rng = np.random.default_rng(seed)
    system, rigid = contact(rng, MOTIONS[seed % len(MOTIONS)])
    found = rigid_motions(system.S, system.own_stiffness)
    assert np.abs(found - rigid @ (np.linalg.pinv(rigid) @ found)).max() < 1e-9
    assert np.abs(found.T @ found - np.eye(rigid.shape[1])).max() < 1e-9
    friction = rng.uniform(0.1, 0.6, system.nodes)
    for shear in rng.uniform(0, 1, 2):
        load = joined(*system.reaction({"P": 1.0, "Q": shear}))
        if balance(system, rigid, 1.0005 * friction, load) == "infeasible":
            with pytest.raises(fo.NoContinuation, match="the load"):
                check_sliding(system, friction, {"the load": load})
        elif balance(system, rigid, friction, load) == "optimal":
            check_sliding(system, friction, {"the load": load})


def test_a_load_that_friction_holds_is_asked_anew_with_less_friction():
    """A proof of balance is kept only for its friction and its load."""
    loads = {"P": ([0, 0, 0], [0, 0, 1.0]), "Q": ([-1.0, 0, 0], [0, 0, 0])}
    block = fo.ContactSystem(
        np.zeros((3, 3)),
        np.zeros((1, 3)),
        {case: sum(map(np.array, parts)) for case, parts in loads.items()},
    )
    held = {"the load": joined(*block.reaction({"P": 1.0, "Q": 0.4}))}
    check_sliding(block, np.array([0.5]), held)
    check_sliding(block, np.array([0.5]), held)
    with pytest.raises(fo.NoContinuation, match="slides"):
        check_sliding(block, np.array([0.3]), held)
    with pytest.raises(fo.NoContinuation, match="slides"):
        check_sliding(
            block, np.array([0.5]), {"the load": joined(*block.reaction({"P": 1.0, "Q": 0.6}))}
        )
