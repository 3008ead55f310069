"""The states of a transient."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..contact import ContactState, ContactSystem, LoadCycle, Plotted, Shown, SolveRecord, Table, Verdict, components, frame, joined, places, referee
from ..contact.checks import Array, choice, frozen, whole_number
from ..contact.tolerances import SIMULTANEOUS
from ..errors import ModelError
from .loop import LoadLoop

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Shown, Plotted):
    """T states of a transient: one after each event of the exact path, or one after each increment.

    Attributes
    ----------
    system
        The contact.
    friction
        (N,) coefficients of friction.
    cycle
        The load cycle.
    time
        (T,) number of corners visited: -1 at the artificial load that carries the initial slip, 0 at the mean load, k at the k-th corner, and
        linear between them. From an earlier state it begins at the number of the corner that came next.
    amplitudes
        (T, cases) amplitudes of the load cases, in the order of `system.bonded`; NaN up to the first load of the cycle, on the way from the
        artificial load or from an earlier state.
    bonded_q, bonded_p
        Bonded reactions of the load, (T, N) in the plane and (T, N, 2) in space, and (T, N): force per depth in the plane, force in space.
    slip, gap
        Slip v, (T, N) along +x in the plane, (T, N, 2) along the tangents in space, and (T, N) gap w, length.
    q, p
        Shear forces in the shape of `slip`, and (T, N) normal forces, compression positive, in the units of `bonded_q`.
    status
        (T, N) 0 stick, 2 open; slip: +1 along +x and -1 against it in the plane, 1 in space. Until the next event (path), or over the increment that
        ends here.
    work
        (T, N) work of friction so far, >= 0, force times length (per depth).
    engine
        What computed the states: "path", "newton", "qp" or "milp".
    step_error
        0 for the exact path. In increments, the estimated error in time of the slip at the mean load and the corners, over the slip scale: the
        largest of the differences from what a half and a quarter of the increments give (inf where these have no answer, or there are none), and of
        the slip that may be missed within the increments at whose ends alone the law is obeyed. Errors of contacts in a plane, whose exact path is
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
        """Scale of the nodal forces: the largest mean pressure of the loads."""
        loaded = self.bonded_p[self.time >= 0] if self.time[-1] >= 0 else self.bonded_p
        return float(np.abs(loaded).mean(axis=1).max()) or 1.0

    @cached_property
    def verdict(self) -> Verdict:
        """Violations of the contact law over all states, with slip since the state before; unit of force: largest mean pressure of the loads."""
        return referee(
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
        """Largest violation of the contact law over all states and, on the exact path, of the balance of energy.

        In increments the balance of energy has an error that depends on their size, see `energy_error`.
        """
        return max(self.verdict.residual, self.energy_residual) if self.engine == "path" else self.verdict.residual

    @property
    def record(self) -> SolveRecord:
        """How the states were found; the solver is the engine."""
        return SolveRecord(self.engine, (), self.residual, (), self._seconds)

    @cached_property
    def energy_residual(self) -> float:
        """Largest error of the energy balance, or negative work of friction at a node, over the largest energy of the transient.

        The largest energy is that of the elastic energies, the work of friction, and the force scale times the slip scale.
        """
        unit = self._force**2 / self.system.stiffness_scale
        scale = max(unit, float(self.energy.max()), float(self.work[-1].sum()))
        return float(max(np.abs(self.energy_error).max(), -np.diff(self.work, axis=0).min(initial=0.0)) / scale)

    @cached_property
    def energy(self) -> Array:
        """(T,) elastic energy `u S u / 2` of the relative motion `u = [v, w - g0]`, force times length (per depth)."""
        u = joined(self.slip, self.gap - self.system.gap)
        return frozen(((u @ self.system.S) * u).sum(axis=1) / 2)

    @cached_property
    def energy_error(self) -> Array:
        """(T,) error of the energy balance: work of friction, plus elastic energy gained, plus work against the bonded reactions.

        The loads are assumed linear between states. On the exact path this holds, and the error is rounding.
        """
        u, load = joined(self.slip, self.gap), joined(self.bonded_q, self.bonded_p)
        against = ((load[1:] + load[:-1]) / 2 * np.diff(u, axis=0)).sum(axis=1)
        spent = self.work.sum(axis=1) - self.work[0].sum()
        return frozen(spent + self.energy - self.energy[0] + np.concatenate([[0.0], np.cumsum(against)]))

    @cached_property
    def cycle_work(self) -> Array:
        """(cycles, N) work of friction in each whole cycle."""
        corners = len(self.cycle.corners)
        first = max(0, -(-int(np.ceil(self.time[0])) // corners) * corners)
        ends = np.searchsorted(self.time, np.arange(first, self.time[-1] + 0.5, corners) + SIMULTANEOUS) - 1
        return frozen(np.diff(self.work[ends], axis=0))

    def state_at(self, number: int) -> ContactState:
        """The state of a number (from the end, if negative), for another transient to start from: at the mean load or after it.

        Raises
        ------
        ModelError
            There is no such state, or it stands on the way from the artificial load to the mean load.
        """
        row = whole_number("number", number, least=-len(self.time), most=len(self.time) - 1)
        if self.time[row] < 0:
            raise ModelError(f"number: {number}, a state on the way from the artificial load to the mean load; give one of time >= 0, or its slip")
        corner = int(self.time[row] + SIMULTANEOUS) % len(self.cycle.corners)
        load = self.bonded_q[row], self.bonded_p[row]
        return ContactState(self.slip[row], np.maximum(self.gap[row], 0.0), *load, corner, self.cycle.corner_names[corner])

    def displacement(self, case: str) -> Array:
        """(T,) displacement of a load case, see `ContactSystem.displacements`; NaN where its amplitude is not known.

        Raises
        ------
        ModelError
            An unknown load case, a system without `compliance`.
        """
        return frozen(self.system.displacements(self.amplitudes, self.slip, self.gap)[:, self._case(case)])

    def loop(self, case: str) -> LoadLoop:
        """The loop of a load case over all states at which its amplitude is known, as one that can be drawn (`plot`).

        Raises
        ------
        ModelError
            See `displacement`.
        """
        amplitude = self.amplitudes[:, self._case(case)]
        known = np.isfinite(amplitude)
        slipping = np.count_nonzero(np.abs(self.status) == 1, axis=1)
        return LoadLoop(case, amplitude[known], self.displacement(case)[known], slipping[known])

    def _case(self, case: str) -> int:
        """The place of a load case among those of the system."""
        return list(self.system.bonded).index(choice("case", case, self.system.bonded))

    def to_frame(self) -> Table:
        """The DataFrame of all states and nodes: columns state, time, node, x, slip, gap, q, p, status, work; in space y, z, slip1 ..

        The status is a word: "stick", "slip", "open"; in the plane "slip+" along the tangent and "slip-" against it.
        """
        states, nodes = self.gap.shape
        state, node = np.repeat(np.arange(states), nodes), np.tile(np.arange(nodes), states)
        columns = {"state": state, "time": self.time[state], "node": node} | {name: place[node] for name, place in places(self.system).items()}
        for name in ("slip", "gap", "q", "p"):
            columns |= components(name, getattr(self, name).reshape(states * nodes, *self.system.slip_shape[1:] if name in ("slip", "q") else ()))
        return frame({**columns, "status": self._words.ravel(), "work": self.work.ravel()}, units=self.system.units)

    @property
    def _words(self) -> NDArray[np.str_]:
        """(T, N) status in words."""
        words = ("stick", "slip+", "open", "slip-") if self.system.tangents == 1 else ("stick", "slip", "open")
        return np.array(words)[self.status]

    def plot_status(self, ax: Any = None) -> Any:
        """Draw what each node does, stick, slip or open, over place and time; see `plot` for the argument and what may be raised."""
        return import_module("frictopt.plots").draw(self, ax, "status")

    def to_xarray(self) -> "xr.Dataset":
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

        vectors = ("state", "node") if self.system.tangents == 1 else ("state", "node", "tangent")
        data = {name: (vectors, getattr(self, name)) for name in ("slip", "q")}
        data |= {name: (("state", "node"), getattr(self, name)) for name in ("gap", "p", "work")}
        data["status"] = (("state", "node"), self._words)
        coordinates = {"node": np.arange(self.system.nodes), "time": ("state", self.time), "case": list(self.system.bonded)}
        coordinates |= {name: ("node", place) for name, place in places(self.system).items()}
        coordinates["amplitude"] = (("state", "case"), self.amplitudes)
        return xr.Dataset(data, coordinates, {} if self.system.units is None else {"units": self.system.units})

    def _answer(self) -> Mapping[str, object]:
        cycles = max(0, int(self.time[-1])) // len(self.cycle.corners)
        size = {"states": len(self.time), "nodes": self.system.nodes, "cycles": cycles}
        error = {} if self.engine == "path" else {"step_error": self.step_error}
        return {**size, "work": float(self.work[-1].sum()), "engine": self.engine, "residual": self.residual, **error}
