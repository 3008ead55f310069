"""A transient of a study: its contact, load cycle and friction, its load factor and its start."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..base import Array
from ..contact import ContactSystem, LoadCycle, contact_law
from ..limits import GrossSlip, ShakedownLimit, gross_slip_of_statics
from .starts import Start


@dataclass(frozen=True, eq=False)
class Case:
    """The input that all runs of a study at one friction and load cycle share.

    `number` is the place of the friction in its list, `label` the name of the load cycle, "" if the
    study has a single one. `limit` is the shakedown limit for starts that need it, None if none
    does or no solver proves one.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    number: int = 0
    label: str = ""
    limit: ShakedownLimit | None = None

    @cached_property
    def force(self) -> float:
        """Sum of the normal reactions under the mean load."""
        _, p = self.cycle.mean_reaction(self.system)
        return float(p.sum())

    @cached_property
    def statics(self) -> GrossSlip:
        """The load factors at which forces within friction balance the loads, for all starts."""
        return gross_slip_of_statics(self.system, self.cycle, self.friction)

    @cached_property
    def loads(self) -> str:
        """Digest of the load case names and amplitudes of the cycle, without the contact."""
        parts: list[Mapping[str, float] | None] = [self.cycle.mean, *self.cycle.corners, None]
        parts += self.cycle.fixed or ()
        content = repr([part and sorted(part.items()) for part in parts])
        return hashlib.sha256(content.encode()).hexdigest()[:40]

    @cached_property
    def digest(self) -> bytes:
        """Digest of contact, load cycle and friction."""
        system, cycle = self.system, self.cycle
        reactions = (*cycle.mean_reaction(system), *cycle.corner_reactions(system))
        fixed = () if cycle.fixed is None else cycle.unscaled_reactions(system)
        terms = contact_law(system, self.friction).terms
        constants = [term.constant for term in terms if term.constant.any()]
        return _digest(system.S, system.gap, self.friction, *reactions, *fixed, *constants)

    @property
    def key(self) -> str:
        """The digest as text, the key of the shakedown limit in a store."""
        return self.digest.hex()[:40]


@dataclass(frozen=True, eq=False)
class Run:
    """A transient of a study: its case, its load factor and its start."""

    case: Case
    load_factor: float
    start: Start

    @cached_property
    def key(self) -> str:
        """Digest of the content.

        For a start at a multiple of the safe slip, the digest uses the multiple, because solvers
        may find different safe slips.
        """
        start = self.start
        state = start.state
        arrays: tuple[ArrayLike | None, ...] = ()
        if state is not None:
            arrays = (state.slip, state.gap, state.bonded_q, state.bonded_p, state.next_corner)
        content = _digest(
            *arrays, self.load_factor, start.slip, start.safe_multiple, start.overload
        )
        return hashlib.sha256(self.case.digest + content).hexdigest()[:40]


def _digest(*values: ArrayLike | None) -> bytes:
    """Digest of the digests of numbers and arrays, so that it depends on their boundaries."""
    parts = list[bytes]()
    for value in values:
        content = b"-"
        if value is not None:
            content = np.ascontiguousarray(value, dtype=np.float64).tobytes()
        parts.append(hashlib.sha256(content).digest())
    return hashlib.sha256(b"".join(parts)).digest()
