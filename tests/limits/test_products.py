"""Contacts that are known by products: the same limits as with the stiffness, or a refusal."""

import warnings
from functools import cache

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, aslinearoperator
from skfem import MeshQuad

import frictopt as fo
from helpers import spatial
from helpers.refused import refused
from helpers.systems import CYCLE, NODE, at_corners, fixed_contact, linprog_limit, random_system

BULK = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
GAP = 0.01


def by_products(contact, **changes):
    """The same contact, whose operators are the plain inverse of A and B times it."""
    compliance = np.linalg.inv(contact.A)
    operators = {"pressing": contact.B @ compliance, "slipping": compliance}
    operators = {name: aslinearoperator(matrix) for name, matrix in operators.items()}
    return fo.ContactProducts(contact.points, contact.bonded, **operators | changes)


def closed_limits(products, contact, cycle, friction):
    """The limit by products, whose slip is safe with the stiffness, and the exact limit."""
    closed = np.zeros(contact.nodes, dtype=bool)
    exact = fo.shakedown_limit(contact, cycle, friction, open_nodes=closed).load_factor
    limit = fo.shakedown_limit(products, cycle, friction, gap=GAP)
    assert limit.gap <= GAP and limit.residual <= 1e-9 and "all nodes closed" in limit.covers
    assert limit.load_factor <= exact * (1 + 1e-8) and limit.bound >= exact * (1 - 1e-8)
    return limit, exact


@pytest.mark.parametrize("seed", range(4))
def test_operators_of_the_user_give_both_numbers_in_the_plane(seed):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, 7)
    limit, exact = closed_limits(by_products(contact), contact, CYCLE, 0.6)
    assert exact == pytest.approx(linprog_limit(contact, CYCLE, 0.6)[1], rel=1e-8)
    q, p = at_corners(contact, CYCLE, limit.load_factor, limit.slip)
    assert (np.abs(q) - 0.6 * p).max() < 1e-9


def test_operators_of_the_user_give_both_numbers_in_space():
    contact = spatial.random_contact(np.random.default_rng(1), 8)
    rough = (contact.B @ np.linalg.inv(contact.A)).astype(np.float32)
    limit, _ = closed_limits(by_products(contact, rough=rough), contact, spatial.cycle(), 0.6)
    q, p = at_corners(contact, spatial.cycle(), limit.load_factor, limit.slip)
    assert (np.linalg.norm(q, axis=-1) - 0.6 * p).max() < 1e-9


def test_fixed_parts_and_strengths_count():
    contact, cycle, friction = fixed_contact(8)
    closed_limits(by_products(contact), contact, cycle, friction)
    contact = spatial.random_contact(np.random.default_rng(4), 6)
    strong = {"width": np.ones(6), "shear_strength": np.full(6, 0.3)}
    strong_contact = fo.ContactSystem(contact.S, contact.points, contact.bonded, **strong)
    closed_limits(by_products(contact, **strong), strong_contact, spatial.cycle(), 0.6)


def half_of_two_blocks():
    """Blocks of which a plane of symmetry cuts off one half: its pair does not slip across it."""
    x = np.linspace(0.0, 1.0, 7)
    upper = MeshQuad.init_tensor(x, np.linspace(0.0, 1.0, 4)).with_boundaries(
        {"contact": lambda x: x[1] == 0, "top": lambda x: x[1] == 1, "middle": lambda x: x[0] == 0}
    )
    lower = MeshQuad.init_tensor(x, np.linspace(-1.0, 0.0, 4)).with_boundaries(
        {"contact": lambda x: x[1] == 0, "bottom": lambda x: x[1] == -1}
        | {"middle": lambda x: x[0] == 0, "side": lambda x: x[0] == 1}
    )
    return fo.fem.ContactModel(
        {"upper": fo.fem.Body(upper), "lower": fo.fem.Body(lower)},
        [
            fo.fem.Support("lower", "bottom", "y"),
            fo.fem.Support("lower", "middle", "x"),
            fo.fem.Support("upper", "middle", "x"),
        ],
        {
            "P": [fo.fem.Pressure("upper", "top")],
            "sigma": [fo.fem.Traction("lower", "side", x=1.0)],
        },
    )


