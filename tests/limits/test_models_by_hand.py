"""The problem of an answer holds true data, for every kind of answer.

The data are status, multipliers, parameters changed by hand, labels, and tables. One model under
several load cycles has the limits by hand.
"""

import copy
import pickle

import cvxpy as cp
import numpy as np
import pandas as pd
import pytest
from cvxpy.atoms.pnorm import Pnorm

import frictopt as fo
from helpers.cases import few
from helpers.spatial import CORNERS, random_contact
from helpers.systems import CYCLE, NODE, random_system

FINE = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), 1e-10)
SPACE = fo.LoadCycle({"mean": 1.0}, CORNERS)


def node(coupling):
    """One node, pressed by P and sheared by Q."""
    return fo.ContactSystem.from_blocks(
        [[1.0]], [[coupling]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    )


NONE_SAFE = node(0.0), fo.LoadCycle({"P": -1.0}, [{"Q": -1.0}, {"Q": 1.0}]), 0.5
ALL_SAFE = node(0.3), fo.LoadCycle({"P": 1.0}, [{"Q": 1.0, "P": 1.0}, {"Q": 0.5, "P": 1.0}]), 0.9
FINITE = node(0.3), fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.5


def size(q):
    return cp.abs(q) if q.ndim == 1 else cp.norm(q, 2, axis=1)


@pytest.mark.parametrize(
    ("contact", "cycle"), [(random_system, CYCLE), (random_contact, SPACE)], ids=["plane", "space"]
)
def test_multipliers_of_a_critical_state_have_the_number_of_their_node(contact, cycle):
    system = contact(np.random.default_rng(3), 3)
    limit = fo.guaranteed_limit(system, cycle, np.array([0.55, 0.6, 0.65]))
    critical = limit.multipliers.query("row.str.startswith('critical')")
    assert set(critical.node) == {limit.node}
    assert critical.component.tolist() == [*range(system.tangents), 0]


def test_a_guaranteed_problem_with_a_fixed_part_names_the_reactions_of_both_corners():
    system = random_system(np.random.default_rng(5), 3, loads=("mean", "cyclic", "still"))
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"cyclic": -1.0}, {"cyclic": 1.0}], fixed=[{"still": 0.1}, {}]
    )
    limit = fo.guaranteed_limit(system, cycle, 0.5)
    assert "critical_q: c0 + q_r[" in str(limit.problem)
    assert limit.problem.solve(solver="HIGHS") == pytest.approx(limit.load_factor, rel=1e-7)


@pytest.mark.parametrize(
    ("question", "expected"),
    [(NONE_SAFE, ("infeasible", -np.inf)), (ALL_SAFE, ("unbounded", np.inf))],
    ids=["none", "all"],
)
def test_a_problem_without_an_optimum_has_the_status_that_plain_cvxpy_gives_it(question, expected):
    limit = fo.shakedown_limit(*question)
    problem = pickle.loads(pickle.dumps(limit)).problem
    assert (
        (limit.problem.status, limit.problem.value) == (problem.status, problem.value) == expected
    )
    assert f"problem     {expected[0]}" in limit.explain()
    problem.solve(solver="HIGHS")
    assert (problem.status, problem.value) == expected


def test_own_rows_where_nothing_is_safe_without_them():
    """They govern nothing, so that their multipliers are 0, even if an earlier answer left other
    values."""
    system, cycle, friction = NONE_SAFE
    model = fo.ShakedownModel(system, cycle)
    row = model.slip <= 1.0
    row.dual_variables[0].save_value(np.ones(1))
    limit = model.solve(friction, [row])
    assert np.isnan(limit.load_factor)
    assert limit.problem.status == "infeasible"
    assert row.dual_value.tolist() == [0.0]


