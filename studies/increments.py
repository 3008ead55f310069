"""The exact path of the paper's scene above the shakedown limit: the way into the steady cycle.

Run with `python -m studies increments [--quick]`. The study "error_vs_time" has the cost and the
errors of increments.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from .paper import LOADS, force_unit, slip_unit, work_unit
from .tables import Row, Study, Table


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    friction: float = 0.7
    # Load factor relative to the shakedown limit.
    overload: float = 1.4
    # Number of elements with the default grading.
    elements: int = 124
    # Number of cycles; the last one is taken as the steady cycle.
    cycles: int = 20
    # Instants of the cycle, in load corners visited. Most slip happens late.
    instants: tuple[float, ...] = (0.0, 0.5, 0.75, 0.9, 1.0, 1.5, 1.75, 1.9, 2.0)
    # Number of cycles of the history before the steady cycle.
    first_cycles: int = 3
    # Place of the inner node divided by a; the nearest node is taken.
    inner_x: float = -0.9


FULL = Parameters()
QUICK = Parameters(elements=16)


@dataclass(frozen=True)
class _Case:
    """The scene under the loads of the study, and its exact path without initial slip."""

    scene: fo.scenes.PunchOnHalfPlane
    system: fo.ContactSystem
    friction: float
    load_factor: float
    path: fo.results.Trajectory


@cache
def _case(parameters: Parameters) -> _Case:
    scene = fo.scenes.PunchOnHalfPlane(elements=parameters.elements)
    friction = parameters.friction
    system = scene.condense()
    load_factor = parameters.overload * fo.shakedown_limit(system, LOADS, friction).load_factor
    return _Case(
        scene,
        system,
        friction,
        load_factor,
        fo.march(system, LOADS, friction, load_factor, cycles=parameters.cycles),
    )


def steady_cycle(parameters: Parameters) -> Iterator[Row]:
    """One row per instant and node.

    Linear interpolation is exact, because the path is linear in time between events.
    """
    case = _case(parameters)
    path = case.path
    start = (parameters.cycles - 1) * len(LOADS.corners)
    for instant in parameters.instants:
        at = start + instant
        found = (_sigma(path), path.q, path.p, path.slip)
        sigma, q, p, slip = (
            np.array([np.interp(at, path.time, column) for column in values.T]) for values in found
        )
        # The status of an interval lasts until the event at or after the instant.
        state = np.searchsorted(path.time, at - 1e-9) - 1
        ratio = np.divide(
            q, case.friction * p, out=np.full_like(q, np.nan), where=p > 1e-9 * np.mean(p)
        )
        part = _states(case, at, float(sigma[0]), q, p, slip, path.status[state])
        yield part.assign(instant=instant, ratio=ratio, x=case.system.x / case.scene.half_width)


def corner_history(parameters: Parameters) -> Iterator[Row]:
    """One row per node and state of the exact path, from the mean load on.

    The first cycles come first, then the steady cycle.
    """
    case = _case(parameters)
    path = case.path
    corners = len(LOADS.corners)
    first = path.time <= parameters.first_cycles * corners
    steady = path.time >= (parameters.cycles - 1) * corners
    for node in (
        0,
        int(np.argmin(np.abs(case.system.x / case.scene.half_width - parameters.inner_x))),
    ):
        for name, rows in (("first", first), ("steady", steady)):
            found = (values[rows, node] for values in (path.q, path.p, path.slip, path.status))
            part = _states(case, path.time[rows], _sigma(path)[rows, 0], *found)
            work = path.work[rows, node] / work_unit(case.system)
            yield part.assign(
                work=work, cycles=name, node=node, x=case.system.x[node] / case.scene.half_width
            )


def _sigma(path: fo.results.Trajectory) -> Any:
    """(T, 1) bulk stress over P / 2a."""
    return path.amplitudes[:, [list(path.system.bonded).index("sigma")]]


def _states(
    case: _Case, times: Any, sigma: Any, q: Any, p: Any, slip: Any, status: Any
) -> pd.DataFrame:
    """Columns that the two tables of the steady cycle share."""
    columns = {
        "elements": case.scene.elements,
        "friction": case.friction,
        "load_factor": case.load_factor,
        "time": times,
        "sigma": sigma,
        "q": q / force_unit(case.system),
        "p": p / force_unit(case.system),
        "slip": slip / slip_unit(case.system),
        "status": status,
        "residual": case.path.residual,
    }
    return pd.DataFrame(columns)


_CYCLE = {
    "instant": "load corners visited since the beginning of the cycle",
    "ratio": "q / (f p); NaN where p vanishes",
    "status": "0 stick, +1 and -1 slip along +x and against it, 2 open: just before the instant",
}
_HISTORY = {"cycles": "'first' or 'steady'", "work": "work of friction so far / (P^2 / E*)"}

CYCLE = Table(
    "increments_cycle",
    "one node at one instant of the steady cycle",
    _CYCLE,
    full=FULL,
    quick=QUICK,
    compute=steady_cycle,
)
CORNER = Table(
    "increments_corner",
    "one node after one event of the exact path",
    _HISTORY,
    full=FULL,
    quick=QUICK,
    compute=corner_history,
)

STUDY = Study("studies.increments", __doc__, "a coarse mesh, in seconds", (CYCLE, CORNER))
