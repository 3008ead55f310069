"""Files of a report: one page of HTML to print and sign, JSON, and tables for a spreadsheet."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from pathlib import Path
from typing import Any

import pandas as pd

from ..base import Plotted
from ..base.files import sealed, write_sheets
from .advice import advice_on, gross_slip_in_words, kind_of_contact
from .report_parts import ReportParts
from .report_tables import curve_table, numbers_of, with_units
from .report_text import (
    PAGES,
    Section,
    loads_of,
    missing_in_words,
    sections_of,
    title_of,
)

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
    sections = [s for page in range(1, len(PAGES) + 1) for s in sections_of(parts, page)]
    lines = [_HEAD, f"<h1>{escape(title_of(parts))}</h1><p>{escape(loads_of(parts))}</p>"]
    picture = [] if parts.model is None else [_image("joint", parts.model)]
    for section in sections:
        if section.title == "Numbers":
            # Beside narrow tables there is room for it.
            lines += picture
            picture = []
        lines.append(f"<h2>{section.title}</h2>")
        if section.table is not None:
            lines.append(_table(parts, section, section.table))
        lines += [f"<p>{_text(sentence)}</p>" for sentence in section.sentences]
    if parts.model is not None:
        bodies = Section("Bodies", [], units={})
        lines.append(f"<h2>Bodies</h2>{_table(parts, bodies, parts.bodies)}")
    lines += [*picture, _SIGNED, '<div class="details">']
    for section in sections:
        if section.in_full is not None:
            lines.append(f"<h3>{section.title}</h3>")
            lines.append(_table(parts, section, section.in_full))
        if section.picture is not None:
            lines.append(_image(section.title, section.picture))
    lines.append("</div>")
    file.write_text("\n".join(lines), encoding="utf-8")


def _image(title: str, pictured: Plotted) -> str:
    from ..plots.style import png  # imported here, because matplotlib is slow to import

    image = b64encode(png(pictured)).decode()
    return f'<img alt="{title}" src="data:image/png;base64,{image}">'


def _table(parts: ReportParts, section: Section, table: pd.DataFrame) -> str:
    if section.units is not None:
        table = with_units(parts, table)
    html: str = table.to_html(
        index=False,
        float_format="{:.4g}".format,
        na_rep="-",
        border=0,
        classes="long" if "meaning" in table.columns else None,
    )
    return html


def _text(sentence: str) -> str:
    return escape(sentence).replace("`", "")


def tables_of(parts: ReportParts) -> dict[str, pd.DataFrame]:
    """Name -> table of a report, with units in the names of columns."""
    tables = {
        "verdicts": parts.verdicts,
        "safety": parts.safety,
        "numbers": numbers_of(parts),
        "contacts": with_units(parts, parts.contacts),
        "bodies": with_units(parts, parts.bodies),
    }
    if parts.curve is not None:
        tables["curve"] = with_units(parts, curve_table(parts, parts.curve))
    return {name: table for name, table in tables.items() if not table.empty}


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
