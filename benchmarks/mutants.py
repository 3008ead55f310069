"""Mutation tests: the faults of `tests/ROOM/faults.py`, planted one at a time in a copy of the
repository, and the tests that should fail.

Run with `python benchmarks/mutants.py [--page FOLDER] [FILE ...]`; FILE is a room or the beginning
of a file's name, `limits` or `study/run`. A fault that no test finds has "SURVIVED"; one that does
not stand once in its file is "gone". The exit status is the number of both. A fault counts as
killed only if the test that fails with it passes without it; slow tests are not asked.

A test that takes more than `PATIENCE` seconds of processor time has no end: its fault is killed, too,
if the test ends without the fault, but the output and the page name such faults apart. Other work
on the machine does not change the verdict, because it takes no processor time of the test.
"""

import argparse
import os
import resource
import shutil
import signal
import subprocess
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

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from helpers.planting import Fault, faults, planted  # noqa: E402

FAULTS = faults()
OF_THE_COPY = "frictopt" not in sys.modules  # else a process would test the code without the fault
PATIENCE = 150  # seconds of processor time for one test; cold, the longest takes about 60
COLLECTION = "the collection"
WAITING = 3000  # seconds of the clock for one test, for one that waits and computes nothing
PROCESSES = get_context("forkserver")


def room(fault: Fault) -> str:
    """The part of the package that a fault is in."""
    return Path(fault.file).parts[0]


def place(fault: Fault, copy: Path) -> Path:
    """The file of a fault."""
    outside = Path(fault.file).parts[0] in ("studies", "validation")
    return copy / fault.file if outside else copy / "frictopt" / fault.file


def test_files(fault: Fault, copy: Path) -> list[str]:
    """The tests that should find a fault."""
    named = (name.partition("::") for name in fault.tests.split())
    return [
        f"{path.relative_to(copy)}{mark}{test}"
        for glob, mark, test in named
        for path in sorted((copy / "tests").glob(f"*/test_{glob}.py"))
    ]


class Failure(NamedTuple):
    """A test that failed, or in which the process had a crash or no end."""

    test: str
    how: Literal["", "crash", "no end"] = ""

    def __str__(self) -> str:
        return f"{self.how} of {self.test}" if self.how else self.test


class Fate(NamedTuple):
    """What became of a planted fault."""

    killed: bool
    no_end: bool = False


