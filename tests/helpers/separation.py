"""Random contacts that open, and starts from which they shake down."""

from itertools import islice

import numpy as np
from hypothesis import assume

import frictopt as fo
from helpers.spatial import random_contact, vectors
from helpers.systems import CYCLE, random_system
from studies.validation.fuzz.cases import random_case


def pulled_system(rng, nodes):
    """A random contact with gaps.

    The mean load pulls some nodes, and cyclic loads lift nodes off.
    """
    contact = random_system(rng, nodes)
    (q, p), (cyclic_q, cyclic_p) = contact.bonded["mean"], contact.bonded["cyclic"]
    p = p - np.where(rng.random(nodes) < 0.3, rng.uniform(0.5, 2.0, nodes), 0.0)
    gap = np.where(rng.random(nodes) < 0.4, 0.3 * rng.random(nodes), 0.0)
    return contact.with_gap(gap).with_bonded(
        {"mean": (q, p), "cyclic": (cyclic_q, cyclic_p * rng.choice([1.0, 4.0]))}
    )


def lifted_system(rng, nodes, coupling=1.0, by=3):
    """A random contact that is closed under its mean load, while the cyclic load lifts nodes off."""
    contact = random_system(rng, nodes, coupling=coupling)
    (q, p), mean = contact.bonded["cyclic"], contact.bonded["mean"]
    return contact.with_bonded({"mean": mean, "cyclic": (q, by * p)})


def fuzzed(seed):
    """A random contact of studies, of two to six nodes, its cycle and friction."""
    nodes = int(np.random.default_rng([seed, 75]).integers(2, 7))
    case = random_case(9_000_000 + seed, nodes=nodes)
    return case.system, case.cycle, case.friction


def rests(contact, cycle, friction, load_factor, **begin):
    """Whether a transient shakes down; a path that ends does not."""
    try:
        return (
            fo.steady_state(contact, cycle, friction, load_factor, **begin, most_cycles=200).outcome
            is fo.Outcome.SHAKEDOWN
        )
    except fo.FrictoptError:
        return False


def with_events(limits, count):
    """The first of some limits that are finite and whose nodes open and close in each cycle."""
    having = (one for one in limits if one.kind is fo.LimitKind.FINITE and not one.events.empty)
    found = list(islice(having, count))
    assert len(found) == count
    return found


def resting_starts(contact, cycle, friction, load_factor, witness, count, rng):
    """Number of random starts around a slip from which the contact shakes down."""
    size = np.abs(witness).max() + 0.5
    starts = witness + rng.normal(size=(count, contact.nodes)) * size * rng.choice(
        [0.03, 0.1, 0.3, 1.0, 3.0], size=(count, 1)
    )
    return sum(rests(contact, cycle, friction, load_factor, initial_slip=start) for start in starts)


THREE = fo.LoadCycle({"mean": 1.0}, [{"cyclic": -1.0}, {"cyclic": 0.8}, {"cyclic": 0.3}])


def open_contact(seed, most_nodes=6, cycle=CYCLE):
    """A random plane contact whose limit has open nodes, its friction, and the limit."""
    rng = np.random.default_rng(seed)
    contact, friction = (
        pulled_system(rng, int(rng.integers(2, most_nodes + 1))),
        float(rng.uniform(0.1, 1.0)),
    )
    limit = fo.shakedown_limit(contact, cycle, friction)
    assume(limit.open.any() and 1e-3 < limit.load_factor < np.inf)
    return contact, friction, limit


def open_in_space(seed, nodes=5):
    """A random contact in space whose limit has open nodes, its friction, load cycle and limit."""
    rng = np.random.default_rng(seed)
    contact = random_contact(rng, nodes)
    loads = vectors(contact)
    loads["mean"] = (
        loads["mean"] - np.r_[np.zeros(2 * nodes), np.where(rng.random(nodes) < 0.4, 2.0, 0.0)]
    )
    contact = fo.ContactSystem(
        contact.S, contact.points, loads, gap=0.3 * rng.random(nodes) * (rng.random(nodes) < 0.4)
    )
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"a": 1.0}, {"a": -1.0}, {"b": 0.7, "c": 0.2}][: int(rng.integers(2, 4))]
    )
    return contact, cycle, fo.shakedown_limit(contact, cycle, 0.6)
