"""The tables in short form, as Markdown."""

from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from studies.limits import corner_law
from studies.tables import markdown, two_digits
from studies.validation.error_vs_time.methods import ROUNDING


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """The short tables, with the machine and the rivals that were absent."""
    error = tables["error_vs_time"]
    installed = ", ".join(f"{name} {number}" for name, number in error.attrs["rivals"].items())
    missing = ", ".join(error.attrs["absent"]) or "none"
    head = f"{error.attrs['machine']}; medians of processor times; rivals: {installed}; not installed and skipped: {missing}."
    return "\n\n".join(
        [
            "",
            head,
            fronts(error),
            increments(error),
            calls(error),
            plain(error),
            law(tables["limits_corner"]),
        ]
    )


def fronts(table: pd.DataFrame) -> str:
    """One line per question, on its coarsest and on its finest mesh."""
    rows = []
    for question in _shown(table):
        ours, rivals = _best(question), question[question["rival"] != ""]
        rows.append(
            [_name(ours), f"{_way(ours)}: {_cost(ours)}", _rival(rivals, ours), _ahead(rivals)]
        )
    return markdown(
        [
            "computation",
            "frictopt: error, time",
            "fastest rival as accurate",
            "rivals ahead of frictopt",
        ],
        rows,
    )


def increments(table: pd.DataFrame) -> str:
    """Error and run time of one increment in the plane, by every method, on the finest mesh."""
    of_increments = table[table["computation"] == "increment"]
    finest = of_increments[of_increments["nodes"] == of_increments["nodes"].max()]
    quantities = list(finest["quantity"].unique())
    rows = []
    for (method, setting), part in finest.groupby(["method", "setting"], sort=False):
        by_quantity = part.set_index("quantity")
        costs = [_cost(by_quantity.loc[name]) for name in quantities]
        rows.append([f"{method} ({setting})", *costs])
    return markdown([f"increment, N = {finest['nodes'].max()}", *quantities], rows)


def calls(table: pd.DataFrame) -> str:
    """Times of first and second calls on the finest mesh in the plane, in ms.

    The first call builds its model, and the second call is on the same model.
    """
    is_call = table["method"].isin(["frictopt, first time", "frictopt, compiled"])
    of_calls = table[is_call & (table["setting"] == "HIGHS")]
    largest = of_calls["nodes"].max()
    finest = of_calls[of_calls["nodes"] == largest].pivot(
        index="computation", columns="method", values="seconds"
    )
    rows = [
        [str(row.Index), *(two_digits(1e3 * seconds) for seconds in row[:0:-1])]
        for row in finest.itertuples()
    ]
    return markdown([f"ms, N = {largest}", "first call", "second call"], rows)


def plain(table: pd.DataFrame) -> str:
    """The first shakedown limit on each mesh, and the same limit in plain cvxpy."""
    limits = table[table["computation"] == "lambda_2"]
    is_plain = limits["rival"] == "cvxpy"
    ours = limits[limits["method"] == "frictopt, first time"].set_index("nodes")["seconds"]
    rows = []
    for nodes, part in limits[is_plain].groupby("nodes"):
        first = ours[nodes]
        costs = [
            f"{_cost(row)}, {two_digits(row.seconds / first)} of ours" for row in part.itertuples()
        ]
        rows.append([str(nodes), _seconds(first), *costs])
    methods = limits.loc[is_plain, "method"].unique()
    return markdown(["lambda_2, N", "frictopt, first call", *methods], rows)


def law(table: pd.DataFrame) -> str:
    """Exponent of the shakedown limit in the size of the corner element.

    The closed form stands beside the exponent between the two finest meshes.
    """
    finest = corner_law(table).groupby("friction").last()
    rows = [
        [f"{row.Index:g}", f"{row.expected:.3f}", f"{row.exponent:.3f}"]
        for row in finest.itertuples()
    ]
    return markdown(["f", "expected exponent", "between the two finest meshes"], rows)


def _questions(table: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """The rows of each question."""
    yield from (rows for _, rows in table.groupby(["computation", "quantity", "scene"], sort=False))


def _shown(table: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """The rows of the questions on the coarsest and on the finest mesh."""
    for question in _questions(table):
        alike = (
            table[["computation", "quantity"]] == question[["computation", "quantity"]].iloc[0]
        ).all(axis=1)
        sizes = table.loc[alike & (table["nodes"] > 0), "nodes"]
        if question["nodes"].iloc[0] in {0, sizes.min(), sizes.max()}:
            yield question


def _best(question: pd.DataFrame) -> Any:
    """The fastest answer of frictopt that only rounding limits, or else the most accurate answer.

    Answers with a given number of cycles do not count, because the necessary number is not known
    beforehand.
    """
    rows = question[(question["rival"] == "") & (question["knob"] != "cycles")]
    exact = rows[rows["error"] <= ROUNDING]
    return exact.loc[exact["seconds"].idxmin()] if len(exact) else rows.loc[rows["error"].idxmin()]


def _rival(rivals: pd.DataFrame, ours: Any) -> str:
    """The fastest rival that is as accurate as frictopt."""
    if not len(rivals):
        return ""
    equal = rivals[rivals["error"] <= max(ours.error, ROUNDING)]
    if not len(equal):
        best = rivals.loc[rivals["error"].idxmin()]
        return f"none; nearest: {best.method} ({best.setting}) {_cost(best)}"
    best = equal.loc[equal["seconds"].idxmin()]
    return f"{best.method} ({best.setting}): {_seconds(best.seconds)}, {two_digits(best.seconds / ours.seconds)} of ours"


def _ahead(rivals: pd.DataFrame) -> str:
    """Rivals that are faster than every answer of frictopt that is as accurate as theirs.

    The most accurate of these answers is shown for each rival.
    """
    if not len(rivals):
        return ""
    ahead = rivals[rivals["ahead"]].sort_values("error").groupby("method", sort=False).first()
    return "; ".join(f"{row.Index} ({_cost(row)})" for row in ahead.itertuples()) or "none"


def _name(row: Any) -> str:
    """Name of the question of a row."""
    return f"{row.computation}: {row.quantity}, {f'N = {row.nodes}' if row.nodes else row.scene}"


def _way(row: Any) -> str:
    """Method or setting of a row."""
    return (
        f"{row.knob} {row.setting}"
        if row.nodes == 0
        else row.method.removeprefix("frictopt").lstrip(", ") or row.setting
    )


def _cost(row: Any) -> str:
    return f"{row.error:.0e}, {_seconds(row.seconds)}"


def _seconds(value: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if value >= 0.995 * size:
            return f"{two_digits(value / size)} {unit}"
    return f"{two_digits(value / 1e-6)} µs"
