"""Pictures of results, behind their `.plot()`; matplotlib comes with the extra `figures` and is imported with the first picture."""

from collections.abc import Callable
from contextlib import nullcontext
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from ..contact import choice
from ..errors import ModelError

if TYPE_CHECKING:  # matplotlib need not be installed
    from matplotlib.axes import Axes

    from ..contact import Table
    from .style import AxesArray

__all__ = ["plot_study"]

_NEEDED = ("friction", "friction_std", "friction_number", "cycle", "load_factor", "load_ratio", "family", "outcome", "dissipation", "engine")


def draw(result: object, ax: "Axes | AxesArray | None" = None, kind: str = "", **options: object) -> "Axes | AxesArray":
    """Draw a result in the given axes, which keep their style, or in those of a new figure, and return the axes.

    Its picture, or another `kind`: the "status" of the nodes of a trajectory, fields in "deformed" bodies, a "mode", the table of a "study".

    Raises
    ------
    ImportError
        matplotlib is not installed.
    ModelError
        `ax` is not as many axes as the picture has panels.
    """
    try:
        import matplotlib.pyplot
    except ImportError as error:
        raise ImportError("plots need matplotlib: python -m pip install 'frictopt[figures]'") from error
    from . import bodies, histories, limits, transients  # each registers its pictures
    from .style import name_units, picture, screen

    with nullcontext() if ax is not None else screen():
        others: dict[str, Callable[..., Axes | AxesArray]]
        others = {"status": transients.node_status, "deformed": bodies.deformed, "mode": bodies.mode, "study": histories.runs_of}
        drawn = others.get(kind, picture)(result, ax, **options)
    name_units(np.ravel(np.asarray(drawn, dtype=object))[0], _units(result))
    return drawn


def png(result: object) -> bytes:
    """The picture of a result as a PNG file; its figure is closed."""
    from matplotlib import pyplot

    figure, file = np.ravel(np.asarray(draw(result), dtype=object))[0].figure, BytesIO()
    figure.savefig(file, format="png", dpi=120)
    pyplot.close(figure)
    return file.getvalue()


def _units(result: object) -> str | None:
    """The units of a result, those of its system or of what it holds; None if they are not known."""
    if hasattr(result, "attrs"):  # a table
        known: str | None = result.attrs.get("units")
        return known
    for name in ("units", "system", "least_state"):
        if (part := getattr(result, name, None)) is not None:
            return part if isinstance(part, str) else _units(part)
    return None


def plot_study(
    table: "Table", ax: "Axes | AxesArray | None" = None, *, x: str | None = None, colour: str | None = None, rows: str | None = None
) -> "Axes | AxesArray":
    """Draw the steady dissipation of each run of a study against its load: a mark for each start, by family.

    Columns of the table, of your own too, split it: `plot_study(table, x="cycle", colour="friction", rows="load_factor")`. Runs that shake down have
    no dissipation and stand in a strip at the bottom. Runs that failed have no mark; the title counts them.

    Parameters
    ----------
    table
        What `dissipation_study` returned, or rows of it.
    ax
        matplotlib axes to draw in, one for each panel; None: those of a new figure.
    x
        Column along the horizontal axis; None: the load factor, over the shakedown limit where all runs have one that is finite.
    colour
        Column that has a colour for each value; None: friction where there are several, else the load cycle, else the family of the starts.
    rows
        Column that has a panel for each value; None: one panel.

    Returns
    -------
    matplotlib.axes.Axes
        With `rows` an array of them.

    Raises
    ------
    ModelError
        No such table or column, or not as many axes as panels.
    ImportError
        matplotlib is not installed.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> table = fo.dissipation_study(rod, cycle, 0.5, load_factors=[0.3, 1.0], starts=fo.starts.no_slip())
    >>> axes = fo.plot_study(table)
    >>> axes.get_yscale(), [text.get_text() for text in axes.get_legend().get_texts()]
    ('log', ['none'])
    """
    if any(name not in getattr(table, "columns", ()) for name in _NEEDED):
        raise ModelError(f"table: give the DataFrame of dissipation_study, with the columns {', '.join(_NEEDED)}")
    for name, column in (("x", x), ("colour", colour), ("rows", rows)):
        if column is not None:
            choice(name, column, list(table.columns))
    return draw(table, ax, "study", x=x, colour=colour, rows=rows)
