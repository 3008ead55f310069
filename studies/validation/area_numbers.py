"""Limits of moving contact areas beside closed forms, and a search of states of rest above limits.

`python -m studies.validation.area_numbers [SEED [COUNT]]` prints three tables:

- limits of a cylinder whose area moves, beside their closed forms (`closed_forms`);
- limits of a cylinder of two materials for several values of Dundurs' constant;
- COUNT random cylinders, pads and twins whose nodes open and close (`contact`). The table counts
  the contacts for which a transient from some start shakes down above the limit with events.

`studies.validation.moving_areas`, `studies.validation.rest_intervals` and `studies.validation.moving_events` have random
contacts of other kinds.
"""

import sys
from collections import Counter

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.limits import normal_path, pose

from .moving_areas import Case, definite
from .moving_events import (
    ABOVE,
    FRICTION,
    IN_PHASE,
    PRESS,
    ROLLS,
    cylinder,
    limits_of_two_materials,
    out_of_phase,
    rests_above,
)

KINDS = ("cylinder", "pad", "twins")
# A transient that shakes down just above a limit would show that another order of events has a
# higher limit.
_ABOVE = (1.001, *ABOVE)
_BETAS = (0.0, 0.05, 0.1, 0.2, 0.3)
_PHASES = (10, 45, 90)
# Length in half-widths by which the cylinder rolls to and fro in `ROLLS`.
_ROLL = 0.35


def closed_forms(cells: int, seed: int) -> pd.DataFrame:
    """Limits of a cylinder beside known values; columns contact, known, limit, work at 0.001.

    The number of cells limits only the accuracy of a rolling cylinder. `seed` determines the cycle
    of a cylinder that rolls and is pressed at random.
    """
    pressed = cylinder(cells, 1.6)
    rolling = cylinder(cells, 1.8)
    in_phase = FRICTION * 0.2 / 0.4
    swept = _ROLL * np.sqrt(1 - _ROLL**2) + np.arcsin(_ROLL)
    rolls = FRICTION * (1 - 2 / np.pi * swept)
    cases = [
        ("in phase, 2 corners", pressed, IN_PHASE, in_phase),
        ("in phase, 8 corners", pressed, out_of_phase(0.0), in_phase),
        ("rolls", rolling, ROLLS, rolls),
    ]
    rows: list[dict[str, object]] = []
    for name, system, cycle, known in cases:
        limit = fo.shakedown_limit(system, cycle, FRICTION, progress=False)
        rows.append({"contact": name, "known": known, "limit": limit.load_factor})
    for phase in _PHASES:
        cycle = out_of_phase(phase)
        limit = fo.shakedown_limit(pressed, cycle, FRICTION, progress=False)
        steady = fo.steady_state(pressed, cycle, FRICTION, 0.001, progress=False)
        row = {"contact": f"phase {phase} degrees", "known": 0.0, "limit": limit.load_factor}
        rows.append({**row, "work at 0.001": steady.dissipation})

    rng = np.random.default_rng([75, 11, seed])
    corners = int(rng.integers(2, 7))
    fixed = [
        {"roll": float(rng.uniform(-0.4, 0.4)), "P": float(rng.uniform(-0.3, 0.3)) * PRESS}
        for _ in range(corners)
    ]
    cycle = fo.LoadCycle({"P": PRESS}, [{"Q": PRESS}] * corners, fixed=fixed)
    system = cylinder(cells, 1.9)
    limit = fo.shakedown_limit(system, cycle, FRICTION, progress=False)
    normal = pose(system, cycle, FRICTION).r0[:, -1]
    least = normal_path(system.C, normal).pressure.min(axis=0)
    known = FRICTION * float(least.sum()) / PRESS
    name = f"rolls and presses at random, {corners} corners"
    rows.append({"contact": name, "known": known, "limit": limit.load_factor})
    return pd.DataFrame(rows)


def contact(seed: int) -> Case:
    """A contact whose nodes open and close, under a scaled load to and fro.

    "cylinder" and "pad", a flat contact that is tilted, are of two materials. "twins" are two equal
    random contacts that are far apart.
    """
    rng = np.random.default_rng([75, 12, seed])
    kind = KINDS[seed % len(KINDS)]
    friction = rng.uniform(0.2, 0.7)
    if kind == "twins":
        nodes = int(rng.integers(2, 4))
        S = np.kron(np.eye(2), definite(rng, 2 * nodes))
        entries = np.arange(4 * nodes).reshape(2, 2, nodes).swapaxes(0, 1).ravel()
        S = S[np.ix_(entries, entries)]
        load = np.tile(rng.normal(size=(2, nodes)) * [[0.5], [1.0]], 2).ravel()
        pressed = np.tile(rng.uniform(0.3, 1.5, nodes), 2)
        points = np.column_stack([np.arange(2.0 * nodes), np.zeros(2 * nodes)])
        loads = {"P": np.r_[np.zeros(2 * nodes), pressed], "cyclic": load}
        cycle = fo.LoadCycle({"P": 1.0}, [{"cyclic": 1.0}, {"cyclic": -1.0}])
        return Case(fo.ContactSystem(S, points, loads), cycle, np.full(2 * nodes, friction), kind)

    cells = 8
    beta = float(rng.uniform(0.0, 0.2))
    if kind == "cylinder":
        system = cylinder(cells, 1.6, beta)
        moved = {"P": PRESS * float(rng.uniform(-0.6, 0.6))}
    else:
        arrays = fo.reference.half_plane_contact(cells, 1.0, 1.0, beta=beta)
        system = fo.ContactSystem.from_blocks(**arrays)
        tilt = system.B.T @ system.x, system.C @ system.x
        system = system.with_bonded({**system.bonded, "tilt": tilt})
        moved = {"tilt": float(rng.uniform(-1.0, 1.0))}
    moved["Q"] = PRESS * float(rng.uniform(0.1, 1.0))
    back = {case: -value for case, value in moved.items()}
    cycle = fo.LoadCycle({"P": PRESS}, [moved, back])
    return Case(system, cycle, np.full(system.nodes, friction), kind)


def main(seed: int = 0, count: int = 200, cells: int = 160) -> None:
    """Print the three tables."""
    print(closed_forms(cells, seed).to_string(index=False))
    print(limits_of_two_materials(_BETAS).to_string(index=False), flush=True)
    table = Counter[tuple[str, ...]]()
    for number in range(seed, seed + count):
        case = contact(number)
        limit = fo.shakedown_limit(*case.arguments, events=True, progress=False)
        events = "some nodes open and close" if len(limit.events) else "no events"
        above = list[float]()
        if 0 < limit.load_factor < np.inf:
            above = rests_above(case, limit.load_factor, number, _ABOVE)
        if above:
            print(number, case.kind, limit.load_factor, "rests at multiples", above, flush=True)
        kind = limit.kind.name
        table[case.kind, kind, events, "some start rests above" if above else ""] += 1
    for row, contacts in sorted(table.items()):
        print(contacts, *row, sep=" | ")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
