"""Every admissible state of a small contact after one increment, by trying all 4^N statuses."""

import numpy as np

import frictopt as fo
from studies.validation.oracles import Stepper


def admissible_states(contact, friction, slip, bonded):
    """States `(slip, gap, q, p)` that obey the contact law, each once: (number of states, 4, N)."""
    n, posed = contact.nodes, contact.with_bonded({"load": bonded})
    stepper = Stepper(
        posed, fo.LoadCycle({"load": 1.0}, [{"load": 1.0}]), np.broadcast_to(friction, n)
    )
    found = [
        np.r_[u * stepper.length, r * stepper.force].reshape(4, n)
        for u, r in stepper.states(np.asarray(slip), np.concatenate(bonded))
    ]
    return np.array(found).reshape(-1, 4, n) + np.array([slip, *np.zeros((3, n))])


def random_increment(rng, nodes, most_friction, floor=0.05, rigid=None):
    """A random coupled contact, its friction, slip and load; half of the contacts have gaps.

    The columns of `rigid` are motions without force.
    """
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + floor * np.eye(2 * nodes)
    if rigid is not None:
        basis, _ = np.linalg.qr(rigid)
        free = np.eye(2 * nodes) - basis @ basis.T
        S = free @ S @ free
    S = (S + S.T) / 2
    gap = np.where(rng.random(nodes) < 0.5, 0.0, rng.exponential(0.3, nodes)) * rng.integers(2)
    load = rng.normal(size=nodes), rng.normal(size=nodes) * rng.choice([0.3, 1.5]) + 1.0
    contact = fo.ContactSystem.from_blocks(
        S[:nodes, :nodes],
        S[nodes:, :nodes],
        S[nodes:, nodes:],
        np.arange(nodes),
        {"load": load},
        gap,
    )
    friction = rng.uniform(0, most_friction, nodes) * (rng.random(nodes) > 0.1)
    return contact, friction, rng.normal(size=nodes) * rng.choice([0.0, 0.3, 1.0]), load


def distance(states, increment):
    """Distance of a result from the nearest state, in slip, gap, q or p."""
    found = np.array([increment.slip, increment.gap, increment.q, increment.p])
    return min((float(np.abs(state - found).max()) for state in states), default=np.inf)
