"""All sets of open nodes: limits of small contacts against brute force, and the cost of the search.

Run with `python -m studies all_sets [--quick]`. Blocks on a rigid base and clamps of C shape are
small finite-element models that lift off (`studies/validation/blocks.py`). Contacts in space are
random, with nodes that the mean load leaves open. A set is missed if some set of open nodes has a
higher limit. The limit of each set comes from plain linear programs, in space from
`shakedown_limit` with this set. The limit of each clamp is computed twice, after different changes
of its last digits. Only the column of seconds depends on the machine.
"""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo
from studies.progress import each
from studies.tables import Row, Study, Table, markdown

from .blocks import Case, block, clamp, in_space
from .stays_open import intervals, intervals_in_space, reach


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Numbers of nodes, and how many contacts have each.
    blocks: tuple[tuple[int, int], ...] = (
        *((nodes, 100) for nodes in (4, 5, 6, 7)),
        *((nodes, 20) for nodes in (8, 10, 12, 14)),
    )
    in_space: tuple[tuple[int, int], ...] = tuple((nodes, 20) for nodes in (4, 5, 6, 7, 8))
    clamps: int = 20
    # Largest numbers of nodes, in the plane and in space, for which every set is tried.
    tried: tuple[int, int] = (8, 6)
    first_seed: int = 40_000
    # Relative size of the changes of a clamp.
    noise: float = 1e-7


FULL = Parameters()
QUICK = Parameters(((4, 3), (6, 2)), ((4, 1),), clamps=1)


def _cases(parameters: Parameters) -> Iterator[tuple[str, int, int, list[Case]]]:
    """Family, nodes and seed of each contact, and its copies that must have the same answer."""
    seed = parameters.first_seed
    for nodes, count in parameters.blocks:
        for _ in range(count):
            seed += 1
            yield "block", nodes, seed, [block(seed, nodes)]
    for nodes, count in parameters.in_space:
        for _ in range(count):
            seed += 1
            yield "in space", nodes, seed, [in_space(seed, nodes)]
    for number in range(parameters.clamps):
        yield "clamp", 14, number, [clamp(number, parameters.noise, member) for member in (1, 2)]


def contacts(parameters: Parameters) -> Iterator[Row]:
    """One row for each contact."""
    for family, nodes, seed, copies in each(list(_cases(parameters)), "contacts"):
        limits = []
        seconds = []
        for copy in copies:
            with threadpool_limits(1):
                start = time.process_time()
                limits.append(fo.shakedown_limit(*copy, progress=False))
                seconds.append(time.process_time() - start)
        limit = limits[0]
        plane = family != "in space"
        every = np.nan
        if nodes <= parameters.tried[0 if plane else 1]:
            known = list(intervals(*copies[0]) if plane else intervals_in_space(*copies[0]))
            # Without a safe load factor the search begins anywhere.
            every = reach(known, 0.0 if np.isnan(limit.load_factor) else limit.load_factor)
            if not known:
                every = np.nan
        yield {
            "family": family,
            "nodes": nodes,
            "seed": seed,
            "load_factor": limit.load_factor,
            "every_set": every,
            "other_digits": limits[-1].load_factor,
            "bound_of_sets": limit.bound_of_sets,
            "best_of_all": all(one.best_of_all for one in limits),
            "open": int(limit.open.sum()),
            "programs": max(one.programs for one in limits),
            "seconds": max(seconds),
            "residual": limit.residual,
        }


def missed(table: pd.DataFrame) -> pd.Series:
    """Whether some set of open nodes has a limit that is larger by a share of more than 1e-6."""
    best = table["every_set"].fillna(0.0)
    return best > table["load_factor"].fillna(0.0) * (1 + 1e-6) + 1e-9


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """Counts and costs for each family and number of nodes, in Markdown."""
    table = tables[CONTACTS.name]
    apart = (table["other_digits"] / table["load_factor"] - 1).abs() > 1e-4
    table = table.assign(missed=missed(table), apart=apart)
    lines = []
    for (family, nodes), rows in table.groupby(["family", "nodes"], sort=False):
        tried = int(rows["every_set"].notna().sum())
        lines.append(
            [
                f"{family}, {nodes} nodes",
                str(len(rows)),
                f"{int(rows['missed'].sum())} of {tried}" if tried else "-",
                str(int((~rows["best_of_all"]).sum())),
                str(int(rows["apart"].sum())) if family == "clamp" else "-",
                f"{rows['programs'].median():.0f}",
                str(rows["programs"].max()),
                f"{rows['seconds'].median():.2g}",
                f"{rows['seconds'].max():.2g}",
            ]
        )
    head = [
        "contacts",
        "number",
        "missed",
        "not proven",
        "two answers",
        "programs, median",
        "most",
        "seconds, median",
        "most",
    ]
    return markdown(head, lines)


CONTACTS = Table(
    "all_sets",
    "one contact",
    {
        "family": "'block' and 'clamp' in the plane, 'in space' a random contact",
        "seed": "of the contact in its family",
        "every_set": "best limit over every set of open nodes by brute force; NaN if no load factor is safe, or of large contacts",
        "other_digits": "limit of the same clamp with other changes of its last digits",
        "bound_of_sets": "load factor that no set of open nodes exceeds",
        "best_of_all": "whether the limit is proven to be the best of all sets",
        "open": "nodes that stay open at the limit",
        "programs": "programs of the search",
        "seconds": "processor time of the limit",
    },
    full=FULL,
    quick=QUICK,
    compute=contacts,
)
STUDY = Study(
    "studies.validation.all_sets",
    __doc__,
    "few contacts of each kind, in seconds",
    (CONTACTS,),
    report,
)
