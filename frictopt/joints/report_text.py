"""The text of a report: its pages, their sections, and tables that fit on paper."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from textwrap import fill
from typing import NamedTuple

import numpy as np
import pandas as pd

from ..base import Plotted
from .advice import advice_on, gross_slip_in_words, kind_of_contact
from .report_parts import ReportParts
from .report_tables import (
    columns_with_units,
    curve_table,
    numbers_at_load,
    numbers_of_limits,
)

PAPER = 72
"""Characters of a line on paper."""

_SHOWN_CORNERS = 4  # corners whose loads and forces are shown
_GAP = "  "  # between two columns
PAGES = ("At your load", "What grows with the load", "Limits")
"""Titles of the pages, in the order in which they are answered."""


class Section(NamedTuple):
    """A part of the text of a report. `units` maps columns of the table to names and units."""

    title: str
    sentences: list[str]
    table: pd.DataFrame | None = None
    picture: Plotted | None = None
    units: Mapping[str, tuple[str, str]] | None = None


def title_of(parts: ReportParts) -> str:
    """The title of a report: the given one, and its nodes, its friction and its units."""
    least, most = parts.friction.min(), parts.friction.max()
    friction = f"{least:g}" if least == most else f"{least:g} to {most:g}"
    nodes = "1 contact node" if parts.system.nodes == 1 else f"{parts.system.nodes} contact nodes"
    title = f"{parts.title}: joint" if parts.title else "Joint"
    title += f" of {nodes}, friction {friction}"
    if parts.system.orthotropic:
        title += ", another one along the second tangents"
    if parts.system.capped:
        title += " up to the shear strength of the surface"
    if parts.system.units is not None:
        title += f", in {parts.system.units}"
    return title


def loads_of(parts: ReportParts) -> str:
    """The loads of a report, the scatter of its input and what is not in its model."""
    mean = ", ".join(f"{name} = {value:.4g}" for name, value in parts.cycle.mean.items())
    names = parts.cycle.corner_names
    corners = [*names[:_SHOWN_CORNERS]]
    if len(names) > _SHOWN_CORNERS:
        corners.append("...")
    text = f"Mean load: {mean or 'none'}. Corners at load factor 1: {'; '.join(corners)}."
    if parts.scatter:
        text += f" Scatter: {parts.scatter}."
    if parts.notes:
        text += f" Not in the model: {parts.notes}."
    return text


def sections_of(parts: ReportParts, page: int) -> Iterator[Section]:
    """The sections of a page, 1 to 3, that are known."""
    yield from (_at_load, _with_load, _limits)[page - 1](parts)


def _at_load(parts: ReportParts) -> Iterator[Section]:
    yield Section("Advice", list(advice_on(parts)))
    if not parts.verdicts.empty:
        yield _verdicts(parts)
    yield Section("Kind of contact", [kind_of_contact(parts)])
    if parts.gross_slip is not None:
        yield Section("Gross slip", list(gross_slip_in_words(parts)))
    numbers = numbers_at_load(parts)
    if not numbers.empty:
        yield Section("Numbers", [], numbers)
    if parts.steady is not None:
        names = parts.cycle.corner_names
        contacts = parts.contacts
        sentences = []
        if len(names) <= _SHOWN_CORNERS:
            corners = "; ".join(f"{k}: {name}" for k, name in enumerate(names))
            along = " along the first tangents" if parts.system.orthotropic else ""
            sentences = [
                "P, Q and fP are pressure, shear and the most that friction can hold"
                f"{along}, at the corners {corners}."
            ]
        else:
            contacts = contacts.filter(regex=r"^(?!f?[PQ]_\d)")  # without forces
        yield Section(
            "Contacts at load factor 1",
            sentences,
            contacts,
            parts.steady,
            columns_with_units(parts, contacts),
        )


def _verdicts(parts: ReportParts) -> Section:
    """The verdicts, and their meaning."""
    sentence = (
        "Passed if the value is at most its limit; for gross slip, at least its limit. The margin "
        "is the limit over the value, with the estimated error of its work; of gross slip the "
        "value over the limit."
    )
    return Section("Verdicts at load factor 1", [sentence], verdicts_in_words(parts))


def verdicts_in_words(parts: ReportParts) -> pd.DataFrame:
    """The verdicts with words for `passed`; only scatter has inputs to be named."""
    table = parts.verdicts.assign(passed=np.where(parts.verdicts["passed"], "yes", "NO"))
    return table if parts.scatter else table.drop(columns="at")


def _with_load(parts: ReportParts) -> Iterator[Section]:
    if not parts.safety.empty:
        sentences = ["A safety factor is the number by which the cyclic load may grow."]
        for method in dict.fromkeys(parts.safety["by"]):
            against = parts.safety.loc[parts.safety["by"] == method, "against"]
            sentences.append(f"The worst of {' and of '.join(against)} is found {method}.")
        table = parts.safety.drop(columns="by")
        yield Section("Safety factors", sentences, table)
    if parts.curve is not None:
        table = curve_table(parts, parts.curve)
        sentence = (
            "work: of friction, per cycle; slipping: share of all contacts; slip_range: largest of "
            "all nodes; damping: ratio."
        )
        units = columns_with_units(parts, table)
        yield Section("What grows with the load", [sentence], table, parts.curve, units)


def _limits(parts: ReportParts) -> Iterator[Section]:
    numbers = numbers_of_limits(parts)
    if not numbers.empty:
        yield Section("Limits", [], numbers, parts.limit)
    if parts.missing:
        yield Section("Without an answer", missing_in_words(parts))


def missing_in_words(parts: ReportParts) -> list[str]:
    """A sentence for each reason, with the parts that lack an answer by it."""
    by_reason = dict[str, list[str]]()
    for name, reason in parts.missing.items():
        by_reason.setdefault(reason, []).append(name)
    return [f"{', '.join(names)}: {reason}" for reason, names in by_reason.items()]


def page_text(parts: ReportParts, page: int) -> str:
    """The text of a page, in lines of paper; "" if nothing on it is known."""
    lines = list[str]()
    for section in sections_of(parts, page):
        lines += ["", section.title, "-" * len(section.title)]
        lines += [fill(sentence, PAPER) for sentence in section.sentences]
        if section.table is None:
            continue
        if section.title in ("Numbers", "Limits"):
            lines += _lines_of_numbers(section.table)
        elif section.title.startswith("Verdicts"):
            lines += _lines_of_verdicts(section.table)
        else:
            lines += table_lines(section.table, section.units or {})
    return "\n".join(lines[1:])


def whole_text(parts: ReportParts) -> str:
    """The text of all pages."""
    pages = [page_text(parts, page) for page in range(1, len(PAGES) + 1)]
    head = f"{fill(title_of(parts), PAPER)}\n{fill(loads_of(parts), PAPER)}"
    return "\n\n".join([head, *filter(None, pages)])


def shown_page(parts: ReportParts, page: int, pages: int) -> str:
    """A page as it is shown when it is ready, with its number."""
    head = f"Page {page} of {pages}: {PAGES[page - 1].lower()}"
    if page == 1:
        head = f"{fill(title_of(parts), PAPER)}\n{fill(loads_of(parts), PAPER)}\n\n{head}"
    return f"{head}\n\n{page_text(parts, page) or 'Nothing is known.'}\n"


def _lines_of_numbers(numbers: pd.DataFrame) -> Iterator[str]:
    """Two texts for each number: its value, and its meaning."""
    for row in numbers.itertuples():
        yield f"{row.number}: {row.value:.5g} {row.unit}".rstrip()
        yield _indented(f"{row.meaning}. Converges with the mesh: {row.converges}.")


def _lines_of_verdicts(verdicts: pd.DataFrame) -> Iterator[str]:
    """Two texts for each verdict: the numbers, and the place."""
    for row in verdicts.to_dict("records"):
        passed = "passed" if row["passed"] == "yes" else "NOT PASSED"
        compared = f"{row['value']:.4g} against {row['limit']:.4g} {row['unit']}"
        yield f"{row['quantity']}: {compared}, margin {row['margin']:.3g}: {passed}"
        places = [row["where"], row.get("at", "")]
        if any(places):
            yield _indented("; ".join(filter(None, places)))


def _indented(text: str) -> str:
    return fill(text, PAPER, initial_indent="    ", subsequent_indent="    ")


def table_lines(table: pd.DataFrame, units: Mapping[str, tuple[str, str]]) -> Iterator[str]:
    """The lines of a table on paper; columns that do not fit follow below, after the first one.

    Units stand below the names of their columns.
    """
    columns = [_column(table, name, *units.get(name, (name, ""))) for name in table.columns]
    key, *others = columns
    block = [key]
    for column in others:
        if len(block) > 1 and _width([*block, column]) > PAPER:
            yield from _joined(block)
            yield ""
            block = [key]
        block.append(column)
    yield from _joined(block)


def _column(table: pd.DataFrame, name: str, title: str, unit: str) -> list[str]:
    """The cells of a column, all of one width: its title, its unit, and its values."""
    values = table[name]
    is_text = values.map(lambda value: isinstance(value, str)).any()
    cells = [_cell(value) for value in values]
    texts = [title, unit, *(_short(cell) for cell in cells)]
    width = max(map(len, texts))
    align: Callable[[str, int], str] = str.ljust if is_text else str.rjust
    return [align(text, width) for text in texts]


def _cell(value: str | float) -> str:
    """A value as text; a number that is not known is a dash."""
    if isinstance(value, str):
        return value
    return "-" if np.isnan(value) else f"{value:.4g}"


def _short(text: str) -> str:
    """A text of at most half a line."""
    most = PAPER // 2
    return text if len(text) <= most else f"{text[: most - 3]}..."


def _width(columns: list[list[str]]) -> int:
    return len(_GAP.join(column[0] for column in columns))


def _joined(columns: list[list[str]]) -> Iterator[str]:
    """The lines of columns beside each other, without an empty line of units."""
    for cells in zip(*columns, strict=True):
        line = _GAP.join(cells).rstrip()
        if line:
            yield line
