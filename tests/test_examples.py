"""Every public class and function of these rooms has an example in its docstring, and the example prints what it says."""

import doctest
import inspect
from importlib import import_module
from pkgutil import walk_packages

import pytest

import frictopt as fo

ROOMS = [import_module(f"frictopt.{room}") for room in ("contact", "reference", "fem", "limits", "transients", "histories", "spatial", "plots")]
FILES = [file.name for room in ROOMS for file in walk_packages(room.__path__, f"{room.__name__}.")]
PUBLIC = [getattr(room, name) for room in (*ROOMS, fo.starts) for name in room.__all__ if name != "starts"]


def is_warning(thing):
    return inspect.isclass(thing) and issubclass(thing, Warning)


@pytest.mark.parametrize("file", FILES)
def test_examples_print_what_they_say(file):
    assert doctest.testmod(import_module(file)).failed == 0


@pytest.mark.parametrize("thing", [thing for thing in PUBLIC if not is_warning(thing)], ids=lambda thing: thing.__name__)
def test_everything_public_has_an_example(thing):
    text = inspect.getdoc(thing)
    assert "\nExamples\n--------\n" in text and doctest.DocTestParser().get_examples(text)