class _Reporter:
    """A plugin of pytest that says which test begins and which fails, and limits the time of each.

    A failing example of hypothesis is not made smaller: that would cost hundreds of runs of the
    test, and change no verdict.
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
    """The system ends this process if it computes for more seconds from now on."""
    end = ceil(process_time() + seconds)  # the system counts whole seconds since the process began
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (end, hard))


def _run(
    end: Connection, copy: Path, caches: str, arguments: Sequence[str], patience: float
) -> None:
    """Run tests of a copy in a process that has the libraries already.

    Those that begin and those that fail are named, and None says that all have run.
    """
    import numba  # not before the process knows its number of threads

    os.chdir(copy)
    sys.dont_write_bytecode = False  # a planted fault has a time of its own
    sys.path[:0] = [str(copy), str(copy / "tests")]
    os.environ |= {"PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": caches}
    numba.config.CACHE_DIR = caches
    for descriptor in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
    _limit_processor_time(patience)
    options = ["-q", "-m", "not slow", "-p", "no:cacheprovider"]
    status = pytest.main([*options, *arguments], [_Reporter(end, patience)])
    if status != pytest.ExitCode.INTERNAL_ERROR:  # of a test that is not there nothing has failed
        end.send(None)


class Ground:
    """A copy of the repository to plant faults in, and the compiled code of its path."""

    def __init__(self, folder: Path) -> None:
        self.copy, self._folder = folder / "copy", folder
        shutil.copytree(
            ROOT, self.copy, ignore=shutil.ignore_patterns(".*", "__pycache__", "_build", "*.nb?")
        )

    def failures(
        self, tests: Iterable[str], *options: str, cold: bool = False, patience: float = PATIENCE
    ) -> list[Failure]:
        """Which tests fail or have no end, by the names that pytest gives them.

        `cold`: with code compiled anew.
        """
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
        """The first test that fails with a fault, if one does; None if the fault is gone."""
        file = place(fault, self.copy)
        before, times = file.read_text(), file.stat()
        with_fault = planted(before, fault)
        if with_fault is None:
            return None
        file.write_text(with_fault)
        # Compiled code is known by the time of its source.
        os.utime(file, ns=(times.st_atime_ns, max(time_ns(), times.st_mtime_ns + 10**9)))
        try:
            compiled = file.name in ("kernel.py", "sweeps.py")
            return self.failures(test_files(fault, self.copy), "-x", cold=compiled)[:1]
        finally:
            file.write_text(before)
            # With its former time, code that was compiled from the file stays valid.
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))


def fates_of(results: dict[Fault, list[Failure] | None], ground: Ground) -> dict[Fault, Fate]:
    """What became of each fault. A test that fails without the faults, too, kills none."""
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
        wrong |= set(tests)  # The tests behind one that ended the process did not run.
    fates = dict[Fault, Fate]()
    for fault in results:
        killer = killers.get(fault)
        killed = killer is not None and killer.test not in wrong
        fates[fault] = Fate(killed, killed and killers[fault].how == "no end")
    return fates


def words(fault: Fault) -> str:
    """How the page names a fault."""
    return f"{fault.meaning} (`{fault.file}`)"


def rows_of(page: str) -> dict[str, list[str]]:
    """The rows of a page by room: planted, killed, code, no end, survived."""
    rows = dict[str, list[str]]()
    for line in page.splitlines():
        name, *row = line.removeprefix("| ").removesuffix(" |").split(" | ")
        if len(row) == 5 and row[0].isdigit() and name != "all":
            rows[name] = row
    return rows


def row_of_room(
    before: Sequence[str] | None, fates: dict[Fault, Fate], own: Sequence[Fault], code: str
) -> list[str] | None:
    """The row of a room whose faults are `own`; None if neither this run nor `before` knows all."""
    known = {fault: fates[fault] for fault in own if fault in fates}
    codes = [code]
    if len(known) < len(own):
        if before is None or int(before[0]) != len(own):
            return None
        codes = [*before[2].split(", "), code]
        for fault in own:
            no_end, survived = (words(fault) in column.split("; ") for column in before[3:])
            known.setdefault(fault, Fate(not survived, no_end))
    endless = [words(fault) for fault in own if known[fault].no_end]
    alive = [words(fault) for fault in own if not known[fault].killed]
    return [
        str(len(own)),
        str(len(own) - len(alive)),
        ", ".join(dict.fromkeys(codes)),
        "; ".join(endless) or "-",
        "; ".join(alive) or "-",
    ]


def page(before: str, fates: dict[Fault, Fate], code: str, made: str) -> str:
    """The table, one row for each room.

    A row is made anew if all faults of its room were planted. If some were, the row that counts all
    says what became of these.
    """
    rows = rows_of(before)
    for name in dict.fromkeys(map(room, fates)):
        own = [fault for fault in FAULTS if room(fault) == name]
        row = row_of_room(rows.get(name), fates, own, code)
        if row is not None:
            rows[name] = row
    ordered = {name: rows[name] for name in dict.fromkeys(map(room, FAULTS)) if name in rows}
    total, killed = (sum(int(row[column]) for row in ordered.values()) for column in (0, 1))
    lines = [
        "| room | planted | killed | code | of the killed, by a test without an end | survived |",
        "|---|---|---|---|---|---|",
        *(f"| {name} | {' | '.join(row)} |" for name, row in ordered.items()),
        f"| all | {total} | {killed} | - | - | - |",
    ]
    return "\n".join([*lines, "", f"*{made}*", ""])


def main(argv: Sequence[str] | None = None) -> int:
    """Plant the chosen faults, or all; returns how many survived or are gone."""
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
            print(
                f"[{place}, {seconds:.0f} s] {fault.file}: {fault.meaning}: {said}",
                flush=True,
            )
            return failures

        results = dict(zip(chosen, threads.map(plant, chosen), strict=True))
        fates = fates_of(results, grounds.get())
    no_end = sum(fate.no_end for fate in fates.values())
    print(f"{no_end} of {len(chosen)} faults were killed by a test without an end")
    if options.page is not None:
        # Not at the top: it imports frictopt, and processes that plant faults begin with the same imports.
        from studies.origin import machine

        options.page.mkdir(parents=True, exist_ok=True)
        file, log = (
            options.page / "mutants.md",
            ["git", "log", "-1", "--format=%h of %cs", "--", "frictopt"],
        )
        code = subprocess.run(
            log, cwd=ROOT, capture_output=True, text=True, check=True
        ).stdout.strip()
        made = f"Made by `python benchmarks/mutants.py --page docs/tables`, all rooms or one by one, on {machine()}."
        file.write_text(
            page(
                file.read_text(encoding="utf-8") if file.is_file() else "",
                fates,
                code,
                made,
            ),
            encoding="utf-8",
        )
    return sum(not fate.killed for fate in fates.values())


if __name__ == "__main__":
    raise SystemExit(main())
