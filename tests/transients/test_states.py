"""A transient that begins from an earlier state continues as if it had never stopped.

Some nodes are open at the state.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.systems import CYCLE, random_system, system

THREE = fo.LoadCycle({"mean": 1.0}, [{"cyclic": -1.0}, {"cyclic": 0.3}, {"cyclic": 1.0}])


@pytest.fixture(scope="module")
def whole(rounded, paper_cycle):
    """A transient of three cycles, with nodes that are open always and nodes that slip."""
    path = fo.march(rounded, paper_cycle, 0.6, 1.5, cycles=3)
    assert (path.status == 2).any(axis=1).all() and path.cycle_work[-1].sum() > 0
    return path


def same_end(one, other, size):
    return (
        max(
            np.abs(getattr(one, name)[-1] - getattr(other, name)[-1]).max()
            for name in ("slip", "gap", "q", "p")
        )
        <= 1e-10 * size
    )


@pytest.mark.parametrize("seed", few(range(10)))
def test_random_contacts_go_on_from_any_state(seed):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, 3).with_gap(0.3 * rng.random(3) * (rng.random(3) < 0.5))
    whole = fo.march(contact, THREE, 0.3, 1.0, initial_slip=rng.normal(size=3), cycles=2)
    for row in np.flatnonzero(whole.time < 3):
        again = fo.march(
            contact,
            THREE,
            0.3,
            1.0,
            initial_state=whole.state_at(int(row)),
            cycles=1 + (whole.time[row] == 0),
        )
        assert same_end(whole, again, 1.0)


def test_increments_go_on_from_a_state(rounded, paper_cycle, whole):
    state = whole.state_at(int(np.flatnonzero(whole.time == 3)[-1]))
    options = {"initial_state": state, "cycles": 1, "steps": 3}
    assert (
        np.abs(fo.march(rounded, paper_cycle, 0.6, 1.5, **options).slip[-1] - whole.slip[-1]).max()
        < 1e-2 * np.abs(whole.slip[-1]).max()
    )


def test_a_study_begins_from_a_state(rounded, paper_cycle, tmp_path):
    above = fo.steady_state(rounded, paper_cycle, 0.6, 1.5)
    starts = [
        fo.starts.Start("earlier", "after the larger load", state=above.state),
        *fo.starts.no_slip(),
    ]
    table = fo.dissipation_study(
        rounded, paper_cycle, 0.6, [0.7, 1.5], starts, store=tmp_path / "runs", progress=False
    )
    for row in table.itertuples():
        begin = {"initial_state": above.state} if row.family == "earlier" else {}
        steady = fo.steady_state(rounded, paper_cycle, 0.6, row.load_factor, **begin)
        assert row.outcome == steady.outcome.name and row.dissipation == steady.dissipation
    assert table.amplitude[0] == pytest.approx(np.sqrt(np.mean(above.slip**2)))
    assert len(fo.results.read_store(tmp_path / "runs")) == 4


def one_node():
    return system(1.0, 0.2, 0.0, 1.0, 1.0, 0.3)


@pytest.mark.parametrize(
    ("message", "call"),
    [
        ("violates the contact law by", lambda: fo.ContactState([5.0], [0.0], [0.0], [1.0])),
        ("violates the contact law by", lambda: fo.ContactState([0.0], [1.0], [0.0], [1.0])),
        (
            r"its slip has the shape \(2,\), a slip of the contact \(1,\)",
            lambda: fo.ContactState([0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [1.0, 1.0]),
        ),
        (
            "next corner is 2, the load cycle has the corners 0 to 1",
            lambda: fo.ContactState([0.0], [0.0], [0.0], [1.0], 2),
        ),
        ("a str; give a ContactState", lambda: "state"),
        ("stresses the contact", lambda: fo.ContactState([1e40], [0.0], [0.0], [1.0])),
    ],
)
def test_states_that_do_not_fit_are_refused(message, call):
    state = call()
    for run in (fo.steady_state, fo.march):
        with pytest.raises(fo.ModelError, match=f"initial_state: .*{message}"):
            run(one_node(), CYCLE, 0.5, 0.1, initial_state=state)


def test_a_slip_and_a_state_are_one_too_many():
    state = fo.ContactState([0.0], [0.0], [0.0], [1.0])
    with pytest.raises(fo.ModelError, match="both are given"):
        fo.steady_state(one_node(), CYCLE, 0.5, 0.1, initial_slip=[0.0], initial_state=state)
    with pytest.raises(fo.ModelError, match="two of slip"):
        fo.starts.Start("a", "b", slip=[0.0], state=state)
    with pytest.raises(fo.ModelError, match=r"start 'b' has a slip of shape \(1,\)"):
        fo.dissipation_study(
            random_system(np.random.default_rng(0), 2),
            CYCLE,
            0.5,
            [0.1],
            [fo.starts.Start("a", "b", state=state)],
        )


def test_a_state_that_does_not_exist_is_refused():
    path = fo.march(one_node(), CYCLE, 0.5, 0.1, cycles=1)
    with pytest.raises(fo.ModelError, match="number"):
        path.state_at(len(path.time))


def test_the_table_of_a_state():
    assert fo.ContactState([0.5], [0.1], [0.0], [1.0]).to_frame().to_dict("list") == {
        "node": [0],
        "slip": [0.5],
        "gap": [0.1],
    }


def test_of_a_gap_and_a_pressure_the_smaller_one_is_rounding():
    contact = one_node()
    pressed = fo.steady_state(
        contact, CYCLE, 0.5, 0.1, initial_state=fo.ContactState([0.0], [1e-15], [0.0], [1.0])
    )
    assert pressed.outcome is fo.Outcome.SHAKEDOWN and not pressed.state.gap.any()


def test_a_state_names_the_corner_that_comes_next_by_its_loads(whole, rounded, paper_cycle):
    for row in range(len(whole.time)):
        state = whole.state_at(row)
        loads = paper_cycle.corner_names[int(np.floor(whole.time[row] + 1e-9)) % 2]
        assert state.next_loads == loads == paper_cycle.corner_names[state.next_corner]
        assert f"next_corner={loads!r}" in repr(state)
    cycle = fo.LoadCycle(paper_cycle.mean, paper_cycle.corners[::-1])
    states = (
        fo.steady_state(rounded, cycle, 0.6, 0.2).state,
        fo.shakedown_limit(rounded, cycle, 0.6).state,
    )
    assert {state.next_loads for state in states} == {cycle.corner_names[0]} != {loads}
    assert "next_corner=1)" in repr(fo.ContactState([0.0], [0.0], [0.0], [1.0], 1))
    with pytest.raises(fo.ModelError, match=r"next_loads: .* is not a text"):
        fo.ContactState([0.0], [0.0], [0.0], [1.0], next_loads={"sigma": 1.0})
    with pytest.raises(
        fo.ModelError,
        match=r"its next corner is 2 \(cyclic = \+1\), the load cycle has the corners 0 to 1",
    ):
        fo.march(
            one_node(),
            CYCLE,
            0.5,
            0.1,
            initial_state=fo.march(one_node(), THREE, 0.5, 0.1, cycles=1).state_at(-2),
        )


def nearly_free(rng, nodes):
    """A random contact whose common slip has next to no stiffness.

    Its slips are large, and rounding of forces moves them.
    """
    contact = random_system(rng, nodes)
    common = np.r_[np.ones(nodes), np.zeros(nodes)]
    held = contact.S @ common
    S = contact.S - np.outer(held, held) / (common @ held) * (1 - 10.0 ** rng.uniform(-8, -4))
    return fo.ContactSystem(S, contact.points, dict(contact.bonded))


def test_the_states_of_each_steady_state_are_found_and_in_equilibrium():
    """They also lie between the corners, where the steady state itself does not look."""
    accepted = 0
    for seed in [68, 150, 189, 192, 243, 245, 261, *few(range(60))]:
        rng = np.random.default_rng(seed)
        contact = nearly_free(rng, int(rng.integers(2, 9)))
        friction = rng.uniform(0.2, 0.8)
        load_factor = float(rng.uniform(0.5, 3.0))
        try:
            steady = fo.steady_state(contact, CYCLE, friction, load_factor, most_cycles=300)
        except (fo.NoContinuation, fo.SolverError):
            continue
        path = steady.states()
        u, r, load = (
            np.hstack(parts)
            for parts in ((path.slip, path.gap), (path.q, path.p), (path.bonded_q, path.bonded_p))
        )
        assert np.abs(r - load - u @ contact.S).max() < 1e-10 * np.abs(load).max()
        work = steady.period * steady.dissipation
        # Rounding of forces moves the slip of a contact that next to nothing holds.
        assert path.work[-1].sum() == pytest.approx(work, rel=2e-5, abs=1e-9)
        accepted += 1
    assert accepted > 10
