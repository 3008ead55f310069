"""The checks between a solver and an answer.

Solvers that return one wrong quantity are detected, and bounds hold where their programs are not
settled.
"""

from contextlib import suppress
from importlib import import_module

import numpy as np
import pytest
from scipy.optimize import linprog

import frictopt as fo
from frictopt.limits import pose, shakedown
from frictopt.limits.guarantee.critical_search import load_factor_bounds
from frictopt.solve import solvers as policy
from helpers.cases import few
from helpers.guaranteed import least_by_node, random_cycle
from helpers.liars import is_excess, lying, lying_by_cvxpy, misread, persuasive, unpolished
from helpers.spatial import CORNERS, random_contact, single
from helpers.systems import CYCLE, FIRST_PAIR, random_system, system


def is_critical(program):
    """Whether a program asks for the critical load factor of a node.

    Only such a program has equations; they belong to the node.
    """
    return program.zero > 0


def largest(program):
    """The x of a program of a least load factor at its largest load factor, by scipy."""
    matrix = program.matrix
    zero = program.zero
    n = len(program.cost)
    free = {"bounds": [(None, None)] * n}
    return linprog(
        -program.cost,
        matrix[zero:],
        program.right[zero:],
        matrix[:zero],
        program.right[:zero],
        **free,
    ).x


@pytest.mark.parametrize("opened", [False, True], ids=["closed", "one open"])
@pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
def test_plain_cvxpy_answers_if_no_answer_of_the_arrays_passes(tangents, opened, monkeypatch):
    """Plain cvxpy has the limit, its slip and its proof, and a wrong answer of it is refused.

    Friction is low at one node, so that the pressure has a row of its own.
    """
    rng = np.random.default_rng(5)
    if tangents == 1:
        contact, cycle = random_system(rng, 4), CYCLE
    else:
        contact, cycle = random_contact(rng, 4), fo.LoadCycle({"mean": 1.0}, CORNERS)
    open_nodes = np.zeros(4, dtype=bool)
    if opened:
        open_nodes[3] = True
        contact = contact.with_gap(8.0 * open_nodes)
    friction = [0.3, 0.005, 0.4, 0.2]
    right = fo.shakedown_limit(contact, cycle, friction, open_nodes=open_nodes)
    lying(monkeypatch, lambda program, name, x, y: "stopped", plain=True)
    limit = fo.shakedown_limit(contact, cycle, friction, open_nodes=open_nodes)
    assert limit.record.solver.startswith("cvxpy: CLARABEL")
    assert limit.load_factor == pytest.approx(right.load_factor, rel=1e-9)
    assert limit.bound == pytest.approx(right.load_factor, rel=1e-9)
    assert limit._question.violation(limit.load_factor, limit.slip) <= 1e-9
    assert limit.friction_rate == pytest.approx(right.friction_rate, rel=1e-6, abs=1e-9)

    def longer(problem, name):
        problem.var_dict["slip"].save_value(1.01 * problem.var_dict["slip"].value)

    lying_by_cvxpy(monkeypatch, longer)
    unpolished(monkeypatch)
    with pytest.raises(fo.SolverError, match="stopped"):
        fo.shakedown_limit(contact, cycle, friction, open_nodes=open_nodes)


def test_multipliers_of_plain_cvxpy_prove_its_limit_before_any_polish(monkeypatch):
    contact = random_system(np.random.default_rng(3), 4)
    lying(monkeypatch, lambda *_: "stopped", plain=True)
    unpolished(monkeypatch)
    limit = fo.shakedown_limit(contact, CYCLE, 0.4, open_nodes=[False] * 4)
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8)


