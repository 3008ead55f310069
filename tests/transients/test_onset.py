import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.separation import pulled_system
from helpers.spatial import random_contact, vectors
from helpers.systems import CYCLE, random_system, system, unit_nodes

ONE_WAY = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}])


def pulled(sigma):
    return fo.LoadCycle({"P": 1.0}, [{"sigma": sigma}])


@pytest.mark.parametrize("make", [random_system, random_contact], ids=["plane", "space"])
@settings(max_examples=few(20))
@given(nodes=st.integers(1, 5), seed=st.integers(0, 10**6), friction=st.floats(0.05, 3.0))
def test_onset_is_the_first_violation(make, nodes, seed, friction):
    contact = make(np.random.default_rng(seed), nodes)
    case = next(name for name in contact.bonded if name != "mean")
    found = fo.onset(contact, fo.LoadCycle({"mean": 1.0}, [{case: 1.0}]), friction)

    def at(lam):
        q, p = contact.reaction({"mean": 1.0, case: lam})
        return q.reshape(nodes, -1), p

    def slips(lam):
        q, p = at(lam)
        return (np.linalg.norm(q, axis=1) - friction * p).max() > 0

    def opens(lam):
        return at(lam)[1].min() < 0

    for event, violated in ((found.slip, slips), (found.separation, opens)):
        if event.load_factor == np.inf:
            assert not violated(1e9) and event.node is None and not np.any(event.sense)
        else:
            assert (
                not any(violated(t * event.load_factor) for t in np.linspace(0, 1 - 1e-9, 20))
                or not found.mean_admissible
            )
            assert violated(event.load_factor * (1 + 1e-9) + 1e-12)
    if found.slip.node is not None and found.mean_admissible:
        assert found.residual < 1e-12
        q, p = at(found.slip.load_factor)
        assert q[found.slip.node] == pytest.approx(
            -np.atleast_1d(found.slip.sense) * friction * p[found.slip.node], abs=1e-9
        )


def test_an_inadmissible_mean_load_is_said():
    contact = system(np.eye(3), np.zeros((3, 3)), (0.9, 0.0, 0.0), (1.0, 1.0, -0.1), 0.1, 0.0)
    found = fo.onset(contact, ONE_WAY, 0.5)
    assert found.mean_slips == (0, 2) and found.mean_opens == (2,) and not found.mean_admissible
    # It is on its bound once the mean load has settled.
    assert (found.slip.load_factor, found.slip.node, found.slip.sense) == (0.0, 0, -1)
    assert found.separation.load_factor == np.inf
    assert found.residual < 1e-12
    assert found.state.open.tolist() == [False, False, True]
    slipping = system(np.eye(3), np.zeros((3, 3)), (0.9, 0.0, 0.0), 1.0, 0.1, 0.0)
    found = fo.onset(slipping, ONE_WAY, 0.5)
    assert found.mean_slips == (0,) and found.state is None and found.slip.load_factor == 0.0
    # Node 0: q - f p = 0.9 - 0.5 * 1.0, over the largest force, 1.
    assert found.residual == pytest.approx(0.4)
    sheared = system(np.eye(2), np.zeros((2, 2)), 0.0, 1.0, 0.1, (0.0, -0.3))
    found = fo.onset(
        sheared, fo.LoadCycle({"mean": 1.0}, CYCLE.corners, fixed=[{"cyclic": 6.0}, {}]), 0.5
    )
    assert (found.mean_slips, found.mean_opens) == ((0, 1), (1,)) and found.residual > 0.1, (
        "with what is fixed at one corner"
    )


def test_mirror_images_name_the_first_node_whatever_the_rounding(punch):
    contact = punch(16)
    assert fo.onset(contact, pulled(1.0), 1.0).slip.node == 0


def test_unknown_loads_are_refused(punch):
    with pytest.raises(fo.ModelError, match="load case 'tau': unknown"):
        fo.onset(punch(16), fo.LoadCycle({"P": 1.0}, [{"tau": 1.0}]), 0.5)


def test_the_line_of_an_onset_counts_nodes():
    contact = system(np.eye(200), np.zeros((200, 200)), 0.9, 1.0, 0.1, 0.0)
    line = repr(fo.onset(contact, ONE_WAY, 0.5))
    assert "200 of 200 nodes" in line and len(line) < 700


def first_event(path, factor):
    """Load factor of the first event on the way from the mean load to the first corner.

    An event is the first slip of a closed node, or a node that opens or touches.
    """
    begin = np.searchsorted(path.time, 0.0, side="right") - 1
    closed = path.gap[begin] == 0
    for before, row in zip(
        range(begin, len(path.time)), range(begin + 1, len(path.time)), strict=False
    ):
        if (
            np.abs((path.slip[row] - path.slip[begin])[closed]).max(initial=0.0)
            > 1e-9 * np.abs(path.slip).max()
        ):
            return factor * path.time[before]
        if ((path.gap[row] > 0) != ~closed).any():
            return factor * path.time[row]
    return np.inf


