"""The steady state of a transient: whether it stops slipping, and if not, how much it dissipates per cycle."""

from numpy.typing import ArrayLike

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.checks import finite_number, flag, whole_number
from ..contact.odd_values import warns_of_odd_values
from ..contact.system import checked_system
from ..errors import NoContinuation
from .exact.cycles import Run
from .exact.path import ExactPath
from .exact.stops import turning_corners
from .march import way_to_follow
from .outcome import SteadyState
from .stepped.path import SteppedPath, step_counts
from .stepped.steady import settled_in_increments

__all__ = ["settled", "steady_state"]

MOST_CYCLES = 2000
"""Number of cycles after which the search for a steady state gives up, unless another one is asked for."""


@warns_of_odd_values
def steady_state(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    initial_slip: ArrayLike | None = None,
    initial_state: ContactState | None = None,
    overload: float | None = None,
    most_cycles: int = MOST_CYCLES,
    steps: int | None = None,
    progress: bool = True,
) -> SteadyState:
    """Follow a transient until its steady state is proven: exactly in the plane, in increments by Newton's method in space.

    The load cycle maps the slip at its beginning to the slip at its end. As long as the events stay the same, this map is affine, and its fixed point
    is extrapolated from the last cycles (reduced-rank extrapolation, Sidi 2017). The order of events within a segment does not count, because slip
    zones at two edges grow side by side. The fixed point is accepted only if a cycle from it comes back to it, and if cycles from states between it
    and the last state show that the map is affine for all states to come. The state may come back after two cycles (`period`), or its slip may drift
    by the same amount in each return. In increments the transient goes on from the fixed point, and what is reported is what the cycles after it do.

    In the plane, shakedown needs a slip that is safe at every corner. If nodes lift off or have no friction, a periodic state without work of
    friction also counts (at each node at most the work of a slip of 1e-9 slip scales under its own largest pressure). Theory, eq. (14).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    initial_slip
        Residual slip from assembly, (N,) in the plane, (N, 2) in space, length; None: no slip.
    initial_state
        An earlier state, instead of a slip: `state` of a steady state, or `state_at(...)` of a trajectory. Its nodes may be open. The load goes
        straight from that of the state to the corner that comes next, and to the end of that cycle, before the first cycle that counts.
    overload
        Load factor of one extra cycle before all others, >= 0; None: no such cycle.
    most_cycles
        Number of cycles after which to give up.
    steps
        Number of increments from corner to corner; a half and a quarter of them tell `step_error`. None: the exact path in the plane, 20 in space.
    progress
        Show a bar where increments take more than two seconds.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The path ends, a load is beyond friction, or no steady state, of period one or two, is proven within `most_cycles`. In increments its
        attributes then say what is known.
    SolverError
        An increment has no valid answer, or the states violate the contact law or the balance of energy by more than the tolerance.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> steady.outcome.name, round(steady.dissipation, 6)
    ('CYCLIC_SLIP', 1.0)
    >>> fo.reference.rod_dissipation(F0=1.0, EA=1.0, tau=0.5, h=1.0)
    1.0
    """
    whole_number("most_cycles", most_cycles, least=1)
    shown = flag("progress", progress)
    extra = None if overload is None else finite_number("overload", overload, least=0.0)
    start = system, cycle, friction, load_factor, initial_slip
    engine, steps = way_to_follow(checked_system(system), None, steps)
    if engine != "path":
        return settled_in_increments([SteppedPath(*start, initial_state, engine, n) for n in step_counts(steps)], extra, most_cycles, shown)
    path = ExactPath(*start, initial_state=initial_state)
    path.start()
    if extra is not None:
        corners = path.corners_at(extra)
        path.check_near("overload", corners)
        for number in turning_corners(cycle):
            path.follow_to(corners[number], f"the overload's segment to corner {number}")
    return settled(path, most_cycles)[0]


def settled(path: ExactPath, most_cycles: int = MOST_CYCLES) -> tuple[SteadyState, ExactPath]:
    """The steady state that cycles lead to from where a path is, and a path on it, at the last corner.

    Cycles stop at the corners at which the load turns.

    Raises
    ------
    NoContinuation
        The path ends, or no steady state is proven within `most_cycles`.
    SolverError
        The states violate the contact law or the balance of energy by more than the tolerance.
    """
    run = Run(path, turning_corners(path.cycle))
    while run.cycles + run.period <= most_cycles:
        run.cycle()
        found = run.steady()
        if found is not None:
            return found, run.settled
        if run.alternates():
            run.double()
        elif run.drifts_on(most_cycles):
            break
    raise NoContinuation(f"steady state: {run.reason(most_cycles)}")
