"""Bases of results, for copying, saving and display; kinds and records of results.

Results are pickled, copied and saved with read-only arrays.
"""

from __future__ import annotations

import copy
import html
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from importlib import import_module
from pathlib import Path
from textwrap import wrap
from time import perf_counter
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np

from .checks import Array
from .files import kept

WIDE = 79  # characters of a line of a terminal


def make_read_only(value: object) -> None:
    """Make all arrays in a value, in its lists, tuples and mappings read-only."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, tuple | list):
        for part in value:
            make_read_only(part)
    elif isinstance(value, Mapping):
        make_read_only(list(value.values()))


if TYPE_CHECKING:
    import pandas as pd

Table: TypeAlias = "pd.DataFrame"


class Shown:
    """Base of dataclasses with read-only arrays, which can be pickled, copied and displayed.

    A copy has read-only arrays, too, and its own cvxpy `problem`. The display is one line (`repr`),
    short lines (`print`) or a notebook table, with the values of `_answer`.
    """

    _shown_names: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that `_answer` returns, unless a class overrides it."""

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __getstate__(self) -> dict[str, object]:
        own = vars(self)
        state = {part.name: own[part.name] for part in fields(self) if part.name in own}  # type: ignore[arg-type]
        if "problem" in state:
            state["problem"] = copy.deepcopy(state["problem"])
        return state

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        make_read_only(list(state.values()))

    def _answer(self) -> Mapping[str, object]:
        """The most important numbers of the result, name -> value."""
        return {name: getattr(self, name) for name in self._shown_names}

    def __repr__(self) -> str:
        parts = [f"{name}={_text(value)}" for name, value in self._answer().items()]
        return f"{type(self).__name__}({', '.join(parts)})"

    def __str__(self) -> str:
        answer = dict(self._answer())
        first = next(iter(answer), "")
        width = max(map(len, answer), default=0)
        # The reason comes second, after the main number.
        names = sorted(answer, key=lambda name: (name != first, name != "reason"))
        lines = [type(self).__name__]
        for name in names:
            lines += _lines(name, answer[name], width)
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{html.escape(name)}</th><td>{_html(value)}</td></tr>"
            for name, value in self._answer().items()
        )
        return f"<table><caption>{type(self).__name__}</caption>{rows}</table>"


