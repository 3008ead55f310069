"""Picture of frequency and damping against the amplitude."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from ..histories.damping import DampingCurve
from .picture import picture
from .style import BLACK, GREY, AxesArray, equals, legend, new_axes, series

_PLAIN = 30  # load factors within it have plain numbers, not powers of ten


@picture.register
def _damping_curve(curve: DampingCurve, ax: AxesArray | None = None) -> AxesArray:
    """Frequency above, damping below, over the load factor (log), each with the band of the residual slips; limits as lines."""
    frequency, damping = panels = new_axes(ax, 2, (6.4, 5.4))
    for axes, name in ((frequency, "frequency"), (damping, "damping")):
        look = series(0)
        axes.plot(curve.load_factor, getattr(curve, name), color=look["color"], marker=look["marker"], label="without residual slip")
        least, most = (getattr(curve, f"{end}_{name}") for end in ("least", "most"))
        if not np.isnan(least).all():
            axes.fill_between(curve.load_factor, least, most, color=look["color"], alpha=0.2, lw=0, label="range over residual slips")
        lines = ((r"guaranteed limit $\lambda_1$", curve.guaranteed_limit, GREY), (r"shakedown limit $\lambda_2$", curve.shakedown_limit, BLACK))
        for title, limit, color in lines:
            if np.isfinite(limit) and limit > 0:
                axes.axvline(limit, color=color, lw=0.8, linestyle="--", zorder=0, label=equals(title, limit))
        axes.set_xscale("log")
    if curve.load_factor[-1] < _PLAIN * curve.load_factor[0]:
        damping.xaxis.set(major_locator=LogLocator(subs=(1, 2, 3, 5, 7)), major_formatter=ScalarFormatter(), minor_formatter=NullFormatter())
    frequency.axhline(curve.natural_frequency, color=GREY, lw=0.6, zorder=0)
    frequency.set_ylabel("frequency (cycles per time)")
    damping.set(xlabel=r"load factor $\lambda$", ylabel=r"damping ratio $\zeta$")
    legend(frequency)
    return np.array(panels)
