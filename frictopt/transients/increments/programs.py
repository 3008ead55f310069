"""The programs of a friction increment, to read and to solve by cvxpy.

`in_form` puts the state of an increment into one of them: `frozen_bound` (form "qp"), `exact`
("milp") or `complementarity`. If no other start leads to a state, Newton's method begins at the
motions of `with_frozen_bounds`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cvxpy as cp
import numpy as np
from cvxpy.reductions.solution import Solution

from ...base import Array, choice
from ...contact import ContactSystem, checked_law, joined, most_shear, parted
from ...errors import ModelError, SolverError
from ...solve.by_cvxpy import solve
from ...solve.problem import Problem, printed_as
from ..transient import OPEN
from .increment import Increment, Posed
from .newton import Law

_TITLES = {
    "qp": "friction increment, frozen bound",
    "complementarity": "friction increment, complementarity",
    "milp": "friction increment, mixed-integer",
}
# Bounds of the motions and forces in a program with booleans, relative to the largest motion and
# force in the state. Solvers satisfy booleans to a tolerance only: with larger bounds they become
# inaccurate.
_REACH = 1e3
# Largest number of programs with frozen bounds, and the change up to which bounds count as
# unchanged.
_MOST_PROGRAMS = 20
_SETTLED = 1e-6


def in_form(posed: Posed, found: Increment, form: str) -> Increment:
    """An increment with the problem of a form, whose variables and parameters hold its state.

    `form` is that of `Trajectory.increment`.
    """
    system, f = posed.owner.system, posed.owner.friction
    choice("form", form, tuple(_TITLES))
    if form != "qp":
        if system.tangents == 2:
            raise ModelError(
                f"form: {form!r}; it needs a piecewise linear law, but the friction bound in space "
                "is a circle: choose 'qp'"
            )
        checked_law(system, f"form {form!r}")
    step = found.slip - posed.slip
    multipliers = {}
    if form == "qp":
        problem = frozen_bound(system)
        bound = most_shear(system, f, found.p.clip(0.0))
        values = {"u": joined(step, found.gap), "trial": posed.reactions, "bound": bound}
        # The pressures are the multipliers of the gaps.
        multipliers = {problem.constraints[0].id: found.p}
    elif form == "complementarity":
        problem = complementarity(system, f)
        q, p = parted(posed.reactions, 2)
        z = np.concatenate([np.maximum(step, 0.0), np.maximum(-step, 0.0), found.gap])
        values = {"z": z, "c": np.concatenate([f * p + q, f * p - q, p])}
    else:
        problem = exact(system, f)
        values = {"slip_step": step, "gap": found.gap, "q": found.q, "p": found.p}
        values |= _with_booleans(posed, found, step)
    for name, parameter in problem.param_dict.items():
        parameter.value = values.pop(name)
    variables = {problem.var_dict[name].id: value for name, value in values.items()}
    problem.unpack(Solution(cp.OPTIMAL, None, variables, multipliers, {}))
    return replace(found, problem=problem, _title=_TITLES[form])


def with_frozen_bounds(system: ContactSystem, law: Law, trial: Array) -> Iterator[Array]:
    """Dimensionless motions (M,) of programs, each with the bounds of the state before it.

    The series ends when the bounds change no more, after `_MOST_PROGRAMS` programs, or if a program
    has no optimum.
    """
    none = {"none": np.zeros(len(trial))}
    problem = frozen_bound(ContactSystem(law.S, system.points, none, frames=system.frames))
    problem.param_dict["trial"].value = trial
    n = system.nodes
    bound = law.bound(trial[-n:])
    for _ in range(_MOST_PROGRAMS):
        problem.param_dict["bound"].value = bound
        try:
            solve(problem, lambda: 0.0)
        except SolverError:
            return
        u = np.array(problem.var_dict["u"].value)
        u[-n:] = u[-n:].clip(0.0)
        yield u
        last, bound = bound, law.bound((trial + law.S @ u)[-n:])
        if np.abs(bound - last).max() <= _SETTLED:
            return


def _with_booleans(posed: Posed, found: Increment, step: Array) -> dict[str, Array]:
    """The booleans and the parameters of `exact`, by their names."""
    f = posed.owner.friction
    motion = np.abs([step, found.gap]).max() / posed.length
    force = max(np.abs(posed.trial).max(), found.p.max() / posed.force)
    reach = _REACH * max(1.0, motion, force)
    statuses = {"forward": 1, "backward": -1, "opened": OPEN}
    booleans = {name: np.where(found.status == n, 1.0, 0.0) for name, n in statuses.items()}
    return {
        **booleans,
        "trial": posed.reactions,
        "unexpected": 1.0 - 2.0 * np.array(list(booleans.values())),
        "most_motion": np.full(len(f), reach * posed.length),
        "most_force": np.full(len(f), reach * posed.force),
        "most_slack": 2 * reach * posed.force * f,
    }


def frozen_bound(system: ContactSystem) -> cp.Problem:
    """The increment with a given friction bound g at each node, in the plane and in space.

    The optimality conditions of this program are the contact law with g, the `bound`, in place of f
    p; the multipliers of no_overlap are the pressures. Klarbring, Mikelic & Shillor 1988.
    """
    n = system.nodes
    u = cp.Variable(len(system.S), name="u")
    trial = cp.Parameter(len(system.S), name="trial")
    bound = cp.Parameter(n, nonneg=True, name="bound")
    S = cp.Constant(system.S, name="S")

    slip_step = u[:-n]
    gap = u[-n:]
    if system.tangents == 1:
        length = cp.abs(slip_step)
    else:
        steps = cp.reshape(slip_step, (n, 2), order="F")
        length = printed_as(cp.norm(steps, axis=1), f"norm({slip_step})")
    energy = printed_as(cp.quad_form(u, cp.psd_wrap(S)), "u @ S @ u") / 2 + trial @ u
    return Problem(cp.Minimize(energy + bound @ length), [(gap >= 0).set_label("no_overlap")])


def exact(system: ContactSystem, friction: Array) -> cp.Problem:
    """The contact law itself, in the plane, with booleans for the status of each node.

    A node slips along +x (`forward`) or against it (`backward`), is open (`opened`), or sticks.
    The parameters `most_motion` and `most_force` are the largest slip step or gap, and the largest
    pressure, of the states considered. `most_slack`, 2 f most_force, is the largest distance of a
    shear force from its bound. The objective counts booleans: `unexpected` is -1 for booleans that
    are expected to be 1, and 1 for all others.
    """
    n = system.nodes
    slip_step = cp.Variable(n, name="slip_step")
    gap = cp.Variable(n, name="gap")
    q = cp.Variable(n, name="q")
    p = cp.Variable(n, name="p")
    forward = cp.Variable(n, boolean=True, name="forward")
    backward = cp.Variable(n, boolean=True, name="backward")
    opened = cp.Variable(n, boolean=True, name="opened")
    trial = cp.Parameter(2 * n, name="trial")
    unexpected = cp.Parameter((3, n), name="unexpected")
    most_motion = cp.Parameter(n, nonneg=True, name="most_motion")
    most_force = cp.Parameter(n, nonneg=True, name="most_force")
    most_slack = cp.Parameter(n, nonneg=True, name="most_slack")
    A = cp.Constant(system.A, name="A")
    B = cp.Constant(system.B, name="B")
    C = cp.Constant(system.C, name="C")
    f = cp.Constant(friction, name="f")

    bound = cp.multiply(f, p)
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
        "friction_bound": cp.abs(q) <= bound,
        "on_forward_bound": bound + q + cp.multiply(most_slack, forward) <= most_slack,
        "on_backward_bound": bound - q + cp.multiply(most_slack, backward) <= most_slack,
    }
    count = unexpected[0] @ forward + unexpected[1] @ backward + unexpected[2] @ opened
    return Problem(cp.Minimize(count), [row.set_label(name) for name, row in rows.items()])


def complementarity(system: ContactSystem, friction: Array) -> cp.Problem:
    """The quadratic program of the complementarity problem, in the plane.

    The program is `min z' (M z + c), z >= 0, M z + c >= 0`. z are the slip steps along +x, the slip
    steps against +x, and the gaps. `M z + c` are f p + q, f p - q and p.
    """
    n = system.nodes
    A, B, C = system.A, system.B, system.C
    f = friction[:, None]
    rows = [[A + f * B, -(A + f * B), B.T + f * C], [f * B - A, A - f * B, f * C - B.T], [B, -B, C]]
    M = cp.Constant(np.block(rows), name="M")
    z = cp.Variable(3 * n, name="z")
    c = cp.Parameter(3 * n, name="c")
    signs = [(z >= 0).set_label("motions"), (M @ z + c >= 0).set_label("slacks")]
    return Problem(cp.Minimize(z @ (M @ z + c)), signs)
