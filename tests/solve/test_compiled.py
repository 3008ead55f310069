"""Programs as cvxpy compiles them, made smaller and scaled.

Each step gives back a solution of the whole program, whatever the program is about.
"""

import warnings
from types import SimpleNamespace

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from scipy.spatial.distance import cdist

import frictopt as fo
from frictopt.base import SolveRecord
from frictopt.limits.models import constant as named
from frictopt.solve import chain as chains
from frictopt.solve import eliminated, redundant
from frictopt.solve.arrays import polish
from frictopt.solve.chain import Chain
from frictopt.solve.compiled import Compiled, by_inverse
from frictopt.solve.reduced import Reduced
from frictopt.solve.solvers import NoOptimum, run
from frictopt.solve.unresisted import unresisted
from helpers.cases import few
from helpers.spatial import cycle as space_cycle
from helpers.spatial import random_contact
from helpers.systems import CYCLE, SEEDS, random_system


def whole(compiled):
    """All rows of a compiled program with its dense equations in them.

    Also returns which of the rows are these equations.
    """
    matrix, kept = compiled.matrix.toarray(), np.ones(len(compiled.right), dtype=bool)
    for block in compiled.blocks:
        at = np.arange(block.rows.start, block.rows.stop)
        assert matrix[at, block.defined].tolist() == [block.sign] * len(at)
        assert matrix[block.sources][:, block.of].any(axis=1).all()
        matrix[np.ix_(at, block.of)] -= block.sign * block.matrix
        kept[block.sources] = False
    return matrix[kept], np.flatnonzero(kept)


def columns(problem, param_prob):
    """The columns of the problem's unknowns in order, then the columns that cvxpy adds."""
    place = param_prob.var_id_to_col
    known = [variable.id for variable in problem.variables()]
    order = sorted(place, key=place.get)
    ends = dict(
        zip(
            sorted(place.values()),
            [*sorted(place.values())[1:], param_prob.x.size],
            strict=True,
        )
    )
    sequence = [one for one in known if one in place] + sorted(
        one for one in order if one not in known
    )
    return np.concatenate([np.arange(place[one], ends[place[one]]) for one in sequence])


def same_rows(mine, theirs):
    """Whether rows are the same ones up to their order."""
    assert mine.shape == theirs.shape
    if len(mine):
        apart = cdist(mine, theirs, "chebyshev")
        assert apart.min(axis=1).max() < 1e-9 and apart.min(axis=0).max() < 1e-9
        assert sorted(np.unique((apart < 1e-9).sum(axis=1))) == sorted(
            np.unique((apart < 1e-9).sum(axis=0))
        )


def contact_problem(seed, tangents, bounded, constrained):
    rng = np.random.default_rng(seed)
    if tangents == 1:
        contact, loads = random_system(rng, 3), CYCLE
    else:
        contact, loads = random_contact(rng, 3), space_cycle()
    model = fo.ShakedownModel(contact, loads, slip_bound=0.8 if bounded else None)
    rows = []
    if constrained:
        rows = [
            model.slip[0] <= 0.1,
            cp.norm1(model.slip[1]) <= 1.0,
            cp.sum(model.p[0]) >= 0.1,
            model.load_factor <= 5.0,
        ]
    return model.solve(0.4, rows).problem


