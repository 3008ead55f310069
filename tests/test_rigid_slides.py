"""Slips that nothing resists: as many as there are, whatever the stiffness of the others."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits.question import pose, rigid_slides


@pytest.mark.parametrize("free", [0, 1, 7, 8, 9, 20, 29])
def test_planted_slides_are_found_with_the_compliance_of_the_others(free):
    rng, nodes = np.random.default_rng(free), 30
    turn = np.linalg.qr(rng.normal(size=(nodes, nodes)))[0]
    stiffness = np.where(np.arange(nodes) < free, 0.0, 10.0 ** rng.uniform(-4, 0, nodes))
    A = (turn * stiffness) @ turn.T
    system = fo.ContactSystem.from_blocks((A + A.T) / 2, np.zeros_like(A), np.eye(nodes), np.arange(nodes), {"P": (np.zeros(nodes), np.ones(nodes))})
    rigid, compliance = rigid_slides(pose(system, fo.LoadCycle({"P": 1.0}, [{"P": -0.1}, {"P": 0.1}]), 0.5))
    assert rigid.T @ rigid == pytest.approx(np.eye(free), abs=1e-13)
    assert rigid @ rigid.T == pytest.approx(turn[:, :free] @ turn[:, :free].T, abs=1e-10)
    forces = turn[:, free:]
    assert A @ compliance @ forces == pytest.approx(forces, abs=1e-9)
