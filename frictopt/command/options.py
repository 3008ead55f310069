"""Options of a command, made from the signature and the docstring of its function.

A parameter becomes an option with its name. The kind of the option follows from `_BY_NAME` if the
name is there, and otherwise from the annotation. Its help is the text of the docstring.
"""

import argparse
import inspect
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import frictopt

from .inputs import load_of, loads_of, numbers_of, ranges_of

# Parameters that a command supplies.
_SUPPLIED = ("system", "cycle", "friction", "progress")
# Parameters that are given in Python only: arrays and states of nodes.
_FOR_PYTHON = ("open_nodes", "initial_slip", "initial_state")

_BY_NAME: dict[str, dict[str, Any]] = {
    "slip_bound": {"type": numbers_of, "metavar": "X[,X]"},
    "load_factors": {"type": float, "nargs": "+", "metavar": "X"},
    "contacts": {"nargs": "+", "metavar": "NAME"},
    "preload": {"type": ranges_of, "metavar": "CASE=X[:X]|CASE=LAW:X[:X]"},
    "load": {"type": load_of, "metavar": "X:X|LAW:X[:X]"},
    "store": {"metavar": "FILE"},
    "limits": {"type": loads_of, "metavar": "NAME=X[,NAME=X]"},
}
_BY_KIND: dict[str, dict[str, Any]] = {
    "float": {"type": float, "metavar": "X"},
    "int": {"type": int, "metavar": "N"},
    "str": {"metavar": "WORD"},
}


@dataclass(frozen=True)
class Command:
    """A command: its name, its description, its example, and the function that adds its options."""

    name: str
    about: str
    example: str
    add_options: Callable[[argparse.ArgumentParser], None]


def public(name: str) -> Any:
    """A public name of frictopt, such as "gross_slip" or "results.load"."""
    attribute: Any = frictopt
    for part in name.split("."):
        attribute = getattr(attribute, part)
    return attribute


def add_options(
    parser: argparse.ArgumentParser, functions: Iterable[str], shared: bool = False
) -> None:
    """Add an option for each parameter of some public functions that can be written in a shell.

    With `shared`, no option is required, since the functions are alternatives.
    """
    known = set[str]()
    for name in functions:
        texts = described(public(name))
        for parameter in _written(public(name)):
            if parameter.name not in known:
                text = texts.get(parameter.name, "").replace("%", "%%")
                _add_option(parser, parameter, text, shared)
                known.add(parameter.name)


def arguments_of(function: str, options: argparse.Namespace) -> dict[str, Any]:
    """The arguments of a public function that were given as options."""
    return {
        parameter.name: getattr(options, f"of_{parameter.name}")
        for parameter in _written(public(function))
        if getattr(options, f"of_{parameter.name}", None) is not None
    }


def _written(function: Any) -> Iterator[inspect.Parameter]:
    """The parameters of a function that can be written in a shell."""
    for parameter in inspect.signature(function).parameters.values():
        if parameter.name in (*_SUPPLIED, *_FOR_PYTHON):
            continue
        if parameter.name in _BY_NAME or _kind(parameter) in ("bool", *_BY_KIND):
            yield parameter


def _kind(parameter: inspect.Parameter) -> str:
    """The annotation of a parameter in words, without `None`."""
    annotation = parameter.annotation
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return text.removesuffix(" | None")


def _add_option(
    parser: argparse.ArgumentParser, parameter: inspect.Parameter, text: str, shared: bool
) -> None:
    flag = parameter.name.replace("_", "-")
    value = f"of_{parameter.name}"
    default = parameter.default
    if _kind(parameter) == "bool":
        name = f"--no-{flag}" if default else f"--{flag}"
        about = f"Switch off: {text}" if default else text
        constant = not default
        parser.add_argument(name, dest=value, action="store_const", const=constant, help=about)
        return
    look = _BY_NAME.get(parameter.name) or _BY_KIND[_kind(parameter)]
    required = default is inspect.Parameter.empty and not shared
    if default not in (None, inspect.Parameter.empty, ()):
        text += f" (default: {default})"
    parser.add_argument(f"--{flag}", dest=value, required=required, help=text, **look)


_SECTION = re.compile(r"^Parameters\n-+\n(.*?)(?:\n\n\w[\w ]*\n-+\n|\Z)", re.MULTILINE | re.DOTALL)
_ENTRY = re.compile(r"^(\w+(?:, \w+)*)\n((?: {4}.*(?:\n|\Z)|\n)+)", re.MULTILINE)
_ELSEWHERE = re.compile(r"^(?:See|As in|As) `([\w.]+)`[^.;:]*[.;:]?\s*", re.DOTALL)
# If a parameter shares its text with `progress`, the words on the progress are cut off.
_ON_PROGRESS = re.compile(r",? and whether to show .*", re.DOTALL)


def described(function: Any) -> dict[str, str]:
    """Parameter -> its text in the docstring, on one line; "see `...`" is followed once."""
    texts = _entries(function)
    for name, text in texts.items():
        reference = _ELSEWHERE.match(text)
        if reference is None:
            continue
        try:
            there = _entries(public(reference[1]))
        except AttributeError:
            continue
        if name in there:
            texts[name] = f"{there[name]} {text[reference.end() :]}".strip()
    return texts


def _entries(function: Any) -> dict[str, str]:
    section = _SECTION.search(inspect.getdoc(function) or "")
    texts = dict[str, str]()
    for names, text in _ENTRY.findall(section[1] if section else ""):
        line = _ON_PROGRESS.sub(".", " ".join(text.split())).replace("None:", "If left out:")
        for name in names.split(", "):
            texts[name] = line
    return texts
