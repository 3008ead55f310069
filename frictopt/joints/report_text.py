"""The text of a report: its pages, their sections, and tables that fit on paper."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterator
from html import escape
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ..base import Plotted, number_of
from ..base.files import sealed, write_sheets
from .advice import advice_on, gross_slip_in_words, kind_of_contact
from .report_tables import (
    ReportParts,
    columns_with_units,
    curve_table,
    motions_of_points,
    numbers_at_load,
    numbers_of,
    numbers_of_limits,
    units_of,
    with_units,
)
from .scatter import range_of

PAPER = 68
"""Characters of a line on paper, and on a page of the documentation."""

_MOST_LINES = 40  # of the text of a whole report
_FIRST = "As assembled"
_BY_IMPORTANCE = (
    *(_FIRST, "Without an answer", "Verdicts", "Numbers", "Face by face", "Safety factors"),
    *("Limits", "The contact", "What grows with the load"),
)
_SHOWN_CORNERS = 4  # corners whose loads and forces are shown
_BRIEF = ["number", "value", "unit", "converges"]
_OF_FACES = [
    *("contact", "slides_at", "slides_at_steady", "utilisation", "slipping"),
    *("slip_range", "work", "carries", "where"),
]
_OF_ONE_FACE = ["slipping", "slip_range", "work"]
_NOT_ON_PAPER = ["converges", "where", "slides_at_steady", "carries"]
_OF_CURVE = ["load_factor", "work", "slipping", "slip_range", "motion"]
PAGES = ("At your load", "What grows with the load", "Limits")
"""Titles of the pages, in the order in which they are answered."""


class Section(NamedTuple):
    """A part of a report.

    The sheet has the sentences and the table; the details have the table in full and the picture.
    """

    title: str
    sentences: list[str]
    table: pd.DataFrame | None = None
    in_full: pd.DataFrame | None = None
    picture: Plotted | None = None


def title_of(parts: ReportParts) -> str:
    """The title of a report: the given title, the number of nodes, the friction and the units."""
    nodes = number_of(parts.system.nodes, "contact node")
    title = f"{parts.title}: " if parts.title else ""
    title += f"Joint of {nodes}, friction {range_of(parts.friction)}"
    if parts.system.orthotropic:
        title += ", another one along the second tangents"
    if parts.system.capped:
        title += " up to the shear strength of the surface"
    if parts.system.units is not None:
        title += f", in {parts.system.units}"
    return title


def loads_of(parts: ReportParts) -> str:
    """The loads of a report, the scatter of its input, its origin, and what is not in its model."""
    loads = parts.cycle.mean.items()
    mean = ", ".join(f"{name} = {value:.4g}" for name, value in loads if value)
    names = parts.cycle.corner_names
    corners = [*names[:_SHOWN_CORNERS]]
    if len(names) > _SHOWN_CORNERS:
        corners.append("...")
    text = f"Mean load: {mean or 'none'}. Corners at load factor 1: {'; '.join(corners)}."
    for point, motion in motions_of_points(parts).items():
        text += f" They move {point} by +-{motion:.4g} {units_of(parts)['motion']}."
    if parts.scatter:
        text += f" Scatter: {parts.scatter}."
    if parts.origin:
        text += f" {parts.origin}"
    return f"{text} Not in the model: {parts.notes}." if parts.notes else text


def _sections(parts: ReportParts) -> list[Section]:
    """The sections of all pages that are known."""
    return [*_at_load(parts), *_with_load(parts), *_limits(parts)]


def _at_load(parts: ReportParts) -> Iterator[Section]:
    yield Section(_FIRST, list(advice_on(parts)))
    yield Section("The contact", [*gross_slip_in_words(parts), kind_of_contact(parts)])
    if not parts.verdicts.empty:
        sentence = (
            "Passed if the value is at most its limit; of a safety factor, at least. The margin "
            "is the limit over the value with the estimated error of its work; of a safety factor "
            "the value over the limit."
        )
        yield Section("Verdicts", [sentence], verdicts_in_words(parts))
    if not parts.contacts.empty:
        yield from _faces(parts)
    numbers = numbers_at_load(parts)
    if not numbers.empty:
        yield Section("Numbers", [], numbers[_BRIEF], numbers)


def _faces(parts: ReportParts) -> Iterator[Section]:
    """The contacts face by face, and the forces through ties, which have no contact nodes."""
    contacts = parts.contacts
    is_tie = contacts.get("nodes", pd.Series(1, contacts.index)) == 0
    along = " along the first tangents" if parts.system.orthotropic else ""
    sentence = (
        "slides_at: load factor at which the face slides in full, with the pressure of the "
        "mean load; slides_at_steady: with that of the steady state. P, Q, fP: pressure, "
        f"shear, and the most that friction can hold{along}; utilisation: Q / fP. carries: "
        "share of the friction as bodies slide off."
    )
    # If there is a single face, its slip and work are already among the numbers.
    faces = contacts[~is_tie].dropna(axis=1, how="all")
    known = _OF_ONE_FACE if len(faces) == 1 else []
    table = faces[[name for name in _OF_FACES if name in faces and name not in known]]
    yield Section("Face by face", [sentence], table, contacts, parts.steady)
    if is_tie.any():
        sentence = (
            "P: normal force at the corners of the steady cycle, compression positive; Q: shear; "
            "M: moment about the middle of the tied area."
        )
        corners = range(min(len(parts.cycle.corners), _SHOWN_CORNERS))
        names = ["contact", *(f"{part}_{k}" for k in corners for part in "PQM")]
        yield Section("Forces through ties", [sentence], contacts.loc[is_tie, names])


def verdicts_in_words(parts: ReportParts) -> pd.DataFrame:
    """The verdicts with words for `passed`; the worst input is named only if the input scatters."""
    table = parts.verdicts.assign(passed=np.where(parts.verdicts["passed"], "yes", "NO"))
    return table if parts.scatter else table.drop(columns="at")


def _with_load(parts: ReportParts) -> Iterator[Section]:
    # Without scatter, a factor against gross slip repeats the gross-slip load.
    if len(parts.safety) > (0 if parts.scatter else 1):
        sentences = ["A safety factor is the number by which the cyclic load may grow."]
        if parts.scatter:
            for method in dict.fromkeys(parts.safety["by"]):
                against = parts.safety.loc[parts.safety["by"] == method, "against"]
                sentences.append(f"The worst of {' and of '.join(against)} is found {method}.")
        table = parts.safety.drop(columns="by" if parts.scatter else ["by", "worst", "at"])
        yield Section("Safety factors", sentences, table)
    if parts.curve is not None:
        table = curve_table(parts, parts.curve)
        brief = table[[name for name in _OF_CURVE if name in table]]
        yield Section("What grows with the load", [], brief, table, parts.curve)


def _limits(parts: ReportParts) -> Iterator[Section]:
    numbers = numbers_of_limits(parts)
    if not numbers.empty:
        rows = parts.probability.itertuples(index=False)
        found = [f"The {name} is found: {method}." for name, _, _, method in rows]
        yield Section("Limits", found, numbers[_BRIEF], numbers, parts.limit)
    if parts.missing:
        yield Section("Without an answer", missing_in_words(parts))


def missing_in_words(parts: ReportParts) -> list[str]:
    """A sentence for each reason, with the parts that lack an answer for this reason."""
    by_reason = dict[str, list[str]]()
    for name, reason in parts.missing.items():
        by_reason.setdefault(reason, []).append(name)
    return [f"{', '.join(names)}: {reason}" for reason, names in by_reason.items()]


def _section_text(parts: ReportParts, section: Section) -> str:
    """The text of a section; the sentences that a report begins with need no heading."""
    heading = [] if section.title == _FIRST else [f"{section.title}:"]
    # In this text a section with a table has no sentences. They explain its columns, and the sheet
    # (HTML) has them.
    if section.table is None:
        return "\n".join([*heading, *(fill(sentence, PAPER) for sentence in section.sentences)])
    table = section.table
    if section.title != "Verdicts":
        table = table.drop(columns=_NOT_ON_PAPER, errors="ignore")
    # The columns of numbers need no names.
    return "\n".join([*heading, _table_text(parts, table, header="number" not in table)])


def whole_text(parts: ReportParts) -> str:
    """The text of all pages in at most `_MOST_LINES` lines.

    Tables have only the columns that fit beside each other. Sections that do not fit are named.
    """
    sections = _sections(parts)
    texts = {section.title: _section_text(parts, section).split("\n\n")[0] for section in sections}
    left = list[str]()
    # The sentence on sections that do not fit takes an empty line and up to two lines of text.
    room = _MOST_LINES - 3 - len(_head(parts).splitlines())
    for title in filter(texts.get, _BY_IMPORTANCE):
        needed = 1 + len(texts[title].splitlines())
        if needed > room:
            del texts[title]
            left.append(title.lower())
        else:
            room -= needed
    if left:
        texts["left"] = fill(f"On the pages of `save` also: {', '.join(left)}.", PAPER)
    return "\n\n".join([_head(parts), *filter(None, texts.values())])


def shown_page(parts: ReportParts, page: int, pages: int) -> str:
    """The text of a finished page, headed by its number."""
    head = f"Page {page} of {pages}: {PAGES[page - 1].lower()}"
    if page == 1:
        head = f"{_head(parts)}\n\n{head}"
    sections = (_at_load, _with_load, _limits)[page - 1](parts)
    texts = [_section_text(parts, section) for section in sections] or ["Nothing is known."]
    return "\n\n".join([head, *texts]) + "\n"


def _head(parts: ReportParts) -> str:
    # Only this text is cut: the sheet has the title, the loads and the notes in full.
    title = fill(title_of(parts), PAPER, max_lines=2, placeholder=" ...")
    return f"{title}\n{fill(loads_of(parts), PAPER, max_lines=9, placeholder=' ...')}"


def _table_text(parts: ReportParts, table: pd.DataFrame, header: bool) -> str:
    """A table on paper; columns that do not fit follow below, with the first column repeated.

    Units stand below the names of their columns.
    """
    key = table.columns[0]
    shown = table.set_index(key).rename_axis(index=None, columns=key)
    named = columns_with_units(parts, shown)
    if any(unit for _, unit in named.values()):
        shown.columns = pd.MultiIndex.from_tuples(named.values(), names=[key, ""])
    text = shown.to_string(
        header=header,
        float_format="{:.4g}".format,
        na_rep="-",
        line_width=PAPER,
        max_colwidth=PAPER // 2,
    )
    # pandas ends a line with a backslash if its columns continue below.
    return re.sub(r" *\\?$", "", text, flags=re.MULTILINE)


# Files of a report: one page of HTML to print and sign, JSON, and tables for a spreadsheet.

_HEAD = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Joint</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body {max-width: 60em; margin: 2em auto; padding: 0 1em; font-family: sans-serif; line-height: 1.4}
table {border-collapse: collapse; font-size: 85%; display: block; overflow-x: auto}
td, th {padding: .2em .6em; border-bottom: 1px solid #ccc; text-align: left; vertical-align: top;
white-space: nowrap}
.long td:last-child, .long td:nth-last-child(2) {white-space: normal}
img {max-width: 100%}
img[alt="joint"] {float: right; max-width: 48%; max-height: 22em}
.signed {clear: both; display: flex; gap: 2em; margin: 3em 0 2em}
.signed span {flex: 1; border-top: 1px solid; padding-top: .3em}
@media print {
  @page {size: A4; margin: 14mm}
  body {max-width: none; margin: 0; padding: 0; font-size: 9.5pt; line-height: 1.3}
  h1 {font-size: 14pt; margin: 0 0 .4em} h2 {font-size: 11pt; margin: .6em 0 .2em}
  p, ul {margin: .2em 0} table {overflow: visible; display: table}
  td, th {white-space: normal}
  .details {break-before: page; font-size: 8.5pt} img {max-height: 150mm}
  tr, img {break-inside: avoid}
  .details h2, .details h3 {break-after: avoid}
}
</style>"""
_SIGNED = (
    '<div class="signed"><span>Prepared, date</span><span>Checked, date</span>'
    "<span>Released, date</span></div>"
)


