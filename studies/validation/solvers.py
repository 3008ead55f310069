"""The printed problems, solved by every solver that cvxpy knows in this environment.

Run with `python -m studies solvers [--quick]`; it prints a table in Markdown. frictopt solves
reduced programs in units of their size, and checks each answer. A user who solves a printed problem
has neither advantage. So each problem is written for the same contact in units of force from 1e-9
to 1e9, and each answer is compared with the answer that frictopt proved.

The table has the solvers that are installed: `python -m pip install` installs the packages in
`PACKAGES`. Each solver runs in a process of its own, which ends after a time limit.
"""

import os
import pickle
import time
import warnings
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import get_context
from typing import Any, Literal

import cvxpy as cp
import numpy as np
import pandas as pd

import frictopt as fo
from studies.progress import each
from studies.tables import Study, Table, markdown, two_digits

# Solver in cvxpy -> package on PyPI.
PACKAGES = {
    "HIGHS": "highspy",
    "CLARABEL": "clarabel",
    "OSQP": "osqp",
    "SCS": "scs",
    "ECOS": "ecos",
    "QOCO": "qoco",
    "PIQP": "piqp",
    "PROXQP": "proxsuite",
    "DAQP": "daqp",
    "QPALM": "qpalm",
    "SCIP": "pyscipopt",
    "CBC": "cylp",
    "GLOP": "ortools",
    "PDLP": "ortools",
    "GLPK": "cvxopt",
    "CVXOPT": "cvxopt",
    "SDPA": "sdpa-python",
    "GUROBI": "gurobipy",
    "COPT": "coptpy",
    "XPRESS": "xpress",
    "MOSEK": "mosek",
}

# Options that name one method of a solver. The other solvers run as cvxpy calls them by default.
METHODS: dict[str, Mapping[str, Mapping[str, Any]]] = {
    "HIGHS": {
        "HIGHS": {},
        "HIGHS ipm": {"highs_options": {"solver": "ipm"}},
        "HIGHS pdlp": {"highs_options": {"solver": "pdlp"}},
    },
}

# The row of a bare `problem.solve()`.
NO_SOLVER_NAMED = "none named"


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Units of force: the stiffness and all loads are multiplied by them.
    units: tuple[float, ...] = (1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
    # Numbers of elements of the punch in the plane, and along each side of the punch in space.
    elements: int = 40
    square: int = 4
    # Seconds after which a solver is stopped.
    seconds: float = 20.0
    # Names of the solvers. Empty: all installed solvers.
    solvers: tuple[str, ...] = ()
    # Largest relative error of an answer that is right, and of an answer that is rough.
    right: float = 1e-6
    rough: float = 1e-3


FULL = Parameters()
QUICK = Parameters(units=(1.0,), elements=8, square=2, solvers=("HIGHS", "CLARABEL"))


@dataclass(frozen=True)
class PrintedProblem:
    """A printed problem without its solution, and the answer that frictopt proved.

    `optimum` is a number, `cp.UNBOUNDED` or `cp.INFEASIBLE`. If the answer is the value of a
    variable instead of the objective, `variable` is its name, and `optimum` its value.
    """

    problem: cp.Problem
    optimum: Any
    variable: str = ""


def _in_unit(system: fo.ContactSystem, unit: float) -> fo.ContactSystem:
    """The same contact with its forces in another unit."""
    loads = {case: (unit * q, unit * p) for case, (q, p) in system.bonded.items()}
    return fo.ContactSystem(
        unit * system.S, system.points, loads, frames=system.frames, contact=system.contact
    )


def problems(parameters: Parameters, unit: float) -> dict[str, PrintedProblem]:
    """The printed problems of contacts whose forces are in this unit, by name."""
    punch = fo.scenes.PunchOnHalfPlane(elements=parameters.elements).condense()
    square = fo.scenes.SquarePunch(elements=parameters.square).condense()
    plane = _in_unit(punch, unit)
    space = _in_unit(square, unit)
    stretched = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    sheared = fo.LoadCycle({"P": 1.0}, [{"Qx": -1.0}, {"Qx": 1.0}])
    pressed = fo.LoadCycle({"P": 1.0}, [{"P": 0.0}, {"P": 1.0}])
    sliding = fo.LoadCycle({"P": 1.0, "Q": 0.8}, [{"Q": -1.0}, {"Q": 1.0}])
    strong = 2.0
    in_plane = fo.shakedown_limit(plane, stretched, 0.7, progress=False)
    in_space = fo.shakedown_limit(space, sheared, 0.4, progress=False)
    infinite = fo.shakedown_limit(
        plane, pressed, strong, open_nodes=np.zeros(plane.nodes, dtype=bool)
    )
    none = fo.shakedown_limit(plane, sliding, 0.7, open_nodes=np.zeros(plane.nodes, dtype=bool))
    margin = fo.safe_slip(plane, stretched, 0.7, 0.9 * in_plane.load_factor)
    guaranteed = fo.guaranteed_limit(plane, stretched, 0.7, progress=False)
    sliding_load = fo.gross_slip(plane, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), 0.7)

    few = _in_unit(fo.scenes.PunchOnHalfPlane(elements=6).condense(), unit)
    return {
        "limit, plane": PrintedProblem(in_plane.problem, in_plane.load_factor),
        "limit, space": PrintedProblem(in_space.problem, in_space.load_factor),
        "limit, infinite": PrintedProblem(infinite.problem, cp.UNBOUNDED),
        "limit, none": PrintedProblem(none.problem, cp.INFEASIBLE),
        "safe slip": PrintedProblem(margin.problem, margin.margin),
        "critical node": PrintedProblem(guaranteed.problem, guaranteed.load_factor),
        "gross slip": PrintedProblem(sliding_load.problem, sliding_load.load_factor),
        "increment, plane": _increment(plane, "qp", "Q", "u"),
        "increment, space": _increment(space, "qp", "Qx", "u"),
        "increment, booleans": _increment(few, "milp", "Q", "slip_step"),
    }


