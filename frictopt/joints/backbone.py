"""The backbone curve of a joint: steady cycles at rising amplitudes of its load, and their range over the residual slips."""

# One file because the curve, the question that makes it and the terms of both name each other.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    ROUNDING,
    Array,
    Kept,
    Outcome,
    Plotted,
    bar_of,
    finite_number,
    finite_numbers,
    flag,
    frame,
    frozen,
    warns_of_odd_values,
)
from ..contact import (
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    friction_coefficients,
    joined,
)
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import GrossSlip, GuaranteedLimit, gross_slip, guaranteed_limit, shakedown_limit
from ..study.dissipation_range import dissipation_range
from ..transients import SteadyState, steady_state
from ..transients.march import open_at_rest

SEEN = ("work", "slipping", "slip_range", "displacement", "stiffness", "frequency", "damping")
RANGES = ("least_damping", "most_damping", "least_frequency", "most_frequency")


@dataclass(frozen=True, eq=False, repr=False)
class BackboneCurve(Kept, Plotted):
    """What a joint does in the steady cycle at rising load factors, from a start without residual slip.

    Attributes
    ----------
    load_factor, outcome
        (K,) load factors, and what happens there: "SHAKEDOWN", "CYCLIC_SLIP" or "RATCHETING", see
        `Outcome`; "SLIDES_OFF" where statics balances the loads with no forces within friction,
        "FAILED" where no steady state is found. `note` says why, and the numbers there are NaN.
    work, exponent
        (K,) work of friction per cycle, and `d ln work / d ln load_factor` from the neighbouring
        load factors, NaN where one of them has no work.
    slipping, slip_range
        (K,) share of the contact that slips, see `SteadyState.slipping_share`, and the largest
        distance of two slips of a node while it is closed.
    displacement, stiffness
        (K,) half the range of the displacement of the load over the cycle, and the load factor over
        it, the secant stiffness. This displacement is the work of the load per load factor, see
        `ContactSystem.displacements`: a length only of a single force of size 1 at load factor 1.
    damping
        (K,) damping ratio `work / (2 pi load_factor displacement)`.
    frequency
        (K,) `sqrt(stiffness) / (2 pi)`, in cycles per unit of time, of the load of a
        mass-normalised mode, which has a `natural_frequency`; NaN of every other load, for then the
        stiffness is not that of a modal mass of 1.
    steady_states
        (K,) the steady states, None where there is none.
    by_contact
        DataFrame, one row for each load factor and contact: columns load_factor, contact, slipping,
        work, slip_range.
    gross_slip
        Load factor of `fo.gross_slip`, the end of the curve: above it the bodies slide off. NaN if
        no load factor, or no solver, has one.
    self_stress
        Whether contact forces balance themselves, as in a press fit: `gross_slip` is then the load
        factor at which the transient from no slip slides off, if statics has no lower one.
    least_damping, most_damping, least_frequency, most_frequency
        (K,) the least and the largest values of all steady states found over the residual slips,
        see `dissipation_range`: they occur; the true range may be wider. NaN without a range, and
        the frequencies where `frequency` is.
    guaranteed_limit, shakedown_limit
        Load factors below which the damping is zero from every start, and above which it is from
        none, while nodes stay closed and have friction. NaN without a range.
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

        It is the displacement over the size of the load at load factor 1. NaN where that is not
        known: of loads that are no tractions or forces per volume, and of systems that no model was
        condensed to, see `load_size` of `ContactSystem`.
        """
        return self.displacement / size_of(self.system, self.cycle)

    def load_at(
        self, *, slipping: float | None = None, work: float | None = None, progress: bool = True
    ) -> SteadyState:
        """The steady state near the load factor at which so large a share of the contact slips, or the work per cycle is so large.

        The load factor is interpolated between the two neighbours on the curve where the number
        first rises to the asked one: work between the logarithms of both. One transient follows
        what happens there. Its `slipping_share` and `dissipation` are what was seen, which is not
        quite what was asked: the share moves in steps of nodes, and between distant load factors
        work is no power of the load.

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
        given = {
            name: value
            for name, value in {"slipping": slipping, "work": work}.items()
            if value is not None
        }
        if len(given) != 1:
            raise ModelError(f"slipping, work: {slipping}, {work}; give one of the two")
        ((name, value),) = given.items()
        asked, seen = finite_number(name, value, above=0.0), getattr(self, name)
        found = np.flatnonzero((seen[:-1] <= asked) & (asked <= seen[1:]))  # NaN is neither
        if not len(found):
            ends = f"{np.nanmin(seen):.6g} to {np.nanmax(seen):.6g} at the load factors {self.load_factor[0]:g} to {self.load_factor[-1]:g}"
            raise ModelError(
                f"{name}: {asked:g}, and the curve has {ends}; give a value in between, or ask for a curve of other load_factors"
            )
        pair = slice(found[0], found[0] + 2)
        of, to = (
            (np.log, np.exp)
            if name == "work" and seen[found[0]] > 0
            else (np.positive, np.positive)
        )
        factor = to(np.interp(of(asked), of(seen[pair]), of(self.load_factor[pair])))
        return steady_state(
            self.system,
            self.cycle,
            self.friction,
            float(factor),
            steps=self.steps,
            progress=progress,
        )

    def to_frame(self) -> pd.DataFrame:
        """The DataFrame of the load factors, one row each: columns load_factor, outcome, .., most_frequency; `attrs["note"]` is the note."""
        names = ("load_factor", "outcome", "exponent", *SEEN[:4], "motion", *SEEN[4:], *RANGES)
        table = frame({name: getattr(self, name) for name in names}, units=self.system.units)
        table.attrs["note"] = self.note
        return table

    def _answer(self) -> Mapping[str, object]:
        known = {
            name: float(np.nanmax(getattr(self, name)))
            for name in SEEN
            if not np.isnan(getattr(self, name)).all()
        }
        named = {
            name: value
            for name in ("natural_frequency", "guaranteed_limit", "shakedown_limit")
            if (value := getattr(self, name)) >= 0
        }
        largest = {
            f"largest_{name}": known[name]
            for name in ("work", "slipping", "slip_range", "damping")
            if name in known
        }
        least = (
            {"least_frequency": float(np.nanmin(self.frequency))} if "frequency" in known else {}
        )
        count = {
            "load_factors": len(self.load_factor),
            "outcomes": ", ".join(dict.fromkeys(self.outcome)),
        }
        return {
            **count,
            **largest,
            **least,
            **named,
            "gross_slip": self.gross_slip,
            "residual": self.residual,
            "note": self.note,
        }


def size_of(system: ContactSystem, cycle: LoadCycle) -> float:
    """Size of the cyclic load at load factor 1, force, by its first corner; NaN where it is not known."""
    return (
        sum(
            abs(amplitude) * system.load_size.get(case, np.nan)
            for case, amplitude in cycle.corners[0].items()
            if amplitude
        )
        or np.nan
    )


_SAME_MODE = (
    1e-2  # two natural frequencies of one mode differ by less: codes write them with few digits
)
_SLIDES_OFF, _FAILED = "SLIDES_OFF", "FAILED"  # outcomes of load factors without a steady state
_FROM, _TO, _COUNT = (
    0.05,
    0.95,
    8,
)  # load factors that are followed unless others are asked for, over the sliding-off load


@warns_of_odd_values
def backbone_curve(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factors: ArrayLike | None = None,
    *,
    natural_frequency: float | None = None,
    range: bool = False,
    steps: int | None = None,
    progress: bool = True,
) -> BackboneCurve:
    """What grows with the load: work of friction, slipping share, slip, stiffness and damping of a joint (Festjens et al. 2013, Allen et al. 2016).

    Each load factor has a quasi-static steady cycle, followed from no residual slip: no dynamics,
    no Masing's rule. Work and slipping share of a bolted joint settle with the mesh where its
    limits do not. For a mode of a structure the load is that of `modal_load`: the load factor is
    then the modal force, the displacement the modal amplitude. Say so by the `natural_frequency` of
    the mode: other loads have no frequency. Displacement, stiffness and damping need two opposed
    corners around a mean load, and a `compliance`; the rest needs neither. Theory, "Joints".

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    load_factors
        (K,) load factors, > 0 and rising. None: eight from 5 % to 95 % of the sliding-off load.
    natural_frequency
        That of the glued contact, or with the nodes open that the mean load leaves open, in cycles
        per unit of time, where the load of amplitude 1 is that of a mass-normalised mode. It may
        differ by 1 % from what the compliance says, which counts. None: no mode, no frequency.
    range
        Whether to search the residual slips for the least and the most damping, and to find both
        limits. Up to a guaranteed limit that is proven the damping is zero, and there is no search.
        In space it takes hundreds of transients for each load factor, see `dissipation_range`.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 20 in space),
        and whether to show a bar after two seconds.

    Raises
    ------
    ModelError
        Bad input: load factors that do not rise, or None where nothing slides off; with a natural
        frequency or a range a load without displacement, and a natural frequency that contradicts
        the compliance.
    NoContinuation, SolverError
        No load factor has a steady state; see `gross_slip`, and with a range `shakedown_limit` and
        `guaranteed_limit`. After Ctrl-C the attribute `curve` of the error has the load factors
        that are finished.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    >>> curve = fo.backbone_curve(punch, cycle, friction=0.5, load_factors=[1.2, 1.5], range=True)
    >>> bool((curve.least_damping <= curve.damping).all() and (curve.damping <= curve.most_damping).all())
    True
    """
    f, searched = (
        np.array(friction_coefficients(friction, checked_system(system).nodes)),
        flag("range", range),
    )
    system.reaction(checked_cycle(cycle).mean)
    cycle.corner_reactions(system)  # says which load case is unknown
    system, load = with_compliance(system, cycle, f, natural_frequency)
    if searched and load.none:
        raise ModelError(
            f"range: True, and there is no damping to have one: {load.none}; leave the range out"
        )
    try:
        gross: GrossSlip | SolverError = gross_slip(system, cycle, f)
    except SolverError as error:  # the curve does without it
        gross = error
    factors = _checked_factors(load_factors, gross)
    limits = (
        (shakedown_limit(system, cycle, f).load_factor, guaranteed_limit(system, cycle, f))
        if searched
        else None
    )
    return Asked(system, cycle, f, load, gross, limits, steps).followed(factors, progress)


@dataclass(frozen=True)
class _Seen:
    """What is seen at one load factor: columns of the curve, those of each contact, and why there is no steady state."""

    row: dict[str, Any]
    by_contact: pd.DataFrame = field(default_factory=pd.DataFrame)
    steady: SteadyState | None = None
    error: NoContinuation | SolverError | None = None


@dataclass(frozen=True)
class _Load:
    """A load with its amplitudes (cases,), its compliance on the glued bodies, and its frequency if it is a mode; or why it has no displacement."""

    direction: Array = field(default_factory=lambda: np.zeros(0))
    compliance: float = np.nan
    natural_frequency: float = np.nan
    none: str = ""

    def measured(self, steady: SteadyState) -> dict[str, float]:
        """Columns of the curve that follow from the displacement of the load over a steady cycle."""
        half, factor = self._half_range(steady), steady.load_factor
        stiffness = factor / half
        frequency = (
            np.sqrt(stiffness) / (2 * np.pi) if np.isfinite(self.natural_frequency) else np.nan
        )
        damping = (
            steady.dissipation / half / factor / (2 * np.pi)
        )  # the product of two tiny ones would be 0
        return {
            "displacement": half,
            "stiffness": stiffness,
            "frequency": frequency,
            "damping": damping,
        }

    def _half_range(self, steady: SteadyState) -> float:
        if self.none or steady.outcome is Outcome.RATCHETING:
            return np.nan
        if steady.outcome is Outcome.SHAKEDOWN and steady.friction.all() and not steady.open.any():
            return self.compliance * steady.load_factor
        path = steady.states()
        return float(
            np.ptp(path.system.displacements(path.amplitudes, path.slip, path.gap) @ self.direction)
            / 2
        )


@dataclass(frozen=True)
class Asked:
    """What a curve is asked of, with its sliding-off load and, if there is a range, its limits."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    load: _Load
    gross: GrossSlip | SolverError
    limits: tuple[float, GuaranteedLimit] | None
    steps: int | None

    def followed(self, factors: Array, progress: bool) -> BackboneCurve:
        """The curve at some load factors."""
        seen = list[_Seen]()

        def kept(_: object) -> tuple[str, BackboneCurve, str] | None:
            return (
                (
                    "curve",
                    self.curve(seen),
                    f"{len(seen)} of {len(factors)} load factors are in the attribute `curve`",
                )
                if seen
                else None
            )

        with bar_of(
            progress, "backbone curve", "load factor", total=len(factors), keeps=kept
        ) as bar:
            for factor in factors:
                seen.append(self.follow(float(factor)))
                bar.update()
        if all(one.error for one in seen):
            raise seen[0].error  # type: ignore[misc]
        return self.curve(seen)

    def follow(self, factor: float) -> _Seen:
        """What the joint does at one load factor."""
        asked = self.system, self.cycle, self.friction, factor
        try:
            steady = steady_state(*asked, steps=self.steps)
            contacts = steady.by_contact()[["contact", "slipping", "work", "slip_range"]]
            measured = [self.load.measured(steady)]
        except (NoContinuation, SolverError) as error:
            return _Seen(
                {
                    "load_factor": factor,
                    "outcome": _SLIDES_OFF if self._slides_off(factor) else _FAILED,
                },
                error=error,
            )
        row = {
            "load_factor": factor,
            "outcome": steady.outcome.name,
            "work": steady.dissipation,
            "slipping": steady.slipping_share,
        }
        row |= {
            "slip_range": contacts["slip_range"].max(),
            "residual": steady.residual,
            **measured[0],
        }
        if self.limits is not None:
            if not (self.limits[1].proven and factor <= self.limits[1].load_factor):
                found = dissipation_range(*asked, steps=self.steps)
                row["residual"] = max(steady.residual, found.residual)
                measured += [self.load.measured(state) for state in found.steady_states]
            ends = pd.DataFrame(measured).agg(["min", "max"])
            row |= {
                f"{end}_{name}": ends[name][of]
                for name in ("damping", "frequency")
                for end, of in (("least", "min"), ("most", "max"))
            }
        return _Seen(row, contacts.assign(load_factor=factor), steady)

    def _slides_off(self, factor: float) -> bool:
        """Whether statics says so, also of the mean load alone, for which the numbers are NaN."""
        return (
            isinstance(self.gross, GrossSlip)
            and not self.gross.least <= factor <= self.gross.load_factor
        )

    def curve(self, seen: Sequence[_Seen]) -> BackboneCurve:
        """The curve of what is seen at some load factors."""
        table = pd.DataFrame([one.row for one in seen]).reindex(
            columns=["load_factor", "outcome", "residual", *SEEN, *RANGES]
        )
        logs, factors = np.log(table["work"].where(table["work"] > 0)), table["load_factor"]
        contacts = pd.concat([one.by_contact for one in seen], ignore_index=True)
        return BackboneCurve(
            **{name: frozen(table[name]) for name in ("load_factor", *SEEN, *RANGES)},
            outcome=tuple(table["outcome"]),
            steady_states=tuple(one.steady for one in seen),
            exponent=frozen(np.gradient(logs, np.log(factors)) if len(seen) > 1 else [np.nan]),
            by_contact=contacts.reindex(
                columns=["load_factor", "contact", "slipping", "work", "slip_range"]
            ),
            gross_slip=self.gross.load_factor if isinstance(self.gross, GrossSlip) else np.nan,
            guaranteed_limit=np.nan if self.limits is None else self.limits[1].load_factor,
            shakedown_limit=np.nan if self.limits is None else self.limits[0],
            natural_frequency=self.load.natural_frequency,
            note="; ".join(self._notes(seen)),
            system=self.system,
            cycle=self.cycle,
            friction=self.friction,
            steps=self.steps,
            residual=float(table["residual"].max()),
            self_stress=isinstance(self.gross, GrossSlip) and self.gross.self_stress is not None,
        )

    def _notes(self, seen: Sequence[_Seen]) -> list[str]:
        """What is NaN, and what shares are of, in words."""
        notes = []
        if self.load.none:
            notes.append(f"no displacement, stiffness, damping and frequency: {self.load.none}")
        elif np.isnan(self.load.natural_frequency):
            notes.append("no frequency: without a natural_frequency the load is no mode")
        if self.system.width is None:
            notes.append("shares are of the nodes: the system has no width")
        if isinstance(self.gross, SolverError):
            notes.append(f"no sliding-off load: {self.gross}")
        elif beyond := [
            f"{one.row['load_factor']:g}" for one in seen if one.row["outcome"] == _SLIDES_OFF
        ]:
            notes.append(f"load factors {', '.join(beyond)}: {self.gross.reason}")
        if isinstance(self.gross, GrossSlip) and self.gross.self_stress is not None:
            notes.append(
                "statics cannot know how far the fit presses: the sliding-off load is that of transients from no slip"
            )
        for one in seen:
            at = f"load factor {one.row['load_factor']:g}"
            if one.row["outcome"] == _FAILED:
                notes.append(f"{at}: {one.error}")
            elif one.row["outcome"] == Outcome.RATCHETING.name and not self.load.none:
                notes.append(f"{at}: the contact ratchets, so its displacement has no range")
        return notes


