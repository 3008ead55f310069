"""The steady state of a transient in three dimensions, by cycles with extrapolation."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from ...contact import LoadCycle
from ...contact.answers import Outcome
from ...contact.checks import Array, finite_number, flag, frozen, whole_number
from ...contact.progress import bar_of
from ...contact.record import Recorded, SolveRecord
from ...contact.show import Plotted, frame
from ...contact.system import ContactSystem
from ...contact.tolerances import RESIDUAL, ROUNDING
from ...errors import NoContinuation, SolverError
from ..increments.projected import OPEN
from .cycles import Run, Settled
from .transient import Transient3D, doubts, step_counts

__all__ = ["SteadyState3D", "steady_state"]


@dataclass(frozen=True, eq=False, repr=False)
class SteadyState3D(Recorded, Plotted):
    """The steady state that a transient reaches in increments, confirmed by cycles that come back to it.

    Attributes
    ----------
    outcome
        The long-run behaviour.
    dissipation
        Work of friction per load cycle in the steady state, the mean over its period, >= 0, force times length; exactly 0 after shakedown.
    dissipation_per_node
        (N,) the same of each node.
    work_error
        Estimated distance of `dissipation` from that of all later cycles, over itself. At most 1e-9, unless rounding hides a work that is little
        beside the loads.
    period
        Load cycles after which the state comes back, or its drift repeats: 1 or 2.
    slip
        (N, 2) slip at the last corner of the cycle, length (for ratcheting: after the last cycle that was followed).
    open
        (N,) whether the node is open at some increment of the steady cycle.
    slipping
        (N,) whether the node slides against friction in the steady cycle, by more than rounding (1e-12 slip scales, or times the largest slip, if
        that is more) and the change over the cycle that `residual` covers.
    first_cycle
        Work of friction in the first cycle (of the load cycle itself, not of an overload).
    cycles
        Number of cycles followed, including those of proofs and of failed extrapolations.
    record
        How it was found. Its `residual` is the larger of the violation of the contact law in the confirming cycle and the change of slip over it;
        forces are in units of the largest nodal force of the load cycle, slips in units of that force over the stiffness scale. At most 1e-9.
    step_error
        Estimated error in time of the dissipation, relative. It is the largest of the differences from what a half and a quarter of the increments
        give (inf where these have no steady state), and of the work that is in doubt within the increments at whose ends alone the law is obeyed.
        Errors of contacts in a plane, whose exact path is known, were at most 5 times larger; it is no bound.
    extrapolated
        True if the transient was taken on at an extrapolated limit of its cycles, False if it reached the state cycle by cycle.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]})
    >>> steady = fo.steady_state(node, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), friction=0.5, load_factor=1.0)
    >>> steady.outcome.name, round(steady.dissipation, 9)
    ('CYCLIC_SLIP', 1.0)
    """

    engine: ClassVar[str] = "newton"

    outcome: Outcome
    dissipation: float
    dissipation_per_node: Array
    work_error: float
    period: int
    slip: Array
    open: np.ndarray[Any, np.dtype[np.bool_]]
    slipping: np.ndarray[Any, np.dtype[np.bool_]]
    first_cycle: float
    cycles: int
    record: SolveRecord
    step_error: float
    extrapolated: bool
    _system: ContactSystem = field(repr=False)

    def to_frame(self) -> Any:
        """The DataFrame of the nodes: columns node, x, y, z, slip1, slip2, open, dissipation (work of friction per cycle)."""
        columns = dict(zip("xyz", self._system.points.T, strict=True)) | {"slip1": self.slip[:, 0], "slip2": self.slip[:, 1], "open": self.open}
        return frame({"node": range(len(self.slip)), **columns, "dissipation": self.dissipation_per_node})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("outcome", "dissipation", "cycles", "residual", "step_error")}


def steady_state(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    initial_slip: Any = None,
    overload: float | None = None,
    most_cycles: int = 1000,
    steps: int = 20,
    progress: bool = True,
) -> SteadyState3D:
    """Follow a transient in increments until its cycles come back to where they began.

    It comes back after one load cycle, or after two, or drifts by the same amount in each return. Where that takes long, the limit of the last
    returns is extrapolated (reduced-rank extrapolation, Sidi 2017), and the transient goes on from there. This is done only if the limit is shown to
    be that of the transient: one linear contraction maps each of the last returns to the next, a cycle from the limit comes back to it, and cycles
    from states between the last one and the limit end where the linear map says. What is reported is what the cycles after it do.

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
    overload
        Load factor of one extra cycle before all others, >= 0; None: no such cycle.
    most_cycles
        Number of cycles after which to give up.
    steps
        Number of increments from corner to corner, at least 2, as in `march`; a half and a quarter of them tell `step_error`.
    progress
        Show a bar where it takes more than two seconds.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        No cycle comes back within `most_cycles`; its attributes say what is known by then.
    SolverError
        An increment has no valid answer, or the states violate the contact law by more than the tolerance.
    """
    start = perf_counter()
    whole_number("most_cycles", most_cycles, least=1)
    extra = None if overload is None else finite_number("overload", overload, least=0.0)
    transients = [Transient3D(system, cycle, friction, load_factor, initial_slip, "newton", number) for number in step_counts(steps)]
    with bar_of(flag("progress", progress), "steady state", "cycle", delay=2) as bar:
        fine, *coarse = [Run(transient, extra, most_cycles, bar.update) for transient in transients]
        found = fine.settled()
        error = max(_in_doubt(fine, found), *(_difference(float(found.dissipation.sum()), run) for run in coarse))
    residual = max(found.change, *(fine.violation(one) for one in found.returning))
    if not residual <= RESIDUAL:
        raise SolverError(
            f"steady state: the states violate the contact law by {residual:.1e} (tolerance {RESIDUAL:g}); bring the loads of the cycle, or the "
            "initial slip and the loads, closer together in size"
        )
    slip, length = found.returning[-1].after, fine.path.length
    way = np.sum([one.way for one in found.returning], axis=0)
    return SteadyState3D(
        outcome=found.outcome,
        dissipation=float(found.dissipation.sum()),
        dissipation_per_node=frozen(found.dissipation),
        work_error=found.work_error,
        period=len(found.returning),
        slip=frozen(slip),
        open=_frozen(np.any([one.statuses == OPEN for one in found.returning], axis=(0, 1))),
        slipping=_frozen((way > max(ROUNDING * max(length, float(np.abs(slip).max())), found.change * length)) & (found.dissipation > 0)),
        first_cycle=fine.works[0],
        cycles=fine.cycles,
        record=SolveRecord("NEWTON", (), residual, (), perf_counter() - start),
        step_error=error,
        extrapolated=fine.extrapolated,
        _system=system,
    )


def _difference(work: float, coarse: Run) -> float:
    """Relative difference of the work from that of fewer increments."""
    try:
        other = float(coarse.settled().dissipation.sum())
    except (NoContinuation, SolverError):
        return np.inf
    return abs(work - other) / max(work, other) if max(work, other) > 0 else 0.0


def _in_doubt(run: Run, found: Settled) -> float:
    """Share of the work that is in doubt within the increments of one return."""
    work = float(np.sum([one.work for one in found.returning]))
    if found.outcome is Outcome.SHAKEDOWN:
        return 0.0
    _, slip, _, q, p = (np.concatenate(states) for states in zip(*(one.states for one in found.returning), strict=True))
    status = np.concatenate([one.statuses for one in found.returning])
    q, p = np.concatenate([q[-1:], q]), np.concatenate([p[-1:], p])  # the reactions come back
    lacking, change, _ = doubts(run.path.friction, np.concatenate([found.returning[0].before[None], slip]), q, p, status)
    return float(np.sqrt(lacking.sum() * change.sum())) / work


def _frozen(values: np.ndarray[Any, np.dtype[np.bool_]]) -> np.ndarray[Any, np.dtype[np.bool_]]:
    values.flags.writeable = False
    return values
