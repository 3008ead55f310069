"""Verification of the guaranteed limit by transients.

Just above the limit the transients start from its witness; just below, from many slips.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.contact import lengths, parted, reactions
from frictopt.limits import pose
from frictopt.limits.program.rest_slips import Furthest, Rests

NO_OUTCOME = "NO_CONTINUATION"


@dataclass(frozen=True)
class CheckSettings:
    """Numbers of the verification."""

    # Load factor of the tests below the limit, as a share of the interval from the least safe load
    # factor to the limit.
    below: float = 0.98
    # Largest change of the slip of a moved witness, relative to its largest slip.
    moved: float = 1e-3
    # If the limit is the least safe load factor: distance of the tests above it, as a share of the
    # interval up to lambda_2, or up to the load factor at which the cyclic reactions reach the mean
    # pressures.
    small_load: float = 0.02
    # Multiples of the distance above the limit that are also tested. If the load presses the
    # contact, a smaller load can be worse.
    near: tuple[float, float] = (0.9, 1.1)
    # Share of the starts that are vertices of the set of safe slips. The same number of starts are
    # multiples of these vertices, up to `largest_multiple`.
    vertices: float = 0.2
    largest_multiple: float = 3.0
    # Powers of ten between which the size of random slips lies, relative to the largest slip of the
    # witness.
    decades: tuple[float, float] = (-1.0, 2.0)
    # Increments from corner to corner in space. The number of increments does not affect whether
    # slip persists.
    steps: int = 2


SETTINGS = CheckSettings()


@dataclass(frozen=True)
class GuaranteeCheck:
    """The verification of a guaranteed limit by transients.

    Attributes
    ----------
    limit
        The limit that is verified.
    runs
        DataFrame, one row for each transient. Columns: load_factor; share, load factor divided by
        the limit (inf if the limit is 0); start, "witness", "moved witness", "vertex", "beyond
        vertex" or "random"; moved, for a witness the largest change of slip relative to the largest
        slip; outcome, the name of an `Outcome`, or "NO_CONTINUATION" if the path ends early or its
        slip is too small; dissipation, work of friction per cycle in the steady state; cycles;
        residual. Dissipation and residual are NaN without a steady state.
    starts
        (rows of runs, N) or (rows of runs, N, 2) the initial slips, length.
    """

    limit: fo.results.GuaranteedLimit
    runs: pd.DataFrame
    starts: np.ndarray

    @property
    def dies_out(self) -> bool:
        """Whether no transient below the limit slips for ever; some may have no outcome."""
        return not self._persisting(below=True).any()

    @property
    def persists(self) -> bool:
        """Whether above the limit a transient from the witness or close to it slips for ever.

        If the limit is lambda_2 (`limit.node` is None), there is no witness, and a contact that
        lifts off may stop slipping above it.
        """
        return bool(self._persisting(below=False).any())

    @property
    def undecided(self) -> int:
        """Number of transients without an outcome: the path ends, or its slip is too small."""
        return int((self.runs["outcome"] == NO_OUTCOME).sum())

    @property
    def residual(self) -> float:
        """Largest residual of the limit and of the transients that have an outcome."""
        return float(np.nanmax([self.limit.residual, *self.runs["residual"]]))

    @property
    def counterexamples(self) -> np.ndarray:
        """(M, N) or (M, N, 2) starts that keep slipping below the limit, length."""
        return np.asarray(self.starts[self._persisting(below=True)])

    def _persisting(self, *, below: bool) -> np.ndarray:
        """Which runs slip for ever, either below the limit or above it."""
        slips = ~self.runs["outcome"].isin([fo.Outcome.SHAKEDOWN.name, NO_OUTCOME])
        is_below = self.runs["share"] < 1
        return np.asarray(slips & (is_below == below))


class _Test(NamedTuple):
    """A transient that is followed: its load factor, the kind of its start, and its slip."""

    load_factor: float
    kind: str
    slip: np.ndarray


def verify(
    limit: fo.results.GuaranteedLimit,
    *,
    starts: int = 1000,
    moved: int = 5,
    above: float = 1.02,
    seed: int = 0,
) -> GuaranteeCheck:
    """Follow transients from the witness just above the limit, and from many starts just below it.

    Each transient begins at the mean of the load corners, where a contact with a safe slip sticks.
    The mean load may differ from this mean. The starts below the limit are vertices of the set of
    safe slips (at the load factor, and under the mean load), multiples of these vertices by factors
    up to three, and random slips of a tenth to a hundred times the size of the witness. If the mean
    load is not safe, half of the starts are tested just above the least safe load factor. Load
    factors below it are not tested.

    If nodes are open, all starts below the limit are random. If friction at the closed nodes can
    hold the slip of a start, the transient begins with the gaps that the open nodes have under this
    slip. Otherwise it begins with all nodes closed. Starts with nodes that open and close in every
    cycle may slip for ever below the limit.

    `starts` is the number of starts below the limit, and `moved` the number of starts above it that
    differ from the witness by up to a thousandth of its largest slip. `above` is the load factor of
    the tests above the limit, divided by the limit. The tests below the limit are at 98 % of the
    interval from the least safe load factor to the limit.

    If the limit is the least safe load factor, usually 0, there are no tests below the limit. The
    tests above it are then at 2 % of an interval that begins at the limit. The interval ends at
    lambda_2, or at the load factor at which the cyclic reactions reach the mean pressures,
    whichever is smaller. Only some starts near the witness slip for ever at this load factor. So
    the study also follows a slip that makes the node critical there, at 0.9 and 1.1 times the
    distance from the limit. A ValueError names a limit without a load to test at.
    """
    rng = np.random.default_rng(seed)
    upper = limit.shakedown.load_factor
    if not np.isfinite(limit.load_factor) or not upper > limit.least:
        raise ValueError(
            f"guaranteed limit {limit.load_factor:g} between the least safe load factor "
            f"{limit.least:g} and lambda_2 = {upper:g}: there is no load to test at"
        )
    pressure, largest = _load_sizes(limit)
    size = float(np.abs(limit.slip).max())
    if size == 0:
        size = (pressure or largest) / limit.system.stiffness_scale

    small = limit.least + SETTINGS.small_load * min(upper - limit.least, pressure / largest)
    near_least = limit.witness_above_least(small) if small > limit.least else None
    high = above * limit.load_factor if near_least is None else small
    changes = SETTINGS.moved * size * rng.uniform(-1.0, 1.0, (moved, *limit.system.slip_shape))
    tests = [_Test(high, "witness", limit.slip)]
    tests += [_Test(high, "moved witness", limit.slip + change) for change in changes]
    if near_least is None:
        tests += _tests_below(rng, limit, starts, size)
    else:
        load_factor, slip = near_least
        way = load_factor - limit.least
        tests += [_Test(limit.least + share * way, "witness", slip) for share in SETTINGS.near]
    rows = [_row(limit, size, test) for test in tests]
    return GuaranteeCheck(limit, pd.DataFrame(rows), np.array([test.slip for test in tests]))


def _load_sizes(limit: fo.results.GuaranteedLimit) -> tuple[float, float]:
    """Mean pressure force at load factor 0, which may be 0, and largest cyclic reaction."""
    _, p = limit.cycle.unscaled_reactions(limit.system)
    cyclic = limit.cycle.corner_reactions(limit.system)
    return float(np.abs(p).mean()), max(float(np.abs(part).max()) for part in cyclic)


def _tests_below(
    rng: np.random.Generator, limit: fo.results.GuaranteedLimit, count: int, size: float
) -> list[_Test]:
    """Tests just below the limit; if the mean load is not safe, half of them just above `least`."""
    least = limit.least
    shares = [SETTINGS.below] if least == 0 else [SETTINGS.below, 1 - SETTINGS.below]
    tests = list[_Test]()
    for number, share in enumerate(shares):
        load_factor = share * limit.load_factor + (1 - share) * least
        part = (count + number) // len(shares)
        tests += _tests_at(rng, limit, load_factor, part, size)
    return tests


def _tests_at(
    rng: np.random.Generator,
    limit: fo.results.GuaranteedLimit,
    load_factor: float,
    count: int,
    size: float,
) -> list[_Test]:
    """Tests at one load factor: vertices of the safe slips, multiples of them, random slips."""
    shape = limit.system.slip_shape
    wanted = 0 if limit.open.any() else int(SETTINGS.vertices * count)
    directions = rng.normal(size=(wanted, *shape))
    # Half of the vertices are for the mean load alone, if it is safe.
    under_mean = 0.0 if limit.least == 0 else load_factor
    half = wanted // 2
    vertices = _vertices(limit, load_factor, directions[:half])
    vertices += _vertices(limit, under_mean, directions[half:])

    tests = [_Test(load_factor, "vertex", slip) for slip in vertices]
    for slip in vertices:
        multiple = rng.uniform(1.0, SETTINGS.largest_multiple)
        tests.append(_Test(load_factor, "beyond vertex", slip * multiple))
    while len(tests) < count:
        random_size = size * 10 ** rng.uniform(*SETTINGS.decades)
        tests.append(_Test(load_factor, "random", random_size * rng.normal(size=shape)))
    return tests


def _vertices(
    limit: fo.results.GuaranteedLimit, load_factor: float, directions: np.ndarray
) -> list[np.ndarray]:
    """For each direction, the safe slip whose tractions go furthest along it, if there is one."""
    question = pose(limit.system, limit.cycle, limit.friction, simplify=False)
    unit = np.tile(question.node_unit, limit.system.tangents)
    by_slip = [question.A @ (direction.T.ravel() / unit) for direction in directions]
    furthest = Furthest(Rests(question, load_factor))
    return [slip for slip in map(furthest.along, by_slip) if slip is not None]


def _row(limit: fo.results.GuaranteedLimit, size: float, test: _Test) -> dict[str, Any]:
    """Follow a transient, and return its row in the table of runs."""
    above_zero = limit.load_factor > 0
    is_witness = "witness" in test.kind
    row: dict[str, Any] = {
        "load_factor": test.load_factor,
        "share": test.load_factor / limit.load_factor if above_zero else np.inf,
        "start": test.kind,
        "moved": float(np.abs(test.slip - limit.slip).max() / size) if is_witness else np.nan,
    }
    try:
        steady = fo.steady_state(
            limit.system,
            from_its_middle(limit.cycle, test.load_factor),
            limit.friction,
            1.0,
            **_beginning(limit, test),
            steps=None if limit.system.tangents == 1 else SETTINGS.steps,
        )
    except fo.NoContinuation:
        return row | {"outcome": NO_OUTCOME, "dissipation": np.nan, "cycles": 0, "residual": np.nan}
    # If slip has nearly died out, its work is smaller than the error of this work.
    row["outcome"] = steady.outcome.name if steady.work_error < 1 else NO_OUTCOME
    return row | {name: getattr(steady, name) for name in ("dissipation", "cycles", "residual")}


def _beginning(limit: fo.results.GuaranteedLimit, test: _Test) -> dict[str, Any]:
    """Argument of `steady_state` for a transient that begins at the mean of the corners.

    The argument is a state if nodes are open and the closed nodes can hold the slip, else a slip.
    """
    question = limit._question
    system = question.system
    if not limit.open.any():
        return {"initial_slip": test.slip}
    # States are linear in the load, so the state at the mean load of the corners is the mean of the
    # states.
    u, r = question.states(test.load_factor, test.slip)
    bonded = reactions(system, limit.cycle.at(test.load_factor))
    (v, w), (q, p), load = (
        parted(part.reshape(len(part), -1).mean(axis=0), system.tangents + 1)
        for part in (u, r, bonded)
    )
    sticks = (lengths(q, p) <= limit.friction * p).all()
    if sticks and (w[limit.open] >= 0).all():
        return {"initial_state": fo.ContactState(v, w.clip(0.0), *load)}
    return {"initial_slip": v}


def from_its_middle(cycle: fo.LoadCycle, load_factor: float) -> fo.LoadCycle:
    """The loads at a load factor, as a cycle at load factor 1 about the mean of its corners."""
    corners = cycle.at(load_factor)
    names = sorted({name for loads in corners for name in loads})
    middle = {name: float(np.mean([corner.get(name, 0.0) for corner in corners])) for name in names}
    changes = [{name: corner.get(name, 0.0) - middle[name] for name in names} for corner in corners]
    return fo.LoadCycle(middle, changes)
