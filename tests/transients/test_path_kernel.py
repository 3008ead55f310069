"""The compiled core of the path.

The tests cover the folder that keeps it, that it is never stale, and that the program announces its
compilation.
"""

import ast
import os
import subprocess
import sys
from pathlib import Path

import frictopt
from frictopt.base import tolerances
from frictopt.transients import transient
from frictopt.transients.exact import kernel
from frictopt.transients.increments import sweeps

PACKAGE = Path(frictopt.__file__).parent

TRANSIENT = """
import frictopt as fo
contact = fo.ContactSystem.from_blocks([[2.0]], [[0.5]], [[2.0]], [0.0], {"P": ([0.1], [1.0]), "Q": ([1.0], [0.2])})
cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
print(fo.steady_state(contact, cycle, 0.4, 0.6).dissipation > 0)
"""


def run(code, **environment):
    paths = os.pathsep.join([str(PACKAGE.parent), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": paths, **environment},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )


def test_compiled_code_stands_in_two_files_that_import_no_compiled_code():
    """Numba judges its cache by the file of the outermost function. Code elsewhere could change
    without a new compilation."""
    rooms = PACKAGE / "transients"
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    compiled = {path for path, text in texts.items() if "@entry_point" in text or "@inner" in text}
    assert compiled == {rooms / "exact" / "kernel.py", rooms / "increments" / "sweeps.py"}
    decorators = rooms / "exact" / "compilation.py"
    assert {path for path, text in texts.items() if "import njit" in text} == {decorators}
    for path in compiled:
        imported = {
            node.module
            for node in ast.walk(ast.parse(texts[path]))
            if isinstance(node, ast.ImportFrom)
            and (node.level > 0 or node.module.startswith("frictopt"))
        }
        assert imported <= {"compilation", "state", "exact.compilation"}


def test_its_copies_of_the_tolerances_are_true():
    assert (kernel._ROUNDING, kernel._CONDENSATION, kernel._NO_DRIVE) == (
        tolerances.ROUNDING,
        tolerances.CONDENSATION,
        tolerances.NO_DRIVE,
    )
    assert sweeps._ROUNDING == tolerances.ROUNDING
    assert (sweeps.STICK, sweeps.SLIP, sweeps.OPEN) == (
        transient.STICK,
        transient.SLIP,
        transient.OPEN,
    )
    assert (kernel.STICK, kernel.OPEN) == (transient.STICK, transient.OPEN)


def test_the_compilation_announces_itself_once_where_no_folder_can_be_written():
    """This is so for a read-only installation with a read-only home. Here numba gets a folder that
    does not exist, within a zip archive."""
    found = run(TRANSIENT, NUMBA_CACHE_LOCATOR_CLASSES="ZipCacheLocator", NUMBA_OPT="0")
    assert found.stdout == "True\n" and found.stderr.count("frictopt: compiling") == 1


SLOW = """
import time
from numba.core.caching import Cache
load = Cache.load_overload
Cache.load_overload = lambda *asked: time.sleep(1.2) or load(*asked)
"""
COUNTS = "from frictopt.transients.exact import kernel\nprint(len(kernel.follow.signatures), sum(kernel.follow.stats.cache_misses.values()))"
STUDY = """
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
import frictopt as fo
if __name__ == "__main__":
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        table = fo.dissipation_study(rod, cycle, 0.5, [1.0 + number / 100 for number in range(20)], executor=pool, progress=False)
    print(len(table), (table["outcome"] == "CYCLIC_SLIP").all())
"""


def test_a_study_by_several_processes_announces_the_compilation_once_and_what_is_kept_is_not_compiled_again(
    tmp_path,
):
    """For one kind of arrays."""
    (tmp_path / "study.py").write_text(STUDY, encoding="utf-8")
    call = f"import subprocess, sys; subprocess.run([sys.executable, {str(tmp_path / 'study.py')!r}], check=True)"
    kept = {"NUMBA_CACHE_DIR": str(tmp_path)}
    # Loading is no compilation, however long it takes.
    found = run(call, **kept)
    again = run(SLOW + TRANSIENT + COUNTS, **kept)
    assert found.stdout == "20 True\n" and found.stderr.count("frictopt: compiling") == 1
    assert again.stdout == "True\n1 0\n" and not again.stderr
