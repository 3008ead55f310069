"""What a transient starts from: residual slips and earlier states, overloads, and the load steps of a protocol."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..contact import ROUNDING, ContactState, ContactSystem, LoadCycle, checked_system
from ..contact.checks import LARGEST_SEED, Array, check_text, finite_array, finite_number, finite_numbers, frozen, whole_number
from ..contact.result import Portable
from ..errors import ModelError
from ..limits import ShakedownLimit, safe_slip, safe_vertices, shakedown_limit
from .load_steps import LoadStep, assembled_slip

__all__ = ["LoadStep", "Start", "assembled_slip", "given_slips", "no_slip", "overloads", "random_slips", "safe_slips", "safe_vertices"]

_MODES = 6  # degree of the Chebyshev polynomials that make up a smooth slip
_MOST = 100_000  # slips of a kind and amplitude; more would fill the memory


@dataclass(frozen=True, eq=False)
class Start(Portable):
    """The start of a transient: a residual slip or an earlier state, an overload, or both.

    Attributes
    ----------
    family
        Family of starts: "none", "safe", "smooth", "rough", "overload", "given", or any other name.
    name
        Name of the start in tables.
    slip
        (N,) residual slip from assembly, in three dimensions (N, 2), length; None: no slip, or a multiple of the safe slip.
    safe_multiple
        Multiple of the safe slip at the load factor of the run (at the shakedown limit if that is lower); None: `slip` is given, or there is none.
    overload
        Load factor of one extra cycle before all others; None: no overload.
    seed
        Seed of a random slip; None: the slip is not random.
    state
        An earlier state instead of a slip, whose nodes may be open.

    Raises
    ------
    ModelError
        Names that are no printable texts, numbers that are not finite, a seed that is no whole number, or more than one of slip, multiple of the safe
        slip, and state.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.starts.Start("assembly", "as assembled", slip=[0.01, -0.01])
    Start(family='assembly', name='as assembled', safe_multiple=None, overload=None, seed=None)
    """

    family: str
    name: str
    slip: Array | None = field(default=None, repr=False)
    safe_multiple: float | None = None
    overload: float | None = None
    seed: int | None = None
    state: ContactState | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        check_text("family of a start", self.family, "a printable text")
        check_text("name of a start", self.name, "a printable text")
        of = f"of start {self.name!r}"
        if self.state is not None and not isinstance(self.state, ContactState):
            raise ModelError(f"state {of}: a {type(self.state).__name__}; give a ContactState")
        if sum(one is not None for one in (self.slip, self.safe_multiple, self.state)) > 1:
            raise ModelError(f"start {self.name!r}: it has two of slip, multiple of the safe slip, and state; give one of them")
        checked = {
            "slip": None if self.slip is None else _slips(f"slip {of}", self.slip, ()),
            "safe_multiple": None if self.safe_multiple is None else finite_number(f"safe_multiple {of}", self.safe_multiple),
            "overload": None if self.overload is None else finite_number(f"overload {of}", self.overload, least=0.0),
            "seed": None if self.seed is None else whole_number(f"seed {of}", self.seed, least=0, most=LARGEST_SEED),
        }
        vars(self).update(checked)

    def slip_at(
        self, system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, load_factor: float, limit: ShakedownLimit | None = None
    ) -> Array | None:
        """Residual slip (N,) with which the run at a load factor starts, length; that of its state, if it has one; None: no slip.

        `limit` is the shakedown limit, if it is known.

        Raises
        ------
        ModelError
            Bad input.
        SolverError
            The safe slip, or the shakedown limit, is not found.
        """
        if self.state is not None:
            return self.state.slip
        if self.safe_multiple is None:
            return self.slip
        limit = shakedown_limit(system, cycle, friction) if limit is None else limit
        above = finite_number("load_factor", load_factor, least=0.0) >= limit.load_factor
        return frozen(self.safe_multiple * (limit.slip if above else safe_slip(system, cycle, friction, load_factor).slip))


def no_slip() -> list[Start]:
    """The start without residual slip.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.starts.no_slip()
    [Start(family='none', name='none', safe_multiple=None, overload=None, seed=None)]
    """
    return [Start("none", "none")]


def safe_slips(multiples: Iterable[float] = (1.0,)) -> list[Start]:
    """Multiples of the safe slip with the largest margin at each load factor.

    Examples
    --------
    >>> import frictopt as fo
    >>> [start.name for start in fo.starts.safe_slips([1.0, -1.0])]
    ['safe x 1', 'safe x -1']
    """
    return [Start("safe", f"safe x {number:g}", safe_multiple=number) for number in finite_numbers("multiples", multiples)]


def random_slips(system: ContactSystem, amplitudes: Iterable[float], count: int, *, seed: int = 0) -> list[Start]:
    """Random residual slips: for each amplitude `count` smooth ones and as many rough ones.

    Smooth ones are sums of the Chebyshev polynomials 1 to 6 along the interface with normally distributed coefficients, rough ones are independent
    from node to node; both have zero mean, because the mean only slides one body along the other. In space both slips of a node are sums of products
    of such polynomials in its coordinates, of degree 1 to 6 in all.

    Parameters
    ----------
    system
        The contact, of two nodes or more.
    amplitudes
        Root mean square of the slips over the nodes, length.
    count
        Number of slips of each kind and amplitude, at most 100,000.
    seed
        Seed of the first slip; the next slips have the next seeds.

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
        raise ModelError("system: one node; its slip has no shape, give it by given_slips")
    whole_number("count", count, least=1, most=_MOST)
    whole_number("seed", seed, least=0, most=LARGEST_SEED)
    modes = smooth_modes(system)
    starts: list[Start] = []
    for amplitude in finite_numbers("amplitudes", amplitudes, least=0.0):
        for family in ("smooth", "rough"):
            for number in range(seed + len(starts), seed + len(starts) + count):
                rng = np.random.default_rng(number)
                slip = smooth(rng, modes, system) if family == "smooth" else rng.normal(size=system.slip_shape)
                slip = slip - slip.mean(axis=0)
                starts.append(Start(family, f"{family} {amplitude:g} #{number}", frozen(slip * amplitude / root_mean_square(slip)), seed=number))
    return starts


