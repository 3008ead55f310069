"""The commands `look`, `compare` and `check`, on files alone."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.files import write_table
from .answers import add_outputs, give, print_json, write_picture
from .inputs import joint_of, system_of
from .options import Command, public

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from ..base import Table
    from ..contact import ContactSystem


def _add_look(look: argparse.ArgumentParser) -> None:
    look.add_argument("file", help="SYSTEM.npz of ContactSystem.save, a deck, or a joint file")
    add_outputs(look, picture=True, save=False)
    look.set_defaults(run=_look, units=None)


def _add_check(check: argparse.ArgumentParser) -> None:
    check.add_argument("file", help="a result, a contact, the store of a study, or a JSON report")
    check.set_defaults(run=_check)


def _add_compare(compare: argparse.ArgumentParser) -> None:
    compare.add_argument("files", nargs="+", help="JSON reports; differences are from the first")
    add_outputs(compare, picture=True)
    compare.set_defaults(run=_compare)


LOOK = Command(
    "look",
    "the content of a file: a contact system, a deck, or a joint file",
    "joint.npz --picture joint.png",
    _add_look,
)
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


def _look(options: argparse.Namespace) -> None:
    file = options.file
    joint = joint_of(options)
    system = joint.system() if joint else system_of(file, None)
    sums = _sums(system)
    if options.picture:
        write_picture(options.picture, system.plot)
    if options.table:
        write_table(options.table, sums)
    if options.json:
        shown = (joint or system)._answer()
        about = {"file": file, "units": system.units, **shown}
        print_json(options, {"answer": about, "tables": {"sums": sums}})
        return
    sums_in_words = sums.to_string(index=False, float_format="{:.5g}".format)
    print(joint or system, sums_in_words, sep="\n")
    if joint:
        print(f"next: frictopt report {file} {joint.suggestion}")
        return
    cases = list(system.bonded)
    print(
        f"next: frictopt report {file} --mean {cases[0]}=1 "
        f"--corners {cases[-1]}=-1 {cases[-1]}=1 --friction 0.5"
    )


def _sums(system: ContactSystem) -> Table:
    """Sums of the bonded reactions of each load case, and extreme normal forces.

    If the tangents of a contact turn, the sums are components in x, y, z. Sums that are only
    rounding are zero.
    """
    import numpy as np

    from ..base import ROUNDING, frame

    size = system.tangents + 1
    if np.ptp(system.frames, axis=0).max() > ROUNDING:
        axes = system.frames
        names = ["sum in x", "sum in y", "sum in z"][:size]
    else:
        axes = np.eye(size)[None]
        names = ["sum of q", "sum of p"] if size == 2 else ["sum of q1", "sum of q2", "sum of p"]
    rows = []
    for q, p in system.bonded.values():
        forces = np.c_[q, p]  # (N, size), along the axes of each node
        sums = (forces[:, :, None] * axes).sum(axis=(0, 1))
        rows.append([*sums, p.min(), p.max()])
    table = np.array(rows)
    table[np.abs(table) <= ROUNDING * np.abs(table).max(axis=1, keepdims=True)] = 0.0
    columns = dict(zip([*names, "least p", "most p"], table.T, strict=True))
    return frame({"load case": list(system.bonded), **columns})


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
