"""Readers of the decks, meshes and matrices of other codes.

In come files; out go a mesh for `split_bodies` (`meshes.py`) or a `MatrixJob` for `condense`
(`job.py`, `labelled.py`). `deck.py` reads decks by their keywords (`keywords.py`),
`calculix_abaqus.py` and `ansys_nastran.py` the matrices of these codes. A new reader is one
function that returns a `MatrixJob`.
"""
