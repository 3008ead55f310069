"""The look of all pictures: colours, axes, legends, arrows, and the names of units."""

import re
from collections.abc import Sequence
from contextlib import nullcontext
from functools import singledispatch
from io import BytesIO
from math import ceil
from pathlib import Path
from textwrap import fill
from typing import Any, TypeAlias

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colormaps, rc_params_from_file
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.text import Text
from mpl_toolkits.mplot3d import Axes3D

from ..base import Array, shown
from ..errors import ModelError

AnyAxes: TypeAlias = Any  # one or several axes of matplotlib, also in space; None: new axes
Look: TypeAlias = dict[str, Any]  # what matplotlib takes as keywords

ALONG = (6.4, 3.6)  # size of a picture along the contact, inches
BLACK, GREY = "#000000", "#767676"
POINTS: Look = {"marker": ".", "markersize": 3}  # of the nodes on a line

# The colours of Okabe and Ito can be distinguished with impaired colour vision. In grey, lines and
# markers distinguish the series.
_COLOURS = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", BLACK, GREY
BLUE = _COLOURS[0]
FILL: Look = {"color": BLUE, "alpha": 0.2, "lw": 0}  # of a range
_DASHES = "-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (7, 2)), (0, (3, 1, 1, 1)), (0, (1, 1))
SERIES: tuple[Look, ...] = tuple(
    {"color": color, "linestyle": dashes, "marker": marker}
    for color, dashes, marker in zip(_COLOURS, _DASHES, "os^DvPX*", strict=True)
)

RC: Look = dict(
    rc_params_from_file(Path(__file__).with_name("page.mplstyle"), use_default_template=False)
)
"""The look on a journal page; for your own pictures, `plt.style.use("frictopt.plots.page")`."""

_STRESS = {
    ("N", "mm"): "MPa",
    ("kN", "mm"): "GPa",
    ("N", "m"): "Pa",
    ("kN", "m"): "kPa",
    ("MN", "m"): "MPa",
}
_MEANING = re.compile(r"\(((?:1 / )?(?:force|length)(?: (?:times|per) (?:length|area|depth))*)\)")


@singledispatch
def picture(result: object, ax: AnyAxes) -> AnyAxes:
    """Draw a result in the given axes, or in the axes of a new figure, and return the axes.

    Each class of results registers its own picture.
    """
    raise NotImplementedError(f"a {type(result).__name__} has no picture")


def screen() -> Any:
    """Context for drawing a picture in a new figure, larger than on a journal page."""
    # This starts the backend before the context begins. The backend of notebooks switches
    # interactive mode on, and the end of the context would undo this.
    plt.draw_if_interactive()
    sizes = {
        name: value * 1.3
        for name, value in RC.items()
        if isinstance(value, float) and not name.startswith("savefig")
    }
    # With this resolution, a picture file is sharp in a report, also without an option of
    # `savefig`.
    return plt.rc_context({**RC, **sizes, "figure.dpi": 150, "savefig.dpi": "figure"})


def series(number: int, count: int = 1) -> Look:
    """Look of one series, of `count` series that differ in colour.

    If there are many series, their colours follow a colour map, in order.
    """
    look = SERIES[number % len(SERIES)]
    if count <= len(SERIES):
        return look
    # The end of the colour map, yellow, can hardly be seen on white.
    return {**look, "color": to_hex(colormaps["viridis"](0.92 * number / (count - 1)))}


def line(number: int, count: int = 1) -> Look:
    """Colour and dashes of a series, without its marker."""
    return {name: series(number, count)[name] for name in ("color", "linestyle")}


def new_axes(
    ax: AnyAxes,
    panels: int = 1,
    size: tuple[float, float] = ALONG,
    *,
    common_x: bool = True,
    in_space: bool = False,
    columns: int = 1,
) -> list[Any]:
    """Axes to draw in, one for each panel: the given axes, or the axes of a new figure, row by row.

    The axis labels of a column of panels are aligned.

    Raises
    ------
    ModelError
        `ax` is not one matplotlib axes for each panel, or lacks the projection in space.
    """
    if ax is None:
        figure = plt.figure(figsize=size, layout="constrained")
        look = {"projection": "3d"} if in_space else None
        rows = ceil(panels / columns)
        grid = figure.subplots(rows, columns, sharex=common_x, squeeze=False, subplot_kw=look)
        for spare in grid.flat[panels:]:
            spare.remove()
        # Labels are aligned only now, without the spare axes: matplotlib would keep these in the
        # group of aligned labels, without a figure to draw them in.
        figure.align_ylabels()
        return list(grid.flat[:panels])
    axes = np.ravel(np.asarray(ax, dtype=object))
    kind = Axes3D if in_space else Axes
    if len(axes) != panels or not all(isinstance(panel, kind) for panel in axes):
        number = "one" if panels == 1 else panels
        projection = " with projection='3d'" if in_space else ""
        raise ModelError(f"ax: {shown(ax)}; give {number} matplotlib axes{projection}, or None")
    return list(axes)


def together(panels: Sequence[Axes]) -> AnyAxes:
    """The axes that a picture returns: a single one, or an array of several."""
    return panels[0] if len(panels) == 1 else np.array(panels)


