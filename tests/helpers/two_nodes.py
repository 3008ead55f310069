"""Limits of two coupled nodes, by hand in the plane of their slips.

Three of four friction lines meet at a limit (Ahn, Bertocchi & Barber 2008). Each node has two
lines, `-(A + f B)_i v = (q0 + f p0)_i - lam |q1 + f p1|_i` (forward slip) and `(A - f B)_i v = (f
p0 - q0)_i - lam |q1 - f p1|_i` (backward slip). Safe slips lie between the two lines of both nodes.
As the load grows the lines approach each other. The two lines of a node cross in its apex. Below
the critical friction one line of the other node faces the apex, and the other line lies behind it:

* If the apex of a node reaches the line facing it, no slip is safe any more. lambda_2 is the first
  such load factor.
* The apex of a node that slips both ways, `|q1| > f |p1|`, may lie between the lines of the other
  node. Then it is a corner of the safe region, and starts near it keep slipping to and fro.
  lambda_1 is the first load factor at which this is so. It is 0 if the apex is a corner from the
  outset.

Both hold for full contact. lambda_2 also covers a node that lifts off rather than slips. lambda_1
omits such a node, because it dissipates nothing.
"""

import numpy as np

ROUNDING = 1e-12


def two_node_limits(A, B, q0, p0, q1, p1, f):
    """lambda_1 and lambda_2 of the corners `s = -1, +1`.

    They are inf if all load factors are safe, and nan if no slip is safe even without the cyclic
    load.
    """
    A, B = np.asarray(A), np.asarray(B)
    q0, p0, q1, p1, f = (np.broadcast_to(part, 2) for part in (q0, p0, q1, p1, f))
    # Line 0 bounds forward slip, line 1 backward slip; safe is `normal . v <= strength - lam *
    # demand`. Axes: line, node (, component of v).
    normal = np.stack([-A - f[:, None] * B, A - f[:, None] * B])
    strength, demand = (
        np.stack([q0 + f * p0, f * p0 - q0]),
        np.stack([np.abs(q1 + f * p1), np.abs(q1 - f * p1)]),
    )
    facing, behind = np.array(
        [meetings(normal, strength, demand, node) for node in (0, 1)]
    ).transpose(1, 0, 2)
    if any(resists < -ROUNDING * terms for resists, _, terms in facing):
        return np.nan, np.nan
    upper = min(
        [np.inf, *(max(resists, 0.0) / closes for resists, closes, _ in facing if closes > 0)]
    )
    corners = [corner(*behind[node]) for node in (0, 1) if abs(q1[node]) > f[node] * abs(p1[node])]
    return min([upper, *corners]), upper


def meetings(normal, strength, demand, node):
    """The apex of a node and both lines of the other node: the facing line, and the line behind it.

    Returns the resistance, its decrease with the load, and the size of the terms.
    """
    found = []
    for third, resists, closes in zip(
        normal[:, 1 - node], strength[:, 1 - node], demand[:, 1 - node], strict=True
    ):
        # With these weights the three normals add up to zero. The weights of the lines of
        # the apex are made positive. All three weights then have one sign, and no slip is
        # safe behind the meeting, exactly if the third line faces the apex.
        first, second = normal[:, node]
        weights = np.array(
            [
                np.linalg.det([second, third]),
                np.linalg.det([third, first]),
                np.linalg.det([first, second]),
            ]
        )
        weights *= np.sign(weights[0])
        resisting = weights * [*strength[:, node], resists]
        found.append(
            (
                weights[2],
                resisting.sum(),
                weights @ [*demand[:, node], closes],
                np.abs(resisting).sum(),
            )
        )
    (_, resists, closes, terms), (_, *faced) = sorted(found)
    return faced, (-resists, -closes, terms)


def corner(strength, demand, terms):
    """Least load factor at which the apex lies before the line behind it; inf if there is none.

    Up to lambda_2 the apex lies before the facing line.
    """
    if demand < 0:
        return max(0.0, strength / demand)
    return 0.0 if strength > ROUNDING * terms else np.inf
