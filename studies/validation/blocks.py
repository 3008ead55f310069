"""Contacts that lift off.

Blocks on a rigid base and clamps are finite elements. The contacts in space are random.
"""

from typing import Any

import numpy as np

import frictopt as fo

# A contact, its load cycle and friction.
Case = tuple[fo.ContactSystem, fo.LoadCycle, float]


def square_stiffness(size: float) -> Any:
    """(8, 8) stiffness of a bilinear square in plane strain, with E = 1 and nu = 0.3."""
    nu = 0.3
    D = np.array([[1 - nu, nu, 0], [nu, 1 - nu, 0], [0, 0, (1 - 2 * nu) / 2]])
    D /= (1 + nu) * (1 - 2 * nu)
    K = np.zeros((8, 8))
    for a in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
        for b in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
            by_x = np.array([-(1 - b), 1 - b, 1 + b, -(1 + b)]) / 2 / size
            by_y = np.array([-(1 - a), -(1 + a), 1 + a, 1 - a]) / 2 / size
            B = np.zeros((3, 8))
            B[0, 0::2] = B[2, 1::2] = by_x
            B[1, 1::2] = B[2, 0::2] = by_y
            K += B.T @ D @ B * size**2 / 4
    return K


def block(seed: int, nodes: int | None = None, corners: int | None = None) -> Case:
    """A random block of 4 to 7 nodes on a rigid base, its load cycle and friction.

    The top of the block is pressed in part, and pulled at a node. The cyclic loads are shears and
    pressures at the top. The block is free, held at one side, or held by soft springs at its top.
    """
    rng = np.random.default_rng([seed, 94])
    nodes = nodes or int(rng.integers(4, 8))
    layers = int(rng.integers(1, 4))
    size = 0.25
    held = rng.choice(["free", "side", "springs"])
    count = nodes * (layers + 1)
    K = np.zeros((2 * count, 2 * count))
    for j in range(layers):
        for i in range(nodes - 1):
            first = j * nodes + i
            at = [first, first + 1, first + nodes + 1, first + nodes]
            dofs = np.ravel([[2 * k, 2 * k + 1] for k in at])
            K[np.ix_(dofs, dofs)] += square_stiffness(size)
    top = np.arange(layers * nodes, count)
    fixed = []
    if held == "side":
        ends = np.arange(2, layers + 2) * nodes - 1
        fixed = np.r_[2 * ends, 2 * ends + 1].tolist()
    if held == "springs":
        K[2 * top, 2 * top] += 0.1
        K[2 * top + 1, 2 * top + 1] += 0.05

    def load(shear: Any, pressure: Any) -> Any:
        forces = np.zeros(2 * count)
        forces[2 * top] = shear
        forces[2 * top + 1] = -pressure
        return forces

    begin, end = sorted(rng.integers(0, nodes, 2))
    pressure = np.zeros(nodes)
    pressure[begin : end + 1] = rng.uniform(0.5, 1.5)
    if rng.random() < 0.4:
        pressure[rng.integers(nodes)] -= rng.uniform(0, 0.8)
    loads = {"mean": load(np.full(nodes, rng.normal(0, 0.05) * (rng.random() < 0.3)), pressure)}
    for k in range(corners or int(rng.choice([1, 2, 2, 2, 3]))):
        shear = np.zeros(nodes)
        pressure = np.zeros(nodes)
        if rng.random() < 0.5:
            shear[:] = rng.normal()
        else:
            shear[rng.integers(nodes)] = 2 * rng.normal()
        if rng.random() < 0.5:
            pressure[rng.integers(nodes)] = rng.normal() * rng.choice([0.3, 1.0])
        loads[f"c{k}"] = load(shear, pressure)
    cycle = fo.LoadCycle({"mean": 1.0}, [{name: 1.0} for name in loads if name != "mean"])

    contact = np.r_[2 * np.arange(nodes), 2 * np.arange(nodes) + 1]
    others = np.setdiff1d(np.arange(2 * count), np.r_[contact, fixed].astype(int))
    within = np.linalg.inv(K[np.ix_(others, others)])
    across = K[np.ix_(contact, others)] @ within
    S = K[np.ix_(contact, contact)] - across @ K[np.ix_(others, contact)]
    reactions = {name: across @ part[others] - part[contact] for name, part in loads.items()}
    gap = rng.exponential(0.3, nodes) * (rng.random(nodes) < 0.3) * (rng.random() < 0.3)
    points = np.column_stack([size * np.arange(nodes), np.zeros(nodes)])
    system = fo.ContactSystem((S + S.T) / 2, points, reactions, gap=gap)
    return system, cycle, float(rng.choice([0.2, 0.4, 0.6, 0.9]))


