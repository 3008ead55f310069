"""Sentences about forces and open nodes of a contact, and the state in which nothing slips."""

from math import hypot

import numpy as np
from numpy.typing import ArrayLike

from ..base import CONDENSATION, Array, Booleans, number_of
from ..base.checks import Names
from .system import ContactSystem


def names_of_several(system: ContactSystem) -> Names | None:
    """(N,) names of the contacts; None if there is one contact alone."""
    names = system.contact
    if names is None or (names == names[0]).all():
        return None
    return names


def nodes_of_contacts(system: ContactSystem) -> dict[str, Booleans]:
    """Contact -> which nodes (N,) belong to it; "the contact" if the system has no names."""
    if system.contact is None:
        return {"the contact": np.ones(system.nodes, dtype=bool)}
    names = system.contact
    return {name: names == name for name in dict.fromkeys(names.tolist())}


def in_contact(system: ContactSystem, nodes: ArrayLike) -> str:
    """The numbers of some nodes in the deck, if known, and their contacts, if there are several.

    The text, such as " (66 in the deck, head)", stands after the node numbers in a sentence. It is
    empty without nodes.
    """
    if not np.size(nodes):
        return ""
    parts = [in_deck(system, nodes)] if system.deck_node is not None else []
    names = names_of_several(system)
    if names is not None:
        parts += dict.fromkeys(names[np.atleast_1d(nodes)].tolist())
    return f" ({', '.join(parts)})" if parts else ""


def in_deck(system: ContactSystem, nodes: ArrayLike) -> str:
    """The numbers of a node or of some nodes in the deck, "66 in the deck"; empty if unknown."""
    if system.deck_node is None:
        return ""
    return f"{system.deck_node[np.asarray(nodes)].tolist()} in the deck"


def counted(system: ContactSystem, selected: Booleans) -> str:
    """Text with the number of selected nodes (N,): "4 of 9 nodes".

    If there are several contacts, " (head 3 of 5, nut 1 of 4)" follows.
    """
    text = f"{int(selected.sum())} of {number_of(system.nodes, 'node')}"
    names = names_of_several(system)
    if names is None:
        return text
    counts = []
    for name in dict.fromkeys(names[selected].tolist()):
        nodes = names == name
        counts.append(f"{name} {int(selected[nodes].sum())} of {int(nodes.sum())}")
    return f"{text} ({', '.join(counts)})"


def pressing(system: ContactSystem, friction: Array, q: Array, p: Array, force: float) -> str:
    """Sentence about the resultants of the forces q, p of each contact.

    Forces that are only rounding errors of forces of the size `force` are shown as zero.
    """
    shear = (q * system.stretch).reshape(len(p), -1)
    rounding = CONDENSATION * force

    def total(values: Array) -> float:
        """Sum of the forces of some nodes; zero if it is only rounding."""
        resultant = float(values.sum())
        return resultant if abs(resultant) > rounding else 0.0

    texts = []
    for name, nodes in nodes_of_contacts(system).items():
        contact = name if system.contact is None else f"contact {name!r}"
        pressed = int((p[nodes] > rounding).sum())
        shears = [total(component) for component in shear[nodes].T]
        of_all = number_of(int(nodes.sum()), "node")
        texts.append(
            f"{contact} has a normal force of {total(p[nodes]):.3g} on {pressed} of "
            f"{of_all} and a shear force of {hypot(*shears):.3g}, of at most f p = "
            f"{total((friction * p)[nodes]):.3g}"
        )
    return ", ".join(texts)


def open_nodes(system: ContactSystem, p: Array) -> Booleans | None:
    """(N,) open nodes of a contact without slip, see `settled`; None if no state is found."""
    state = settled(system, p)
    if state is None:
        return None
    return state[0]


def settled(system: ContactSystem, p: Array) -> tuple[Booleans, Array] | None:
    """Open nodes (N,) and normal reactions (N,) >= 0 of a contact in which no node slips.

    p (N,) are the normal reactions of the closed contact. The gaps w solve `p + C w >= 0, w >= 0, w
    (p + C w) = 0`: the set of open nodes is corrected until it no longer changes. The result is
    None if the set keeps changing, or if nothing holds the open nodes.
    """
    force = float(np.abs(p).max()) or 1.0
    stiffness = float(np.abs(system.C).max()) or 1.0
    opened = p < -CONDENSATION * force
    # The search for a state without slip ends after this number of changes of the set of open
    # nodes.
    most_sets = 100
    for _ in range(most_sets):
        w = np.zeros(system.nodes)
        C_open = system.C[np.ix_(opened, opened)] / stiffness
        w[opened] = np.linalg.lstsq(C_open, -p[opened] / force, rcond=CONDENSATION)[0]
        pressure = p / force + system.C @ w / stiffness
        if np.abs(pressure[opened]).max(initial=0.0) > np.sqrt(CONDENSATION):
            return None
        corrected = np.where(opened, w > 0, pressure < -CONDENSATION)
        if (corrected == opened).all():
            return opened, np.where(opened, 0.0, force * pressure).clip(0.0)
        opened = corrected
    return None
