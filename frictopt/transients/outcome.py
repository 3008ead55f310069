"""The steady state of a contact, the states of its cycle, and its tables for fretting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    COUNTS,
    RESIDUAL,
    SAME_STATE,
    Array,
    Booleans,
    Outcome,
    Plotted,
    Recorded,
    SolveRecord,
    Table,
    components,
    finite_number,
    frame,
    frozen,
    whole_number,
)
from ..base.results import named_places
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    contact_law,
    joined,
    off_law,
    reactions,
)
from ..errors import ModelError, SolverError
from .fretting import contact_table, fretting_table, tensions, with_critical_planes
from .march import amplitudes_at, march
from .trajectory import LoadLoop, Trajectory
from .transient import scales


@dataclass(frozen=True, eq=False, repr=False)
class SteadyState(Recorded, Plotted):
    """The steady state that a transient reaches, on the exact path or in increments.

    It is proven by a cycle that starts from this state and returns to it. Theory, eq. (15).

    Attributes
    ----------
    outcome
        The long-run behaviour.
    dissipation
        Work of friction per load cycle in the steady state, the mean over its period, >= 0, force
        times length (per depth); 0 after shakedown.
    dissipation_per_node
        (N,) the dissipation of each node.
    sliding_distance
        (N,) distance that each node slides per load cycle while it is closed, the mean over the
        period, length; 0 after shakedown.
    work_error
        Estimated relative difference between `dissipation` and the dissipation of later cycles. At
        most 1e-9, with two exceptions: the work is so small that it is rounding of the loads, or
        slip in increments converges slowly to one of many steady cycles. It is no bound: in
        increments, it was too small in 3 of 546 random contacts of 3 to 8 nodes, by at most 1.8e-7.
    step_error
        0 for the exact path. In increments, the estimated relative error of the dissipation due to
        the size of the increments: twice the change in finer increments, plus a share of the
        uncertain work within the increments. The estimate is inf if finer increments have no
        answer, or if the contact sticks but may slip in finer increments. It is no bound. In random
        contacts of 1 to 5 nodes, with 1 to 4 increments, the median of the estimates was 2.2 times
        the true error. At load factors at least 5 % above the limit, none of 114 estimates was too
        small (the smallest was 1.2 times the true error). Within 2 % of the limit, 1 of 183
        estimates was too small (0.6 times the true error). In bolted joints, where many nodes slip
        only in the first cycles, the estimate was 3 to 35 times the true error. NaN: not estimated,
        see `report`.
    period
        Number of load cycles after which the state, or its drift, repeats: 1 or 2.
    system, cycle, friction, load_factor
        The arguments of `steady_state`; friction is (N,).
    slip
        Slip at the last corner of the cycle, (N,) in the plane, (N, 2) in space, length. For
        ratcheting it is the slip after the last cycle that was followed.
    gap
        (N,) gap w at the last corner, length.
    state
        Slip, gap and load at the last corner. Another transient may start from this state.
    open
        (N,) whether the node is open at some corner of the steady cycle (corners on a straight
        segment between others do not count); in increments, at the end of some increment.
    slipping
        (N,) whether the node slides against friction in the steady cycle. Its sliding distance must
        exceed rounding, and also the change of slip from one cycle to the next.
    first_cycle
        Work of friction in the first load cycle; an overload before it is not included.
    cycles
        Number of cycles followed, including cycles of proofs and of failed extrapolations.
    events
        Number of changes of status. In increments, the ends of successive increments are compared.
    record
        How the state was found. Its `residual`, at most 1e-9, is the largest of three errors: the
        violation of the contact law at the corners or increments of the proving cycle; the change
        of slip over this cycle; and, on the exact path, the error of the energy balance of any
        cycle, relative to the largest energy in it. Forces are in units of the largest nodal force
        of the load cycle, slips in units of that force divided by the stiffness scale.
    extrapolated
        True if the state is the extrapolated fixed point of the cycle map, or was reached from it;
        False if the transient reached it cycle by cycle.
    unproven
        Number of events after which the rates of slip and gap are not proven to be unique under the
        contact law. 0: the transient from this start is unique. Such events occur if nodes lift
        off, or if friction comes near its critical value. Another transient from the same start may
        then end in another steady state. In increments uniqueness is proven for no event.
    steps
        Number of increments from corner to corner; 0 for the exact path.
    drift
        Largest slip that a node gains per load cycle, length. It is 0 unless the contact ratchets.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> steady.dissipation_per_node.round(6).tolist(), float(steady.states().slip[:, 0].max())
    ([1.0, 0.0, 0.0, 0.0], 0.5)
    """

    outcome: Outcome
    dissipation: float
    dissipation_per_node: Array
    sliding_distance: Array
    work_error: float
    step_error: float
    period: int
    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    load_factor: float
    slip: Array
    gap: Array
    state: ContactState
    open: Booleans
    slipping: Booleans
    first_cycle: float
    cycles: int
    events: int
    extrapolated: bool
    unproven: int
    steps: int
    record: SolveRecord
    drift: float = 0.0

    def check_kept(self) -> None:
        """Check the last state of a loaded result by the contact law; ValueError if it is off."""
        system = self.system
        law = contact_law(system, self.friction)
        loads = reactions(system, self.cycle.at(self.load_factor))
        u = joined(self.slip, self.gap - system.gap)
        force = float(np.abs(loads).max()) or 1.0
        off = off_law(system, law, loads[-1], u, loads[-1] + system.S @ u, force).max()
        # Another processor may round an error to the other side of its tolerance.
        if not off <= 10 * RESIDUAL:
            raise ValueError(f"its last state violates the contact law by {off:.1e}")
        work = self.dissipation_per_node
        if work.shape != (system.nodes,) or not np.isclose(
            work.sum(), self.dissipation, RESIDUAL, 0
        ):
            raise ValueError(
                f"its nodes dissipate {work.sum():g}, all of them {self.dissipation:g}"
            )

    @property
    def engine(self) -> str:
        """Method of the transient: "path" for the exact path, "newton" for increments."""
        return "newton" if self.steps else "path"

    def to_frame(self) -> Table:
        """The DataFrame of the nodes.

        Columns are node, contact (if named), x (x, y, z), slip (slip1, slip2), open and dissipation
        (work per cycle).
        """
        columns = {
            "node": range(len(self.gap)),
            **named_places(self.system),
            **components("slip", self.slip),
            "open": self.open,
        }
        return frame({**columns, "dissipation": self.dissipation_per_node}, units=self.system.units)

    @property
    def slipping_share(self) -> float:
        """Share of the area (in the plane, of the length) that slips in the steady cycle.

        See `slipping`. If the nodes have no `width`, it is the share of the nodes.
        """
        return float(np.average(self.slipping, weights=self.system.width))

    def states(self) -> Trajectory:
        """All states of one period, from one last corner to the next.

        They are the state at the beginning, and one state after each event or increment.

        Raises
        ------
        SolverError
            The states do not return to the beginning, or their work differs.
        """
        return self._states

    @cached_property
    def _states(self) -> Trajectory:
        path = march(
            self.system,
            self.cycle,
            self.friction,
            self.load_factor,
            initial_state=self.state,
            cycles=self.period,
            steps=self.steps or None,
            progress=False,
        )
        work = self.period * self.dissipation_per_node
        check_return(path, self.load_factor, self.outcome, work, self.work_error)
        # The path does not know the amplitudes at its start, which are the amplitudes of the last
        # corner.
        last = self.cycle.at(self.load_factor)[-1]
        start = {case: last.get(case, 0.0) for case in self.system.bonded}
        amplitudes = amplitudes_at(self.system, self.cycle, self.load_factor, path.time, start)
        return replace(path, amplitudes=frozen(amplitudes))

    def displacement(self, case: str) -> Array:
        """(T,) displacement of a load case at the `states`, see `Trajectory.displacement`."""
        return self.states().displacement(case)

    def loop(self, case: str) -> LoadLoop:
        """The loop of a load case over one period, see `Trajectory.displacement`.

        Displacements follow from the loads. Displacement-controlled cycles are not supported: give
        the loads.
        """
        return self.states().loop(case)

    def by_contact(self, model: Any = None) -> Table:
        """The sticking, slipping and open parts of each contact, and the forces through it.

        Parameters
        ----------
        model
            The `ContactModel` that was condensed, for a row of each of its ties.

        Returns
        -------
        DataFrame
            One row for each contact. Columns:

            - contact, its name ("the contact" if the system has no names), its number of nodes,
              and its area (in the plane its length), if `width` is known;
            - sticking, slipping, open: shares of the area or, without `width`, of the nodes; they
              add up to 1. Slipping nodes slide against friction (`slipping`), open nodes open at
              some corner (`open`) and do not slip, all other nodes stick;
            - work of friction per cycle; slip_range, the largest distance of two slips of a node
              while it is closed;
            - P_0, Q_0, fP_0, P_1 ..: forces at the corners 0, 1 .. of the cycle (of the second
              cycle, if the `period` is two). P is the sum of the normal forces, compression
              positive. Q is the resultant of the shear forces. On a straight plane contact it is
              the component along the tangent; otherwise it is the size of the resultant. fP is the
              sum of friction (along the first tangent) times normal force, or of shear strengths:
              the largest Q that a flat face can carry.

            The rows of ties follow, with 0 nodes and without area and fP. P is the sum of the
            forces on body 1 along the normals, Q the size of the resultant of what remains, and the
            columns M_0, M_1 .. have the size of the moment about the middle of the tied area.

            `attrs["corners"]` has the names of the corners; `attrs["note"]` says whether the shares
            are of the area or of the nodes.

        Raises
        ------
        ModelError, SolverError
            The system was condensed from another model; or an error of `states`.

        Examples
        --------
        >>> import frictopt as fo
        >>> blocks = fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0)
        >>> rod = fo.ContactSystem.from_blocks(**blocks)
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
        >>> table = steady.by_contact()
        >>> table[["nodes", "slipping", "work", "P_0", "Q_0", "Q_1", "fP_0"]].round(6)
           nodes  slipping  work  P_0  Q_0  Q_1  fP_0
        0      4      0.25   1.0  4.0 -1.0  1.0   2.0
        """
        work = self.dissipation_per_node
        return contact_table(self.states(), self.slipping, self.open, work, model)

    def bolt_table(self) -> Table:
        """Tensions of the locked bolts over the steady cycle: one row for each bolt.

        Columns are bolt, its load case; force, the force of its `BoltPreload`; tension_mean, the
        middle of the range of its tension; and tension_amplitude, half of the range, for the
        fatigue of the bolt. In increments, the range is taken over the ends of the increments.

        Raises
        ------
        ModelError
            There is no locked bolt, or the system has no `compliance`.
        """
        return tensions(self.states())

    def fretting_table(
        self,
        *,
        stress: ArrayLike | None = None,
        strain: ArrayLike | None = None,
        fields: Any = None,
        side: int = 1,
        findley: float = 0.3,
        crossland: float = 0.3,
        fatemi_socie: float = 0.0,
    ) -> Table:
        """Parameters of fretting: one row for each node.

        Theory, eq. (22).

        Parameters
        ----------
        stress, strain
            (M, N), in space (M, N, 2, 2), stress and strain of one body along the tangents at the
            nodes of the contact, at M states of the steady cycle, as `BodyFields.at_contact` gives
            them. Pass both or neither.
        fields, side
            All stress components of body `side`, instead of `stress` and `strain`. Give the
            `ContactModel` that was condensed, for its fields at all states; or the fields of
            `ContactModel.recover` at two or more states of the cycle.
        findley, crossland, fatemi_socie
            Weights of the largest normal stress (Findley), of the largest hydrostatic stress
            (Crossland), and of the largest normal stress (Fatemi and Socie: k divided by the yield
            stress, 1 / stress).

        Returns
        -------
        DataFrame
            Columns:

            - node, x (in space x, y, z), and contact if the system names its contacts;
            - slip_range, the largest distance of two slips of the cycle while the node is closed
              (including its drift, if the contact ratchets);
            - tau_amplitude, tau_mean, pressure_amplitude, pressure_mean: half the largest distance
              of two tractions, and the middle of their range, for `q / width` and `p / width` (in
              space tau_mean1 and tau_mean2). Without a width the same values of the nodal forces:
              q_amplitude, q_mean, p_amplitude, p_mean;
            - work, share, work_density: work of friction per cycle, its share of the whole, and
              divided by the width;
            - F1, Ruiz's first parameter: largest shear traction of the cycle times slip range
              (without a width F1_force, with the nodal force);
            - F2 and SWT, with stress and strain: Ruiz's second parameter, largest tensile stress
              times F1; and the parameter of Smith, Watson and Topper, largest tensile stress times
              half the range of the strain. Both are computed on the plane normal to the tangent, in
              space on the plane normal to the largest slip. So in space SWT is NaN at nodes that do
              not slip, unless `fields` are given;
            - SWT, Findley, Fatemi_Socie and Crossland, with fields: the first three on the critical
              plane of each, in any direction. Planes are searched in steps down to 0.001 degrees.
              SWT may be too low by a relative 1e-4 if its maximum is at a kink;
            - from, to, with fields: the least and the largest normal stress in the cycle on the
              critical plane of SWT. pyLife needs these two names for a load collective, which here
              has one cycle per node.

            `attrs["note"]` names the columns that depend on the mesh, and explains `from` and `to`.
            At the corner of a complete contact, tractions and stresses grow without bound as the
            elements shrink. So do F1, F2 and SWT.

        Raises
        ------
        ModelError, SolverError
            Bad input; or an error of `states`.

        Notes
        -----
        F1 and F2: Ruiz, Boddington & Chen 1984, Experimental Mechanics 24, 208-217. SWT: Smith,
        Watson & Topper 1970, J. Materials 5, 767-778; for fretting: Szolwinski & Farris 1996, Wear
        198, 93-107. Findley 1959, J. Eng. Ind. 81, 301-306; Fatemi & Socie 1988, Fatigue Fract.
        Eng. Mater. Struct. 11, 149-165; Crossland 1956, Int. Conf. Fatigue of Metals, London,
        138-149.

        Examples
        --------
        >>> import frictopt as fo
        >>> blocks = fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0)
        >>> rod = fo.ContactSystem.from_blocks(**blocks)
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
        >>> columns = ["node", "slip_range", "q_amplitude", "share", "F1_force"]
        >>> steady.fretting_table()[columns].round(6).head(2)
           node  slip_range  q_amplitude  share  F1_force
        0     0         1.0          0.5    1.0       0.5
        1     1         0.0          0.5    0.0       0.0
        """
        body = whole_number("side", side, least=1, most=2)
        weights = {
            "SWT": 0.0,
            "Findley": finite_number("findley", findley, least=0.0),
            "Fatemi_Socie": finite_number("fatemi_socie", fatemi_socie, least=0.0),
            "Crossland": finite_number("crossland", crossland, least=0.0),
        }
        if fields is not None and stress is not None:
            raise ModelError("fields, stress: both; give the fields, which have the stress")
        states = self.states()
        table = fretting_table(states, self.dissipation_per_node, stress, strain)
        if fields is None:
            return table
        if hasattr(fields, "recover"):
            # If nothing slips or opens, stresses change linearly from corner to corner, so the
            # fields at the corners are enough.
            every = bool(self.slipping.any() or (states.gap > 0).any())
            fields = list(fields._over(self, every=every))
        return with_critical_planes(table, fields, body, weights)

    def _answer(self) -> Mapping[str, object]:
        last = "unproven" if self.engine == "path" else "step_error"
        names = ["outcome", "dissipation", "cycles", "residual", last]
        if self.outcome is Outcome.RATCHETING:
            names.insert(2, "drift")
        return {name: getattr(self, name) for name in names}


# Check that the states of one period of a steady state come back, with the same work.

# A cycle from a steady state may differ from this state by so many times the accepted errors.
_ACCEPTED = 10


def check_return(
    path: Trajectory, load_factor: float, outcome: Outcome, work: Array, work_error: float
) -> None:
    """Check the states of one period against the steady state; SolverError if they differ.

    `work` (N,) is the work per period of the steady state. Changes that `steady_state` neglects are
    neglected here, too: slips of `RESIDUAL` slip scales, a relative work of `work_error` and, after
    shakedown, the work of such a slip.
    """
    system = path.system
    cycle = path.cycle
    mean, *corners = reactions(system, [cycle.mean, *cycle.at(load_factor)])
    units = scales(system.S, mean, np.array(corners), system.nodes)
    if outcome is Outcome.SHAKEDOWN:
        accepted_work = units.force * units.length * RESIDUAL
    else:
        accepted_work = work_error * work.sum()
    force = float(np.abs(path.p).max()) or 1.0
    motion = max(float(np.abs(path.slip).max()), float(path.gap.max()))
    # If all works are rounding, their change is relative to the unit of work.
    unit_of_work = force * max(motion, COUNTS * force / system.stiffness_scale)
    change = np.abs(path.work[-1] - work) - _ACCEPTED * accepted_work
    error = max(float(change.max()), 0.0) / max(float(path.work.max()), unit_of_work)
    if outcome is not Outcome.RATCHETING:
        ends = joined(path.slip, path.gap)[[0, -1]]
        moved = np.ptp(ends, axis=0).reshape(-1, system.nodes).max(axis=0)
        moved[moved <= _ACCEPTED * RESIDUAL * units.length] = 0.0
        error = max(error, float(moved.max()) / (motion or 1.0))
    if not error <= SAME_STATE:
        raise SolverError(
            "steady state: a cycle from this state does not return to it, the difference is "
            f"{error:.1e} (tolerance {SAME_STATE:g})"
        )
