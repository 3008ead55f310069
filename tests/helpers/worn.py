"""Contacts that wear, for the tests."""

from itertools import pairwise

import numpy as np
from scipy.special import ellipe, ellipk

import frictopt as fo

F = 0.5


def cylinder(nodes, half_length=1.3, share=0.5):
    """A cylinder, its load cycle, and the load factor of a share of gross slip.

    Before wear the half-width of the contact is 1.
    """
    contact = fo.reference.LineContact(P=1.0, R=1.0, E_star=4 / np.pi, f=F)
    arrays = fo.reference.half_plane_contact(nodes, half_length, contact.E_star, R=contact.R)
    system = fo.ContactSystem.from_blocks(**arrays, width=np.full(nodes, 2 * half_length / nodes))
    return (
        system,
        fo.LoadCycle({"P": contact.P}, [{"Q": 1.0}, {"Q": -1.0}]),
        F,
        share * F * contact.P,
    )


def on_edges(stick, reach=1.3, share=0.5):
    """The cylinder with a number of cells on each side of the middle in the stick zone.

    The stick zone ends on an edge of cells.
    """
    cell = np.sqrt(1 - share) / stick
    half = int(np.ceil(reach / cell))
    return cylinder(2 * half, half * cell, share)


def plain_rate(steady, coefficient):
    """Depth per cycle by Archard's law, from the states of the steady cycle.

    The wear is force times slip over width.
    """
    states = steady.states()
    slip, p = states.slip.reshape(*states.p.shape, -1), states.p
    ways = np.linalg.norm(np.diff(slip, axis=0), axis=2) * (states.gap[1:] == 0)
    return (
        coefficient
        * ((p[1:] + p[:-1]) / 2 * ways).sum(axis=0)
        / steady.period
        / steady.system.width
    )


def sphere(cells, half_length):
    """A sphere under forces, its load cycle, and the load factor at half of gross slip.

    Before wear the radius of the contact is 1.
    """
    arrays = fo.reference.half_space_contact(cells, half_length, R=1.0, E=1.0, nu=0.0)
    return held_by_forces(
        arrays["S"],
        arrays["points"],
        arrays["gap"],
        np.full(len(arrays["gap"]), (2 * half_length / cells) ** 2),
    )


def sphere_of_rings(stick, reach=1.3):
    """The sphere with a node for each ring of the contact.

    Without Poisson's ratio, shear and slip are along the load, and the same all around. A number of
    rings is in the stick zone, which ends on an edge of a ring. Displacements are taken in the
    middle of each ring, as differences of displacements of discs.
    """
    edge = 0.5 ** (1 / 3) / stick * np.arange(int(np.ceil(reach / 0.5 ** (1 / 3) * stick)) + 1)
    r, area = (edge[1:] + edge[:-1]) / 2, np.pi * np.diff(edge**2)

    def of_disc(a):
        inside, far = r < a, np.minimum(a / r, 1 - 1e-15) ** 2
        outside = r * (ellipe(far) - (1 - far) * ellipk(far))
        # Displacements of a uniform pressure of 1, E* = 1/2.
        return 8 / np.pi * np.where(inside, a * ellipe(np.minimum(r / a, 1.0) ** 2), outside)

    flexibility = (
        np.column_stack(
            [of_disc(end) - (of_disc(begin) if begin else 0.0) for begin, end in pairwise(edge)]
        )
        / area
    )
    S = np.kron(np.eye(3), np.linalg.inv((flexibility + flexibility.T) / 2))
    return held_by_forces(S, np.column_stack([r, 0 * r, 0 * r]), r**2 / 2, area)


def held_by_forces(S, points, gap, width):
    """A contact under forces on its free far end, and the further results of `sphere`.

    The stiffness of the contact is given.
    """
    rigid, P = np.kron(np.eye(3), np.ones((len(gap), 1))), 2 / 3
    held = S @ rigid
    # Shares of the nodes in a force on the far end.
    shares = held @ np.linalg.inv(rigid.T @ held)
    S = S - shares @ held.T
    system = fo.ContactSystem(
        (S + S.T) / 2, points, {"P": shares[:, 2], "Q": shares[:, 0]}, gap=gap, width=width
    )
    return system, fo.LoadCycle({"P": P}, [{"Q": 1.0}, {"Q": -1.0}]), F, 0.5 * F * P
