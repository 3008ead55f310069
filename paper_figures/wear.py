"""Wear of a cylinder and a lap joint over the cycles.

The figure has depth, pressure and work of friction of the cylinder, damping of the lap joint, and
limits before and after.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.tables import Table
from studies.wear import HISTORY, LIFE, LIMITS, PROFILES

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {
    "profiles": PROFILES,
    "history": HISTORY,
    "limits": LIMITS,
    "life": LIFE,
}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Above: profiles. Middle: work of friction, and limits. Below: the lap joint."""
    figure = new_figure(WIDE, 170)
    (depth, pressure), (work, limits), joint = figure.subplots(3, 2)
    profiles = tables["profiles"]
    for (cycles, rows), look in zip(profiles.groupby("cycles"), SERIES, strict=False):
        line = {"color": look["color"], "linestyle": look["linestyle"], "label": f"{cycles:,.0f}"}
        depth.plot(rows["x"], rows["depth"], **line)
        pressure.plot(rows["x"], rows["pressure"], **line)
    first = profiles[profiles["cycles"] == 0]
    depth.plot(
        first["x"], first["end"], color=GREY, lw=2.4, alpha=0.5, zorder=0, label="closed form"
    )
    depth.set_ylabel("depth / $(a^2 / R)$")
    depth.legend(title="cycles", loc="upper center", ncols=2, handlelength=1.8)
    depth.set_ylim(top=2.2 * float(profiles["depth"].max()))
    pressure.set_ylabel("pressure / $(P / a)$")
    for axes in (depth, pressure):
        axes.set_xlabel("$x / a$")
    for (name, rows), look in zip(
        tables["history"].groupby("contact", sort=False), SERIES, strict=False
    ):
        share = rows["cycles"] / rows["cycles"].iloc[-1]
        work.plot(
            np.asarray(share),
            rows["work_share"],
            color=look["color"],
            linestyle=look["linestyle"],
            label=str(name),
        )
    work.set_xlabel("cycles / cycles until worn in")
    work.set_ylabel("work per cycle / first")
    work.legend(loc="upper right")
    table = tables["limits"]
    limits.plot(table["nodes"], table["before"], label="before wear", **SERIES[0])
    limits.plot(table["nodes"], table["after"], label="worn in", **SERIES[1])
    limits.axhline(1.0, color=BLACK, lw=0.6)
    plain_log(limits, "x")
    limits.set_xlabel("nodes")
    limits.set_ylabel("limit / load that wears")
    limits.set_ylim(bottom=0.0)
    limits.legend(loc="center right")
    _joint(joint, tables["life"])
    for axes, letter in zip((depth, pressure, work, limits, *joint), "abcdef", strict=True):
        panel_label(axes, letter)
    return figure


def _joint(panels: Sequence[Axes], life: pd.DataFrame) -> None:
    """Damping, frequency and both limits of the lap joint over the cycles.

    The joint without wear is at the left end.
    """
    damping, limits = panels
    first = float(life["cycles"].iloc[1])
    cycles = life["cycles"].clip(lower=first / 2)
    lines = damping.plot(cycles, 100 * life["damping"], label=r"damping ratio $\zeta$", **SERIES[0])
    frequency = damping.twinx()
    lines += frequency.plot(
        cycles, 100 * (life["frequency"] - 1), label="change of frequency", **SERIES[1]
    )
    damping.set_ylabel(r"damping ratio $\zeta$, %")
    damping.set_ylim(0.0, 160 * float(life["damping"].max()))
    frequency.set_ylabel("change of frequency, %")
    frequency.set_ylim(top=0.5 * 100 * float(1 - life["frequency"].min()))
    damping.legend(handles=lines, loc="upper right")
    limits.plot(cycles, life["limit"], label=r"shakedown limit $\lambda_2$", **SERIES[0])
    limits.plot(cycles, life["guaranteed"], label=r"guaranteed limit $\lambda_1$", **SERIES[1])
    limits.axhline(1.0, color=BLACK, lw=0.6)
    limits.set_ylim(0.0, 1.35)
    limits.set_ylabel("limit / load that wears")
    limits.legend(loc="upper left")
    for axes in (*panels, frequency):
        axes.set_xscale("log")
        axes.set_xlabel("cycles of the lap joint (left end: none)")
