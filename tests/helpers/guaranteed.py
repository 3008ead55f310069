"""Guaranteed limits by independent methods, for the tests."""

import numpy as np
import pytest

import frictopt as fo
from helpers.systems import on_both_bounds


def random_cycle(rng, corners):
    return fo.LoadCycle(
        {"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(corners, 2))]
    )


def least_by_node(contact, cycle, friction, most=None):
    """The least load factor of every node; inf if the node is never on both bounds."""
    return np.nan_to_num(on_both_bounds(contact, cycle, friction, most=most)[:, 0], nan=np.inf)


def check(limit):
    """Check the witness, its node and the limit.

    The witness is safe. Its node is on its bounds at its corners, in the plane first on the bound
    of forward slip. The limit is not above lambda_2.
    """
    (q, p), f = limit.reactions, limit.friction
    size, force = (
        np.linalg.norm(q.reshape(*p.shape, -1), axis=-1),
        np.abs(limit.cycle.mean_reaction(limit.system)[1]).mean(),
    )
    assert (
        limit.residual <= 1e-9
        and limit.load_factor <= limit.shakedown.load_factor
        and limit.kind is fo.LimitKind.FINITE
    )
    assert (size - f * p).max() <= 1e-8 * force
    if limit.node is not None:
        at, i = list(limit.corners), limit.node
        assert (
            np.abs(size[at, i] - f[i] * p[at, i]).max() <= 1e-8 * force
            and len(set(at)) == len(at) > 1
        )
        ways = (q[at, i] if q.ndim == 2 else q[at, i] @ [1, 1j]) / np.maximum(size[at, i], 1e-300)
        # No half-plane contains all directions.
        angles = np.sort(np.angle(ways))
        assert (
            limit.load_factor == 0
            or np.diff(np.r_[angles, angles[0] + 2 * np.pi]).max() <= np.pi + 1e-5
        )
        assert q.ndim == 3 or q[at[0], i] <= 1e-8 * force
        assert max(np.max(row.violation()) for row in limit.problem.constraints) < 1e-6, (
            "its problem has its own solution, not another node's"
        )
        assert limit.problem.var_dict["load_factor"].value == pytest.approx(
            limit.load_factor, rel=1e-8, abs=1e-9
        )
