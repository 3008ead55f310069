"""The commands `check` and `compare`: files are read and proven again, or compared."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from pathlib import Path

from .answers import add_outputs, give
from .options import Command, public


def _add_check(check: argparse.ArgumentParser) -> None:
    check.add_argument("file", help="a result, a contact, the store of a study, or a JSON report")
    check.set_defaults(run=_check)


def _add_compare(compare: argparse.ArgumentParser) -> None:
    compare.add_argument("files", nargs="+", help="JSON reports; differences are from the first")
    add_outputs(compare, picture=True)
    compare.set_defaults(run=_compare)


COMMANDS = (
    Command(
        "compare",
        "the numbers of several reports in one table, with their differences and the best",
        "today.json M12.json --picture variants.png",
        _add_compare,
    ),
    Command(
        "check",
        "read a file and prove it again; say which version wrote it, when, for which input",
        "limit.npz",
        _add_check,
    ),
)


def _compare(options: argparse.Namespace) -> int:
    answer = public("compare")({file.removesuffix(".json"): file for file in options.files})
    request = {"command": "compare", "files": options.files}
    return give(options, answer, {"numbers": answer.table}, request, ())


def _check(options: argparse.Namespace) -> None:
    file = Path(options.file)
    with file.open("rb") as opened:
        is_store = opened.read(6) == b"SQLite"
    if is_store:
        lines = _of_store(file)
    elif file.suffix.lower() == ".json":
        lines = _of_json(file)
    else:
        lines = _of_archive(file)
    print(*lines, sep="\n")


def _of_archive(file: Path) -> Iterator[str]:
    from ..base.files import origin
    from ..contact import ContactSystem
    from ..contact.files import is_contact

    if is_contact(file):
        yield f"{ContactSystem.load(file)!r}"
    else:
        result = public("results.load")(file)
        yield str(result)
        for name in ("system", "cycle", "friction"):
            if hasattr(result, name):
                yield f"{name}: {getattr(result, name)!r}"
    yield f"{file}: holds, {origin(file)}"


def _of_store(file: Path) -> Iterator[str]:
    from ..base import number_of
    from ..study.case import KEY
    from ..study.store import DamagedRows, read_store

    with warnings.catch_warnings():
        warnings.simplefilter("error", DamagedRows)
        runs = read_store(file)
    contacts = runs["key"].str[:KEY].rename("contact")
    for (version, contact), rows in runs.groupby(["version", contacts]):
        outcomes = rows["outcome"].value_counts().to_dict()
        least, most = rows["friction"].min(), rows["friction"].max()
        text = f"{number_of(len(rows), 'run')} of version {version}, contact {contact}"
        yield f"{text}, friction {least:g} to {most:g}: {outcomes}"
    yield f"{file}: holds, {number_of(len(runs), 'run')}"


def _of_json(file: Path) -> Iterator[str]:
    from ..base.files import unsealed

    sheet = unsealed(file)
    yield from (sheet["title"], sheet["loads"])
    yield f"{file}: holds, of version {sheet['version']}, {sheet['date']}"
