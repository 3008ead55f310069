"""What is asked of the guaranteed limit of a random case: against plain linear programs, and against transients."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.study.verify import from_its_middle
from validation import oracles
from validation.fuzz.known import Known, NotAsked, Wrong, same, transformed
from validation.lower_bound import lower_bound

_STARTS = 10  # below the limit
_FEW = 3  # nodes and corners up to which sequences of increments are computed
_SECONDS = 5.0  # for each sequence
# error of sequences of increments, in mean normal forces: beside little friction it is large
_FEASIBLE = 1e-8
# load factors next to 0, over lambda_2 or that at which cyclic reactions reach the mean pressure
_SMALL = (0.1, 0.02, 1e-3)
_NO_SLIP = (fo.Outcome.SHAKEDOWN.name, "NO_CONTINUATION")
_MOVED = 5  # starts next to the witness, above the limit
_ABOVE = 1.02
# change of a node's forces, over the mean normal force, whose work of slip may be too little to
# tell
_TOO_LITTLE = 1e-6


def guaranteed(known: Known) -> tuple[float, bool]:
    """Against one linear program per node on the plain rows of all corners; the witness against the rows themselves."""
    limit = known.answered_guarantee
    if not (limit.load_factor <= limit.shakedown.load_factor or np.isnan(limit.load_factor)):
        raise Wrong(
            f"guaranteed limit {limit.load_factor!r} above the shakedown limit "
            f"{limit.shakedown.load_factor!r}"
        )
    if not limit.shakedown.events.empty:
        # Nodes come and go by the loads alone, so the contact is uncoupled: both limits are one.
        same("guaranteed limit", limit.load_factor, limit.shakedown.load_factor)
        return limit.residual, True
    if limit.open.any():
        same(
            "limit of all nodes",
            limit.load_factor,
            fo.guaranteed_limit(*known.args, simplify=False).load_factor,
            1e-8,
        )
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
    same(
        "guaranteed limit", limit.load_factor, float(np.minimum(known.limit, least)), absolute=1e-8
    )
    return limit.residual, True


def _against_sequences(known: Known, limit: fo.results.GuaranteedLimit) -> None:
    """For few nodes: no periodic sequence of increments with all nodes closed dissipates below the limit, and one does at it."""
    system, cycle, friction = known.args
    if (
        limit.node is None
        or limit.load_factor == 0
        or limit.least > 0
        or system.nodes > _FEW
        or len(cycle.corners) > _FEW
    ):
        return  # below a least safe load factor above 0 slip goes on too
    try:
        bound = lower_bound(
            system, cycle, friction, limit.load_factor, witnessed=True, time_limit=_SECONDS
        )
    except fo.SolverError as error:
        raise Wrong(str(error)) from error
    off = 1e-5 + _FEASIBLE / friction[friction > 0].min(initial=1.0)
    if (
        1e-6 * limit.load_factor < bound.found < limit.load_factor * (1 - off)
        and not bound.lifts_off
    ):  # at 0 a node without reaction is on both bounds
        raise Wrong(
            f"a sequence of increments dissipates at {bound.found:.9g}, below the limit "
            f"{limit.load_factor:.9g}"
        )


def guaranteed_transformed(known: Known) -> tuple[float, bool]:
    """The same guaranteed limit of the same contact in other units, order and orientation."""
    return transformed(
        known,
        "guaranteed limit",
        fo.guaranteed_limit,
        lambda limit: float(limit.load_factor),
        known.answered_guarantee,
    )


def followed(known: Known) -> tuple[float, bool]:
    """Just above the limit a transient from the witness persists; just below, none from a few starts does in which all nodes stay closed."""
    limit = known.answered_guarantee
    if limit.open.any() or not (
        np.isfinite(limit.load_factor) and limit.shakedown.load_factor > limit.least
    ):
        raise NotAsked
    moved = 0 if limit.node is None else _MOVED
    check = fo.verify(
        limit, starts=_STARTS, moved=moved, above=_above(known, limit), seed=known.case.seed
    )
    below = check.runs[check.runs["share"] < 1]
    for number in np.flatnonzero(~below["outcome"].isin(_NO_SLIP)) + len(check.runs) - len(below):
        if not _lifts_off(
            known, float(check.runs["load_factor"].iloc[number]), check.starts[number]
        ):
            raise Wrong(
                f"persists below the limit {limit.load_factor:.6g} with all nodes closed, from "
                f"{check.starts[number].tolist()}"
            )
    if limit.node is not None and not check.persists:
        if limit.load_factor <= limit.least:
            q, p = known.case.cycle.corner_reactions(known.case.system)
            unit = min(
                limit.shakedown.load_factor - limit.least,
                known.force / max(float(np.abs(q).max()), float(np.abs(p).max())),
            )
            return limit.residual, _persists_next_to(
                known, limit, [limit.least + share * unit for share in _SMALL]
            )
        if (check.runs.loc[check.runs["share"] > 1, "outcome"] == "NO_CONTINUATION").all():
            raise fo.NoContinuation(
                "all transients from next to the witness end before they have an outcome; lower "
                "the friction"
            )
        if _persists_next_to(known, limit, [1.2 * limit.load_factor]):
            return limit.residual, True
        A, B, friction = (
            np.diag(known.case.system.A),
            np.diag(known.case.system.B),
            known.case.friction,
        )
        if (friction * np.abs(B) > A)[
            limit.node
        ]:  # one slip relieves both its bounds: it may wedge itself
            raise NotAsked
        raise Wrong(
            f"dies out above the limit {limit.load_factor:.6g}: {check.runs['outcome'].to_list()}"
        )
    return limit.residual, check.undecided < len(check.runs)


def _above(known: Known, limit: fo.results.GuaranteedLimit) -> float:
    """How far above the limit, as its multiple, slip is to be seen: 1.02, or more where that changes the forces of the node too little to tell."""
    if limit.node is None or limit.load_factor == 0:
        return _ABOVE
    q, p = (part[:, limit.node] for part in known.case.cycle.corner_reactions(known.case.system))
    change = limit.load_factor * max(float(np.abs(q).max()), float(np.abs(p).max())) / known.force
    if (_ABOVE - 1) * change >= _TOO_LITTLE:
        return _ABOVE
    above = 1 + 10 * _TOO_LITTLE / change
    if above * limit.load_factor >= limit.shakedown.load_factor:  # slip persists there in any case
        raise NotAsked
    return above


def _lifts_off(known: Known, load_factor: float, start: Any) -> bool:
    """Whether nodes open in the steady state that a start comes to."""
    system, cycle, friction = (
        known.case.system,
        from_its_middle(known.case.cycle, load_factor),
        known.case.friction,
    )
    steady = fo.steady_state(system, cycle, friction, 1.0, initial_slip=start)
    path = fo.march(system, cycle, friction, 1.0, initial_slip=steady.slip, cycles=4)
    return bool(path.gap[path.time > 3 * len(cycle.corners)].max() > 1e-9 * known.length)


def _persists_next_to(
    known: Known, limit: fo.results.GuaranteedLimit, load_factors: Sequence[float]
) -> bool:
    """Whether slip is seen to go on next to one of these load factors, from a slip that holds the node on both its bounds there.

    The witness itself need not do: of a limit of 0 its node carries nothing, so that no load is
    small; and loads that press the contact may make it safe as they grow. Next to a limit of 0
    there often is too little work to tell.
    """
    assert limit.node is not None and limit.corners is not None
    for load_factor in load_factors:
        slip = oracles.on_both_bounds(*known.args, load_factor, limit.node, limit.corners)
        for next_to in (
            (0.9, 1.1) if slip is not None else ()
        ):  # if the load presses the contact, less load can be worse
            with suppress(fo.NoContinuation):
                cycle = from_its_middle(known.case.cycle, next_to * load_factor)
                if (
                    fo.steady_state(
                        known.case.system, cycle, known.case.friction, 1.0, initial_slip=slip
                    ).outcome
                    is not fo.Outcome.SHAKEDOWN
                ):
                    return True
    return False
