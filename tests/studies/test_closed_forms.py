"""Closed-form limits against published instances and against linear programs written from Coulomb's
law, every corner in full."""

import numpy as np
import pytest

import frictopt as fo
from helpers.systems import CYCLE, FIRST_PAIR, linprog_limit, on_both_bounds, system
from helpers.two_nodes import two_node_limits
from studies.validation.closed_forms import single_node_limit, uncoupled_limit

EXACT = {"rel": 1e-9, "abs": 1e-12}


def programs(A, B, f, **load):
    """Shakedown limit, and least load at which some node is on both its bounds at a safe slip, by
    linear programs with every corner."""
    contact = system(A, B, **load)
    most, either = linprog_limit(contact, CYCLE, f)[1], on_both_bounds(contact, CYCLE, f)
    return most, np.fmin(most, np.nanmin(np.append(either[:, 0], most))) if most == most else np.nan


def random_load(rng, nodes):
    shape = None if nodes == 1 else nodes
    return {
        "q0": rng.normal(scale=0.3, size=shape),
        "p0": rng.uniform(0.2, 2, shape),
        "q1": rng.normal(size=shape),
        "p1": rng.normal(size=shape),
        "f": rng.uniform(0.1, 1, shape),
    }


def stiff(rng, nodes):
    root = rng.normal(size=(nodes, nodes))
    return root @ root.T + 0.2 * np.eye(nodes)


def random_pairs(rng, count):
    """Coupled pairs of nodes below the critical friction, found by rejection."""
    pairs = []
    while len(pairs) < count:
        pair = {"A": stiff(rng, 2), "B": rng.normal(size=(2, 2)), **random_load(rng, 2)}
        mixed = [
            pair["A"] + np.diag([s, t]) * pair["f"] @ pair["B"] for s in (1, -1) for t in (1, -1)
        ]
        if all(np.linalg.det(m) > 0 and np.diag(m).min() > 0 for m in mixed):
            pairs.append(pair)
    return pairs


def test_single_node_equals_the_linear_program():
    rng = np.random.default_rng(1)
    regimes = set()
    for _ in range(120):
        node = {"A": rng.uniform(0.2, 3), **random_load(rng, 1)}
        node["B"] = 0.98 * rng.uniform(-1, 1) * node["A"] / node["f"]
        limit = single_node_limit(**node)
        assert limit == pytest.approx(programs(**node)[0], **EXACT, nan_ok=True)
        regimes.add((bool(np.isnan(limit)), bool(abs(node["q1"]) > node["f"] * abs(node["p1"]))))
    assert len(regimes) == 4


def test_two_nodes_equal_the_linear_programs():
    regimes = set()
    for pair in random_pairs(np.random.default_rng(2), 60):
        lower, upper = two_node_limits(**pair)
        assert (upper, lower) == pytest.approx(programs(**pair), **EXACT, nan_ok=True)
        share = lower / upper
        regimes.add(
            "nothing safe"
            if np.isnan(share)
            else "zero"
            if share == 0
            else "apart"
            if share < 0.999
            else "equal"
        )
    assert regimes == {"nothing safe", "zero", "apart", "equal"}


@pytest.mark.parametrize("nodes", [1, 3, 6])
@pytest.mark.parametrize("coupled", [False, True])
def test_proportional_coupling_equals_the_linear_program(nodes, coupled):
    rng = np.random.default_rng(30 + nodes)
    for _ in range(10):
        load, A = random_load(rng, nodes), stiff(rng, nodes)
        d = coupled * 0.95 * rng.uniform(-1, 1, nodes) / load["f"]
        limit = uncoupled_limit(**load, d=d)
        assert (limit, limit) == pytest.approx(
            programs(A, d[:, None] * A, **load), **EXACT, nan_ok=True
        )


def test_limits_are_infinite_without_cyclic_load():
    assert (
        uncoupled_limit(0, 1, 0, 0, 0.5) == single_node_limit(1, 0.3, 0.1, 1, 0, 0, 0.5) == np.inf
    )
    assert two_node_limits(*FIRST_PAIR[:4], 0, 0, 0.6) == (np.inf, np.inf)


def test_a_mean_load_on_the_bound_leaves_a_limit_of_zero_not_none():
    assert not any(
        fo.onset(system(1, 0, q0, 1, 1, 0), CYCLE, 0.3).slip.load_factor for q0 in (0.3, 0.1 + 0.2)
    )
    assert single_node_limit(A=1, B=1, q0=0.1 + 0.2, p0=0.3, q1=1, p1=0, f=0.5) == 0
