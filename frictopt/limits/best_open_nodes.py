"""The proof that no other open nodes among given ones have a higher limit, or the better limit.

The given nodes are *loose*: a loose node has forces as a closed node, and at each corner also a
slip and a gap of its own. The largest load factor of this program bounds the limits of all sets of
open nodes that differ in these nodes alone. If the bound is not above the best limit so far, these
sets are proven all at once. Else one loose node opens in one branch and closes in another, and
both branches have bounds of their own (theory, "Proof for given nodes").
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    FLOOR,
    Array,
    Bar,
    Booleans,
    Integers,
    Kept,
    frame,
    number_of,
    places,
    progress_bar,
    shown,
    warns_of_odd_values,
)
from ..base.checks import whole_array, whole_number
from ..errors import ModelError, SolverError
from ..solve.solvers import LP, SOCP, solver_order
from .loose_nodes import BRANCHES, Branch, LooseNodes, Relaxed
from .moving_areas import MovingAreas
from .question import with_open
from .sentences import Sentence
from .shakedown import ShakedownLimit, ShakedownLimits

BETTER_SET = Sentence(
    "with {changes} the limit is {load_factor:.6g}, not {given_limit:.6g}; ",
    assumes="the limit of this set passes the checks of every limit",
)
NO_SET_ABOVE = Sentence(
    "{better}no {other}set of open nodes that differs only in {nodes} has a limit above "
    "{bound:.6g}{more}{separate}",
    assumes="the other nodes stay as they are, and the closed nodes hold the open ones",
)
MORE_PROGRAMS = Sentence(
    ": give more programs, or fewer nodes, for a proof that none is better",
    assumes="the bound is above the best limit",
)
SEPARATE = Sentence(
    ", except with safe load factors that begin at {least:.6g} or above",
    assumes="these sets are not safe at the best load factor",
)


@dataclass(frozen=True, eq=False, repr=False)
class BestOpenNodes(Kept):
    """Best limit over all sets of open nodes that differ only in given nodes.

    Attributes
    ----------
    limit
        The best limit. It is the given limit if no set has a higher limit.
    given_limit
        The given limit.
    nodes
        (n,) the nodes that may open or close; the other nodes stay as they are in `given_limit`.
    bound
        Load factor that no set exceeds with its limit, except the sets in `separate`. It follows
        from multipliers that are checked in this run.
    programs
        Number of programs that were solved.
    separate
        Higher limits that do not count, because their least safe load factor is above
        `limit.load_factor`: load factors between the two are not safe.

    Examples
    --------
    >>> import frictopt as fo
    >>> flat = fo.scenes.PunchOnHalfPlane(elements=8).condense()
    >>> rounded = flat.with_gap(2.0 * flat.x**4)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    >>> limit = fo.shakedown_limit(rounded, cycle, friction=0.6)
    >>> best = fo.best_open_nodes(limit, nodes=[0, 1, 2, 6, 7, 8])
    >>> best.proven, best.limit is limit
    (True, True)
    """

    _shown_names = ("load_factor", "bound", "proven", "improved", "programs", "reason")
    limit: ShakedownLimit
    given_limit: ShakedownLimit
    nodes: Integers
    bound: float
    programs: int
    separate: tuple[ShakedownLimit, ...] = ()

    @property
    def load_factor(self) -> float:
        """The load factor of the best limit."""
        return self.limit.load_factor

    @property
    def improved(self) -> bool:
        """Whether a set has a higher limit than the given limit."""
        return bool((self.limit.open != self.given_limit.open).any())

    @property
    def proven(self) -> bool:
        """Whether no set has a limit above `limit`, except the sets in `separate`.

        It is proven up to a relative difference of 1e-7, for all sets whose closed nodes hold the
        open nodes. False if the largest number of programs was reached, or if no solver gave an
        answer to one of them that passes the checks.
        """
        return self.bound <= _just_above(self.limit)

    @property
    def reason(self) -> str:
        """The answer in words."""
        better = ""
        if self.improved:
            better = BETTER_SET(
                changes=self._changes,
                load_factor=self.load_factor,
                given_limit=self.given_limit.load_factor,
            )
        separate = ""
        if self.separate:
            separate = SEPARATE(least=min(limit.least for limit in self.separate))
        return NO_SET_ABOVE(
            better=better,
            other="other " if self.improved else "",
            nodes=number_of(len(self.nodes), "node"),
            bound=self.load_factor if self.proven else self.bound,
            more="" if self.proven else MORE_PROGRAMS(),
            separate=separate,
        )

    def to_frame(self) -> Any:
        """A row for each of `nodes`: node, its place, `open` in the best limit, `was_open`."""
        columns: dict[str, object] = {"node": self.nodes}
        for name, values in places(self.limit.system).items():
            columns[name] = values[self.nodes]
        columns["open"] = self.limit.open[self.nodes]
        columns["was_open"] = self.given_limit.open[self.nodes]
        return frame(columns, units=self.limit.system.units)

    @property
    def _changes(self) -> str:
        """The nodes that are open or closed in the better set, in words."""
        states = {
            "open": self.limit.open & ~self.given_limit.open,
            "closed": self.given_limit.open & ~self.limit.open,
        }
        texts = list[str]()
        for state, chosen in states.items():
            numbers = ", ".join(map(str, np.flatnonzero(chosen).tolist()))
            if numbers:
                noun = "node" if chosen.sum() == 1 else "nodes"
                texts.append(f"{noun} {numbers} {state}")
        return " and ".join(texts)


@warns_of_odd_values
def best_open_nodes(
    limit: ShakedownLimit,
    nodes: ArrayLike,
    *,
    programs: int = 1000,
    solver: str | None = None,
    progress: bool = True,
) -> BestOpenNodes:
    """Best limit over all sets of open nodes that differ from `limit.open` only in given nodes.

    `shakedown_limit` searches the open nodes, and its bound holds only for the set of the result.
    `best_open_nodes` proves by branch and bound that no other set is better, or finds a better set.
    The result is exact for the given nodes. Theory, "Proof for given nodes".

    Parameters
    ----------
    limit
        A finite limit, from `shakedown_limit` or `ShakedownModel` without constraints.
    nodes
        (n,) numbers of the nodes that may open or close. Their 2^n sets are compared without
        enumeration. Good choices are nodes that touch, nodes at the border of the open nodes, and
        nodes of `limit.mechanism`.
    programs
        Largest number of programs. In the plane, 4 to 40 programs are usual for nodes that govern,
        and some hundreds for 20 nodes. In space, three times as many are usual. If it is reached,
        `bound` is the bound that is proven so far. Ctrl-C raises KeyboardInterrupt with an
        attribute `best`, this answer.
    solver, progress
        See `shakedown_limit`.

    Returns
    -------
    BestOpenNodes
        The best limit, its open nodes, and whether it is proven to be the best.

    Raises
    ------
    ModelError, SolverError
        Bad input; a limit that is not finite, with events, with a slip bound, or with user
        constraints or an objective.

    Examples
    --------
    Of all sets of open nodes of this contact, the search has found the best one.

    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0, 0], [1.0, -0.2, 1.0]), "Q": ([1, 0.2, 0.5], [0, 0, 0])}
    >>> A, B, C = 2 * np.eye(3), np.zeros((3, 3)), 2 * np.eye(3)
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1, 2], loads)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.shakedown_limit(system, cycle, friction=0.5)
    >>> best = fo.best_open_nodes(limit, range(3))
    >>> best.reason
    'no set of open nodes that differs only in 3 nodes has a limit above 0.5'
    """
    _check(limit)
    chosen = _checked_nodes(nodes, limit)
    most = whole_number("programs", programs, least=1)
    solver_order(solver, LP if limit.system.tangents == 1 else SOCP)
    with progress_bar(progress, "best open nodes", "program") as bar:
        return _BranchAndBound(limit, chosen, solver, bar).run(most)


def _check(limit: object) -> None:
    """ModelError if the open nodes of this limit cannot be compared."""
    if not isinstance(limit, ShakedownLimit):
        raise ModelError(
            f"limit: {shown(limit)}; give the answer of shakedown_limit or of ShakedownModel.solve"
        )
    reasons = {
        f"it is {limit.load_factor:g}, so there is nothing to compare; give a finite limit": (
            not np.isfinite(limit.load_factor)
        ),
        "loads alone open and close its nodes, and it holds for all openings and closings; "
        "no other nodes have a larger one": isinstance(limit._question, MovingAreas),
        "its nodes open and close in each cycle; call shakedown_limit without events": bool(
            limit._question.events
        ),
        "it has user constraints or an objective, which the proof does not include; compute it "
        "without them": bool(limit.constraints) or limit.objective is not None,
        "its slip is bounded, which does not hold for open nodes; compute it without slip_bound": (
            limit._question.slip_bound is not None
        ),
    }
    for reason, holds in reasons.items():
        if holds:
            raise ModelError(f"limit: {reason}")


def _checked_nodes(nodes: object, limit: ShakedownLimit) -> Integers:
    last = limit.system.nodes - 1
    values = list(nodes) if isinstance(nodes, range) else nodes
    numbers = np.unique(whole_array("nodes", values, (None,), least=0, most=last))
    if not len(numbers):
        raise ModelError("nodes: none; give the numbers of the nodes that may open or close")
    return numbers


class _BranchAndBound:
    """The remaining branches, and the best limit so far, which an interrupt keeps."""

    def __init__(
        self, limit: ShakedownLimit, nodes: Integers, solver: str | None, bar: Bar
    ) -> None:
        question = limit._question
        self._given_limit = limit
        self._question = question
        self._nodes = nodes
        self._bar = bar
        self._limits = ShakedownLimits(solver)
        open_outside = question.open_nodes.copy()
        open_outside[nodes] = False
        with_loose_closed = with_open(question, open_outside)
        assert with_loose_closed is not None  # fewer nodes are open than in the limit
        self._relaxed = LooseNodes(with_loose_closed, nodes, limit.load_factor, solver)

        none = np.zeros(len(nodes), dtype=bool)
        self._branches = [Branch(none, none)]
        self._best = limit
        # The bound of each set whose limit has been computed, see `_compare`.
        self._bounds = {limit.open.tobytes(): limit.bound}
        # Higher limits that are not safe at the best load factor.
        self._higher = list[ShakedownLimit]()
        # Largest bound of the branches that are done.
        self._bound = limit.bound
        self._programs = 0

    def run(self, most: int) -> BestOpenNodes:
        """The answer after all branches, or after the largest number of programs."""
        note = "the attribute `best` has the result proven so far"
        self._bar.keep("best", self._answer, note)
        while self._branches and self._programs < most:
            # An interrupt must find the branch that is being solved.
            self._branches[-1:] = self._parts(self._branches[-1])
        return self._answer()

    def _answer(self) -> BestOpenNodes:
        return BestOpenNodes(
            limit=self._best,
            given_limit=self._given_limit,
            nodes=self._nodes,
            bound=max(self._bound, *(branch.bound for branch in self._branches), self._best.bound),
            programs=self._programs,
            separate=tuple(self._higher),
        )

    def _parts(self, branch: Branch) -> list[Branch]:
        """Bound a branch; if the bound is above the best limit, return its two parts."""
        relaxed = Relaxed(branch.bound, 0.0)
        if branch.bound > _just_above(self._best):
            self._count()
            relaxed = self._relaxed.solve(branch, _just_above(self._best))
        branch = replace(branch, bound=min(branch.bound, relaxed.bound), basis=relaxed.basis)
        undecided = branch.undecided
        if not undecided.any():
            self._finish(branch)
            return []
        opens = branch.opens
        index = int(undecided.argmax())
        if relaxed.motion is not None and relaxed.pressure is not None:
            opens = np.where(undecided, relaxed.pressure <= relaxed.motion, branch.opens)
            index = _furthest(relaxed.motion, relaxed.pressure, undecided)
            between = np.minimum(relaxed.motion, relaxed.pressure)[undecided].max()
            if max(between, relaxed.excess) <= BRANCHES.decided:
                self._compare(opens)
        if branch.bound > _just_above(self._best):
            return branch.divided(index, open_first=bool(opens[index]))
        self._bound = max(self._bound, branch.bound)
        return []

    def _finish(self, branch: Branch) -> None:
        """Bound the limit of a branch that is one set."""
        bound = branch.bound
        if bound > _just_above(self._best):
            bound = min(bound, self._compare(branch.opens))
        self._bound = max(self._bound, bound)

    def _compare(self, opens: Booleans) -> float:
        """Compute the limit of one set, and keep it if it is the best one; returns its bound.

        `opens` (n,) are the loose nodes that are open. The bound is -inf if the set has no limit or
        a separate one, and inf if no solver's answer passes the checks.
        """
        open_nodes = self._question.open_nodes.copy()
        open_nodes[self._nodes] = opens
        key = open_nodes.tobytes()
        if key not in self._bounds:
            self._bounds[key] = np.inf
            with suppress(SolverError):
                self._bounds[key] = self._of_set(open_nodes)
        return self._bounds[key]

    def _of_set(self, open_nodes: Booleans) -> float:
        """See `_compare`."""
        question = None if open_nodes.all() else with_open(self._question, open_nodes)
        if question is None:
            return -np.inf
        self._count()
        limit = self._limits.of_set(question)
        if np.isnan(limit.load_factor):
            return -np.inf
        if limit.load_factor <= _just_above(self._best):
            return limit.bound
        self._higher.append(limit)
        self._keep_best()
        return -np.inf if limit in self._higher else limit.bound

    def _keep_best(self) -> None:
        """Take higher limits as the best one, as long as one is safe at the best load factor."""
        while True:
            reach = _just_above(self._best)
            counts = [limit for limit in self._higher if not limit.least > reach]
            if not counts:
                return
            highest = max(counts, key=lambda limit: limit.load_factor)
            self._best = replace(highest, least=min(self._best.least, highest.least))
            above = _just_above(self._best)
            self._higher = [limit for limit in self._higher if limit.load_factor > above]

    def _count(self) -> None:
        self._programs += 1
        self._bar.update()


def _furthest(motion: Array, pressure: Array, undecided: Booleans) -> int:
    """The undecided node that is furthest from open and closed, relative to the largest values."""
    between = np.minimum(_shares(motion[undecided]), _shares(pressure[undecided]))
    return int(np.flatnonzero(undecided)[between.argmax()])


def _shares(values: Array) -> Array:
    """Values above 0 relative to the largest of them."""
    values = np.maximum(values, 0.0)
    return np.asarray(values / (values.max() or 1.0))


def _just_above(limit: ShakedownLimit) -> float:
    """The load factor above which a limit is higher than this one."""
    unit = FLOOR * limit._question.load_unit
    return limit.load_factor + BRANCHES.gain * max(limit.load_factor, unit)
