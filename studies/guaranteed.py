"""The guaranteed limit of the paper's scene beside the shakedown limit; two nodes as an example.

Run with `python -m studies guaranteed [--quick]`. All limits of the scene are amplitudes of the
bulk stress over the mean pressure, sigma / (P / 2a). Between the two limits the start decides
whether the contact stops slipping. The witness of the guaranteed limit is a start from which slip
goes on just above this limit. The plane of slips of two nodes explains it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from .paper import LOADS, slip_unit
from .progress import each
from .tables import Row, Study, Table

PAIR_LOADS = fo.LoadCycle(mean={"mean": 1.0}, corners=[{"cyclic": -1.0}, {"cyclic": 1.0}])
PAIR_FRICTION = 0.6
_SENSES = {1: "forward", -1: "backward"}


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Meshes of the friction table, grading "sine".
    elements: tuple[int, ...] = (16, 32, 64, 124)
    frictions: tuple[float, ...] = tuple(round(float(f), 6) for f in np.arange(0.1, 1.5001, 0.02))
    # Meshes of the table of corners, grading "sine".
    corner_elements: tuple[int, ...] = (8, 12, 16, 24, 32, 48, 64, 96, 124)
    corner_frictions: tuple[float, ...] = (0.2, 0.3, 0.5, 0.7)
    # Mesh of the table of slip bounds, grading "sine".
    bound_elements: int = 64
    bound_frictions: tuple[float, ...] = (0.3, 0.5, 0.7)
    # Slip bounds in units of (P / 2a) a / E*.
    bounds: tuple[float, ...] = tuple(round(float(b), 6) for b in np.geomspace(0.1, 10.0, 41))
    # Load factors of the plane of slips, relative to the guaranteed limit. The shakedown limit is
    # added.
    shares: tuple[float, ...] = (0.5, 1.0, 1.4)
    # One of these load factors, at which paths are followed.
    path_share: float = 1.4
    # Slips from which the paths start.
    starts: tuple[tuple[float, float], ...] = (
        (-0.5, 0.9),
        (0.1, 1.1),
    )
    path_cycles: int = 6


FULL = Parameters()
QUICK = Parameters(
    elements=(8, 16),
    frictions=tuple(round(float(f), 6) for f in np.arange(0.1, 1.5001, 0.1)),
    corner_elements=(8, 16, 32),
    corner_frictions=(0.3, 0.5),
    bound_elements=16,
    bound_frictions=(0.3, 0.5),
    bounds=(0.1, 0.3, 0.5, 1.0, 3.0, 10.0),
)


def pair() -> fo.ContactSystem:
    """The two coupled nodes of the plane of slips."""
    A, B = np.array([[1.0, -0.4], [-0.4, 1.0]]), np.array([[-0.1, -0.7], [0.7, 0.1]])
    loads = {
        "mean": (np.zeros(2), np.ones(2)),
        "cyclic": (np.array([0.8, 0.8]), np.array([0.4, 0.1])),
    }
    return fo.ContactSystem.from_blocks(A, B, 3 * np.eye(2), np.arange(2.0), loads)


def limits_by_friction(parameters: Parameters) -> pd.DataFrame:
    """One row per mesh and friction coefficient."""
    return _by_mesh(parameters.elements, parameters.frictions, "guaranteed limit by friction")


def limits_by_corner(parameters: Parameters) -> pd.DataFrame:
    """One row per mesh and friction coefficient."""
    return _by_mesh(
        parameters.corner_elements, parameters.corner_frictions, "guaranteed limit by corner size"
    )


def _by_mesh(meshes: Sequence[int], frictions: Sequence[float], what: str) -> Iterator[Row]:
    for elements in each(meshes, what):
        scene = fo.scenes.PunchOnHalfPlane(elements=elements, grading="sine")
        system = scene.condense()
        model = fo.GuaranteedModel(system, LOADS)
        yield from [
            _mesh(scene) | _limits(system, model.solve(friction), friction)
            for friction in frictions
        ]


def limits_by_bound(parameters: Parameters) -> Iterator[Row]:
    """One row per friction coefficient and slip bound."""
    scene = fo.scenes.PunchOnHalfPlane(elements=parameters.bound_elements, grading="sine")
    system = scene.condense()
    for bound in each(parameters.bounds, "guaranteed limit by slip bound"):
        model = fo.GuaranteedModel(system, LOADS, slip_bound=bound * slip_unit(system))
        limits = {friction: model.solve(friction) for friction in parameters.bound_frictions}
        yield from [
            _mesh(scene) | {"slip_bound": bound} | _limits(system, limit, friction)
            for friction, limit in limits.items()
        ]


def _mesh(scene: fo.scenes.PunchOnHalfPlane) -> dict[str, Any]:
    return {"elements": scene.elements, "corner_size": scene.corner_size / scene.half_width}


def _limits(
    system: fo.ContactSystem, limit: fo.results.GuaranteedLimit, friction: float
) -> dict[str, Any]:
    return {
        "friction": friction,
        "guaranteed": limit.load_factor,
        "shakedown": limit.shakedown.load_factor,
        "x": np.nan if limit.node is None else float(system.x[limit.node] / system.x[-1]),
        "residual": limit.residual,
    }


def plane_of_slips(parameters: Parameters) -> Iterator[Row]:
    """Lines, safe region and paths at several load factors, as polylines.

    There is one row per point, in the order of the points.
    """
    system = pair()
    limit = fo.guaranteed_limit(system, PAIR_LOADS, PAIR_FRICTION)
    factors = [("", share * limit.load_factor) for share in parameters.shares] + [
        ("shakedown limit", limit.shakedown.load_factor)
    ]
    for name, factor in factors:
        share = factor / limit.load_factor
        label = name or ("guaranteed limit" if share == 1 else "")
        head = {"load_factor": factor, "share": share, "limit": label, "residual": limit.residual}
        lines = list(_lines(system, factor))
        for node, sense, normal, strength, rate in lines:
            for what, height in (("mean line", strength), ("line", strength - factor * rate)):
                point = normal * height / (normal @ normal)
                along = np.array([-normal[1], normal[0]]) / np.linalg.norm(normal)
                yield from [
                    head | _point(what, node, _SENSES[sense], 0, point + reach * along)
                    for reach in (-10.0, 10.0)
                ]
        yield from [head | _point("safe", -1, "", 0, vertex) for vertex in _region(lines, factor)]
        yield from (
            [head | _point("witness", limit.node, "", 0, limit.slip)]
            if label == "guaranteed limit"
            else []
        )
        if share == parameters.path_share:
            for number, start in enumerate(parameters.starts):
                path = fo.march(
                    system,
                    PAIR_LOADS,
                    PAIR_FRICTION,
                    factor,
                    initial_slip=start,
                    cycles=parameters.path_cycles,
                )
                fate = fo.steady_state(
                    system, PAIR_LOADS, PAIR_FRICTION, factor, initial_slip=start
                ).outcome.name
                yield from [
                    head | {"residual": path.residual} | _point("path", -1, fate, number, slip)
                    for slip in path.slip
                ]


def _point(what: str, node: int | None, sense: str, number: int, slip: Any) -> dict[str, Any]:
    return {
        "what": what,
        "node": node,
        "sense": sense,
        "path": number,
        "v1": float(slip[0]),
        "v2": float(slip[1]),
    }


def _lines(system: fo.ContactSystem, factor: float) -> Iterator[tuple[int, int, Any, float, float]]:
    """Node, sense, and `normal . v <= strength - factor * rate` of each friction bound.

    Each bound is taken at the corner at which it governs.
    """
    q0, p0 = PAIR_LOADS.mean_reaction(system)
    q1, p1 = PAIR_LOADS.corner_reactions(system)
    for node in range(system.nodes):
        for sense in _SENSES:
            rate = float(np.max(-sense * q1[:, node] - PAIR_FRICTION * p1[:, node]))
            yield (
                node,
                sense,
                -sense * system.A[node] - PAIR_FRICTION * system.B[node],
                float(sense * q0[node] + PAIR_FRICTION * p0[node]),
                rate,
            )


def _region(lines: Sequence[tuple[int, int, Any, float, float]], factor: float) -> list[Any]:
    """Vertices of the region of safe slips, in order."""
    normals = np.array([line[2] for line in lines])
    heights = np.array([line[3] - factor * line[4] for line in lines])
    found = [
        np.linalg.solve(normals[[a, b]], heights[[a, b]])
        for a, b in combinations(range(len(lines)), 2)
    ]
    kept = np.array([slip for slip in found if (normals @ slip <= heights + 1e-9).all()])
    centre = kept.mean(axis=0)
    return list(kept[np.argsort(np.arctan2(*(kept - centre).T))])


_BOUND = {"slip_bound": "largest slip that assembly may leave, v E* / (a P / 2a)"}
_LIMIT = {"x": "node that starts to slip back and forth, x / a; NaN if the limit is lambda_2"}
_PLANE = {
    "share": "load factor over the guaranteed limit",
    "limit": "name of the limit, if the load factor is one",
    "what": "line: friction bound at its ruling corner; mean line: the same under the mean load; safe: vertex of the safe slips; witness; path",
    "node": "node of a line or of the witness, else -1",
    "sense": "for a line the sense of the slip that it bounds; for a path its outcome",
    "path": "number of the path",
    "v1": "slip of node 0",
    "v2": "slip of node 1",
}

FRICTION = Table(
    "guaranteed_friction",
    "limits of one mesh at one friction",
    _LIMIT,
    full=FULL,
    quick=QUICK,
    compute=limits_by_friction,
)
CORNER = Table(
    "guaranteed_corner",
    "limits of one mesh at one friction",
    _LIMIT,
    full=FULL,
    quick=QUICK,
    compute=limits_by_corner,
)
BOUND = Table(
    "guaranteed_bound",
    "limits under one slip bound at one friction",
    _BOUND | _LIMIT,
    full=FULL,
    quick=QUICK,
    compute=limits_by_bound,
)
PLANE = Table(
    "guaranteed_plane",
    "one point of a polyline in the plane of slips",
    _PLANE,
    full=FULL,
    quick=QUICK,
    compute=plane_of_slips,
)

STUDY = Study(
    "studies.guaranteed", __doc__, "few coarse meshes, in seconds", (FRICTION, CORNER, BOUND, PLANE)
)