# cvxpy warns of expressions of three dimensions.
@pytest.mark.filterwarnings("ignore:The problem includes expressions")
@pytest.mark.parametrize("constrained", [False, True])
@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
@pytest.mark.parametrize("seed", few(range(2)))
def test_a_program_with_dense_blocks_is_the_one_that_cvxpy_compiles_of_the_whole_problem(
    seed, tangents, bounded, constrained
):
    problem = contact_problem(seed, tangents, bounded, constrained)
    data, *_ = problem.get_problem_data("CLARABEL", solver_opts={"use_quad_obj": True})
    compiled, rng = Compiled(problem), np.random.default_rng(seed)
    assert len(compiled.blocks) == 2
    theirs = columns(problem, data["param_prob"])
    mine = columns(
        problem,
        SimpleNamespace(var_id_to_col=compiled.columns, x=SimpleNamespace(size=len(compiled.cost))),
    )
    (matrix, kept), A = whole(compiled), data["A"].toarray()
    assert sorted(mine) == sorted(theirs) == list(range(len(compiled.cost)))
    assert compiled.cost[mine] == pytest.approx(data["c"][theirs])
    ways = rng.normal(size=(len(mine), 4))
    ours, others = (
        np.c_[rows[:, at] @ ways, right]
        for rows, at, right in ((matrix, mine, compiled.right[kept]), (A, theirs, data["b"]))
    )
    dims, zero = data["dims"], int((kept < compiled.zero).sum())
    assert (zero, compiled.nonneg, compiled.soc) == (dims.zero, dims.nonneg, dims.soc)
    end = zero + compiled.nonneg
    same_rows(ours[:zero], others[:zero])
    same_rows(ours[zero:end], others[zero:end])
    for size in set(compiled.soc):  # a cone as one row: the order within it matters
        starts = end + np.cumsum([0, *compiled.soc])[:-1][np.array(compiled.soc) == size]
        same_rows(
            *(
                rows[starts[:, None] + np.arange(size)].reshape(len(starts), -1)
                for rows in (ours, others)
            )
        )
    y = rng.normal(size=len(compiled.right))
    for block in compiled.blocks:
        y[block.sources] = np.nan  # they follow from the others
    y = compiled.whole(y)
    assert compiled.matrix.T @ y == pytest.approx(matrix.T @ y[kept])


def test_parameters_are_read_anew():
    x, most = cp.Variable(2), cp.Parameter(value=1.0)
    chain = Chain(cp.Problem(cp.Maximize(cp.sum(x)), [x <= most]), {})
    for value in (1.0, 3.0):
        most.value = value
        assert chain.solve(lambda: SolveRecord(residual=chain.proof.gap))[0].residual <= 1e-9
        assert chain.problem.value == pytest.approx(2 * value)


def any_program(rng, cones, n=5):
    """A bounded random program and a point inside of it.

    It has dense and sparse equations, bounds of abs and perhaps norm, and redundant rows.
    """
    G, M, free = rng.normal(size=(n, n - 1)), rng.normal(size=(3, n)), rng.normal(size=n)
    free /= np.linalg.norm(free)
    # One direction it does not resist.
    square = (
        (np.eye(n) - np.outer(free, free))
        @ (G @ G.T + np.eye(n))
        @ (np.eye(n) - np.outer(free, free))
    )
    square, M = (square + square.T) / 2, M - np.outer(M @ free, free)
    x = cp.Variable(n, name="x")
    y = cp.Variable(n, name="y")
    w = cp.Variable(3, name="w")
    t = cp.Variable(2, name="t")
    load = cp.Variable(name="load")
    at = 0.1 * rng.normal(size=n)
    y0, w0, weights = square @ at, M @ at, rng.uniform(0.5, 2.0, 4)
    t0 = w0[:2] + 2 * y0[1:3] + at[0]
    rows = [y == named(square, "G") @ x, w == named(M, "M") @ x, t == w[:2] + 2 * y[1:3] + x[0]]
    rows += [
        cp.abs(y - y0) <= rng.uniform(0.5, 1.0, n) + 0.1 * load,
        cp.abs(t - t0) <= rng.uniform(0.5, 1.0, 2),
        cp.norm1(x) <= 5,
        load >= 0,
    ]
    rows += [
        weight * load + y[k % 2] <= y0[k % 2] + right
        for k, (weight, right) in enumerate(zip(weights, rng.uniform(0.2, 1.0, 4), strict=True))
    ]
    if cones:
        rows += [
            cp.pnorm(cp.reshape(y[:4] - y0[:4], (2, 2), order="F"), 2, axis=1) <= 0.9 + load,
            cp.norm(w - w0) <= 1.5,
        ]
    if rng.random() < 0.3:
        rows += [rng.normal(size=(2, n)) @ (x - at) == 0]
    problem = cp.Problem(
        cp.Maximize(
            rng.normal(size=n) @ x
            + rng.normal(size=3) @ w
            + rng.normal(size=2) @ t
            + rng.uniform(0.1, 1.0) * load
            + 2.0
        ),
        rows,
    )
    free, inverse = unresisted(square, M, np.sqrt(np.diag(square)), np.ones(3))
    assert free.shape == (n, 1)
    return problem, lambda: by_inverse(
        rows[0], rows[1:2], free, inverse, rng.uniform(0.5, 2.0, n), np.ones(1)
    )


