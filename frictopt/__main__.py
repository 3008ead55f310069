"""The command line: `frictopt look`, `condense`, `report`, `limit`, `study` and `merge`, from files to limits, tables and pictures.

Exit codes: 0 done, 2 bad input, 3 no answer that passes the checks, 4 a file that cannot be read or
written, 130 interrupted (Ctrl-C, SIGTERM), 141 nobody read its output to the end (`| head`).
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
_ROWS = 8  # of a table that is printed


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    try:
        with to_its_end():
            asked = _parser().parse_args(arguments)
            for name in ("file", "job", "history"):
                given = getattr(asked, name, None)
                if given and not any(
                    Path(given + ending).exists() for ending in ("", ".inp", ".sti")
                ):  # a job may go without ending
                    raise FileNotFoundError(f"there is no file {given!r}; give its path")
            for name, endings in (
                ("table", WRITERS),
                ("picture", ()),
                ("system", (".npz",)),
                ("page", (".html",)),
            ):
                if getattr(asked, name, None):
                    setattr(asked, name, output(getattr(asked, name), *endings))
            with warnings.catch_warnings():
                warnings.showwarning = lambda message, *_: print(
                    f"frictopt: warning: {message}", file=sys.stderr
                )
                asked.command(asked)
    except KeyboardInterrupt as interrupt:
        print(
            "frictopt: interrupted", *getattr(interrupt, "__notes__", []), sep="\n", file=sys.stderr
        )
        return 130
    except (FrictoptError, OSError, ImportError) as error:
        print(f"frictopt: error: {error}", file=sys.stderr)
        of_file = isinstance(error, StoreError) or isinstance(error.__cause__, OSError)
        return (
            4
            if of_file or not isinstance(error, FrictoptError)
            else 2
            if isinstance(error, ModelError)
            else 3
        )
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="frictopt", description="Decides whether a frictional contact will stop slipping."
    )
    parser.add_argument("--version", action="version", version=f"frictopt {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(function: Any, about: str, example: str) -> argparse.ArgumentParser:
        made = commands.add_parser(
            function.__name__.lstrip("_"),
            help=about,
            description=about,
            epilog=f"example: frictopt {example}",
        )
        made.set_defaults(command=function)
        return made

    look = command(
        _look,
        "what a file holds: a contact system, or a job of CalculiX",
        "look punch.npz --picture punch.png",
    )
    look.add_argument(
        "file", help="SYSTEM.npz as ContactSystem.save writes it, or JOB.inp of CalculiX"
    )
    condense = command(
        _condense,
        "condense a job of CalculiX to a contact system",
        "condense job.inp job.npz --contact N_PUNCH N_BLOCK --load P=N_TOP:pressure=1 Q=N_TOP:traction=1,0",
    )
    condense.add_argument(
        "job", help="JOB.inp, beside the JOB.sti and JOB.dof that CalculiX writes"
    )
    condense.add_argument("system", help="SYSTEM.npz to be written")
    condense.add_argument(
        "--contact",
        nargs=2,
        required=True,
        metavar="SET",
        help="node sets of the faces of body 1 and body 2",
    )
    condense.add_argument(
        "--load",
        nargs="+",
        required=True,
        metavar="CASE=SET:KIND=X[,Y]",
        help="KIND: traction, pressure, total or nodal",
    )
    report = command(
        _report,
        "what there is to know of a joint under its loads, as text and as one page with pictures",
        "report flange.npz --mean preload=1 --corners shear=1 shear=-1 --friction .15 --page flange.html",
    )
    limit = command(
        _limit,
        "a limit of a contact system: its load factor, its reason, its table and picture",
        "limit punch.npz --mean P=1 --corners sigma=-1 sigma=1 --friction .4 --picture limit.png",
    )
    for one in (report, limit):
        one.add_argument("file", help="SYSTEM.npz")
        one.add_argument(
            "--mean",
            type=_loads,
            metavar="CASE=X[,CASE=X]",
            help="static load (default: none; of a history the middle of each load)",
        )
        cycle = one.add_mutually_exclusive_group(required=True)
        cycle.add_argument(
            "--corners",
            nargs="+",
            type=_loads,
            metavar="CASE=X[,CASE=X]",
            help="corners of the load cycle, in their order",
        )
        cycle.add_argument(
            "--history",
            metavar="FILE",
            help="measured history instead: csv, xlsx or parquet, a column for each load case",
        )
        one.add_argument(
            "--tolerance",
            type=float,
            metavar="X",
            help="noise of the history, as a share of the range of each load case (default: 0)",
        )
        one.add_argument(
            "--time",
            metavar="COLUMN",
            help="time of the history, which is no load (default: the column of that name)",
        )
        one.add_argument("--friction", type=float, required=True, help="coefficient of friction")
    limit.add_argument(
        "--kind", choices=_KINDS, default="shakedown", help="which limit (default: %(default)s)"
    )
    report.add_argument(
        "--load-factors",
        nargs="+",
        type=float,
        metavar="X",
        help="load factors of its curve (default: 1/4, 1/2, 1, 2)",
    )
    report.add_argument("--page", metavar="FILE", help="write the report with its pictures: html")
    study = command(
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
    study.add_argument(
        "--store",
        help="file that keeps each finished run (default: the store of STUDY.toml, else STUDY.sqlite)",
    )
    study.add_argument(
        "--workers", type=int, default=1, help="number of processes (default: %(default)s)"
    )
    for one in (limit, study):
        one.add_argument("--table", metavar="FILE", help=f"write the table: {', '.join(WRITERS)}")
    for one in (look, limit, study):
        one.add_argument("--picture", metavar="FILE", help="draw the picture: png, pdf, svg")
    merge = command(
        _merge,
        "write the runs of several stores into one",
        "merge study.sqlite study.*-of-50.sqlite",
    )
    merge.add_argument("into", help="the store to be written, or added to")
    merge.add_argument("parts", nargs="+", help="stores to read")
    return parser


def _look(asked: argparse.Namespace) -> None:
    if (
        Path(asked.file).suffix in (".inp", ".sti", ".mas", ".dof")
        or not Path(asked.file).is_file()
    ):
        if asked.picture:
            raise ModelError(
                f"--picture: {str(asked.picture)!r} of a job; condense it, and look at the system that it becomes"
            )
        job = _job(asked.file)
        print(
            job,
            *(f"faces that match: {len(pairs)} pairs" for pairs in job.matching_faces()),
            sep="\n",
        )
        print(
            f"next: frictopt condense {asked.file} SYSTEM.npz --contact SET_1 SET_2 --load CASE=SET:pressure=1"
        )
        return
    from .contact import ContactSystem

    system = ContactSystem.load(asked.file)
    _written(asked.picture, system.plot)
    print(system, _sums(system).to_string(index=False, float_format="{:.5g}".format), sep="\n")
    mean, *_, cyclic = [*system.bonded, *system.bonded]
    print(
        f"next: frictopt report {asked.file} --mean {mean}=1 --corners {cyclic}=-1 {cyclic}=1 --friction 0.5"
    )


def _job(file: str, *faces: str) -> "MatrixJob":
    """A job of CalculiX, in which the nodes amid edges of contact faces follow the corners, as `condense` needs it."""
    from .readers.calculix_abaqus import read_calculix

    job = read_calculix(file)
    return job.with_linear_faces(*faces) if len(getattr(job.deck, "midsides", ())) else job


def _condense(asked: argparse.Namespace) -> None:
    from .fem.condense import condense

    job = _job(asked.job, *asked.contact)
    loads: dict[str, Any] = {}
    for text in asked.load:
        case, face, kind, numbers = _load_parts(text)
        try:
            loads[case] = loads.get(case, 0.0) + job.force(
                face, **{kind: numbers[0] if kind == "pressure" and len(numbers) == 1 else numbers}
            )
        except ModelError as error:
            raise ModelError(f"--load {text}: {error}") from error
    pairs = job.pairs(*asked.contact)
    normals, width = job.normals(pairs[:, 1]), job.areas(pairs[:, 1])
    system = condense(
        job.K,
        loads,
        pairs,
        normals,
        job.unknowns,
        job.points,
        generalised=job.generalised,
        width=width,
    )
    system.save(asked.system)
    print(system)


def _cycle(asked: argparse.Namespace) -> "LoadCycle":
    """The load cycle of corners, or of a history."""
    from .contact import LoadCycle
    from .study.plans import read_table

    if asked.history:
        return LoadCycle.from_history(
            read_table(asked.history),
            mean=asked.mean,
            time=asked.time,
            tolerance=asked.tolerance or 0.0,
        )
    if asked.tolerance is not None:
        raise ModelError(
            f"--tolerance: {asked.tolerance:g}; corners have no noise: leave it out, or give a --history"
        )
    if asked.time is not None:
        raise ModelError(
            f"--time: {asked.time!r}; corners have no time: leave it out, or give a --history"
        )
    return LoadCycle(asked.mean or {}, asked.corners)


def _report(asked: argparse.Namespace) -> None:
    from .contact import ContactSystem
    from .joints.report import report

    found = report(
        ContactSystem.load(asked.file), _cycle(asked), asked.friction, asked.load_factors
    )
    print(found)
    if asked.page:
        found.save(asked.page)


def _limit(asked: argparse.Namespace) -> None:
    from . import contact, limits, transients

    system, question, cycle = (
        contact.ContactSystem.load(asked.file),
        _KINDS[asked.kind],
        _cycle(asked),
    )
    found = getattr(transients if asked.kind == "onset" else limits, question)(
        system, cycle, asked.friction
    )
    table = found.to_frame()
    try:
        _written(asked.picture, found.plot, asked.table, table)
    finally:
        print(found)
        print(table.head(_ROWS).to_string(index=False, float_format="{:.5g}".format))
        if len(table) > _ROWS and not asked.table:
            print(f"... {len(table)} rows in all; --table FILE writes them")


def _study(asked: argparse.Namespace) -> None:
    from concurrent.futures import ProcessPoolExecutor
    from contextlib import nullcontext
    from functools import partial
    from multiprocessing import get_context

    from .base import whole_number
    from .study.dissipation import dissipation_study
    from .study.plans import read_plan
    from .study.plot_study import plot_study

    question, files = read_plan(asked.file)
    store = Path(asked.store or files["store"])
    if asked.shard:
        store = store.with_suffix(f".{'-of-'.join(map(str, asked.shard))}{store.suffix}")
    workers = whole_number("--workers", asked.workers, least=1)
    with (
        nullcontext()
        if workers == 1
        else ProcessPoolExecutor(workers, get_context("spawn")) as pool
    ):
        table = dissipation_study(**question, shard=asked.shard, executor=pool, store=store)
    if asked.shard is None:
        picture, file = asked.picture or files.get("picture"), asked.table or files.get("table")
        _written(picture, partial(plot_study, table), file, table)
    by = ["friction", *["cycle"] * (table["cycle"].nunique() > 1), "load_factor", "outcome"]
    print(table.groupby(by).size().rename("runs").reset_index().to_string(index=False))
    print(f"kept in {store}")


def _merge(asked: argparse.Namespace) -> None:
    from .study.store import merge_stores

    print(f"{merge_stores(asked.into, asked.parts)} runs in {asked.into}")


def _sums(system: "ContactSystem") -> "Table":
    """Sums of the bonded reactions of each load case, of contacts that turn in x, y, z, zero where only rounding is left; extreme normal forces."""
    import numpy as np

    from .base import ROUNDING, frame

    turns = np.ptp(system.frames, axis=0).max() > ROUNDING
    names = ["sum of q"] if system.tangents == 1 else ["sum of q1", "sum of q2"]
    names = [
        *(
            ["sum in x", "sum in y", "sum in z"][: system.tangents + 1]
            if turns
            else [*names, "sum of p"]
        ),
        "least p",
        "most p",
    ]
    seen = system.frames if turns else np.eye(system.tangents + 1)[None]
    rows = np.array(
        [
            [*(np.c_[q, p][:, :, None] * seen).sum(axis=(0, 1)), p.min(), p.max()]
            for q, p in system.bonded.values()
        ]
    )
    rows[np.abs(rows) <= ROUNDING * np.abs(rows).max(axis=1, keepdims=True)] = 0.0
    return frame({"load case": list(system.bonded), **dict(zip(names, rows.T, strict=True))})


def _written(
    picture: Path | None, plot: Callable[[], Any], file: Path | None = None, table: Any = None
) -> None:
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
            f"--load: {text!r}; give CASE=SET:KIND=NUMBERS with the kind traction, pressure, total or nodal, such as P=N_TOP:pressure=1"
        ) from error


def _shard(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(number) for number in text.split("/"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r}; give K/N, such as 3/50") from error


if __name__ == "__main__":
    sys.exit(main())
