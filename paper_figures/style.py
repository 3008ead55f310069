"""Look of all figures, and the one place that saves them."""

from math import ceil, floor, log10
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

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
NARROW, WIDE = 84.0, 174.0  # one and two columns of a journal page, mm
BLACK, GREY = "#000000", "#767676"

# Okabe and Ito's colours, told apart with impaired colour vision; line and marker tell the series apart in grey as well.
SERIES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linestyle": "-", "marker": "o"},
    {"color": "#D55E00", "linestyle": "--", "marker": "s"},
    {"color": "#009E73", "linestyle": "-.", "marker": "^"},
    {"color": "#CC79A7", "linestyle": ":", "marker": "D"},
    {"color": "#56B4E9", "linestyle": (0, (5, 1, 1, 1, 1, 1)), "marker": "v"},
    {"color": "#E69F00", "linestyle": (0, (7, 2)), "marker": "P"},
    {"color": "#000000", "linestyle": (0, (3, 1, 1, 1)), "marker": "X"},
    {"color": "#767676", "linestyle": (0, (1, 1)), "marker": "*"},
)

_RC = {
    "font.family": "STIXGeneral",  # comes with matplotlib, so every machine draws the same letters
    "mathtext.fontset": "stix",
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.titlesize": 8.0,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.2,
    "hatch.linewidth": 0.5,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "pdf.fonttype": 42,  # letters stay text that can be searched and edited
    "savefig.dpi": 300,
}


def styled() -> Any:
    """Context in which figures are drawn and saved."""
    return rc_context(_RC)


def new_figure(width: float, height: float) -> Figure:
    """Figure of that size in mm; it has no window and is in no global list, so it need not be closed."""
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
    """Make "x", "y" or "xy" logarithmic, from the decade below the data to the one above, with the powers of ten alone as labels."""
    for direction in directions:
        axes.set(**{f"{direction}scale": "log"})
        low, high = getattr(axes, f"get_{direction}lim")()
        axes.set(**{f"{direction}lim": (10.0 ** floor(log10(low)), 10.0 ** ceil(log10(high)))})
        getattr(axes, f"{direction}axis").set_minor_formatter(NullFormatter())


def output_folder(quick: bool) -> Path:
    """Default folder of the figures; those of quick data have another one."""
    return OUTPUT / "quick" if quick else OUTPUT


def save(figure: Figure, name: str, folder: Path) -> list[Path]:
    """Write the figure as PDF and PNG, the same bytes for the same data, and return the two paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.pdf", folder / f"{name}.png"]
    figure.savefig(paths[0], metadata={"CreationDate": None})
    figure.savefig(paths[1])
    return paths
