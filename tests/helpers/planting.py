"""Planted faults: one changed expression or statement, found by syntax.

A formatter therefore does not lose a fault. Each room has its list in `tests/ROOM/faults.txt`: after
the name of each file its faults, one paragraph each, as in a patch:

    == contact/law.py

    friction pulls [law_check shakedown]
    @ Law.bound
    - friction * pressure
    + -friction * pressure

`tests/tools/mutants.py` plants the faults one at a time.
"""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

TESTS = Path(__file__).parents[1]
_HEAD = re.compile(r"(?P<meaning>.+) \[(?P<tests>.+)\]")


class Fault(NamedTuple):
    """A fault that a reviewer would fear.

    `file` is a path in the package, or a path that begins with "studies". `old` and `new` are one
    expression each, or statements. `old` stands once in the file, or once in the function or class
    `within`, such as "Scene._checked". `tests` are names of test files without "test_", each alone
    or with a test, such as "limit_kinds compiled::test_an_infeasible_program".
    """

    file: str
    meaning: str
    old: str
    new: str
    tests: str
    within: str = ""


def faults() -> list[Fault]:
    """All faults of all rooms."""
    texts = [path.read_text(encoding="utf-8") for path in sorted(TESTS.glob("*/faults.txt"))]
    return [fault for text in texts for fault in listed(text)]


def listed(text: str) -> Iterator[Fault]:
    """The faults of a list."""
    file = ""
    for paragraph in text.strip().split("\n\n"):
        first, *lines = paragraph.splitlines()
        if first.startswith("== "):
            file = first.removeprefix("== ")
            continue
        head = _HEAD.fullmatch(first)
        if head is None or any(line[:2] not in ("@ ", "- ", "+ ") for line in lines):
            raise ValueError(f"this is no planted fault, see {__file__}:\n{paragraph}")
        within, old, new = (
            "\n".join(line[2:] for line in lines if line[0] == mark) for mark in "@-+"
        )
        yield Fault(file, head["meaning"], old, new, head["tests"], within)


def planted(source: str, fault: Fault) -> str | None:
    """The text of a file with the fault; None if `old` does not stand there exactly once."""
    scope = _scope(_parsed(source), fault.within)
    if scope is None:
        return None
    wanted = ast.parse(fault.old).body
    if len(wanted) == 1 and isinstance(wanted[0], ast.Expr):
        places = list(_expressions(scope, wanted[0].value))
    else:
        places = list(_statements(scope, wanted))
    if len(places) != 1:
        return None
    return _replaced(source, places[0], fault.new)


@cache
def _parsed(source: str) -> ast.Module:
    """The syntax of a file, read once for all its faults."""
    return ast.parse(source)


def _scope(tree: ast.AST, within: str) -> ast.AST | None:
    """The function or class of a dotted name; the whole file for an empty one."""
    scope: ast.AST | None = tree
    for name in filter(None, within.split(".")):
        inside = [node for node in _walk(scope) if isinstance(node, ast.FunctionDef | ast.ClassDef)]
        scope = next((node for node in inside if node.name == name), None)
        if scope is None:
            return None
    return scope


@cache
def _walk(node: ast.AST) -> list[ast.AST]:
    """A node and all nodes below it, in the order of the file, listed once for all faults in it.

    Texts with braces count as a whole, because Python 3.11 does not know places in them.
    """
    listed = []
    ahead = [node]
    while ahead:
        node = ahead.pop()
        listed.append(node)
        if not isinstance(node, ast.JoinedStr):
            ahead += reversed(list(ast.iter_child_nodes(node)))
    return listed


def _expressions(scope: ast.AST, wanted: ast.expr) -> Iterator[list[ast.AST]]:
    kind, text = type(wanted), ast.unparse(wanted)
    for node in _walk(scope):
        if type(node) is kind and ast.unparse(node) == text:
            yield [node]


def _statements(scope: ast.AST, wanted: list[ast.stmt]) -> Iterator[list[ast.AST]]:
    texts = [ast.unparse(statement) for statement in wanted]
    for node in _walk(scope):
        for name in ("body", "orelse", "finalbody"):
            block = getattr(node, name, None)
            # The body of a lambda is an expression.
            if not isinstance(block, list):
                continue
            for first in range(len(block) - len(wanted) + 1):
                run = block[first : first + len(wanted)]
                if [ast.unparse(statement) for statement in run] == texts:
                    yield run


def _replaced(source: str, run: list[ast.AST], new: str) -> str:
    """The source with the nodes of a run replaced by a text."""
    # Columns of nodes are counted in bytes.
    lines = source.encode().splitlines(keepends=True)
    first, last = run[0], run[-1]
    begin = sum(map(len, lines[: first.lineno - 1])) + first.col_offset
    end = sum(map(len, lines[: last.end_lineno - 1])) + last.end_col_offset
    if isinstance(first, ast.expr):
        text = f"({new})"
    else:
        text = new.replace("\n", "\n" + " " * first.col_offset)
    whole = source.encode()
    return (whole[:begin] + text.encode() + whole[end:]).decode()
