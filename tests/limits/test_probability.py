"""The probability that a contact can stop slipping.

It is compared with integrals and closed forms of contacts whose nodes do not know each other, and
with draws of limits.
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import lognorm, multivariate_normal, norm, uniform

import frictopt as fo
from helpers.cases import few
from helpers.systems import CYCLE, random_system

TO_AND_FRO = fo.LoadCycle({"P": 2.0}, [{"Q": -0.4}, {"Q": 0.4}])
FRICTION = lognorm(0.2, scale=0.22)


def apart(nodes, **options):
    """A contact of nodes on springs of their own; its limit is the least of `f P / 0.4`."""
    loads = {"P": (np.zeros(nodes), np.ones(nodes)), "Q": (np.ones(nodes), np.zeros(nodes))}
    return fo.ContactSystem.from_blocks(
        np.eye(nodes), np.zeros((nodes, nodes)), np.eye(nodes), np.arange(nodes), loads, **options
    )


def limit_of(contact):
    return fo.shakedown_limit(contact, TO_AND_FRO, 0.22)


def agrees(random, exact):
    return abs(random.probability - exact) <= 3 * random.standard_error


def test_friction_preload_and_load_of_a_node_are_those_of_an_integral():
    """A node is safe if `f P` is at least 0.4 times the load factor."""
    preload, load = norm(2.0, 0.2), uniform(0.8, 0.3)

    def at(factor, amplitude):
        return FRICTION.sf(0.4 * factor / amplitude)

    def over_preload(factor):
        inside = quad(lambda p: at(factor, p) * preload.pdf(p), 1.0, 3.0)[0]
        return inside * load.pdf(factor)

    exact = quad(over_preload, 0.8, 1.1)[0]
    random = limit_of(apart(1)).probability(
        friction=FRICTION, preload={"P": preload}, load=load, draws=80
    )
    assert random.form == pytest.approx(exact, abs=0.01) and agrees(random, exact)
    assert "by FORM" in random.method and random.standard_error < 0.03
    assert sum(random.importance.values()) == pytest.approx(1.0)
    assert list(random.importance) == ["friction", "P", "the load factor"]


def test_a_friction_far_above_the_required_one_is_sure_to_be_enough():
    """Friction of 0.2 is enough; 0.4 is 100 standard deviations above it."""
    random = limit_of(apart(1)).probability(
        friction=norm(0.4, 0.002), preload={"P": norm(2.0, 0.01)}, draws=10
    )
    assert random.probability == random.form == 1.0 and random.standard_error < 0.1


@pytest.mark.parametrize("law", [FRICTION, norm(0.2, 0.05), uniform(0.15, 0.1)])
def test_one_friction_has_the_exact_probability(law):
    contact = apart(3)
    exact = fo.required_friction(contact, TO_AND_FRO, 1.0).probability(law)
    random = limit_of(contact).probability(friction=law, draws=80)
    assert random.form == pytest.approx(exact, abs=1e-4) == law.sf(0.2) and agrees(random, exact)


def test_where_two_faces_are_next_to_slip_the_sample_corrects_form():
    """Both faces have to hold, each with 50 %; FORM sees one of them."""
    limit = limit_of(apart(2, contact=["head", "lap"]))
    law = lognorm(0.2, scale=0.2)
    random = limit.probability(friction={"head": law, "lap": law}, draws=80)
    assert random.form == pytest.approx(0.5, abs=0.01) and agrees(random, 0.25)
    assert "by FORM (0.5), corrected by 80 draws" in random.method
    one = limit.probability(friction={"head": law, "lap": uniform(0.5, 0.1)}, draws=10)
    assert one.form == pytest.approx(0.5, abs=1e-3)
    assert one.importance["friction of head"] == pytest.approx(1.0)


@pytest.mark.parametrize("length", [0.0, 0.5, 2.0, 1e6])
def test_two_nodes_that_correlate_are_those_of_a_bivariate_normal(length):
    """Both nodes are safe if two normal numbers of this correlation are above their bounds."""
    correlation = np.exp(-1.0 / length) if length else 0.0
    bound = norm.isf(FRICTION.sf(0.2))
    exact = multivariate_normal.cdf(
        [-bound, -bound], cov=[[1, correlation], [correlation, 1]], allow_singular=True
    )
    random = limit_of(apart(2)).probability(friction=FRICTION, correlation_length=length, draws=80)
    assert agrees(random, exact) and random.standard_error <= 0.06


def test_scatter_from_node_to_node_lowers_the_limit_of_many_nodes():
    """The least of 25 frictions governs: their mean is that of drawn ones."""
    contact = apart(25)
    law = lognorm(0.15, scale=0.3)
    random = limit_of(contact).probability(friction=law, correlation_length=0.0, draws=80)
    least = law.rvs((20000, 25), random_state=1).min(axis=1) * 2.0 / 0.4
    assert random.limits.mean() == pytest.approx(least.mean(), abs=4 * least.std() / 80**0.5)
    assert agrees(random, law.sf(0.2) ** 25)


@pytest.mark.parametrize("seed", few(range(3)))
def test_as_assembled_joints_stop_as_often_as_drawn_transients(seed):
    """Nodes that change each other's pressure, with friction and load at which some slip on."""
    contact = random_system(np.random.default_rng(seed), 4)
    needed = fo.required_friction(contact, CYCLE, 1.0).required
    limit = fo.shakedown_limit(contact, CYCLE, needed)
    laws = {"friction": uniform(needed, needed), "load": uniform(0.8, 0.4)}
    some = limit.probability(**laws, assembled=True, draws=150)
    random = some.assembled
    numbers = np.random.default_rng(seed + 7)
    stops = [
        fo.steady_state(contact, CYCLE, friction, factor).outcome is fo.Outcome.SHAKEDOWN
        for friction, factor in zip(
            laws["friction"].rvs(150, random_state=numbers),
            laws["load"].rvs(150, random_state=numbers),
            strict=True,
        )
    ]
    share = np.mean(stops)
    # One more draw of each outcome keeps the error above 0.
    spread = (150 * share + 1) * (150 * (1 - share) + 1) / 152**2
    assert abs(share - random.probability) <= 4 * np.hypot(
        random.standard_error, (spread / 150) ** 0.5
    )
    assert "corrected by 150 steady states from no slip" in random.method
    assert random.form == some.form
    assert some.probability == limit.probability(**laws, draws=150).probability


