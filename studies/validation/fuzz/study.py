"""Thousands of random contacts, whose answers are compared with independent answers.

Each answer agrees with the independent answer, or is an error of frictopt that names a remedy. Run
with `python -m studies fuzz [--quick] [--cases N] [--seed S] [--only answers | differential | space
| sliding]`. It prints wrong answers with their seeds, and the counts in Markdown; its exit status
is 1 if any answer is wrong. Without a seed it draws a new one and prints it, so each run tests new
cases; a quick run always has the same seed. The part "answers" has small contacts, ordinary and
extreme. The part "differential" has contacts of 3 to 130 nodes, each solved in two equivalent
descriptions. The part "space" has contacts in three dimensions, the part "sliding" bodies that
slide off. The tests run some of the same cases.
"""

import argparse
import re
import secrets
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import chain
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

import frictopt as fo
from studies.progress import each
from studies.tables import Study, Table, markdown, whole_number
from studies.validation.fuzz.cases import random_case
from studies.validation.fuzz.checks import CHECKS, Finding, findings
from studies.validation.fuzz.differential import DIFFERENTIAL, differences
from studies.validation.fuzz.scenes import random_scene
from studies.validation.fuzz.sliding import SLIDING, sliding_findings
from studies.validation.fuzz.space import SPACE, space_findings

PARTS: Mapping[str, tuple[Mapping[str, Any], Callable[[int], Iterator[Finding]]]] = {
    "answers": (CHECKS, lambda seed: findings(random_case(seed))),
    "differential": (DIFFERENTIAL, lambda seed: differences(random_scene(seed))),
    "space": (SPACE, lambda seed: space_findings(seed)),
    "sliding": (SLIDING, lambda seed: sliding_findings(seed)),
}
"""Part -> its questions, and the function that returns all findings for the case of a seed."""


@dataclass(frozen=True)
class Parameters:
    """The number of cases, the seed of the first case, and the parts that are computed.

    Each further case has the next seed.
    """

    cases: int = 10_000
    seed: int = 0
    parts: tuple[str, ...] = tuple(PARTS)


FULL = Parameters()
QUICK = Parameters(cases=1)
_QUICK_SEED = 427_205_129


@cache
def _run(parameters: Parameters) -> pd.DataFrame:
    """One row per finding, with the seconds that it took."""
    rows: list[dict[str, Any]] = []
    with threadpool_limits(1), warnings.catch_warnings():
        # Extreme cases are intended, so their warnings are not shown.
        warnings.simplefilter("ignore", fo.ModelWarning)
        for seed in each(range(parameters.seed, parameters.seed + parameters.cases), "fuzzing"):
            start = time.perf_counter()
            for finding in chain.from_iterable(PARTS[part][1](seed) for part in parameters.parts):
                rows.append({**asdict(finding), "seconds": time.perf_counter() - start})
                start = time.perf_counter()
                if finding.result == "wrong":
                    tqdm.write(f"WRONG, seed {finding.seed}, {finding.check}: {finding.text}")
                    # A reader of a long run sees the line at once.
                    sys.stdout.flush()
    return pd.DataFrame(rows)


def counts(parameters: Parameters) -> pd.DataFrame:
    """One row per question."""
    by_question = _run(parameters).groupby("check")
    table = by_question.agg(
        cases=("seed", "size"),
        compared=("compared", "sum"),
        residual=("residual", "max"),
        seconds=("seconds", "sum"),
    )
    results = ["answer", "missed", "ModelError", "NoContinuation", "SolverError", "wrong"]
    table[results] = by_question["result"].value_counts().unstack().reindex(columns=results)
    # A question without findings has a row of zeros.
    questions = [check for part in parameters.parts for check in PARTS[part][0]]
    table = table.reindex(questions).fillna(0.0)
    whole = table.drop(columns=["residual", "seconds"]).astype(int)
    table = table.assign(**whole).rename(columns={"answer": "answers"})
    return table.rename_axis("question").reset_index()[["question", *_COUNTS]]


