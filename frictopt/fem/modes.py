"""Modes of vibration of a model, whose contacts are glued or open at some nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import block_diag, csr_matrix, diags
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
    frame,
    frozen,
    whole_number,
)
from ..base.checks import flags
from ..contact import compliances
from ..errors import ModelError, SolverError
from . import schur
from .assembly import Assembly, Load
from .bodies import Body
from .bolts import tied_across
from .condense import Glued, eliminated, fronts
from .elasticity import Kinematics, basis_of, circumference
from .loads import NodalForces

# of the stiffness towards that of bodies without rigid motions, over (speed of sound / size)^2:
# below the first mode of most bodies
_SHIFT = 1e-3
_RIGID = 1e-7  # over the shift: the squares of frequencies up to which a motion has none
_MORE = (
    20  # vectors of the search beyond those of the modes: modes of one frequency are found together
)


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Shown, Plotted):
    """Natural frequencies and modes of a model, the lowest first.

    Attributes
    ----------
    frequency
        (n,) natural frequencies, cycles per unit of time; 0 of rigid motions that nothing prevents.
    shapes
        Body name -> (n, d, nodes) displacements, normalised to unit modal mass. A body with a
        `BoltPreload` has the nodes of its section twice.
    modal_mass
        (n,) mass of each mode where its largest displacement is the amplitude.
    participation
        (n, d) participation factors, `shape M r` with the translation r along x, y (and z): square
        root of mass.
    effective_mass
        (n, d) their squares: mass that moves along each axis in a mode. Over all modes they sum up
        to `mass`, less what supports hold.
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
    >>> square, steel = MeshQuad.init_tensor([0.0, 5.0, 10.0], [0.0, 5.0, 10.0]), fo.Material(210e3, 0.3, density=7.85e-9)
    >>> lower = square.with_boundaries({"contact": lambda x: x[1] == 10, "bottom": lambda x: x[1] == 0})
    >>> upper = square.translated((0.0, 10.0)).with_boundaries({"contact": lambda x: x[1] == 10, "top": lambda x: x[1] == 20})
    >>> model = fo.ContactModel(
    ...     {"upper": fo.Body(upper, steel), "lower": fo.Body(lower, steel)},
    ...     supports=[fo.Support("lower", "bottom")],
    ...     loads={"P": [fo.Pressure("upper", "top")]},
    ... )
    >>> modes = model.modes(2)
    >>> modes.frequency.round(-2).tolist(), modes.to_frame().shape  # per second: it bends, it stretches
    ([20300.0, 69500.0], (2, 6))
    >>> shaken = model.with_loads({"mode": modes.load(0)}).condense()  # `modes.frequency[0]` is the natural frequency of its curve
    >>> bool(abs(shaken.compliance[1, 1] ** -0.5 / 6.2831853 / modes.frequency[0] - 1) < 1e-6)
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

    _said = ("frequency", "mass")

    def load(self, k: int) -> list[NodalForces]:
        """The load case of mode k (0: the lowest), forces `M shape`: of amplitude 1 it is that of a unit modal force; for `with_loads`.

        It moves the bodies in this mode alone, and its displacement is the modal amplitude, as with
        the function `modal_load`.

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

    def plot(self, ax: Any = None, *, k: int = 0) -> Any:
        """Draw the shape of mode k with matplotlib (extra `figures`), in one axes `ax` or None for a new figure; returns the axes.

        ImportError without matplotlib; ModelError for another number of axes, or no such mode.
        """
        pictures = self._pictures()
        return pictures.draw(self, ax, pictures.mode, number=self._number(k))

    def _number(self, k: int) -> int:
        return whole_number("k", k, least=0, most=len(self.frequency) - 1)

    def to_frame(self) -> Table:
        """The DataFrame of the modes: columns frequency, modal_mass, participation_x, .., effective_mass_x, .."""
        columns = {"frequency": self.frequency, "modal_mass": self.modal_mass}
        for name in ("participation", "effective_mass"):
            columns |= {
                f"{name}_{axis}": column
                for axis, column in zip("xyz", getattr(self, name).T, strict=False)
            }
        return frame(columns, self.units)


class Vibrating:
    """Base of models that have modes of vibration."""

    def modes(self: Any, n: int, *, open: ArrayLike | None = None) -> Modes:
        """The n lowest natural frequencies and modes, with the contacts glued apart from the surfaces' own stiffness, or with some nodes open.

        The mass follows from the `density` of each material. What nothing holds has rigid motions
        of frequency 0. A bolt takes up what a vibration adds to its tension: both faces of its
        section, see `BoltPreload`, move together. Loads count for nothing: they do not stiffen the
        bodies, as the pull of a spin does. Axisymmetric models have axisymmetric modes alone. A
        sector (`Cyclic`) has those of its ring that are the same in all sectors: without nodal
        diameters, or with a multiple of the number of sectors. Its masses are those of one sector.
        Theory, eq. (34).

        Parameters
        ----------
        n
            Number of modes, less than that of the unknowns.
        open
            (N,) whether each node of the contacts is open, in the order of the condensed system; or
            a result that has it, such as a steady state: its open nodes are open, its closed ones
            stick. None: all stick.

        Raises
        ------
        ModelError
            A body without density, no number of modes, other than True or False for each node.
        SolverError
            The search for modes does not converge.
        """
        parts: Assembly = self._parts
        nodes = len(parts.contact)
        opened = (
            np.zeros(nodes, dtype=bool)
            if open is None
            else flags("open", getattr(open, "open", open), nodes)
        )
        return _found(parts, self._springs, opened, n, self.units)

    def with_loads(self: Any, loads: Mapping[str, Sequence[Load]]) -> Any:
        """The model with more load cases, or with others of the same name.

        Raises
        ------
        ModelError
            See `ContactModel`.
        """
        return replace(
            self, loads={**self.loads, **checked_cases("loads", loads, "list of Traction")}
        )


def _found(
    parts: Assembly, springs: tuple[Array, Array], opened: Booleans, n: int, units: str | None
) -> Modes:
    """The lowest modes of an assembly with springs (N,) along and across the surfaces, and open nodes (N,)."""
    masses = {name: body_mass(name, body, parts.kinematics) for name, body in parts.bodies.items()}
    T, front, D = _motions(parts, springs, opened)
    K = csr_matrix(T.T @ parts.whole @ T + diags(D))
    M = csr_matrix(
        T.T
        @ block_diag(
            [mass for mass in masses.values() for _ in range(parts.points.shape[1])], format="csr"
        )
        @ T
    )
    squares, y = _lowest(replace(parts.glued, K=K), M, T, front, _shift(parts), n)
    u = np.asarray(T @ y).T
    u *= np.sign(
        np.take_along_axis(u, np.abs(u).argmax(axis=1)[:, None], axis=1)
    )  # the largest displacement along an axis is positive
    at = {
        name: parts.rows[first : first + parts.bodies[name].mesh.p.shape[1]]
        for name, first in parts.first_node.items()
    }
    shapes = {name: frozen(u[:, rows].swapaxes(1, 2)) for name, rows in at.items()}
    largest = np.max([np.linalg.norm(own, axis=1).max(axis=1) for own in shapes.values()], axis=0)
    factors = sum(
        own @ np.asarray(masses[name].sum(axis=0)).ravel() for name, own in shapes.items()
    )
    if parts.kinematics == "axisymmetric":
        factors = factors * [0.0, 1.0]  # no motion along the radius is a translation
    elif parts.sector.count > 1:
        factors = factors @ np.outer(
            parts.sector.along, parts.sector.along
        )  # nor is one that turns from sector to sector
    return Modes(
        frequency=frozen(np.sqrt(squares) / (2 * np.pi)),
        shapes=shapes,
        modal_mass=frozen(largest**-2),
        participation=frozen(factors),
        effective_mass=frozen(factors**2),
        mass=float(sum(mass.sum() for mass in masses.values())),
        open=opened,
        bodies=parts.bodies,
        units=units,
        _masses=masses,
    )


def body_mass(name: str, body: Body, kinematics: Kinematics) -> csr_matrix:
    """(nodes, nodes) consistent mass of a body, the same along each axis; per depth in the plane, axisymmetric that of the whole circumference."""
    if body.material.density is None:
        raise ModelError(
            f"material: body {name!r} has no density, and modes need that of every body; give Material(..., density=), mass per volume, "
            "such as 7.85e-9 tonne/mm^3 beside N, mm and s"
        )
    form = BilinearForm(lambda u, v, w: circumference(w.x[0], kinematics) * u * v)
    return csr_matrix(body.material.density * form.assemble(basis_of(body.mesh)))


def _motions(
    parts: Assembly, springs: tuple[Array, Array], opened: Booleans
) -> tuple[csr_matrix, Integers, Array]:
    """The matrix T of the displacements `u = T y` in a mode, the front that eliminates each of the y, and springs that hold them."""
    d, (T, front) = parts.points.shape[1], fronts(parts.glued)
    give = np.where(np.tile(opened, d), np.inf, compliances(*springs, parts.width, d - 1))
    stiff = np.zeros(len(front))
    stiff[front < 0] = np.divide(1.0, give, out=np.zeros(len(give)), where=give > 0)
    front[np.flatnonzero(front < 0)[give > 0]] = front.max() + 1  # what is open or gives moves, too
    moves = (front >= 0) & (np.diff(T.tocsc().indptr) > 0)
    return (
        csr_matrix(parts.tied @ parts.turned(tied_across(parts.rows, parts.cuts)) @ T[:, moves]),
        front[moves],
        stiff[moves],
    )


def _shift(parts: Assembly) -> float:
    """The shift of the squares of angular frequencies, by which bodies without supports have an inverse, too."""
    size = float(np.linalg.norm(np.ptp(parts.points, axis=0)))
    materials = [body.material for body in parts.bodies.values()]
    return (
        _SHIFT
        / size**2
        * min(
            material.E / material.density for material in materials if material.density is not None
        )
    )


def _lowest(
    glued: Glued, M: csr_matrix, T: csr_matrix, front: Integers, shift: float, n: int
) -> tuple[Array, Array]:
    """Squares (n,) of angular frequencies, the lowest first, and modes (unknowns, n) of unit modal mass, of a stiffness and a mass M."""
    size = whole_number("n", n, least=1, most=len(front) - 1)
    _, factors = eliminated(glued, csr_matrix(glued.K + shift * M), T, front, keep=True)
    apply = LinearOperator(
        M.shape, matvec=lambda force: schur.solve(factors, np.ravel(force)), dtype=np.float64
    )
    vectors, start = (
        min(2 * size + _MORE, len(front)),
        np.random.default_rng(0).normal(size=len(front)),
    )
    try:
        squares, y = eigsh(glued.K, size, M, sigma=-shift, OPinv=apply, ncv=vectors, v0=start)
    except ArpackNoConvergence as error:
        raise SolverError(
            f"modes: the search for {n} modes found {len(error.eigenvalues)}; ask for fewer modes"
        ) from error
    order = np.argsort(squares)
    squares, y = squares[order], y[:, order]
    return np.where(squares > _RIGID * shift, squares, 0.0), y / np.sqrt(
        np.sum(y * (M @ y), axis=0)
    )
