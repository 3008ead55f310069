"""A first look at the scene of Flicek et al. (2015), in less than a minute.

Run it with `python -m studies first_look [--quick]`. It prints a table of the onset, the guaranteed
limit, the shakedown limit and the steady state at two loads. It draws one picture: the behaviour of
the contact at each load. A load is an amplitude of the bulk stress divided by the mean pressure,
sigma / (P / 2a).
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from textwrap import fill

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.plots.style import BLACK, GREY, SERIES, screen
from frictopt.study.after_overload import left_by_overload

from .paper import LOADS, work_unit
from .tables import Row, Study, Table, markdown


@dataclass(frozen=True)
class Parameters:
    """Mesh, friction and loads."""

    elements: int = 124
    friction: float = 0.7
    load_factors: tuple[float, ...] = (1.5, 1.9)
    # Load at which the start of most work is searched, relative to the shakedown limit.
    searched: float = 0.95
    # Number of loads of the picture.
    points: int = 25


FULL = Parameters()
QUICK = Parameters(elements=16, points=13)
# Number of letters of a line as wide as the picture.
_LETTERS = 84
# Letters of a line that is turned upright if there is no room for more.
_NARROW = 9
# The table and the picture have the same numbers under the same names.
_ONSET = "onset"
_ALL_STARTS = "guaranteed limit, from all starts"
_OVERLOADED = "guaranteed limit, after one overload"
_SHAKEDOWN = "shakedown limit"
_LIMITS = (_ONSET, _OVERLOADED, _SHAKEDOWN)
# The behaviour of the contact between neighbouring loads, and its colour.
_ZONES = (
    ("bonded", "#FFFFFF"),
    ("slips for a while,\nthen sticks", "#E3EEF6"),
    ("the start decides:\nit sticks, or\nslips for ever", "#F8E3D6"),
    ("slips for ever,\nfrom every start", "#EDC4AA"),
)


def answers(parameters: Parameters) -> Iterator[Row]:
    """One row per question."""
    for question, ask in _questions(parameters):
        start = time.perf_counter()
        value, meaning, residual = ask()
        yield {
            "question": question,
            "value": value,
            "meaning": meaning,
            "residual": residual,
            "seconds": time.perf_counter() - start,
        }


@cache
def _contact_and_models(
    elements: int, friction: float
) -> tuple[fo.ContactSystem, fo.GuaranteedModel, Callable[[], fo.results.GuaranteedLimit]]:
    """The contact, its model of the guaranteed limit, and its model after one overload."""
    system = fo.scenes.PunchOnHalfPlane(elements=elements).condense()
    model = fo.GuaranteedModel(system, LOADS)
    return system, model, cache(lambda: fo.after_overload(model.solve(friction)))


def works(parameters: Parameters) -> Iterator[Row]:
    """One row per load and start.

    There are these starts: no slip, the slip of most work that one overload can leave, the opposite
    slip, the witness, and the safe slip.
    """
    system, lower, after_overload = _contact_and_models(parameters.elements, parameters.friction)
    safe = fo.shakedown_limit(system, LOADS, parameters.friction)
    limit = safe.load_factor
    # The slip bound of all these starts.
    most = left_by_overload(lower.solve(parameters.friction), limit)
    worst = fo.dissipation_range(
        system,
        LOADS,
        parameters.friction,
        parameters.searched * limit,
        slip_bound=most,
        progress=False,
    ).worst_start
    starts = {
        "no slip": np.zeros(system.nodes),
        "most work": worst,
        "the opposite": -worst,
        "witness": after_overload().slip,
        "safe slip": safe.slip,
    }
    for load_factor in np.linspace(0.0, 1.3 * limit, parameters.points)[1:]:
        for name, slip in starts.items():
            steady = fo.steady_state(
                system, LOADS, parameters.friction, load_factor, initial_slip=slip, progress=False
            )
            yield {
                "load_factor": load_factor,
                "start": name,
                "work": steady.dissipation / work_unit(system),
                "residual": steady.residual,
            }


def _questions(
    parameters: Parameters,
) -> Iterator[tuple[str, Callable[[], tuple[float, str, float]]]]:
    friction = parameters.friction
    system, lower, overloaded = _contact_and_models(parameters.elements, friction)

    def onset() -> tuple[float, str, float]:
        first = fo.onset(system, LOADS, friction)
        return (
            first.slip.load_factor,
            "the bonded contact slips first at x / a = "
            f"{system.x[first.slip.node] / system.x[-1]:.3g}",
            first.residual,
        )

    def guaranteed() -> tuple[float, str, float]:
        limit = lower.solve(friction)
        zero = "no load is safe from every start: a large residual slip can take all force off the node at the edge"
        return (
            limit.load_factor,
            "above it slip never stops from some residual slips" if limit.load_factor else zero,
            limit.residual,
        )

    def after_overload() -> tuple[float, str, float]:
        limit = overloaded()
        return (
            limit.load_factor,
            "slip stops from every start that one overload can leave",
            limit.residual,
        )

    def shakedown() -> tuple[float, str, float]:
        limit = fo.shakedown_limit(system, LOADS, friction)
        return (
            limit.load_factor,
            "above it no residual slip is safe with all nodes closed",
            limit.residual,
        )

    yield _ONSET, onset
    yield _ALL_STARTS, guaranteed
    yield "compilation of transients", _compile
    yield _OVERLOADED, after_overload
    yield _SHAKEDOWN, shakedown
    for load_factor in parameters.load_factors:
        yield (
            f"work of friction per cycle at load {load_factor:g}, W E* / P^2",
            partial(_steady, system, friction, load_factor),
        )


def _compile() -> tuple[float, str, float]:
    """Run a transient of two nodes, so that later times contain no compilation."""
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=2, EA=1.0, h=1.0))
    fo.steady_state(
        rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 0.1
    )
    return np.nan, "only once on a machine: the machine code is stored", 0.0


def _steady(
    system: fo.ContactSystem, friction: float, load_factor: float
) -> tuple[float, str, float]:
    steady = fo.steady_state(system, LOADS, friction, load_factor)
    return (
        steady.dissipation / work_unit(system),
        f"without initial slip, {steady.outcome.value}",
        steady.residual,
    )


def _summary(tables: Mapping[str, pd.DataFrame]) -> str:
    rows = [
        [
            row.question,
            "" if np.isnan(row.value) else f"{row.value:.4g}",
            row.meaning,
            f"{row.seconds:.2g} s",
        ]
        for row in tables[ANSWERS.name].itertuples()
    ]
    head = f"A square punch on a half-plane, f = {tables[ANSWERS.name].attrs['parameters']['friction']:g}; loads are sigma / (P / 2a)."
    more = """Next:
