"""Wear of a cylinder and of a rounded punch: profiles and work of friction over the cycles, and limits before and after.

Run with `python -m studies wear [--quick]`. The cylinder (Hertz, half-width of the contact 1) is sheared by shares of gross slip, the rounded punch
is worn by the strain of the block above its shakedown limit; the coefficient of wear is 1e-3 in the units of each contact.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

import numpy as np
import pandas as pd

import frictopt as fo

from .paper import LOADS
from .tables import Study, Table, markdown, two_digits

__all__ = ["FULL", "HISTORY", "LIMITS", "PROFILES", "QUICK", "STUDY", "Parameters"]

_FRICTION, _COEFFICIENT = 0.5, 1e-3
_CYLINDER = fo.reference.LineContact(P=1.0, R=1.0, E_star=4 / pi, f=_FRICTION)


@dataclass(frozen=True)
class Parameters:
    """What the study varies."""

    nodes: int = 128
    shares: tuple[float, ...] = (0.3, 0.5, 0.7)  # of gross slip
    elements: int = 48  # of the rounded punch
    meshes: tuple[int, ...] = (16, 32, 64, 128, 256)  # nodes of the cylinder whose limit is asked
    profiles: int = 6


FULL = Parameters()
QUICK = Parameters(nodes=32, shares=(0.5, 0.7), elements=24, meshes=(16, 32, 64), profiles=4)


def _cylinder(nodes: int) -> fo.ContactSystem:
    arrays = fo.reference.half_plane_contact(nodes, 1.4, _CYLINDER.E_star, R=1.0)
    return fo.ContactSystem.from_blocks(**arrays, width=np.full(nodes, 2.8 / nodes))


def _cycle(share: float) -> fo.LoadCycle:
    return fo.LoadCycle({"P": 1.0}, [{"Q": share * _FRICTION}, {"Q": -share * _FRICTION}])


def profiles(parameters: Parameters) -> pd.DataFrame:
    """One row for each node and number of cycles, at half of gross slip."""
    history = fo.wear(_cylinder(parameters.nodes), _cycle(0.5), _FRICTION, 1.0, coefficient=_COEFFICIENT)
    largest, x = history.depth.max(axis=1), history.system.x
    chosen = np.unique([np.abs(largest - part).argmin() for part in np.linspace(0.0, largest[-1], parameters.profiles)])
    form = _CYLINDER.worn_depth(x, 0.5 * _FRICTION)
    parts = [
        pd.DataFrame(
            {
                "cycles": history.cycles[row],
                "x": x,
                "depth": history.depth[row],
                "pressure": history.pressure[row],
                "end": form,
                "residual": history.residual,
            }
        )
        for row in chosen
    ]
    return pd.concat(parts, ignore_index=True)


def histories(parameters: Parameters) -> pd.DataFrame:
    """One row for each jump of each contact."""
    punch = fo.scenes.RoundedPunch(punch=fo.scenes.PunchOnHalfPlane(elements=parameters.elements)).condense()
    above = 1.2 * fo.shakedown_limit(punch, LOADS, _FRICTION).load_factor
    asked = [(f"cylinder, {share:g} of gross slip", _cylinder(parameters.nodes), _cycle(share), 1.0) for share in parameters.shares]
    tables = []
    for name, contact, cycle, load_factor in [*asked, ("rounded punch", punch, LOADS, above)]:
        history = fo.wear(contact, cycle, _FRICTION, load_factor, coefficient=_COEFFICIENT)
        table = history.to_frame()
        tables.append(table.assign(contact=name, work_share=table["work"] / table["work"][0], residual=history.residual))
    return pd.concat(tables, ignore_index=True)[["contact", "cycles", "work_share", "largest_depth", "volume", "slipping", "residual"]]


def limits(parameters: Parameters) -> pd.DataFrame:
    """One row for each mesh of the cylinder, worn in under half of gross slip."""
    rows = []
    for nodes in parameters.meshes:
        contact = _cylinder(nodes)
        end = fo.worn_in(contact, _cycle(0.5), _FRICTION, 1.0)
        before, after = (fo.separated_limit(one, _cycle(0.5), _FRICTION).load_factor for one in (contact, end.system))
        rows.append({"nodes": nodes, "before": before, "after": after, "residual": end.residual})
    return pd.DataFrame(rows)


PROFILES = Table(
    "wear_profiles",
    "profiles of a cylinder at half of gross slip while it wears",
    {
        "cycles": "load cycles",
        "x": "place, over the half-width of the contact",
        "depth": "depth worn off",
        "pressure": "pressure at the last corner",
        "end": "depth in the end, in closed form",
        "residual": "largest residual of all steady states",
    },
    FULL,
    QUICK,
    profiles,
)
HISTORY = Table(
    "wear_history",
    "work of friction while contacts wear",
    {
        "contact": "which",
        "cycles": "load cycles",
        "work_share": "work of friction per cycle, over that of the unworn contact",
        "largest_depth": "largest depth worn off",
        "volume": "volume worn off",
        "slipping": "nodes that slip",
        "residual": "largest residual of all steady states",
    },
    FULL,
    QUICK,
    histories,
)
LIMITS = Table(
    "wear_limits",
    "limits of a cylinder before and after wear, over the load that wears it",
    {
        "nodes": "number of node pairs",
        "before": "limit with open nodes of the unworn contact",
        "after": "the same of the contact worn in",
        "residual": "largest violation of the contact law by the worn contact at rest",
    },
    FULL,
    QUICK,
    limits,
)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """How long each contact takes, and how deep it wears."""
    rows = []
    for name, table in tables[HISTORY.name].groupby("contact", sort=False):
        rows.append([str(name), f"{table['cycles'].iloc[-1]:.3g}", two_digits(table["work_share"].max()), f"{table['largest_depth'].iloc[-1]:.3g}"])
    return markdown(["contact", "cycles", "largest work over the first", "largest depth"], rows)


STUDY = Study(__name__, __doc__, "coarse meshes, in half a minute", (PROFILES, HISTORY, LIMITS), summary)
