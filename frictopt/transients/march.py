"""Transients: the states of a contact over a number of load cycles, by the exact path or in increments."""

from collections import Counter
from time import perf_counter
from typing import Any, Literal

import numpy as np

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.checks import Array, choice, flag, frozen, whole_number
from ..contact.dispatch import answered_by_kind
from ..contact.tolerances import RESIDUAL
from ..errors import ModelError, SolverError
from .exact import ExactPath
from .increments import ExactIncrement, FrozenBoundIncrement
from .trajectory import Trajectory

__all__ = ["march"]

_ENGINES = {"qp": FrozenBoundIncrement, "milp": ExactIncrement}


@answered_by_kind
def march(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    initial_slip: Any = None,
    initial_state: ContactState | None = None,
    cycles: int = 5,
    engine: Literal["path", "qp", "milp"] = "path",
    steps: int | None = None,
    simplify: bool = True,
) -> Trajectory:
    """Follow a transient from an initial slip, or from an earlier state, through a number of load cycles.

    The load path starts at an artificial load that carries the initial slip with q = 0 and, at every node, p equal to the mean of `abs(p^w)`
    under the mean load. It goes in a straight line to the mean load, and then visits the corners in their order, again and again. Theory, eq. (13).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    initial_slip
        (N,) residual slip from assembly, length; None: no slip.
    initial_state
        An earlier state, instead of a slip: `state` of a steady state, or `state_at(...)` of a trajectory. Its nodes may be open. The load goes
        straight from that of the state to the corner that comes next, and to the end of that cycle.
    cycles
        Number of whole cycles.
    engine
        "path": exactly, from event to event; "qp": in increments, by quadratic programs with a frozen friction bound; "milp": in increments, by
        complementarity conditions with booleans.
    steps
        Number of increments from corner to corner, for the engines "qp" and "milp".
    simplify
        Leave out what cannot change the result, see the increments; the exact path leaves out nothing.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The exact path ends.
    SolverError
        An increment has no valid solution, or the residual of the states exceeds the tolerance.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> path = fo.march(rod, cycle, friction=0.5, load_factor=1.0, cycles=2)
    >>> path.cycle_work.sum(axis=1).round(6).tolist()
    [0.75, 1.0]
    >>> increments = fo.march(rod, cycle, friction=0.5, load_factor=1.0, cycles=1, engine="qp", steps=2)
    >>> bool(abs(increments.slip[-1] - path.slip[-1]).max() < 1e-6)
    True
    """
    whole_number("cycles", cycles, least=0)
    choice("engine", engine, ("path", *_ENGINES))
    flag("simplify", simplify)
    path = ExactPath(system, cycle, friction, load_factor, initial_slip, initial_state=initial_state, keep=True)
    stations, loads = _stations(path, cycles)
    left_out: tuple[str, ...] = ()
    if engine == "path":
        if steps is not None:
            raise ModelError(f"steps: {steps}; the exact path has none, leave it out or choose engine='qp' or 'milp'")
        path.start()
        for _ in range(cycles):
            path.run_cycle()
        time, u, r, status, work = (np.concatenate(parts) for parts in zip(*path.history, strict=True))
        bonded = _between(stations, loads, time)
    else:
        if steps is None:
            raise ModelError(f"steps: None; engine={engine!r} needs the number of increments from corner to corner")
        time = np.linspace(stations[0], stations[-1], (len(stations) - 1) * whole_number("steps", steps, least=1) + 1)
        bonded = _between(stations, loads, time)
        u, r, status, work, left_out = _increments(path, bonded, engine, simplify)
    n = path.nodes
    status.flags.writeable = False
    trajectory = Trajectory(
        system=path.system,
        friction=path.friction,
        corners=len(cycle.corners),
        time=frozen(time),
        bonded_q=frozen(bonded[:, :n]),
        bonded_p=frozen(bonded[:, n:]),
        slip=frozen(u[:, :n]),
        gap=frozen(u[:, n:] + path.system.gap),
        q=frozen(r[:, :n]),
        p=frozen(r[:, n:]),
        status=status,
        work=frozen(work),
        engine=engine,
        _left_out=left_out,
        _seconds=perf_counter() - path.started,
    )
    if not trajectory.residual <= RESIDUAL:
        raise SolverError(
            f"march: the states violate the contact law or the balance of energy by {trajectory.residual:.1e} (tolerance {RESIDUAL:g}; "
            f"{trajectory.verdict}); {path.cause_of_rounding}"
        )
    return trajectory


def _stations(path: ExactPath, cycles: int) -> tuple[Array, Array]:
    """Times (T,) and bonded reactions (T, 2N) at which the load path of a transient turns, from where it stands."""
    first = path.visited
    begun = [path.mean] if first < 0 else path.corners[first:] if first > 0 else []
    loads = [path.bonded, *begun, *path.corners * cycles]
    return first + np.arange(len(loads), dtype=np.float64), np.array(loads)


def _between(stations: Array, loads: Array, time: Array) -> Array:
    """(T, 2N) bonded reactions at each time, linear between the loads (rows) at the stations."""
    return np.array([np.interp(time, stations, values) for values in loads.T]).T


def _increments(path: ExactPath, bonded: Array, engine: str, simplify: bool) -> tuple[Any, Array, Any, Array, tuple[str, ...]]:
    """`u`, `r`, status and work at each of the loads (rows), from the state of the path on, and what was left out."""
    n = path.nodes
    increment, left_out = _ENGINES[engine](path.system, path.friction, simplify=simplify), Counter[str]()
    states = [(path.state.u.copy(), path.state.r.copy(), path.state.status.copy(), np.zeros(n))]
    for load in bonded[1:]:
        u, r, _, work = states[-1]
        new = increment.solve(u[:n], (load[:n], load[n:]))
        left_out.update(new.record.left_out)
        slid = path.friction * (r[n:] + new.p) / 2 * np.abs(new.slip - u[:n]) * (new.p > 0)  # not by status: little pressure counts as open there
        states.append((np.concatenate([new.slip, new.gap - path.system.gap]), np.concatenate([new.q, new.p]), new.status, work + slid))
    u, r, status, work = (np.array(parts) for parts in zip(*states, strict=True))
    return u, r, status, work, tuple(f"in {count} of {len(bonded) - 1} increments, {text}" for text, count in left_out.items())
