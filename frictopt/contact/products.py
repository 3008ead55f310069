"""A contact whose bodies are known by products with vectors, without a stiffness matrix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

import numpy as np

from ..base import Array, finite_array, frozen
from ..errors import ModelError
from .given_parts import checked_gap
from .system import ContactSystem

# Largest difference of two products that should be equal, relative to the sizes of their vectors.
_ADJOINT = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class ContactProducts(ContactSystem):
    """N node pairs of two elastic bodies, known by products with vectors, without a stiffness.

    `shakedown_limit(..., gap=)` and `required_friction(..., gap=)` need only products (theory, "A
    limit between two proven numbers"). Other questions need the stiffness `S`, and raise a
    ModelError that says so. The bodies stay in contact at all nodes: initial gaps and open nodes
    need the stiffness, too.

    `ContactModel.products` makes it from finite elements. You can make your own, for instance from
    a boundary-element code with hierarchical matrices: all products are linear operators of
    `scipy.sparse.linalg`. `studies/half_space.py` makes one for a half-space by convolutions.

    Parameters
    ----------
    points, bonded
        See `ContactSystem`, also for the parameters that are not listed here.
    pressing
        (N, t N) operator T, with its transpose: pressures due to unit shear forces on the bodies,
        which stay in contact and slip freely. Shear forces are ordered by component, as in `S`.
        Products with T need 10 correct digits, because they prove the load factor and its bound.
    slipping
        (t N, t N) operator, symmetric: the slips due to the same shear forces, length per force.
    rough
        The operator T in single precision with 4 digits, for the search; None: `pressing`.
    slides
        (t N, r) slips that nothing resists: rigid motions of the bodies along the contact, which
        open no pair. None: supports hold the bodies. Products need to be right only for forces that
        do no work on slides.

    Raises
    ------
    ModelError
        Operators of other shapes, transposes that do not fit, an initial gap, and what
        `ContactSystem` refuses.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> from scipy.sparse.linalg import aslinearoperator
    >>> A, B = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([[0.0, 0.5], [-0.5, 0.0]])
    >>> contact = fo.ContactProducts(
    ...     [[0.0, 0.0], [1.0, 0.0]],
    ...     {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ...     pressing=aslinearoperator(B @ np.linalg.inv(A)),
    ...     slipping=aslinearoperator(np.linalg.inv(A)),
    ... )
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.shakedown_limit(contact, cycle, friction=0.5, gap=0.01)
    >>> bool(limit.load_factor <= 0.535714 <= limit.bound)
    True
    """

    S: Array = field(init=False)
    points: Array
    bonded: Mapping[str, Any]
    _: KW_ONLY
    pressing: Any
    slipping: Any
    rough: Any = None
    slides: Any = None

    def __getattr__(self, name: str) -> Any:
        """ModelError for the stiffness, which is not known."""
        if name != "S":
            raise AttributeError(name)
        raise ModelError(
            "system: it is known by products, and this question needs its stiffness S; condense "
            "the bodies (`model.condense()`), or ask shakedown_limit or required_friction with "
            "gap=0.01 and all nodes closed"
        )

    def _check_stiffness(self, n: int, tangents: int) -> None:
        """Check the operators, and that their transposes fit."""
        if checked_gap(self.gap, n).any():
            raise ModelError(
                "gap: products know no initial gap; condense the bodies (`model.condense()`)"
            )
        size = tangents * n
        rough = self.pressing if self.rough is None else self.rough
        slides = np.zeros((size, 0)) if self.slides is None else self.slides
        slides = np.linalg.qr(finite_array("slides", slides, (size, None)))[0]
        operators = {
            "pressing": (self.pressing, (n, size)),
            "rough": (rough, (n, size)),
            "slipping": (self.slipping, (size, size)),
        }
        for name, (operator, shape) in operators.items():
            given = getattr(operator, "shape", None)
            if given != shape:
                raise ModelError(f"{name}: shape {given}; give a linear operator of shape {shape}")
        random = np.random.default_rng(0)
        shear, other = (q - slides @ (slides.T @ q) for q in random.normal(size=(2, size)))
        lifts = random.normal(size=n)
        pressure, slip = self.pressing @ shear, self.slipping @ shear
        _check_equal("pressing", lifts, pressure, shear, lifts @ self.pressing)
        _check_equal("slipping", other, slip, shear, self.slipping @ other)
        scale = float(np.linalg.norm(shear) / np.linalg.norm(slip))
        vars(self).update(
            rough=rough,
            slides=frozen(slides),
            stiffness_scale=scale,
            own_stiffness=frozen(np.full(size + n, scale)),
        )


def _check_equal(name: str, left: Array, there: Array, right: Array, back: Array) -> None:
    """Check that two works are equal, as they are if an operator and its transpose fit."""
    error = abs(left @ there - back @ right)
    size = np.linalg.norm(left) * np.linalg.norm(there)
    if not error <= _ADJOINT * size:
        raise ModelError(
            f"{name}: products with it and with its transpose differ by {error / size:.1e} of "
            "their size; give both, with more digits"
        )