NO_ROWS = np.zeros(0, dtype=int)
NO_DEFINITIONS = eliminated.Definitions(NO_ROWS, NO_ROWS, np.zeros(0))
STEPS = ("bounds_of_norms", "defined_unknowns", "dominated", "changes")


@pytest.mark.parametrize("cones", [False, True])
@pytest.mark.parametrize(
    "steps", [(), *((step,) for step in STEPS), STEPS], ids=lambda steps: "+".join(steps) or "none"
)
@settings(max_examples=few(10))
@given(seed=SEEDS)
def test_what_a_reduction_gives_back_solves_the_compiled_program(seed, steps, cones):
    rng = np.random.default_rng(seed)
    problem, change = any_program(rng, cones)
    units = {
        variable: 10.0 ** rng.uniform(-2, 2)
        for variable in problem.variables()
        if rng.random() < 0.7
    }
    exact = {"tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11, "tol_feas": 1e-11}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        best, compiled = problem.solve(solver="CLARABEL", **exact), Compiled(problem)
    # Clarabel does not reach these tolerances in some random programs.
    assume(problem.status == cp.OPTIMAL)
    with pytest.MonkeyPatch.context() as patch:
        for module, name, none in (
            (eliminated, "bounds_of_norms", NO_DEFINITIONS),
            (eliminated, "defined_unknowns", NO_DEFINITIONS),
            (redundant, "dominated", NO_ROWS),
        ):
            if name not in steps:
                patch.setattr(module, name, lambda *_, none=none: none)
        reduced = Reduced(compiled, units, [change()] if "changes" in steps else [])
    if steps == STEPS:
        assert len(reduced.arrays.cost) < len(compiled.cost) - 9
        assert len(reduced.arrays.right) < len(compiled.right) - 10
    status, x, y = run(reduced.arrays, "CLARABEL", -np.inf)
    z, multipliers = reduced.back(*polish(reduced.arrays, x, y))
    assert status == "optimal"
    (matrix, kept), at = whole(compiled), 0
    m, s = multipliers[kept], compiled.right[kept] - matrix @ z
    zero = int((kept < compiled.zero).sum())
    assert np.abs(s[:zero]).max() < 1e-9
    for size in [1] * compiled.nonneg + compiled.soc:
        for part in (s, m):
            cone = part[zero + at : zero + at + size]
            assert cone[0] >= np.linalg.norm(cone[1:]) - 1e-9
        at += size
    assert matrix.T @ m + compiled.cost == pytest.approx(np.zeros(len(z)), abs=1e-8)
    assert compiled.matrix.T @ multipliers + compiled.cost == pytest.approx(
        np.zeros(len(z)), abs=1e-8
    )
    assert compiled.cost @ z == pytest.approx(-compiled.right[kept] @ m, abs=1e-8)
    compiled.save(z, multipliers)
    assert (problem.value, problem.objective.value) == pytest.approx(
        (best, best), rel=1e-7, abs=1e-7
    )
    assert all(row.violation().max() < 1e-8 for row in problem.constraints)


def of(goal, rows, units=None, **options):
    """The arrays of a program, and its reductions."""
    reduced = Reduced(Compiled(cp.Problem(goal, rows)), units or {}, **options)
    return reduced.arrays, reduced


@pytest.mark.parametrize("scale", [1.0, 1e-20])
def test_rows_that_differ_in_the_coefficient_of_a_load_all_stay_in_any_unit_of_it(scale):
    """x + y + load <= 1 and x + y - load <= 1; and |q| <= p + load beside p - load >= 0."""
    x, y, q, p, load = (cp.Variable(name=name) for name in ("x", "y", "q", "p", "load"))
    scaled = scale * load
    pairs = [
        [x >= 0, y >= 0, x + y - scaled <= 1, x + y + scaled <= 1],
        [load >= 0, cp.abs(q) <= p + scaled, p - scaled >= 0, p <= 1, p - q <= 3],
    ]
    for rows in pairs:
        problem = cp.Problem(cp.Maximize(scaled), rows)
        chain = Chain(problem, {load: 1 / scale}, simplify=True)
        chain.solve(lambda chain=chain: SolveRecord(residual=chain.proof.gap))
        assert problem.value == pytest.approx(1.0) and chain.reduced.left_out == 0


@pytest.mark.parametrize("simplify", [True, False])
def test_rows_that_others_stand_for(simplify):
    """Redundant rows are left out.

    With load >= 0, of rows that differ only in the coefficient of the load a row is left out if
    another row has a larger coefficient and no larger right side.
    """
    x, y, load = cp.Variable(), cp.Variable(), cp.Variable()
    rows = [
        load >= 0,
        load + y <= 3,
        2 * load + y <= 2,
        0.5 * load + y <= 1,
        0.25 * load + y <= 4,
        3 * load + x <= 9,
        x >= -1,
        y >= -1,
    ]
    problem = cp.Problem(cp.Maximize(3 * load + y + x), rows)
    chain = Chain(problem, {}, simplify=simplify)
    record = chain.solve(lambda: SolveRecord(residual=chain.proof.gap))[1]
    best = max(
        3 * a + b + min(9 - 3 * a, np.inf) for a, b in ((0.0, 1.0), (2 / 3, 2 / 3), (1.5, -1.0))
    )
    assert problem.value == pytest.approx(best) and chain.reduced.left_out == (2 if simplify else 0)
    assert record.left_out == (("rows: 2 redundant",) if simplify else ())
    assert [float(rows[k].dual_value) for k in (1, 4)] == [0.0, 0.0]


@pytest.mark.parametrize("sign", ["none", "<= 0", ">= -1", ">= 0", ">= 0.5"])
def test_rows_that_others_stand_for_only_where_the_unknown_has_the_sign(sign):
    """Rows are redundant only if the unknown has the sign.

    `load + y <= 3` follows from `2 load + y <= 2` if load >= -1, but the test of redundancy needs
    load >= 0.
    """
    y, load = cp.Variable(), cp.Variable()
    signed = {
        "none": [],
        "<= 0": [load <= 0],
        ">= -1": [load >= -1],
        ">= 0": [load >= 0],
        ">= 0.5": [load >= 0.5],
    }[sign]
    rows = [load + y <= 3, 2 * load + y <= 2, y >= -9, *signed]
    assert of(cp.Maximize(y), rows)[1].left_out == (1 if sign in (">= 0", ">= 0.5") else 0)


def test_the_row_that_says_the_sign_is_never_left_out_by_it():
    """`-load <= 0` follows from `load <= 0` and load >= 0, which is itself."""
    load, y = cp.Variable(), cp.Variable()
    rows = [load >= 0, load <= 0, y <= 1 + load, y >= 0]
    chain = Chain(cp.Problem(cp.Minimize(load), rows), {})
    assert chain.growth() is None
    assert (
        chain.solve(
            lambda: SolveRecord(residual=max(chain.proof.gap, *(row.violation() for row in rows)))
        )[0].residual
        <= 1e-9
    )
    assert load.value == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("least", "left_out"), [(-0.5, 1), (0.0, 1), (0.5, 0)])