def smooth_modes(system: ContactSystem) -> Array:
    """(N, modes) products of Chebyshev polynomials in the coordinates of the nodes, of degree 1 to 6 in all."""
    places = system.x[:, None] if system.tangents == 1 else system.points
    low, wide = places.min(axis=0), np.ptp(places, axis=0)
    along = wide > ROUNDING * wide.max()  # not across a flat face
    axes = [np.polynomial.chebyshev.chebvander(x, _MODES).T for x in (2 * (places - low)[:, along] / wide[along] - 1).T]
    degrees = [powers for powers in np.ndindex(*[_MODES + 1] * len(axes)) if 0 < sum(powers) <= _MODES]
    products = [np.prod([axis[power] for axis, power in zip(axes, powers, strict=True)], axis=0) for powers in degrees]
    return np.reshape(products, (-1, system.nodes)).T


def smooth(rng: np.random.Generator, modes: Array, system: ContactSystem) -> Array:
    """A sum of modes with normally distributed coefficients, (N,) or (N, 2)."""
    return modes @ rng.normal(size=(modes.shape[1], *system.slip_shape[1:]))


def spread(slip: Array) -> float:
    """Largest difference of two nodes' slips along a tangent."""
    return float(np.ptp(slip, axis=0).max())


def overloads(load_factors: Iterable[float]) -> list[Start]:
    """Starts without residual slip that begin with one cycle at each of these load factors.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.starts.overloads([2.0])
    [Start(family='overload', name='overload to 2', safe_multiple=None, overload=2.0, seed=None)]
    """
    return [Start("overload", f"overload to {factor:g}", overload=factor) for factor in finite_numbers("load_factors", load_factors, least=0.0)]


def given_slips(slips: ArrayLike, *, family: str = "given") -> list[Start]:
    """Starts from given residual slips (S, N), in three dimensions (S, N, 2), length.

    Examples
    --------
    >>> import frictopt as fo
    >>> [start.name for start in fo.starts.given_slips([[0.1, 0.0], [0.0, 0.1]], family="measured")]
    ['measured 0', 'measured 1']
    """
    return [
        Start(family, f"{family} {number}", slip)
        for number, slip in enumerate(_slips("slips", list(slips) if isinstance(slips, Iterator) else slips, (None,)))
    ]


def checked_starts(starts: Sequence[Start] | ArrayLike | None, slip_shape: tuple[int, ...]) -> list[Start]:
    """Check starts for a contact: a list of `Start`, an array of slips, (S, *slip_shape), or None.

    Raises
    ------
    ModelError
        Neither of these, none at all, slips of another number of nodes, or two starts of one name.
    """
    starts = no_slip() if starts is None else list(starts) if isinstance(starts, Iterator) else starts
    if isinstance(starts, Sequence) and not starts:
        raise ModelError("starts: empty; give at least one start")
    if not np.iterable(starts) or not any(isinstance(start, Start) for start in starts):
        starts = given_slips(finite_array("starts", starts, (None, *slip_shape)))
    names = set()
    for start in starts:
        if not isinstance(start, Start):
            raise ModelError(f"starts: a {type(start).__name__} among starts; make starts of slips by given_slips, and add lists up")
        slip = start.slip if start.state is None else start.state.slip
        if slip is not None and slip.shape != slip_shape:
            raise ModelError(f"starts: start {start.name!r} has a slip of shape {slip.shape}, the contact needs {slip_shape}")
        if start.name in names:
            raise ModelError(f"starts: two starts are called {start.name!r}; give them different names or seeds")
        names.add(start.name)
    return list(starts)


def _slips(name: str, values: ArrayLike, axes: tuple[None, ...]) -> Array:
    """Check slips (*axes, N), or (*axes, N, 2) in three dimensions."""
    array = finite_array(name, values)
    return array if array.ndim == len(axes) + 2 and array.shape[-1] == 2 else finite_array(name, array, (*axes, None))


def root_mean_square(slip: Array) -> float:
    """Root mean square over the nodes, the same for any size of the numbers."""
    largest = float(np.abs(slip).max()) or 1.0
    return largest * float(np.sqrt(np.mean((slip / largest) ** 2)))
