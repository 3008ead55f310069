"""Mutation tests: the faults of `tests/ROOM/faults.py`, planted one at a time in a copy of the repository, and the tests that should fail.

Run with `python benchmarks/mutants.py [--page FOLDER] [FILE ...]`; FILE is a room or the beginning
of a file's name, `limits` or `study/run`. A fault that no test finds has "SURVIVED"; one that does
not stand once in its file is "gone". The exit status is the number of both. A fault counts as
killed only if the test that fails with it passes without it; slow tests are not asked.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from time import monotonic, time_ns

import pytest

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from helpers.planting import Fault, faults, planted  # noqa: E402

FAULTS = faults()
OF_THE_COPY = "frictopt" not in sys.modules  # else a process would test the code without the fault
PATIENCE = 400  # seconds, for tests that hang because of a fault
NO_END = "no end"
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


class _Failed:
    """A plugin of pytest that says which tests fail."""

    def __init__(self, end: Connection) -> None:
        self._end = end

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self._end.send(report.nodeid)

    pytest_collectreport = pytest_runtest_logreport


def _run(end: Connection, copy: Path, caches: str, arguments: Sequence[str]) -> None:
    """Run tests of a copy in a process that has the libraries already; those that fail are named, and None says that all have run."""
    import numba  # not before the process knows its number of threads

    os.chdir(copy)
    sys.dont_write_bytecode = False  # a planted fault has a time of its own
    sys.path[:0] = [str(copy), str(copy / "tests")]
    os.environ |= {"PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": caches}
    numba.config.CACHE_DIR = caches
    for descriptor in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
    status = pytest.main(
        ["-q", "-m", "not slow", "-p", "no:cacheprovider", *arguments], [_Failed(end)]
    )
    if status != pytest.ExitCode.INTERNAL_ERROR:  # of a test that is not there nothing has failed
        end.send(None)


class Ground:
    """A copy of the repository to plant faults in, and the compiled code of its path."""

    def __init__(self, folder: Path) -> None:
        self.copy, self._folder = folder / "copy", folder
        shutil.copytree(
            ROOT, self.copy, ignore=shutil.ignore_patterns(".*", "__pycache__", "_build", "*.nb?")
        )

    def failures(self, tests: Iterable[str], *options: str, cold: bool = False) -> list[str]:
        """Which tests fail, by the names that pytest gives them; `cold`: with code compiled anew."""
        found, (mine, other) = list[str](), PROCESSES.Pipe(duplex=False)
        with tempfile.TemporaryDirectory() as empty:
            arguments = (
                other,
                self.copy,
                empty if cold else str(self._folder / "compiled"),
                [*options, *tests],
            )
            process = PROCESSES.Process(target=_run, args=arguments)
            process.start()
            other.close()
            end = monotonic() + PATIENCE
            try:
                while mine.poll(max(end - monotonic(), 0)):
                    if (name := mine.recv()) is None:
                        process.join(10)
                        return found
                    found.append(name)
                found.append(NO_END)
            except EOFError:
                found.append("a crash")
            finally:
                process.kill()
                process.join()
        return found

    def killer(self, fault: Fault) -> str | None:
        """The first test that fails with a fault, empty where none does; None where the fault is gone."""
        file = place(fault, self.copy)
        before, times = file.read_text(), file.stat()
        with_fault = planted(before, fault)
        if with_fault is None:
            return None
        file.write_text(with_fault)
        os.utime(
            file, ns=(times.st_atime_ns, max(time_ns(), times.st_mtime_ns + 10**9))
        )  # compiled code is known by it
        try:
            return next(
                iter(
                    self.failures(
                        test_files(fault, self.copy),
                        "-x",
                        cold=file.name in ("kernel.py", "sweeps.py"),
                    )
                ),
                "",
            )
        finally:
            file.write_text(before)
            os.utime(
                file, ns=(times.st_atime_ns, times.st_mtime_ns)
            )  # so that code compiled from it stays valid


def page(before: str, faults: Sequence[Fault], killed: Sequence[bool], code: str, made: str) -> str:
    """The table, one row for each room: anew if all its faults were planted; if some were, the row that counts all, with what became of these."""
    rows = {
        line.split(" | ")[0].removeprefix("| "): line.removeprefix("| ")
        .removesuffix(" |")
        .split(" | ")[1:]
        for line in before.splitlines()
    }
    rows = {name: row for name, row in rows.items() if len(row) == 4 and row[0].isdigit()}
    dead = dict(zip(faults, killed, strict=True))
    for name in dict.fromkeys(map(room, faults)):
        own = [fault for fault in FAULTS if room(fault) == name]
        words = {fault: f"{fault.meaning} (`{fault.file}`)" for fault in own}
        if not set(own) <= dead.keys():
            if int(rows.get(name, ["0"])[0]) != len(own):
                continue
            dead |= {
                fault: words[fault] not in rows[name][3].split("; ")
                for fault in own
                if fault not in dead
            }
        alive = [words[fault] for fault in own if not dead[fault]]
        earlier = [] if set(own) <= set(faults) else rows[name][2].split(", ")
        codes = ", ".join(dict.fromkeys([*earlier, code]))
        rows[name] = [str(len(own)), str(len(own) - len(alive)), codes, "; ".join(alive) or "-"]
    known = {name: rows[name] for name in dict.fromkeys(map(room, FAULTS)) if name in rows}
    planted, found = (sum(int(row[column]) for row in known.values()) for column in (0, 1))
    head = "| room | planted | killed | code | survived |", "|---|---|---|---|---|"
    lines = [f"| {name} | {' | '.join(row)} |" for name, row in known.items()]
    return "\n".join([*head, *lines, f"| all | {planted} | {found} | - | - |", "", f"*{made}*", ""])


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

        def asked(fault: Fault) -> str | None:
            ground = grounds.get()
            try:
                killer = ground.killer(fault)
            finally:
                grounds.put(ground)
            said = "gone" if killer is None else f"killed by {killer}" if killer else "SURVIVED"
            print(f"{fault.file}: {fault.meaning}: {said}", flush=True)
            return killer

        killers = list(threads.map(asked, chosen))
        distinct = sorted({killer for killer in killers if killer and "::" in killer})
        wrong = set(grounds.get().failures(distinct)) if distinct else set()
    for test in sorted(wrong):
        print(f"{test} fails without a fault, too")
    killed = [bool(killer) and killer not in wrong for killer in killers]
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
                chosen,
                killed,
                code,
                made,
            ),
            encoding="utf-8",
        )
    return len(killed) - sum(killed)


if __name__ == "__main__":
    raise SystemExit(main())
