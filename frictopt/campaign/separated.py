"""The limit of a contact whose nodes may open: the largest load factor at which some state of rest exists."""

# One file because it is one answer: its search, its bound, and the reason in words.

import time
from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import IO, Any

import numpy as np

from ..contact import ContactState, ContactSystem, LoadCycle, friction_coefficients
from ..contact.checks import Array, flag, frozen, whole_number
from ..contact.cycle import checked_cycle
from ..contact.diagnosis import mean_load_diagnosis
from ..contact.progress import bar_of
from ..contact.record import Attempt, SolveRecord, WithSlip
from ..contact.show import Plotted, frame
from ..contact.system import checked_plane
from ..contact.tolerances import ONE_LIMIT
from ..limits import LimitKind
from ..limits.separated import CornerStates, SeparatedProblem
from ..solve.bounds import BoundStatus
from ..solve.explain import Units, explain
from .rest import Booleans, Question, Rest
from .rest_search import RestSearch

__all__ = ["SeparatedLimit", "separated_limit"]

_RANGE = 2.0  # load factors that the bound covers, over the largest found; four times more where a state comes to its end
_WIDER, _ROUNDS = 4.0, 6
_PROGRAMS, _FEWEST, _SMALL_CONTACT = 300, 20, 40  # programs and transients of a search, at least, and nodes up to which it has all of them
_TREE, _MOST_BOOLEANS = 10, 60  # nodes of the search tree for each program, and booleans above which a bound takes more than minutes
_SMALL = 1e-3  # load factor, in load units, below which the range of the bound does not shrink


@dataclass(frozen=True, eq=False, repr=False)
class SeparatedLimit(WithSlip, Plotted):
    """The largest load factor found at which the contact comes to rest with nodes open or closed, and what is known above it.

    Attributes
    ----------
    load_factor
        A proven lower bound of the largest load factor at which some start comes to rest: the state `state` does. Inf: one does at every load factor.
        NaN: none was found, see `reason`.
    least
        A state of rest is proven for all load factors from `least` to `load_factor`: the same nodes stay open, or none. It is 0 where they do so
        under the mean load alone. `load_factor` itself where nodes open and close, which proves nothing of other load factors; NaN without a state.
    bound
        Upper bound, within `covers`, of the load factors with a state of rest; inf where the time limit was reached before anything was known, NaN
        where there is no such state.
    exact
        Whether `bound` equals `load_factor` to 1e-6: then `load_factor` is the limit, within `covers`.
    covers
        What the bound holds for, in words.
    kind, reason
        What kind of answer it is, and how it is known, in words.
    slip, state
        (N,) slip at the last corner of the resting cycle, length; and the whole state there, from which the exact path rests. NaN and None without
        one.
    open
        (K, N) which nodes are open at the corners of the resting cycle.
    record
        How it was found. Its `residual` is the largest violation of the contact law and of the balance of energy by the resting cycle. At most 1e-9.
    problem
        The mixed-integer program of the bound, as it was solved last; None where none was, or in a copy.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "N": ([0.0], [1.0])})
    >>> limit = fo.separated_limit(node, fo.LoadCycle({"P": 1.0}, [{"N": -1.0}, {"N": 1.0}]), friction=0.5)
    >>> limit.load_factor > 1e5  # it lifts off above 1, and never slips
    True
    """

    load_factor: float
    least: float
    bound: float
    exact: bool
    covers: str
    kind: LimitKind
    reason: str
    slip: Array = field(repr=False)
    state: ContactState | None = field(repr=False)
    open: Booleans = field(repr=False)
    record: SolveRecord
    problem: Any = field(repr=False)
    _question: Question = field(repr=False)
    _rest: Rest | None = field(repr=False)
    _units: Units = field(repr=False)

    @property
    def system(self) -> ContactSystem:
        """The contact."""
        return self._question.system

    @property
    def friction(self) -> Array:
        """(N,) coefficients of friction."""
        return self._question.friction

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners of the resting cycle, force per depth, zero where open; NaN where `load_factor` is not finite."""
        if self._rest is None or not np.isfinite(self.load_factor):
            return np.full(self.open.shape, np.nan), np.full(self.open.shape, np.nan)
        q, p = self._question.reactions(self._rest)
        return np.where(self.open, 0.0, q), np.where(self.open, 0.0, p)

    def to_frame(self) -> Any:
        """The DataFrame of the nodes: columns node, x, slip, gap at the last corner, and open, the number of corners at which it is."""
        gap = np.full_like(self.slip, np.nan) if self.state is None else self.state.gap
        return frame({"node": range(self.system.nodes), "x": self.system.x, "slip": self.slip, "gap": gap, "open": self.open.sum(axis=0)})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("load_factor", "least", "bound", "exact", "kind", "largest_slip", "residual", "reason")}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the answer, the reason, what the bound covers, and the mixed-integer program by its names."""
        title = f"limit with separation: load factor {self.load_factor:.12g}, bound {self.bound:.12g}"
        explain(title, self.problem, None, self._units, self.record.left_out, None, file, f"{self.reason}\nbound holds {self.covers}")


