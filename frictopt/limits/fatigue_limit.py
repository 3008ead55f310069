"""The fatigue limit: how far states of rest stay below an allowable fatigue parameter."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
import scipy  # its parts are imported when they are used

from ..base import (
    ROUNDING,
    PerNode,
    SolveRecord,
    finite_number,
    flag,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import LoadCycle, StressMap, amplitudes_of
from ..errors import ModelError
from ..transients.critical_plane import SEARCHED
from .answers import sentences
from .answers.answered import Answered
from .fatigue_band import Parameter, posed
from .program.question import Question
from .search.stress_levels import Level, StressCrossings, Stresses, tensors_at_rest
from .shakedown import limit_of_question


@dataclass(frozen=True, eq=False, repr=False)
class FatigueLimit(Answered):
    """The largest load factor up to which states of rest have at most an allowable parameter.

    Attributes
    ----------
    parameter, weight, allowable, every
        As given.
    load_factor
        Up to this load factor, every (or some) state of rest has at most the allowable value at all
        points. It is 0 if the parameter exceeds the value under the mean load alone, and the
        shakedown limit if the value is not reached.
    reached
        Whether the allowable value is reached below the shakedown limit.
    slip
        Slip (N,) or (N, 2) of a state of rest at this load factor, length: the first state that has
        the allowable value (`every`), or the last state that does not exceed it. If the value is
        not reached, the slip of the shakedown limit.
    bound
        Load factor that multipliers prove. With `every`, no state of rest up to this load factor
        exceeds the value on the planes tried. Otherwise, all states of rest above it exceed the
        value. With every=False, programs do not resolve an allowable value below about 1e-8 of the
        largest value of the band; the bound is then far above the load factor.
    proven
        Whether `bound` holds for all planes: always if `every` is False, otherwise for Crossland,
        Dang Van and Matake. For the other parameters only the planes of a search count.
    record
        Its `residual` is the larger of two errors: the violation of the contact law by the slip,
        and the distance of the bound from the load factor of the program, relative to this load
        factor.

    Examples
    --------
    >>> import frictopt as fo
    >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    >>> stresses = model.stress_map(depth=0.3, side=2)
    >>> limit = fo.fatigue_limit(stresses, cycle, 0.7, 0.8, "Crossland")
    >>> band = fo.fatigue_band(stresses, cycle, 0.7, limit.load_factor, "Crossland")
    >>> limit.reached, round(band.most, 6)
    (True, 0.8)
    """

    _shown_names = ("load_factor", "bound", "reached", "proven", "residual", "reason")
    parameter: str
    weight: float
    allowable: float
    every: bool
    reached: bool
    bound: float
    proven: bool
    stress_map: StressMap = field(repr=False)

    @property
    def reason(self) -> str:
        """The limit in words, and what it does not cover."""
        which = sentences.ALLOWED if self.load_factor else sentences.NOT_ALLOWED
        text = which.format(
            load_factor=self.load_factor,
            some="every" if self.every == bool(self.load_factor) else "some",
            node_states=self._question.node_states,
            parameter=self.parameter,
            allowable=self.allowable,
        )
        if not self.reached:
            text += sentences.RESTS_END
        if self.every and self.stress_map.on_face:
            text += sentences.GROWS_WITH_MESH
        return text + sentences.OTHER_STARTS

    def check_kept(self) -> None:
        """Check that the slip of a limit from a file has the allowable value; ValueError if not."""
        super().check_kept()
        tensors = tensors_at_rest(self._question, self.stress_map, self.load_factor)
        stresses = Stresses(self._question, self.stress_map, tensors, self.parameter, self.weight)
        value = float(stresses.values(self.slip).max())
        if self.reached and self.load_factor and not abs(value / self.allowable - 1) <= 1e-6:
            raise ValueError(f"its slip has the value {value:g}, not {self.allowable:g}")


@warns_of_odd_values
def fatigue_limit(
    stress_map: StressMap,
    cycle: LoadCycle,
    friction: PerNode,
    allowable: float,
    parameter: Parameter = "SWT",
    *,
    every: bool = True,
    weight: float = 0.3,
    slip_bound: PerNode | None = None,
    planes: int = 36,
    progress: bool = True,
) -> FatigueLimit:
    """The largest load factor up to which states of rest have at most an allowable parameter.

    Theory, eq. (38). The nodes that are open at the shakedown limit stay open.

    Parameters
    ----------
    stress_map, cycle, friction, parameter, weight, slip_bound, planes
        See `fatigue_band`. Fixed parts of the cycle must not differ between the corners.
    allowable
        The allowable value of the parameter at all points, > 0.
    every
        True: every state of rest has at most this value. The limit is the first load factor at
        which some state of rest has this value; near the shakedown limit, all states of rest may be
        below the value again. False: some state of rest has at most this value. The mean load must
        then be a mean of the loads at the corners.
    progress
        Whether to show a progress bar after two seconds.

    Returns
    -------
    FatigueLimit
        The load factor, and a state of rest that has the allowable value there.

    Raises
    ------
    ModelError
        Bad input; no finite shakedown limit; normal loads that open and close nodes in each cycle;
        with `every`, friction that wedges without a slip bound.
    SolverError
        No solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    >>> stresses = model.stress_map(depth=0.3, side=2)
    >>> some = fo.fatigue_limit(stresses, cycle, 0.7, 0.8, "Crossland", every=False)
    >>> some.reached, some.proven
    (True, True)
    """
    question, weight = posed(stress_map, cycle, friction, parameter, weight, planes, slip_bound)
    allowable = finite_number("allowable", allowable, above=0.0)
    if not flag("every", every):
        _check_mean(cycle)
    with progress_bar(progress, "fatigue limit"):
        limit = limit_of_question(question, None, False)
        at_rest = limit._question
        _check_rests(at_rest, limit.load_factor)
        crossings = StressCrossings(at_rest, stress_map, parameter, weight, planes, allowable)
        if every and crossings.levels(0.0).wedges:
            raise ModelError(
                "friction: it wedges, so that residual slips may press the contact without end; "
                "give a `slip_bound`, or reduce the friction"
            )
        found = crossings.first() if every else crossings.last(limit.load_factor)
    end = found or Level(limit.load_factor, limit.bound, limit.slip, limit.residual)
    return FatigueLimit(
        parameter=parameter,
        weight=weight,
        allowable=allowable,
        every=bool(every),
        load_factor=end.value,
        reached=found is not None,
        slip=end.slip,
        bound=end.bound,
        proven=not every or parameter not in SEARCHED,
        record=SolveRecord(residual=end.residual, seconds=perf_counter() - question.started),
        stress_map=stress_map,
        _question=at_rest,
    )


def _check_mean(cycle: LoadCycle) -> None:
    """ModelError if the mean load is no mean of the loads at the corners."""
    corners = amplitudes_of(cycle.corners)
    relative = corners / np.abs(corners).max(axis=0, initial=np.finfo(float).tiny)
    sums = np.vstack([relative.T, np.ones(len(corners))])
    _, off = scipy.optimize.nnls(sums, np.eye(len(sums))[-1])
    if off > ROUNDING:
        raise ModelError(
            "every: False, but the mean load is no mean of the loads at the corners, so that a "
            "higher load factor may have better states of rest; add the corner {} to the cycle, or "
            "compare `fatigue_band` at several load factors"
        )


def _check_rests(question: Question, limit: float) -> None:
    """ModelError if states of rest are not a convex set up to a finite load factor."""
    reasons = {
        f"its shakedown limit is {limit:g}, not finite": not np.isfinite(limit),
        "its normal loads open and close nodes in each cycle": question.moves,
        "its fixed parts differ between the corners": question.fixed,
    }
    for reason, holds in reasons.items():
        if holds:
            raise ModelError(
                f"cycle: {reason}, so that no program has its fatigue limit; compare "
                "`fatigue_band` at several load factors"
            )