def _checked_factors(load_factors: ArrayLike | None, gross: GrossSlip | SolverError) -> Array:
    """The load factors of a curve, by default below the load that slides the bodies off."""
    if load_factors is None:
        if isinstance(gross, SolverError):
            raise gross
        if not 0 < gross.load_factor < np.inf:
            raise ModelError(
                f"load_factors: None, and the load that slides the bodies off is {gross.load_factor:g}; give load factors"
            )
        return gross.load_factor * np.geomspace(_FROM, _TO, _COUNT)
    return rising_factors(load_factors)


def rising_factors(load_factors: ArrayLike) -> Array:
    """Check load factors that rise from above 0."""
    factors = np.array(finite_numbers("load_factors", load_factors, least=0.0))
    if not len(factors) or not (np.diff(factors, prepend=0.0) > 0).all():
        raise ModelError(
            f"load_factors: {factors.tolist()}; give load factors that rise, the first one above 0"
        )
    return factors


def with_compliance(
    system: ContactSystem, cycle: LoadCycle, friction: Array, natural_frequency: float | None
) -> tuple[ContactSystem, _Load]:
    """The contact with a compliance, its own or one of which the load has what its natural frequency says; and the load."""
    given = (
        None
        if natural_frequency is None
        else finite_number("natural_frequency", natural_frequency, above=0.0)
    )
    first, *others = (
        np.array([corner.get(case, 0.0) for case in system.bonded]) for corner in cycle.corners
    )
    if cycle.fixed or len(others) != 1 or not np.array_equal(first, -others[0]) or not first.any():
        remedy = "give two opposed corners, [{'mode': 1.0}, {'mode': -1.0}], around a mean load, and no fixed part"
        if given is not None:
            raise ModelError(f"cycle: {cycle}; a mode has a natural_frequency, so {remedy}")
        return system, _Load(none=f"the corners are not two opposed ones; {remedy}")
    if system.compliance is None:
        if given is None:
            return system, _Load(
                none="the system has no compliance, which `condense` finds; of a mode give the natural_frequency"
            )
        compliance = (2 * np.pi * given) ** -2
        return replace(
            system, compliance=compliance * np.outer(first, first) / (first @ first) ** 2
        ), _Load(first, compliance, given)
    compliance = float(first @ system.compliance @ first)
    reactions = joined(*system.reaction(cycle.corners[0]))
    own = (
        np.abs(first) @ np.abs(system.compliance) @ np.abs(first)
        + reactions @ reactions / system.stiffness_scale
    )
    if not compliance > ROUNDING * own:  # other load cases may have any size, so they do not count
        if given is not None:
            raise ModelError(
                f"corners: the load does no work on the glued bodies (compliance {compliance:g}); give a load of forces"
            )
        return system, _Load(
            none=f"the load does no work on the glued bodies (compliance {compliance:g}); give a load of forces"
        )
    if given is None:
        return system, _Load(first, compliance)
    softness = [compliance, compliance + _of_open_nodes(system, cycle, friction)]
    own = min(
        (1 / (2 * np.pi * np.sqrt(each)) for each in softness),
        key=lambda each: abs(each / given - 1),
    )
    if abs(own / given - 1) > _SAME_MODE:
        raise ModelError(
            f"natural_frequency: {given:g}, and the compliance of the load says {own:g}; give the load of a mass-normalised mode (`modal_load`), or "
            "leave the natural frequency out"
        )
    return system, _Load(first, compliance, own)


def _of_open_nodes(system: ContactSystem, cycle: LoadCycle, friction: Array) -> float:
    """What the nodes that the mean load leaves open add to the compliance of the load of a corner: they follow it without force."""
    out = np.tile(open_at_rest(system, cycle, friction), system.tangents + 1)
    r = joined(*system.reaction(cycle.corners[0]))[out]
    return float(r @ np.linalg.lstsq(system.S[np.ix_(out, out)], r, rcond=CONDENSATION)[0])
