"""Every public class and function of these rooms has an example in its docstring;
`--doctest-modules` runs them all."""

import doctest
import inspect
from importlib import import_module
from pkgutil import iter_modules

import pytest

import frictopt as fo

ROOMS = [
    import_module(f"frictopt.{room.name}")
    for room in iter_modules(fo.__path__)
    if room.ispkg and room.name not in ("scenes", "solve")
]
NAMES = [
    (room, name)
    for room in (*ROOMS, fo, fo.results, fo.starts)
    for name in getattr(room, "__all__", ())
]
PUBLIC = list(dict.fromkeys(getattr(room, name) for room, name in NAMES))


def has_example(thing):
    return not inspect.ismodule(thing) and not (
        inspect.isclass(thing) and issubclass(thing, Exception)
    )


@pytest.mark.parametrize(
    "thing", list(filter(has_example, PUBLIC)), ids=lambda thing: thing.__name__
)
def test_everything_public_has_an_example(thing):
    text = inspect.getdoc(thing)
    assert "\nExamples\n--------\n" in text and doctest.DocTestParser().get_examples(text)
