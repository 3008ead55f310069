"""The sliding-off load: above it no contact forces within friction balance the loads in the rigid motions of the bodies; one program each corner."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..base import (
    CONDENSATION,
    COUNTS,
    RESIDUAL,
    ZERO_LOAD_FACTOR,
    Array,
    Booleans,
    SolveRecord,
    bar_of,
    frame,
    frozen,
    listed,
    shown,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle, most_shear, reactions
from ..errors import ModelError
from ..solve.chain import Chain
from ..solve.problem import Explained, Problem
from ..transients.statics import nodal_motions, rigid_motions
from . import models
from .programs import outer_corners
from .question import Question, pose
from .self_stress import self_stress, sliding_off

# of the largest motion: what is less is told as none, for answers of cone programs have this error
_MOVES = 1e-4
_FIT = COUNTS  # of the largest motion, up to which nodes move as one body
_TOLD = 3  # motions that a reason names


@dataclass(frozen=True, eq=False, repr=False)
class GrossSlip(Explained):
    """The load factor above which bodies slide off, turn over or lift off as a whole, with the motion that proves it.

    Attributes
    ----------
    load_factor
        Above it no state of rest exists, from no start, whatever slips and opens. Inf where the
        loads drive no motion that the contact alone holds; NaN where no load factor has a state of
        rest. With a `self_stress`: above it the transient from no slip slides off, if that is less.
    bound
        That of statics from above, also with a `self_stress`: `phi` times the reactions at load
        factor 0, over minus those of the cyclic load.
    least
        Below it no state of rest exists either; above 0 where the loads that the load factor leaves
        as they are slide a body off.
    corner, loads
        The corner that governs, and its loads in words; -1 and "" where none does.
    phi
        (t + 1, N) the motion that proves it, of body 1 relative to body 2: slips along the
        tangents, then lifts; the largest node has the size 1. It strains nothing, lifts each node
        by at least f times its slip, and the loads do work in it. 0 where there is none.
    motion
        The same, one row for each contact that moves: columns contact, nodes (that move), x and y
        (and z), the direction of the slide or in space the axis of the turn, slide (along it), lift
        (off a flat face), turn (angle, in the plane from x to y), at_x, at_y (and at_z), a point
        that does not turn, else NaN. NaN where the nodes of a contact do not move as one body.
    reason
        Why it is so, in words.
    self_stress
        (t + 1, N) contact forces within friction that balance themselves, their pressures adding up
        to 1: shear along the tangents, then pressure. None if there are none, or the cyclic loads
        drive no body. With them statics cannot know how far a fit presses.
    record, problem
        How it was found; its `residual`, at most 1e-9, is the largest error of both proofs. The
        cvxpy problem of the corner, in your units, or None.

    Examples
    --------
    >>> import frictopt as fo
    >>> block = fo.ContactSystem.from_blocks([[0.0]], [[0.0]], [[0.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])})
    >>> slide = fo.gross_slip(block, fo.LoadCycle({"P": 4.0}, [{"Q": 1.0}, {"Q": -0.5}]), friction=0.5)
    >>> slide.phi.round(3).tolist(), slide.loads  # it rises by the angle of friction
    ([[0.894], [0.447]], 'Q = +1')
    """

    _said = ("load_factor", "bound", "loads", "residual", "reason")
    load_factor: float
    bound: float
    least: float
    corner: int
    loads: str
    phi: Array
    motion: pd.DataFrame
    reason: str
    record: SolveRecord
    problem: cp.Problem | None
    self_stress: Array | None = None

    def to_frame(self) -> pd.DataFrame:
        """The motion, see there."""
        return self.motion.copy()

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        title = f"sliding-off load: load factor {self.load_factor:.12g}, bound {self.bound:.12g}"
        return title, self.load_factor if np.isfinite(self.load_factor) else None, None, self.reason


def motion_table(system: ContactSystem, phi: Array) -> pd.DataFrame:
    """See `GrossSlip.motion`; phi (t + 1, N) has the size 1."""
    names = np.zeros(system.nodes) if system.contact is None else np.asarray(system.contact)
    back = phi / np.vstack([system.stretch.reshape(system.nodes, -1).T, np.ones(system.nodes)])
    moves = np.einsum("an,nak->nk", back, system.frames)
    rows, moving = list[dict[str, Any]](), np.abs(phi).max(axis=0) > _MOVES
    for name in dict.fromkeys(names[moving].tolist()):
        own = moving & (names == name)
        contact = "the contact" if system.contact is None else name
        rows.append(
            {
                "contact": contact,
                "nodes": int(own.sum()),
                **_as_one(system.points[own], system.normals[own], moves[own]),
            }
        )
    axes = "xyz"[: system.tangents + 1]
    columns = ["contact", "nodes", *axes, "slide", "lift", "turn", *(f"at_{axis}" for axis in axes)]
    return frame({name: [row[name] for row in rows] for name in columns}, units=system.units)


def _as_one(points: Array, normals: Array, moves: Array) -> dict[str, float]:
    """The rigid motion (n, axes) of points, as columns of the table; NaN where it is none."""
    (n, axes), centre = points.shape, points.mean(axis=0)
    arms = points - centre
    turns = np.stack(
        [arms[:, ::-1] * [-1, 1]] if axes == 2 else [np.cross(axis, arms) for axis in np.eye(3)],
        axis=-1,
    )
    basis = np.concatenate([np.tile(np.eye(axes), (n, 1, 1)), turns], axis=-1).reshape(n * axes, -1)
    found = np.linalg.lstsq(basis, moves.ravel())[0]
    shift, spin, along, at = found[:axes], found[axes:], np.zeros(axes), np.full(axes, np.nan)
    turn, slide, lift = float(np.linalg.norm(spin)), 0.0, 0.0
    if np.abs(basis @ found - moves.ravel()).max() > _FIT:
        along, turn, slide, lift = at, np.nan, np.nan, np.nan
    elif turn * np.linalg.norm(arms, axis=1).max() > _MOVES and axes == 2:
        turn, at = float(spin[0]), centre + np.array([-shift[1], shift[0]]) / spin[0]
    elif turn * np.linalg.norm(arms, axis=1).max() > _MOVES:
        along, at = spin / turn, centre + np.cross(spin, shift) / turn**2
        slide = float(along @ shift)
    else:
        flat = bool((np.abs(normals - normals[0]) <= _FIT).all())
        turn, lift = 0.0, float(shift @ normals[0]) if flat else 0.0
        shift = shift - lift * normals[0]
        slide = float(np.linalg.norm(shift))
        along = shift / slide if slide > _MOVES else along
    names = "xyz"[:axes]
    columns = {
        **dict(zip(names, along.tolist(), strict=True)),
        "slide": slide,
        "lift": lift,
        "turn": turn,
    }
    return columns | {f"at_{name}": value for name, value in zip(names, at.tolist(), strict=True)}


def moves_told(motion: pd.DataFrame) -> str:
    """The motions of a table in words, contacts that move alike together."""
    told, axes = dict[str, list[str]](), [name for name in "xyz" if name in motion]
    for row in motion.to_dict("records"):
        along, at = (_point([row[of + name] for name in axes]) for of in ("", "at_"))
        if np.isnan(row["slide"]):
            text = "not as one body"
        elif row["turn"]:
            text = (
                f"by a turn about {at}"
                if len(axes) == 2
                else f"by a turn about the axis {along} through {at}"
            )
        else:
            text = f"along {along}" if row["slide"] > _MOVES else "off"
        told.setdefault(text, []).append(str(row["contact"]))
    said = [
        f"{', '.join(names[:_TOLD])}{', ...' * (len(names) > _TOLD)} {text}"
        for text, names in told.items()
    ]
    return f"body 1 moves at {'; '.join(said[:_TOLD])}{'; ...' * (len(said) > _TOLD)}"


def _point(values: list[float]) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.round(values, 4) + 0.0) + ")"


@warns_of_odd_values
def gross_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    contacts: Iterable[str] | None = None,
    *,
    progress: bool = True,
) -> GrossSlip:
    """The load factor above which no state of rest exists, from no start, whatever slips and opens: bodies slide off, turn over or lift off.

    By statics: on all that the contact alone holds, forces within friction, `|q| <= f p`, and
    within the shear strength of the surface have to balance the loads at each corner. Stiffness,
    gaps and residual slips do not matter, so the answer settles with the mesh. It is inf where
    supports hold the bodies. A contact may slip for ever far below it, and wedged bodies may slide
    off below it too: Coulomb's law does not choose forces as statics does. Theory, eq. (33).

    If contact forces can balance themselves or press against supports, as in a press fit, a clip, a
    joint with a locked bolt or under a body that supports guide along its face, statics cannot know
    how far the fit presses. Then transients from no slip are followed, and the answer is the load
    factor at which they slide off, if that is less; `reason` says so. It is found to 2e-4 of it, in
    space to 2e-3 with two increments from corner to corner, which may take minutes.

    Parameters
    ----------
    system, cycle, friction
        See `shakedown_limit`.
    contacts
        Names of the contacts, of `system.contact`, in which friction counts; pressure counts in
        all. `["flange"]` gives the slip load of this joint, friction times the clamping force,
        without the heads of its bolts. None: all.
    progress
        Whether to show after two seconds that it is still at work.

    Raises
    ------
    ModelError, SolverError
        Bad input, contacts that the system does not have; no solver gave an answer that passes the
        checks; with forces that balance themselves, see also `steady_state`.

    Examples
    --------
    A block of weight P = 4 on a plane is pushed by Q:

    >>> import frictopt as fo
    >>> block = fo.ContactSystem.from_blocks([[0.0]], [[0.0]], [[0.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])})
    >>> slide = fo.gross_slip(block, fo.LoadCycle({"P": 4.0}, [{"Q": 1.0}, {"Q": -0.5}]), friction=0.5)
    >>> round(slide.load_factor, 9)
    2.0
    >>> print(slide.problem)
    maximize load_factor
    subject to balance: N.T @ [q, p] == N.T @ (r0 + load_factor * r1[0])
               stuck: abs(q) <= f * p
               pressed: 0.0 <= p
               load_factor: 0.0 <= load_factor
    """
    with bar_of(progress, "gross slip"):
        question, only = _asked(system, cycle, friction, contacts)
        return beyond_statics(_of_corners(question, only), system, cycle, question.friction)


def statics_alone(system: ContactSystem, cycle: LoadCycle, friction: Any) -> float:
    """The load factor above which statics has no state of rest, whatever the fit presses: `bound` of `gross_slip`, without transients."""
    return _of_corners(*_asked(system, cycle, friction, None)).load_factor


def _asked(
    system: ContactSystem, cycle: LoadCycle, friction: Any, contacts: Iterable[str] | None
) -> tuple[Question, str]:
    """The question, with friction in some contacts alone, and that in words."""
    question = pose(system, cycle, friction, strong=True)
    if contacts is None:
        return question, ""
    names, among = _checked(system, contacts)
    return replace(
        question, friction=frozen(question.friction * among)
    ), f"with friction at {', '.join(names)} alone, "


def _of_corners(question: Question, only: str) -> GrossSlip:
    """The answer of statics, of what each corner allows."""
    system, cycle = question.system, question.cycle
    N, bounds = (
        nodal_motions(rigid_motions(system.S, system.own_stiffness)),
        "friction" + " and the strength of the surface" * system.capped,
    )
    r1 = reactions(system, cycle.corners)  # without gaps, which do no work in rigid motions
    r0 = np.broadcast_to(reactions(system, cycle.unscaled), r1.shape)
    corners = outer_corners(cycle) if N.size else []
    held = _Answer(-1, np.inf, np.inf, np.zeros(len(N)), SolveRecord("statics", residual=0.0), None)
    answers = [_statics(question, N, k, r0[k], r1[k], cp.Maximize) for k in corners] or [held]
    load = [f"the load at the corner ({name})" for name in cycle.corner_names]
    if none := next((answer for answer in answers if np.isnan(answer.value)), None):
        unbalanced = f"{only}forces within {bounds} cannot balance {load[none.corner]}: {_moves(question, none)}"
        return _result(
            question,
            none,
            np.nan,
            f"no load factor has a state of rest, nor has 0: {unbalanced}",
            answers,
        )
    most = min(answer.value for answer in answers)
    governs = next(answer for answer in answers if answer.value <= most * (1 + RESIDUAL))
    lower = list[_Answer]()
    for k in corners:  # without fixed parts none is at 0 if the first one is
        *q, p = r0[k].reshape(-1, system.nodes)
        rests = (
            np.linalg.norm(q, axis=0) <= most_shear(system, question.friction, p)
        ).all()  # the closed contact, at load factor 0
        if not rests and (question.fixed or not lower or lower[0].value > 0):
            lower.append(_statics(question, N, k, r0[k], r1[k], cp.Minimize))
    first = max(lower, key=lambda answer: answer.value, default=held)
    least = first.value if lower else 0.0
    if least > most * (1 + RESIDUAL):
        why = f"no load factor has a state of rest: {only}{load[first.corner]} needs at least {least:.4g}, {load[governs.corner]} at most {most:.4g}"
        return _result(
            question, replace(governs, value=np.nan, bound=np.nan), np.nan, why, [*answers, *lower]
        )
    if governs is held:
        why = "supports hold the bodies: no motion of theirs is left to the contact alone"
    elif most == np.inf:
        why = f"{only}forces within {bounds} balance the loads at all load factors{f' from {least:.4g} on' * (least > 0)}"
    else:
        unbalanced = f"{only}forces within {bounds} cannot balance {load[governs.corner]}: {_moves(question, governs)}"
        why = f"above it no state of rest exists, whatever slips and opens: {unbalanced}"
    if least > 0:
        why += (
            f"; below {least:.4g} nothing balances {load[first.corner]}: {_moves(question, first)}"
        )
    return _result(question, governs, least, why, [*answers, *lower])


@dataclass(frozen=True, eq=False)
class _Answer:
    """What a corner allows: a load factor, its bound, and the motion phi (M,) of size 1 that proves it."""

    corner: int
    value: float
    bound: float
    phi: Array
    record: SolveRecord
    problem: cp.Problem | None

    @property
    def residual(self) -> float:
        """The largest error of both proofs."""
        return self.record.residual


def _statics(question: Question, N: Array, k: int, r0: Array, r1: Array, sense: Any) -> _Answer:
    """The largest or least load factor at which forces balance corner k, r0 + load_factor r1, (M,), in the rigid motions N (M, m); nan where none."""
    held, drives = (
        float(size) if (size := np.linalg.norm(N.T @ r)) > CONDENSATION * np.linalg.norm(r) else 0.0
        for r in (r0, r1)
    )
    load = {f"r0{f'[{k}]' * question.fixed}": r0, f"r1[{k}]": r1 if drives else np.zeros_like(r1)}
    unit, n = _load_unit(question, N, r0, r1) if held and drives else 1.0, question.system.nodes
    f, strength = (
        cp.Parameter(n, nonneg=True, name="f", value=question.friction),
        question.system.shear_strength,
    )
    rows = models.gross_slip(N, load, f, strength, question.system.slip_shape, sense)
    problem = Problem(rows.objective, rows.constraints)
    load_factor, q, p = (
        next(each for each in problem.variables() if each.name() == name)
        for name in ("load_factor", "q", "p")
    )
    sheared = question.node_unit * np.where(
        (question.friction > 0) & (question.friction < 1), question.friction, 1.0
    )
    chain = Chain(
        problem,
        {load_factor: unit, q: sheared.reshape(n, *[1] * (q.ndim - 1)), p: question.node_unit},
        unit=unit,
        defines=False,
    )

    def still(value: float, bound: float, residual: float) -> _Answer:
        return _Answer(k, value, bound, np.zeros(len(N)), SolveRecord(residual=residual), problem)

    def moving(value: float, bound: float, residual: float) -> _Answer:
        """With the motion that the multipliers of balance are: how far it strains the bodies, or lifts less than friction needs, counts too."""
        S, phi = question.system.S, N @ problem.constraints[0].dual_value
        phi = phi / (float(np.linalg.norm(phi.reshape(-1, n), axis=0).max()) or np.nan)
        *v, w = phi.reshape(-1, n)
        lack = float(
            np.where(strength < np.inf, -w, question.friction * np.linalg.norm(v, axis=0) - w).max()
        )  # what is strained off need not rise
        strain = float(np.abs(S @ phi).max()) / (float(np.diag(S).max()) or 1.0)
        worst = float(np.nan_to_num(np.max([residual, lack, strain]), nan=np.inf))
        return _Answer(k, value, bound, phi, SolveRecord(residual=worst), problem)

    def answered() -> _Answer:
        value = float(load_factor.value)
        found = (
            value if value > ZERO_LOAD_FACTOR * unit else 0.0,
            chain.proof.bound,
            max(chain.proof.gap, chain.violation),
        )
        return (
            still(*found) if sense is cp.Minimize and not found[0] else moving(*found)
        )  # no motion proves that it is at least 0

    def none() -> _Answer | None:
        if no := chain.contradiction():
            return moving(np.nan, np.nan, no.residual)
        more = chain.growth()
        return still(np.inf, np.inf, more.residual) if more else None

    answer, record = chain.solve(answered, no_optimum=none)
    return replace(answer, record=record)


def _load_unit(question: Question, N: Array, r0: Array, r1: Array) -> float:
    """Load factor at which the cyclic load reaches the friction of the mean load, or in the normal motions the mean load itself."""
    friction, shear = (
        min(float(question.friction.max()), 1.0) or 1.0,
        len(r1) - question.system.nodes,
    )
    sheared, swung = (
        float(np.linalg.norm(part)) for part in (N[:shear].T @ r1[:shear], N[shear:].T @ r1[shear:])
    )
    return friction * float(np.linalg.norm(N.T @ r0)) / (sheared + friction * swung)


def _checked(system: ContactSystem, contacts: Iterable[str]) -> tuple[list[str], Booleans]:
    """Names of contacts of the system, at least one, and which nodes (N,) belong to them."""
    names = listed("contacts", contacts)
    if system.contact is None:
        raise ModelError(
            f"contacts: {shown(names)}, but the system has no names of contacts; give them as its `contact`, or leave contacts out"
        )
    known = list(dict.fromkeys(system.contact.tolist()))
    if not names or (unknown := [name for name in names if name not in known]):
        raise ModelError(
            f"contacts: {shown(unknown[0] if names else names)}; give some of {known}, or None for all"
        )
    return names, np.isin(system.contact, names)


def _moves(question: Question, answer: _Answer) -> str:
    return moves_told(motion_table(question.system, answer.phi.reshape(-1, question.system.nodes)))


def _result(
    question: Question, governs: _Answer, least: float, reason: str, answers: Sequence[_Answer]
) -> GrossSlip:
    records, phi = (
        [answer.record for answer in answers],
        governs.phi.reshape(-1, question.system.nodes),
    )
    attempts = tuple(attempt for record in records for attempt in record.attempts)
    worst, seconds = (
        max(record.residual for record in records),
        sum(record.seconds for record in records),
    )
    idle = len(question.cycle.corners) - len({answer.corner for answer in answers})
    left_out = (
        (f"corners: {idle} of {len(question.cycle.corners)} are within the hull of the others",)
        if idle and governs.problem
        else ()
    )
    return GrossSlip(
        load_factor=governs.value,
        bound=governs.bound,
        least=least,
        corner=governs.corner if np.isfinite(governs.phi).all() and governs.phi.any() else -1,
        loads=question.cycle.corner_names[governs.corner] if governs.phi.any() else "",
        phi=phi,
        motion=motion_table(question.system, phi),
        reason=reason,
        record=replace(
            governs.record, attempts=attempts, residual=worst, left_out=left_out, seconds=seconds
        ),
        problem=governs.problem,
    )


def beyond_statics(
    found: GrossSlip, system: ContactSystem, cycle: LoadCycle, friction: Array
) -> GrossSlip:
    """An answer of statics, corrected by transients if contact forces can balance themselves, and the cyclic loads drive the bodies."""
    if found.problem is None or np.isnan(found.load_factor) or not friction.any():
        return found
    N, loads = rigid_motions(system.S, system.own_stiffness), reactions(system, cycle.corners)
    driven = np.linalg.norm(loads @ N, axis=1) > CONDENSATION * np.linalg.norm(loads, axis=1)
    forces = self_stress(system, friction, N) if driven.any() else None
    if forces is None:
        return found
    slides_off, why = sliding_off(system, cycle, friction, found.load_factor)
    unknown = f"contact forces balance themselves here, so statics cannot know how far the fit presses: {found.reason}"
    if not why:
        return replace(
            found,
            self_stress=forces,
            reason=f"{unknown}; transients from no slip go on up to there",
        )
    if slides_off == 0:
        reason = f"from no slip the transient finds no way on at any load factor ({why}); {unknown}"
        return replace(found, self_stress=forces, load_factor=np.nan, reason=reason)
    reason = f"from no slip the transient finds no way on above {slides_off:.4g} ({why}); {unknown}"
    return replace(found, self_stress=forces, load_factor=slides_off, reason=reason)
