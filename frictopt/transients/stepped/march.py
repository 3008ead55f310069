"""Transients in three dimensions: the states of a contact over a number of load cycles, in increments."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from ...contact import LoadCycle
from ...contact.checks import choice, flag, whole_number
from ...contact.parts import parted
from ...contact.progress import bar_of
from ...contact.system import ContactSystem
from ...contact.tolerances import RESIDUAL
from ...errors import ModelError, NoContinuation, SolverError
from .trajectory import Trajectory3D
from .transient import Point3D, Transient3D, doubts, step_counts

__all__ = ["march"]


def march(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    initial_slip: Any = None,
    cycles: int = 5,
    engine: str = "newton",
    steps: int = 20,
    progress: bool = True,
) -> Trajectory3D:
    """Follow a transient from an initial slip through a number of load cycles.

    The load path starts at an artificial load that carries the initial slip with q = 0 and, at every node, p equal to the mean of |p^w| under the
    mean load. It goes in a straight line to the mean load, and then visits the corners in their order, again and again.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    initial_slip
        (N, 2) residual slip from assembly, length; None: no slip.
    cycles
        Number of cycles.
    engine
        "newton": each increment by Newton's method; "socp": by cone programs with a frozen friction bound, to read. There is no engine "path".
    steps
        Number of increments from corner to corner, at least 2. The transient is followed with a half and a quarter of them, too, which tells
        `step_error`.
    progress
        Show a bar where it takes more than two seconds.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        An increment has no valid answer, or the residual of the states exceeds the tolerance.
    """
    start = perf_counter()
    whole_number("cycles", cycles, least=0)
    if isinstance(engine, str) and engine == "path":
        raise ModelError(
            "engine: 'path'; an exact path needs a law of straight lines, and the friction circle is curved: choose 'newton' or 'socp', and see "
            "`step_error` for what the increments leave"
        )
    choice("engine", engine, ("newton", "socp"))
    counts = step_counts(steps)
    with bar_of(flag("progress", progress), "march", "cycle", total=len(counts) * cycles, delay=2) as bar:
        transient, points = _followed(Transient3D(system, cycle, friction, load_factor, initial_slip, engine, steps), cycles, bar.update)
        error = 0.0
        for number in counts[1:]:
            coarse = Transient3D(system, cycle, friction, load_factor, initial_slip, engine, number)
            error = max(error, _distance(points[::steps], coarse, cycles, bar.update))
    rest, bonded = points[1:], parted(np.array([point.bonded for point in points]), 3)
    time = np.linspace(-1, len(rest) / steps - 1, len(points))
    arrays = {name: np.array([getattr(point, name) for point in points]) for name in ("slip", "gap", "q", "p", "status", "work")}
    *works, bound = doubts(transient.friction, arrays["slip"], arrays["q"], arrays["p"], arrays["status"][1:])
    ways = [float((work / np.where(bound > 0, bound, np.inf)).sum(axis=0).max()) for work in works]
    error = max(error, float(np.sqrt(np.prod(ways)))) / transient.length
    arrays |= {"time": time, "bonded_q": bonded[0], "bonded_p": bonded[1], "work": np.cumsum(arrays["work"], axis=0)}
    for array in arrays.values():
        array.flags.writeable = False
    found = Trajectory3D(
        system=system,
        friction=transient.friction,
        corners=len(cycle.corners),
        engine=engine,
        step_error=error,
        _seconds=perf_counter() - start,
        **arrays,
    )
    if not found.residual <= RESIDUAL:
        raise SolverError(
            f"march: the states violate the contact law by {found.residual:.1e} (tolerance {RESIDUAL:g}; {found.verdict}); bring the loads of the "
            "cycle, or the initial slip and the loads, closer together in size"
        )
    return found


def _followed(transient: Transient3D, cycles: int, tell: Callable[[], Any]) -> tuple[Transient3D, list[Point3D]]:
    """All states of a transient, the initial one first."""
    points = [transient.state, *transient.follow_to(transient.mean)]
    for _ in range(cycles):
        for corner in transient.corners:
            points += transient.follow_to(corner)
        tell()
    return transient, points


def _distance(corners: list[Point3D], coarse: Transient3D, cycles: int, tell: Callable[[], Any]) -> float:
    """Largest distance of the slip at the mean load and the corners from that of fewer increments; inf where these have no answer."""
    try:
        others = _followed(coarse, cycles, tell)[1][:: coarse.steps]
    except (NoContinuation, SolverError):
        return np.inf
    return float(max(np.abs(one.slip - other.slip).max() for one, other in zip(corners, others, strict=True)))
