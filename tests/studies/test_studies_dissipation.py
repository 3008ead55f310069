"""The dissipation study at quick size: what shakedown theory says of any mesh, and the step engine
as another opinion."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from studies import __main__ as studies
from studies import dissipation

TABLES = {"runs": dissipation.RUNS, "limits": dissipation.LIMITS, "states": dissipation.STATES}
STARTS = 1 + 4 + 2 * 2 * 3 + 1


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    options = [
        "--quick",
        "--workers",
        "1",
        "--store",
        str(folder / "store"),
        "--data",
        str(folder / "tables"),
    ]
    assert studies.main(["dissipation", *options]) == 0
    assert len(fo.results.read_store(folder / "store")) == 2 * 3 * STARTS
    return {name: pd.read_parquet(table.path(folder / "tables")) for name, table in TABLES.items()}


def test_there_is_a_row_for_each_friction_load_and_start(tables):
    runs = tables["runs"]
    assert (
        len(runs) == 2 * 3 * STARTS
        and not runs.duplicated(["friction", "load_ratio", "start"]).any()
    )
    assert (runs["error"] == "").all() and (runs["residual"] <= 1e-9).all()


def test_units_are_those_of_the_paper(tables):
    """P = 2, E* = E / (2 (1 - nu^2)) with E = 1, nu = 0.3."""
    runs = tables["runs"]
    assert np.allclose(
        runs["dissipation_scaled"], runs["dissipation"] / (4 * 2 * (1 - 0.3**2)), rtol=1e-12
    )
    sizes = runs.loc[runs["family"].isin(["smooth", "rough"]), "amplitude"]
    assert np.allclose(np.sort(sizes.round(9).unique()), [0.06, 0.6])


def test_summaries_count_the_runs(tables):
    runs = tables["runs"]
    for more in ([], ["family"]):
        keys = ["friction", "load_ratio", *more]
        for _, row in dissipation.summary(runs, *more).iterrows():
            rows = runs[(runs[keys] == row[keys]).all(axis=1)]
            assert row["runs"] == len(rows) > 0
            assert row["shakedown"] == pytest.approx(np.mean(rows["dissipation"] == 0))
            assert [row["least"], row["median"], row["most"]] == pytest.approx(
                np.quantile(rows["dissipation_scaled"], [0, 0.5, 1]), abs=1e-15
            )


def test_studies_are_listed_with_their_minutes_and_options(capsys):
    assert studies.main([]) == 0
    lines = capsys.readouterr().out.splitlines()
    for name in studies.STUDIES:
        (number,) = (n for n, line in enumerate(lines) if line.split()[:1] == [name])
        assert "--quick" in lines[number + 1] and "--data" in lines[number + 1]
        page = Path(studies.__file__).parents[1] / "docs" / "tables" / f"{name}.md"
        assert not page.exists() or lines[number].split()[2] == "min"
        if name == "dissipation":
            assert "--workers" in lines[number + 1]


def test_every_program_of_the_repository_is_listed(capsys):
    """Programs outside of the package, without those that another Python runs for a study."""
    root = Path(studies.__file__).parents[1]
    studies.main([])
    said = capsys.readouterr().out
    found = [
        path.relative_to(root)
        for folder in ("studies", "paper_figures", "tests/tools", "docs")
        for path in sorted((root / folder).rglob("*.py"))
        if {"outside", "_build"}.isdisjoint(path.parts)
        and '\nif __name__ == "__main__"' in path.read_text(encoding="utf-8")
    ]
    assert len(found) > 9
    for path in found:
        module = ".".join(path.with_suffix("").parts).removesuffix(".__main__")
        assert f"python {path.as_posix()}" in said or f"python -m {module} " in said


def test_an_unknown_study_is_refused(capsys):
    assert studies.main(["limit"]) == 2
    assert "unknown study 'limit'" in capsys.readouterr().err
