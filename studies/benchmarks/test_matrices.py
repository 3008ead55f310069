"""Reading the matrix of a CalculiX job of 6,630 equations, against the bare parser of its rows."""

import numpy as np
import pandas as pd
import pytest
from scipy.sparse import triu
from skfem import Basis, ElementHex1, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

import frictopt as fo

# Numbers of nodes in x, y, z. The nodes at the bottom are not in the file.
SIDES = (13, 17, 10)
# The order of a brick's nodes in scikit-fem, by their numbers in decks.
HEX = [0, 3, 6, 2, 1, 5, 7, 4]


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """Files as CalculiX writes them: upper triangle, 14 digits, one label per row."""
    folder = tmp_path_factory.mktemp("job")
    mesh = MeshHex.init_tensor(*(np.linspace(0, 1, nodes) for nodes in (*SIDES[:2], SIDES[2] + 1)))
    K = linear_elasticity(*lame_parameters(1.0, 0.3)).assemble(
        Basis(mesh, ElementVector(ElementHex1()))
    )
    free = np.flatnonzero(np.repeat(mesh.p[2] > 0, 3))
    upper = triu(K[free][:, free]).tocoo()
    rows = "".join(
        f"{i + 1} {j + 1}  {value:.13e}\n"
        for i, j, value in zip(upper.row, upper.col, upper.data, strict=True)
    )
    (folder / "big.sti").write_text(rows)
    (folder / "big.dof").write_text(
        "".join(f"{unknown // 3 + 1}.{unknown % 3 + 1}\n" for unknown in free)
    )
    nodes = "".join(f"{i + 1},{x:.12g},{y:.12g},{z:.12g}\n" for i, (x, y, z) in enumerate(mesh.p.T))
    bricks = "".join(
        f"{i + 1}," + ",".join(map(str, nodes)) + "\n" for i, nodes in enumerate(mesh.t[HEX].T + 1)
    )
    (folder / "big.inp").write_text(
        f"*NODE, NSET=NALL\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=EALL\n{bricks}"
    )
    return folder / "big"


def test_reading_a_job(benchmark, job):
    read = benchmark.pedantic(lambda: fo.readers.read_calculix(job), rounds=7)
    assert read.K.shape == (6630, 6630) and read.unknowns.shape == (2431, 3)
    assert benchmark.stats.stats.median < 0.3


def test_reading_a_job_against_parsing_its_rows(compare, job):
    assert (
        compare(
            lambda: fo.readers.read_calculix(job),
            lambda: pd.read_csv(f"{job}.sti", sep=r"\s+", header=None),
            rounds=7,
        )
        < 4.0
    )
