"""Limits that follow from equilibrium alone, for any mesh and material."""

from ..contact.checks import finite_number


def patch_limit(f: float, p: float, tau: float) -> float:
    """Onset of slip and both limits, `f p / |tau|`, of two identical blocks under uniform stress.

    The blocks mirror each other in the interface, mesh included. A uniform pressure p is the mean load, a uniform shear stress `+-tau` on all
    outer faces the two corners of the cycle. Mirror symmetry uncouples slip and pressure (`B = 0`), and under uniform stress the nodal forces of
    shear and pressure stand as tau to p at every node: all nodes slip at the same load factor, so onset, lambda_1 and lambda_2 are one.

    Parameters
    ----------
    f
        Coefficient of friction, dimensionless, not negative.
    p
        Mean pressure on the interface, compression positive, stress.
    tau
        Amplitude of the shear stress at load factor one, stress; the sign does not matter.

    Returns
    -------
    float
        Dimensionless; inf for `tau = 0`.

    Raises
    ------
    ModelError
        A value that is not real and finite, negative friction, pressure not positive.

    References
    ----------
    A. Klarbring, M. Ciavarella and J. R. Barber (2007), Shakedown in elastic contact problems with Coulomb friction, International Journal of
    Solids and Structures 44, 8355-8365: uncoupled contacts.

    Examples
    --------
    >>> from frictopt.reference import patch_limit
    >>> patch_limit(f=0.5, p=2.0, tau=4.0)
    0.25
    """
    shear = abs(finite_number("tau", tau))
    bound = finite_number("f", f, least=0.0) * finite_number("p", p, above=0.0)
    return bound / shear if shear else float("inf")


def gross_slip_bound(f: float, P0: float, Q1: float) -> float:
    """Upper bound `f P0 / |Q1|` of lambda_2 for a punch that its loads alone hold in place.

    Whatever the slip, the nodal forces of such a punch add up to the applied ones, `P0` and `+-lam Q1`. Coulomb's law added up over the nodes
    (scalar friction) then reads `lam |Q1| <= f P0`. The bound is attained where the shear and the pressure are spread alike.

    Parameters
    ----------
    f
        Coefficient of friction, the same at all nodes, dimensionless, not negative.
    P0
        Normal force of the mean load, compression positive, force per depth. The cyclic load adds none.
    Q1
        Tangential force of a corner of the cycle at load factor one, force per depth; the sign does not matter, the mean load has none.

    Returns
    -------
    float
        Dimensionless; inf for `Q1 = 0`.

    Raises
    ------
    ModelError
        A value that is not real and finite, negative friction, normal force not positive.

    References
    ----------
    G. Björkman and A. Klarbring (1987), shakedown and residual stresses in frictional systems: every kinematically admissible mechanism
    bounds lambda_2 from above; here it is the slip of the whole punch, to and fro.

    Examples
    --------
    >>> from frictopt.reference import gross_slip_bound
    >>> gross_slip_bound(f=0.5, P0=3.0, Q1=1.0)
    1.5
    """
    shear = abs(finite_number("Q1", Q1))
    bound = finite_number("f", f, least=0.0) * finite_number("P0", P0, above=0.0)
    return bound / shear if shear else float("inf")
