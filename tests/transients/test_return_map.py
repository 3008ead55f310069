"""The derivative of a cycle against differences."""

from functools import partial

import numpy as np
import pytest

import frictopt as fo
from frictopt.transients.exact import return_map
from helpers.paths import followed
from helpers.systems import CYCLE, random_system, system

STEP = 1e-8


at_last_corner = partial(followed, cycles=1)  # a path from a slip


def after_a_cycle(path):
    """State and work of one more cycle of a path."""
    found = path.cycle_on(1)
    return found.u[-1], found.work.sum()


def stops_within_segments(status):
    """Number of changes of status that stop some motion and let another motion continue.

    Such changes only happen within a segment.
    """
    before, after = status[:-1], status[1:]
    return int(
        (
            ((before != 0) & (after == 0)).any(axis=1)
            & ((abs(before) == 1) & (after == before)).any(axis=1)
        ).sum()
    )


def test_it_agrees_with_differences():
    checked = stops = opens = 0
    for seed in range(240):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 8))
        contact = random_system(rng, n, ("mean", "one", "other"), coupling=rng.uniform(0.2, 1.0))
        cycle = fo.LoadCycle(
            {"mean": 1.0},
            [{"one": 1.0}, {"other": 1.0}, {"one": -1.0, "other": 0.3}, {}][: 2 + seed % 3],
        )
        problem = (contact, cycle, rng.uniform(0.2, 0.6), rng.uniform(0.1, 2.5))
        start = 0.3 * rng.normal(size=n)
        try:
            path = at_last_corner(*problem, start)
            one = return_map(path)
        except fo.NoContinuation:
            continue
        begin, (end, work) = one.before, after_a_cycle(path)
        stops += stops_within_segments(one.status)
        opens += bool((one.status == 2).any())
        for _ in range(3):
            step, found = STEP * rng.normal(size=n), []
            for sense in (1, -1):
                path = at_last_corner(*problem, start + sense * step)
                before = path.state.u.copy()
                found.append(
                    (
                        before - begin,
                        *(
                            new - old
                            for new, old in zip(after_a_cycle(path), (end, work), strict=True)
                        ),
                    )
                )
            size = np.abs(found[0][0]).max()
            if size < 1e-3 * STEP or any(
                np.abs(there + back).max() > 1e-5 * size for there, back in zip(*found, strict=True)
            ):
                # One side has another cycle than the other side, where events happen at once.
                continue
            for change, moved, gained in found:
                assert np.abs(moved - one.derivative @ change).max() < 1e-4 * size
                assert gained == pytest.approx(
                    one.work_gradient @ change, rel=1e-3, abs=1e-4 * size
                )
            checked += 1
    assert checked > 250 and stops > 20 and opens > 30


def test_one_node_forgets_its_start():
    one = return_map(at_last_corner(system(2.0, 0.5, 0.1, 1.0, 1.0, 0.2), CYCLE, 0.4, 0.6, [0.0]))
    assert not one.locked.any() and not one.derivative.any()
    stuck = return_map(at_last_corner(system(2.0, 0.5, 0.1, 1.0, 1.0, 0.2), CYCLE, 0.4, 0.1, [0.0]))
    assert stuck.locked.all() and np.array_equal(stuck.derivative, np.diag([1.0, 0.0]))
    assert not stuck.work_gradient[0] > 1e-15


def test_motions_on_each_stretch_keep_the_law():
    """Reactions at slipping nodes stay on their bound, reactions at open nodes stay zero, and a
    sticking node keeps its slip."""
    stretches = opens = 0
    for seed in range(8):
        n = 5
        contact = random_system(np.random.default_rng(seed), n)
        one = return_map(at_last_corner(contact, CYCLE, 0.3, 2.0, np.zeros(n)))
        last = np.eye(2 * n)
        for number, status in enumerate(one.status):
            motion = one.motions[number]
            q, p = np.split(contact.S @ motion, 2)
            assert np.abs(q + (status * 0.3)[:, None] * p)[np.abs(status) == 1] == pytest.approx(
                0.0, abs=1e-12
            )
            assert np.abs(np.vstack([q, p]))[np.tile(status == 2, 2)] == pytest.approx(
                0.0, abs=1e-12
            )
            stuck = (status == 0) & (number > 0) & (one.status[number - 1] == 0)
            assert motion[:n][stuck] == pytest.approx(last[:n][stuck], abs=1e-12)
            last = motion
            stretches = stretches + 1
            opens = opens + (status == 2).any()
        assert last == pytest.approx(np.asarray(one.derivative), abs=1e-12)
    assert stretches > 30 and opens > 5


def symmetric_contact(rng, nodes):
    """A random contact that is its own mirror image; its loads are symmetric, too."""
    contact = random_system(rng, nodes, ("mean", "one", "other"), coupling=rng.uniform(0.2, 1.0))
    reversed_order = np.eye(nodes)[::-1]
    none = np.zeros((nodes, nodes))
    mirror = np.block([[-reversed_order, none], [none, reversed_order]])
    loads = {}
    for name, (q, p) in contact.bonded.items():
        r = np.concatenate([q, p])
        loads[name] = tuple(np.split((r + mirror @ r) / 2, 2))
    return fo.ContactSystem((contact.S + mirror @ contact.S @ mirror.T) / 2, contact.points, loads)


def test_a_closed_node_has_no_gap_that_could_change_also_if_two_close_at_once():
    """In a symmetric contact twin nodes open and close at the same time."""
    twins_that_close = 0
    for seed in range(0, 100, 2):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(3, 7))
        contact = symmetric_contact(rng, n)
        cycle = fo.LoadCycle({"mean": 1.0}, [{"one": 1.0}, {"other": 1.0}])
        try:
            one = return_map(at_last_corner(contact, cycle, 0.4, rng.uniform(0.5, 3), np.zeros(n)))
        except fo.NoContinuation:
            continue
        twins_that_close += int(((one.status[:-1] == 2) & (one.status[1:] != 2)).sum())
        for number, status in enumerate(one.status):
            gaps = one.motions[number][n:]
            assert np.abs(gaps[status != 2]).max(initial=0.0) < 1e-9
    assert twins_that_close > 10
