"""Boxes of elements of several shapes, as decks: each column of cells has a shape."""

from itertools import pairwise

import numpy as np

CUBE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
SIDES = [(0, 3, 2, 1), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
TYPES = {
    ("hexahedron", 1): "C3D8", ("wedge", 1): "C3D6", ("pyramid", 1): "C3D5", ("tetra", 1): "C3D4",
    ("hexahedron", 2): "C3D20", ("wedge", 2): "C3D15", ("tetra", 2): "C3D10",
}  # fmt: skip
# The edges of C3D20, C3D15 and C3D10, in the order of their nodes (CalculiX's manual).
EDGES = {
    "hexahedron": ["01", "12", "23", "30", "45", "56", "67", "74", "04", "15", "26", "37"],
    "wedge": ["01", "12", "20", "34", "45", "53", "03", "14", "25"],
    "tetra": ["01", "12", "20", "03", "13", "23"],
}


def cut(shape, corners):
    """The elements of a cell, by the points of its corners."""
    if shape == "hexahedron":
        return [("hexahedron", corners)]
    if shape == "wedge":
        return [("wedge", [corners[i] for i in (0, 1, 2, 4, 5, 6)]),
                ("wedge", [corners[i] for i in (0, 2, 3, 4, 6, 7)])]  # fmt: skip
    middle = tuple(np.mean(corners, axis=0).tolist())
    parts = [("pyramid", [*(corners[i] for i in side), middle]) for side in SIDES]
    if shape == "tetra":
        # The pyramids at the bottom and at the top are two tetrahedra each.
        for a, b, c, d, _ in [parts.pop(5)[1], parts.pop(0)[1]]:
            parts += [("tetra", [a, b, c, middle]), ("tetra", [a, c, d, middle])]
    return parts


def box(shapes, lines, order=1, bent=lambda x: x):
    """Points of the nodes, and (type, nodes) of the elements, of a box of cells on three lines.

    `shapes` has the shape of each column along x; `bent` moves each point.
    """
    number, elements = {}, []

    def node(point):
        return number.setdefault(tuple(np.round(point, 12).tolist()), len(number))

    for i, (x_low, x_high) in enumerate(pairwise(lines[0])):
        for y in pairwise(lines[1]):
            for z in pairwise(lines[2]):
                low = np.array([x_low, y[0], z[0]])
                size = np.array([x_high, y[1], z[1]]) - low
                for shape, corners in cut(shapes[i], [tuple(low + size * c) for c in CUBE]):
                    ends = [[corners[int(k)] for k in edge] for edge in EDGES.get(shape, [])]
                    middles = [np.mean(two, axis=0) for two in ends] if order == 2 else []
                    nodes = [node(point) for point in [*corners, *middles]]
                    elements.append((TYPES[shape, order], nodes))
    return np.array([bent(np.array(point)) for point in number]), elements


def deck(points, elements, name="BODY", first=1):
    """Nodes and elements of a box as text, numbered from `first` on."""
    text = f"*NODE, NSET=N{name}\n" + "".join(
        f"{i}, {', '.join(f'{v:.12g}' for v in point)}\n" for i, point in enumerate(points, first)
    )
    for kind in dict.fromkeys(kind for kind, _ in elements):
        text += f"*ELEMENT, TYPE={kind}, ELSET={name}\n"
        for i, (other, nodes) in enumerate(elements, first):
            entries = [str(first + n) for n in nodes]
            if other == kind:
                # CalculiX reads up to 16 entries of a line.
                lines = [", ".join(entries[k : k + 10]) for k in range(0, len(entries), 10)]
                text += f"{i}, " + ",\n".join(lines) + "\n"
    return text


def node_set(name, points, on, first=1):
    """A node set of the points where `on` holds."""
    rows = np.flatnonzero([on(point) for point in points])
    return f"*NSET, NSET={name}\n" + "".join(f"{first + i},\n" for i in rows)
