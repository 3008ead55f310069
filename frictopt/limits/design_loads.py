"""Loads of the mean state that a design chooses: preloads, and a profile of the faces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cvxpy as cp
import numpy as np

from ..contact import Array, ContactSystem, LoadCycle, joined

PROFILE = "profile"  # load case of the overlap that a profile leaves


@dataclass(frozen=True, eq=False)
class DesignLoads:
    """What a design changes in the reactions, linear in its dimensionless amounts.

    Attributes
    ----------
    preloads
        Names of the load cases whose amplitudes are unknown.
    unit
        (d,) what unit amounts are: amplitudes of the preloads, then depths of the profile, length.
    reactions
        (M, d) reactions of unit amplitudes and depths, ordered by component, force.
    amounts
        The unknowns.
    """

    preloads: tuple[str, ...]
    unit: Array
    reactions: Array
    amounts: cp.Variable

    def shared(self, shares: Mapping[str, float]) -> "DesignLoads":
        """The same design where some preloads act with a share of their amplitude alone."""
        factors = np.ones(len(self.unit))
        factors[: len(self.preloads)] = [shares.get(name, 1.0) for name in self.preloads]
        return replace(self, reactions=self.reactions * factors)

    def forces(self, unit: Array) -> cp.Expression:
        """(M,) reactions of the amounts over the (N,) units of the nodes, an affine cvxpy expression."""
        return (self.reactions * self.unit / np.resize(unit, len(self.reactions))[:, None]) @ self.amounts

    @property
    def values(self) -> cp.Expression:
        """(d,) amplitudes and depths, an affine cvxpy expression."""
        return cp.multiply(self.unit, self.amounts)

    def name(self, index: int) -> str:
        """What an amount is, in words of the user."""
        return f"preload[{self.preloads[index]!r}]" if index < len(self.preloads) else f"profile[{index - len(self.preloads)}]"


def design_loads(system: ContactSystem, preloads: Sequence[str], profile: bool, force: float) -> DesignLoads:
    """The loads that a design chooses; unit amounts make reactions of about `force` at a node."""
    bolts = np.array([joined(*system.bonded[name]) for name in preloads]).reshape(len(preloads), len(system.S))
    faces = -system.S[-system.nodes :] if profile else np.zeros((0, len(system.S)))
    sizes = np.concatenate([np.abs(bolts).mean(axis=1), system.own_stiffness[-system.nodes :][: len(faces)]])
    amounts = cp.Variable(len(sizes), name="design")
    return DesignLoads(tuple(preloads), force / np.where(sizes > 0, sizes, 1.0), np.vstack([bolts, faces]).T, amounts)


def built_in(
    system: ContactSystem, cycles: Sequence[tuple[LoadCycle, Mapping[str, float]]], profile: Array | None
) -> tuple[ContactSystem, tuple[LoadCycle, ...]]:
    """Contact, and load cycles each with its preloads in its mean load, with a profile in the gap, or as an overlap where it adds material."""
    overlap = dict[str, float]()
    if profile is not None:
        gap = system.gap + profile
        system = system.with_gap(np.maximum(gap, 0.0))
        if gap.min() < 0:
            system = system.with_interference({PROFILE: np.maximum(-gap, 0.0)})
            overlap[PROFILE] = 1.0
    added = [(cycle, {name: cycle.mean.get(name, 0.0) + amount for name, amount in preload.items()}) for cycle, preload in cycles]
    return system, tuple(replace(cycle, mean={**cycle.mean, **preload, **overlap}) for cycle, preload in added)
