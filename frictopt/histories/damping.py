"""Frequency and damping of a joint against the amplitude of its load, and their range over the residual slips."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..contact import ROUNDING, ContactSystem, Kept, LoadCycle, Outcome, Plotted, checked_cycle, checked_system, friction_coefficients, reactions
from ..contact.checks import Array, finite_number, finite_numbers, flag, frozen, warns_of_odd_values
from ..errors import ModelError, NoContinuation
from ..limits import guaranteed_limit, shakedown_limit
from ..transients import SteadyState, steady_state
from .dissipation_range import dissipation_range

_SAME_MODE = 1e-2  # two natural frequencies of one mode differ by less: codes write them with few digits


@dataclass(frozen=True, eq=False, repr=False)
class DampingCurve(Kept, Plotted):
    """Frequency and damping of a contact at rising amplitudes of its load.

    Attributes
    ----------
    load_factor, displacement, stiffness
        (K,) amplitudes of the load, half the range of its displacement over the steady cycle that a contact without residual slip reaches, and the
        former over the latter.
    frequency
        (K,) `sqrt(stiffness) / (2 pi)`, in cycles per unit of time, of the load of a mass-normalised mode, which has a `natural_frequency`; NaN of
        every other load, for then the stiffness is not that of a modal mass of 1.
    work, damping, exponent
        (K,) work of friction per cycle, damping ratio `work / (2 pi load_factor displacement)`, and `d ln work / d ln load_factor` from the
        neighbouring load factors, NaN where one of them has no work.
    least_damping, most_damping, least_frequency, most_frequency
        (K,) the least and the largest values of all steady states found over the residual slips, see `dissipation_range`: they occur; the true range
        may be wider. NaN without a range, and the frequencies where `frequency` is.
    natural_frequency
        Frequency of the glued contact, at amplitude zero; NaN where none was given.
    guaranteed_limit, shakedown_limit
        Load factors below which the damping is zero from every start, and above which it is from none, while nodes stay closed and have friction.
    residual
        Largest residual of the steady states. At most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"N": ([0.0], [1.0]), "F": ([-1.0], [0.0])}
    >>> slider = fo.ContactSystem.from_blocks([[3.0]], [[0.0]], [[1.0]], [0.0], loads, compliance=[[0, 0], [0, 1]])
    >>> curve = fo.damping_curve(slider, fo.LoadCycle({"N": 1.0}, [{"F": 1.0}, {"F": -1.0}]), friction=0.5, load_factors=[0.4, 1.0])
    >>> curve.displacement.round(6).tolist(), curve.work.round(6).tolist()
    ([0.4, 1.166667], [0.0, 0.333333])
    """

    load_factor: Array
    displacement: Array
    stiffness: Array
    frequency: Array
    work: Array
    damping: Array
    least_damping: Array
    most_damping: Array
    least_frequency: Array
    most_frequency: Array
    exponent: Array
    natural_frequency: float
    guaranteed_limit: float
    shakedown_limit: float
    residual: float

    def to_frame(self) -> pd.DataFrame:
        """The DataFrame of the load factors, one row each: columns load_factor, displacement, .., most_frequency, exponent."""
        return pd.DataFrame({name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)})

    def _answer(self) -> Mapping[str, object]:
        said = {"load_factors": len(self.load_factor), "largest_damping": float(self.damping.max())}
        if self.natural_frequency > 0:
            said |= {"least_frequency": float(self.frequency.min()), "natural_frequency": self.natural_frequency}
        return said | {name: getattr(self, name) for name in ("guaranteed_limit", "shakedown_limit", "residual")}


@warns_of_odd_values
def damping_curve(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factors: ArrayLike,
    *,
    natural_frequency: float | None = None,
    range: bool = True,
    steps: int | None = None,
    progress: bool = True,
) -> DampingCurve:
    """Frequency and damping of a joint at rising amplitudes of a load, by quasi-static steady cycles (Festjens et al. 2013, Allen et al. 2016).

    No dynamics and no Masing's rule: each amplitude has its own steady cycle. For a mode of a structure the load is that of `modal_load`: the load
    factor is then the modal force, the displacement the modal amplitude. Say so by the `natural_frequency` of the mode: other loads have a stiffness
    and a damping, and no frequency. Theory, "Joints".

    Parameters
    ----------
    system, friction
        The contact, with its `compliance` or else with a `natural_frequency`, and its coefficient of friction, one or one per node.
    cycle, load_factors
        Mean load (bolts, preload), and two opposed corners, `{"mode": 1.0}` and `{"mode": -1.0}`; (K,) load factors, > 0 and rising.
    natural_frequency
        That of the glued contact, in cycles per unit of time, where the load of amplitude 1 is that of a mass-normalised mode. It may differ by 1 %
        from what the compliance says, which counts. None: the load is no mode, and has no frequency.
    range
        Whether to search the residual slips for the least and the most damping. Up to a guaranteed limit that is proven it is zero, and there is no
        search. In space it takes hundreds of transients in increments for each load factor, see `dissipation_range`.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 20 in space), and whether to show a bar after two seconds.

    Raises
    ------
    ModelError
        Bad input: corners that are not opposed, a load that does no work on the glued bodies, neither compliance nor natural frequency, or two that
        contradict each other.
    NoContinuation
        No steady state is found at a load factor, for example because the bodies slide off, or the contact ratchets.
    SolverError
        See `steady_state`, `shakedown_limit` and `guaranteed_limit`.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    >>> curve = fo.damping_curve(punch, cycle, friction=0.5, load_factors=[1.2, 1.5])
    >>> bool((curve.least_damping <= curve.damping).all() and (curve.damping <= curve.most_damping).all())
    True
    """
    direction = _direction(checked_system(system), checked_cycle(cycle))
    f, searched = np.array(friction_coefficients(friction, system.nodes)), flag("range", range)
    factors = np.array(finite_numbers("load_factors", load_factors, least=0.0))
    if not len(factors) or not (np.diff(factors, prepend=0.0) > 0).all():
        raise ModelError(f"load_factors: {factors.tolist()}; give load factors that rise, the first one above 0")
    system, compliance = _with_compliance(system, direction, natural_frequency)
    safe, guaranteed = shakedown_limit(system, cycle, f).load_factor, guaranteed_limit(system, cycle, f)
    seen, residuals = [], []
    for factor in factors:
        states = [steady_state(system, cycle, f, factor, steps=steps, progress=progress)]
        residuals.append(states[0].residual)
        if searched and not (guaranteed.proven and factor <= guaranteed.load_factor):
            found = dissipation_range(system, cycle, f, factor, steps=steps, progress=progress)
            residuals.append(found.residual)
            states += [state for state in found.steady_states if state.outcome is not Outcome.RATCHETING]
        seen += [(factor, *_measured(state, direction, compliance)) for state in states]
    table = pd.DataFrame(seen, columns=["load_factor", "displacement", "work"])
    table["stiffness"] = table["load_factor"] / table["displacement"]
    table["frequency"] = np.nan if natural_frequency is None else np.sqrt(table["stiffness"]) / (2 * np.pi)
    table["damping"] = table["work"] / table["displacement"] / table["load_factor"] / (2 * np.pi)  # the product of two tiny ones would be 0
    curve = table.drop_duplicates("load_factor").set_index("load_factor", drop=False)  # the first state is that without residual slip
    logs = np.log(curve["work"].where(curve["work"] > 0))
    curve["exponent"] = np.gradient(logs, np.log(factors)) if len(factors) > 1 else np.nan
    for name in ("damping", "frequency"):
        ends = table.groupby("load_factor")[name]
        curve[f"least_{name}"], curve[f"most_{name}"] = (ends.min(), ends.max()) if searched else (np.nan, np.nan)
    return DampingCurve(
        **{name: frozen(column) for name, column in curve.items()},
        natural_frequency=np.nan if natural_frequency is None else float(compliance**-0.5 / (2 * np.pi)),
        guaranteed_limit=guaranteed.load_factor,
        shakedown_limit=safe,
        residual=max(residuals),
    )


def _measured(steady: SteadyState, direction: Array, compliance: float) -> tuple[float, float]:
    """Half range of the displacement of a load, by its amplitudes (cases,) and its compliance, and work per cycle."""
    if steady.outcome is Outcome.RATCHETING:
        raise NoContinuation(f"damping: the contact ratchets at load factor {steady.load_factor:g}, so its displacement has no range; load it less")
    if steady.outcome is Outcome.SHAKEDOWN and steady.friction.all() and not steady.open.any():
        return compliance * steady.load_factor, 0.0
    path = steady.states()
    return float(np.ptp(path.system.displacements(path.amplitudes, path.slip, path.gap) @ direction) / 2), steady.dissipation


def _direction(system: ContactSystem, cycle: LoadCycle) -> Array:
    """(cases,) amplitudes of the load of two opposed corners."""
    system.reaction(cycle.mean)
    corners = [np.array([corner.get(case, 0.0) for case in system.bonded]) for corner in cycle.corners]
    reactions(system, cycle.corners)  # says which load case is unknown
    if cycle.fixed or len(corners) != 2 or not np.array_equal(corners[0], -corners[1]) or not corners[0].any():
        raise ModelError(f"cycle: {cycle}; give two opposed corners, [{{'mode': 1.0}}, {{'mode': -1.0}}], around a mean load, and no fixed part")
    return corners[0]


def _with_compliance(system: ContactSystem, direction: Array, natural_frequency: float | None) -> tuple[ContactSystem, float]:
    """The contact with a compliance, its own or one of which the load has what its natural frequency says; and that of the load."""
    given = None if natural_frequency is None else (2 * np.pi * finite_number("natural_frequency", natural_frequency, above=0.0)) ** -2
    if system.compliance is None:
        if given is None:
            raise ModelError("natural_frequency: None, and the system has no compliance, which `condense` finds; of a mode give the frequency")
        return replace(system, compliance=given * np.outer(direction, direction) / (direction @ direction) ** 2), given
    own = float(direction @ system.compliance @ direction)
    if not own > ROUNDING * np.abs(system.compliance).max():
        raise ModelError(f"corners: the load does no work on the glued bodies (compliance {own:g}); give a load of forces")
    if given is not None and abs(np.sqrt(given / own) - 1) > _SAME_MODE:
        raise ModelError(
            f"natural_frequency: {natural_frequency:g}, and the compliance of the load says {1 / (2 * np.pi * np.sqrt(own)):g}; give the load of a "
            "mass-normalised mode (`modal_load`), or leave the natural frequency out"
        )
    return system, own
