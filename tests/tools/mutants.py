"""Mutation tests: faults are planted in a copy of the repository, and tests must find them.

Run with `python tests/tools/mutants.py [--page FOLDER] [FILE ...]`; FILE is a room or the beginning
of the name of a file, `limits` or `study/run`. The faults are listed in `tests/ROOM/faults.txt`, and
planted one at a time. A fault that no test finds has "SURVIVED". A fault whose text does not stand
exactly once in its file is "gone". The exit status is the number of both. A fault counts as killed
only if the test that fails with it passes without it. The slow tests (`tests/slow.txt`) are run only
if no test of the default set finds the fault. The page names the faults that only slow tests kill.

A test that takes more than `PATIENCE` seconds of processor time has no end. Its fault is killed,
too, if the test ends without the fault, but the output and the page name such faults separately.
Other work on the machine does not change the verdict, because it takes no processor time of the
test.
"""

import argparse
import os
import resource
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import ceil
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from time import perf_counter, process_time, time_ns
from typing import Literal, NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from helpers.planting import Fault, faults, planted  # noqa: E402

FAULTS = faults()
# A process that has imported frictopt would test the code without the fault.
OF_THE_COPY = "frictopt" not in sys.modules
# Seconds of processor time for one test. The longest test takes about 60 s without compiled code.
PATIENCE = 150
COLLECTION = "the collection"
# Seconds of the clock for one test. They end a test that waits and computes nothing.
WAITING = 600
# The sets of tests that a fault is tried against, one after the other, by their marks.
DEFAULT, SLOW = "not slow", "slow"
PROCESSES = get_context("forkserver")


def room(fault: Fault) -> str:
    """The part of the package that a fault is in."""
    return Path(fault.file).parts[0]


def place(fault: Fault, copy: Path) -> Path:
    """The file of a fault."""
    return copy / fault.file if room(fault) == "studies" else copy / "frictopt" / fault.file


def test_files(fault: Fault, copy: Path) -> list[str]:
    """The tests that should find a fault."""
    named = (name.partition("::") for name in fault.tests.split())
    return [
        f"{path.relative_to(copy)}{mark}{test}"
        for glob, mark, test in named
        for path in sorted((copy / "tests").glob(f"*/test_{glob}.py"))
    ]


class Failure(NamedTuple):
    """A failed test, or a test during which the process crashed or had no end.

    `slow`: whether it was run after all tests of the default set had passed.
    """

    test: str
    how: Literal["", "crash", "no end"] = ""
    slow: bool = False

    def __str__(self) -> str:
        test = f"{self.how} of {self.test}" if self.how else self.test
        return f"{test}, which is slow" if self.slow else test


class Fate(NamedTuple):
    """The outcome of a planted fault."""

    killed: bool
    no_end: bool = False
    slow: bool = False


class _Reporter:
    """A plugin of pytest that reports the tests that begin and fail, and limits the time of each.

    It switches off the reduction of failing examples of hypothesis, which would cost hundreds of
    runs of the test and change no verdict.
    """

    def __init__(self, end: Connection, patience: float) -> None:
        self._end = end
        self._patience = patience

    def pytest_sessionstart(self) -> None:
        # Not before pytest has its plugins: it warns of a hypothesis that was imported earlier.
        from hypothesis import Phase, settings

        phases = Phase.explicit, Phase.generate
        settings.register_profile("planted", derandomize=True, deadline=None, phases=phases)
        settings.load_profile("planted")

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        _limit_processor_time(self._patience)
        self._end.send(("begins", nodeid))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self._end.send(("fails", report.nodeid))

    pytest_collectreport = pytest_runtest_logreport


def _limit_processor_time(seconds: float) -> None:
    """Let the system end this process if it computes for more seconds from now on."""
    # The system counts whole seconds since the process began.
    end = ceil(process_time() + seconds)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (end, hard))


def _run(
    end: Connection, copy: Path, caches: str, arguments: Sequence[str], patience: float
) -> None:
    """Run tests of a copy in a process that has loaded the libraries already.

    The names of tests that begin and of tests that fail are sent, and None at the end of all tests.
    """
    # numba is imported only after the process knows its number of threads.
    import numba

    os.chdir(copy)
    # A planted fault has another time than the source, so bytecode may be written.
    sys.dont_write_bytecode = False
    sys.path[:0] = [str(copy), str(copy / "tests")]
    os.environ |= {"PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": caches}
    numba.config.CACHE_DIR = caches
    for descriptor in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
    _limit_processor_time(patience)
    # This process limits the time of tests itself, by other clocks.
    options = ["-q", "-o", "timeout=0", "-p", "no:cacheprovider"]
    status = pytest.main([*options, *arguments], [_Reporter(end, patience)])
    # A test that does not exist has not failed.
    if status != pytest.ExitCode.INTERNAL_ERROR:
        end.send(None)