def test_a_bound_on_an_abs_implies_only_a_pressure_that_is_not_above_zero(least, left_out):
    """`abs(q) <= p / 2` implies `p >= least` if `least <= 0`; for a larger one the row stays."""
    q, p = cp.Variable(2), cp.Variable(2)
    rows = [cp.abs(q) <= 0.5 * p, p[0] >= least, p[1] >= 0.75, q >= -1]
    chain = Chain(cp.Problem(cp.Minimize(p[0] + p[1]), rows), {})
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert chain.reduced.left_out == left_out
    assert p.value == pytest.approx([max(least, 0.0), 0.75], abs=1e-12)


def test_one_of_equal_rows_is_left():
    y, load = cp.Variable(), cp.Variable()
    program, reduced = of(
        cp.Maximize(load + y),
        [load >= 0, load + y <= 1, load + y <= 1, load + 2 * y <= 1, load + 2 * y <= 1, y <= 0.75],
    )
    assert reduced.left_out == 2 and len(program.right) == 4


@pytest.mark.parametrize(("side", "zero"), [(2.0, 1), (3.0, 2)])
def test_an_equation_is_left_out_that_others_stand_for_and_not_one_that_they_contradict(side, zero):
    x = cp.Variable(2)
    one, two = x[0] + x[1] == 1, 2 * x[0] + 2 * x[1] == side
    problem = cp.Problem(cp.Maximize(x[0]), [one, two, x >= 0])
    chain = Chain(problem, {})
    assert chain.reduced.arrays.zero == zero
    if zero == 1:
        chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
        assert x.value == pytest.approx([1.0, 0.0])
        assert float(one.dual_value) + 2 * float(two.dual_value) == pytest.approx(1.0)
    else:
        none = chain.contradiction()
        assert none.ruling == {one.id, two.id}
        assert float(one.dual_value) == pytest.approx(-2 * float(two.dual_value))


