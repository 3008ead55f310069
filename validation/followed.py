"""The guaranteed limit in three dimensions, followed: transients of random coupled contacts just below it and, from its witness, just above.

Run with `python -m studies followed [--quick]`; it prints the counts in Markdown. That nothing
slips for ever below the limit of a coupled contact is an observation, and here is what it was seen
on. Each transient takes one increment from corner to corner, in which slip begins and ends at the
same load as in many.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo
from studies.progress import each
from studies.tables import Row, Study, Table, markdown

_NONE = 0.01  # limits below this share of lambda_2 leave no load factors to follow
# powers of ten of the size of random slips, over the largest slip of the witness
_DECADES = (-1.0, 1.0)


@dataclass(frozen=True)
class Parameters:
    """What the study varies."""

    contacts: int = 300
    seed: int = 0  # of the first contact; the others have the next seeds
    starts: int = 3  # random ones below each limit, beside the witness
    below: float = 0.995  # load factors, over the limit
    above: float = 1.005


FULL = Parameters()
QUICK = Parameters(contacts=6, starts=1)


def random_contact(
    seed: int, most: int = 8, corners: int | None = None
) -> tuple[fo.ContactSystem, fo.LoadCycle, np.ndarray]:
    """A coupled contact of 1 to `most` nodes, its load cycle of 2 to 5 corners with their mean at the mean load, and its friction (N,)."""
    rng = np.random.default_rng(seed)
    nodes, corners = int(rng.integers(1, most + 1)), corners or int(rng.integers(2, 6))
    G = rng.normal(size=(3 * nodes, 3 * nodes))
    loads = np.hstack(
        [rng.normal(size=(corners, 2 * nodes)), 0.2 * rng.normal(size=(corners, nodes))]
    )
    bonded = {f"c{k}": load for k, load in enumerate(loads - loads.mean(axis=0))} | {
        "P": np.r_[np.zeros(2 * nodes), 1 + rng.random(nodes)]
    }
    system = fo.ContactSystem(
        G @ G.T / (3 * nodes) + 0.5 * np.eye(3 * nodes), rng.normal(size=(nodes, 3)), bonded
    )
    return (
        system,
        fo.LoadCycle({"P": 1.0}, [{f"c{k}": 1.0} for k in range(corners)]),
        rng.uniform(0.2, 0.7, nodes),
    )


def followed(parameters: Parameters) -> Iterator[Row]:
    """One row for each transient."""
    with threadpool_limits(1):
        for seed in each(
            range(parameters.seed, parameters.seed + parameters.contacts), "contacts followed"
        ):
            yield from _of_contact(seed, parameters)


def _of_contact(seed: int, parameters: Parameters) -> list[dict[str, object]]:
    system, cycle, friction = random_contact(seed)
    limit, rng = fo.guaranteed_limit(system, cycle, friction), np.random.default_rng(seed)
    lambda_1, lambda_2, least = limit.load_factor, limit.shakedown.load_factor, limit.least
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
    random = [
        limit.largest_slip * 10 ** rng.uniform(*_DECADES) * rng.normal(size=(system.nodes, 2))
        for _ in range(parameters.starts)
    ]
    asked = [
        (parameters.below, "witness", limit.slip),
        *((parameters.below, "random", slip) for slip in random),
    ]
    rows = []
    for share, start, slip in [*asked, (parameters.above, "witness", limit.slip)]:
        steady = fo.steady_state(
            system, cycle, friction, least + share * (lambda_1 - least), initial_slip=slip, steps=1
        )
        work = {"work": steady.dissipation, "work_error": steady.work_error}
        rows.append(
            head
            | {"share": share, "start": start, "outcome": steady.outcome.name}
            | work
            | {"residual": steady.residual}
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
    dying = ~rests & (table["work_error"] >= 1)  # what slip is left is within its error
    near = table["guaranteed"] > 0.99 * table["shakedown"]
    kinds = {
        "below, from the witness": (table["share"] < 1) & (table["start"] == "witness"),
        "below, from random slips": (table["share"] < 1) & (table["start"] == "random"),
        "above, from the witness, $\\lambda_1 \\le 0.99\\, \\lambda_2$": (table["share"] > 1)
        & ~near,
        "above, from the witness, $\\lambda_1 > 0.99\\, \\lambda_2$": (table["share"] > 1) & near,
    }
    rows = [
        [name, *(str(int((of & which).sum())) for which in (of, rests, dying, ~rests & ~dying))]
        for name, of in kinds.items()
    ]
    none = int((table["start"] == "none").sum())
    counted = f"{table['seed'].nunique()} contacts, of which {none} have a limit of about 0 and no load factors below it."
    return f"{markdown(['transients', 'number', 'come to rest', 'slip within its error', 'slip for ever'], rows)}\n\n{counted}"


STUDY = Study("validation.followed", __doc__, "few contacts, in seconds", (FOLLOWED,), report)