MODELS = {
    "a punch in space, which slides": (lambda: fo.scenes.SquarePunch(elements=5).model(), BULK),
    "a punch in the plane": (lambda: fo.scenes.PunchOnHalfPlane(elements=10).model(), BULK),
    "two flanks": (
        lambda: fo.scenes.Dovetail(elements=8).model(),
        fo.LoadCycle({"pull": 1.0}, [{"sway": 1.0}, {"sway": -1.0}]),
    ),
    "a plane of symmetry": (half_of_two_blocks, BULK),
}


@cache
def of_model(name):
    model = MODELS[name][0]()
    return model.condense(), model.products()


@pytest.mark.parametrize("name", MODELS)
def test_products_of_a_model_are_those_of_its_stiffness(name):
    contact, products = of_model(name)
    for case in contact.bonded:
        by_stiffness, there = (
            np.hstack([part.T.ravel() for part in system.bonded[case]])
            for system in (contact, products)
        )
        assert np.abs(there - by_stiffness).max() < 1e-10 * np.abs(by_stiffness).max()
    np.testing.assert_allclose(products.compliance, contact.compliance, rtol=1e-9, atol=1e-9)
    slides = products.slides
    assert np.abs(contact.A @ slides).max(initial=0) < 1e-9 * np.abs(contact.A).max()
    assert np.abs(contact.B @ slides).max(initial=0) < 1e-9 * np.abs(contact.A).max()
    # A slip causes shear, and this shear has to cause the pressures of the slip.
    rng = np.random.default_rng(0)
    slip = rng.normal(size=len(contact.A))
    # A pair that does not slip has no coupling, and a stiffness of any size.
    slip[np.count_nonzero(np.abs(contact.A) > 1e-12, axis=0) == 1] = 0.0
    shear, pressure = contact.A @ slip, contact.B @ slip
    assert np.abs(products.pressing @ shear - pressure).max() < 1e-10 * np.abs(pressure).max()
    assert np.abs(products.rough @ shear - pressure).max() < 1e-3 * np.abs(pressure).max()
    rest = contact.A @ (products.slipping @ shear) - shear
    assert np.abs(rest).max() < 1e-9 * np.abs(shear).max()
    lifts = rng.normal(size=contact.nodes)
    work = shear @ (lifts @ products.pressing)
    assert work == pytest.approx(lifts @ pressure, abs=1e-10 * np.abs(pressure).sum())


@pytest.mark.parametrize("name", MODELS)
def test_limits_of_a_model_by_products(name):
    contact, products = of_model(name)
    limit, _ = closed_limits(products, contact, MODELS[name][1], 0.5)
    q, p = at_corners(contact, MODELS[name][1], limit.load_factor, limit.slip)
    size = np.abs(q) if contact.tangents == 1 else np.linalg.norm(q, axis=-1)
    assert (size - 0.5 * p).max() < 1e-9 * np.abs(p).max()
    assert len(limit.mechanism) and limit.least == 0
    with pytest.raises(fo.ModelError, match=r"condense"):
        _ = limit.reactions


@pytest.mark.parametrize(
    ("mean", "corners", "kind"),
    [
        ({"P": 1.0}, [{"N": 1.0}, {"N": 2.0, "Q": 0.1}], fo.LimitKind.UNBOUNDED),
        ({"P": -1.0}, [{"Q": 1.0}, {"Q": -1.0}], fo.LimitKind.NO_SAFE_SLIP),
        ({"P": -1.0}, [{"N": -1.0}, {"N": -1.0, "Q": 0.1}], fo.LimitKind.NO_SAFE_SLIP),
    ],
    ids=["pressed", "pulled", "pulled and lifted"],
)
def test_products_prove_that_there_is_no_limit(mean, corners, kind):
    cycle = fo.LoadCycle(mean, corners)
    exact = fo.shakedown_limit(NODE, cycle, 0.5, open_nodes=[False])
    limit = fo.shakedown_limit(by_products(NODE), cycle, 0.5, gap=GAP)
    assert limit.kind is exact.kind is kind and 0 <= limit.residual <= 1e-9
    assert limit.least == exact.least or kind is fo.LimitKind.NO_SAFE_SLIP
    if kind is fo.LimitKind.NO_SAFE_SLIP:
        assert "see the mechanism" in limit.reason
        assert set(limit.mechanism.node) == set(exact.mechanism.node)


