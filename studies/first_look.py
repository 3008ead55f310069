"""A first look at the scene of Flicek et al. (2015), in less than a minute.

Run it with `python -m studies first_look [--quick]`. It prints a table: the onset, four limits up
to which slip stops, and the steady state at two loads. Each limit holds for a set of starts, and
the table says whether it is proven. The picture shows the behaviour of the contact at each load. A
load is an amplitude of the bulk stress divided by the mean pressure, sigma / (P / 2a).
"""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from textwrap import fill, shorten

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictopt as fo
from frictopt.plots.style import BLACK, SERIES, screen
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
    # Number of loads of the picture, evenly spaced.
    points: int = 25
    # Relative distance of two more loads on both sides of the shakedown limit, where the least work
    # jumps.
    beside: float = 2e-3


FULL = Parameters()
QUICK = Parameters(elements=16, points=13)
# Number of letters of a line as wide as the picture.
_LETTERS = 84
# Letters of a line of a narrow zone, and of a line that is turned upright if a zone is narrower.
_NARROW = 9
_UPRIGHT = 13
# The table and the picture have the same numbers under the same names.
_ONSET = "onset"
_ALL_STARTS = "guaranteed limit"
_OVERLOADED = "limit after one overload"
_ASSEMBLED = "limit as assembled"
_SHAKEDOWN = "shakedown limit"
_LIMITS = (_ONSET, _OVERLOADED, _SHAKEDOWN)
# The behaviour of the contact in each zone between two limits, and the colour of the zone.
_ZONES = (
    ("without residual slip no node slips", "#FFFFFF"),
    ("after one overload slip stops", "#E3EEF6"),
    ("the start decides whether slip stops", "#F8E3D6"),
    ("from every start slip goes on, if all nodes stay closed", "#EDC4AA"),
)


@dataclass(frozen=True)
class Answer:
    """The answer to one question.

    Attributes
    ----------
    value
        Load factor, or scaled work.
    meaning
        The answer in words, with the starts and nodes for which it holds.
    residual
        Largest error of its checks.
    proven
        Whether the words are proven; None if there is nothing to prove.
    """

    value: float
    meaning: str
    residual: float
    proven: bool | None


def answers(parameters: Parameters) -> Iterator[Row]:
    """One row per question."""
    for question, ask in _questions(parameters):
        start = time.perf_counter()
        answer = ask()
        yield {
            "question": question,
            "value": answer.value,
            "proven": {True: "yes", False: "no", None: ""}[answer.proven],
            "meaning": answer.meaning,
            "residual": answer.residual,
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

    The starts are: no slip; of all slips no larger than one overload leaves, the slip that leads
    to the most work, and its opposite; the witness; and the safe slip. Besides evenly spaced loads, there are the
    limit after one overload, and two loads beside the shakedown limit.
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
    evenly = np.linspace(0.0, 1.3 * limit, parameters.points)[1:]
    beside = limit * (1 - parameters.beside), limit * (1 + parameters.beside)
    for load_factor in np.sort([*evenly, after_overload().load_factor, *beside]):
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


def _questions(parameters: Parameters) -> Iterator[tuple[str, Callable[[], Answer]]]:
    friction = parameters.friction
    system, lower, overloaded = _contact_and_models(parameters.elements, friction)

    def onset() -> Answer:
        first = fo.onset(system, LOADS, friction)
        place = system.x[first.slip.node] / system.x[-1]
        meaning = f"without residual slip, the first node slips at x / a = {place:.3g}"
        return Answer(first.slip.load_factor, meaning, first.residual, proven=True)

    def guaranteed() -> Answer:
        limit = lower.solve(friction)
        meaning = "below it slip stops from every start while nodes stay closed"
        if not limit.load_factor:
            meaning += "; it is 0, because a large residual slip can take all force off the node at the edge"
        return Answer(limit.load_factor, meaning, limit.residual, limit.proven)

    def after_overload() -> Answer:
        limit = overloaded()
        meaning = (
            "below it slip stops from every start that one overload can leave while nodes stay "
            "closed"
        )
        return Answer(limit.load_factor, meaning, limit.residual, limit.proven)

    def assembled() -> Answer:
        limit = fo.limit_after_protocol(fo.shakedown_limit(system, LOADS, friction), progress=False)
        meaning = f"without residual slip, slip stops at all loads tried below it ({limit.transients} tried)"
        return Answer(limit.load_factor, meaning, limit.residual, proven=False)

    def shakedown() -> Answer:
        limit = fo.shakedown_limit(system, LOADS, friction)
        meaning = "above it no residual slip is safe with all nodes closed"
        return Answer(limit.load_factor, meaning, limit.residual, proven=True)

    yield _ONSET, onset
    yield _ALL_STARTS, guaranteed
    yield "compilation of transients", _compile
    yield _OVERLOADED, after_overload
    yield _ASSEMBLED, assembled
    yield _SHAKEDOWN, shakedown
    for load_factor in parameters.load_factors:
        yield (
            f"work of friction per cycle at load {load_factor:g}, W E* / P^2",
            partial(_steady, system, friction, load_factor),
        )


def _compile() -> Answer:
    """Run a transient of two nodes, so that later times contain no compilation."""
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=2, EA=1.0, h=1.0))
    fo.steady_state(
        rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 0.1
    )
    meaning = "only once on a machine: the machine code is stored"
    return Answer(np.nan, meaning, residual=0.0, proven=None)