class Kept(Shown):
    """Base of results that can be saved."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        kept(cls)

    def save(self, path: str | Path) -> None:
        """Write the result to a file, such as `limit.npz`; `frictopt.results.load` reads it.

        The file is an npz archive of plain arrays and one text, no pickle, so reading it runs no
        code of the file. All numbers, words and tables are kept, also in the contact and in other
        results that this result contains. The cvxpy `problem` of the loaded result is made again
        from the numbers; designs, and results with constraints of a model, have none.

        Raises
        ------
        ModelError
            The file cannot be written, or has the ending of another format, such as `.csv`; or the
            result holds a value of a type that cannot be kept.

        Examples
        --------
        >>> import tempfile
        >>> import frictopt as fo
        >>> blocks = fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0)
        >>> rod = fo.ContactSystem.from_blocks(**blocks)
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> limit = fo.shakedown_limit(rod, cycle, friction=0.5)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     limit.save(f"{folder}/limit.npz")
        ...     again = fo.results.load(f"{folder}/limit.npz")
        >>> again.load_factor == limit.load_factor
        True
        """
        # Imported here, because pandas is slow to import.
        from .archive import save

        save(self, path)


@kept
class LimitKind(Enum):
    """The kind of answer that a limit gives.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.LimitKind.UNBOUNDED.value.partition(":")[0]
    'there is no largest safe load factor'
    """

    FINITE = (
        "the limit is finite: stay below it, and not below the least safe load factor if that "
        "is above 0"
    )
    UNBOUNDED = (
        "there is no largest safe load factor: check that the corners of the cycle load the "
        "contact as intended"
    )
    NO_SAFE_SLIP = (
        "no load factor has a safe residual slip: see the reason, and change the mean load, the "
        "friction or the slip bound"
    )

    def __repr__(self) -> str:
        return str(self)


@kept
class Outcome(Enum):
    """The long-run behaviour of a contact.

    Examples
    --------
    >>> import frictopt as fo
    >>> print(fo.Outcome.SHAKEDOWN.value)
    the contact stops slipping: its residual slip keeps every later cycle without dissipation
    """

    SHAKEDOWN = (
        "the contact stops slipping: its residual slip keeps every later cycle without dissipation"
    )
    CYCLIC_SLIP = "the contact slips back and forth for ever, the same in every cycle"
    RATCHETING = "the contact slips for ever and its slip drifts by the same amount in every cycle"


@kept
@dataclass(frozen=True)
class Attempt:
    """A run of one solver: name, outcome, and residual of its answer, inf without an answer.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.results.Attempt("HIGHS", "optimal", 1e-12).outcome
    'optimal'
    """

    solver: str
    outcome: str
    residual: float


@kept
@dataclass(frozen=True)
class SolveRecord:
    """How a result was found.

    Attributes
    ----------
    solver, attempts
        Name of the solver or method whose answer this is; all solver runs, in order.
    residual
        Largest violation of the statements of the result, recomputed from the result. Each result
        documents which errors this covers.
    left_out
        Sentences on the parts of the problem that were left out, because they cannot change the
        answer. Empty with `simplify=False`.
    seconds
        Wall time of the computation.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> record = fo.shakedown_limit(rod, cycle, friction=0.5).record
    >>> record.solver, record.left_out, record.residual < 1e-9
    ('HIGHS', (), True)
    """

    solver: str = ""
    attempts: tuple[Attempt, ...] = field(repr=False, default=())
    residual: float = np.inf
    left_out: tuple[str, ...] = ()
    seconds: float = 0.0

    def joined(self, others: Iterable[SolveRecord], started: float) -> SolveRecord:
        """The record of a result that also needed other programs, in their order.

        `started` is a time of `perf_counter`.
        """
        records = [self, *others]
        return replace(
            self,
            attempts=tuple(attempt for record in records for attempt in record.attempts),
            residual=max(record.residual for record in records),
            seconds=perf_counter() - started,
        )


def worst(violations: Iterable[float]) -> float:
    """The largest of some violations; inf if one of them is not a number."""
    return float(np.nan_to_num(np.max([*violations]), nan=np.inf, posinf=np.inf))


class Recorded(Kept):
    """Base of results with a `record`."""

    record: SolveRecord

    @property
    def residual(self) -> float:
        """The residual of the record."""
        return self.record.residual


class Plotted:
    """Base of classes with a picture."""

    def plot(self, ax: Any = None) -> Any:
        """Draw a picture with matplotlib (extra `figures`) and return its axes.

        `ax` are as many axes as the picture has panels, or None for a new figure. ImportError
        without matplotlib; ModelError for another number of axes, or a contact in space that one
        map cannot show.
        """
        return self._draw(ax)

    def _draw(self, ax: Any, **options: object) -> Any:
        """Draw the picture of this class, or of the class it is derived from."""
        package = __name__.split(".")[0]
        modules = [base.__module__ for base in type(self).__mro__]
        ours = next(module for module in modules if module.split(".")[0] == package)
        return drawn(self, ours, ax, **options)


def drawn(result: object, module: str, ax: Any, **options: object) -> Any:
    """Draw a result by the file of pictures in the folder of a module, and return the axes.

    The file is imported here, because matplotlib is slow to import and need not be installed.

    Raises
    ------
    ImportError
        matplotlib is not installed.
    """
    try:
        import_module("matplotlib")
    except ImportError as error:
        raise ImportError(
            "plots need matplotlib: python -m pip install 'frictopt[figures]'"
        ) from error
    package, room = module.split(".")[:2]
    import_module(f"{package}.{room}.pictures")
    return import_module(f"{package}.plots.style").draw(result, ax, **options)


def frame(
    data: Mapping[str, object] | Sequence[object],
    units: str | None = None,
    names: list[str] | None = None,
) -> Table:
    """A pandas DataFrame with these columns, or with these rows and the names of their columns.

    `units` go to its `attrs`.
    """
    import pandas as pd  # imported here, because only tables need it

    table = pd.DataFrame(data, columns=names)
    if units is not None:
        table.attrs["units"] = units
    return table


def components(name: str, values: Array) -> dict[str, Array]:
    """Columns of a table from values with one tangent, (N,), or with two, (N, 2).

    With two tangents the names of the columns end with the numbers 1 and 2.
    """
    if values.ndim == 1:
        return {name: values}
    return {f"{name}{axis + 1}": values[:, axis] for axis in range(values.shape[1])}


def places(system: Any) -> dict[str, Any]:
    """Columns of a table with the places of the nodes: x along the interface, in space x, y, z.

    Before them is the number of each node in its deck, if it is known.
    """
    numbers = {} if system.deck_node is None else {"deck_node": system.deck_node}
    if system.tangents == 1:
        return {**numbers, "x": system.x}
    return {**numbers, **dict(zip("xyz", system.points.T, strict=True))}


def named_places(system: Any) -> dict[str, Any]:
    """The columns of `places`, after the contact of each node if the system names its contacts."""
    if system.contact is None:
        return places(system)
    return {"contact": system.contact, **places(system)}


def _html(value: object) -> str:
    """A value as HTML: a line for each entry of a mapping."""
    return "<br>".join(html.escape(text) for text in _texts(value))


def _lines(name: str, value: object, width: int) -> list[str]:
    """A name, in a column of its own, with its value in lines of a terminal."""
    head = " " * (width + 4)
    lines = list[str]()
    for text in _texts(value):
        lines += wrap(text, WIDE - len(head), break_long_words=False) or [""]
    if not lines:
        return [f"  {name}"]
    return [f"  {name:<{width}}  {lines[0]}".rstrip(), *(head + line for line in lines[1:])]


def _texts(value: object) -> list[str]:
    """The texts of a value: one for each entry of a mapping."""
    if isinstance(value, Mapping):
        return [f"{name}: {_text(part)}" for name, part in value.items()]
    return [_text(value)]


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray):
        return ", ".join(map(_text, value.tolist()))
    if isinstance(value, Enum):
        return value.name
    return repr(value) if isinstance(value, Shown) else str(value)
