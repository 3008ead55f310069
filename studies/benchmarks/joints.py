"""Joints of the size that users bring, with meshes by gmsh (extra `test`).

Lengths are in mm, forces in N.
"""

import math
from contextlib import contextmanager
from pathlib import Path

import gmsh

import frictopt as fo

LAP = Path(__file__).parents[2] / "docs/tutorial/lap.msh"
FRICTION = 0.15
# The shear is in kN.
SHEAR = fo.LoadCycle({"preload": 1.0}, [{"shear": 1.0}, {"shear": -1.0}])
PULL = fo.LoadCycle({"preload": 1.0}, [{"pull": 1.0, "side": 1.0}, {"pull": -1.0, "side": -1.0}])
VIBRATION = fo.LoadCycle({"spin": 1.0}, [{"vib": 1.0}, {"vib": -1.0}])
# These loads leave no symmetry of the punch.
ASKEW = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0, "Qx": 0.1, "Qy": 0.07}, {"sigma": 1.0}])
BOLTS = ("bolt1", "bolt2", "bolt3", "bolt4")


@contextmanager
def _mesh(path, size):
    """A mesh with elements of at most a given size, saved after the shapes are made and named."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        yield gmsh.model.occ
        gmsh.model.mesh.generate(gmsh.model.getDimension())
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def _name(name, dimension, tags):
    gmsh.model.addPhysicalGroup(dimension, tags, name=name)


def _in_box(dimension, low, high):
    found = gmsh.model.getEntitiesInBoundingBox(
        *(value - 0.1 for value in low), *(value + 0.1 for value in high), dim=dimension
    )
    return [tag for _, tag in found]


def flange(folder, size):
    """Two pipes that meet in a whole ring, with four bolts of 25 kN.

    The size 9 gives 747 contact nodes, the size 5 gives 1,096.
    """
    places = [
        (48 * math.cos(angle), 48 * math.sin(angle))
        for angle in (math.pi / 4 + k * math.pi / 2 for k in range(4))
    ]
    with _mesh(folder / "flange.msh", size) as occ:
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 16)

        def half(side):
            ring, pipe = (
                occ.addCylinder(0, 0, 0, 0, 0, side * height, radius)
                for height, radius in ((12, 60), (40, 36))
            )
            return occ.cut(
                occ.fuse([(3, ring)], [(3, pipe)])[0],
                [(3, occ.addCylinder(0, 0, 0, 0, 0, side * 40, 30))],
            )[0]

        halves = half(1) + half(-1)
        rings = occ.cut(
            halves, [(3, occ.addCylinder(x, y, -12, 0, 0, 24, 5.5)) for x, y in places]
        )[0]
        pins = []
        for x, y in places:
            for side in (1, -1):
                shank, head = (
                    occ.addCylinder(x, y, 0, 0, 0, side * 12, 5),
                    occ.addCylinder(x, y, side * 12, 0, 0, side * 6, 8.5),
                )
                pins += occ.fuse([(3, shank)], [(3, head)])[0]
        parts = [[tag for _, tag in part] for part in occ.fragment(rings, pins)[1]]
        occ.synchronize()
        solids = {
            "upper": parts[0],
            "lower": parts[1],
            **{bolt: parts[2 + 2 * k] + parts[3 + 2 * k] for k, bolt in enumerate(BOLTS)},
        }
        for name, tags in solids.items():
            _name(name, 3, tags)
        for bolt, (x, y) in zip(BOLTS, places, strict=True):
            _name(f"section of {bolt}", 2, _in_box(2, (x - 5, y - 5, 0), (x + 5, y + 5, 0)))
        for name, z in (("top", 40), ("bottom", -40)):
            _name(name, 2, _in_box(2, (-60, -60, z), (60, 60, z)))
    bodies = fo.fem.split_bodies(
        fo.readers.read_mesh(folder / "flange.msh"),
        dict.fromkeys(solids, fo.fem.Material(E=210e3, nu=0.3)),
    )
    pairs = [("upper", "lower"), *((bolt, plate) for bolt in BOLTS for plate in ("upper", "lower"))]
    contacts = [fo.fem.Contact(*pair, *pair[::-1], name=" on ".join(pair)) for pair in pairs]
    loads = {
        "preload": [fo.fem.BoltPreload(bolt, f"section of {bolt}", 25e3) for bolt in BOLTS],
        "shear": [fo.fem.Traction("upper", "top", x=1e3 / (math.pi * (36**2 - 30**2)))],
    }
    return fo.fem.ContactModel(
        bodies, contacts=contacts, supports=[fo.fem.Support("lower", "bottom")], loads=loads
    ).condense()


def lap_joint():
    """The lap joint of the tutorial."""
    bodies = fo.fem.split_bodies(
        fo.readers.read_mesh(LAP),
        dict.fromkeys(("upper", "lower", "bolt"), fo.fem.Material(E=210e3, nu=0.3)),
    )
    contacts = [
        fo.fem.Contact(*pair, *pair[::-1], name=pair[0])
        for pair in (("upper", "lower"), ("bolt", "upper"))
    ]
    contacts.append(fo.fem.Contact("bolt", "lower", "lower", "bolt", name="nut"))
    loads = {
        "preload": [fo.fem.BoltPreload("bolt", "section", 20e3)],
        "pull": [fo.fem.Traction("upper", "right", x=5.0)],
        "side": [fo.fem.Traction("upper", "right", y=0.5)],
    }
    return fo.fem.ContactModel(
        bodies, contacts=contacts, supports=[fo.fem.Support("lower", "left")], loads=loads
    ).condense()


def lap_of_three_bolts(folder):
    """The lap joint of the tutorial three times as wide, with three bolts: some 440 contact nodes.

    Returns the contact and its model.
    """
    with _mesh(folder / "bolts.msh", 7.0) as occ:
        gmsh.option.setNumber("Mesh.MeshSizeMin", 2.7)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
        upper, lower = (occ.addBox(x, 0, z, 60, 90, 8) for x, z in ((0, 0), (-20, -8)))
        places = [15, 45, 75]
        holes = [(3, occ.addCylinder(20, y, -8, 0, 0, 16, 5.5)) for y in places]
        plates = occ.cut([(3, upper), (3, lower)], holes)[0]
        pins = []
        for y in places:
            for side in (1, -1):
                shank = occ.addCylinder(20, y, 0, 0, 0, 8 * side, 5)
                head = occ.addCylinder(20, y, 8 * side, 0, 0, 5 * side, 9)
                pins += occ.fuse([(3, shank)], [(3, head)])[0]
        parts = [[tag for _, tag in part] for part in occ.fragment(plates, pins)[1]]
        occ.synchronize()
        bolts = ["left bolt", "middle bolt", "right bolt"]
        solids = {"upper": parts[0], "lower": parts[1]}
        solids |= {bolt: parts[2 + 2 * k] + parts[3 + 2 * k] for k, bolt in enumerate(bolts)}
        for name, tags in solids.items():
            _name(name, 3, tags)
        for bolt, y in zip(bolts, places, strict=True):
            _name(f"section of {bolt}", 2, _in_box(2, (15, y - 5, 0), (25, y + 5, 0)))
        _name("loaded", 2, _in_box(2, (60, 0, 0), (60, 90, 8)))
        _name("held", 2, _in_box(2, (-20, 0, -8), (-20, 90, 0)))
    steel = fo.fem.Material(E=210e3, nu=0.3)
    bodies = fo.fem.split_bodies(
        fo.readers.read_mesh(folder / "bolts.msh"), dict.fromkeys(solids, steel)
    )
    pairs = [("upper", "lower"), *((bolt, plate) for bolt in bolts for plate in ("upper", "lower"))]
    loads = {
        "preload": [fo.fem.BoltPreload(bolt, f"section of {bolt}", 20e3) for bolt in bolts],
        "pull": [fo.fem.Traction("upper", "loaded", x=5.0)],
        "side": [fo.fem.Traction("upper", "loaded", y=0.5)],
    }
    model = fo.fem.ContactModel(
        bodies,
        contacts=[fo.fem.Contact(*pair, *pair[::-1], name=" on ".join(pair)) for pair in pairs],
        supports=[fo.fem.Support("lower", "held")],
        loads=loads,
        units="N, mm",
    )
    return model.condense(), model


def fir_tree(folder, size=0.25):
    """A blade in a disc, in the plane, on four flanks with 96 contact nodes.

    More than half of the nodes open when the blade spins.
    """
    blade = [(10, 30), (10, 0), (16, -6), (8, -14), (14, -20), (6, -28)]
    disc = [
        (40, -60),
        (40, 3),
        (12, 3),
        (11, -1),
        (15, -5),
        (18, -6),
        (18, -8),
        (9.3, -13.7),
        (9, -15),
        (13, -19),
        (16, -20),
        (16, -32),
    ]
    # Low and high corners of the boxes of the right flanks.
    flanks = {
        "1": ((11, -5), (15, -1)),
        "2": ((9, -19), (13, -15)),
    }
    with _mesh(folder / "fir.msh", 4) as occ:

        def outline(right):
            points = [occ.addPoint(x, y, 0) for x, y in right + [(-x, y) for x, y in right[::-1]]]
            return 2, occ.addPlaneSurface(
                [
                    occ.addCurveLoop(
                        [
                            occ.addLine(*ends)
                            for ends in zip(points, points[1:] + points[:1], strict=True)
                        ]
                    )
                ]
            )

        parts = occ.fragment([outline(blade)], [outline(disc)])[1]
        occ.synchronize()
        for name, part in zip(("blade", "disc"), parts, strict=True):
            _name(name, 2, [tag for _, tag in part])
        curves = {
            "top": _in_box(1, (-10, 30, 0), (10, 30, 0)),
            "bottom": _in_box(1, (-40, -60, 0), (40, -60, 0)),
        }
        for number, ((x1, y1), (x2, y2)) in flanks.items():
            curves |= {
                f"R{number}": _in_box(1, (x1, y1, 0), (x2, y2, 0)),
                f"L{number}": _in_box(1, (-x2, y1, 0), (-x1, y2, 0)),
            }
        for name, tags in curves.items():
            _name(name, 1, tags)
        fields = gmsh.model.mesh.field
        away, sizes = fields.add("Distance"), fields.add("Threshold")
        fields.setNumbers(
            away,
            "CurvesList",
            [tag for name, tags in curves.items() if name[0] in "RL" for tag in tags],
        )
        fields.setNumber(away, "Sampling", 200)
        for option, value in {
            "InField": away,
            "SizeMin": size,
            "SizeMax": 4,
            "DistMin": 0.5,
            "DistMax": 15,
        }.items():
            fields.setNumber(sizes, option, value)
        fields.setAsBackgroundMesh(sizes)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    bodies = fo.fem.split_bodies(
        fo.readers.read_mesh(folder / "fir.msh"),
        dict.fromkeys(("blade", "disc"), fo.fem.Material(E=115e3, nu=0.33)),
    )
    contacts = [
        fo.fem.Contact("blade", "disc", name, name, name=name) for name in ("R1", "R2", "L1", "L2")
    ]
    spin = [
        fo.fem.Centrifugal(body, density=4.4e-9, speed=1200.0, centre=(0.0, -300.0))
        for body in ("blade", "disc")
    ]
    loads = {
        "spin": [*spin, fo.fem.Traction("blade", "top", y=60.0)],
        "vib": [fo.fem.Traction("blade", "top", x=1.0)],
    }
    return fo.fem.ContactModel(
        bodies, contacts=contacts, supports=[fo.fem.Support("disc", "bottom")], loads=loads
    ).condense()
