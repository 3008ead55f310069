"""Constraints of the user where the mean load leaves nodes open.

The limits are compared with programs of the slips and gaps of all nodes at all corners.
"""

from types import SimpleNamespace

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.oracle import Oracle
from helpers.separation import THREE, open_contact, open_in_space, pulled_system
from helpers.systems import CYCLE
from studies.validation.fuzz.embedded import embedded

seeds = st.integers(0, 10**6)


def of_model(model):
    """The same of a model of the package."""
    corners = range(model.q.shape[0])
    return SimpleNamespace(
        slip=model.slip,
        lam=model.load_factor,
        q=[model.q[k] for k in corners],
        p=[model.p[k] for k in corners],
    )


def own_rows(limit, seed):
    """Rows of the user, as a function of slips, load factor and reactions.

    The rows bound the slips of all nodes, the load factor, and the forces of one node. Some slip
    obeys them at half the limit.
    """
    rng = np.random.default_rng(seed)
    half = fo.safe_slip(limit.system, limit.cycle, limit.friction, 0.5 * limit.load_factor)
    weights = rng.normal(size=limit.slip.shape)
    node = rng.choice(np.flatnonzero(~limit.open))
    (q, p) = half.reactions
    at = (weights * half.slip).sum()
    share = 0.05 + np.linalg.norm(q[-1, node]) / p[-1, node]

    def rows(of):
        shear = of.q[-1][node] if limit.slip.ndim == 1 else cp.norm(of.q[-1][node])
        return [
            cp.sum(cp.multiply(weights, of.slip)) == at,
            shear <= share * of.p[-1][node],
            cp.sum(of.p[0])
            >= 0.5 * p[0].sum() - abs(p[0].sum()) * (of.lam / limit.load_factor - 0.5),
        ]

    return rows


def agrees(contact, cycle, f, limit, seed):
    """Compare a limit, and a chosen slip, under rows of the user with a plain program.

    Returns the model, the rows, and the limit under the rows.
    """
    model = fo.ShakedownModel(contact, cycle)
    oracle = Oracle(contact, cycle, f, limit.open)
    rows = own_rows(limit, seed)
    assert oracle.largest() == pytest.approx(limit.load_factor, rel=1e-6)
    constraints, oracle_constraints = rows(of_model(model)), rows(oracle)
    goal = [
        lam - 0.1 * cp.sum(cp.abs(slip))
        for lam, slip in ((model.load_factor, model.slip), (oracle.lam, oracle.slip))
    ]
    chosen = model.solve(f, constraints, objective=goal[0])
    assert chosen.objective == pytest.approx(
        oracle.largest(oracle_constraints, goal[1]), rel=1e-5, abs=1e-7
    )
    assert chosen.residual <= 1e-9
    found = model.solve(f, constraints)
    assert found.load_factor == pytest.approx(oracle.largest(oracle_constraints), rel=1e-6)
    assert found.bound == pytest.approx(found.load_factor, rel=1e-8)
    assert found.open.tolist() == limit.open.tolist() and found.residual <= 1e-9
    assert 0.5 * limit.load_factor <= found.load_factor * (1 + 1e-9)
    assert found.load_factor <= limit.load_factor * (1 + 1e-9)
    assert max(np.max(row.violation()) for row in constraints) <= 1e-8
    return model, constraints, found


@settings(max_examples=few(6, 1, 6))
@given(seeds, st.sampled_from([CYCLE, THREE]))
def test_the_limit_under_rows_on_all_nodes(seed, cycle):
    contact, f, limit = open_contact(seed, cycle=cycle)
    model, _, found = agrees(contact, cycle, f, limit, seed)
    (q, p), out = found.reactions, limit.open
    assert not model.q.value[:, out].any() and not model.p.value[:, out].any()
    assert (model.slip.value, model.q.value, model.p.value) == (
        pytest.approx(found.slip),
        pytest.approx(q),
        pytest.approx(p),
    )
    assert (
        fo.steady_state(
            contact, cycle, f, found.load_factor * (1 - 1e-6), initial_state=found.state
        ).outcome
        is fo.Outcome.SHAKEDOWN
    )


