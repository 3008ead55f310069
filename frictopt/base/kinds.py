"""The classes of results, and of their parts, that files keep: each class registers itself."""

from typing import Any, TypeVar

T = TypeVar("T")

KINDS: dict[str, Any] = {}
"""Name -> class of all values, besides numbers, texts and tables, that a file of a result holds.
"""


def kept(kind: type[T]) -> type[T]:
    """Register a class whose values are kept in files of results, by the names of its fields.

    A class may have three attributes for its files. `KEPT_FIELDS` are the fields that a file holds,
    if the other fields follow from them. `from_kept` then makes a value from a mapping of the kept
    fields. `check_kept` checks a value that was read from a file, and raises a ValueError if
    something is wrong.
    """
    KINDS[kind.__name__] = kind
    return kind