def test_what_products_do_not_prove_is_said_to_be_unknown():
    """A node that is pulled by 1, pressed and sheared by the load, is safe from 2.5 on."""
    cycle = fo.LoadCycle({"P": -1.0}, [{"N": 1.0, "Q": 0.6}, {"N": 1.0, "Q": -0.6}])
    assert fo.shakedown_limit(NODE, cycle, 1.0).least == pytest.approx(2.5)
    words = r"no bound, and nothing proves that there is none; condense"
    with pytest.raises(fo.SolverError, match=words):
        fo.shakedown_limit(by_products(NODE), cycle, 1.0, gap=GAP)


def test_a_large_limit_is_not_infinite():
    """The load unloads a node by a millionth of what presses it at the other corner."""
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": 1.0}, {"N": -1e-6}])
    limit, exact = closed_limits(by_products(NODE), NODE, cycle, 0.5)
    assert limit.kind is fo.LimitKind.FINITE and exact == pytest.approx(1e6)


PLANE = by_products(random_system(np.random.default_rng(0), 4))


@refused(
    (lambda: fo.shakedown_limit(PLANE, CYCLE, 0.5), "stiffness S; condense.*gap=0.01"),
    (lambda: fo.guaranteed_limit(PLANE, CYCLE, 0.5), "stiffness S; condense"),
    (lambda: fo.march(PLANE, CYCLE, 0.5, load_factor=1.0), "stiffness S; condense"),
    (lambda: fo.steady_state(PLANE, CYCLE, 0.5, 1.0), "stiffness S; condense"),
    (lambda: fo.gross_slip(PLANE, CYCLE, 0.5), "stiffness S; condense"),
    (lambda: fo.required_friction(PLANE, CYCLE, 1.0), "stiffness S; condense.*gap=0.01"),
    (lambda: PLANE.save("contact.npz"), "stiffness S; condense"),
    (lambda: PLANE.with_gap(np.full(4, 0.1)), "gap: products know no initial gap"),
    (lambda: PLANE.with_interference({"fit": 0.1}), "stiffness S; condense"),
    (
        lambda: fo.shakedown_limit(PLANE, CYCLE, 0.5, gap=GAP, open_nodes=[True] + 3 * [False]),
        "stiffness S; condense",
    ),
)
def test_questions_that_need_the_stiffness(ask):
    ask()


CONTACT = random_system(np.random.default_rng(0), 4)


@refused(
    ({"pressing": aslinearoperator(np.eye(5))}, r"pressing: shape \(5, 5\).*\(4, 4\)"),
    ({"slipping": aslinearoperator(np.triu(np.ones((4, 4))))}, "slipping: .*transpose"),
    (
        {"pressing": LinearOperator((4, 4), lambda q: 2 * q, lambda q: q, dtype=float)},
        "pressing: .*transpose",
    ),
    ({"rough": aslinearoperator(np.eye(3))}, "rough: shape"),
    ({"slides": np.ones((3, 1))}, "slides: shape"),
)
def test_operators_that_do_not_fit(changes):
    by_products(CONTACT, **changes)


def test_models_whose_products_are_not_known():
    pressed = fo.scenes.PressFit(elements=8).model()
    with warnings.catch_warnings(), pytest.raises(fo.ModelError, match="condense"):
        warnings.simplefilter("ignore")
        pressed.products()
