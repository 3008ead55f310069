"""The discrete contact: N node pairs and the matrices of their elastic bodies.

The blocks A, B, C and bonded reactions of the load cases come in. A `ContactSystem`, a `LoadCycle`
and the contact law go out. With slips v, gaps w and reactions q, p of body 2 on body 1::

    q = q^w + A v + B^T (w - gap)      |q| <= bound(p), friction opposes slip
    p = p^w + B v + C (w - gap)        p >= 0,  w >= 0,  p w = 0

- `system.py`: the contact and its copies; `given_parts.py` checks its parts, `stiffness.py` has the
  algebra of its stiffness, `components.py` the order of its vectors, tangents and normals,
  `files.py` its files.
- `products.py`: a contact that is known by products with vectors, without its stiffness.
- `cycle.py`: load cycles; `history.py` makes their corners from histories and harmonic loads.
- `law.py`: the bound of the shear force. A new law of friction begins there.
- `law_check.py`: how much a state violates the law; `state.py`: a state to start from.
- `stress_map.py`: stresses at points as linear functions of loads and motions.
- `diagnosis.py`: what is wrong with a load, in words.
- `pictures.py` draws contacts and their shear forces on lines and maps.
"""

from .components import amplitudes_of, frames_of, joined, parted
from .cycle import LoadCycle, checked_cycle
from .given_parts import checked_springs, compliances
from .law import (
    ROWS,
    BoundTerm,
    ContactLaw,
    checked_law,
    contact_law,
    friction_coefficients,
    lengths,
    most_shear,
)
from .law_check import Verdict, check_contact_law, off_law
from .products import ContactProducts
from .state import ContactState
from .stress_map import StressMap
from .system import (
    ContactSystem,
    checked_round,
    checked_system,
    checked_width,
    reactions,
)
