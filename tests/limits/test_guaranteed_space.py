"""The guaranteed limit in space against independent methods.

The methods are closed forms, one cone program over raw slips for each node, plane contacts turned
into space, and transients on both sides of the limit.
"""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.guaranteed import check
from helpers.spatial import random_contact
from studies.validation.followed import random_contact as centred

# The cone programs of the comparison may be inaccurate.
pytestmark = pytest.mark.filterwarnings("ignore:Solution may be inaccurate")

TIGHT = {"tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11, "tol_feas": 1e-11}


def state_of(q1, p1, f):
    """Least mean pressure rho and shear c of a node, by a cone program of the node."""
    r, c = cp.Variable(), cp.Variable(2)
    cones = [cp.norm(q + c) <= f * (r + p) for q, p in zip(q1, p1, strict=True)]
    cp.Problem(cp.Minimize(r), cones).solve(solver="CLARABEL", **TIGHT)
    return float(r.value), c.value


def least_of_node(contact, loads, f, node, *, most=None, user_rows=()):
    """The least load factor at which a node is critical, by a cone program over raw slips.

    The value is inf if the node is never critical, or only lifts off.
    """
    (q0, p0) = loads.mean_reaction(contact)
    (q1, p1) = loads.corner_reactions(contact)
    n = contact.nodes
    rho, c = state_of(q1[:, node], p1[:, node], f[node])
    if rho <= (-p1[:, node]).max() + 1e-8:
        return np.inf
    v, lam = cp.Variable(2 * n), cp.Variable(nonneg=True)
    q, p = cp.reshape(contact.A @ v, (n, 2), order="F"), contact.B @ v
    rows = [p0[node] + p[node] == lam * rho, q0[node] + q[node] == lam * c]
    for k in range(len(q1)):
        rows += [
            cp.norm(q0[j] + lam * q1[k, j] + q[j]) <= f[j] * (p0[j] + lam * p1[k, j] + p[j])
            for j in range(n)
            if j != node
        ]
    slip = cp.reshape(v, (n, 2), order="F")
    rows += [] if most is None else [cp.norm(slip[j]) <= most for j in range(n)]
    problem = cp.Problem(cp.Minimize(lam), rows + [row(slip) for row in user_rows])
    problem.solve(solver="CLARABEL", **TIGHT)
    return float(lam.value) if problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE) else np.inf


@pytest.mark.parametrize("seed", few(range(8)))
def test_one_cone_program_for_each_node(seed):
    contact, loads, f = centred(seed, most=5)
    least = np.array([least_of_node(contact, loads, f, node) for node in range(contact.nodes)])
    for simplify in (True, False):
        limit = fo.guaranteed_limit(contact, loads, f, simplify=simplify)
        assert limit.load_factor == pytest.approx(
            min(least.min(), limit.shakedown.load_factor), rel=1e-6, abs=1e-8
        )
        check(limit)
        table = limit.to_frame()
        assert (table["load_factor"] <= least * (1 + 1e-6) + 1e-8).all() and not limit.proven
        solved = table[table["how"] == "solved"]
        assert solved["load_factor"].to_numpy() == pytest.approx(
            least[solved["node"]], rel=1e-6, abs=1e-8
        )
    assert set(table["how"]) <= {"solved", "never critical", "one corner alone governs"}


