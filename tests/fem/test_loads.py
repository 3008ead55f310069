"""Loads, plane stress and axisymmetry against closed forms."""

import numpy as np
import pytest
from skfem import MeshQuad

import frictopt as fo
from helpers.meshes import box
from helpers.refused import refused

STEEL = fo.fem.Material(E=3.0, nu=0.3)
TOP = [fo.fem.Support("upper", "y+", "y")]


def column(
    kinematics="plane_strain", loads=None, supports=(), half=1.0, material=STEEL, element=None
):
    """Two blocks one on the other, on rollers, from y = -1 to 2.

    Their sides are 0 <= x <= half (axisymmetric: from 0.5).
    """
    x = np.linspace(0.5 if kinematics == "axisymmetric" else 0.0, half, 5)
    upper = box(MeshQuad, x, np.linspace(0.0, 2.0, 5))
    lower = box(MeshQuad, x, np.linspace(-1.0, 0.0, 4))
    beside = [
        fo.fem.Support("lower", (0.0, -1.0), "x"),
        fo.fem.Support("lower", (0.0, 0.0), "x"),
        fo.fem.Support("upper", (0.0, 2.0), "x"),
    ]
    return fo.fem.ContactModel(
        bodies={
            "upper": fo.fem.Body(upper, material, element),
            "lower": fo.fem.Body(lower, material, element),
        },
        supports=[
            fo.fem.Support("lower", "y-", "y"),
            *(beside if kinematics != "axisymmetric" else []),
            *supports,
        ],
        loads=loads or {"P": [fo.fem.Traction("upper", "y+", y=-1.0)]},
        kinematics=kinematics,
    )


def ring(loads, inner=0.5, outer=2.0, height=0.02, elements=40):
    """A disc with a hole, cut at radius 1 and glued again."""
    z = [0.0, height]
    hub = MeshQuad.init_tensor(np.linspace(inner, 1.0, elements + 1), z).with_boundaries(
        {"contact": lambda x: x[0] == 1.0, "bore": lambda x: x[0] == inner}
    )
    rim = MeshQuad.init_tensor(np.linspace(1.0, outer, 2 * elements + 1), z).with_boundaries(
        {"contact": lambda x: x[0] == 1.0}
    )
    return fo.fem.ContactModel(
        bodies={"rim": fo.fem.Body(rim, STEEL), "hub": fo.fem.Body(hub, STEEL)},
        supports=[fo.fem.Support("hub", (inner, 0.0), "y")],
        loads=loads,
        kinematics="axisymmetric",
    )


def glued(model, **loads):
    n = model.condense().nodes
    return model.recover(loads, np.zeros(n))


def at(model, fields, name, body):
    """Radii of the nodes of a body, and a field there."""
    return model.bodies[body].mesh.p[0], getattr(fields, name)[body]


@pytest.mark.parametrize("element", ["linear", "quadratic"])
@pytest.mark.parametrize("kinematics", ["plane_strain", "plane_stress", "axisymmetric"])
def test_uniform_tension(kinematics, element):
    model = column(kinematics, element=element)
    fields = glued(model, P=-2.0)
    normal = {"plane_strain": STEEL.nu * 2.0, "plane_stress": 0.0, "axisymmetric": 0.0}[kinematics]
    strain = (2.0 - STEEL.nu * normal) / STEEL.E
    for body in ("upper", "lower"):
        assert np.allclose(
            fields.stress[body], np.array([0.0, 2.0, 0.0, normal])[:, None], atol=1e-10
        )
        assert np.allclose(fields.strain[body][1], strain)
        assert np.allclose(fields.strain[body][3], (normal - STEEL.nu * 2.0) / STEEL.E, atol=1e-10)
    assert np.allclose(fields.p / model.condense().width, -2.0)


