"""Random uncoupled contacts whose normal loads open and close nodes, compared with transients.

`contact` makes the contact of a seed. `compared` compares its limit with the outcomes of transients
from several starts, just below the limit and just above it.
`python -m studies.validation.moving_areas FIRST COUNT` prints a table, and each contact that disagrees.
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
# Relative distance of the transients from the limit.
_APART = 0.01

# The arguments of a question: system, cycle and friction.
Arguments: TypeAlias = tuple[fo.ContactSystem, fo.LoadCycle, NDArray[Any]]


@dataclass(frozen=True)
class Case:
    """A contact, its load cycle, its friction and its kind."""

    system: fo.ContactSystem
    cycle: fo.LoadCycle
    friction: NDArray[Any]
    kind: str

    @property
    def arguments(self) -> Arguments:
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
    # One node has much pressure, so that it usually stays closed.
    pressed[rng.integers(nodes)] += 2.0
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
    arguments: Arguments, load_factor: float, starts: int, seed: int = 0, length: float = 1.0
) -> Counter[str]:
    """Outcomes of transients; the first one starts without slip, the others from random slips.

    The random slips are about as large as `length`.
    """
    rng = np.random.default_rng([seed, starts])
    outcomes = Counter[str]()
    for start in range(starts):
        slip = length * rng.normal(size=arguments[0].slip_shape) * rng.choice([0.1, 1.0])
        try:
            steady = fo.steady_state(
                *arguments,
                load_factor,
                initial_slip=slip if start else None,
                progress=False,
            )
            outcomes[steady.outcome.name] += 1
        except fo.FrictoptError as error:
            outcomes[type(error).__name__] += 1
    return outcomes


def agrees(outcomes: Counter[str], at_rest: bool) -> bool:
    """Whether all transients shake down, or all continue to slip if `at_rest` is False."""
    if at_rest:
        return set(outcomes) == {"SHAKEDOWN"}
    return set(outcomes) <= {"CYCLIC_SLIP", "RATCHETING"}


def works(case: Case, load_factor: float, steps: tuple[int, ...]) -> list[float]:
    """Work of friction per cycle without initial slip, for several numbers of increments."""
    return [
        fo.steady_state(*case.arguments, load_factor, steps=count, progress=False).dissipation
        for count in steps
    ]


def expected(
    limit: fo.results.ShakedownLimit, beyond: float = 10.0
) -> Iterator[tuple[float, bool]]:
    """Load factors near the ends of the safe load factors, and whether the contact shakes down.

    If all load factors are safe, it shakes down at least at `beyond`.
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


def compared(seed: int, tangents: int = 1, starts: int = 4) -> tuple[str, str, str, str]:
    """Kind, whether nodes open and close, kind of limit, and the transients that disagree."""
    case = contact(seed, tangents)
    limit = fo.shakedown_limit(*case.arguments, progress=False)
    wrong = []
    for load_factor, at_rest in expected(limit):
        outcomes = ends(case.arguments, load_factor, starts, seed)
        if not agrees(outcomes, at_rest):
            wrong.append(f"{load_factor:.6g}: {dict(outcomes)}, limit {limit.load_factor:.6g}")
    moves = "nodes come and go" if len(limit.events) else "none comes or goes"
    kind = "zero" if limit.load_factor == 0 else limit.kind.name
    return case.kind, moves, kind, "; ".join(wrong)


def main(first: int, count: int, tangents: int = 1) -> None:
    """Print a table of contacts, and each contact that disagrees."""
    table = Counter[tuple[str, ...]]()
    for seed in range(first, first + count):
        kind, moves, limit, wrong = compared(seed, tangents)
        table[kind, moves, limit, "disagrees" if wrong else "agrees"] += 1
        if wrong:
            print(seed, kind, moves, limit, wrong, flush=True)
    for row, number in sorted(table.items()):
        print(*row, number, sep=" | ")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
