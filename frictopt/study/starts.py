"""Starts of transients: residual slips, earlier states, overloads, and load steps of a protocol."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    LARGEST_SEED,
    ROUNDING,
    Array,
    Loads,
    PerNode,
    Shown,
    check_text,
    checked_loads,
    finite_array,
    finite_number,
    finite_numbers,
    frozen,
    number_of,
    warns_of_odd_values,
    whole_number,
)
from ..contact import ContactState, ContactSystem, LoadCycle, checked_system, joined, parted
from ..errors import ModelError
from ..limits import ShakedownLimit, safe_slip, shakedown_limit
from ..transients.march import path_of
from ..transients.transient import Transient

__all__ = [
    "LoadStep",
    "Start",
    "assembled_slip",
    "given_slips",
    "no_slip",
    "overloads",
    "random_slips",
    "safe_slips",
]


def __dir__() -> list[str]:
    return __all__


_SMOOTH_DEGREE = 6  # highest degree of the Chebyshev polynomials of a smooth slip


@dataclass(frozen=True, eq=False, repr=False)
class Start(Shown):
    """The start of a transient: a residual slip or an earlier state, an overload, or both.

    Attributes
    ----------
    family, name
        Family of starts ("none", "safe", "smooth", "rough", "overload", "given", or any other
        name), and name of the start in tables.
    slip
        (N,) residual slip from assembly, in space (N, 2), length; None: no slip, or a multiple of
        the safe slip.
    safe_multiple
        Multiple of the safe slip at the load factor of the run, or at the shakedown limit if this
        limit is lower. None: the start has another slip, a state, or no slip.
    overload, seed
        Load factor of one extra cycle before all others, and seed of a random slip; None if the
        start has none.
    state
        An earlier state, instead of a slip. Its nodes may be open.
    amplitude
        Root mean square of a random slip, length; None: the slip is not random. A store identifies
        a random slip by its family, amplitude and seed, and any other slip by its numbers.

    Raises
    ------
    ModelError
        A name is not a printable text, a number is not finite, a seed is not a whole number, or two
        of slip, multiple and state are given.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.starts.Start("assembly", "as assembled", slip=[0.01, -0.01])
    Start(family=assembly, name=as assembled, safe_multiple=None, overload=None, seed=None)
    """

    _shown_names = "family", "name", "safe_multiple", "overload", "seed"
    family: str
    name: str
    slip: Array | None = None
    safe_multiple: float | None = None
    overload: float | None = None
    seed: int | None = None
    state: ContactState | None = None
    amplitude: float | None = None

    def __post_init__(self) -> None:
        check_text("family of a start", self.family, "a printable text")
        check_text("name of a start", self.name, "a printable text")
        if not isinstance(self.state, ContactState | None):
            raise ModelError(
                f"state of start {self.name!r}: a {type(self.state).__name__}; give a ContactState"
            )
        slips = [self.slip, self.safe_multiple, self.state]
        if sum(slip is not None for slip in slips) > 1:
            raise ModelError(
                f"start {self.name!r}: two of slip, multiple of the safe slip, and state are "
                "given; give one of them"
            )
        for name, check in _CHECKS.items():
            value = getattr(self, name)
            if value is not None:
                vars(self)[name] = check(f"{name} of start {self.name!r}", value)

    def slip_at(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: PerNode,
        load_factor: float,
        limit: ShakedownLimit | None = None,
    ) -> Array | None:
        """Residual slip, (N,) or (N, 2), length, of a run at a load factor; None: no slip.

        `limit` is the shakedown limit of the run, if it is known.

        Raises
        ------
        ModelError, SolverError
            Bad input; no solver finds the safe slip or the shakedown limit.
        """
        if self.safe_multiple is None:
            return self.slip if self.state is None else self.state.slip
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        if limit is None:
            limit = shakedown_limit(system, cycle, friction)
        if load_factor >= limit.load_factor:
            slip = limit.slip
        else:
            slip = safe_slip(system, cycle, friction, load_factor).slip
        return frozen(self.safe_multiple * slip)


def no_slip() -> list[Start]:
    """The start without residual slip.

    Returns
    -------
    list of Start
        One start.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.starts.no_slip()
    [Start(family=none, name=none, safe_multiple=None, overload=None, seed=None)]
    """
    return [Start("none", "none")]


def safe_slips(multiples: Iterable[float] = (1.0,)) -> list[Start]:
    """Multiples of the safe slip that has the largest margin, at each load factor.

    Returns
    -------
    list of Start
        A start for each multiple.

    Examples
    --------
    >>> import frictopt as fo
    >>> [start.name for start in fo.starts.safe_slips([1.0, -1.0])]
    ['safe x 1', 'safe x -1']
    """
    return [
        Start("safe", f"safe x {number:g}", safe_multiple=number)
        for number in finite_numbers("multiples", multiples)
    ]


def random_slips(
    system: ContactSystem, amplitudes: Iterable[float], count: int, *, seed: int = 0
) -> list[Start]:
    """Random residual slips: for each amplitude, `count` smooth slips and as many rough slips.

    Smooth slips are sums, with normally distributed coefficients, of Chebyshev polynomials of
    degree 1 to 6 in the coordinates of the nodes (in space, of their products). Rough slips are
    independent from node to node. Both have zero mean, because a mean slip is only a slide of one
    body along the other.

    Parameters
    ----------
    system, amplitudes
        The contact, which has at least two nodes; and the amplitudes of the slips: root mean
        squares over the nodes, length.
    count, seed
        Number of slips of each kind and amplitude, and the seed of the first slip. Each further
        slip has the next seed. There are at most 100,000 slips, and 10^8 numbers in them.

    Returns
    -------
    list of Start
        `2 count` starts for each amplitude.

    Raises
    ------
    ModelError
        A contact of one node, bad amplitudes, counts or seeds.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> [start.name for start in fo.starts.random_slips(rod, amplitudes=[0.1], count=2)]
    ['smooth 0.1 #0', 'smooth 0.1 #1', 'rough 0.1 #2', 'rough 0.1 #3']
    """
    if checked_system(system).nodes < 2:
        raise ModelError(
            "system: one node, so smooth and rough slips do not exist; give its slip by given_slips"
        )
    count = whole_number("count", count, least=1)
    seed = whole_number("seed", seed, least=0, most=LARGEST_SEED)
    checked_amplitudes = finite_numbers("amplitudes", amplitudes, least=0.0)
    slips = 2 * count * len(checked_amplitudes)
    # More slips would fill the memory.
    most = min(100_000, 10**8 // (system.nodes * system.tangents))
    if slips > most:
        raise ModelError(
            f"count: {count} for {number_of(len(checked_amplitudes), 'amplitude')} are {slips} "
            f"slips; give a count of at most {most} slips in all"
        )
    modes = smooth_modes(system)
    starts = list[Start]()
    kinds = product(checked_amplitudes, ("smooth", "rough"), range(count))
    for number, (amplitude, family, _) in enumerate(kinds, seed):
        rng = np.random.default_rng(number)
        if family == "smooth":
            slip = modes @ rng.normal(size=(modes.shape[1], *system.slip_shape[1:]))
        else:
            slip = rng.normal(size=system.slip_shape)
        slip = slip - slip.mean(axis=0)
        slip = slip * amplitude / root_mean_square(slip)
        starts.append(
            Start(
                family, f"{family} {amplitude:g} #{number}", slip, seed=number, amplitude=amplitude
            )
        )
    return starts


def smooth_modes(system: ContactSystem) -> Array:
    """(N, modes) products of Chebyshev polynomials in the coordinates, of total degree 1 to 6."""
    places = system.x[:, None] if system.tangents == 1 else system.points
    low = places.min(axis=0)
    width = np.ptp(places, axis=0)
    along_face = width > ROUNDING * width.max()  # no polynomials across a flat face
    scaled = 2 * (places - low)[:, along_face] / width[along_face] - 1  # (N, axes), from -1 to 1
    # For each axis (degree + 1, N): the polynomials of all degrees at the nodes.
    polynomials = [np.polynomial.chebyshev.chebvander(x, _SMOOTH_DEGREE).T for x in scaled.T]
    modes = []
    for degrees in np.ndindex(*[_SMOOTH_DEGREE + 1] * len(polynomials)):
        if 0 < sum(degrees) <= _SMOOTH_DEGREE:
            factors = [axis[degree] for axis, degree in zip(polynomials, degrees, strict=True)]
            modes.append(np.prod(factors, axis=0))
    return np.reshape(modes, (-1, system.nodes)).T


def root_mean_square(slip: Array) -> float:
    """Root mean square over the nodes; it neither overflows nor underflows."""
    largest = float(np.abs(slip).max()) or 1.0
    return largest * float(np.sqrt(np.mean((slip / largest) ** 2)))


def overloads(load_factors: Iterable[float]) -> list[Start]:
    """Starts without residual slip that begin with one cycle at each of these load factors.

    Returns
    -------
    list of Start
        A start for each load factor.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.starts.overloads([2.0])
    [Start(family=overload, name=overload to 2, safe_multiple=None, overload=2, seed=None)]
    """
    return [
        Start("overload", f"overload to {factor:g}", overload=factor)
        for factor in finite_numbers("load_factors", load_factors, least=0.0)
    ]


def given_slips(slips: ArrayLike, *, family: str = "given") -> list[Start]:
    """Starts from given residual slips (S, N), in space (S, N, 2), length.

    Returns
    -------
    list of Start
        A start for each slip.

    Examples
    --------
    >>> import frictopt as fo
    >>> [start.name for start in fo.starts.given_slips([[0.1, 0.0], [0.0, 0.1]], family="measured")]
    ['measured 0', 'measured 1']
    """
    rows = _slips("slips", slips, (None,))
    return [Start(family, f"{family} {number}", slip) for number, slip in enumerate(rows)]


def _slips(name: str, values: ArrayLike, axes: tuple[None, ...] = ()) -> Array:
    """Check slips (*axes, N), or in space (*axes, N, 2)."""
    array = finite_array(name, values)
    if array.ndim == len(axes) + 2 and array.shape[-1] == 2:
        return array
    return finite_array(name, array, (*axes, None))


_CHECKS: dict[str, Callable[[str, Any], object]] = {
    "slip": _slips,
    "safe_multiple": finite_number,
    "overload": partial(finite_number, least=0.0),
    "amplitude": partial(finite_number, least=0.0),
    "seed": partial(whole_number, least=0, most=LARGEST_SEED),
}


@dataclass(frozen=True)
class LoadStep:
    """A load of a protocol, `loads + lam * cyclic`, which is reached along a straight line.

    Parameters
    ----------
    loads, cyclic
        Load case name -> amplitude: the part that does not depend on the load factor, and the part
        that the load factor scales.

    Raises
    ------
    ModelError
        A name that is not a text, or an amplitude that is not finite.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.starts.LoadStep({"P": 0.3}, {"sigma": 1.0})
    LoadStep(loads={'P': 0.3}, cyclic={'sigma': 1.0})
    """

    loads: Loads
    cyclic: Loads = field(default_factory=dict)

    def __post_init__(self) -> None:
        vars(self).update(
            loads=checked_loads("loads", self.loads), cyclic=checked_loads("cyclic", self.cyclic)
        )

    def __repr__(self) -> str:
        return f"LoadStep(loads={dict(self.loads)}, cyclic={dict(self.cyclic)})"

    def reactions(self, system: ContactSystem, load_factor: float) -> Array:
        """Bonded reactions `[q, p]` at a load factor, in the order of S.

        (2N,), force per depth; in space (3N,), force.

        Raises
        ------
        ModelError
            Not a contact system, load cases that it does not have, or a bad load factor.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        constant = joined(*checked_system(system).reaction(self.loads))
        cyclic = joined(*system.reaction(self.cyclic))
        return constant + load_factor * cyclic


