"""Picture of the amplitudes of two loads at which some residual slip is safe."""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes

from ..limits import SafeRegion
from .picture import picture
from .style import BLACK, SERIES, Look, legend, line, new_axes, no_lines, series

_INSIDE: Look = {"color": "#56B4E9", "alpha": 0.25, "lw": 0, "label": "some residual slip is safe"}
_MARGIN = 1.08  # of the axes, over the largest amplitude


@picture.register
def _safe_region(region: SafeRegion, ax: Axes | None = None) -> Axes:
    """The region, with the node that slips or opens most beyond each side (of many sides, one look for all)."""
    (axes,) = new_axes(ax)
    axes.set_title("amplitudes of two loads that vary independently")
    if not len(region.sides):
        return no_lines(axes, region.reason)
    names = [f"amplitude of {name}" + (": no limit" if name in region.unlimited else " (times its unit load)") for name in region.loads]
    axes.set(xlabel=names[0], ylabel=names[1])
    if region.unlimited:
        _strip(axes, region)
    else:
        _polygon(axes, region)
    legend(axes)
    return axes


def _strip(axes: Axes, region: SafeRegion) -> None:
    """One of the loads has no limit."""
    upright = np.isinf(region.vertices[0, 1])
    span, line, free = (axes.axvspan, axes.axvline, "y") if upright else (axes.axhspan, axes.axhline, "x")
    most = float(region.vertices.min())
    span(0.0, most, **_INSIDE)
    line(most, color=series(0)["color"], label=_limiting(region, 0))
    axes.set(**{f"{free}ticks": [], f"{free}lim": (0.0, 1.0), f"{'x' if upright else 'y'}lim": (0.0, _MARGIN * most or 1.0)})


def _polygon(axes: Axes, region: SafeRegion) -> None:
    """Both loads have a limit."""
    axes.fill(*np.vstack([[0.0, 0.0], region.vertices]).T, **_INSIDE)
    few = len(region.sides) <= len(SERIES)
    for number, ends in enumerate(pairwise(region.outer)):
        look = line(number) if few else {"color": BLACK}
        all_sides = f"{len(region.sides)} sides, each a mechanism" if number == 0 else None
        axes.plot(*np.transpose(ends), **look, label=_limiting(region, number) if few else all_sides)
    axes.plot(*region.vertices.T, linestyle="none", marker="o", markersize=3, color=BLACK, clip_on=False, label="vertex, proven safe")
    most = region.outer.max(axis=0)
    axes.set(xlim=(0.0, _MARGIN * most[0] or 1.0), ylim=(0.0, _MARGIN * most[1] or 1.0))


def _limiting(region: SafeRegion, side: int) -> str:
    """The node with the largest share in the mechanism of a side."""
    first = region.mechanisms[side].iloc[0]
    slips = first["direction"] if "direction" in first else first["slip1"] or first["slip2"]
    return f"side {side}: node {int(first['node'])}, $x = {first['x']:.4g}$, {'slips' if slips else 'opens'} most"
