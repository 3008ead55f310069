"""The states along an exact path, and what the referee says of them."""

import numpy as np

import frictopt as fo
from frictopt.transients.cycles import Run
from frictopt.transients.exact import ExactPath
from frictopt.transients.steady import reported


def followed(*asked, cycles=0, keep=False):
    """A path that has followed some cycles after the mean load, and if wanted keeps its states."""
    path = ExactPath(*asked)
    path = path.recorded() if keep else path
    path.start()
    path.follow(path.legs * cycles)
    return path


def settled(path):
    """The steady state that cycles lead to from where a transient is, and a transient on it."""
    run = Run(path, 2000)
    found = run.settled()
    return reported(run, found, np.inf if path.steps else 0.0), found.path


def bonded_at(path, times):
    """(T, 2N) bonded reactions at times that count the corners visited, from the path's first cycle on."""
    corners = np.array([path.mean, *path.corners * int(np.ceil(times.max() / len(path.corners)) + 1)])
    return np.array([np.interp(times, np.arange(len(corners)), values) for values in corners.T]).T


def judged(path):
    """The referee's residual over all states since the mean load."""
    n = path.nodes
    time, u, r, _, _ = path.states()
    loaded = time >= 0
    u, r, load = u[loaded], r[loaded], bonded_at(path, time[loaded])
    return fo.reference.referee(
        path.system,
        (load[:, :n], load[:, n:]),
        path.friction,
        v=u[:, :n],
        w=u[:, n:] + path.system.gap,
        q=r[:, :n],
        p=r[:, n:],
        previous_slip=np.vstack([u[:1, :n], u[:-1, :n]]),
        force_scale=path.force,
    ).residual
