"""The text of decks of CalculiX and Abaqus: their blocks, and the entries of a line.

Decks of Abaqus/CAE have parts, and their instances in an assembly. `flat` makes one flat deck of
them. Each instance gets moved copies of the nodes and elements of its part, with numbers of its
own. A set or surface S of the part becomes the set I.S of an instance I. The elements of an
instance I form the element set I.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ..base import Array
from ..errors import ModelError

# Largest number of includes in all files of a deck. The limit of their depth is not enough: files
# that include each other several times would be read for ever.
_MOST_FILES = 1_000


@dataclass(frozen=True)
class Block:
    """A keyword with its parameters, and the data lines below it.

    The keyword and the names and values of parameters are in capital letters; keyword and names
    have no blanks.
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


@contextmanager
def reading(block: Block) -> Iterator[None]:
    """While a block is read, give each error its file, its line and its keyword line."""
    try:
        yield
    except (KeyError, ValueError, IndexError) as error:
        why = str(error)
        if isinstance(error, KeyError):
            why = f"{error} is not in this deck"
        elif re.match("invalid literal|could not convert", why):
            # Python's message quotes the entry, which may be a line of any file that a deck
            # includes.
            why = "an entry is no number"
        raise ModelError(f"{block.title}: {why}") from error


def blocks(path: Path) -> Iterator[Block]:
    """The blocks of a deck in order; included blocks take the place of their *INCLUDE."""
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

    Abaqus continues keyword lines in this way. CalculiX ignores a comma at the end of a keyword
    line.
    """
    return "=" in line or line.split(",")[0].strip().upper() == "GENERATE"


def _lines(
    path: Path, folder: Path, included_files: list[str], depth: int = 0
) -> Iterator[tuple[str, str]]:
    """The lines of a deck that are not comments, each with its file and line number.

    The lines of an included file take the place of its *INCLUDE, and may continue the block above.
    The name of the file is relative to the folder of the whole deck, as in CalculiX, or to the
    folder of the file with the *INCLUDE.
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
    """Add a file to those that a deck includes; ModelError if the includes do not end."""
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


# Keyword -> its parameters that name a set or a surface.
_NAMES = {
    "NODE": ("NSET",),
    "ELEMENT": ("ELSET",),
    "NSET": ("NSET", "ELSET"),
    "ELSET": ("ELSET",),
    "SURFACE": ("NAME",),
    "SOLIDSECTION": ("ELSET",),
}


@dataclass(frozen=True)
class _Instance:
    """An instance: its name, blocks and place, and the offset of the numbers of its part."""

    name: str
    blocks: list[Block]
    offset: int
    move: Callable[[Array], Array]

    def flat(self) -> Iterator[Block]:
        """The blocks of the part, with the numbers and names of this instance."""
        for block in self.blocks:
            if block.keyword in _NAMES:
                parameters = dict(block.parameters)
                for name in _NAMES[block.keyword]:
                    if parameters.get(name):
                        parameters[name] = f"{self.name}.{parameters[name]}"
                yield replace(block, parameters=parameters, lines=[*self.lines(block)])
            else:
                yield block

    def lines(self, block: Block) -> Iterator[str]:
        """The lines of a block of the part, with the numbers and names of this instance."""
        for line in block.lines:
            if block.keyword == "NODE":
                yield self._moved(line)
            elif block.keyword == "SOLIDSECTION":
                yield line
            elif "GENERATE" in block.parameters:
                first, last, *step = fields(line)
                yield ", ".join([self.member(first), self.member(last), *step])
            elif block.keyword == "SURFACE" and "COMBINE" not in block.parameters:
                where, *face = entries(line)
                yield ", ".join([self.member(where), *face])
            else:
                # A comma at the end of a line shows that the element continues on the next line.
                yield ", ".join(self.member(entry) for entry in entries(line))

    def _moved(self, line: str) -> str:
        node, *place = entries(line)
        point = np.zeros(3)
        point[: len(place)] = [number(value or "0") for value in place]
        moved = self.move(point)
        return ", ".join([self.member(node), *(repr(float(value)) for value in moved)])

    def member(self, entry: str) -> str:
        """An entry of the part, a number or the name of a set, as it is in the assembly."""
        if entry.isdecimal():
            return str(int(entry) + self.offset)
        return f"{self.name}.{entry.upper()}" if entry else entry