def test_a_witness_off_its_bounds_is_not_accepted(monkeypatch):
    """The slip is safe at the right load factor, with the right multipliers, but the node is on
    neither bound."""
    contact, lies = system(*FIRST_PAIR), []
    right = fo.guaranteed_limit(contact, CYCLE, 0.6)
    inside = fo.safe_slip(contact, CYCLE, 0.6, right.load_factor).slip
    assert (
        pose(contact, CYCLE, 0.6).violation(right.load_factor, inside)
        <= 1e-9
        < 1e-3
        < np.abs(inside - right.slip).max()
    )

    # The unknowns are the load factor and the residual shear forces, which begin at the mean load.
    question = pose(contact, CYCLE, 0.6)
    shear = (contact.A @ inside + question.r0[0, 0]) / question.shear_unit

    def lie(program, x, y):
        if is_critical(program) and x[0] * question.load_unit <= right.load_factor * (1 + 1e-9):
            x[1:] = shear
            lies.append(x)

    with monkeypatch.context() as patch:
        misread(patch, lie)
        with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
            fo.guaranteed_limit(contact, CYCLE, 0.6)
    assert lies
    lying(monkeypatch, lambda program, name, x, y: (x + 1e-3, y) if is_critical(program) else None)
    limit = fo.guaranteed_limit(contact, CYCLE, 0.6)
    q, p = limit.reactions
    (first, last), node = limit.corners, limit.node
    assert abs(q[first, node] + 0.6 * p[first, node]) < 1e-8
    assert abs(q[last, node] - 0.6 * p[last, node]) < 1e-8
    assert "refined" in [attempt.outcome for attempt in limit.record.attempts]


def test_a_witness_at_more_than_the_least_load_factor_is_not_accepted(monkeypatch):
    """The slip is safe and on both bounds, with multipliers of the least load factor."""
    contact = system(*FIRST_PAIR)
    right = fo.guaranteed_limit(contact, CYCLE, 0.6)
    lying(
        monkeypatch,
        lambda program, name, x, y: (largest(program), y) if is_critical(program) else None,
    )
    try:
        limit = fo.guaranteed_limit(contact, CYCLE, 0.6)
    except fo.SolverError as error:
        # The vertex of these rows is no better.
        assert "refined, residual" in str(error)
    else:
        assert limit.load_factor == pytest.approx(right.load_factor, rel=1e-9)
    unpolished(monkeypatch)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.guaranteed_limit(contact, CYCLE, 0.6)


def test_multipliers_that_balance_nothing_prove_no_least_load_factor(monkeypatch):
    """Multipliers prove no least load factor if residual slip can help against them.

    The slip is safe and on both bounds at the largest load factor, and the multipliers have the
    right work.
    """
    contact, gaps_and_values = system(*FIRST_PAIR), []
    right = fo.guaranteed_limit(contact, CYCLE, 0.6).load_factor

    def at_most(program, name, x, y):
        if not is_critical(program):
            return None
        x = largest(program)
        y = persuasive(program, x)
        gaps_and_values.append((program.cost @ x + program.right @ y, np.abs(program.cost @ x)))
        return x, y

    lying(monkeypatch, at_most)
    unpolished(monkeypatch)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.guaranteed_limit(contact, CYCLE, 0.6)
    assert len(gaps_and_values) >= len(policy.LP_SOLVERS)
    assert right > 0
    assert all(abs(gap) < 1e-6 * value for gap, value in gaps_and_values)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 1 - 1e-7])
def test_multipliers_that_stress_the_contact_prove_nothing(share, monkeypatch):
    """Multipliers prove no limit if residual slip can help against them.

    The solver returns a share of the limit, which is safe, with slips whose work balances there.
    """
    contact = random_system(np.random.default_rng(0), 3)
    relative_gaps = []
    right = fo.shakedown_limit(contact, CYCLE, 0.4, simplify=False)

    def less(program, name, x, y):
        y = persuasive(program, share * x)
        relative_gaps.append(
            abs(share * program.cost @ x + program.right @ y) / abs(share * program.cost @ x)
        )
        assert (y >= 0).all()
        return share * x, y

    lying(monkeypatch, less)
    unpolished(monkeypatch)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.shakedown_limit(contact, CYCLE, 0.4, simplify=False)
    assert len(relative_gaps) >= len(policy.LP_SOLVERS)
    assert max(relative_gaps) < 1e-6
    assert right.load_factor > 0


