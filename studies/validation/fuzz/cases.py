"""Random contacts, loads, frictions and starts, ordinary and extreme, each made from one seed."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import frictopt as fo

SHARES = (0.0, 0.5, 0.9, 1 - 1e-6, 1 + 1e-6, 1.1, 1.5, 3.0, 20.0)
"""Load factors of the cases, relative to the shakedown limit, or to 1 without a finite limit."""

_NODES = (1, 1, 2, 2, 2, 3, 3, 3, 4, 5, 6, 8, 12)


@dataclass(frozen=True, eq=False)
class Case:
    """One contact with all arguments of the questions about it.

    Attributes
    ----------
    seed
        The seed of the random numbers that made the case.
    system, cycle
        The contact and its load cycle, with the load case "mean" and cyclic load cases.
    friction
        (N,) coefficients of friction.
    share
        Load factor relative to the shakedown limit.
    start
        (N,) initial slip, or None.
    family
        The kind of contact.
    """

    seed: int
    system: fo.ContactSystem
    cycle: fo.LoadCycle
    friction: Any
    share: float
    start: Any
    family: str = "small"


def random_case(seed: int, nodes: int | None = None) -> Case:
    """The case of a seed. The seed also chooses the number of nodes, unless it is given."""
    rng = np.random.default_rng(seed)
    nodes = int(rng.choice(_NODES)) if nodes is None else nodes
    A, B, C = _stiffness(rng, nodes)
    q0, p0, cyclic = _loads(rng, nodes)
    if rng.random() < 0.15:
        # Nodal forces of a graded mesh.
        sizes = 10.0 ** rng.uniform(-4, 0, nodes)
        q0, p0, cyclic = _scaled(q0, p0, cyclic, sizes)
    gap = np.zeros(nodes)
    if rng.random() < 0.15:
        gap = rng.uniform(0, 0.4, nodes) * (rng.random(nodes) < 0.5)
    start = None
    if rng.random() >= 0.3:
        start = rng.normal(size=nodes) * rng.choice([1e-3, 1.0, 1e3], p=[0.2, 0.6, 0.2])
    if rng.random() < 0.3:
        # Other units.
        force, length = 10.0 ** rng.uniform(-15, 15, 2)
        A, B, C = (matrix * (force / length) for matrix in (A, B, C))
        q0, p0, cyclic = _scaled(q0, p0, cyclic, force)
        gap = gap * length
        start = None if start is None else start * length
    loads = {"mean": (q0, p0), "a": cyclic[0], "b": cyclic[1]}
    system = fo.ContactSystem.from_blocks(A, B, C, np.arange(float(nodes)), loads, gap)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in _corners(rng)])
    return Case(seed, system, cycle, _friction(rng, nodes), float(rng.choice(SHARES)), start)


def _scaled(q0: Any, p0: Any, cyclic: list[tuple[Any, Any]], size: Any) -> tuple[Any, Any, Any]:
    """The mean reactions and the cyclic reactions, all multiplied by a size."""
    return q0 * size, p0 * size, [(q * size, p * size) for q, p in cyclic]


def _stiffness(rng: np.random.Generator, nodes: int) -> tuple[Any, Any, Any]:
    """Blocks A, B, C: well or badly conditioned, coupled or not, held or free."""
    if nodes in _MESHED and rng.random() < 0.3:
        return _meshed(nodes, int(rng.integers(len(MATERIALS))))
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + rng.choice([1.0, 0.1, 1e-3]) * np.eye(2 * nodes)
    coupling = rng.choice([0.0, 1e-7, 0.3, 0.7, 1.0], p=[0.1, 0.05, 0.35, 0.3, 0.2])
    S[nodes:, :nodes] *= coupling
    S[:nodes, nodes:] *= coupling
    if rng.random() < 0.15:
        # No support holds a rigid motion: sliding alone, or sliding, lifting and turning.
        ones = np.ones(nodes)
        zeros = np.zeros(nodes)
        turn = np.arange(nodes) - (nodes - 1) / 2
        motions = [np.r_[ones, zeros], np.r_[zeros, ones], np.r_[zeros, turn]]
        free = rng.choice([1, 3]) if nodes > 2 else 1
        rigid = np.linalg.qr(np.array(motions[:free]).T)[0]
        S = S - rigid @ (rigid.T @ S)
        S = S - (S @ rigid) @ rigid.T
    return S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:]


# Contacts with these numbers of nodes may be the paper's scene on a coarse mesh.
_MESHED = 3, 5
MATERIALS = fo.fem.Material(), fo.fem.Material(100.0, 0.1), fo.fem.Material(1e-2, 0.45)
"""Materials of the punch of the paper's scene."""


@cache
def _meshed(nodes: int, material: int) -> tuple[Any, Any, Any]:
    """Stiffness of the paper's scene on a very coarse mesh, with similar or dissimilar materials."""
    scene = fo.scenes.PunchOnHalfPlane(
        elements=nodes - 1,
        grading=3.0,
        growth=2.5,
        punch_material=MATERIALS[material],
        element="mean_dilatation",
    )
    system = scene.condense()
    return system.A, system.B, system.C


def _loads(rng: np.random.Generator, nodes: int) -> tuple[Any, Any, list[tuple[Any, Any]]]:
    """Reactions of the mean load, and of the two cyclic load cases.

    Some reactions pull. Some cases have rounded reactions, which meet bounds exactly.
    """
    q0 = rng.choice([0.0, 0.1, 0.5]) * rng.normal(size=nodes)
    p0 = rng.uniform(0.5, 1.5, nodes)
    if rng.random() < 0.15:
        p0[rng.integers(nodes)] = rng.choice([0.0, 1e-12, -0.3])
    cyclic = []
    for _ in "ab":
        q = rng.normal(size=nodes)
        p = rng.choice([0.0, 0.3, 1.0]) * rng.normal(size=nodes)
        cyclic.append((q, p))
    if rng.random() < 0.2:
        q0 = _to_halves(q0)
        p0 = _to_halves(p0)
        cyclic = [(_to_halves(q), _to_halves(p)) for q, p in cyclic]
    if rng.random() < 0.05:
        q, p = cyclic[1]
        cyclic[1] = 0 * q, 0 * p
    return q0, p0, cyclic


def _to_halves(values: Any) -> Any:
    """Values rounded to multiples of one half."""
    return np.round(2 * values) / 2


def _corners(rng: np.random.Generator) -> Any:
    """(K, 2) amplitudes of the cyclic load cases at the corners."""
    corners = int(rng.integers(1, 6))
    kinds: tuple[Callable[[], Any], ...] = (
        lambda: rng.integers(-2, 3, (corners, 2)) / 2,
        lambda: rng.normal(size=(corners, 2)),
        lambda: np.array([[-1.0, 0.0], [1.0, 0.0]]),
    )
    return kinds[rng.integers(3)]()


def _friction(rng: np.random.Generator, nodes: int) -> Any:
    """(N,) coefficients of friction: uniform, random, zero at some nodes, or extreme."""
    kinds: tuple[Callable[[], Any], ...] = (
        lambda: np.full(nodes, rng.uniform(0.05, 0.8)),
        lambda: rng.uniform(0.05, 0.8, nodes),
        lambda: rng.uniform(0.1, 0.6, nodes) * (rng.random(nodes) < 0.6),
        lambda: np.full(nodes, rng.choice([0.0, 1e-6, 1e-3, 1.0, 3.0, 10.0])),
    )
    return kinds[rng.choice(4, p=[0.35, 0.35, 0.15, 0.15])]()
