"""How a result was found: the record that every result of a computation carries."""

from dataclasses import dataclass, field

import numpy as np

from .checks import Array
from .show import Shown


@dataclass(frozen=True)
class Attempt:
    """One run of one solver.

    Attributes
    ----------
    solver
        Its name.
    outcome
        What it reports.
    residual
        The residual of its answer; inf without an answer.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> limit = fo.shakedown_limit(rod, cycle, friction=0.5, solver="HIGHS")
    >>> limit.record.attempts[0].outcome
    'optimal'
    """

    solver: str
    outcome: str
    residual: float


@dataclass(frozen=True)
class SolveRecord:
    """How a result was found.

    Attributes
    ----------
    solver
        Name of the solver or method whose answer this is; "closed form" where no program was solved.
    attempts
        All solver runs, in order.
    residual
        Largest violation of what the result claims, recomputed from the result; each result says what it covers.
    left_out
        Sentences that say what the computation left out, because it cannot change the answer. Empty with `simplify=False`.
    seconds
        Wall time of the computation.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> record = fo.shakedown_limit(rod, cycle, friction=0.5).record
    >>> record.solver, record.left_out, record.residual < 1e-9
    ('closed form', ('linear program: the contact is uncoupled (B = 0), the limit has a closed form',), True)
    """

    solver: str = ""
    attempts: tuple[Attempt, ...] = field(repr=False, default=())
    residual: float = np.inf
    left_out: tuple[str, ...] = ()
    seconds: float = 0.0


class Recorded(Shown):
    """Base of results with a `record`."""

    record: SolveRecord

    @property
    def residual(self) -> float:
        """The residual of the record."""
        return self.record.residual


class WithSlip(Recorded):
    """Base of results with a residual slip, (N,) or (N, 2)."""

    slip: Array

    @property
    def largest_slip(self) -> float:
        """Largest size of the slip at a node, length; NaN without a slip. Other slips may be safe too.

        Compare it with what assembly can leave. A slip far larger than that is of no use: bound it by `slip_bound`.
        """
        return float(np.linalg.norm(self.slip.reshape(len(self.slip), -1), axis=1).max())
