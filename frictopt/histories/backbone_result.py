"""The backbone curve: what a joint does at rising amplitudes of its load, and at which load so much of it slips or so much work is done."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..contact import Array, ContactSystem, Kept, LoadCycle, Plotted, finite_number, frame
from ..errors import ModelError
from ..transients import SteadyState, steady_state

SEEN = ("work", "slipping", "slip_range", "displacement", "stiffness", "frequency", "damping")
RANGES = ("least_damping", "most_damping", "least_frequency", "most_frequency")


@dataclass(frozen=True, eq=False, repr=False)
class BackboneCurve(Kept, Plotted):
    """What a joint does in the steady cycle at rising load factors, from a start without residual slip.

    Attributes
    ----------
    load_factor, outcome
        (K,) load factors, and what happens there: "SHAKEDOWN", "CYCLIC_SLIP" or "RATCHETING", see `Outcome`; "SLIDES_OFF" where statics balances the
        loads with no forces within friction, "FAILED" where no steady state is found. `note` says why, and the numbers there are NaN.
    work, exponent
        (K,) work of friction per cycle, and `d ln work / d ln load_factor` from the neighbouring load factors, NaN where one of them has no work.
    slipping, slip_range
        (K,) share of the contact that slips, see `SteadyState.slipping_share`, and the largest distance of two slips of a node while it is closed.
    displacement, stiffness
        (K,) half the range of the displacement of the load over the cycle, and the load factor over it, the secant stiffness. This displacement is
        the work of the load per load factor, see `ContactSystem.displacements`: a length only of a single force of size 1 at load factor 1.
    damping
        (K,) damping ratio `work / (2 pi load_factor displacement)`.
    frequency
        (K,) `sqrt(stiffness) / (2 pi)`, in cycles per unit of time, of the load of a mass-normalised mode, which has a `natural_frequency`; NaN of
        every other load, for then the stiffness is not that of a modal mass of 1.
    steady_states
        (K,) the steady states, None where there is none.
    by_contact
        DataFrame, one row for each load factor and contact: columns load_factor, contact, slipping, work, slip_range.
    gross_slip
        Load factor of `fo.gross_slip`, the end of the curve: above it the bodies slide off. NaN if no load factor, or no solver, has one.
    self_stress
        Whether contact forces balance themselves, as in a press fit: `gross_slip` is then the load factor at which the transient from no slip slides
        off, if statics has no lower one.
    least_damping, most_damping, least_frequency, most_frequency
        (K,) the least and the largest values of all steady states found over the residual slips, see `dissipation_range`: they occur; the true range
        may be wider. NaN without a range, and the frequencies where `frequency` is.
    guaranteed_limit, shakedown_limit
        Load factors below which the damping is zero from every start, and above which it is from none, while nodes stay closed and have friction.
        NaN without a range.
    natural_frequency
        Frequency of the glued contact, at amplitude zero; NaN where none was given.
    note
        What is NaN, and why, in words.
    system, cycle, friction, steps
        What was asked; friction is (N,).
    residual
        Largest residual of the steady states. At most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"N": ([0.0], [1.0]), "F": ([-1.0], [0.0])}
    >>> slider = fo.ContactSystem.from_blocks([[3.0]], [[0.0]], [[1.0]], [0.0], loads, compliance=[[0, 0], [0, 1]])
    >>> curve = fo.backbone_curve(slider, fo.LoadCycle({"N": 1.0}, [{"F": 1.0}, {"F": -1.0}]), friction=0.5, load_factors=[0.4, 1.0])
    >>> curve.displacement.round(6).tolist(), curve.work.round(6).tolist(), curve.slipping.tolist()
    ([0.4, 1.166667], [0.0, 0.333333], [0.0, 1.0])
    """

    load_factor: Array
    outcome: tuple[str, ...]
    work: Array
    exponent: Array
    slipping: Array
    slip_range: Array
    displacement: Array
    stiffness: Array
    frequency: Array
    damping: Array
    least_damping: Array
    most_damping: Array
    least_frequency: Array
    most_frequency: Array
    steady_states: tuple[SteadyState | None, ...]
    by_contact: pd.DataFrame
    gross_slip: float
    guaranteed_limit: float
    shakedown_limit: float
    natural_frequency: float
    note: str
    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    steps: int | None
    residual: float
    self_stress: bool = False

    @property
    def motion(self) -> Array:
        """(K,) half the range of the mean motion of what the load acts on, along the load, over the cycle, length.

        It is the displacement over the size of the load at load factor 1. NaN where that is not known: of loads that are no tractions or forces per
        volume, and of systems that no model was condensed to, see `load_size` of `ContactSystem`.
        """
        return self.displacement / size_of(self.system, self.cycle)

    def load_at(self, *, slipping: float | None = None, work: float | None = None, progress: bool = True) -> SteadyState:
        """The steady state near the load factor at which so large a share of the contact slips, or the work per cycle is so large.

        The load factor is interpolated between the two neighbours on the curve where the number first rises to the asked one: work between the
        logarithms of both. One transient follows what happens there. Its `slipping_share` and `dissipation` are what was seen, which is not quite
        what was asked: the share moves in steps of nodes, and between distant load factors work is no power of the load.

        Parameters
        ----------
        slipping, work
            Share of the contact, or work of friction per cycle, > 0; one of the two.
        progress
            See `steady_state`.

        Raises
        ------
        ModelError
            The curve does not rise to the number.
        NoContinuation, SolverError
            See `steady_state`.

        Examples
        --------
        >>> import frictopt as fo
        >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=21, EA=1.0, h=0.1))
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> curve = fo.backbone_curve(rod, cycle, friction=0.5, load_factors=[0.2, 0.4, 0.6, 0.8])
        >>> half = curve.load_at(slipping=0.5)
        >>> round(half.load_factor, 2), round(half.slipping_share, 2)
        (0.57, 0.52)
        """
        given = {name: value for name, value in {"slipping": slipping, "work": work}.items() if value is not None}
        if len(given) != 1:
            raise ModelError(f"slipping, work: {slipping}, {work}; give one of the two")
        ((name, value),) = given.items()
        asked, seen = finite_number(name, value, above=0.0), getattr(self, name)
        found = np.flatnonzero((seen[:-1] <= asked) & (asked <= seen[1:]))  # NaN is neither
        if not len(found):
            ends = f"{np.nanmin(seen):.6g} to {np.nanmax(seen):.6g} at the load factors {self.load_factor[0]:g} to {self.load_factor[-1]:g}"
            raise ModelError(f"{name}: {asked:g}, and the curve has {ends}; give a value in between, or ask for a curve of other load_factors")
        pair = slice(found[0], found[0] + 2)
        of, to = (np.log, np.exp) if name == "work" and seen[found[0]] > 0 else (np.positive, np.positive)
        factor = to(np.interp(of(asked), of(seen[pair]), of(self.load_factor[pair])))
        return steady_state(self.system, self.cycle, self.friction, float(factor), steps=self.steps, progress=progress)

    def to_frame(self) -> pd.DataFrame:
        """The DataFrame of the load factors, one row each: columns load_factor, outcome, .., most_frequency; `attrs["note"]` is the note."""
        names = ("load_factor", "outcome", "exponent", *SEEN[:4], "motion", *SEEN[4:], *RANGES)
        table = frame({name: getattr(self, name) for name in names}, units=self.system.units)
        table.attrs["note"] = self.note
        return table

    def _answer(self) -> Mapping[str, object]:
        known = {name: float(np.nanmax(getattr(self, name))) for name in SEEN if not np.isnan(getattr(self, name)).all()}
        named = {name: value for name in ("natural_frequency", "guaranteed_limit", "shakedown_limit") if (value := getattr(self, name)) >= 0}
        largest = {f"largest_{name}": known[name] for name in ("work", "slipping", "slip_range", "damping") if name in known}
        least = {"least_frequency": float(np.nanmin(self.frequency))} if "frequency" in known else {}
        count = {"load_factors": len(self.load_factor), "outcomes": ", ".join(dict.fromkeys(self.outcome))}
        return {**count, **largest, **least, **named, "gross_slip": self.gross_slip, "residual": self.residual, "note": self.note}


def size_of(system: ContactSystem, cycle: LoadCycle) -> float:
    """Size of the cyclic load at load factor 1, force, by its first corner; NaN where it is not known."""
    return sum(abs(amplitude) * system.load_size.get(case, np.nan) for case, amplitude in cycle.corners[0].items() if amplitude) or np.nan
