"""Sentences about a mean load from which no transient can start.

`mean_load_diagnosis` describes the mean load, `unscaled_diagnosis` also the fixed parts of a cycle.
"""

import numpy as np

from ..base import CONDENSATION, Array, Booleans, PerNode, number_of
from ..contact import (
    ContactSystem,
    LoadCycle,
    checked_cycle,
    friction_coefficients,
    joined,
    lengths,
    most_shear,
)
from ..contact.diagnosis import counted, names_of_several, open_nodes
from .statics import Statics

SAFE = "the mean load presses all nodes and none slips under it"
SAFE_WITH_FIXED = "with each of the fixed parts the mean load presses all nodes and none slips"
UNPRESSED = (
    "the mean load {shear}, and nothing presses the bodies together: add a load to `cycle.mean` "
    "that presses them"
)
PULLS = (
    "the mean load {pulls}: its normal reactions sum to {total:.3g}, and compression must be "
    "positive; change the sign of the load, or press the contact; given normals must point from "
    "body 2 into body 1"
)
WOULD_PULL = "the mean load would pull at {nodes} if the contact were closed: press it there"
OPEN = (
    "{nodes} are open under the mean load alone if no node slips{gaps}: the contact is incomplete; "
    "press these nodes if they should carry load"
)
GAPS = ", {number} of them with an initial gap that the load does not close"
BARE = "{nodes} carry no pressure under the mean load if nothing slips"
SMOOTH = "{nodes} have no friction and slip under the shear of the mean load"
BEYOND = (
    "the mean load presses all nodes, but {nodes} exceed their {bound} and slip: {remedy}{shear}"
)
LESS_SHEAR = ", or less shear"
PRESSED_ALONE = "; the resultant shear of the load is zero: the pressing load causes the shear"


def mean_load_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: PerNode) -> str:
    """Sentence about the mean load: its fault and the remedy, or that it has none.

    Wrong are: a mean load that is zero, pulls the bodies apart, or makes a body slide, turn or lift
    off as a whole; nodes that are open, without pressure or beyond their friction bound while
    nothing slips. Sentences are joined by "; ", without a full stop.
    """
    f = friction_coefficients(friction, system)
    glued_q, glued_p = system.reaction(checked_cycle(cycle).mean)
    if not glued_p.any():
        return UNPRESSED.format(shear="has no normal reactions" if glued_q.any() else "is zero")
    rounding = CONDENSATION * np.abs(glued_p).sum()
    if glued_p.sum() <= rounding:
        pulls = "does not press the bodies together"
        if glued_p.sum() < -rounding:
            pulls = "pulls the bodies apart"
        return PULLS.format(pulls=pulls, total=glued_p.sum())
    # Whichever nodes open, a body may slide or turn as a whole.
    moved = Statics(system, f).sentence("the mean load", joined(glued_q, glued_p))
    if moved:
        return moved
    q, p = cycle.mean_reaction(system)
    floor = CONDENSATION * float(np.abs(np.r_[glued_q.ravel(), glued_p]).mean())
    if (p < -floor).any():
        return _open_text(system, p, floor)
    return _closed_text(system, f, q, p, floor)


def unscaled_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: PerNode) -> str:
    """The diagnosis of the mean load with the loads that the load factor does not scale.

    It is that of the first `fixed` part with which the mean load is not safe if nothing slips.
    """
    if checked_cycle(cycle).fixed is None:
        return mean_load_diagnosis(system, cycle, friction)
    for k, loads in enumerate(cycle.unscaled):
        text = mean_load_diagnosis(system, LoadCycle(loads, cycle.corners), friction)
        if text != SAFE:
            return text.replace("the mean load", f"the mean load with fixed[{k}]")
    return SAFE_WITH_FIXED


def _open_text(system: ContactSystem, p: Array, floor: float) -> str:
    """Text on a mean load that pulls at some nodes of the closed contact."""
    opened = open_nodes(system, p)
    if opened is None:
        return WOULD_PULL.format(nodes=_share(system, p < -floor))
    number = int((opened & (system.gap > 0)).sum())
    gaps = GAPS.format(number=number) if number else ""
    return OPEN.format(nodes=_share(system, opened), gaps=gaps)


def _closed_text(system: ContactSystem, f: Array, q: Array, p: Array, floor: float) -> str:
    """Text on a mean load with which all nodes are closed, if nothing slips."""
    shear = lengths(q, p)
    bare = np.abs(p) <= floor
    smooth = (f == 0) & (shear > floor)
    exceeding = shear > most_shear(system, f, p) + floor
    texts = []
    if bare.any():
        texts.append(BARE.format(nodes=_share(system, bare)))
    if smooth.any():
        texts.append(SMOOTH.format(nodes=_share(system, smooth)))
    if texts:
        return "; ".join(texts)
    if not exceeding.any():
        return SAFE
    bound = "friction bound f p"
    remedy = "more friction"
    if system.capped:
        bound = "bound of friction or strength"
        remedy = "more of the lower one"
    total = np.abs((q * system.stretch).reshape(len(p), -1).sum(axis=0)).max()
    pressed_alone = total <= CONDENSATION * float(shear.sum())
    return BEYOND.format(
        nodes=_share(system, exceeding),
        bound=bound,
        remedy=remedy,
        shear=PRESSED_ALONE if pressed_alone else LESS_SHEAR,
    )


def _share(system: ContactSystem, which: Booleans) -> str:
    """Number of some nodes, and their contacts or, if there is one contact, their positions."""
    numbers = np.flatnonzero(which)
    if names_of_several(system) is not None:
        return counted(system, np.asarray(which))
    places = []
    # Ranges of nodes that a sentence names.
    most_ranges = 4
    if system.tangents == 2:
        points = system.points[numbers]
        for name, low, high in zip("xyz", points.min(axis=0), points.max(axis=0), strict=True):
            end = f" .. {high:.4g}" if high > low else ""
            places.append(f"{name} = {low:.4g}{end}")
    else:
        # Nodes that follow each other make one range.
        runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
        for run in runs[:most_ranges]:
            end = f" .. {system.x[run[-1]]:.4g}" if len(run) > 1 else ""
            places.append(f"{system.x[run[0]]:.4g}{end}")
        places[0] = f"x = {places[0]}"
        if len(runs) > most_ranges:
            places.append("...")
    return f"{len(numbers)} of {number_of(system.nodes, 'node')} ({', '.join(places)})"