@pytest.mark.parametrize("tiny_share", [1e-8, 1e-11])
def test_an_unknown_does_not_follow_from_an_equation_that_hardly_has_it(tiny_share):
    """An equation with a tiny coefficient of an unknown does not determine the unknown.

    The unknown t would be a difference of two equal numbers over a tiny number.
    """
    x, t, w = cp.Variable(), cp.Variable(), cp.Variable()
    rows = [x / 3 + tiny_share * t == 0.1, x + w == 0.7, t <= 0.3, t >= -0.3]
    problem = cp.Problem(cp.Maximize(t + w), rows)
    chain = Chain(problem, {})
    chain.solve(lambda: SolveRecord(residual=max(chain.proof.gap, chain.violation)))
    assert t.value == pytest.approx(0.3, rel=1e-12)
    assert w.value == pytest.approx(0.7 - 3 * (0.1 - tiny_share * 0.3), rel=1e-12)


def test_an_unknown_that_one_equation_alone_has_follows_from_the_others():
    x, t = cp.Variable(), cp.Variable()
    define = t - 3 * x == 1
    problem = cp.Problem(cp.Maximize(t), [define, x <= 2])
    chain = Chain(problem, {})
    assert chain.reduced.arrays.matrix.shape == (1, 1)
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert (
        problem.value,
        float(t.value),
        float(define.dual_value),
        float(problem.constraints[1].dual_value),
    ) == pytest.approx((7.0, 7.0, 1.0, 3.0))


def test_bounds_of_abs_are_no_unknowns():
    x = cp.Variable(2)
    row = cp.abs(x - 1) <= np.array([0.5, 2.0])
    chain = Chain(cp.Problem(cp.Maximize(x[0] - x[1]), [row]), {})
    assert chain.reduced.arrays.matrix.shape == (4, 2)
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert x.value == pytest.approx([1.5, -1.0]) and row.dual_value == pytest.approx([1.0, 1.0])


def test_bounds_of_norms_are_no_unknowns():
    x = cp.Variable((2, 2))
    row = cp.pnorm(x, 2, axis=1, approx=False) <= np.array([5.0, 1.0])
    chain = Chain(cp.Problem(cp.Maximize(3 * x[0, 0] + 4 * x[0, 1] + x[1, 1]), [row]), {})
    assert chain.reduced.arrays.matrix.shape == (6, 4)
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert x.value == pytest.approx(np.array([[3.0, 4.0], [0.0, 1.0]]))
    assert row.dual_value == pytest.approx([5.0, 1.0])


def test_a_cone_without_room_is_equations_and_its_multiplier_is_in_the_cone():
    x = cp.Variable(3)
    shut = cp.SOC(cp.Constant(0.0), x[:2] - np.array([1.0, 2.0]))
    chain = Chain(cp.Problem(cp.Maximize(3 * x[0] + 4 * x[1] + x[2]), [shut, x[2] <= 5.0]), {})
    assert chain.reduced.arrays.zero == 2 and chain.reduced.arrays.sizes.tolist() == [1]
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert x.value == pytest.approx(np.array([1.0, 2.0, 5.0]))
    assert shut.dual_value[0] == pytest.approx(5.0)


@pytest.mark.parametrize(
    "why",
    [
        "two rows bound it",
        "a row and a cone bound it",
        "a cone bounds it",
        "it is what is sought",
        "it stands in an equation",
        "it hurts in a cone",
    ],
)
def test_an_unknown_is_kept_unless_one_row_bounds_it_and_it_only_helps_elsewhere(why):
    x, t = cp.Variable(2), cp.Variable()
    goal, rows = x[0] + x[1], [x[0] <= t, -x[0] <= t, t <= 1 - x[1], x[1] >= 0.25]
    goal, rows = {
        "two rows bound it": (goal, [*rows, t <= 0.5]),
        "a row and a cone bound it": (goal, [*rows, cp.SOC(0.9 - t, x)]),
        "a cone bounds it": (goal, [*rows[:2], x[1] >= 0.25, cp.SOC(0.9 - t, x)]),
        "it is what is sought": (0.5 * x[0] - x[1] - t, rows),
        "it stands in an equation": (goal, [*rows, t + x[0] + 2 * x[1] == 1.6]),
        "it hurts in a cone": (goal, [*rows, cp.SOC(0.9, cp.hstack([t, x[0]]))]),
    }[why]
    problem = cp.Problem(cp.Maximize(goal), rows)
    best = problem.solve(solver="CLARABEL", tol_gap_abs=1e-11, tol_gap_rel=1e-11, tol_feas=1e-11)
    chain = Chain(problem, {})
    chain.solve(lambda: SolveRecord(residual=max(chain.proof.gap, chain.violation)))
    assert problem.value == pytest.approx(best, abs=1e-8)
    assert all(row.violation().max() < 1e-9 for row in rows)


