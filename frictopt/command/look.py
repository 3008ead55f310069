"""The command `look`, on contacts, decks and joint files."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ..base.files import write_table
from .answers import print_json, write_picture
from .inputs import joint_of, system_of
from .options import Command

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from ..base import Table
    from ..contact import ContactSystem


def _add_look(look: argparse.ArgumentParser) -> None:
    look.add_argument("file", help="SYSTEM.npz of ContactSystem.save, a deck, or a joint file")
    look.add_argument("--json", action="store_true", help="print the sums of forces as JSON")
    look.add_argument(
        "--table", metavar="FILE", help="write the sums of forces: csv, xlsx, parquet"
    )
    look.add_argument("--picture", metavar="FILE", help="draw the picture: png, pdf, svg")
    look.set_defaults(run=_look, units=None)


COMMANDS = (
    Command(
        "look",
        "the content of a file: a contact system, a deck, or a joint file",
        "joint.npz --picture joint.png",
        _add_look,
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
