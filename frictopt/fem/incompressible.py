"""Bodies whose Poisson's ratio is near 0.5: elements that lock, and matrices that lose digits."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import skfem

from ..errors import ModelError
from .bodies import Body
from .elasticity import Kinematics
from .mixed import MIXED


def locking(bodies: Mapping[str, Body], kinematics: Kinematics) -> Iterator[str]:
    """Warnings of bodies whose elements lock: they are too stiff, and limits are wrong.

    From nu = 0.49 on, linear triangles deform at least a tenth less than they should.
    """
    if kinematics == "plane_stress":
        return
    for name, body in bodies.items():
        nu = body.material.nu
        mesh = body.mesh
        # Triangles, tetrahedra and most wedges have one dilatation already.
        has_simplices = isinstance(mesh, (skfem.MeshTri1, skfem.MeshTet1, *MIXED))
        is_averaged = body.element == "mean_dilatation" and not has_simplices
        if nu >= 0.49 and body.element != "quadratic" and not is_averaged:
            yield (
                f"bodies[{name!r}]: nu = {nu!r} and element {body.element!r} on a "
                f"{type(mesh).__name__}, which locks near nu = 0.5: the body is too stiff, and "
                "limits are wrong; give it quadratic elements"
            )


@contextmanager
def naming_incompressible(bodies: Mapping[str, Body], kinematics: Kinematics) -> Iterator[None]:
    """Name bodies with nu next to 0.5 in an error of the elimination of their stiffness.

    The stiffness then consists of the resistance to a change of volume. The resistance to a change
    of shape, which supports and contacts feel, has few digits in it, or none.
    """
    try:
        yield
    except ModelError as error:
        for name, body in bodies.items():
            ratio = 1 / (1 - 2 * body.material.nu)
            if ratio > 1e6 and kinematics != "plane_stress":
                raise ModelError(
                    f"bodies[{name!r}]: nu = {body.material.nu!r} is too close to 0.5: its "
                    f"resistance to a change of volume is {ratio:.1e} times its resistance to a "
                    "change of shape, of which rounding leaves too few digits; take nu = 0.4999 "
                    f"and quadratic elements. Without these digits: {error}"
                ) from error
        raise
