"""Finite-element models of a contact, condensed to its interface.

The input is meshes of scikit-fem, or matrices of any finite-element code. The result is a
`ContactSystem`: the stiffness S of the relative motions z of the node pairs, and the bonded
reactions of each load case. K is the stiffness of the separate bodies. The displacements are
`u = T y`, where y consists of the displacements inside the bodies and of z. S is the Schur
complement of z in `T^T K T`.

| file | what is in it |
|---|---|
| `model.py` | `ContactModel`: the description by the user, and its condensation |
| `bodies.py`, `elasticity.py` | meshes with materials, their stiffness and nodal forces |
| `mixed.py` | meshes of elements of several shapes |
| `contacts.py` | contacts, the corners that they share, and faces that are glued for good |
| `supports.py`, `couplings.py` | supports, and nodes coupled to a point |
| `sector.py` | sectors of a ring |
| `adjusting.py` | position tolerances: nodes moved onto the opposite face |
| `loads.py`, `node_forces.py` | loads, forces on nodes and at a point |
| `bolts.py` | tightened bolts |
| `faces.py`, `normals.py` | facets, overlaps of faces, and normals |
| `mortar.py` | nodes of one face joined to places on another; faces that touch but are not joined |
| `coincidence.py` | which points coincide |
| `assembly.py`, `load_cases.py` | all bodies in one numbering, and load cases |
| `condense.py`, `schur.py`, `rigid.py` | condensation, elimination, and free rigid motions |
| `products.py` | the contact by products, without a dense stiffness |
| `interface.py` | relative motions of pairs as unknowns, also on planes of symmetry |
| `matrix_checks.py` | checks of matrices, and of the order and sides of pairs |
| `fields.py`, `recovery.py`, `modes.py` | displacements and stresses, and modes of vibration |
| `pictures.py`, `grids.py` | drawing and export |
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
