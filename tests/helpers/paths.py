"""The states along an exact path, and their check of the contact law."""

import numpy as np

import frictopt as fo
from frictopt.transients.cycles import Run
from frictopt.transients.exact import ExactPath
from frictopt.transients.steady import reported


def followed(*asked, cycles=0, keep=False):
    """A path that has followed some cycles after the mean load; on request it keeps its states."""
    path = ExactPath(*asked)
    path = path.recorded() if keep else path
    path.start()
    path.follow(path.segments * cycles)
    return path


def settled(path):
    """The steady state after some cycles from the state of a transient, and a transient on it."""
    run = Run(path, 2000)
    found = run.settled()
    return reported(run, found, np.inf if path.steps else 0.0), found.path


def bonded_at(path, times):
    """(T, 2N) bonded reactions at times that count the visited corners, from the first cycle on."""
    corners = np.array(
        [path.mean, *path.corners * int(np.ceil(times.max() / len(path.corners)) + 1)]
    )
    return np.array([np.interp(times, np.arange(len(corners)), values) for values in corners.T]).T


def judged(path):
    """The residual of the contact law over all states since the mean load."""
    n = path.nodes
    time, u, r, _, _ = path.states()
    loaded = time >= 0
    u, r, load = u[loaded], r[loaded], bonded_at(path, time[loaded])
    return fo.reference.check_contact_law(
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


# A punch that rocks under a steady pull walks: each node holds while the other node slips.
ROCKED = {"P": ([0.3, 0.3], [1, 1]), "rock": ([0, 0], [0.6, -0.6]), "Q": ([0.5, -0.5], [0, 0])}
ROCKING = fo.ContactSystem.from_blocks(
    [[1, -1], [-1, 1]], np.zeros((2, 2)), np.eye(2), [0, 1], ROCKED
)
WALKING = ROCKING, fo.LoadCycle({"P": 1.0}, [{"rock": 1.0}, {"rock": -1.0}]), 0.5, 1.0

# Node 0 opens at corner 1, and drags node 1 along before. The further node 1 has slid, the less it
# is dragged in the next cycle.
A, B, C = (
    [[6.02, 2.5], [2.5, 11.2]],
    [[1.75, -4.16], [-7.96, -6.72]],
    [[12.48, 2.55], [2.55, 16.53]],
)
MEAN = {"mean": ([0, 0], [0.7, 0.73])}
LOADS = {
    "a": ([0.01, -0.54], [0.83, 0.06]),
    "b": ([-0.62, -0.55], [-2.79, 0.49]),
    "c": ([0.81, 1.06], [3.15, -0.68]),
}
TWICE = fo.ContactSystem.from_blocks(A, B, C, [0.0, 1.0], MEAN | LOADS)
ROUND = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}, {"c": 1.0}])
ASKED = TWICE, ROUND, 1.2, 1.0