python -m studies                            lists the studies
python -m studies dissipation --quick        between the two limits the start decides
python -m paper_figures                      draws all figures (if interrupted, start it again)"""
    return "\n\n".join([head, markdown(["question", "value", "meaning", "time"], rows), more])


def _picture(tables: Mapping[str, pd.DataFrame], folder: Path) -> Path:
    """The axis of load with the limits, the behaviour of the contact, and the range of the work."""
    values = tables[ANSWERS.name].set_index("question")["value"]
    runs = tables[WORKS.name]
    path = folder / "first_look.png"
    edges = [float(values[name]) for name in _LIMITS]
    end = float(runs["load_factor"].max())
    ends = np.clip([0.0, *np.maximum.accumulate(edges), end], 0.0, end)
    work = runs.groupby("load_factor")["work"]
    least = work.min()
    most = work.max()
    slipping = runs["work"][runs["work"] > 0]
    low = 10 ** np.floor(np.log10(slipping.min()))
    high = 10 ** np.ceil(np.log10(slipping.max()))
    with screen():
        figure, (zones, axes) = plt.subplots(
            2, 1, figsize=(8.0, 4.8), sharex=True, height_ratios=(1.0, 3.0), layout="constrained"
        )
        for (behaviour, color), left, right in zip(_ZONES, ends[:-1], ends[1:], strict=True):
            for each in (zones, axes):
                each.axvspan(left, right, color=color, lw=0, zorder=0)
            if right > left:
                room = int(_LETTERS * (right - left) / end)
                wide = room >= _NARROW
                lines = behaviour.split("\n")
                if wide:
                    lines = [fill(line, room) for line in lines]
                else:
                    lines = [fill(lines[0].rstrip(":"), _NARROW)]
                zones.text(
                    (left + right) / 2,
                    0.5,
                    "\n".join(lines),
                    ha="center",
                    va="center",
                    fontsize=9,
                    rotation=0 if wide else 90,
                )
        all_starts = float(values[_ALL_STARTS])
        zones.annotate(
            f"{_ALL_STARTS} {all_starts:.2f}",
            (all_starts, 1.0),
            (0, 20),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
        )
        zones.plot(
            all_starts, 1.0, "v", color=BLACK, clip_on=False, transform=zones.get_xaxis_transform()
        )
        for number, (edge, name) in enumerate(zip(edges, _LIMITS, strict=True)):
            if edge < end:
                zones.axvline(edge, color=BLACK, lw=0.8)
                axes.axvline(edge, color=BLACK, lw=0.8)
                # Distance in points, so that names of neighbours do not overlap.
                above = 20 if number % 2 else 4
                zones.annotate(
                    f"{name} {edge:.2f}",
                    (edge, 1.0),
                    (0, above),
                    xycoords=("data", "axes fraction"),
                    textcoords="offset points",
                )
        look = {"color": SERIES[0]["color"], "alpha": 0.35, "lw": 0, "label": "range over starts"}
        axes.fill_between(most.index, least.clip(low / 3), most.clip(low / 3), **look)
        own = runs[runs["start"] == "no slip"]
        axes.plot(
            own["load_factor"],
            own["work"].clip(low / 3),
            "o",
            color=BLACK,
            markersize=4,
            label="from a contact that has not slipped",
        )
        axes.axhline(low, color=GREY, lw=0.6)
        axes.annotate(
            "$W = 0$",
            (1.0, low / 3),
            (4, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            va="center",
        )
        axes.set(
            yscale="log",
            ylim=(low / 6, high),
            xlim=(0.0, end),
            xlabel=r"load factor: amplitude of the bulk stress over the mean pressure",
        )
        axes.set_ylabel("work of friction per cycle in the end\n$W E^* / P^2$")
        axes.legend(loc="upper left", frameon=False)
        zones.set(yticks=[], ylim=(0.0, 1.0))
        figure.savefig(path, dpi=150)
        plt.close(figure)
    return path


_COLUMNS = {
    "value": "load factor, or scaled work of friction",
    "meaning": "the answer in words",
}
ANSWERS = Table("first_look", "one question", _COLUMNS, full=FULL, quick=QUICK, compute=answers)

_OF_RUNS = {
    "start": "residual slip from assembly, by what it is",
    "work": "work of friction per cycle of the steady state, W E* / P^2",
}
WORKS = Table(
    "first_look_work", "one load and start", _OF_RUNS, full=FULL, quick=QUICK, compute=works
)

STUDY = Study(
    "studies.first_look", __doc__, "a coarse mesh", (ANSWERS, WORKS), _summary, picture=_picture
)
