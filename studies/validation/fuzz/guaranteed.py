"""The questions about the guaranteed limit of a random case.

The limit is compared with plain linear programs, with periodic sequences of increments, and with
transients on both sides of it.
"""

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

import frictopt as fo
from studies.validation import oracles
from studies.validation.fuzz.known import Known, NotApplicable, Wrong, same, transformed
from studies.validation.lower_bound import lower_bound
from studies.validation.verify import GuaranteeCheck, from_its_middle, verify

# Number of transients below the limit.
_STARTS = 10
# Largest number of nodes, and of corners, for which sequences of increments are computed.
_FEW = 3
# Time limit of a sequence of increments, in seconds.
_SECONDS = 5.0
# Error of sequences of increments, in mean normal forces. If friction is small, it changes the
# result much.
_FEASIBLE = 1e-8
# Load factors above a limit of 0, relative to the smaller of two load factors: the shakedown limit,
# and the load factor at which the cyclic reactions reach the mean pressure.
_SMALL = (0.1, 0.02, 1e-3)
_NO_SLIP = (fo.Outcome.SHAKEDOWN.name, "NO_CONTINUATION")
# Number of starts next to the witness, above the limit.
_MOVED = 5
# Load factor of these starts, relative to the limit.
_ABOVE = 1.02
# Change of the forces of a node, over the mean normal force, below which the work of its slip may
# be lost in rounding.
_TOO_LITTLE = 1e-6


def guaranteed(known: Known) -> tuple[float, bool]:
    """Compare the guaranteed limit with one plain linear program per node.

    The programs have the rows of all corners. The witness must satisfy these rows.
    """
    limit = known.answered_guarantee
    if not (limit.load_factor <= limit.shakedown.load_factor or np.isnan(limit.load_factor)):
        raise Wrong(
            f"guaranteed limit {limit.load_factor!r} above the shakedown limit "
            f"{limit.shakedown.load_factor!r}"
        )
    if not limit.shakedown.events.empty:
        # Loads alone open and close nodes, so the contact is uncoupled, and both limits are equal.
        same("guaranteed limit", limit.load_factor, limit.shakedown.load_factor)
        return limit.residual, True
    if limit.open.any():
        unsimplified = fo.guaranteed_limit(*known.args, simplify=False)
        same("limit of all nodes", limit.load_factor, unsimplified.load_factor, 1e-8)
        return limit.residual, False
    if np.isfinite(limit.load_factor):
        excess = oracles.excess(*known.args, limit.load_factor, limit.slip)
        if excess > 1e-8:
            raise Wrong(f"the witness is not safe by {excess:.1e}")
    if limit.node is not None and limit.corners is not None:
        off = oracles.off_bounds(
            *known.args, limit.load_factor, limit.slip, limit.node, limit.corners
        )
        if off > 1e-8 or limit.corners[0] == limit.corners[1]:
            raise Wrong(
                f"node {limit.node} is off its bounds by {off:.1e} at corners {limit.corners}"
            )
    _against_sequences(known, limit)
    if known.limit is None:
        return limit.residual, False
    least = np.inf if np.isnan(known.limit) else oracles.least_on_both_bounds(*known.args)
    if least is None:
        return limit.residual, False
    expected = float(np.minimum(known.limit, least))
    same("guaranteed limit", limit.load_factor, expected, absolute=1e-8)
    return limit.residual, True


def _against_sequences(known: Known, limit: fo.results.GuaranteedLimit) -> None:
    """Compare the limit with periodic sequences of increments with all nodes closed.

    No sequence may dissipate below the limit, and some sequence must dissipate at the limit. Only
    contacts of few nodes and corners are compared.
    """
    system, cycle, friction = known.args
    if system.nodes > _FEW or len(cycle.corners) > _FEW:
        return
    # If the least safe load factor is above 0, slip continues below it, too.
    if limit.node is None or limit.load_factor == 0 or limit.least > 0:
        return
    try:
        bound = lower_bound(
            system, cycle, friction, limit.load_factor, witnessed=True, time_limit=_SECONDS
        )
    except fo.SolverError as error:
        raise Wrong(str(error)) from error
    off = 1e-5 + _FEASIBLE / friction[friction > 0].min(initial=1.0)
    # At the load factor 0 a node without reaction is on both bounds.
    below = 1e-6 * limit.load_factor < bound.found < limit.load_factor * (1 - off)
    if below and not bound.lifts_off:
        raise Wrong(
            f"a sequence of increments dissipates at {bound.found:.9g}, below the limit "
            f"{limit.load_factor:.9g}"
        )


def guaranteed_transformed(known: Known) -> tuple[float, bool]:
    """Compare the guaranteed limit with the limit in other units, order or orientation."""
    return transformed(known, "guaranteed limit", fo.guaranteed_limit, known.answered_guarantee)


