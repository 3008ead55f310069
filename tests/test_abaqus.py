"""Matrices of Abaqus: the same as those of CalculiX, and every way in which the files can be wrong."""

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import triu

import frictopt as fo

DATA = Path(__file__).parent / "data"


def largest(matrix):
    return np.abs(matrix).max()


def abaqus(path, job, entries):
    labels = job.labels
    rows = [f"{labels[i, 0]},{labels[i, 1]}, {labels[j, 0]},{labels[j, 1]}, {value:.15e}" for i, j, value in entries]
    path.write_text("** Assembled stiffness\n" + "\n".join(rows) + "\n")


@pytest.mark.parametrize("part", ["lower", "upper", "all"])
def test_abaqus_gives_the_same_matrix(flat, tmp_path, part):
    kept = flat.K.tocoo() if part == "all" else triu(flat.K).tocoo()
    ends = (kept.row, kept.col) if part != "lower" else (kept.col, kept.row)
    abaqus(tmp_path / "job_STIF1.mtx", flat, zip(*ends, kept.data, strict=True))
    with (tmp_path / "job_STIF1.mtx").open("a") as file:
        file.writelines(f"{node},1, {node},1, 1.0e36\n" for node in (1, 2))  # held displacements
    job = fo.read_abaqus(tmp_path / "job_STIF1.mtx", deck=DATA / "flat.inp")
    where = job.unknowns[flat.unknowns >= 0]
    order = np.empty(964, dtype=int)
    order[flat.unknowns[flat.unknowns >= 0]] = where
    assert job.K.shape == (964, 964) and largest(job.K[order][:, order] - flat.K) < 1e-14 * largest(flat.K)
    assert np.array_equal(job.labels[order], flat.labels)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 1 2.0\n2 1 -1.0\n", "FORMAT=COORDINATE"),
        ("1, 1, 2.0\n2, 1, -1.0\n", "FORMAT=COORDINATE"),
        ("7,1, 7,1\n", "rows of 4 columns"),
        ("7,4, 8,5, 1.0\n", "labels: none is that of a displacement"),
        ("-1,1, -7,1, 1.0\n", "labels: none is that of a displacement"),
        ("7,1, 7,1, 1.0\n", "labels: none"),
        ("7,1, 8,1, -1.0\n8,1, 7,1, -2.0\n", "not symmetric"),
        ("", "stiffness: "),
    ],
)
def test_other_files_of_abaqus_are_refused(tmp_path, text, said):
    (tmp_path / "a.mtx").write_text(text)
    with pytest.raises(fo.ModelError, match=said):
        fo.read_abaqus(tmp_path / "a.mtx")