def _steady(system: fo.ContactSystem, friction: float, load_factor: float) -> Answer:
    steady = fo.steady_state(system, LOADS, friction, load_factor)
    meaning = f"without residual slip, {steady.outcome.value}"
    return Answer(steady.dissipation / work_unit(system), meaning, steady.residual, proven=True)


def _summary(tables: Mapping[str, pd.DataFrame]) -> str:
    rows = [
        [
            row.question,
            "" if np.isnan(row.value) else f"{row.value:.4g}",
            row.proven,
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
    return "\n\n".join(
        [head, markdown(["question", "value", "proven", "meaning", "time"], rows), more]
    )


def _picture(tables: Mapping[str, pd.DataFrame], folder: Path) -> Path:
    """The zones of load between the limits, and below them the range of the work."""
    path = folder / "first_look.png"
    limits = tables[ANSWERS.name].set_index("question")
    runs = tables[WORKS.name]
    edges = [float(limits["value"][name]) for name in _LIMITS]
    # The last mark is inside of the picture.
    end = 1.01 * float(runs["load_factor"].max())
    with screen():
        figure, panels = plt.subplots(
            3, 1, figsize=(8.0, 4.8), sharex=True, height_ratios=(8, 24, 2), layout="constrained"
        )
        figure.get_layout_engine().set(hspace=0.0, h_pad=0.02)
        zones, work, none = panels
        _shade(panels, edges, end)
        _name_limits(zones, limits)
        _draw_works(work, none, runs, edges)
        zones.set(yticks=[], ylim=(0.0, 1.0))
        none.set_xlabel("load factor: amplitude of the bulk stress over the mean pressure")
        work.set_ylabel("work of friction per cycle in the end\n$W E^* / P^2$")
        work.legend(loc="upper left", frameon=False)
        figure.savefig(path, dpi=150)
        plt.close(figure)
    return path


def _shade(panels: Sequence[Axes], edges: Sequence[float], end: float) -> None:
    """The zones between the limits in all panels, with their words in the first panel."""
    ends = np.clip([0.0, *np.maximum.accumulate(edges), end], 0.0, end)
    for (behaviour, color), left, right in zip(_ZONES, ends[:-1], ends[1:], strict=True):
        if right == left:
            continue
        for axes in panels:
            axes.axvspan(left, right, color=color, lw=0, zorder=0)
            if right < end:
                axes.axvline(right, color=BLACK, lw=0.8)
        room = int(_LETTERS * (right - left) / end)
        wide = room >= _NARROW
        panels[0].text(
            (left + right) / 2,
            0.5,
            fill(behaviour, room)
            if wide
            else fill(shorten(behaviour, 2 * _UPRIGHT, placeholder=" ..."), _UPRIGHT),
            ha="center",
            va="center",
            fontsize=9,
            rotation=0 if wide else 90,
        )
    panels[0].set_xlim(0.0, end)


def _name_limits(zones: Axes, limits: pd.DataFrame) -> None:
    """Name and number of each limit above the zones, and whether it is proven."""
    # Distances in points, so that names of neighbours do not overlap.
    heights = {_ONSET: 4, _ALL_STARTS: 20, _OVERLOADED: 20, _SHAKEDOWN: 4}
    for name, above in heights.items():
        load_factor = float(limits["value"][name])
        how = "proven" if limits["proven"][name] == "yes" else "not proven"
        zones.annotate(
            f"{name} {load_factor:.2f}, {how}",
            (load_factor, 1.0),
            (0, above),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
        )
    # The guaranteed limit ends no zone, because the zones do not show all starts.
    all_starts = float(limits["value"][_ALL_STARTS])
    zones.plot(
        all_starts, 1.0, "v", color=BLACK, clip_on=False, transform=zones.get_xaxis_transform()
    )


def _draw_works(work: Axes, none: Axes, runs: pd.DataFrame, edges: Sequence[float]) -> None:
    """The range of the work over all starts of the table, and the work from no slip.

    The lower panel shows work 0, which has no place on a logarithmic axis.
    """
    by_load = runs.groupby("load_factor")["work"]
    least, most = by_load.min(), by_load.max()
    ends = pd.concat([least, most])
    low = 10 ** np.floor(np.log10(ends[ends > 0].min()))
    high = 10 ** np.ceil(np.log10(ends.max()))
    look = {"color": SERIES[0]["color"], "alpha": 0.35, "lw": 0}
    _, overloaded, limit = edges
    # The range ends at the limit and begins there again, because the least work jumps.
    below = (most.index >= overloaded) & (most.index < limit)
    for shown, name in ((below, None), (most.index > limit, "range over five starts")):
        loads = most.index[shown]
        work.fill_between(loads, least[shown].clip(low), most[shown].clip(low), **look, label=name)
        stopping = loads[(least[shown] == 0).to_numpy()]
        none.fill_between(stopping, -1.0, 1.0, **look)
    from_no_slip = runs[runs["start"] == "no slip"]
    stops = from_no_slip["work"] == 0
    dot = partial(Axes.plot, color=BLACK, marker="o", markersize=4, lw=0)
    slips = from_no_slip[~stops]
    dot(work, slips["load_factor"], slips["work"], label="without residual slip")
    dot(none, from_no_slip["load_factor"][stops], from_no_slip["work"][stops])
    work.set(yscale="log", ylim=(low, high))
    none.set(ylim=(-1.0, 1.0), yticks=[0.0], yticklabels=["0"])


_COLUMNS = {
    "value": "load factor, or scaled work of friction",
    "proven": "whether the answer is proven: yes, no, or empty",
    "meaning": "the answer in words, with the starts and nodes for which it holds",
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