@pytest.mark.parametrize("seed", range(4))
def test_a_node_that_only_lifts_off_is_never_critical(seed):
    """The cyclic loads put no shear force on the first node, so that one corner governs it."""
    contact, loads, f = centred(seed, most=5)
    without_shear = {}
    for case in {case for corner in loads.corners for case in corner}:
        q, p = contact.bonded[case]
        without_shear[case] = q * (np.arange(len(q)) > 0)[:, None], p
    contact = contact.with_bonded(without_shear)
    assert least_of_node(contact, loads, f, 0) == np.inf
    first = fo.guaranteed_limit(contact, loads, f).to_frame().iloc[0]
    assert first["how"] == "one corner alone governs"


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 5, 11])
def test_one_node_that_its_equations_fix(seed):
    """Three equations give the critical slip and the load factor of one node.

    The program has no other freedom, and its solver may leave few digits of the solution.
    """
    S = [[1.76, 0.21, 0.26], [0.21, 1.07, 0.52], [0.26, 0.52, 0.74]]
    m = [0.7, -0.8, -0.3]
    a = [-0.2, 0.1, -1.6]
    rng = np.random.default_rng(seed)
    m, a = (np.array(load) + (0.1 * rng.normal(size=3) if seed else 0.0) for load in (m, a))
    node = fo.ContactSystem(S, [[0, 0, 0]], {"m": m, "a": a})
    loads = fo.LoadCycle({"m": 1.0}, [{"a": 1.0}, {"a": -1.0}])
    f, shear = 0.1, np.linalg.norm(a[:2])
    # The rates c and rho fulfil `|c + a_t| = f (rho + a_n)` and `|c - a_t| = f (rho - a_n)`.
    needs = np.r_[f * a[2] * a[:2] / shear, shear / f]
    slip, lam = np.split(np.linalg.solve(np.c_[np.array(S)[:, :2], -needs], -m), [2])
    limit = fo.guaranteed_limit(node, loads, f)
    if lam > 0:
        assert limit.node == 0
        assert limit.load_factor == pytest.approx(lam[0], rel=1e-6)
        assert limit.slip[0] == pytest.approx(slip, rel=1e-6)
        check(limit)
    else:
        assert limit.node is None
        assert np.isnan(limit.load_factor) == np.isnan(limit.shakedown.load_factor)


@settings(max_examples=few(10))
@given(seed=st.integers(0, 10**6))
def test_one_node_and_two_corners_in_closed_form(seed):
    """The critical state fixes the slip: `lam = (p0 - B A^-1 q0) / (rho - B A^-1 c)`. At this slip
    the node is safe by itself."""
    rng = np.random.default_rng(seed)
    contact, f = random_contact(rng, 1), float(rng.uniform(0.2, 0.8))
    contact = contact.with_bonded(
        {name: (contact.bonded[name][0], 0 * contact.bonded[name][1]) for name in "abc"}
    )
    loads = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}])
    (q0, p0), (q1, _) = loads.mean_reaction(contact), loads.corner_reactions(contact)
    reach = np.linalg.solve(contact.A, contact.B[0])
    lift = p0[0] - reach @ q0[0]
    drop = np.linalg.norm(q1[0, 0] - q1[1, 0]) / (2 * f) + reach @ (q1[0, 0] + q1[1, 0]) / 2
    limit = fo.guaranteed_limit(contact, loads, f)
    critical = lift / drop if drop > 0 and lift > 0 else np.inf
    if limit.node is not None:
        assert limit.load_factor == pytest.approx(critical, rel=1e-8) and limit.corners == (0, 1)
        check(limit)
    elif np.isfinite(limit.load_factor):
        assert critical >= limit.load_factor * (1 - 1e-8)


def test_what_a_limit_of_none_means_and_what_one_overload_leaves():
    contact, loads, f = centred(192, most=4)
    limit = fo.guaranteed_limit(contact, loads, f)
    assert limit.load_factor == 0
    assert f"residual slip of up to {limit.largest_slip:.3g}" in limit.reason
    assert "after_overload" in limit.reason
    q, p = limit.reactions
    assert np.abs(q[:, limit.node]).max() < 1e-8 and np.abs(p[:, limit.node]).max() < 1e-8
    after = fo.after_overload(limit)
    left = np.linalg.norm(
        fo.march(contact, loads, f, limit.shakedown.load_factor, cycles=1).slip[-1], axis=1
    ).max()
    assert left < limit.largest_slip
    assert after.load_factor > 0
    assert after.largest_slip <= left * (1 + 1e-9)
    assert after.load_factor == pytest.approx(
        fo.guaranteed_limit(contact, loads, f, slip_bound=left).load_factor, rel=1e-7
    )
    bounded = fo.guaranteed_limit(contact, loads, f, slip_bound=0.5 * left)
    assert fo.after_overload(bounded, limit.shakedown.load_factor).load_factor == pytest.approx(
        bounded.load_factor, rel=1e-7
    )
    assert bounded.load_factor > after.load_factor
    # Nothing slips in so small an overload.
    assert fo.after_overload(limit, 0.5 * limit.shakedown.load_factor).largest_slip == 0
