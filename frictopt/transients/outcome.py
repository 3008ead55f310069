"""The steady state of a contact and its outcome."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.answers import Outcome
from ..contact.checks import Array
from ..contact.record import Recorded, SolveRecord
from ..contact.show import Plotted, frame

__all__ = ["SteadyState"]


@dataclass(frozen=True, eq=False, repr=False)
class SteadyState(Recorded, Plotted):
    """The steady state that a transient reaches, proven by a cycle that starts from it and returns to it.

    Theory, eq. (15).

    Attributes
    ----------
    outcome
        The long-run behaviour.
    dissipation
        Work of friction per load cycle in the steady state, the mean over its period, >= 0, force times length per depth; exactly 0 after shakedown.
    dissipation_per_node
        (N,) the same of each node.
    work_error
        Estimated distance of `dissipation` from that of all later cycles, over itself. At most 1e-9, unless rounding hides a work that is little
        beside the loads.
    period
        Load cycles after which the state comes back, or its drift repeats: 1 or 2.
    system, cycle, friction, load_factor
        What was asked: the contact, its load cycle, (N,) coefficients of friction, and the load factor.
    slip
        (N,) slip at the last corner of the cycle, length (for ratcheting: after the last cycle that was followed).
    gap
        (N,) gap w at the last corner, length.
    state
        Slip, gap and load there, from which another transient may start.
    open
        (N,) whether the node is open at some corner of the steady cycle at which the load turns.
    slipping
        (N,) whether the node slides against friction in the steady cycle, by more than the resolution of the path: 1e-12 slip scales (or times the
        largest slip, if that is more), and the change over the cycle that `residual` covers.
    first_cycle
        Work of friction in the first cycle (of the load cycle itself, not of an overload).
    cycles
        Number of cycles followed, including those of proofs and of failed extrapolations.
    events
        Number of changes of status.
    record
        How it was found. Its `residual` is the largest of three errors: the violation of the contact law at the corners of the proving cycle; the
        change of slip over that cycle; and the error of the energy balance of any cycle, over the largest energy in it. Forces are in units of the
        largest nodal force of the load cycle, slips in units of that force over the stiffness scale. At most 1e-9.
    extrapolated
        True if the state is the extrapolated fixed point of the cycle map, False if the transient reached it cycle by cycle.
    unproven
        Number of events whose rates are not proven to be the only ones that obey the contact law; 0: no other transient follows from this start. Such
        events occur where nodes lift off, or where friction comes near its critical value. The transient and its steady state obey the law all the
        same, to `residual`; but another transient from the same start may end in another steady state.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> steady.to_frame()[["node", "dissipation"]].round(6)
       node  dissipation
    0     0          1.0
    1     1          0.0
    2     2          0.0
    3     3          0.0
    """

    engine: ClassVar[str] = "path"

    outcome: Outcome
    dissipation: float
    dissipation_per_node: Array
    work_error: float
    period: int
    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    load_factor: float
    slip: Array
    gap: Array
    state: ContactState
    open: np.ndarray[Any, np.dtype[np.bool_]]
    slipping: np.ndarray[Any, np.dtype[np.bool_]]
    first_cycle: float
    cycles: int
    events: int
    extrapolated: bool
    unproven: int
    record: SolveRecord

    @property
    def x(self) -> Array:
        """(N,) coordinates of the nodes along the interface, length."""
        return self.system.x

    @property
    def uniqueness(self) -> str:
        """Whether another transient may follow from the same start, in words."""
        if self.unproven == 0:
            return "proven: no other transient follows from this start"
        return (
            f"not proven at {self.unproven} events: this transient and its steady state obey the contact law, but from the same start there may be "
            "another with another outcome"
        )

    def to_frame(self) -> Any:
        """The DataFrame of the nodes: columns node, x, slip, open, dissipation (work of friction per cycle)."""
        return frame({"node": range(len(self.x)), "x": self.x, "slip": self.slip, "open": self.open, "dissipation": self.dissipation_per_node})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("outcome", "dissipation", "cycles", "residual", "uniqueness")}