@settings(max_examples=few(15))
@given(seed=st.integers(0, 10**6), sense=st.sampled_from([-1.0, 1.0]))
def test_the_onset_of_a_contact_with_open_nodes_is_the_first_event_after_the_mean_load_has_settled(
    seed, sense
):
    rng = np.random.default_rng(seed)
    contact = pulled_system(rng, int(rng.integers(2, 6)))
    friction = float(rng.uniform(0.2, 1.0))
    cycle = fo.LoadCycle({"mean": 1.0}, [{"cyclic": sense}])
    found = fo.onset(contact, cycle, friction)
    assume(found.state is not None and found.state.open.any())
    first = min(event.load_factor for event in (found.slip, found.separation, found.touch))
    factor = 2 * first if 1e-9 < first < np.inf else 1.0
    assert first_event(
        fo.march(contact, cycle, friction, factor, cycles=1), factor
    ) == pytest.approx(first, rel=1e-7, abs=1e-9)
    assert found.to_frame()["event"].tolist() == ["slip", "separation", "touch"]
    assert found.residual < 1e-9


@pytest.mark.parametrize("seed", [2, 3, 5, 8])
def test_the_onset_in_space_with_open_nodes_is_the_first_event_of_small_increments(seed):
    rng, steps = np.random.default_rng(seed), 100
    contact = random_contact(rng, 5)
    loads = vectors(contact)
    loads["mean"] = loads["mean"] - np.r_[np.zeros(10), 2.0 * (rng.random(5) < 0.4)]
    contact = fo.ContactSystem(contact.S, contact.points, loads)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}])
    found = fo.onset(contact, cycle, 1.5)
    first = min(event.load_factor for event in (found.slip, found.separation, found.touch))
    assert found.state.open.any() and 1e-3 < first < np.inf
    factor = 2 * first
    path = fo.march(contact, cycle, 1.5, factor, cycles=1, steps=steps, progress=False)
    assert first_event(path, factor) == pytest.approx(first, abs=1.01 * factor / steps)


def test_a_picture_and_the_reason_tell_the_settled_mean_load():
    pair = unit_nodes({"P": ([0, 0], [2.0, -1.0]), "Q": ([1.0, 0.0], [0.0, 0.5])})
    found = fo.onset(pair, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), 0.5)
    assert (found.slip.load_factor, found.slip.node, found.touch.load_factor, found.touch.node) == (
        1.0,
        0,
        2.0,
        1,
    )
    assert found.plot().get_title() == "contact under the settled mean load, at the onset of slip"
    assert "with 1 node open" in found.reason and "touch" in repr(found)
    # Nothing holds the open node.
    free = fo.ContactSystem.from_blocks(
        np.eye(2), np.zeros((2, 2)), np.zeros((2, 2)), [0, 1], pair.bonded
    )
    assert fo.onset(free, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), 0.5).state is None


@pytest.mark.parametrize(
    ("q0", "p0", "q1", "p1", "first"),
    [
        (0.2, 2.0, 0.5, -2.0, 0.8 / 1.5),  # the bound, p / 2, shrinks faster than the shear grows
        (0.0, 2.0, 0.5, 0.0, 2.0),
        (0.5, 2.0, -0.5, 0.4, 5.0),
        (0.5, 2.0, 0.3, 0.6, np.inf),
        (1.0, 2.0, 0.5, -1.0, 0.0),
        (0.0, 4.0, 0.0, -8.0, 0.5),
        # Without pressure: pulled off, and sheared less than by its bound, or more.
        (0.0, 0.0, 0.3, -1.0, 0.0),
        (0.0, 0.0, 0.8, -1.0, 0.0),
        (0.0, 0.0, 0.3, 0.4, 0.0),
        (0.0, 0.0, 0.3, 1.0, np.inf),
        # At its bound, which the load relieves: it waits for the other one.
        (-1.0, 2.0, 1.0, 0.0, 2.0),
        (-1.0, 2.0, -0.5, 1.0, np.inf),  # or leaves there
    ],
)
def test_a_node_slips_first_where_its_shear_leaves_its_bound_in_the_plane_and_in_any_direction_in_space(
    q0, p0, q1, p1, first
):
    """Beside a node that holds more."""
    turn = np.array([0.6, 0.8])
    shears = {"mean": np.array([q0, 0.0]), "cyclic": np.array([q1, 0.0])}
    presses = {"mean": np.array([p0, 1.0]), "cyclic": np.array([p1, 0.0])}
    plane = unit_nodes({name: (shears[name], presses[name]) for name in shears})
    solid = fo.ContactSystem(
        np.eye(6),
        np.eye(3)[:2],
        {name: np.r_[turn[0] * q, turn[1] * q, presses[name]] for name, q in shears.items()},
    )
    for contact in (plane, solid):
        found = fo.onset(contact, ONE_WAY, 0.5)
        assert found.mean_admissible and found.slip.load_factor == pytest.approx(first, abs=1e-12)
        assert found.slip.node == (None if first == np.inf else 0)
        # Without pressure yet, but pressed by the load, too.
        assert (found.separation.load_factor == np.inf) == (p1 >= 0)


def test_shear_of_pressing_alone_asks_for_friction_and_for_no_less_shear():
    """Shears of +-0.8 balance each other: the load has no shear as a whole. With 0.8 and 0.2 it has
    a shear."""
    for shears, expected in (
        (
            (0.8, -0.8),
            "more friction; the resultant shear of the load is zero: the pressing load causes the shear",
        ),
        ((0.8, 0.2), "more friction, or less shear"),
    ):
        loads = {"P": (shears, [1.0, 1.0]), "Q": ([1.0, 1.0], [0.0, 0.0])}
        pair = unit_nodes(loads)
        first = fo.onset(pair, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), 0.5)
        assert expected in first.reason and ("less shear" in first.reason) is ("less" in expected)
