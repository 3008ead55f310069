"""All answers about a joint under its loads in one call, as text, tables and pictures."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import ROUNDING, Array, Bar, Booleans, Kept, Plotted, progress_bar, warns_of_odd_values
from ..base.files import output
from ..base.results import WIDE
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    friction_coefficients,
    other_laws,
)
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import (
    GrossSlip,
    ShakedownLimit,
    gross_slip,
    guaranteed_limit,
    required_friction,
    shakedown_limit,
)
from ..transients.march import mean_state
from .advice import advice_on, kind_of_contact
from .backbone import BackboneCurve, curve_at, rising_factors
from .curve_load import with_compliance
from .curve_question import CurveQuestion
from .report_parts import ReportParts
from .report_tables import curve_table, numbers_of, with_units

_SHOWN_CORNERS = 4  # corners whose loads and forces are shown
_HEAD = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Joint</title>
<style>
body {max-width: 60em; margin: 2em auto; padding: 0 1em; font-family: sans-serif; line-height: 1.4}
table {border-collapse: collapse; font-size: 85%; display: block; overflow-x: auto}
td, th {padding: .2em .6em; border-bottom: 1px solid #ccc; text-align: left; vertical-align: top;
white-space: nowrap}
td:nth-child(n+4):nth-last-child(-n+2) {white-space: normal}
img {max-width: 100%}
</style>"""


class _Section(NamedTuple):
    """A part of the text of a report."""

    title: str
    sentences: list[str]
    table: pd.DataFrame | None = None
    picture: Plotted | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Report(Kept, ReportParts):
    """All answers about a joint under its loads; `print` shows them as text.

    `save` writes them with their pictures.

    Attributes
    ----------
    system, cycle, friction
        The input; friction is (N,). The load of the joint is the cycle at load factor 1.
    missing
        Parts without an answer, name -> reason.
    mean_state
        The state under the mean load, reached from a state without slip.
    gross_slip, curve, limit, guaranteed, required
        Results of `gross_slip`, `backbone_curve` (with both limits, for its picture),
        `shakedown_limit`, `guaranteed_limit`, `required_friction`; None if `missing` has a reason.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> joint = fo.report(rod, cycle, friction=0.5)
    >>> print(joint.numbers[["number", "value"]].head(3).round(3).to_string(index=False))
              number  value
     gross-slip load   2.00
      work per cycle   1.00
    share that slips   0.25
    """

    def _answer(self) -> Mapping[str, object]:
        values = zip(self.numbers["number"], self.numbers["value"], strict=True)
        return {
            "nodes": self.system.nodes,
            **{name.replace(" ", "_"): value for name, value in values},
        }

    @property
    def kind(self) -> str:
        """The kind of contact, in words: its open nodes, and their consequences for the numbers."""
        return kind_of_contact(self)

    @property
    def numbers(self) -> pd.DataFrame:
        """A row for each number: columns number, value, unit, settles, meaning.

        The column settles says whether the number converges as the mesh is refined.
        """
        return numbers_of(self)

    @property
    def advice(self) -> list[str]:
        """Advice from these numbers, in sentences."""
        return list(advice_on(self))

    def _sections(self) -> Iterator[_Section]:
        """The parts of the text, in their order."""
        yield _Section("Advice", self.advice)
        yield _Section("Kind of contact", [self.kind])
        yield _Section("Numbers", [], self.numbers, self.limit)
        if self.steady is not None:
            names = self.cycle.corner_names
            if len(names) <= _SHOWN_CORNERS:
                corners = "; ".join(f"{k}: {name}" for k, name in enumerate(names))
                contacts = self.contacts
                sentences = [
                    "P, Q and fP are pressure, shear and the most that friction can hold, at the "
                    f"corners {corners}."
                ]
            else:
                sentences = []
                contacts = self.contacts.filter(regex=r"^(?!f?[PQ]_\d)")  # without forces
            table = with_units(self, contacts)
            yield _Section("Contacts at load factor 1", sentences, table, self.steady)
        if self.curve is not None:
            sentence = (
                "work: of friction, per cycle; slipping: share of all contacts; slip_range: "
                "largest of all nodes; damping: ratio."
            )
            table = with_units(self, curve_table(self, self.curve))
            yield _Section("What grows with the load", [sentence], table, self.curve)
        if self.missing:
            sentences = [f"{name}: {reason}" for name, reason in self.missing.items()]
            yield _Section("Without an answer", sentences)

    @property
    def _title(self) -> str:
        least, most = self.friction.min(), self.friction.max()
        friction = f"{least:g}" if least == most else f"{least:g} to {most:g}"
        title = f"Joint of {self.system.nodes} contact nodes, friction {friction}"
        if self.system.orthotropic:
            title += ", another one along the second tangents"
        if self.system.capped:
            title += " up to the shear strength of the surface"
        if self.system.units is not None:
            title += f", in {self.system.units}"
        return title

    @property
    def _loads(self) -> str:
        mean = ", ".join(f"{name} = {value:.4g}" for name, value in self.cycle.mean.items())
        names = self.cycle.corner_names
        corners = [*names[:_SHOWN_CORNERS]]
        if len(names) > _SHOWN_CORNERS:
            corners.append("...")
        return f"Mean load: {mean or 'none'}. Corners at load factor 1: {'; '.join(corners)}."

    def __str__(self) -> str:
        lines = [self._title, fill(self._loads, WIDE)]
        for section in self._sections():
            lines += ["", section.title, "-" * len(section.title)]
            lines += [fill(sentence, WIDE) for sentence in section.sentences]
            if section.title == "Numbers":
                lines += self._lines_of_numbers()
            elif section.table is not None:
                text = section.table.to_string(
                    index=False, float_format="{:.4g}".format, line_width=WIDE - 4
                )
                lines.append(text.rstrip())
        return "\n".join(lines)

    def _lines_of_numbers(self) -> Iterator[str]:
        """Two texts for each number: its value, and its meaning."""
        for row in self.numbers.itertuples():
            yield f"{row.number}: {row.value:.5g} {row.unit}".rstrip()
            meaning = f"{row.meaning}. Settles with the mesh: {row.settles}."
            yield fill(meaning, WIDE, initial_indent="    ", subsequent_indent="    ")

    def save(self, path: str | Path) -> None:
        """Write the report with its pictures into a single HTML file.

        If the name does not end in .html or .htm, the report is saved as any other result, for
        `results.load`.

        Raises
        ------
        ModelError
            The file cannot be written.
        ImportError
            matplotlib is not installed (extra `figures`).
        """
        if Path(path).suffix.lower() not in (".html", ".htm"):
            super().save(path)
            return
        file = output(path)
        from ..plots.draw import png  # imported here, because matplotlib is slow to import

        parts = [_HEAD, f"<h1>{escape(self._title)}</h1><p>{escape(self._loads)}</p>"]
        for section in self._sections():
            parts.append(f"<h2>{section.title}</h2>")
            for sentence in section.sentences:
                parts.append(f"<p>{escape(sentence).replace('`', '')}</p>")
            if section.table is not None:
                text = section.table.to_html(index=False, float_format="{:.4g}".format, border=0)
                parts.append(text)
            if section.picture is not None:
                image = b64encode(png(section.picture)).decode()
                parts.append(f'<img alt="{section.title}" src="data:image/png;base64,{image}">')
        file.write_text("\n".join(parts), encoding="utf-8")


