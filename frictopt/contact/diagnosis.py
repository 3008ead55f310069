"""Forces and open nodes of a contact that does not slip, why a load may grow without end, and where nodes are, in words."""

from math import hypot

import numpy as np
from numpy.typing import ArrayLike

from ..base import CONDENSATION, Array, Booleans
from ..base.checks import Names
from .law import lengths
from .system import ContactSystem

_MOST_SETS = 100  # changes of the set of open nodes


def _names(system: ContactSystem) -> Names | None:
    """(N,) names of the contacts, where there are two or more."""
    names = system.contact
    return None if names is None or (names == names[0]).all() else names


def in_contact(system: ContactSystem, nodes: ArrayLike) -> str:
    """The contacts of some nodes, by their numbers, as they follow these in a text: " (head)"; nothing where there is one contact, or no node."""
    names = _names(system)
    numbers = np.atleast_1d(nodes)
    if names is None or not numbers.size:
        return ""
    return f" ({', '.join(dict.fromkeys(names[numbers].tolist()))})"


def counted(system: ContactSystem, which: Booleans) -> str:
    """How many of all nodes these (N,) are, and of each contact where there are two or more: "4 of 9 nodes (head 3 of 5, nut 1 of 4)"."""
    names, text = _names(system), f"{int(which.sum())} of {system.nodes} nodes"
    if names is None:
        return text
    each = [(name, names == name) for name in dict.fromkeys(names[which].tolist())]
    return f"{text} ({', '.join(f'{name} {int(which[own].sum())} of {int(own.sum())}' for name, own in each)})"


def pressing(system: ContactSystem, friction: Array, q: Array, p: Array, force: float) -> str:
    """The forces q, p of each contact in a state, as a text (in space the resultants of q); within rounding of the size `force` they are none."""
    names = np.array(
        ["the contact"] * system.nodes
        if system.contact is None
        else [f"contact {str(name)!r}" for name in system.contact]
    )
    texts = []
    for name in dict.fromkeys(names.tolist()):
        own, floor = names == name, CONDENSATION * force
        sums = [
            float(part[own].sum())
            for part in (p, friction * p, *(q * system.stretch).reshape(len(p), -1).T)
        ]
        P, most, *Q = (total if abs(total) > floor else 0.0 for total in sums)
        pressed = (
            f"a normal force of {P:.3g} on {int((p[own] > floor).sum())} of {int(own.sum())} nodes"
        )
        texts.append(
            f"{name} has {pressed} and a shear force of {hypot(*Q):.3g}, of at most f p = "
            f"{most:.3g}"
        )
    return ", ".join(texts)


def growth_diagnosis(
    friction: Array, corners: tuple[Array, Array], slipped: tuple[Array, Array], rounding: float
) -> str:
    """Why the load may grow without end, from `slipped`, the reactions of the slip that then grows with it.

    `corners` are the reactions there, shear (K, N) or (K, N, 2) and normal, without the mean;
    `rounding` is a force that counts as none.
    """
    if not any(part.any() for part in corners):
        return "the corners carry no load"
    if _within(friction, *corners, rounding):
        return "at no node does the cyclic shear exceed f p, so the residual slip stays bounded"
    text = "a slip that grows with the load keeps every node within its friction bound"
    locks = (
        f" and wedges the contact tighter (self-locking with f = {float(friction.max()):g})"
        if _within(friction, *slipped, rounding)
        else ""
    )
    return f"{text}{locks}; assembly may not leave one so large: slip_bound limits it"


def open_nodes(system: ContactSystem, p: Array) -> Booleans | None:
    """(N,) whether each node is open if no node slips and the closed contact has the normal reactions p (N,); None if no state is found."""
    rest = settled(system, p)
    return None if rest is None else rest[0]


def settled(system: ContactSystem, p: Array) -> tuple[Booleans, Array] | None:
    """The same nodes, and (N,) the normal reactions left, >= 0; by `p + C w >= 0, w >= 0, w (p + C w) = 0`, iterated until open nodes repeat."""
    force, stiff = float(np.abs(p).max()) or 1.0, float(np.abs(system.C).max()) or 1.0
    opened = p < -CONDENSATION * force
    for _ in range(_MOST_SETS):
        w = np.zeros(system.nodes)
        w[opened] = np.linalg.lstsq(
            system.C[np.ix_(opened, opened)] / stiff, -p[opened] / force, rcond=CONDENSATION
        )[0]
        left = p / force + system.C @ w / stiff
        if np.abs(left[opened]).max(initial=0.0) > np.sqrt(
            CONDENSATION
        ):  # nothing holds the open part
            return None
        again = np.where(opened, w > 0, left < -CONDENSATION)
        if (again == opened).all():
            return opened, np.where(opened, 0.0, force * left).clip(0.0)
        opened = again
    return None


def _within(f: Array, q: Array, p: Array, rounding: float) -> bool:
    return bool((lengths(q, p) <= f * p + rounding).all() and (p >= -rounding).all())
