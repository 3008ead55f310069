"""Sentences of a report: the kind of contact, and advice from its answers."""

from collections.abc import Iterator

import numpy as np

from ..base import ROUNDING, Outcome
from ..contact.diagnosis import counted
from ..limits import GrossSlip
from ..transients import SteadyState
from .report_parts import ReportParts, many_nodes_slip, mean_load_opens


def kind_of_contact(parts: ReportParts) -> str:
    """The open nodes under the mean load and in the steady cycle, and their effect on limits."""
    mean, steady, system = parts.mean_state, parts.steady, parts.system
    if mean is None:
        return (
            "From no slip the mean load is not followed to a state of rest: "
            f"{parts.missing['mean load']}."
        )
    if mean.open.all():
        return "The mean load opens all nodes."
    if mean.open.any():
        return (
            f"The mean load leaves {counted(system, mean.open)} open. Pressure falls to zero "
            "beside them. There the last closed node decides every limit, which falls as elements "
            "shrink: limits change with the mesh."
        )
    if steady is None:
        return "All nodes are closed under the mean load."
    if steady.open.any():
        return (
            f"All nodes are closed under the mean load; {counted(system, steady.open)} lift off in "
            "each cycle at load factor 1."
        )
    return (
        "All nodes are closed under the mean load, and in each cycle at load factor 1. At sharp "
        "edges pressure grows as elements shrink, and limits there settle with the mesh slowly or "
        "not at all; where edges are rounded or the surfaces give, they settle."
    )


def advice_on(parts: ReportParts) -> Iterator[str]:
    """Advice from the numbers of a report, in sentences."""
    if parts.mean_state is not None and parts.mean_state.open.all():
        yield "The mean load opens all nodes: press the contact."
        return
    # More friction helps, unless it is known that no friction keeps the contact stuck.
    friction_helps = parts.required is None or bool(np.isfinite(parts.required.required))
    if parts.gross_slip is not None:
        yield from _on_sliding(parts.gross_slip, friction_helps)
    if parts.steady is not None:
        if parts.steady.outcome is Outcome.SHAKEDOWN:
            yield from _on_rest(parts, parts.steady)
        else:
            yield from _on_slip(parts, parts.steady, friction_helps)
    elif "steady state at load factor 1" in parts.missing:
        yield "At your load no steady state is found, see what is without an answer."
    if mean_load_opens(parts):
        settled = "the gross-slip load"
        if many_nodes_slip(parts):
            settled += ", the work and the share that slips"
        yield f"Quote {settled}, not the limits, which change with the mesh."


def _on_sliding(gross_slip: GrossSlip, friction_helps: bool) -> Iterator[str]:
    """Advice on bodies that slide off."""
    if not gross_slip.load_factor * (1 + ROUNDING) >= 1:
        raise_friction = " raise friction," if friction_helps else ""
        yield (
            "At your load nothing rests, bodies slide off: press them more,"
            f"{raise_friction} or load them less."
        )
    elif gross_slip.least * (1 - ROUNDING) > 1:
        yield (
            f"At your load nothing rests: below load factor {gross_slip.least:.4g} the mean load "
            "slides bodies off."
        )
    elif gross_slip.load_factor < np.inf:
        of_fit = ""
        if gross_slip.self_stress is not None:
            of_fit = " in a transient from no slip: statics cannot know how far the fit presses"
        yield (
            f"Your load is {1 / gross_slip.load_factor:.1%} of the gross-slip load, at which "
            f"bodies slide off{of_fit}."
        )


def _on_rest(parts: ReportParts, steady: SteadyState) -> Iterator[str]:
    """Advice on a contact that stops slipping, if it starts without slip."""
    guaranteed = parts.guaranteed
    if (steady.friction == 0).any() and parts.contacts["slip_range"].max() > 0:
        yield "At your load no friction does work; nodes without friction slide to and fro."
    else:
        yield "From assembly without slip the contact stops slipping at your load."
    if guaranteed is not None and guaranteed.load_factor < 1 and steady.friction.any():
        yield (
            "Another start may slip for ever: `dissipation_range` says how much the start matters."
        )


def _on_slip(parts: ReportParts, steady: SteadyState, friction_helps: bool) -> Iterator[str]:
    """Advice on a contact that slips in every cycle, from the steady state and the limits."""
    contacts, limit, guaranteed = parts.contacts, parts.limit, parts.guaranteed
    place = ""
    if len(contacts) > 1:
        worst = contacts.loc[contacts["work"].idxmax()]
        place = f", most of the work is done in {worst['contact']}"
    yield (
        f"From assembly without slip {steady.slipping_share:.1%} of all contacts slips in every "
        f"cycle at your load{place}."
    )
    if steady.outcome is Outcome.RATCHETING:
        yield "It ratchets: with each cycle it slips further in one direction."
    if limit is not None and limit.least <= 1 <= limit.load_factor:
        yield (
            "A state of rest exists at your load: `steady_state(..., initial_slip=limit.slip)` "
            "shows whether that start leads there."
        )
    elif parts.required is not None and friction_helps:
        yield (
            f"Friction of {parts.required.required:.3g} and the right residual slip would keep it "
            "stuck."
        )
    if guaranteed is not None and guaranteed.load_factor >= 1:
        yield (
            "It slips below the guaranteed limit: nodes open and close in each cycle, and such "
            "cycles it does not cover."
        )
