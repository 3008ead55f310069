"""The questions of a report, page by page, and the reasons why questions have no answer."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import pandas as pd

from ..base import Array, Bar, Booleans, Outcome, number_of
from ..base.archive import load
from ..base.files import written_by
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import (
    GrossSlip,
    RequiredFriction,
    ShakedownLimit,
    gross_slip,
    guaranteed_limit,
    required_friction,
    shakedown_limit,
)
from ..study.case import sketch
from ..study.protocols import (
    FrictionAfterProtocol,
    LimitAfterProtocol,
    friction_after_protocol,
    limit_after_protocol,
)
from ..study.store import SAME
from ..transients import SteadyState
from .backbone import BackboneCurve, curve_at
from .curve_question import CurveQuestion, load_of_curve
from .report_tables import ReportParts, areas_move, mean_load_opens, units_of
from .safety import SteadyStates, face_table, safety_table, verdict_table
from .scatter import Scatter
from .thresholds import BELOW_GROSS_SLIP, FACE_SLIP, GROSS_SLIP, SLIP_RANGE, SLIPPING_SHARE

Parts = TypeVar("Parts", bound=ReportParts)

LOAD_FACTORS = (0.25, 0.5, 1.0, 2.0), (0.5, 1.0, 2.0)
"""Default load factors of the curve in the plane, and in space, where each takes long.

