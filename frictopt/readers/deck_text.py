"""The text of decks of CalculiX and Abaqus: their blocks, and the entries of a line."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from ..errors import ModelError

# Most files that a deck may include. Twelve files that include each other could be 12^8.
_MOST_FILES = 1_000


@dataclass(frozen=True)
class Block:
    """A keyword with its parameters, and the data lines below it.

    Keyword, names and values of parameters are in capital letters; keyword and names lack blanks.
    """

    keyword: str
    parameters: Mapping[str, str]
    lines: list[str]
    # file and line of the keyword
    place: str = ""

    def __str__(self) -> str:
        pairs = [f"{name}={value}" if value else name for name, value in self.parameters.items()]
        return f"*{self.keyword} {', '.join(pairs)}".rstrip()

    @property
    def title(self) -> str:
        """Words for the block in messages: its file, line and keyword line."""
        return f"{self.place}: {self}"

    @property
    def rows(self) -> list[list[str]]:
        """The entries of each data line that are not empty."""
        return [fields(line) for line in self.lines]


def blocks(path: Path) -> Iterator[Block]:
    """The blocks of a deck, in order; those of an included file stand in its place."""
    lines = list(_lines(path, path.parent, []))
    starts = [i for i, (line, _) in enumerate(lines) if line.startswith("*")]
    if not starts:
        raise ModelError(
            f"deck {path.name}: no line begins with `*`; give a deck, as a text in UTF-8 or ASCII"
        )
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        yield _block(lines[start:end])


def _block(placed_lines: list[tuple[str, str]]) -> Block:
    lines = [line for line, _ in placed_lines]
    head = lines[0][1:]
    first = 1
    while head.endswith(",") and first < len(lines) and _has_parameters(lines[first]):
        head += lines[first]
        first += 1

    keyword, *parts = head.split(",")
    parameters = {}
    for part in filter(None, map(str.strip, parts)):
        name, _, value = part.partition("=")
        parameters[_without_blanks(name)] = value.strip().strip('"').upper()
    return Block(_without_blanks(keyword), parameters, lines[first:], placed_lines[0][1])


def _has_parameters(line: str) -> bool:
    """Whether a line after a comma continues the keyword line.

    Abaqus continues keyword lines in this way. CalculiX ignores a comma at the end of one.
    """
    return "=" in line or line.split(",")[0].strip().upper() == "GENERATE"


def _lines(
    path: Path, folder: Path, included_files: list[str], depth: int = 0
) -> Iterator[tuple[str, str]]:
    """The lines of a deck that are no comments, each with its file and number.

    The lines of an included file stand in its place, where they may continue the block above. Its
    name is relative to the folder of the whole deck, as in CalculiX, or to the file that includes.
    """
    check_includes(path, "deck", included_files, depth)
    stripped = enumerate(map(str.strip, text_of(path, "deck").splitlines()), start=1)
    lines = ((line, n) for n, line in stripped if line and not line.startswith("**"))
    for line, number_of_line in lines:
        if _without_blanks(line.split(",")[0]) != "*INCLUDE":
            yield line, f"{path.name}, line {number_of_line}"
            continue
        # The name of the file may stand on the line below the keyword.
        parameters = line if "=" in line else next(lines, ("", 0))[0]
        name = _included_file(parameters)
        included = folder / name
        if not included.is_file():
            included = path.parent / name
        yield from _lines(included, folder, included_files, depth + 1)


def check_includes(path: Path, what: str, included_files: list[str], depth: int) -> None:
    """Add a file to those that a deck includes; ModelError if there is no end of them."""
    if depth > 20:
        raise ModelError(f"{what} {path.name}: it includes itself; take the INCLUDE out")
    included_files.append(path.name)
    if len(included_files) > _MOST_FILES:
        raise ModelError(
            f"{what} {path.name}: more than {_MOST_FILES} INCLUDE in all files; join files"
        )


def _included_file(parameters: str) -> str:
    for part in parameters.split(","):
        name, _, file = part.partition("=")
        if _without_blanks(name) == "INPUT":
            return file.strip(' "')
    return ""


def _without_blanks(words: str) -> str:
    return "".join(words.split()).upper()


def entries(line: str) -> list[str]:
    """The entries of a data line, empty ones too."""
    return [entry.strip().strip('"') for entry in line.split(",")]


def fields(line: str) -> list[str]:
    """The entries of a data line that are not empty."""
    return [entry for entry in entries(line) if entry]


def number(entry: str) -> float:
    """The value of an entry, with an exponent of E or D."""
    return float(entry.upper().replace("D", "E"))


def text_of(path: Path, what: str) -> str:
    """Text of a file, without a byte-order mark."""
    try:
        return path.read_text(encoding="utf-8-sig", errors="replace")
    except (OSError, ValueError) as error:
        raise ModelError(
            f"{what}: {str(path)!r} cannot be read ({error}); give the path of a file"
        ) from error
