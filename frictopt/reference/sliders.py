"""Sliders in series under constant pressure: a rod on a foundation."""

from __future__ import annotations

from math import floor
from typing import Any

import numpy as np

from ..base import finite_number, whole_number


def rod_dissipation(F0: float, EA: float, tau: float, h: float = 0.0) -> float:
    """Work of friction in one cycle of a rod on a Coulomb foundation.

    A force of amplitude F0 pulls the end of the rod to and fro. Friction balances the force over
    the slip length `F0 / tau`. Beyond this length the rod is at rest. The slip length has `n = F0 /
    (tau h)` nodes; if n is whole, the last of them does not slip. In each cycle, a node travels
    four times its largest displacement against the friction `tau h`. For whole n (any n is
    accepted)::

        W = 2 F0^3 / (3 EA tau) (1 - 1/n^2)

    Parameters
    ----------
    F0, EA
        Amplitude of the end force, not negative, and axial stiffness of the rod, positive, force
        (per depth).
    tau
        Friction bound per length, f times the pressure, positive.
    h
        Distance of the nodes, length; 0 is the continuous rod, `n = inf`. The rod is longer than
        the slip length `F0 / tau`.

    Returns
    -------
    float
        Work per cycle, force (per depth) times length.

    References
    ----------
    C.-H. Menq, J. Bielak and J. H. Griffin (1986), The influence of microslip on vibratory
    response, Journal of Sound and Vibration 107, 279-293: the continuous rod, on a foundation that
    yields before it slips; for the discrete rod, the integral becomes a sum.

    Raises
    ------
    ModelError
        A value is out of its range.

    Examples
    --------
    >>> from frictopt.reference import rod_dissipation
    >>> rod_dissipation(F0=1.0, EA=1.0, tau=0.5, h=1.0)
    1.0
    """
    F0 = finite_number("F0", F0, least=0.0)
    h = finite_number("h", h, least=0.0)
    EA = finite_number("EA", EA, above=0.0)
    tau = finite_number("tau", tau, above=0.0)
    if h == 0:
        return 2 * F0**3 / (3 * EA * tau)
    # Number of nodes that slip. If n is whole, rounding may add or omit a node without work.
    m = floor(F0 / (tau * h))
    sum_of_displacements = h / EA * (F0 * m * (m + 1) / 2 - tau * h * m * (m + 1) * (2 * m + 1) / 6)
    return 4 * tau * h * sum_of_displacements


def foundation_rod(nodes: int, EA: float, h: float) -> dict[str, Any]:
    """Rod of equal elements on a foundation, as a contact system.

    Every node carries a length h of the rod, including the loaded node at the left end. Slip does
    not change the pressure (`B = 0`). Only friction holds the rod, so A allows it to slide as a
    whole. The normal stiffness does not matter as long as the rod is pressed down.

    Parameters
    ----------
    nodes
        Number of nodes N. It must exceed `F0 / (tau h)`, otherwise the whole rod slides.
    EA, h
        Axial stiffness of the rod, force per depth, and distance of the nodes, length, positive.

    Returns
    -------
    dict[str, Any]
        Arguments A, B, C, x, bonded and gap of `ContactSystem.from_blocks`. Load cases: "pressure",
        force per length and depth between rod and foundation, with the friction `tau = f *
        pressure`; "force", along +x on the first node, with the bonded reaction -1.

    Raises
    ------
    ModelError
        A value is out of its range.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    ContactSystem(nodes=4, x=0.5 .. 3.5, loads=['force', 'pressure'], gap=False)
    """
    N = whole_number("nodes", nodes, least=1, most=10_000)
    EA = finite_number("EA", EA, above=0.0)
    h = finite_number("h", h, above=0.0)
    # (elements, nodes) elongation of each element by the slips
    incidence = np.diff(np.eye(N), axis=0)
    zero = np.zeros(N)
    return dict(
        A=EA / h * incidence.T @ incidence,
        B=np.zeros((N, N)),
        C=EA / h * np.eye(N),
        x=h * np.arange(0.5, N),
        bonded={"pressure": (zero, np.full(N, h)), "force": (-np.eye(N)[0], zero)},
        gap=zero,
    )
