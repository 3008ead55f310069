"""Pictures of what was tried: load factors, excursions and starts, and what became of the contact."""

import numpy as np
from matplotlib.axes import Axes

from ..contact.answers import Outcome
from ..contact.checks import Array
from ..histories.excursion import LeastExcursion
from ..histories.guarantee import NO_OUTCOME, GuaranteeCheck
from ..histories.protocols import REST, SLIP, UNDECIDED, LimitAfterProtocol
from .picture import picture
from .style import BLACK, GREY, equals, legend, line, new_axes, no_lines, series

_STRIP = (6.4, 2.4)  # size of a picture with a row for each outcome, inches
_ROWS = {REST: "comes to rest", SLIP: "keeps slipping", UNDECIDED: "undecided"}


@picture.register
def _practical_limit(limit: LimitAfterProtocol, ax: Axes | None = None) -> Axes:
    """The load factors tried, in a row for each outcome."""
    (axes,) = new_axes(ax, size=_STRIP)
    again = "" if limit.monotonic else ", and at some load factors above"
    axes.set_title(equals(r"comes to rest up to $\lambda$", limit.load_factor) + again)
    _rows(axes, limit.tried["load_factor"], limit.tried["outcome"])
    axes.axvline(limit.load_factor, color=GREY, lw=0.8, zorder=0, label="practical limit")
    if np.isfinite(limit.shakedown_limit):
        name = equals(r"shakedown limit $\lambda_2$", limit.shakedown_limit)
        axes.axvline(limit.shakedown_limit, color=BLACK, lw=0.8, linestyle="--", zorder=0, label=name)
    axes.set_xlabel(r"load factor $\lambda$")
    axes.set_xlim(left=0.0)
    legend(axes)
    return axes


@picture.register
def _excursion(found: LeastExcursion, ax: Axes | None = None) -> Axes:
    """The shares of the excursion tried, in a row for each outcome; a share may have several, for the start is the hardest one then."""
    (axes,) = new_axes(ax, size=_STRIP)
    if not len(found.tried):
        return no_lines(axes, "all starts come to rest without an excursion")
    if found.loads is None:
        axes.set_title("no share of the excursion tried brings all starts to rest")
    else:
        loads = ", ".join(f"{name} = {value:.4g}" for name, value in found.loads.items())
        axes.set_title(f"least excursion found: {found.share:.4g} of the largest, to {loads}")
    _rows(axes, found.tried["share"], found.tried["outcome"])
    if np.isfinite(found.share):
        axes.axvline(found.share, color=GREY, lw=0.8, zorder=0, label="least found")
        legend(axes)
    axes.set(xlabel="share of the largest excursion", xlim=(0.0, 1.02))
    return axes


@picture.register
def _guarantee_check(check: GuaranteeCheck, ax: Axes | None = None) -> Axes:
    """Which share of the starts of each kind has come to rest after so many cycles."""
    (axes,) = new_axes(ax)
    axes.set_title(equals(r"check of the guaranteed limit $\lambda_1$", check.limit.load_factor))
    most = int(check.runs["cycles"].max())
    for number, ((factor, kind), runs) in enumerate(check.runs.groupby(["load_factor", "start"], sort=False)):
        rests = np.sort(runs.loc[runs["outcome"] == Outcome.SHAKEDOWN.name, "cycles"])
        cycles, share = np.r_[0, rests, most], np.r_[0, np.arange(1, len(rests) + 1), len(rests)] / len(runs)
        name, undecided = rf"{kind}, $\lambda = {factor:.4g}$: {len(rests)} of {len(runs)}", int((runs["outcome"] == NO_OUTCOME).sum())
        axes.step(cycles, share, where="post", label=f"{name}, {undecided} undecided" if undecided else name, **line(number))
    axes.locator_params(axis="x", integer=True)
    axes.set(xlabel="cycles followed", ylabel="share of the starts at rest", ylim=(-0.05, 1.05))
    legend(axes, "at rest in the end")
    return axes


def _rows(axes: Axes, at: Array, outcomes: Array) -> None:
    """Draw a mark for each thing tried, in the row of its outcome."""
    names = [outcome for outcome in _ROWS if outcome != UNDECIDED or (outcomes == UNDECIDED).any()]
    for row, outcome in enumerate(names):
        tried = at[outcomes == outcome]
        look = {"color": series(row)["color"], "marker": series(row)["marker"], "markersize": 5, "mfc": "none"}
        axes.plot(tried, np.full(len(tried), row), linestyle="none", **look)
    axes.set(yticks=range(len(names)), yticklabels=[_ROWS[name] for name in names], ylim=(-0.6, len(names) - 0.4))
    axes.tick_params(axis="y", length=0)
