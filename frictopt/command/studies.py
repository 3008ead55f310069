"""Commands on studies: `study` and `merge`."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.files import write_table
from .answers import ExitCode, add_outputs, print_json, write_picture
from .options import Command

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from ..base import Table


def _add_study(study: argparse.ArgumentParser) -> None:
    study.add_argument("file", help="STUDY.toml")
    study.add_argument(
        "--shard",
        type=_shard,
        metavar="K/N",
        help="follow part K of N, with a separate store, without table and picture",
    )
    store = "file that keeps each run (default: the store of STUDY.toml, else STUDY.sqlite)"
    study.add_argument("--store", help=store)
    workers = "number of processes (default: %(default)s)"
    study.add_argument("--workers", type=int, default=1, help=workers)
    add_outputs(study, picture=True, save=False)
    study.set_defaults(run=_study)


def _add_merge(merge: argparse.ArgumentParser) -> None:
    merge.add_argument("into", help="the store to write or to extend")
    merge.add_argument("parts", nargs="+", help="stores to read")
    merge.set_defaults(run=_merge)


COMMANDS = (
    Command(
        "study",
        "the study of a file: many transients, as one table",
        "study.toml --shard 3/50",
        _add_study,
    ),
    Command(
        "merge",
        "write the runs of several stores into one",
        "study.sqlite study.*-of-50.sqlite",
        _add_merge,
    ),
)


def _study(options: argparse.Namespace) -> int:
    from ..base import number_of, whole_number
    from ..study.case import FAILED
    from ..study.dissipation import plot_study
    from ..study.plans import read_plan

    question, files = read_plan(options.file)
    store = Path(options.store or files["store"])
    if options.shard:
        part = "-of-".join(map(str, options.shard))
        store = store.with_suffix(f".{part}{store.suffix}")
    workers = whole_number("--workers", options.workers, least=1)
    table = _followed(question, options.shard, workers, store)
    if options.shard is None:
        file = options.table or files.get("table")
        if file:
            write_table(file, table)
        picture = options.picture or files.get("picture")
        if picture:
            write_picture(picture, partial(plot_study, table))
    if options.json:
        answer = {"runs": len(table), "failed": int((table["outcome"] == FAILED).sum())}
        request = {"command": "study", "file": options.file, "store": str(store)}
        print_json(options, {"question": request, "answer": answer, "tables": {"runs": table}})
    else:
        columns = ["friction", "cycle", "load_factor", "outcome"]
        if table["cycle"].nunique() <= 1:
            columns.remove("cycle")
        print(table.groupby(columns).size().rename("runs").reset_index().to_string(index=False))
        print(f"kept in {store}")
    failed = table[table["outcome"] == FAILED]
    if failed.empty:
        return 0
    first = failed.iloc[0]
    print(
        f"frictopt: {len(failed)} of {number_of(len(table), 'run')} FAILED; the first: load factor "
        f"{first.load_factor:g}, friction {first.friction:g}, start {first.start!r}: {first.error}",
        file=sys.stderr,
    )
    return ExitCode.NO_ANSWER


def _followed(question: dict[str, Any], shard: Any, workers: int, store: Path) -> Table:
    """The table of a study; an interrupt gets a text on the number of runs that the store keeps."""
    from threadpoolctl import threadpool_limits

    from ..study.dissipation import dissipation_study

    executor = workers if workers > 1 else None
    try:
        # With one BLAS thread, one process and several give the same digits.
        with threadpool_limits(1):
            return dissipation_study(**question, shard=shard, executor=executor, store=store)
    except KeyboardInterrupt as interrupt:
        table = getattr(interrupt, "table", None)
        if table is not None:
            total = len(table) + table.attrs["missing"]
            interrupt.printed_text = (  # type: ignore[attr-defined]
                f"{len(table)} of {total} runs kept in {store}; the same command continues"
            )
        raise


def _merge(options: argparse.Namespace) -> None:
    from ..study.store import merge_stores

    print(f"{merge_stores(options.into, options.parts)} runs in {options.into}")


def _shard(text: str) -> tuple[int, ...]:
    """The part K of N: "3/50"."""
    try:
        return tuple(int(number) for number in text.split("/"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r}; give K/N, such as 3/50") from error
