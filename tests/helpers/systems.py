"""Small contact systems for the tests."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from scipy.linalg import block_diag
from scipy.optimize import linprog

import frictopt as fo
from frictopt.contact import frames_of, joined, parted

CYCLE = fo.LoadCycle(mean={"mean": 1.0}, corners=[{"cyclic": -1.0}, {"cyclic": 1.0}])
PULL, SHEAR = (fo.LoadCycle({"P": 1.0}, [{name: -1.0}, {name: 1.0}]) for name in ("sigma", "Q"))

# Jenkins' element: a block under the pressure N on a spring of 3, sheared by F to and fro.
BLOCK = fo.ContactSystem.from_blocks(
    [[3.0]],
    [[0.0]],
    [[1.0]],
    [0.0],
    {"N": ([0.0], [1.0]), "F": ([-1.0], [0.0])},
    compliance=[[0, 0], [0, 1]],
    units="N, mm",
)
PUSHED_AND_PULLED = fo.LoadCycle({"N": 1.0}, [{"F": 1.0}, {"F": -1.0}])
# A block of one node and a body of two nodes that nothing holds.
FREE = fo.ContactSystem(
    np.zeros((2, 2)), [[0.0, 0.0]], {"P": [0.0, 1.0], "Q": [-1.0, 0.0], "side": [-1.0, 0.0]}
)
FREE_PAIR = fo.ContactSystem.from_blocks(
    [[1, -1], [-1, 1]],
    np.zeros((2, 2)),
    [[1, -1], [-1, 1]],
    [0, 1],
    {"P": ([0, 0], [1, 1]), "Q": ([1, 1], [0, 0]), "R": ([0, 0], [1, -1])},
)

SEEDS = st.integers(0, 10**6)
# Two coupled pairs for `system`: with f = 0.6 and 0.4 their guaranteed limits are well below their
# shakedown limits.
FIRST_PAIR = (
    np.array([[1, -0.4], [-0.4, 1]]),
    np.array([[-0.1, -0.7], [0.7, 0.1]]),
    0,
    1,
    (0.8, 0.8),
    (0.4, 0.1),
)
SECOND_PAIR = (
    np.array([[1, -0.6], [-0.6, 1]]),
    np.array([[-0.5, -0.4], [0.4, 0.5]]),
    0,
    1,
    (0.4, -0.4),
    (0.1, -0.1),
)
# One coupled node, and three without coupling.
ONE_NODE = (2.0, 0.5, 0.1, 1.0, 1.0, 0.2)
THREE = (
    [[2, -1, 0], [-1, 2, -1], [0, -1, 2]],
    np.zeros((3, 3)),
    (0.05, 0, -0.1),
    (1, 0.8, 1.2),
    (0.5, 0.3, -0.2),
    (0.1, -0.2, 0.9),
)


def unit_nodes(loads, **known):
    """Nodes of unit stiffness at 0, 1 and so on that do not feel each other."""
    shears, _ = next(iter(loads.values()))
    unit, none = np.eye(len(shears)), np.zeros((len(shears),) * 2)
    return fo.ContactSystem.from_blocks(unit, none, unit, np.arange(len(shears)), loads, **known)


# One node that two load cases press and one shears.
NODE = unit_nodes({"P": ([0.0], [1.0]), "N": ([0.0], [1.0]), "Q": ([1.0], [0.0])})


def system(A, B, q0, p0, q1, p1, C=None, gap=None):
    """A system with the load cases "mean" (q0, p0) and "cyclic" (q1, p1).

    C is so large that S is positive definite.
    """
    A, B = np.atleast_2d(A).astype(float), np.atleast_2d(B).astype(float)
    n = len(A)
    if C is None:
        C = np.eye(n) * (1.0 + np.abs(B @ np.linalg.pinv(A) @ B.T).sum())
    C = np.atleast_2d(C)
    bonded = {
        name: (np.broadcast_to(q, n), np.broadcast_to(p, n))
        for name, (q, p) in (("mean", (q0, p0)), ("cyclic", (q1, p1)))
    }
    return fo.ContactSystem.from_blocks(A, B, C, np.arange(n), bonded, gap)


def random_system(rng, nodes, loads=("mean", "cyclic"), coupling=0.5):
    """A coupled system with a well-conditioned S; every load case is random, and the mean presses."""
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + np.eye(2 * nodes)
    A, B, C = S[:nodes, :nodes], coupling * S[nodes:, :nodes], S[nodes:, nodes:]
    bonded = {name: (rng.normal(size=nodes), 0.3 * rng.normal(size=nodes)) for name in loads}
    bonded["mean"] = (0.1 * rng.normal(size=nodes), rng.uniform(0.5, 1.5, size=nodes))
    return fo.ContactSystem.from_blocks(A, B, C, np.arange(nodes), bonded)


def odd(rng, nodes):
    """A random slip that is mirror-symmetric."""
    values = rng.normal(size=nodes)
    return (values - values[::-1]) / 2


def mirrored(rng, nodes, gap=False, coupling=1.0):
    """A random mirror-symmetric system with the load cases "mean" (pressing), "one" and "other"."""
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + 0.3 * np.eye(2 * nodes)
    image = np.kron(np.diag([-1.0, 1.0]), np.eye(nodes)[::-1])
    S = (S + image @ S @ image) / 2
    S[nodes:, :nodes] *= coupling
    even = [part + part[::-1] for part in rng.normal(size=(3, nodes))]
    bonded = {
        name: (odd(rng, nodes), 0.15 * part)
        for name, part in zip(("mean", "one", "other"), even, strict=True)
    }
    bonded["mean"] = (0.1 * bonded["mean"][0], 1.0 + bonded["mean"][1])
    opening = 0.3 * np.maximum(even[1], 0.0) if gap else None
    x = np.arange(nodes) - (nodes - 1) / 2
    return fo.ContactSystem.from_blocks(
        S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:], x, bonded, opening
    )


def explained(answer):
    """The text that an answer or a model prints about itself."""
    return answer.explain()


def at_corners(contact, cycle, load_factor, slip):
    """Reactions q and p at all corners under a slip with all nodes closed, from the stiffness."""
    bonded = np.array([joined(*contact.closed_reaction(loads)) for loads in cycle.at(load_factor)])
    return parted(
        bonded + contact.S @ joined(np.asarray(slip), np.zeros(contact.nodes)), contact.tangents + 1
    )


def all_closed(contact, cycle, friction, **options):
    """The shakedown limit with all nodes closed."""
    none = np.zeros(contact.nodes, dtype=bool)
    return fo.shakedown_limit(contact, cycle, friction, open_nodes=none, **options)


def excess(contact, cycle, friction, load_factor, slip):
    """How far a slip is from being safe with all nodes closed, over the largest pressure."""
    q, p = at_corners(contact, cycle, load_factor, slip)
    shear = np.linalg.norm(q.reshape(*p.shape, -1), axis=-1)
    return max((shear - np.asarray(friction) * p).max(), -p.min()) / p.max()


def among_others(contact, friction, nodes):
    """A plane contact and its friction among other nodes, which nothing couples to it or shears.

    They are pressed as its own nodes are, so that they rest.
    """
    more = nodes - contact.nodes
    stiff = contact.stiffness_scale * np.eye(more)
    blocks = [
        block_diag(block, other)
        for block, other in ((contact.A, stiff), (contact.B, 0 * stiff), (contact.C, stiff))
    ]
    pressed = np.abs(contact.bonded["mean"][1]).mean()
    loads = {
        name: (np.r_[q, np.zeros(more)], np.r_[p, np.full(more, pressed * (name == "mean"))])
        for name, (q, p) in contact.bonded.items()
    }
    friction = np.r_[np.broadcast_to(friction, contact.nodes), np.full(more, np.mean(friction))]
    gap = np.r_[contact.gap, np.zeros(more)]
    return fo.ContactSystem.from_blocks(*blocks, np.arange(nodes), loads, gap), friction


def stress_of(contact, table, friction):
    """(N,) shear forces that the slips of a mechanism leave.

    They are zero if the slips do no work on any residual slip.
    """
    net, lift = np.zeros((2, contact.nodes))
    np.add.at(net, table.node, table.direction * table.share)
    np.add.at(lift, table.node, lifts(table, friction) * table.share)
    return contact.A @ net + contact.B.T @ lift


def lifts(table, friction):
    """(rows,) the lift of its node per length of each slip of a mechanism.

    A slip lifts by the coefficient of friction, an opening by 1.
    """
    f = np.asarray(friction)
    return np.where(table.direction == 0, 1.0, f[table.node] if f.ndim else f)


def corner_rows(contact, cycle, friction):
    """(2, K, N, N + 1) rows and (2, K, N) right sides of `rows @ (v, lam) <= right`.

    They exclude forward slip and backward slip at all corners.
    """
    f, ways = np.broadcast_to(friction, contact.nodes), (-1.0, 1.0)
    unscaled, corners = (
        map(contact.closed_reaction, cycle.at(0.0)),
        list(zip(*cycle.corner_reactions(contact), strict=True)),
    )
    rows = [
        [
            np.column_stack([way * contact.A - f[:, None] * contact.B, way * q - f * p])
            for q, p in corners
        ]
        for way in ways
    ]
    return np.array(rows), np.array(
        [[f * p - way * q for way in ways] for q, p in unscaled]
    ).swapaxes(0, 1)


def linprog_limit(contact, cycle, friction, most=None, upper=(), equal=(), least=False):
    """Largest (or least) load factor from all K corners and raw slips of at most `most`, by scipy.

    Returns (status, value). Status 0 is optimal, 2 infeasible (value nan), 3 unbounded (inf). More
    rows `(a, b, right)` mean `a @ v + b lam <= right`, or `==`.
    """
    n, unscaled = contact.nodes, [contact.closed_reaction(loads)[1] for loads in cycle.at(0.0)]
    rows, right = corner_rows(contact, cycle, friction)
    closed = [np.column_stack([-contact.B, -p]) for p in cycle.corner_reactions(contact)[1]]
    rows = np.vstack([rows.reshape(-1, n + 1), *closed, *(np.append(a, b) for a, b, _ in upper)])
    right = np.concatenate([right.ravel(), *unscaled, [c for *_, c in upper]])
    also = (
        {"A_eq": [np.append(a, b) for a, b, _ in equal], "b_eq": [c for *_, c in equal]}
        if equal
        else {}
    )
    slips = [(None, None)] * n if most is None else [(-m, m) for m in np.broadcast_to(most, n)]
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    goal = np.append(np.zeros(n), 1.0 if least else -1.0)
    answer = linprog(goal, rows, right, **also, bounds=[*slips, (0, None)], options=tight)
    # HiGHS cannot solve so many rows of nearly the same direction.
    if answer.status == 4:
        answer = linprog(goal, rows, right, **also, bounds=[*slips, (0, None)])
    if answer.status == 4:
        answer = linprog(goal, rows, right, **also, bounds=[*slips, (0, None)], method="highs-ipm")
    return answer.status, {
        0: answer.fun if least or answer.fun is None else -answer.fun,
        3: np.inf,
    }.get(answer.status, np.nan)


def has_safe_slip(contact, cycle, friction, load_factor, most=None):
    """Whether some raw slip of at most `most` keeps all nodes stuck at a load factor, by scipy."""
    at = (np.zeros(contact.nodes), 1.0, load_factor)
    return linprog_limit(contact, cycle, friction, most, equal=[at])[0] == 0


def linprog_margin(contact, cycle, friction, load_factor, most=None, upper=()):
    """Largest margin of raw slips of at most `most` at a load factor, by scipy.

    More rows `(a, b, right)` mean `a @ v + b margin <= right`.
    """
    n, (rows, right) = contact.nodes, corner_rows(contact, cycle, friction)
    unit = np.mean([(friction * contact.reaction(loads)[1]).mean() for loads in cycle.unscaled])
    stuck = np.column_stack([rows.reshape(-1, n + 1)[:, :-1], np.full(right.size, unit)])
    rows, right = (
        np.vstack([stuck, *(np.append(a, b) for a, b, _ in upper)]),
        (right - load_factor * rows[..., -1]).ravel(),
    )
    slips = [(None, None)] * n if most is None else [(-m, m) for m in np.broadcast_to(most, n)]
    # The default tolerance of 1e-7 hides changes by small load factors.
    exact = {"primal_feasibility_tolerance": 1e-10}
    return -linprog(
        -np.eye(n + 1)[-1],
        rows,
        np.r_[right, [c for *_, c in upper]],
        bounds=[*slips, (None, 1)],
        options=exact,
    ).fun


def on_both_bounds(contact, cycle, friction, **options):
    """(N, 2) least and largest load factor at which a safe slip holds a node on both its bounds.

    scipy computes them. They are nan if no slip does.
    """
    rows, right = corner_rows(contact, cycle, friction)
    found = np.full((contact.nodes, 2), np.nan)
    for node in range(contact.nodes):
        rules = list(enumerate(rows[:, :, node, -1].argmax(axis=1)))
        if rules[0][1] != rules[1][1]:
            equal = [
                (rows[way, k, node, :-1], rows[way, k, node, -1], right[way, k, node])
                for way, k in rules
            ]
            found[node] = [
                linprog_limit(contact, cycle, friction, equal=equal, least=least, **options)[1]
                for least in (True, False)
            ]
    return found


def fixed_contact(seed, most_nodes=6):
    """A coupled plane contact, its friction, and a cycle whose corners differ at load factor 0."""
    rng = np.random.default_rng(seed)
    nodes, corners = int(rng.integers(1, most_nodes + 1)), int(rng.integers(2, 5))
    contact = random_system(rng, nodes, coupling=rng.choice([0.0, 0.3, 0.7]))
    cases = {
        f"c{k}": (rng.normal(size=nodes), 0.2 * rng.normal(size=nodes)) for k in range(corners)
    }
    cases |= {
        f"f{k}": (0.2 * rng.normal(size=nodes), 0.3 * rng.normal(size=nodes))
        for k in range(corners)
    }
    cycle = fo.LoadCycle(
        {"mean": 1.0},
        [{f"c{k}": 1.0} for k in range(corners)],
        [{f"f{k}": 1.0} for k in range(corners)],
    )
    return contact.with_bonded(cases), cycle, rng.uniform(0.3, 0.8, size=nodes)


TO_AND_FRO = [{"Q": 1.0}, {"Q": -1.0}]


def rigid(points, normals):
    """(M, 3) or (M, 6) directions of reactions in the shifts and turns of body 1.

    They follow from the places and normals of the nodes.
    """
    n, axes = points.shape
    frames = frames_of(normals)
    shifts = [np.tile(axis, (n, 1)) for axis in np.eye(axes)]
    turns = (
        [np.column_stack([-points[:, 1], points[:, 0]])]
        if axes == 2
        else [np.cross(axis, points) for axis in np.eye(3)]
    )
    return np.column_stack(
        [np.einsum("nak,nk->an", frames, motion).ravel() for motion in [*shifts, *turns]]
    ), frames


def body(rng, points, normals, bonded, **more):
    """A body that only its contact holds.

    Its random stiffness does not resist its rigid motions.
    """
    motions, frames = rigid(points, normals)
    root = rng.normal(size=(len(motions),) * 2)
    off = np.eye(len(motions)) - motions @ np.linalg.pinv(motions)
    return fo.ContactSystem(
        off @ (root @ root.T + np.eye(len(root))) @ off, points, bonded, frames=frames, **more
    )


def block(rng, width=2.0, height=1.0, nodes=5, axes=2, **more):
    """A block on a plane: its weight P, and a push Q along x at its upper edge."""
    points = np.zeros((nodes, axes))
    points[:, 0] = np.linspace(-width / 2, width / 2, nodes)
    if axes == 3:
        points = np.array(
            [
                [x, y, 0.0]
                for x in np.linspace(-width / 2, width / 2, nodes)
                for y in (-1.0, 0.0, 1.0)
            ]
        )
    normals = np.eye(axes)[[-1] * len(points)]
    motions, _ = rigid(points, normals)
    # These are the forces of body 2 on body 1 along the axes, and their moments about the
    # origin.
    resultants = np.zeros((2, motions.shape[1]))
    resultants[0, axes - 1] = 1.0
    resultants[1, [0, 4 if axes == 3 else 2]] = -1.0, -height if axes == 3 else height
    forces = resultants @ np.linalg.pinv(motions)
    return body(rng, points, normals, dict(zip("PQ", forces, strict=True)), **more)


def largest_in_balance(motions, friction, r0, r1, least=False, strength=np.inf):
    """Largest or least load factor >= 0 with forces within friction in the plane, by scipy.

    The forces balance `r0 + lam r1` in all motions. The value is nan if there are none.
    """
    n = len(friction)
    eye = np.eye(n)
    rows = np.block(
        [[eye, -np.diag(friction), np.zeros((n, 1))], [-eye, -np.diag(friction), np.zeros((n, 1))]]
    )
    goal = np.eye(2 * n + 1)[-1] * (1.0 if least else -1.0)
    bounds = [(-most, most) for most in np.broadcast_to(strength, n)] + [(0, None)] * (n + 1)
    answer = linprog(
        goal,
        rows,
        np.zeros(2 * n),
        np.column_stack([motions.T, -motions.T @ r1]),
        motions.T @ r0,
        bounds=bounds,
    )
    assert answer.status in (0, 2, 3)
    return {0: answer.x[-1] if answer.x is not None else np.nan, 2: np.nan, 3: np.inf}[
        answer.status
    ]


def uncoupled(rng, nodes, tangents):
    """A contact in which only "mean" changes pressures, and the pressures under "mean"."""
    axes = tangents + 1
    root = rng.normal(size=(tangents * nodes,) * 2)
    S = np.zeros((axes * nodes,) * 2)
    S[:-nodes, :-nodes], S[-nodes:, -nodes:] = (
        root @ root.T / nodes + 0.3 * np.eye(tangents * nodes),
        10 * np.eye(nodes),
    )
    p = rng.uniform(0.5, 2.0, nodes)
    bonded = {
        name: np.r_[rng.normal(size=tangents * nodes), np.zeros(nodes)]
        for name in ("cyclic", "other")
    }
    points = np.column_stack([np.arange(nodes), *np.zeros((tangents, nodes))])
    return fo.ContactSystem(S, points, {**bonded, "mean": np.r_[np.zeros(tangents * nodes), p]}), p


def freed(contact):
    """The same contact without any resistance to a slide of all nodes."""
    n = contact.nodes
    project = np.eye(2 * n)
    project[:n, :n] -= 1 / n
    S = project @ contact.S @ project
    return fo.ContactSystem.from_blocks(
        S[:n, :n], S[n:, :n], S[n:, n:], contact.x, dict(contact.bonded)
    )


def stresses_of(contact):
    """A stress map of a contact: one point whose stress along x is the first slip."""
    motions = np.zeros((len(contact.S), 2, 1, 3, 3))
    motions[0, :, :, 0, 0] = 1.0
    cases = {name: np.zeros((2, 1, 3, 3)) for name in contact.bonded}
    cases["cyclic"] = np.broadcast_to(np.diag([1.0, 0.0, 0.0]), (2, 1, 3, 3))
    return fo.results.StressMap(contact, np.zeros((1, contact.tangents + 1)), cases, motions)


def of_mode(contact, cycle, frequency):
    """The contact whose load at the first corner is that of a mode of unit modal mass."""
    direction = np.array([cycle.corners[0].get(case, 0.0) for case in contact.bonded])
    square = (2 * np.pi * frequency * (direction @ direction)) ** 2
    return replace(contact, compliance=np.outer(direction, direction) / square)
