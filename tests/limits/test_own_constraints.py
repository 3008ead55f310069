"""Constraints and objectives of the user, in the plane and in space.

They are compared with programs over raw slips that have every row of every corner.
"""

import re

import cvxpy as cp
import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.liars import misread
from helpers.oracle import Oracle
from helpers.spatial import cycle as spatial_cycle
from helpers.spatial import random_contact
from helpers.systems import (
    CYCLE,
    NODE,
    SEEDS,
    explained,
    freed,
    linprog_limit,
    on_both_bounds,
    random_system,
)

BOTH = pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
TURNS = spatial_cycle()


def contact_of(rng, nodes, tangents, coupling=0.5):
    if tangents == 2:
        return random_contact(rng, nodes, coupling)
    return random_system(rng, nodes, ("mean", *"abc"), coupling)


def agrees(limit, value, rel=1e-7):
    """A limit has the value of an oracle and a proof.

    The value is nan if no load factor is safe, and inf if there is no largest one.
    """
    assert limit.load_factor == pytest.approx(value, rel=rel, abs=rel / 10, nan_ok=True)
    assert limit.residual <= 1e-9
    if limit.kind is fo.LimitKind.FINITE:
        assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8, abs=1e-8)


@BOTH
@settings(max_examples=few(8))
@given(
    seed=SEEDS,
    f=st.floats(0.1, 1.0),
    # Without coupling a limit has a closed form, but not under constraints.
    coupling=st.sampled_from([0.0, 0.5]),
    at=st.sampled_from([0.0, 0.1, 3.0]),
    cost=st.sampled_from([0.0, 0.3, 3.0]),
    simplify=st.booleans(),
    solver=st.sampled_from([None, "CLARABEL"]),
    free=st.booleans(),
)
def test_rows_equations_norms_and_objectives_of_slip_load_factor_and_reactions(
    tangents, seed, f, coupling, at, cost, simplify, solver, free
):
    """Rows, equations, norms and objectives agree with a plain program of all corners.

    If `free`, nothing holds the body against a slide; this case is only in the plane, and not for a
    single solver.
    """
    rng = np.random.default_rng(seed)
    rel = 1e-7 if tangents == 1 else 1e-6
    contact = contact_of(rng, 3, tangents, coupling)
    weights = rng.normal(size=(3, tangents)).squeeze()
    contact = freed(contact) if free and tangents == 1 and solver is None else contact
    model = fo.ShakedownModel(contact, TURNS, simplify=simplify, solver=solver)
    oracle = Oracle(contact, TURNS, f)

    def user_rows(slip, lam, q, p):
        return [
            cp.sum(cp.multiply(weights, slip)) + 0.3 * lam == at,
            cp.norm1(slip[0]) <= 0.5 + 0.01 * lam,
            cp.max(slip[1]) <= 0.4,
            cp.sum(q[1][2]) <= 0.9 * f * p[1][2],
            cp.norm(q[2][1]) <= 0.8 * f * p[2][1],
        ]

    model_rows = user_rows(model.slip, model.load_factor, model.q, model.p)
    oracle_rows = user_rows(oracle.slip, oracle.lam, oracle.q, oracle.p)
    limit = model.solve(f, model_rows)
    agrees(limit, oracle.largest(oracle_rows), rel)
    if limit.kind is fo.LimitKind.FINITE:
        values = model.slip, model.load_factor, model.q, model.p
        for expression, value in zip(
            values, (limit.slip, limit.load_factor, *limit.reactions), strict=True
        ):
            assert expression.value == pytest.approx(value, abs=1e-9)
        goals = [
            2 * lam - cost * cp.sum(cp.abs(slip))
            for lam, slip in ((model.load_factor, model.slip), (oracle.lam, oracle.slip))
        ]
        chosen = model.solve(f, model_rows, objective=goals[0])
        rough = rel if tangents == 1 else 10 * rel
        assert chosen.objective == pytest.approx(
            oracle.largest(oracle_rows, goals[1]), rel=rough, abs=rough / 10
        )
        assert chosen.bound == pytest.approx(chosen.objective, rel=1e-7, abs=1e-8)
        assert f"objective={chosen.objective:.6g}" in repr(chosen)
        assert 2 * chosen.load_factor - cost * np.abs(chosen.slip).sum() == pytest.approx(
            chosen.objective, abs=1e-8
        )
        assert chosen.load_factor <= limit.load_factor * (1 + 1e-8)
        assert "not a limit" in chosen.reason


