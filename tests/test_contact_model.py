import numpy as np
import pytest
from skfem import MeshQuad, MeshTet, MeshTri, MeshTri2

import frictopt as fo
from frictopt.reference import patch_limit

X = np.array([-1.0, -0.5, 0.1, 1.0])
BOXES = {"left": lambda x: x[0] == -1.0, "right": lambda x: x[0] == 1.0}


def bodies(kind=MeshQuad, x_punch=X, x_block=X, gap=0.0, material=None, element="linear"):
    y = np.array([0.0, 0.4, 1.0])
    punch = kind.init_tensor(x_punch, y + gap).with_boundaries({**BOXES, "contact": lambda x: x[1] == gap, "top": lambda x: x[1] == 1.0 + gap})
    block = kind.init_tensor(x_block, -y[::-1]).with_boundaries({**BOXES, "contact": lambda x: x[1] == 0.0, "bottom": lambda x: x[1] == -1.0})
    material = material or fo.Material()
    return fo.Body(punch, material, element), fo.Body(block, material, element)


FREE = [fo.Support("block", (-1.0, -1.0), "xy"), fo.Support("block", (1.0, -1.0), "y")]
LOADS = {
    "p": [fo.Traction("punch", "top", y=-1.0), fo.Traction("block", "bottom", y=1.0)],
    "tau": [fo.Traction("punch", "top", x=1.0), fo.Traction("block", "bottom", x=-1.0)]
    + [fo.Traction(body, side, y=sign) for body in ("punch", "block") for side, sign in (("right", 1.0), ("left", -1.0))],
}


def patch(kind=MeshQuad, **options):
    return fo.ContactModel(*bodies(kind, **options), supports=FREE, loads=LOADS)


@pytest.mark.parametrize("kind", [MeshQuad, MeshTri])
@pytest.mark.parametrize("element", ["linear", "mean_dilatation"])
@pytest.mark.parametrize("material", [fo.Material(), fo.Material(E=7e4, nu=0.45), fo.Material(nu=0.4999)])
def test_patch_of_uniform_stress(kind, material, element):
    """Uniform pressure and shear on two blocks: exact nodal forces; with mirror-image meshes the closed-form limit."""
    system = patch(kind, material=material, element=element).condense()
    weights = np.array([0.25, 0.55, 0.75, 0.45])
    q, p = system.reaction({"p": 2.0, "tau": 3.0})
    assert np.allclose(p, 2.0 * weights, rtol=1e-12) and np.allclose(np.abs(q), 3.0 * weights, rtol=1e-12)
    found = fo.onset(system, fo.LoadCycle({"p": 2.0}, [{"tau": 1.0}]), 0.4)
    assert found.slip.load_factor == pytest.approx(patch_limit(0.4, 2.0, 1.0), rel=1e-9)
    if kind is MeshQuad:  # triangles of init_tensor are not mirror images across the interface
        assert np.abs(system.B).max() < 1e-12 * np.abs(system.A).max()
        limit = fo.shakedown_limit(system, fo.LoadCycle({"p": 2.0}, [{"tau": -1.0}, {"tau": 1.0}]), 0.4)
        assert limit.load_factor == pytest.approx(patch_limit(0.4, 2.0, 1.0), rel=1e-9)
        assert limit.problem is None and limit.record.solver == "closed form"


def test_the_punch_keeps_its_free_motions_and_a_held_one_has_none():
    free = patch().condense()
    rigid = np.linalg.eigvalsh(free.S) < 1e-12 * np.linalg.norm(free.S)
    assert rigid.sum() == 3
    assert np.abs(free.S @ np.r_[np.ones(4), np.zeros(4)]).max() < 1e-15
    held = fo.ContactModel(*bodies(), supports=[*FREE, fo.Support("punch", "top", "xy")], loads={"tau": LOADS["tau"]}).condense()
    assert np.linalg.eigvalsh(held.S)[0] > 1e-3
    guided = fo.ContactModel(*bodies(), supports=[*FREE, fo.Support("punch", "top", "x")], loads={"p": LOADS["p"]}).condense()
    assert (np.linalg.eigvalsh(guided.S) < 1e-12 * np.linalg.norm(guided.S)).sum() == 2  # up and down, and a turn about the guide


def test_condensation_against_two_separate_bodies():
    """With the block held rigid everywhere, S is the punch's own condensed stiffness, by dense algebra."""
    from frictopt.fem.elasticity import body_stiffness

    punch, block = bodies()
    everywhere = [fo.Support("block", tuple(point), "xy") for point in block.mesh.p.T]
    system = fo.ContactModel(punch, block, supports=everywhere, loads={"p": [fo.Traction("punch", "top", y=-1.0)]}).condense()
    K = body_stiffness(punch.mesh, punch.material).toarray()
    contact = np.flatnonzero(punch.mesh.p[1] == 0.0)
    contact = contact[np.argsort(punch.mesh.p[0, contact])]
    r = np.r_[contact, contact + punch.mesh.p.shape[1]]
    i = np.setdiff1d(np.arange(len(K)), r)
    S = K[np.ix_(r, r)] - K[np.ix_(r, i)] @ np.linalg.solve(K[np.ix_(i, i)], K[np.ix_(i, r)])
    assert np.allclose(system.S, S, atol=1e-12 * np.abs(S).max())


