"""A limit question in the plane or in space."""

from typing import Any

from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..contact.checks import Array
from ..errors import ModelError
from ..solve.solvers import Kind
from .loads import Loads, cycle_loads
from .plane import PlaneQuestion
from .question import LimitQuestion
from .slip_bound import slip_bounds
from .space import SpaceQuestion

__all__ = ["bounded", "kind_of", "plane", "pose"]


def pose(
    system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, simplify: bool = True, most: Array | None = None, loads: Loads | None = None
) -> PlaneQuestion | SpaceQuestion:
    """Check a limit problem and pose it.

    Raises
    ------
    ModelError
        Wrong types, load cases that the system does not have, bad friction, a mean load whose shear hides its pressure.
    """
    loads = loads or cycle_loads(system, cycle)
    question = PlaneQuestion if system.tangents == 1 else SpaceQuestion
    return question(system, cycle, loads, friction_coefficients(friction, system.nodes), simplify, most)


def plane(task: LimitQuestion) -> PlaneQuestion:
    """The question, if it is on a plane contact.

    Raises
    ------
    ModelError
        A contact in space.
    """
    if not isinstance(task, PlaneQuestion):
        raise ModelError("constraints: they are for plane contacts; in space leave constraints and objective out")
    return task


def kind_of(system: ContactSystem) -> Kind:
    """What the programs over its safe slips are."""
    return Kind.LP if system.tangents == 1 else Kind.SOCP


def bounded(slip_bound: Any, system: ContactSystem) -> Array | None:
    """(N,) bounds on the slip, checked; None for no bound.

    Raises
    ------
    ModelError
        A bad bound, or one in space.
    """
    if slip_bound is not None and system.tangents != 1:
        raise ModelError("slip_bound: it is for plane contacts; in space leave it out")
    return slip_bounds(slip_bound, system.nodes)