def write_html(parts: ReportParts, file: Path) -> None:
    """Write the sheet, one page to print and sign; behind it tables in full and pictures."""
    sections = _sections(parts)
    lines = [_HEAD, f"<h1>{escape(title_of(parts))}</h1><p>{escape(loads_of(parts))}</p>"]
    picture = [] if parts.model is None else [_image("joint", parts.model)]
    for section in sections:
        if section.title == "Numbers":
            # Beside narrow tables there is room for the picture.
            lines += picture
            picture = []
        lines.append(f"<h2>{section.title}</h2>")
        if section.table is not None:
            lines.append(_table(parts, section.table))
        for sentence in section.sentences:
            lines.append(f"<p>{escape(sentence).replace('`', '')}</p>")
    if parts.model is not None:
        lines.append(f"<h2>Bodies</h2>{_table(parts, parts.bodies)}")
    lines += [*picture, _SIGNED, '<div class="details">']
    for section in sections:
        if section.in_full is not None:
            lines.append(f"<h3>{section.title}</h3>")
            lines.append(_table(parts, section.in_full))
        if section.picture is not None:
            lines.append(_image(section.title, section.picture))
    lines.append("</div>")
    file.write_text("\n".join(lines), encoding="utf-8")


def _image(title: str, pictured: Plotted) -> str:
    from ..plots.style import png  # imported here, because matplotlib is slow to import

    image = b64encode(png(pictured)).decode()
    return f'<img alt="{title}" src="data:image/png;base64,{image}">'


