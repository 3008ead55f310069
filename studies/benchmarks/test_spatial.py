"""Three dimensions with 400 nodes and with 50,000 unknowns: times and memory.

The rivals are the bare solver and one dense solve. Each call is timed once or a few times by the
processor time of one thread, because it takes seconds.
"""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.contact import joined
from frictopt.limits import pose
from frictopt.limits.program import assembled
from frictopt.solve import interior_point
from frictopt.solve.solvers import run
from frictopt.transients.increments.sweeps import sweep

BULK = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])


@pytest.fixture(scope="module")
def model():
    return fo.scenes.SquarePunch(elements=19, block_half_width=5.0, block_depth=4.0).model()


@pytest.fixture(scope="module")
def contact(model):
    return model.condense()


def seconds(call, rounds=1):
    """Least processor time of a call with one thread."""
    spent = []
    with threadpool_limits(1):
        for _ in range(rounds):
            start = time.process_time()
            call()
            spent.append(time.process_time() - start)
    return min(spent)


def ratio(ours, rival, record_property):
    record_property("ratio", ours / rival)
    print(f"\n    ours {ours:.3g} s, rival {rival:.3g} s, ratio {ours / rival:.2f}")
    return ours / rival


@pytest.mark.parametrize(("elements", "most"), [(19, 1.5), (29, 0.15)])
def test_limit_against_the_bare_solver(elements, most, record_property):
    """The limit of the whole contact, with its assembly and the proof, against Clarabel on the same cones."""
    contact = fo.scenes.SquarePunch(elements=elements).condense()
    limits = []
    program = assembled.shakedown(pose(contact, BULK, 0.5, simplify=False))
    arrays = program.arrays()
    ours = seconds(
        lambda: limits.append(fo.shakedown_limit(contact, BULK, 0.5, simplify=False)), rounds=3
    )
    assert limits[0].residual <= 1e-9 and limits[0].record.solver == "INTERIOR_POINT"
    rival = seconds(lambda: run(arrays, "CLARABEL", -np.inf))
    assert ours < 8.0 and ratio(ours, rival, record_property) < most


def test_steps_through_the_block_against_direct_ones(record_property, monkeypatch):
    """The limit of 900 nodes, against the limit with direct steps only."""
    contact = fo.scenes.SquarePunch(elements=29).condense()
    limits = []

    def ask():
        limits.append(fo.shakedown_limit(contact, BULK, 0.5, simplify=False))

    # This call compiles, and stores what all questions about the contact share.
    ask()
    ours = seconds(ask, rounds=2)
    monkeypatch.setattr(interior_point, "begins_through_block", lambda program: False)
    rival = seconds(ask, rounds=2)
    found = [limit.load_factor for limit in limits]
    assert np.ptp(found) <= 1e-9 * max(found)
    assert ratio(ours, rival, record_property) < 0.95


