"""The guaranteed limit for slips up to the largest slip that one overload leaves."""

from typing import Any

import numpy as np

from ..base import finite_number, progress_bar, warns_of_odd_values
from ..contact import lengths
from ..errors import ModelError
from ..limits import GuaranteedLimit, GuaranteedModel
from ..limits.guaranteed import checked_guaranteed
from ..transients import march


@warns_of_odd_values
def after_overload(
    limit: GuaranteedLimit, load_factor: float | None = None, *, progress: bool = True
) -> GuaranteedLimit:
    """Guaranteed limit for slips up to the largest slip that one overload leaves.

    The overload is one cycle of a contact that has not slipped before. The largest slip that it
    leaves is the slip bound of the result, unless the slip bound of `limit` is smaller. Use this
    function if a witness needs more slip than assembly and overloads leave.

    Parameters
    ----------
    limit
        A guaranteed limit, from `guaranteed_limit` or `GuaranteedModel`, without user constraints.
    load_factor
        Load factor of the overload; by default lambda_2, above which the contact slips for ever.
    progress
        Whether to show the progress after two seconds.

    Returns
    -------
    GuaranteedLimit
        The guaranteed limit for this slip bound.

    Raises
    ------
    ModelError, NoContinuation, SolverError
        Bad input; a limit with user constraints; lambda_2 is not finite and no load factor is
        given; the transient of the overload fails; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> loads = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], loads)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.guaranteed_limit(pair, cycle, friction=0.6)
    >>> after = fo.after_overload(limit)
    >>> [round(one.load_factor, 6) for one in (limit, after, limit.shakedown)]
    [0.391864, 0.726057, 0.726057]
    """
    limit = checked_guaranteed(limit)
    if limit.constraints:
        names = ", ".join(limit.constraints)
        raise ModelError(
            f"after_overload: the limit is under {names}; compute a limit without user constraints"
        )
    if load_factor is None:
        load_factor = limit.shakedown.load_factor
        if not np.isfinite(load_factor):
            raise ModelError(
                f"limit: its shakedown limit is {load_factor:g}, so that no overload follows from "
                "it; pass the `load_factor` of the overload"
            )
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    question = limit._question
    with progress_bar(progress, "after an overload"):
        slip_bound: Any = left_by_overload(limit, load_factor)
        if question.slip_bound is not None:
            slip_bound = np.minimum(slip_bound, question.slip_bound)
        model = GuaranteedModel(
            limit.system, limit.cycle, slip_bound=slip_bound, simplify=question.simplify
        )
        return model.solve(limit.friction)


def left_by_overload(limit: GuaranteedLimit, load_factor: float) -> float:
    """The largest slip, length, that one cycle leaves in a contact that has not slipped before."""
    path = march(limit.system, limit.cycle, limit.friction, load_factor, cycles=1)
    return float(lengths(path.slip[-1], path.gap[-1]).max())