def test_unknowns_that_no_row_feels_are_no_unknowns_and_their_values_follow():
    G, M = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([[1.0, 1.0], [1.0, -1.0], [3.0, 0.0]])
    x, y, w, idle = cp.Variable(2), cp.Variable(2), cp.Variable(3), cp.Variable(2)
    problem = cp.Problem(
        cp.Maximize(x[0] + x[1]),
        [y == named(G, "G") @ x, w == named(M, "M") @ x, x <= 1, idle == named(G, "G") @ x],
    )
    chain = Chain(problem, {})
    assert chain.reduced.arrays.matrix.shape[1] == 2
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert x.value == pytest.approx([1.0, 1.0])
    assert y.value == pytest.approx([1.0, 1.0])
    assert w.value == pytest.approx([2.0, 0.0, 3.0])
    assert all(row.violation().max() < 1e-12 for row in problem.constraints)


@pytest.mark.parametrize("felt", [True, False])
def test_what_a_square_matrix_does_not_resist_is_an_unknown_only_where_a_row_feels_it(felt):
    """A motion without resistance is an unknown only if a row depends on it.

    One body of two nodes may slide. Only the slide opens a gap, which may matter or not.
    """
    G, M, W = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[1.0, -1.0]]), np.array([[1.0, 1.0]])
    x, y, w, gap = cp.Variable(2), cp.Variable(2), cp.Variable(1), cp.Variable(1)
    dense = [y == named(G, "G") @ x, w == named(M, "M") @ x, gap == named(W, "W") @ x]
    free, inverse = unresisted(G, M, np.ones(2), np.ones(1))
    change = by_inverse(dense[0], dense[1:], free, inverse, np.ones(2), np.ones(1))
    rows = [cp.abs(y) <= 2, w <= 3, *([gap >= 5] if felt else [])]
    problem = cp.Problem(cp.Maximize(y[0]), [*dense, *rows])
    chain = Chain(problem, {}, [change])
    assert chain.reduced.arrays.matrix.shape[1] == (2 if felt else 1)
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert y.value == pytest.approx([2.0, -2.0])
    assert all(row.violation().max() < 1e-9 for row in problem.constraints)


def tiny(kind, cone):
    """A program of a kind, with the ids of the rows that rule it, and its unknown."""
    x, t = cp.Variable(2), cp.Variable()
    ball = cp.norm(x) <= t if cone else cp.abs(x) <= t
    low, idle = (x[0] >= 2).set_label("low"), x[1] <= 7
    if kind == "infeasible":
        high = t <= 1
        return cp.Problem(cp.Maximize(x[1]), [ball, high, low, idle]), {ball.id, high.id, low.id}
    rows = [ball, low, idle] if kind == "unbounded" else [ball, t <= 3, low, idle]
    return cp.Problem(cp.Maximize(x[0]), rows), set()


@pytest.mark.parametrize("free", [0, 1, 3])
def test_a_compliance_is_the_inverse_where_something_resists_and_nothing_elsewhere(free):
    rng, n = np.random.default_rng(free), 8
    still = np.linalg.qr(rng.normal(size=(n, free)))[0] if free else np.zeros((n, 0))
    root = (np.eye(n) - still @ still.T) @ rng.normal(size=(n, n))
    square = root @ root.T
    found, inverse = unresisted(square, np.zeros((1, n)), np.sqrt(np.diag(square)), np.ones(1))
    assert found @ found.T == pytest.approx(still @ still.T, abs=1e-9)
    assert inverse == pytest.approx(
        np.linalg.pinv(square, rcond=1e-9), abs=1e-6 * np.abs(inverse).max()
    )


