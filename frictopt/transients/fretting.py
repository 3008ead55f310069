"""What frets where: the steady cycle of a contact, node by node, in the words of fretting fatigue."""

from typing import Any

import numpy as np

from ..contact import ContactSystem, LoadCycle, referee
from ..contact.answers import Outcome
from ..contact.checks import Array, finite_array
from ..contact.show import frame
from ..contact.tolerances import SAME_STATE
from ..errors import ModelError
from .exact import ExactPath
from .exact.kernel import OPEN
from .outcome import SteadyState

__all__ = ["fretting_table", "steady_cycle"]

_NOTE = "at the ends of a contact with sharp corners, tractions, F1, F2 and SWT are a property of the mesh; refine it before you compare them"


def steady_cycle(system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float, steady: SteadyState) -> dict[str, Array]:
    """All states of one period of a steady state, from the last corner to the last corner: one after each event and at each corner.

    Parameters
    ----------
    system, cycle, friction, load_factor
        Those of the steady state.
    steady
        The steady state.

    Returns
    -------
    dict
        "time" (T,), from 0 to the number of corners times the period; "slip", "gap", "q", "p" and "work", (T, N), the work of
        friction since the first state.

    Raises
    ------
    ModelError
        Bad input, or a steady state of another contact, load or friction.
    NoContinuation
        The path ends, which it does not from a steady state.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> problem = rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0
    >>> states = fo.steady_cycle(*problem, fo.steady_state(*problem))
    >>> float(states["slip"][:, 0].min()), float(states["slip"][:, 0].max()), states["work"][-1].round(6).tolist()
    (-0.5, 0.5, [1.0, 0.0, 0.0, 0.0])
    """
    path = ExactPath(system, cycle, friction, load_factor, keep=True)
    n = path.nodes
    if not isinstance(steady, SteadyState) or len(steady.slip) != n:
        nodes = f" of {len(steady.slip)} nodes" if isinstance(steady, SteadyState) else ""
        raise ModelError(f"steady: a {type(steady).__name__}{nodes}; give the steady state of this contact, of {n} nodes")
    opened = steady.gap > 0
    path.bonded, path.visited, state = path.corners[-1], 0, path.state
    state.u[:] = np.concatenate([steady.slip, steady.gap - system.gap])
    state.r[:] = np.where(np.r_[opened, opened], 0.0, path.bonded + path.stress(state.u))
    state.status[:] = np.where(opened, OPEN, np.where(path.friction == 0, 1, 0))
    states = [(np.zeros(1), state.u[None].copy(), state.r[None].copy(), state.status[None].copy(), np.zeros((1, n)))]
    for _ in range(steady.period):
        path.run_cycle()
    time, u, r, _, work = (np.concatenate(parts) for parts in zip(*states, *path.history, strict=True))
    drift = u[-1] - u[0]
    changed = 0.0 if steady.outcome is Outcome.RATCHETING else _over(drift, u)
    lawful = referee(
        system, (path.bonded[:n], path.bonded[n:]), path.friction, v=u[0, :n], w=steady.gap, q=r[0, :n], p=r[0, n:], force_scale=path.force
    )
    spent = work[-1] - steady.period * steady.dissipation_per_node
    off = max(lawful.residual, changed, _over(spent, np.maximum(work, path.force * np.abs(u).max())))
    if not off <= SAME_STATE:
        raise ModelError(
            f"steady: a cycle from it differs from it by {off:.1e}; give the same system, cycle, friction and load_factor as to steady_state"
        )
    return {"time": time, "slip": u[:, :n], "gap": u[:, n:] + system.gap, "q": r[:, :n], "p": r[:, n:], "work": work}


