"""Commands on contacts and on jobs of CalculiX: `look` and `condense`."""

from __future__ import annotations

import argparse
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.files import write_table
from ..errors import ModelError
from .answers import print_json, write_picture
from .inputs import is_joint, system_of
from .options import Command

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from ..base import Table
    from ..contact import ContactSystem
    from ..readers.job import MatrixJob

# Endings of the files of a job of CalculiX.
_JOBS = (".inp", ".sti", ".mas", ".dof")


def _add_look(look: argparse.ArgumentParser) -> None:
    look.add_argument("file", help="SYSTEM.npz of ContactSystem.save, or DECK.inp, JOB.inp")
    look.add_argument("--json", action="store_true", help="print the sums of forces as JSON")
    look.add_argument(
        "--table", metavar="FILE", help="write the sums of forces: csv, xlsx, parquet"
    )
    look.add_argument("--picture", metavar="FILE", help="draw the picture: png, pdf, svg")
    look.set_defaults(run=_look)


def _add_condense(condense: argparse.ArgumentParser) -> None:
    condense.add_argument("job", help="JOB.inp, beside JOB.sti and JOB.dof of CalculiX")
    condense.add_argument("system", help="SYSTEM.npz to be written")
    sets = "node sets of the faces of body 1 and body 2"
    condense.add_argument("--contact", nargs=2, required=True, metavar="SET", help=sets)
    load, kinds = "CASE=SET:KIND=X[,Y]", "KIND: traction, pressure, total or nodal"
    condense.add_argument("--load", nargs="+", required=True, metavar=load, help=kinds)
    units = "names of the units of force and length, such as 'N, mm'"
    condense.add_argument("--units", metavar="NAMES", help=units)
    condense.set_defaults(run=_condense)


COMMANDS = (
    Command(
        "look",
        "the content of a file: a contact system, or a job of CalculiX",
        "joint.npz --picture joint.png",
        _add_look,
    ),
    Command(
        "condense",
        "condense a job of CalculiX to a contact system",
        "job.inp job.npz --contact N_PUNCH N_BLOCK --load P=N_TOP:pressure=1 "
        "Q=N_TOP:traction=1,0 --units 'N, mm'",
        _add_condense,
    ),
)


def _look(options: argparse.Namespace) -> None:
    file = options.file
    joint = None
    if is_joint(file):
        from ..joint_files.read_joint import read_joint

        joint = read_joint(file)
    elif Path(file).suffix in _JOBS or not Path(file).is_file():
        _look_at_job(options)
        return
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


def _look_at_job(options: argparse.Namespace) -> None:
    for name in ("picture", "table", "json"):
        value = getattr(options, name)
        if value:
            given = "" if value is True else f" {str(value)!r}"
            raise ModelError(
                f"--{name}:{given} cannot be used for a job; condense the job, and use the option "
                "for the system"
            )
    job = _job(options.file)
    print(job)
    for pairs in job.matching_faces():
        print(f"faces that match: {len(pairs)} pairs")
    print(
        f"next: frictopt condense {options.file} SYSTEM.npz --contact SET_1 SET_2 "
        "--load CASE=SET:pressure=1"
    )


def _job(file: str, *faces: str) -> MatrixJob:
    """A job of CalculiX in which midside nodes of contact faces follow the corner nodes."""
    from ..readers.calculix_abaqus import read_calculix

    job = read_calculix(file)
    return job.with_linear_faces(*faces) if len(getattr(job.deck, "midsides", ())) else job


def _condense(options: argparse.Namespace) -> None:
    from ..fem.condense import condense

    job = _job(options.job, *options.contact)
    loads: dict[str, Any] = {}
    for text in options.load:
        case, face, kind, numbers = _load_parts(text)
        one_pressure = kind == "pressure" and len(numbers) == 1
        try:
            force = job.force(face, **{kind: numbers[0] if one_pressure else numbers})
        except ModelError as error:
            raise ModelError(f"--load {text}: {error}") from error
        loads[case] = loads.get(case, 0.0) + force
    pairs = job.pairs(*options.contact)
    system = condense(
        job.K,
        loads,
        pairs,
        job.normals(pairs[:, 1]),
        job.unknowns,
        job.points,
        generalised=job.generalised,
        width=job.areas(pairs[:, 1]),
    )
    axisymmetric = getattr(job.deck, "is_axisymmetric", False)
    system = replace(system, units=options.units or None, axisymmetric=axisymmetric)
    system.save(options.system)
    print(system)


def _sums(system: ContactSystem) -> Table:
    """Sums of the bonded reactions of each load case, and extreme normal forces.

    If the tangents of a contact turn, the sums are components in x, y, z. What is only rounding is
    zero.
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


def _load_parts(text: str) -> tuple[str, str, str, list[float]]:
    """Load case, node set, kind and numbers: "P=N_TOP:pressure=1"."""
    try:
        ((case, face, kind, values),) = re.findall(
            r"^(.+?)=(.+):(traction|pressure|total|nodal)=(.+)$", text
        )
        return case, face, kind, [float(value) for value in values.split(",")]
    except ValueError as error:
        raise ModelError(
            f"--load: {text!r}; give CASE=SET:KIND=NUMBERS with the kind traction, pressure, total "
            "or nodal, such as P=N_TOP:pressure=1"
        ) from error