def followed(known: Known) -> tuple[float, bool]:
    """Compare the guaranteed limit with transients on both sides of it.

    Just above the limit, slip must persist from the witness. Just below, it must die out from a few
    starts, unless nodes open.
    """
    limit = known.answered_guarantee
    has_interval = np.isfinite(limit.load_factor) and limit.shakedown.load_factor > limit.least
    if limit.open.any() or not has_interval:
        raise NotApplicable
    moved = 0 if limit.node is None else _MOVED
    check = verify(
        limit, starts=_STARTS, moved=moved, above=_above(known, limit), seed=known.case.seed
    )
    _dies_out_below(known, limit, check)
    if limit.node is None or check.persists:
        return limit.residual, check.undecided < len(check.runs)
    if limit.load_factor <= limit.least:
        q, p = known.case.cycle.corner_reactions(known.case.system)
        largest_reaction = max(float(np.abs(q).max()), float(np.abs(p).max()))
        to_shakedown = limit.shakedown.load_factor - limit.least
        unit = min(to_shakedown, known.force / largest_reaction)
        load_factors = [limit.least + share * unit for share in _SMALL]
        return limit.residual, _persists_next_to(known, limit, load_factors)
    if (check.runs.loc[check.runs["share"] > 1, "outcome"] == "NO_CONTINUATION").all():
        raise fo.NoContinuation(
            "all transients from next to the witness end before they have an outcome; lower "
            "the friction"
        )
    if _persists_next_to(known, limit, [1.2 * limit.load_factor]):
        return limit.residual, True
    A = np.diag(known.case.system.A)
    B = np.diag(known.case.system.B)
    # Above the critical friction one slip relieves both bounds of the node, which may then wedge.
    if (known.case.friction * np.abs(B) > A)[limit.node]:
        raise NotApplicable
    raise Wrong(
        f"dies out above the limit {limit.load_factor:.6g}: {check.runs['outcome'].to_list()}"
    )


def _dies_out_below(known: Known, limit: fo.results.GuaranteedLimit, check: GuaranteeCheck) -> None:
    """Raise Wrong if slip persists below the limit while all nodes stay closed."""
    below = check.runs[check.runs["share"] < 1]
    first_below = len(check.runs) - len(below)
    for number in np.flatnonzero(~below["outcome"].isin(_NO_SLIP)) + first_below:
        load_factor = float(check.runs["load_factor"].iloc[number])
        if not _lifts_off(known, load_factor, check.starts[number]):
            raise Wrong(
                f"persists below the limit {limit.load_factor:.6g} with all nodes closed, from "
                f"{check.starts[number].tolist()}"
            )


def _above(known: Known, limit: fo.results.GuaranteedLimit) -> float:
    """The load factor, relative to the limit, at which slip of a transient can be seen.

    This ratio is larger than 1.02 if 1.02 changes the forces of the node too little.
    """
    if limit.node is None or limit.load_factor == 0:
        return _ABOVE
    q, p = (part[:, limit.node] for part in known.case.cycle.corner_reactions(known.case.system))
    change = limit.load_factor * max(float(np.abs(q).max()), float(np.abs(p).max())) / known.force
    if (_ABOVE - 1) * change >= _TOO_LITTLE:
        return _ABOVE
    above = 1 + 10 * _TOO_LITTLE / change
    # Above the shakedown limit slip persists in any case.
    if above * limit.load_factor >= limit.shakedown.load_factor:
        raise NotApplicable
    return above


def _lifts_off(known: Known, load_factor: float, start: Any) -> bool:
    """Whether nodes open in the steady state that follows from a start."""
    system = known.case.system
    cycle = from_its_middle(known.case.cycle, load_factor)
    friction = known.case.friction
    steady = fo.steady_state(system, cycle, friction, 1.0, initial_slip=start)
    path = fo.march(system, cycle, friction, 1.0, initial_slip=steady.slip, cycles=4)
    return bool(path.gap[path.time > 3 * len(cycle.corners)].max() > 1e-9 * known.length)


def _persists_next_to(
    known: Known, limit: fo.results.GuaranteedLimit, load_factors: Sequence[float]
) -> bool:
    """Whether a transient continues to slip next to one of these load factors.

    The transient starts from a slip with which the node is on both its bounds at the load factor.
    The witness itself may be no such start, for two reasons. At a limit of 0 its node carries no
    force. If loads press the contact, larger loads may make the witness safe. Next to a limit of 0
    the work of slip is often lost in rounding.
    """
    assert limit.node is not None and limit.corners is not None
    system = known.case.system
    friction = known.case.friction
    for load_factor in load_factors:
        slip = oracles.on_both_bounds(*known.args, load_factor, limit.node, limit.corners)
        if slip is None:
            continue
        # If the load presses the contact, slip may continue at the smaller load only.
        for ratio in (0.9, 1.1):
            cycle = from_its_middle(known.case.cycle, ratio * load_factor)
            with suppress(fo.NoContinuation):
                steady = fo.steady_state(system, cycle, friction, 1.0, initial_slip=slip)
                if steady.outcome is not fo.Outcome.SHAKEDOWN:
                    return True
    return False
