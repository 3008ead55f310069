"""The command line: `frictopt look`, `condense`, `report`, `limit`, `study` and `merge`.

It leads from files to limits, tables and pictures. Exit codes: 0 done, 2 bad input, 3 no answer
that passes the checks, 4 a file that cannot be read or written, 130 interrupted (Ctrl-C, SIGTERM),
141 nobody read its output to the end (`| head`).
"""

import argparse
import re
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import __version__
from .base.files import WRITERS, output, to_its_end
from .errors import FrictoptError, ModelError, StoreError

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from .base import Table
    from .contact import ContactSystem, LoadCycle
    from .readers.job import MatrixJob

_KINDS = {"shakedown": "shakedown_limit", "guaranteed": "guaranteed_limit", "onset": "onset"}
# Rows of a table that are printed.
_ROWS = 8
# Arguments that name a file to be written -> the endings that it may have; of none: any.
_OUTPUTS: dict[str, tuple[str, ...]] = {
    "table": tuple(WRITERS),
    "picture": (),
    "system": (".npz",),
    "page": (".html",),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    try:
        with to_its_end():
            options = _parser().parse_args(arguments)
            _check_files(options)
            with warnings.catch_warnings():
                warnings.showwarning = lambda message, *_: print(
                    f"frictopt: warning: {message}", file=sys.stderr
                )
                options.command(options)
    except KeyboardInterrupt as interrupt:
        notes = getattr(interrupt, "__notes__", [])
        print("frictopt: interrupted", *notes, sep="\n", file=sys.stderr)
        return 130
    except (FrictoptError, OSError, ImportError) as error:
        print(f"frictopt: error: {error}", file=sys.stderr)
        return _exit_code(error)
    return 0


def _exit_code(error: Exception) -> int:
    of_file = isinstance(error, StoreError) or isinstance(error.__cause__, OSError)
    if of_file or not isinstance(error, FrictoptError):
        return 4
    return 2 if isinstance(error, ModelError) else 3


def _check_files(options: argparse.Namespace) -> None:
    """Check the files to be read and to be written before anything is computed."""
    for name in ("file", "job", "history"):
        file = getattr(options, name, None)
        # A job may go without ending.
        if file and not any(Path(file + ending).exists() for ending in ("", ".inp", ".sti")):
            raise FileNotFoundError(f"there is no file {file!r}; give its path")
    for name, endings in _OUTPUTS.items():
        file = getattr(options, name, None)
        if file:
            setattr(options, name, output(file, *endings))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="frictopt", description="Decides whether a frictional contact will stop slipping."
    )
    parser.add_argument("--version", action="version", version=f"frictopt {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    look = _command(
        commands,
        _look,
        "what a file holds: a contact system, or a job of CalculiX",
        "look punch.npz --picture punch.png",
    )
    look.add_argument("file", help="SYSTEM.npz of ContactSystem.save, or JOB.inp of CalculiX")
    _add_condense(commands)
    report = _command(
        commands,
        _report,
        "what there is to know of a joint under its loads, as text and as one page with pictures",
        "report flange.npz --mean preload=1 --corners shear=1 shear=-1 --friction .15 "
        "--page flange.html",
    )
    limit = _command(
        commands,
        _limit,
        "a limit of a contact system: its load factor, its reason, its table and picture",
        "limit punch.npz --mean P=1 --corners sigma=-1 sigma=1 --friction .4 --picture limit.png",
    )
    for command in (report, limit):
        _add_cycle(command)
    kinds = "which limit (default: %(default)s)"
    limit.add_argument("--kind", choices=_KINDS, default="shakedown", help=kinds)
    factors = "load factors of its curve (default: 1/4, 1/2, 1, 2)"
    report.add_argument("--load-factors", nargs="+", type=float, metavar="X", help=factors)
    report.add_argument("--page", metavar="FILE", help="write the report with its pictures: html")
    study = _add_study(commands)
    for command in (limit, study):
        tables = ", ".join(WRITERS)
        command.add_argument("--table", metavar="FILE", help=f"write the table: {tables}")
    for command in (look, limit, study):
        command.add_argument("--picture", metavar="FILE", help="draw the picture: png, pdf, svg")
    merge = _command(
        commands,
        _merge,
        "write the runs of several stores into one",
        "merge study.sqlite study.*-of-50.sqlite",
    )
    merge.add_argument("into", help="the store to be written, or added to")
    merge.add_argument("parts", nargs="+", help="stores to read")
    return parser


