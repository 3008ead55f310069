"""What is done to a contact before its load cycle, and what then becomes of it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..contact.answers import Outcome
from ..contact.checks import Array, checked_loads, finite_array, finite_number, frozen, listed
from ..contact.cycle import checked_cycle
from ..contact.system import checked_plane
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import shakedown_limit
from ..limits.posed import LimitQuestion, cycle_loads
from ..transients.exact import ExactPath
from ..transients.exact.stops import turning_corners
from ..transients.steady import settled
from .range_starts import RangeStarts

__all__ = ["REST", "SLIP", "UNDECIDED", "LoadStep", "Treatment", "assembled_slip", "checked_protocol"]

REST, SLIP, UNDECIDED = "rest", "slip", "UNDECIDED"
"""What becomes of a contact after a protocol: it comes to rest, slip goes on, or a transient has no result."""

_ASSEMBLED_FROM = 1e-6  # share of the mean load at which assembly begins: at no load at all every node is closed without pressure


@dataclass(frozen=True)
class LoadStep:
    """One load of a protocol, `loads + lam * cyclic`; the load goes there in a straight line.

    Parameters
    ----------
    loads
        The part that does not depend on the load factor, load case name -> amplitude.
    cyclic
        The part that the load factor multiplies, load case name -> amplitude at load factor 1.

    Raises
    ------
    ModelError
        A name that is not a text, or an amplitude that is not finite.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.LoadStep({"P": 0.3}, {"sigma": 1.0})
    LoadStep(loads={'P': 0.3}, cyclic={'sigma': 1.0})
    """

    loads: Mapping[str, float]
    cyclic: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "loads", checked_loads("loads", self.loads))
        object.__setattr__(self, "cyclic", checked_loads("cyclic", self.cyclic))

    def __hash__(self) -> int:
        return hash((frozenset(self.loads.items()), frozenset(self.cyclic.items())))

    def __repr__(self) -> str:
        return f"LoadStep(loads={dict(self.loads)}, cyclic={dict(self.cyclic)})"

    def reactions(self, system: ContactSystem, load_factor: float) -> Array:
        """(2N,) bonded reactions `[q, p]` at a load factor, force per depth.

        Raises
        ------
        ModelError
            Not a contact system, load cases that it does not have, or a bad load factor.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        checked_plane(system)
        return np.concatenate(system.reaction(self.loads)) + load_factor * np.concatenate(system.reaction(self.cyclic))


class Treatment:
    """A contact and what is done to it before its load cycle: decides from which starts it comes to rest.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and coefficients of friction.
    start
        "assembled", "worst", or an (N,) slip.

    Raises
    ------
    ModelError
        Bad input.
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, friction: Any, start: Any) -> None:
        self.system, self.cycle = checked_plane(system), checked_cycle(cycle)
        self.friction = np.array(friction_coefficients(friction, system.nodes))
        self.limit = shakedown_limit(system, cycle, self.friction).load_factor
        self._stops = turning_corners(cycle)
        self.transients = 0
        self.residual = 0.0
        self.assembled = isinstance(start, str) and start == "assembled"
        if isinstance(start, str):
            if start not in ("assembled", "worst"):
                raise ModelError(f"start: {start!r}; give 'assembled', 'worst' or a slip, (N,)")
            self.starts = [np.zeros(system.nodes)] if self.assembled else list(self._extreme())
        else:
            self.starts = [finite_array("start", start, (system.nodes,))]

    def _extreme(self) -> Iterator[Array]:
        task = LimitQuestion(self.system, self.cycle, cycle_loads(self.system, self.cycle), self.friction, True)
        starts = RangeStarts(task, 0.0, None)
        yield from {**starts.simple(), **starts.under_mean_load}.values()

    def rests(self, load_factor: float, protocol: Sequence[LoadStep]) -> str:
        """Whether the contact comes to "rest" from all starts, keeps to "slip" from one, or is "UNDECIDED" because a transient has no result.

        A start from which it slips goes to the front of the list, for the next load factor.
        """
        undecided = False
        for number, start in enumerate(self.starts):
            answer = self.outcome(load_factor, protocol, start)
            if answer == SLIP:
                self.starts.insert(0, self.starts.pop(number))
                return SLIP
            undecided = undecided or answer == UNDECIDED
        return UNDECIDED if undecided else REST

    def outcome(self, load_factor: float, protocol: Sequence[LoadStep], start: Array) -> str:
        """The same from one start."""
        path = ExactPath(self.system, self.cycle, self.friction, load_factor, start)
        steps = [step.reactions(self.system, load_factor) for step in protocol]
        if steps:
            path.check_near("protocol", steps)
        self.transients += 1
        try:
            if self.assembled:
                _begin_assembly(path)
            path.follow_to(path.mean, "the segment to the mean load")
            for number, load in enumerate([*steps, path.mean] if steps else []):
                path.follow_to(load, f"segment {number} of the protocol")
            state, _ = settled(path, self._stops, self._stops)
        except (NoContinuation, SolverError):
            return UNDECIDED
        self.residual = max(self.residual, state.residual)
        return REST if state.outcome is Outcome.SHAKEDOWN else SLIP


def assembled_slip(system: ContactSystem, cycle: LoadCycle, friction: Any) -> Array:
    """Slip (N,) under the mean load that assembly leaves: the mean load grows from a millionth of itself, and nothing has slipped before.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle, of which only the mean load counts.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The path ends, for example because the mean load opens the contact or makes it slide as a whole.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.8, 0.0], [1.0, 1.0]), "Q": ([1.0, 0.0], [0.0, 0.0])}
    >>> pair = fo.ContactSystem.from_blocks([[1.0, -0.4], [-0.4, 1.0]], [[0.0, 0.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.assembled_slip(pair, cycle, friction=0.6).round(9)
    array([-0.2,  0. ])
    """
    path = ExactPath(system, cycle, friction, 0.0)
    _begin_assembly(path)
    path.follow_to(path.mean, "the segment to the mean load")
    return frozen(path.state.u[: path.nodes])


def _begin_assembly(path: ExactPath) -> None:
    """Go from the artificial load to the load at which assembly begins."""
    path.follow_to(_ASSEMBLED_FROM * path.mean, "the segment to the load at which assembly begins")


def checked_protocol(protocol: Any) -> list[LoadStep]:
    """Check that `protocol` is a list of load steps."""
    steps = listed("protocol", protocol)
    for step in steps:
        if not isinstance(step, LoadStep):
            raise ModelError(f"protocol: a {type(step).__name__} among its steps; give LoadStep(loads, cyclic)")
    return steps