def test_reactions_balance_the_loads():
    system = patch().condense()
    q, p = system.reaction({"p": 1.0, "tau": 1.0})
    assert p.sum() == pytest.approx(2.0, rel=1e-12) and q.sum() == pytest.approx(-2.0, rel=1e-12)


SUPPORTS = {"supports": FREE, "loads": LOADS}
PUNCH, BLOCK = bodies()
SHIFTED = bodies(x_punch=X + [0, 0, 1e-3, 0])[0]
FEWER = bodies(x_punch=X[[0, 1, 3]])[0]
BAD_MODELS = {
    "interface: node 2 is at": dict(SUPPORTS, punch=SHIFTED, block=BLOCK),
    "interface: 3 nodes on the punch, 4 on the block": dict(SUPPORTS, punch=FEWER, block=BLOCK),
    "interface of the punch: boundary 'joint' is unknown": dict(SUPPORTS, punch=PUNCH, block=BLOCK, interface="joint"),
    "interface: node 0": dict(SUPPORTS, punch=bodies(gap=0.5)[0], block=BLOCK),
    "punch: it lies below the interface": dict(
        SUPPORTS, punch=BLOCK, block=PUNCH, supports=[fo.Support("block", "top")], loads={"t": [fo.Traction("block", "top")]}
    ),
    "punch: a MeshQuad1; give a Body": dict(SUPPORTS, punch=PUNCH.mesh, block=BLOCK),
    "they prevent 2 of the 3": dict(SUPPORTS, punch=PUNCH, block=BLOCK, supports=FREE[:1]),
    "they prevent 0 of the 3": dict(SUPPORTS, punch=PUNCH, block=BLOCK, supports=[]),
    "they prevent 1 of the 3": dict(
        SUPPORTS, punch=PUNCH, block=BLOCK, supports=[fo.Support("block", "left", "x"), fo.Support("block", (0.1, 0.0), "x")][1:]
    ),
    "holds nodes of the punch on the interface": dict(SUPPORTS, punch=PUNCH, block=BLOCK, supports=[*FREE, fo.Support("punch", "left", "x")]),
    r"supports: \['bottom'\]; give a list of Support": dict(SUPPORTS, punch=PUNCH, block=BLOCK, supports=["bottom"]),
    r"no node at \(0.0, 5.0\)": dict(SUPPORTS, punch=PUNCH, block=BLOCK, supports=[fo.Support("block", (0.0, 5.0))]),
    r"loads\['p'\]: boundary 'roof' is unknown": dict(SUPPORTS, punch=PUNCH, block=BLOCK, loads={"p": [fo.Traction("punch", "roof", y=1.0)]}),
    "loads: {}; give at least one": dict(SUPPORTS, punch=PUNCH, block=BLOCK, loads={}),
    r"loads\['p'\]: no traction": dict(SUPPORTS, punch=PUNCH, block=BLOCK, loads={"p": []}),
    "load case name 3": dict(SUPPORTS, punch=PUNCH, block=BLOCK, loads={3: LOADS["p"]}),
    r"interface of the punch: boundary \[1\]": dict(SUPPORTS, punch=PUNCH, block=BLOCK, interface=[1]),
    r"loads\['p'\]: 3; give a list of Traction": dict(SUPPORTS, punch=PUNCH, block=BLOCK, loads={"p": 3}),
}


@pytest.mark.parametrize("message", BAD_MODELS)
def test_bad_models_are_refused(message):
    with pytest.raises(fo.ModelError, match=message):
        fo.ContactModel(**BAD_MODELS[message])


def test_bad_parts_are_refused():
    square = MeshQuad.init_tensor([0.0, 1.0], [0.0, 1.0])
    apart = MeshQuad.init_tensor([0.0, 1.0, 2.0, 3.0], [0.0, 1.0]).remove_elements(np.array([1]))
    hinge = MeshQuad.init_tensor([0.0, 1.0, 2.0], [0.0, 1.0, 2.0]).remove_elements(np.array([1, 2]))
    for make, message in {
        lambda: fo.Body(apart): "2 parts that share no edge",
        lambda: fo.Body(hinge): "2 parts that share no edge",
        lambda: fo.Body("mesh"): "mesh: a str",
        lambda: fo.Body(square, material=1.0): "material: a float",
        lambda: fo.Body(square, element="Q2"): "element: 'Q2'; give 'linear' or 'mean_dilatation'",
        lambda: fo.Body(MeshTet()): "mesh: a MeshTet1; give a MeshTri or a MeshQuad",
        lambda: fo.Body(MeshTri2()): "mesh: a MeshTri2; give a MeshTri or a MeshQuad",
        lambda: fo.Support("bolt", "top"): "body: 'bolt'",
        lambda: fo.Support("punch", "top", "z"): "directions: 'z'",
        lambda: fo.Support("punch", 3.0): "where: 3.0",
        lambda: fo.Support("punch", (0.0, np.nan)): "where: nan",
        lambda: fo.Traction("punch", "top", x=np.inf): "traction x: inf",
        lambda: fo.Traction("foundation", "top"): "body: 'foundation'",
        lambda: fo.Traction("punch", ["top"]): r"boundary: \['top'\]",
        lambda: fo.Support(["punch"], "top"): r"body: \['punch'\]",
        lambda: fo.Support("punch", "top", np.array(["x", "y"])): "directions: array",
    }.items():
        with pytest.raises(fo.ModelError, match=message):
            make()


