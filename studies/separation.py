"""Limits of contacts that open: rounded punches, a cylinder, a flat punch, and a pin.

Run with `python -m studies separation [--quick]`. If the pressure falls to zero at the edge of the
contact, the continuum slips there at any cyclic load. The limit then depends on the mesh, and falls
as elements shrink. The limit of the cylinder falls in proportion to the size of the cells: the
pressure at the edge varies as the root of the distance from the edge, and the bonded shear as one
over this root. Partial slip (Cattaneo 1938, Mindlin 1949: c/a = sqrt(1 - Q/(f P)) in two
dimensions) then reaches just one cell.

The flat punch at high friction and the pin are closed under the mean load. Yet, with nodes that
open and close in each cycle, they shake down above the limit with all nodes closed. The limit with
these nodes is compared with transients from its slip. The load factor is sigma / (P / 2a) for a
punch, Q / (f P) for the cylinder, and force divided by overlap of the fit for the pin.
"""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from .paper import LOADS
from .progress import each
from .tables import Row, Study, Table, markdown, two_digits

# Radius and half-length of the cylinder. E* is 1, and P makes the half-width of the contact 1.
_RADIUS, _HALF_LENGTH = 1.0, 2.0
_CYLINDER_FRICTION = 0.5
# Load factors relative to the shakedown limit, for contacts that are closed under the mean load.
_BEYOND = 1.5


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Numbers of cells of the cylinder's interface, which is twice as long as the contact.
    cells: tuple[int, ...] = (20, 28, 40, 56, 80, 112, 160, 224)
    # Numbers of elements of the punches, grading 3.
    elements: tuple[int, ...] = (16, 24, 32, 48, 64, 96)
    # Roundings s: the gap is s (|x| / a - 0.6)^2 in units of a P / (2a E).
    roundings: tuple[float, ...] = (2.0, 20.0, 100.0, 1000.0)
    friction: float = 0.6
    # Frictions of the rounded punch.
    frictions: tuple[float, ...] = tuple(round(float(f), 6) for f in np.arange(0.2, 1.2001, 0.2))
    friction_elements: int = 48
    flat_elements: int = 20
    flat_frictions: tuple[float, ...] = (1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0)
    pin_elements: int = 40
    pin_frictions: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)
    # Number of load factors before the bisection.
    closed_scan: int = 100


FULL = Parameters()
QUICK = Parameters(
    cells=(20, 40, 80),
    elements=(24, 32),
    roundings=(20.0, 100.0),
    frictions=(0.4, 0.6),
    friction_elements=24,
    flat_elements=12,
    flat_frictions=(1.5, 2.0),
    pin_elements=16,
    pin_frictions=(0.3, 0.5),
    closed_scan=10,
)


def _row(contact: fo.ContactSystem, cycle: fo.LoadCycle, friction: float) -> dict[str, Any]:
    begin = time.perf_counter()
    limit = fo.shakedown_limit(contact, cycle, friction)
    return {
        "nodes": contact.nodes,
        "friction": friction,
        "shakedown": limit.load_factor,
        "bound": limit.bound,
        "open": int(limit.open.sum()),
        "residual": limit.residual,
        "seconds": time.perf_counter() - begin,
    }


def cylinder(parameters: Parameters) -> Iterator[Row]:
    """One row per mesh."""
    # The half-width a is 1: P = pi E* a^2 / (4 R).
    pressure = np.pi / 4
    loads = fo.LoadCycle(
        {"P": pressure},
        [{"Q": -_CYLINDER_FRICTION * pressure}, {"Q": _CYLINDER_FRICTION * pressure}],
    )
    for cells in each(parameters.cells, "cylinder"):
        contact = fo.ContactSystem.from_blocks(
            **fo.reference.half_plane_contact(cells, _HALF_LENGTH, 1.0, R=_RADIUS)
        )
        yield {"size": 2 * _HALF_LENGTH / cells} | _row(contact, loads, _CYLINDER_FRICTION)


