"""The fatigue band of a rounded punch along the contact, and its largest value against the mesh.

Run with `python -m studies fatigue_band [--quick]`. The parameter of Smith, Watson and Topper is
computed in the block, on its face and below the face. The load factor is below the guaranteed
limit, so that all starts come to rest: transients from random starts must stay in the band. On the
face the largest value grows with each refinement; at a depth it converges. Lengths are divided by
the half-width a of the punch, and stresses by P / 2a. Young's modulus is 1.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import pi

import numpy as np
import pandas as pd

import frictopt as fo

from .paper import LOADS
from .progress import each
from .tables import Row, Study, Table, markdown


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    friction: float = 0.7
    load_factor: float = 0.5
    # Radius of the ends of the punch, beside a flat of half its width.
    radius: float = 1.0
    # Depth of the band along the contact, and its number of elements.
    depth: float = 0.2
    elements: int = 32
    # Number of random starts, smooth and rough, of two sizes of slip.
    starts: int = 40
    # Numbers of elements for the values under the middle, and their depths.
    meshes: tuple[int, ...] = (16, 24, 32, 48, 64, 96)
    depths: tuple[float, ...] = (0.0, 0.1, 0.2, 0.4)


FULL = Parameters()
QUICK = Parameters(elements=6, starts=4, meshes=(24, 32))


def _model(elements: int, radius: float) -> fo.fem.ContactModel:
    straight = fo.scenes.PunchOnHalfPlane(elements=elements, grading=1.0, growth=1.15)
    return fo.scenes.RoundedPunch(radius=radius, flat_half_width=0.5, punch=straight).model()


def along(parameters: Parameters) -> Iterator[Row]:
    """One row for each point, on the face and at a depth."""
    friction, load_factor = parameters.friction, parameters.load_factor
    model = _model(parameters.elements, parameters.radius)
    system = model.condense()
    guaranteed = fo.guaranteed_limit(system, LOADS, friction)
    safe = fo.shakedown_limit(system, LOADS, friction).slip
    size = float(np.abs(safe).max())
    starts = fo.starts.random_slips(system, [size, 10 * size], parameters.starts // 4)
    left = [
        fo.steady_state(system, LOADS, friction, load_factor, initial_slip=start.slip)
        for start in each([*fo.starts.no_slip(), *starts], "starts")
    ]
    for depth in (0.0, parameters.depth):
        stresses = model.stress_map(depth=depth, side=2)
        band = fo.fatigue_band(stresses, LOADS, friction, load_factor)
        seen = np.array([band.at(steady.slip) for steady in left])
        table = band.to_frame()[["x", "least", "most"]]
        yield table.assign(
            depth=depth,
            best=band.at(band.least_slip),
            assembled=seen[0],
            seen_least=seen.min(axis=0),
            seen_most=seen.max(axis=0),
            load_factor=load_factor,
            guaranteed=guaranteed.load_factor,
            residual=max(band.residual, *(steady.residual for steady in left)),
        )


def against_mesh(parameters: Parameters) -> Iterator[Row]:
    """One row for each mesh and depth, under the middle of the contact."""
    friction, load_factor = parameters.friction, parameters.load_factor
    points = [(0.0, -depth) for depth in parameters.depths]
    for elements in each(parameters.meshes, "meshes"):
        model = _model(elements, parameters.radius)
        stresses = model.stress_map(points=points, body="block")
        band = fo.fatigue_band(stresses, LOADS, friction, load_factor)
        growth = _growth(stresses, friction, load_factor)
        for depth, value in zip(parameters.depths, band.to_frame()["most"], strict=True):
            yield {
                "elements": elements,
                "size": 2 / elements,
                "depth": depth,
                "most": value,
                "growth": growth,
                "residual": band.residual,
            }


def _growth(stresses: fo.results.StressMap, friction: float, load_factor: float) -> float:
    """Growth of the largest value in the middle of the face, with ln(1 / size).

    If slip changes no pressure, the shear traction there may jump by twice the friction times the
    pressure. The strain is the strain along x.
    """
    system = stresses.system
    middle = system.nodes // 2
    pressures, strains = [], []
    for loads in LOADS.at(load_factor):
        _, p = system.reaction(loads)
        pressures.append(p[middle] / np.asarray(system.width)[middle])
        _, strain = stresses.tensors(loads, np.zeros(system.nodes))
        strains.append(strain[0, 0, 0])
    jump = 2 * friction * min(pressures)
    return float(2 / pi * jump * np.ptp(strains) / 2)


_ALONG_COLUMNS = {
    "depth": "depth of the point; 0: on the face",
    "least": "least value of this point over all states of rest",
    "best": "value in the state of rest whose largest value is least",
    "assembled": "value in the state of rest that a transient without initial slip reaches",
    "most": "largest value of this point over all states of rest",
    "seen_least": "least value of the transients",
    "seen_most": "largest value of the transients",
}
ALONG = Table(
    "fatigue_band_along",
    "one point of the block",
    _ALONG_COLUMNS,
    FULL,
    QUICK,
    along,
)
_MESH_COLUMNS = {
    "size": "element on the contact",
    "depth": "depth of the point under the middle; 0: on the face",
    "most": "largest value over all states of rest",
    "growth": "growth of `most` on the face with ln(1 / size), by the half-plane",
}
MESH = Table(
    "fatigue_band_mesh",
    "one point under the middle of the contact on one mesh",
    _MESH_COLUMNS,
    FULL,
    QUICK,
    against_mesh,
)


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """The ends of both bands, and the largest values against the mesh, in Markdown."""
    rows = []
    for depth, part in tables[ALONG.name].groupby("depth"):
        values = [part[name].max() for name in ("best", "assembled", "seen_most", "most")]
        rows.append([_place(depth), *(f"{value:.4f}" for value in values)])
    first = markdown(
        [
            "largest SWT of the contact",
            "best rest",
            "as assembled",
            "worst transient",
            "worst rest",
        ],
        rows,
    )
    table = tables[MESH.name].pivot(index="elements", columns="depth", values="most")
    second = markdown(
        ["elements", *map(_place, table.columns)],
        [[str(count), *(f"{value:.4f}" for value in row)] for count, *row in table.itertuples()],
    )
    return f"{first}\n\n{second}"


def _place(depth: float) -> str:
    return f"depth {depth:g}" if depth else "face"


STUDY = Study("studies.fatigue_band", __doc__, "coarse meshes, in seconds", (ALONG, MESH), report)