def _command(commands: Any, function: Any, about: str, example: str) -> argparse.ArgumentParser:
    """A command with the name of its function."""
    command: argparse.ArgumentParser = commands.add_parser(
        function.__name__.lstrip("_"),
        help=about,
        description=about,
        epilog=f"example: frictopt {example}",
    )
    command.set_defaults(command=function)
    return command


def _add_condense(commands: Any) -> None:
    condense = _command(
        commands,
        _condense,
        "condense a job of CalculiX to a contact system",
        "condense job.inp job.npz --contact N_PUNCH N_BLOCK --load P=N_TOP:pressure=1 "
        "Q=N_TOP:traction=1,0",
    )
    condense.add_argument("job", help="JOB.inp, beside JOB.sti and JOB.dof of CalculiX")
    condense.add_argument("system", help="SYSTEM.npz to be written")
    sets = "node sets of the faces of body 1 and body 2"
    condense.add_argument("--contact", nargs=2, required=True, metavar="SET", help=sets)
    load, kinds = "CASE=SET:KIND=X[,Y]", "KIND: traction, pressure, total or nodal"
    condense.add_argument("--load", nargs="+", required=True, metavar=load, help=kinds)


def _add_cycle(command: argparse.ArgumentParser) -> None:
    """A contact system, its load cycle, from corners or a history, and its friction."""
    loads: dict[str, Any] = {"type": _loads, "metavar": "CASE=X[,CASE=X]"}
    mean = "static load (default: none; of a history the middle of each load)"
    command.add_argument("file", help="SYSTEM.npz")
    command.add_argument("--mean", help=mean, **loads)
    cycle = command.add_mutually_exclusive_group(required=True)
    cycle.add_argument(
        "--corners", nargs="+", help="corners of the load cycle, in their order", **loads
    )
    cycle.add_argument(
        "--history",
        metavar="FILE",
        help="measured history instead: csv, xlsx or parquet, a column for each load case",
    )
    command.add_argument(
        "--tolerance",
        type=float,
        metavar="X",
        help="noise of the history, as a share of the range of each load case (default: 0)",
    )
    command.add_argument(
        "--time",
        metavar="COLUMN",
        help="time of the history, which is no load (default: the column of that name)",
    )
    command.add_argument("--friction", type=float, required=True, help="coefficient of friction")


def _add_study(commands: Any) -> argparse.ArgumentParser:
    study = _command(
        commands,
        _study,
        "the study of a file: many transients, as one table",
        "study study.toml --shard 3/50",
    )
    study.add_argument("file", help="STUDY.toml")
    study.add_argument(
        "--shard",
        type=_shard,
        metavar="K/N",
        help="follow the K-th of N parts, with a store of its own, without table and picture",
    )
    store = "file that keeps each run (default: the store of STUDY.toml, else STUDY.sqlite)"
    study.add_argument("--store", help=store)
    workers = "number of processes (default: %(default)s)"
    study.add_argument("--workers", type=int, default=1, help=workers)
    return study


def _look(options: argparse.Namespace) -> None:
    file = options.file
    if Path(file).suffix in (".inp", ".sti", ".mas", ".dof") or not Path(file).is_file():
        _look_at_job(options)
        return
    from .contact import ContactSystem

    system = ContactSystem.load(file)
    _write(options.picture, system.plot)
    print(system, _sums(system).to_string(index=False, float_format="{:.5g}".format), sep="\n")
    cases = list(system.bonded)
    print(
        f"next: frictopt report {file} --mean {cases[0]}=1 "
        f"--corners {cases[-1]}=-1 {cases[-1]}=1 --friction 0.5"
    )


def _look_at_job(options: argparse.Namespace) -> None:
    if options.picture:
        raise ModelError(
            f"--picture: {str(options.picture)!r} of a job; condense it, and look at the system "
            "that it becomes"
        )
    job = _job(options.file)
    print(job)
    for pairs in job.matching_faces():
        print(f"faces that match: {len(pairs)} pairs")
    print(
        f"next: frictopt condense {options.file} SYSTEM.npz --contact SET_1 SET_2 "
        "--load CASE=SET:pressure=1"
    )


def _job(file: str, *faces: str) -> "MatrixJob":
    """A job of CalculiX, in which the nodes amid edges of contact faces follow the corners."""
    from .readers.calculix_abaqus import read_calculix

    job = read_calculix(file)
    return job.with_linear_faces(*faces) if len(getattr(job.deck, "midsides", ())) else job


def _condense(options: argparse.Namespace) -> None:
    from .fem.condense import condense

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
    system.save(options.system)
    print(system)


