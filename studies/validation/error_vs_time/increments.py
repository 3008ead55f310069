"""One increment of friction, from one corner of the load cycle to the next: programs, Lemke's method, and direct calls of quadratic programs."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, identity, triu

import frictopt as fo
from frictopt.transients.exact import ExactPath
from frictopt.transients.increments import ExactIncrement, FrozenBoundIncrement, NewtonIncrement

from ...paper import LOADS
from .bare_lp import clarabel_settings, osqp_set_up
from .exact import exact_increment
from .lemke import Lemke
from .methods import Method, Question, installed
from .parameters import Parameters
from .scenes import Scene

Array = np.ndarray[Any, Any]

_PATIENCE = 5.0  # seconds until the frozen bound must have converged


@dataclass(frozen=True)
class FrozenBound:
    """The increment with the friction bound frozen, as a bare quadratic program in `z = (s+, s-) >= 0`; no node opens.

    Minimise `z' H z / 2 + (c + (g, g))' z` with `dv = s+ - s-`; dimensionless. As in the package's program the gaps are left out.

    Attributes
    ----------
    hessian
        (2N, 2N), positive semi-definite.
    trial
        (2N,) reactions `[q, p]` without further slip.
    coupling
        (N, N) change of pressure with slip.
    friction
        Coefficient of friction.
    length
        Unit of slip.
    """

    hessian: Array
    trial: Array
    coupling: Array
    friction: float
    length: float

    @classmethod
    def of(cls, system: fo.ContactSystem, friction: float, slip: Array, bonded: Array) -> "FrozenBound":
        """The increment from a slip (N,) to bonded reactions (2N,)."""
        n, r = system.nodes, bonded + system.S[:, : system.nodes] @ slip
        force = float(np.abs(bonded[n:]).mean())
        A, B = system.A / system.stiffness_scale, system.B / system.stiffness_scale
        return cls(np.block([[A, -A], [-A, A]]), r / force, B, friction, force / system.stiffness_scale)

    def sweep(self, solve: Callable[[Array], Array], tolerance: float) -> Array:
        """(N,) slip of the increment: programs with the bound of the last one, until the bound changes by less than the tolerance.

        Raises
        ------
        ArithmeticError
            The bound does not settle.
        """
        n = len(self.coupling)
        bound = self.friction * np.maximum(self.trial[n:], 0.0)
        start = time.perf_counter()
        while time.perf_counter() - start < _PATIENCE:
            z = solve(np.r_[self.trial[:n] + bound, bound - self.trial[:n]])
            dv = z[:n] - z[n:]
            new = self.friction * np.maximum(self.trial[n:] + self.coupling @ dv, 0.0)
            change, bound = float(np.abs(new - bound).max()), new
            if change <= tolerance:
                return np.asarray(dv * self.length)
        raise ArithmeticError(f"the bound still changes by {change:.0e} after {_PATIENCE:g} s of programs")


def osqp(program: FrozenBound, tolerance: float) -> Array:
    """By OSQP, polished, each program started from the last one."""
    rows = len(program.hessian)
    bounds = np.zeros(rows), np.full(rows, np.inf)
    solver = osqp_set_up(csc_matrix(triu(program.hessian)), np.zeros(rows), identity(rows, format="csc"), *bounds, tolerance)

    def solve(cost: Array) -> Array:
        solver.update(q=cost)
        return np.asarray(solver.solve(raise_error=False).x)

    return program.sweep(solve, tolerance)


def clarabel(program: FrozenBound, tolerance: float) -> Array:
    """By Clarabel, which starts each program afresh."""
    package, rows = installed("clarabel"), len(program.hessian)
    hessian, signs, cones = csc_matrix(triu(program.hessian)), -identity(rows, format="csc"), [package.NonnegativeConeT(rows)]
    solver = package.DefaultSolver(hessian, np.zeros(rows), signs, np.zeros(rows), cones, clarabel_settings(tolerance))

    def solve(cost: Array) -> Array:
        solver.update(q=cost)
        return np.asarray(solver.solve().x)

    return program.sweep(solve, tolerance)


def daqp(program: FrozenBound, tolerance: float) -> Array:
    """By DAQP's active set, which starts each program afresh; its own proximal steps for the singular Hessian."""
    rows = len(program.hessian)
    none, free, tolerances = np.zeros((0, rows)), np.full(rows, 1e30), {"primal_tol": tolerance, "dual_tol": tolerance, "eps_prox": -1.0}

    def solve(cost: Array) -> Array:
        z, _, flag, _ = installed("daqp").solve(program.hessian, cost, none, free, np.zeros(rows), **tolerances)
        if flag < 1:
            raise ArithmeticError(f"no optimum (exit flag {flag})")
        return np.asarray(z)

    return program.sweep(solve, tolerance)


