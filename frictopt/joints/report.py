"""What there is to know of a joint under its loads, in one call: every number with what it means and whether it settles with the mesh."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import ROUNDING, Array, Booleans, Kept, Outcome, Plotted, bar_of, warns_of_odd_values
from ..base.files import output
from ..base.results import WIDE
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    friction_coefficients,
)
from ..contact.diagnosis import counted
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import (
    GrossSlip,
    GuaranteedLimit,
    RequiredFriction,
    ShakedownLimit,
    gross_slip,
    guaranteed_limit,
    required_friction,
    shakedown_limit,
)
from ..transients import SteadyState
from ..transients.march import mean_state
from .backbone import Asked, BackboneCurve, rising_factors, size_of, with_compliance

_MANY = (
    20  # nodes that slip, from which on their work and share settle with the mesh to some per cent
)
_CORNERS = 4  # whose forces are shown
_MEASURES = "work: of friction, per cycle; slipping: share of all contacts; slip_range: largest of all nodes; damping: ratio."
_HEAD = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Joint</title>
<style>
body {max-width: 60em; margin: 2em auto; padding: 0 1em; font-family: sans-serif; line-height: 1.4}
table {border-collapse: collapse; font-size: 85%; display: block; overflow-x: auto}
td, th {padding: .2em .6em; border-bottom: 1px solid #ccc; text-align: left; vertical-align: top; white-space: nowrap}
td:nth-child(n+4):nth-last-child(-n+2) {white-space: normal}
img {max-width: 100%}
</style>"""


