"""The report on a joint: its numbers in a table, its contacts, advice, and one file to send."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape
from importlib import import_module
from pathlib import Path
from textwrap import fill

import numpy as np
import pandas as pd

from ..contact import Array, ContactState, ContactSystem, Kept, LoadCycle, Outcome, Plotted
from ..contact.diagnosis import counted
from ..contact.files import output
from ..limits import GrossSlip, GuaranteedLimit, RequiredFriction, ShakedownLimit
from ..transients import SteadyState
from .backbone_result import BackboneCurve

_WIDTH = 79  # characters of a line
_HEAD = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Joint</title>
<style>
body {max-width: 60em; margin: 2em auto; padding: 0 1em; font-family: sans-serif; line-height: 1.4}
table {border-collapse: collapse; font-size: 85%; display: block; overflow-x: auto}
td, th {padding: .2em .6em; border-bottom: 1px solid #ccc; text-align: left; vertical-align: top; white-space: nowrap}
td:last-child {white-space: normal}
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
        Results of `gross_slip`, `backbone_curve` (with both limits, for its picture), `shakedown_limit`, `guaranteed_limit`, `required_friction`;
        None where `missing` says why.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> joint = fo.report(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), friction=0.5)
    >>> print(joint.numbers[["number", "value", "settles"]].head(3).round(3).to_string(index=False))
                          number  value settles
                sliding-off load    inf     yes
                  work per cycle   1.00     yes
    share of the face that slips   0.25     yes
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
        return {"nodes": self.system.nodes, **{row.number.replace(" ", "_"): row.value for row in self.numbers.itertuples()}}

    @property
    def steady(self) -> SteadyState | None:
        """The steady state at load factor 1, from no slip; None where there is none."""
        return None if self.curve is None else next((one for one in self.curve.steady_states if one is not None and one.load_factor == 1), None)

    @property
    def kind(self) -> str:
        """What kind of contact it is, in words: which nodes the mean load and the steady cycle leave open, and what that means for its numbers."""
        mean, steady = self.mean_state, self.steady
        if mean is None:
            return f"The mean load alone comes to no rest: {self.missing['mean load']}."
        if mean.open.any():
            told = f"The mean load leaves {counted(self.system, mean.open)} open. Pressure falls to zero beside them."
            return told + " There the last closed node decides every limit, which falls as elements shrink: limits belong to the mesh."
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
        steady, limit, slides = self.steady, self.limit, self.gross_slip
        by_nodes = "no" if self.mean_state is not None and self.mean_state.open.any() else "unless edges are sharp"
        force, length = (self.system.units or "force, length").split(", ")
        if slides is not None:
            yield "sliding-off load", slides.load_factor, "load factor", "yes", slides.reason
        if steady is not None:
            work = f"{force} {length}{' per depth' * (self.system.tangents == 1)}"
            yield "work per cycle", steady.dissipation, work, "yes", f"of friction, from assembly, at load factor 1: {steady.outcome.value}"
            yield "share of the face that slips", steady.slipping_share, "", "yes", "in each cycle of this steady state"
            yield "largest slip range", float(self.contacts["slip_range"].max()), length, "yes", "in each cycle of this steady state"
        if limit is not None:
            yield "shakedown limit", limit.load_factor, "load factor", by_nodes, f"{limit.reason}. It covers {limit.covers}"
        if self.guaranteed is not None:
            yield "guaranteed limit", self.guaranteed.load_factor, "load factor", by_nodes, self.guaranteed.reason
        if self.required is not None:
            yield "required friction", self.required.required, "", by_nodes, f"at load factor 1: {self.required.reason}"

    @property
    def advice(self) -> list[str]:
        """What to do with these numbers, in sentences."""
        return list(self._advice())

    def _advice(self) -> Iterator[str]:
        slides, steady, limit = self.gross_slip, self.steady, self.limit
        if slides is not None and not slides.load_factor >= 1:
            yield "At your load nothing rests, bodies slide off: press them more, raise friction, or load them less."
        elif slides is not None and slides.load_factor < np.inf:
            yield f"Your load is {1 / slides.load_factor:.1%} of the load at which bodies slide off."
        rests = limit is not None and limit.least <= 1 <= limit.load_factor
        if steady is not None and steady.outcome is Outcome.SHAKEDOWN:
            yield "From assembly without slip the contact stops slipping at your load."
            if self.guaranteed is not None and self.guaranteed.load_factor < 1:
                yield "Another start may slip for ever: `dissipation_range` tells how much the start matters."
        elif steady is not None:
            worst = self.contacts.loc[self.contacts["work"].idxmax(), "contact"]
            yield (
                f"From assembly without slip {steady.slipping_share:.1%} of the face slips in every cycle at your load, most of the work is done in "
                f"{worst}: `wear` and `steady.fretting_table` tell what that does."
            )
            if rests:
                yield "The start decides: from another one, such as `limit.slip`, the contact would rest at your load."
            elif self.required is not None and np.isfinite(self.required.required):
                yield f"Friction of {self.required.required:.3g} and the right residual slip would keep it stuck."
        if self.mean_state is not None and self.mean_state.open.any():
            yield "Quote the sliding-off load, the work and the share of the face that slips, not the limits: they belong to the mesh."

    def _sections(self) -> Iterator[tuple[str, list[str], pd.DataFrame | None, Plotted | None]]:
        """Title, sentences, table and picture of each part, in their order."""
        yield "Advice", self.advice, None, None
        yield "Kind of contact", [self.kind], None, None
        yield "Numbers", ["In brackets: does the number settle as elements shrink?"], self.numbers, self.limit
        if self.steady is not None:
            corners = [f"{k}: {name}" for k, name in enumerate(self.cycle.corner_names)]
            yield "Contacts at load factor 1", [f"Forces P, Q and f P at the corners {'; '.join(corners)}."], self.contacts, self.steady
        if self.curve is not None:
            yield "What grows with the load", [self.curve.note] * bool(self.curve.note), self.curve.to_frame().dropna(axis=1, how="all"), self.curve
        if self.missing:
            yield "Without an answer", [f"{name}: {why}" for name, why in self.missing.items()], None, None

    def __str__(self) -> str:
        lines = [f"Joint of {self.system.nodes} contact nodes", fill(str(self.cycle), _WIDTH)]
        for title, sentences, table, _ in self._sections():
            lines += ["", title, "-" * len(title), *(fill(sentence, _WIDTH) for sentence in sentences)]
            if title == "Numbers":
                for row in self.numbers.itertuples():
                    lines.append(f"{row.number}: {row.value:.5g} {row.unit}".rstrip() + f" (settles: {row.settles})")
                    lines.append(fill(row.meaning, _WIDTH, initial_indent="    ", subsequent_indent="    "))
            elif table is not None:
                lines.append(table.to_string(index=False, float_format="{:.4g}".format, line_width=_WIDTH - 4).rstrip())
        return "\n".join(lines)

    def save(self, path: str | Path) -> None:
        """Write the report with its pictures into one HTML file, which needs no other; under another name than .html as any result, to be loaded.

        Raises
        ------
        ModelError
            The file cannot be written.
        ImportError
            matplotlib is not installed (extra `figures`).
        """
        if Path(path).suffix != ".html":
            super().save(path)
            return
        file, parts = output(path), [_HEAD, f"<h1>Joint of {self.system.nodes} contact nodes</h1><p>{escape(str(self.cycle))}</p>"]
        png = import_module("frictopt.plots").png  # here, for matplotlib is slow to import and need not be installed
        for title, sentences, table, shown in self._sections():
            parts += [f"<h2>{title}</h2>", *(f"<p>{escape(sentence)}</p>" for sentence in sentences)]
            parts += [] if table is None else [table.to_html(index=False, float_format="{:.4g}".format, border=0)]
            parts += [] if shown is None else [f'<img alt="{title}" src="data:image/png;base64,{b64encode(png(shown)).decode()}">']
        file.write_text("\n".join(parts), encoding="utf-8")
