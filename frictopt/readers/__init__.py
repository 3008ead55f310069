"""Readers of the decks, meshes and matrices of other codes.

A reader returns a mesh with named boundaries and subdomains, for `split_bodies`, or a `MatrixJob`.
The job has the arguments of `condense`: a stiffness K, the labels (n, 2) of its rows (node and
direction), and a `Deck` of nodes, sets, elements and constraints.

The readers, and the class that they return:

- `meshes.py`: `read_mesh`. `groups.py` finds the named groups of mesh files, `mixed_elements.py`
  makes meshes of elements of several shapes.
- `calculix_abaqus.py`: `read_calculix`, `read_abaqus`, also substructures.
- `ansys_nastran.py`: `read_ansys`, `read_nastran`. `bulk_data.py` finds the cards of Nastran and
  makes a deck of them, also for `read_mesh`.
- `job.py`: `MatrixJob`, with faces, pairs and forces. Its base is `labelled.py`, with labels,
  rows and bodies.

Decks, from the text to the `Deck`:

- `deck_text.py`: makes blocks of the text. A block is a keyword with its parameters and data lines.
  Parts and instances are replaced by the blocks of one flat deck.
- `keywords.py`: a function for each keyword that is kept, the keywords that are refused, and
  `read_deck`.
- `listing.py`: the numbers, names and constraints that the blocks list, resolved to a `Deck`.
- `deck.py`: the `Deck`, and the types of elements.

To add a keyword, see `keywords.py`. A new reader of matrices is one function that returns a
`MatrixJob`. A new format of meshes is one function that returns a `Deck`; `read_mesh` calls it by
the ending of the file. In both cases `deck_of_points` of `listing.py` makes the `Deck` of nodes,
elements and sets. Then name a new reader in `__init__.pyi`, in `docs/api/models.md` and in
`called.py` of the tests. Contacts, loads and steps of decks are read in `joint_files/`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
