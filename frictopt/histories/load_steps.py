"""What is done to a contact before its load cycle: assembly, and the load steps of a protocol."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from ..contact import Array, ContactSystem, LoadCycle, checked_loads, checked_system, finite_number, frozen, joined, parted
from ..transients.begin import Transient
from ..transients.march import path_of

_ASSEMBLED_FROM = 1e-6  # share of the mean load at which assembly begins: at no load at all every node is closed without pressure


@dataclass(frozen=True)
class LoadStep:
    """One load of a protocol, `loads + lam * cyclic`; the load goes there in a straight line.

    Parameters
    ----------
    loads
        The part that does not depend on the load factor, load case name -> amplitude.
    cyclic
        The part that the load factor multiplies, load case name -> amplitude at load factor 1.

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

    loads: Mapping[str, float]
    cyclic: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        vars(self).update(loads=checked_loads("loads", self.loads), cyclic=checked_loads("cyclic", self.cyclic))

    def __repr__(self) -> str:
        return f"LoadStep(loads={dict(self.loads)}, cyclic={dict(self.cyclic)})"

    def reactions(self, system: ContactSystem, load_factor: float) -> Array:
        """Bonded reactions `[q, p]` at a load factor, in the order of S: (2N,), force per depth; (3N,), force, in space.

        Raises
        ------
        ModelError
            Not a contact system, load cases that it does not have, or a bad load factor.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        checked_system(system)
        return joined(*system.reaction(self.loads)) + load_factor * joined(*system.reaction(self.cyclic))


def assembled_slip(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, *, steps: int | None = None) -> Array:
    """Slip under the mean load that assembly leaves: the mean load grows from a millionth of itself, and nothing has slipped before.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle, of which only the mean load counts.
    friction
        Coefficient of friction, one or one per node.
    steps
        Number of increments in which the load grows. None: the exact path in the plane, 20 in space.

    Returns
    -------
    Array
        (N,), in space (N, 2), length.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The path ends, for example because the mean load opens the contact or makes it slide as a whole.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.8, 0.0], [1.0, 1.0]), "Q": ([1.0, 0.0], [0.0, 0.0])}
    >>> pair = fo.ContactSystem.from_blocks([[1.0, -0.4], [-0.4, 1.0]], [[0.0, 0.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.starts.assembled_slip(pair, cycle, friction=0.6).round(9)
    array([-0.2,  0. ])
    """
    path = path_of(system, cycle, friction, 0.0, steps=steps)
    assemble(path)
    return frozen(parted(path.state.u, system.tangents + 1)[0])


def assemble(path: Transient) -> None:
    """Follow a path that has not begun through assembly, to the mean load."""
    path.follow_to(_ASSEMBLED_FROM * path.mean, "the segment to the load at which assembly begins")
    path.follow_to(path.mean, "the segment to the mean load")
