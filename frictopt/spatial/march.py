"""Transients in three dimensions: the states of a contact over a number of load cycles, in increments."""

from time import perf_counter
from typing import Any

import numpy as np

from ..contact import LoadCycle
from ..contact.checks import choice, whole_number
from ..contact.tolerances import RESIDUAL
from ..errors import ModelError, SolverError
from .system import ContactSystem3D, parted
from .trajectory import Trajectory3D
from .transient import Point3D, Transient3D, checked_steps

__all__ = ["march"]


def march(
    system: ContactSystem3D,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    initial_slip: Any = None,
    cycles: int = 5,
    engine: str = "newton",
    steps: int = 20,
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
        Number of increments from corner to corner, even. The transient is followed with half as many, too, which tells `step_error`.

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
    fine, coarse = (
        _followed(Transient3D(system, cycle, friction, load_factor, initial_slip, engine, number), cycles)
        for number in (checked_steps(steps), steps // 2)
    )
    transient, points = fine
    rest, bonded = points[1:], parted(np.array([point.bonded for point in points]))
    time = np.linspace(-1, len(rest) / steps - 1, len(points))
    arrays = {name: np.array([getattr(point, name) for point in points]) for name in ("slip", "gap", "q", "p", "status", "work")}
    arrays |= {"time": time, "bonded_q": bonded[0], "bonded_p": bonded[1], "work": np.cumsum(arrays["work"], axis=0)}
    for array in arrays.values():
        array.flags.writeable = False
    apart = [np.abs(one.slip - other.slip).max() for one, other in zip(points[::steps], coarse[1][:: steps // 2], strict=True)]
    error = float(max(apart)) / transient.length
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


def _followed(transient: Transient3D, cycles: int) -> tuple[Transient3D, list[Point3D]]:
    """All states of a transient, the initial one first."""
    points = [transient.state, *transient.follow_to(transient.mean)]
    for _ in range(cycles):
        for corner in transient.corners:
            points += transient.follow_to(corner)
    return transient, points
