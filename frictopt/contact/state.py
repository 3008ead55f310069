"""The state of a contact from which a transient goes on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..base import (
    Array,
    Booleans,
    Kept,
    Table,
    check_entries,
    components,
    finite_array,
    frame,
    real_array,
    shown,
    whole_number,
)
from ..errors import ModelError
from .system import ContactSystem


@dataclass(frozen=True, eq=False, repr=False)
class ContactState(Kept):
    """Slip and gap of all nodes under a load.

    The further motion of a quasi-static contact depends only on this state. Nodes may be open. The
    reactions follow from the system, so the state is valid only for the system and the friction
    with which it was computed.

    Parameters
    ----------
    slip, gap
        Slip v, (N,) along +x in the plane, (N, 2) along the tangents in space, and (N,) gap w
        (initial gap included, >= 0), length.
    bonded_q, bonded_p
        Bonded reactions of the load, as `ContactSystem.reaction` returns them: q in the shape of
        `slip`, p (N,); force per depth in the plane, force in space.
    next_corner, next_loads
        Index and name of the next corner, see `LoadCycle.corner_names`; the load changes linearly
        up to it. If the name is None, the index is shown.

    Raises
    ------
    ModelError
        Arrays of different lengths, entries not finite, a negative gap, or a corner that is no
        whole number >= 0.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> before = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> before.state
    ContactState(nodes=4, open=0, next_corner='force = +1')
    >>> fo.steady_state(
    ...     rod, cycle, friction=0.5, load_factor=0.4, initial_state=before.state
    ... ).outcome.name
    'SHAKEDOWN'
    """

    slip: Array
    gap: Array
    bonded_q: Array
    bonded_p: Array
    next_corner: int = 0
    next_loads: str | None = None

    def __post_init__(self) -> None:
        in_plane = real_array("slip", self.slip).ndim < 2
        slip = finite_array("slip", self.slip, (None,) if in_plane else (None, 2))
        nodes = slip.shape[:1]
        gap = finite_array("gap", self.gap, nodes)
        bonded_q = finite_array("bonded_q", self.bonded_q, slip.shape)
        bonded_p = finite_array("bonded_p", self.bonded_p, nodes)
        if not len(slip):
            raise ModelError("slip: no nodes; a state has at least one")
        check_entries("gap", gap, gap >= 0, "the bodies cannot overlap, give gap >= 0")
        corner = whole_number("next_corner", self.next_corner, least=0)
        if self.next_loads is not None and not isinstance(self.next_loads, str):
            raise ModelError(
                f"next_loads: {shown(self.next_loads)} is not a text; give the loads of the "
                "corner as LoadCycle.corner_names writes them"
            )
        vars(self).update(
            slip=slip, gap=gap, bonded_q=bonded_q, bonded_p=bonded_p, next_corner=corner
        )

    @property
    def open(self) -> Booleans:
        """(N,) whether each node has a gap."""
        return self.gap > 0

    def to_frame(self) -> Table:
        """The DataFrame of the nodes: columns node, slip (in space slip1, slip2), gap."""
        columns = {"node": range(len(self.slip)), **components("slip", self.slip), "gap": self.gap}
        return frame(columns)

    def _answer(self) -> Mapping[str, object]:
        corner = self.next_corner if self.next_loads is None else repr(self.next_loads)
        return {"nodes": len(self.slip), "open": int(self.open.sum()), "next_corner": corner}


def checked_state(state: object, system: ContactSystem, corners: int) -> ContactState:
    """Check that `state` is a state of a contact under a load cycle with so many corners."""
    if not isinstance(state, ContactState):
        raise ModelError(
            f"initial_state: a {type(state).__name__}; give a ContactState, as `.state` of a "
            "steady state or `.state_at(...)` of a trajectory"
        )
    if state.slip.shape != system.slip_shape:
        raise ModelError(
            f"initial_state: its slip has the shape {state.slip.shape}, a slip of the contact "
            f"{system.slip_shape}; give a state of this contact"
        )
    if state.next_corner >= corners:
        loads = "" if state.next_loads is None else f" ({state.next_loads})"
        raise ModelError(
            f"initial_state: its next corner is {state.next_corner}{loads}, the load cycle has the "
            f"corners 0 to {corners - 1}"
        )
    return state
