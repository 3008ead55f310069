"""Diagnosis of the mean load in sentences: why a contact has no limit, or no state from which a transient can start."""

from math import hypot

import numpy as np
from numpy.typing import ArrayLike

from .checks import Array
from .coulomb import friction_coefficients, lengths
from .cycle import LoadCycle, checked_cycle
from .system import ContactSystem, checked_system
from .tolerances import CONDENSATION

_MOST_SETS = 100  # changes of the set of open nodes
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
        pressure, whether it makes the body slide as a whole, and which nodes are beyond their friction bound while nothing slips.

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
    q, p = cycle.mean_reaction(system)
    floor, shear = CONDENSATION * float(np.abs(np.r_[glued_q.ravel(), glued_p]).mean()), lengths(q, p)
    texts = _slides(system, f, glued_q, glued_p) if system.tangents == 1 else []
    if (p < -floor).any():
        return "; ".join([_opens(system, p, floor), *texts])
    bare, smooth, beyond = np.abs(p) <= floor, (f == 0) & (shear > floor), shear > f * p + floor
    if bare.any():
        texts.insert(0, f"{_share(system, bare)} carry no pressure under the mean load if nothing slips")
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


def pressing(system: ContactSystem, friction: Array, q: Array, p: Array, force: float) -> str:
    """The forces of each contact in a state, as a text.

    Parameters
    ----------
    system, friction
        The contact and its (N,) coefficients of friction.
    q, p
        (N,) reactions of the state, q (N, 2) in space, where a contact has the resultant of its components.
    force
        Size of the forces: what is within rounding of it is none.
    """
    names = np.array(["the contact"] * system.nodes if system.contact is None else [f"contact {str(name)!r}" for name in system.contact])
    texts = []
    for name in dict.fromkeys(names.tolist()):
        own, floor = names == name, CONDENSATION * force
        P, most, *Q = (total if abs(total := float(part[own].sum())) > floor else 0.0 for part in (p, friction * p, *q.reshape(len(p), -1).T))
        pressed = f"a normal force of {P:.3g} on {int((p[own] > floor).sum())} of {int(own.sum())} nodes"
        texts.append(f"{name} has {pressed} and a shear force of {hypot(*Q):.3g}, of at most f p = {most:.3g}")
    return ", ".join(texts)


def growth_diagnosis(friction: Array, corners: tuple[Array, Array], slipped: tuple[Array, Array], rounding: float) -> str:
    """Describe why the load may grow without end, from the residual slip that then grows with it.

    Parameters
    ----------
    friction
        (N,) coefficients of friction.
    corners
        Reactions (K, N) or (K, N, 2) of shear, and (K, N), at the corners, without the mean.
    slipped
        Those of the slip that is safe under them, (N,) or (N, 2), and (N,).
    rounding
        Force that counts as none.
    """
    if not any(part.any() for part in corners):
        return "the corners carry no load"
    if _within(friction, *corners, rounding):
        return "at no node does the cyclic shear exceed f p, so the residual slip stays bounded"
    text = "a slip that grows with the load keeps every node within its friction bound"
    locks = f" and wedges the contact tighter (self-locking with f = {float(friction.max()):g})" if _within(friction, *slipped, rounding) else ""
    return f"{text}{locks}; assembly may not leave one so large: slip_bound limits it"


def open_nodes(system: ContactSystem, p: Array) -> np.ndarray | None:
    """(N,) whether each node is open if no node slips and the closed contact has the normal reactions p (N,); None if no state is found.

    The state is that of the complementarity problem `p + C w >= 0, w >= 0, w (p + C w) = 0`; its set of open nodes is iterated until it repeats.
    """
    force, stiff = float(np.abs(p).max()) or 1.0, float(np.abs(system.C).max()) or 1.0
    opened = p < -CONDENSATION * force
    for _ in range(_MOST_SETS):
        w = np.zeros(system.nodes)
        w[opened] = np.linalg.lstsq(system.C[np.ix_(opened, opened)] / stiff, -p[opened] / force, rcond=CONDENSATION)[0]
        left = p / force + system.C @ w / stiff
        if np.abs(left[opened]).max(initial=0.0) > np.sqrt(CONDENSATION):  # nothing holds the open part
            return None
        again = np.where(opened, w > 0, left < -CONDENSATION)
        if (again == opened).all():
            return opened
        opened = again
    return None


def _within(f: Array, q: Array, p: Array, rounding: float) -> bool:
    return bool((lengths(q, p) <= f * p + rounding).all() and (p >= -rounding).all())


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
        f"{_share(system, opened)} are open under the mean load alone if nothing slips{initial}: the contact is incomplete; press these nodes, or "
        "ask `separated_limit`, which lets them be open"
    )


def _slides(system: ContactSystem, f: Array, q: Array, p: Array) -> list[str]:
    """The sentence that the body slides as a whole, or none. It can if slip does not change the sums of q and p: only friction resists."""
    stiff = max(float(np.abs(system.A).max()), float(np.abs(system.C).max()))
    sums = (system.A.sum(axis=0), system.B.sum(axis=0), system.B.sum(axis=1), system.C.sum(axis=0))
    shear, most = abs(float(q.sum())), float(f.max() * p.sum())
    if max(float(np.abs(part).max()) for part in sums) > CONDENSATION * system.nodes * stiff or shear <= most * (1 + CONDENSATION):
        return []
    return [f"the body slides as a whole: the mean load has the shear force {shear:.3g}, above f P = {most:.3g}; hold it, or press it"]


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
