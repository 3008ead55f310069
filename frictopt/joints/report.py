"""All answers about a joint under its loads in one call, as text, tables and pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    Kept,
    Plotted,
    check_text,
    checked_cases,
    flag,
    progress_bar,
    shown,
    warns_of_odd_values,
    whole_number,
)
from ..base.files import file_path, unsealed, written
from ..contact import ContactSystem, LoadCycle, checked_cycle, checked_system
from ..errors import ModelError
from .advice import advice_on, kind_of_contact
from .backbone import rising_factors
from .report_pages import Pages
from .report_tables import LIVES, ReportParts, numbers_of
from .report_text import PAGES, shown_page, whole_text, write_html, write_json, write_spreadsheet
from .scatter import checked_scatter
from .thresholds import checked_limits

# Ending of a file -> the function that writes a report in this form.
_WRITERS: dict[str, Callable[[ReportParts, Path], None]] = {
    ".html": write_html,
    ".htm": write_html,
    ".json": write_json,
    ".xlsx": write_spreadsheet,
}


@dataclass(frozen=True, eq=False, repr=False)
class Report(Kept, ReportParts):
    """All answers about a joint under its loads; `print` shows them as text of up to 40 lines.

    `save` writes them in full with their pictures.

    Attributes
    ----------
    system, cycle, friction
        The input; friction is (N,). The load of the joint is the cycle at load factor 1.
    missing
        Parts without an answer, name -> reason; the most important part comes first.
    mean_state
        The state under the mean load, reached from a state without slip.
    gross_slip
        Result of `gross_slip`. On the first page it follows from equilibrium alone. If contact
        forces can balance themselves (`self_stress`), the second page computes it again, by
        transients.
    steady
        The steady state at load factor 1, from no slip; None if `missing` has a reason.
    assembled
        Result of `limit_after_protocol`: the limit from no slip, searched between the guaranteed
        limit and the shakedown limit in at most eight transients. None if `missing` has a reason.
    required_assembled
        Result of `friction_after_protocol`: the friction needed from no slip at load factor 1,
        searched above the required friction in at most eight transients. None if `missing` has a
        reason.
    curve, limit, guaranteed, required
        Results of `backbone_curve` (with both limits, for its picture), `shakedown_limit`,
        `guaranteed_limit`, `required_friction`; None if `missing` has a reason.
    safety
        DataFrame with a row for each safety factor, the number by which the cyclic load may grow:
        columns `against`, `nominal`, `worst` (in the scatter), `at` (the worst input), `by` (the
        method: a theorem, or the corners of the scatter). A factor above 16 is inf. The factor
        against gross slip is inf if no body slides off at any load, and 0 if no state of rest
        exists.
    verdicts
        DataFrame with a row for each threshold: columns quantity, value, limit, unit, passed,
        margin, where, at (the worst input). The margin is the limit divided by the value; a work is
        first increased by its `step_error`. For gross slip and face slip the margin is the safety
        factor divided by its limit. Without a steady state the value is NaN and the threshold is
        not passed.
    scatter
        The ranges of friction and preloads in words; "" if there is no scatter.
    probability
        DataFrame with a row for each probability that slip stops at your load: columns number,
        value, error (the standard error of a sample), meaning (the method). It has no rows if no
        input has a distribution. If `load` has a distribution, the load varies with it.
    title, notes, life, origin
        The input; notes are facts that the model leaves out, and the life is an empty table if none
        is given. The origin is the version of frictopt, the day, a checksum of the input, and the
        name and the SHA-256 of the file of the joint.
    states, identity
        `states` maps (corner of the scatter, load factor) to a steady state, or to the reason why
        there is none. `identity` has numbers of the input, which show whether a `store` belongs to
        the same call.
    bodies, model
        DataFrame with a row for each body of the model, and the model. A file of the report leaves
        the model out, and with it the picture of the joint.
    contacts
        DataFrame with a row for each contact, and for each tie of the model: the columns of
        `SteadyState.by_contact` at load factor 1, and

        - slides_at, slides_at_steady: the load factor at which this face slides in full. Its shear
          forces have the resultant and the moment that the loads send through it while all faces
          stick. Its pressure is distributed as under the mean load (`slides_at`), or as in the
          steady state. If bodies slide off at a lower load factor and this face moves, the value is
          the gross-slip load. The value is NaN for a face that is not flat. Parts of the mean load
          that slide no body, such as preloads, do not count, since slip relieves them.
        - utilisation: the largest Q / fP of all corners;
        - carries: the share of this face in the work of friction as bodies slide off;
        - where: the place of its largest slip range.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> joint = fo.report(rod, cycle, friction=0.5)
    >>> print(joint.numbers[["number", "value"]].head(3).round(3).to_string(index=False))
              number  value
     gross-slip load   2.00
      work per cycle   1.00
    share that slips   0.25
    """

    def _answer(self) -> Mapping[str, object]:
        values = zip(self.numbers["number"], self.numbers["value"], strict=True)
        return {
            "nodes": self.system.nodes,
            **{name.replace(" ", "_"): value for name, value in values},
        }

    @property
    def kind(self) -> str:
        """The kind of contact, in words: its open nodes, and their consequences for the numbers."""
        return kind_of_contact(self)

    @property
    def numbers(self) -> pd.DataFrame:
        """A row for each number: columns number, value, unit, converges, meaning.

        The column converges states whether the number converges as the mesh is refined.
        """
        return numbers_of(self)

    @property
    def advice(self) -> list[str]:
        """Advice from these numbers, in sentences."""
        return list(advice_on(self))

    def __str__(self) -> str:
        return whole_text(self)

    def save(self, path: str | Path) -> None:
        """Write the report to a file, in the format of its ending.

        - `.html`: one page to print and sign, with verdicts, safety factors, numbers and advice;
          behind it all pages with their tables and pictures, in the same file.
        - `.json`: all numbers and sentences as strict JSON, null for NaN and the texts "inf" and
          "-inf".
        - `.xlsx`: the sentences, and a sheet for each table.
        - Any other ending: the file format of all results, for `results.load`.

        Raises
        ------
        ModelError
            The file cannot be written.
        ImportError
            matplotlib is not installed (`.html`, extra `figures`), or openpyxl (`.xlsx`, extra
            `xlsx`).
        """
        write = _WRITERS.get(Path(path).suffix.lower())
        if write is None:
            super().save(path)
        else:
            with written(path, Path(path).suffix) as file:
                write(self, file)


@warns_of_odd_values
def report(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factors: ArrayLike | None = None,
    *,
    preload: Mapping[str, Any] | None = None,
    load: Any = None,
    correlation_length: float | None = None,
    limits: Mapping[str, float] | None = None,
    life: pd.DataFrame | None = None,
    pages: int = 3,
    mesh_limits: bool = False,
    title: str = "",
    notes: str = "",
    model: Any = None,
    file: str | Path | None = None,
    show: Callable[[str], object] | None = None,
    store: str | Path | None = None,
    steps: int | None = None,
    progress: bool = True,
) -> Report:
    """All answers of frictopt about a joint; its load has the load factor 1.

    The answers come in pages:

    1. The nodes that are open under the mean load; the load at which bodies slide off, turn or pry
       open, from equilibrium; the steady state at load factor 1, from no slip; verdicts.
    2. Work, slip and stiffness as functions of the load (`backbone_curve`), and safety factors. If
       contact forces balance themselves, transients find the load at which bodies slide off
       (`gross_slip`).
    3. Shakedown limit, guaranteed limit, and between them the limit of the joint as assembled; the
       friction that would keep the contact stuck (`required_friction`), and the friction that the
       joint needs as assembled.

    For a part without an answer, `missing` has the reason. The guaranteed limit and the required
    friction do not support a shear strength. If the mean load leaves nodes open, the third page
    depends on the mesh and is omitted, unless `mesh_limits` is True or normal loads alone open and
    close nodes in each cycle. In space, `mesh_limits` computes the shakedown limit with just these
    nodes open. The guaranteed limit and the required friction are then omitted, because their
    searches take minutes: for full searches, call the functions themselves.

    Safety factors against gross slip follow theorems. The gross-slip load from equilibrium never
    falls as friction grows, and it is a concave function of the preloads, so its minimum is at a
    corner of their ranges. If contact forces balance themselves, and for steady slip, no such
    theorem exists. Transients then follow the nominal input and all corners of the ranges. An input
    between the corners may be worse.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction: one value, one per node, or contact -> coefficient. A tuple of
        three is (least, nominal, most). For a frozen distribution of `scipy.stats`, the median is
        the nominal value, and 95 % lies between least and most; the report then has the probability
        that slip stops. Each contact can also have its own tuple or distribution, by its name.
    load_factors
        (K,) load factors of the curve, > 0 and rising; 1 is added to them. None: 1/4, 1/2, 1 and 2
        (in space without 1/4). If 2 exceeds 95 % of the gross-slip load, these defaults are scaled
        down to end there.
    preload
        Load case of the mean load -> scatter of its amplitude by tightening: (least, most), a
        distribution, or the tightening factor alpha_A of VDI 2230. This factor is the largest
        preload divided by the least; it gives a normal distribution with 95 % between the two. At
        most four load cases. Bolts with the same scatter belong in one load case. Each corner of
        the scatter needs its own steady states.
    load
        (least, most) load factor around 1, or its distribution, for safety factors, verdicts and
        the probability. Numbers and curves do not include this scatter.
    correlation_length
        Length over which a friction with a distribution varies along its face, see
        `ShakedownLimit.probability`.
    limits
        Thresholds for the verdicts, name -> largest value: "slip range" and "drift" (length),
        "work" (of friction per cycle), "work density" (per area), "Ruiz" (`F1` of the fretting
        table), "slipping share"; and two least safety factors: "gross slip", and "face slip" (of
        the first face that slides in full). The slip range and the slipping share also have safety
        factors.
    life
        Cycles to failure from `FatigueBand.life`, of a band at load factor 1. The first page then
        has the shortest life of the points: in the best state of rest, as assembled, and in the
        worst state of rest.
    pages
        Number of pages, 1 to 3.
    mesh_limits
        Whether to compute the third page although it depends on the mesh.
    title
        Title of the report, such as the name and the number of the drawing.
    notes
        Facts that the model leaves out, such as parts of a deck. The report has them below the
        loads.
    model
        The `ContactModel` that was condensed. The sheet then has its bodies with their materials
        and meshes, and a picture of the joint with its loads and faces.
    file
        File of the joint, such as a deck. The sheet has its name and the first digits of its
        SHA-256.
    show
        Function, such as `print`, that is called with the text of each finished page.
    store
        File for the report (npz), written after each page and at an interrupt. A repeated call
        continues from the steady states and limits in this file. `results.load` reads the file.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 2 increments
        in space), and whether to show a bar after two seconds. The error of increments is estimated
        only at load factor 1 (`step_error`). Ctrl-C raises a KeyboardInterrupt whose attribute
        `report` holds the parts known so far.

    Returns
    -------
    Report
        The answers of all pages; `print` and `save` write them.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    >>> joint = fo.report(punch, cycle, friction=0.9, load_factors=[0.5, 1.5])
    >>> print(joint.advice[0])
    As assembled the joint stops slipping at your load, after at most 1 cycle.

    A threshold, with friction between 0.2 and 0.4:

    >>> sheet = fo.report(
    ...     punch, cycle, friction=(0.2, 0.3, 0.4), limits={"slipping share": 0.3}, pages=2
    ... )
    >>> sheet.verdicts[["quantity", "passed", "at"]]
             quantity  passed                  at
    0  slipping share   False  least friction 0.2
    """
    # This raises an error if the cycle names an unknown load case.
    checked_cycle(cycle).corner_reactions(checked_system(system))
    scatter = checked_scatter(system, cycle, friction, preload, load, correlation_length)
    thresholds = checked_limits(system, limits)
    whole_number("pages", pages, least=1, most=len(PAGES))
    with_mesh_limits = flag("mesh_limits", mesh_limits)
    _check_shows(show)
    identity = _checked_identity(system, title, notes, life, model)
    origin = "" if file is None else _of_file(file)
    kept_in = None if store is None else file_path("store", store)
    if steps is not None:
        steps = whole_number("steps", steps, least=1)
    elif system.tangents == 2:
        steps = 2
    factors = None if load_factors is None else rising_factors(load_factors)
    with progress_bar(progress, "report", "page", total=pages) as bar:
        parts = Pages(system, scatter, thresholds, steps, pages, factors, bar, Report)
        parts.known.update(identity)
        parts.origin += origin
        if kept_in is not None and kept_in.exists():
            parts.take(kept_in)
        questions: list[Callable[[], None]] = [
            parts.ask_at_load,
            parts.ask_with_load,
            lambda: parts.ask_limits(with_mesh_limits),
        ]
        for page, ask in enumerate(questions[:pages], start=1):
            try:
                ask()
            finally:
                if kept_in is not None:
                    Kept.save(parts.report(), kept_in)
            bar.update()
            if show is not None:
                show(shown_page(parts.report(), page, pages))
        parts.leave_out_the_rest()
    return parts.report()


def _check_shows(show: Any) -> None:
    if show is not None and (isinstance(show, type) or not callable(show)):
        raise ModelError(f"show: {show!r}; give a function of a text, such as print")


def _checked_identity(
    system: ContactSystem, title: str, notes: str, life: Any, model: Any
) -> dict[str, Any]:
    """The parts of a sheet that describe the joint and need no computation."""
    for name, text in (("title", title), ("notes", notes)):
        if not (isinstance(text, str) and text == ""):
            check_text(name, text, "a printable text")
    if life is not None and not {*LIVES} <= {*getattr(life, "columns", ())}:
        raise ModelError(f"life: {shown(life)}; give the table of `FatigueBand.life`")
    says = {"title": title, "notes": notes, "life": pd.DataFrame() if life is None else life}
    if model is None:
        return says
    made = getattr(model, "_assembly", None)
    if made is None or len(made.pairs.nodes) != system.nodes:
        raise ModelError(f"model: {shown(model)}; give the ContactModel that made this system")
    return {**says, "model": model, "bodies": model.to_frame()}


def _of_file(file: str | Path) -> str:
    """The name of a file and its checksum, in a sentence."""
    try:
        content = Path(file).read_bytes()
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(
            f"file: {shown(file)} cannot be read ({error}); give the file of the joint"
        ) from error
    return f" File {Path(file).name}, SHA-256 {sha256(content).hexdigest()[:12]}."


# Reports on variants of a joint in one table: their numbers, their differences, and the best.

_MORE_IS_BETTER = ("load factor", "probability", "cycles")  # units; with other units less is better


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Kept, Plotted):
    """Numbers of the variants of a joint, see `compare`.

    Attributes
    ----------
    table
        DataFrame with a row for each number: number, unit, its value in each variant, its
        difference from the first variant, and `best`: the variants with the largest load factor,
        probability or number of cycles, or with the least value of any other number; "" if all
        variants are equal.
    names
        Names of the variants.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> variants = {f: fo.report(rod, cycle, float(f), pages=1) for f in ("0.5", "0.6")}
    >>> fo.compare(variants).names
    ('0.5', '0.6')
    """

    table: pd.DataFrame
    names: tuple[str, ...]

    def __str__(self) -> str:
        return str(self.table.to_string(index=False, float_format="{:.4g}".format, na_rep="-"))

    def _answer(self) -> Mapping[str, object]:
        return dict(zip(self.table["number"], self.table["best"], strict=True))


def compare(reports: Mapping[str, Report | str | Path]) -> Comparison:
    """Compare the reports on variants of a joint, number by number.

    Parameters
    ----------
    reports
        Name of a variant -> its report, or the JSON file of a report. Differences are from the
        first variant. All reports have the same units.

    Returns
    -------
    Comparison
        One table; `plot` draws all numbers, divided by the numbers of the first variant.

    Raises
    ------
    ModelError
        Fewer than two reports, different units, or a file that is no report.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> variants = {f: fo.report(rod, cycle, float(f), pages=1) for f in ("0.5", "0.6")}
    >>> work = fo.compare(variants).table.set_index("number").loc["work per cycle"]
    >>> round(work["0.6 - 0.5"], 4), work["best"]
    (-0.04, '0.6')
    """
    tables = {
        name: _numbers_of(name, report).set_index("number")
        for name, report in checked_cases("reports", reports, "report").items()
    }
    if len(tables) < 2:
        raise ModelError(f"reports: {list(tables)}; give two or more")
    units = pd.concat({name: table["unit"] for name, table in tables.items()}, axis=1)
    if (units.nunique(axis=1) > 1).any():
        raise ModelError(f"reports: {list(tables)}; give reports with the same units")
    values = pd.concat({name: table["value"] for name, table in tables.items()}, axis=1)
    unit = units.bfill(axis=1).iloc[:, 0]
    rising = values.mul(unit.isin(_MORE_IS_BETTER) * 2 - 1, axis=0)
    is_best = rising.eq(rising.max(axis=1), axis=0)
    first, *others = tables
    table = values.assign(**{f"{name} - {first}": values[name] - values[first] for name in others})
    table["best"] = [
        "" if row.all() else ", ".join(row.index[row]) for _, row in is_best.iterrows()
    ]
    table.insert(0, "unit", unit)
    return Comparison(table.reset_index(names="number"), tuple(tables))


def _numbers_of(name: str, report: object) -> pd.DataFrame:
    """The numbers of a report, or of its JSON file, which has infinity as a text."""
    if isinstance(report, Report):
        return report.numbers
    if isinstance(report, str | Path):
        return pd.DataFrame(unsealed(report)["numbers"]).astype({"value": float})
    raise ModelError(f"reports[{name!r}]: {shown(report)}; give a report or its JSON file")
