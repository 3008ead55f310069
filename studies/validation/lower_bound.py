"""A lower bound of the guaranteed limit for few nodes, by a mixed-integer program.

The bound is the least load factor with a periodic sequence of friction increments that dissipates.
One increment leads from each corner of the load cycle to the next, and the last increment leads
back to the first corner. At the end of an increment each node sticks, slips along or against +x, or
is open; booleans choose its status. Some node must slip in one increment, and return in another
one, by slip or while open. Amplitudes may be zero, because the slip at the guaranteed limit is
zero. All bounds of the program are derived (`periodic_bounds`).

Below this load factor no sequence of these increments dissipates in a periodic state. The statement
holds for increments of one segment: the exact path may stop and reverse slip within a segment. The
number comes from branching in floating-point arithmetic, and is no proof in exact arithmetic.
"""

import warnings
from dataclasses import dataclass
from itertools import product
from typing import Any

import cvxpy as cp
import numpy as np
from highspy import Highs

import frictopt as fo
from studies.validation import oracles

# Largest number of nodes. More nodes have too many combinations of signs.
_NODES = 10
# Share by which load factors may exceed `highest`, so that the witness of a limit there is
# feasible.
_ROOM = 1e-6
# Bounds are widened by this share and by this dimensionless amount, to be safe from rounding.
_PAD = 1e-3
# H counts as positive definite if its least eigenvalue exceeds this share of the least eigenvalue
# without friction.
_DEFINITE = 1e-6
# S counts as singular if its least eigenvalue is at most this share of its largest entry.
_SINGULAR = 1e-10
_HIGHS = {"mip_rel_gap": 0.0, "mip_abs_gap": 1e-9, "threads": 1}
# With much tighter tolerances HiGHS reports feasible programs as infeasible.
_TOLERANCES = (
    {"mip_feasibility_tolerance": 1e-8, "primal_feasibility_tolerance": 1e-8},
    {"mip_feasibility_tolerance": 1e-6, "primal_feasibility_tolerance": 1e-7},
)


@dataclass(frozen=True)
class LowerBound:
    """The lower bound, and the sequence of increments with the least load factor.

    Attributes
    ----------
    load_factor
        The lower bound: no sequence dissipates below it. It is 0 if nothing is known.
    found
        Load factor of the sequence; inf without a sequence.
    status
        The status of the program, in words.
    slips
        (K, N) slips at the corners in the sequence, length; None without a sequence.
    lifts_off
        Whether a node is open in the sequence.
    """

    load_factor: float
    found: float
    status: str
    slips: Any
    lifts_off: bool


@dataclass(frozen=True)
class PeriodicBounds:
    """Bounds of every state, in the units of `oracles.units`.

    Attributes
    ----------
    slip_low, slip_high
        (N,) slip.
    gap_high, pressure_high
        (N,) total gap and normal reaction (their lower bounds are 0).
    """

    slip_low: Any
    slip_high: Any
    gap_high: Any
    pressure_high: Any


def lower_bound(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    highest: float,
    *,
    witnessed: bool,
    slip_bound: float | None = None,
    time_limit: float = 60.0,
) -> LowerBound:
    """The least load factor up to `highest` with a periodic sequence of increments that dissipates.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle and the coefficient of friction, one or one per node.
    highest
        Largest load factor that is searched, above 0.
    witnessed
        Whether a sequence exists at `highest`. This holds for a guaranteed limit with a node on
        both its bounds.
    slip_bound
        Largest slip at the corners; None for no bound.
    time_limit
        Seconds for each of at most two runs of the solver.

    Raises
    ------
    SolverError
        The program has no solution although there is a sequence: a bound or the solver is wrong.
    """
    f = np.broadcast_to(np.asarray(friction, dtype=float), system.nodes)
    bounds = periodic_bounds(system, cycle, f, highest * (1 + _ROOM))
    if bounds is None:
        why = "no bound on the reactions can be derived: S is singular (nothing holds the body), friction is too large, or there are too many nodes"
        return LowerBound(0.0, np.inf, why, None, False)
    problem = _problem(system, cycle, f, bounds, highest, slip_bound)
    least, found, status = _least(problem, time_limit)
    if witnessed and np.isinf(least) and least > 0:
        raise fo.SolverError(
            f"lower bound: {status}, although a sequence exists at load factor {highest:g}; a "
            "derived bound or the solver is wrong"
        )
    slips = None
    lifts_off = False
    if np.isfinite(found):
        slips = problem.var_dict["slip"].value * oracles.units(system, cycle)[1]
        lifts_off = bool((problem.var_dict["opened"].value > 0.5).any())
    load_factor = min(max(least, 0.0) * highest, highest)
    return LowerBound(load_factor, found * highest, status, slips, lifts_off)


