"""The least friction with which a load factor is safe."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..base import (
    RESIDUAL,
    Bar,
    Booleans,
    SolveRecord,
    bar_of,
    finite_number,
    flag,
    frozen,
    place,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import SolverError
from .answered import Answered, Mechanism
from .models import most_pressed, unknowns
from .programs import listed_rows
from .question import pose, with_open
from .safe_slip import SafeSlip, SafeSlipModel

_PROVEN_FRICTION = (
    100 * RESIDUAL
)  # share between the two friction coefficients of a proof that is tried first
_WIDEST_PROOF = 1e4 * RESIDUAL  # and the largest: a small node has a small part of the margin
_LEAST_FRICTION = 1e-6  # which linear programs can tell from 0
_MORE_FRICTION = tuple(
    4.0**k for k in range(1, 8)
)  # tried where 1 is not enough, up to what linear programs can tell from inf
_NO_LEAST_PRESSURE = (
    RESIDUAL  # pressure, over the force scale, that counts as none: it has the error of an answer
)


@dataclass(frozen=True, eq=False, repr=False)
class RequiredFriction(Answered):
    """The least coefficient of friction with which a load factor is safe, with its proof from both sides.

    Attributes
    ----------
    required
        Coefficient of friction with which `slip` is safe; 0 if none is needed, inf if none is
        enough.
    bound
        Coefficient of friction with which no slip is safe, all nodes closed or those open that
        `required` has, less than 1e-5 below `required`, relatively; nan where none is needed. Where
        nodes open and close in each cycle (`events`), others may need less.
    slip
        (N,) or (N, 2) a residual slip that is safe with `required`, length; NaN where none is
        enough. See `largest_slip`.
    mechanism
        Why `bound` is not enough (Farkas's lemma), or why no friction is: motions for which the
        loads do more work than friction can take up, while no residual slip resists them. Columns
        as in `ShakedownLimit.mechanism`, direction 0: it opens.
    load_factor, reason
        The load factor that was asked for, and why it is so, in words.
    record
        How it was found. Its `residual`, at most 1e-9, is the larger one of the two proofs.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> fo.required_friction(node, fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 3.0}]), 1.0).mechanism["direction"].tolist()
    [1, -1]
    """

    _said = ("required", "bound", "largest_slip", "residual", "reason")
    required: float
    bound: float
    mechanism: pd.DataFrame
    reason: str


@warns_of_odd_values
def required_friction(
    system: ContactSystem,
    cycle: LoadCycle,
    load_factor: float,
    *,
    events: bool = False,
    slip_bound: Any = None,
    progress: bool = True,
) -> RequiredFriction:
    """Least coefficient of friction, the same at all nodes, with which some residual slip is safe at a load factor.

    A slip that is safe with friction f, also with f = 0, presses every node at every corner, and
    stays safe with more friction, as the bounds f p only grow. So there is one coefficient above
    which a slip is safe and below which none is: the root of the margin of `safe_slip`. It is
    finite if some slip presses every node at every corner; else no friction is enough. More load
    may need less friction, where the mean load alone is not safe and the corners press: the load
    factors that are safe with one friction are an interval, see `ShakedownLimit.least`. Where nodes
    stay open, a pattern that the search of `shakedown_limit` finds is followed to its least
    friction, then one that the search finds just below, if any. A slip is proven safe with its
    nodes open at the answer, and none just below, nor with those that the search finds there.
    Theory, eq. (16).

    Ctrl-C stays a KeyboardInterrupt with an attribute `table`, the frictions tried by then.

    Parameters
    ----------
    system, cycle, slip_bound
        See `ShakedownModel`. Faces that lock themselves may need far more slip than assembly can
        leave.
    load_factor
        Load factor, >= 0.
    events
        See `shakedown_limit`; each friction that is tried then has a search of its own.
    progress
        Whether to show after two seconds how far it is, see `shakedown_limit`.

    Raises
    ------
    ModelError, SolverError
        Bad input; the two sides of the proof do not come within 1e-5 of each other, or whether any
        friction is enough is within rounding.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> cycle = fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 3.0}])  # a slip of 1 leaves a shear of 2 at both corners
    >>> required = fo.required_friction(node, cycle, 1.0)
    >>> round(required.required, 5), required.bound < required.required
    (1.0, True)
    """
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    asked = _Asked(
        SafeSlipModel(system, cycle, slip_bound=slip_bound), load_factor, flag("events", events)
    )
    with bar_of(progress, "required friction", "program", best=asked.told, keeps=asked.kept) as bar:
        return _required(asked, slip_bound, bar)


def _required(asked: _Asked, slip_bound: Any, bar: Bar) -> RequiredFriction:
    """The answer, with each friction asked for once; `bar` counts them."""
    started, most, question, load_factor = (
        perf_counter(),
        1.0,
        asked.model._asked,
        asked.load_factor,
    )
    system, cycle, asked.tell = question.system, question.cycle, bar.update
    within, smaller = ("", "") if slip_bound is None else (" within the slip bound", "smaller ")
    held, sheared = question.r0[:, :-1], load_factor * question.r1[:, :-1]
    alike = np.ptp(held + sheared, axis=0).max() <= RESIDUAL * max(
        np.abs(held).max(), np.abs(sheared).max()
    )
    none_needed = alike and asked.proven(
        0.0, True
    )  # else no slip takes the shear off at all corners
    if not (none_needed or asked.proven(most, True)):
        most = next(
            (friction for friction in _MORE_FRICTION if asked.proven(friction, True)), np.inf
        )
    if most == np.inf:
        pressed, record = best_pressed(system, cycle, load_factor, slip_bound)
        if pressed.impossible:
            mechanism, record = (
                pressed.motion.table(system, cycle.corner_names),
                replace(record, seconds=perf_counter() - started),
            )
            nodes, unsafe, question = (
                mechanism["node"].unique(),
                np.full(system.slip_shape, np.nan),
                replace(question, friction=question.friction * np.inf),
            )
            named = (
                [f"{x:.4g}" for x in system.x[nodes]]
                if system.tangents == 1
                else [place(point) for point in system.points[nodes]]
            )
            where = f"{'x =' if system.tangents == 1 else 'at'} {', '.join(named[:4])}{', ...' * (len(nodes) > 4)}"
            why = f"whatever slips{within}, the loads open one of {len(nodes)} nodes ({where}) at some corner; press them"
            why = f"no friction is enough to keep all nodes closed: {why}"
            return RequiredFriction(
                load_factor, frozen(unsafe), record, question, np.inf, np.inf, mechanism, why
            )
        raise SolverError(
            f"required friction: none up to {_MORE_FRICTION[-1]:g} is enough, although no node need open: the best residual slip leaves a "
            f"pressure of {pressed.least:.1e} force scales at one node; press nodes of little pressure, or leave them out"
        )
    root, step = 0.0 if none_needed else asked.root(most), _PROVEN_FRICTION
    while (
        root >= _LEAST_FRICTION
        and asked.proven(root * (1 - step), True)
        and (asked.safe(root * (1 - step)).open != asked.opened).any()
    ):
        root = asked.root(root * (1 - step))  # with these nodes open still less may be enough
    if root < _LEAST_FRICTION:
        if not asked.proven(0.0, True):
            raise SolverError(
                f"required friction: {_LEAST_FRICTION:.0e} is enough and 0 is not; no shear load of that size matters, take it as 0"
            )
        enough = too_little = asked.safe(0.0)
        mechanism, bound = enough._motion.table(system, cycle.corner_names)[:0], np.nan
        why = f"none is needed: a residual slip{within} takes all shear off every node at every corner"
    else:
        sides = (1, asked.opened), (-1, asked.opened), (-1, None)  # and no search finds others
        while not all(
            asked.proven(root * (1 + side * step), side > 0, opened) for side, opened in sides
        ):
            step *= 4
            if step > _WIDEST_PROOF:
                less, more = asked.between
                slip = next(
                    safe.largest_slip
                    for (f, _), safe in asked.found.items()
                    if f == more and safe.exists
                )
                raise SolverError(
                    f"required friction: no slip is safe with {less:g}, one of up to {slip:.3g} is with {more:g}, and "
                    f"rounding leaves it open what is enough between them; give a {smaller}slip_bound if that slip is more than assembly can leave, "
                    "or check for reactions of very different sizes"
                )
        (enough, too_little), bound = (
            (asked.safe(root * (1 + side * step), opened) for side, opened in sides[:2]),
            root * (1 - step),
        )
        mechanism = too_little._motion.table(system, cycle.corner_names)
        opened = int(too_little.open.sum())
        closed = f", {opened} nodes open and the others closed" if opened else ", all nodes closed"
        why = f"no residual slip{within} is safe with less{closed}: see the mechanism"
        why += (
            "; with this friction nodes open and close in each cycle, with less the search finds none that rest so"
            * (not enough.events.empty)
        )
    attempts = enough.record.attempts + too_little.record.attempts * (too_little is not enough)
    record = replace(
        enough.record,
        attempts=attempts,
        residual=max(enough.residual, too_little.residual),
        seconds=perf_counter() - started,
    )
    required = root * (1 + step) if bound > 0 else 0.0
    return RequiredFriction(
        load_factor, enough.slip, record, enough._question, required, bound, mechanism, why
    )


class _Asked:
    """Safe slips of one load factor, by friction and open nodes; each is solved for once."""

    def __init__(self, model: SafeSlipModel, load_factor: float, events: bool) -> None:
        self.model, self.load_factor, self._events = model, load_factor, events
        self.opened, self.found = (
            np.zeros(0, dtype=bool),
            dict[tuple[float, bytes], SafeSlip](),
        )  # open nodes at the last root, and all that is found
        self.tell: Callable[[], object] = lambda: None

    def safe(self, friction: float, opened: Booleans | None = None) -> SafeSlip:
        """The slip that stays furthest inside the friction bounds, with given nodes open or the first ones of a search with which it is safe."""
        question, load_factor, opened = (
            self.model._posed(friction),
            self.load_factor,
            None if self._events else opened,
        )
        key = friction, b"" if opened is None else opened.tobytes()
        if key not in self.found:
            self.tell()
            if opened is None:
                self.found[key] = self.model.of_pattern(
                    question, load_factor, events=self._events, enough=load_factor
                )
            else:
                question = with_open(question, opened) or question
                self.found[key] = self.model._safe(question, load_factor)
        return self.found[key]

    @property
    def between(self) -> tuple[float, float]:
        """Between which frictions it is."""
        more = min((f for (f, _), safe in self.found.items() if safe.exists), default=np.inf)
        return max(
            (f for (f, _), safe in self.found.items() if not safe.exists and f < more), default=0.0
        ), more

    def told(self) -> str:
        """The same in words."""
        return "between {:.4g} and {:.4g} so far".format(*self.between) if self.found else ""

    def kept(self, _: object) -> tuple[str, object, str] | None:
        """What an interrupt keeps."""
        table = pd.DataFrame(
            [(f, safe.exists, safe.margin) for (f, _), safe in sorted(self.found.items())],
            columns=["friction", "safe", "margin"],
        )
        return (
            ("table", table, f"{self.told()}; the frictions tried are in the attribute `table`")
            if len(table)
            else None
        )

    def root(self, most: float) -> float:
        """The friction at which the margin vanishes with the open nodes of one that is enough; less than the least friction where it does not.

        By Newton's method, the reserve `f p - |q|` growing by the sum of p weighted by its
        multipliers; else, or if steps are not halved, bisection.
        """
        friction, least, before, safe = most, 0.0, np.inf, self.safe(most)
        self.opened = safe.open
        while friction >= _LEAST_FRICTION:
            least, most = (least, friction) if safe.margin >= 0 else (friction, most)
            step = -safe.margin / safe.friction_rate if safe.friction_rate > 0 else np.inf
            if (
                abs(step) <= RESIDUAL * friction or most - least <= _PROVEN_FRICTION * friction
            ):  # within the share that the proof leaves
                break
            if not (
                max(least, _LEAST_FRICTION) < friction + step < most and abs(step) < before / 2
            ):
                step = (least + most) / 2 - friction
            friction, before = friction + step, abs(step)
            try:
                safe = self.safe(friction, self.opened)
            # within rounding of the root, or of a critical friction above which slips without end
            # are safe: the proof decides
            except SolverError:
                break
        return friction

    def proven(self, friction: float, exists: bool, opened: Booleans | None = None) -> bool:
        """Whether it is proven that a safe slip exists, or that none does."""
        try:
            return self.safe(friction, opened).exists is exists
        except SolverError:
            return False


@dataclass(frozen=True)
class Pressing:
    """Least normal reaction under a slip, in mean normal forces of the mean load, at most 1; if negative, openings that prove it; and both errors."""

    least: float
    motion: Mechanism
    residual: float

    @property
    def impossible(self) -> bool:
        """Whether no slip presses every node at every corner."""
        return self.least < -_NO_LEAST_PRESSURE


def best_pressed(
    system: ContactSystem, cycle: LoadCycle, load_factor: float, slip_bound: Any
) -> tuple[Pressing, SolveRecord]:
    """The slip, within its bound, under which the least normal reaction over the nodes and corners is largest."""
    question, least = pose(system, cycle, 0.0, slip_bound=slip_bound), cp.Variable(name="least")
    x = unknowns(
        system.slip_shape,
        range(len(cycle.corners)),
        cp.Parameter(nonneg=True, name="load_factor", value=load_factor),
    )
    program = listed_rows(
        question, x, cp.Parameter(system.nodes, nonneg=True, name="f"), friction=lambda *_: []
    )
    program.compiled(most_pressed(x, least, question.force, program.corners, program.rows), 1.0)

    def judged() -> Pressing:
        slip, proof = program.slip, program.chain.proof
        reached = float(
            min(question.states(load_factor, slip)[1][:, -1].min() / question.force, 1.0)
        )
        gap = abs(proof.bound - reached) + proof.defect
        return Pressing(
            reached,
            program.motion,
            float(np.nan_to_num(max(gap, question.excess_over_slip_bound(slip)), nan=np.inf)),
        )

    return program.chain.solve(judged)
