"""Blocks on a rigid base, by finite elements of their own: small contacts whose nodes lift off."""

import numpy as np

import frictopt as fo


def square_stiffness(size):
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


def block(seed, nodes=None, corners=None):
    """A random block of 4 to 7 nodes on a rigid base, its load cycle and friction.

    Its top is pressed in part, and pulled at a node. The cyclic loads are shears and pressures at
    the top. The block is free, held at one side, or held by soft springs at its top.
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

    def load(shear, pressure):
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