def periodic_bounds(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, highest: float
) -> PeriodicBounds | None:
    """Bounds of every state at a corner, for load factors from 0 to `highest` and any residual slip.

    None if no bounds can be derived. The derivation follows.

    Let `Z = S^-1` and `[q, p] = r^w + S [v, w]` with r^w the reactions of the closed contact. The
    lower half of `[v, w] = Z (r - r^w)`, multiplied by p, and the contact condition `p' w = 0` give
    `p' Z_wv q + p' Z_ww p = p' z` with `z = (Z r^w)_w`. Friction writes `q = diag(sigma f) p` with
    each sigma in [-1, 1], so that `p' H p = p' z` with H the symmetric part of `Z_ww + Z_wv
    diag(sigma f)`. If friction is small enough, H is positive definite for all 2^N signs sigma.
    Then p lies in an ellipsoid. Its extent follows from `(H^-1)_ii` and `z' H^-1 z`. Both are
    convex in H and z, so each is largest with every sigma at -1 or 1, and at an end of the load
    range. Bounds of q follow, and with Z bounds of slips and gaps.
    """
    force, length = oracles.units(system, cycle)
    n = system.nodes
    f = np.broadcast_to(np.asarray(friction, dtype=float), n)
    S = system.S * length / force
    if n > _NODES or np.linalg.eigvalsh(S)[0] <= _SINGULAR * np.abs(S).max():
        return None
    Z = np.linalg.inv(S)
    mean = np.concatenate(cycle.mean_reaction(system)) / force
    ends = np.vstack([mean, mean + highest * np.hstack(cycle.corner_reactions(system)) / force])
    z = ends @ Z[n:].T
    normal = np.linalg.eigvalsh(Z[n:, n:])[0]
    share = np.zeros(n)
    size = 0.0
    for signs in product((-1.0, 1.0), repeat=n):
        tilted = Z[n:, n:] + Z[n:, :n] * (np.array(signs) * f)
        H = (tilted + tilted.T) / 2
        if np.linalg.eigvalsh(H)[0] <= _DEFINITE * normal:
            return None
        inverse = np.linalg.inv(H)
        share = np.maximum(share, np.diag(inverse))
        size = max(size, float(((z @ inverse) * z).sum(axis=1).max()))
    p = (1 + _PAD) * np.sqrt(share * size) + _PAD
    centre = -ends @ Z
    reach = np.abs(Z[:, :n]) @ (f * p)
    low = centre.min(axis=0) - reach + np.minimum(Z[:, n:], 0.0) @ p - _PAD
    high = centre.max(axis=0) + reach + np.maximum(Z[:, n:], 0.0) @ p + _PAD
    return PeriodicBounds(low[:n], high[:n], np.maximum(high[n:], 0.0), p)