LOAD_FACTORS = (0.25, 0.5, 1.0, 2.0)
"""Default load factors of the curve; they are reduced if the bodies slide off below the last one.
"""

# The default curve ends at this share of the gross-slip load. Closer to it the slip needs many
# cycles to become steady.
_BELOW_GROSS_SLIP = 0.95

_PARTS = {  # name of a part -> attribute of the report
    "mean load": "mean_state",
    "gross-slip load": "gross_slip",
    "curve": "curve",
    "shakedown limit": "limit",
    "guaranteed limit": "guaranteed",
    "required friction": "required",
}


@warns_of_odd_values
def report(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factors: ArrayLike | None = None,
    *,
    steps: int | None = None,
    progress: bool = True,
) -> Report:
    """All answers of frictopt about a joint; its load has the load factor 1.

    Its parts are: the nodes that are open under the mean load; the load at which bodies slide off
    (`gross_slip`); work, slip and stiffness as functions of the load, from no slip
    (`backbone_curve`), with the steady state at load factor 1; shakedown and guaranteed limit; the
    friction that would keep the contact stuck (`required_friction`); and advice. For a part without
    an answer there is a reason.

    If nodes of a contact in space are open under the mean load, the shakedown limit is computed
    with these open nodes only. Guaranteed limit and required friction are then left out, because
    their search takes minutes. For full searches call `shakedown_limit`, `guaranteed_limit` and
    `required_friction` themselves. The last two do not support a shear strength.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    load_factors
        (K,) load factors of the curve, > 0 and rising; 1 is added to them. None: 1/4, 1/2, 1 and 2,
        reduced in proportion if 2 is above 95 % of the gross-slip load.
    steps, progress
        Number of increments from corner to corner, and whether to show a bar after two seconds.
        None: the exact path in the plane, 2 increments in space; `step_error` estimates their
        error. Ctrl-C raises a KeyboardInterrupt whose attribute `report` holds the parts known so
        far.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    >>> joint = fo.report(punch, cycle, friction=0.9, load_factors=[0.5, 1.5])
    >>> print(joint.advice[0])
    From assembly without slip the contact stops slipping at your load.
    """
    coefficients = np.array(friction_coefficients(friction, checked_system(system).nodes))
    checked_cycle(cycle).corner_reactions(
        system
    )  # raises an error if the cycle names an unknown load case
    if steps is None and system.tangents == 2:
        steps = 2
    factors = None if load_factors is None else rising_factors(load_factors)
    with progress_bar(progress, "report", "part", total=len(_PARTS)) as bar:
        parts = _Parts(system, cycle, coefficients, steps, bar)
        mean = parts.ask("mean load", lambda: mean_state(system, cycle, coefficients))
        slides = parts.ask("gross-slip load", lambda: gross_slip(system, cycle, coefficients))
        parts.ask_curve(factors, slides)
        parts.ask_limits(mean)
    return parts.report()