All are scaled down if the last one exceeds 95 % of the gross-slip load.
"""

_AT_LOAD = "steady state at load factor 1"
_SAFETY = "safety factors and verdicts"
# Name of a part -> attribute and page of the report, the most important part first.
_PARTS = {
    _AT_LOAD: ("steady", 1),
    "gross-slip load": ("gross_slip", 1),
    "mean load": ("mean_state", 1),
    "faces": ("contacts", 1),
    "curve": ("curve", 2),
    _SAFETY: ("verdicts", 2),
    "shakedown limit": ("limit", 3),
    "guaranteed limit": ("guaranteed", 3),
    "required friction": ("required", 3),
    "limit as assembled": ("assembled", 3),
    "friction as assembled": ("required_assembled", 3),
    "probability": ("probability", 3),
}
# Thresholds whose safety factors are found by a search.
_SEARCHED = (SLIP_RANGE, SLIPPING_SHARE)
_SOME_START = "probability for some start"
_AS_ASSEMBLED = "probability as assembled"
# Width of the last interval of a bisection, relative to the largest value tried, for the limit and
# the friction as assembled. With the values tried first, this takes at most eight transients.
_TOLERANCE = 1 / 64
_OF_THE_MESH = (
    "omitted, because the mean load leaves nodes open and the answer changes with the mesh: pass "
    "mesh_limits=True"
)
_LONG_SEARCH = (
    "omitted, because with open nodes in space its search takes minutes: call `fo.{}` yourself"
)
_LONG_SAMPLE = (
    "omitted, because in space 200 steady states take minutes: call "
    "`limit.probability(..., assembled=True)` yourself"
)
_OTHER_PAGE = "on page {page}, which was not requested"


class Pages(Generic[Parts]):
    """The known parts of a report, attribute -> result, and the reasons of the missing parts.

    The bar counts the pages and shows the current part. An interrupt keeps the known parts.
    """

    def __init__(
        self,
        system: ContactSystem,
        scatter: Scatter,
        limits: Mapping[str, float],
        steps: int | None,
        pages: int,
        factors: Array | None,
        bar: Bar,
        made: type[Parts],
    ) -> None:
        self.system = system
        self.scatter = scatter
        self.cycle: LoadCycle = scatter.cycle
        self.friction: Array = scatter.friction
        self.limits = limits
        self.steps = steps
        self.pages = pages
        self.factors = factors
        self.states = SteadyStates(system, scatter, steps)
        corners = [np.r_[sketch(system, at.cycle), at.friction] for at in self.states.all_corners()]
        self.identity = np.concatenate([[steps or 0], *corners])
        self.origin = _origin(self.identity)
        self._stored: ReportParts | None = None
        self.known = dict[str, Any]()
        self.missing = dict[str, str]()
        self._bar = bar
        self._made = made
        self._searches = pages > 1 and not self.limits.keys().isdisjoint(_SEARCHED)
        self._plan(None)

    def _plan(self, slides: GrossSlip | None) -> None:
        """Plan the steady states of the curve and of the verdicts, with the gross-slip load.

        None: this load is not known. Searches for safety factors need further steady states, whose
        number is not known yet.
        """
        nominal, *corners = self.states.all_corners()
        self._planned = {(nominal.name, 1.0)}
        if self.pages > 1:
            factors = self._factors_of_curve(slides)
            self._planned = {(nominal.name, factor) for factor in factors.tolist()}
            if not self.limits.keys() <= {GROSS_SLIP, FACE_SLIP}:
                self._planned |= {(corner.name, 1.0) for corner in corners}

    def take(self, file: Path) -> None:
        """Take the steady states and the limits of a stored report on the same input."""
        stored = load(file)
        same = (
            isinstance(stored, self._made)
            and stored.origin.split(",")[0] == self.origin.split(",")[0]
            and stored.scatter == self.scatter.in_words()
            and stored.identity.shape == self.identity.shape
            and np.allclose(stored.identity, self.identity, rtol=0.0, atol=SAME)
        )
        if not same:
            raise ModelError(
                f"store: {str(file)!r} has no report on this input by this version; give another "
                "file"
            )
        self._stored = stored
        for key, state in stored.states.items():
            self.states.known[key] = NoContinuation(state) if isinstance(state, str) else state

    def ask(self, part: str, question: Callable[[], Any]) -> Any:
        """Keep and return an answer; if there is none, keep the reason and return None."""
        self._keep(part)
        # Only parts of page 3 are taken from the store. Parts of other pages depend on thresholds
        # and load factors, or follow from the stored states.
        attribute, page = _PARTS[part]
        stored = getattr(self._stored, attribute, None) if page == 3 else None
        is_known = not stored.empty if isinstance(stored, pd.DataFrame) else stored is not None
        try:
            answer = stored if is_known else question()
            self.known[attribute] = answer
        except (NoContinuation, SolverError) as error:
            self.missing[part] = without_lists(str(error))
            return None
        self.missing.pop(part, None)
        return answer

    def _keep(self, doing: str) -> None:
        """Set the parts that an interrupt keeps from now on."""
        left = ", ".join(self._left())
        note = f"the parts known so far are in the attribute `report`, without {left}"
        self._bar.keep(
            "report",
            self._interrupted,
            note,
            lambda: f"{doing}, {self._number_known()}",
        )

    def _number_known(self) -> str:
        """The number of steady states that are known, and the number that is needed, in words."""
        known = self.states.known.keys()
        needed = number_of(len(known | self._planned), "steady state")
        return f"{len(known)} of {needed}{' or more' if self._searches else ''}"

    def ask_at_load(self) -> None:
        """Page 1: the contact, gross slip by statics, and the steady state at load factor 1."""
        system, cycle, friction = self.system, self.cycle, self.friction
        self.ask("mean load", lambda: self.states.mean_state(self.scatter.nominal()))
        slides = self.ask(
            "gross-slip load", lambda: gross_slip(system, cycle, friction, seconds=0.0)
        )
        if slides is None or slides.rests_at(1.0):
            self.ask(_AT_LOAD, self._steady_at_load)
        else:
            self.missing[_AT_LOAD] = slides.reason
            self.states.known[self.scatter.nominal().name, 1.0] = NoContinuation(slides.reason)
        mean = self.known.get("mean_state")
        if mean is None:
            self.missing["faces"] = self.missing["mean load"]
        else:
            steady = self.known.get("steady")
            model = self.known.get("model")
            self.ask(
                "faces", lambda: face_table(system, cycle, friction, mean, steady, slides, model)
            )
        if not self.scatter.exists:
            fit_is_known = slides is None or slides.self_stress is None
            self._judge(slides if fit_is_known else None, (FACE_SLIP,))

    def _steady_at(self, factor: float) -> SteadyState:
        """The steady state of the nominal input at a load factor."""
        answer = self.states.at(self.scatter.nominal(), factor)
        if not isinstance(answer, SteadyState):
            raise answer
        return answer

    def _steady_at_load(self) -> SteadyState:
        steady = self._steady_at(1.0)
        steady.states()  # tables need the states: an error here is an error of the state
        return steady

    def ask_with_load(self) -> None:
        """Page 2: the load at which a fit slides off, the curve, and the safety factors."""
        slides: GrossSlip | None = self.known.get("gross_slip")
        if slides is not None and slides.self_stress is not None:
            slides = self.ask(
                "gross-slip load", lambda: gross_slip(self.system, self.cycle, self.friction)
            )
            if slides is not None and _AT_LOAD in self.missing and not slides.rests_at(1.0):
                self.missing[_AT_LOAD] = slides.reason
        self._plan(slides)
        self._ask_curve(slides)
        self._keep("safety factors")
        self._judge(slides, (FACE_SLIP, *_SEARCHED))
        self._searches = False

    def _judge(self, slides: GrossSlip | None, factors_against: Sequence[str]) -> None:
        """Find safety factors against gross slip and some thresholds, and all verdicts."""
        try:
            against = {name: self.limits[name] for name in factors_against if name in self.limits}
            safety = safety_table(self.states, slides, against)
        except SolverError as error:
            self.missing[_SAFETY] = without_lists(str(error))
            return
        self.known["safety"] = safety
        self.known["verdicts"] = verdict_table(
            self.states, safety, self.limits, units_of(self.report())
        )

    def _factors_of_curve(self, slides: GrossSlip | None) -> Array:
        """The load factors of the curve, including 1 unless the bodies slide off below it."""
        upper = np.inf if slides is None else slides.load_factor
        factors = self.factors
        if factors is None:
            factors = np.array(LOAD_FACTORS[self.system.tangents - 1])
            if upper > 0:
                factors *= min(1.0, BELOW_GROSS_SLIP * upper / factors[-1])
        if slides is None or slides.rests_at(1.0):
            factors = np.union1d(factors, [1.0])
        return factors

    def _ask_curve(self, slides: GrossSlip | None) -> None:
        """The backbone curve."""
        factors = self._factors_of_curve(slides)
        load = load_of_curve(self.system, self.cycle, self.friction, None)
        gross = slides or SolverError(self.missing["gross-slip load"])
        question = CurveQuestion(
            self.system, self.cycle, self.friction, load, gross, None, self.steps, self._steady_at
        )
        self.ask("curve", lambda: curve_at(question, factors, True))

    def ask_limits(self, mesh_limits: bool) -> None:
        """Page 3: both limits and the required friction.

        Limits are omitted if they depend on the mesh, unless `mesh_limits` is set. Long searches
        for open nodes in space are omitted, too.
        """
        system, cycle, f = self.system, self.cycle, self.friction
        opens = mean_load_opens(self.report())
        if areas_move(system, cycle, f):
            # The limits hold for all openings and closings, without a search.
            opens = False
        if opens and not mesh_limits:
            for part in self._left():
                self.missing[part] = _OF_THE_MESH
            return
        reason = ""
        if opens and system.tangents == 2:
            mean = self.known["mean_state"]
            self.ask("shakedown limit", lambda: self._limit_with_open(mean.open))
            reason = _LONG_SEARCH
        else:
            self.ask("shakedown limit", lambda: shakedown_limit(system, cycle, f))
            if system.capped:
                reason = "not supported for a surface with a shear strength"
        if reason:
            for part in ("guaranteed limit", "required friction"):
                self.missing[part] = reason.format(part.replace(" ", "_"))
        else:
            self.ask("guaranteed limit", lambda: guaranteed_limit(system, cycle, f))
            self.ask("required friction", lambda: required_friction(system, cycle, 1.0))
        self.ask("limit as assembled", self._limit_as_assembled)
        self.ask("friction as assembled", self._friction_as_assembled)
        if self.scatter.laws:
            self._ask_probability()

    def _limit_as_assembled(self) -> LimitAfterProtocol:
        """The load factor up to which the contact comes to rest from no slip, by bisection."""
        limit: ShakedownLimit | None = self.known.get("limit")
        if limit is None or not 0 < limit.load_factor < np.inf:
            raise NoContinuation("no load factor is known above which the contact slips for ever")
        scan = [1.0]
        if "guaranteed" in self.known:
            # The guaranteed limit is tried, too, because it does not cover cycles in which nodes
            # open and close.
            share = self.known["guaranteed"].load_factor / limit.load_factor
            scan = [share, 1.0] if 0 < share < 1 else scan
        return limit_after_protocol(limit, scan=scan, **self._from_no_slip())

    def _friction_as_assembled(self) -> FrictionAfterProtocol:
        """The friction that the contact needs to come to rest from no slip, by bisection."""
        required: RequiredFriction | None = self.known.get("required")
        if required is None or required.required == np.inf:
            raise NoContinuation("no friction is known with which a state of rest exists")
        steady: SteadyState | None = self.known.get("steady")
        friction = float(self.scatter.frictions[-1].max())
        enough = steady is not None and steady.outcome is Outcome.SHAKEDOWN
        return friction_after_protocol(
            required,
            up_to=friction if enough and friction > required.required else None,
            scan=2,
            **self._from_no_slip(),
        )

    def _ask_probability(self) -> None:
        """The probabilities; in space a sample of steady states takes too long."""
        known = self.ask("probability", self._probability)
        if known is not None and self._needs_sample and self.system.tangents == 2:
            self.missing[_AS_ASSEMBLED] = _LONG_SAMPLE

    @property
    def _needs_sample(self) -> bool:
        """Whether more than one coefficient of friction is random. One alone is solved exactly."""
        laws = self.scatter.laws
        return len(laws) > 1 or isinstance(laws.get("friction", {}), Mapping)

    def _probability(self) -> pd.DataFrame:
        """A row for each known probability, with its source."""
        laws = self.scatter.laws
        limit: ShakedownLimit | None = self.known.get("limit")
        required: RequiredFriction | None = self.known.get("required")
        assembled: FrictionAfterProtocol | None = self.known.get("required_assembled")
        rows = list[tuple[str, float, float, str]]()
        if self._needs_sample:
            if limit is not None:
                some = limit.probability(**laws, assembled=self.system.tangents == 1)
                for name, found in ((_SOME_START, some), (_AS_ASSEMBLED, some.assembled)):
                    if found is not None:
                        known = found.probability, found.standard_error, found.method
                        rows.append((name, *known))
        else:
            law = laws["friction"]
            if required is not None:
                source = "exact: the probability of more than the required friction"
                rows.append((_SOME_START, required.probability(law), 0.0, source))
            if assembled is not None and assembled.required < np.inf:
                source = (
                    "from no slip: the probability of more than the friction as assembled, if the "
                    "contact stops with all frictions between those tried"
                )
                value = float(law.sf(assembled.required))
                rows.append((_AS_ASSEMBLED, value, 0.0, source))
        if not rows:
            raise NoContinuation("no limit is known, of which it is the probability")
        return pd.DataFrame(rows, columns=["number", "value", "error", "meaning"])

    def _from_no_slip(self) -> dict[str, Any]:
        """Options of a search by transients from no slip."""
        start = np.zeros(self.system.slip_shape)
        return {"start": start, "tolerance": _TOLERANCE, "steps": self.steps}

    def _limit_with_open(self, is_open: Booleans) -> ShakedownLimit:
        """The shakedown limit with these nodes open."""
        try:
            return shakedown_limit(self.system, self.cycle, self.friction, open_nodes=is_open)
        except ModelError as error:
            # The closed nodes do not hold the open nodes.
            raise NoContinuation(str(error)) from error

    def leave_out_the_rest(self) -> None:
        """Give the parts of later pages the reason that their page was not requested."""
        for part in self._left():
            if (page := _PARTS[part][1]) > self.pages:
                self.missing[part] = _OTHER_PAGE.format(page=page)

    def report(self) -> Parts:
        """The known parts; the curve gets the limits for its picture."""
        known = dict(self.known)
        curve: BackboneCurve | None = known.get("curve")
        if curve is not None:
            if "limit" in known:
                curve = replace(curve, shakedown_limit=known["limit"].load_factor)
            if "guaranteed" in known:
                curve = replace(curve, guaranteed_limit=known["guaranteed"].load_factor)
            known["curve"] = curve
        names = [*_PARTS, _AS_ASSEMBLED]
        missing = {part: self.missing[part] for part in names if part in self.missing}
        return self._made(
            system=self.system,
            cycle=self.cycle,
            friction=self.friction,
            missing=missing,
            scatter=self.scatter.in_words(),
            origin=self.origin,
            identity=self.identity,
            states={
                key: state if isinstance(state, SteadyState) else str(state)
                for key, state in self.states.known.items()
            },
            **known,
        )

    def _left(self) -> list[str]:
        """The parts that are neither known nor missing."""
        return [
            part
            for part, (attribute, _) in _PARTS.items()
            if attribute not in self.known and part not in self.missing
            if part != "probability" or self.scatter.laws
        ]

    def _interrupted(self) -> Parts:
        """The report of the known parts; all other parts are missing because of the interrupt."""
        missing = {**self.missing, **dict.fromkeys(self._left(), "interrupted")}
        return replace(self.report(), missing=missing)


def _origin(identity: Array) -> str:
    """The version, the day, and a checksum of the input, in a sentence."""
    checksum = sha256(identity.tobytes()).hexdigest()
    by = written_by()
    return f"frictopt {by['version']}, {by['date'][:10]}, checksum of the input {checksum[:12]}."


def without_lists(reason: str) -> str:
    """A reason in which the number of nodes replaces each long list of node numbers."""

    def counted(match: re.Match[str]) -> str:
        numbers = match[2].split(",")
        # Longest list of node numbers in a reason.
        longest = 5
        if len(numbers) <= longest:
            return match[0]
        return f"{len(numbers)} nodes" if match[1] else "[...]"

    return re.sub(r"(nodes )?\[([-\d, ]+)\]", counted, reason)
