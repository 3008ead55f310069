"""Random uncoupled contacts whose normal loads open and close nodes, judged by transients.

`contact` makes the contact of a seed, `judged` compares its limit with the ends of transients from
several starts, just below and just above. `python -m validation.moving_areas FIRST COUNT` prints a
table, and each contact that disagrees.
"""

import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import frictopt as fo

KINDS = ("static", "there and back", "closed path", "pressed")
# Distance of the transients from the limit, as a share of it.
_APART = 0.01

# The arguments of a question: system, cycle and friction.
Asked: TypeAlias = tuple[fo.ContactSystem, fo.LoadCycle, NDArray[Any]]


@dataclass(frozen=True)
class Case:
    """A contact, its cycle and friction; `held` parts of the shear may differ between corners."""

    system: fo.ContactSystem
    cycle: fo.LoadCycle
    friction: NDArray[Any]
    kind: str

    @property
    def asked(self) -> Asked:
        """The arguments of a question."""
        return self.system, self.cycle, self.friction


def definite(rng: np.random.Generator, size: int) -> NDArray[Any]:
    """A random positive definite matrix."""
    factor = rng.normal(size=(size, size))
    return np.asarray(factor @ factor.T / size + 0.4 * np.eye(size))


def contact(seed: int, tangents: int = 1) -> Case:
    """The contact of a seed: 2 to 6 nodes, 2 to 6 corners; the load factor scales shear alone."""
    rng = np.random.default_rng([75, tangents, seed])
    nodes = int(rng.integers(2, 7))
    corners = int(rng.integers(2, 7))
    kind = KINDS[seed % len(KINDS)]
    entries = tangents * nodes
    S = np.zeros((entries + nodes, entries + nodes))
    S[:entries, :entries] = definite(rng, entries)
    S[entries:, entries:] = definite(rng, nodes)

    pressed = rng.uniform(0.4, 1.4, nodes)
    pressed[rng.integers(nodes)] += 2.0  # this node mostly stays closed
    size = rng.uniform(0.3, 1.6) * (0.2 if kind == "pressed" else 1.0)
    normal = size * rng.normal(size=(corners, nodes))
    shear = rng.normal(size=(corners, entries))
    if kind == "there and back" and corners > 2:
        half = (corners + 2) // 2
        path = [*range(half), *range(half - 2, 0, -1)]
        normal, shear = normal[path], shear[path]
    if kind == "static":
        shear[:] = shear[0]
    held = 0.1 * rng.normal(size=entries) * (seed % 3 == 0)
    gap = 0.3 * rng.random(nodes) * (rng.random(nodes) < 0.3) * (seed % 2)

    none = np.zeros(entries)
    loads = {"P": np.r_[none, pressed], "held": np.r_[held, np.zeros(nodes)]}
    for k in range(len(normal)):
        loads[f"normal {k}"] = np.r_[none, normal[k]]
        loads[f"shear {k}"] = np.r_[shear[k], np.zeros(nodes)]
    points = np.zeros((nodes, tangents + 1))
    points[:, 0] = np.arange(nodes)
    cycle = fo.LoadCycle(
        {"P": 1.0, "held": 1.0},
        [{f"shear {k}": 1.0} for k in range(len(shear))],
        fixed=[{f"normal {k}": 1.0} for k in range(len(normal))],
    )
    system = fo.ContactSystem(S, points, loads, gap=gap)
    return Case(system, cycle, rng.uniform(0.2, 0.9, nodes), kind)


def ends(
    asked: Asked, load_factor: float, starts: int, seed: int = 0, length: float = 1.0
) -> Counter[str]:
    """Outcomes of transients from no slip and from random slips of about this length."""
    rng = np.random.default_rng([seed, starts])
    found = Counter[str]()
    for start in range(starts):
        slip = length * rng.normal(size=asked[0].slip_shape) * rng.choice([0.1, 1.0])
        try:
            steady = fo.steady_state(
                *asked,
                load_factor,
                initial_slip=slip if start else None,
                progress=False,
            )
            found[steady.outcome.name] += 1
        except fo.FrictoptError as error:
            found[type(error).__name__] += 1
    return found


def works(case: Case, load_factor: float, steps: tuple[int, ...]) -> list[float]:
    """Work of friction per cycle from no slip, by increments, for some numbers of them a leg."""
    return [
        fo.steady_state(*case.asked, load_factor, steps=count, progress=False).dissipation
        for count in steps
    ]


def expected(
    limit: fo.results.ShakedownLimit, beyond: float = 10.0
) -> Iterator[tuple[float, bool]]:
    """Load factors near the ends of the safe ones, and whether the contact rests there.

    If no load factor is too large, it rests at least at `beyond`.
    """
    largest = limit.load_factor
    least = limit.least
    if np.isnan(largest):
        yield from ((0.0, False), (0.1, False))
    elif np.isinf(largest):
        yield max(beyond, 2 * least), True
    elif largest == 0:
        yield from ((0.0, True), (0.01, False), (0.1, False))
    else:
        yield largest * (1 + _APART), False
        if largest * (1 - _APART) > least:
            yield largest * (1 - _APART), True
    if 0 < least < largest:
        yield least * (1 - _APART), False


def judged(seed: int, tangents: int = 1, starts: int = 4) -> tuple[str, str, str, str]:
    """Kind, whether nodes open and close, kind of limit, and where transients disagree."""
    case = contact(seed, tangents)
    limit = fo.shakedown_limit(*case.asked, progress=False)
    wrong = []
    for load_factor, rests in expected(limit):
        found = ends(case.asked, load_factor, starts, seed)
        slips = set(found) <= {"CYCLIC_SLIP", "RATCHETING"}
        if set(found) != {"SHAKEDOWN"} if rests else not slips:
            wrong.append(f"{load_factor:.6g}: {dict(found)}, limit {limit.load_factor:.6g}")
    moves = "nodes come and go" if len(limit.events) else "none comes or goes"
    kind = "zero" if limit.load_factor == 0 else limit.kind.name
    return case.kind, moves, kind, "; ".join(wrong)


def main(first: int, count: int, tangents: int = 1) -> None:
    """Print a table of contacts, and those that disagree."""
    table = Counter[tuple[str, ...]]()
    for seed in range(first, first + count):
        kind, moves, limit, wrong = judged(seed, tangents)
        table[kind, moves, limit, "disagrees" if wrong else "agrees"] += 1
        if wrong:
            print(seed, kind, moves, limit, wrong, flush=True)
    for row, number in sorted(table.items()):
        print(*row, number, sep=" | ")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
