"""Random contacts, loads, frictions and starts, ordinary and extreme, each made from one seed."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import frictopt as fo

SHARES = (0.0, 0.5, 0.9, 1 - 1e-6, 1 + 1e-6, 1.1, 1.5, 3.0, 20.0)
"""Load factors of the cases, over the shakedown limit (over 1 where there is no finite one)."""

_NODES = (1, 1, 2, 2, 2, 3, 3, 3, 4, 5, 6, 8, 12)


@dataclass(frozen=True, eq=False)
class Case:
    """One contact with everything that a question to it needs.

    Attributes
    ----------
    seed
        What it was made from.
    system, cycle
        The contact and its load cycle, with the load case "mean" and cyclic ones.
    friction
        (N,) coefficients of friction.
    share
        Load factor over the shakedown limit.
    start
        (N,) initial slip, or None.
    family
        What kind of contact it is.
    """

    seed: int
    system: fo.ContactSystem
    cycle: fo.LoadCycle
    friction: Any
    share: float
    start: Any
    family: str = "small"


def random_case(seed: int, nodes: int | None = None) -> Case:
    """The case of a seed, with so many nodes, or a number that the seed chooses."""
    rng = np.random.default_rng(seed)
    nodes = int(rng.choice(_NODES)) if nodes is None else nodes
    A, B, C = _stiffness(rng, nodes)
    q0, p0, cyclic = _loads(rng, nodes)
    if rng.random() < 0.15:  # nodal forces of a graded mesh
        sizes = 10.0 ** rng.uniform(-4, 0, nodes)
        q0, p0, cyclic = q0 * sizes, p0 * sizes, [(q * sizes, p * sizes) for q, p in cyclic]
    gap = (
        rng.uniform(0, 0.4, nodes) * (rng.random(nodes) < 0.5)
        if rng.random() < 0.15
        else np.zeros(nodes)
    )
    start = (
        None
        if rng.random() < 0.3
        else rng.normal(size=nodes) * rng.choice([1e-3, 1.0, 1e3], p=[0.2, 0.6, 0.2])
    )
    if rng.random() < 0.3:  # other units
        force, length = 10.0 ** rng.uniform(-15, 15, 2)
        A, B, C = (matrix * (force / length) for matrix in (A, B, C))
        q0, p0, cyclic = q0 * force, p0 * force, [(q * force, p * force) for q, p in cyclic]
        gap, start = gap * length, None if start is None else start * length
    loads = {"mean": (q0, p0), "a": cyclic[0], "b": cyclic[1]}
    system = fo.ContactSystem.from_blocks(A, B, C, np.arange(float(nodes)), loads, gap)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in _corners(rng)])
    return Case(seed, system, cycle, _friction(rng, nodes), float(rng.choice(SHARES)), start)


def _stiffness(rng: np.random.Generator, nodes: int) -> tuple[Any, Any, Any]:
    """Blocks A, B, C: well and badly conditioned, coupled and not, held and free."""
    if nodes in _MESHED and rng.random() < 0.3:
        return _meshed(nodes, int(rng.integers(len(MATERIALS))))
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + rng.choice([1.0, 0.1, 1e-3]) * np.eye(2 * nodes)
    coupling = rng.choice([0.0, 1e-7, 0.3, 0.7, 1.0], p=[0.1, 0.05, 0.35, 0.3, 0.2])
    S[nodes:, :nodes] *= coupling
    S[:nodes, nodes:] *= coupling
    if (
        rng.random() < 0.15
    ):  # a rigid motion without supports: sliding, or sliding, lifting and turning
        ones, zeros, turn = np.ones(nodes), np.zeros(nodes), np.arange(nodes) - (nodes - 1) / 2
        motions = [np.r_[ones, zeros], np.r_[zeros, ones], np.r_[zeros, turn]][
            : rng.choice([1, 3]) if nodes > 2 else 1
        ]
        rigid = np.linalg.qr(np.array(motions).T)[0]
        S = S - rigid @ (rigid.T @ S)
        S = S - (S @ rigid) @ rigid.T
    return S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:]


_MESHED = 3, 5  # numbers of nodes of which the paper's scene is a contact, too
MATERIALS = fo.Material(), fo.Material(100.0, 0.1), fo.Material(1e-2, 0.45)  # of its punch


@cache
def _meshed(nodes: int, which: int) -> tuple[Any, Any, Any]:
    """Stiffness of the paper's scene on a very coarse mesh, similar or dissimilar materials."""
    scene = fo.scenes.PunchOnHalfPlane(
        elements=nodes - 1,
        grading=3.0,
        growth=2.5,
        punch_material=MATERIALS[which],
        element="mean_dilatation",
    )
    system = scene.condense()
    return system.A, system.B, system.C


def _loads(rng: np.random.Generator, nodes: int) -> tuple[Any, Any, list[tuple[Any, Any]]]:
    """Mean reactions, and those of the two cyclic load cases; some meet bounds exactly, some pull."""
    q0, p0 = rng.choice([0.0, 0.1, 0.5]) * rng.normal(size=nodes), rng.uniform(0.5, 1.5, nodes)
    if rng.random() < 0.15:
        p0[rng.integers(nodes)] = rng.choice([0.0, 1e-12, -0.3])
    cyclic = [
        (rng.normal(size=nodes), rng.choice([0.0, 0.3, 1.0]) * rng.normal(size=nodes)) for _ in "ab"
    ]
    if rng.random() < 0.2:
        q0, p0 = np.round(2 * q0) / 2, np.round(2 * p0) / 2
        cyclic = [(np.round(2 * q) / 2, np.round(2 * p) / 2) for q, p in cyclic]
    if rng.random() < 0.05:
        cyclic[1] = 0 * cyclic[1][0], 0 * cyclic[1][1]
    return q0, p0, cyclic


def _corners(rng: np.random.Generator) -> Any:
    corners = int(rng.integers(1, 6))
    kinds: tuple[Callable[[], Any], ...] = (
        lambda: rng.integers(-2, 3, (corners, 2)) / 2,
        lambda: rng.normal(size=(corners, 2)),
        lambda: np.array([[-1.0, 0.0], [1.0, 0.0]]),
    )
    return kinds[rng.integers(3)]()


def _friction(rng: np.random.Generator, nodes: int) -> Any:
    kinds: tuple[Callable[[], Any], ...] = (
        lambda: np.full(nodes, rng.uniform(0.05, 0.8)),
        lambda: rng.uniform(0.05, 0.8, nodes),
        lambda: rng.uniform(0.1, 0.6, nodes) * (rng.random(nodes) < 0.6),
        lambda: np.full(nodes, rng.choice([0.0, 1e-6, 1e-3, 1.0, 3.0, 10.0])),
    )
    return kinds[rng.choice(4, p=[0.35, 0.35, 0.15, 0.15])]()
