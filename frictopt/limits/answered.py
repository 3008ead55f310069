"""What the answers of limit questions have in common: the contact, its reactions and its state under a residual slip at a load factor."""

from functools import cached_property

import numpy as np
import pandas as pd

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.checks import Array, Booleans, frozen
from ..contact.coulomb import lengths
from ..contact.record import WithSlip
from ..contact.show import Plotted, components, places
from ..contact.tolerances import RESIDUAL
from .mechanism import Mechanism
from .question import LimitQuestion

_BARE = 10 * RESIDUAL  # share of the mean friction bound below which a node carries nothing, and its traction ratio is rounding


class Answered(WithSlip, Plotted):
    """Base of results that answer a limit question by a residual slip at a load factor."""

    load_factor: float
    slip: Array
    _task: LimitQuestion

    @property
    def system(self) -> ContactSystem:
        """The contact."""
        return self._task.system

    @property
    def cycle(self) -> LoadCycle:
        """The load cycle."""
        return self._task.cycle

    @property
    def friction(self) -> Array:
        """(N,) coefficients of friction."""
        return self._task.friction

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) or (K, N, 2) and (K, N) reactions `q, p` at the corners under the slip at the load factor, force; NaN where it is not finite."""
        if not np.isfinite(self.load_factor):
            return np.full_like(self._task.q1, np.nan), np.full_like(self._task.p1, np.nan)
        return self._task.states(self.load_factor, self.slip)[2:]

    @property
    def open(self) -> Booleans:
        """(N,) which nodes are open at all corners."""
        return ~self._task.closed

    @property
    def _opened(self) -> str:
        """How many nodes are open, as the beginning of a reason."""
        opened = int(self.open.sum())
        return f"with {opened} of {self.system.nodes} nodes open under the mean load: " if opened else ""

    @property
    def state(self) -> ContactState | None:
        """The state at the last corner, from which a transient at this load factor rests where the slip is safe; None where it is not finite."""
        if not np.isfinite(self.load_factor) or not np.isfinite(self.slip).all():
            return None
        v, w, _, _ = self._task.states(self.load_factor, self.slip)
        bonded = self.system.reaction(self.cycle.at(self.load_factor)[-1])
        return ContactState(v[-1], w[-1].clip(0.0), *bonded, next_loads=self.cycle.corner_names[0])

    @property
    def traction_ratios(self) -> Array:
        """(K, N) ratios `|q| / (f p)` at the corners under the slip; NaN where the pressure or the friction vanishes, or without a slip."""
        (q, p), f = self.reactions, self.friction
        pressed = f * p > _BARE * self._task.mean_bound
        return np.where(pressed, lengths(q, p) / np.where(pressed, f * p, 1.0), np.nan)

    def _places(self) -> dict[str, object]:
        """Columns of a table with one row for each node: node, its place, its slip, and whether it is open where one is."""
        opened = {"open": self.open} if self.open.any() else {}
        return {"node": range(self.system.nodes), **places(self.system), **components("slip", self.slip), **opened}


class Rated(Answered):
    """Base of limits whose motion tells how they change with the loads."""

    constraints: tuple[str, ...]
    _motion: Mechanism

    @property
    def _rated(self) -> bool:
        return bool(np.isfinite(self.load_factor)) and not self.constraints

    @cached_property
    def load_rates(self) -> pd.DataFrame:
        """Rate of the limit with each amplitude of the load cycle: columns load, part ("mean", or the loads of a corner), amplitude, rate.

        The mean part has all load cases of the system, those of no amplitude too: which bolt to tighten is the row with the largest rate. Those of a
        guaranteed limit are of the critical state of `node`: where several nodes are critical first, such as mirror images, or its corners are more
        than needed, the limit has a kink, and this is the rate of one. NaN without a finite limit, where a guaranteed limit is `least`, and with
        constraints of your own, for those may change with the loads.
        """
        rates = self._motion.load_rates(self.system, self.cycle, self.load_factor)
        return rates if self._rated else rates.assign(rate=np.nan)

    @cached_property
    def interference_rate(self) -> Array:
        """(N,) rate of the limit with an interference at each node, 1 over length; minus that with material taken off there, a profile.

        NaN where `load_rates` are. For a load case that is an interference see also `load_rates`.
        """
        rate = self._motion.interference_rate(self.system)
        return frozen(rate if self._rated else np.full_like(rate, np.nan))