@pytest.mark.parametrize("element", ["linear", "quadratic"])
@pytest.mark.parametrize("kinematics", ["plane_strain", "plane_stress", "axisymmetric"])
def test_free_expansion_without_stress(kinematics, element):
    model = column(
        kinematics,
        element=element,
        loads={
            "T": [
                fo.fem.Expansion("upper", 0.01),
                fo.fem.Expansion("lower", lambda x, y: 0.01 + 0 * x),
            ]
        },
    )
    fields = glued(model, T=2.0)
    for body in ("upper", "lower"):
        out = -STEEL.E * 0.02 if kinematics == "plane_strain" else 0.0
        assert np.allclose(fields.stress[body], np.array([0.0, 0.0, 0.0, out])[:, None], atol=1e-12)
        grows = 0.02 * (1 + STEEL.nu) if kinematics == "plane_strain" else 0.02
        assert np.allclose(
            fields.strain[body],
            np.array([grows, grows, 0.0, 0.0 if out else 0.02])[:, None],
            atol=1e-12,
        )
    assert np.abs([fields.q, fields.p]).max() < 1e-12


def cylinders(bore=0.0, loads=None, directions="y"):
    """Two cylinders one on the other, around the axis or a bore."""

    def cylinder(z, other):
        face = {"contact": lambda x: x[1] == 0.0, "end": lambda x: x[1] == other}
        return fo.fem.Body(
            MeshQuad.init_tensor(np.r_[bore, 0.25, 0.5, 1.0], z).with_boundaries(face), STEEL
        )

    bodies = {"upper": cylinder([0.0, 1.0, 2.0], 2.0), "lower": cylinder([-1.0, 0.0], -1.0)}
    loads = {"P": loads or [fo.fem.Traction("upper", "end", y=-1.0)]}
    return fo.fem.ContactModel(
        bodies, [fo.fem.Support("lower", "end", directions)], loads, kinematics="axisymmetric"
    )


@pytest.mark.parametrize("bore", [0.0, 1e-3])
def test_bodies_of_revolution_meet_on_their_axis_and_around_a_bore(bore):
    model = cylinders(bore)
    system = model.condense()
    assert glued(model, P=1.0).p / system.width == pytest.approx(1.0)
    assert system.bonded["P"][1] / system.width == pytest.approx(1.0)
    assert np.abs(system.bonded["P"][0]).max() < 1e-12


@pytest.mark.parametrize("nu", [0.3, 0.4999, 0.499999])
def test_a_linear_temperature_bends_a_body_without_stress_however_little_its_volume_changes(nu):
    x, y = np.linspace(0.0, 2.0, 17), np.linspace(0.0, 1.0, 9)
    bodies = {
        name: fo.fem.Body(box(MeshQuad, x, y + low), fo.fem.Material(1.0, nu), "mean_dilatation")
        for name, low in (("a", 0.0), ("b", -1.0))
    }
    heat = [fo.fem.Expansion(name, lambda x, y: x) for name in bodies]
    model = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("b", (0.0, -1.0)), fo.fem.Support("b", (2.0, -1.0), "y")],
        {"T": heat},
    )
    fields = glued(model, T=1.0)
    shape = [
        (1 + nu) * np.array([x**2 - y**2, 2 * x * y]) / 2
        for x, y in (body.mesh.p for body in bodies.values())
    ]
    moved = np.hstack([fields.displacement[name] for name in bodies]) - np.hstack(shape)
    x, y = np.hstack([body.mesh.p for body in bodies.values()])
    rigid = np.vstack(
        [np.column_stack([1 + 0 * x, 0 * x, -y]), np.column_stack([0 * x, 1 + 0 * x, x])]
    )
    left = moved.ravel() - rigid @ np.linalg.lstsq(rigid, moved.ravel(), rcond=None)[0]
    assert np.abs(left).max() < 0.01 * (1 + nu)
    assert np.abs(fields.stress["a"][:3]).max() < 0.1 * 2  # of E times the largest strain


