"""The end of wear of a contact, without simulation, under the conditions of a theorem."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..base import (
    CONDENSATION,
    RESIDUAL,
    Array,
    Booleans,
    Outcome,
    PerNode,
    SolveRecord,
    Table,
    finite_number,
    frame,
    frozen,
    places,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import (
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_round,
    checked_system,
    friction_coefficients,
    reactions,
)
from ..contact.diagnosis import in_contact, open_nodes
from ..errors import ModelError, SolverError
from ..transients import SteadyState, steady_state
from .archard import ONE_FRICTION, Worn


@dataclass(frozen=True, eq=False, repr=False)
class WornIn(Worn):
    """Worn-in contact: it sticks, and its worn nodes carry no force.

    Theory, eq. (30).

    Attributes
    ----------
    steady, record
        The steady state of the worn contact, which is shakedown, and the record of this state. The
        `system` of the steady state is the worn contact, and all other functions accept it.
    depth, stick
        (N,) depth worn off at each node, of both bodies together, length; and the nodes that never
        slip while the contact wears. In the end only these nodes are in contact. The depth exceeds
        the depth of the theorem by a billionth of the largest depth, so that worn nodes are open in
        all other functions.
    proven
        True: the conditions of the theorem were checked, and the worn contact is at rest.

    Examples
    --------
    >>> import frictopt as fo
    >>> cylinder = {"nodes": 32, "half_length": 1.0, "E_star": 1e5, "R": 100.0}  # N and mm
    >>> system = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(**cylinder))
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> end = fo.joints.worn_in(system, cycle, friction=0.5, load_factor=100.0)
    >>> f"{end.depth.max():.2e}", f"{end.depth[end.stick].max():.2e}"
    ('6.12e-04', '0.00e+00')
    """

    steady: SteadyState
    depth: Array
    stick: Booleans
    record: SolveRecord
    proven: bool = True

    def to_frame(self) -> Table:
        """The DataFrame of the nodes: columns node, x, stick, depth; in space x, y, z."""
        columns = {
            "node": range(len(self.depth)),
            **places(self.system),
            "stick": self.stick,
            "depth": self.depth,
        }
        return frame(columns, units=self.system.units)

    def _answer(self) -> Mapping[str, object]:
        return {
            "nodes": len(self.depth),
            "stick": int(self.stick.sum()),
            "largest_depth": float(self.depth.max()),
            "proven": self.proven,
            "residual": self.residual,
        }


@warns_of_odd_values
def worn_in(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    *,
    progress: bool = True,
) -> WornIn:
    """The end of wear of a contact of similar bodies under an alternating load, by linear solves.

    The theorem needs an uncoupled contact whose tangential stiffness is a multiple of its normal
    stiffness, and loads that stay on one line. Without slip, the shear of all nodes must change in
    the same direction, by at least friction times the change of pressure. Then the stick zone
    equals the contact area of the same bodies under a smaller normal force,
    `(P1 + P2) / 2 - |Q2 - Q1| / (2 f)` with the forces at both ends of the load (Ciavarella 1998,
    Jäger 1998). A
    larger gap outside the stick zone does not change this zone, so it is the same at any depth of
    wear. Outside the zone, wear continues while there is pressure (Popov 2014), if wear at one
    place does not reduce the pressure elsewhere. In the end the contact is confined to the stick
    zone. Theory, eq. (30). `wear` computes the number of cycles that this takes.

    Parameters
    ----------
    system, cycle, friction, load_factor
        The contact, its load cycle, its coefficient of friction, the same at all nodes, and the
        load factor, >= 0.
    progress
        Whether to show the progress after two seconds. Ctrl-C raises KeyboardInterrupt. Once the
        theorem has been applied, the attribute `depth` of this error has the depths, (N,), which no
        transient has checked yet.

    Returns
    -------
    WornIn
        The depth worn off in the end, the nodes that never slip, and the steady state.

    Raises
    ------
    ModelError
        Bad input, or a contact that the theorem does not cover: the message has the reason, and
        `wear` follows such a contact.
    SolverError
        The worn contact does not shake down, or has no steady state that passes the checks.

    Notes
    -----
    M. Ciavarella 1998, Int. J. Solids Struct. 35, 2349-2362; J. Jäger 1998, J. Tribology 120,
    677-684; V. L. Popov 2014, Sci. Rep. 4, 3749, with closed forms of a cylinder
    (`fo.reference.LineContact.worn_depth`) and a sphere.

    Examples
    --------
    >>> import frictopt as fo
    >>> cylinder = {"nodes": 32, "half_length": 1.0, "E_star": 1e5, "R": 100.0}  # N and mm
    >>> system = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(**cylinder))
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> end = fo.joints.worn_in(system, cycle, friction=0.5, load_factor=100.0)
    >>> f"{1e3 * end.depth.max():.2f} micrometres, {end.stick.sum()} nodes never slip"
    '0.61 micrometres, 16 nodes never slip'
    """
    f = _checked_friction(checked_system(system), friction)
    _check_similar(system)
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    first, last = _ends_of_cycle(system, checked_cycle(cycle), load_factor)
    shear_change = _shear_change(system, first, last)
    stick = _stick_zone(system, first, last, shear_change / (2 * f))
    depth = _depth(system, stick, first, last)
    if depth.any():
        _check_lead(shear_change, f * np.abs((last - first)[-system.nodes :]))
    # Worn nodes are open for other questions, in spite of rounding.
    depth[~stick & (depth > 0)] += RESIDUAL * depth.max()

    note = (
        "the depths by the theorem are in the attribute `depth`; it is not checked that the "
        "worn contact shakes down"
    )
    with progress_bar(progress, "worn in") as bar:
        bar.keep("depth", frozen(depth), note)
        steady = steady_state(system.with_gap(system.gap + depth), cycle, friction, load_factor)
    if steady.outcome is not Outcome.SHAKEDOWN:
        raise SolverError(
            "worn_in: the worn contact does not shake down, it dissipates "
            f"{steady.dissipation:.1e} per cycle; use wear"
        )
    return WornIn(steady, frozen(depth), stick, steady.record)


def _require(holds: bool | np.bool_, reason: str) -> None:
    """Raise an error if a condition of the theorem does not hold."""
    if not holds:
        raise ModelError(f"{reason}; no theorem predicts the end of wear then: use `wear`")


def _checked_friction(system: ContactSystem, friction: PerNode) -> float:
    """The coefficient of friction, which is the same at all nodes."""
    f = friction_coefficients(friction, system)
    _require(f.min() == f.max() > 0, f"friction: from {f.min():g} to {f.max():g}")
    return float(f[0])


def _check_similar(system: ContactSystem) -> None:
    """Check that the contact is uncoupled, and that A is a multiple of its normal stiffness C.

    Also check that wear at one node takes next to no pressure off other nodes.
    """
    A, B, C = system.A, system.B, system.C
    checked_round(system, ONE_FRICTION)
    _require(not system.capped, "system: it has a shear strength")
    _require(
        np.abs(B).max() <= CONDENSATION * np.abs(A).max(),
        "system: it is coupled: slip changes its pressures",
    )
    ratio = np.trace(A) / (system.tangents * np.trace(C) or 1.0)
    similar = np.kron(np.eye(system.tangents), C) * ratio
    _require(
        _near(A, similar),
        "system: its tangential stiffness is not a multiple of its normal stiffness, as for "
        "similar half-planes",
    )
    diagonal = np.diag(C)
    # Largest pressure that wear at one node takes off another node, divided by the pressure that it
    # takes off its own node. For half-planes that are divided into cells it is 0.01.
    most_relief = 0.03
    relief = C - np.diag(diagonal) - most_relief * diagonal[:, None]
    relieved, worn = np.unravel_index(relief.argmax(), C.shape)
    _require(
        relief.max() <= 0,
        f"system: wear at node {worn}{in_contact(system, worn)} takes pressure off node {relieved}"
        f"{in_contact(system, relieved)}, so that the order in which they wear matters",
    )


def _ends_of_cycle(
    system: ContactSystem, cycle: LoadCycle, load_factor: float
) -> tuple[Array, Array]:
    """The two loads (M,) at the ends of the line on which all loads of a cycle lie."""
    loads = reactions(system, cycle.at(load_factor))
    changes = loads - loads[0]
    line = changes[np.linalg.norm(changes, axis=1).argmax()]
    place = changes @ line / (line @ line or 1.0)
    on_line = loads[0] + np.outer(place, line)
    _require(_near(loads, on_line), "cycle: its loads do not stay on one line")
    return loads[place.argmin()], loads[place.argmax()]


def _shear_change(system: ContactSystem, first: Array, last: Array) -> Array:
    """(N,) change of the bonded shear between two loads (M,), along its common direction."""
    n = system.nodes
    shear = (last - first)[:-n].reshape(-1, n)
    direction = np.linalg.svd(shear)[0][:, 0]
    change = direction @ shear
    _require(
        _near(shear, np.outer(direction, change)),
        "cycle: its shear does not act along one direction at all nodes",
    )
    return np.asarray(np.sign(change.sum()) * change)


def _stick_zone(
    system: ContactSystem, first: Array, last: Array, shear_over_friction: Array
) -> Booleans:
    """(N,) which nodes of the unworn bodies are closed under the normal reactions p*.

    With the loads 1 and 2 at the ends of the cycle::

        p* = (p1 + p2) / 2 - |q2 - q1| / (2 f)

    `shear_over_friction` is the last term.
    """
    n = system.nodes
    normal = (first + last)[-n:] / 2 - shear_over_friction
    is_open = open_nodes(system, normal - system.C @ system.gap)
    stick = np.zeros(n, dtype=bool) if is_open is None else ~is_open
    _require(stick.any(), "load_factor: no node sticks, the contact slides as a whole")
    return stick


def _depth(system: ContactSystem, stick: Booleans, first: Array, last: Array) -> Array:
    """(N,) the larger of the overlaps at the two loads, if only the stick zone is in contact.

    Nodes outside the stick zone carry no force, even if they overlap.
    """
    C, gap, outside = system.C, system.gap, ~stick
    loads = np.array([first, last])[:, -system.nodes :][:, outside]
    by_closed = C[np.ix_(outside, stick)] @ gap[stick]
    closing = np.linalg.solve(C[np.ix_(outside, outside)], (loads - by_closed).T)
    depth = np.zeros(system.nodes)
    depth[outside] = np.maximum(closing.max(axis=1) - gap[outside], 0.0)
    return depth


def _check_lead(shear_change: Array, bound_change: Array) -> None:
    """Check that at each node the shear changes at least as much as its friction bound, (N,)."""
    lead = shear_change - bound_change
    _require(
        lead.min() >= -CONDENSATION * np.abs(lead).max(),
        f"cycle: with no slip, the shear at node {int(lead.argmin())} changes by less than "
        "friction times the change of its pressure, or in another direction than at most nodes",
    )


def _near(values: Array, expected: Array) -> bool:
    return bool(np.abs(values - expected).max() <= CONDENSATION * np.abs(values).max())
