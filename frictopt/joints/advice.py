"""Sentences of a report: the kind of contact, and advice from its answers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..base import ROUNDING, Array, Outcome, number_of
from ..contact import ContactSystem
from ..contact.diagnosis import counted, nodes_of_contacts
from ..limits import GrossSlip, RequiredFriction
from ..limits.balance.statics import MOVES
from ..study.protocols import FrictionAfterProtocol
from ..transients import SteadyState
from .report_tables import (
    ReportParts,
    increments_are_coarse,
    limits_change_with_mesh,
    many_nodes_slip,
)
from .thresholds import QUANTITIES, SLIP_RANGE

# Names of the motions in which bodies slide off: slides, turns, pries, lifts off.

SLIDES, TURNS, PRIES, LIFTS_OFF = "slides", "turns", "pries", "lifts off"
# If the contacts of a joint move in several ways, the joint gets the first motion in this order.
_ORDER = (PRIES, TURNS, SLIDES, LIFTS_OFF)
_MOST_NAMES = 4  # largest number of contacts that a sentence names


def motions_of_contacts(system: ContactSystem, gross_slip: GrossSlip) -> dict[str, str]:
    """Contact -> name of its motion, for the contacts that move as bodies slide off."""
    motions = dict[str, str]()
    faces = nodes_of_contacts(system)
    # The normals of a flat face differ by at most this number.
    flat = 1e-6
    for row in gross_slip.motion.to_dict("records"):
        name = str(row["contact"])
        nodes = faces[name]
        is_flat = np.ptp(system.normals[nodes], axis=0).max() <= flat
        motions[name] = _motion(gross_slip.phi[:, nodes], float(row["turn"]), bool(is_flat))
    return motions


def _motion(phi: Array, turn: float, is_flat: bool) -> str:
    """Name of a motion (t + 1, n) of the nodes of a contact; `turn` is its angle, NaN if unknown.

    A turn that pries a face open tilts it: the lifts of its nodes differ by more than their mean
    slip. A turn about the normal of a flat face, or of a shaft in its hub, lifts all nodes alike.
    If all nodes that move lift by the same distance, the angle is 0. A flat face is then pried
    open, too, if its other nodes stay at rest.
    """
    *slips, lift = phi
    slip = float(np.linalg.norm(slips, axis=0).mean())
    tilt = float(np.ptp(lift))
    turns = is_flat or turn != 0  # also if the angle is NaN
    if tilt > slip + MOVES and turns:
        return PRIES
    if turn != 0 and not np.isnan(turn):
        return TURNS
    return SLIDES if slip > MOVES else LIFTS_OFF


def motion_of_joint(system: ContactSystem, gross_slip: GrossSlip) -> str:
    """Name of the motion of the joint; "" if it does not slide off."""
    motions = set(motions_of_contacts(system, gross_slip).values())
    return next((name for name in _ORDER if name in motions), "")


def motion_in_words(system: ContactSystem, gross_slip: GrossSlip, body: str) -> str:
    """Text such as "body blade pries at lap and slides at head, nut"; "" without a motion.

    `body` is the name of body 1, or "1".
    """
    by_motion = dict[str, list[str]]()
    for contact, motion in motions_of_contacts(system, gross_slip).items():
        by_motion.setdefault(motion, []).append(contact)
    texts = [f"{name} at {_some(by_motion[name])}" for name in _ORDER if name in by_motion]
    return f"body {body} {' and '.join(texts)}" if texts else ""


def _some(contacts: Sequence[str]) -> str:
    names = list(contacts[:_MOST_NAMES])
    if len(contacts) > _MOST_NAMES:
        names.append(f"{len(contacts) - _MOST_NAMES} more")
    return ", ".join(names)


# The numbers of advice.

# Largest coefficient of friction that advice asks for. Dry metals reach about 1.
_PRACTICAL_FRICTION = 1.0
# The sliding-off load of a joint that pries says little about slip if the joint slips much at a far
# smaller load. "Far smaller" is below this share of the sliding-off load.
_FAR_BELOW = 0.5
# "Much" is more than this share of the contacts.
_MUCH_SLIPS = 0.05

_MOVES_OFF = {
    SLIDES: "bodies slide off",
    TURNS: "bodies turn",
    PRIES: "bodies pry open",
    LIFTS_OFF: "bodies lift off",
}


def kind_of_contact(parts: ReportParts) -> str:
    """The open nodes under the mean load and in the steady cycle, and their effect on limits."""
    mean, steady, system = parts.mean_state, parts.steady, parts.system
    if mean is None:
        return "No state of rest is found under the mean load, from no slip."
    if mean.open.all():
        return "The mean load opens all nodes."
    if mean.open.any() and not limits_change_with_mesh(parts):
        return (
            f"The mean load leaves {counted(system, mean.open)} open. Slip changes no pressure, "
            "and normal loads alone open and close nodes in each cycle: limits hold for all "
            "openings and closings."
        )
    if mean.open.any():
        return (
            f"The mean load leaves {counted(system, mean.open)} open. Pressure falls to zero "
            "beside them. The last closed node there governs every limit. Limits fall as elements "
            "shrink, so they change with the mesh."
        )
    if steady is None:
        return "All nodes are closed under the mean load."
    if steady.open.any():
        return (
            f"All nodes are closed under the mean load; {counted(system, steady.open)} lift off in "
            "each cycle at load factor 1."
        )
    return (
        "All nodes are closed under the mean load, and in each cycle at load factor 1. Limits at "
        "sharp edges change with the mesh."
    )


def gross_slip_in_words(parts: ReportParts) -> Iterator[str]:
    """The gross-slip load, the motion of the bodies, and a note if equilibrium cannot decide."""
    gross = parts.gross_slip
    if gross is None:
        return
    motion = motion_in_words(parts.system, gross, _body_1(parts))
    if np.isnan(gross.load_factor):
        yield f"No load factor has a state of rest: {motion}."
    elif gross.load_factor == np.inf and gross.self_stress is None:
        yield "Bodies do not slide off at any load factor."
    elif gross.load_factor == np.inf:
        yield "Equilibrium alone has no load at which bodies slide off."
    elif motion:
        faces = parts.contacts
        held = ""
        if "carries" in faces and faces["carries"].count() > 1:
            shares = zip(faces["contact"], faces["carries"], strict=True)
            held = ", ".join(f"{name} {share:.0%}" for name, share in shares if share >= 0.005)
            held = f" Friction there is shared by {held}." if held else ""
        yield f"At load factor {gross.load_factor:.4g} {motion}.{held}"
    else:
        yield f"At load factor {gross.load_factor:.4g} bodies slide off."
    if gross.self_stress is not None:
        yield (
            "Contact forces can balance themselves here, as in a press fit or with a locked bolt: "
            "equilibrium does not determine the pressure of the fit, and transients decide."
        )


def _body_1(parts: ReportParts) -> str:
    """The name of body 1, or "1" if it is not known, or not the same in all contacts."""
    contacts = [] if parts.model is None else parts.model.contacts
    names = {contact.body_1 for contact in contacts}
    return names.pop() if len(names) == 1 else "1"


def advice_on(parts: ReportParts) -> Iterator[str]:
    """Advice from the numbers of a report, in sentences."""
    if parts.mean_state is not None and parts.mean_state.open.all():
        yield "The mean load opens all nodes: press the contact."
        return
    # More friction helps, unless it is known that no friction keeps the contact stuck.
    friction_helps = parts.required is None or bool(np.isfinite(parts.required.required))
    if parts.steady is not None:
        if parts.steady.outcome is Outcome.SHAKEDOWN:
            yield from _on_rest(parts, parts.steady)
        else:
            yield from _on_slip(parts, parts.steady, friction_helps)
        yield from _on_assembled_limit(parts)
        yield from _on_increments(parts.steady)
    elif parts.gross_slip is None or parts.gross_slip.rests_at(1.0):
        yield "At your load no steady state is found, see the missing results."
    if parts.gross_slip is not None:
        yield from _on_sliding(parts, parts.gross_slip, friction_helps)
    yield from _on_verdicts(parts)
    if limits_change_with_mesh(parts):
        settled = "the gross-slip load"
        if many_nodes_slip(parts):
            settled += ", the work and the share that slips"
        yield f"Quote {settled}, not the limits, which change with the mesh."


def _on_verdicts(parts: ReportParts) -> Iterator[str]:
    """Whether the thresholds are kept."""
    if parts.verdicts.empty:
        return
    failed = parts.verdicts.loc[~parts.verdicts["passed"].astype(bool), "quantity"].tolist()
    if failed:
        yield f"Not passed: {', '.join(failed)}."
    else:
        yield "All of your thresholds are kept."


def _on_sliding(parts: ReportParts, gross_slip: GrossSlip, friction_helps: bool) -> Iterator[str]:
    """Advice on bodies that slide off, turn, pry open or lift off."""
    motion = motion_of_joint(parts.system, gross_slip)
    move_off = _MOVES_OFF.get(motion, "bodies slide off")
    if not gross_slip.load_factor * (1 + ROUNDING) >= 1:
        raise_friction = " raise friction," if friction_helps and motion in (SLIDES, TURNS) else ""
        yield (
            f"At your load no state of rest exists, {move_off}: press them more,"
            f"{raise_friction} or load them less."
        )
    elif gross_slip.least * (1 - ROUNDING) > 1:
        yield (
            f"At your load no state of rest exists: below load factor {gross_slip.least:.4g} "
            "the mean load slides bodies off."
        )
    elif gross_slip.load_factor < np.inf:
        of_fit = ""
        if gross_slip.self_stress is not None:
            of_fit = (
                " in a transient from no slip: equilibrium does not determine the "
                "pressure of the fit"
            )
        share = 1 / gross_slip.load_factor
        yield f"Your load is {share:.1%} of the gross-slip load, at which {move_off}{of_fit}."
        slips = 0.0 if parts.steady is None else parts.steady.slipping_share
        if motion == PRIES and share < _FAR_BELOW and slips > _MUCH_SLIPS:
            yield (
                "That load opens the joint and says little about slip, which begins far below it: "
                "judge the slip by its range and its work."
            )


def _on_rest(parts: ReportParts, steady: SteadyState) -> Iterator[str]:
    """Advice on a contact that stops slipping after a start without slip."""
    guaranteed = parts.guaranteed
    if (steady.friction == 0).any() and parts.contacts["slip_range"].max() > 0:
        yield "At your load friction does no work; nodes without friction slide to and fro."
    else:
        cycles = number_of(steady.cycles, "cycle")
        yield f"As assembled the joint stops slipping at your load, after at most {cycles}."
    if guaranteed is not None and guaranteed.load_factor < 1 and steady.friction.any():
        yield (
            "Another start may slip for ever: `dissipation_range` shows how much the start matters."
        )


def _on_slip(parts: ReportParts, steady: SteadyState, friction_helps: bool) -> Iterator[str]:
    """Advice on a contact that slips in every cycle, from the steady state and the limits."""
    limit, guaranteed = parts.limit, parts.guaranteed
    length = "" if parts.system.units is None else f" {parts.system.units.split(', ')[1]}"
    largest = QUANTITIES[SLIP_RANGE].judged(steady)
    yield (
        f"As assembled the joint slips for ever at your load: {steady.slipping_share:.1%} of all "
        f"contacts slips in each cycle, by up to {largest.value:.3g}{length} at {largest.where}."
    )
    if steady.outcome is Outcome.RATCHETING:
        yield (
            "It ratchets: with each cycle it slips further in one direction, by up to "
            f"{steady.drift:.3g}{length}."
        )
    if limit is not None and limit.least <= 1 <= limit.load_factor:
        yield (
            "A state of rest exists at your load: `steady_state(..., initial_slip=limit.slip)` "
            "shows whether that start leads there."
        )
    elif parts.required is not None and friction_helps:
        yield from _on_required_friction(parts.required)
    if parts.required_assembled is not None:
        yield from _on_friction_as_assembled(parts.required_assembled)
    if guaranteed is not None and guaranteed.load_factor >= 1:
        yield (
            "It slips below the guaranteed limit: nodes open and close in each cycle, and this "
            "limit does not cover such cycles."
        )


def _on_assembled_limit(parts: ReportParts) -> Iterator[str]:
    """The load up to which the joint as assembled stops slipping; it lies between the limits."""
    assembled, guaranteed = parts.assembled, parts.guaranteed
    if assembled is None:
        return
    from_any = ""
    if guaranteed is not None:
        from_any = f", from any start up to {guaranteed.load_factor:.3g}"
    yield (
        f"As assembled it stops up to load factor {assembled.load_factor:.3g}{from_any}, from no "
        f"start above {assembled.shakedown_limit:.3g}."
    )
    for name, value, error, _ in parts.probability.tail(1).itertuples(index=False):
        which = name.removeprefix("probability ")
        by_sample = f" (standard error {error:.2g})" if error else ""
        yield f"At your load, slip stops {which} with the probability {value:.3g}{by_sample}."
    if not assembled.monotonic:
        yield f"It also stops at some load factors above {assembled.upper:.3g}, where it slips."


def _on_required_friction(answer: RequiredFriction) -> Iterator[str]:
    """Advice on the friction that would keep the contact stuck, as far as it is practical."""
    required = answer.required
    if float(f"{required:.3g}") <= _PRACTICAL_FRICTION:
        yield (
            f"With friction of {_rounded_up(answer)} or more, some residual slip keeps it stuck; "
            "from others it may still slip in every cycle."
        )
    else:
        yield (
            f"No practical friction keeps it stuck: it needs {required:.3g}. Press the contact "
            "more, or load it less."
        )


def _on_friction_as_assembled(answer: FrictionAfterProtocol) -> Iterator[str]:
    """Advice on the friction with which slip stops as assembled."""
    if answer.required == np.inf:
        yield f"As assembled it slips for ever, also with friction of {answer.lower:.3g}."
    else:
        yield f"As assembled it stops from friction {answer.required:.3g} on."
    if not answer.monotonic:
        yield f"It also stops with some frictions below {answer.lower:.3g}, with which it slips."


def _rounded_up(required: RequiredFriction) -> str:
    """The required friction with three digits, rounded up, because less does not suffice."""
    value = required.required
    rounded = float(f"{value:.3g}")
    # The exact value lies between the bound and the required friction.
    if rounded < required.bound:
        rounded += 10 ** (np.floor(np.log10(value)) - 2)  # one more in the last digit
    return f"{rounded:.3g}"


def _on_increments(steady: SteadyState) -> Iterator[str]:
    """Advice on increments that are too coarse."""
    if not steady.steps:
        return
    if np.isinf(steady.step_error):
        yield (
            f"Finer increments may have another answer: repeat with steps={4 * steady.steps}, or "
            "more."
        )
    elif increments_are_coarse(steady):
        yield (
            f"Finer increments may change the work by {steady.step_error:.0%}: repeat with "
            f"steps={2 * steady.steps}."
        )
