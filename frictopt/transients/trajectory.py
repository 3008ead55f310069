"""The states of a transient, and the loop of a load case over them."""

# One file, because the loop, the tables and the check all read the same states.
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ..base import (
    ROUNDING,
    SIMULTANEOUS,
    Array,
    Integers,
    Kept,
    Plotted,
    SolveRecord,
    Table,
    choice,
    components,
    frame,
    frozen,
    whole_number,
)
from ..base.results import named_places
from ..contact import ContactState, ContactSystem, LoadCycle, Verdict, check_contact_law, joined

if TYPE_CHECKING:
    from .increments import Increment


@dataclass(frozen=True, eq=False, repr=False)
class LoadLoop(Kept, Plotted):
    """Amplitude and displacement of one load case at T states of a transient.

    On the exact path they are linear between the states, so the loop is exact.

    Attributes
    ----------
    case
        Name of the load case.
    amplitude, displacement
        (T,) amplitude of the load case, and the work-conjugate displacement, see
        `ContactSystem.displacements`.
    slipping
        (T,) number of slipping nodes. On the exact path they slip from the state to the next event;
        in increments they slip during the increment that ends at the state.
    area
        Area of the loop, force times length (per depth): the work that the load case does over
        these states. Over a steady cycle the areas of all load cases add up to the work of
        friction. In increments the sum of the areas is smaller if nodes slip only in a part of an
        increment.
    stiffness
        Secant stiffness: range of the amplitude divided by the range of the displacement; inf if
        there is no displacement.
    units, per_depth
        Names of the units of force and length, or None if they are not known; and whether works are
        per depth, as in plane strain and plane stress.
    load_size
        Force of the amplitude 1, see `ContactSystem.load_size`; NaN if it is not known. The picture
        shows the displacement divided by this force, which is a length, and the stiffness times its
        square, which is a force per length.

    Examples
    --------
    >>> import frictopt as fo
    >>> blocks = fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0)
    >>> rod = fo.ContactSystem.from_blocks(**blocks, compliance=[[0, 0], [0, 0]])
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> loop = steady.loop("force")  # the force moves its node by 0.5 either way
    >>> round(loop.area, 9), round(steady.dissipation, 9), round(loop.stiffness, 9)
    (1.0, 1.0, 2.0)
    """

    case: str
    amplitude: Array
    displacement: Array
    slipping: Integers
    units: str | None = None
    per_depth: bool = False
    load_size: float = np.nan

    @property
    def area(self) -> float:
        """Area of the loop, see `LoadLoop`; 0 if it is rounding."""
        area = float((self.amplitude[1:] + self.amplitude[:-1]) / 2 @ np.diff(self.displacement))
        around = float(np.ptp(self.amplitude) * np.ptp(self.displacement))
        return area if abs(area) > ROUNDING * around else 0.0

    @property
    def stiffness(self) -> float:
        """Secant stiffness, see `LoadLoop`."""
        distance = np.ptp(self.displacement)
        return float(np.ptp(self.amplitude) / distance) if distance > 0 else np.inf

    def to_frame(self) -> Table:
        """The DataFrame of the states: columns amplitude, displacement, slipping."""
        return frame(
            {name: getattr(self, name) for name in ("amplitude", "displacement", "slipping")}
        )

    def _answer(self) -> Mapping[str, object]:
        return {
            "case": self.case,
            "states": len(self.amplitude),
            "area": self.area,
            "stiffness": self.stiffness,
        }


