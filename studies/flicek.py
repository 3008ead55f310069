"""Claims of the paper of Flicek, Hills, Barber and Dini (2015) beside answers of frictopt.

Run with `python -m studies flicek [--quick]`; it prints a table in Markdown, and needs the
transients of the study "dissipation". The claims are from the public parts of the paper: the
abstract, the introduction and the beginning of section 2.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.reference import half_plane_contact

from . import dissipation
from .paper import LOADS
from .progress import each
from .tables import Row, Study, Table, markdown, two_digits


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # The default grading, as in the study "dissipation".
    elements: int = 124
    frictions: tuple[float, ...] = (0.5, 0.7)
    range_elements: int = 32
    range_frictions: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
    # Numbers of cells of the cylinder.
    incomplete: tuple[int, ...] = (40, 80, 160)
    # Number of cells of the flat half-plane.
    uncoupled: int = 40


FULL = Parameters()
QUICK = Parameters(
    elements=16, range_elements=8, range_frictions=(0.3, 0.6), incomplete=(20, 40), uncoupled=8
)


def answers(parameters: Parameters) -> Iterator[Row]:
    """One row per question and friction, mesh or number of cells."""
    scene = fo.scenes.PunchOnHalfPlane(elements=parameters.elements)
    model = scene.model()
    system = model.condense()
    unknowns = sum(body.mesh.p.size for body in model.bodies.values())
    for question, value in (
        ("unknowns", unknowns),
        ("unknowns on the interface", 2 * system.nodes),
    ):
        yield {
            "question": question,
            "at": np.nan,
            "value": float(value),
            "other": np.nan,
            "seconds": np.nan,
            "residual": 0.0,
        }
    for f in each(parameters.frictions, "onset and limits"):
        yield _row("onset", f, partial(fo.onset, system, LOADS, f), _first)
        yield _row("shakedown limit", f, partial(fo.shakedown_limit, system, LOADS, f), _proven)
        yield _row("guaranteed limit", f, partial(fo.guaranteed_limit, system, LOADS, f), _both)
    coarse = fo.scenes.PunchOnHalfPlane(elements=parameters.range_elements).condense()
    for f in each(parameters.range_frictions, "range of a coupled contact"):
        yield _row("coupled", f, partial(fo.guaranteed_limit, coarse, LOADS, f), _both)
    # The half-width a is 1: P = pi E* a^2 / (4 R).
    pressed = {"P": np.pi / 4}
    for cells in each(parameters.incomplete, "incomplete contact"):
        cylinder = fo.ContactSystem.from_blocks(**half_plane_contact(cells, 1.25, 1.0, R=1.0))
        sheared = fo.LoadCycle(pressed, [{"Q": -pressed["P"]}, {"Q": pressed["P"]}])
        yield _row(
            "incomplete",
            cells,
            partial(fo.guaranteed_limit, cylinder, sheared, parameters.frictions[0]),
            _both,
        )
    flat = fo.ContactSystem.from_blocks(**half_plane_contact(parameters.uncoupled, 1.0, 1.0))
    stretched = flat.with_bonded({**flat.bonded, "bulk": (-flat.A @ flat.x, np.zeros(flat.nodes))})
    pulled = fo.LoadCycle({"P": 1.0}, [{"bulk": -1.0}, {"bulk": 1.0}])
    yield _row(
        "uncoupled",
        parameters.uncoupled,
        partial(fo.guaranteed_limit, stretched, pulled, parameters.frictions[0]),
        _both,
    )


def _first(onset: fo.results.Onset) -> tuple[float, float]:
    return onset.slip.load_factor, onset.separation.load_factor


def _proven(limit: fo.results.ShakedownLimit) -> tuple[float, float]:
    return limit.load_factor, limit.bound


def _both(lower: fo.results.GuaranteedLimit) -> tuple[float, float]:
    return lower.load_factor, lower.shakedown.load_factor


def _row(
    question: str, at: float, ask: Callable[[], Any], read: Callable[[Any], tuple[float, float]]
) -> Row:
    begin = time.process_time()
    answer = ask()
    seconds = time.process_time() - begin
    value, other = read(answer)
    # If the mean load causes slip, the residual of the onset is the excess over the bound, which is
    # not an error.
    mean_load_slips = isinstance(answer, fo.results.Onset) and answer.mean_slips
    residual = 0.0 if mean_load_slips else answer.residual
    return {
        "question": question,
        "at": float(at),
        "value": value,
        "other": other,
        "seconds": seconds,
        "residual": residual,
    }


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """The claims in their order."""
    asked = dict(list(tables[ANSWERS.name].groupby("question")))
    runs = tables[dissipation.RUNS.name]
    head = ["said", "of theirs", "of ours", "command"]
    rows = [*_scene(asked), *_limits(asked), *_transients(runs, asked["guaranteed limit"])]
    return markdown(head, [[*row[:-1], f"`python -m studies {row[-1]}`"] for row in rows])


def _scene(asked: Mapping[str, pd.DataFrame]) -> list[tuple[str, ...]]:
    unknowns = asked["unknowns"]["value"].iloc[0]
    interface = asked["unknowns on the interface"]["value"].iloc[0]
    return [
        ("unknowns of the finite-element model", "about 50,000", f"{unknowns:,.0f}", "flicek"),
        (
            "unknowns along the interface",
            "about 250",
            f"{interface:,.0f}, of {interface / 2:,.0f} node pairs",
            "flicek",
        ),
    ]


def _limits(asked: Mapping[str, pd.DataFrame]) -> list[tuple[str, ...]]:
    onset, upper, lower = asked["onset"], asked["shakedown limit"], asked["guaranteed limit"]
    coupled = asked["coupled"]
    incomplete = asked["incomplete"]
    uncoupled = asked["uncoupled"].iloc[0]
    apart = (coupled["value"] < coupled["other"] * (1 - 1e-9)).sum()
    zero = lower[lower["value"] == 0]
    cells = ", ".join(f"{row.other:.3g} with {row.at:g} cells" for row in incomplete.itertuples())
    return [
        (
            "first slip and first separation (section 3)",
            "a method",
            _at(onset, "{:.4g} and {:.4g}") + "; 0: the mean load alone slips",
            "flicek",
        ),
        (
            "shakedown limit as a linear program (section 4)",
            "a method, of about 125 nodes",
            _at(upper, "{:.4g}") + _timed(upper),
            "flicek",
        ),
        (
            "the guaranteed limit",
            "of two nodes; of ten cracks by combinations; more is prohibitive",
            _at(lower, "{:.4g}") + _timed(lower),
            "flicek",
        ),
        (
            "the guaranteed limit may be 0 while the shakedown limit is not",
            "may be",
            _share(len(zero), len(lower), "frictions"),
            "flicek",
        ),
        (
            "of a coupled contact the two limits nearly always differ",
            "nearly always",
            _share(apart, len(coupled), "frictions"),
            "flicek",
        ),
        (
            "of an uncoupled contact they are one",
            "a theorem",
            f"{uncoupled['value']:.12g} and {uncoupled['other']:.12g}",
            "flicek",
        ),
        (
            "both are 0 of many incomplete contacts",
            "so in the continuum",
            f"a cylinder, Q / P: {cells}",
            "flicek",
        ),
    ]


def _transients(runs: pd.DataFrame, lower: pd.DataFrame) -> list[tuple[str, ...]]:
    rests = runs["outcome"] == "SHAKEDOWN"
    above = runs["load_ratio"] > 1
    below = runs["load_factor"] < runs["friction"].map(lower.set_index("at")["value"])
    between = ~above & ~below
    work = runs[runs["dissipation_scaled"] > 0].groupby(["friction", "load_ratio"])[
        "dissipation_scaled"
    ]
    spread = (work.max() / work.min())[
        lambda ratio: ratio.index.get_level_values("load_ratio") > 1
    ].groupby("friction")
    said = "; ".join(
        f"f = {f:g}: {part.max():.3g} at {part.idxmax()[1]:g} of the limit, {part.iloc[-1]:.3g} at "
        f"{part.index[-1][1]:g} of the limit"
        for f, part in spread
    )
    cycles = runs.loc[rests, "cycles"]
    return [
        (
            "transients followed",
            "more than 1,000",
            f"{len(runs):,}, of which {int((runs['error'] == '').sum()):,} reach a steady state",
            "dissipation",
        ),
        (
            "above the shakedown limit none comes to rest",
            "none can",
            _share(int((rests & above).sum()), int(above.sum()), "starts rest"),
            "dissipation",
        ),
        (
            "below the guaranteed limit all do",
            "all",
            _share(int((rests & below).sum()), int(below.sum()), "starts rest"),
            "dissipation",
        ),
        (
            "between them the start decides",
            "so",
            _share(int((rests & between).sum()), int(between.sum()), "starts rest"),
            "dissipation",
        ),
        (
            "dissipation depends on the initial slip",
            "highly",
            f"most over least work above the limit: {said}",
            "dissipation",
        ),
        (
            "slip ceases after the first few cycles",
            "some few",
            f"{cycles.median():g} cycles in the median, at most {cycles.max():g}",
            "dissipation",
        ),
    ]


def _at(rows: pd.DataFrame, form: str) -> str:
    return "; ".join(
        f"f = {row.at:g}: {form.format(row.value, row.other)}" for row in rows.itertuples()
    )


def _timed(rows: pd.DataFrame) -> str:
    return f"; {two_digits(rows['seconds'].mean())} s each"


def _share(some: int, total: int, what: str) -> str:
    return f"{some:,} of {total:,} {what}"


_COLUMNS = {
    "question": "what is asked",
    "at": "friction, or number of cells",
    "value": "first slip, or a limit; of contacts with both limits the guaranteed one",
    "other": "first separation, bound, or shakedown limit beside the guaranteed one",
}
ANSWERS = Table("flicek", "one answer to what the paper says", _COLUMNS, FULL, QUICK, answers)

STUDY = Study(
    "studies.flicek",
    __doc__,
    "coarse meshes, in seconds",
    (ANSWERS,),
    summary,
    needs=(dissipation.RUNS,),
)
