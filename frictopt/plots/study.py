"""Picture of a study of many transients."""

import numpy as np
from matplotlib.axes import Axes

from ..contact.show import Table
from .style import BLACK, SERIES, legend, new_axes, series


def runs_of(table: Table, ax: Axes | None = None) -> Axes:
    """Steady dissipation against the load, over a finite lambda_2; a look for each family of starts, a colour for each of several frictions."""
    (axes,) = new_axes(ax)
    runs = table[table["outcome"] != "FAILED"]
    slips = runs["dissipation"] > 0
    low, high = (runs.loc[slips, "dissipation"].min() / 3, runs.loc[slips, "dissipation"].max() * 3) if slips.any() else (0.1, 10.0)
    bounded = bool(np.isfinite(runs["load_ratio"]).all())
    families, frictions = ({name: k for k, name in enumerate(table[column].unique())} for column in ("family", "friction_number"))
    several = len(frictions) > 1
    for (family, friction), rows in runs.groupby(["family", "friction_number"], sort=False):
        at = np.where(rows["dissipation"] > 0, rows["dissipation"], low / 2)
        color, marker = series(frictions[friction] if several else families[family])["color"], series(families[family])["marker"]
        load = rows["load_ratio" if bounded else "load_factor"]
        axes.plot(load, at, linestyle="none", markersize=5, mfc="none", color=color, marker=marker, label=None if several else family)
    if several:
        for family, number in families.items():
            axes.plot([], [], color=BLACK, marker=series(number)["marker"], linestyle="none", mfc="none", label=family)
        for friction, number in list(frictions.items())[: len(SERIES)]:
            row = table[table["friction_number"] == friction].iloc[0]
            scattered = rf" $\pm$ {row['friction_std']:.2g}" if row["friction_std"] > 0 else ""
            axes.plot([], [], color=series(number)["color"], lw=3, label=f"$f$ = {row['friction']:.4g}{scattered}")
    axes.axhline(low, color=BLACK, lw=0.6)
    axes.set(yscale="log", ylim=(low / 4, high), ylabel="work of friction per cycle, $W$\n(force times length per depth)")
    axes.annotate("$W = 0$", (1, low / 2), (5, 0), xycoords=("axes fraction", "data"), textcoords="offset points", va="center")
    axes.set_xlabel(r"load factor over the shakedown limit, $\lambda / \lambda_2$" if bounded else r"load factor $\lambda$")
    if bounded:
        axes.axvline(1, color=BLACK, lw=0.8, linestyle="--")
    if len(runs) < len(table):
        axes.set_title(f"{len(table) - len(runs)} of {len(table)} runs failed")
    legend(axes, "start and friction" if several else "start")
    return axes