def test_memory_of_1600_nodes_in_stiffnesses(tmp_path, record_property):
    """Largest memory of a limit, in sizes of the stiffness.

    The memory that the process holds after a small limit is subtracted. This small limit also
    compiles the increments, on its path to the mean load.
    """
    contact = fo.scenes.SquarePunch(elements=39).condense()
    contact.save(tmp_path / "contact.npz")
    code = (
        "import re, sys, frictopt as fo\n"
        "from pathlib import Path\n"
        # The resource usage of a process begins with the memory of its parent.
        "def memory(kind): return int(re.search(kind + r':\\s*(\\d+)', Path('/proc/self/status').read_text())[1])\n"
        "cycle = fo.LoadCycle({'P': 1.0}, [{'sigma': -1.0}, {'sigma': 1.0}])\n"
        "small = fo.scenes.SquarePunch(elements=14).condense()\n"
        "fo.shakedown_limit(small, cycle, 0.5, simplify=False)\n"
        "before, contact = memory('VmRSS'), fo.ContactSystem.load(sys.argv[1])\n"
        "limit = fo.shakedown_limit(contact, cycle, 0.5, simplify=False)\n"
        "print(limit.residual, memory('VmHWM') - before)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, tmp_path / "contact.npz"],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )
    residual, kilobytes = map(float, done.stdout.split())
    stiffnesses = 1024 * kilobytes / contact.S.nbytes
    record_property("stiffnesses", stiffnesses)
    print(f"\n    {stiffnesses:.2f} stiffnesses")
    assert residual <= 1e-9 and stiffnesses < 2.9


def test_limit_and_safe_slip_of_2500_nodes(record_property):
    """Limit and safe slip each take less than 180 s and 8 GB, proven from both sides."""
    code = (
        "import resource, time, frictopt as fo\n"
        "contact = fo.scenes.SquarePunch(elements=49).condense()\n"
        "cycle, start = fo.LoadCycle({'P': 1.0}, [{'sigma': -1.0}, {'sigma': 1.0}]), time.process_time()\n"
        "limit, middle = fo.shakedown_limit(contact, cycle, 0.5, simplify=False), time.process_time()\n"
        "safe = fo.safe_slip(contact, cycle, 0.5, 0.9 * limit.load_factor, simplify=False)\n"
        "print(limit.residual, safe.residual, middle - start, time.process_time() - middle, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )
    *residuals, limit, safe, memory = map(float, done.stdout.split())
    record_property("seconds", (limit, safe))
    record_property("gigabytes", memory / 1e6)
    assert max(residuals) <= 1e-9 and max(limit, safe) < 180 and memory < 8e6


def test_increment_against_one_dense_solve(contact, record_property):
    limit = fo.shakedown_limit(contact, BULK, 0.5)
    increments, load = (
        fo.increments.NewtonIncrement(contact, 0.5),
        contact.reaction({"P": 1.0, "sigma": -0.9 * limit.load_factor}),
    )
    zero, S, r = (
        np.zeros((contact.nodes, 2)),
        contact.S + np.eye(3 * contact.nodes),
        load[1].repeat(3),
    )
    assert (increments.solve(zero, load).status == 1).sum() > 20
    ours = seconds(lambda: increments.solve(zero, load), rounds=5)
    assert (
        ours < 0.2
        and ratio(ours, seconds(lambda: np.linalg.solve(S, r), rounds=5), record_property) < 5.0
    )


@pytest.mark.parametrize("elements", [9, 19])
def test_increment_against_bare_sweeps(elements, record_property):
    """The rival sweeps over all nodes to 1e-12, without a proof or a state."""
    contact = fo.scenes.SquarePunch(elements=elements).condense()
    factor = 0.9 * fo.shakedown_limit(contact, BULK, 0.5).load_factor
    increments, load = (
        fo.increments.NewtonIncrement(contact, 0.5),
        contact.reaction({"P": 1.0, "sigma": -factor}),
    )
    law, zero = increments.law, np.zeros((contact.nodes, 2))
    trial = joined(*load) / np.abs(load[1]).mean()

    def bare():
        u, r = np.zeros_like(trial), trial.copy()
        sweep(law.S, law.slopes, law.constants, law.augmentation, u, r, 1000, 1e-12, 1.0)
        return u

    assert (bare() != 0).any()
    ours = seconds(lambda: increments.solve(zero, load), rounds=100)
    assert ratio(ours, seconds(bare, rounds=100), record_property) < 1.5


def test_memory_at_50000_unknowns(record_property):
    code = (
        "import resource, frictopt as fo\n"
        "model = fo.scenes.SquarePunch(elements=24, block_half_width=6.0).model()\n"
        "assert sum(3 * body.mesh.p.shape[1] for body in model.bodies.values()) > 50000\n"
        "fo.shakedown_limit(model.condense(), fo.LoadCycle({'P': 1.0}, [{'sigma': -1.0}, {'sigma': 1.0}]), 0.5)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    record_property("gigabytes", int(done.stdout) / 1e6)
    # The unit is kB.
    assert int(done.stdout) < 2e6
