"""Limits within a gap: their errors and steps, and their times against those of exact limits.

`norm` is the norm of T times friction, with T the pressures per unit shear force on the closed
contact. If it is below 1, the repair of multipliers is proven to converge.
"""

import os
import re
import subprocess
import sys
import time

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.limits import pose
from frictopt.limits.program.rest_program import elastic
from studies.half_space import CYCLE, punch_on_half_space

BULK = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])


def printed_by(code, *arguments):
    """The numbers that a new process prints, with one thread."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )
    return [float(number) for number in done.stdout.split()]


def steps_of(limit):
    return int(re.search(r"(\d+) steps", limit.reason)[1])


def random_contact(rng, tangents, coupling, below=30):
    """A contact whose compliance falls with the distance of its nodes, and its load cycle."""
    nodes, corners = int(rng.integers(4, below)), int(rng.integers(2, 5))
    x = rng.uniform(0, 1, (nodes, 2))
    if tangents == 1:
        x[:, 0].sort()
    distance = np.linalg.norm(x[:, None] - x[None], axis=2)
    own = np.exp(-distance / 0.3)
    compliance = np.kron(np.eye(tangents + 1), own)
    for axis in range(tangents):
        shear = slice(axis * nodes, (axis + 1) * nodes)
        mixed = np.subtract.outer(x[:, axis], x[:, axis]) / 0.3 * own * coupling
        compliance[shear, tangents * nodes :] = mixed
        compliance[tangents * nodes :, shear] = mixed.T
    compliance += max(0.0, 1e-2 - np.linalg.eigvalsh(compliance)[0]) * np.eye(len(compliance))
    S = np.linalg.inv(compliance)
    size = tangents * nodes
    loads = {"P": np.r_[0.1 * rng.normal(size=size), rng.uniform(0.5, 1.5, nodes)]}
    for k in range(corners):
        loads[f"c{k}"] = np.r_[rng.normal(size=size), 0.3 * rng.normal(size=nodes)]
    points = np.column_stack([x, np.zeros(nodes)])
    if tangents == 1:
        points = np.column_stack([np.arange(float(nodes)), np.zeros(nodes)])
    contact = fo.ContactSystem((S + S.T) / 2, points, loads)
    return contact, fo.LoadCycle({"P": 1.0}, [{f"c{k}": 1.0} for k in range(corners)])


@pytest.mark.filterwarnings("ignore:shakedown_limit. stopped")
@pytest.mark.parametrize(("coupling", "most_friction", "share"), [(0.6, 1.0, 1.0), (2.0, 3.0, 0.8)])
def test_random_contacts(coupling, most_friction, share, record_property):
    """No exact limit of 100 contacts is outside the gap; this share of them needs at most 2000 steps."""
    rng = np.random.default_rng(17)
    steps, norms = [], []
    for number in range(100):
        contact, cycle = random_contact(rng, 1 + number % 2, rng.uniform(0, coupling))
        f = rng.uniform(0.1, most_friction, contact.nodes)
        closed = np.zeros(contact.nodes, dtype=bool)
        exact = fo.shakedown_limit(contact, cycle, f, open_nodes=closed)
        if exact.kind is fo.LimitKind.UNBOUNDED:
            # Friction wedges the contact. The exact program proves it, so there are no steps to
            # count.
            limit = fo.shakedown_limit(contact, cycle, f, open_nodes=closed, gap=0.01)
            assert limit.kind is exact.kind
            continue
        pressing = elastic(pose(contact, cycle, f)).normal
        norms.append(np.linalg.norm(f[:, None] * pressing, 2))
        try:
            limit = fo.shakedown_limit(contact, cycle, f, open_nodes=closed, gap=0.01)
        except fo.SolverError:
            # Where friction times T is far above 1, the repair of multipliers may not converge.
            assert norms[-1] > 1
            steps.append(np.inf)
            continue
        assert exact.kind is limit.kind is fo.LimitKind.FINITE
        assert limit.load_factor <= exact.load_factor * (1 + 1e-8)
        assert limit.bound >= exact.load_factor * (1 - 1e-8)
        steps.append(steps_of(limit))
    median, most = np.median(steps), max(steps)
    print(
        f"\n    {len(steps)} finite, norm up to {max(norms):.2f}, steps: median {median:.0f}, most {most}"
    )
    ended = np.array(steps) <= 2000
    record_property("ended", float(ended.mean()))
    print(
        f"    {ended.mean():.0%} within 2000 steps; norms of the others {np.array(norms)[~ended]}"
    )
    assert ended.mean() >= share


def test_required_frictions_of_random_contacts(record_property):
    """The gap of 1 % contains the exact frictions of 60 contacts, after at most 3000 steps."""
    rng = np.random.default_rng(17)
    steps = []
    for number in range(60):
        contact, cycle = random_contact(rng, 1 + number % 2, rng.uniform(0, 0.6), below=16)
        closed = np.zeros(contact.nodes, dtype=bool)
        load_factor = rng.uniform(0.3, 1.0) * (
            fo.shakedown_limit(contact, cycle, 0.7, open_nodes=closed).load_factor
        )
        exact = fo.required_friction(contact, cycle, load_factor)
        answer = fo.required_friction(contact, cycle, load_factor, gap=0.01)
        assert answer.bound >= 0.99 * answer.required
        # With open nodes less friction may be enough.
        assert exact.bound <= answer.required * (1 + 1e-8)
        assert answer.bound <= exact.required * (1 + 1e-8) or exact.open.any()
        steps.append(steps_of(answer))
    record_property("steps", float(np.median(steps)))
    print(f"\n    steps: median {np.median(steps):.0f}, most {max(steps)}")
    assert max(steps) <= 3000


def test_the_required_friction_of_400_nodes(record_property):
    """The friction to 1 % takes at most half of the time of the exact friction."""
    spent, answers = [], []
    for elements, gap in ((4, None), (4, 0.01), (19, None), (19, 0.01)):  # small ones compile
        contact = fo.scenes.SquarePunch(elements=elements).condense()
        with threadpool_limits(1):
            start = time.process_time()
            answers.append(fo.required_friction(contact, BULK, 1.0, gap=gap))
            spent.append(time.process_time() - start)
    ratio = spent[3] / spent[2]
    record_property("ratio", ratio)
    print(f"\n    within 1 % {spent[3]:.2f} s, exact {spent[2]:.2f} s, ratio {ratio:.2f}")
    assert answers[3].bound <= answers[2].required and answers[2].bound <= answers[3].required
    assert ratio < 0.5


@pytest.mark.parametrize(("elements", "gap", "most"), [(19, 0.01, 350), (19, 0.001, 900)])
def test_steps_of_a_square_punch(elements, gap, most):
    contact = fo.scenes.SquarePunch(elements=elements).condense()
    limit = fo.shakedown_limit(contact, BULK, 0.5, gap=gap)
    print(f"\n    {steps_of(limit)} steps")
    assert limit.gap <= gap and steps_of(limit) <= most


def test_steps_of_a_dovetail_that_wedges():
    contact = fo.scenes.Dovetail(elements=30).condense()
    cycle = fo.LoadCycle({"pull": 1.0}, [{"sway": 1.0}, {"sway": -1.0}])
    limit = fo.shakedown_limit(contact, cycle, 0.4, gap=0.01)
    norm = 0.4 * np.linalg.norm(elastic(limit._question).normal, 2)
    print(f"\n    norm {norm:.2f}, {steps_of(limit)} steps")
    assert limit.gap <= 0.01 and steps_of(limit) <= 600


def test_900_nodes_against_the_exact_limit(tmp_path, record_property):
    """Each contact is new, so that each time includes the work that its questions share."""
    fo.scenes.SquarePunch(elements=29).condense().save(tmp_path / "contact.npz")
    spent = []
    for gap in (None, None, 0.01):  # the first call compiles
        contact = fo.ContactSystem.load(tmp_path / "contact.npz")
        with threadpool_limits(1):
            start = time.process_time()
            limit = fo.shakedown_limit(contact, BULK, 0.5, gap=gap)
            spent.append(time.process_time() - start)
    assert steps_of(limit) <= 350
    ratio = spent[2] / spent[1]
    record_property("ratio", ratio)
    print(f"\n    within 1 % {spent[2]:.2f} s, exact {spent[1]:.2f} s, ratio {ratio:.2f}")
    assert ratio < 0.6


def test_2500_nodes_within_a_thousandth(tmp_path, record_property):
    """They take at most 0.4 of the time of the exact limit, at a second friction at most 0.25."""
    path = tmp_path / "contact.npz"
    code = (
        "import resource, sys, time, frictopt as fo\n"
        "cycle = fo.LoadCycle({'P': 1.0}, [{'sigma': -1.0}, {'sigma': 1.0}])\n"
        "small = fo.scenes.SquarePunch(elements=9).condense()\n"
        "gap = eval(sys.argv[2])\n"
        "fo.shakedown_limit(small, cycle, 0.5, gap=gap)\n"
        "contact, start = fo.ContactSystem.load(sys.argv[1]), time.process_time()\n"
        "limit = fo.shakedown_limit(contact, cycle, 0.5, gap=gap)\n"
        "print(limit.load_factor, limit.bound, time.process_time() - start)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)\n"
        "start = time.process_time()\n"
        "fo.shakedown_limit(contact, cycle, 0.4, gap=gap or 0.001)\n"
        "print(time.process_time() - start)\n"
    )
    fo.scenes.SquarePunch(elements=49).condense().save(path)
    exact, within = (printed_by(code, path, gap) for gap in ("None", "0.001"))
    ratio = within[2] / exact[2]
    record_property("ratio", ratio)
    print(
        f"\n    {within[2]:.0f} s and {within[3]:.1f} GB, exact {exact[2]:.0f} s, {exact[3]:.1f} GB, "
        f"second friction {within[4]:.0f} s"
    )
    assert within[4] <= 0.25 * exact[2]
    assert within[0] <= exact[0] * (1 + 1e-8) and exact[0] <= within[1] * (1 + 1e-8)
    assert within[1] - within[0] <= 0.001 * within[1] and ratio < 0.4


def test_half_spaces_of_4096_and_16384_nodes(record_property):
    """Four times the nodes take at most 4.5 times the time, and at most 600 steps to 1 %."""
    fo.shakedown_limit(punch_on_half_space(12), CYCLE, 0.5, gap=0.01)
    spent = []
    for cells in (64, 128):
        with threadpool_limits(1):
            start = time.process_time()
            limit = fo.shakedown_limit(punch_on_half_space(cells), CYCLE, 0.5, gap=0.01)
            spent.append(time.process_time() - start)
        assert limit.gap <= 0.01 and steps_of(limit) <= 600
    ratio = spent[1] / spent[0]
    record_property("ratio", ratio)
    print(f"\n    {spent[0]:.1f} s and {spent[1]:.1f} s, ratio {ratio:.1f}")
    assert ratio <= 4.5


def test_900_nodes_by_products_alone(record_property):
    """They take at most twice the time of the condensed contact, and 1.1 times its memory."""
    code = (
        "import resource, sys, time, frictopt as fo\n"
        "cycle = fo.LoadCycle({'P': 1.0}, [{'sigma': -1.0}, {'sigma': 1.0}])\n"
        "model, start = fo.scenes.SquarePunch(elements=29).model(), time.process_time()\n"
        "contact = getattr(model, sys.argv[1])()\n"
        "limit = fo.shakedown_limit(contact, cycle, 0.5, gap=0.01)\n"
        "print(limit.load_factor, limit.bound, time.process_time() - start)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)\n"
    )
    condensed, products = (printed_by(code, kind) for kind in ("condense", "products"))
    ratio, memory = products[2] / condensed[2], products[3] / condensed[3]
    record_property("ratio", ratio)
    print(f"\n    {products[2]:.1f} s, ratio {ratio:.2f}; {products[3]:.2f} GB, ratio {memory:.2f}")
    assert ratio <= 2 and memory <= 1.1
    assert products[0] == pytest.approx(condensed[0], rel=1e-3)
    assert products[1] == pytest.approx(condensed[1], rel=1e-3)
