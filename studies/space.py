"""Shakedown and guaranteed limits in three dimensions, and the work of friction between the two limits.

Run with `python -m studies space [--quick]`. The limits of a square punch and of a sphere are
computed against friction and mesh. Bulk stress and shear of the square punch are in units of the
mean pressure. The shear of the sphere moves its far end, in units of its approach.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from .progress import each
from .tables import Row, Study, Table, markdown, two_digits


def _circle(corners: int) -> list[tuple[float, float]]:
    angles = 2 * np.pi * np.arange(corners) / corners
    # Rounding leaves tiny amplitudes, which are set to 0.
    return [(round(float(np.cos(angle)), 15), round(float(np.sin(angle)), 15)) for angle in angles]


def _shears(mean: str, x: str, y: str) -> dict[str, fo.LoadCycle]:
    """Shear along both axes, by name."""
    corners = {
        "to and fro": _circle(2),
        "turning, 4 corners": _circle(4),
        "turning, 16 corners": _circle(16),
    }
    return {
        name: fo.LoadCycle({mean: 1.0}, [{x: first, y: second} for first, second in of])
        for name, of in corners.items()
    }


LOADS: Mapping[str, fo.LoadCycle] = {
    "bulk": fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}]),
    **_shears("P", "Qx", "Qy"),
}
"""Load cycles of the punch by name: bulk stress, and shear on the top."""


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Number of elements along a side of the punch.
    elements: int = 10
    frictions: tuple[float, ...] = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.25, 1.5)
    friction: float = 0.5
    meshes: tuple[int, ...] = (4, 6, 8, 10, 14, 18)
    # Numbers of cells along the diameter of the sphere's contact.
    cells: tuple[int, ...] = (9, 13, 17, 21, 25)
    work_elements: int = 3
    # Load factors relative to lambda_2.
    ratios: tuple[float, ...] = (0.7, 0.8, 0.85, 0.9, 0.95, 1.05, 1.1, 1.2)
    # Number of random starts.
    starts: int = 8


FULL = Parameters()
QUICK = Parameters(
    elements=2,
    frictions=(0.2, 0.5),
    meshes=(2, 3),
    cells=(5, 7),
    work_elements=2,
    ratios=(0.95, 1.2),
    starts=2,
)


def _punch(elements: int) -> tuple[fo.ContactSystem, Mapping[str, fo.LoadCycle]]:
    return fo.scenes.SquarePunch(elements=elements).condense(), LOADS


def _sphere(cells: int) -> tuple[fo.ContactSystem, Mapping[str, fo.LoadCycle]]:
    arrays: dict[str, Any] = fo.reference.half_space_contact(
        cells=cells, half_length=1.1, R=1.0, E=1.0, nu=0.3
    )
    return fo.ContactSystem(**arrays), _shears("approach", "x", "y")


def _limits(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float) -> dict[str, float]:
    shakedown = fo.shakedown_limit(system, cycle, friction)
    guaranteed = fo.guaranteed_limit(system, cycle, friction)
    return {
        "onset": fo.onset(system, cycle, friction).slip.load_factor,
        "guaranteed": guaranteed.load_factor,
        "shakedown": shakedown.load_factor,
        "residual": max(shakedown.residual, guaranteed.residual),
    }


def against_friction(parameters: Parameters) -> pd.DataFrame:
    """One row for each load cycle and friction coefficient."""
    system, cycles = _punch(parameters.elements)
    asked = [(load, friction) for load in cycles for friction in parameters.frictions]
    shown = each(asked, "limits against friction")
    return pd.DataFrame(
        [
            {"load": load, "friction": friction} | _limits(system, cycles[load], friction)
            for load, friction in shown
        ]
    )


def against_mesh(parameters: Parameters) -> Iterator[Row]:
    """One row for each contact, mesh and load cycle."""
    asked = [("square punch", _punch, count) for count in parameters.meshes] + [
        ("sphere", _sphere, count) for count in parameters.cells
    ]
    for scene, contact, count in each(asked, "limits against the mesh"):
        system, cycles = contact(count)
        for load, cycle in cycles.items():
            yield {"scene": scene, "nodes": system.nodes, "load": load} | _limits(
                system, cycle, parameters.friction
            )


def work_between(parameters: Parameters) -> Iterator[Row]:
    """One row for each load factor of bulk stress.

    A row has the work without initial slip, and the least and the most work of all starts.
    """
    system, _ = _punch(parameters.work_elements)
    limit = fo.shakedown_limit(system, LOADS["bulk"], parameters.friction)
    guaranteed = fo.guaranteed_limit(system, LOADS["bulk"], parameters.friction)
    # Root mean square of the safe slip at the limit.
    size = float(np.sqrt(np.mean(np.sum(limit.slip**2, axis=1))))
    starts = [*fo.starts.no_slip(), *fo.starts.random_slips(system, [size], parameters.starts // 2)]
    factors = [ratio * limit.load_factor for ratio in parameters.ratios]
    table = fo.dissipation_study(system, LOADS["bulk"], parameters.friction, factors, starts=starts)
    for ratio, (_, runs) in zip(parameters.ratios, table.groupby("load_factor"), strict=True):
        work = runs["dissipation"]
        yield {
            "ratio": ratio,
            "guaranteed": guaranteed.load_factor / limit.load_factor,
            "work": work[runs["start"] == "none"].iloc[0],
            "least": work.min(),
            "most": work.max(),
            "residual": runs["residual"].max(),
        }


FRICTION = Table(
    "space_friction", "limits of a square punch at one friction", {}, FULL, QUICK, against_friction
)
MESH = Table(
    "space_mesh",
    "limits of one contact on one mesh",
    {"scene": '"square punch" or "sphere"'},
    FULL,
    QUICK,
    against_mesh,
)
_WORK_COLUMNS = {
    "ratio": "load factor over lambda_2",
    "guaranteed": "lambda_1 over lambda_2",
    "work": "work of friction per cycle from no slip",
    "least": "least of all starts",
    "most": "most of all starts",
}
WORK = Table(
    "space_work",
    "steady work of friction of a square punch under bulk stress at one load factor",
    _WORK_COLUMNS,
    FULL,
    QUICK,
    work_between,
)


def limits_over_mesh(mesh: pd.DataFrame) -> str:
    """Limits over the mesh, in Markdown."""
    rows = [
        [
            f"{scene}, {load}",
            str(row["nodes"]),
            *(two_digits(row[name]) for name in ("onset", "guaranteed", "shakedown")),
        ]
        for (scene, load), part in mesh.groupby(["scene", "load"], sort=False)
        for _, row in part.iterrows()
    ]
    return markdown(["contact and load", "N", "onset", "lambda_1", "lambda_2"], rows)


STUDY = Study(
    "studies.space",
    __doc__,
    "coarse meshes, in seconds",
    (FRICTION, MESH, WORK),
    lambda tables: limits_over_mesh(tables[MESH.name]),
)