def rounded(parameters: Parameters) -> Iterator[Row]:
    """One row per mesh, rounding and friction coefficient."""
    asked = [
        (elements, size, parameters.friction)
        for elements in parameters.elements
        for size in parameters.roundings
    ]
    asked += [
        (parameters.friction_elements, size, friction)
        for friction in parameters.frictions
        for size in parameters.roundings
    ]
    scenes = {
        elements: fo.scenes.PunchOnHalfPlane(elements=elements, grading=3).condense()
        for elements in {elements for elements, _, _ in asked}
    }
    for elements, size, friction in each(dict.fromkeys(asked), "rounded punch"):
        contact = scenes[elements].with_gap(
            size * np.maximum(np.abs(scenes[elements].x) - 0.6, 0.0) ** 2
        )
        yield {"elements": elements, "rounding": size} | _row(contact, LOADS, friction)


def closed(parameters: Parameters) -> Iterator[Row]:
    """One row per scene and friction coefficient."""
    punch = fo.scenes.PunchOnHalfPlane(elements=parameters.flat_elements)
    pin = fo.scenes.PinInPlate(elements=parameters.pin_elements)
    fit = fo.LoadCycle({"fit": 1.0}, [{"Fx": -1.0}, {"Fx": 1.0}])
    for name, scene, cycle, frictions in (
        ("flat punch", punch, LOADS, parameters.flat_frictions),
        ("pin", pin, fit, parameters.pin_frictions),
    ):
        contact = scene.condense()
        for friction in each(frictions, name):
            limit = fo.shakedown_limit(contact, cycle, friction, events=True)
            closed = fo.shakedown_limit(
                contact, cycle, friction, open_nodes=np.zeros(contact.nodes, dtype=bool)
            )
            largest, scan = _BEYOND * limit.load_factor, parameters.closed_scan
            rests = fo.limit_after_protocol(limit, start=limit.slip, up_to=largest, scan=scan)
            found = {
                "shakedown": limit.load_factor,
                "bound": limit.bound,
                "all_closed": closed.load_factor,
            }
            more = found | {"opening": limit.events["node"].nunique(), "rests": rests.load_factor}
            yield {"scene": name} | _row(contact, cycle, friction) | more


def exponent(sizes: Any, limits: Any) -> float:
    """Exponent of the limit in the size of the mesh, by a least-squares fit of the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(limits), 1)[0])


_COLUMNS = {
    "shakedown": "shakedown limit of the best set of nodes that stay open, the others closed and stuck",
    "bound": "upper bound with the same nodes open",
    "open": "nodes that stay open",
}
_CYLINDER_COLUMNS = {"size": "cell over the half-width of the contact"} | _COLUMNS
CYLINDER = Table(
    "separation_cylinder",
    "limit of a cylinder on a half-plane under tangential load, Q / (f P)",
    _CYLINDER_COLUMNS,
    FULL,
    QUICK,
    cylinder,
)
_ROUNDED_COLUMNS = {"rounding": "s of the gap s (|x| / a - 0.6)^2, over a P / (2a E)"} | _COLUMNS
ROUNDED = Table(
    "separation_rounded",
    "limit of a punch with rounded edges, sigma / (P / 2a)",
    _ROUNDED_COLUMNS,
    FULL,
    QUICK,
    rounded,
)
_CLOSED_COLUMNS = (
    {"scene": "flat punch, sigma / (P / 2a); or pin, force over overlap"}
    | _COLUMNS
    | {
        "shakedown": "shakedown limit, with nodes that open and close in each cycle",
        "bound": "upper bound with the same order of openings",
        "all_closed": "the limit with all nodes closed",
        "opening": "nodes that open and close in each cycle",
        "rests": "load factor up to which transients from the slip of the limit come to rest",
    }
)
CLOSED = Table(
    "separation_closed",
    "limits of contacts that are closed under the mean load",
    _CLOSED_COLUMNS,
    FULL,
    QUICK,
    closed,
)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """Exponents of the limit in the mesh size, for the cylinder and for each rounding."""
    line, punches = tables[CYLINDER.name], tables[ROUNDED.name]
    rows = [["cylinder", two_digits(exponent(line["size"], line["shakedown"])), "1"]]
    parameters = punches[punches["friction"] == FULL.friction]
    for size, group in parameters.groupby("rounding"):
        rows.append(
            [
                f"rounded punch, s = {size:g}",
                two_digits(exponent(1 / group["elements"], group["shakedown"])),
                "",
            ]
        )
    return markdown(["contact", "exponent of the limit in h", "expected"], rows)


STUDY = Study(
    __name__, __doc__, "few and coarse meshes, in a minute", (CYLINDER, ROUNDED, CLOSED), summary
)
