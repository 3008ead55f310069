"""The fatigue band: a fatigue parameter over all states of rest of a contact."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    RESIDUAL,
    Array,
    Outcome,
    PerNode,
    Plotted,
    Recorded,
    SolveRecord,
    Table,
    choice,
    finite_array,
    finite_number,
    frame,
    frozen,
    progress_bar,
    shown,
    warns_of_odd_values,
    whole_number,
    worst,
)
from ..contact import ContactSystem, LoadCycle, StressMap, joined
from ..errors import ModelError
from ..transients.critical_plane import PARAMETERS, SEARCHED, WITHOUT_PLANE
from .answers import sentences
from .moving.moving_areas import uncoupled
from .program.question import Question, pose
from .program.rest_program import is_held
from .program.rest_slips import Rests, SteadyCycles
from .safe_slip import safe_slip_of_question
from .search.stress_levels import DRAWN, End, Stresses, StressLevels, tensors_at_rest
from .shakedown import limit_of_question

Parameter: TypeAlias = Literal["SWT", "Findley", "Fatemi_Socie", "Matake", "Crossland", "Dang_Van"]


@dataclass(frozen=True, eq=False, repr=False)
class FatigueBand(Recorded, Plotted):
    """A fatigue parameter over all states of rest at a load factor, at the points of a stress map.

    The larger the parameter, the shorter the life. So `least` belongs to the longest life that
    assembly can leave, and `most` to the shortest.

    Attributes
    ----------
    parameter, weight, load_factor
        As given.
    least, bound, least_slip
        The least value, over all states of rest, of the largest value over the points; its lower
        bound, which multipliers prove; and the slip (N,) or (N, 2) of the state of rest with this
        value, length. `least` is -inf if there is no least value.
    most, worst_slip
        The largest value of a point that the search finds over all states of rest, and the slip of
        the state of rest in which it occurs. `most` is inf if friction wedges: residual slips may
        then press the contact without end. With points on the face, `most` grows with each
        refinement of the mesh.
    proven
        Whether no state of rest exceeds `most`: True for Crossland, Dang Van and Matake. For the
        other parameters `most` comes from a search over planes.
    record
        Its `residual` is the larger violation of the contact law by the two slips.

    Examples
    --------
    >>> import frictopt as fo
    >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    >>> stresses = model.stress_map(depth=0.3, side=2)
    >>> band = fo.fatigue_band(stresses, cycle, 0.7, load_factor=0.5)
    >>> bool(band.bound <= band.least < band.most)
    True
    >>> bool(abs(band.at(band.worst_slip).max() - band.most) < 1e-9 * band.most)
    True
    """

    _shown_names = ("parameter", "load_factor", "least", "most", "proven", "residual", "reason")
    parameter: str
    weight: float
    load_factor: float
    least: float
    bound: float
    least_slip: Array = field(repr=False)
    most: float
    worst_slip: Array = field(repr=False)
    proven: bool
    record: SolveRecord
    stress_map: StressMap = field(repr=False)
    _slips: Rests | SteadyCycles
    _tensors: Array  # (K, 2, P, 3, 3) stress and strain with the slip `_start`
    _start: Array
    _table: Table

    @property
    def system(self) -> ContactSystem:
        """The contact."""
        return self.stress_map.system

    @property
    def cycle(self) -> LoadCycle:
        """The load cycle."""
        return self._slips.question.cycle

    @property
    def friction(self) -> Array:
        """(N,) coefficients of friction."""
        return self._slips.question.friction

    @property
    def reason(self) -> str:
        """The band in words, and what it does not cover."""
        which = sentences.BAND_OF_RESTS
        if isinstance(self._slips, SteadyCycles):
            unique = _differ_by_constants(self._slips.question)
            which = sentences.BAND_OF_CYCLES if unique else sentences.BAND_OF_FAMILY
        text = which.format(
            node_states=self._slips.question.node_states,
            parameter=self.parameter,
            least=self.least,
            most=self.most,
        )
        if np.isinf(self.most):
            text += sentences.WEDGES
        elif self.stress_map.on_face:
            text += sentences.GROWS_WITH_MESH
        if which is sentences.BAND_OF_RESTS:
            text += sentences.OTHER_STARTS
        return text

    def at(self, slip: ArrayLike) -> Array:
        """(P,) the parameter at the points in the state of rest with a slip (N,) or (N, 2).

        Above the shakedown limit it is the parameter in the steady cycle that has this slip at its
        last corner.

        Raises
        ------
        ModelError
            The contact does not rest with this slip, or the slip has another shape.
        """
        slip = finite_array("slip", slip, self.system.slip_shape)
        off = self._slips.violation(slip - self._start)
        if not off <= 10 * RESIDUAL:
            raise ModelError(
                f"slip: it violates the contact law by {off:.1e} at load factor "
                f"{self.load_factor:g}, so that the contact does not rest with it; give a slip "
                "that `safe_slip` or a transient has left"
            )
        stresses = Stresses(
            self._slips.question, self.stress_map, self._tensors, self.parameter, self.weight
        )
        return frozen(stresses.values(slip - self._start))

    def life(self, k_1: float, ND: float, SD: float, *, slip: ArrayLike | None = None) -> Table:
        """Cycles to failure at the points, by Basquin's line `ND * (value / SD) ** -k_1`.

        Parameters
        ----------
        k_1, ND, SD
            Exponent k_1, and the number ND of cycles at the value SD of the parameter; all > 0.
            pyLife has the same names.
        slip
            Slip of the state of rest that assembly leaves, such as `SteadyState.slip`. None: zero.

        Returns
        -------
        pandas.DataFrame
            A row for each point: point; x, y, in space z; and three numbers of cycles: best, in the
            state of rest whose largest value is the least; assembled, with the given slip, or NaN
            if none is given and the contact does not rest with zero slip; worst, in the worst state
            of rest of this point. The least of a column is the life of the contact. `report` takes
            this table.

        Raises
        ------
        ModelError
            A number that is not above 0; a slip with which the contact does not rest.
        """
        numbers = {"k_1": k_1, "ND": ND, "SD": SD}
        k_1, ND, SD = (finite_number(name, number, above=0.0) for name, number in numbers.items())
        # If pressure lowers the values without end, nothing fails in the best state.
        best = self.at(self.least_slip) if np.isfinite(self.least) else 0.0
        left = self._table["no_slip"] if slip is None else self.at(slip)
        values = {"best": best, "assembled": left, "worst": self._table["most"]}
        table = self._table.filter(["point", *"xyz"])
        with np.errstate(divide="ignore"):
            cycles = {
                name: ND * (np.maximum(value, 0.0) / SD) ** -k_1 for name, value in values.items()
            }
        return table.assign(**cycles)

    def check_kept(self) -> None:
        """Check that the slips of a band from a file have its values; ValueError if not."""
        ends = [(self.least, self.least_slip), (self.most, self.worst_slip)]
        for value, slip in ends:
            if not np.isfinite(value):
                continue
            try:
                found = float(self.at(slip).max())
            except ModelError as error:
                raise ValueError(str(error)) from error
            if not abs(found - value) <= 10 * RESIDUAL * max(abs(value), 1.0):
                raise ValueError(f"its slip has the value {found:g}, not {value:g}")

    def to_frame(self) -> Table:
        """A row for each point.

        Columns:

        - point; x, y, in space z: its place;
        - least: the least value of this point over all states of rest. Different points may have
          it in different states;
        - no_slip: the value without residual slip, NaN if the contact does not rest with it;
        - most: the largest value over all states of rest;
        - normal_x, normal_y, normal_z and corner, if the parameter belongs to a plane: the normal
          of the plane of `most`, and the corner (in a band of steady cycles, the state of the
          cycle) at which the normal stress on this plane is largest, which is the same in all
          states of rest;
        - from_least, to_least, from_most, to_most: on this plane the least and the largest normal
          stress of the cycle, in the states of rest with the least and with the largest mean
          stress. pyLife reads `from` and `to` of a load collective.
        """
        return self._table.copy()


@warns_of_odd_values
def fatigue_band(
    stress_map: StressMap,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    parameter: Parameter = "SWT",
    *,
    weight: float = 0.3,
    slip_bound: PerNode | None = None,
    initial_slip: ArrayLike | None = None,
    planes: int = 36,
    progress: bool = True,
) -> FatigueBand:
    """The least and the largest value of a fatigue parameter over all states of rest.

    Theory, eq. (37).

    Above the shakedown limit there are no states of rest. If slip changes no pressure (B = 0), all
    steady cycles differ by a slip that does not change in time, and the band is about all steady
    cycles. Below the limit, too, the band is about all steady cycles if normal loads open and close
    nodes in each cycle.

    Parameters
    ----------
    stress_map
        The contact with the stresses at its points, from `ContactModel.stress_map`. At a depth the
        band converges with the mesh, if the load factor stays below the shakedown limits of the
        finer meshes; on the face its largest value grows with each refinement.
    cycle, friction, slip_bound
        See `shakedown_limit`. The slip bound must be None above the limit.
    load_factor
        Load factor, >= 0.
    parameter
        "SWT", "Findley", "Fatemi_Socie", "Matake", "Crossland" or "Dang_Van": the values of the
        columns of `SteadyState.fretting_table`. Matake is Findley's sum on the plane of the largest
        shear amplitude. Dang Van is the largest sum of two stresses: Tresca's shear stress about
        the centre of the smallest ball around the deviators, and the weighted hydrostatic stress.
    weight
        Weight of the largest normal stress, or of the hydrostatic stress (Crossland, Dang Van). Its
        unit is 1 / stress for Fatemi and Socie. SWT has no weight.
    initial_slip
        Slip (N,) or (N, 2) of the start of a transient, length, see `steady_state`. None: the band
        of the states of rest.
    planes
        Number of planes at which the search for the largest value begins; in plane models they are
        at equal angles.
    progress
        Whether to show a progress bar after two seconds.

    Returns
    -------
    FatigueBand
        Both ends with their slips, and a table of the points.

    Raises
    ------
    ModelError
        Bad input. No state of rest at this load factor and no `initial_slip`, unless B = 0 and
        supports hold the bodies. A transient that slips on without end.
    SolverError
        No solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    >>> stresses = model.stress_map(depth=0.3, side=2)
    >>> band = fo.fatigue_band(stresses, cycle, 0.7, 0.5, "Crossland")
    >>> bool(band.least < band.most), band.proven
    (True, True)
    """
    question, weight = posed(stress_map, cycle, friction, parameter, weight, planes, slip_bound)
    count = stress_map.count
    with progress_bar(progress, "fatigue band", "point", total=count) as bar:
        slips, tensors, start = _set_of(question, stress_map, load_factor, initial_slip)
        stresses = Stresses(slips.question, stress_map, tensors, parameter, weight)
        levels = StressLevels(slips, stresses, planes)
        least = levels.least(range(count))
        without = np.full(count, np.nan)
        if slips.violation(-start) <= RESIDUAL:
            without = stresses.values(-start)
        ends = []
        rows = []
        for point, place in enumerate(np.asarray(stress_map.points)):
            ends.append(levels.most(point))
            at = {"point": point, **dict(zip("xyz", place, strict=False))}
            rows.append(at | _row(levels, point, ends[-1], without[point], parameter))
            bar.update()
    most = max(ends, key=lambda end: end.value)
    found = [end.slip for end in (least, most) if np.isfinite(end.value)]
    violations = [slips.violation(slip) for slip in found] + [0.0]
    return FatigueBand(
        parameter=parameter,
        weight=weight,
        load_factor=float(load_factor),
        least=least.value,
        bound=least.bound,
        least_slip=least.slip + start,
        most=most.value,
        worst_slip=most.slip + start,
        proven=parameter not in SEARCHED,
        record=SolveRecord(residual=worst(violations), seconds=perf_counter() - question.started),
        stress_map=stress_map,
        _slips=slips,
        _tensors=tensors,
        _start=start,
        _table=frame(rows, units=stress_map.system.units),
    )


def posed(
    stress_map: StressMap,
    cycle: LoadCycle,
    friction: PerNode,
    parameter: str,
    weight: float,
    planes: int,
    slip_bound: PerNode | None,
) -> tuple[Question, float]:
    """The question about the contact of a stress map, and the weight; ModelError for bad input."""
    if not isinstance(stress_map, StressMap):
        raise ModelError(
            f"stress_map: {shown(stress_map)}; give the StressMap of "
            "`ContactModel.stress_map(depth=...)`"
        )
    choice("parameter", parameter, PARAMETERS)
    whole_number("planes", planes, least=6)
    question = pose(stress_map.system, cycle, friction, slip_bound=slip_bound)
    return question, finite_number("weight", weight, least=0.0)


def _row(
    levels: StressLevels, point: int, end: End, no_slip: float, parameter: str
) -> dict[str, float]:
    """The columns of a point in the table of a band, see `FatigueBand.to_frame`."""
    least = levels.least([point], DRAWN).value
    row = {"least": least, "no_slip": no_slip, "most": end.value}
    if parameter in WITHOUT_PLANE:
        return row
    x, y, z = end.normal.tolist()
    return row | {"normal_x": x, "normal_y": y, "normal_z": z} | levels.on_plane(point, end.normal)


def _set_of(
    question: Question, stress_map: StressMap, load_factor: float, initial_slip: ArrayLike | None
) -> tuple[Rests | SteadyCycles, Array, Array]:
    """The set of slips; stress and strain (K, 2, P, 3, 3) with one slip of it; and this slip."""
    system, cycle = question.system, question.cycle
    if initial_slip is None:
        safe = safe_slip_of_question(question, load_factor)
        if safe.exists and not safe._question.moves:
            tensors = tensors_at_rest(safe._question, stress_map, load_factor)
            return Rests(safe._question, load_factor), tensors, np.zeros(system.slip_shape)
        if question.slip_bound is not None or not _differ_by_constants(question):
            limit = limit_of_question(question, None, False)
            raise ModelError(
                f"load_factor: {load_factor:g} has no state of rest: the shakedown limit is "
                f"{limit.load_factor:.6g}; reduce the load factor, or without a slip bound give an "
                "`initial_slip`, such as the `worst_start` of `dissipation_range`"
            )
    elif question.slip_bound is not None:
        raise ModelError("initial_slip: not with a slip_bound; give one of them")
    # Imported here, because it needs numba, and no other limit does.
    from ..transients.steady import steady_state

    steady = steady_state(system, cycle, question.friction, load_factor, initial_slip=initial_slip)
    if steady.outcome is Outcome.RATCHETING:
        raise ModelError(
            f"load_factor: at {load_factor:g} the contact slips on in every cycle; reduce it, or "
            "give another initial_slip"
        )
    states = steady.states()
    of_states = [
        stress_map.at(
            dict(zip(system.bonded, amplitudes, strict=True)), joined(slip, gap - system.gap)
        )
        for amplitudes, slip, gap in zip(states.amplitudes, states.slip, states.gap, strict=True)
    ]
    moved = steady.slipping | (states.gap > 0).any(axis=0)
    return SteadyCycles(question, states.q, states.p, moved), np.array(of_states), steady.slip


def _differ_by_constants(question: Question) -> bool:
    """Whether all steady cycles at a load factor differ by a slip that is constant in time."""
    return uncoupled(question) and is_held(question)
