"""Onset of slip, separation and touch, from the bonded contact or from where the mean load leaves it."""

import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle, Onset, checked_cycle, checked_system, friction_coefficients, warns_of_odd_values
from ..contact.onset import onset_from
from ..errors import FrictoptError


@warns_of_odd_values
def onset(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> Onset:
    """Find the first slip and the first separation of the bonded contact as the load grows towards each corner, `lam >= 0`.

    Where the mean load would pull at nodes of the bonded contact, it is that of the contact once the mean load has settled, from no slip: closed
    nodes stick, open ones follow. The load at a corner is `mean + fixed + lam * corner`, see `LoadCycle`. Closed form, node by node: slip starts
    where `|q| = f p`, against q (in space the root of a quadratic), separation where `p = 0`, touch where a gap is zero. Theory, eq. (6).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad friction, no load cycle, or a load case that the system lacks.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 2.0]), "Q": ([1.0, 1.0], [0.0, 0.0])}
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0], [0, 0]], [[2, 0], [0, 2]], [0, 1], bonded)
    >>> first = fo.onset(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), friction=0.5)
    >>> first.slip
    OnsetEvent(corner='Q = +1', event=slip, load_factor=0.5, node=0, sense=-1)
    >>> first.to_frame()
       corner   loads       event  load_factor  node  sense
    0       0  Q = +1        slip          0.5     0     -1
    1       0  Q = +1  separation          inf  <NA>      0
    2       1  Q = -1        slip          0.5     0      1
    3       1  Q = -1  separation          inf  <NA>      0
    """
    f = np.array(friction_coefficients(friction, checked_system(system).nodes))
    first = onset_from(system, checked_cycle(cycle), f)
    if not first.mean_opens:
        return first
    from .march import mean_state  # here, because a closed contact needs none

    try:
        return onset_from(system, cycle, f, mean_state(system, cycle, f))
    except FrictoptError:
        return first
