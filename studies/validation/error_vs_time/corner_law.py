"""The power law of the shakedown limit in the size of the corner element; the limit has no value without a mesh.

At the limit the corner slides, while its bonded tractions grow as `r ** (l_bonded - 1)`: the limit goes with the size h of the corner element as
`h ** (l_sliding - l_bonded)`, with the exponents of the sliding and of the bonded corner (closed forms), for friction below the traction ratio
0.543 of the bonded corner.
"""

from functools import partial
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.reference import bonded_corner, sliding_corner_exponent

from ...clock import timed
from ...paper import LOADS
from .parameters import Parameters


def corner_law(parameters: Parameters) -> pd.DataFrame:
    """One row per friction and mesh, from the coarsest corner to the finest: the limit, its exponent between neighbouring meshes, and their time."""
    rows: list[dict[str, Any]] = []
    for grading in parameters.law_gradings:
        scene = fo.scenes.PunchOnHalfPlane(elements=parameters.law_elements, grading=grading)
        condensed = timed(scene.condense, 1)
        for friction in parameters.law_frictions:
            limit = timed(partial(fo.shakedown_limit, condensed.answer, LOADS, friction), 1)
            rows.append(
                {
                    "friction": friction,
                    "elements": parameters.law_elements,
                    "grading": grading,
                    "corner_size": scene.corner_size / scene.half_width,
                    "load_factor": limit.answer.load_factor,
                    "residual": limit.answer.residual,
                    "seconds": condensed.seconds + limit.seconds,
                }
            )
    table = pd.DataFrame(rows).sort_values(["friction", "corner_size"], ascending=[True, False], kind="stable")
    bonded = bonded_corner()[0].exponent
    table["expected"] = [sliding_corner_exponent(friction) - bonded for friction in table["friction"]]
    table["exponent"] = table.groupby("friction", group_keys=False)[["load_factor", "corner_size"]].apply(_slopes)
    table["error"] = (table["exponent"] - table["expected"]).abs()
    return table


def _slopes(rows: pd.DataFrame) -> pd.Series:
    """Exponent between each mesh and the one before; NaN for the first."""
    logs = np.log(rows)
    return logs["load_factor"].diff() / logs["corner_size"].diff()
