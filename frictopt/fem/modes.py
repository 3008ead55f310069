"""Modes of vibration of a model whose contact nodes are glued or open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import block_diag, csr_matrix, diags, identity, kron
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh
from skfem import BilinearForm

from ..base import (
    Array,
    Booleans,
    Integers,
    Plotted,
    Shown,
    Table,
    checked_cases,
    choice,
    finite_array,
    frame,
    frozen,
    number_of,
    whole_number,
)
from ..base.checks import flags, listed_parts
from ..contact import compliances
from ..errors import ModelError, SolverError
from . import schur
from .assembly import Assembly
from .bodies import Body
from .bolts import tied_across
from .condense import eliminated, fronts
from .elasticity import Kinematics, basis_of, circumference
from .load_cases import Load
from .loads import BodyForce, Centrifugal, NodalForces, Pressure, Traction
from .node_forces import PointForce, RemoteForce
from .rigid import Glued

# The numbers of the search for modes.

# Shift of the squares of angular frequencies, relative to (speed of sound / size)^2. The shift lies
# below the first mode of most bodies.
_SHIFT = 1e-3
# A motion is rigid if the square of its angular frequency, divided by the shift, is at most this.
_RIGID = 1e-7
# Number of vectors of the search beyond the number of modes: modes of equal frequency need them.
_MORE_VECTORS = 20

# Kinds of loads that are forces on bodies.
_OF_FORCES = Traction, Pressure, PointForce, RemoteForce, BodyForce, Centrifugal, NodalForces


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Shown, Plotted):
    """Natural frequencies and modes of a model, the lowest first.

    Attributes
    ----------
    frequency
        (n,) natural frequencies, cycles per unit of time; 0 for free rigid motions. The unit of
        time follows from the unit of the densities: the second if they are in tonne/mm^3 beside N
        and mm, or in kg/m^3 beside N and m. The frequencies are then in Hz.
    shapes
        Body name -> (n, d, nodes) displacements, normalised to unit modal mass. A body with a
        `BoltPreload` has the nodes of its section twice.
    modal_mass
        (n,) mass of each mode if its shape is scaled to a largest displacement of 1.
    participation
        (n, d) participation factors, `shape M r` with the translation r along x, y (and z); their
        unit is the square root of mass.
    effective_mass
        (n, d) squares of the participation factors: mass that moves along each axis in a mode. The
        sum over all modes is `mass` minus the mass that supports hold.
    mass
        Mass of the bodies; per depth in the plane.
    open
        (N,) nodes that are open in these modes.
    bodies
        Body name -> body.
    units
        Names of the units of the model; None: not known.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> square = MeshQuad.init_tensor([0.0, 5.0, 10.0], [0.0, 5.0, 10.0])
    >>> lower = square.with_boundaries(
    ...     {"contact": lambda x: x[1] == 10, "bottom": lambda x: x[1] == 0}
    ... )
    >>> upper = square.translated((0.0, 10.0)).with_boundaries(
    ...     {"contact": lambda x: x[1] == 10, "top": lambda x: x[1] == 20}
    ... )
    >>> steel = fo.fem.Material(210e3, 0.3, density=7.85e-9)
    >>> model = fo.fem.ContactModel(
    ...     {"upper": fo.fem.Body(upper, steel), "lower": fo.fem.Body(lower, steel)},
    ...     supports=[fo.fem.Support("lower", "bottom")],
    ...     loads={"P": [fo.fem.Pressure("upper", "top")]},
    ... )
    >>> modes = model.modes(2)  # per second: it bends, it stretches
    >>> modes.frequency.round(-2).tolist(), modes.to_frame().shape
    ([20300.0, 69500.0], (2, 6))

    The compliance under the load of a mode yields the natural frequency of the mode:

    >>> shaken = model.with_loads({"mode": modes.load(0)}).condense()
    >>> frequency = shaken.compliance[1, 1] ** -0.5 / (2 * 3.14159265)
    >>> bool(abs(frequency / modes.frequency[0] - 1) < 1e-6)
    True
    """

    frequency: Array
    shapes: Mapping[str, Array]
    modal_mass: Array
    participation: Array
    effective_mass: Array
    mass: float
    open: Booleans
    bodies: Mapping[str, Body]
    units: str | None
    _masses: Mapping[str, csr_matrix]
    _kinematics: Kinematics

    _shown_names = ("frequency", "mass")

    def load(self, k: int) -> list[NodalForces]:
        """The load case of mode k (0: the lowest) for `with_loads`: the forces `M shape`.

        Amplitude 1 is a unit modal force. The load moves the bodies in this mode alone, and its
        displacement is the modal amplitude.

        Raises
        ------
        ModelError
            There is no such mode.
        """
        mode = self._number(k)
        return [
            NodalForces(name, frozen(shapes[mode] @ self._masses[name]))
            for name, shapes in self.shapes.items()
        ]

    def force(
        self, k: int, loads: Sequence[Load] = (), *, acceleration: ArrayLike | None = None
    ) -> float:
        """The modal force of loads in mode k: `shape F`, in units of force / square root of mass.

        If the modal force is small relative to the load, the load mainly excites other modes.

        Parameters
        ----------
        k
            Number of the mode, 0: the lowest.
        loads
            Tractions, pressures, forces per volume and nodal forces, at amplitude 1.
        acceleration
            (d,) acceleration of all supports along x, y (and z), for a shaken base. Its modal force
            is the sum of the participation factors times its components; the response is then the
            motion relative to the base.

        Raises
        ------
        ModelError
            There is no such mode; neither loads nor an acceleration is given; a load is not a
            force, or its body or boundary is unknown.

        Examples
        --------
        >>> import frictopt as fo
        >>> from skfem import MeshQuad
        >>> mesh = MeshQuad.init_tensor([0.0, 1.0, 2.0], [0.0, 1.0]).with_boundaries(
        ...     {"left": lambda x: x[0] == 0, "middle": lambda x: x[0] == 1}
        ... )
        >>> right = mesh.translated((2.0, 0.0)).with_boundaries(
        ...     {"left": lambda x: x[0] == 2, "end": lambda x: x[0] == 4}
        ... )
        >>> left = mesh.with_boundaries({"right": lambda x: x[0] == 2})
        >>> steel = fo.fem.Material(3.0, 0.0, density=2.0)
        >>> model = fo.fem.ContactModel(
        ...     {"left": fo.fem.Body(left, steel), "right": fo.fem.Body(right, steel)},
        ...     supports=[fo.fem.Support("left", "left")],
        ...     loads={"P": [fo.fem.Pressure("right", "end")]},
        ...     contacts=[fo.fem.Contact("right", "left", "left", "right")],
        ... )
        >>> modes = model.modes(1)
        >>> tip = modes.force(0, [fo.fem.Traction("right", "end", y=1.0)])
        >>> base = modes.force(0, acceleration=[0.0, 9.81])
        >>> bool(abs(base / (9.81 * modes.participation[0, 1]) - 1) < 1e-12), abs(tip) > 0
        (True, True)
        """
        mode = self._number(k)
        forces: tuple[Any, ...] = listed_parts("loads", loads, *_OF_FORCES)
        if not forces and acceleration is None:
            raise ModelError("loads, acceleration: neither is given; give at least one")
        total = 0.0
        if acceleration is not None:
            axes = self.participation.shape[1]
            total += float(
                self.participation[mode] @ finite_array("acceleration", acceleration, (axes,))
            )
        for load in forces:
            body = self.bodies[choice("loads: body", load.body, self.bodies)]
            nodal = load._forces(body, self._kinematics)
            total += float(np.sum(self.shapes[load.body][mode] * nodal))
        return total

    def plot(self, k: int | None = None, ax: Any = None) -> Any:  # type: ignore[override]
        """Draw the shape of mode k with matplotlib (extra `figures`), and return the axes.

        k=None: all modes, each in a panel. The deformed bodies are drawn over their undeformed
        shape, which is grey. `ax` has one axes for each mode; None: a new figure. ImportError
        without matplotlib; ModelError for another number of axes, or if there is no such mode.
        """
        numbers = range(len(self.frequency)) if k is None else [self._number(k)]
        return self._draw(ax, numbers=numbers)

    def _number(self, k: int) -> int:
        return whole_number("k", k, least=0, most=len(self.frequency) - 1)

    def to_frame(self) -> Table:
        """The DataFrame of the modes.

        Columns are frequency, modal_mass, participation_x, .., effective_mass_x, ..
        """
        columns = {"frequency": self.frequency, "modal_mass": self.modal_mass}
        for name in ("participation", "effective_mass"):
            for axis, column in zip("xyz", getattr(self, name).T, strict=False):
                columns[f"{name}_{axis}"] = column
        return frame(columns, self.units)


class Vibrating:
    """Base of models that have modes of vibration."""

    def modes(self: Any, n: int, *, open_nodes: ArrayLike | None = None) -> Modes:
        """The n lowest natural frequencies and modes, with the contacts glued or some nodes open.

        The contact stiffness of the surfaces acts at glued nodes. The mass follows from the
        `density` of each material. Free rigid motions have frequency 0. Both faces of the section
        of a bolt, see `BoltPreload`, move together, so the tension of the bolt changes in a
        vibration. The loads of the model have no effect: not even a spin stiffens the bodies here.
        Axisymmetric models have axisymmetric modes only. A sector (`Cyclic`) has the modes of its
        ring that are the same in all sectors: their number of nodal diameters is zero, or a
        multiple of the number of sectors. Masses refer to one sector. Theory, eq. (34).

        Parameters
        ----------
        n
            Number of modes, smaller than the number of unknowns.
        open_nodes
            (N,) whether each node of the contacts is open, in the order of the condensed system; or
            a result with the attribute `open`, such as a steady state. Nodes that are not open
            stick. None: all stick.

        Raises
        ------
        ModelError
            A body without density, a wrong number of modes, or a value of `open_nodes` that is not
            True or False for each node.
        SolverError
            The search for modes does not converge.
        """
        parts: Assembly = self._assembly
        opened = np.zeros(len(parts.contact), dtype=bool)
        if open_nodes is not None:
            opened = flags("open_nodes", getattr(open_nodes, "open", open_nodes), len(opened))
        return _modes(parts, self._springs, opened, n, self.units)

    def with_loads(self: Any, loads: Mapping[str, Sequence[Load]]) -> Any:
        """The model with more load cases; a load case of the same name is replaced.

        Raises
        ------
        ModelError
            See `ContactModel`.
        """
        added = checked_cases("loads", loads, "list of Traction")
        return replace(self, loads={**self.loads, **added})


def _modes(
    parts: Assembly, springs: tuple[Array, Array], opened: Booleans, n: int, units: str | None
) -> Modes:
    """The lowest modes of an assembly with springs (N,) along and across the surfaces."""
    masses = {name: body_mass(name, body, parts.kinematics) for name, body in parts.bodies.items()}
    d = parts.points.shape[1]
    T, front, held = _motions(parts, springs, opened)
    K = csr_matrix(T.T @ parts.whole @ T + diags(held))
    mass = kron(block_diag([*masses.values()]), identity(d), format="csr")
    M = csr_matrix(T.T @ mass @ T)
    squares, y = _lowest(replace(parts.glued, K=K), M, T, front, _shift(parts), n)

    u = np.asarray(T @ y).T
    # The largest displacement along an axis is positive.
    largest_entry = np.abs(u).argmax(axis=1)[:, None]
    u *= np.sign(np.take_along_axis(u, largest_entry, axis=1))
    shapes = {}
    for name, nodes in parts.own_nodes.items():
        shapes[name] = frozen(u[:, parts.rows[nodes]].swapaxes(1, 2))
    sizes = [np.linalg.norm(shape, axis=1).max(axis=1) for shape in shapes.values()]
    factors = _participation(parts, shapes, masses)
    return Modes(
        frequency=frozen(np.sqrt(squares) / (2 * np.pi)),
        shapes=shapes,
        modal_mass=frozen(np.max(sizes, axis=0) ** -2),
        participation=frozen(factors),
        effective_mass=frozen(factors**2),
        mass=float(sum(mass.sum() for mass in masses.values())),
        open=opened,
        bodies=parts.bodies,
        units=units,
        _masses=masses,
        _kinematics=parts.kinematics,
    )


def _participation(
    parts: Assembly, shapes: Mapping[str, Array], masses: Mapping[str, csr_matrix]
) -> Array:
    """(n, d) participation factors of shapes, see `Modes`."""
    factors = np.asarray(
        sum(shape @ np.asarray(masses[name].sum(axis=0)).ravel() for name, shape in shapes.items())
    )
    if parts.kinematics == "axisymmetric":
        # A motion along the radius is no translation.
        return factors * [0.0, 1.0]
    if parts.sector.count > 1:
        # A translation across the axis has another direction in each sector, so it does not count.
        return factors @ np.outer(parts.sector.along, parts.sector.along)
    return factors


def body_mass(name: str, body: Body, kinematics: Kinematics) -> csr_matrix:
    """(nodes, nodes) consistent mass of a body, the same along each axis.

    It is per depth in the plane, and of the whole circumference if axisymmetric.
    """
    if body.material.density is None:
        raise ModelError(
            f"material: body {name!r} has no density, and modes need the density of every body; "
            "give "
            "Material(..., density=), mass per volume, such as 7.85e-9 tonne/mm^3 beside N, mm and "
            "s"
        )
    form = BilinearForm(lambda u, v, w: circumference(w.x[0], kinematics) * u * v)
    return csr_matrix(body.material.density * form.assemble(basis_of(body.mesh)))


def _motions(
    parts: Assembly, springs: tuple[Array, Array], opened: Booleans
) -> tuple[csr_matrix, Integers, Array]:
    """The matrix T of `u = T y`, the front of each unknown y, and the stiffness of its spring."""
    d = parts.points.shape[1]
    T, front = fronts(parts.glued)
    compliance = compliances(*springs, parts.width, d - 1)
    compliance = np.where(np.tile(opened, d), np.inf, compliance)
    # Relative motions, in front -1, are free at open nodes and on springs, and zero elsewhere.
    with_spring = compliance > 0
    free = np.flatnonzero(front < 0)[with_spring]
    stiff = np.zeros(len(front))
    stiff[free] = 1 / compliance[with_spring]
    front[free] = front.max() + 1
    moves = (front >= 0) & (np.diff(T.tocsc().indptr) > 0)
    bolts = tied_across(parts.rows, parts.cuts)
    return csr_matrix(parts.tied @ bolts @ T[:, moves]), front[moves], stiff[moves]


def _shift(parts: Assembly) -> float:
    """Shift of the squares of angular frequencies, which makes the matrix invertible."""
    size = float(np.linalg.norm(np.ptp(parts.points, axis=0)))
    materials = [body.material for body in parts.bodies.values()]
    speeds = [
        material.E / material.density for material in materials if material.density is not None
    ]
    return _SHIFT / size**2 * min(speeds)


def _lowest(
    glued: Glued, M: csr_matrix, T: csr_matrix, front: Integers, shift: float, n: int
) -> tuple[Array, Array]:
    """Squares (n,) of angular frequencies, the lowest first, and modes (unknowns, n).

    The stiffness is `glued.K`, and the mass is M. Modes have unit modal mass.
    """
    size = whole_number("n", n, least=1, most=len(front) - 1)
    _, factors = eliminated(glued, csr_matrix(glued.K + shift * M), T, front, keep=float)

    def solve(force: Array) -> Array:
        return schur.solve(factors, np.reshape(force, (-1, 1))).ravel()

    inverse = LinearOperator(M.shape, matvec=solve, dtype=np.float64)
    vectors = min(2 * size + _MORE_VECTORS, len(front))
    start = np.random.default_rng(0).normal(size=len(front))
    try:
        squares, y = eigsh(glued.K, size, M, sigma=-shift, OPinv=inverse, ncv=vectors, v0=start)
    except ArpackNoConvergence as error:
        raise SolverError(
            f"modes: the search for {number_of(n, 'mode')} found {len(error.eigenvalues)}; "
            "request fewer modes"
        ) from error
    order = np.argsort(squares)
    squares = squares[order]
    y = y[:, order]
    modal_mass = np.sum(y * (M @ y), axis=0)
    return np.where(squares > _RIGID * shift, squares, 0.0), y / np.sqrt(modal_mass)