def refusals(parameters: Parameters) -> pd.DataFrame:
    """One row per question, kind of error and message without its numbers.

    Wrong answers come first, each in its own row with its numbers.
    """
    rows = _run(parameters).query("result != 'answer'").rename(columns={"check": "question"})
    text_with_seed = rows["text"] + " (seed " + rows["seed"].astype(str) + ")"
    is_wrong = rows["result"] == "wrong"
    rows["message"] = text_with_seed.where(is_wrong, rows["text"].map(_without_numbers))
    table = (
        rows.groupby(["question", "result", "message"], sort=False)
        .agg(cases=("seed", "size"), seed=("seed", "first"))
        .reset_index()
    )
    table = table.sort_values(
        ["result", "cases"],
        ascending=False,
        key=lambda column: column == "wrong" if column.name == "result" else column,
    )
    return table.assign(residual=0.0)


def _without_numbers(message: str) -> str:
    """A message with "#" for each number and "[..]" for each list."""
    without_solver = message.split("(HIGHS")[0]
    numbered = re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", without_solver)
    return re.sub(r"\[[^\]]*\]", "[..]", numbered)


def short(table: pd.DataFrame) -> str:
    """Counts as a table in Markdown."""
    form = {"residual": "{:.0e}", "seconds": "{:.0f}"}
    rows = [
        [form.get(name, "{}").format(value) for name, value in row.items()]
        for row in table.to_dict("records")
    ]
    return markdown(list(table.columns), rows)


_COUNTS = {
    "cases": "number of cases",
    "answers": "number of answers that are not wrong",
    "missed": "right answers about the nodes that they leave open, with a better one that leaves others open",
    "compared": "number of answers that were compared with an independent one",
    "ModelError": "cases refused, because they are not a contact problem",
    "NoContinuation": "cases whose path ends or is not unique",
    "SolverError": "cases without an answer that passes the checks",
    "wrong": "answers that an independent one contradicts, and errors of other packages: must be 0",
    "residual": "largest residual of an answer",
    "seconds": "time, including the independent answers",
}
_REFUSALS = {
    "result": "kind of error, or 'wrong'",
    "message": "its message without numbers",
    "cases": "number of cases",
    "seed": "the first case",
}
COUNTS = Table(
    "fuzz_counts", "one question, all cases", _COUNTS, full=FULL, quick=QUICK, compute=counts
)
REFUSALS = Table(
    "fuzz_refusals", "one message of an error", _REFUSALS, full=FULL, quick=QUICK, compute=refusals
)


class _Random(Study):
    """The study of random contacts; the command line chooses their number and seeds."""

    def parser(self) -> argparse.ArgumentParser:
        parser = super().parser()
        parser.add_argument(
            "--cases",
            type=whole_number(1),
            metavar="N",
            help=f"number of random contacts of each part (default {FULL.cases})",
        )
        parser.add_argument(
            "--seed",
            type=whole_number(0, 2**62),
            metavar="N",
            help="seed of the first one (default: another one each time, which is printed; of a quick run the same)",
        )
        parser.add_argument("--only", choices=tuple(PARTS), help="the questions of one part")
        return parser

    def run(self, argv: Sequence[str] | None = None) -> int:
        options = self.parser().parse_args(argv)
        cases = options.cases or (QUICK if options.quick else FULL).cases
        if options.seed is not None:
            seed = options.seed
        elif options.quick:
            seed = _QUICK_SEED
        else:
            seed = secrets.randbelow(10**9)
        parts = (options.only,) if options.only else tuple(PARTS)
        parameters = Parameters(cases, seed, parts)
        print(f"seeds {seed} to {seed + cases - 1}")
        tables = [replace(table, full=parameters, quick=parameters) for table in self.tables]
        status = Study.run(replace(self, tables=tables), argv)
        return status or int((_run(parameters)["result"] == "wrong").any())


STUDY = _Random(
    "studies.validation.fuzz",
    __doc__,
    "few cases, in half a minute",
    (COUNTS, REFUSALS),
    summary=lambda tables: short(tables[COUNTS.name]),
)
