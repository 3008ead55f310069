"""What the mean load does to a contact, in sentences: why there is no limit, or no state from which a transient can start."""

import numpy as np
from numpy.typing import ArrayLike

from ..contact import CONDENSATION, Array, ContactSystem, LoadCycle, checked_cycle, checked_system, friction_coefficients, joined, lengths
from ..contact.diagnosis import open_nodes
from .sliding import Statics

_SAFE = "the mean load presses all nodes and none slips under it"
_RANGES = 4  # ranges of x that a text names


def mean_load_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> str:
    """Describe what is wrong with the mean load and how to correct it, or that nothing is wrong.

    Parameters
    ----------
    system, cycle
        The contact, plane or in space, and its load cycle.
    friction
        Coefficient of friction, one or one per node.

    Returns
    -------
    str
        Sentences joined by "; ", without a full stop: whether the mean load is zero or pulls the bodies apart, which nodes it leaves open or without
        pressure, whether it makes a body slide, turn or lift off as a whole, and which nodes are beyond their friction bound while nothing slips.

    Raises
    ------
    ModelError
        Bad input.
    """
    f = friction_coefficients(friction, checked_system(system).nodes)
    glued_q, glued_p = system.reaction(checked_cycle(cycle).mean)
    if not glued_p.any():
        what = "has no normal reactions" if glued_q.any() else "is zero"
        return f"the mean load {what}, and nothing presses the bodies together: give `cycle.mean` a load that does"
    if glued_p.sum() <= CONDENSATION * np.abs(glued_p).sum():
        return _pulls(glued_p)
    if moved := Statics(system, f).told("the mean load", joined(glued_q, glued_p)):
        return moved  # whatever opens
    q, p = cycle.mean_reaction(system)
    floor, shear = CONDENSATION * float(np.abs(np.r_[glued_q.ravel(), glued_p]).mean()), lengths(q, p)
    if (p < -floor).any():
        return _opens(system, p, floor)
    bare, smooth, beyond = np.abs(p) <= floor, (f == 0) & (shear > floor), shear > f * p + floor
    texts = list[str]()
    if bare.any():
        texts.append(f"{_share(system, bare)} carry no pressure under the mean load if nothing slips")
    if smooth.any():
        texts.append(f"{_share(system, smooth)} have no friction and slip under the shear of the mean load")
    if not texts and beyond.any():
        return f"the mean load presses all nodes, but {_share(system, beyond)} exceed their friction bound f p and slip: more friction, or less shear"
    return "; ".join(texts) or _SAFE


def unscaled_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> str:
    """The same of what the load factor leaves as it is: of the mean load, or of it with the first `fixed` part that is not safe if nothing slips."""
    if checked_cycle(cycle).fixed is None:
        return mean_load_diagnosis(system, cycle, friction)
    for k, loads in enumerate(cycle.unscaled):
        text = mean_load_diagnosis(system, LoadCycle(loads, cycle.corners), friction)
        if text != _SAFE:
            return text.replace("the mean load", f"the mean load with fixed[{k}]")
    return "with each of the fixed parts the mean load presses all nodes and none slips"


def _pulls(p: Array) -> str:
    pulls = "pulls the bodies apart" if p.sum() < -CONDENSATION * np.abs(p).sum() else "does not press the bodies together"
    return (
        f"the mean load {pulls}: its normal reactions sum to {p.sum():.3g}, and compression must be positive; "
        "turn the sign of the load, or press the contact; normals of your own must point from body 2 into body 1"
    )


def _opens(system: ContactSystem, p: Array, floor: float) -> str:
    opened = open_nodes(system, p)
    if opened is None:
        return f"the mean load would pull at {_share(system, p < -floor)} if the contact were closed: press it there"
    gaps = int((opened & (system.gap > 0)).sum())
    initial = f", {gaps} of them with an initial gap that the load does not close" if gaps else ""
    return (
        f"{_share(system, opened)} are open under the mean load alone if nothing slips{initial}: the contact is incomplete; press these nodes "
        "if they are to carry load"
    )


def _share(system: ContactSystem, which: np.ndarray) -> str:
    """Number and positions of the nodes, as a text."""
    numbers = np.flatnonzero(which)
    if system.tangents == 2:
        low, high = (pick(system.points[numbers], axis=0) for pick in (np.min, np.max))
        where = (f"{name} = {a:.4g}" + (f" .. {b:.4g}" if b > a else "") for name, a, b in zip("xyz", low, high, strict=True))
        return f"{len(numbers)} of {system.nodes} nodes ({', '.join(where)})"
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    ranges = [f"{system.x[run[0]]:.4g}" + (f" .. {system.x[run[-1]]:.4g}" if len(run) > 1 else "") for run in runs[:_RANGES]]
    more = ", ..." if len(runs) > _RANGES else ""
    return f"{len(numbers)} of {system.nodes} nodes (x = {', '.join(ranges)}{more})"