@pytest.mark.parametrize("cone", [False, True])
@pytest.mark.parametrize("kind", ["infeasible", "unbounded", "feasible"])
def test_why_there_is_no_optimum(kind, cone):
    problem, ruling = tiny(kind, cone)
    chain = Chain(problem, {})
    none = chain.contradiction()
    more = chain.growth() if kind != "infeasible" else None
    assert (none is not None, more is not None) == (kind == "infeasible", kind == "unbounded")
    if none:
        assert none.ruling == ruling and none.residual <= 1e-9 and none.z is None
        y = {row.label or index: row.dual_value for index, row in enumerate(problem.constraints)}
        # The multiplier t balances: 1 < 2.
        assert float(y["low"]) > 0
        assert float(y[1]) == pytest.approx(float(y["low"]))
    if more:
        x, t = sorted(problem.variables(), key=lambda variable: -variable.size)
        ray, size = chain.value_along(more, x), chain.value_along(more, t)
        assert ray[0] > 0
        assert ray[1] <= 1e-9
        assert (np.linalg.norm(ray) if cone else np.abs(ray).max()) <= size + 1e-9


@pytest.mark.parametrize("kind", ["infeasible", "unbounded"])
def test_solvers_that_agree_on_no_optimum_are_not_believed_without_a_proof(kind):
    chain = Chain(tiny(kind, False)[0], {})
    with pytest.raises(NoOptimum):
        chain.solve(lambda: pytest.fail("nothing to judge"))
    with pytest.raises(NoOptimum):
        chain.solve(lambda: pytest.fail("nothing to judge"), no_optimum=lambda: None)
    with pytest.raises(NoOptimum):
        chain.solve(
            lambda: pytest.fail("nothing to judge"), no_optimum=lambda: SolveRecord(residual=1e-8)
        )
    assert (
        chain.solve(
            lambda: pytest.fail("nothing to judge"), no_optimum=lambda: SolveRecord(residual=1e-10)
        )[1].residual
        == 1e-10
    )


@pytest.mark.parametrize("damage", ["unbalanced", "the wrong way", "none"])
@pytest.mark.parametrize("kind", ["infeasible", "feasible"])
def test_damaged_multipliers_contradict_nothing(kind, damage, monkeypatch):
    """Damaged multipliers prove no contradiction.

    Whatever excess a search of a contradiction claims, its multipliers must balance, and must prove
    this excess.
    """
    chain = Chain(tiny(kind, True)[0], {})
    honest = chains._least_excess

    def damaged(program):
        y = honest(program)[1]
        y = {"unbalanced": y + 1e-3 * np.arange(1, len(y) + 1), "the wrong way": -y, "none": 0 * y}[
            damage
        ]
        return 1.0, y

    monkeypatch.setattr(chains, "_least_excess", damaged)
    assert chain.contradiction() is None


@pytest.mark.parametrize("over", [0.0, 1e-12])
def test_rows_that_rounding_parts_contradict_nothing(over):
    t = cp.Variable()
    chain = Chain(cp.Problem(cp.Maximize(t), [t >= 1 + over, t <= 1]), {})
    assert chain.contradiction() is None


def lies(answer):
    """Solvers that tell this x and these multipliers of any program."""
    return lambda program, name, above: ("optimal", *answer(program))


def test_an_excess_needs_multipliers_that_prove_it(monkeypatch):
    """An excess needs multipliers that prove it.

    A solver claims an excess of a feasible program, or no excess of a program without a solution.
    """
    for kind, excess in (("feasible", 1.0), ("infeasible", 0.0)):
        chain = Chain(tiny(kind, True)[0], {})
        with monkeypatch.context() as patch:
            patch.setattr(
                chains,
                "run",
                lies(
                    lambda program, excess=excess: (
                        excess * program.cost,
                        np.zeros(len(program.right)),
                    )
                ),
            )
            patch.setattr(chains, "polish", lambda program, x, y: (x, y))
            assert chain.contradiction() is None