@settings(max_examples=few(4, 1, 4))
@given(seeds)
def test_the_limit_in_space_under_rows_on_all_nodes(seed):
    contact, cycle, limit = open_in_space(seed)
    assume(limit.open.any() and 1e-3 < limit.load_factor < np.inf)
    agrees(contact, cycle, 0.6, limit, seed)


@settings(max_examples=few(3, 1))
@given(seeds)
def test_a_guaranteed_limit_under_rows_is_the_least_with_a_closed_node_on_both_bounds(seed):
    contact, f, limit = open_contact(seed)
    flat = fo.GuaranteedModel(contact, CYCLE)
    shut = np.flatnonzero(~limit.open)
    most = 0.7 * np.abs(limit.slip[~limit.open]).max()
    found = flat.solve(f, [cp.abs(flat.slip[shut]) <= most])
    assume(found.kind is fo.LimitKind.FINITE and found.shakedown.open.any())
    oracle = Oracle(contact, CYCLE, f, limit.open)
    least = found.shakedown.load_factor
    assert least == pytest.approx(oracle.largest([cp.abs(oracle.slip[shut]) <= most]), rel=1e-6)
    for node in shut:
        for k in (0, 1):
            critical = [
                oracle.q[k][node] == -f * oracle.p[k][node],
                oracle.q[1 - k][node] == f * oracle.p[1 - k][node],
            ]
            least = np.fmin(
                least, -oracle.largest([cp.abs(oracle.slip[shut]) <= most, *critical], -oracle.lam)
            )
    assert found.load_factor == pytest.approx(least, rel=1e-5, abs=1e-7) and found.residual <= 1e-9
    solid, along = embedded(contact, np.random.default_rng(seed))
    model = fo.GuaranteedModel(solid, CYCLE)
    limited = cp.abs(cp.sum(cp.multiply(along, model.slip), axis=1)[shut]) <= most
    assert model.solve(f, [limited]).load_factor == pytest.approx(
        found.load_factor, rel=1e-6, abs=1e-8
    )


def test_rows_that_nothing_obeys_are_named_and_open_no_node_of_a_closed_contact():
    contact, f = pulled_system(np.random.default_rng(1), 4), 0.4
    limit = fo.shakedown_limit(contact, CYCLE, f)
    model = fo.ShakedownModel(contact, CYCLE)
    refused = model.solve(
        f,
        [
            model.slip <= 1e3,
            (model.load_factor >= 1.01 * limit.load_factor).set_label("service load"),
        ],
    )
    assert refused.kind is fo.LimitKind.NO_SAFE_SLIP
    assert refused.reason.startswith(f"with {limit.open.sum()} of {contact.nodes} nodes open")
    assert "obeys service load:" in refused.reason
    assert np.isnan(refused.slip).all()
    assert model.slip.value is None
    shut = contact.with_bonded(
        {"mean": (contact.bonded["mean"][0], np.ones(contact.nodes))}
    ).with_gap(np.zeros(contact.nodes))
    closed = fo.ShakedownModel(shut, CYCLE)
    none = closed.solve(f, [closed.p[0, 0] <= 0.0, closed.load_factor >= 0.1])
    assert none.kind is fo.LimitKind.NO_SAFE_SLIP and not none.open.any()


def test_a_node_without_friction_that_stays_open_takes_no_limit_away():
    """Node 1 has no friction and is sheared, but open; the slip of node 0 rules."""
    loads = {"P": [0, 0, 0, 0, 1.0, -1.0], "X": [1.0, 0.3, 0, 0, 0, 0]}
    pair = fo.ContactSystem(np.eye(6), [[0.0, 0, 0], [1.0, 0, 0]], loads)
    model = fo.ShakedownModel(pair, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": 0.0}]))
    assert model.solve([0.5, 0.0]).load_factor == pytest.approx(1.0)
    limit = model.solve([0.5, 0.0], [model.slip[0, 0] >= -0.2])
    assert limit.load_factor == pytest.approx(0.7) and limit.open.tolist() == [False, True]
