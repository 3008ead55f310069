"""The load cycle of the paper's scene, and the units of its results: half-width a, mean pressure P / 2a and contact modulus E*."""

import frictopt as fo

LOADS = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
"""Static pressure on the punch, P / 2a = 1, and bulk stress to and fro."""


def force_unit(system: fo.ContactSystem) -> float:
    """Force per depth P / 2 of the mean load."""
    return LOADS.mean["P"] * float(system.x[-1])


def slip_unit(system: fo.ContactSystem) -> float:
    """Unit of slip under the mean pressure, a (P / 2a) / E*."""
    return force_unit(system) / float(system.E_star or float("nan"))


def work_unit(system: fo.ContactSystem) -> float:
    """Work per depth P^2 / E*."""
    return 4 * force_unit(system) * slip_unit(system)
