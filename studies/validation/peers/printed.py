"""The printed problems by solvers alone, and increments by Lemke's method and by quadratic programs.

A solver gets the arrays that cvxpy makes of the problem that frictopt prints. Its answer is not
checked, and nothing is proven.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

import frictopt as fo
from studies.paper import LOADS
from studies.validation.error_vs_time import parameters as of_times
from studies.validation.error_vs_time import transients
from studies.validation.error_vs_time.bare_lp import (
    SIMPLEX,
    LinearProgram,
    clarabel_cone,
    highs,
    highs_cost,
)
from studies.validation.error_vs_time.limits import exact_largest_margin, exact_limit
from studies.validation.error_vs_time.methods import Method, installed, relative
from studies.validation.peers.parameters import Parameters
from studies.validation.peers.questions import Contact

Array = np.ndarray[Any, Any]

FRICTION = 0.7
# Load factor of the safe slip divided by the limit.
SHARE = 0.9
RATIONAL = "vertex in rational arithmetic"


class Arrays:
    """A printed linear program as arrays: minimise `cost x`; rows are equations or upper bounds.

    Attributes
    ----------
    program
        For HiGHS.
    equal
        Number of rows at the top that are equations.
    """

    def __init__(self, problem: Any) -> None:
        data, _, _ = problem.get_problem_data("CLARABEL")
        self.equal = data["dims"].zero
        right = np.asarray(data["b"])
        floor = np.full(len(right), -np.inf)
        floor[: self.equal] = right[: self.equal]
        cost = np.asarray(data["c"])
        lower = np.full(len(cost), -np.inf)
        self.program = LinearProgram(cost, csc_matrix(data["A"]), right, lower, floor)

    def highs(self, options: dict[str, Any]) -> float:
        """The largest objective, by HiGHS."""
        return -highs_cost(highs(self.program, options))

    def clarabel(self, tolerance: float) -> float:
        """The largest objective, by Clarabel."""
        package, program = installed("clarabel"), self.program
        cones = [package.ZeroConeT(self.equal)]
        cones.append(package.NonnegativeConeT(len(program.right) - self.equal))
        return -clarabel_cone(program.cost, program.matrix, program.right, cones, tolerance)

    def osqp(self, tolerance: float) -> float:
        """The largest objective, by OSQP with polishing.

        Raises
        ------
        ArithmeticError
            No optimum in 20,000 iterations.
        """
        program, solver = self.program, installed("osqp").OSQP()
        none = csc_matrix((len(program.cost),) * 2)
        options = {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": 20000}
        solver.setup(
            none,
            program.cost,
            program.matrix,
            program.floor,
            program.right,
            polishing=True,
            verbose=False,
            **options,
        )
        answer = solver.solve(raise_error=False)
        if not str(answer.info.status).startswith("solved"):
            raise ArithmeticError(f"no optimum ({answer.info.status})")
        return -float(program.cost @ answer.x)

    def methods(self, exact: float, tolerances: tuple[float, ...]) -> Iterator[Method]:
        """The calls of the solvers: HiGHS with two settings, Clarabel and OSQP at these tolerances."""
        error = relative(exact, float)
        for name, options in (("dual simplex", {}), ("primal simplex, no presolve", SIMPLEX)):
            run = partial(self.highs, options)
            yield Method(f"HiGHS, {name}", "none", "printed problem", run, error, rival="highspy")
        for tolerance in tolerances:
            setting = f"printed problem, {tolerance:.0e}"
            for name, ask in (("Clarabel", self.clarabel), ("OSQP", self.osqp)):
                run = partial(ask, tolerance)
                yield Method(name, "none", setting, run, error, rival=name.lower())


def contacts(parameters: Parameters) -> Iterator[Contact]:
    """Limit and safe slip on each mesh, and an increment on the finest one."""
    of_mesh = of_times.Parameters(increment_tolerances=parameters.tolerances)
    for elements in parameters.elements:
        system = fo.scenes.PunchOnHalfPlane(elements=elements).condense(progress=False)
        limit = fo.shakedown_limit(system, LOADS, FRICTION, progress=False)
        yield _limit(parameters, system, limit)
        yield _safe_slip(parameters, system, limit.load_factor)
        scene = of_times.Scene(f"N = {system.nodes}", system, limit.load_factor)
        for question in transients.increments(of_mesh, scene):
            name = f"punch, N = {system.nodes}, one increment"
            reference = "statuses in rational arithmetic"
            yield Contact(name, question.quantity, reference, question.methods)


def _limit(
    parameters: Parameters, system: fo.ContactSystem, limit: fo.results.ShakedownLimit
) -> Contact:
    """The shakedown limit on one mesh."""
    exact = exact_limit(system, FRICTION)
    model = fo.ShakedownModel(system, LOADS)
    model.solve(FRICTION)
    error = relative(exact, lambda found: found.load_factor)
    runs = {
        "first call": partial(fo.shakedown_limit, system, LOADS, FRICTION, progress=False),
        "compiled model": partial(model.solve, FRICTION),
    }
    ours = [Method(f"frictopt, {name}", "none", "proven", run, error) for name, run in runs.items()]
    bare = Arrays(limit.problem).methods(exact, parameters.tolerances)
    name = f"punch, N = {system.nodes}"
    return Contact(name, "shakedown limit", RATIONAL, [*ours, *bare])


def _safe_slip(parameters: Parameters, system: fo.ContactSystem, limit: float) -> Contact:
    """The margin of a safe slip on one mesh."""
    factor = SHARE * limit
    exact = exact_largest_margin(system, FRICTION, factor)
    error = relative(exact, lambda safe: safe.margin)
    run = partial(fo.safe_slip, system, LOADS, FRICTION, factor)
    ours = [Method("frictopt, first call", "none", "proven", run, error)]
    bare = Arrays(run().problem).methods(exact, parameters.tolerances)
    name = f"punch, N = {system.nodes}"
    return Contact(name, "margin of a safe slip", RATIONAL, [*ours, *bare])