def _problem(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    f: Any,
    bounds: PeriodicBounds,
    highest: float,
    slip_bound: float | None,
) -> cp.Problem:
    """The mixed-integer program, in the units of `oracles.units`.

    The unit of the load factor is `highest`.
    """
    n = system.nodes
    corners = len(cycle.corners)
    force, length = oracles.units(system, cycle)
    before = np.roll(np.arange(corners), 1)
    load_factor = cp.Variable(name="load_factor")
    slip = cp.Variable((corners, n), name="slip")
    gap = cp.Variable((corners, n), name="gap")
    forward = cp.Variable((corners, n), boolean=True, name="forward")
    backward = cp.Variable((corners, n), boolean=True, name="backward")
    opened = cp.Variable((corners, n), boolean=True, name="opened")
    returns = cp.Variable(n, boolean=True, name="returns")

    def everywhere(row: Any) -> Any:
        return np.broadcast_to(row, (corners, n))

    mean = np.concatenate(cycle.mean_reaction(system)) / force
    cyclic = np.hstack(cycle.corner_reactions(system)) / force
    r = (
        np.tile(mean, (corners, 1))
        + highest * cyclic * load_factor
        + cp.hstack([slip, gap]) @ (system.S * length / force)
    )
    q = r[:, :n]
    p = r[:, n:]
    moved = slip - slip[before]
    bound = cp.multiply(everywhere(f), p)
    reach = everywhere(bounds.slip_high - bounds.slip_low)
    room = everywhere(2 * f * bounds.pressure_high)
    slides = forward + backward
    rows = {
        "load_factor_high": load_factor <= 1 + _ROOM,
        "load_factor_not_negative": load_factor >= 0,
        "one_status": slides + opened <= 1,
        "moves_forward": moved <= cp.multiply(reach, forward + opened),
        "moves_backward": -moved <= cp.multiply(reach, backward + opened),
        "slip_low": slip >= everywhere(bounds.slip_low),
        "slip_high": slip <= everywhere(bounds.slip_high),
        "no_overlap": gap >= 0,
        "opens": gap <= cp.multiply(everywhere(bounds.gap_high), opened),
        "no_tension": p >= 0,
        "no_force_across_a_gap": p <= cp.multiply(everywhere(bounds.pressure_high), 1 - opened),
        "forward_bound": bound + q >= 0,
        "on_forward_bound": bound + q <= cp.multiply(room, 1 - forward - opened),
        "backward_bound": bound - q >= 0,
        "on_backward_bound": bound - q <= cp.multiply(room, 1 - backward - opened),
        "some_node_returns": cp.sum(returns) >= 1,
        "returning_node_slips": returns <= cp.sum(slides, axis=0),
        "returning_node_goes": returns <= cp.sum(forward + opened, axis=0),
        "returning_node_comes_back": returns <= cp.sum(backward + opened, axis=0),
    }
    if slip_bound is not None:
        rows["slip_bound"] = cp.abs(slip) <= slip_bound / length
    return cp.Problem(cp.Minimize(load_factor), [row.set_label(name) for name, row in rows.items()])


def _least(problem: cp.Problem, time_limit: float) -> tuple[float, float, str]:
    """Lower bound of the objective, its value, and the status.

    The bound is inf if both tolerances find that there is no solution, and -inf if nothing is
    known.
    """
    statuses = []
    for tolerance in _TOLERANCES:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # HiGHS refuses one thread if an earlier solution began with several threads.
            Highs.resetGlobalScheduler(True)
            problem.solve(
                solver="HIGHS",
                warm_start=False,
                highs_options=_HIGHS | tolerance | {"time_limit": time_limit},
            )
        statuses.append(str(problem.status))
        if problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE, cp.settings.USER_LIMIT):
            without_solution = any(variable.value is None for variable in problem.variables())
            value = float("inf") if without_solution else float(problem.value)
            bound = float(problem.solver_stats.extra_stats.mip_dual_bound)
            return bound, value, "; ".join(statuses)
    bound = float("inf") if set(statuses) == {cp.INFEASIBLE} else float("-inf")
    return bound, float("inf"), "; ".join(statuses)
