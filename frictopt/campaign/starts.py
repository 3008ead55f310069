"""The starts of the transients of a campaign: families of residual slips, and overloads."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.checks import LARGEST_SEED, Array, finite_array, finite_number, finite_numbers, frozen, whole_number
from ..contact.portable import Portable
from ..contact.system import checked_plane
from ..errors import ModelError
from ..limits import safe_slip, shakedown_limit

__all__ = ["Start", "checked_starts", "given_slips", "no_slip", "overloads", "random_slips", "safe_part", "safe_slips"]

_MODES = 6  # Chebyshev polynomials that make up a smooth slip
_MOST = 100_000  # slips of a kind and amplitude; more would fill the memory


@dataclass(frozen=True, eq=False)
class Start(Portable):
    """The start of a transient: a residual slip or an earlier state, an overload, or both.

    Attributes
    ----------
    family
        Family of starts: "none", "safe", "smooth", "rough", "overload", "given", or your own name.
    name
        Name of the start in tables.
    slip
        (N,) residual slip from assembly, in three dimensions (N, 2), length; None: no slip, or a multiple of the safe slip.
    safe_multiple
        Multiple of the safe slip at the load factor of the run (at the shakedown limit if that is lower); None: `slip` is given, or there is none.
    overload
        Load factor of one extra cycle before all others, over that of the run; None: no overload.
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
    >>> start = fo.Start("assembly", "as assembled", slip=[0.01, -0.01])
    >>> start
    Start(family='assembly', name='as assembled', safe_multiple=None, overload=None, seed=None)
    >>> start == fo.Start("assembly", "as assembled", slip=[0.01, -0.01])
    True
    """

    family: str
    name: str
    slip: Array | None = field(default=None, repr=False)
    safe_multiple: float | None = None
    overload: float | None = None
    seed: int | None = None
    state: ContactState | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for label in ("family", "name"):
            text = getattr(self, label)
            if not isinstance(text, str) or not text or not text.isprintable():
                raise ModelError(f"{label} of a start: {text!r}; give a printable text")
        if self.slip is not None:
            object.__setattr__(self, "slip", _slips(f"slip of start {self.name!r}", self.slip, ()))
        if self.safe_multiple is not None:
            object.__setattr__(self, "safe_multiple", finite_number(f"safe_multiple of start {self.name!r}", self.safe_multiple))
        if self.state is not None and not isinstance(self.state, ContactState):
            raise ModelError(f"state of start {self.name!r}: a {type(self.state).__name__}; give a ContactState")
        if sum(one is not None for one in (self.slip, self.safe_multiple, self.state)) > 1:
            raise ModelError(f"start {self.name!r}: it has two of slip, multiple of the safe slip, and state; give one of them")
        if self.overload is not None:
            object.__setattr__(self, "overload", finite_number(f"overload of start {self.name!r}", self.overload, least=0.0))
        if self.seed is not None:
            object.__setattr__(self, "seed", whole_number(f"seed of start {self.name!r}", self.seed, least=0, most=LARGEST_SEED))

    def _content(self) -> tuple[Any, ...]:
        slip = None if self.slip is None else (self.slip.shape, tuple(self.slip.ravel().tolist()))
        return self.family, self.name, slip, self.safe_multiple, self.overload, self.seed, self.state

    def __eq__(self, other: object) -> bool:
        return self._content() == other._content() if isinstance(other, Start) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._content())

    def slip_at(self, system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float) -> Array | None:
        """(N,) residual slip with which the run at a load factor starts, length; that of its state, if it has one; None: no slip.

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
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        limit = shakedown_limit(system, cycle, friction)
        return frozen(self.safe_multiple * safe_part(system, cycle, friction, load_factor, limit.load_factor, limit.slip))


def no_slip() -> list[Start]:
    """The start without residual slip.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.no_slip()
    [Start(family='none', name='none', safe_multiple=None, overload=None, seed=None)]
    """
    return [Start("none", "none")]


def safe_slips(multiples: Iterable[float] = (1.0,)) -> list[Start]:
    """Multiples of the safe slip with the largest margin at each load factor.

    Examples
    --------
    >>> import frictopt as fo
    >>> [start.name for start in fo.safe_slips([1.0, -1.0])]
    ['safe x 1', 'safe x -1']
    """
    return [Start("safe", f"safe x {number:g}", safe_multiple=number) for number in finite_numbers("multiples", multiples)]


