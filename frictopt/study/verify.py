"""Verification of the guaranteed limit: transients from its witness just above it, and from many starts just below."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ..base import (
    LARGEST_SEED,
    Array,
    Kept,
    Outcome,
    finite_number,
    frozen,
    warns_of_odd_values,
    whole_number,
)
from ..contact import ContactState, LoadCycle, lengths, parted, reactions
from ..errors import ModelError, NoContinuation
from ..limits import GuaranteedLimit, safe_vertices
from ..limits.guaranteed import checked_guaranteed
from ..transients import steady_state

NO_OUTCOME = "NO_CONTINUATION"
# load factor of the test below the limit, on the way to it from the least safe load factor
_BELOW = 0.98
_MOVED = 1e-3  # largest change of the slip of a moved witness, over its largest slip
# load factor just above the least safe one, on the way to lambda_2 or to where cyclic reactions
# reach the mean pressures
_SMALL_LOAD = 0.02
_NEAR = (
    0.9,
    1.1,
    # multiples of that load factor that are tested: if the load presses the contact, less load can be
    # worse
)
# share of the starts at vertices of the set of safe slips; as many starts are beyond these vertices
_VERTICES = 0.2
_BEYOND = 3.0  # largest multiple of a vertex that is a start
# increments from corner to corner in space, where slip begins and ends at the same load whatever
# their number
_STEPS = 2
_DECADES = (
    -1.0,
    2.0,
)  # powers of ten of the size of random slips, over the largest slip of the witness


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteeCheck(Kept):
    """The verification of a guaranteed limit by transients.

    Attributes
    ----------
    limit
        The limit that is verified.
    runs
        DataFrame, one row for each transient. Columns: load_factor; share, load factor over the
        limit (inf if the limit is 0); start, "witness", "moved witness", "vertex", "beyond vertex"
        or "random"; moved, for a witness the largest change of slip over the largest slip; outcome,
        the name of an `Outcome`, or "NO_CONTINUATION" if the path ends early or slips too little to
        tell; dissipation, work of friction per cycle in the steady state; cycles; residual.
        Dissipation and residual are NaN without a steady state.
    starts
        (rows of runs, N) or (rows of runs, N, 2) the initial slips, length.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"N": ([0.0], [1.0]), "F": ([-1.0], [0.0])}
    >>> slider = fo.ContactSystem.from_blocks([[3.0]], [[0.0]], [[1.0]], [0.0], loads)
    >>> limit = fo.guaranteed_limit(slider, fo.LoadCycle({"N": 1.0}, [{"F": 1.0}, {"F": -1.0}]), friction=0.6)
    >>> check = fo.verify(limit, starts=4, moved=0)
    >>> sorted(check.runs.loc[check.runs["share"] < 1, "outcome"].unique())
    ['SHAKEDOWN']
    """

    limit: GuaranteedLimit
    runs: pd.DataFrame
    starts: Array

    @property
    def dies_out(self) -> bool:
        """Whether every transient below the limit stops slipping; transients without an outcome do not count."""
        return not self._persisting(below=True).any()

    @property
    def persists(self) -> bool:
        """Whether a transient above the limit slips for ever, from the witness or from a slip close to it.

        If the limit is lambda_2 (`limit.node` is None), there is no witness, and a contact that
        lifts off may stop slipping above it.
        """
        return bool(self._persisting(below=False).any())

    @property
    def undecided(self) -> int:
        """Number of transients without an outcome, because their path ends, or slips too little to tell."""
        return int((self.runs["outcome"] == NO_OUTCOME).sum())

    @property
    def residual(self) -> float:
        """Largest residual of the limit and of the transients that have an outcome."""
        return float(np.nanmax([self.limit.residual, *self.runs["residual"]]))

    @property
    def counterexamples(self) -> Array:
        """(M, N) or (M, N, 2) starts that keep slipping below the limit, length."""
        return frozen(self.starts[self._persisting(below=True)])

    def _answer(self) -> Mapping[str, object]:
        said = {
            name: getattr(self, name) for name in ("dies_out", "persists", "undecided", "residual")
        }
        return {"load_factor": self.limit.load_factor, "runs": len(self.runs), **said}

    def _persisting(self, *, below: bool) -> np.ndarray:
        runs = self.runs
        slips = ~runs["outcome"].isin([Outcome.SHAKEDOWN.name, NO_OUTCOME])
        return np.asarray(slips & ((runs["share"] < 1) == below))


@warns_of_odd_values
def verify(
    limit: GuaranteedLimit,
    *,
    starts: int = 1000,
    moved: int = 5,
    above: float = 1.02,
    seed: int = 0,
) -> GuaranteeCheck:
    """Follow transients from the witness just above the limit, and from many starts just below; returns a `GuaranteeCheck`.

    Each transient begins at the mean of the load corners, where a contact with a safe slip sticks;
    the mean load may be another load. The starts below the limit are vertices of the set of safe
    slips (at the load factor, and under the mean load alone), up to three times these vertices, and
    random slips of a tenth to a hundred times the size of the witness. If none of them slips for
    ever, this is evidence, not a proof. Where the mean load alone is not safe, half of them are
    next to the least safe load factor: nothing is said of load factors below it.

    Where nodes are open, all starts below the limit are random. A slip that the closed nodes can
    hold begins with the others open as it leaves them, any other one with all nodes closed. Starts
    from which nodes open and close in every cycle may slip for ever below the limit.

    Parameters
    ----------
    limit
        A guaranteed limit, of `guaranteed_limit` or `GuaranteedModel`.
    starts, seed
        Number of starts below the limit, and the seed of the random ones.
    moved
        Number of starts above the limit that differ from the witness by up to a thousandth of its
        largest slip.
    above
        Load factor of the test above the limit, over the limit. The test below is at 98 % of the
        way to it from the least safe load factor. If the limit is the least safe load factor,
        mostly 0, there is no test below, and the test above is further by 2 % of the way to
        lambda_2, or of the load factor at which the cyclic reactions reach the mean pressures if
        that is less. There only some starts near the witness slip for ever, so a slip that makes
        the node critical at this load factor is followed too, at 0.9 and 1.1 times the way.

    Raises
    ------
    ModelError, SolverError
        Bad input, a limit that is not finite, a contact without safe slip at any load above 0; a
        transient does not pass its checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B, loads = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]], {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], loads)
    >>> limit = fo.guaranteed_limit(pair, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), friction=0.6)
    >>> check = fo.verify(limit, starts=4, moved=0)
    >>> check.dies_out, check.persists
    (True, True)
    """
    limit = checked_guaranteed(limit)
    system, cycle = limit.system, limit.cycle
    starts, moved = whole_number("starts", starts, least=0), whole_number("moved", moved, least=0)
    above, rng = (
        finite_number("above", above, above=1.0),
        np.random.default_rng(whole_number("seed", seed, least=0, most=LARGEST_SEED)),
    )
    least = limit.least
    if not np.isfinite(limit.load_factor) or not limit.shakedown.load_factor > least:
        raise ModelError(
            f"guaranteed limit {limit.load_factor:g} between the least safe load factor {least:g} and lambda_2 = "
            f"{limit.shakedown.load_factor:g}; there is no load to test at"
        )
    pressure = float(
        np.abs(cycle.unscaled_reactions(system)[1]).mean()
    )  # the mean load may press nothing
    largest = max(float(np.abs(part).max()) for part in cycle.corner_reactions(system))
    size = float(np.abs(limit.slip).max()) or (pressure or largest) / system.stiffness_scale
    small = least + _SMALL_LOAD * min(limit.shakedown.load_factor - least, pressure / largest)
    next_to = limit.witness_above_least(small) if small > least else None
    high = above * limit.load_factor if next_to is None else small
    changes = _MOVED * size * rng.uniform(-1.0, 1.0, (moved, *system.slip_shape))
    begins = [
        (high, "witness", limit.slip),
        *((high, "moved witness", limit.slip + change) for change in changes),
    ]
    if next_to is not None:
        begins += [(least + share * (next_to[0] - least), "witness", next_to[1]) for share in _NEAR]
    else:
        shares = (_BELOW,) if least == 0 else (_BELOW, 1 - _BELOW)
        for number, share in enumerate(shares):
            low = share * limit.load_factor + (1 - share) * least
            begins += [
                (low, kind, slip)
                for kind, slip in _starts(rng, limit, low, (starts + number) // len(shares), size)
            ]
    return GuaranteeCheck(
        limit,
        pd.DataFrame([_run(limit, size, *begin) for begin in begins]),
        frozen([slip for _, _, slip in begins]),
    )


def _starts(
    rng: np.random.Generator, limit: GuaranteedLimit, load_factor: float, count: int, size: float
) -> list[tuple[str, Array]]:
    """Kind and slip of each start."""
    system, wanted = limit.system, 0 if limit.open.any() else int(_VERTICES * count)
    directions = rng.normal(size=(wanted, *system.slip_shape))
    under_mean = 0.0 if limit.least == 0 else load_factor
    parts = (load_factor, directions[: wanted // 2]), (under_mean, directions[wanted // 2 :])
    vertices = [
        slip for part in parts for slip in safe_vertices(system, limit.cycle, limit.friction, *part)
    ]
    begins = [("vertex", slip) for slip in vertices]
    begins += [("beyond vertex", slip * rng.uniform(1.0, _BEYOND)) for slip in vertices]
    while len(begins) < count:
        begins.append(
            ("random", size * 10 ** rng.uniform(*_DECADES) * rng.normal(size=system.slip_shape))
        )
    return begins


def _run(
    limit: GuaranteedLimit, size: float, load_factor: float, kind: str, slip: Array
) -> dict[str, str | float]:
    row: dict[str, str | float] = {
        "load_factor": load_factor,
        "share": load_factor / limit.load_factor if limit.load_factor > 0 else np.inf,
    }
    row |= {
        "start": kind,
        "moved": float(np.abs(slip - limit.slip).max() / size) if "witness" in kind else np.nan,
    }
    asked, steps = (
        (limit.system, from_its_middle(limit.cycle, load_factor), limit.friction, 1.0),
        None if limit.system.tangents == 1 else _STEPS,
    )
    try:
        steady = steady_state(*asked, **_begin(limit, load_factor, slip), steps=steps)
    except NoContinuation:
        return row | {"outcome": NO_OUTCOME, "dissipation": np.nan, "cycles": 0, "residual": np.nan}
    row["outcome"] = (
        steady.outcome.name if steady.work_error < 1 else NO_OUTCOME
    )  # slip that has nearly died out has no work beside its error
    return row | {name: getattr(steady, name) for name in ("dissipation", "cycles", "residual")}


def _begin(limit: GuaranteedLimit, load_factor: float, slip: Array) -> dict[str, Any]:
    """What a transient begins from at the mean of the corners: a slip; where nodes are open and the others can hold it, the state that it leaves."""
    task = limit._question
    if not limit.open.any():
        return {"initial_slip": slip}
    of_corners = (
        *task.states(load_factor, slip),
        reactions(limit.system, limit.cycle.at(load_factor)),
    )
    (v, w), (q, p), load = (
        parted(part.reshape(len(part), -1).mean(axis=0), task.system.tangents + 1)
        for part in of_corners
    )
    held = (lengths(q, p) <= limit.friction * p).all() and (
        w[limit.open] >= 0
    ).all()  # states are linear in the load
    return {"initial_state": ContactState(v, w.clip(0.0), *load)} if held else {"initial_slip": v}


def from_its_middle(cycle: LoadCycle, load_factor: float) -> LoadCycle:
    """The same corners at that load factor, as a cycle with factor 1 about the mean of its corners."""
    corners = cycle.at(load_factor)
    names = sorted({name for loads in corners for name in loads})
    middle = {name: float(np.mean([corner.get(name, 0.0) for corner in corners])) for name in names}
    return LoadCycle(
        middle,
        [{name: corner.get(name, 0.0) - middle[name] for name in names} for corner in corners],
    )
