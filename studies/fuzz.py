"""Random contacts by the thousand: every answer is held against an independent one, or is an error of frictopt that says what to do.

Run with `python -m studies fuzz [--quick] [--cases N] [--seed S]`; it prints the counts in Markdown. The same cases run in the tests, fewer of them.
"""

import argparse
import re
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

from .fuzz_cases import random_case
from .fuzz_checks import CHECKS, Finding, findings
from .tables import Study, Table, at_least_one, markdown, seed_number

__all__ = ["COUNTS", "FULL", "QUICK", "REFUSALS", "STUDY", "Parameters", "counts", "refusals", "short"]


@dataclass(frozen=True)
class Parameters:
    """Which cases."""

    cases: int = 10_000
    seed: int = 0  # of the first case; the others count on


FULL = Parameters()
QUICK = Parameters(cases=100)


@cache
def _run(parameters: Parameters) -> tuple[tuple[Finding, ...], dict[str, float]]:
    """All findings, and the seconds that each question took."""
    found: list[Finding] = []
    seconds = dict.fromkeys(CHECKS, 0.0)
    with threadpool_limits(1):
        for seed in tqdm(range(parameters.seed, parameters.seed + parameters.cases), desc="fuzzing", disable=None):
            start = time.perf_counter()
            for finding in findings(random_case(seed)):
                found.append(finding)
                seconds[finding.check] += time.perf_counter() - start
                start = time.perf_counter()
    return tuple(found), seconds


def counts(parameters: Parameters) -> pd.DataFrame:
    """One row per question."""
    found, seconds = _run(parameters)
    rows = []
    for check in CHECKS:
        asked = [finding for finding in found if finding.check == check]
        outcomes = [finding.outcome for finding in asked]
        row = {"question": check, "cases": len(asked), "answers": outcomes.count("answer"), "compared": sum(finding.compared for finding in asked)}
        row |= {error: outcomes.count(error) for error in ("ModelError", "NoContinuation", "SolverError", "wrong")}
        row["residual"] = max((finding.residual for finding in asked if finding.outcome == "answer"), default=0.0)
        rows.append(row | {"seconds": seconds[check]})
    return pd.DataFrame(rows)


def refusals(parameters: Parameters) -> pd.DataFrame:
    """One row per question, kind of error and message, numbers left out; what is wrong comes first, one row each."""
    found, _ = _run(parameters)
    rows = [
        {"question": f.check, "outcome": f.outcome, "message": f.text if f.outcome == "wrong" else _pattern(f.text), "seed": f.seed, "residual": 0.0}
        for f in found
        if f.outcome != "answer"
    ]
    table = pd.DataFrame(rows, columns=["question", "outcome", "message", "seed", "residual"])
    grouped = table.groupby(["question", "outcome", "message"], sort=False).agg(
        cases=("seed", "size"), seed=("seed", "first"), residual=("residual", "max")
    )
    return grouped.reset_index().sort_values(["outcome", "cases"], ascending=False, key=lambda c: c == "wrong" if c.name == "outcome" else c)


def _pattern(message: str) -> str:
    return re.sub(r"\[[^\]]*\]", "[..]", re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", message.split("(HIGHS")[0]))


def short(table: pd.DataFrame) -> str:
    """Counts as a table in Markdown."""
    form = {"residual": "{:.0e}", "seconds": "{:.0f}"}
    rows = [[form.get(name, "{}").format(value) for name, value in row.items()] for row in table.to_dict("records")]
    return markdown(list(table.columns), rows)


_COUNTS = {
    "question": "what is asked",
    "cases": "number of cases",
    "answers": "of these answered, and right as far as could be compared",
    "compared": "of these held against an independent answer",
    "ModelError": "cases refused as no contact problem",
    "NoContinuation": "cases whose path ends or is not unique",
    "SolverError": "cases without an answer that passes the checks",
    "wrong": "answers that an independent one contradicts, and errors that are not frictopt's: must be 0",
    "residual": "worst residual of an answer",
    "seconds": "time, with that of the independent answers",
}
_REFUSALS = {
    "question": "what is asked",
    "outcome": "kind of error, or 'wrong'",
    "message": "its message, numbers left out",
    "cases": "how often",
    "seed": "the first case",
    "residual": "0",
}
COUNTS = Table("fuzz_counts", "one question to all cases", _COUNTS, full=FULL, quick=QUICK, compute=counts)
REFUSALS = Table("fuzz_refusals", "one message of an error", _REFUSALS, full=FULL, quick=QUICK, compute=refusals)


class _Random(Study):
    """The study of random contacts, of which the command line says how many and which."""

    def parser(self) -> argparse.ArgumentParser:
        parser = super().parser()
        parser.add_argument("--cases", type=at_least_one, default=FULL.cases, metavar="N", help=f"number of random contacts (default {FULL.cases})")
        parser.add_argument("--seed", type=seed_number, default=FULL.seed, metavar="N", help=f"seed of the first one (default {FULL.seed})")
        return parser

    def run(self, argv: Sequence[str] | None = None) -> int:
        options = self.parser().parse_args(argv)
        quick = options.quick and (options.cases, options.seed) == (FULL.cases, FULL.seed)  # numbers that are asked for go before
        tables = [replace(table, full=Parameters(options.cases, options.seed)) for table in self.tables]
        tables = tables if quick else [replace(table, quick=table.full) for table in tables]
        return Study.run(replace(self, tables=tables), argv)


STUDY = _Random("studies.fuzz", __doc__, "few cases, in seconds", (COUNTS, REFUSALS), summary=lambda tables: short(tables[COUNTS.name]))


if __name__ == "__main__":
    raise SystemExit(STUDY.run())
