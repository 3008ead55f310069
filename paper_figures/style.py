"""The look of all figures, and the function that saves them."""

from math import ceil, floor, log10
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from frictopt.plots.style import BLACK, GREY, RC, SERIES

__all__ = [
    "BLACK",
    "GREY",
    "NARROW",
    "OUTPUT",
    "SERIES",
    "WIDE",
    "new_figure",
    "output_folder",
    "panel_label",
    "plain_log",
    "save",
    "styled",
    "whole_decades",
]

OUTPUT = Path(__file__).parent / "output"
# Widths of one and two columns of a journal page, in mm.
NARROW, WIDE = 84.0, 174.0


def styled() -> Any:
    """Context in which figures are drawn and saved."""
    return rc_context({**RC})


def new_figure(width: float, height: float) -> Figure:
    """A figure of a size in mm.

    It has no window and is in no global list, so nobody has to close it.
    """
    return Figure(figsize=(width / 25.4, height / 25.4), layout="constrained")


def panel_label(axes: Any, letter: str) -> None:
    """Letter of a panel, above its upper left corner."""
    axes.set_title(f"({letter})", loc="left")


def plain_log(axes: Any, directions: str) -> None:
    """Make "x", "y" or "xy" logarithmic, with the plain numbers 1, 2, 5, 10 ... as labels."""
    for direction in directions:
        axes.set(**{f"{direction}scale": "log"})
        axis = getattr(axes, f"{direction}axis")
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def whole_decades(axes: Any, directions: str) -> None:
    """Make "x", "y" or "xy" logarithmic, with whole decades and powers of ten as labels.

    The axis begins with the decade below the data and ends with the decade above.
    """
    for direction in directions:
        axes.set(**{f"{direction}scale": "log"})
        low, high = getattr(axes, f"get_{direction}lim")()
        axes.set(**{f"{direction}lim": (10.0 ** floor(log10(low)), 10.0 ** ceil(log10(high)))})
        getattr(axes, f"{direction}axis").set_minor_formatter(NullFormatter())


def output_folder(quick: bool) -> Path:
    """Default folder of the figures; figures of quick data have another folder."""
    return OUTPUT / "quick" if quick else OUTPUT


def save(figure: Figure, name: str, folder: Path) -> list[Path]:
    """Write the figure as PDF and PNG, and return the two paths.

    The same data gives the same bytes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.pdf", folder / f"{name}.png"]
    figure.savefig(paths[0], metadata={"CreationDate": None})
    # Both files have the same layout, which takes as long as the drawing.
    figure.set_layout_engine("none")
    figure.savefig(paths[1])
    return paths