@BOTH
def test_constraints_that_nothing_obeys_are_named(tangents):
    contact = contact_of(np.random.default_rng(2), 3, tangents)
    model = fo.ShakedownModel(contact, TURNS)
    above = model.solve(0.4).load_factor * 1.01
    harmless = model.slip <= 10.0
    impossible = (model.load_factor >= above).set_label("service load")
    limit = model.solve(0.4, [harmless, impossible])
    assert limit.kind is fo.LimitKind.NO_SAFE_SLIP
    assert np.isnan(limit.load_factor)
    assert np.isnan(limit.slip).all()
    assert "obeys service load:" in limit.reason
    assert limit.constraints == ("constraints[0]", "service load")
    limit = model.solve(0.4, [harmless, model.load_factor >= 0.98 * above])
    printed = explained(limit)
    assert all(
        text in printed
        for text in (
            "slip <= 10.0",
            "the dual bound covers them",
            f"answer      {limit.load_factor:.12g}",
        )
    )


def test_all_forms_of_a_constraint_say_the_same():
    model = fo.ShakedownModel(random_system(np.random.default_rng(1), 3), CYCLE)
    sizes = cp.Variable(3)
    bounds = (
        [model.slip <= 0.05],
        [cp.NonNeg(0.05 - model.slip)],
        [0.05 >= model.slip],
        [cp.max(model.slip) <= 0.05],
    )
    plus, minus = (cp.Variable(3, nonneg=True, name=name) for name in ("plus", "minus"))
    sums_of_variables = (
        [sizes >= model.slip, sizes >= -model.slip, cp.sum(sizes) <= 0.06],
        [model.slip == plus - minus, cp.sum(plus + minus) <= 0.06],
    )
    sums = [cp.norm1(model.slip) <= 0.06], *sums_of_variables  # with variables of the user
    for forms in (bounds, sums):
        limits = [model.solve(0.4, form).load_factor for form in forms]
        assert limits == pytest.approx([limits[0]] * len(limits), rel=1e-9)
        assert limits[0] < 0.99 * model.solve(0.4).load_factor


def test_rates_under_constraints_are_the_slopes_of_a_sweep():
    contact = random_system(np.random.default_rng(1), 3)
    model = fo.ShakedownModel(contact, CYCLE)
    constraints = [model.slip <= 0.05, model.load_factor <= 5 - 10 * model.slip[2]]
    table = model.sweep([0.4 - 1e-5, 0.4, 0.4 + 1e-5], constraints)
    limit = model.solve(0.4, constraints)
    assert limit.friction_rate.sum() == pytest.approx(
        np.diff(table.load_factor)[0] / 1e-5, rel=1e-3
    )
    assert limit.load_rates.rate.isna().all() and not model.solve(0.4).load_rates.rate.isna().any()


