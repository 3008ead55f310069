"""The look of all pictures."""

from collections.abc import Collection
from contextlib import AbstractContextManager
from functools import singledispatch
from pathlib import Path
from textwrap import fill
from typing import Any, TypeAlias

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import rc_params_from_file
from matplotlib.axes import Axes
from matplotlib.text import Text
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from ..contact import shown
from ..contact.units import in_units
from ..errors import ModelError

AxesArray: TypeAlias = NDArray[np.object_]  # of matplotlib axes
Look: TypeAlias = dict[str, Any]  # what matplotlib takes as keywords

ALONG = (6.4, 3.6)  # size of a picture along the contact, inches
FACE = (5.6, 4.6)  # size of a map of the contact face, inches
BLACK, GREY = "#000000", "#767676"

# Okabe and Ito's colours, told apart with impaired colour vision; line and marker tell the series apart in grey as well.
SERIES: tuple[Look, ...] = (
    {"color": "#0072B2", "linestyle": "-", "marker": "o"},
    {"color": "#D55E00", "linestyle": "--", "marker": "s"},
    {"color": "#009E73", "linestyle": "-.", "marker": "^"},
    {"color": "#CC79A7", "linestyle": ":", "marker": "D"},
    {"color": "#56B4E9", "linestyle": (0, (5, 1, 1, 1, 1, 1)), "marker": "v"},
    {"color": "#E69F00", "linestyle": (0, (7, 2)), "marker": "P"},
    {"color": "#000000", "linestyle": (0, (3, 1, 1, 1)), "marker": "X"},
    {"color": "#767676", "linestyle": (0, (1, 1)), "marker": "*"},
)

RC: Look = dict(rc_params_from_file(Path(__file__).with_name("page.mplstyle"), use_default_template=False))
"""The look on a journal page; in pictures of your own `plt.style.use("frictopt.plots.page")`."""

_ONE_LINE = 60  # characters of names side by side
_SCALE = 1.3  # letters and lines of a picture on a screen, over those on a journal page


@singledispatch
def picture(result: object, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Draw one kind of result in the given axes, or in those of a new figure, and return the axes; each kind registers its own."""
    raise NotImplementedError(f"a {type(result).__name__} has no picture")


def screen() -> AbstractContextManager[None]:
    """Context in which a picture of its own is drawn, larger than on a journal page."""
    plt.draw_if_interactive()  # begins the backend: that of notebooks switches interactive mode on, which the end of the context would undo
    sizes = {name: value * _SCALE for name, value in RC.items() if isinstance(value, float) and not name.startswith("savefig")}
    context: AbstractContextManager[None] = plt.rc_context({**RC, **sizes, "savefig.dpi": "figure"})
    return context


def series(number: int) -> Look:
    """Look of a series; after the last one they begin again."""
    return SERIES[number % len(SERIES)]


def line(number: int) -> Look:
    """Colour and dashes of a series, without its marker."""
    return {name: series(number)[name] for name in ("color", "linestyle")}


def new_axes(
    ax: Axes | AxesArray | None,
    panels: int = 1,
    size: tuple[float, float] = ALONG,
    *,
    common_x: bool = True,
    in_space: bool = False,
    columns: int = 1,
) -> list[Axes]:
    """Axes to draw in, one for each panel: the given ones, or those of a new figure, one below the other or in columns, their labels in a line.

    Raises
    ------
    ModelError
        Not that many axes.
    """
    if ax is None:
        look = {"projection": "3d"} if in_space else None
        figure = plt.figure(figsize=size, layout="constrained")
        grid = figure.subplots(-(-panels // columns), columns, sharex=common_x, squeeze=False, subplot_kw=look)
        figure.align_ylabels()
        for spare in grid.flat[panels:]:
            spare.remove()
        return list(grid.flat[:panels])
    axes = np.ravel(np.asarray(ax, dtype=object))
    if len(axes) != panels or not all(isinstance(one, Axes3D if in_space else Axes) for one in axes):
        kind = " with projection='3d'" if in_space else ""
        raise ModelError(f"ax: {shown(ax)}; give {'one' if panels == 1 else panels} matplotlib axes{kind}, or None")
    return list(axes)


def one_axes(ax: Axes | AxesArray | None, tangents: int) -> Axes:
    """One axes: along a contact in the plane, or for the face of one in space."""
    return new_axes(ax, size=ALONG if tangents == 1 else FACE)[0]


def slanted(names: Collection[str], ha: str, va: str) -> Look:
    """Look of names beside each other: slanted, with that corner at their place, where one line is too short for them."""
    return {"rotation": 50, "rotation_mode": "anchor", "ha": ha, "va": va} if len("".join(names)) > _ONE_LINE else {}


def legend(axes: Axes, title: str | None = None) -> None:
    """Legend beside the axes, where it covers no data."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.02), title=title, alignment="left", handlelength=2.2)


def name_units(axes: Axes, units: str | None) -> None:
    """Name the units in all texts of a picture."""
    for text in [] if units is None else axes.figure.findobj(Text):
        text.set_text(in_units(text.get_text(), units))


def equals(name: str, value: float) -> str:
    """A name with its value."""
    if np.isfinite(value):
        return f"{name} = {value:.5g}"
    return f"{name} is infinite" if value > 0 else f"{name}: none"


def no_lines(axes: Axes, why: str) -> Axes:
    """Say why there is nothing to draw."""
    axes.text(0.5, 0.5, fill(why, width=60), transform=axes.transAxes, ha="center", va="center")
    axes.set(xticks=[], yticks=[])
    return axes
