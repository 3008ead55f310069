"""Errors of frictopt: one base, and one child for each thing that a caller can do about it.

Every message names the argument or quantity, its value, and what to change. Errors of the libraries
underneath (scikit-fem, scipy, cvxpy and its solvers) never leak: they are either handled or turned
into one of these.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = [
    "FrictoptError",
    "ModelError",
    "ModelWarning",
    "NoContinuation",
    "SolverError",
    "StoreError",
]


class FrictoptError(Exception):
    """Base of every error that frictopt raises on purpose."""


class ModelError(FrictoptError, ValueError):
    """The input is not a contact problem.

    Repeating the call cannot help, changing the named argument can.
    """


class ModelWarning(UserWarning):
    """The input is a contact problem, but perhaps not the intended problem.

    The message names the value that is odd. The result is the solution of the problem as given.
    """


class SolverError(FrictoptError, RuntimeError):
    """No solver gave an answer that passes the checks.

    The input may be fine. The message lists the attempts and the remedies.
    """


class NoContinuation(FrictoptError, RuntimeError):
    """The quasi-static path ends, or no steady state is found in as many cycles as were allowed.

    A path ends at a load at which no rates, or several sets of rates, obey the contact law. The
    message names the load and the nodes. If no steady state is found, the message reports the
    progress of the cycles.

    Attributes
    ----------
    slip, gap
        Slip, (N,) in the plane and (N, 2) in space, and (N,) gap after the last cycle, length. None
        if no cycles were followed.
    work
        (cycles,) work of friction in each cycle of the transient, force times length; None as well.
    """

    slip: "NDArray[np.float64] | None" = None
    gap: "NDArray[np.float64] | None" = None
    work: "NDArray[np.float64] | None" = None


class StoreError(FrictoptError, OSError):
    """A store cannot be read or written.

    The file is not a store, it is damaged, or the disk is full. Rows written before are kept.

    Attributes
    ----------
    table
        DataFrame of the finished runs, in the store or not yet written; None if no run was started.
    """

    table: Any = None
