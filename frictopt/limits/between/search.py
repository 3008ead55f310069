"""The first-order method that finds rough states and multipliers: primal-dual hybrid gradient.

Each step takes one product with T and one with its transpose (`cones.py`). The steps are reflected
and anchored (Halpern). If the error has fallen, they begin anew from the last state (restarts of
PDLP, Applegate et al. 2021; Lu and Yang 2024). There is no proven number of steps, but no proof
needs one.

`FrictionBracket` finds the least friction with a safe slip at one load factor. For a given
friction, the search finds the largest value of the least room of a row, which proves that this
friction is enough or too little. The room of a row is its bound minus the size of its shear. These
proofs narrow a bracket from both ends. A safe point needs no more friction than its largest ratio
of shear to pressure.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...base import FLOOR, Array, progress_bar, worst
from ...contact.law import reach
from ..program.question import Question
from ..program.solution import Mechanism
from .cones import Cones, Point, margins, mechanism_of, raised, towards, work_of_stress

# A search for a better point begins at these shares of the way from the best point back to the
# first one: at the best point itself, the rows that limit it may forbid every step.
_BACK = (0.5, 0.1, 0.01, 0.0)
# Above this load factor, in units of `Question.load_unit`, the limit seems to be infinite; the
# exact program decides.
_FAR = 1e4
# Rough products reduce a stress to this share before an exact product measures it.
_REFRESH = 1e-3


class SafePoints:
    """The best safe point so far. `grows` says whether its load factor may grow without end."""

    def __init__(self, cones: Cones) -> None:
        self._cones = cones
        self._first: Point | None = None
        self.best: Point | None = None
        self.grows = False

    @property
    def load_factor(self) -> float:
        """The largest load factor that is proven to be safe."""
        return -np.inf if self.best is None else self.best.load_factor

    def try_towards(self, rough: Point) -> None:
        """Go from safe points towards a rough one, as far as rows allow; raise the load there."""
        if self._first is None or self.best is None:
            if margins(rough.rows).min() >= 0:
                self.best = rough
                self._rise(rough)
                # Half way up, all rows have room.
                self._first = towards(rough, self.best, 0.5)
            return
        start = self.best
        for share in _BACK:
            base = towards(start, self._first, share)
            length = _reach(base.rows, rough.rows - base.rows)
            # Beyond the rough point there is no reason to expect better points.
            self._rise(towards(base, rough, min(length, 1.0)))

    def _rise(self, point: Point) -> None:
        """Raise the load factor with the same residual shear; keep the point if it is the best."""
        rate = self._cones.rate
        more = _reach(point.rows, rate)
        self.grows |= point.load_factor + more > _FAR
        if np.isfinite(more) and point.load_factor + more > self.load_factor:
            self.best = Point(point.load_factor + more, point.shear, point.rows + more * rate)


def _reach(rows: Array, direction: Array) -> float:
    """How far one can go in a direction from sides that obey all rows; inf without a limit."""
    q0, q1 = (np.moveaxis(sides[:, :-1], 1, -1) for sides in (rows, direction))
    return float(reach(q0, rows[:, -1], q1, direction[:, -1]).min().clip(0.0))


class Multipliers(NamedTuple):
    """Moves (K, t + 1, R) of the rows, on which the cyclic loads do unit work, and their bound.

    The moves prove that no load factor above `bound` is safe. `bound` is inf if they prove nothing,
    and below 0 if they prove that no load factor is safe.
    """

    moves: Array
    bound: float


def mechanism(cones: Cones, moves: Array, rounds: int, enough: float, usable: float) -> Multipliers:
    """Rough multipliers as a mechanism, by at most `rounds` rough products.

    The rounds end if the sum of the stresses, relative to the largest move, is at most `enough`. If
    it stays above `usable`, the multipliers prove nothing, because residual shear may be larger
    than its unit.
    """
    rough = cones.roughly()
    closed = cones.closed
    node = cones.node[closed]
    moves = raised(moves)
    stress = cones.stress(moves)
    while rounds > 0 and np.abs(stress).sum() > enough * np.abs(moves).max():
        first, last = moves, stress
        # For small changes, rough products are exact enough until the stress has fallen.
        while rounds > 0 and np.abs(last).sum() > _REFRESH * np.abs(stress).sum():
            moves = moves.copy()
            moves[:, :-1, closed] -= last[:, node] / len(moves)
            moves = raised(moves)
            last = stress + rough.stress(moves - first)
            rounds -= 1
        stress = cones.stress(moves)
    if np.abs(stress).sum() > usable * np.abs(moves).max():
        return Multipliers(moves, np.inf)
    # The stress does work on residual shear of up to `Question.force` at each node.
    value = float((moves * cones.start).sum() + np.abs(stress).sum())
    drive = -float((moves * cones.rate).sum())
    if drive > 0:
        return Multipliers(moves / drive, value / drive)
    return Multipliers(moves, -np.inf if value < 0 else np.inf)


# Numbers of the method, which were tried on punches, pins, dovetails and random contacts.

# Largest number of steps.
_MOST = 3000
# Numbers of steps between two checks of the bounds, and between two looks at the error.
_CHECK = 25
_LOOK = 10
# A restart is due in three cases: the error has fallen to the share `_FALLEN` of its value at the
# last restart; it has fallen to `_RISING` and rises again; or the share `_LONG` of all steps has
# passed.
_FALLEN = 0.2
_RISING = 0.8
_LONG = 0.36
# Least number of steps without a restart, if the error does not fall.
_SHORT = 60
# Size of the column of the load factor, relative to the norm of the other columns.
_LOAD = 0.3
# Largest weight of the unknowns relative to the multipliers, and the inverse of the least weight.
_HEAVIEST = 1e6
# Length of a step, relative to the largest that converges.
_STEP = 0.95
# Number of power steps for the norm, and the factor by which their result may be too small.
_POWERS = 8
_SHORT_BY = 1.1
# Rounds, `enough` and `usable` of `mechanism`, for multipliers that guide the search, and for
# multipliers that prove a bound.
_GUIDE = (8, 1e-5, 1e-3)
_PROOF = (300, 1e-12, 1e-10)


class State(NamedTuple):
    """A state of the method, all of whose parts are linear in the unknowns and multipliers."""

    load: float
    shear: Array  # (t, N)
    rows: Array  # (K, t + 1, R) sides of the rows
    moves: Array  # (K, t + 1, R) multipliers
    stress: Array  # (t, N) of the multipliers
    drive: float  # drive of the multipliers: -1 at the optimum


def search(cones: Cones, gap: float) -> Method:
    """Look for a safe point and multipliers whose load factors are within a relative gap."""
    first = cones.at(0.0, cones.relaxed())
    if margins(first.rows).min() < 0:
        room = most_room(cones).safe.best
        assert room is not None
        first = cones.at(0.0, room.shear)
    return _run(Method(cones, first, gap))


def most_room(cones: Cones) -> Method:
    """Look for residual shear that is safe at load factor 0, or for a proof that there is none.

    The least room of a row takes the place of the load factor. This room is counted from one unit
    below the least room of the first state. A room above `Method.enough` proves that the shear is
    safe. An upper bound of the room below `Method.enough` proves that no shear is safe.
    """
    first = cones.at(0.0, cones.relaxed())
    least = float(margins(first.rows).min()) - 1.0
    rate, start = np.zeros_like(cones.rate), cones.start.copy()
    rate[:, -1] = -1.0
    start[:, -1] -= least
    of_room = replace(cones, rate=rate, start=start)
    return _run(Method(of_room, of_room.at(0.0, first.shear), 0.0, -least))


def _run(method: Method) -> Method:
    """Take steps until the method is done."""
    with progress_bar(True, "limit within a gap", "step", total=_MOST) as bar:
        while not method.done and method.steps < _MOST:
            method.advance()
            bar.update()
    if not method.done:
        method.prove()
    return method


class Method:
    """The method from a first state on.

    Its results are its `safe` points, its `multipliers` and its `steps`. It is done if the load
    factors that the safe points and the multipliers prove are within the gap, or if it is proven on
    which side of `enough` the limit lies.
    """

    def __init__(self, cones: Cones, first: Point, gap: float, enough: float = np.nan) -> None:
        self._cones = cones
        self._rough = cones.roughly()
        self._gap = gap
        self.enough = enough
        self.steps = 0
        self.done = False
        self.safe = SafePoints(cones)
        self.multipliers = Multipliers(np.zeros_like(cones.start), np.inf)
        # Points and multipliers from rough products, which show when exact products are worth
        # while.
        self._points = SafePoints(self._rough)
        self._likely = self.multipliers

        norm = _norm(self._rough)
        size = float(np.linalg.norm(cones.rate)) or 1.0
        self._load_scale = _LOAD * norm / size
        self._step = _STEP / (norm * float(np.hypot(1, _LOAD)))
        self._weight = 1.0

        self.first = first
        self.safe.try_towards(first)
        self._points.try_towards(first)
        load = max(self.safe.load_factor, first.load_factor)
        shear = first.shear
        still = np.zeros_like(self._rough.start)
        rows = self._rough.at(load, shear).rows
        self._begin(State(load, shear, rows, still, np.zeros_like(shear), 0.0))

    def _begin(self, state: State) -> None:
        """Anchor the following steps at a state."""
        self._state = self._anchor = state
        self._first_error = self._last_error = self._error(state)
        self._since = 0

    def advance(self) -> None:
        """Make a step, and check its error and the bounds if this is due."""
        new = self._stepped(self._state)
        self.steps += 1
        self._since += 1
        share = self._since / (self._since + 1)
        self._state = towards(self._anchor, towards(self._state, new, 2.0), share)
        if self.steps % _CHECK == 0:
            self._check(new)
        if self.steps % _LOOK == 0:
            self._look(new)

    def _stepped(self, state: State) -> State:
        cones = self._rough
        along, against = self._step / self._weight, self._step * self._weight
        shear = state.shear + along * state.stress
        load = max(state.load + along * self._load_scale**2 * (1 + state.drive), 0.0)
        rows = cones.at(load, shear).rows
        moves = _in_cones(state.moves - against * (2 * rows - state.rows))
        drive = float((moves * cones.rate).sum())
        return State(load, shear, rows, moves, cones.stress(moves), drive)

    def _error(self, state: State) -> float:
        """Violation of the rows, imbalance of the multipliers, and the gap, in one number."""
        unsafe = np.linalg.norm(_in_cones(state.rows) - state.rows)
        unbalanced = np.hypot(np.linalg.norm(state.stress), self._load_scale * (1 + state.drive))
        apart = state.load - float((state.moves * self._rough.start).sum())
        return float(np.hypot(np.hypot(self._weight * unsafe, unbalanced / self._weight), apart))

    def _look(self, new: State) -> None:
        """Restart at a step if its error says so, with a new weight of the unknowns."""
        error = self._error(new)
        fallen = error / (self._first_error or 1.0)
        due = fallen <= _FALLEN or (fallen <= _RISING and error > self._last_error)
        self._last_error = error
        if not due and self._since < max(_LONG * self.steps, _SHORT):
            return
        by_shear = np.linalg.norm(new.shear - self._anchor.shear)
        by_load = (new.load - self._anchor.load) / self._load_scale
        unknowns = np.hypot(by_shear, by_load)
        moves = np.linalg.norm(new.moves - self._anchor.moves)
        if unknowns > 0 and moves > 0:
            weight = np.sqrt(self._weight * moves / unknowns)
            self._weight = float(weight.clip(1 / _HEAVIEST, _HEAVIEST))
        self._begin(new)

    def _check(self, new: State) -> None:
        """Try to improve the bounds by a step. If they seem close enough, prove them and end."""
        self._points.try_towards(self._rough.at(new.load, self._cones.balanced(new.shear)))
        likely = mechanism(self._rough, new.moves, *_GUIDE)
        if likely.bound < self._likely.bound:
            self._likely = likely
        if self._ends(self._points, self._likely):
            self.prove()
            self.done = self._ends(self.safe, self.multipliers)

    def _ends(self, safe: SafePoints, multipliers: Multipliers) -> bool:
        """Whether the bounds are close enough, or are known not to be finite."""
        low, high = safe.load_factor, multipliers.bound
        close = np.isfinite(high) and high - low <= self._gap * max(high, FLOOR)
        decided = low > self.enough or high < self.enough
        return bool(close or decided or high < 0 or safe.grows)

    def prove(self) -> None:
        """Prove the bounds with exact products, after all stress is taken from the multipliers."""
        best = self._points.best
        if best is not None:
            self.safe.try_towards(self._cones.at(best.load_factor, best.shear))
        self.multipliers = mechanism(self._cones, self._likely.moves, *_PROOF)


def _norm(cones: Cones) -> float:
    """An upper estimate of the norm of the rows of all corners, as functions of the shear."""
    size = cones.start.shape[1] - 1, cones.pressing.shape[0]
    shear = np.random.default_rng(0).normal(size=size)
    shear = cones.balanced(shear)
    norm = 1.0
    for _ in range(_POWERS):
        shear /= np.linalg.norm(shear) or 1.0
        shear = cones.stress(cones.effects(shear)[None])
        norm = float(np.linalg.norm(shear))
    return _SHORT_BY * float(np.sqrt(len(cones.start) * max(norm, 1.0)))


def _in_cones(rows: Array) -> Array:
    """The nearest sides (K, t + 1, R) that obey `|shear| <= bound`."""
    size = np.linalg.norm(rows[:, :-1], axis=1)
    bound = rows[:, -1]
    mean = ((size + bound) / 2).clip(0.0)
    inside = size <= bound
    new = np.where(inside, bound, mean)
    share = np.where(inside, 1.0, mean / np.where(size > 0, size, 1.0))
    return np.concatenate([rows[:, :-1] * share[:, None], new[:, None]], axis=1)


# Numbers of the search for the least friction.

# Frictions that are tried until one is enough; in programs, larger ones act like infinite friction.
TRIED = tuple(4.0**k for k in range(8))
# Ratio `too_little / enough` that is assumed as long as no friction is proven too little.
_LOWER = 1 / 16
# If the two frictions are within three gaps, the next friction is this share of the gap below
# `enough`. If this friction is too little, the bracket is within the gap. The next friction lies
# close to `enough`, because `enough` is usually the better of the two.
_CLOSE, _SHARE = 3.0, 0.9


class FrictionBracket:
    """The largest friction that is proven too little, and the smallest that is proven enough.

    Attributes
    ----------
    too_little, enough
        The two frictions. At first they are 0, and the friction that is needed by the residual
        shear of a contact without friction.
    moves
        Multipliers (K, t + 1, R) that prove that no slip is safe with `too_little`.
    shear
        (t, N) residual shear that is safe with `enough`.
    steps
        Number of steps of all searches.
    """

    def __init__(self, cones: Cones, load_factor: float) -> None:
        """Start from `cones` with a friction of 1 and all nodes closed."""
        start = cones.start + load_factor * cones.rate
        self._cones = replace(cones, start=start, rate=np.zeros_like(start))
        self.shear = self._cones.relaxed()
        self.too_little, self.enough = 0.0, self._enough_for(self.shear)
        self.moves = np.zeros_like(start)
        self.steps = 0

    def _with_friction(self, friction: float) -> Cones:
        """The cones at the load factor, with this friction."""
        start = self._cones.start.copy()
        start[:, -1] *= friction
        return replace(self._cones, slope=friction * self._cones.slope, start=start)

    def narrow(self, gap: float, smallest: float) -> None:
        """Try frictions until the two are within a relative gap, or neither proof is found.

        The search also ends if the friction `smallest` is proven to be enough.
        """
        for friction in TRIED:
            if self.enough < np.inf or not self._try(friction):
                break
        while smallest < self.enough < np.inf and not self.is_within(gap):
            ratio = self.too_little / self.enough or _LOWER
            first = np.sqrt(ratio)
            if ratio > 1 - _CLOSE * gap:
                first = max(first, 1 - _SHARE * gap)
            # Very close to the least friction neither proof is found. Then one more friction is
            # tried, nearer to `enough`.
            if not any(self._try(self.enough * share) for share in (first, np.sqrt(first))):
                break

    def is_within(self, gap: float) -> bool:
        """Whether the two frictions are within a relative gap."""
        return self.enough - self.too_little <= gap * self.enough

    def _try(self, friction: float) -> bool:
        """Look for a proof that a friction is enough or too little; True if the bracket shrinks."""
        before = self.too_little, self.enough
        found = most_room(self._with_friction(friction))
        self.steps += found.steps
        assert found.safe.best is not None
        shear = found.safe.best.shear
        enough = self._enough_for(shear)
        if enough < self.enough:
            self.enough, self.shear = enough, shear
        if found.multipliers.bound < found.enough and friction > self.too_little:
            self.too_little, self.moves = friction, found.multipliers.moves
        return before != (self.too_little, self.enough)

    def proof(self, question: Question) -> tuple[Mechanism, float]:
        """The mechanism that proves that the friction of the question is `too_little`; its error.

        The error is the larger of two: the violation of a row by `shear`; and the work that the
        multipliers do because they do not balance exactly, divided by the sum of their lifts.
        """
        rows = self._with_friction(self.enough).at(0.0, self.shear).rows
        cones = self._with_friction(self.too_little)
        moves = raised(self.moves)
        work = work_of_stress(cones, moves, self.shear)
        wrong = max(work, float((moves * cones.start).sum()) + work)
        error = wrong / (float(moves[:, -1].sum()) or 1.0)
        return mechanism_of(question, cones, moves), worst([-margins(rows).min(), error])

    def _enough_for(self, shear: Array) -> float:
        """The least friction with which residual shear (t, N) is safe; inf if it opens a node."""
        rows = self._cones.at(0.0, shear).rows
        pressure = rows[:, -1]
        if pressure.min() <= 0:
            return np.inf
        return float((np.linalg.norm(rows[:, :-1], axis=1) / pressure).max())