@pytest.mark.parametrize("tangents", [1, 2])
def test_a_strength_that_rules_leaves_friction_no_rate(tangents):
    """If a strength governs the limit, more friction changes nothing.

    One node carries only shear. With `|q| <= c` below `f p` the limit is c over the shear.
    """
    zero = [0.0] * (tangents - 1)
    loads = {"P": [0.0] * tangents + [1.0], "Q": [1.0] + [0.0] * tangents}
    contact = fo.ContactSystem(np.eye(tangents + 1), [[0.0, *zero, 0.0]], loads)
    model = fo.ShakedownModel(contact, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]))
    sizes = [
        cp.abs(model.q[k]) if tangents == 1 else cp.norm(model.q[k], 2, axis=1) for k in (0, 1)
    ]
    limit = model.solve(0.5, [size <= 0.3 for size in sizes])
    assert limit.load_factor == pytest.approx(0.3)
    assert limit.friction_rate == pytest.approx([0.0], abs=1e-9)
    assert model.solve(0.2, [size <= 0.3 for size in sizes]).friction_rate == pytest.approx([1.0])


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (lambda model: True, r"constraints\[0\]: True"),
        (lambda model: model.slip, r"constraints\[0\]"),
        (lambda model: cp.norm1(model.slip) >= 1, r"constraints\[0\]: not convex"),
        (lambda model: cp.exp(model.load_factor) <= 2, r"constraints\[0\].*ExpCone cone"),
        (
            lambda model: model.slip <= cp.Variable(3, boolean=True, name="own"),
            r"constraints\[0\]: variable own is an integer",
        ),
        (
            lambda model: model.slip <= cp.Variable((3, 3), PSD=True, name="own")[0],
            r"constraints\[0\]: variable own is PSD; give",
        ),
        (
            lambda model: model.slip <= cp.Variable(3, sparsity=[(0, 1)], name="own"),
            r"constraints\[0\]: variable own is sparsity; give",
        ),
        (
            lambda model: cp.abs(cp.Variable(3, complex=True, name="own")) <= 1,
            r"constraints\[0\]: variable own is complex; give",
        ),
        (
            lambda model: model.slip <= cp.Parameter(name="most"),
            r"constraints\[0\]: parameter most has no value",
        ),
        (
            lambda model: (
                cp.abs(model.slip + cp.Parameter(complex=True, value=1j, name="most")) <= 1
            ),
            r"constraints\[0\]: parameter most is not finite or",
        ),
        (lambda model: model.slip <= np.nan, r"constraints\[0\]: a constant is not finite"),
        (
            lambda model: model.slip <= sp.csr_array([[np.inf, 0.0, 1.0]]) @ model.slip,
            r"constraints\[0\]: a constant is not finite",
        ),
        (lambda model: fo.ShakedownModel(*TWO).slip <= 1, r"constraints\[0\].*another model"),
        (lambda model: 3.0, "objective: 3.0"),
        (lambda model: model.slip, "objective: .*scalar"),
        (lambda model: cp.norm1(model.slip), "objective: not convex"),
        (
            lambda model: model.load_factor - np.inf * cp.norm1(model.slip),
            "objective: a constant is not finite",
        ),
        (lambda model: cp.sum(cp.Variable(2)), "objective: it grows without bound"),
    ],
)
def test_bad_constraints_and_objectives_are_refused(part, message):
    model = fo.ShakedownModel(*TWO)
    arguments = (
        {"objective": part(model)}
        if message.startswith("objective")
        else {"constraints": [part(model)]}
    )
    with pytest.raises(fo.ModelError, match=message):
        model.solve(0.4, **arguments)


@pytest.mark.parametrize("label", ["constraints[1]", "constraints[0]", "mine", None])
def test_each_constraint_has_a_name_of_its_own_and_holds(label):
    model = fo.ShakedownModel(*TWO)
    rows = [
        (model.load_factor <= 0.01).set_label(label),
        model.load_factor <= 7.0,
        (model.load_factor <= 8.0).set_label(label),
    ]
    limit = model.solve(0.4, rows)
    assert limit.load_factor == pytest.approx(0.01, rel=1e-9) and len(set(limit.constraints)) == 3
    assert limit.constraints[1:] == ("constraints[1]", "constraints[2]")
    assert limit.constraints[0] == ("mine" if label == "mine" else "constraints[0]")


def test_rows_that_print_alike_keep_their_multipliers_and_those_of_the_model():
    """Rows of the user that print alike, or as a row of the model, keep all multipliers."""
    model = fo.ShakedownModel(*TWO)
    rows = [
        model.load_factor <= 9.0,
        model.load_factor <= 0.1,
        cp.sum(model.slip) <= 8.0,
        cp.sum(model.slip) <= 7.0,
    ]
    table = model.solve(0.4, rows).multipliers.groupby("row").multiplier.sum()
    printed = str(rows[2].args[0])
    own = ["constraints[0]", "constraints[1]", printed, "constraints[3]"]
    assert table[own].tolist() == pytest.approx([0.0, 1.0, 0.0, 0.0], abs=1e-9)
    assert "load_factor" in table


