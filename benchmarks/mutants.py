"""Mutation tests: one-line faults, planted one at a time in a copy of the repository, and the tests that should fail because of them.

Run with `python benchmarks/mutants.py [NAME ...]`; all of them take about an hour. A fault that no test finds has "SURVIVED"; the exit status is the
number of these. A fault whose text does not occur exactly once is "gone": the code has changed, and the table needs a new line.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PATIENCE = 900  # seconds, for tests that hang because of a fault


class Fault(NamedTuple):
    name: str
    meaning: str
    old: str  # text that stands once in the files of `where`
    new: str
    tests: str  # globs in tests/
    where: str = "frictopt/**/*.py"


PATH = "test_path_*.py test_left_out.py test_march.py test_work_of_friction.py test_fuzz.py test_differential.py"
LIMITS = "test_guaranteed*.py test_shakedown*.py test_safe_slip.py test_limit_*.py test_fuzz.py"
CONDENSED = "test_condense.py test_contact_model.py test_punch.py test_studies_extremes.py"
MARCH = "test_march.py test_increment_engines.py test_work_of_friction.py"
FAULTS = [
    Fault("P1", "work by the pressure before", "0.5 * (before + state.r[nodes + node])", "before", PATH),
    Fault("P2", "work by six tenths of the two pressures", "f[node] * 0.5 * (before", "f[node] * 0.6 * (before", PATH),
    Fault("P3", "twice the friction bound", "bound = f[node] * r[nodes + node]", "bound = 2.0 * f[node] * r[nodes + node]", PATH),
    Fault("P4", "a limit need not come back", "if self._change(proving) > PERIODIC:", "if False:", PATH),
    Fault("P5", "the map need not be affine near a limit", "if off > PERIODIC + _AFFINE *", "if False and off > PERIODIC + _AFFINE *", PATH),
    Fault("P6", "one map need not make all states", "np.any(off > PERIODIC + AFFINE_FIT", "np.any(off < PERIODIC + AFFINE_FIT", PATH),
    Fault("P7", "little work is conclusive", "return slips or (slips is False", "return True or (slips is False", PATH),
    Fault("P15", "no return after two cycles is looked for", "        if run.alternates():\n", "        if False:\n", PATH),
    Fault("P16", "a work need not repeat", "<= RESIDUAL and len(cycles) < _MORE", "<= 1.0 and len(cycles) < _MORE", PATH),
    Fault("P17", "rounding counts as slip", "max(ROUNDING * max(1.0, far), change) * self.scales", "0.0 * self.scales", PATH),
    Fault("K1", "the work of a steady cycle is not compared", "spent = work[-1] -", "spent = 0.0 * work[-1] if True else", "test_fretting.py"),
    Fault("K2", "a steady cycle need not come back", "off = max(lawful.residual, changed,", "off = max(lawful.residual,", "test_fretting.py"),
    Fault("K3", "a steady state may break the law", "off = max(lawful.residual, changed,", "off = max(changed,", "test_fretting.py"),
    Fault("K4", "no sampled slip is smooth", "else np.cumsum(rng.normal(size=nodes))", "else rng.normal(size=nodes)", "test_protocols.py"),
    Fault("K5", "a state of rest may work", "if path.cycle_work.max() >", "if False and path.cycle_work.max() >", "test_separated.py"),
    Fault("K6", "undecided counts as rest", "return UNDECIDED if undecided else REST", "return REST", "test_protocols.py"),
    Fault("P8", "slow cycles are taken for ones that came back", "self._distance_left() <= RESIDUAL and", "", PATH),
    Fault("P11", "states may turn round their limit", "np.any(np.abs(rates.imag) > 0) or", "", PATH),
    Fault("P12", "states may change sides", "np.any(rates.real < 0) or", "", PATH),
    Fault("P13", "lost energy is let pass", "self._violation(cycle), cycle.energy, self.energy)", "self._violation(cycle))", PATH),
    Fault("P14", "the first cycle proves a steady state", "        if self.cycles == 1:\n", "        if self.cycles == 0:\n", PATH),
    Fault("P9", "Lemke's answer counts as the only one", "bool(candidates) and _is_positive_definite(M)", "bool(candidates)", PATH),
    Fault("P10", "events of the rate problem count as proven", "self.state.trace[2] += not solutions.complete", "pass", PATH),
    Fault("G1", "distance of the node from its bounds not judged", "slip), off, gap, model", "slip), gap, model", LIMITS),
    Fault("G2", "duality gap not judged", "slip), off, gap, model", "slip), off, model", LIMITS),
    Fault("G3", "bound of a mechanism that has not settled", "np.where(done & (resistance <", "np.where((resistance <", LIMITS),
    Fault("G5", "sign of the derived bounds", "centre, reach = -ends @ Z", "centre, reach = ends @ Z", LIMITS, "studies/**/*.py"),
    Fault("L1", "least for largest load", "corners=(forward.argmax(axis=0)", "corners=(forward.argmin(axis=0)", LIMITS),
    Fault("L3", "stress of a mechanism closes the gap", "bound - load_factor) + defect)", "bound + defect - load_factor))", LIMITS),
    Fault("L4", "the limit itself is not safe", "margin >= -max(NO_MARGIN, state.residual)", "margin >= 0", LIMITS, "frictopt/limits/*.py"),
    Fault("L5", "wrong node limits an uncoupled contact", "int(limits.argmin())", "int(limits.argmax())", LIMITS),
    Fault("C1", "referee takes B for its transpose", "pw - v @ system.B.T", "pw - v @ system.B", "test_referee.py"),
    Fault("C2", "referee takes friction the wrong way", "np.where(moved > 0, f * p", "np.where(moved < 0, f * p", "test_referee.py"),
    Fault("C3", "a relieved node at its bound", "where(slack < -floor, 0.0,", "where(slack < floor, 0.0,", "test_onset.py", "frictopt/contact/*.py"),
    Fault("F1", "inaccurate elimination is let pass", "EQUILIBRIUM = 1e3", "EQUILIBRIUM = 1e8", CONDENSED),
    Fault("F2", "reordered interface is not noticed", "if not (np.array_equal(factors.", "if False and not (np.array_equal(factors.", CONDENSED),
    Fault("F3", "flat elements are let pass", "(turns > 0).all(axis=0)", "(turns >= 0).all(axis=0)", "test_contact_model.py test_punch.py"),
    Fault("I6", "a node that opens in an increment does work", " * (new.status != 2)", "", MARCH),
    Fault("M1", "cycles begin one state late", "self.corners) + SIMULTANEOUS) - 1", "self.corners) + SIMULTANEOUS)", MARCH),
    Fault("M2", "energy by twice the loads", "(load[1:] + load[:-1]) / 2", "(load[1:] + load[:-1])", MARCH),
    Fault("K1", "True is a whole number", "or isinstance(value, bool | np.timedelta64)", "or isinstance(value, np.timedelta64)", "test_checks.py"),
    Fault("S1", "overload is not part of a run's key", '("overload", start.overload)', '("overload", None)', "test_dissipation_study.py"),
]  # fmt: skip


def planted(fault: Fault, copy: Path) -> tuple[Path, str] | None:
    """The file that the fault goes in and its content before; None where its text does not stand exactly once."""
    files = [path for path in copy.glob(fault.where) if fault.old in path.read_text()]
    text = files[0].read_text() if len(files) == 1 else ""
    if text.count(fault.old) != 1:
        return None
    files[0].write_text(text.replace(fault.old, fault.new))
    return files[0], text


def failure(copy: Path, tests: str, caches: Path) -> str:
    """The first test that fails in the copy, of which compiled code is kept in `caches`; empty where all pass."""
    files = [str(path) for glob in tests.split() for path in sorted((copy / "tests").glob(glob))]
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *files]
    environment = os.environ | {"PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(caches), "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return "no end"
    return "" if done.returncode == 0 else next((line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))), "no tests")


def main(names: list[str]) -> int:
    """Plant the named faults, or all; returns how many survived."""
    chosen = [fault for fault in FAULTS if not names or fault.name in names]
    if unknown := set(names) - {fault.name for fault in FAULTS}:
        raise SystemExit(f"unknown faults {sorted(unknown)}; known are {[fault.name for fault in FAULTS]}")
    survived = 0
    with tempfile.TemporaryDirectory() as folder:
        copy, warm = Path(folder) / "copy", Path(folder) / "warm"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".*", "__pycache__", "data", "*.nb?"))
        fails = {tests: failure(copy, tests, warm) for tests in sorted({fault.tests for fault in chosen})}
        for number, fault in enumerate(chosen):
            place, said = planted(fault, copy), "gone"
            if place is not None:
                file, before = place
                cold = Path(folder) / f"cold{number}" if file.parent.name == "path" else warm  # compiled code of other sources
                seen = fails[fault.tests] or failure(copy, fault.tests, cold)
                file.write_text(before)
                survived += not seen
                said = "SURVIVED" if not seen else f"not asked, since without it {seen}" if fails[fault.tests] else f"killed by {seen}"
                said += f" ({file.relative_to(copy)})"
            print(f"{fault.name:4} {said}: {fault.meaning}", flush=True)
    return survived


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
