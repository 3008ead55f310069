"""Random contacts that open, and what rests on them."""

import numpy as np

import frictopt as fo
from systems import random_system


def pulled_system(rng, nodes):
    """A random contact with gaps, nodes that the mean load pulls, and cyclic loads that lift nodes off."""
    contact = random_system(rng, nodes)
    (q, p), (cyclic_q, cyclic_p) = contact.bonded["mean"], contact.bonded["cyclic"]
    p = p - np.where(rng.random(nodes) < 0.3, rng.uniform(0.5, 2.0, nodes), 0.0)
    gap = np.where(rng.random(nodes) < 0.4, 0.3 * rng.random(nodes), 0.0)
    return contact.with_gap(gap).with_bonded({"mean": (q, p), "cyclic": (cyclic_q, cyclic_p * rng.choice([1.0, 4.0]))})


def rests(contact, cycle, friction, load_factor, **begin):
    """Whether a transient comes to rest; a path that ends does not."""
    try:
        return fo.steady_state(contact, cycle, friction, load_factor, **begin, most_cycles=200).outcome is fo.Outcome.SHAKEDOWN
    except fo.FrictoptError:
        return False


def resting_starts(contact, cycle, friction, load_factor, witness, count, rng):
    """How many of random starts around a slip come to rest."""
    size = np.abs(witness).max() + 0.5
    starts = witness + rng.normal(size=(count, contact.nodes)) * size * rng.choice([0.03, 0.1, 0.3, 1.0, 3.0], size=(count, 1))
    return sum(rests(contact, cycle, friction, load_factor, initial_slip=start) for start in starts)
