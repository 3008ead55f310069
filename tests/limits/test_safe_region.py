import itertools
from dataclasses import replace
from importlib import import_module
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.refused import refused
from helpers.separation import open_in_space
from helpers.spatial import random_contact
from helpers.systems import lifts, linprog_limit, random_system, stress_of, unit_nodes
from studies.validation.fuzz.cases import random_case
from studies.validation.polygons import polygon_limit

MEAN = {"mean": 1.0}
CIRCLE = [{"x": float(np.cos(t)), "y": float(np.sin(t))} for t in np.arange(5)]


def random_region(seed, loads=("a", "b")):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, int(rng.integers(1, 7)), loads=("mean", "a", "b", "x", "y"))
    f = rng.uniform(0.2, 0.9, size=contact.nodes)
    return contact, f, fo.safe_region(contact, MEAN, loads, f)


def reach(vertices, direction):
    """Largest factor of a direction in the polygon of the vertices, by its edges alone."""
    factors = [np.inf]
    for one, other in itertools.pairwise(vertices):
        normal = np.array([other[1] - one[1], one[0] - other[0]])
        if normal @ direction > 0:
            factors.append(normal @ one / (normal @ direction))
    return min(factors)


@settings(max_examples=few(10))
@given(
    seed=st.integers(0, 10**6),
    loads=st.sampled_from([("a", "b"), ("a", CIRCLE), (CIRCLE, [{"b": 1.0}])]),
)
def test_the_polygon_is_the_limit_along_every_ray_by_another_program(seed, loads):
    contact, f, region = random_region(seed, loads)
    status = linprog_limit(contact, region.cycle(0.0, 0.0), f)[0]
    assert (len(region.vertices) == 0) == (status == 2)
    assert region.gap == 0 and np.array_equal(region.vertices, region.outer)
    if len(region.vertices) and not region.unlimited:
        rng = np.random.default_rng(seed)
        rays = np.abs([*rng.normal(size=(6, 2)), [1.0, 0.0], [0.0, 1.0], *region.vertices])
        for ray in rays[np.abs(rays).max(axis=1) > 0]:
            assert linprog_limit(contact, region.cycle(*ray), f)[1] == pytest.approx(
                reach(region.vertices, ray), rel=1e-7, abs=1e-9
            )


@settings(max_examples=few(10))
@given(seed=st.integers(0, 10**6))
@example(seed=186)  # a node that slips and opens at one corner
def test_vertices_are_a_convex_chain_and_each_side_is_its_mechanism(seed):
    contact, f, region = random_region(seed)
    if not len(region.vertices) or region.unlimited:
        return
    assert len(region.mechanisms) == len(region.sides) == len(region.vertices) - 1
    ways = np.diff(region.vertices, axis=0)
    assert (ways[:-1, 0] * ways[1:, 1] - ways[:-1, 1] * ways[1:, 0] > 0).all()
    (q0, p0) = contact.reaction(MEAN)
    units = [
        region.cycle(1.0, 0.0).corner_reactions(contact),
        region.cycle(0.0, 1.0).corner_reactions(contact),
    ]
    for side, table in zip(region.sides.itertuples(), region.mechanisms, strict=True):
        node, corner, sense, share = (
            table[name].to_numpy() for name in ("node", "corner", "direction", "share")
        )
        lift = lifts(table, f)
        resistance = share @ (sense * q0[node] + lift * p0[node])
        drives = [
            -share @ (sense * q[corner, node] + lift * p[corner, node]) / resistance
            for q, p in units
        ]
        assert np.allclose(drives, [side.a, side.b], rtol=1e-6, atol=1e-8)
        assert np.abs(stress_of(contact, table, f)).max() < 1e-7 * np.abs(contact.A).max()


def test_without_a_mean_load_only_zero_is_safe():
    region = fo.safe_region(
        random_system(np.random.default_rng(0), 3, loads=("mean", "a", "b")), {}, ["a", "b"], 0.5
    )
    assert np.array_equal(region.vertices, np.zeros((2, 2)))
    assert region.contains(0.0, 0.0)
    assert not region.contains(1e-6, 0.0)
    assert region.reason.startswith("no amplitudes above 0 are safe: ")


def test_a_load_without_room_leaves_the_other_one_its_limit():
    """The mean load brings the first node to its bound; the second load shears the other one."""
    loads = {
        "P": ([0.5, 0.0], [1.0, 1.0]),
        "a": ([1.0, 0.0], [0.0, 0.0]),
        "b": ([0.0, 1.0], [0.0, 0.0]),
    }
    contact = fo.ContactSystem.from_blocks(
        np.diag([0.0, 1.0]), np.zeros((2, 2)), np.eye(2), [0.0, 1.0], loads
    )
    region = fo.safe_region(contact, {"P": 1.0}, ["a", "b"], 0.5)
    assert region.vertices == pytest.approx(np.array([[0.0, 0.0], [0.0, 0.5]]), abs=1e-9)
    assert region.contains(0.0, 0.49)
    assert not region.contains(0.0, 0.51)
    assert not region.contains(1e-6, 0.1)


