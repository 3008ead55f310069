"""One run of a campaign: its input, and the row of results."""

import hashlib
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from ..contact import LoadCycle
from ..contact.checks import Array
from ..errors import FrictoptError
from ..transients import steady_state
from .starts import Start, root_mean_square, safe_part

__all__ = ["CampaignContact", "Run", "failed", "follow", "one_thread", "run_key"]


@dataclass(frozen=True, eq=False)
class CampaignContact:
    """The input that all runs of a campaign share; it can be pickled.

    Attributes
    ----------
    system, cycle, friction
        The contact of any kind, its load cycle, and (N,) coefficients of friction.
    limit, safe
        Shakedown limit (NaN if it is not known), and the (N,) safe slip at the limit.
    """

    system: Any
    cycle: LoadCycle
    friction: Array
    limit: float
    safe: Array

    def key(self) -> bytes:
        """Digest of the content."""
        system, digest = self.system, hashlib.sha256()
        reactions = *self.cycle.mean_reaction(system), *self.cycle.corner_reactions(system)
        for array in (system.A, system.B, system.C, system.gap, self.friction, *reactions):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.digest()


@dataclass(frozen=True, eq=False)
class Run:
    """One transient: the key of its content, its start and its load factor."""

    key: str
    start: Start
    load_factor: float


def run_key(contact: bytes, load_factor: float, start: Start) -> str:
    """Digest of a run's content; a safe slip enters by its definition, because solvers may find different ones."""
    digest = hashlib.sha256(contact)
    if start.state is not None:
        state = start.state
        for array in (state.slip, state.gap, state.bonded_q, state.bonded_p, np.float64(state.next_corner)):
            digest.update(np.ascontiguousarray(array).tobytes())
    for label, value in (("load", load_factor), ("slip", start.slip), ("safe", start.safe_multiple), ("overload", start.overload)):
        digest.update(label.encode() if value is None else label.encode() + np.asarray(value, dtype=np.float64).tobytes())
    return digest.hexdigest()[:40]


def follow(contact: CampaignContact, runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Follow runs one after the other, with one BLAS thread; the rows do not depend on the machine's load, except for the seconds."""
    with one_thread():
        return [_row(contact, run) for run in runs]


def one_thread() -> Any:
    """A context in which linear algebra uses one thread."""
    return _libraries().limit(limits=1)


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


def _row(contact: CampaignContact, run: Run) -> dict[str, Any]:
    begin, slip = time.perf_counter(), np.zeros(contact.system.slip_shape)
    overload = None if run.start.overload is None else run.start.overload * run.load_factor
    try:
        slip = _initial_slip(contact, run)
        begin_at: dict[str, Any] = {"initial_state": run.start.state} if run.start.state else {"initial_slip": slip}
        if contact.system.tangents == 2:
            begin_at["progress"] = False  # the study has its own bar
        steady = steady_state(contact.system, contact.cycle, contact.friction, run.load_factor, **begin_at, overload=overload)
    except FrictoptError as error:
        return failed(run, f"{type(error).__name__}: {error}", time.perf_counter() - begin) | {"amplitude": root_mean_square(slip)}
    work = steady.dissipation_per_node
    return _input(run) | {
        "amplitude": root_mean_square(slip),
        "outcome": steady.outcome.name,
        "dissipation": steady.dissipation,
        "first_cycle": steady.first_cycle,
        "largest_share": float(work.max() / steady.dissipation) if steady.dissipation > 0 else 0.0,
        "cycles": steady.cycles,
        "slipping": int(np.count_nonzero(steady.slipping)),
        "open": int(np.count_nonzero(steady.open)),
        "residual": steady.residual,
        "engine": steady.engine,
        "seconds": time.perf_counter() - begin,
        "error": "",
    }


def _initial_slip(contact: CampaignContact, run: Run) -> Array:
    if run.start.state is not None:
        return run.start.state.slip
    if run.start.safe_multiple is not None:
        return np.asarray(run.start.safe_multiple * _safe_slip(contact, run.load_factor))
    return np.zeros(contact.system.slip_shape) if run.start.slip is None else run.start.slip


@lru_cache(maxsize=32)
def _safe_slip(contact: CampaignContact, load_factor: float) -> Array:
    return safe_part(contact.system, contact.cycle, contact.friction, load_factor, contact.limit, contact.safe)


def failed(run: Run, error: str, seconds: float = np.nan) -> dict[str, Any]:
    """The row of a run that has no result."""
    numbers = dict.fromkeys(("amplitude", "dissipation", "first_cycle", "largest_share", "residual"), np.nan)
    counts = dict.fromkeys(("cycles", "slipping", "open"))
    return _input(run) | numbers | counts | {"outcome": "FAILED", "engine": "path", "seconds": seconds, "error": error}


def _input(run: Run) -> dict[str, Any]:
    return {"key": run.key, "start": run.start.name, "load_factor": run.load_factor}