_OF_LOADS = "time", "amplitudes", "bonded_q", "bonded_p"
_OF_NODES = "slip", "gap", "q", "p", "status", "work"


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Kept, Plotted):
    """T states of a transient: one after each event of the exact path, or one after each increment.

    Attributes
    ----------
    system, friction, cycle
        The contact, (N,) coefficients of friction, and the load cycle.
    time
        (T,) number of corners visited: 0 at the mean load, k at the k-th corner, and linear between
        them. In a transient from an earlier state, the count begins at the number (from 0) of the
        corner that comes next after that state.
    amplitudes
        (T, cases) amplitudes of the load cases, in the order of `system.bonded`. They are NaN from
        an earlier state to the first corner after it.
    bonded_q, bonded_p
        Bonded reactions of the load: `bonded_q` is (T, N) in the plane and (T, N, 2) in space,
        `bonded_p` is (T, N). They are forces per depth in the plane, forces in space.
    slip, gap
        Slip v, (T, N) along +x in the plane, (T, N, 2) along the tangents in space; and gap w,
        (T, N). Both are lengths.
    q, p
        Shear forces in the shape of `slip`, and (T, N) normal forces, compression positive, in the
        units of `bonded_q`.
    status
        (T, N) 0: stick; 2: open; 1: slip, in the plane along +x; -1 (only in the plane): slip
        against +x. On the exact path a status holds from the state to the next event, in increments
        during the increment that ends at the state.
    work
        (T, N) work of friction so far, >= 0, force times length (per depth).
    engine
        "path": followed exactly, from event to event. "newton": in increments.
    step_error
        0 for the exact path. In increments, the estimated error of the slip at the mean load and
        the corners due to the size of the increments, in slip scales (the largest nodal force
        divided by the stiffness scale). This estimate is the larger of two numbers: the change of
        slip if a half or a quarter of the increments is used (inf if these runs fail or do not
        exist), and the slip that may be missed within the increments. In plane contacts, whose
        exact path is known, the true error was at most 5 times larger; the estimate is no bound.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> path = fo.march(rod, cycle, friction=0.5, load_factor=1.0, cycles=1)
    >>> path.residual < 1e-9
    True
    >>> at_second_corner = path.to_frame().query("node == 0 and time == 2.0")
    >>> at_second_corner[["slip", "gap", "q", "p"]].round(6)
        slip  gap    q    p
    24  -0.5  0.0  0.5  1.0
    """

    system: ContactSystem
    friction: Array
    cycle: LoadCycle
    time: Array
    amplitudes: Array
    bonded_q: Array
    bonded_p: Array
    slip: Array
    gap: Array
    q: Array
    p: Array
    status: NDArray[np.int8]
    work: Array
    engine: str
    step_error: float
    _seconds: float

    def check_kept(self) -> None:
        """Check the states of a loaded result by the contact law; ValueError if they are off."""
        # States in increments have larger errors than steady states.
        if not self.verdict.residual <= 1e-6:
            raise ValueError(f"its states violate the contact law by {self.verdict.residual:.1e}")

    @cached_property
    def _force(self) -> float:
        """Scale of the nodal forces, at least as large as in a steady state.

        The scale is the largest nodal force of the loads, or the mean normal force under the mean
        load if this force is larger.
        """
        loads = joined(self.bonded_q, self.bonded_p)
        if self.time[-1] >= 0:
            loads = loads[self.time >= 0]
        pressure = self.system.reaction(self.cycle.mean)[1]
        return max(float(np.abs(loads).max()), float(np.abs(pressure).mean())) or 1.0

    @cached_property
    def verdict(self) -> Verdict:
        """Violations of the contact law over all states, with the slip since the previous state.

        The unit of force is the largest nodal force of the loads.
        """
        return check_contact_law(
            self.system,
            (self.bonded_q, self.bonded_p),
            self.friction,
            v=self.slip,
            w=self.gap,
            q=self.q,
            p=self.p,
            previous_slip=np.concatenate([self.slip[:1], self.slip[:-1]]),
            force_scale=self._force,
        )

    @property
    def residual(self) -> float:
        """Largest violation of the contact law over all states.

        On the exact path it includes the error of the energy balance, see `energy_error`.
        """
        if self.engine == "path":
            return max(self.verdict.residual, self._energy_residual)
        return self.verdict.residual

    @property
    def record(self) -> SolveRecord:
        """Record of the computation. Its solver is the engine."""
        return SolveRecord(self.engine, (), self.residual, (), self._seconds)

    @cached_property
    def _energy_residual(self) -> float:
        """Largest error of the energy balance, or negative work of a node, relative to an energy.

        The reference energy is the largest of three: the unit of energy, the work of friction, and
        the elastic energy as a sum of absolute values.
        """
        unit = self._force**2 / self.system.stiffness_scale
        u = joined(self.slip, self.gap - self.system.gap)
        elastic = float((np.abs(u @ self.system.S) * np.abs(u)).sum(axis=1).max())
        scale = max(unit, elastic, float(self.work[-1].sum()))
        negative_work = -np.diff(self.work, axis=0).min(initial=0.0)
        return float(max(np.abs(self.energy_error).max(), negative_work) / scale)

    @cached_property
    def energy(self) -> Array:
        """(T,) elastic energy `u S u / 2` of the relative motion `u = [v, w - g0]`.

        Its unit is force times length (per depth).
        """
        u = joined(self.slip, self.gap - self.system.gap)
        return frozen(((u @ self.system.S) * u).sum(axis=1) / 2)

    @cached_property
    def energy_error(self) -> Array:
        """(T,) work of friction + elastic energy gained + work against the bonded reactions.

        On the exact path this sum is only rounding. In increments motions are not linear, so the
        sum depends on the size of the increments.
        """
        u = joined(self.slip, self.gap)
        load = joined(self.bonded_q, self.bonded_p)
        steps = ((load[1:] + load[:-1]) / 2 * np.diff(u, axis=0)).sum(axis=1)
        against_loads = np.concatenate([[0.0], np.cumsum(steps)])
        friction_work = self.work.sum(axis=1) - self.work[0].sum()
        return frozen(friction_work + self.energy - self.energy[0] + against_loads)

    @cached_property
    def cycle_work(self) -> Array:
        """(cycles, N) work of friction in each whole cycle."""
        corners = len(self.cycle.corners)
        # Whole cycles begin at the first multiple of `corners`.
        first = -(-int(np.ceil(self.time[0])) // corners) * corners
        times = np.arange(first, self.time[-1] + 0.5, corners)
        rows = np.searchsorted(self.time, times + SIMULTANEOUS) - 1
        return frozen(np.diff(self.work[rows], axis=0))

    def from_mean_load(self) -> Trajectory:
        """The states from the mean load on, without the artificial load before it."""
        first = int(np.flatnonzero(self.time >= 0)[0])
        return replace(
            self, **{name: getattr(self, name)[first:] for name in (*_OF_LOADS, *_OF_NODES)}
        )

    def state_at(self, number: int) -> ContactState:
        """The state with index `number`; another transient may start from it.

        A negative index counts from the end.

        Raises
        ------
        ModelError
            There is no such state.
        """
        row = whole_number("number", number, least=-len(self.time), most=len(self.time) - 1)
        corner = int(self.time[row] + SIMULTANEOUS) % len(self.cycle.corners)
        return ContactState(
            self.slip[row],
            np.maximum(self.gap[row], 0.0),
            self.bonded_q[row],
            self.bonded_p[row],
            corner,
            self.cycle.corner_names[corner],
        )

    def increment(
        self, number: int, form: Literal["qp", "complementarity", "milp"] = "qp"
    ) -> Increment:
        """The increment that ends at the state with index `number`, as a problem.

        The variables of its `problem` hold this state. Its `residual` is the violation of the
        contact law, relative to the loads of this increment.

        Parameters
        ----------
        number
            Index of the state at the end of the increment, from 1.
        form
            "qp": the convex program with the friction bound `f p` of this state, also in space.
            "complementarity": the complementarity problem, which is not convex. "milp": the contact
            law with booleans.

        Raises
        ------
        ModelError
            There is no such increment, or no such form in space.

        Examples
        --------
        >>> import frictopt as fo
        >>> blocks = fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0)
        >>> rod = fo.ContactSystem.from_blocks(**blocks)
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> path = fo.march(rod, cycle, friction=0.5, load_factor=1.0, cycles=1)
        >>> increment = path.increment(3, "complementarity")
        >>> print(increment.problem)
        minimize z @ (M @ z + c)
        subject to motions: 0.0 <= z
                   slacks: 0.0 <= M @ z + c
        >>> bool(abs(increment.problem.value) < 1e-12), increment.residual < 1e-12
        (True, True)
        """
        from .increments import NewtonIncrement

        row = whole_number("number", number, least=1, most=len(self.time) - 1)
        bonded = self.bonded_q[row], self.bonded_p[row]
        after = self.slip[row], np.maximum(self.gap[row], 0.0)
        engine = NewtonIncrement(self.system, self.friction)
        return engine.held(self.slip[row - 1], bonded, after, form)

    def displacement(self, case: str) -> Array:
        """(T,) displacement of a load case, see `ContactSystem.displacements`.

        The displacement is NaN if the amplitude of the load case is not known.

        Raises
        ------
        ModelError
            An unknown load case, or a system without `compliance`.
        """
        displacements = self.system.displacements(self.amplitudes, self.slip, self.gap)
        return frozen(displacements[:, self._column(case)])

    def tension(self, case: str) -> Array:
        """(T,) tension of the locked bolt of a load case, force, see `ContactSystem.tension`.

        The tension is NaN if the amplitudes are not known.

        Raises
        ------
        ModelError
            A load case without a locked bolt, or a system without `compliance`.
        """
        return frozen(self.system.tension(case, self.amplitudes, self.slip, self.gap))

    def loop(self, case: str) -> LoadLoop:
        """The loop of a load case over all states at which its amplitude is known.

        Raises
        ------
        ModelError
            See `displacement`.
        """
        displacement = self.displacement(case)
        amplitude = self.amplitudes[:, self._column(case)]
        known = np.isfinite(amplitude)
        slipping = np.count_nonzero(np.abs(self.status) == 1, axis=1)
        return LoadLoop(
            case,
            amplitude[known],
            displacement[known],
            slipping[known],
            units=self.system.units,
            per_depth=self.system.per_depth,
            load_size=self.system.load_size.get(case, np.nan),
        )

    def _column(self, case: str) -> int:
        """Column of a load case in `amplitudes`."""
        return list(self.system.bonded).index(choice("case", case, self.system.bonded))

    def to_frame(self) -> Table:
        """The DataFrame of all states and nodes.

        Columns are state, time, node, contact (if known), x (in space x, y, z), slip (in space
        slip1, slip2), gap, q (q1, q2), p, status and work. Statuses are words: "stick", "slip",
        "open"; in the plane "slip+" along the tangent and "slip-" against it.
        """
        states, nodes = self.gap.shape
        state = np.repeat(np.arange(states), nodes)
        node = np.tile(np.arange(nodes), states)
        columns: dict[str, object] = {"state": state, "time": self.time[state], "node": node}
        for name, values in named_places(self.system).items():
            columns[name] = values[node]
        for name in ("slip", "gap", "q", "p"):
            values = getattr(self, name)
            columns |= components(name, values.reshape(states * nodes, *values.shape[2:]))
        columns |= {"status": self._words.ravel(), "work": self.work.ravel()}
        return frame(columns, units=self.system.units)

    @property
    def _words(self) -> NDArray[np.str_]:
        """(T, N) status in words."""
        if self.system.tangents == 1:
            # The status -1 is the last word.
            return np.array(["stick", "slip+", "open", "slip-"])[self.status]
        return np.array(["stick", "slip", "open"])[self.status]

    def _answer(self) -> Mapping[str, object]:
        answer: dict[str, object] = {
            "states": len(self.time),
            "nodes": self.system.nodes,
            "cycles": max(0, int(self.time[-1])) // len(self.cycle.corners),
            "work": float(self.work[-1].sum()),
            "engine": self.engine,
            "residual": self.residual,
        }
        if self.engine != "path":
            answer["step_error"] = self.step_error
        return answer