@dataclass(frozen=True, eq=False, repr=False)
class Report(Kept):
    """What there is to know of a joint under its loads. `print` shows it as text, `save` writes it with its pictures.

    Attributes
    ----------
    system, cycle, friction
        What was asked; friction is (N,). The user's load is that of load factor 1.
    missing
        Parts that have no answer, name -> why.
    mean_state
        The state under the mean load alone, from no slip.
    gross_slip, curve, limit, guaranteed, required
        Results of `gross_slip`, `backbone_curve` (with both limits, for its picture),
        `shakedown_limit`, `guaranteed_limit`, `required_friction`; None where `missing` says why.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> joint = fo.report(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), friction=0.5)
    >>> print(joint.numbers[["number", "value"]].head(3).round(3).to_string(index=False))
              number  value
     gross-slip load   2.00
      work per cycle   1.00
    share that slips   0.25
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    missing: Mapping[str, str]
    mean_state: ContactState | None = None
    gross_slip: GrossSlip | None = None
    curve: BackboneCurve | None = None
    limit: ShakedownLimit | None = None
    guaranteed: GuaranteedLimit | None = None
    required: RequiredFriction | None = None

    def _answer(self) -> Mapping[str, object]:
        return {
            "nodes": self.system.nodes,
            **{row.number.replace(" ", "_"): row.value for row in self.numbers.itertuples()},
        }

    @property
    def steady(self) -> SteadyState | None:
        """The steady state at load factor 1, from no slip; None where there is none."""
        return (
            None
            if self.curve is None
            else next(
                (
                    one
                    for one in self.curve.steady_states
                    if one is not None and one.load_factor == 1
                ),
                None,
            )
        )

    @property
    def kind(self) -> str:
        """What kind of contact it is, in words: which nodes the mean load and the steady cycle leave open, and what that means for its numbers."""
        mean, steady = self.mean_state, self.steady
        if mean is None:
            return f"From no slip the mean load is not followed to a state of rest: {self.missing['mean load']}."
        if mean.open.all():
            return "The mean load opens all nodes."
        if mean.open.any():
            told = f"The mean load leaves {counted(self.system, mean.open)} open. Pressure falls to zero beside them."
            return (
                told
                + " There the last closed node decides every limit, which falls as elements shrink: limits change with the mesh."
            )
        told = "All nodes are closed under the mean load"
        if steady is None:
            return told + "."
        if steady.open.any():
            return f"{told}; {counted(self.system, steady.open)} lift off in each cycle at load factor 1."
        return (
            f"{told}, and in each cycle at load factor 1. At sharp edges pressure grows as elements shrink, and limits there settle "
            "with the mesh slowly or not at all; where edges are rounded or the surfaces give, they settle."
        )

    @property
    def contacts(self) -> pd.DataFrame:
        """What each contact does at load factor 1, see `SteadyState.by_contact`; empty without a steady state."""
        return pd.DataFrame() if self.steady is None else self.steady.by_contact()

    @property
    def numbers(self) -> pd.DataFrame:
        """One row for each number: columns number, value, unit, settles (whether it does as elements shrink), meaning."""
        return pd.DataFrame(self._rows(), columns=["number", "value", "unit", "settles", "meaning"])

    def _rows(self) -> Iterator[tuple[str, float, str, str, str]]:
        steady, limit, slides, lifts = self.steady, self.limit, self.gross_slip, self._lifts
        by_nodes = "no" if lifts else "unless edges are sharp"
        units = self._units
        if slides is not None:
            settles = "yes" if slides.self_stress is None else "as the pressure of the fit does"
            yield "gross-slip load", slides.load_factor, "load factor", settles, slides.reason
        if steady is not None:
            slipping = int(steady.slipping.sum())
            as_slip = (
                "yes"
                if slipping >= _MANY
                else f"once more nodes slip, {slipping} do here"
                if slipping
                else "unless nodes slip on finer meshes"
            )
            told = (
                f"of friction, from assembly without slip, at load factor 1: {steady.outcome.value}"
            )
            if steady.steps:
                told += f"; finer increments may change it by {steady.step_error:.1g} of it"
            elif steady.unproven:
                told += (
                    f"; at {steady.unproven} events it is not proven that there is no other way on"
                )
            yield "work per cycle", steady.dissipation, units["work"], as_slip, told
            of = (
                "the area of all contacts"
                if self.system.width is not None
                else "the nodes of all contacts"
            )
            yield (
                "share that slips",
                steady.slipping_share,
                "of 1",
                as_slip,
                f"of {of}, in each cycle of this steady state",
            )
            yield (
                "largest slip range",
                float(self.contacts["slip_range"].max()),
                units["slip_range"],
                as_slip,
                "in each cycle of this steady state",
            )
            if np.isfinite(motion := self._motion):
                meaning = "half the range of the mean motion of what the load acts on, along the load, in this steady state"
                yield "motion of the load", motion, units["motion"], "yes", meaning
        if limit is not None:
            name = "shakedown limit" + " with these nodes open" * (
                lifts and self.system.tangents == 2
            )
            yield (
                name,
                limit.load_factor,
                "load factor",
                by_nodes,
                f"{limit.reason}. It covers {limit.covers}",
            )
        if self.guaranteed is not None:
            yield (
                "guaranteed limit",
                self.guaranteed.load_factor,
                "load factor",
                by_nodes,
                self.guaranteed.reason,
            )
        if self.required is not None:
            yield (
                "required friction",
                self.required.required,
                "coefficient",
                by_nodes,
                f"at load factor 1: {self.required.reason}",
            )

    @property
    def _units(self) -> dict[str, str]:
        """Units of the columns of tables; a column without a unit is a share, a ratio or a name."""
        force, length = (self.system.units or "force, length").split(", ")
        deep, area = (" per depth", length) if self.system.tangents == 1 else ("", f"{length}^2")
        units = {
            "work": f"{force} {length}{deep}",
            "slip_range": length,
            "motion": length,
            "area": area,
        }
        units |= {
            "stiffness": f"{force}{deep} per {length}",
            "displacement": f"{force} {length}{deep} per load factor",
        }
        return units | dict.fromkeys(("P", "Q", "fP"), f"{force}{deep}")

    def _with_units(self, table: pd.DataFrame) -> pd.DataFrame:
        """A table with the unit of each column in its name. A displacement is named for what it is, no length."""
        units = self._units

        def name_of(column: str) -> str:
            kind = column.split("_")[0] if column[-1:].isdigit() else column
            name = "work of the load" if column == "displacement" else column
            return f"{name} ({units[kind]})" if kind in units else name

        return table.rename(columns=name_of)

    def _growing(self, curve: BackboneCurve) -> pd.DataFrame:
        """What is known of a curve. Its stiffness is force over motion, not the load factor over the work of the load."""
        known, size = curve.to_frame().drop(columns="stiffness"), size_of(self.system, self.cycle)
        if np.isfinite(size):
            known = known.drop(columns="displacement")
            known.insert(
                known.columns.get_loc("motion") + 1,
                "stiffness",
                size * curve.load_factor / curve.motion,
            )
        return known.dropna(axis=1, how="all")

    @property
    def _motion(self) -> float:
        """Half the range of the motion of the load at load factor 1; NaN where it is not known."""
        return (
            np.nan
            if self.curve is None
            else float(self.curve.motion[self.curve.load_factor == 1].max(initial=-np.inf))
        )

    @property
    def _lifts(self) -> bool:
        """Whether the mean load leaves nodes open."""
        return self.mean_state is not None and bool(self.mean_state.open.any())

    @property
    def advice(self) -> list[str]:
        """What to do with these numbers, in sentences."""
        return list(self._advice())

    def _advice(self) -> Iterator[str]:
        if self.mean_state is not None and self.mean_state.open.all():
            yield "The mean load opens all nodes: press the contact."
            return
        enough = self.required is None or bool(np.isfinite(self.required.required))
        yield from self._on_sliding(enough)
        yield from self._on_slip(enough)
        if self._lifts:
            slips = self.steady is not None and int(self.steady.slipping.sum()) >= _MANY
            yield f"Quote the gross-slip load{', the work and the share that slips' * slips}, not the limits, which change with the mesh."

    def _on_sliding(self, enough: bool) -> Iterator[str]:
        """Whether bodies slide off; `enough` friction might keep the contact stuck."""
        slides = self.gross_slip
        if slides is not None and not slides.load_factor * (1 + ROUNDING) >= 1:
            yield f"At your load nothing rests, bodies slide off: press them more,{' raise friction,' * enough} or load them less."
        elif slides is not None and slides.least * (1 - ROUNDING) > 1:
            yield f"At your load nothing rests: below load factor {slides.least:.4g} the mean load slides bodies off."
        elif slides is not None and slides.load_factor < np.inf:
            fit = " in a transient from no slip: statics cannot know how far the fit presses" * (
                slides.self_stress is not None
            )
            yield f"Your load is {1 / slides.load_factor:.1%} of the gross-slip load, at which bodies slide off{fit}."

    def _on_slip(self, enough: bool) -> Iterator[str]:
        """What the steady cycle says, and what the limits add to it."""
        steady, limit, guaranteed = self.steady, self.limit, self.guaranteed
        if steady is not None and steady.outcome is Outcome.SHAKEDOWN:
            if (steady.friction == 0).any() and self.contacts["slip_range"].max() > 0:
                yield "At your load no friction does work; nodes without friction slide to and fro."
            else:
                yield "From assembly without slip the contact stops slipping at your load."
            if guaranteed is not None and guaranteed.load_factor < 1 and steady.friction.any():
                yield "Another start may slip for ever: `dissipation_range` says how much the start matters."
        elif steady is not None:
            worst = self.contacts.loc[self.contacts["work"].idxmax()]
            where = f", most of the work is done in {worst['contact']}" * (len(self.contacts) > 1)
            yield f"From assembly without slip {steady.slipping_share:.1%} of all contacts slips in every cycle at your load{where}."
            if steady.outcome is Outcome.RATCHETING:
                yield "It ratchets: with each cycle it slips further in one direction."
            if limit is not None and limit.least <= 1 <= limit.load_factor:
                yield "A state of rest exists at your load: `steady_state(..., initial_slip=limit.slip)` shows whether that start leads there."
            elif self.required is not None and enough:
                yield f"Friction of {self.required.required:.3g} and the right residual slip would keep it stuck."
            if guaranteed is not None and guaranteed.load_factor >= 1:
                yield "It slips below the guaranteed limit: nodes open and close in each cycle, and such cycles it does not cover."
        elif "steady state at load factor 1" in self.missing:
            yield "At your load no steady state is found, see what is without an answer."

    def _sections(self) -> Iterator[tuple[str, list[str], pd.DataFrame | None, Plotted | None]]:
        """Title, sentences, table and picture of each part, in their order."""
        yield "Advice", self.advice, None, None
        yield "Kind of contact", [self.kind], None, None
        yield "Numbers", [], self.numbers, self.limit
        if self.steady is not None:
            corners = [f"{k}: {name}" for k, name in enumerate(self.cycle.corner_names)]
            few = len(corners) <= _CORNERS
            told = f"P, Q and fP are pressure, shear and the most that friction can hold, at the corners {'; '.join(corners)}."
            contacts = self.contacts if few else self.contacts.filter(regex=r"^(?!f?[PQ]_\d)")
            yield "Contacts at load factor 1", [told] * few, self._with_units(contacts), self.steady
        if self.curve is not None:
            yield (
                "What grows with the load",
                [_MEASURES],
                self._with_units(self._growing(self.curve)),
                self.curve,
            )
        if self.missing:
            yield (
                "Without an answer",
                [f"{name}: {why}" for name, why in self.missing.items()],
                None,
                None,
            )

    @property
    def _title(self) -> str:
        least, most = self.friction.min(), self.friction.max()
        friction = f"{least:g}" if least == most else f"{least:g} to {most:g}"
        units = f", in {self.system.units}" * (self.system.units is not None)
        strong = " up to the shear strength of the surface" * self.system.capped
        across = ", another one along the second tangents" * self.system.orthotropic
        return f"Joint of {self.system.nodes} contact nodes, friction {friction}{across}{strong}{units}"

    @property
    def _loads(self) -> str:
        mean = (
            ", ".join(f"{name} = {value:.4g}" for name, value in self.cycle.mean.items()) or "none"
        )
        names = self.cycle.corner_names
        return f"Mean load: {mean}. Corners at load factor 1: {'; '.join(names[:_CORNERS])}{'; ...' * (len(names) > _CORNERS)}."

    def __str__(self) -> str:
        lines = [self._title, fill(self._loads, WIDE)]
        for title, sentences, table, _ in self._sections():
            lines += [
                "",
                title,
                "-" * len(title),
                *(fill(sentence, WIDE) for sentence in sentences),
            ]
            if title == "Numbers":
                for row in self.numbers.itertuples():
                    lines.append(f"{row.number}: {row.value:.5g} {row.unit}".rstrip())
                    meaning = f"{row.meaning}. Settles with the mesh: {row.settles}."
                    lines.append(
                        fill(meaning, WIDE, initial_indent="    ", subsequent_indent="    ")
                    )
            elif table is not None:
                lines.append(
                    table.to_string(
                        index=False, float_format="{:.4g}".format, line_width=WIDE - 4
                    ).rstrip()
                )
        return "\n".join(lines)

    def save(self, path: str | Path) -> None:
        """Write the report with its pictures into one HTML file, which needs no other; under a name that ends otherwise as any result, to be loaded.

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
        file, parts = (
            output(path),
            [_HEAD, f"<h1>{escape(self._title)}</h1><p>{escape(self._loads)}</p>"],
        )
        from ..plots.draw import png  # imported here, for matplotlib is slow to import

        for title, sentences, table, shown in self._sections():
            parts += [
                f"<h2>{title}</h2>",
                *(f"<p>{escape(sentence).replace('`', '')}</p>" for sentence in sentences),
            ]
            parts += (
                []
                if table is None
                else [table.to_html(index=False, float_format="{:.4g}".format, border=0)]
            )
            parts += (
                []
                if shown is None
                else [
                    f'<img alt="{title}" src="data:image/png;base64,{b64encode(png(shown)).decode()}">'
                ]
            )
        file.write_text("\n".join(parts), encoding="utf-8")


