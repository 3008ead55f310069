"""The effect of Poisson's ratio, the element and the corner on the limits of the paper's scene.

Run with `python -m studies validity [--quick]`; it prints two tables in Markdown. Linear elements
lock as Poisson's ratio approaches 0.5, elements with averaged dilatation do not. The guaranteed
limit falls with the corner element. It jumps up at the friction above which the corner node only
lifts off. Its values are from the study "guaranteed".
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
import pandas as pd

import frictopt as fo

from . import guaranteed
from .paper import LOADS
from .progress import each
from .tables import Row, Study, Table, markdown

# Poisson's ratio with which the others are compared.
_USUAL = 0.3
# A guaranteed limit has jumped up if it is at least this many times as large as all limits before
# it.
_JUMP = 1.5


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Number of elements with the default grading.
    elements: int = 124
    kinds: tuple[Literal["linear", "mean_dilatation"], ...] = ("linear", "mean_dilatation")
    ratios: tuple[float, ...] = (0.0, 0.1, _USUAL, 0.4, 0.45, 0.49, 0.4999)
    frictions: tuple[float, ...] = (0.3, 0.5, 0.7)


FULL = Parameters()
QUICK = Parameters(elements=16, ratios=(0.1, _USUAL, 0.4999))


def limits(parameters: Parameters) -> Iterator[Row]:
    """One row per element, Poisson's ratio and friction coefficient."""
    for element, nu in each(list(product(parameters.kinds, parameters.ratios)), "Poisson's ratio"):
        material = fo.fem.Material(nu=nu)
        scene = fo.scenes.PunchOnHalfPlane(
            elements=parameters.elements,
            punch_material=material,
            block_material=material,
            element=element,
        )
        system = scene.condense()
        for friction in parameters.frictions:
            limit = fo.shakedown_limit(system, LOADS, friction)
            yield {
                "element": element,
                "nu": nu,
                "friction": friction,
                "load_factor": limit.load_factor,
                "residual": limit.residual,
            }


_POISSON_COLUMNS = {
    "element": "kind of element",
    "nu": "Poisson's ratio of both bodies",
}
POISSON = Table(
    "validity_poisson",
    "shakedown limit with one kind of element at one Poisson's ratio and friction",
    _POISSON_COLUMNS,
    FULL,
    QUICK,
    limits,
)


def jump(rows: pd.DataFrame) -> tuple[float, float] | None:
    """The two neighbouring frictions between which the guaranteed limit of a mesh jumps up.

    None if the largest rise is no jump above all values before it.
    """
    ordered = rows.sort_values("friction")
    friction = ordered["friction"].to_numpy()
    limit = ordered["guaranteed"].to_numpy()
    k = int(np.diff(limit).argmax())
    if limit[k + 1] > _JUMP * limit[: k + 1].max():
        return float(friction[k]), float(friction[k + 1])
    return None


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """Both tables."""
    limits = tables[POISSON.name].pivot(
        index=["element", "nu"], columns="friction", values="load_factor"
    )
    rows = []
    for element, nu in limits.index:
        change = 100 * (limits.loc[element, nu] / limits.loc[element, _USUAL] - 1)
        rows.append([str(element), f"{nu:g}", *(f"{value:+.1f} %" for value in change)])
    first = markdown(
        [
            "element",
            r"Poisson's ratio",
            *(f"$\\lambda_2$ at f = {friction:g}" for friction in limits.columns),
        ],
        rows,
    )
    rows = []
    for size, mesh in sorted(tables[guaranteed.FRICTION.name].groupby("corner_size"), reverse=True):
        between = jump(mesh)
        rows.append(
            [f"{size:.2g}", "no jump" if between is None else "f = {:g} to {:g}".format(*between)]
        )
    return f"{first}\n\n{markdown(['corner element / a', 'guaranteed limit jumps up from'], rows)}"


STUDY = Study(
    "studies.validity",
    __doc__,
    "a coarse mesh, in seconds",
    (POISSON,),
    summary,
    needs=(guaranteed.FRICTION,),
)
