"""One run of a campaign: what goes to where it is followed, and the row that comes back."""

import hashlib
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..errors import FrictoptError
from ..path import steady_state
from .starts import Start, root_mean_square

__all__ = ["Contact", "Run", "failed", "follow", "one_thread", "run_key"]

_MEANING = b"steady state 1"  # of what a run is: another meaning asks for all runs again


@dataclass(frozen=True, eq=False)
class Contact:
    """What all runs of a campaign share: plain arrays, so that they travel."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array

    def key(self) -> bytes:
        """Digest of the content."""
        system, digest = self.system, hashlib.sha256(_MEANING)
        reactions = *self.cycle.mean_reaction(system), *self.cycle.corner_reactions(system)
        for array in (system.A, system.B, system.C, system.gap, self.friction, *reactions):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.digest()


@dataclass(frozen=True, eq=False)
class Run:
    """One transient: its load factor, residual slip (None: none) and overload (a load factor; None: none), and the key of its content."""

    key: str
    start: str
    load_factor: float
    slip: Array | None
    overload: float | None


def run_key(contact: bytes, load_factor: float, start: Start) -> str:
    """Digest of a run's content; a safe slip counts by its definition, since solvers may find different ones."""
    digest = hashlib.sha256(contact)
    for label, value in (("load", load_factor), ("slip", start.slip), ("safe", start.safe_multiple), ("overload", start.overload)):
        digest.update(label.encode() if value is None else label.encode() + np.asarray(value, dtype=np.float64).tobytes())
    return digest.hexdigest()[:40]


def follow(contact: Contact, runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Follow runs one after the other, with one BLAS thread: the same rows wherever this happens, but for the seconds."""
    with one_thread():
        return [_row(contact, run) for run in runs]


def one_thread() -> Any:
    """A context in which linear algebra uses one thread."""
    return _libraries().limit(limits=1)


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


def _row(contact: Contact, run: Run) -> dict[str, Any]:
    begin = time.perf_counter()
    try:
        steady = steady_state(contact.system, contact.cycle, contact.friction, run.load_factor, initial_slip=run.slip, overload=run.overload)
    except FrictoptError as error:
        return failed(run, f"{type(error).__name__}: {error}", time.perf_counter() - begin)
    work = steady.dissipation_per_node
    return _described(run) | {
        "outcome": steady.outcome.name,
        "dissipation": steady.dissipation,
        "first_cycle": steady.first_cycle,
        "largest_share": float(work.max() / steady.dissipation) if steady.dissipation > 0 else 0.0,
        "cycles": steady.cycles,
        "slipping": int(np.count_nonzero(work)),
        "open": int(np.count_nonzero(steady.open)),
        "residual": steady.residual,
        "engine": "path",
        "seconds": time.perf_counter() - begin,
        "error": "",
    }


def failed(run: Run, error: str, seconds: float = np.nan) -> dict[str, Any]:
    """The row of a run that has no result."""
    numbers = dict.fromkeys(("dissipation", "first_cycle", "largest_share", "residual"), np.nan)
    counts = dict.fromkeys(("cycles", "slipping", "open"))
    return _described(run) | numbers | counts | {"outcome": "FAILED", "engine": "path", "seconds": seconds, "error": error}


def _described(run: Run) -> dict[str, Any]:
    amplitude = 0.0 if run.slip is None else root_mean_square(run.slip)
    return {"key": run.key, "start": run.start, "load_factor": run.load_factor, "amplitude": amplitude}
