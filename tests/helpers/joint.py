"""One joint in space for all readers of matrices: two blocks of bricks.

The entries of its stiffness are whole numbers.
"""

import numpy as np
from scipy.sparse import block_diag

import frictopt as fo
from helpers.calculix import Block, lines, node_set

UPPER = Block(1, lines((0, 2, 2), (0, 1, 1), (0, 1, 1)), 1800.0, 0.25, "UP")
LOWER = Block(
    101, [np.arange(-1.0, 4.0), np.array([0.0, 1.0]), np.array([-1.0, 0.0])], 1800.0, 0.25, "LOW"
)
BLOCKS = (UPPER, LOWER)
PAIRS = np.array(
    [
        [n, LOWER.numbers[np.flatnonzero((LOWER.points == UPPER.points[n - 1]).all(axis=1))[0]]]
        for n in UPPER.on(2, 0)
    ]
)
POINTS = {
    int(n): tuple(point)
    for part in BLOCKS
    for n, point in zip(part.numbers, part.points, strict=True)
}
FREE = [int(n) for n in POINTS if POINTS[n][2] > -1]
DECK = (
    UPPER.deck()
    + LOWER.deck()
    + node_set("FREE", FREE)
    + node_set("BOT", LOWER.on(2, -1))
    + "*BOUNDARY\nBOT, 1, 3\n"
)
CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])


def stiffness():
    """Stiffness by scikit-fem, and labels of its rows; the bottom of the lower block is held."""
    K = block_diag([part.stiffness() for part in BLOCKS]).toarray()
    labels = np.array([(n, k) for n in POINTS for k in (1, 2, 3)])
    free = np.flatnonzero(np.isin(labels[:, 0], FREE))
    return np.round(K[np.ix_(free, free)], 9), labels[free]


def limit(job):
    """The shakedown limit of the joint, from any job.

    It is pressed by 1 on top and pulled to and fro there, equally at the four corners of the top.
    """
    row = {(int(n), int(k)): i for i, (n, k) in enumerate(job.labels)}
    top, K = [int(n) for n in UPPER.on(2, 1)], job.K
    loads = {"P": np.zeros(K.shape[0]), "Q": np.zeros(K.shape[0])}
    for n in top:
        loads["P"][row[n, 3]], loads["Q"][row[n, 1]] = -1.0, 1.0
    place = {int(n): i for i, n in enumerate(job.deck.numbers)}
    pairs = [[place[int(a)], place[int(b)]] for a, b in PAIRS]
    unknowns = np.where(job.unknowns == -2, -1, job.unknowns)
    system = fo.condense(
        K, loads, pairs, [0, 0, 1], unknowns, job.points, generalised=job.generalised
    )
    return fo.shakedown_limit(system, CYCLE, 0.5).load_factor
