"""The picture of the runs of a study."""

from typing import TYPE_CHECKING

from ..base import Table, choice
from ..base.results import pictures_of
from ..errors import ModelError

if TYPE_CHECKING:  # matplotlib need not be installed
    from matplotlib.axes import Axes

_NEEDED = (
    "friction",
    "cycle",
    "load_factor",
    "family",
    "outcome",
    "dissipation",
    "engine",
)


def plot_study(
    table: "Table",
    ax: "Axes | None" = None,
    *,
    x: str | None = None,
    colour: str | None = None,
) -> "Axes":
    """Draw the steady dissipation of each run of a study against its load: a mark for each start.

    Columns of the table, also columns that you add, split it: `plot_study(table, x="cycle",
    colour="friction")`. Runs that shake down have no dissipation. Runs that failed or slide
    off have no mark; the title counts them.

    Parameters
    ----------
    table
        The table of `dissipation_study`, or rows of it.
    ax
        matplotlib axes to draw in; None: a new figure.
    x
        Column along the horizontal axis. None: the load factor, divided by the shakedown limit if
        the table has a finite limit for all runs; friction if all runs have one load factor.
    colour
        Column whose values have different colours. None: friction if it has several values,
        otherwise the load cycle, unless this column is along the horizontal axis; otherwise the
        family of the starts.

    Returns
    -------
    matplotlib.axes.Axes
        The axes of the picture.

    Raises
    ------
    ModelError
        The table, a column or `ax` is unsuitable.
    ImportError
        matplotlib is not installed.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> axes = fo.plot_study(fo.dissipation_study(rod, cycle, 0.5, load_factors=[0.3, 1.0]))
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['no slip']
    """
    if any(name not in getattr(table, "columns", ()) for name in _NEEDED):
        raise ModelError(
            f"table: give the DataFrame of dissipation_study, with the columns {', '.join(_NEEDED)}"
        )
    for name, column in (("x", x), ("colour", colour)):
        if column is not None:
            choice(name, column, list(table.columns))
    pictures = pictures_of(__name__)
    axes: Axes = pictures.draw(table, ax, pictures.runs_of, x=x, colour=colour)
    return axes