@pytest.mark.parametrize("tolerance", [0.1, 1e-3])
def test_shear_along_both_tangents_of_a_node_is_safe_within_a_circle(tolerance):
    node = fo.ContactSystem(
        np.eye(3), np.zeros((1, 3)), {"P": [0, 0, 2.0], "Q": [0.8, 0.6, 0], "R": [-1.2, 1.6, 0]}
    )
    region = fo.safe_region(node, {"P": 1.0}, ["Q", "R"], 0.5, tolerance=tolerance)
    size = [1.0, 2.0]  # of both shears, across each other
    assert np.linalg.norm(region.vertices * size, axis=1) == pytest.approx(1.0, abs=1e-8)
    beyond = np.linalg.norm(region.outer * size, axis=1)
    assert beyond.min() > 1 - 1e-8
    assert beyond.max() <= 1 / (1 - tolerance)
    assert 0 < region.gap <= tolerance
    normals = region.sides[["a", "b"]].to_numpy() / size
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-8)
    assert region.sides["bound"].to_numpy() == pytest.approx(1.0)
    assert len(region.outer) == len(region.sides) + 1 == len(region.vertices) + 1
    for angle in np.linspace(0, np.pi / 2, 7):
        ray = np.array([np.cos(angle), np.sin(angle)]) / size
        assert region.contains(*(1 - tolerance) * ray) and not region.contains(*(1 + 1e-7) * ray)
    assert f"up to {region.gap:.1e} apart" in region.reason


@pytest.mark.parametrize("seed", few(range(2)))
def test_in_space_every_ray_ends_between_both_polygons(seed):
    """The end of the ray is a limit by polygons around the friction circles, over raw slips."""
    rng = np.random.default_rng(seed)
    contact, f = random_contact(rng, 3), rng.uniform(0.3, 0.8, 3)
    region = fo.safe_region(
        contact, {"mean": 1.0}, ["a", [{"b": 1.0}, {"c": -0.5}]], f, tolerance=0.02
    )
    for ray in np.abs(rng.normal(size=(4, 2))):
        limit = polygon_limit(contact, region.cycle(*ray), f)
        assert (
            reach(region.vertices, ray) * (1 - 1e-7)
            <= limit
            <= reach(region.outer, ray) * (1 + 1e-7)
        )
        assert reach(region.outer, ray) <= reach(region.vertices, ray) / (1 - region.gap) * (
            1 + 1e-7
        )


def test_in_space_open_nodes_stay_open():
    contact, _, limit = open_in_space(1)
    region = fo.safe_region(
        contact, {"mean": 1.0}, ["a", [{"b": 0.7, "c": 0.2}]], 0.6, tolerance=0.1
    )
    assert limit.open.any() and len(region.vertices) > 1 and region.gap <= 0.1
    for ray in ([1.0, 0.3], [0.2, 1.0]):
        other = fo.shakedown_limit(contact, region.cycle(*ray), 0.6).load_factor
        assert (
            reach(region.vertices, ray) * (1 - 1e-7)
            <= other
            <= reach(region.outer, ray) * (1 + 1e-7)
        )


def test_a_curved_region_is_drawn_with_its_outer_polygon():
    node = fo.ContactSystem(
        np.eye(3), np.zeros((1, 3)), {"P": [0, 0, 2.0], "Q": [1.0, 0, 0], "R": [0, 1.0, 0]}
    )
    region = fo.safe_region(node, {"P": 1.0}, ["Q", "R"], 0.5, tolerance=0.1)
    lines = {line.get_label(): line for line in region.plot().get_lines()}
    drawn = [line for name, line in lines.items() if name.startswith("side ")]
    assert [line.get_xydata().tolist() for line in drawn] == [
        list(map(list, ends)) for ends in itertools.pairwise(region.outer.tolist())
    ]


@pytest.mark.usefixtures("no_figures_stay_open")
def test_directions_without_a_limit_are_named():
    loads = {"P": ([0], [1]), "Q": ([1], [0]), "idle": ([0], [0]), "other": ([0], [0])}
    contact = unit_nodes(loads)
    region = fo.safe_region(contact, {"P": 1.0}, ["idle", "Q"], 0.5)
    assert region.unlimited == ("idle",)
    assert np.allclose(region.vertices, [[np.inf, 0.5]])
    assert np.allclose(region.sides, [[0.0, 2.0, 1.0]])
    assert region.contains(1e9, 0.49) and not region.contains(0.0, 0.51)
    for loads, name in (["idle", "Q"], "y"), (["Q", "idle"], "x"):
        drawn = fo.safe_region(contact, {"P": 1.0}, loads, 0.5)
        ax = drawn.plot()
        assert "'idle' has no limit" in drawn.reason
        (side,) = ax.get_lines()
        assert getattr(side, f"get_{name}data")() == pytest.approx([0.5, 0.5])
        assert side.get_label() == "side 0: node 0 moves most"
        (inside,) = ax.patches
        reach = np.ptp(
            inside.get_extents().transformed(ax.transData.inverted()).get_points(), axis=0
        )
        assert reach == pytest.approx([1.0, 0.5] if name == "y" else [0.5, 1.0])
    region = fo.safe_region(contact, {"P": 1.0}, ["idle", "other"], 0.5)
    assert region.unlimited == ("idle", "other")
    assert region.contains(1e9, 1e9)
    assert np.isinf(region.vertices).all()


