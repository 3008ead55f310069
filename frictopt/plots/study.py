"""Picture of a study of many transients."""

import numpy as np
from matplotlib.axes import Axes

from .picture import Runs, picture
from .style import BLACK, legend, new_axes, series

__all__: list[str] = []


@picture.register
def _study(study: Runs, ax: Axes | None = None) -> Axes:
    """Steady dissipation against the load, over lambda_2 where that is finite; families of starts have each a look."""
    (axes,) = new_axes(ax)
    table = study.table
    runs = table[table["outcome"] != "FAILED"]
    slips = runs["dissipation"] > 0
    low, high = (runs.loc[slips, "dissipation"].min() / 3, runs.loc[slips, "dissipation"].max() * 3) if slips.any() else (0.1, 10.0)
    bounded = bool(np.isfinite(runs["load_ratio"]).all())
    for number, (family, rows) in enumerate(runs.groupby("family", sort=False)):
        at = np.where(rows["dissipation"] > 0, rows["dissipation"], low / 2)
        look = {"color": series(number)["color"], "marker": series(number)["marker"], "markersize": 5, "mfc": "none"}
        axes.plot(rows["load_ratio" if bounded else "load_factor"], at, linestyle="none", label=family, **look)
    axes.axhline(low, color=BLACK, lw=0.6)
    axes.set(yscale="log", ylim=(low / 4, high), ylabel="work of friction per cycle, $W$\n(force times length per depth)")
    axes.annotate("$W = 0$", (1, low / 2), (5, 0), xycoords=("axes fraction", "data"), textcoords="offset points", va="center")
    axes.set_xlabel(r"load factor over the shakedown limit, $\lambda / \lambda_2$" if bounded else r"load factor $\lambda$")
    if bounded:
        axes.axvline(1, color=BLACK, lw=0.8, linestyle="--")
    if len(runs) < len(table):
        axes.set_title(f"{len(table) - len(runs)} of {len(table)} runs failed")
    legend(axes, "start")
    return axes
