"""Transients of random contacts in three dimensions, just below and just above the guaranteed limit.

Run with `python -m studies followed [--quick]`; it prints the counts in Markdown. No coupled
contact was seen to slip for ever below its guaranteed limit. That is an observation, and this study
makes it. Just above the limit, transients start from its witness. Each transient takes one
increment per segment, because the number of increments does not affect whether slip persists.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo
from studies.progress import each
from studies.tables import Row, Study, Table, markdown

# A guaranteed limit below this share of the shakedown limit leaves no load factors to follow.
_NONE = 0.01
# Powers of ten of the size of random slips, relative to the largest slip of the witness.
_DECADES = (-1.0, 1.0)


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study.

    `seed` is the seed of the first contact; each further contact has the next seed. Below each
    limit, transients start from the witness and from `starts` random slips. The load factors
    `below` and `above` are relative to the limit.
    """

    contacts: int = 300
    seed: int = 0
    starts: int = 3
    below: float = 0.995
    above: float = 1.005


FULL = Parameters()
QUICK = Parameters(contacts=6, starts=1)


def random_contact(
    seed: int, most: int = 8, corners: int | None = None
) -> tuple[fo.ContactSystem, fo.LoadCycle, np.ndarray]:
    """A coupled contact of 1 to `most` nodes, its load cycle, and its friction (N,).

    The cycle has 2 to 5 corners, whose mean is the mean load.
    """
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(1, most + 1))
    corners = corners or int(rng.integers(2, 6))
    G = rng.normal(size=(3 * nodes, 3 * nodes))
    shears = rng.normal(size=(corners, 2 * nodes))
    pressures = 0.2 * rng.normal(size=(corners, nodes))
    loads = np.hstack([shears, pressures])
    bonded = {f"c{k}": load for k, load in enumerate(loads - loads.mean(axis=0))}
    bonded["P"] = np.r_[np.zeros(2 * nodes), 1 + rng.random(nodes)]
    S = G @ G.T / (3 * nodes) + 0.5 * np.eye(3 * nodes)
    system = fo.ContactSystem(S, rng.normal(size=(nodes, 3)), bonded)
    cycle = fo.LoadCycle({"P": 1.0}, [{f"c{k}": 1.0} for k in range(corners)])
    return system, cycle, rng.uniform(0.2, 0.7, nodes)


def followed(parameters: Parameters) -> Iterator[Row]:
    """One row for each transient."""
    seeds = range(parameters.seed, parameters.seed + parameters.contacts)
    with threadpool_limits(1):
        for seed in each(seeds, "contacts followed"):
            yield from _of_contact(seed, parameters)


def _of_contact(seed: int, parameters: Parameters) -> list[dict[str, object]]:
    """The rows of one contact."""
    system, cycle, friction = random_contact(seed)
    limit = fo.guaranteed_limit(system, cycle, friction)
    rng = np.random.default_rng(seed)
    lambda_1 = limit.load_factor
    lambda_2 = limit.shakedown.load_factor
    least = limit.least
    head = {
        "seed": seed,
        "nodes": system.nodes,
        "corners": len(cycle.corners),
        "guaranteed": lambda_1,
        "shakedown": lambda_2,
    }
    if lambda_1 <= _NONE * lambda_2:
        return [
            head
            | {
                "share": 0.0,
                "start": "none",
                "outcome": "not followed",
                "work": 0.0,
                "work_error": 0.0,
                "residual": limit.residual,
            }
        ]
    transients = [(parameters.below, "witness", limit.slip)]
    for _ in range(parameters.starts):
        size = limit.largest_slip * 10 ** rng.uniform(*_DECADES)
        slip = size * rng.normal(size=(system.nodes, 2))
        transients.append((parameters.below, "random", slip))
    transients.append((parameters.above, "witness", limit.slip))
    rows = []
    for share, start, slip in transients:
        load_factor = least + share * (lambda_1 - least)
        steady = fo.steady_state(system, cycle, friction, load_factor, initial_slip=slip, steps=1)
        rows.append(
            head
            | {
                "share": share,
                "start": start,
                "outcome": steady.outcome.name,
                "work": steady.dissipation,
                "work_error": steady.work_error,
                "residual": steady.residual,
            }
        )
    return rows


_COLUMNS = {
    "seed": "of the contact",
    "corners": "of its load cycle",
    "share": "load factor over lambda_1, from the least safe one on",
    "start": "witness, random, or none where lambda_1 is about 0 and nothing was followed",
    "outcome": "of the transient",
    "work": "of friction in its steady cycle",
    "work_error": "error of the work, over the work",
}
FOLLOWED = Table(
    "followed",
    "one transient of one random contact",
    _COLUMNS,
    full=FULL,
    quick=QUICK,
    compute=followed,
)


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """Counts of the transients, in Markdown."""
    table = tables[FOLLOWED.name]
    rests = table["outcome"] == fo.Outcome.SHAKEDOWN.name
    # The remaining slip of these transients is within its error.
    dying = ~rests & (table["work_error"] >= 1)
    near = table["guaranteed"] > 0.99 * table["shakedown"]
    kinds = {
        "below, from the witness": (table["share"] < 1) & (table["start"] == "witness"),
        "below, from random slips": (table["share"] < 1) & (table["start"] == "random"),
        "above, from the witness, $\\lambda_1 \\le 0.99\\, \\lambda_2$": (table["share"] > 1)
        & ~near,
        "above, from the witness, $\\lambda_1 > 0.99\\, \\lambda_2$": (table["share"] > 1) & near,
    }
    rows = []
    for name, of_kind in kinds.items():
        counts = [
            int((of_kind & selected).sum()) for selected in (of_kind, rests, dying, ~rests & ~dying)
        ]
        rows.append([name, *map(str, counts)])
    none = int((table["start"] == "none").sum())
    counted = f"{table['seed'].nunique()} contacts, of which {none} have a limit of about 0 and no load factors below it."
    return f"{markdown(['transients', 'number', 'come to rest', 'slip within its error', 'slip for ever'], rows)}\n\n{counted}"


STUDY = Study(
    "studies.validation.followed", __doc__, "few contacts, in seconds", (FOLLOWED,), report
)