def test_a_label_of_the_model_is_refused():
    """A label of the model is refused, whatever the problem of the answer is."""
    model = fo.ShakedownModel(*TWO)
    gap = fo.ShakedownModel(TWO[0].with_gap([0.0, 0.0, 8.0]), CYCLE)
    for one, labels in ((model, ("stuck[0]", "q_r", "load_factor")), (gap, ("apart[1]", "w_r"))):
        for label in labels:
            assert label in [row.label for row in one.solve(0.4).problem.constraints]
            with pytest.raises(fo.ModelError, match=re.escape(f"the label '{label}' is that of")):
                one.solve(0.4, [(one.slip <= 5.0).set_label(label)])


def test_norms_of_all_corners_at_once_are_refused_and_those_of_each_corner_hold():
    """cvxpy ends in an assertion along the last of three axes, and takes other entries along the
    middle axis."""
    model = fo.ShakedownModel(contact_of(np.random.default_rng(0), 3, 2), TURNS)
    free = model.solve(0.4).load_factor
    most = 0.8 * np.linalg.norm(model.q.value, axis=2).max()
    for axis in (1, 2):
        with pytest.raises(
            fo.ModelError,
            match=rf"constraints.0.: it has norms along axis {axis} of 3 axes.*cp\.norm\(model\.q\[k\], 2, axis=1\)",
        ):
            model.solve(0.4, [cp.norm(model.q, 2, axis=axis) <= most])
    assert (
        model.solve(0.4, [cp.norm(q, 2, axis=1) <= most for q in model.q]).load_factor
        < 0.999 * free
    )
    assert np.linalg.norm(model.q.value, axis=2).max() == pytest.approx(most, rel=1e-8)
    model.solve(0.4, [cp.norm(model.q, 2, axis=0) <= most])
    assert np.linalg.norm(model.q.value, axis=0).max() == pytest.approx(most, rel=1e-8)


@pytest.mark.parametrize(
    ("own", "rest"),
    [
        (lambda v: 0.02 - v, {"nonneg": True}),
        (lambda v: 0.02 - v, {"pos": True}),
        (lambda v: 0.02 + v, {"nonpos": True}),
        (lambda v: 0.02 + v, {"neg": True}),
        (lambda v: v, {"bounds": [0.01, 0.02]}),
        (lambda v: v, {"bounds": [-np.inf, np.full(3, 0.02)]}),
        (
            lambda v: cp.minimum(v @ np.eye(3)[0], 0.02 + v[:, 1] - v[1]),
            {"symmetric": True, "shape": (3, 3), "name": "square"},
        ),
    ],
)
@BOTH
def test_variables_with_a_sign_bounds_or_symmetry_bound_the_slip_as_their_rows_do(
    tangents, own, rest
):
    contact = contact_of(np.random.default_rng(0), 3, tangents)
    model = fo.ShakedownModel(contact, TURNS)
    variable = cp.Variable(**{"shape": 3, "name": "own", **rest})
    size = cp.abs(model.slip) if tangents == 1 else cp.norm(model.slip, axis=1)
    rows = [size <= own(variable)] + (
        [] if "symmetric" not in rest else [cp.diag(variable) <= 0.02, variable <= 0.02]
    )
    limit = model.solve(0.4, rows)
    plain = fo.shakedown_limit(contact, TURNS, 0.4, slip_bound=0.02)
    assert limit.load_factor == pytest.approx(plain.load_factor, rel=1e-7)
    assert limit.bound == pytest.approx(plain.load_factor, rel=1e-7)
    assert (size.value <= own(variable).value + 1e-9).all()
    if "symmetric" in rest:
        assert np.array_equal(variable.value, variable.value.T)


