"""A contact as a plain program over raw slips, in the plane or in space.

All nodes are in it at all corners; nothing is omitted.
"""

import cvxpy as cp
import numpy as np

from frictopt.contact import joined

TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
FINE = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), 1e-9)


class Oracle:
    """Slips and reactions of a contact at every corner.

    Closed nodes stick within `|q| <= f p`, and the `opened` nodes are free of force. `slip` is the
    slip at load factor 0 and corner 0. `q` and `p` have one part for each corner. `lam` is the load
    factor, `most` a slip bound, and `added` are reactions at all corners, (M,).
    """

    def __init__(self, contact, cycle, f, opened=None, most=None, added=0.0):
        n, self.contact = contact.nodes, contact
        self.opened, f = (
            np.zeros(n, dtype=bool) if opened is None else opened,
            np.broadcast_to(f, n),
        )
        self.lam, self.shared = cp.Variable(), cp.Variable((n, contact.tangents))
        self.rows, self.q, self.p = [self.lam >= 0], [], []
        at_rest = [joined(*contact.closed_reaction(loads)) for loads in cycle.unscaled] * (
            1 if cycle.fixed else len(cycle.corners)
        )
        for mean, corner in zip(at_rest, cycle.corners, strict=True):
            _, w, q, p = self.state(mean + added + self.lam * joined(*contact.reaction(corner)))
            self.rows += [w >= 0] if self.opened.any() else []
            self.rows.append(
                self.size(q[~self.opened]) <= cp.multiply(f[~self.opened], p[~self.opened])
            )
            self.q.append(self.shaped(q))
            self.p.append(p)
        slip = self.state(at_rest[0] + added)[0] if self.opened.any() else self.shared
        self.slip = self.shaped(slip)
        self.rows += [] if most is None else [self.size(slip) <= most]

    def state(self, load):
        """Slips, gaps and reactions under a load.

        Closed nodes have the shared slip, and open nodes move so that no force acts on them.
        """
        n, axes, u, w = (
            self.contact.nodes,
            self.contact.tangents,
            self.shared,
            np.zeros(self.contact.nodes),
        )
        q, p = cp.Variable((n, axes)), cp.Variable(n)
        if self.opened.any():
            u, w = cp.Variable((n, axes)), cp.Variable(n)
            self.rows += [
                w[~self.opened] == 0,
                (u - self.shared)[~self.opened] == 0,
                q[self.opened] == 0,
                p[self.opened] == 0,
            ]
        self.rows.append(
            cp.hstack([cp.vec(q, order="F"), p])
            == load + self.contact.S @ cp.hstack([cp.vec(u, order="F"), w])
        )
        return u, w, q, p

    def shaped(self, vectors):
        """Values (N,) in the plane, (N, 2) in space."""
        return vectors[:, 0] if self.contact.tangents == 1 else vectors

    def size(self, vectors):
        return cp.abs(vectors[:, 0]) if self.contact.tangents == 1 else cp.norm(vectors, 2, axis=1)

    def largest(self, own=(), goal=None):
        """The largest load factor, or value of a goal, with further rows.

        The result is inf if there is no bound, and nan if nothing obeys the rows.
        """
        problem = cp.Problem(cp.Maximize(self.lam if goal is None else goal), [*self.rows, *own])
        value = problem.solve(
            **{"solver": "SCIPY", "scipy_options": TIGHT}
            if self.contact.tangents == 1
            else {"solver": "CLARABEL", **FINE}
        )
        return np.nan if value is None or value == -np.inf else value

    def least(self):
        """The least load factor; nan if there is none."""
        return -self.largest(goal=-self.lam)
