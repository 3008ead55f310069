"""Contacts to be designed, and the best design by a plain program, for the tests."""

import cvxpy as cp
import numpy as np

import frictopt as fo
from helpers.components import joined
from helpers.oracle import Oracle
from helpers.spatial import random_contact
from helpers.systems import random_system

CYCLE = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"a": -1.0}, {"b": 0.4}])


def pulled(seed, tangents):
    """A contact that its mean load pulls open at some nodes."""
    rng = np.random.default_rng(seed)
    contact = random_contact(rng, 2) if tangents == 2 else random_system(rng, 3, ("mean", *"abc"))
    q, p = contact.bonded["mean"]
    return contact.with_bonded(
        {"mean": (q, p - rng.uniform(0.5, 1.5) * p.max() * (rng.uniform(size=len(p)) < 0.4))}
    ), rng.uniform(0.3, 0.9)


def largest_load_factor(contact, scenarios, preloads, user_rows, opened=None, at_mean_load=False):
    """Largest load factor of a plain program with the law of each node at each corner.

    Each scenario is a load cycle, its friction, and shares of the preloads. `user_rows(b, g)` gives
    constraints on the amplitudes b of the preloads and the depths g of the profile. If
    `at_mean_load`, there is also a slip for the mean load alone.
    """
    b, g = cp.Variable(max(len(preloads), 1)), cp.Variable(contact.nodes)
    rows, programs = user_rows(b, g), []
    for cycle, friction, shares in scenarios:
        added = -contact.S[:, -contact.nodes :] @ g
        for i, name in enumerate(preloads):
            added += shares.get(name, 1.0) * b[i] * joined(*contact.bonded[name])
        programs.append(Oracle(contact, cycle, friction, opened, added=added))
        rows += [*programs[-1].rows, programs[-1].lam == programs[0].lam]
        if at_mean_load:
            at_rest = Oracle(contact, cycle, friction, opened, added=added)
            rows += [*at_rest.rows, at_rest.lam == 0]
    return programs[0].largest(rows)