def separated_limit(
    system: ContactSystem, cycle: LoadCycle, friction: Any, *, most_programs: int | None = None, progress: bool = True
) -> SeparatedLimit:
    """Largest load factor at which some state of rest exists, whose nodes may be open always, or open and close in each cycle.

    `load_factor` is a lower bound that a state of rest proves. It comes from linear programs over sets of nodes that stay open, searched outward from
    the state under the mean load, and from transients at ever larger load factors. `bound` is the upper bound by a mixed-integer program of what
    holds at the corners, for the class of cycles that `covers` names. It is never below `shakedown_limit`, whose safe slips keep all nodes closed.

    A contact whose pressure falls to zero at its edge slips there at any load in the continuum (Barber, Klarbring & Ciavarella 2008): its limit
    belongs to the mesh, and falls with it. Theory, eq. (18).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    most_programs
        Number of linear programs and transients that the search may take, at least 1; the mixed-integer program may have ten times as many nodes in
        its search tree. None: 300, for more than 40 nodes in proportion to 1 / N^2 fewer, but at least 20. Contacts of more than about 20 nodes use
        them up; with more than 60 pairs of node and corner there is no bound.
    progress
        Show what is being done, on a terminal only.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=4).condense()
    >>> rounded = punch.with_gap(2.0 * punch.x**4)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    >>> fo.shakedown_limit(rounded, cycle, friction=0.6).load_factor
    nan
    >>> limit = fo.separated_limit(rounded, cycle, friction=0.6)
    >>> limit.exact, limit.open.tolist()
    (True, [[True, False, False, False, True], [True, False, False, False, True]])
    """
    began = time.perf_counter()
    f = np.array(friction_coefficients(friction, checked_plane(system).nodes))
    checked_cycle(cycle).corner_reactions(system)
    few = max(_FEWEST, int(_PROGRAMS * min(1.0, (_SMALL_CONTACT / system.nodes) ** 2)))
    most = few if most_programs is None else whole_number("most_programs", most_programs, least=1)
    question = Question(system, cycle, f)
    with _progress(flag("progress", progress)) as tell:
        search = RestSearch(question, most, tell)
        search.run()
        found = _Bound(search, _TREE * most)
        if not (search.unbounded or search.endless):
            found.run()
    return _result(question, search, found, began)


class _Bound:
    """The upper bound by the mixed-integer program, over ever wider ranges of load factors as long as a state comes to their end."""

    def __init__(self, search: RestSearch, most_nodes: int) -> None:
        self.search, self.most_nodes = search, most_nodes
        self.bound, self.problem, self.units = np.inf, None, dict[str, Any]()
        self.attempts: list[Attempt] = []
        self.most = _RANGE * max(search.least, _SMALL * search.unit)
        self.touched = self.contradicted = self.endless = False

    @property
    def large(self) -> bool:
        """Whether the program has more booleans than it can decide on."""
        asked = self.search.question
        return asked.system.nodes * len(asked.cycle.corners) > _MOST_BOOLEANS

    def run(self) -> None:
        search, asked = self.search, self.search.question
        if self.large:
            return
        for number in range(_ROUNDS):
            if search.unbounded or search.endless:
                return
            self.most *= _WIDER if number else 1.0
            search.tell(f"bound up to {self.most:.6g}")
            model = SeparatedProblem(asked.system, asked.cycle, asked.friction, self.most)
            bounds, states, self.problem = model.search(search.least * (1 - ONE_LIMIT), self.most_nodes)
            self.units = dict(model.units)
            self.attempts.append(Attempt("HIGHS", f"load factors up to {self.most:.6g}: {bounds.status.value}", 0.0))
            if states is not None:
                self._follow(model, states)
            if bounds.status is BoundStatus.INFEASIBLE:
                self.contradicted = search.best is not None
                self.bound = np.inf if self.contradicted else np.nan
                return
            self.touched = states is not None and model.touches(states)
            if bounds.bound < self.most * (1 - ONE_LIMIT):
                self.bound = np.inf if self.touched else max(bounds.bound, search.least)
                return
            if bounds.status is not BoundStatus.OPTIMAL:
                return
        self.endless = True

    def _follow(self, model: SeparatedProblem, states: CornerStates) -> None:
        """Give the search what the program found: its load factor, or a little less."""
        opened = np.asarray(self.problem.var_dict["opened"].value) > 0.5 if self.problem is not None else states.gap > 0
        best = model.with_open(opened) or states
        if self.search.rise(best) or self.search.rise(states):
            self.search.climb()