def test_bad_elements_are_refused():
    square = MeshQuad.init_tensor([0.0, 1.0, 2.0], [0.0, 1.0])
    for place, message in (((3.0, 5.0), "not convex"), ((1.0, 0.0), "no area"), ((np.nan, 0.0), "not finite"), ((np.inf, 0.0), "not finite")):
        points = square.p.copy()
        points[:, 0] = place
        with pytest.raises(fo.ModelError, match=message):
            fo.Body(MeshQuad(points, square.t, sort_t=False))


def test_a_punch_in_a_socket_is_accepted_and_one_turned_over_is_not():
    """Which body is above is a matter of the elements at the interface, not of where most nodes are."""
    punch, block = bodies()
    walls = MeshQuad.init_tensor([-3.0, -2.0, *X, 2.0, 3.0], [-1.0, 0.0, 5.0, 5.1, 5.2, 5.3])
    centre = walls.p[:, walls.t].mean(axis=1)
    walls = walls.remove_elements(np.flatnonzero((np.abs(centre[0]) < 2) & (centre[1] > 0)))
    walls = walls.with_boundaries({"contact": lambda x: (x[1] == 0.0) & (np.abs(x[0]) < 1), "bottom": lambda x: x[1] == -1.0})
    load = {"p": [fo.Traction("punch", "top", y=-1.0)]}
    system = fo.ContactModel(punch, fo.Body(walls), supports=[fo.Support("block", "bottom")], loads=load).condense()
    assert system.reaction({"p": 1.0})[1].sum() == pytest.approx(2.0, rel=1e-12)
    over = fo.Body(MeshQuad(punch.mesh.p * [[1.0], [-1.0]], punch.mesh.t).with_boundaries(punch.mesh.boundaries))
    with pytest.raises(fo.ModelError, match="punch: it lies below the interface"):
        fo.ContactModel(over, block, **SUPPORTS)


@pytest.mark.parametrize("contrast", [1e-6, 1e-3, 1e3, 1e6])
def test_bodies_of_very_different_stiffness(contrast):
    """Compliances of the two bodies add: with the block held everywhere but near the interface, against dense algebra in series."""
    from frictopt.fem.elasticity import body_stiffness

    punch, block = bodies()[0], fo.Body(bodies()[1].mesh, fo.Material(E=contrast))
    held = [fo.Support("block", "bottom"), fo.Support("punch", "top")]
    S = fo.ContactModel(punch, block, supports=held, loads={"tau": [fo.Traction("block", "left", x=1.0)]}).condense().S

    def own(body, y_held):
        K = body_stiffness(body.mesh, body.material).toarray()
        nodes = body.mesh.p.shape[1]
        contact = np.flatnonzero(body.mesh.p[1] == 0.0)
        contact = contact[np.argsort(body.mesh.p[0, contact])]
        fixed = np.flatnonzero(body.mesh.p[1] == y_held)
        r = np.r_[contact, nodes + contact]
        i = np.setdiff1d(np.arange(2 * nodes), np.r_[r, fixed, nodes + fixed])
        return K[np.ix_(r, r)] - K[np.ix_(r, i)] @ np.linalg.solve(K[np.ix_(i, i)], K[np.ix_(i, r)])

    upper, lower = own(punch, 1.0), own(block, -1.0)
    assert np.allclose(S, np.linalg.inv(np.linalg.inv(upper) + np.linalg.inv(lower)), rtol=0, atol=1e-9 * np.abs(S).max())


def test_an_interior_boundary_is_refused():
    punch = bodies()[0]
    inner = punch.mesh.with_boundaries({"contact": lambda x: np.isclose(x[1], 0.4)}, boundaries_only=False)
    with pytest.raises(fo.ModelError, match="facets inside the body"):
        fo.ContactModel(fo.Body(inner), BLOCK, **SUPPORTS)


def test_a_tilted_interface_is_refused():
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    punch, block = (fo.Body(type(body.mesh)(turn @ body.mesh.p, body.mesh.t).with_boundaries(body.mesh.boundaries)) for body in bodies())
    with pytest.raises(fo.ModelError, match="interface: y varies"):
        fo.ContactModel(punch, block, supports=[fo.Support("block", "bottom")], loads=LOADS)


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 2, 1, 0]])
def test_a_quadrilateral_with_a_straight_corner_is_refused(order):
    """Its map from the square is singular there."""
    points = np.array([[0.0, 1.0, 2.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    with pytest.raises(fo.ModelError, match="mesh: 1 elements"):
        fo.Body(MeshQuad(points, np.array(order)[:, None]))
