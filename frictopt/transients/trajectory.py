"""The states of a transient, and the loop that a load case makes over them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..base import (
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
    places,
    whole_number,
)
from ..base.results import named_places
from ..contact import ContactState, ContactSystem, LoadCycle, Verdict, joined, referee
from ..errors import ModelError

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class LoadLoop(Kept, Plotted):
    """Amplitude and displacement of one load case at T states of a transient; on the exact path, linear between them, the loop is exact.

    Attributes
    ----------
    case
        Name of the load case.
    amplitude, displacement
        (T,) its amplitude, and its displacement, whose product with the amplitude is work, see
        `ContactSystem.displacements`.
    slipping
        (T,) number of nodes that slip: until the next event (path), or over the increment that ends
        here.
    area
        Area of the loop, force times length (per depth): the work that the load case does over
        these states. Over a steady cycle the areas of all load cases add up to the work of
        friction. In increments they fall short of it, by nodes that slip in a part of an increment
        only.
    stiffness
        Secant stiffness: range of the amplitude over that of the displacement; inf where nothing
        moves.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0), compliance=[[0, 0], [0, 0]])
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> loop = steady.loop("force")
    >>> round(loop.area, 9), round(steady.dissipation, 9), round(loop.stiffness, 9)  # the force moves its node by 0.5 either way
    (1.0, 1.0, 2.0)
    """

    case: str
    amplitude: Array
    displacement: Array
    slipping: Integers

    @property
    def area(self) -> float:
        """Area of the loop, see `LoadLoop`."""
        return float((self.amplitude[1:] + self.amplitude[:-1]) / 2 @ np.diff(self.displacement))

    @property
    def stiffness(self) -> float:
        """Secant stiffness, see `LoadLoop`."""
        way = np.ptp(self.displacement)
        return float(np.ptp(self.amplitude) / way) if way > 0 else np.inf

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


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Kept, Plotted):
    """T states of a transient: one after each event of the exact path, or one after each increment.

    Attributes
    ----------
    system, friction, cycle
        The contact, (N,) coefficients of friction, and the load cycle.
    time
        (T,) number of corners visited: -1 at the artificial load that carries the initial slip, 0
        at the mean load, k at the k-th corner, and linear between them. From an earlier state it
        begins at the number of the corner that came next.
    amplitudes
        (T, cases) amplitudes of the load cases, in the order of `system.bonded`; NaN up to the
        first load of the cycle, on the way from the artificial load or from an earlier state.
    bonded_q, bonded_p
        Bonded reactions of the load, (T, N) in the plane and (T, N, 2) in space, and (T, N): force
        per depth in the plane, force in space.
    slip, gap
        Slip v, (T, N) along +x in the plane, (T, N, 2) along the tangents in space, and (T, N) gap
        w, length.
    q, p
        Shear forces in the shape of `slip`, and (T, N) normal forces, compression positive, in the
        units of `bonded_q`.
    status
        (T, N) 0 stick, 2 open; slip: +1 along +x and -1 against it in the plane, 1 in space. Until
        the next event (path), or over the increment that ends here.
    work
        (T, N) work of friction so far, >= 0, force times length (per depth).
    engine
        "path", "newton", "qp" or "milp", see `march`.
    step_error
        0 for the exact path. In increments, the estimated error in time of the slip at the mean
        load and the corners, over the slip scale: what a half and a quarter of the increments
        change (inf where these have no answer, or there are none), or the slip that may be missed
        within the increments, if that is more. Errors of contacts in a plane, whose exact path is
        known, were at most 5 times larger; it is no bound.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> path = fo.march(rod, cycle, friction=0.5, load_factor=1.0, cycles=1)
    >>> path.residual < 1e-9
    True
    >>> path.to_frame().query("node == 0 and time == 2.0")[["slip", "gap", "q", "p"]].round(6)  # at the second corner
        slip  gap    q    p
    28  -0.5  0.0  0.5  1.0
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

    @cached_property
    def _force(self) -> float:
        """Scale of the nodal forces, which that of a steady state is at most: the largest nodal force of the loads, or the mean load's pressure."""
        loads = joined(self.bonded_q, self.bonded_p)
        loads = loads[self.time >= 0] if self.time[-1] >= 0 else loads
        pressure = self.system.reaction(self.cycle.mean)[1]
        return max(float(np.abs(loads).max()), float(np.abs(pressure).mean())) or 1.0

    @cached_property
    def verdict(self) -> Verdict:
        """Violations of the contact law over all states, with slip since the state before; unit of force: largest nodal force of the loads."""
        before, load = (
            np.concatenate([self.slip[:1], self.slip[:-1]]),
            (self.bonded_q, self.bonded_p),
        )
        state = {"v": self.slip, "w": self.gap, "q": self.q, "p": self.p}
        return referee(
            self.system, load, self.friction, **state, previous_slip=before, force_scale=self._force
        )

    @property
    def residual(self) -> float:
        """Largest violation of the contact law over all states and, on the exact path, of the balance of energy, see `energy_error`."""
        return (
            max(self.verdict.residual, self._energy_residual)
            if self.engine == "path"
            else self.verdict.residual
        )

    @property
    def record(self) -> SolveRecord:
        """How the states were found; the solver is the engine."""
        return SolveRecord(self.engine, (), self.residual, (), self._seconds)

    @cached_property
    def _energy_residual(self) -> float:
        """Largest error of the energy balance, or negative work of a node, over the largest: elastic without regard to sign, of friction, unit."""
        unit, u = (
            self._force**2 / self.system.stiffness_scale,
            joined(self.slip, self.gap - self.system.gap),
        )
        elastic = float((np.abs(u @ self.system.S) * np.abs(u)).sum(axis=1).max())
        scale = max(unit, elastic, float(self.work[-1].sum()))
        return float(
            max(np.abs(self.energy_error).max(), -np.diff(self.work, axis=0).min(initial=0.0))
            / scale
        )

    @cached_property
    def energy(self) -> Array:
        """(T,) elastic energy `u S u / 2` of the relative motion `u = [v, w - g0]`, force times length (per depth)."""
        u = joined(self.slip, self.gap - self.system.gap)
        return frozen(((u @ self.system.S) * u).sum(axis=1) / 2)

    @cached_property
    def energy_error(self) -> Array:
        """(T,) work of friction, plus elastic energy gained, plus work against the bonded reactions: rounding on the exact path.

        In increments, between which the loads are not linear, the error depends on their size.
        """
        u, load = joined(self.slip, self.gap), joined(self.bonded_q, self.bonded_p)
        against = ((load[1:] + load[:-1]) / 2 * np.diff(u, axis=0)).sum(axis=1)
        spent = self.work.sum(axis=1) - self.work[0].sum()
        return frozen(
            spent + self.energy - self.energy[0] + np.concatenate([[0.0], np.cumsum(against)])
        )

    @cached_property
    def cycle_work(self) -> Array:
        """(cycles, N) work of friction in each whole cycle."""
        corners = len(self.cycle.corners)
        first = max(0, -(-int(np.ceil(self.time[0])) // corners) * corners)
        ends = (
            np.searchsorted(
                self.time, np.arange(first, self.time[-1] + 0.5, corners) + SIMULTANEOUS
            )
            - 1
        )
        return frozen(np.diff(self.work[ends], axis=0))

    def state_at(self, number: int) -> ContactState:
        """The state of a number (from the end, if negative), for another transient to start from.

        Raises
        ------
        ModelError
            There is no such state, or it stands before the mean load.
        """
        row = whole_number("number", number, least=-len(self.time), most=len(self.time) - 1)
        if self.time[row] < 0:
            raise ModelError(
                f"number: {number}, a state on the way from the artificial load to the mean load; give one of time >= 0, or its slip"
            )
        corner = int(self.time[row] + SIMULTANEOUS) % len(self.cycle.corners)
        load = self.bonded_q[row], self.bonded_p[row]
        return ContactState(
            self.slip[row],
            np.maximum(self.gap[row], 0.0),
            *load,
            corner,
            self.cycle.corner_names[corner],
        )

    def displacement(self, case: str) -> Array:
        """(T,) displacement of a load case, see `ContactSystem.displacements`; NaN where its amplitude is not known.

        Raises
        ------
        ModelError
            An unknown load case, a system without `compliance`.
        """
        return frozen(
            self.system.displacements(self.amplitudes, self.slip, self.gap)[:, self._case(case)]
        )

    def tension(self, case: str) -> Array:
        """(T,) tension of the locked bolt of a load case, force, see `ContactSystem.tension`; NaN where amplitudes are not known.

        Raises
        ------
        ModelError
            A load case of no locked bolt, a system without `compliance`.
        """
        return frozen(self.system.tension(case, self.amplitudes, self.slip, self.gap))

    def loop(self, case: str) -> LoadLoop:
        """The loop of a load case over all states at which its amplitude is known.

        Raises
        ------
        ModelError
            See `displacement`.
        """
        moved, amplitude = self.displacement(case), self.amplitudes[:, self._case(case)]
        known = np.isfinite(amplitude)
        return LoadLoop(
            case,
            amplitude[known],
            moved[known],
            np.count_nonzero(np.abs(self.status) == 1, axis=1)[known],
        )

    def _case(self, case: str) -> int:
        return list(self.system.bonded).index(choice("case", case, self.system.bonded))

    def to_frame(self) -> Table:
        """The DataFrame of all states and nodes: columns state, time, node, contact, x, slip, gap, q, p, status, work; in space y, z, slip1 ..

        Statuses are words: "stick", "slip", "open"; in the plane "slip+" along the tangent and
        "slip-" against it. Contact is there if known.
        """
        states, nodes = self.gap.shape
        state, node = np.repeat(np.arange(states), nodes), np.tile(np.arange(nodes), states)
        named = {name: values[node] for name, values in named_places(self.system).items()}
        columns = {"state": state, "time": self.time[state], "node": node, **named}
        for name in ("slip", "gap", "q", "p"):
            columns |= components(
                name,
                getattr(self, name).reshape(
                    states * nodes, *self.system.slip_shape[1:] if name in ("slip", "q") else ()
                ),
            )
        return frame(
            {**columns, "status": self._words.ravel(), "work": self.work.ravel()},
            units=self.system.units,
        )

    @property
    def _words(self) -> NDArray[np.str_]:
        """(T, N) status in words."""
        words = (
            ("stick", "slip+", "open", "slip-")
            if self.system.tangents == 1
            else ("stick", "slip", "open")
        )
        return np.array(words)[self.status]

    def plot_status(self, ax: Any = None) -> Any:
        """Draw what each node does, stick, slip or open, over place and time; see `plot` for the argument and what may be raised."""
        pictures = self._pictures()
        return pictures.draw(self, ax, pictures.node_status)

    def to_xarray(self) -> xr.Dataset:
        """The states as a Dataset of xarray, which must be installed: slip, gap, q, p, status (in words) and work over state, node and tangent.

        Coordinates are time, the places of the nodes, and the amplitudes of the load cases (case).

        Examples
        --------
        >>> import frictopt as fo
        >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> states = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0).states().to_xarray()
        >>> round(float(states["slip"].sel(node=0).max()), 9)
        0.5
        """
        import xarray as xr  # here, for it need not be installed

        axes = ("state", "node", "tangent")
        data = {
            name: (axes[: getattr(self, name).ndim], getattr(self, name))
            for name in ("slip", "gap", "q", "p", "work")
        }
        data["status"] = (axes[:2], self._words)
        coordinates = {
            "node": np.arange(self.system.nodes),
            "time": ("state", self.time),
            "case": list(self.system.bonded),
        }
        coordinates |= {name: ("node", place) for name, place in places(self.system).items()}
        coordinates["amplitude"] = (("state", "case"), self.amplitudes)
        return xr.Dataset(
            data, coordinates, {} if self.system.units is None else {"units": self.system.units}
        )

    def _answer(self) -> Mapping[str, object]:
        cycles = max(0, int(self.time[-1])) // len(self.cycle.corners)
        error = {} if self.engine == "path" else {"step_error": self.step_error}
        answer = {
            "work": float(self.work[-1].sum()),
            "engine": self.engine,
            "residual": self.residual,
        }
        return {
            "states": len(self.time),
            "nodes": self.system.nodes,
            "cycles": cycles,
            **answer,
            **error,
        }
