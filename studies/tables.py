"""Tables of the studies: their files, and the record of their origin."""

import argparse
import json
import os
import shlex
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.base import progress_bar

from .columns import COLUMNS
from .origin import commit, machine, source_digest

DATA = Path(__file__).parent / "data"
# Exit status after Ctrl-C, as in shells.
INTERRUPTED = 130
_LIBRARIES = ("numpy", "scipy", "cvxpy", "highspy", "clarabel", "osqp", "scikit-fem", "pandas")

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

# A row of a table, or a part of the table.
Row: TypeAlias = Mapping[str, Any] | pd.DataFrame
# Parameters of a study are a frozen dataclass of plain values.
P = TypeVar("P", bound="DataclassInstance")


def data_folder(quick: bool) -> Path:
    """Default folder of the tables; quick runs have another one."""
    return DATA / "quick" if quick else DATA


def writable(name: str | Path) -> Path:
    """A folder from the command line that can be written; it is created if it does not exist.

    Raises
    ------
    argparse.ArgumentTypeError
        The folder cannot be created, or cannot be written.
    """
    try:
        if not str(name) or "://" in str(name):
            raise ValueError("no name, or an address")
        folder = Path(name).expanduser()
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, ValueError, RuntimeError) as error:
        raise argparse.ArgumentTypeError(
            f"{str(name)!r} is no folder to write in ({error}); give one that exists or can be made"
        ) from error


def whole_number(least: int, most: int = 10**6) -> Callable[[str], int]:
    """Type of an option of the command line: a whole number in a range.

    Another value raises an `argparse.ArgumentTypeError`.
    """
    # A partial function can be sent to other processes together with its table.
    return partial(_whole_number, least, most)


def _whole_number(least: int, most: int, text: str) -> int:
    if not text.strip().isdecimal() or len(text) > 30 or not least <= int(text) <= most:
        raise argparse.ArgumentTypeError(
            f"{text!r}; give a whole number of at least {least} and at most {most}"
        )
    return int(text)


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    first, *others = (f"| {' | '.join(row)} |" for row in [head, *rows])
    return "\n".join([first, "|" + "---|" * len(head), *others])


def two_digits(value: float) -> str:
    """A number with two digits and no exponent."""
    return np.format_float_positional(value, precision=2, fractional=False, trim="-")


def described(columns: Mapping[str, str]) -> list[str]:
    """The columns that a table may take from a result: its own columns, and the shared columns."""
    return [*COLUMNS, *columns]


@dataclass(frozen=True)
class Table(Generic[P]):
    """One table of a study: its computation, the meaning of its columns, and its file.

    The file is parquet and carries in `attrs`: table, about, columns, parameters, versions,
    seconds, and the notes of `compute`. Only run times and these notes depend on the machine.

    Parameters
    ----------
    name
        Name of the file, without ending.
    about
        Meaning of a row.
    columns
        Column -> meaning and unit, for the columns of this table alone. Columns of `COLUMNS` may stand
        beside them.
    full, quick
        Parameters of the two sizes.
    compute
        Function of the parameters that returns the table, its rows, or parts of it. Its options, if
        any, are keywords.
    options
        Options of the computation that change only the times: name -> keywords of
        `ArgumentParser.add_argument`.
    alone
        Whether the table measures times, so that nothing else should run beside it.
    """

    name: str
    about: str
    columns: Mapping[str, str]
    full: P
    quick: P
    compute: Callable[..., pd.DataFrame | Iterable[Row]]
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    alone: bool = False

    def parameters(self, quick: bool) -> P:
        """Parameters of the quick or the full size."""
        return self.quick if quick else self.full

    def path(self, folder: Path) -> Path:
        """File that keeps the table."""
        return folder / f"{self.name}.parquet"

    def frame(self, parameters: P, **options: Any) -> pd.DataFrame:
        """Compute the table.

        Raises
        ------
        ValueError
            A column of the table is not computed, or a computed column has no description.
        """
        with progress_bar(True, f"table {self.name}", "part") as bar:
            found = self.compute(parameters, **options)
            if not isinstance(found, pd.DataFrame):
                rows = []
                for row in found:
                    rows.append(row)
                    bar.update()
                found = pd.concat(rows) if isinstance(rows[0], pd.DataFrame) else pd.DataFrame(rows)
        missing = set(self.columns) - set(found.columns)
        more = set(found.columns) - set(self._meanings)
        if missing or more:
            raise ValueError(
                f"table {self.name}: described columns {sorted(missing)} are not computed, "
                f"computed ones {sorted(more)} not described"
            )
        return found.reset_index(drop=True)

    def make(self, parameters: P, folder: Path, **options: Any) -> pd.DataFrame:
        """Compute the table and write it."""
        start = time.perf_counter()
        table = self.frame(parameters, **options)
        table.attrs = (
            table.attrs
            | self._origin(parameters, table)
            | {"seconds": round(time.perf_counter() - start, 3)}
        )
        _write(table, self.path(folder))
        return table

    def stored(self, parameters: P, folder: Path) -> pd.DataFrame | None:
        """The table in the file; None if it is missing, unreadable, or made with another origin.

        The origin is the parameters and the sources.
        """
        # There is no file, or the file is not parquet.
        try:
            table = pd.read_parquet(self.path(folder))
        except (OSError, ValueError):
            return None
        return table if _same_origin(table.attrs, self._origin(parameters, table)) else None

    def load(self, parameters: P, folder: Path) -> pd.DataFrame:
        """The stored table for these parameters, or else a new table."""
        table = self.stored(parameters, folder)
        return self.make(parameters, folder) if table is None else table

    @property
    def _meanings(self) -> dict[str, str]:
        return {**COLUMNS, **self.columns}

    def _origin(self, parameters: P, table: pd.DataFrame) -> dict[str, Any]:
        columns = {name: self._meanings.get(name) for name in table.columns}
        versions = {"frictopt": f"{fo.__version__}+{source_digest(self.compute.__module__)}"} | {
            name: version(name) for name in _LIBRARIES
        }
        origin = {
            "table": self.name,
            "about": self.about,
            "columns": columns,
            "parameters": asdict(parameters),
            "versions": versions,
        }
        # Tuples become lists, as in a file that is read back.
        return dict(json.loads(json.dumps(origin)))