def _table(parts: ReportParts, table: pd.DataFrame) -> str:
    html: str = with_units(parts, table).to_html(
        index=False,
        float_format="{:.4g}".format,
        na_rep="-",
        border=0,
        classes="long" if "meaning" in table.columns else None,
    )
    return html


def tables_of(parts: ReportParts) -> dict[str, pd.DataFrame]:
    """Name -> table of a report, with units in the names of columns."""
    tables = {
        "verdicts": parts.verdicts,
        "safety": parts.safety,
        "numbers": numbers_of(parts),
        "contacts": parts.contacts,
        "bodies": parts.bodies,
    }
    if parts.curve is not None:
        tables["curve"] = curve_table(parts, parts.curve)
    return {name: with_units(parts, table) for name, table in tables.items() if not table.empty}


def write_json(parts: ReportParts, file: Path) -> None:
    """Write all numbers and sentences as strict JSON: null for NaN, "inf" and "-inf" as texts."""
    content: dict[str, Any] = {
        "title": title_of(parts),
        "origin": parts.origin,
        "loads": loads_of(parts),
        "units": parts.system.units,
        "scatter": parts.scatter,
        "advice": list(advice_on(parts)),
        "kind": kind_of_contact(parts),
        "gross_slip": list(gross_slip_in_words(parts)),
        "outcome": None if parts.steady is None else parts.steady.outcome.name,
        "missing": dict(parts.missing),
    }
    content |= tables_of(parts)
    file.write_text(sealed(content), encoding="utf-8")


def write_spreadsheet(parts: ReportParts, file: Path) -> None:
    """Write a sheet with the sentences and one for each table."""
    sentences = [title_of(parts), loads_of(parts), *advice_on(parts), *gross_slip_in_words(parts)]
    sentences.append(kind_of_contact(parts))
    sentences += missing_in_words(parts)
    write_sheets(file, {"joint": pd.DataFrame({"joint": sentences}), **tables_of(parts)})
