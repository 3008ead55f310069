"""A lower bound of the guaranteed limit of few nodes: the least load factor with a periodic sequence of friction increments that dissipates.

One increment leads from each corner of the load cycle to the next, the last one back to the first.
Each node sticks, slips along or against +x, or is open at the end of an increment, by booleans.
Some node must slip in one increment and come back, by slip or while open, in another one;
amplitudes may be zero, which is where the guaranteed limit lies. All bounds are derived
(`periodic_bounds`).

Below the least such load factor no sequence of these increments dissipates in a periodic state.
That is a statement about increments as long as the way between two corners: the exact path may stop
and reverse slip in between. It is a number from floating-point branching, no proof in exact
arithmetic.
"""

import warnings
from dataclasses import dataclass
from itertools import product
from typing import Any

import cvxpy as cp
import numpy as np
from highspy import Highs

import frictopt as fo
from validation import oracles

_NODES = 10  # more have too many signs
# share by which load factors may exceed the highest one: the witness of a limit at it stays
# feasible
_ROOM = 1e-6
_PAD = 1e-3  # bounds are widened by this share and by this dimensionless amount: above rounding
_DEFINITE = 1e-6  # least eigenvalue of H, over that of friction 0, that counts as positive definite
_SINGULAR = 1e-10  # least eigenvalue of S over its largest entry that counts as 0
_HIGHS = {"mip_rel_gap": 0.0, "mip_abs_gap": 1e-9, "threads": 1}
_TOLERANCES = (  # HiGHS calls feasible programs infeasible when they are much tighter
    {"mip_feasibility_tolerance": 1e-8, "primal_feasibility_tolerance": 1e-8},
    {"mip_feasibility_tolerance": 1e-6, "primal_feasibility_tolerance": 1e-7},
)


@dataclass(frozen=True)
class LowerBound:
    """What is known from periodic sequences of increments.

    Attributes
    ----------
    load_factor
        No sequence dissipates below it; 0 where nothing is known.
    found
        Least load factor of a sequence that was found, inf where none was.
    status
        What became of the program, in words.
    slips
        (K, N) slips at the corners in the sequence that was found, length; None where none was.
    lifts_off
        Whether a node is open in that sequence.
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
    """The least load factor, up to `highest`, of a periodic sequence of increments with dissipation.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle and the coefficient of friction, one or one per node.
    highest
        Largest load factor that is looked at, above 0.
    witnessed
        Whether there is a sequence at `highest`, as where it is a guaranteed limit with a node on
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
    slips = (
        problem.var_dict["slip"].value * oracles.units(system, cycle)[1]
        if np.isfinite(found)
        else None
    )
    lifts_off = slips is not None and bool((problem.var_dict["opened"].value > 0.5).any())
    return LowerBound(
        min(max(least, 0.0) * highest, highest), found * highest, status, slips, lifts_off
    )


def periodic_bounds(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, highest: float
) -> PeriodicBounds | None:
    """Bounds of every state at a corner with a load factor from 0 to `highest`, whatever its residual slip; None where none can be derived.

    Let `Z = S^-1` and `[q, p] = r^w + S [v, w]` with r^w the reactions of the closed contact. The
    lower half of `[v, w] = Z (r - r^w)`, multiplied by p, and the contact condition `p' w = 0` give
    `p' Z_wv q + p' Z_ww p = p' z` with `z = (Z r^w)_w`. Friction writes `q = diag(sigma f) p` with
    each sigma in [-1, 1], so that `p' H p = p' z` with H the symmetric part of `Z_ww + Z_wv
    diag(sigma f)`. Where H is positive definite for all 2^N signs sigma, which holds for small
    enough friction, p lies in an ellipsoid; all quantities that bound it are convex in H and in z,
    so the signs and the ends of the load range decide. Then q, and with Z slips and gaps, have
    bounds too.
    """
    (force, length), n, f = (
        oracles.units(system, cycle),
        system.nodes,
        np.broadcast_to(np.asarray(friction, dtype=float), system.nodes),
    )
    S = system.S * length / force
    if n > _NODES or np.linalg.eigvalsh(S)[0] <= _SINGULAR * np.abs(S).max():
        return None
    Z = np.linalg.inv(S)
    mean = np.concatenate(cycle.mean_reaction(system)) / force
    ends = np.vstack([mean, mean + highest * np.hstack(cycle.corner_reactions(system)) / force])
    z = ends @ Z[n:].T
    normal = np.linalg.eigvalsh(Z[n:, n:])[0]
    share, size = np.zeros(n), 0.0
    for signs in product((-1.0, 1.0), repeat=n):
        tilted = Z[n:, n:] + Z[n:, :n] * (np.array(signs) * f)
        H = (tilted + tilted.T) / 2
        if np.linalg.eigvalsh(H)[0] <= _DEFINITE * normal:
            return None
        inverse = np.linalg.inv(H)
        share, size = (
            np.maximum(share, np.diag(inverse)),
            max(size, float(((z @ inverse) * z).sum(axis=1).max())),
        )
    p = (1 + _PAD) * np.sqrt(share * size) + _PAD
    centre, reach = -ends @ Z, np.abs(Z[:, :n]) @ (f * p)
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
    """The mixed-integer program, in the units of `oracles.units`; load factors in units of `highest`."""
    n, corners, (force, length) = system.nodes, len(cycle.corners), oracles.units(system, cycle)
    before = np.roll(np.arange(corners), 1)
    load_factor = cp.Variable(name="load_factor")
    slip, gap = cp.Variable((corners, n), name="slip"), cp.Variable((corners, n), name="gap")
    forward, backward, opened = (
        cp.Variable((corners, n), boolean=True, name=name)
        for name in ("forward", "backward", "opened")
    )
    returns = cp.Variable(n, boolean=True, name="returns")

    def everywhere(row: Any) -> Any:
        return np.broadcast_to(row, (corners, n))

    mean, cyclic = (
        np.concatenate(cycle.mean_reaction(system)) / force,
        np.hstack(cycle.corner_reactions(system)) / force,
    )
    r = (
        np.tile(mean, (corners, 1))
        + highest * cyclic * load_factor
        + cp.hstack([slip, gap]) @ (system.S * length / force)
    )
    q, p, moved = r[:, :n], r[:, n:], slip - slip[before]
    bound, reach = cp.multiply(everywhere(f), p), everywhere(bounds.slip_high - bounds.slip_low)
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
    """Lower bound of the objective (inf where there is no solution, by both tolerances; -inf where nothing is known), a value, and the status."""
    words = []
    for tolerance in _TOLERANCES:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            Highs.resetGlobalScheduler(
                True
            )  # else one thread is refused where a solution before has begun with several
            problem.solve(
                solver="HIGHS",
                warm_start=False,
                highs_options=_HIGHS | tolerance | {"time_limit": time_limit},
            )
        words.append(str(problem.status))
        if problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE, cp.settings.USER_LIMIT):
            found = (
                float("inf")
                if any(variable.value is None for variable in problem.variables())
                else float(problem.value)
            )
            return float(problem.solver_stats.extra_stats.mip_dual_bound), found, "; ".join(words)
    return (
        (float("inf") if set(words) == {cp.INFEASIBLE} else float("-inf")),
        float("inf"),
        "; ".join(words),
    )
