"""The result of the closed-form scenes: the plain arrays of a contact system."""

from typing import TypedDict

from ..contact.checks import Array


class ContactArrays(TypedDict):
    """Arguments of `frictopt.ContactSystem`, to be passed as `ContactSystem(**arrays)`.

    Attributes
    ----------
    A, B, C
        (N, N) stiffness of the tangential motion, normal force per slip, and stiffness of the opening, force per depth and length.
    x
        (N,) coordinates of the nodes, length.
    bonded
        Load case -> (N,) tangential (along +x) and normal (compression positive) reactions of the glued contact under the unit load, force per depth.
    gap
        (N,) initial gap, length.

    Examples
    --------
    >>> import frictopt as fo
    >>> arrays = fo.reference.half_plane_contact(nodes=4, half_length=1.0, E_star=1.0)
    >>> fo.ContactSystem.from_blocks(**arrays)
    ContactSystem(nodes=4, x=-0.75 .. 0.75, loads=['P', 'Q'], gap=False)
    """

    A: Array
    B: Array
    C: Array
    x: Array
    bonded: dict[str, tuple[Array, Array]]
    gap: Array
