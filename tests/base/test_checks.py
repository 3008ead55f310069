"""The checks that all input goes through."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from scipy.sparse import csr_matrix

import frictopt as fo
from frictopt.base import checks
from helpers.systems import CYCLE, random_system

MASKED = np.ma.masked_array([1.0, 2.0], mask=[False, True])
THREE = random_system(np.random.default_rng(3), 3)
CIRCLE: list = [1.0]
CIRCLE.append(CIRCLE)


class Unprintable:
    def __repr__(self):
        raise RuntimeError


@pytest.mark.parametrize("value", [3, np.int8(3), np.uint64(3), 10**6])
def test_whole_numbers(value):
    assert checks.whole_number("n", value, least=0) == value


def test_a_seed_may_be_more_than_a_million():
    assert checks.whole_number("n", 2**63 - 1, least=0, most=checks.LARGEST_SEED) == 2**63 - 1


@pytest.mark.parametrize(
    "value",
    [
        2,
        2.0,
        np.float32(2),
        np.array(2.0),
        np.array(2),
        Fraction(2),
        np.longdouble(2),
        np.ma.masked_array(2.0),
    ],
)
def test_real_numbers(value):
    found = checks.finite_number("a", value)
    assert type(found) is float and found == 2.0


NO_NUMBERS = [True, np.True_, "2", b"2", None, 2j, pd.NA, {}, np.timedelta64(2), Decimal(2)]
NO_COUNTS = [3.0, np.array(3), -1, 10**6 + 1, 10**5000]
NOT_FINITE = [np.nan, -np.inf, np.ma.masked, 1e151, 10**400, 10**5000]
SEVERAL = [[2.0], np.array([2.0]), csr_matrix([[2.0]]), np.array(True), np.datetime64("2020-01-01")]
NO_ROWS = [None, {}, {1.0}, b"AB", [b"A"], "12", ["1"], CIRCLE, [[1.0], [1.0, 2.0]], Unprintable()]
ODD_ROWS = [MASKED, (MASKED,), [1.0, None], [1.0, pd.NA], [True, False], [1.0, True], [1j]]
ODD_ARRAYS = [[Fraction(1)], [10**30], np.array([1], dtype="m8[s]"), [csr_matrix(np.eye(2))]]
REFUSED = {
    "count": (
        lambda value: checks.whole_number("a", value, least=0),
        [*NO_NUMBERS, *NO_COUNTS],
    ),
    "number": (
        lambda value: checks.finite_number("a", value),
        [*NO_NUMBERS, *NOT_FINITE, *SEVERAL, Unprintable()],
    ),
    "array": (
        lambda value: checks.real_array("a", value),
        [*NO_ROWS, *ODD_ROWS, *ODD_ARRAYS],
    ),
    "row": (
        lambda value: checks.finite_numbers("a", value, least=0.0),
        [b"AB", "12", MASKED, {1.0: 2.0}, 3.0, None, [1.0, np.nan], [1.0, -1.0]],
    ),
    "option": (
        lambda value: checks.choice("a", value, ("x", "y")),
        ["z", b"x", None, ["x"], np.array(["x", "y"]), pd.NA, Unprintable()],
    ),
}


@pytest.mark.parametrize(
    ("kind", "value"),
    [(kind, value) for kind, (_, values) in REFUSED.items() for value in values],
    ids=lambda one: repr(type(one)),
)
def test_what_is_of_another_kind_is_refused(kind, value):
    with pytest.raises(fo.ModelError, match="a: .*give 'x' or 'y'" if kind == "option" else "a: "):
        REFUSED[kind][0](value)


def test_rows_of_numbers_may_be_anything_that_can_be_gone_through():
    for values in (
        [1, 2.0],
        (1, 2),
        np.array([1.0, 2.0]),
        range(1, 3),
        (k for k in (1, 2)),
        pd.Series([1, 2]),
    ):
        assert checks.finite_numbers("a", values) == [1.0, 2.0]


def test_an_error_message_is_short():
    for value in (np.eye(100), "a" * 10**6, list(range(10**5)), 10**5000):
        with pytest.raises(fo.ModelError) as caught:
            checks.flag("a", value)
        assert len(str(caught.value)) < 120


def test_a_count_agrees_with_its_noun_and_verb():
    assert checks.number_of(1, "node") == "1 node"
    assert checks.number_of(2, "node") == "2 nodes" and checks.number_of(0, "node") == "0 nodes"
    assert checks.number_of(1, "node is", "nodes are") == "1 node is"
    assert checks.number_of(3, "node is", "nodes are") == "3 nodes are"


def test_a_series_is_read_by_its_labels_if_they_are_nodes():
    friction = pd.Series([0.3, 0.1, 0.2], index=[2, 0, 1])
    asked = fo.shakedown_limit(THREE, CYCLE, friction)
    assert asked.friction.tolist() == [0.1, 0.2, 0.3]
    assert asked.load_factor == fo.shakedown_limit(THREE, CYCLE, [0.1, 0.2, 0.3]).load_factor
    names = pd.Series(["right", "left", "left"], index=[2, 1, 0])
    contact = fo.ContactSystem.from_blocks(
        THREE.A, THREE.B, THREE.C, THREE.x, THREE.bonded, contact=names
    )
    assert contact.contact.tolist() == ["left", "left", "right"]


@pytest.mark.parametrize("labels", [[1, 2, 3], [0, 0, 1]])
def test_a_series_with_other_labels_is_refused(labels):
    friction = pd.Series([0.3, 0.1, 0.2], index=labels)
    with pytest.raises(fo.ModelError, match=r"friction: .*labels are not 0 to 2; .*to_numpy"):
        fo.shakedown_limit(THREE, CYCLE, friction)


NAMED = fo.ContactSystem.from_blocks(
    THREE.A,
    THREE.B,
    THREE.C,
    THREE.x,
    THREE.bonded,
    contact=["rim", "rim", "hub"],
    width=[1.0, 1.0, 2.0],
)
BY_CONTACT = {
    "friction": lambda f: fo.shakedown_limit(NAMED, CYCLE, f).load_factor,
    "friction of a transient": lambda f: fo.steady_state(NAMED, CYCLE, f, 2.0).dissipation,
    "friction of a study": lambda f: fo.dissipation_study(NAMED, CYCLE, [f], [2.0]).dissipation[0],
    "slip bound": lambda v: fo.shakedown_limit(NAMED, CYCLE, 0.4, slip_bound=v).load_factor,
    "overlap": lambda d: NAMED.with_interference({"fit": d}).bonded["fit"],
    "strength": lambda c: NAMED.with_shear_strength(c).shear_strength,
    "tangential": lambda k: NAMED.with_contact_stiffness(tangential=k).S,
    "normal": lambda k: NAMED.with_contact_stiffness(normal=k).S,
}


@pytest.mark.parametrize("given", BY_CONTACT)
def test_values_of_contacts_are_those_of_their_nodes(given):
    ask = BY_CONTACT[given]
    of_nodes = ask([0.4, 0.4, 0.3])
    assert not np.array_equal(of_nodes, ask([0.3, 0.3, 0.4]))
    for by_name in ({"hub": 0.3, "rim": 0.4}, pd.Series([0.3, 0.4], index=["hub", "rim"])):
        assert np.array_equal(ask(by_name), of_nodes)


@pytest.mark.parametrize("by_name", [dict, pd.Series])
def test_a_study_reads_the_frictions_of_contacts_as_one_friction(by_name):
    table = fo.dissipation_study(NAMED, CYCLE, by_name({"rim": 0.4, "hub": 0.1}), [1.0])
    assert table["friction"].round(9).tolist() == [0.3]


@pytest.mark.parametrize("by_name", [dict, pd.Series])
def test_names_of_other_contacts_are_refused(by_name):
    for names in ({"rim": 0.4}, {"rim": 0.4, "hub": 0.3, "key": 0.2}, {"a": 1.0}):
        with pytest.raises(fo.ModelError, match=r"friction: .*each of .* \['rim', 'hub'\]"):
            fo.steady_state(NAMED, CYCLE, by_name(names), 1.0)
    with pytest.raises(fo.ModelError, match=r"friction: .*; .*name the contacts of the system"):
        fo.shakedown_limit(THREE, CYCLE, by_name({"rim": 0.4}))
    with pytest.warns(fo.ModelWarning, match="not per cent"):
        fo.shakedown_limit(NAMED, CYCLE, by_name({"rim": 30.0, "hub": 0.3}))
