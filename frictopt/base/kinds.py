"""The classes of results, and of their parts, that files keep: each class registers itself."""

from typing import Any, TypeVar

T = TypeVar("T")

KINDS: dict[str, Any] = {}
"""Name -> class of all that a file of a result may hold beside numbers, texts and tables."""


def kept(kind: type[T]) -> type[T]:
    """Register a class whose values are kept in files of results, by the names of its fields."""
    KINDS[kind.__name__] = kind
    return kind
