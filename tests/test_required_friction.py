import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import frictopt as fo
from systems import CYCLE, random_system, system


def brute_force(contact, cycle, load_factor):
    """Least friction by bisection on the feasibility of all rows of all corners in raw slips; inf if none up to 1000 will do."""
    (q0, p0), (q1, p1) = cycle.mean_reaction(contact), cycle.corner_reactions(contact)
    q, p = q0 + load_factor * q1, p0 + load_factor * p1

    def safe(f):
        rows = np.vstack([np.vstack([contact.A - f * contact.B, -contact.A - f * contact.B, -contact.B])] * len(q))
        right = np.concatenate([np.concatenate([f * pk - qk, f * pk + qk, pk]) for qk, pk in zip(q, p, strict=True)])
        return linprog(np.zeros(contact.nodes), rows, right, bounds=(None, None)).status == 0

    if not safe(1e3):
        return np.inf
    least, most = 0.0, 1e3
    while most - least > 1e-7 * most + 1e-9:
        middle = np.sqrt(least * most) if least > 1e-4 else (least + most) / 2
        least, most = (least, middle) if safe(middle) else (middle, most)
    return most


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), nodes=st.integers(1, 5), factor=st.floats(0.01, 4.0), coupling=st.sampled_from([0.0, 0.5, 1.0]))
def test_required_friction_by_brute_force(seed, nodes, factor, coupling):
    contact = random_system(np.random.default_rng(seed), nodes, coupling=coupling)
    required = fo.required_friction(contact, CYCLE, factor)
    expected = brute_force(contact, CYCLE, factor)
    if expected < 500:
        assert required.friction == pytest.approx(expected, rel=1e-5, abs=1e-6)
    elif np.isfinite(required.friction):  # more friction than the brute force tries
        assert required.friction > 500
    assert required.residual <= 1e-9


def test_it_is_proven_from_both_sides(punch, paper_cycle):
    contact = punch(40)
    required = fo.required_friction(contact, paper_cycle, 1.5)
    (q0, p0), (q1, p1) = paper_cycle.mean_reaction(contact), paper_cycle.corner_reactions(contact)
    q, p = q0 + 1.5 * q1 + contact.A @ required.slip, p0 + 1.5 * p1 + contact.B @ required.slip
    assert (np.abs(q) <= required.friction * p + 1e-12 * p.mean()).all()
    less, table = required.too_little, required.mechanism
    assert (1 - 1e-5) * required.friction < less < required.friction
    node, corner, sense, share = (table[name].to_numpy() for name in ("node", "corner", "direction", "share"))
    net, total = np.zeros((2, contact.nodes))
    np.add.at(net, node, sense * share)
    np.add.at(total, node, share)
    assert np.abs(contact.A @ net + less * contact.B.T @ total).max() < 1e-9 * np.abs(contact.A).max()
    work = sense * (q0 + 1.5 * q1[corner])[np.arange(len(node)), node] + less * (p0 + 1.5 * p1[corner])[np.arange(len(node)), node]
    assert share @ work < 0
    assert fo.shakedown_limit(contact, paper_cycle, required.friction).load_factor == pytest.approx(1.5, rel=1e-5)


def test_where_no_friction_is_needed():
    still = system(np.eye(2), np.zeros((2, 2)), 0.3, 1.0, 0.0, 0.1)
    required = fo.required_friction(still, CYCLE, 1.0)
    assert required.friction == 0.0 and np.isnan(required.too_little) and required.mechanism.empty
    assert np.allclose(required.slip, -0.3) and "none is needed" in required.reason


def test_where_no_friction_is_enough():
    """The second node is pulled at one corner, and slip presses one node only as much as it unloads the other."""
    B = np.array([[0.5, -0.5], [-0.5, 0.5]])
    pulled = system(np.eye(2), B, 0.0, (1.0, 1.0), 0.2, (0.0, 3.0))
    required = fo.required_friction(pulled, CYCLE, 1.0)
    assert required.friction == np.inf and np.isnan(required.slip).all()
    assert "no friction is enough" in required.reason and "x = 0, 1" in required.reason
    table = required.mechanism
    assert set(table["direction"]) == {0} and table["share"].to_numpy() == pytest.approx([0.5, 0.5])
    assert dict(zip(table["node"], table["corner"], strict=True))[1] == 0
    assert np.isfinite(fo.required_friction(pulled, CYCLE, 0.6).friction)


def test_friction_next_to_none_is_no_answer():
    hardly = system(np.eye(1), np.zeros((1, 1)), 0.0, 1.0, 1e-7, 0.0)
    with pytest.raises(fo.SolverError, match="is enough and 0 is not"):
        fo.required_friction(hardly, CYCLE, 1.0)


def test_pressures_within_rounding_of_zero_are_no_answer():
    bare = system(np.eye(2), np.zeros((2, 2)), 0.0, (1.0, 0.0), 0.2, 0.0)
    with pytest.raises(fo.SolverError, match="the best residual slip leaves a pressure of"):
        fo.required_friction(bare, CYCLE, 1.0)