def fretting_table(
    system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float, steady: SteadyState, *, stress: Any = None, strain: Any = None
) -> Any:
    """What frets where in a steady state: one row for each node.

    Theory, eq. (21).

    Parameters
    ----------
    system, cycle, friction, load_factor
        Those of the steady state.
    steady
        The steady state.
    stress, strain
        (M, N) stress and strain of one body along the tangent at the nodes of the contact, at M states of the steady cycle, as
        `BodyFields.at_contact` gives them; both or none.

    Returns
    -------
    DataFrame
        Columns:

        - node, x, and contact where the system names its contacts;
        - slip_range, largest less least slip of the cycle while the node is closed (with its drift, if the contact ratchets);
        - tau_amplitude, tau_mean, pressure_amplitude, pressure_mean, half the range and the middle of the tractions `q / width` and `p / width`;
          where the system has no width, q_amplitude, q_mean, p_amplitude, p_mean, of the nodal forces;
        - work, share, work_density: work of friction per cycle, its share of the whole, and over width;
        - F1, Ruiz's first parameter: largest shear traction of the cycle times slip range (F1_force, of the nodal force, where there is no width);
        - F2 and SWT, where stress and strain are given: Ruiz's second parameter, largest tensile stress times F1; and that of Smith, Watson and
          Topper on the plane normal to the tangent, largest tensile stress times half the range of the strain.

        `attrs["note"]` says which columns are a property of the mesh: at the corner of a complete contact tractions and stresses grow without end
        as elements shrink, and so do F1, F2 and SWT there.

    Raises
    ------
    ModelError
        Bad input, or a steady state of another contact, load or friction.

    Notes
    -----
    F1 and F2: Ruiz, Boddington & Chen 1984, Experimental Mechanics 24, 208-217. SWT: Smith, Watson & Topper 1970, J. Materials 5, 767-778; for
    fretting: Szolwinski & Farris 1996, Wear 198, 93-107.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> problem = rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0
    >>> fo.fretting_table(*problem, fo.steady_state(*problem))[["node", "slip_range", "q_amplitude", "share", "F1_force"]].round(6)
       node  slip_range  q_amplitude  share  F1_force
    0     0         1.0          0.5    1.0       0.5
    1     1         0.0          0.5    0.0       0.0
    2     2         0.0          0.0    0.0       0.0
    3     3         0.0          0.0    0.0       0.0
    """
    states = steady_cycle(system, cycle, friction, load_factor, steady)
    closed = states["gap"] <= 0
    most, least = (np.where(closed, states["slip"], outside) for outside in (-np.inf, np.inf))
    slipped = np.where(closed.any(axis=0), most.max(axis=0) - least.min(axis=0), 0.0)
    width = np.ones(system.nodes) if system.width is None else system.width
    q, p = states["q"] / width, states["p"] / width
    names = ("q", "p") if system.width is None else ("tau", "pressure")
    columns: dict[str, Any] = {"node": np.arange(system.nodes), "x": system.x, "slip_range": slipped}
    if system.contact is not None:
        columns = {"node": columns["node"], "contact": system.contact, "x": system.x, "slip_range": slipped}
    for name, part in zip(names, (q, p), strict=True):
        columns[f"{name}_amplitude"] = np.ptp(part, axis=0) / 2
        columns[f"{name}_mean"] = (part.max(axis=0) + part.min(axis=0)) / 2
    work = steady.dissipation_per_node if steady.outcome is not Outcome.SHAKEDOWN else np.zeros(system.nodes)
    columns["work"], columns["share"] = work, work / (work.sum() or 1.0)
    if system.width is not None:
        columns["work_density"] = work / width
    first = np.abs(q).max(axis=0) * slipped
    columns["F1" if system.width is not None else "F1_force"] = first
    if (stress is None) != (strain is None):
        raise ModelError("stress, strain: one of them alone; give both, as BodyFields.at_contact does, or none")
    if stress is not None:
        sigma, epsilon = (finite_array(name, values, (None, system.nodes)) for name, values in (("stress", stress), ("strain", strain)))
        if len(sigma) != len(epsilon) or not len(sigma):
            raise ModelError(f"stress, strain: {len(sigma)} and {len(epsilon)} states; give both at the same states, at least one")
        tension = np.maximum(sigma.max(axis=0), 0.0)
        columns["F2" if system.width is not None else "F2_force"] = tension * first
        columns["SWT"] = tension * np.ptp(epsilon, axis=0) / 2
    table = frame(columns)
    table.attrs["note"] = _NOTE if system.width is not None else f"nodal forces, not tractions: the system has no width; {_NOTE}"
    return table


def _over(difference: Array, values: Array) -> float:
    """Largest difference over the largest value."""
    return float(np.abs(difference).max() / (np.abs(values).max() or 1.0))
