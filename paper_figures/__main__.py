"""Draw the figures: `python -m paper_figures [name ...] [--quick] [--workers N] [--list]`.

If data is missing, or has other parameters or another version of frictopt, it is computed first, on
all processors. Tables of times come after the others, alone. Finished tables are kept, so the same
command continues after an interrupt.
"""

import argparse
import os
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, cast

import pandas as pd
from matplotlib.figure import Figure

from frictopt.base import progress_bar
from frictopt.base.files import to_its_end
from studies.tables import INTERRUPTED, Table, data_folder, whole_number, writable

from . import style
from .prepare import prepare


class Script(Protocol):
    """The interface of a script of this folder."""

    __doc__: str | None
    TABLES: Mapping[str, Table[Any]]

    def draw(self, tables: Mapping[str, pd.DataFrame]) -> Figure:
        """Draw the figure from its tables."""


_NAMES = """
scene onset shakedown_limit traction_ratio cycle hysteresis increments guaranteed_limit slip_plane dissipation shakedown_share amplitude two_states
dissipation_range least_slip limit_after_protocol separation moving_areas fatigue_band damping_backbone damping_friction backbone_meshes wear design all_sets
error_vs_time mesh_error extremes scenes joint space spatial_limit spatial_numerics published
"""
FIGURES: dict[str, Script] = {
    name: cast(Script, import_module(f"{__package__}.{name}")) for name in _NAMES.split()
}


def make(
    name: str, *, quick: bool = False, data: Path | None = None, output: Path | None = None
) -> list[Path]:
    """Draw one figure, compute the tables that it lacks, and return the paths of its files.

    Parameters
    ----------
    name
        One of `FIGURES`.
    quick
        Use the quick data.
    data, output
        Folders of the tables and of the figures; by default those of the repository.
    """
    script = FIGURES[name]
    folder = data or data_folder(quick)
    tables = {
        key: table.load(table.parameters(quick), folder) for key, table in script.TABLES.items()
    }
    with progress_bar(True, f"drawing {name}"), style.styled():
        return style.save(script.draw(tables), name, output or style.output_folder(quick))


def main(argv: Sequence[str] | None = None) -> int:
    """Draw the named figures, all without names, and print their paths; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m paper_figures", description="Draw the figures of the paper's scene."
    )
    parser.add_argument(
        "names",
        nargs="*",
        metavar="name",
        help=f"figures to draw, all by default: {', '.join(FIGURES)}",
    )
    parser.add_argument("--quick", action="store_true", help="from quick data on coarse meshes")
    parser.add_argument(
        "--workers",
        type=whole_number(1),
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes; by default one for each processor",
    )
    parser.add_argument("--list", action="store_true", help="list the figures and draw none")
    parser.add_argument("--data", type=writable, metavar="FOLDER", help="folder of the tables")
    parser.add_argument("--output", type=writable, metavar="FOLDER", help="folder of the figures")
    options = parser.parse_args(argv)
    unknown = [name for name in options.names if name not in FIGURES]
    if unknown:
        print(
            f"unknown figure {', '.join(map(repr, unknown))}; known are {', '.join(FIGURES)}",
            file=sys.stderr,
        )
        return 2
    if options.list:
        print(
            *(
                f"{name:16} {(FIGURES[name].__doc__ or '').splitlines()[0]}"
                for name in options.names or FIGURES
            ),
            sep="\n",
        )
        return 0
    try:
        folders = (
            options.data or writable(data_folder(options.quick)),
            options.output or writable(style.output_folder(options.quick)),
        )
        names = options.names or list(FIGURES)
        if options.workers > 1:
            prepare(
                (table for name in names for table in FIGURES[name].TABLES.values()),
                options.quick,
                folders[0],
                options.workers,
            )
        for number, name in enumerate(names, start=1):
            print(f"figure {number} of {len(names)}: {name}", file=sys.stderr, flush=True)
            print(
                *make(name, quick=options.quick, data=folders[0], output=folders[1]),
                sep="\n",
                flush=True,
            )
    except KeyboardInterrupt:
        print("interrupted; finished tables and figures are kept", file=sys.stderr)
        return INTERRUPTED
    except (OSError, argparse.ArgumentTypeError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    with to_its_end():
        raise SystemExit(main())
