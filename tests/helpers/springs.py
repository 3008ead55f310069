"""Contacts whose springs are given, for the tests."""

import numpy as np

import frictopt as fo


def collocation(cells, give=0.0, beta=0.286):
    """Flexibility of a half-plane under a rigid flat punch of half-width 1, E* = 1.

    Tractions are constant on cells, and displacements are taken in their middles. Shear of a cell
    moves the surface along, and pressure moves it down. Dundurs' constant beta couples the two
    (Johnson 1985, sections 2.2 and 5.4).
    """
    ends = np.sin(np.pi / 2 * np.linspace(-1, 1, cells + 1))
    x, width = (ends[1:] + ends[:-1]) / 2, np.diff(ends)

    def integral(y):
        return y * np.log(np.abs(y)) - y

    own = -2 / np.pi * (integral(x[:, None] - ends[:-1]) - integral(x[:, None] - ends[1:])) / width
    across = beta * np.sign(np.subtract.outer(x, x))
    flexibility = np.block([[own, across], [across.T, own]]) + np.diag(give / np.tile(width, 2))
    return x, width, (flexibility + flexibility.T) / 2


def punch(cells, give=0.0):
    """The rigid punch, free to slide and to press, under a force P and a strain of the half-plane."""
    x, width, flexibility = collocation(cells, give)
    free = np.kron(np.eye(2), np.ones((cells, 1)))
    K = np.linalg.inv(flexibility)
    held_by = K @ free @ np.linalg.inv(free.T @ K @ free)
    S = K - held_by @ (free.T @ K)
    return fo.ContactSystem(
        (S + S.T) / 2,
        np.column_stack([x, 0 * x]),
        {"P": held_by[:, 1], "sigma": S @ np.r_[x, 0 * x]},
        width=width,
    )
