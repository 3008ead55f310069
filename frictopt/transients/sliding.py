"""Gross sliding: a rigid motion of the bodies that friction cannot stop."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpstrf

from ..contact import COUNTS, RIGID, Array, ContactSystem
from ..errors import NoContinuation, SolverError

_WITHIN, _PROJECTIONS = 0.99, 50  # of the friction, so that a projection comes to lie within it; at most
_FOUND = 0.5  # of the largest size of a motion, which one of negative work has; without one there is none, up to rounding
_EVEN = 0.5  # a motion whose mean is at least so large a part of it is a slide, else a turn


class _Motion(NamedTuple):
    """A rigid motion of size up to 1, and how far it goes beyond `w >= f |v|`."""

    phi: Array
    residual: float


def rigid_motions(system: ContactSystem) -> Array:
    """(M, k) relative motions that strain nothing, an orthonormal basis: the slides, turns and lifts of bodies that no support guides."""
    S = system.S
    factor, order, rank, _ = dpstrf(S, tol=RIGID * np.diag(S).max())  # where pivots are rounding, the others follow what is left
    motions = np.eye(len(S), len(S) - rank, -rank)
    motions[:rank] = solve_triangular(factor[:rank, :rank], -factor[:rank, rank:])
    return np.asarray(np.linalg.qr(motions[np.argsort(order)])[0])


def check_sliding(system: ContactSystem, friction: Array, loads: dict[str, Array]) -> None:
    """Check that contact forces can balance each load, in words that name the motion if they cannot.

    A motion phi = (v, w) that strains nothing, S phi = 0, has the work `phi . r = phi . r^w` with the reactions of every state. Where `w >= f |v|`
    at all nodes, contact forces have no negative work in it (`p >= 0`, `|q| <= f p`). So a load with `phi . r^w < 0` has no state: this proves gross
    sliding, turning over or lift-off, whatever the slip and the history. Where no forces within friction are found that balance the load, a cone
    program looks for the motion of size 1 with the least work.

    Parameters
    ----------
    system, friction
        The contact and its (N,) coefficients of friction.
    loads
        Name of a load, as the beginning of a sentence -> its bonded reactions (M,).

    Raises
    ------
    NoContinuation
        A load has no state.
    """
    V, less, beyond = rigid_motions(system), _WITHIN * friction, dict[str, Array]()
    for name, load in loads.items():
        r = load.reshape(-1, system.nodes)
        for _ in range(_PROJECTIONS):  # on either condition in turn
            q, p, size = r[:-1], r[-1], np.linalg.norm(r[:-1], axis=0)
            if (size <= friction * p).all():
                break
            nearest = np.where(size <= less * p, p, np.maximum(p + less * size, 0.0) / (1 + less**2))
            r = np.vstack([q * np.minimum(1.0, less * nearest / np.where(size > 0, size, 1.0)), nearest])
            r = r + (V @ (V.T @ (load - r.ravel()))).reshape(r.shape)
        else:
            beyond[name] = load
    if not beyond:
        return
    import cvxpy as cp  # here, for loads that friction bears need no program

    from ..solve.solvers import solve

    share, work = cp.Variable(V.shape[1]), cp.Parameter(V.shape[1])
    *v, w = (part @ share for part in V.reshape(-1, system.nodes, V.shape[1]))
    opposed = cp.SOC(w, cp.multiply((1 + COUNTS) * friction, cp.vstack(v)))
    problem = cp.Problem(cp.Minimize(work @ share), [opposed, cp.SOC(cp.Constant(1.0), share)])

    def claimed() -> _Motion:
        phi = V @ share.value
        *slid, lifted = phi.reshape(-1, system.nodes)
        return _Motion(phi, float((friction * np.linalg.norm(slid, axis=0) - lifted).max()))

    for name, load in beyond.items():
        work.value = V.T @ load / (float(np.abs(load).max()) or 1.0)
        with suppress(SolverError):
            phi = solve(problem, claimed)[0].phi
            if phi @ phi > _FOUND and phi @ load < -COUNTS * np.abs(phi) @ np.abs(load):
                raise NoContinuation(_sentence(system, name, load, phi))


def _sentence(system: ContactSystem, name: str, load: Array, phi: Array) -> str:
    """What moves, where to, and the forces: those of the load and of friction in units of the mean slip."""
    phi, load = (values.reshape(-1, system.nodes) for values in (phi, load))
    sizes = np.linalg.norm(phi[:-1], axis=0)
    moves = np.abs(phi).max(axis=0) > COUNTS * np.abs(phi).max()
    where = f"body 1 (at {int(moves.sum())} of {system.nodes} nodes)"
    mean = float(sizes[moves].mean())
    demand, holds = (float(part) / (mean or 1.0) for part in (-np.sum(phi[:-1] * load[:-1]), phi[-1] @ load[-1]))
    if mean <= COUNTS * np.abs(phi).max() or demand <= 0 or holds <= 0:
        return f"{name} lifts {where} off or turns it over: no pressure with friction up to f p balances it; press the bodies together, or hold them"
    along = np.einsum("an,nak->nk", phi[:-1], system.frames[:, :-1])[moves].mean(axis=0)
    size = float(np.linalg.norm(along))
    way = ", ".join(f"{part:g}" for part in (along / (size or 1.0)).round(6) + 0.0)
    motion = f"slides as a whole along ({way})" if size > _EVEN * mean else "turns as a whole on its contact"
    return (
        f"{name} is beyond friction: {where} {motion}; the load drives it with {demand:.4g}, and friction can hold f P = {holds:.4g} at most: press "
        "the bodies together, hold them by supports, or load them less"
    )
