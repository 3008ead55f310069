"""Contacts to be designed, and the best design by a plain program, for the tests."""

import cvxpy as cp
import numpy as np

import frictopt as fo
from helpers.components import joined
from helpers.oracle import TIGHT
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


def largest_load_factor(contact, scenarios, preloads, user_rows, opened=(), at_mean_load=False):
    """Largest load factor of a plain program with the law of each node at each corner.

    Each scenario is a load cycle, its friction, and shares of the preloads. `user_rows(b, g)` gives
    constraints on the amplitudes b of the preloads and the depths g of the profile. The `opened`
    nodes have a slip and a gap of their own at each corner. If `at_mean_load`, there is also a slip
    for the mean load alone. The value is nan if no load factor is safe, and inf if there is no
    largest one.
    """
    n, t, lam = contact.nodes, contact.tangents, cp.Variable()
    b, g = cp.Variable(max(len(preloads), 1)), cp.Variable(n)
    rows = [lam >= 0, *user_rows(b, g)]
    shut = np.setdiff1d(np.arange(n), opened)
    for loads, friction, shares in scenarios:
        mean = joined(*loads.mean_reaction(contact)) + sum(
            shares.get(name, 1.0) * b[i] * joined(*contact.bonded[name])
            for i, name in enumerate(preloads)
        )
        corners = [
            lam * joined(*pair) for pair in zip(*loads.corner_reactions(contact), strict=True)
        ]
        for states in [corners, [0.0]] if at_mean_load else [corners]:
            slip = cp.Variable((n, t))
            for cyclic in states:
                v, w, q, p = (
                    cp.Variable((n, t)),
                    cp.Variable(n),
                    cp.Variable((n, t)),
                    cp.Variable(n),
                )
                moved = cp.hstack([cp.vec(v, order="F"), w - g])
                shear = cp.abs(q[:, 0]) if t == 1 else cp.norm(q, 2, axis=1)
                rows += [
                    cp.hstack([cp.vec(q, order="F"), p]) == mean + cyclic + contact.S @ moved,
                    shear <= cp.multiply(friction, p),
                    v[shut] == slip[shut],
                    w[shut] == 0,
                ]
                if len(opened):
                    rows += [q[opened] == 0, p[opened] == 0, w[opened] >= 0]
    value = cp.Problem(cp.Maximize(lam), rows).solve(
        **{"solver": "SCIPY", "scipy_options": TIGHT} if t == 1 else {"solver": "CLARABEL"}
    )
    return np.nan if value is None or value == -np.inf else float(value)