@pytest.mark.parametrize("seed", [1, 6])
def test_own_rows_keep_the_multipliers_of_the_limit_where_no_node_is_critical_below_it(seed):
    """Multipliers of the user's rows are those of lambda_2 if no node is critical below it.

    The programs of nodes are solved after the program of lambda_2, with the same rows. The
    multiplier is the derivative, by finite differences.
    """
    system = random_system(np.random.default_rng(seed), 3)
    model = fo.GuaranteedModel(system, CYCLE, simplify=False)
    most = cp.Parameter(
        nonneg=True, value=0.5 * np.abs(fo.guaranteed_limit(system, CYCLE, 0.2).slip).max()
    )
    row = cp.norm_inf(model.slip) <= most
    limit = model.solve(0.2, [row])
    assert limit.node is None and len(limit.record.attempts) > len(limit.shakedown.record.attempts)
    dual = float(np.ravel(row.dual_value)[0])
    most.value += 1e-6
    more = model.solve(0.2, [row]).load_factor
    assert dual == pytest.approx((more - limit.load_factor) / 1e-6, rel=1e-3) and dual > 0.1


def answers():
    """Answers of all kinds, by their questions."""
    for question in (FINITE, NONE_SAFE, ALL_SAFE):
        limit = fo.shakedown_limit(*question)
        yield "limit", limit
        yield "guaranteed", fo.guaranteed_limit(*question)
        yield "gross slip", fo.gross_slip(*question)
        yield "safe", fo.safe_slip(*question, 0.3)


def test_tables_of_every_kind_of_answer_have_columns_of_the_same_types():
    types = dict[tuple[str, str], list[tuple]]()
    for name, answer in answers():
        for table in ("mechanism", "multipliers", "events", "motion", "load_rates"):
            found = getattr(answer, table, None)
            if isinstance(found, pd.DataFrame):
                types.setdefault((name, table), []).append(tuple(found.dtypes.astype(str).items()))
    assert len(types) >= 8
    for kind, of_answers in types.items():
        assert len(set(of_answers)) == 1, (kind, of_answers)


@pytest.mark.parametrize(
    ("contact", "cycle"), few([(random_contact, SPACE), (random_system, CYCLE)], 1)
)
def test_each_row_has_a_label_of_its_own(contact, cycle):
    system = contact(np.random.default_rng(1), 3).with_gap([0.0, 0.0, 8.0])
    opens = fo.ShakedownModel(system, cycle)
    design = fo.DesignModel(
        system, cycle, preloads=["mean"], profile=True, scenarios=[(cycle, 0.4)]
    )
    size = cp.abs(design.profile) <= 0.01
    problems = [
        opens.solve(0.5, [(opens.load_factor <= 9.0).set_label("own")]).problem,
        fo.safe_slip(system, cycle, 0.5, 0.1).problem,
        fo.guaranteed_limit(system, cycle, 0.5, slip_bound=10.0).problem,
        design.solve(
            0.5, [(cp.abs(design.preload) <= 0.1).set_label("bolts"), size.set_label("depth")]
        ).problem,
    ]
    for problem in problems:
        labels = [row.label for row in problem.constraints]
        assert None not in labels and len(set(labels)) == len(labels), labels
        names = {}
        for constant in problem.constants():
            value = np.asarray(constant.value).tolist()
            assert constant.is_scalar() or names.setdefault(constant.name(), value) == value, (
                constant.name()
            )


def test_the_rows_of_a_node_are_replaced_by_their_label():
    """Without its friction row the limit is that of a strength of the surface."""
    cycle = FINITE[1]
    limit = fo.shakedown_limit(node(0.0), cycle, 0.5)
    q = [limit.problem.var_dict[f"q[{k}]"] for k in (0, 1)]
    rows = [row for row in limit.problem.constraints if not row.label.startswith("stuck")]
    bonded = cp.Problem(limit.problem.objective, [*rows, *(cp.abs(each) <= 0.2 for each in q)])
    assert bonded.solve(solver="HIGHS") == pytest.approx(0.2, rel=1e-9)


