"""The programs of one increment of friction as cvxpy problems, in the units of the contact: each body runs by itself in a script of yours.

The unknowns are `u = [slip_step, gap]`, the slip since the one before and the total gap; `[q, p] = trial + S u` are the reactions.
"""

import cvxpy as cp
import numpy as np

from ...contact import Array, ContactSystem


def frozen_bound(system: ContactSystem) -> cp.Problem:
    """The increment with a given friction bound g at each node (Klarbring, Mikelic & Shillor 1988), in the plane and in space.

    Its optimality conditions are the contact law with g, the `bound`, in place of f p; the multipliers of no_overlap are the pressures.
    """
    n = system.nodes
    u, trial = cp.Variable(len(system.S), name="u"), cp.Parameter(len(system.S), name="trial")
    bound = cp.Parameter(n, nonneg=True, name="bound")
    S = cp.Constant(system.S, name="S")

    slip_step, gap = u[:-n], u[-n:]
    length = cp.abs(slip_step) if system.tangents == 1 else cp.norm(cp.reshape(slip_step, (n, 2), order="F"), axis=1)
    energy = cp.quad_form(u, cp.psd_wrap(S)) / 2 + trial @ u
    return cp.Problem(cp.Minimize(energy + bound @ length), [(gap >= 0).set_label("no_overlap")])


def exact(system: ContactSystem, friction: Array) -> cp.Problem:
    """The contact law itself, in the plane: each node sticks, slips along or against +x, or is open, with a boolean for each but sticking.

    `most_motion` and `most_force` are the largest slip step or gap, and pressure, that are looked for; `most_slack`, 2 f most_force, is the largest
    distance of a shear force from its bound. The objective counts booleans: `unexpected` is -1 for those that are expected to be 1, else 1.
    """
    n = system.nodes
    slip_step, gap, q, p = (cp.Variable(n, name=name) for name in ("slip_step", "gap", "q", "p"))
    forward, backward, opened = (cp.Variable(n, boolean=True, name=name) for name in ("forward", "backward", "opened"))
    trial, unexpected = cp.Parameter(2 * n, name="trial"), cp.Parameter((3, n), name="unexpected")
    most_motion, most_force, most_slack = (cp.Parameter(n, nonneg=True, name=name) for name in ("most_motion", "most_force", "most_slack"))
    A, B, C, f = (cp.Constant(value, name=name) for name, value in (("A", system.A), ("B", system.B), ("C", system.C), ("f", friction)))

    rows = {
        "shear": q == trial[:n] + A @ slip_step + B.T @ gap,
        "pressure": p == trial[n:] + B @ slip_step + C @ gap,
        "one_status": forward + backward + opened <= 1,
        "slips_forward": slip_step <= cp.multiply(most_motion, forward + opened),
        "slips_backward": -slip_step <= cp.multiply(most_motion, backward + opened),
        "no_overlap": gap >= 0,
        "opens": gap <= cp.multiply(most_motion, opened),
        "no_tension": p >= 0,
        "no_force_across_a_gap": p + cp.multiply(most_force, opened) <= most_force,
        "friction_bound": cp.abs(q) <= cp.multiply(f, p),
        "on_forward_bound": cp.multiply(f, p) + q + cp.multiply(most_slack, forward) <= most_slack,
        "on_backward_bound": cp.multiply(f, p) - q + cp.multiply(most_slack, backward) <= most_slack,
    }
    count = cp.sum(cp.multiply(unexpected, cp.vstack([forward, backward, opened])))
    return cp.Problem(cp.Minimize(count), [row.set_label(name) for name, row in rows.items()])


def complementarity(system: ContactSystem, friction: Array) -> cp.Problem:
    """The quadratic program `min z' (M z + c), z >= 0, M z + c >= 0` of the complementarity problem, in the plane.

    The slip step is `forward_slip - backward_slip`, and `M z + c` are f p + q, f p - q and p.
    """
    A, B, C, f = system.A, system.B, system.C, friction[:, None]
    rows = [[A + f * B, -(A + f * B), B.T + f * C], [f * B - A, A - f * B, f * C - B.T], [B, -B, C]]
    matrix, n = np.block(rows), system.nodes
    M, symmetric = cp.Constant(matrix, name="M"), cp.Constant((matrix + matrix.T) / 2, name="(M + M.T) / 2")
    trial = cp.Parameter(2 * n, name="trial")

    q, p, coefficient = trial[:n], trial[n:], cp.Constant(friction, name="f")
    c = cp.hstack([cp.multiply(coefficient, p) + q, cp.multiply(coefficient, p) - q, p])
    z = cp.hstack([cp.Variable(n, name=name) for name in ("forward_slip", "backward_slip", "gap")])
    signs = [(z >= 0).set_label("motions"), (M @ z + c >= 0).set_label("slacks")]
    return cp.Problem(cp.Minimize(cp.quad_form(z, symmetric) + c @ z), signs)
