"""Limits and safe slips under a bound on the slip, against linear programs over raw slips with the same bound."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import frictopt as fo
from frictopt.solve import solvers as policy
from systems import CYCLE, corner_rows, linprog_limit, random_system, stress_of


def freed(contact):
    """The same contact without anything that resists a slide of all nodes."""
    n = contact.nodes
    project = np.eye(2 * n)
    project[:n, :n] -= 1 / n
    S = project @ contact.S @ project
    return fo.ContactSystem.from_blocks(S[:n, :n], S[n:, :n], S[n:, n:], contact.x, dict(contact.bonded))


@settings(max_examples=40)
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 5),
    f=st.floats(0.05, 1.0),
    free=st.booleans(),
    simplify=st.booleans(),
    size=st.sampled_from([0.0, 0.05, 0.3, 2.0, 100.0]),
)
def test_the_shakedown_limit_against_a_linear_program(seed, nodes, f, free, simplify, size):
    rng = np.random.default_rng(seed)
    contact, most = random_system(rng, nodes), size * rng.uniform(0.5, 1.5, nodes)
    contact = freed(contact) if free else contact
    status, value = linprog_limit(contact, CYCLE, f, most)
    limit = fo.shakedown_limit(contact, CYCLE, f, slip_bound=most, simplify=simplify)
    assert limit.kind is {0: fo.LimitKind.FINITE, 2: fo.LimitKind.NO_SAFE_SLIP, 3: fo.LimitKind.UNBOUNDED}[status] and limit.residual <= 1e-9
    if status == 0:
        assert limit.load_factor == pytest.approx(value, rel=1e-7, abs=1e-8) and limit.bound == pytest.approx(value, rel=1e-7, abs=1e-8)
        assert (np.abs(limit.slip) <= most).all()
        guaranteed = fo.guaranteed_limit(contact, CYCLE, f, slip_bound=most, simplify=simplify)
        assert guaranteed.load_factor <= limit.load_factor * (1 + 1e-12) and (np.abs(guaranteed.slip) <= most).all()


@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), free=st.booleans(), size=st.sampled_from([0.05, 0.3, 2.0]), factor=st.floats(0.0, 2.0), simplify=st.booleans())
def test_safe_slips_keep_within_and_certificates_are_proofs(seed, free, size, factor, simplify):
    rng = np.random.default_rng(seed)
    contact, most, f = random_system(rng, 3), size * rng.uniform(0.5, 1.5, 3), 0.4
    contact = freed(contact) if free else contact
    status, value = linprog_limit(contact, CYCLE, f, most)
    safe = fo.safe_slip(contact, CYCLE, f, factor, slip_bound=most, simplify=simplify)
    assert (np.abs(safe.slip) <= most).all() and safe.residual <= 1e-9
    if status == 0 and abs(factor - value) < 1e-6:
        return
    assert safe.exists == (status == 0 and factor < value)
    (q0, p0), (q1, p1) = CYCLE.mean_reaction(contact), CYCLE.corner_reactions(contact)
    unit = f * p0.mean()
    reserve = (f * (p0 + factor * p1 + contact.B @ safe.slip) - np.abs(q0 + factor * q1 + contact.A @ safe.slip)).min() / unit
    assert reserve == pytest.approx(min(safe.margin, reserve), abs=1e-9)
    if safe.exists:
        return
    table = safe.certificate
    q, p = q0 + factor * q1, p0 + factor * p1
    work = (table.share * (table.direction * q[table.corner, table.node] + f * p[table.corner, table.node])).sum()
    assert work + np.abs(stress_of(contact, table, f)) @ most < 0


def test_the_safe_slip_has_the_largest_reserve_within_the_bound():
    contact, most, f, factor = random_system(np.random.default_rng(1), 4), 0.1, 0.5, 0.2
    rows, right = corner_rows(contact, CYCLE, f)
    rows, right = rows.reshape(-1, 5), right.ravel()
    right, rows[:, -1] = right - factor * rows[:, -1], f * CYCLE.mean_reaction(contact)[1].mean()  # the margin in place of the load factor
    answer = linprog(-np.eye(5)[-1], rows, right, bounds=[(-most, most)] * 4 + [(None, 1)])
    safe = fo.safe_slip(contact, CYCLE, f, factor, slip_bound=most)
    assert safe.margin == pytest.approx(-answer.fun, abs=1e-8)
    assert safe.margin < fo.safe_slip(contact, CYCLE, f, factor).margin - 1e-3


def test_without_any_slip_the_limit_is_the_first_onset():
    rng = np.random.default_rng(0)
    for _ in range(10):
        contact = random_system(rng, 4)
        first = fo.onset(contact, CYCLE, 0.6).slip.load_factor
        for simplify in (True, False):
            for ask in (fo.shakedown_limit, fo.guaranteed_limit):
                limit = ask(contact, CYCLE, 0.6, slip_bound=0.0, simplify=simplify)
                assert limit.load_factor == pytest.approx(first, rel=1e-9) and not limit.slip.any()


def test_a_false_denial_is_not_believed(monkeypatch):
    """The cyclic load alone is safe by slips within the bound, which cannot grow with the load: that proves no unbounded limit."""
    contact = random_system(np.random.default_rng(0), 3)
    assert np.isfinite(fo.shakedown_limit(contact, CYCLE, 0.4, slip_bound=1e3).load_factor)
    honest = policy._run

    def denies(problem, name):
        return honest(problem, name) if "margin" in problem.var_dict else "unbounded"

    monkeypatch.setattr(policy, "_run", denies)
    pressing = contact.with_bonded({"cyclic": (contact.A @ np.ones(3) * 1.0, np.full(3, 2.0) + contact.B @ np.ones(3))})
    with pytest.raises(fo.SolverError):
        fo.shakedown_limit(pressing, fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}]), 0.4, slip_bound=1e3)


@pytest.mark.parametrize("share", [1.0, 1e-3])
@pytest.mark.parametrize("stiff", [1.0, 1e6, 1e9])
@pytest.mark.parametrize("most", [[0.1, 0.4], [0.4, 0.1]])
def test_a_slide_within_the_bound_is_not_lost_beside_a_stiff_node(most, stiff, share):
    """Two nodes of a sliding body reach v_0 - v_1 = 0.5 within their bounds only by a slide, and so carry 1.5.

    Node 1 has a share of the forces of node 0, and slips in proportion. Neither this nor the third node changes the limit.
    """
    forces = np.array([1.0, share, 1.0])
    A = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, stiff]]) * np.outer(forces, forces)
    bonded = {"P": (np.zeros(3), forces), "Q": (forces * [-1.0, 1.0, 0.1], np.zeros(3))}
    contact = fo.ContactSystem.from_blocks(A, np.zeros((3, 3)), np.diag([2.0, 2 * share**2, stiff]), [0.0, 1.0, 2.0], bonded)
    cycle, bound = fo.LoadCycle({"P": 1.0}, [{}, {"Q": 1.0}]), [*most, 1.0] / forces
    assert fo.shakedown_limit(contact, cycle, 1.0, slip_bound=bound).load_factor == pytest.approx(1.5, rel=1e-8)
