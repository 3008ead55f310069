"""How far locked bolts are shortened so that they have their forces under the mean load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import root

from ..base import RESIDUAL, Array, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle, checked_cycle, checked_system, friction_coefficients
from ..errors import ModelError, SolverError
from ..transients.march import mean_state

_CLOSE = 1e-12  # last relative change of the shortenings


@warns_of_odd_values
def tightened(
    system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, *, steps: int | None = None
) -> LoadCycle:
    """The load cycle in whose mean load locked bolts have their forces, with the contact as it is: nodes that slip and open under it do so.

    The amplitude of a locked bolt in the mean load given is the share of its force that it is
    tightened to. That in the mean load returned is the shortening that gives this tension, over
    that of the unit amplitude. The mean load comes from no slip, as `march` begins; its other loads
    act while the bolts are tightened. To add loads after that, tighten first, and add them to the
    mean load of the cycle returned.

    Parameters
    ----------
    system, cycle, friction
        The contact with its locked bolts (`BoltPreload`), the load cycle, and the coefficient of
        friction, one or one per node.
    steps
        Number of increments to the mean load, that of the transients to come. None: the exact path
        in the plane, 20 in space.

    Raises
    ------
    ModelError
        Bad input, no locked bolt in the mean load, or a share that is not above 0; other mean loads
        that give a bolt its tension, or more, before it is tightened, so that the mean load does
        not close its section.
    NoContinuation
        The mean load makes a body slide or opens the contact as a whole.
    SolverError
        Shortenings with these tensions are not found, to a relative 1e-9.

    Examples
    --------
    Two springs of stiffness 20 and 30, bolt and plate, and a pull of 1 between them that goes
    through both:

    >>> import frictopt as fo
    >>> loads, L = {"bolt": ([0.0], [3.0]), "pull": ([0.0], [-0.6])}, [[-0.75, -0.1], [-0.1, 0.02]]
    >>> joint = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[12.0]], [0.0], loads, compliance=L, bolts={"bolt": (3.0, 0.25)})
    >>> cycle = fo.LoadCycle({"bolt": 1.0, "pull": 2.0}, [{"pull": 1.0}, {"pull": -1.0}])
    >>> tight = fo.tightened(joint, cycle, friction=0.3)
    >>> steady = fo.steady_state(joint, tight, friction=0.3, load_factor=1.0)
    >>> steady.bolt_table().round(9)
       bolt  force  tension_mean  tension_amplitude
    0  bolt    3.0           3.0                0.4
    """
    mean, f = (
        checked_cycle(cycle).mean,
        friction_coefficients(friction, checked_system(system).nodes),
    )
    bolts = {name: mean[name] for name in system.bolts if name in mean}
    if not bolts:
        raise ModelError(
            f"cycle: its mean load has none of the locked bolts {sorted(system.bolts)}; give each the share of its force, such as 1.0"
        )
    if loose := [name for name, share in bolts.items() if not share > 0]:
        raise ModelError(
            f"cycle: mean[{loose[0]!r}] = {bolts[loose[0]]:g}; give the share of its force that the bolt is tightened to, above 0"
        )
    cases, shares = list(system.bonded), np.array([*bolts.values()])
    forces, shortenings = (
        shares * [system.bolts[name][0] for name in bolts],
        np.array([system.bolts[name][1] for name in bolts]),
    )
    rows = [cases.index(name) for name in bolts]

    def loaded(amplitudes: Array) -> LoadCycle:
        return replace(
            cycle, mean={**cycle.mean, **dict(zip(bolts, amplitudes.tolist(), strict=True))}
        )

    def missing(amplitudes: Array) -> Array:
        """What tensions lack of their forces, over these."""
        tried = loaded(amplitudes)
        state = mean_state(system, tried, f, steps=steps)
        loads = [tried.mean.get(case, 0.0) for case in cases]
        return np.asarray(
            [system.tension(name, loads, state.slip, state.gap) for name in bolts] / forces - 1
        )

    if system.compliance is None:
        missing(shares)  # says so
    glued = (
        -np.asarray(system.compliance)[np.ix_(rows, rows)] / shortenings[:, None] / forces[:, None]
    )
    found = root(missing, shares, jac=lambda _: glued, options={"xtol": _CLOSE})
    error = float(np.abs(found.fun).max())
    for k, name in enumerate(bolts) if error > RESIDUAL or found.x.min() <= 0 else ():
        if (pulled := missing(np.where(np.arange(len(rows)) == k, 0.0, found.x))[k]) >= 0:
            raise ModelError(
                f"cycle: the mean load does not close the section of bolt {name!r}: its other loads pull it to {(1 + pulled) * forces[k]:.4g} before "
                f"it is tightened to {forces[k]:.4g}; tighten it to more, or leave these loads out and add them to the cycle returned"
            )
    if not error <= RESIDUAL or found.x.min() <= 0:
        raise SolverError(
            f"tightened: the tensions found differ from the forces by a relative {error:.1e} (tolerance {RESIDUAL:g}); {found.message}"
        )
    return loaded(found.x)