class Ground:
    """A copy of the repository for planted faults, and the compiled code of its exact path."""

    def __init__(self, folder: Path) -> None:
        self.copy, self._folder = folder / "copy", folder
        self._planted = 0  # time of the last planted fault, in ns
        shutil.copytree(
            ROOT, self.copy, ignore=shutil.ignore_patterns(".*", "__pycache__", "_build", "*.nb?")
        )

    def failures(
        self,
        tests: Iterable[str],
        *options: str,
        marks: str = "",
        cold: bool = False,
        patience: float = PATIENCE,
    ) -> list[Failure]:
        """The tests that fail or have no end, by their names in pytest.

        `marks`: the set of tests, as for `pytest -m`. `cold`: whether the code is compiled anew.
        """
        options = ("-m", marks, *options)
        mine, other = PROCESSES.Pipe(duplex=False)
        with tempfile.TemporaryDirectory() as empty:
            caches = empty if cold else str(self._folder / "compiled")
            process = PROCESSES.Process(
                target=_run, args=(other, self.copy, caches, [*options, *tests], patience)
            )
            process.start()
            other.close()
            found = list[Failure]()
            current = COLLECTION
            try:
                while mine.poll(WAITING):
                    if (said := mine.recv()) is None:
                        process.join(10)
                        return found
                    word, test = said
                    if word == "fails":
                        found.append(Failure(test))
                    current = test
                found.append(Failure(current, how="no end"))
            except EOFError:
                process.join()
                if process.exitcode == -signal.SIGXCPU:
                    found.append(Failure(current, how="no end"))
                else:
                    found.append(Failure(current, how="crash"))
            finally:
                process.kill()
                process.join()
        return found

    def failures_with(self, fault: Fault) -> list[Failure] | None:
        """The first test that fails with a fault, if one fails; None if the fault is gone."""
        file = place(fault, self.copy)
        before, times = file.read_text(), file.stat()
        with_fault = planted(before, fault)
        if with_fault is None:
            return None
        file.write_text(with_fault)
        # Compiled code is known by the time of its source, bytecode by the second and the size.
        second = 10**9
        self._planted = max(time_ns(), times.st_mtime_ns + second, self._planted + second)
        os.utime(file, ns=(times.st_atime_ns, self._planted))
        try:
            compiled = file.name in ("kernel.py", "sweeps.py")
            tests = test_files(fault, self.copy)
            for marks in (DEFAULT, SLOW):
                failures = self.failures(tests, "-x", marks=marks, cold=compiled)
                if failures:
                    return [failures[0]._replace(slow=marks == SLOW)]
            return []
        finally:
            file.write_text(before)
            # With its former time, code that was compiled from the file stays valid.
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))


def fates_of(results: dict[Fault, list[Failure] | None], ground: Ground) -> dict[Fault, Fate]:
    """The outcome of each fault. A test that also fails without the fault does not kill it."""
    killers = {fault: failures[0] for fault, failures in results.items() if failures}
    tests = sorted({killer.test for killer in killers.values() if "::" in killer.test})
    failures = ground.failures(tests) if tests else []
    for fault, killer in killers.items():
        if killer.test == COLLECTION and ground.failures(test_files(fault, ground.copy), "--co"):
            failures.append(killer)
            break
    for failure in failures:
        print(f"without a fault, too: {failure}")
    wrong = {failure.test for failure in failures}
    if any(failure.how for failure in failures):
        # If a test ended the process, the tests behind it did not run.
        wrong |= set(tests)
    fates = dict[Fault, Fate]()
    for fault in results:
        killer = killers.get(fault)
        killed = killer is not None and killer.test not in wrong
        fates[fault] = Fate(
            killed, killed and killers[fault].how == "no end", killed and killers[fault].slow
        )
    return fates


def words(fault: Fault) -> str:
    """The text for a fault on the page."""
    return f"{fault.meaning} (`{fault.file}`)"