@warns_of_odd_values
def assembled_slip(
    system: ContactSystem, cycle: LoadCycle, friction: PerNode, *, steps: int | None = None
) -> Array:
    """Slip, (N,) or (N, 2), length, that assembly leaves.

    The contact begins without slip, and the mean load grows from a millionth of itself.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle (only the mean load matters), and its coefficient of friction,
        one or one per node.
    steps
        Number of increments in which the load grows. None: the exact path in the plane, 20 in
        space.

    Returns
    -------
    Array
        (N,) or (N, 2) slip, length.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The path ends, for example because the mean load opens the contact or makes it slide as a
        whole.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.8, 0.0], [1.0, 1.0]), "Q": ([1.0, 0.0], [0.0, 0.0])}
    >>> A, B, C = [[1.0, -0.4], [-0.4, 1.0]], [[0.0, 0.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]]
    >>> pair = fo.ContactSystem.from_blocks(A, B, C, [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.starts.assembled_slip(pair, cycle, friction=0.6).round(9)
    array([-0.2,  0. ])
    """
    path = path_of(system, cycle, friction, 0.0, steps=steps)
    assemble(path)
    slip, _ = parted(path.state.u, system.tangents + 1)
    return frozen(slip)


def assemble(path: Transient) -> None:
    """Begin a path: follow it through assembly, to the mean load."""
    # Share of the mean load at which assembly begins. Without load every node is closed but has no
    # pressure, so the direction of its first slip is unknown.
    assembled_from = 1e-6
    path.follow_to(assembled_from * path.mean, "the segment to the load at which assembly begins")
    path.follow_to(path.mean, "the segment to the mean load")
