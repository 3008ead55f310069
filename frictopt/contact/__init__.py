"""The discrete contact: N node pairs and the matrices of their elastic bodies.

In come blocks A, B, C and bonded reactions; out go a `ContactSystem` (`system.py`, its files in
`files.py`), a `LoadCycle` (`cycle.py`, from measured histories in `history.py`), and Coulomb's law
with the referee of every state (`coulomb.py`). `parts.py` has the algebra of the stiffness,
`frames.py` tangents and normals, `diagnosis.py` words what is wrong with a load. `pictures.py`,
`strip.py` (plane) and `face.py` (space) draw.
"""

from .coulomb import (
    ContactState,
    Verdict,
    friction_coefficients,
    lengths,
    most_shear,
    off_law,
    referee,
)
from .cycle import LoadCycle, checked_cycle
from .parts import checked_springs, compliances, joined, parted, runs
from .system import (
    ContactSystem,
    checked_plane,
    checked_round,
    checked_system,
    checked_uncapped,
    checked_width,
    reactions,
)
