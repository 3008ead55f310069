"""Dissipation of single nodes and of sliders in parallel and in series against the exact path, and
where it begins and ends."""

import numpy as np
import pytest

import frictopt as fo
from helpers.systems import CYCLE, system
from studies.validation.closed_forms import (
    masing_dissipation,
    single_node_dissipation,
    single_node_limit,
)

F = 0.3
FIRST = {"A": 2.0, "B": 0.5, "q0": 0.1, "p0": 1.0, "q1": 1.0, "p1": 0.2, "f": 0.4}


def contact_of(node):
    return system(**{name: value for name, value in node.items() if name != "f"})


def lift_off(node):
    """Load factor at which the pressure falls to zero at a corner."""
    return (node["A"] * node["p0"] - node["B"] * node["q0"]) / abs(
        node["A"] * node["p1"] - node["B"] * node["q1"]
    )


def random_nodes(rng, count):
    """Nodes that slip to and fro before they lift off."""
    nodes = []
    while len(nodes) < count:
        A, p0, f = rng.uniform(0.3, 3), rng.uniform(0.3, 2), rng.uniform(0.1, 0.9)
        node = {
            "A": A,
            "B": 0.9 * rng.uniform(-1, 1) * A / f,
            "q0": rng.normal(scale=0.3),
            "p0": p0,
            "q1": rng.normal(),
            "p1": rng.normal(),
            "f": f,
        }
        if (
            abs(node["q1"]) > f * abs(node["p1"])
            and lift_off(node) > 1.1 * single_node_limit(**node) > 0
        ):
            nodes.append(node)
    return nodes


def between(node, share):
    """Load factor between the limit and lift-off, at a share of the way of at most three limits."""
    limit = single_node_limit(**node)
    return limit + share * (min(3 * limit, lift_off(node)) - limit)


def test_single_node_dissipation_is_that_of_the_exact_path_from_every_start():
    for node in random_nodes(np.random.default_rng(1), 16):
        lam = between(node, 0.6)
        work = [
            fo.steady_state(
                contact_of(node), CYCLE, node["f"], lam, initial_slip=[start]
            ).dissipation
            for start in (-3.0, -0.2, 0.4, 5.0)
        ]
        assert work == pytest.approx(
            [single_node_dissipation(**node, load_factor=lam)] * 4, rel=1e-9
        )


def test_a_node_dissipates_nothing_up_to_its_limit_and_starts_from_zero():
    for node in random_nodes(np.random.default_rng(3), 30):
        limit = single_node_limit(**node)
        assert (
            single_node_dissipation(**node, load_factor=0)
            == single_node_dissipation(**node, load_factor=0.999999 * limit)
            == 0
        )
        little, more = (
            single_node_dissipation(**node, load_factor=between(node, share))
            for share in (1e-6, 2e-6)
        )
        assert little > 0
        assert more == pytest.approx(2 * little, rel=1e-4)


def test_lift_off_ends_the_closed_form_where_the_exact_path_opens():
    for node in random_nodes(np.random.default_rng(4), 20):
        lift = lift_off(node)
        below, above = (
            fo.steady_state(contact_of(node), CYCLE, node["f"], factor * lift).open.any()
            for factor in (0.999, 1.001)
        )
        assert above and not below and single_node_dissipation(**node, load_factor=0.999 * lift) > 0
        assert np.isnan(single_node_dissipation(**node, load_factor=1.001 * lift))


def test_a_node_whose_shear_is_small_lifts_off_at_its_limit():
    node = FIRST | {"q1": 0.1, "p1": 1.0}
    limit = single_node_limit(**node)
    assert limit == pytest.approx(lift_off(node), rel=1e-12)
    assert single_node_dissipation(**node, load_factor=(1 - 1e-9) * limit) == 0
    assert np.isnan(single_node_dissipation(**node, load_factor=1.01 * limit))


def test_a_node_between_slip_and_lift_off_never_dissipates():
    node = {
        "A": 1.0,
        "B": 0.0,
        "q0": 0.0,
        "p0": 1.0,
        "q1": 0.5,
        "p1": 1.0,
        "f": 0.5,
    }  # |q1| = f |p1|
    assert single_node_limit(**node) == lift_off(node) == 1
    assert (
        single_node_dissipation(**node, load_factor=1.0)
        == single_node_dissipation(**node, load_factor=1 + 1e-14)
        == 0
    )


def test_masing_dissipation_is_that_of_the_exact_path():
    rng = np.random.default_rng(8)
    k, bound, X = rng.uniform(0.5, 3, 3), rng.uniform(0.05, 1, 3), 0.6
    sliders = system(np.diag(k), np.zeros((3, 3)), 0, bound / F, -k, 0)
    for start in rng.uniform(-1, 1, size=(4, 3)):
        steady = fo.steady_state(sliders, CYCLE, F, X, initial_slip=start)
        assert (
            steady.dissipation == pytest.approx(masing_dissipation(k, bound, X), rel=1e-12)
            and steady.dissipation > 0
        )


@pytest.mark.parametrize("n", [0.7, 1.0, 2.4, 3.0, 3.9])
def test_rod_closed_forms_equal_the_exact_path_for_any_number_of_nodes(n):
    EA, tau, h = 2.0, 0.7, 0.4
    rod, cycle = (
        fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(5, EA, h)),
        fo.LoadCycle({"pressure": tau / F}, [{"force": -1.0}, {"force": 1.0}]),
    )
    F0 = n * tau * h
    for start in (np.zeros(5), *np.random.default_rng(9).uniform(-0.4, 0.4, size=(2, 5))):
        path = fo.march(rod, cycle, F, F0, initial_slip=start, cycles=6)
        assert path.cycle_work[-1].sum() == pytest.approx(
            fo.reference.rod_dissipation(F0, EA, tau, h), rel=1e-12, abs=1e-12
        )
        if not start.any():
            forces = F0 - tau * h * np.arange(
                1, int(n) + 1
            )  # in the rod beside each node that slips
            assert path.slip[-1, 0] == pytest.approx(h / EA * forces.sum(), rel=1e-12, abs=1e-12)


def test_rod_approaches_the_continuum_at_second_order():
    F0, EA, tau = 1.3, 2.0, 0.7
    n = np.array([8, 64, 512])
    works = [
        1
        - fo.reference.rod_dissipation(F0, EA, tau, F0 / (tau * k))
        / fo.reference.rod_dissipation(F0, EA, tau)
        for k in n
    ]
    assert works == pytest.approx(1 / n**2, rel=1e-8)
