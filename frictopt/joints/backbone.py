"""The backbone curve of a joint: its steady cycles at rising amplitudes of the load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    Array,
    Kept,
    PerNode,
    Plotted,
    finite_number,
    finite_numbers,
    flag,
    frame,
    frozen,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle, checked_cycle, friction_coefficients
from ..errors import ModelError, SolverError
from ..limits import (
    GrossSlip,
    GuaranteedLimit,
    ShakedownLimit,
    gross_slip,
    guaranteed_limit,
    shakedown_limit,
)
from ..transients import SteadyState, steady_state
from .curve_question import CurveCycle, CurveQuestion, default_factors, load_of_curve, load_size
from .resonant import Resonant
from .thresholds import first_state_that_reaches

_COLUMNS = [
    *("load_factor", "outcome", "exponent", "work", "step_error", "slipping", "slip_range"),
    *("displacement", "motion", "stiffness", "frequency", "resonance", "damping"),
    *("least_damping", "most_damping", "least_frequency", "most_frequency"),
]
_FROM_OTHERS = ["step_error", "motion"]  # columns that follow from other data of a curve
_EXTREMES = ["load_factor", "extreme", "displacement", "frequency", "resonance", "damping"]


@dataclass(frozen=True, eq=False, repr=False)
class BackboneCurve(Kept, Plotted, Resonant):
    """The steady cycles of a joint at rising load factors, each from no residual slip.

    Attributes
    ----------
    load_factor, outcome
        (K,) load factors and their outcomes: "SHAKEDOWN", "CYCLIC_SLIP" or "RATCHETING", see
        `Outcome`; "SLIDES_OFF" if no forces within friction balance the loads, "FAILED" if no
        steady state is found. For the last two the numbers are NaN, and `note` has the reason.
    work, exponent
        (K,) work of friction per cycle, and `d ln work / d ln load_factor` from the neighbouring
        load factors; NaN if a neighbouring load factor has no work.
    slipping, slip_range
        (K,) share of the contact that slips, see `SteadyState.slipping_share`, and the largest
        distance between two slips of a closed node during the cycle.
    displacement, stiffness
        (K,) half the range of the displacement of the load in the cycle, and the secant stiffness,
        which is the load factor divided by this displacement. The displacement is the work of the
        load per load factor, see `ContactSystem.displacements`. The displacement is a length only
        if the load is a single force of size 1 at load factor 1.
    damping
        (K,) damping ratio `work / (2 pi load_factor displacement)`.
    frequency
        (K,) `sqrt(stiffness) / (2 pi)`, in cycles per unit of time, if the load is the load of a
        mass-normalised mode with a `natural_frequency`. NaN for all other loads, because their
        modal mass is unknown.
    resonance
        (K,) resonance frequency under a harmonic force, from the first harmonic of the loop;
        `frequency` follows from the tips of the loop. NaN if `frequency` is NaN, or if no harmonic
        motion has this loop (see `note`). Theory, "The forced response".
    steady_states
        (K,) the steady states; None at a load factor without a steady state.
    by_contact
        DataFrame, one row for each load factor and contact: columns load_factor, contact, slipping,
        work, slip_range.
    gross_slip
        Load factor of `fo.gross_slip`. The curve ends there, because the bodies slide off above it.
        NaN if there is no such load factor, or if no solver finds it.
    self_stress
        Whether contact forces can balance themselves, as in a press fit. `gross_slip` is then the
        load factor at which the transient from no slip slides off, unless statics gives a lower
        load factor.
    least_damping, most_damping, least_frequency, most_frequency
        (K,) the smallest and the largest values of all steady states found in a search over the
        residual slips, see `dissipation_range`. These values occur, but the true range may be
        wider. NaN without a range; the frequencies are also NaN if `frequency` is NaN.
    extremes
        DataFrame of the states with the least and the most damping, two rows for each load factor:
        columns load_factor, extreme ("least", "most"), displacement, frequency, resonance, damping.
        Without rows if there is no range.
    guaranteed_limit, shakedown_limit
        Load factors of the two limits. If nodes stay closed and have friction, the damping is zero
        from every start below the guaranteed limit, and from no start above the shakedown limit.
        NaN without a range.
    natural_frequency
        Frequency of the glued contact, at amplitude zero; NaN if none was passed.
    note
        Sentences on the values that are NaN, with their reasons.
    system, cycle, friction, steps
        The input; friction is (N,).
    residual
        Largest residual of the steady states. At most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"N": ([0.0], [1.0]), "F": ([-1.0], [0.0])}
    >>> blocks = [[3.0]], [[0.0]], [[1.0]], [0.0], loads
    >>> slider = fo.ContactSystem.from_blocks(*blocks, compliance=[[0, 0], [0, 1]])
    >>> cycle = fo.LoadCycle({"N": 1.0}, [{"F": 1.0}, {"F": -1.0}])
    >>> curve = fo.joints.backbone_curve(slider, cycle, friction=0.5, load_factors=[0.4, 1.0])
    >>> curve.displacement.round(6).tolist(), curve.work.round(6).tolist(), curve.slipping.tolist()
    ([0.4, 1.166667], [0.0, 0.333333], [0.0, 1.0])
    """

    _shown_names = ("gross_slip", "guaranteed_limit", "shakedown_limit", "residual", "note")
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
    self_stress: bool
    resonance: Array
    extremes: pd.DataFrame

    def plot(self, ax: Any = None, *, scale: float | None = None) -> Any:
        """Draw the curve with matplotlib (extra `figures`), and return its axes.

        The horizontal axis is the load factor. A `scale` is the motion of a point per modal
        amplitude: with it, the horizontal axis is the amplitude at this point. `ax` are two axes,
        four for a load with a displacement, or None for a new figure. It raises ImportError if
        matplotlib is not installed, and ModelError for another number of axes, or for a `scale` if
        the load has no displacement.
        """
        return self._draw(ax, scale=scale)

    @property
    def step_error(self) -> Array:
        """(K,) estimated relative error of the work due to increments; 0 on exact paths.

        See `SteadyState.step_error`. NaN if there is no steady state. In a report, it is estimated
        only at load factor 1, and is NaN at all other load factors.
        """
        return frozen(
            [np.nan if steady is None else steady.step_error for steady in self.steady_states]
        )

    @property
    def motion(self) -> Array:
        """(K,) half the range of the mean motion of the loaded region along the load, a length.

        It is the displacement divided by the size of the load at load factor 1. NaN if this size is
        not known. Tractions, pressures, forces per volume and forces on nodes have a size, unless
        their load case also contains a moment or a load of another kind. Systems that were not
        condensed from a model lack it, see `load_size` of `ContactSystem`.
        """
        return self.displacement / load_size(self.system, self.cycle)

    def load_at(
        self, *, slipping: float | None = None, work: float | None = None, progress: bool = True
    ) -> SteadyState:
        """The steady state at which the slipping share or the work of friction reaches a number.

        The search begins in the first interval of the load factors of the curve in which the share
        or the work rises through the number. Transients narrow this interval to a ten thousandth of
        the load factor in the plane, and to a hundredth in space. The steady state at its upper end
        is returned. The share or work there is at least the number, and may be larger, because
        nodes begin to slip one by one. If the curve has just this number at its first load factor,
        the interval begins at 0.

        Parameters
        ----------
        slipping, work
            Share of the contact, or work of friction per cycle, > 0; one of the two.
        progress
            Whether to show a bar after two seconds, which counts the transients.

        Raises
        ------
        ModelError
            The curve does not rise to the number.
        NoContinuation, SolverError
            See `steady_state`.

        Examples
        --------
        >>> import frictopt as fo
        >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(21, EA=1.0, h=0.1))
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> curve = fo.joints.backbone_curve(
        ...     rod, cycle, friction=0.5, load_factors=[0.2, 0.4, 0.6, 0.8]
        ... )
        >>> half = curve.load_at(slipping=0.5)
        >>> round(half.load_factor, 2), round(half.slipping_share, 2)
        (0.55, 0.52)
        """
        if (slipping is None) == (work is None):
            raise ModelError(f"slipping, work: {slipping}, {work}; give one of the two")
        name = "work" if slipping is None else "slipping"
        wanted = finite_number(name, work if slipping is None else slipping, above=0.0)
        values = getattr(self, name)
        rises = np.flatnonzero((values[:-1] <= wanted) & (wanted <= values[1:]))  # never at NaN
        if not len(rises):
            factors = f"{self.load_factor[0]:g} to {self.load_factor[-1]:g}"
            raise ModelError(
                f"{name}: {wanted:g}, and the curve has {np.nanmin(values):.6g} to "
                f"{np.nanmax(values):.6g} at the load factors {factors}; give a value in between, "
                "or compute a curve with other load_factors"
            )
        below, reaches = self.steady_states[rises[0]], self.steady_states[rises[0] + 1]
        assert below is not None and reaches is not None  # their numbers are not NaN
        with progress_bar(progress, "load of the curve", "transient") as bar:

            def follow(factor: float) -> SteadyState:
                bar.update()
                return steady_state(
                    self.system, self.cycle, self.friction, factor, steps=self.steps, progress=False
                )

            of_steady = "dissipation" if name == "work" else "slipping_share"
            return first_state_that_reaches(wanted, of_steady, below, reaches, follow)

    def to_frame(self) -> pd.DataFrame:
        """The DataFrame with a row for each load factor; `attrs["note"]` is the note.

        The columns are load_factor, outcome, ..., most_frequency.
        """
        table = frame({name: getattr(self, name) for name in _COLUMNS}, units=self.system.units)
        table.attrs["note"] = self.note
        return table

    def _answer(self) -> Mapping[str, object]:
        outcomes = ", ".join(dict.fromkeys(self.outcome))
        factors = {"load_factors": len(self.load_factor), "outcomes": outcomes}
        return {**factors, **super()._answer()}


@warns_of_odd_values
def backbone_curve(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factors: ArrayLike | None = None,
    *,
    natural_frequency: float | None = None,
    with_range: bool = False,
    steps: int | None = None,
    progress: bool = True,
) -> BackboneCurve:
    """Work of friction, slipping share, slip, stiffness and damping of a joint for rising loads.

    Each load factor has a quasi-static steady cycle, followed from no residual slip, without
    dynamics and without Masing's rule (Festjens et al. 2013, Allen et al. 2016). Work and slipping
    share of a bolted joint converge with the mesh even if its limits do not. For a mode of a
    structure use the load from `Modes.load`, and give the `natural_frequency` of the mode. The load
    factor is then the modal force, and the displacement is the modal amplitude. Other loads have no
    frequency. Displacement, stiffness and damping need two opposed corners around a mean load, and
    a `compliance`; the other columns need neither. Theory, "Joints".

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    load_factors
        (K,) load factors, > 0 and rising. None: eight from 5 % to 95 % of the gross-slip load.
    natural_frequency
        Natural frequency in cycles per unit of time, if the load of amplitude 1 is the load of a
        mass-normalised mode. It is the frequency of the glued contact, in which nodes that are open
        under the mean load may be glued or left open. The compliance also gives a frequency, which
        the curve uses; the two may differ by 1 %. None: the load is not the load of a mode.
    with_range
        Whether to search the residual slips for the smallest and the largest damping, and to
        compute the guaranteed limit and the shakedown limit. Up to a proven guaranteed limit the
        damping is zero, and there is no search. In space the search takes hundreds of transients
        for each load factor, see `dissipation_range`.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 20 increments
        in space), and whether to show a bar after two seconds.

    Returns
    -------
    BackboneCurve
        The steady cycle at each load factor, with the gross-slip load.

    Raises
    ------
    ModelError
        Bad input: load factors that do not rise, or no load factors although nothing slides off; a
        load without displacement, if a natural frequency or a range is requested; a natural
        frequency that contradicts the compliance.
    NoContinuation, SolverError
        No load factor has a steady state, or `gross_slip` has no result. With a range, also errors
        of `shakedown_limit` and `guaranteed_limit`. After Ctrl-C the attribute `curve` of the
        KeyboardInterrupt has the finished load factors.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    >>> curve = fo.joints.backbone_curve(punch, cycle, 0.5, [1.2, 1.5], with_range=True)
    >>> bool((curve.least_damping <= curve.damping).all())
    True
    >>> bool((curve.damping <= curve.most_damping).all())
    True
    """
    coefficients = friction_coefficients(friction, system)
    flag("with_range", with_range)
    # These calls raise an error if the cycle names an unknown load case.
    system.reaction(checked_cycle(cycle).mean)
    cycle.corner_reactions(system)
    load = load_of_curve(system, cycle, coefficients, natural_frequency)
    if with_range and load.missing:
        raise ModelError(
            f"with_range: True, but the damping is unknown: {load.missing}; leave the range out"
        )
    try:
        gross: GrossSlip | SolverError = gross_slip(system, cycle, coefficients)
    except SolverError as error:
        gross = error  # for given load factors the curve does not need it
    factors = default_factors(gross) if load_factors is None else rising_factors(load_factors)
    limits: tuple[ShakedownLimit, GuaranteedLimit] | None = None
    if with_range:
        shakedown = shakedown_limit(system, cycle, coefficients)
        limits = shakedown, guaranteed_limit(system, cycle, coefficients)
    steady_at = partial(steady_state, system, cycle, coefficients, steps=steps)
    question = CurveQuestion(system, cycle, coefficients, load, gross, limits, steps, steady_at)
    return curve_at(question, factors, progress)


def rising_factors(load_factors: ArrayLike) -> Array:
    """Check load factors that rise from above 0."""
    factors = np.array(finite_numbers("load_factors", load_factors, least=0.0))
    if not len(factors) or not (np.diff(factors, prepend=0.0) > 0).all():
        raise ModelError(f"load_factors: {factors.tolist()}; give rising load factors above 0")
    return factors


def curve_at(question: CurveQuestion, factors: Array, progress: bool) -> BackboneCurve:
    """The curve at some load factors."""
    cycles = list[CurveCycle]()
    with progress_bar(progress, "backbone curve", "load factor", total=len(factors)) as bar:
        for factor in factors:
            cycles.append(question.follow(float(factor)))
            note = f"{len(cycles)} of {len(factors)} load factors are in the attribute `curve`"
            bar.keep("curve", partial(_curve, question, cycles), note)
            bar.update()
    if all(cycle.error for cycle in cycles):
        raise cycles[0].error  # type: ignore[misc]
    return _curve(question, cycles)


def _curve(question: CurveQuestion, cycles: Sequence[CurveCycle]) -> BackboneCurve:
    """The curve of the load factors that have been followed."""
    table = pd.DataFrame([cycle.row for cycle in cycles]).reindex(columns=["residual", *_COLUMNS])
    if len(cycles) > 1:
        log_work = np.log(table["work"].where(table["work"] > 0))
        table["exponent"] = np.gradient(log_work, np.log(table["load_factor"]))
    residual = float(table.pop("residual").max())
    outcome = tuple(table.pop("outcome"))
    contacts = pd.concat([cycle.by_contact for cycle in cycles], ignore_index=True)
    extremes = pd.concat([cycle.extremes for cycle in cycles], ignore_index=True)
    slides = None if isinstance(question.gross, SolverError) else question.gross
    shakedown, guaranteed = np.nan, np.nan
    if question.limits is not None:
        shakedown, guaranteed = (limit.load_factor for limit in question.limits)
    return BackboneCurve(
        **{name: frozen(values) for name, values in table.drop(columns=_FROM_OTHERS).items()},
        outcome=outcome,
        steady_states=tuple(cycle.steady for cycle in cycles),
        by_contact=contacts.reindex(
            columns=["load_factor", "contact", "slipping", "work", "slip_range"]
        ),
        extremes=extremes.reindex(columns=_EXTREMES),
        gross_slip=np.nan if slides is None else slides.load_factor,
        guaranteed_limit=guaranteed,
        shakedown_limit=shakedown,
        natural_frequency=question.load.natural_frequency,
        note="; ".join(question.notes(cycles)),
        system=question.system,
        cycle=question.cycle,
        friction=question.friction,
        steps=question.steps,
        residual=residual,
        self_stress=slides is not None and slides.self_stress is not None,
    )