def clamp(seed: int, noise: float = 0.0, member: int = 0) -> Case:
    """A bolt of C shape that grips a rigid plate at 14 nodes, its load cycle and friction.

    `noise`: relative size of random changes of all numbers; `member` is their seed.
    """
    rng = np.random.default_rng([seed, 14])
    arm, back, opening = (int(number) for number in rng.integers(1, [3, 3, 4]))
    across, height = back + 6, 2 * arm + opening
    cells = [
        (i, j)
        for i in range(across)
        for j in range(height)
        if i < back or not arm <= j < arm + opening
    ]
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    places = sorted({(i + a, j + b) for i, j in cells for a, b in corners})
    number = {place: k for k, place in enumerate(places)}
    K = np.zeros((2 * len(places),) * 2)
    for i, j in cells:
        dofs = np.ravel([[2 * k, 2 * k + 1] for k in (number[i + a, j + b] for a, b in corners)])
        K[np.ix_(dofs, dofs)] += square_stiffness(0.25)
    spine = np.array([number[0, j] for j in range(height + 1)])
    springs = np.r_[2 * spine, 2 * spine + 1]
    K[springs, springs] += 10 ** rng.uniform(-3, -1)

    def load(shear: float = 0.0, lift: float = 0.0, tip: float = 0.0) -> Any:
        forces = np.zeros(len(K))
        forces[2 * spine] = shear / len(spine)
        forces[2 * spine + 1] = lift / len(spine)
        forces[2 * number[across, height]] += tip
        return forces

    loads = {"bolt": load(0.1 * rng.normal() * (rng.random() < 0.5))}
    gripped = back + int(rng.integers(2, 6))
    loads["bolt"][2 * number[gripped, height] + 1] -= 1.0
    loads["bolt"][2 * number[gripped, 0] + 1] += 1.0
    kind = rng.integers(3)
    loads["c0"] = load(rng.normal(), rng.normal() * (kind == 1), rng.normal() * (kind == 2))
    loads["c1"] = -loads["c0"] if rng.random() < 0.6 else load(rng.normal(), 0.3 * rng.normal())

    jaws = [number[i, j] for j in (arm, arm + opening) for i in range(back, across + 1)]
    contact = np.r_[2 * np.array(jaws), 2 * np.array(jaws) + 1]
    # The gap of the lower jaw opens downwards.
    sign = np.where((np.arange(28) >= 14) & (np.arange(28) < 21), -1.0, 1.0)
    others = np.setdiff1d(np.arange(len(K)), contact)
    follow = K[np.ix_(contact, others)] @ np.linalg.inv(K[np.ix_(others, others)])
    S = K[np.ix_(contact, contact)] - follow @ K[np.ix_(others, contact)]
    S = (S + S.T) / 2 * np.outer(sign, sign)
    random = np.random.default_rng(member)
    changes = random.normal(size=S.shape)
    S *= 1 + noise * (changes + changes.T) / 2
    reactions = {}
    for name, part in loads.items():
        r = (follow @ part[others] - part[contact]) * sign
        reactions[name] = r * (1 + noise * random.normal(size=len(r)))
    points = np.column_stack([0.25 * np.arange(14), np.zeros(14)])
    cycle = fo.LoadCycle({"bolt": 1.0}, [{"c0": 1.0}, {"c1": 1.0}])
    return fo.ContactSystem(S, points, reactions), cycle, float(rng.choice([0.15, 0.3, 0.5]))


def in_space(seed: int, nodes: int) -> Case:
    """A random contact in space, whose mean load leaves nodes open."""
    rng = np.random.default_rng([seed, 64])
    G = rng.normal(size=(3 * nodes, 3 * nodes))
    S: Any = G @ G.T / nodes + 0.3 * np.eye(3 * nodes)
    pressed = rng.uniform(0.5, 1.5, nodes)
    pressed[rng.random(nodes) < 0.4] *= -0.5
    shear = np.zeros((2, nodes))
    loads: dict[str, Any] = {
        "mean": np.concatenate([*shear, pressed]),
        "a": np.concatenate([*rng.normal(size=(2, nodes)), 0.3 * rng.normal(size=nodes)]),
        "b": np.concatenate([*rng.normal(size=(2, nodes)), 0.3 * rng.normal(size=nodes)]),
    }
    gap = 0.3 * rng.random(nodes) * (rng.random(nodes) < 0.3)
    points = np.column_stack([np.arange(float(nodes)), np.zeros((nodes, 2))])
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}, {"a": -1.0}])
    return fo.ContactSystem(S, points, loads, gap=gap), cycle, float(rng.uniform(0.2, 0.8))
