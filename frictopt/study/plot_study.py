"""The picture of the runs of a study."""

from typing import TYPE_CHECKING

from ..base import Table, choice
from ..base.results import pictures_of
from ..errors import ModelError

if TYPE_CHECKING:  # matplotlib need not be installed
    from matplotlib.axes import Axes

    from ..plots.style import AxesArray

_NEEDED = (
    "friction",
    "friction_std",
    "friction_number",
    "cycle",
    "load_factor",
    "family",
    "outcome",
    "dissipation",
    "engine",
)


def plot_study(
    table: "Table",
    ax: "Axes | AxesArray | None" = None,
    *,
    x: str | None = None,
    colour: str | None = None,
    rows: str | None = None,
) -> "Axes | AxesArray":
    """Draw the steady dissipation of each run of a study against its load: a mark for each start.

    Columns of the table, also columns that you add, split it: `plot_study(table, x="cycle",
    colour="friction", rows="load_factor")`. Runs that shake down have no dissipation. They are
    drawn in a strip at the bottom, with several runs of one load above each other. Runs that failed
    or slide off have no mark; the title counts them.

    Parameters
    ----------
    table
        The table of `dissipation_study`, or rows of it.
    ax
        matplotlib axes to draw in, one for each panel; None: a new figure.
    x
        Column along the horizontal axis. None: the load factor, divided by the shakedown limit if
        the table has a finite limit for all runs; friction if all runs have one load factor.
    colour
        Column whose values have different colours. None: friction if it has several values,
        otherwise the load cycle, unless this column is along the horizontal axis; otherwise the
        family of the starts.
    rows
        Column whose values have different panels; None: one panel.

    Returns
    -------
    matplotlib.axes.Axes
        With `rows` an array of them.

    Raises
    ------
    ModelError
        The table or a column is unsuitable, or the number of axes is not the number of panels.
    ImportError
        matplotlib is not installed.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> axes = fo.plot_study(fo.dissipation_study(rod, cycle, 0.5, load_factors=[0.3, 1.0]))
    >>> axes.get_yscale(), [text.get_text() for text in axes.get_legend().get_texts()]
    ('log', ['no slip'])
    """
    if any(name not in getattr(table, "columns", ()) for name in _NEEDED):
        raise ModelError(
            f"table: give the DataFrame of dissipation_study, with the columns {', '.join(_NEEDED)}"
        )
    for name, column in (("x", x), ("colour", colour), ("rows", rows)):
        if column is not None:
            choice(name, column, list(table.columns))
    pictures = pictures_of(__name__)
    axes: Axes | AxesArray = pictures.draw(
        table, ax, pictures.runs_of, x=x, colour=colour, rows=rows
    )
    return axes