class _Parts:
    """The known parts of a report, attribute -> result, and the reasons of the missing parts.

    The bar counts the parts and shows the current one. An interrupt keeps those that are known.
    """

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, friction: Array, steps: int | None, bar: Bar
    ) -> None:
        self.system = system
        self.cycle = cycle
        self.friction = friction
        self.steps = steps
        self.known = dict[str, Any]()
        self.missing = dict[str, str]()
        self._bar = bar

    def ask(self, part: str, question: Callable[[], Any]) -> Any:
        """Keep and return an answer; if there is none, keep the reason and return None."""
        left = ", ".join(self._left())
        note = f"the parts known so far are in the attribute `report`, without {left}"
        self._bar.keep("report", self._interrupted, note, best=part)
        answer = None
        try:
            answer = self.known[_PARTS[part]] = question()
        except (NoContinuation, SolverError) as error:
            self.missing[part] = str(error)
        self._bar.update()
        return answer

    def ask_curve(self, factors: Array | None, slides: GrossSlip | None) -> None:
        """The backbone curve, with load factor 1 unless the bodies slide off below."""
        upper = np.inf if slides is None else slides.load_factor
        if factors is None:
            scale = min(1.0, _BELOW_GROSS_SLIP * upper / LOAD_FACTORS[-1]) if upper > 0 else 1.0
            factors = scale * np.array(LOAD_FACTORS)
        load_rests = 1 <= upper * (1 + ROUNDING)
        if load_rests:
            factors = np.union1d(factors, [1.0])
        joint, load = with_compliance(self.system, self.cycle, self.friction, None)
        gross = slides or SolverError(self.missing["gross-slip load"])
        question = CurveQuestion(joint, self.cycle, self.friction, load, gross, None, self.steps)
        curve = self.ask("curve", lambda: curve_at(question, factors, True))
        if curve is not None and load_rests:
            states = [state for state in curve.steady_states if state is not None]
            if all(state.load_factor != 1 for state in states):
                self.missing["steady state at load factor 1"] = curve.note

    def ask_limits(self, mean: ContactState | None) -> None:
        """Both limits and the required friction, except long searches for open nodes in space."""
        system, cycle, f = self.system, self.cycle, self.friction
        reason = ""
        if mean is not None and mean.open.any() and system.tangents == 2:
            self.ask("shakedown limit", lambda: self._limit_with_open(mean.open))
            reason = (
                "not asked, for with open nodes in space its search takes minutes: call `fo.{}` "
                "yourself"
            )
        else:
            self.ask("shakedown limit", lambda: shakedown_limit(system, cycle, f))
            for law in other_laws(system):
                reason = f"not known of a surface with {law}"
        if reason:
            for part in ("guaranteed limit", "required friction"):
                self.missing[part] = reason.format(part.replace(" ", "_"))
            return
        self.ask("guaranteed limit", lambda: guaranteed_limit(system, cycle, f))
        self.ask("required friction", lambda: required_friction(system, cycle, 1.0))

    def _limit_with_open(self, is_open: Booleans) -> ShakedownLimit:
        """The shakedown limit with these nodes open."""
        try:
            return shakedown_limit(self.system, self.cycle, self.friction, open=is_open)
        except ModelError as error:
            # The closed nodes do not hold the open ones.
            raise NoContinuation(str(error)) from error

    def report(self) -> Report:
        """The report of the known parts; the curve gets the limits for its picture."""
        known = dict(self.known)
        curve: BackboneCurve | None = known.get("curve")
        if curve is not None:
            if "limit" in known:
                curve = replace(curve, shakedown_limit=known["limit"].load_factor)
            if "guaranteed" in known:
                curve = replace(curve, guaranteed_limit=known["guaranteed"].load_factor)
            known["curve"] = curve
        return Report(self.system, self.cycle, self.friction, dict(self.missing), **known)

    def _left(self) -> list[str]:
        """The parts that are neither known nor missing."""
        return [
            part
            for part, attribute in _PARTS.items()
            if attribute not in self.known and part not in self.missing
        ]

    def _interrupted(self) -> Report:
        """The report of the known parts, in which the parts that are left are missing."""
        missing = {**self.missing, **dict.fromkeys(self._left(), "interrupted")}
        return replace(self.report(), missing=missing)