def random_slips(system: ContactSystem, amplitudes: Iterable[float], count: int, *, seed: int = 0) -> list[Start]:
    """Random residual slips: for each amplitude `count` smooth ones and as many rough ones.

    Smooth ones are sums of the Chebyshev polynomials 1 to 6 along the interface with normally distributed coefficients, rough ones are independent
    from node to node; both have zero mean, because the mean only slides one body along the other.

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
    >>> [start.name for start in fo.random_slips(rod, amplitudes=[0.1], count=2)]
    ['smooth 0.1 #0', 'smooth 0.1 #1', 'rough 0.1 #2', 'rough 0.1 #3']
    """
    if checked_plane(system).nodes < 2:
        raise ModelError("system: one node; a slip of one node is a number, give it by given_slips")
    whole_number("count", count, least=1, most=_MOST)
    whole_number("seed", seed, least=0, most=LARGEST_SEED)
    position = np.interp(system.x, [system.x[0], system.x[-1]], [-1.0, 1.0])
    modes = np.polynomial.chebyshev.chebvander(position, _MODES)[:, 1:]
    starts: list[Start] = []
    for amplitude in finite_numbers("amplitudes", amplitudes, least=0.0):
        for family in ("smooth", "rough"):
            for own in range(seed + len(starts), seed + len(starts) + count):
                rng = np.random.default_rng(own)
                slip = modes @ rng.normal(size=_MODES) if family == "smooth" else rng.normal(size=system.nodes)
                slip = slip - slip.mean()
                starts.append(Start(family, f"{family} {amplitude:g} #{own}", frozen(slip * amplitude / root_mean_square(slip)), seed=own))
    return starts


def safe_part(system: Any, cycle: LoadCycle, friction: Any, load_factor: float, limit: float, at_limit: Array) -> Array:
    """(N,) the safe slip with the largest margin, length; above the shakedown limit (NaN: not known) the one that is safe there."""
    if np.isfinite(limit) and load_factor >= limit:
        return at_limit
    return np.asarray(safe_slip(system, cycle, friction, load_factor).slip)


def overloads(factors: Iterable[float]) -> list[Start]:
    """Starts without residual slip that begin with one overload cycle; each factor multiplies the load factor of the run.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.overloads([2.0])
    [Start(family='overload', name='overload x 2', safe_multiple=None, overload=2.0, seed=None)]
    """
    return [Start("overload", f"overload x {factor:g}", overload=factor) for factor in finite_numbers("factors", factors, least=0.0)]


def given_slips(slips: Any, *, family: str = "given") -> list[Start]:
    """Starts from residual slips of your own, (starts, N), in three dimensions (starts, N, 2), length.

    Examples
    --------
    >>> import frictopt as fo
    >>> [start.name for start in fo.given_slips([[0.1, 0.0], [0.0, 0.1]], family="measured")]
    ['measured 0', 'measured 1']
    """
    rows = _slips("slips", list(slips) if isinstance(slips, Iterator) else slips, (None,))
    return [Start(family, f"{family} {number}", slip) for number, slip in enumerate(rows)]


def checked_starts(initial_slips: Any, slip_shape: tuple[int, ...]) -> Sequence[Start]:
    """Check starts for a contact of N nodes: a sequence of `Start`, an array of slips, (starts, *slip_shape), or None.

    Raises
    ------
    ModelError
        Neither of these, none at all, slips of another number of nodes, or two starts of one name.
    """
    starts = no_slip() if initial_slips is None else initial_slips
    if isinstance(starts, Start):
        raise ModelError(f"initial_slips: one start, {starts.name!r}; put it in a list")
    if isinstance(starts, Iterator) or (getattr(getattr(starts, "dtype", None), "kind", "") == "O" and np.iterable(starts)):
        starts = list(starts)
    if isinstance(starts, Sequence | np.ndarray) and np.iterable(starts) and len(starts) == 0:
        raise ModelError("initial_slips: empty; give at least one start")
    if isinstance(starts, Sequence) and any(isinstance(start, Sequence) and any(isinstance(one, Start) for one in start) for start in starts):
        raise ModelError("initial_slips: a list of lists of starts; add them up, no_slip() + overloads([2.0])")
    if not (isinstance(starts, Sequence) and any(isinstance(start, Start) for start in starts)):
        starts = given_slips(finite_array("initial_slips", starts, (None, *slip_shape)))
    names = set()
    for start in starts:
        if not isinstance(start, Start):
            raise ModelError(f"initial_slips: a {type(start).__name__} among starts; put slips of your own in by given_slips(...)")
        for what, slip in (("a slip", start.slip), ("the slip of a state", None if start.state is None else start.state.slip)):
            if slip is not None and slip.shape != slip_shape:
                raise ModelError(f"initial_slips: start {start.name!r} has {what} of shape {slip.shape}, the contact needs {slip_shape}")
        if start.name in names:
            raise ModelError(f"initial_slips: two starts are called {start.name!r}; give them different names or seeds")
        names.add(start.name)
    return starts


def _slips(name: str, values: Any, axes: tuple[None, ...]) -> Array:
    """Check slips (*axes, N), or (*axes, N, 2) in three dimensions."""
    array = finite_array(name, values)
    return array if array.ndim == len(axes) + 2 and array.shape[-1] == 2 else finite_array(name, array, (*axes, None))


def root_mean_square(slip: Array) -> float:
    """Root mean square over the nodes, the same for any size of the numbers."""
    largest = float(np.abs(slip).max()) or 1.0
    return largest * float(np.sqrt(np.mean((slip / largest) ** 2)))
