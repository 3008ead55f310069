"""Dissipation of single nodes: instances, marches in small increments, energy, invariances."""

import numpy as np
import pytest

from frictopt.errors import ModelError
from frictopt.reference import single_node_dissipation, single_node_limit
from marching import last_cycle

FIRST = {"A": 2.0, "B": 0.5, "q0": 0.1, "p0": 1.0, "q1": 1.0, "p1": 0.2, "f": 0.4}
ORDER = ("A", "B", "q0", "p0", "q1", "p1", "f")


def as_tuple(node):
    return tuple(node[name] for name in ORDER)


def lift_off(node):
    """Load factor at which the pressure falls to zero at a corner."""
    return (node["A"] * node["p0"] - node["B"] * node["q0"]) / abs(node["A"] * node["p1"] - node["B"] * node["q1"])


def random_nodes(rng, count):
    """Nodes that slip to and fro before they lift off."""
    nodes = []
    while len(nodes) < count:
        A, p0, f = rng.uniform(0.3, 3), rng.uniform(0.3, 2), rng.uniform(0.1, 0.9)
        node = {"A": A, "B": 0.9 * rng.uniform(-1, 1) * A / f, "q0": rng.normal(scale=0.3), "p0": p0, "q1": rng.normal(), "p1": rng.normal(), "f": f}
        if abs(node["q1"]) > f * abs(node["p1"]) and lift_off(node) > 1.1 * single_node_limit(**node) > 0:
            nodes.append(node)
    return nodes


def between(node, share):
    """Load factor between the limit and lift-off, at a share of the way of at most three limits."""
    limit = single_node_limit(**node)
    return limit + share * (min(3 * limit, lift_off(node)) - limit)


def test_single_node_dissipation_is_what_marches_converge_to_from_every_start():
    starts = [[-3.0], [-0.2], [0.0], [0.4], [5.0]]
    errors = []
    for node in random_nodes(np.random.default_rng(1), 16):
        lam = between(node, 0.6)
        exact = single_node_dissipation(**node, load_factor=lam)
        coarse, fine = (last_cycle(as_tuple(node), lam, starts, increments, cycles=2).work for increments in (40, 320))
        assert np.ptp(fine) < 1e-9 * exact
        assert fine[0] == pytest.approx(exact, rel=1e-3)
        errors.append(np.abs([coarse[0] / exact - 1, fine[0] / exact - 1]))
    order = np.mean(np.diff(-np.log(errors), axis=1)) / np.log(8)  # the mean, since slip sets in at a random place of its increment
    assert order == pytest.approx(2, abs=0.4)


def test_single_node_dissipation_is_the_work_of_the_load_on_the_slip():
    for node in random_nodes(np.random.default_rng(2), 100):
        A, B, q0, p0, q1, p1, f = as_tuple(node)
        for share in (0.1, 0.9):
            lam = between(node, share)
            ahead = (lam * abs(q1 + f * p1) - q0 - f * p0) / (A + f * B)
            behind = (f * p0 - q0 - lam * abs(q1 - f * p1)) / (A - f * B)
            middle = (ahead + behind) / 2
            forward = -((A + f * B) * middle + q0 + f * p0) / (lam * (q1 + f * p1))  # the swing s half-way through either passage
            backward = (f * p0 - q0 - (A - f * B) * middle) / (lam * (q1 - f * p1))
            supplied = lam * q1 * (backward - forward) * (ahead - behind)
            assert single_node_dissipation(**node, load_factor=lam) == pytest.approx(supplied, rel=1e-9)


def test_a_node_dissipates_nothing_up_to_its_limit_and_starts_from_zero():
    for node in random_nodes(np.random.default_rng(3), 30):
        limit = single_node_limit(**node)
        assert single_node_dissipation(**node, load_factor=0) == single_node_dissipation(**node, load_factor=0.999999 * limit) == 0
        little, more = (single_node_dissipation(**node, load_factor=between(node, share)) for share in (1e-6, 2e-6))
        assert little > 0
        assert more == pytest.approx(2 * little, rel=1e-4)


def test_lift_off_ends_the_closed_form_where_a_march_in_full_contact_runs_out_of_pressure():
    for node in random_nodes(np.random.default_rng(4), 20):
        lift = lift_off(node)
        below, above = (last_cycle(as_tuple(node), factor * lift, [[0.0]], 30, cycles=2).least_pressure[0] for factor in (0.999, 1.001))
        assert above < 0 < below
        assert single_node_dissipation(**node, load_factor=0.999 * lift) > 0
        with pytest.raises(ModelError, match=r"load_factor: .*lifts off at one corner, give at most"):
            single_node_dissipation(**node, load_factor=1.001 * lift)


def test_a_node_whose_shear_is_small_lifts_off_at_its_limit():
    node = FIRST | {"q1": 0.1, "p1": 1.0}
    limit = single_node_limit(**node)
    assert limit == pytest.approx(lift_off(node), rel=1e-12)
    assert single_node_dissipation(**node, load_factor=(1 - 1e-9) * limit) == 0
    with pytest.raises(ModelError, match=f"load_factor: .*give at most {limit:g}"):
        single_node_dissipation(**node, load_factor=1.01 * limit)


def test_a_node_between_slip_and_lift_off_never_dissipates():
    node = {"A": 1.0, "B": 0.0, "q0": 0.0, "p0": 1.0, "q1": 0.5, "p1": 1.0, "f": 0.5}  # |q1| = f |p1|
    assert single_node_limit(**node) == lift_off(node) == 1
    assert single_node_dissipation(**node, load_factor=1.0) == single_node_dissipation(**node, load_factor=1 + 1e-14) == 0
