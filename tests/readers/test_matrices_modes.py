"""Modes of CalculiX, of a file beside the matrices."""

import numpy as np
from scipy.sparse import csr_matrix

import frictopt as fo
from helpers.refused import refused

MODE = """
     E I G E N V A L U E   O U T P U T

      1   0.4000000E+01   0.2000000E+01   0.3183099E+00   0.0000000E+00

     P A R T I C I P A T I O N   F A C T O R S

      1   0.1000000E+01   0.0000000E+00   0.0000000E+00   0.0000000E+00   0.0000000E+00   0.0000000E+00

                    E I G E N V A L U E    N U M B E R     1

 displacements (vx,vy,vz) for set A and time  0.1000000E+01

         7  1.500000E+00 -2.000000E-01  0.000000E+00

 forces (fx,fy,fz) for set A and time  0.1000000E+01

         7  9.000000E+00  9.000000E+00  9.000000E+00

 displacements (vx,vy,vz) for set B and time  0.1000000E+01

         9  2.500000-103 -3.000000E-01  0.000000E+00
"""


def test_modes_stand_in_the_order_of_the_rows(tmp_path):
    (tmp_path / "job.dat").write_text(MODE)
    job = fo.readers.MatrixJob(
        csr_matrix(np.eye(4)), [[9, 2], [7, 1], [9, 1], [7, 2]], {7: (0.0, 0.0), 9: (1.0, 0.0)}
    )
    frequencies, shapes = job.modes(tmp_path / "job.dat")
    assert frequencies.tolist() == [0.3183099] and shapes.tolist() == [[-0.3, 1.5, 2.5e-103, -0.2]]


@refused(
    (
        "",
        [[7, 1]],
        r"modes: .*job\.dat' has frequencies: 0, modes: 0; give the .dat of a \*FREQUENCY step with \*NODE PRINT",
    ),
    (MODE.replace("N U M B E R", "-"), [[7, 1]], "has frequencies: 1, modes: 0"),
    (MODE, [[7, 1], [8, 1]], "has no displacement of node 8 of the matrix; print U of all nodes"),
    (MODE.replace("displacements", "forces"), [[7, 1]], "has no displacement of node 7"),
    (MODE, [[7, 1], [7, 6]], "modes: the matrix has unknowns that are no displacements of nodes"),
    (None, [[7, 1]], r"modes: '.*job\.dat' cannot be read"),
)
def test_files_without_modes_are_refused(text, labels, tmp_path):
    if text is not None:
        (tmp_path / "job.dat").write_text(text)
    fo.readers.MatrixJob(
        csr_matrix(np.eye(len(labels))), labels, {7: (0.0, 0.0), 8: (1.0, 0.0)}
    ).modes(tmp_path / "job.dat")
