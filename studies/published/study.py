"""Results of others beside frictopt: nodes, cylinders, spheres, joints, and the corner of a punch.

Run with `python -m studies published [--quick]`. It prints a table in Markdown: for each result the
value with the largest difference. The result of others is a closed form or a rule, evaluated here.
The result of frictopt is computed on the named mesh.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pandas as pd

from ..progress import each
from ..tables import Row, Study, Table, markdown
from . import half_planes, joints, nodes, oscillator, spheres
from .case import Case

# Number of points of a curve of others.
_POINTS = 61
_ENDS = {"least": "idxmin", "most": "idxmax"}


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    of_nodes: nodes.Parameters = field(default_factory=nodes.Parameters)
    of_half_planes: half_planes.Parameters = field(default_factory=half_planes.Parameters)
    of_spheres: spheres.Parameters = field(default_factory=spheres.Parameters)
    of_joints: joints.Parameters = field(default_factory=joints.Parameters)
    of_oscillator: oscillator.Parameters = field(default_factory=oscillator.Parameters)


FULL = Parameters()
QUICK = Parameters(
    nodes.Parameters(
        frictions=(0.2, 0.6), angles=(60.0,), phases=(0.0, 60.0, 90.0), points=32, bisections=11
    ),
    half_planes.Parameters(
        cells=60,
        shears=(0.5, 0.95),
        bulks=(0.0, 0.5),
        swings=(0.1, 0.3),
        phases=(0.0, 90.0),
        points=16,
        springs=300,
    ),
    spheres.Parameters(cells=(10, 11), shears=(0.8,), sticks=(0.3, 0.7)),
    joints.Parameters(
        slider_loads=(0.2, 0.5),
        rod_nodes=8,
        rod_loads=(0.5, 1.0),
        beam_elements=20,
        beam_length=10.0,
        beam_loads=(1.5, 3.0),
        lap_elements=40,
        lap_thickness=0.1,
        lap_loads=(0.6, 0.95),
        corner_elements=32,
        corner_grading=20.0,
        law_elements=24,
        law_gradings=(10.0, 100.0),
        law_frictions=(0.3,),
    ),
    oscillator.Parameters(forces=(1200.0,)),
)


@cache
def cases(parameters: Parameters) -> tuple[Case, ...]:
    """The cases of all files."""
    rooms: tuple[Callable[[], Iterator[Case]], ...] = (
        lambda: nodes.cases(parameters.of_nodes),
        lambda: half_planes.cases(parameters.of_half_planes),
        lambda: spheres.cases(parameters.of_spheres),
        lambda: joints.cases(parameters.of_joints),
        lambda: oscillator.cases(parameters.of_oscillator),
    )
    return tuple(case for room in each(rooms, "results of others") for case in room())


def compared(parameters: Parameters) -> Iterator[Row]:
    """One row per result and value of its parameter."""
    for case in cases(parameters):
        theirs = [case.theirs(at) for at in case.at]
        size = max(map(abs, theirs)) or 1.0
        for at, known, ours in zip(case.at, theirs, case.ours, strict=True):
            named = {
                "source": case.source,
                "quantity": case.quantity,
                "over": case.over,
                "at": at,
                "theirs": known,
                "ours": ours,
            }
            yield named | {
                "difference": (ours - known) / size,
                "how": case.how,
                "residual": case.residual,
            }


def curves(parameters: Parameters) -> Iterator[Row]:
    """One row per point of each result of others that is a curve."""
    for case in cases(parameters):
        if case.curve and len(case.at) > 1:
            named = {"source": case.source, "quantity": case.quantity, "residual": case.residual}
            yield from [
                named | {"at": at, "theirs": case.theirs(at)}
                for at in np.linspace(case.at[0], case.at[-1], _POINTS)
            ]


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """The row with the largest difference, for each result."""
    rows = []
    for (source, quantity), part in tables[COMPARED.name].groupby(
        ["source", "quantity"], sort=False
    ):
        worst = part.loc[part["difference"].abs().idxmax()]
        at = f"{worst['over']} = {worst['at']:g}" if worst["over"] else ""
        if len(part) > 1:
            at += f", worst of {len(part)}"
        difference = (
            f"{100 * worst['difference']:+.2g} %"
            if abs(worst["difference"]) > 1e-6
            else "less than 1e-6"
        )
        rows.append(
            [
                str(source),
                str(quantity),
                at,
                f"{worst['theirs']:.6g}",
                f"{worst['ours']:.6g}",
                difference,
                str(worst["how"]),
            ]
        )
    table, said = tables[COMPARED.name], []
    for what in ("a node", "a cylinder under loads"):
        work = table[
            table["quantity"].str.startswith(f"work of friction per cycle of {what}")
        ].set_index("at")
        ends = (
            f"{name} at {work['theirs'].agg(which):g} (theirs) and {work['ours'].agg(which):g} "
            "(ours)"
            for name, which in _ENDS.items()
        )
        said.append(f"{', '.join(ends)} of {' '.join(what.split()[:2])}")
    head = [
        "source",
        "quantity",
        "at",
        "theirs",
        "ours",
        "difference",
        "how ours is made, and why it differs",
    ]
    return f"{markdown(head, rows)}\n\nOf these phases of the normal load, in degrees, the work of friction is {'; '.join(said)}."


_COLUMNS = {
    "source": "whose result it is",
    "quantity": "what is compared",
    "over": "what varies; empty for one number",
    "at": "its value",
    "theirs": "the result of others there",
    "ours": "the answer of frictopt",
    "difference": "ours less theirs, over the largest of theirs",
    "how": "what ours is made with, and why it differs",
}
COMPARED = Table(
    "published", "one result of others at one value of what varies", _COLUMNS, FULL, QUICK, compared
)
CURVES = Table(
    "published_curves",
    "one point of a curve of others",
    {name: _COLUMNS[name] for name in ("source", "quantity", "at", "theirs")},
    FULL,
    QUICK,
    curves,
)

STUDY = Study(
    "studies.published", __doc__, "coarse meshes, in seconds", (COMPARED, CURVES), summary
)