@pytest.mark.parametrize("cone", [False, True])
def test_multipliers_outside_their_cones_prove_no_limit(cone, monkeypatch):
    """Multipliers outside of their cones prove no limit.

    All solvers return the least value as the largest one. Their multipliers balance, and the bound
    is that value, but one multiplier has the wrong sign.
    """
    x = cp.Variable(2)
    row = cp.SOC(cp.Constant(1.0), x) if cone else cp.abs(x) <= 1.0
    chain = Chain(cp.Problem(cp.Maximize(x[0]), [row]), {})

    def answer(program, name, above):
        y = np.zeros(len(program.right))
        against = np.argmax(program.matrix.toarray() @ program.cost)
        y[[0, against] if cone else against] = -1.0
        return "optimal", np.array([-1.0, 0.0]), y

    with monkeypatch.context() as patch:
        patch.setattr(chains, "polish", lambda program, x, y: (x, program.admissible(y)))
        patch.setattr(chains, "run", answer)
        with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
            chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
    assert x.value[0] == pytest.approx(1.0)


@pytest.mark.parametrize("value", [0.0, 5.0])
def test_an_excess_that_one_solver_gets_wrong_is_asked_of_the_next(value, monkeypatch):
    """The next solver is called if one solver returns a wrong excess.

    The first solver returns zeros for all unknowns and multipliers, or multipliers that do not
    balance but prove some excess.
    """
    chain, names = Chain(tiny("infeasible", True)[0], {}), []

    def answer(program, name, above):
        names.append(name)
        if len(set(names)) > 1:
            return run(program, name, above)
        x, y = np.zeros(len(program.cost)), np.zeros(len(program.right))
        x[program.cost.astype(bool)] = value
        y[np.argmin(program.right)] = value / -program.right.min()
        return "optimal", x, y

    monkeypatch.setattr(chains, "polish", lambda program, x, y: (x, y))
    monkeypatch.setattr(chains, "run", answer)
    assert chain.contradiction() is not None and len(set(names)) > 1


@pytest.mark.parametrize("still", [False, True])
def test_a_way_that_leaves_the_rows_or_leads_nowhere_is_no_growth(still, monkeypatch):
    """Solvers tell a way that breaks a row of a bounded program, or none at all."""
    chain = Chain(tiny("feasible", True)[0], {})
    assert chain.growth() is None

    def answer(program):
        objective = program.matrix[[np.flatnonzero(program.right == -1)[0]]].toarray().ravel()
        return np.where(program.cost.astype(bool) | still, 0.0, -objective), np.zeros(
            len(program.right)
        )

    monkeypatch.setattr(chains, "polish", lambda program, x, y: (x, y))
    monkeypatch.setattr(
        chains,
        "run",
        lies(
            lambda program: (
                answer(program)
                if (program.right == -1).any()
                else (program.cost, 0 * program.right)
            )
        ),
    )
    assert chain.ray() is None and chain.growth() is None


@pytest.mark.parametrize("friction", [1.0, 1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("cone", [False, True])
def test_growth_within_little_friction_needs_pressure_that_grows_and_values_to_begin_with(
    friction, cone
):
    q, p, load = cp.Variable(2), cp.Variable(), cp.Variable()
    rows = [(cp.norm(q) if cone else cp.max(cp.abs(q))) <= friction * p, load == q[0], q[1] == 0]
    units = {p: 1.0, q: friction, load: friction}
    for more, grows in (([], True), ([p <= 1], False), ([q[0] <= -1], False), ([q[1] >= 1], False)):
        assert (
            Chain(cp.Problem(cp.Maximize(load), [*rows, *more]), units).growth() is not None
        ) == grows
    pulled = Chain(cp.Problem(cp.Maximize(p), [*rows, q[0] <= -friction, load >= friction]), units)
    assert pulled.ray() is not None
    assert pulled.growth() is None
    assert pulled.contradiction() is not None


def test_values_that_cannot_be_read_are_refused_each_time(monkeypatch):
    """Values that cannot be read are refused each time.

    Otherwise the second question would be answered with the values of the first one.
    """
    x, bound = cp.Variable(), cp.Parameter(value=2.0)
    compiled = Compiled(cp.Problem(cp.Minimize(x), [x >= bound]))
    bound.value = 3.0

    def refuse(*arguments, **options):
        raise cp.error.SolverError

    with monkeypatch.context() as patch:
        patch.setattr(cp.Problem, "get_problem_data", refuse)
        for _ in range(2):
            with pytest.raises(cp.error.SolverError):
                compiled.read()
    compiled.read()
    assert sorted(np.abs(compiled.right)) == [3.0]
