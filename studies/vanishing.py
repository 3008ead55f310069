"""Cyclic slip just above the guaranteed limit in space: its amplitude, and the room of the nodes.

Run with `python -m studies vanishing [--quick]`. The contacts are the contacts of `python -m
studies followed` whose two limits differ. One transient starts from the witness at each distance
above the guaranteed limit, with one increment per segment. Room is the pressure of a slipping node
in excess of the pressure that it needs without slip. According to theory, cyclic slip whose
amplitude vanishes leaves some node no room (`docs/writeups/guaranteed-in-space.md`). That the
amplitude does vanish is an observation. A second table has the guaranteed limit and the shakedown
limit for a few meshes of `python -m studies space`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.limits.guarantee.critical_state import needed
from frictopt.limits.program.question import pose
from studies.validation.followed import random_contact

from . import space
from .progress import each
from .tables import Row, Study, Table, markdown, two_digits

# Least and largest ratio of the two limits of the followed contacts.
_APART = 0.01, 0.97


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Number of random contacts, with seeds from 0 on.
    contacts: int = 100
    # Distances of the load factors from the guaranteed limit, relative to it.
    distances: tuple[float, ...] = (0.016, 0.008, 0.004, 0.002)
    # Meshes of the square punch.
    meshes: tuple[int, ...] = (4, 6, 8, 10)
    # Meshes of the sphere.
    cells: tuple[int, ...] = (9,)


FULL = Parameters()
QUICK = Parameters(contacts=8, distances=(0.008, 0.004), meshes=(2,), cells=(5,))


def followed(parameters: Parameters) -> Iterator[Row]:
    """One row for each contact and distance."""
    with threadpool_limits(1):
        for seed in each(range(parameters.contacts), "contacts followed"):
            system, cycle, friction = random_contact(seed)
            limit = fo.guaranteed_limit(system, cycle, friction)
            if _APART[0] < limit.load_factor / limit.shakedown.load_factor < _APART[1]:
                for distance in parameters.distances:
                    yield {"seed": seed, "nodes": system.nodes, "distance": distance} | _above(
                        limit, distance
                    )


def _above(limit: fo.results.GuaranteedLimit, distance: float) -> dict[str, Any]:
    system, cycle, friction = limit.system, limit.cycle, limit.friction
    load_factor = limit.least + (1 + distance) * (limit.load_factor - limit.least)
    steady = fo.steady_state(system, cycle, friction, load_factor, initial_slip=limit.slip, steps=1)
    path, corners = steady.states(), len(cycle.corners)
    moved = np.linalg.norm(path.slip - path.slip[0], axis=-1).max(axis=0)
    of_corner = (np.round(path.time).astype(int) - 1) % corners
    # The least pressure of each node without the cyclic load.
    least = (path.p - load_factor * cycle.corner_reactions(system)[1][of_corner]).min(axis=0)
    question = pose(system, cycle, friction)
    needed_bounds = needed(friction, question.q1, question.p1)[1]
    room = least - load_factor * needed_bounds / friction
    slips = moved > 1e-6 * moved.max()
    return {
        "amplitude": float(moved.max() / limit.largest_slip),
        "room": float(np.abs(room[slips]).min() / np.abs(cycle.mean_reaction(system)[1]).mean()),
        "outcome": steady.outcome.name,
        "residual": max(limit.residual, steady.residual),
    }


def limits(parameters: Parameters) -> Iterator[Row]:
    """One row for each contact, mesh and load cycle."""
    yield from space.against_mesh(
        space.Parameters(meshes=parameters.meshes, cells=parameters.cells)
    )


_COLUMNS = {
    "seed": "of the contact",
    "distance": "of the load factor above the guaranteed limit, over it",
    "amplitude": "largest distance of two slips of a node in the steady cycle, over the largest slip of the witness",
    "room": "least pressure, over the mean one, that a node that slips has beyond what it needs without slip",
    "outcome": "of the transient",
}
VANISHING = Table(
    "vanishing", "one contact at one distance", _COLUMNS, full=FULL, quick=QUICK, compute=followed
)
LIMITS = Table(
    "vanishing_limits", space.MESH.about, space.MESH.columns, full=FULL, quick=QUICK, compute=limits
)


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """Medians by distance, and exponents, in Markdown."""
    table = tables[VANISHING.name]
    rows = [
        [
            f"{100 * distance:g} %",
            str(len(part)),
            str(int((part["outcome"] == "CYCLIC_SLIP").sum())),
        ]
        + [f"{part[name].median():.1e}, {part[name].max():.1e}" for name in ("amplitude", "room")]
        for distance, part in table.groupby("distance", sort=False)
    ]
    named = [
        "above the guaranteed limit",
        "contacts",
        "slip for ever",
        "amplitude: median, largest",
        "room: median, largest",
    ]
    powers = [
        np.polyfit(np.log(part["distance"]), np.log(part["amplitude"]), 1)[0]
        for _, part in table.groupby("seed")
    ]
    low, middle, high = np.quantile(powers, (0.0, 0.5, 1.0))
    told = f"The amplitude goes with the distance to the power {two_digits(middle)} (median; least {two_digits(low)}, largest {two_digits(high)})."
    of_meshes = space.limits_over_mesh(tables[LIMITS.name])
    return f"{markdown(named, rows)}\n\n{told}\n\n{of_meshes}"


STUDY = Study("studies.vanishing", __doc__, "few contacts, in seconds", (VANISHING, LIMITS), report)
