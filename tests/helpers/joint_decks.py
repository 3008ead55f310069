"""Decks of a slider on a base, and the forces that the contact carries."""

from itertools import product

import numpy as np

import frictopt as fo

MATERIAL = """*MATERIAL, NAME=STEEL
*ELASTIC
1000., 0.3
*DENSITY
2.
*EXPANSION
1.E-4
"""
PAIR = """*SURFACE INTERACTION, NAME=DRY
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
1.E7
*FRICTION
0.5, 1.E6
*CONTACT PAIR, INTERACTION=DRY, TYPE=SURFACE TO SURFACE
SLOW, SHIGH
"""
HELD = "*BOUNDARY\nNBASE, 1, 3\n"
# A cap over the slider, .01 above it, under a lid; no body of the plane strains across.
CAP = """*NODE
21, 0, 2.01, 0
22, .7, 2.01, 0
23, 1.4, 2.01, 0
24, 2, 2.01, 0
25, 0, 3, 0
26, .7, 3, 0
27, 1.4, 3, 0
28, 2, 3, 0
*NSET, NSET=NCAP
21, 22, 23, 24, 25, 26, 27, 28
*NSET, NSET=NLID
25, 26, 27, 28
*ELEMENT, TYPE=CPS4, ELSET=CAP
5, 21, 22, 26, 25
6, 22, 23, 27, 26
7, 23, 24, 28, 27
*SOLID SECTION, ELSET=CAP, MATERIAL=STEEL
2.
*SURFACE, NAME=SFOOT
CAP, S1
*BOUNDARY
NLID, 2, 2
NALL, 1, 1
NCAP, 1, 1
"""
PRESS = "*DLOAD\nETOP, P3, 10.\n"


def mesh(kind="CPS4", *, lift=0.0, shift=0.0):
    """The slider, 2 x 1 (x 1), elements 3 and 4, on the base, elements 1 and 2; y is upright.

    `lift` is the gap between them, `shift` the least x. Faces S1 are below, S3 on top; in space
    these are S3 and S5.
    """
    in_space = kind.startswith("C3D")
    depths = (0, 1) if in_space else (0,)
    number = {}
    lines = []
    for body, level in enumerate((0, 1)):
        for z, y, x in product(depths, (level, level + 1), (0, 1, 2)):
            number[body, x, y, z] = len(number) + 1
            lines.append(f"{len(number)}, {x + shift:g}, {y + body * lift:.12g}, {z}")
    elements = []
    for body, x in product((0, 1), (0, 1)):
        ring = [(x, body), (x + 1, body), (x + 1, body + 1), (x, body + 1)]
        elements.append([number[body, *corner, z] for z in depths for corner in ring])
    low, high = ("S3", "S5") if in_space else ("S1", "S3")
    listed = [", ".join(map(str, [n, *nodes])) for n, nodes in enumerate(elements, start=1)]

    def nodes(body, y):
        return ", ".join(
            str(n) for (b, _, height, _), n in number.items() if (b, height) == (body, y)
        )

    return "\n".join(
        [
            "*NODE, NSET=Nall",
            *lines,
            f"*ELEMENT, TYPE={kind}, ELSET=BASE",
            *listed[:2],
            f"*ELEMENT, TYPE={kind}, ELSET=SLIDER",
            *listed[2:],
            f"*NSET, NSET=NBASE\n{nodes(0, 0)}",
            f"*NSET, NSET=NTOP\n{nodes(1, 2)}",
            "*ELSET, ELSET=ETOP\n3, 4",
            f"*SURFACE, NAME=SLOW\nSLIDER, {low}",
            f"*SURFACE, NAME=SHIGH\nBASE, {high}",
            f"*SURFACE, NAME=STOP\nSLIDER, {high}",
            "*SOLID SECTION, ELSET=BASE, MATERIAL=STEEL\n2.",
            "*SOLID SECTION, ELSET=SLIDER, MATERIAL=STEEL\n2.",
            "",
        ]
    )


def steps(*contents):
    """A static step with each content."""
    return "".join(f"*STEP, NLGEOM\n*STATIC\n1., 1.\n{text}*END STEP\n" for text in contents)


def deck(*contents, kind="CPS4", more="", held=HELD, pair=PAIR, material=MATERIAL, **places):
    """A whole deck with steps of these contents."""
    return mesh(kind, **places) + material + pair + held + more + steps(*contents)


def joint_of(folder, text, **options):
    """The joint of a deck."""
    (folder / "joint.inp").write_text(text)
    return fo.read_joint(folder / "joint.inp", **options)


def carried(joint, loads):
    """Total force of the slider on the base in x, y (and z) under some loads, glued."""
    system = joint.system()
    q, p = system.reaction(loads)
    forces = np.column_stack([q, p])
    return -(forces[:, :, None] * system.frames).sum(axis=(0, 1))


def of_states(joint):
    """The force that the contact carries in each state."""
    return {name: carried(joint, loads).round(9).tolist() for name, loads in joint.states.items()}
