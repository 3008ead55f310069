"""The cards of Nastran's bulk data: small, large and free fields, continued lines, and INCLUDE."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..errors import ModelError
from .deck_text import check_includes, text_of

_INCLUDE = re.compile(r"\s*include\s+(.*)", re.IGNORECASE)


@dataclass(frozen=True)
class Card:
    """A card: its name in capital letters, and its fields; the last one is not blank."""

    name: str
    fields: list[str]

    def field(self, place: int) -> str:
        """A field, counted from 1 after the name; empty if it is blank."""
        return self.fields[place - 1] if place <= len(self.fields) else ""

    def __str__(self) -> str:
        return f"{self.name} {self.field(1)}".rstrip()


@dataclass(frozen=True)
class Line:
    """A line: its first field, its data fields, its last field, and what stands beyond."""

    first: str
    data: list[str]
    last: str
    rest: str
    is_large: bool

    @property
    def name(self) -> str:
        """Name of the card that begins here, in capital letters; empty for a continued card."""
        return "" if self.first[:1] in ("", "+", "*") else self.first.rstrip("*").upper()


def cards(path: Path, what: str, names: tuple[str, ...]) -> list[Card]:
    """The cards of some names in a file of bulk data and in the files that it includes.

    Everything before `BEGIN BULK` and after `ENDDATA` is left out.
    """
    where = f"{what} {path.name}"
    found: list[Card] = []
    # Name of a line -> the card that it continues.
    waiting: dict[str, Card] = {}
    card: Card | None = None
    previous = Line("", [], "", "", is_large=False)
    for text in _bulk_data(list(_lines(path, what, path.parent, [])), where):
        line = split(text)
        if line.first.startswith("="):
            raise ModelError(f"{where}: the line {text!r} repeats the card above; write each card")
        if line.name:
            card = Card(line.name, [])
            found.append(card)
        elif _names_another(line, previous):
            card = waiting.get(line.first[1:])
            if card is None:
                raise ModelError(
                    f"{where}: the line {text!r} continues no card above it; sort the lines"
                )
        elif previous.is_large and not line.first:
            # Results in a punch file begin with blanks.
            card = None
        if card is None:
            continue
        card.fields.extend(line.data)
        if line.rest and card.name in names:
            raise ModelError(
                f"{where}: {card} has a line of more than ten fields, {text!r}; "
                "continue it on the next line"
            )
        waiting[line.last[1:]] = card
        previous = line
    return [_without_blanks_at_end(card) for card in found if card.name in names]


def _names_another(line: Line, previous: Line) -> bool:
    """Whether a line that continues a card names another line than the previous one."""
    return line.first[1:] not in ("", previous.last[1:])


def _without_blanks_at_end(card: Card) -> Card:
    count = max((i for i, field in enumerate(card.fields, start=1) if field), default=0)
    return Card(card.name, card.fields[:count])


def split(text: str) -> Line:
    """The fields of a line.

    A line with a comma has free fields. Otherwise a field has 8 characters, or 16 if the first one
    has an asterisk.
    """
    has_commas = "," in text
    first = (text.split(",")[0] if has_commas else text[:8]).strip()
    count = 4 if "*" in first else 8
    if has_commas:
        fields = [field.strip() for field in text.split(",")[1:]]
    else:
        width = 64 // count
        starts = range(8, 72, width)
        fields = [text[start : start + width].strip() for start in starts] + [text[72:80].strip()]
    fields += [""] * (count + 1 - len(fields))
    rest = "".join(fields[count + 1 :])
    return Line(first, fields[:count], fields[count], rest, count == 4)


def _bulk_data(lines: list[str], where: str) -> list[str]:
    """The lines after `BEGIN BULK`, if there is one, as far as `ENDDATA`."""
    words = [line.split(maxsplit=1)[0].upper() for line in lines]
    end = words.index("ENDDATA") if "ENDDATA" in words else len(lines)
    begins = [i for i in range(end) if words[i] == "BEGIN"]
    if len(begins) > 1:
        raise ModelError(
            f"{where}: several parts, which may use the same numbers: "
            f"{', '.join(lines[i].strip() for i in begins)}; give the bulk data of one part"
        )
    return lines[begins[0] + 1 if begins else 0 : end]


def _lines(
    path: Path, what: str, root: Path, included_files: list[str], depth: int = 0
) -> Iterator[str]:
    """The lines of a file without comments; those of an included file stand in its place."""
    check_includes(path, what, included_files, depth)
    if not path.is_file():
        raise ModelError(f"{what}: there is no file {str(path)!r}; give its path")
    lines = iter(text_of(path, what).expandtabs().splitlines())
    for line in lines:
        include = _INCLUDE.match(line)
        if include is None:
            card = line.partition("$")[0].rstrip()
            if card:
                yield card
            continue
        name = _included_file(include[1], lines)
        # A name is relative to its file; one with folders may be relative to the first file.
        beside = path.parent / name
        file = beside if beside.is_file() else root / name
        yield from _lines(file, what, root, included_files, depth + 1)


def _included_file(words: str, lines: Iterator[str]) -> str:
    """The name of an included file; one in quotes may go on on the next lines."""
    quote = words[0]
    if quote not in "'\"":
        return words.partition("$")[0].strip()
    name = words[1:].strip()
    while quote not in name:
        following = next(lines, quote)
        name += following.strip()
    return name.partition(quote)[0]


def number_in(field: str) -> float:
    """The value of a field, such as 1.5, 1.5E-3, 1.5D-3 or 1.5-3; 0 if it is blank."""
    text = (field or "0").upper().replace("D", "E")
    return float(re.sub(r"(?<=[\d.])(?=[+-])", "E", text))


def free_fields(bulk: list[Card]) -> str:
    """The text of cards in free fields, eight on a line."""
    lines = []
    for card in bulk:
        for i in range(0, len(card.fields), 8):
            name = card.name if i == 0 else ""
            lines.append(",".join([name, *card.fields[i : i + 8]]))
    return "\n".join(lines) + "\n"
