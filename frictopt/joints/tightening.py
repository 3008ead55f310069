"""Shortenings that give locked bolts their forces under the mean load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import root

from ..base import RESIDUAL, Array, Bar, Loads, PerNode, progress_bar, warns_of_odd_values
from ..contact import (
    ContactSystem,
    LoadCycle,
    amplitudes_of,
    checked_cycle,
    friction_coefficients,
)
from ..errors import ModelError, SolverError
from ..transients.march import mean_state


@warns_of_odd_values
def tightened(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    *,
    steps: int | None = None,
    progress: bool = True,
) -> LoadCycle:
    """The load cycle whose mean load gives the locked bolts their forces.

    Nodes may slip and open under the mean load. In the given mean load, the amplitude of a locked
    bolt is its tension divided by the force of its `BoltPreload`. In the returned mean load, the
    amplitude is the shortening that gives this tension, divided by the shortening of the unit
    amplitude. The mean load is applied to a contact without slip, as in `march`. The other parts of
    the mean load act while the bolts are tightened. To add loads after that, tighten first, and add
    them to the mean load of the cycle returned.

    Parameters
    ----------
    system, cycle, friction
        The contact with its locked bolts (`BoltPreload`), the load cycle, and the coefficient of
        friction, one or one per node.
    steps
        Number of increments to the mean load. Pass the same number as to the transients that
        follow. None: the exact path in the plane, 20 increments in space.
    progress
        Whether to show the progress after two seconds.

    Returns
    -------
    LoadCycle
        The given load cycle, with the amplitudes of the locked bolts in its mean load.

    Raises
    ------
    ModelError
        Bad input, no locked bolt in the mean load, or an amplitude that is not above 0. Also if the
        other mean loads already give a bolt its tension or more, so that tightening does not close
        its section.
    NoContinuation
        The mean load makes a body slide or opens the contact as a whole.
    SolverError
        No shortenings are found that give the bolts their tensions with relative errors of at most
        1e-9.

    Examples
    --------
    Two springs of stiffness 20 and 30, bolt and plate, and a pull of 1 between them that goes
    through both:

    >>> import frictopt as fo
    >>> loads, L = {"bolt": ([0.0], [3.0]), "pull": ([0.0], [-0.6])}, [[-0.75, -0.1], [-0.1, 0.02]]
    >>> bolts = {"bolt": (3.0, 0.25)}  # force and shortening
    >>> blocks = [[1.0]], [[0.0]], [[12.0]], [0.0], loads
    >>> joint = fo.ContactSystem.from_blocks(*blocks, compliance=L, bolts=bolts)
    >>> cycle = fo.LoadCycle({"bolt": 1.0, "pull": 2.0}, [{"pull": 1.0}, {"pull": -1.0}])
    >>> tight = fo.joints.tightened(joint, cycle, friction=0.3)
    >>> steady = fo.steady_state(joint, tight, friction=0.3, load_factor=1.0)
    >>> steady.bolt_table().round(9)
       bolt  force  tension_mean  tension_amplitude
    0  bolt    3.0           3.0                0.4
    """
    mean = checked_cycle(cycle).mean
    coefficients = friction_coefficients(friction, system)
    shares = _checked_shares(system, mean)
    with progress_bar(progress, "tightening", "transient") as bar:
        return _tightened(_Bolts(system, cycle, coefficients, steps, list(shares), bar), shares)


def _tightened(bolts: _Bolts, shares: Mapping[str, float]) -> LoadCycle:
    """The load cycle whose mean load gives the bolts these shares of their forces."""
    amplitudes = np.array([*shares.values()])
    forces = amplitudes * bolts.unit_forces
    if bolts.system.compliance is None:
        bolts.tensions(amplitudes)  # raises an error that says how to get a compliance

    def errors(amplitudes: Array) -> Array:
        return bolts.tensions(amplitudes) / forces - 1

    derivative = bolts.glued_derivative() / forces[:, None]
    answer = root(errors, amplitudes, jac=lambda _: derivative, options={"xtol": 1e-12})
    error = float(np.abs(answer.fun).max())
    if not error <= RESIDUAL or answer.x.min() <= 0:
        _refuse_open_sections(bolts, forces, answer.x)
        raise SolverError(
            f"tightened: the computed tensions differ from the forces by a relative {error:.1e} "
            f"(tolerance {RESIDUAL:g}); {answer.message}"
        )
    return bolts.loaded(answer.x)


def _checked_shares(system: ContactSystem, mean: Loads) -> dict[str, float]:
    """Locked bolt in the mean load -> share of its force that it is tightened to."""
    shares = {name: mean[name] for name in system.bolts if name in mean}
    if not shares:
        raise ModelError(
            f"cycle: its mean load has none of the locked bolts {sorted(system.bolts)}; give each "
            "bolt the share of its force, such as 1.0"
        )
    for name, share in shares.items():
        if not share > 0:
            raise ModelError(
                f"cycle: mean[{name!r}] = {share:g}; give the share of its force that the bolt is "
                "tightened to, above 0"
            )
    return shares


@dataclass(frozen=True)
class _Bolts:
    """Locked bolts of a contact whose amplitudes in the mean load are to be found."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    steps: int | None
    names: list[str]
    bar: Bar

    @property
    def unit_forces(self) -> Array:
        """(bolts,) forces that the bolts are tightened to."""
        return np.array([self.system.bolts[name][0] for name in self.names])

    def loaded(self, amplitudes: Array) -> LoadCycle:
        """The load cycle with these amplitudes (bolts,) in its mean load."""
        of_bolts = dict(zip(self.names, amplitudes.tolist(), strict=True))
        return replace(self.cycle, mean={**self.cycle.mean, **of_bolts})

    def tensions(self, amplitudes: Array) -> Array:
        """(bolts,) tensions under the mean load with these amplitudes, from no slip."""
        cycle = self.loaded(amplitudes)
        state = mean_state(self.system, cycle, self.friction, steps=self.steps)
        self.bar.update()
        (loads,) = amplitudes_of([cycle.mean], self.system.bonded)
        return np.array(
            [self.system.tension(name, loads, state.slip, state.gap) for name in self.names]
        )

    def glued_derivative(self) -> Array:
        """(bolts, bolts) change of the tensions per change of the amplitudes, for glued bodies."""
        cases = list(self.system.bonded)
        rows = [cases.index(name) for name in self.names]
        shortenings = np.array([self.system.bolts[name][1] for name in self.names])
        compliance = np.asarray(self.system.compliance)[np.ix_(rows, rows)]
        return np.asarray(-compliance / shortenings[:, None])


def _refuse_open_sections(bolts: _Bolts, forces: Array, amplitudes: Array) -> None:
    """Raise an error if the other loads pull a bolt to its force before it is tightened."""
    for k, name in enumerate(bolts.names):
        without_bolt = amplitudes.copy()
        without_bolt[k] = 0.0
        tension = bolts.tensions(without_bolt)[k]
        if tension >= forces[k]:
            raise ModelError(
                f"cycle: the mean load does not close the section of bolt {name!r}: its other "
                f"loads pull it to {tension:.4g} before it is tightened to {forces[k]:.4g}; "
                "tighten it to a larger force, or leave these loads out and add them to the "
                "returned cycle"
            )
