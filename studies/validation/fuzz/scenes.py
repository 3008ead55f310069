"""Random contacts of 3 to 130 nodes, each made from one seed: chains, half-planes, punches.

Some contacts are symmetric, while their loads or starts are not.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.reference import half_plane_influence
from studies.validation.fuzz.cases import MATERIALS, Case

_SHARES = (0.8, 0.95, 1.05, 1.2, 1.5, 2.0, 4.0)
# Numbers of elements along the contact of a punch.
_ELEMENTS = (16, 24, 40, 64, 96, 128)


def random_scene(seed: int, family: str | None = None) -> Case:
    """The contact of a seed, of the given family or of a family that the seed chooses.

    The load case "mean" presses, and the other load cases are cyclic. If the contact is symmetric,
    the first cyclic load case is symmetric, too.
    """
    # The 3 makes the random numbers differ from the random numbers of `random_case`.
    rng = np.random.default_rng([seed, 3])
    family = str(rng.choice(list(FAMILIES), p=_PROBABILITIES)) if family is None else family
    system = FAMILIES[family](rng)
    symmetric = bool(
        np.abs(system.B + np.flip(system.B)).max() <= 1e-12 * np.abs(system.A).max()
        and rng.random() < 0.7
    )
    if rng.random() < 0.15:
        gap = rng.uniform(0, 0.3, system.nodes) * (rng.random(system.nodes) < 0.5) * _length(system)
        system = system.with_gap(np.maximum(gap, gap[::-1]) if symmetric else gap)
    mean_friction = rng.uniform(0.1, 0.7)
    variation = rng.choice([0.0, 0.3]) * rng.uniform(-1, 1, system.nodes)
    friction = mean_friction * (1 + variation)
    friction = np.maximum(friction, friction[::-1]) if symmetric else friction
    names = [name for name in system.bonded if name != "mean"]
    corners = []
    for amplitudes in _corners(rng, len(names)):
        corners.append(dict(zip(names, map(float, amplitudes), strict=True)))
    cycle = fo.LoadCycle({"mean": 1.0}, corners)
    share = float(rng.choice(_SHARES))
    start = _start(rng, system, symmetric)
    return Case(seed, system, cycle, friction, share, start, family)


def _length(system: fo.ContactSystem) -> float:
    """Slip that the mean pressure makes."""
    return float(np.abs(system.bonded["mean"][1]).mean()) / system.stiffness_scale


def _start(rng: np.random.Generator, system: fo.ContactSystem, symmetric: bool) -> Any:
    """No slip, a symmetric slip, a slip that is symmetric except at one node, or any slip."""
    slip = rng.normal(size=system.nodes) * _length(system) * rng.choice([0.1, 1.0, 10.0])
    kind = rng.integers(4)
    if kind == 0:
        return None
    if kind < 3 and symmetric:
        is_chosen = np.arange(system.nodes) == rng.integers(system.nodes)
        return (slip - slip[::-1]) / 2 + is_chosen * slip * (kind == 2)
    return slip


def _corners(rng: np.random.Generator, cases: int) -> Any:
    """(K, cases) amplitudes of the cyclic load cases.

    There are four kinds: symmetric loads with an unsymmetric end; such loads with a return to zero;
    loads whose first load case goes there and back on a straight path while the other load cases
    turn; and any loads.
    """
    number = int(rng.integers(2, 6))
    first = np.eye(cases)[0]
    late = first * rng.choice([-1.0, 0.0, 0.5, 1.0], number)[:, None]
    late[-int(rng.integers(1, 3)) :] += (
        rng.choice([-0.2, 0.05, 0.2, 1.0]) * (1 - first) * rng.normal(size=cases)
    )
    late[:2, 0] = -1.0, 1.0
    straight = np.linspace(-1, 1, number + 1)[:, None] * first + rng.choice(
        [-1.0, 0.0, 1.0], (number + 1, cases)
    ) * (1 - first)
    kinds: Sequence[Callable[[], Any]] = (
        lambda: late,
        lambda: np.vstack([late, 0 * first]),
        lambda: np.vstack([straight, straight[-2:0:-1]]),
        lambda: rng.normal(size=(number, cases)),
    )
    return kinds[rng.choice(4, p=[0.4, 0.1, 0.25, 0.25])]()


def _nodes(rng: np.random.Generator) -> int:
    """A number of nodes from 3 to 130."""
    return int(3 * (130 / 3) ** (rng.random() ** 1.5))


def _loaded(rng: np.random.Generator, A: Any, B: Any, C: Any) -> fo.ContactSystem:
    """The contact of the blocks, with random loads.

    In a part of the cases the contact is made symmetric. The loads are smooth along the contact, or
    vary from node to node.
    """
    n = len(A)
    symmetric = rng.random() < 0.6
    smooth = rng.random() < 0.5
    x = np.linspace(-1, 1, n)
    waves = [np.cos(k * np.pi / 2 * (x + 1)) for k in range(4)]

    def profile() -> Any:
        return np.dot(rng.normal(size=4) / (1, 2, 4, 8), waves) if smooth else rng.normal(size=n)

    mean = 0.1 * profile(), np.clip(1 + 0.3 * profile(), 0.3, None)
    cases = {"mean": mean} | {
        name: (profile(), rng.choice([0.0, 0.3]) * profile())
        for name in "abc"[: rng.integers(2, 4)]
    }
    if symmetric:
        A, B, C = (A + np.flip(A)) / 2, (B - np.flip(B)) / 2, (C + np.flip(C)) / 2
        for name in ("mean", "a"):
            q, p = cases[name]
            cases[name] = (q - q[::-1]) / 2, (p + p[::-1]) / 2
    return fo.ContactSystem.from_blocks(A, B, C, np.arange(float(n)), cases)


def _any(rng: np.random.Generator) -> fo.ContactSystem:
    """A random positive definite stiffness without structure."""
    n = min(_nodes(rng), 30)
    G = rng.normal(size=(2 * n, 2 * n))
    S = G @ G.T / (2 * n) + 0.5 * np.eye(2 * n)
    return _loaded(rng, S[:n, :n], rng.choice([0.0, 0.5, 0.8]) * S[n:, :n], S[n:, n:])


def _chain(rng: np.random.Generator) -> fo.ContactSystem:
    """Springs from node to node and to the ground; slip changes the pressures at the neighbours."""
    n = _nodes(rng)
    A, C = (2.2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1) for _ in "AC")
    B = rng.choice([0.0, 0.2, 0.4]) * (np.eye(n, k=1) - np.eye(n, k=-1))
    return _loaded(rng, A, B, C + 0.5 * np.eye(n))


def _half_planes(rng: np.random.Generator) -> fo.ContactSystem:
    """Two half-planes; if they are dissimilar, a sign matrix couples them.

    See Johnson 1985, section 2.2.
    """
    n = _nodes(rng)
    G = half_plane_influence(n, 1.0)
    sign = np.sign(np.subtract.outer(np.arange(n), np.arange(n)))
    coupling = rng.choice([0.0, 0.1, 0.3]) * sign * np.abs(G).max() / n
    S = np.linalg.inv(np.block([[G, coupling], [coupling.T, G]]))
    S = (S + S.T) / 2
    return _loaded(rng, S[:n, :n], S[n:, :n], S[n:, n:])


def _punch(rng: np.random.Generator) -> fo.ContactSystem:
    """The paper's scene with similar or dissimilar bodies.

    The loads are pressure on the whole top of the punch, tension, shear, and pressure on half of
    the top.
    """
    return _condensed(int(rng.choice(_ELEMENTS)), int(rng.integers(len(MATERIALS))))


@cache
def _condensed(elements: int, material: int) -> fo.ContactSystem:
    """The system of the paper's scene with its four load cases."""
    scene = fo.scenes.PunchOnHalfPlane(
        elements=elements, growth=1.3, punch_material=MATERIALS[material]
    )
    system = scene.condense()
    model = scene.model()
    mesh = model.bodies["punch"].mesh.with_boundaries(
        {"half": lambda x: (x[1] == scene.punch_height) & (x[0] < 0)}
    )
    tilted = replace(
        model,
        bodies={**model.bodies, "punch": replace(model.bodies["punch"], mesh=mesh)},
        loads={"half": [fo.fem.Traction("punch", "half", y=-1.0)]},
    ).condense()
    loads = {
        "mean": system.bonded["P"],
        "sigma": system.bonded["sigma"],
        "Q": system.bonded["Q"],
        "half": tilted.bonded["half"],
    }
    return replace(system, bonded=loads, compliance=None, load_size={})


FAMILIES: dict[str, Callable[[np.random.Generator], fo.ContactSystem]] = {
    "any": _any,
    "chain": _chain,
    "half-planes": _half_planes,
    "punch": _punch,
}
"""Family -> function that makes a contact."""

# Probability of each family.
_PROBABILITIES = (0.4, 0.25, 0.25, 0.1)