def rows_of(page: str) -> dict[str, list[str]]:
    """The rows of a page by room: planted, killed, code, slow, no end, survived."""
    rows = dict[str, list[str]]()
    for line in page.splitlines():
        name, *row = line.removeprefix("| ").removesuffix(" |").split(" | ")
        if len(row) == 6 and row[0].isdigit() and name != "all":
            rows[name] = row
    return rows


def row_of_room(fates: dict[Fault, Fate], own: Sequence[Fault], code: str) -> list[str]:
    """The row of a room with the faults `own`, whose outcomes are known."""
    late = [words(fault) for fault in own if fates[fault].slow]
    endless = [words(fault) for fault in own if fates[fault].no_end]
    alive = [words(fault) for fault in own if not fates[fault].killed]
    return [
        str(len(own)),
        str(len(own) - len(alive)),
        code,
        "; ".join(late) or "-",
        "; ".join(endless) or "-",
        "; ".join(alive) or "-",
    ]


def page(before: str, fates: dict[Fault, Fate], code: str, made: str) -> str:
    """The table, one row for each room. A row is made anew if all faults of its room were planted."""
    rows = rows_of(before)
    for name in dict.fromkeys(map(room, fates)):
        own = [fault for fault in FAULTS if room(fault) == name]
        if fates.keys() >= set(own):
            rows[name] = row_of_room(fates, own, code)
    ordered = {name: rows[name] for name in dict.fromkeys(map(room, FAULTS)) if name in rows}
    total, killed = (sum(int(row[column]) for row in ordered.values()) for column in (0, 1))
    lines = [
        "| room | planted | killed | code | of the killed, by slow tests only | by a test without an end | survived |",
        "|---|---|---|---|---|---|---|",
        *(f"| {name} | {' | '.join(row)} |" for name, row in ordered.items()),
        f"| all | {total} | {killed} | - | - | - | - |",
    ]
    return "\n".join([*lines, "", f"*{made}*", ""])


def main(argv: Sequence[str] | None = None) -> int:
    """Plant the chosen faults, or all faults; returns the number that survived or are gone."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="*", metavar="FILE")
    parser.add_argument(
        "--page", type=Path, metavar="FOLDER", help="write the table as mutants.md, of whole rooms"
    )
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args(argv)
    if __name__ == "__main__" and not OF_THE_COPY:
        raise RuntimeError("frictopt was imported before its copies: no fault would be found")
    chosen = [
        fault
        for fault in FAULTS
        if not options.files or fault.file.startswith(tuple(options.files))
    ]
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    PROCESSES.set_forkserver_preload(
        ["cvxpy", "matplotlib.pyplot", "numba", "pandas", "pytest", "scipy.optimize", "skfem"]
    )
    grounds = SimpleQueue[Ground]()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.workers) as threads:
        for number in range(options.workers):
            grounds.put(Ground(Path(folder) / str(number)))

        def plant(fault: Fault) -> list[Failure] | None:
            ground = grounds.get()
            begin = perf_counter()
            try:
                failures = ground.failures_with(fault)
            finally:
                grounds.put(ground)
            said = "SURVIVED"
            if failures is None:
                said = "gone"
            elif failures:
                said = f"killed by {failures[0]}"
            place = f"{chosen.index(fault) + 1} of {len(chosen)}"
            seconds = perf_counter() - begin
            print(f"[{place}, {seconds:.0f} s] {fault.file}: {fault.meaning}: {said}", flush=True)
            return failures

        results = dict(zip(chosen, threads.map(plant, chosen), strict=True))
        fates = fates_of(results, grounds.get())
    slow, no_end = (
        sum(getattr(fate, how) for fate in fates.values()) for how in ("slow", "no_end")
    )
    print(f"{slow} of {len(chosen)} faults were killed by slow tests only")
    print(f"{no_end} of {len(chosen)} faults were killed by a test without an end")
    if options.page is not None:
        # Not at the top: it imports frictopt, and processes that plant faults begin with the same imports.
        from studies.origin import commit, machine

        options.page.mkdir(parents=True, exist_ok=True)
        file = options.page / "mutants.md"
        made = f"Made by `python tests/tools/mutants.py --page docs/tables`, all rooms or one by one, on {machine()}."
        file.write_text(
            page(file.read_text(encoding="utf-8") if file.is_file() else "", fates, commit(), made),
            encoding="utf-8",
        )
    return sum(not fate.killed for fate in fates.values())


if __name__ == "__main__":
    raise SystemExit(main())