def arrows(axes: AnyAxes, begin: Array, step: Array, enlarged: float = 1.0, **look: Any) -> None:
    """Draw arrows (n, 2) or (n, 3), none if they are NaN, and make room for them."""
    if begin.shape[1] == 3:
        axes.quiver(*begin.T, *(enlarged * step.T), **look)
        axes.auto_scale_xyz(*np.concatenate([begin, begin + enlarged * step]).T, had_data=True)
        return
    axes.quiver(*begin.T, *step.T, angles="xy", scale_units="xy", scale=1 / enlarged, **look)
    axes.update_datalim(np.concatenate([begin, begin + enlarged * np.nan_to_num(step)]))
    axes.autoscale_view()


def rings(axes: AnyAxes, places: Array, areas: Array, label: str | None, color: str) -> None:
    """Draw rings round places (n, d)."""
    if len(places):
        axes.scatter(
            *places.T,
            s=areas,
            facecolors="none",
            edgecolors=color,
            linewidths=1.3,
            zorder=2.8,
            label=label,
        )


def spread(points: Array, most: int) -> list[int]:
    """Indices of at most `most` points, each as far as possible from the points before it.

    On a straight side the points are evenly spaced.
    """
    chosen = [int(points.sum(axis=0).argmin())]
    distance = np.linalg.norm(points - points[:, chosen], axis=0)
    while len(chosen) < most and distance.max() > 0:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[:, chosen[-1:]], axis=0))
    return chosen


def named(panels: Sequence[AnyAxes]) -> Look:
    """The drawings under each label of some panels, as keywords of a legend."""
    by_label: dict[str, Any] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        by_label |= dict(zip(labels, handles, strict=True))
    return {"handles": [*by_label.values()], "labels": [*by_label]}


def legend(axes: Axes, title: str | None = None) -> None:
    """Legend beside the axes, where it covers no data, in columns if it is long."""
    names = named([axes])
    axes.legend(
        **names,
        ncols=max(1, ceil(len(names["labels"]) / 10)),  # ten names fit beside a panel
        loc="upper left",
        bbox_to_anchor=(1.0, 1.02),
        title=title,
        alignment="left",
    )


def as_is(name: object) -> str:
    """A name that the user gave, as a text in which no sign acts as markup in pictures."""
    text = str(name).replace("$", r"\$")
    # matplotlib leaves labels that begin with an underscore out of legends.
    return rf"$\_${text[1:]}" if text.startswith("_") else text


def equals(name: str, value: float) -> str:
    """A name with its value."""
    if np.isfinite(value):
        return f"{name} = {value:.5g}"
    return f"{name} is infinite" if value > 0 else f"{name}: none"


def unit(meaning: str, per_depth: bool) -> str:
    """A meaning such as "force" in brackets, per depth in plane strain and stress."""
    return f"({meaning} per depth)" if per_depth else f"({meaning})"


def no_lines(panels: Sequence[Axes], why: str) -> None:
    """Say in the first panel why there is nothing to draw."""
    first = panels[0]
    first.text(
        0.5, 0.5, fill(as_is(why), width=60), transform=first.transAxes, ha="center", va="center"
    )
    for axes in panels:
        axes.set(xticks=[], yticks=[])


def in_units(text: str, units: str) -> str:
    """A text in which meanings, such as "(force per area)", are units, such as "(MPa)".

    Examples
    --------
    >>> from frictopt.plots.style import in_units
    >>> in_units("slip (length), traction (force per area), work (force times length)", "N, mm")
    'slip (mm), traction (MPa), work (N mm)'
    """
    force, length = units.split(", ")
    words = {
        "times": "",
        "per": "/",
        "area": f"{length}²",
        "depth": length,
        "length": length,
        "force": force,
    }

    def named(match: re.Match[str]) -> str:
        if match[1] == "force per area" and (force, length) in _STRESS:
            return f"({_STRESS[force, length]})"
        names = [words.get(word, word) for word in match[1].split()]
        return f"({' '.join(filter(None, names))})"

    return _MEANING.sub(named, text)


# Draw a result: its picture in the look of a screen, with the units of the result.


def draw(result: object, ax: AnyAxes, **options: object) -> AnyAxes:
    """Draw a result in the given axes, which keep their style, or in a new figure.

    Returns the axes. The picture that is registered for its class draws it, with these options.

    Raises
    ------
    ModelError
        `ax` is not as many axes as the picture has panels.
    """
    with nullcontext() if ax is not None else screen():
        axes = picture(result, ax, **options)
    units = _units(result)
    if units is not None:
        for text in np.ravel(axes)[0].figure.findobj(Text):
            text.set_text(in_units(text.get_text(), as_is(units)))
    return axes


def png(result: Any) -> bytes:
    """The picture of a result as a PNG file; its figure is closed."""
    figure = np.ravel(result.plot())[0].figure
    file = BytesIO()
    figure.savefig(file, format="png")
    plt.close(figure)
    return file.getvalue()


def _units(result: object) -> str | None:
    """The units of a result, of its system or of a state in it; None if they are not known."""
    if hasattr(result, "attrs"):  # a table
        units: str | None = result.attrs.get("units")
        return units
    for name in ("units", "system", "least_state"):
        part = getattr(result, name, None)
        if part is not None:
            return part if isinstance(part, str) else _units(part)
    return None
