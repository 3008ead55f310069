"""What a contact wears into, without simulation, where a theorem says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    RESIDUAL,
    Array,
    Booleans,
    Outcome,
    SolveRecord,
    Table,
    bar_of,
    finite_number,
    frame,
    frozen,
    places,
    warns_of_odd_values,
)
from ..contact import (
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    friction_coefficients,
    reactions,
)
from ..contact.diagnosis import open_nodes
from ..errors import ModelError, SolverError
from ..transients import SteadyState, steady_state
from .wear import Worn

# of the pressure that a node's own wear takes off it, taken off by the same wear at another one:
# half-planes in cells have 0.01
_RELIEF = 0.03


@dataclass(frozen=True, eq=False, repr=False)
class WornIn(Worn):
    """The contact that wear ends at: it rests, and its worn nodes carry nothing.

    Theory, eq. (30).

    Attributes
    ----------
    steady, record
        Its steady state, at rest, and the record of that. Its contact is worn, and takes every
        other question.
    depth, stick
        (N,) depth worn off at each node, of both bodies together, length (a billionth of the
        largest more than the theorem says, so that worn nodes are open for every other question),
        and which nodes never slip while the contact wears; it is confined to them in the end.
    proven
        True: the conditions of the theorem were checked, and the worn contact is at rest.

    Examples
    --------
    >>> import frictopt as fo
    >>> arrays = fo.reference.half_plane_contact(nodes=32, half_length=1.0, E_star=1e5, R=100.0)  # a cylinder; N and mm
    >>> cylinder = fo.ContactSystem.from_blocks(**arrays)
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> end = fo.worn_in(cylinder, cycle, friction=0.5, load_factor=100.0)
    >>> f"{end.depth.max():.2e}", f"{end.depth[end.stick].max():.2e}"
    ('6.12e-04', '0.00e+00')
    """

    steady: SteadyState = field(repr=False)
    depth: Array
    stick: Booleans
    record: SolveRecord
    proven: bool = True

    def to_frame(self) -> Table:
        """The DataFrame of the nodes: columns node, x, stick, depth; in space x, y, z."""
        return frame(
            {
                "node": range(len(self.depth)),
                **places(self.system),
                "stick": self.stick,
                "depth": self.depth,
            },
            units=self.system.units,
        )

    def _answer(self) -> Mapping[str, object]:
        numbers = {
            "nodes": len(self.depth),
            "stick": int(self.stick.sum()),
            "largest_depth": float(self.depth.max()),
        }
        return {**numbers, "proven": self.proven, "residual": self.residual}


@warns_of_odd_values
def worn_in(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    progress: bool = True,
) -> WornIn:
    """What a contact of similar bodies wears into under an alternating load, by linear solves instead of a simulation.

    In an uncoupled contact whose tangential stiffness is its normal one times a number, under loads
    that stay on one line and whose shear, with no slip, changes the same way at all nodes, by
    friction times the change of pressure or more, the stick zone is the contact of the same bodies
    under the mean normal force less half the change of shear over friction (Ciavarella 1998, Jäger
    1998). A larger gap outside it does not change that contact: so the stick zone is the same
    however much is worn off, and outside it wear goes on as long as there is pressure (Popov 2014),
    if wear at one place takes no pressure off others. In the end the contact is confined to the
    stick zone. Theory, eq. (30). How many cycles that takes, `wear` says.

    Parameters
    ----------
    system, cycle, friction, load_factor
        The contact, its load cycle, its coefficient of friction, the same at all nodes, and the
        load factor, >= 0.
    progress
        Whether to show after two seconds how far it is. Ctrl-C stays a KeyboardInterrupt; once the
        theorem is applied, its attribute `depth` has the depths, (N,), in which nothing has come to
        rest yet.

    Raises
    ------
    ModelError
        Bad input, or a contact that the theorem does not cover: the message says why. Use `wear`
        then.
    SolverError
        The worn contact does not rest, or has no steady state that passes the checks.

    Notes
    -----
    M. Ciavarella 1998, Int. J. Solids Struct. 35, 2349-2362; J. Jäger 1998, J. Tribology 120,
    677-684; V. L. Popov 2014, Sci. Rep. 4, 3749. Closed forms:
    `fo.reference.LineContact.worn_depth` and `fo.reference.SphereContact.worn_depth`.

    Examples
    --------
    >>> import frictopt as fo
    >>> arrays = fo.reference.half_plane_contact(nodes=32, half_length=1.0, E_star=1e5, R=100.0)  # a cylinder; N and mm
    >>> cylinder = fo.ContactSystem.from_blocks(**arrays)
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> end = fo.worn_in(cylinder, cycle, friction=0.5, load_factor=100.0)
    >>> f"{1e3 * end.depth.max():.2f} micrometres, {end.stick.sum()} nodes never slip"
    '0.61 micrometres, 16 nodes never slip'
    """
    f = _similar(checked_system(system), friction)
    first, last = _ends(
        system, checked_cycle(cycle), finite_number("load_factor", load_factor, least=0.0)
    )
    depth, stick = _profile(system, f, first, last)
    depth[~stick & (depth > 0)] += RESIDUAL * depth.max()
    kept = (
        "depth",
        frozen(depth),
        "the depths by the theorem are in the attribute `depth`; it is not checked that the worn contact rests",
    )
    with bar_of(progress, "worn in", keeps=lambda _: kept):
        steady = steady_state(system.with_gap(system.gap + depth), cycle, friction, load_factor)
    if steady.outcome is not Outcome.SHAKEDOWN:
        raise SolverError(
            f"worn_in: the worn contact does not rest, it dissipates {steady.dissipation:.1e} per cycle; use wear"
        )
    return WornIn(steady, frozen(depth), stick, steady.record)


def _profile(system: ContactSystem, f: float, first: Array, last: Array) -> tuple[Array, Booleans]:
    """Depth and stick set of the contact worn in under loads (M,) that go to and fro between two.

    With the shear over friction taken off the bonded normal reactions::

    p* = (p1 + p2) / 2 - |q2 - q1| / (2 f)          bonded normal reactions less the shear over
    friction stick: where the contact of the unworn bodies under p* is closed h = largest overlap
    outside, at both loads, of the contact that is confined to it, where p = 0 outside
    """
    n, C, gap = system.nodes, system.C, system.gap
    shear = (last - first)[:-n].reshape(-1, n)
    along = np.linalg.svd(shear)[0][:, 0]
    change = along @ shear
    _need(
        _near(shear, np.outer(along, change)),
        "cycle: its shear does not act along one direction at all nodes",
    )
    way = np.sign(change.sum())
    normal = (first + last)[-n:] / 2 - way * change / (2 * f)
    out = open_nodes(system, normal - C @ gap)
    stick = np.zeros(n, dtype=bool) if out is None else ~out
    _need(stick.any(), "load_factor: no node sticks, the contact slides as a whole")
    depth, out = np.zeros(n), ~stick
    for p in (first[-n:], last[-n:]):
        depth[out] = np.maximum(depth[out], -_confined(C, p, gap, stick)[out] - gap[out])
    lead = way * change - f * np.abs((last - first)[-n:])
    less = f"cycle: with no slip, the shear at node {int(lead.argmin())} changes by less than friction times the change of its pressure"
    _need(
        not depth.any() or lead.min() >= -CONDENSATION * np.abs(lead).max(),
        f"{less}, or another way than at most nodes",
    )
    return depth, stick


def _similar(system: ContactSystem, friction: ArrayLike) -> float:
    """The one coefficient of friction of an uncoupled contact whose tangential stiffness is its normal one times a number."""
    f, A, B, C = friction_coefficients(friction, system.nodes), system.A, system.B, system.C
    _need(f.min() == f.max() > 0, f"friction: from {f.min():g} to {f.max():g}")
    _need(
        not (system.capped or system.orthotropic),
        "system: it has a shear strength, or orthotropic friction",
    )
    _need(
        np.abs(B).max() <= CONDENSATION * np.abs(A).max(),
        "system: it is coupled, slip changes its pressures",
    )
    similar = (
        np.kron(np.eye(system.tangents), C) * np.trace(A) / (system.tangents * np.trace(C) or 1.0)
    )
    _need(
        _near(A, similar),
        "system: its tangential stiffness is not its normal one times a number, as that of similar half-planes is",
    )
    own = np.diag(C)
    relief = C - np.diag(own) - _RELIEF * own[:, None]
    one, other = np.unravel_index(relief.argmax(), C.shape)
    _need(
        relief.max() <= 0,
        f"system: wear at node {other} takes pressure off node {one}, and so the order in which they wear counts",
    )
    return float(f[0])


def _ends(system: ContactSystem, cycle: LoadCycle, load_factor: float) -> tuple[Array, Array]:
    """The two loads (M,) between which those of a cycle stay, on a line."""
    loads = reactions(system, cycle.at(load_factor))
    far = loads - loads[0]
    along = far[np.linalg.norm(far, axis=1).argmax()]
    place = far @ along / (along @ along or 1.0)
    _need(
        _near(loads, loads[0] + np.outer(place, along)), "cycle: its loads do not stay on one line"
    )
    return loads[place.argmin()], loads[place.argmax()]


def _near(values: Array, wanted: Array) -> bool:
    return bool(np.abs(values - wanted).max() <= CONDENSATION * np.abs(values).max())


def _confined(C: Array, p: Array, gap: Array, closed: Booleans) -> Array:
    """(N,) `w - g0` of a contact without friction that is closed at some nodes and carries nothing at the others, whatever overlaps there."""
    u, out = -gap, ~closed
    u[out] = -np.linalg.solve(C[np.ix_(out, out)], p[out] - C[np.ix_(out, closed)] @ gap[closed])
    return u


def _need(holds: bool | np.bool_, otherwise: str) -> None:
    if not holds:
        raise ModelError(f"{otherwise}; no theorem gives the end of wear then: follow it by wear")