@pytest.mark.parametrize("inner", [0.01, 1.0])
@pytest.mark.parametrize("elements", [(7, 7), (7, 5), (5, 8)])
def test_uniform_pressure_passes_between_rings_that_do_not_match(inner, elements):
    one, two = (inner + np.linspace(0.0, 1.0, n + 1) ** 1.2 for n in elements)
    bodies = {
        "upper": fo.fem.Body(box(MeshQuad, one, [0.0, 0.4, 1.0])),
        "lower": fo.fem.Body(box(MeshQuad, two, [-1.0, -0.3, 0.0])),
    }
    model = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("lower", "y-", "y")],
        {"P": [fo.fem.Pressure("upper", "y+")]},
        kinematics="axisymmetric",
    )
    fields, width = glued(model, P=1.0), model.condense().width
    assert np.allclose(fields.p, width, atol=1e-12 * width.sum()) and np.abs(fields.q).max() < 1e-12
    assert width.sum() == pytest.approx(np.pi * ((inner + 1) ** 2 - inner**2))
    for body in bodies:
        assert np.allclose(fields.stress[body], np.array([0.0, -1.0, 0.0, 0.0])[:, None], atol=1e-9)


def test_a_prescribed_displacement_is_the_equivalent_traction():
    cork = fo.fem.Material(E=3.0, nu=0.0)
    pulled = column(material=cork).condense().bonded["P"]
    held = [fo.fem.Support("upper", "y+", "y")]
    top = {"D": [fo.fem.Displacement("upper", "y+", y=-1.0)]}
    bottom = {"D": [fo.fem.Displacement("lower", "y-", y=lambda x, y: 1.0 + 0 * x)]}
    rigid = {"D": [fo.fem.Displacement("lower", where, y=2.0 / 3.0) for where in ("y-", "contact")]}
    for loads, supports in (
        (top, held),
        (bottom, held),
        (rigid, [*held, fo.fem.Support("lower", "contact", "y")]),
    ):
        model = column(loads=loads, supports=supports, material=cork)
        assert np.allclose(model.condense().bonded["D"], pulled, atol=1e-10)
        fields = glued(model, D=1.0)
        assert np.allclose([fields.q, fields.p], pulled, atol=1e-10)
        assert np.allclose(fields.stress["upper"][1], -1.0)


def test_the_end_of_a_cylinder_may_grow_about_its_axis():
    model = cylinders(
        loads=[
            fo.fem.Displacement("lower", "end", x=lambda x, y: 0.1 * x),
            *(fo.fem.Expansion(name, 0.1) for name in ("upper", "lower")),
        ],
        directions="xy",
    )
    assert np.abs(glued(model, P=1.0).stress["lower"]).max() < 1e-12


def test_displacements_that_share_a_node_agree_or_are_refused():
    hold = [fo.fem.Support("upper", "y+", "y")]

    def moved(*parts):
        return column(loads={"D": list(parts)}, supports=hold).condense().bonded["D"][1]

    down = fo.fem.Displacement("upper", "y+", y=lambda x, y: -0.01 * x)
    assert np.array_equal(
        moved(down), moved(down, fo.fem.Displacement("upper", (1.0, 2.0), y=-0.01))
    )
    for other in (
        fo.fem.Displacement("upper", (1.0, 2.0), y=-0.02),
        fo.fem.Displacement("upper", "y+", y=0.0),
    ):
        for parts in ((down, other), (other, down)):
            with pytest.raises(
                fo.ModelError, match=r"move the node at \(.*, 2\) differently in y; give one"
            ):
                moved(*parts)