def _result(question: Question, search: RestSearch, found: _Bound, began: float) -> SeparatedLimit:
    corners, n = len(question.cycle.corners), question.system.nodes
    best = search.best
    largest = np.inf if search.unbounded else np.nan if best is None else best.load_factor
    least = _least(search)
    bound = np.inf if search.unbounded else found.bound
    exact = bool(search.unbounded or bound <= largest * (1 + ONE_LIMIT) or (best is None and np.isnan(bound)))
    kind = LimitKind.UNBOUNDED if search.unbounded else LimitKind.NO_SAFE_SLIP if best is None else LimitKind.FINITE
    return SeparatedLimit(
        load_factor=float(largest),
        least=least,
        bound=float(bound),
        exact=exact,
        covers=(
            "for cycles in which closed nodes stick and each node opens or closes at most once on the way from corner to corner"
            + ("" if search.unbounded else f", at load factors up to {found.most:.6g}")
        ),
        kind=kind,
        reason=_reason(question, search, found, exact, least),
        slip=frozen(np.full(n, np.nan) if best is None else best.state.slip),
        state=None if best is None else best.state,
        open=np.zeros((corners, n), dtype=bool) if best is None else best.open,
        record=SolveRecord(*_found(search, found), time.perf_counter() - began),
        problem=found.problem,
        _question=question,
        _rest=best,
        _units=found.units,
    )


def _least(search: RestSearch) -> float:
    """The least load factor from which on the nodes of the best state can stay open, and the others closed and stuck."""
    if search.endless_set is not None:
        return search.endless_set.least
    if (best := search.best) is None:
        return np.nan
    limit = search.limit_of(best.open[0]) if (best.open == best.open[0]).all() else None
    return limit.least if limit is not None and best.load_factor <= limit.load_factor * (1 + ONE_LIMIT) else best.load_factor


def _found(search: RestSearch, found: _Bound) -> tuple[str, tuple[Attempt, ...], float, tuple[str, ...]]:
    """Who answered, the mixed-integer programs, and the residual."""
    best = search.best
    solver = "none" if best is None else "exact path" if best.followed else "linear program"
    return solver, tuple(found.attempts), 0.0 if best is None else best.residual, ()


def _reason(question: Question, search: RestSearch, found: _Bound, exact: bool, least: float) -> str:
    best, start = search.best, f" from {least:.6g} on" if least > 0 else ""
    if search.unbounded:
        return f"every load factor{start} has a state of rest with the same nodes open"
    if best is None:
        return f"no state of rest was found: {mean_load_diagnosis(question.system, question.cycle, question.friction)}"
    always, sometimes = int(best.open.all(axis=0).sum()), int((best.open.any(axis=0) & ~best.open.all(axis=0)).sum())
    n, proof = question.system.nodes, "the exact path from it rests" if best.followed else "proven at its corners"
    text = f"a state of rest with {always} of {n} nodes open at all corners and {sometimes} at some ({proof})"
    if least > 0:
        text += f", as there is{start}" if least < best.load_factor else "; nothing is proven of lower load factors"
    if exact:
        return f"{text}; the mixed-integer program finds none above it"
    if found.contradicted:
        return f"{text}; it is outside of what the bound covers"
    if found.touched:
        return f"{text}; a big-M bound is active, so there is no upper bound"
    if search.endless:
        return f"{text}; larger load factors were not tried"
    if found.endless:
        return f"{text}; no bound, for at the corners the mixed-integer program allows states at any load factor, of which none was found to rest"
    if found.large:
        return f"{text}; no bound, for a mixed-integer program of {question.system.nodes * len(question.cycle.corners)} booleans is not tried"
    if np.isinf(found.bound):
        return f"{text}; all programs are used up: nothing is known above it; give more most_programs"
    return f"{text}; above it the mixed-integer program allows states, of which none was found to rest"


@contextmanager
def _progress(show: bool) -> Any:
    with bar_of(show, "separated limit", "step") as bar:

        def tell(text: str) -> None:
            bar.set_postfix_str(text, refresh=False)
            bar.update()

        yield tell