def test_norms_in_space_are_bare_so_that_solvers_of_second_order_cones_take_them():
    """cvxpy counts `Pnorm`, the norm with approx=False, as one that needs power cones."""
    limit = fo.shakedown_limit(random_contact(np.random.default_rng(0), 3), SPACE, 0.5)
    assert Pnorm not in limit.problem.atoms()


@pytest.mark.parametrize("friction", [[0.5, 0.5, 0.5], [0.0, 0.5, 0.5], [1e-3, 0.0, 2.0]], ids=str)
@pytest.mark.parametrize(
    ("contact", "cycle"), [(random_system, CYCLE), (random_contact, SPACE)], ids=["plane", "space"]
)
def test_rows_of_pressure_that_are_left_out_change_nothing(contact, cycle, friction):
    """Plain cvxpy solves the rows as they are printed, and all rows."""
    system, friction = contact(np.random.default_rng(2), 3), np.array(friction)
    load = fo.LoadCycle(cycle.mean, [{**corner, "mean": 0.4} for corner in cycle.corners])
    limit = fo.shakedown_limit(system, load, friction, open_nodes=np.zeros(3, dtype=bool))
    every = fo.shakedown_limit(
        system, load, friction, open_nodes=np.zeros(3, dtype=bool), simplify=False
    )
    options = {"solver": "HIGHS"} if system.tangents == 1 else {"solver": "CLARABEL", **FINE}
    value = copy.deepcopy(limit.problem).solve(**options)
    assert limit.load_factor == pytest.approx(every.load_factor, rel=1e-8, abs=1e-8, nan_ok=True)
    assert np.isnan(limit.load_factor) or value == pytest.approx(
        limit.load_factor, rel=1e-6, abs=1e-7
    )


@pytest.mark.parametrize("axes", [1, 2])
def test_programs_hold_no_copy_of_the_stiffness(axes):
    """Programs hold no copy of the stiffness, although constants of cvxpy usually copy arrays."""
    rng = np.random.default_rng(1)
    contact = random_system(rng, 5) if axes == 1 else random_contact(rng, 5)
    limit = fo.shakedown_limit(contact, CYCLE if axes == 1 else SPACE, 0.5, open_nodes=[False] * 5)
    matrices = [part.value for part in limit.problem.constants() if part.ndim == 2]
    stiffness = [matrix for matrix in matrices if matrix.shape[1] == axes * 5]
    assert len(stiffness) == 2
    for matrix in stiffness:
        assert np.shares_memory(matrix, contact.S) and not matrix.flags.writeable


TO_AND_FRO = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])


def test_a_limit_by_hand():
    """A node is pressed by P and sheared by Q to and fro: the limit is f P / Q."""
    model = fo.ShakedownModel(NODE, TO_AND_FRO)
    for P, Q, friction in [(1.0, 1.0, 0.5), (3.0, 0.5, 0.4), (0.2, 2.0, 0.9)]:
        cycle = fo.LoadCycle({"P": P}, [{"Q": -Q}, {"Q": Q}])
        limit = model.solve(friction, cycle=cycle)
        assert limit.load_factor == pytest.approx(friction * P / Q, rel=1e-9)
        assert limit.problem.value == pytest.approx(limit.load_factor, rel=1e-9)


def test_corners_within_the_hull_of_one_load_cycle_are_vertices_of_another():
    """Of three corners on a line the middle one is left out, until it is an end."""
    middle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 0.5}, {"Q": 1.0}])
    end = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 4.0}, {"Q": 1.0}])
    model = fo.ShakedownModel(NODE, middle)
    assert model.solve(0.5).load_factor == pytest.approx(0.5)
    # The slip moves the mean of the shear forces to zero: their range is 5 Q.
    assert model.solve(0.5, cycle=end).load_factor == pytest.approx(2 * 0.5 / 5)


def test_another_number_of_corners_is_refused():
    model = fo.ShakedownModel(NODE, TO_AND_FRO)
    with pytest.raises(fo.ModelError, match=r"cycle: 1 corner, the model has 2; give as many"):
        model.solve(0.5, cycle=fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]))
