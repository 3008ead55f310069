"""The references and rivals of the study of error against run time, against enumeration, rational elimination and other programs."""

from itertools import combinations, product
from types import SimpleNamespace

import numpy as np
import pytest

import frictopt as fo
from frictopt.reference import two_node_limits
from studies.validation.error_vs_time import condensation, exact
from studies.validation.error_vs_time.lemke import Lemke
from studies.validation.oracles import largest_load_factor
from systems import CYCLE, random_system, system

pytestmark = pytest.mark.slow


def fastened(contact):
    """The contact with a further node that takes up any slip: then it is no restriction that slips add up to zero."""
    n = contact.nodes
    blocks = {name: np.pad(getattr(contact, name), ((0, 1), (0, 1))) for name in "ABC"}
    blocks["A"][n, n], blocks["C"][n, n] = 1e-3, 1.0
    bonded = {name: (np.append(q, 0.0), np.append(p, 0.0 if name == "cyclic" else 10.0)) for name, (q, p) in contact.bonded.items()}
    return fo.ContactSystem.from_blocks(**blocks, x=np.arange(n + 1.0), bonded=bonded)


def vertices(contact, friction):
    """All choices of as many rows as there are unknowns."""
    return [np.array(rows) for rows in combinations(range(2 * contact.nodes), contact.nodes)]


@pytest.mark.parametrize("seed", range(4))
def test_exact_limit_is_that_of_an_independent_program(seed):
    contact = fastened(random_system(np.random.default_rng(seed), 2))
    expected = largest_load_factor(contact, CYCLE, 0.4)
    assert np.isfinite(expected)
    proven = []
    for active in vertices(contact, 0.4):
        try:
            proven.append(exact.exact_shakedown_limit(contact, CYCLE, 0.4, active))
        except exact.NotProven:
            continue
    assert len(proven) >= 2 and max(limit.pivots for limit in proven) > 0, "wrong vertices too must lead to the optimum"
    assert all(limit.value == pytest.approx(expected, rel=1e-9) for limit in proven)
    assert all(abs(limit.slip.sum()) < 1e-12 for limit in proven)


@pytest.mark.parametrize(
    ("two", "f"),
    [
        (system([[1, -0.4], [-0.4, 1]], [[-0.1, -0.7], [0.7, 0.1]], 0.0, 1.0, 0.8, [0.4, 0.1]), 0.6),
        (system([[1, -0.6], [-0.6, 1]], [[-0.5, -0.4], [0.4, 0.5]], 0.0, 1.0, [0.4, -0.4], [0.1, -0.1]), 0.4),
    ],
)
def test_exact_guaranteed_limit_is_the_closed_form_of_two_nodes(two, f):
    expected = two_node_limits(two.A, two.B, *two.bonded["mean"], *two.bonded["cyclic"], f)
    assert 0 < expected.lambda_1 < 0.6 * expected.lambda_2
    contact, found = fastened(two), []
    for node in (0, 1):
        for other in set(range(6)) - {node, node + 3}:
            try:
                found.append(exact.exact_guaranteed_limit(contact, CYCLE, f, node, np.array([node, node + 3, other])).value)
            except exact.NotProven:
                continue
    assert min(found) == pytest.approx(expected.lambda_1, rel=1e-9)


@pytest.mark.parametrize(("q", "status"), [(-0.9, 1), (0.9, -1), (0.1, 0)])
def test_exact_increment_of_one_node(q, status):
    """Its slip is where `q + A v` meets the bound `f (p + B v)`; no other status is accepted."""
    A, B, f = 2.0, 0.5, 0.4
    node = system(A, B, 0.0, 1.0, 1.0, 0.0)
    slip = exact.exact_increment(node, f, np.zeros(1), ([q], [1.0]), np.array([status]))
    assert slip == pytest.approx(0 if status == 0 else -(q + status * f) / (A + status * f * B), abs=1e-15)
    for wrong in {-1, 0, 1} - {status}:
        with pytest.raises(exact.NotProven, match="contradicts"):
            exact.exact_increment(node, f, np.zeros(1), ([q], [1.0]), np.array([wrong]))


def test_refined_stiffness_is_that_of_rational_elimination():
    """And all that is compared is the same stiffness: the package's from its own assembly, the rivals' from scikit-fem's."""
    scene = fo.scenes.PunchOnHalfPlane(elements=2, growth=3.0)
    K_ii, K_ir, K_rr = blocks = condensation.assembled(scene)
    interior, coupling = exact.fractions(K_ii.toarray()), exact.fractions(K_ir.toarray())
    solution = np.column_stack([exact.refined(interior, column) for column in coupling.T])
    rational = exact.fractions(K_rr) - coupling.T @ solution
    doubles = rational.astype(float)
    beyond = (rational - exact.fractions(doubles)).astype(float)
    scale, refined = np.abs(doubles).max(), condensation.refined_stiffness(blocks)
    assert np.abs(refined - doubles - beyond).max() < 100 * np.finfo(np.longdouble).eps * scale
    for S in (scene.condense().S, *(condensation.multiple_right_hand_sides(blocks, name) for name in condensation.ORDERINGS)):
        assert np.abs(S - doubles).max() < 1e-13 * scale


def enumerated(M, c, **_):
    """Solution of the complementarity problem by trying which of each pair of unknowns is zero."""
    for choice in product([False, True], repeat=len(c)):
        basic, z = np.array(choice), np.zeros(len(c))
        if np.linalg.matrix_rank(M[np.ix_(basic, basic)]) == basic.sum():
            z[basic] = np.linalg.solve(M[np.ix_(basic, basic)], -c[basic])
            if min(z.min(), (M @ z + c).min()) > -1e-12:
                return SimpleNamespace(z=z)
    raise AssertionError("no solution")


@pytest.mark.parametrize("seed", range(3))
def test_complementarity_problem_of_the_rival_is_that_of_an_increment(monkeypatch, seed):
    contact = random_system(np.random.default_rng(seed), 2)
    n, factor, start = 2, 1.5 * fo.shakedown_limit(contact, CYCLE, 0.4).load_factor, np.array([0.2, -0.1])
    mean = np.concatenate(contact.reaction(CYCLE.mean))
    corners = [mean + factor * np.concatenate(pair) for pair in zip(*CYCLE.corner_reactions(contact), strict=True)]
    force = np.abs(mean[n:]).mean()
    carried = np.r_[np.zeros(n), np.full(n, force)] - contact.S[:, :n] @ start
    monkeypatch.setattr("studies.validation.error_vs_time.lemke.installed", lambda _: SimpleNamespace(lcp_lemke=enumerated))
    work = Lemke(contact, 0.4, force).cycle_work(start, [carried, mean, *corners * 2], 3, 2)
    march = fo.march(contact, CYCLE, 0.4, factor, initial_slip=start, cycles=2, engine="qp", steps=3)
    assert march.cycle_work[-1].sum() > 1e-3 and work == pytest.approx(march.cycle_work[-1].sum(), rel=1e-9)