@pytest.mark.parametrize(
    "ask",
    [lambda: fo.shakedown_limit(*TWO, 0.4), lambda: fo.safe_slip(*TWO, 0.4, 0.1)],
    ids=["limit", "margin"],
)
@pytest.mark.parametrize("which", ["values", "multipliers"])
def test_what_is_no_number_proves_nothing(ask, which, monkeypatch):
    def lie(compiled, z, multipliers):
        (z if which == "values" else multipliers)[:] = np.nan

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError):
        ask()


def test_a_solver_that_breaks_a_row_of_your_own_is_not_believed(monkeypatch):
    """Only the unknown of the user is wrong: slip, load factor and multipliers are right."""
    contact, _ = TWO
    model, variable = fo.ShakedownModel(*TWO), cp.Variable(name="own")
    right = model.solve(0.4, [variable == 0.5 * model.slip[0]])

    def lie(program, x, multipliers):
        # A goal, the residual shear forces, and last the unknown of the user.
        if len(x) == 1 + contact.nodes + 1:
            x[-1] += 1e-3

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        model.solve(0.4, [variable == 0.5 * model.slip[0]])
    assert right.residual <= 1e-9


def test_rows_of_your_own_are_printed_by_the_names_of_the_model_and_have_multipliers():
    model = fo.ShakedownModel(*TWO)
    kept = cp.constraints.Zero(model.slip[0])
    rows = [
        model.q[0] <= 10.0,
        model.p >= 0.01,
        model.slip[:0] <= 1.0,
        kept,
        (model.p[1] >= 0.0).set_label("q[all]"),
    ]
    limit = model.solve(0.4, rows)
    assert [str(model.q), str(model.p), str(model.p[1, 2])] == ["q", "p", "p[1, 2]"]
    assert "Concatenate" not in limit.explain()
    # The empty row is printed as slip[0], too.
    assert {"q[0, 0:3]", "p", "constraints[3]", "q[all]"} <= set(limit.multipliers.row)
    assert "           0.01 <= p\n" in str(limit.problem)
    assert (limit.multipliers[limit.multipliers.row == "p"].corner == -1).all()


TWO = random_system(np.random.default_rng(0), 3), CYCLE


def test_a_contact_that_its_load_presses_has_no_limit_under_constraints_that_leave_a_slip():
    model = fo.ShakedownModel(
        random_system(np.random.default_rng(0), 2),
        fo.LoadCycle({"mean": 1.0}, [{"mean": 1.0}, {"mean": 2.0}]),
    )
    limit = model.solve(0.5, [cp.abs(model.slip) <= 1.0])
    assert limit.kind is fo.LimitKind.UNBOUNDED
    assert limit.load_factor == np.inf
    assert "constraints[0]" in limit.reason
    assert model.solve(0.5, [model.load_factor <= 7.0]).load_factor == pytest.approx(7.0, rel=1e-9)


@settings(max_examples=few(15))
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(2, 4),
    f=st.floats(0.1, 1.0),
    size=st.sampled_from([-0.05, 0.02, 0.2, 2.0]),
)
def test_the_guaranteed_limit_under_constraints_is_the_least_over_the_slips_that_obey_them(
    seed, nodes, f, size
):
    contact = random_system(np.random.default_rng(seed), nodes)
    model = fo.GuaranteedModel(contact, CYCLE, simplify=False)
    limit = model.solve(f, [model.slip <= size])
    upper = [(row, 0.0, size) for row in np.eye(nodes)]
    agrees(limit.shakedown, linprog_limit(contact, CYCLE, f, upper=upper)[1])
    if limit.kind is fo.LimitKind.FINITE:
        expected = np.nanmin(
            [*on_both_bounds(contact, CYCLE, f, upper=upper)[:, 0], limit.shakedown.load_factor]
        )
        assert limit.load_factor == pytest.approx(expected, rel=1e-7, abs=1e-8)
        assert limit.constraints == ("constraints[0]",)
        with pytest.raises(
            fo.ModelError, match=r"after_overload: the limit is under constraints\[0\]"
        ):
            fo.after_overload(limit)
        assert limit.slip.max() <= size + 1e-9 and limit.residual <= 1e-9
        assert model.slip.value == pytest.approx(limit.slip, abs=1e-9)
        assert model.load_factor.value == pytest.approx(limit.load_factor, abs=1e-9)
        q, p = limit.reactions
        assert model.q.value == pytest.approx(q, abs=1e-9)
        assert model.p.value == pytest.approx(p, abs=1e-9)