def posed(parameters: Parameters, scene: Scene) -> tuple[ExactPath, Array]:
    """The exact path at the first corner, above the shakedown limit, and the slip (N,) that one increment to the second corner leads to."""
    system, friction, n = scene.system, parameters.friction, scene.system.nodes
    path = ExactPath(system, LOADS, friction, parameters.overload * scene.limit)
    path.start()
    path.follow_to(path.corners[0], "the segment to the first corner")
    slip, pair = path.state.u[:n], (path.corners[1][:n], path.corners[1][n:])
    after = NewtonIncrement(system, friction).solve(slip, pair)
    return path, exact_increment(system, friction, slip, pair, np.sign(after.slip - slip))


def questions(parameters: Parameters, scene: Scene, elements: int) -> Iterator[Question]:
    """From the state at the first corner, above the shakedown limit, to the second corner at once."""
    system, friction, n = scene.system, parameters.friction, scene.system.nodes
    path, exact = posed(parameters, scene)
    before, bonded = path.state.u.copy(), path.corners[1]
    slip, pair = before[:n], (bonded[:n], bonded[n:])
    engines = {"frozen bounds (QP)": ("CLARABEL", FrozenBoundIncrement), "newton": ("steps", NewtonIncrement)}

    def error(found: Array) -> float:
        return float(np.abs(found - exact).max() / np.abs(exact - slip).max())

    def ours(method: str, solver: str, engine: Any) -> Method:
        return Method(method, "solver", solver, partial(engine.solve, slip, pair), lambda made: error(made.slip))

    methods = [ours(f"frictopt, {name}", way, engine(system, friction)) for name, (way, engine) in engines.items()]
    methods.append(Method("frictopt, exact path", "none", "events", partial(_followed, path, before), lambda u: error(u[:n])))
    if elements in parameters.milp_elements:
        methods.append(ours("frictopt, complementarity (MILP)", "HIGHS", ExactIncrement(system, friction)))
    if installed("quantecon"):
        lemke = Lemke(system, friction, float(np.abs(bonded[n:]).mean()))
        methods.append(Method("Lemke", "none", "pivots", partial(lemke.increment, slip, bonded), lambda made: error(made[0]), rival="quantecon"))
    program = FrozenBound.of(system, friction, slip, bonded)
    for name, solve in (("OSQP", osqp), ("Clarabel", clarabel), ("DAQP", daqp)):
        for tolerance in parameters.tolerances:
            run = partial(solve, program, tolerance)
            methods.append(Method(f"{name}, frozen bounds", "tolerance", f"{tolerance:.0e}", run, lambda dv: error(slip + dv), rival=name.lower()))
    reference = "linear system of the final statuses in rational arithmetic, refined to 40 digits; the contact law checked on it"
    yield Question("increment", "slip", scene.name, n, reference, methods)


def _followed(path: ExactPath, before: Array) -> Array:
    """(2N,) slip and gap at the second corner, on the exact path from a state at the first."""
    here = path.at(before / path.unit)
    if here is None:
        raise ArithmeticError("the state at the first corner does not obey the contact law")
    here.follow_to(path.corners[1], "the segment to the second corner")
    return np.asarray(here.state.u)