def _increment(
    system: fo.ContactSystem, form: Literal["qp", "milp"], shear: str, variable: str
) -> PrintedProblem:
    """The program of an increment from no slip, pressed and sheared; its answer is a motion."""
    load = system.reaction({"P": 1.0, shear: 0.4})
    slip = np.zeros(system.slip_shape)
    increment = fo.increments.NewtonIncrement(system, 0.5).solve(slip, load, form)
    motion = np.array(increment.problem.var_dict[variable].value)
    return PrintedProblem(increment.problem, motion, variable)


def solved(packed: bytes, solver: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Status, relative error, processor time and solver of one solution, in this process.

    Errors of the solver become statuses, such as `not taken` if the solver does not accept this
    kind of problem.
    """
    # Compiled code of solvers prints banners, which only the file descriptors can silence.
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    printed: PrintedProblem = pickle.loads(packed)
    problem = printed.problem
    named = {} if solver == NO_SOLVER_NAMED else {"solver": solver}
    row = {"status": "", "error": np.nan, "seconds": np.nan, "solved_by": solver}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            problem.get_problem_data(solver=named.get("solver"))
        except ImportError:
            return row | {"status": "not loaded"}
        except Exception:
            return row | {"status": "not taken"}
        started = time.process_time()
        try:
            problem.solve(**named, **options)
        except ImportError:
            return row | {"status": "not loaded"}
        except Exception as error:
            return row | {"status": f"refused: {type(error).__name__}"}
    row["seconds"] = time.process_time() - started
    row["status"] = problem.status
    row["solved_by"] = str(problem.solver_stats.solver_name)
    if problem.status in cp.settings.SOLUTION_PRESENT and not isinstance(printed.optimum, str):
        value = problem.value
        if printed.variable:
            value = problem.var_dict[printed.variable].value
        difference = np.linalg.norm(value - printed.optimum)
        row["error"] = float(difference / np.linalg.norm(printed.optimum))
    return row


def outcome(printed: PrintedProblem, row: Mapping[str, Any], parameters: Parameters) -> str:
    """Whether an answer is right, rough, wrong, reported as inaccurate, or none."""
    status = row["status"]
    if isinstance(printed.optimum, str):
        if status in (printed.optimum, cp.settings.INFEASIBLE_OR_UNBOUNDED):
            return "right"
        without_an_optimum = (cp.OPTIMAL, cp.INFEASIBLE, cp.UNBOUNDED)
        return "wrong" if status in without_an_optimum else _without_answer(status)
    if status == cp.OPTIMAL:
        if row["error"] <= parameters.right:
            return "right"
        return "rough" if row["error"] <= parameters.rough else "wrong"
    if status in (cp.INFEASIBLE, cp.UNBOUNDED, cp.settings.INFEASIBLE_OR_UNBOUNDED):
        return "wrong"
    return _without_answer(status)


def _without_answer(status: str) -> str:
    """The outcome of a status without an answer."""
    if status in ("not taken", "not loaded", "timed out", "crashed"):
        return status
    return "inaccurate" if status.endswith("inaccurate") else "refused"


class SolverProcess:
    """One worker, which is started again after a solver crashes or exceeds its time."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None

    def solve(
        self, packed: bytes, solver: str, options: Mapping[str, Any], seconds: float
    ) -> dict[str, Any]:
        """The result of `solved` in the worker.

        The status is `timed out` or `crashed` if no answer comes.
        """
        if self._pool is None:
            self._pool = ProcessPoolExecutor(1, get_context("spawn"))
        try:
            return self._pool.submit(solved, packed, solver, options).result(timeout=seconds)
        except TimeoutError:
            status = "timed out"
        except BrokenProcessPool:
            status = "crashed"
        self.end()
        return {"status": status, "error": np.nan, "seconds": np.nan, "solved_by": solver}

    def end(self) -> None:
        """Kill the worker, if there is one."""
        if self._pool is not None:
            for process in list(self._pool._processes.values()):
                process.kill()
            self._pool.shutdown()
            self._pool = None


def tried(parameters: Parameters) -> Iterator[Mapping[str, Any]]:
    """One row for each solver, problem and unit of force."""
    installed = parameters.solvers or [name for name in PACKAGES if name in cp.installed_solvers()]
    printed = {unit: problems(parameters, unit) for unit in parameters.units}
    for solver in each([*installed, NO_SOLVER_NAMED], "solvers"):
        for method, options in METHODS.get(solver, {solver: {}}).items():
            process = SolverProcess()
            for unit, named in printed.items():
                for name, problem in named.items():
                    row = process.solve(pickle.dumps(problem), solver, options, parameters.seconds)
                    yield row | {
                        "solver": method,
                        "version": _version(solver),
                        "problem": name,
                        "unit": unit,
                        "outcome": outcome(problem, row, parameters),
                        "residual": 0.0,
                    }
            process.end()


def _version(solver: str) -> str:
    if solver == NO_SOLVER_NAMED:
        return f"cvxpy {cp.__version__}"
    try:
        return f"{PACKAGES[solver]} {version(PACKAGES[solver])}"
    except PackageNotFoundError:
        return PACKAGES[solver]


# Outcome -> its letter in the table.
LETTERS = {
    "right": "R",
    "rough": "r",
    "wrong": "W",
    "inaccurate": "i",
    "refused": "-",
    "timed out": "t",
    "crashed": "x",
    "not loaded": "n",
}


def _report(table: pd.DataFrame) -> str:
    """A line for each solver: the outcomes of each problem, a letter for each unit of force."""
    names = list(dict.fromkeys(table["problem"]))
    rows = []
    for (solver, package), part in table.groupby(["solver", "version"], sort=False):
        cells = []
        for name in names:
            outcomes = part.loc[part["problem"] == name, "outcome"]
            letters = "".join(LETTERS.get(outcome, "") for outcome in outcomes)
            cells.append(f"`{letters}`" if letters else "")
        rows.append([f"{solver} ({package})", *cells, _milliseconds(part)])
    units = ", ".join(f"{unit:g}" for unit in dict.fromkeys(table["unit"]))
    meaning = ", ".join(f"`{letter}` {outcome}" for outcome, letter in LETTERS.items())
    legend = (
        f"A letter for each unit of force ({units}): {meaning}. No letters: the solver does not "
        "take such problems. *ms*: processor time of `solve` for the limit in the plane in the "
        "unit 1, cvxpy included."
    )
    head = ["solver", *names, "ms"]
    return f"{markdown(head, rows)}\n\n{legend}"


def _milliseconds(part: pd.DataFrame) -> str:
    """Processor time of the limit in the plane in the unit of force 1, with cvxpy's part."""
    seconds = part.loc[(part["problem"] == "limit, plane") & (part["unit"] == 1.0), "seconds"]
    return "" if seconds.isna().all() else two_digits(1e3 * seconds.iloc[0])


_COLUMNS = {
    "solver": "name in cvxpy, with the method if an option chooses it",
    "version": "package and its version",
    "problem": "printed problem",
    "unit": "unit of force that multiplies stiffness and loads",
    "status": "of cvxpy; `not taken`, `refused` with the kind of error, `timed out` or `crashed`",
    "error": "relative error of the objective, or of the motion of an increment",
    "seconds": "processor time of `problem.solve`",
    "solved_by": "solver that cvxpy names afterwards",
    "outcome": "right, rough, wrong with status optimal, inaccurate (and says so), or no answer",
}
SOLVERS = Table(
    "solvers", "one problem by one solver", _COLUMNS, full=FULL, quick=QUICK, compute=tried
)

STUDY = Study(
    "studies.validation.solvers",
    __doc__,
    "two solvers and small contacts, in seconds",
    (SOLVERS,),
    lambda tables: _report(tables[SOLVERS.name]),
)
