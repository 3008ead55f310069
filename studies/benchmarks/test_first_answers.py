"""The first answer of a new process, and the compilation of the exact path.

The rival is a process that only imports the necessary packages. Each process is timed by its
processor time, including the start of Python, as the least of a few runs by turns. The system is
loaded from a file, and the bytecode and machine code are on disk.
"""

import os
import resource
import subprocess
import sys

import numpy as np
import pytest

_ASK = (
    "import sys, frictopt as fo\n"
    "system = fo.ContactSystem.load(sys.argv[1])\n"
    "cycle = fo.LoadCycle({'P': 1.0}, [{'sigma': -1.0}, {'sigma': 1.0}])\n"
)
FIRST = {
    # The question, the imports that its process needs at least, and the largest ratio.
    "limit": ("assert fo.shakedown_limit(system, cycle, 0.7).load_factor > 0", "cvxpy", 1.35),
    "limit with open nodes": (
        "gap = 2.0 * system.x**4\n"
        "assert fo.shakedown_limit(system.with_gap(gap), cycle, 0.6).open.any()",
        "cvxpy, numba",
        2.3,
    ),
    "exact path": ("fo.steady_state(system, cycle, 0.7, 1.0)", "numpy, numba", 3.3),
}


def spent(code, *arguments, **environment):
    """Processor time of a new process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-c", code, *arguments],
        check=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment},
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("first")


@pytest.mark.parametrize("question", FIRST)
def test_first_answer_against_its_imports(system, folder, question, record_property):
    asked, packages, most = FIRST[question]
    file = folder / "contact.npz"
    system.save(file)
    kept = {
        "PYTHONDONTWRITEBYTECODE": "",
        "PYTHONPYCACHEPREFIX": str(folder / "bytecode"),
        "NUMBA_CACHE_DIR": str(folder / "machine"),
    }
    calls = [(_ASK + asked, str(file)), (f"import {packages}",)]
    for call in calls:
        spent(*call, **kept)
    rounds = [[spent(*call, **kept) for call in calls] for _ in range(3)]
    ours, rival = np.min(rounds, axis=0)
    record_property("ratio", ours / rival)
    print(f"\n    ours {ours:.2f} s, imports {rival:.2f} s, ratio {ours / rival:.2f}")
    assert ours / rival < most


def test_compilation_of_the_exact_path(tmp_path, record_property):
    """The compilation takes less than 8 s beside the imports, without machine code on disk."""
    code = "from frictopt.transients.exact.kernel import compiled; compiled()"
    kept = {"NUMBA_CACHE_DIR": str(tmp_path)}
    first = spent(code, **kept)
    seconds = first - spent(code, **kept)
    record_property("seconds", seconds)
    print(f"\n    {seconds:.1f} s")
    assert seconds < 8.0