LOAD_FACTORS = (0.25, 0.5, 1.0, 2.0)
"""Load factors of the curve, unless others are asked for; scaled down where the contact slides off before the last one."""

# share of the gross-slip load up to which the curve goes: nearer to it many cycles pass before the
# slip is steady
_BELOW = 0.95
_STEPS = 2  # increments from corner to corner in space
_PARTS = {  # as they are called -> attribute of the report
    "mean load": "mean_state",
    "gross-slip load": "gross_slip",
    "curve": "curve",
    "shakedown limit": "limit",
    "guaranteed limit": "guaranteed",
    "required friction": "required",
}
_SEARCHED = (
    "not asked, for with open nodes in space its search takes minutes: call `fo.{}` yourself"
)


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
    """All that frictopt has to say of a joint under its loads, the user's load being that of load factor 1.

    Its parts are: the nodes that the mean load leaves open; the load at which bodies slide off
    (`gross_slip`); what grows with the load, from no slip (`backbone_curve`), with the steady state
    at load factor 1; shakedown and guaranteed limit; the friction that would keep the contact stuck
    (`required_friction`); and advice. A part without an answer stands there with the reason. Where
    the mean load leaves nodes open in space, the shakedown limit is that with these nodes open, and
    guaranteed limit and required friction are left out, for they search for minutes: ask
    `shakedown_limit`, `guaranteed_limit` and `required_friction` themselves. These two do not know
    a shear strength.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    load_factors
        (K,) load factors of the curve, > 0 and rising, to which 1 is added; None: 1/4, 1/2, 1 and
        2, or less, where 2 is above 95 % of the gross-slip load.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 2 in space,
        whose `step_error` says what they leave), and whether to show a bar after two seconds.
        Ctrl-C stays a KeyboardInterrupt with an attribute `report`, which holds what is known by
        then.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    >>> joint = fo.report(punch, fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}]), friction=0.9, load_factors=[0.5, 1.5])
    >>> print(joint.advice[0])
    From assembly without slip the contact stops slipping at your load.
    """
    f = np.array(friction_coefficients(friction, checked_system(system).nodes))
    checked_cycle(cycle).corner_reactions(system)  # says which load case is unknown
    in_space = system.tangents == 2
    steps = _STEPS if steps is None and in_space else steps
    factors = None if load_factors is None else rising_factors(load_factors)
    found, missing, at = dict[str, Any](), dict[str, str](), ""

    def ask(part: str, question: Callable[[], Any]) -> Any:
        """The answer, kept; None where there is no such state, or no proof of one."""
        nonlocal at
        at = part
        try:
            found[_PARTS[part]] = answer = question()
        except (NoContinuation, SolverError) as error:
            missing[part], answer = str(error), None
        bar.update()
        return answer

    def limit_of(opened: Booleans) -> ShakedownLimit:
        """The limit with these nodes open."""
        try:
            return shakedown_limit(system, cycle, f, open=opened)
        except ModelError as error:  # the closed nodes do not hold the open ones
            raise NoContinuation(str(error)) from error

    def kept(_: object) -> tuple[str, Report, str]:
        left = [part for part, name in _PARTS.items() if name not in found and part not in missing]
        known = Report(system, cycle, f, missing | dict.fromkeys(left, "interrupted"), **found)
        return (
            "report",
            known,
            f"what is known by then is the attribute `report`, without {', '.join(left)}",
        )

    with bar_of(progress, "report", "part", total=len(_PARTS), best=lambda: at, keeps=kept) as bar:
        mean = ask("mean load", lambda: mean_state(system, cycle, f))
        slides = ask("gross-slip load", lambda: gross_slip(system, cycle, f))
        most = np.inf if slides is None else slides.load_factor
        if factors is None:
            factors = (min(1.0, _BELOW * most / LOAD_FACTORS[-1]) if most > 0 else 1.0) * np.array(
                LOAD_FACTORS
            )
        rests = 1 <= most * (1 + ROUNDING)
        joint, load = with_compliance(system, cycle, f, None)
        asked = Asked(
            joint, cycle, f, load, slides or SolverError(missing["gross-slip load"]), None, steps
        )
        curve = ask("curve", lambda: asked.followed(np.union1d(factors, [1.0] * rests), True))
        if (
            curve
            and rests
            and not any(steady and steady.load_factor == 1 for steady in curve.steady_states)
        ):
            missing["steady state at load factor 1"] = curve.note
        opened = in_space and mean is not None and bool(mean.open.any())
        ask(
            "shakedown limit",
            lambda: limit_of(mean.open) if opened else shakedown_limit(system, cycle, f),
        )
        if opened:
            missing |= {
                part: _SEARCHED.format(part.replace(" ", "_"))
                for part in ("guaranteed limit", "required friction")
            }
        elif system.capped:
            missing |= dict.fromkeys(
                ("guaranteed limit", "required friction"),
                "not known of a surface with a shear strength",
            )
        else:
            ask("guaranteed limit", lambda: guaranteed_limit(system, cycle, f))
            ask("required friction", lambda: required_friction(system, cycle, 1.0))
    if curve:
        limits = {
            name: found[of].load_factor
            for name, of in (("shakedown_limit", "limit"), ("guaranteed_limit", "guaranteed"))
            if of in found
        }
        found["curve"] = replace(curve, **limits)
    return Report(system, cycle, f, missing, **found)