def test_as_assembled_a_body_that_slides_off_does_not_stop():
    """A free body stops if `f P` is at least 0.4, and else slides off, without a steady state."""
    loads = {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])}
    free = fo.ContactSystem.from_blocks([[0.0]], [[0.0]], [[0.0]], [0.0], loads)
    laws = {"friction": FRICTION, "preload": {"P": norm(2.0, 1e-6)}}
    random = limit_of(free).probability(**laws, assembled=True, draws=40)
    assert agrees(random.assembled, FRICTION.sf(0.2))


@pytest.mark.parametrize("seed", few(range(3)))
def test_the_sample_has_the_limits_of_its_inputs(seed):
    """Limits of drawn frictions and preloads have the mean and the share of the sample."""
    contact = random_system(np.random.default_rng(seed), 4)
    needed = fo.required_friction(contact, CYCLE, 1.0).required
    law, preload = lognorm(0.1, scale=1.05 * needed), norm(1.0, 0.05)
    limit = fo.shakedown_limit(contact, CYCLE, needed)
    random = limit.probability(friction=law, preload={"mean": preload}, draws=60)
    numbers = np.random.default_rng(seed + 9)
    drawn = [
        fo.shakedown_limit(
            contact,
            fo.LoadCycle({"mean": preload.rvs(random_state=numbers)}, CYCLE.corners),
            law.rvs(random_state=numbers),
            open_nodes=limit.open,
        ).load_factor
        for _ in range(60)
    ]
    share = np.mean(np.array(drawn) >= 1)
    error = np.hypot(random.standard_error, (share * (1 - share) / 60) ** 0.5)
    assert abs(share - random.probability) <= 3 * error
    assert np.mean(drawn) == pytest.approx(random.limits.mean(), abs=np.std(drawn) / 2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "none is a distribution"),
        ({"friction": 0.3}, "friction: .*frozen distribution"),
        ({"friction": {"lap": FRICTION}}, "friction: "),
        ({"preload": {"Q": FRICTION}}, "preload.*no such load case"),
        ({"preload": {"P": 2.0}}, "P: .*frozen distribution"),
        ({"load": -1.0, "friction": FRICTION}, "load: -1"),
        ({"friction": FRICTION, "correlation_length": -1.0}, "correlation_length: -1"),
        ({"friction": FRICTION, "draws": 3}, "draws: 3"),
        ({"friction": FRICTION, "seed": -1}, "seed: -1"),
    ],
)
def test_bad_input_is_refused_by_name(options, message):
    with pytest.raises(fo.ModelError, match=message):
        limit_of(apart(1)).probability(**options)