@dataclass(frozen=True)
class Study:
    """One study: its tables, and the command line that computes them.

    Parameters
    ----------
    module
        Full name of its module; the last part is the name of the study.
    about
        Description of the study.
    quick
        Description of its quick size.
    tables
        Its tables.
    summary
        Function that returns the text that is printed after the tables, from the tables by name. The
        default prints nothing.
    picture
        Function that draws one picture into a folder, from the tables by name, and returns its file.
        The default draws nothing.
    needs
        Tables of other studies with which the summary compares. These tables are loaded, or
        computed first if they are missing.
    """

    module: str
    about: str | None
    quick: str
    tables: Sequence[Table[Any]]
    summary: Callable[[Mapping[str, pd.DataFrame]], str] | None = None
    picture: Callable[[Mapping[str, pd.DataFrame], Path], Path] | None = None
    needs: Sequence[Table[Any]] = ()

    @property
    def name(self) -> str:
        """Name of the study."""
        return self.module.rpartition(".")[2]

    def parser(self) -> argparse.ArgumentParser:
        """The options of the command line."""
        parser = argparse.ArgumentParser(
            prog=f"python -m studies {self.name}", description=self.about
        )
        parser.add_argument("--quick", action="store_true", help=self.quick)
        parser.add_argument(
            "--data",
            type=writable,
            metavar="FOLDER",
            help="where to write; by default studies/data, or studies/data/quick",
        )
        for name, keywords in {
            name: keywords for table in self.tables for name, keywords in table.options.items()
        }.items():
            parser.add_argument(f"--{name}", **keywords)
        if self.summary is not None:
            parser.add_argument(
                "--page",
                type=writable,
                metavar="FOLDER",
                help="write what is printed as NAME.md too, with the command that made it",
            )
        return parser

    def run(self, argv: Sequence[str] | None = None) -> int:
        """Compute all tables and write them; `argv` is the command line, by default of the process.

        Returns
        -------
        int
            The exit status: 0; 1 if a table or a run cannot be written; 130 after Ctrl-C.
        """
        arguments = list(sys.argv[1:] if argv is None else argv)
        options = self.parser().parse_args(arguments)
        try:
            folder = options.data or writable(data_folder(options.quick))
            made = self._make(options, folder)
            if self.picture is not None:
                print(self.picture(made, folder))
            if self.summary is not None:
                said = self.summary(
                    {
                        table.name: table.load(table.parameters(options.quick), folder)
                        for table in self.needs
                    }
                    | made
                )
                print(said)
                if options.page is not None:
                    (options.page / f"{self.name}.md").write_text(
                        f"{said.strip()}\n\n*{self._origin(arguments, made)}*\n", encoding="utf-8"
                    )
        except KeyboardInterrupt:
            print(
                f"{self.module}: interrupted; finished tables, and finished runs in a store, are "
                "kept",
                file=sys.stderr,
            )
            return INTERRUPTED
        except (OSError, argparse.ArgumentTypeError, fo.ModelError) as error:
            print(f"{self.module}: error: {error}", file=sys.stderr)
            return 1
        return 0

    def _origin(self, arguments: Sequence[str], made: Mapping[str, pd.DataFrame]) -> str:
        """Origin of a page: the command (without folders), the version, the commit, the time and the machine."""
        folders = argparse.ArgumentParser(add_help=False)
        folders.add_argument("--page")
        folders.add_argument("--data")
        folders.add_argument("--pythons", nargs="*")
        command = shlex.join(
            ["python", "-m", "studies", self.name, *folders.parse_known_args(arguments)[1]]
        )
        seconds = sum(table.attrs["seconds"] for table in made.values())
        code = ", ".join(filter(None, [f"frictopt {fo.__version__}", commit()]))
        return f"Made by `{command}`, {code}, in {seconds:.0f} s on {machine()}."

    def _make(self, options: argparse.Namespace, folder: Path) -> dict[str, pd.DataFrame]:
        made = {}
        for table in self.tables:
            own = {name: getattr(options, name) for name in table.options}
            made[table.name] = table.make(table.parameters(options.quick), folder, **own)
            rows, seconds = made[table.name], made[table.name].attrs["seconds"]
            print(
                f"{table.path(folder)}: {len(rows)} rows, worst residual "
                f"{rows['residual'].max():.1e}, {seconds:.1f} s"
            )
        return made


def _same_origin(found: Mapping[str, Any], wanted: Mapping[str, Any]) -> bool:
    """Whether a stored table is still valid; new versions of libraries alone keep it valid."""
    same = all(found.get(key) == wanted[key] for key in ("table", "columns", "parameters"))
    return same and found.get("versions", {}).get("frictopt") == wanted["versions"]["frictopt"]


def _write(table: pd.DataFrame, path: Path) -> None:
    """Write to a temporary file and rename it, so that no reader sees an incomplete table."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        table.to_parquet(temporary, index=False)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