def test_a_spinning_disc():
    """A spinning ring has the stresses of a thin ring.

    Timoshenko & Goodier, Theory of Elasticity, section 32.
    """
    density, speed, a, b, nu = 2.0, 0.7, 0.5, 2.0, STEEL.nu
    model = ring({"spin": [fo.fem.Centrifugal(body, density, speed) for body in ("rim", "hub")]})
    fields = glued(model, spin=1.0)
    for body in ("rim", "hub"):
        r, (radial, axial, _, hoop) = at(model, fields, "stress", body)
        inside = (r > 0.53) & (r < 1.97) & (np.abs(r - 1) > 0.03)
        pull = (3 + nu) / 8 * density * speed**2
        assert np.allclose(
            radial[inside],
            (pull * (a**2 + b**2 - (a * b / r) ** 2 - r**2))[inside],
            atol=4e-3 * pull * b**2,
        )
        expected = pull * (a**2 + b**2 + (a * b / r) ** 2 - (1 + 3 * nu) / (3 + nu) * r**2)
        assert np.allclose(hoop[inside], expected[inside], atol=4e-3 * pull * b**2)
        assert np.abs(axial[inside]).max() < 4e-3 * pull * b**2


def test_loads_add_up_to_their_integrals():
    mesh = box(MeshQuad, np.linspace(1, 3, 4), np.linspace(0, 1, 3))
    around = 2 * np.pi * 4.0  # integral of x over the section
    for load, kinematics, expected in (
        (fo.fem.Centrifugal("b", 2.0, 3.0, (1.0, 0.0)), "plane_strain", [36.0, 18.0]),
        (fo.fem.BodyForce("b", y=-3.0), "axisymmetric", [0.0, -3 * around]),
        (fo.fem.Pressure("b", "y+", 1.0), "axisymmetric", [0.0, -around]),
    ):
        assert np.allclose(load._forces(fo.fem.Body(mesh), kinematics).sum(axis=1), expected)


@refused(
    (lambda: fo.fem.Displacement("b", "y+"), "Displacement: x, y and z are all missing"),
    (
        lambda: fo.fem.Traction("b", "y+"),
        "Traction: x, y and z are all missing; give at least one",
    ),
    (lambda: fo.fem.BodyForce("b"), "BodyForce: x, y and z are all missing; give at least one"),
    (lambda: fo.fem.Displacement("b", (1.0,), x=1.0), "give the name of a boundary, one point"),
    (
        lambda: column(loads={"P": [fo.fem.Pressure("upper", "y+", lambda x, y: 1 / 0)]}),
        "the function raised ZeroDivisionError",
    ),
    (
        lambda: column(loads={"P": [fo.fem.Pressure("upper", "y+", lambda x, y: np.ones(3))]}),
        r"the function gave shape \(3,\)",
    ),
    (
        lambda: column(loads={"P": [fo.fem.Pressure("upper", "y+", lambda x, y: x * np.nan)]}),
        "pressure, of the function: nan at index",
    ),
    (
        lambda: column(loads={"P": [fo.fem.Pressure("upper", "none")]}),
        r"loads\['P'\]: boundary 'none' is unknown",
    ),
    (lambda: column(loads={"P": [fo.fem.BodyForce("none", y=1.0)]}), "body: 'none'; give"),
    (
        lambda: column(loads={"P": [fo.fem.Displacement("upper", "y+", y=1.0)]}),
        "moves nodes in y that no support holds",
    ),
    (
        lambda: column(supports=TOP),
        r"loads\['P'\]: \[.*body='upper'.* act only where supports hold .*'y\+', directions='y'",
    ),
    (
        lambda: column("axisymmetric", {"P": [fo.fem.Pressure("upper", "y+")]}, TOP),
        "load another boundary, or hold fewer directions",
    ),
    (lambda: column("axisymmetric", half=-1.0), "x is the radius, >= 0"),
    (
        lambda: cylinders(loads=[fo.fem.Displacement("lower", "end", x=0.1)], directions="xy"),
        "'lower'.* moves nodes by 0.1 off the axis, x = 0",
    ),
    (
        lambda: column(
            "axisymmetric", loads={"P": [fo.fem.Centrifugal("upper", 1.0, centre=(1.0, 0.0))]}
        ),
        "spin about their axis",
    ),
)
def test_bad_loads_are_refused(make):
    make()
