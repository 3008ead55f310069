"""Thousands of random contacts: every answer is compared with an independent one, or is an error of frictopt that names a remedy.

Run with `python -m studies fuzz [--quick] [--cases N] [--seed S] [--only answers | differential | space]`. It prints wrong answers with their seeds,
and the counts in Markdown; its exit status is 1 if any answer is wrong. Without a seed it draws a new one and prints it, so each run tests new cases.
The part "answers" has small contacts, ordinary and extreme. The part "differential" has contacts of 3 to 130 nodes, each solved in two equivalent
descriptions. The part "space" has contacts in three dimensions. The tests run some of the same cases.
"""

import argparse
import re
import secrets
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

import frictopt as fo

from ...tables import Study, Table, at_least_one, markdown, seed_number
from .cases import random_case
from .checks import CHECKS, Finding, findings
from .differential import DIFFERENTIAL, differences
from .scenes import random_scene
from .space import SPACE, space_findings

PARTS: Mapping[str, Mapping[str, Any]] = {"answers": CHECKS, "differential": DIFFERENTIAL, "space": SPACE}
"""Part -> its questions."""


@dataclass(frozen=True)
class Parameters:
    """The cases, and the parts that are asked for each."""

    cases: int = 10_000
    seed: int = 0  # of the first case; the others have the next seeds
    parts: tuple[str, ...] = tuple(PARTS)


FULL = Parameters()
QUICK = Parameters(cases=100)


@dataclass
class _Asked:
    """Results of one question over all cases."""

    results: Counter[str] = field(default_factory=Counter)
    compared: int = 0
    residual: float = 0.0
    seconds: float = 0.0


@dataclass
class _Found:
    """Results of a run, by question; and for errors their number and first seed, by question, result and message."""

    asked: dict[str, _Asked]
    refused: dict[tuple[str, str, str], list[int]] = field(default_factory=dict)

    def add(self, finding: Finding, seconds: float) -> None:
        asked = self.asked[finding.check]
        asked.results[finding.result] += 1
        asked.compared += finding.compared
        asked.seconds += seconds
        if finding.result == "answer":
            asked.residual = max(asked.residual, finding.residual)
            return
        wrong = finding.result == "wrong"
        if wrong:
            tqdm.write(f"WRONG, seed {finding.seed}, {finding.check}: {finding.text}")
            sys.stdout.flush()  # so that a long run can be watched
        key = finding.check, finding.result, f"{finding.text} (seed {finding.seed})" if wrong else _pattern(finding.text)
        self.refused.setdefault(key, [0, finding.seed])[0] += 1


@cache
def _run(parameters: Parameters) -> _Found:
    found = _Found({check: _Asked() for part in parameters.parts for check in PARTS[part]})
    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore", fo.ModelWarning)  # it asks odd questions on purpose
        for seed in tqdm(range(parameters.seed, parameters.seed + parameters.cases), desc="fuzzing", disable=None):
            start = time.perf_counter()
            for finding in _findings(seed, parameters.parts):
                found.add(finding, time.perf_counter() - start)
                start = time.perf_counter()
    return found


def _findings(seed: int, parts: Sequence[str]) -> Iterator[Finding]:
    if "answers" in parts:
        yield from findings(random_case(seed))
    if "differential" in parts:
        yield from differences(random_scene(seed))
    if "space" in parts:
        yield from space_findings(seed)


def counts(parameters: Parameters) -> pd.DataFrame:
    """One row per question."""
    rows = []
    for check, asked in _run(parameters).asked.items():
        row = {"question": check, "cases": asked.results.total(), "answers": asked.results["answer"], "compared": asked.compared}
        row |= {result: asked.results[result] for result in ("ModelError", "NoContinuation", "SolverError", "wrong")}
        rows.append(row | {"residual": asked.residual, "seconds": asked.seconds})
    return pd.DataFrame(rows)


def refusals(parameters: Parameters) -> pd.DataFrame:
    """One row per question, kind of error and message without its numbers; wrong answers come first, one row each."""
    columns = ["question", "result", "message", "cases", "seed", "residual"]
    table = pd.DataFrame([(*key, *number, 0.0) for key, number in _run(parameters).refused.items()], columns=columns)
    return table.sort_values(["result", "cases"], ascending=False, key=lambda c: c == "wrong" if c.name == "result" else c)


def _pattern(message: str) -> str:
    return re.sub(r"\[[^\]]*\]", "[..]", re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", message.split("(HIGHS")[0]))


def short(table: pd.DataFrame) -> str:
    """Counts as a table in Markdown."""
    form = {"residual": "{:.0e}", "seconds": "{:.0f}"}
    rows = [[form.get(name, "{}").format(value) for name, value in row.items()] for row in table.to_dict("records")]
    return markdown(list(table.columns), rows)


_COUNTS = {
    "question": "the question",
    "cases": "number of cases",
    "answers": "number of answers that are not wrong",
    "compared": "number of answers that were compared with an independent one",
    "ModelError": "cases refused, because they are not a contact problem",
    "NoContinuation": "cases whose path ends or is not unique",
    "SolverError": "cases without an answer that passes the checks",
    "wrong": "answers that an independent one contradicts, and errors of other packages: must be 0",
    "residual": "largest residual of an answer",
    "seconds": "time, including the independent answers",
}
_REFUSALS = {
    "question": "the question",
    "result": "kind of error, or 'wrong'",
    "message": "its message without numbers",
    "cases": "number of cases",
    "seed": "the first case",
    "residual": "0",
}
COUNTS = Table("fuzz_counts", "one question, all cases", _COUNTS, full=FULL, quick=QUICK, compute=counts)
REFUSALS = Table("fuzz_refusals", "one message of an error", _REFUSALS, full=FULL, quick=QUICK, compute=refusals)


class _Random(Study):
    """The study of random contacts; the command line chooses their number and seeds."""

    def parser(self) -> argparse.ArgumentParser:
        parser = super().parser()
        parser.add_argument("--cases", type=at_least_one, metavar="N", help=f"number of random contacts of each part (default {FULL.cases})")
        parser.add_argument("--seed", type=seed_number, metavar="N", help="seed of the first one (default: another one each time, which is printed)")
        parser.add_argument("--only", choices=tuple(PARTS), help="the questions of one part")
        return parser

    def run(self, argv: Sequence[str] | None = None) -> int:
        options = self.parser().parse_args(argv)
        cases = options.cases or (QUICK if options.quick else FULL).cases
        seed = secrets.randbelow(10**9) if options.seed is None else options.seed
        parameters = Parameters(cases, seed, (options.only,) if options.only else tuple(PARTS))
        print(f"seeds {seed} to {seed + cases - 1}")
        status = Study.run(replace(self, tables=[replace(table, full=parameters, quick=parameters) for table in self.tables]), argv)
        return status or int(any(asked.results["wrong"] for asked in _run(parameters).asked.values()))


STUDY = _Random("studies.validation.fuzz", __doc__, "few cases, in seconds", (COUNTS, REFUSALS), summary=lambda tables: short(tables[COUNTS.name]))