@pytest.mark.parametrize("seed", [88, 157, 186, 278])
def test_a_mechanism_that_does_not_settle_bounds_nothing(seed):
    """A mechanism that does not settle gives no bound of the critical load factors.

    Friction is so large that the bounds of some nodes would be wrong.
    """
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(2, 5))
    contact = random_system(rng, nodes, loads=("mean", "a", "b"), coupling=1.0)
    cycle = random_cycle(rng, 2)
    friction = np.full(nodes, rng.uniform(0.3, 3))
    question = pose(contact, cycle, friction)
    bounds = load_factor_bounds(question)
    least = least_by_node(contact, cycle, friction)
    assert (bounds <= least * (1 + 1e-8) + 1e-12).all() and (bounds == 0).any()


@pytest.mark.parametrize("share", [0.1, 0.25, 0.9])
def test_a_mechanism_that_stresses_the_contact_does_not_prove_a_small_limit_by_a_small_slip(
    share, monkeypatch
):
    """Node 0 slips and so presses itself: it carries any load, with a slip in proportion. Only node
    1 limits the load, at 1."""
    wedge, shear, friction = 1e10, 1e12, 2.0
    bonded = {"P": ([0.0, 0.0], [1.0, 1e5]), "X": ([shear, 2e5], [0.0, 0.0])}
    contact = fo.ContactSystem.from_blocks(
        np.eye(2), np.diag([wedge, 0.0]), np.diag([4 * wedge**2, 1.0]), [0.0, 1.0], bonded
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    assert fo.shakedown_limit(contact, cycle, friction).load_factor == pytest.approx(1.0, rel=1e-9)

    lies = []

    def less(program, name, x, y):
        lies.append(share * x)
        return share * x, persuasive(program, share * x)

    lying(monkeypatch, less)
    unpolished(monkeypatch)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.shakedown_limit(contact, cycle, friction)
    assert lies


def test_a_safe_slip_exists_at_the_limit_itself():
    """It exists even if rounding leaves its margin just below zero."""
    margins = []
    for seed in few(range(10), 5):
        contact = random_system(np.random.default_rng(seed), 8)
        limit = fo.shakedown_limit(contact, CYCLE, 0.4, simplify=False).load_factor
        for solver in ("HIGHS", "CLARABEL"):
            safe = fo.safe_slip(contact, CYCLE, 0.4, limit, simplify=False, solver=solver)
            assert safe.exists
            margins.append(safe.margin)
    assert min(margins) < 0


@pytest.mark.parametrize("large", [1e6, 1e12, 1e13, 1e15])
def test_a_node_whose_load_is_small_beside_the_others_still_limits(large):
    """Node 2 slips at 0.25. The other nodes are pressed by a load that is larger by decades, and an
    answer without node 2 would be inf."""
    bonded = {
        "P": (np.zeros(3), np.ones(3)),
        "X": ([0.0, 0.0, 2.0], np.zeros(3)),
        "Y": (np.zeros(3), [large, large, 0.0]),
    }
    coupling = np.array([[0.0, 0.5, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    contact = fo.ContactSystem.from_blocks(
        2 * np.eye(3), coupling, 2 * np.eye(3), [0.0, 1.0, 2.0], bonded
    )
    try:
        limit = fo.shakedown_limit(
            contact, fo.LoadCycle({"P": 1.0}, [{"X": 1.0, "Y": 1.0}, {"X": -1.0}]), 0.5
        )
    except fo.SolverError:
        assert large > 1e12  # no solver sees it, and that is said
    else:
        assert limit.load_factor == pytest.approx(0.25, rel=1e-9)


@pytest.mark.parametrize("wedge", [1.0, 1e3, 1e6, 1e8, 1e10])
@pytest.mark.parametrize("count", [1, 2])
def test_a_soft_slip_that_presses_a_stiff_node_is_no_free_one(wedge, count):
    """Node 0 locks by a slip whose stiffness is small beside the stiffness along its normal. Node 1
    limits the load, at 1, in the plane and in space."""
    stiff, shear = 4 * wedge**2, 1e6
    if count == 1:
        bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "X": ([shear, 2.0], [0.0, 0.0])}
        contact = fo.ContactSystem.from_blocks(
            np.eye(2), np.diag([wedge, 0.0]), np.diag([stiff, 1.0]), [0.0, 1.0], bonded
        )
    else:
        S = np.diag([1.0, 1.0, 1.0, 1.0, stiff, 1.0])
        S[0, 4] = S[4, 0] = wedge
        bonded = {"P": [0.0, 0.0, 0.0, 0.0, 1.0, 1.0], "X": [shear, 2.0, 0.0, 0.0, 0.0, 0.0]}
        contact = fo.ContactSystem(
            S,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
            {name: np.array(value) for name, value in bonded.items()},
        )
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    assert fo.shakedown_limit(contact, cycle, 2.0).load_factor == pytest.approx(1.0, rel=1e-8)


@pytest.mark.parametrize(
    ("proof", "cycle", "kind"),
    [
        ("contradiction", fo.LoadCycle({"P": -1.0}, [{"X": 1.0}]), fo.LimitKind.NO_SAFE_SLIP),
        ("growth", fo.LoadCycle({"P": 1.0}, [{"P": 1.0}]), fo.LimitKind.UNBOUNDED),
    ],
)
def test_that_there_is_no_limit_has_the_error_of_its_proof(proof, cycle, kind, monkeypatch):
    honest = getattr(shakedown, proof)
    for error in (1e-10, 1e-3):
        monkeypatch.setattr(
            shakedown, proof, lambda *asked, error=error: (honest(*asked)[0], error)
        )
        try:
            limit = fo.shakedown_limit(single(), cycle, 0.5, open_nodes=[False])
        except fo.SolverError:
            assert error == 1e-3
        else:
            assert limit.kind is kind and limit.residual == error == 1e-10


@pytest.mark.parametrize("ask", [fo.shakedown_limit, fo.guaranteed_limit])
def test_the_right_load_factor_at_a_slip_that_is_not_safe_is_no_answer(ask, monkeypatch):
    """One node is uncoupled from the others and far from its bounds. Its returned slip is beyond
    the bounds; values and multipliers are right."""
    A, B, *loads = FIRST_PAIR
    alone = np.eye(3)
    alone[:2, :2] = A
    pressed = [
        np.append(np.broadcast_to(part, 2), at_alone)
        for part, at_alone in zip(loads, (0.0, 5.0, 0.0, 0.0), strict=True)
    ]
    contact = system(alone, np.pad(B, ((0, 1), (0, 1))), *pressed)
    right = ask(contact, CYCLE, 0.6)
    assert right.load_factor == pytest.approx(
        ask(system(*FIRST_PAIR), CYCLE, 0.6).load_factor, rel=1e-8
    )
    assert right.residual < 1e-9

    def lie(program, x, y):
        if is_critical(program) == (ask is fo.guaranteed_limit):
            x[1 + 2] += 10.0

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        ask(contact, CYCLE, 0.6)


@pytest.mark.parametrize("sense", [-1, 1])
def test_a_solver_that_finds_nothing_safe_is_believed_for_its_multipliers_alone(sense, monkeypatch):
    """A shear of 3 exceeds the friction bound of 0.5, and slip in one sense does work on it. But a
    residual slip takes the shear off the node, because stiffness resists."""
    contact = single()
    cycle = fo.LoadCycle({"P": 1.0, "X": 3.0}, [{"X": 1.0}, {"X": -1.0}])
    assert fo.shakedown_limit(contact, cycle, 0.5).load_factor == pytest.approx(0.5)

    def slips_one_way(program, name, x, y):
        if not is_excess(program):
            return "infeasible"
        y = np.zeros(len(y))
        for cone in program.cones:
            if cone.shape[1] > 1:
                y[cone[:, 0]], y[cone[:, 1]] = 1.0, sense
        return np.eye(1, len(x), len(x) - 1)[0], y

    for lie in (
        slips_one_way,
        lambda program, name, x, y: None if is_excess(program) else "infeasible",
    ):
        lying(monkeypatch, lie)
        with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
            fo.shakedown_limit(contact, cycle, 0.5)


def of_moved_slip(monkeypatch, contact, friction, by, *, number=-1, **options):
    """Residuals of a judged safe slip as found, and with its first node moved by `by`.

    The slip is the last one judged, or the one with the index `number`.
    """
    residuals, module = [], import_module("frictopt.limits.safe_slip")
    judged, read = module.checked_slip, module.read_solution

    def moved_slip(*given):
        placed, slip, motion = read(*given)
        return placed, slip + [by, 0.0], motion

    def of_both(*given):
        claim = judged(*given)
        with monkeypatch.context() as patch:
            patch.setattr(module, "read_solution", moved_slip)
            moved = judged(*given)
        residuals.append((claim.residual, moved.residual))
        return claim

    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    with monkeypatch.context() as patch:
        patch.setattr(module, "checked_slip", of_both)
        fo.safe_slip(contact, cycle, friction, 0.0, **options)
    return residuals[number]


def test_the_reserve_of_a_safe_slip_counts_gaps_and_pressures_where_these_are_the_least(
    monkeypatch,
):
    """The slip of node 0 changes the pressure, or the gap, of node 1. Back from its best place node
    0 has a larger reserve against its own friction bound."""
    one, pressing = np.eye(2), [[0.0, 0.0], [0.5, 0.0]]
    loads = {"P": ([0.0, 0.0], [1.0, -0.05]), "Q": ([0.1, 0.0], [0.0, 0.0])}
    # Too little to press node 1.
    opened = fo.ContactSystem.from_blocks(one, [[0.0, 0.0], [0.02, 0.0]], one, [0.0, 1.0], loads)
    found, moved = of_moved_slip(monkeypatch, opened, 0.5, 0.1)
    assert found < 1e-9 and moved > 1e-3
    little = fo.ContactSystem.from_blocks(
        one,
        pressing,
        one,
        [0.0, 1.0],
        {"P": ([0.0, 0.0], [1.0, 0.003]), "Q": ([0.001, 0.0], [0.0, 0.0])},
    )
    found, moved = of_moved_slip(monkeypatch, little, [0.005, 2.0], -1e-4)
    assert found < 1e-9 and moved > 1e-3
    # Node 1 is pulled, and its friction is so small that its tension counts more than its bound.
    pulled = fo.ContactSystem.from_blocks(
        one, pressing, one, [0.0, 1.0], {**loads, "P": ([0.0, 0.0], [1.0, -0.3])}
    )
    found, moved = of_moved_slip(monkeypatch, pulled, [0.5, 0.005], -0.05, number=0)
    assert found < 1e-9 and moved > 1e-4


def test_a_smaller_margin_than_the_multipliers_prove_is_no_answer(monkeypatch):
    contact = random_system(np.random.default_rng(0), 4)
    largest = fo.safe_slip(contact, CYCLE, 0.4, 0.1).margin

    def less(program, name, x, y):
        return np.where(program.cost != 0, x - 0.1, x), y

    lying(monkeypatch, less)
    with suppress(fo.SolverError):
        assert fo.safe_slip(contact, CYCLE, 0.4, 0.1).margin == pytest.approx(largest)


def test_a_safe_slip_beyond_its_bound_is_no_answer_though_nothing_resists_it(monkeypatch):
    loads = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.1, 0.1], [0.0, 0.0])}
    loose = fo.ContactSystem.from_blocks(
        np.zeros((2, 2)), np.zeros((2, 2)), np.eye(2), [0.0, 1.0], loads
    )
    found, moved = of_moved_slip(monkeypatch, loose, 0.5, 0.3, slip_bound=0.1)
    assert found < 1e-9 and moved > 1e-3


@pytest.mark.parametrize("friction", [0.3, 0.7])
def test_a_bound_with_its_error_is_not_below_what_it_bounds(friction):
    punch = fo.scenes.PunchOnHalfPlane(elements=16).condense()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    limit = fo.shakedown_limit(punch, cycle, friction)
    assert limit.load_factor <= limit.bound < limit.load_factor * (1 + 1e-12)