def test_the_rate_of_an_objective_is_its_slope():
    contact = random_system(np.random.default_rng(1), 3)
    model = fo.ShakedownModel(contact, CYCLE)
    goal = 3 * model.load_factor - 0.4 * cp.norm1(model.slip)
    low, at, high = (model.solve(f, objective=goal) for f in (0.4 - 1e-5, 0.4, 0.4 + 1e-5))
    assert at.friction_rate.sum() == pytest.approx(
        (high.objective - low.objective) / 2e-5, rel=1e-3
    )
    assert at.load_rates.rate.isna().all()


def test_constraints_on_a_contact_with_a_node_without_friction_say_that_nothing_is_safe():
    loads = {"P": [0, 0, 0, 0, 1, 1], "X": [1, 0.4, 0, 0, 0, 0], "Y": [0, 0, 1, 0.3, 0, 0]}
    pair = fo.ContactSystem(np.eye(6), [[0, 0, 0], [1, 0, 0]], loads)
    model = fo.ShakedownModel(pair, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"Y": 1.0}]))
    small = cp.norm(model.slip, 2, axis=1) <= 0.1
    for rows in ([], [small]):
        none = model.solve([0.5, 0.0], rows)
        assert none.load_factor == 0.0
        assert abs(none.bound) < 1e-12
        assert "node 1 has no friction, and the cyclic load shears it" in none.reason
    never = model.solve([0.5, 0.0], [(model.load_factor >= 0.1).set_label("service load")])
    assert never.kind is fo.LimitKind.NO_SAFE_SLIP and "obeys service load" in never.reason
    limit = model.solve([0.5, 0.3], [small])
    assert limit.kind.name == "FINITE" and np.linalg.norm(limit.slip, axis=1).max() <= 0.1 + 1e-9
    printed = explained(limit)
    assert "1 of 2 rows bind" in printed
    with pytest.raises(fo.ModelError, match="PSD cone"):
        model.solve([0.5, 0.3], [cp.norm(model.slip, 2) <= 0.1])


@pytest.mark.parametrize("simplify", [True, False])
def test_own_rows_hold_at_a_corner_that_others_stand_for(simplify):
    """Rows of the user hold at a corner that other corners make redundant.

    One node has the loads -L, L and L / 2, so that |L| + |s| <= 1/2 for a slip s. By hand, L / 2 +
    s <= 1/10 reduces the limit.
    """
    model = fo.ShakedownModel(
        NODE, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}, {"Q": 0.5}]), simplify=simplify
    )
    limit = model.solve(0.5, [model.q[2] <= 0.1])
    assert (limit.load_factor, limit.slip[0]) == (
        pytest.approx(0.4, rel=1e-9),
        pytest.approx(-0.1, rel=1e-9),
    )
    assert model.solve(0.5).load_factor == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_factors_of_a_product_may_differ_in_size(unit):
    """The unit of a divisor, of which the bound has the inverse, changes nothing."""
    contact = random_system(np.random.default_rng(3), 3)

    def limit(unit):
        model = fo.ShakedownModel(contact, CYCLE)
        row = cp.quad_over_lin(model.slip, unit) <= 1e-3 / unit
        return model.solve(0.5, constraints=[row]).load_factor

    assert limit(1.0) < fo.shakedown_limit(contact, CYCLE, 0.5).load_factor * (1 - 1e-3)
    assert limit(unit) == pytest.approx(limit(1.0), rel=1e-8)