def test_a_mean_load_at_the_bound_leaves_amplitude_zero():
    contact = fo.ContactSystem.from_blocks(
        [[0.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.5], [1]), "Q": ([1], [0]), "N": ([0], [1])}
    )
    region = fo.safe_region(contact, {"P": 1.0}, ["Q", "N"], 0.5)
    assert np.allclose(region.vertices, 0.0, atol=1e-9)
    assert region.contains(0.0, 0.0)
    assert not region.contains(1e-3, 0.0)


@refused(
    (["a"], "loads: 1; give two"),
    ("ab", "loads: 'ab'; give a list"),
    (["a", "a"], "load case 'a' is in two loads"),
    (["a", []], r"loads\[1\]: no corners with a load"),
    (["a", "none"], "load case 'none': unknown"),
    (["a", [{"b": np.inf}]], r"loads\[1\]\[0\]\['b'\]: inf"),
)
def test_bad_loads_are_refused(loads):
    contact = random_system(np.random.default_rng(0), 2, loads=("mean", "a", "b"))
    fo.safe_region(contact, MEAN, loads, 0.5)


def test_the_ray_of_one_load_alone_gives_a_line_for_both():
    """The corners of the cycle differ by the other load, which has amplitude 0 there. With the
    right multipliers each side takes at most two limits."""
    for seed in range(5):
        contact, _, region = random_region(seed)
        if len(region.sides) and not region.unlimited and contact.B.any():
            assert {attempt.outcome for attempt in region.record.attempts} == {"optimal"}
            assert len(region.record.attempts) <= 2 * len(region.sides)


@pytest.mark.parametrize("other", ["idle", "twin"])
def test_a_side_that_misses_its_vertices_is_no_answer(monkeypatch, other):
    """If the mechanism of a limit proves a little more than its slip carries, its line is beside
    its point; the lines of twin points are parallel."""

    rays = import_module("frictopt.limits.safe_region").Rays
    limit_of = rays._limit

    def loose(*args):
        limit = limit_of(*args)
        return replace(limit, bound=limit.bound * (1 + 1e-6))

    contact = unit_nodes({"P": ([0], [1]), "Q": ([1], [0]), "idle": ([0], [0]), "twin": ([1], [0])})
    monkeypatch.setattr(rays, "_limit", loose)
    with pytest.raises(fo.SolverError, match=r"its sides and vertices differ by 1\.0e-06"):
        fo.safe_region(contact, {"P": 1.0}, [other, "Q"], 0.5)


@pytest.mark.parametrize("seed", few([500116, 500188, 500128]))
def test_all_amplitudes_of_a_region_are_safe_where_each_load_alone_leaves_other_nodes_open(seed):
    case = random_case(seed)
    region = fo.safe_region(case.system, {"mean": 1.0}, ["a", "b"], case.friction)
    points = region.vertices[np.isfinite(region.vertices).all(axis=1)]
    for point in [*points, *((one + other) / 2 for one, other in pairwise(points))]:
        if (point > 0).any():
            assert (
                fo.shakedown_limit(case.system, region.cycle(*point), case.friction).load_factor
                >= 1 - 1e-7
            )
    # The region is that of one set of open nodes: each vertex is on the border of this set.
    for point in points:
        chosen = opened_in(region, points[0], case)
        assert fo.shakedown_limit(
            case.system, region.cycle(*point), case.friction, open_nodes=chosen
        ).load_factor == pytest.approx(1.0, rel=1e-7)


def opened_in(region, point, case):
    """The set of open nodes of a region, which its reason counts."""
    closed = np.zeros(case.system.nodes, dtype=bool)
    if region.reason == "beyond each side its mechanism slips for ever with all nodes closed":
        return closed
    assert region.reason == (
        f"with 1 of {case.system.nodes} nodes open: beyond each side its mechanism slips for ever "
        "with these nodes open and the others closed"
    )
    # With all nodes closed the region would be smaller.
    cycle = region.cycle(*point)
    assert (
        fo.shakedown_limit(case.system, cycle, case.friction, open_nodes=closed).load_factor
        < 1 - 1e-6
    )
    return fo.shakedown_limit(case.system, cycle, case.friction).open