def flat(blocks: Iterable[Block]) -> Iterator[Block]:
    """The blocks of a flat deck: an instance is replaced by its nodes and elements.

    ModelError: a part or an instance is not known, or has no end.
    """
    all_blocks = list(blocks)
    if not any(block.keyword == "INSTANCE" for block in all_blocks):
        yield from all_blocks
        return
    parts: dict[str, list[Block]] = {}
    outside: list[Block] = []
    for head, inside in _sections(all_blocks, "PART"):
        if head is None:
            outside += inside
        else:
            parts[head.parameters.get("NAME", "")] = inside
    largest = _largest(all_blocks)
    # The first instance keeps the numbers of its part.
    step = 10 ** len(str(largest))
    element_sets = {block.parameters.get("ELSET") for block in outside}
    instances: dict[str, _Instance] = {}
    for head, inside in _sections(outside, "INSTANCE"):
        if head is None:
            yield from (_of_assembly(block, instances) for block in inside)
            continue
        instance = _instance(head, [*_part_of(head, parts), *inside], step * len(instances))
        instances[instance.name] = instance
        yield from instance.flat()
        if instance.name not in element_sets:
            members = f"{instance.offset + 1}, {instance.offset + largest}"
            yield Block("ELSET", {"ELSET": instance.name, "GENERATE": ""}, [members])


def _sections(blocks: Iterable[Block], keyword: str) -> Iterator[tuple[Block | None, list[Block]]]:
    """The sections from a keyword to its *END: of each, the first block and all further blocks.

    A block outside of all sections is a section of its own, with None as its first block.
    """
    head: Block | None = None
    inside: list[Block] = []
    for block in blocks:
        is_begin = block.keyword == keyword
        if head is None and is_begin:
            head, inside = block, []
        elif head is None:
            yield None, [block]
        elif block.keyword == f"END{keyword}":
            yield head, inside
            head = None
        elif is_begin:
            break
        else:
            inside.append(block)
    if head is not None:
        raise ModelError(
            f"{head.title} has no *END {keyword}, so that its content is unknown; write one"
        )


def _part_of(head: Block, parts: dict[str, list[Block]]) -> list[Block]:
    part = head.parameters.get("PART", "")
    if part not in parts or not head.parameters.get("NAME"):
        raise ModelError(
            f"{head.title} has no name, or its part {part!r} is not in this deck; "
            "write the parts into it"
        )
    return parts[part]


def _largest(blocks: list[Block]) -> int:
    """The largest number of a node or an element."""
    largest = 1
    for block in blocks:
        if block.keyword in ("NODE", "ELEMENT"):
            firsts = (entries(line)[0] for line in block.lines)
            largest = max([largest, *(int(first) for first in firsts if first.isdecimal())])
    return largest


def _instance(head: Block, blocks: list[Block], offset: int) -> _Instance:
    """The instance of a block *INSTANCE: one line has its shift, the next an axis and an angle."""
    with reading(head):
        values = [[number(entry) for entry in row] for row in head.rows]
    shift = np.zeros(3)
    if values:
        shift[: len(values[0])] = values[0]
    if len(values) < 2:
        return _Instance(head.parameters["NAME"], blocks, offset, lambda point: point + shift)
    if len(values[1]) != 7:
        raise ModelError(
            f"{head.title} turns by {len(values[1])} numbers; give two points of the "
            "axis and an angle"
        )
    start = np.array(values[1][:3])
    axis = np.array(values[1][3:6]) - start
    # The shift comes first: the points of the axis are places in the assembly.
    turn = Rotation.from_rotvec(np.radians(values[1][6]) * axis / np.linalg.norm(axis))

    def move(point: Array) -> Array:
        return np.asarray(start + turn.apply(point + shift - start))

    return _Instance(head.parameters["NAME"], blocks, offset, move)


def _of_assembly(block: Block, instances: dict[str, _Instance]) -> Block:
    """A block of the assembly, with numbers of the instances that the block or its entries name."""
    if block.keyword in ("NSET", "ELSET") and "INSTANCE" in block.parameters:
        instance = instances.get(block.parameters["INSTANCE"])
        if instance is None:
            raise ModelError(f"{block.title} names an unknown instance; repair it")
        # Only the lines of the block belong to the instance; its name belongs to the assembly.
        return replace(block, lines=[*instance.lines(block)])

    def numbered(match: re.Match[str]) -> str:
        owner = instances.get(match[1].upper())
        return owner.member(match[2]) if owner else match[0]

    return replace(block, lines=[_ENTRY.sub(numbered, line) for line in block.lines])


# A node or element of an instance, such as Part-1-1.17.
_ENTRY = re.compile(r"([^\s,.]+)\.(\d+)(?=\s*(?:,|$))")
