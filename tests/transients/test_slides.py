"""Bodies that may slide, closed or with nodes that the mean load opens.

The tests check the number of slides, their effect on gaps, and the proofs of limits.
"""

import numpy as np
import pytest
from scipy.optimize import linprog

import frictopt as fo
from frictopt.base import unresisted
from frictopt.limits import limit_of_set, pose, with_open
from frictopt.solve import answer
from helpers.cases import few
from helpers.liars import persuasive, unpolished, without_plain_cvxpy
from helpers.oracle import Oracle


def test_slides_that_only_open_gaps_are_as_small_as_they_can_be(paper_cycle):
    """The interior point goes as far as a slide opens gaps. All solvers prove one limit, with slips
    of the size of the slips by the loads."""
    contact = fo.scenes.SquarePunch(elements=5).condense()
    contact = contact.with_gap(4.0 * (contact.points[:, :2] ** 4).sum(axis=1))
    one, other = (
        fo.shakedown_limit(contact, paper_cycle, 0.6, solver=solver)
        for solver in ("INTERIOR_POINT", "CLARABEL")
    )
    assert one.open.any() and one.open.tolist() == other.open.tolist()
    assert one.load_factor == pytest.approx(other.load_factor, rel=1e-8)
    assert max(one.largest_slip, other.largest_slip) < 5.0


@pytest.mark.parametrize(("seed", "tilt"), few([(1, 0.0), (1, 0.5), (4, 0.0), (7, 0.0), (2, 0.5)]))
def test_one_closed_node_slides_as_far_as_gaps_ask_for(seed, tilt):
    """Along x a body moves freely. Level faces stay as far apart as before, but for rounding;
    tilted faces open by no more than they need."""
    rng = np.random.default_rng(seed)
    face = tilt * np.array([0.0, 1.0, 2.0, 1.5])
    free = np.r_[np.cos(face), np.zeros(4), -np.sin(face)] / 2
    aside = np.eye(12) - np.outer(free, free)
    G = rng.normal(size=(12, 12))
    loads = {
        "P": np.r_[np.zeros(8), 1.0, [-0.2] * 3],
        "a": 0.3 * rng.normal(size=12),
        "b": 0.3 * rng.normal(size=12),
    }
    gap = 5.0 * (face > 0)
    contact = fo.ContactSystem(
        aside @ (G @ G.T / 12 + np.eye(12)) @ aside,
        np.c_[np.arange(4.0), np.zeros((4, 2))],
        loads,
        gap=gap,
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"a": 1.0}, {"b": 1.0}, {"a": -1.0, "b": -1.0}])
    one, other = (
        fo.shakedown_limit(contact, cycle, 0.5, solver=solver)
        for solver in ("INTERIOR_POINT", "CLARABEL")
    )
    assert one.open.sum() == 3 and one.load_factor == pytest.approx(other.load_factor, rel=1e-8)
    assert one.load_factor == pytest.approx(
        Oracle(contact, cycle, 0.5, one.open).largest(), rel=1e-6
    )
    assert one.largest_slip == pytest.approx(other.largest_slip, rel=1e-6)
    assert one.largest_slip < 1.0


def test_a_mechanism_proves_nothing_where_a_slide_of_the_body_does_work_on_it(monkeypatch):
    """Slip of node 0 lifts node 1, and nothing resists it. The cycle presses node 1 shut at load
    factor 1, but this is no limit."""
    k = np.eye(3)
    bonded = {"P": ([0.0] * 3, [1.0, -1.0, 1.0]), "Q": ([0.0] * 3, [0.0, 1.0, 0.0])}
    contact = fo.ContactSystem.from_blocks(
        k, [[0, 0, 0], [-1, 0, 0], [0, 0, 0]], k, [0.0, 1.0, 2.0], bonded
    )
    question = with_open(
        pose(contact, fo.LoadCycle({"P": 1.0}, [{"Q": 0.0}, {"Q": 1.0}]), 5.0),
        np.array([False, True, False]),
    )
    assert not fo.shakedown_limit(contact, question.cycle, 0.5).load_factor <= 1.0
    assert not limit_of_set(question).load_factor <= 1.0 + 1e-3
    lies = []

    def less(program, name, above):
        """A load factor that is no limit, and the multipliers that come closest to a proof."""
        matrix, n, zero = program.matrix, len(program.cost), program.zero
        x = linprog(
            np.zeros(n),
            matrix[zero:],
            program.right[zero:],
            np.vstack([program.cost, matrix[:zero]]),
            np.r_[-share / question.load_unit, program.right[:zero]],
            bounds=[(None, None)] * n,
        ).x
        lies.append(x)
        return "optimal", x, persuasive(program, x)

    with monkeypatch.context() as patch:
        patch.setattr(answer, "run", less)
        unpolished(patch)
        without_plain_cvxpy(patch)
        for share in (0.5, 1.0):  # noqa: B007  the solver returns it
            with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
                limit_of_set(question)
    assert len(lies) == 6
    # The bound of 2 lets node 0 lift node 1 by 2 more.
    within = pose(contact, question.cycle, 5.0, slip_bound=2.0)
    limit = limit_of_set(with_open(within, np.array([False, True, False])))
    assert limit.load_factor == pytest.approx(3.0)
    assert limit.slip[0] == pytest.approx(2.0)
    assert limit.residual <= 1e-9


@pytest.mark.parametrize("free", [0, 1, 7, 8, 9, 20, 29])
def test_planted_slides_are_found_with_the_compliance_of_the_others(free):
    rng, nodes = np.random.default_rng(free), 30
    turn = np.linalg.qr(rng.normal(size=(nodes, nodes)))[0]
    stiffness = np.where(np.arange(nodes) < free, 0.0, 10.0 ** rng.uniform(-4, 0, nodes))
    A = (turn * stiffness) @ turn.T
    A = (A + A.T) / 2
    rigid, compliance = unresisted(A, np.diag(A))
    assert rigid.T @ rigid == pytest.approx(np.eye(free), abs=1e-13)
    assert rigid @ rigid.T == pytest.approx(turn[:, :free] @ turn[:, :free].T, abs=1e-10)
    forces = turn[:, free:]
    assert A @ compliance @ forces == pytest.approx(forces, abs=1e-9)
    # Forces that do work on the slides move nothing else.
    assert np.abs(compliance @ rigid).max(initial=0.0) <= 1e-10 * np.abs(compliance).max()


def test_of_two_soft_motions_that_press_only_one_may_be_resisted():
    """Each of two bodies presses as it slides, by one spring: together they may slide freely."""
    relative = np.kron(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]])
    spring = 1e-7 * np.array([1.0, 1.0, 0.5, 0.5])
    pressing = np.outer([1.0, -1.0, 0.5, -0.5], spring)
    rigid, compliance = unresisted(relative + np.outer(spring, spring), np.ones(4), pressing)
    assert abs(rigid[:, 0]) == pytest.approx(np.sqrt([0.1, 0.1, 0.4, 0.4]), rel=0.02)
    # Its stiffness is only some hundred times the rounding of the others.
    assert spring @ compliance @ spring == pytest.approx(1.0, rel=0.02)