def _cycle(options: argparse.Namespace) -> "LoadCycle":
    """The load cycle of corners, or of a history."""
    from .contact import LoadCycle
    from .study.plans import read_table

    if options.history:
        return LoadCycle.from_history(
            read_table(options.history),
            mean=options.mean,
            time=options.time,
            tolerance=options.tolerance or 0.0,
        )
    if options.tolerance is not None:
        raise ModelError(
            f"--tolerance: {options.tolerance:g}; corners have no noise: leave it out, or give a "
            "--history"
        )
    if options.time is not None:
        raise ModelError(
            f"--time: {options.time!r}; corners have no time: leave it out, or give a --history"
        )
    return LoadCycle(options.mean or {}, options.corners)


def _report(options: argparse.Namespace) -> None:
    from .contact import ContactSystem
    from .joints.report import report

    system = ContactSystem.load(options.file)
    answer = report(system, _cycle(options), options.friction, options.load_factors)
    print(answer)
    if options.page:
        answer.save(options.page)


def _limit(options: argparse.Namespace) -> None:
    from . import contact, limits, transients

    system = contact.ContactSystem.load(options.file)
    room = transients if options.kind == "onset" else limits
    question = getattr(room, _KINDS[options.kind])
    limit = question(system, _cycle(options), options.friction)
    table = limit.to_frame()
    try:
        _write(options.picture, limit.plot, options.table, table)
    finally:
        print(limit)
        print(table.head(_ROWS).to_string(index=False, float_format="{:.5g}".format))
        if len(table) > _ROWS and not options.table:
            print(f"... {len(table)} rows in all; --table FILE writes them")


def _study(options: argparse.Namespace) -> None:
    from concurrent.futures import ProcessPoolExecutor
    from contextlib import nullcontext
    from functools import partial
    from multiprocessing import get_context

    from .base import whole_number
    from .study.dissipation import dissipation_study
    from .study.plans import read_plan
    from .study.plot_study import plot_study

    question, files = read_plan(options.file)
    store = Path(options.store or files["store"])
    if options.shard:
        part = "-of-".join(map(str, options.shard))
        store = store.with_suffix(f".{part}{store.suffix}")
    workers = whole_number("--workers", options.workers, least=1)
    executor: Any = nullcontext()
    if workers > 1:
        executor = ProcessPoolExecutor(workers, get_context("spawn"))
    with executor as pool:
        table = dissipation_study(**question, shard=options.shard, executor=pool, store=store)
    if options.shard is None:
        picture = options.picture or files.get("picture")
        file = options.table or files.get("table")
        _write(picture, partial(plot_study, table), file, table)
    columns = ["friction", "cycle", "load_factor", "outcome"]
    if table["cycle"].nunique() <= 1:
        columns.remove("cycle")
    print(table.groupby(columns).size().rename("runs").reset_index().to_string(index=False))
    print(f"kept in {store}")


def _merge(options: argparse.Namespace) -> None:
    from .study.store import merge_stores

    print(f"{merge_stores(options.into, options.parts)} runs in {options.into}")


def _sums(system: "ContactSystem") -> "Table":
    """Sums of the bonded reactions of each load case, and extreme normal forces.

    Sums of contacts that turn are those in x, y, z. What is only rounding is zero.
    """
    import numpy as np

    from .base import ROUNDING, frame

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


def _write(
    picture: Path | None, plot: Callable[[], Any], file: Path | None = None, table: Any = None
) -> None:
    """Write a table and a picture, each if it has a file."""
    if file:
        getattr(table, WRITERS[file.suffix])(file, index=False)
    if picture:
        axes = plot()
        try:
            getattr(axes, "flat", [axes])[0].figure.savefig(picture, bbox_inches="tight")
        except ValueError as error:
            raise ModelError(f"--picture: {error}") from error


def _loads(text: str) -> dict[str, float]:
    """Loads of one corner: "P=1,Q=-0.5"."""
    parts = [part.rpartition("=") for part in text.split(",")]
    try:
        loads = {name: float(value) for name, _, value in parts}
    except ValueError:
        loads = {}
    if len(loads) < len(parts) or "" in loads:
        raise argparse.ArgumentTypeError(
            f"{text!r}; give CASE=AMPLITUDE, several with commas between"
        )
    return loads


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


def _shard(text: str) -> tuple[int, ...]:
    """The part K of N: "3/50"."""
    try:
        return tuple(int(number) for number in text.split("/"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r}; give K/N, such as 3/50") from error


if __name__ == "__main__":
    sys.exit(main())
