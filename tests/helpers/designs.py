"""Contacts to be designed, for the tests."""

import numpy as np

import frictopt as fo
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
