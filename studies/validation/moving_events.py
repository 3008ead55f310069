"""Random coupled contacts whose nodes open and close in each cycle, compared with transients.

`contact` makes the contact of a seed. `python -m studies.validation.moving_events FIRST COUNT`
prints how many limits are larger with events, and how many contacts shake down above their limit
from some start. `limits_of_two_materials` computes the limits of a cylinder for several values of
Dundurs' constant.
"""

import sys
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

import frictopt as fo

from .moving_areas import Case, definite

KINDS = ("around an area", "there and back", "static shear")
# The corners that the load visits, by kind.
_VISITED = {"around an area": "0123", "there and back": "0121", "static shear": "012"}
# Multiples of a limit at which transients are followed, and the number of starts at each.
ABOVE = (1.01, 1.1, 1.3, 1.6, 2.0, 3.0)
_STARTS = 4


def contact(seed: int, kind: str) -> Case:
    """The contact of a seed: 2 to 4 nodes, 3 or 4 corners.

    "there and back" returns along the same two segments. The load factor of "static shear" scales a
    static shear, while normal loads vary.
    """
    rng = np.random.default_rng([75, 4, seed])
    nodes = int(rng.integers(2, 5))
    none = np.zeros(nodes)
    S = definite(rng, 2 * nodes)
    loads = {"mean": (0.1 * rng.normal(size=nodes), rng.uniform(0.3, 1.5, nodes))}
    for k in range(4):
        shear = none if kind == "static shear" else rng.normal(size=nodes)
        loads[f"{k}"] = shear, rng.normal(size=nodes)
    loads["shear"] = rng.normal(size=nodes), none

    corners = [{k: 1.0} for k in _VISITED[kind]]
    cycle = fo.LoadCycle({"mean": 1.0}, corners)
    if kind == "static shear":
        cycle = fo.LoadCycle({"mean": 1.0}, [{"shear": 1.0}] * len(corners), fixed=corners)
    bonded = {name: np.concatenate(part) for name, part in loads.items()}
    gap = rng.uniform(0.0, 0.3, nodes) * (rng.random(nodes) < 0.2)
    points = np.column_stack([np.arange(float(nodes)), none])
    system = fo.ContactSystem(S, points, bonded, gap=gap)
    return Case(system, cycle, rng.uniform(0.2, 0.7, nodes), kind)


def rests_above(
    case: Case, load_factor: float, seed: int = 0, multiples: Sequence[float] = ABOVE
) -> list[float]:
    """The multiples of a load factor at which a transient from some start shakes down."""
    rng = np.random.default_rng([76, seed])
    at_rest = list[float]()
    for multiple in multiples:
        for number in range(_STARTS):
            slip = None if number == 0 else 0.5 * rng.normal(size=case.system.nodes)
            try:
                steady = fo.steady_state(
                    *case.arguments, multiple * load_factor, initial_slip=slip, progress=False
                )
            except fo.FrictoptError:
                continue
            if steady.outcome is fo.Outcome.SHAKEDOWN:
                at_rest.append(multiple)
                break
    return at_rest


# A cylinder of radius and modulus 1: this force presses it to a half-width of 1.
PRESS = np.pi / 4
FRICTION = 0.35
# The pressure varies in phase with a shear that the load factor scales.
IN_PHASE = fo.LoadCycle(
    {"P": PRESS},
    [{"Q": -0.4 * PRESS}, {"Q": 0.4 * PRESS}],
    fixed=[{"P": -0.2 * PRESS}, {"P": 0.2 * PRESS}],
)
# The cylinder rolls to and fro, while the load factor scales a static shear.
ROLLS = fo.LoadCycle({"P": PRESS}, [{"Q": PRESS}] * 2, fixed=[{"roll": -0.35}, {"roll": 0.35}])


def out_of_phase(phase: float, corners: int = 8, shear: float = 0.4) -> fo.LoadCycle:
    """A shear in units of P, and a fixed normal load of P +- P / 5.

    The normal load leads the shear by `phase` degrees.
    """
    angles = 2 * np.pi * np.arange(corners) / corners
    pressed = 0.2 * PRESS * np.cos(angles + np.deg2rad(phase))
    return fo.LoadCycle(
        {"P": PRESS},
        [{"Q": shear * PRESS * float(np.cos(angle))} for angle in angles],
        fixed=[{"P": float(part)} for part in pressed],
    )


def cylinder(cells: int, half_length: float, beta: float = 0.0) -> fo.ContactSystem:
    """A cylinder on a half-plane; "roll" shifts its pressure by a length."""
    arrays = fo.reference.half_plane_contact(cells, half_length, 1.0, R=1.0, beta=beta)
    system = fo.ContactSystem.from_blocks(**arrays)
    rolls = system.B.T @ system.x, system.C @ system.x
    return system.with_bonded({**system.bonded, "roll": rolls})


def limits_of_two_materials(betas: Iterable[float], cells: int = 20) -> pd.DataFrame:
    """Limits with events of a cylinder; columns beta, in_phase, rolls."""
    rows = []
    for beta in betas:
        row = {"beta": beta}
        for name, half_length, cycle in (("in_phase", 1.6, IN_PHASE), ("rolls", 1.8, ROLLS)):
            pressed = cylinder(cells, half_length, beta)
            limit = fo.shakedown_limit(pressed, cycle, FRICTION, events=True, progress=False)
            row[name] = limit.load_factor
        rows.append(row)
    return pd.DataFrame(rows)


def main(first: int, count: int) -> None:
    """Print a table of contacts, and the ratios by which events raise limits."""
    table = Counter[tuple[str, ...]]()
    gains = list[float]()
    for seed in range(first, first + count):
        case = contact(seed, KINDS[seed % len(KINDS)])
        without_events = fo.shakedown_limit(*case.arguments, progress=False).load_factor
        limit = fo.shakedown_limit(*case.arguments, events=True, progress=False)
        assert not without_events > limit.load_factor * (1 + 1e-9)
        if np.isinf(without_events):
            table[case.kind, "infinite without events"] += 1
            continue
        gain = "none"
        if not limit.load_factor <= without_events * (1 + 1e-6):
            gain = "by events" if not limit.events.empty else "by another set"
        if np.isinf(limit.load_factor):
            gain += ", infinite"
        elif gain == "by events" and without_events > 0:
            gains.append(limit.load_factor / without_events)
        above = ""
        if 0 < limit.load_factor < np.inf and rests_above(case, limit.load_factor, seed):
            above = "some start rests above"
        if np.isnan(limit.load_factor):
            gain = "still nan"
        known = "nan" if np.isnan(without_events) else "finite"
        table[case.kind, f"{known} without events", gain, above] += 1
    for row, number in sorted(table.items()):
        print(number, *row, sep=" | ")
    print("gains:", np.round(sorted(gains), 3).tolist())


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
