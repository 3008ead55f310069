"""Questions at the edge in three dimensions, each with an answer known from elsewhere."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import linprog

import frictopt as fo
from frictopt.reference import smallest_circle_limit

from .probes import Probe, Sizes, shakedown

_SIDES, _CUTS = 16, 40  # of the first polygons around the circles, and refinements of them
_EXCESS = 1e-10  # over a circle, in the node's pressure, that the last polygon leaves
_TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
_BULK = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
_TURNING = fo.LoadCycle({"P": 1.0}, [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}])


def space_probes(sizes: Sizes) -> Iterator[Probe]:
    """All questions."""
    scene = fo.scenes.SquarePunch(elements=min(4, sizes.elements // 4), growth=2.0)
    for f in (0.01, 0.1, 0.5, 2.0, 10.0):
        yield from _limits("friction, 3-D", f"f = {f:g}", scene, f)
    for ratio in (1e-4, 1e-2, 1e2, 1e4):
        yield from _limits("stiffness of punch over block, 3-D", f"{ratio:g}", replace(scene, punch_material=fo.Material(ratio)), 0.5)
    for nu in (0.0, 0.4999):
        material = fo.Material(1.0, nu)
        mean = replace(scene, punch_material=material, block_material=material, element="mean_dilatation")
        yield from _limits("Poisson's ratio, 3-D", f"{nu:g}", mean, 0.5)
    plain = scene.condense()
    known = partial(shakedown, plain, _BULK, 0.5)
    for unit in (1e-12, 1e12):
        scaled = fo.ContactSystem(unit * plain.S, plain.points, {name: (unit * q, unit * p) for name, (q, p) in plain.bonded.items()})
        yield Probe("units, 3-D", f"{unit:g}", "shakedown limit", partial(shakedown, scaled, _BULK, 0.5), lambda: known().number, "other units")
    for nodes in (1, 10, sizes.elements):
        yield _uncoupled(nodes)


def _limits(extreme: str, value: str, scene: fo.scenes.SquarePunch, friction: float) -> Iterator[Probe]:
    system = scene.condense()
    for cycle, question in ((_BULK, "shakedown limit, bulk"), (_TURNING, "shakedown limit, turning")):
        asked = partial(shakedown, system, cycle, friction), partial(polygon_limit, system, cycle, friction)
        yield Probe(extreme, value, question, *asked, "linear programs, polygons for the circles, scipy")


def polygon_limit(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, *, least: bool = False) -> float | None:
    """The limit with polygons around the circles, over raw slips, a side more wherever a circle is still exceeded; None where scipy finds none.

    Or, if asked for, the least load factor with a safe slip.
    """
    n, (q0, p0), f = system.nodes, cycle.mean_reaction(system), np.broadcast_to(friction, system.nodes)
    unit, stiff = np.where(p0 > 0, p0, 1.0), system.stiffness_scale  # of the rows, and of the slips
    q1, p1 = cycle.corner_reactions(system)
    A1, A2, B = (part / stiff / unit[:, None] for part in (system.A[:n], system.A[n:], system.B))
    q0, p0, q1, p1 = q0 / unit[:, None], p0 / unit, q1 / unit[:, None], p1 / unit
    nodes, corners = np.arange(n), np.arange(len(p1))
    k, i, angle = (grid.ravel() for grid in np.meshgrid(corners, nodes, 2 * np.pi * np.arange(_SIDES) / _SIDES, indexing="ij"))
    rows, right = np.vstack([np.column_stack([-B, -load]) for load in p1]), np.tile(p0, len(p1))  # no node opens
    for _ in range(_CUTS):
        c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
        load = c[:, 0] * q1[k, i, 0] + s[:, 0] * q1[k, i, 1] - f[i] * p1[k, i]
        rows = np.vstack([rows, np.column_stack([c * A1[i] + s * A2[i] - f[i, None] * B[i], load])])
        right = np.r_[right, f[i] * p0[i] - c[:, 0] * q0[i, 0] - s[:, 0] * q0[i, 1]]
        found = _solved(rows, right, least)
        if found.status != 0:
            return float("inf") if found.status == 3 else None
        v, lam = found.x[:-1], float(found.x[-1])
        q = q0 + lam * q1 + np.column_stack([A1 @ v, A2 @ v])
        excess = np.linalg.norm(q, axis=-1) - f * (p0 + lam * p1 + B @ v)
        if excess.max() <= _EXCESS:
            return lam
        k, i = np.nonzero(excess > _EXCESS)
        angle = np.arctan2(q[k, i, 1], q[k, i, 0])
    return None


def _solved(rows: Any, right: Any, least: bool) -> Any:
    """Largest, or least, load factor of some rows, by the interior point method and crossover; by the simplex method where that fails."""
    goal, bounds = np.r_[np.zeros(rows.shape[1] - 1), 1.0 if least else -1.0], [*[(None, None)] * (rows.shape[1] - 1), (0, None)]
    for method in ("highs-ipm", "highs-ds"):
        found = linprog(goal, rows, right, bounds=bounds, method=method, options=_TIGHT)
        if found.status in (0, 2, 3):
            break
    return found


def _uncoupled(nodes: int) -> Probe:
    rng = np.random.default_rng(nodes)
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = np.zeros((3 * nodes, 3 * nodes))
    S[: 2 * nodes, : 2 * nodes], S[2 * nodes :, 2 * nodes :] = G @ G.T / nodes + np.eye(2 * nodes), np.eye(nodes)
    p0, q1 = 10.0 ** rng.uniform(-3, 3, nodes), rng.normal(size=(5, nodes, 2))
    cases = {f"{k}": np.r_[q[:, 0], q[:, 1], np.zeros(nodes)] for k, q in enumerate(q1)}
    system = fo.ContactSystem(S, rng.normal(size=(nodes, 3)), {"mean": np.r_[np.zeros(2 * nodes), p0], **cases})
    cycle = fo.LoadCycle({"mean": 1.0}, [{name: 1.0} for name in cases])
    asked = partial(shakedown, system, cycle, 0.5), partial(smallest_circle_limit, p0, q1, 0.5)
    return Probe("pressures over six decades, uncoupled, 3-D", f"{nodes} nodes", "shakedown limit", *asked, "smallest circle")
