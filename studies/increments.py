"""Transients of the paper's scene above the shakedown limit: error and time of increments against the exact path, and the steady cycle.

Run with `python -m studies increments [--quick]`. Both engines that march in increments refine every increment to rounding, so the number of
increments is all there is to choose: no tolerance of a solver shows in the table of errors. Its column of seconds depends on the machine.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

import frictopt as fo

from .clock import timed
from .paper import LOADS, force_unit, slip_unit, work_unit
from .tables import Row, Study, Table


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    friction: float = 0.7
    overload: float = 1.4  # load factor over the shakedown limit
    elements: tuple[int, ...] = (16, 40, 124)  # of the table of errors; all meshes have the default grading
    qp_steps: tuple[int, ...] = (2, 5, 10, 20, 40, 80)  # increments from corner to corner
    milp_steps: tuple[int, ...] = (2, 5, 10, 20)
    repetitions: int = 3  # of a timing at most
    cycle_elements: int = 124  # of the two tables of the steady cycle
    cycles: int = 20  # the last one of so many is the steady one
    instants: tuple[float, ...] = (0.0, 0.5, 0.75, 0.9, 1.0, 1.5, 1.75, 1.9, 2.0)  # of the cycle, in load corners visited; most slip comes late
    first_cycles: int = 3  # cycles of the history before the steady one
    inner_x: float = -0.9  # the inner node is the one nearest to it, over a


FULL = Parameters()
QUICK = Parameters(elements=(8, 16), qp_steps=(5, 10, 20, 40), milp_steps=(5,), repetitions=1, cycle_elements=16)


@dataclass(frozen=True)
class _Case:
    """One mesh under the loads of the study."""

    scene: fo.scenes.PunchOnHalfPlane
    system: fo.ContactSystem
    friction: float
    load_factor: float

    def march(self, cycles: int, engine: Any = "path", steps: int | None = None) -> fo.results.Trajectory:
        """The transient from no initial slip."""
        return fo.march(self.system, LOADS, self.friction, self.load_factor, cycles=cycles, engine=engine, steps=steps)


def _case(parameters: Parameters, elements: int) -> _Case:
    scene = fo.scenes.PunchOnHalfPlane(elements=elements)
    system = scene.condense()
    limit = fo.shakedown_limit(system, LOADS, parameters.friction)
    return _Case(scene, system, parameters.friction, parameters.overload * limit.load_factor)


def error_by_increments(parameters: Parameters) -> pd.DataFrame:
    """One row per mesh, engine and number of increments; the exact path first. All runs take two cycles."""
    cases = {elements: _case(parameters, elements) for elements in parameters.elements}
    runs: list[tuple[int, str, int]] = []
    for elements in parameters.elements:
        runs.append((elements, "path", 0))
        runs += [(elements, "qp", steps) for steps in parameters.qp_steps]
        runs += [(elements, "milp", steps) for steps in parameters.milp_steps]
    with threadpool_limits(1):
        exact = {elements: case.march(2) for elements, case in cases.items()}  # before any timing: compiles the path
        rows = [_error(parameters, cases[run[0]], exact[run[0]], *run) for run in tqdm(runs, desc="error by increments", disable=None)]
    return pd.DataFrame(rows)


def _error(parameters: Parameters, case: _Case, exact: fo.results.Trajectory, elements: int, engine: str, steps: int) -> dict[str, Any]:
    made = timed(partial(case.march, 2, engine, steps or None), parameters.repetitions)
    run = made.answer
    work, exact_work = (float(trajectory.cycle_work[1].sum()) for trajectory in (run, exact))
    error = np.max(np.abs(run.energy_error)) / work if engine == "path" else abs(work / exact_work - 1)
    return {
        "elements": elements,
        "engine": engine,
        "steps": steps,
        "work": work / work_unit(case.system),
        "error": float(error),
        "slip_error": float(np.max(np.abs(run.slip[-1] - exact.slip[-1])) / np.max(np.abs(exact.slip[-1]))),
        "residual": run.residual,
        "seconds": made.seconds,
    }


def steady_cycle(parameters: Parameters) -> Iterator[Row]:
    """One row per instant and node. Between events the exact path is linear in time, and so is the interpolation."""
    case = _case(parameters, parameters.cycle_elements)
    path = case.march(parameters.cycles)
    start = (parameters.cycles - 1) * len(LOADS.corners)
    for instant in parameters.instants:
        at = start + instant
        found = (_sigma(path), path.q, path.p, path.slip)
        sigma, q, p, slip = (np.array([np.interp(at, path.time, column) for column in values.T]) for values in found)
        state = np.searchsorted(path.time, at - 1e-9) - 1  # its status lasts until the event at or after the instant
        ratio = np.divide(q, case.friction * p, out=np.full_like(q, np.nan), where=p > 1e-9 * np.mean(p))
        part = _states(case, path, at, float(sigma[0]), q, p, slip, path.status[state])
        yield part.assign(instant=instant, ratio=ratio, x=case.system.x / case.scene.half_width)


def corner_history(parameters: Parameters) -> Iterator[Row]:
    """One row per node and state of the exact path, from the mean load on: the first cycles, then the steady one."""
    case = _case(parameters, parameters.cycle_elements)
    path = case.march(parameters.cycles)
    corners = len(LOADS.corners)
    first = (path.time >= 0) & (path.time <= parameters.first_cycles * corners)
    steady = path.time >= (parameters.cycles - 1) * corners
    for node in (0, int(np.argmin(np.abs(case.system.x / case.scene.half_width - parameters.inner_x)))):
        for name, rows in (("first", first), ("steady", steady)):
            found = (values[rows, node] for values in (path.q, path.p, path.slip, path.status))
            part = _states(case, path, path.time[rows], _sigma(path)[rows, 0], *found)
            work = path.work[rows, node] / work_unit(case.system)
            yield part.assign(work=work, cycles=name, node=node, x=case.system.x[node] / case.scene.half_width)


def _sigma(path: fo.results.Trajectory) -> Any:
    """(T, 1) bulk stress over P / 2a."""
    return path.amplitudes[:, [list(path.system.bonded).index("sigma")]]


def _states(case: _Case, path: fo.results.Trajectory, times: Any, sigma: Any, q: Any, p: Any, slip: Any, status: Any) -> pd.DataFrame:
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
        "residual": path.residual,
    }
    return pd.DataFrame(columns)


_ERROR = {
    "elements": "elements on the contact, default grading",
    "engine": "'path': exact, from event to event; 'qp': frozen bounds; 'milp': complementarity with booleans; increments exact to rounding",
    "steps": "increments from corner to corner; 0 for the exact path",
    "work": "work of friction in the second cycle / (P^2 / E*), P the total force per depth",
    "error": "|work / that of the exact path - 1|; for the path itself its largest energy residual / work",
    "slip_error": "largest |v - v of the exact path| at the last corner / largest |v of the exact path|",
    "residual": "largest violation of the contact law over all states",
    "seconds": "processor time of two cycles without condensation, one thread: median of the repetitions that 2 s allow, at least one",
}
_SHARED = {
    "elements": "elements on the contact, default grading",
    "friction": "coefficient of friction",
    "load_factor": "amplitude of sigma / (P / 2a)",
    "time": "load corners visited; 0 at the mean load",
    "sigma": "bulk stress / (P / 2a)",
}
_STATE = {
    "q": "nodal shear force on the punch / (P / 2)",
    "p": "nodal normal force / (P / 2)",
    "slip": "slip v E* / (a P / 2a), from no initial slip",
}
_NODE = {"x": "position / a"}
_RESIDUAL = {"residual": "largest violation of the contact law over all states of the path"}
_CYCLE = (
    _SHARED
    | {"instant": "load corners visited since the beginning of the cycle"}
    | _NODE
    | _STATE
    | {"ratio": "q / (f p); NaN where p vanishes", "status": "0 stick, +1 and -1 slip along +x and against it, 2 open: just before the instant"}
    | _RESIDUAL
)
_HISTORY = (
    _SHARED
    | {"cycles": "'first' or 'steady'", "node": "number of the node, from the left"}
    | _NODE
    | _STATE
    | {"status": "0 stick, +1 and -1 slip along +x and against it, 2 open: until the next event", "work": "work of friction so far / (P^2 / E*)"}
    | _RESIDUAL
)

ERROR = Table("increments_error", "two cycles on one mesh by one engine", _ERROR, full=FULL, quick=QUICK, compute=error_by_increments, alone=True)
CYCLE = Table("increments_cycle", "one node at one instant of the steady cycle", _CYCLE, full=FULL, quick=QUICK, compute=steady_cycle)
CORNER = Table("increments_corner", "one node after one event of the exact path", _HISTORY, full=FULL, quick=QUICK, compute=corner_history)

STUDY = Study("studies.increments", __doc__, "coarse meshes and few increments, in seconds", (ERROR, CYCLE, CORNER))
