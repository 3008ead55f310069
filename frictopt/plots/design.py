"""Pictures of a best design: its profile, and how far each node is from slip with it."""

import numpy as np
from matplotlib.axes import Axes

from ..limits import Design
from .along import friction_ratio, label_contacts, lines
from .picture import picture
from .spatial import safe_slip_face
from .style import ALONG, BLACK, GREY, AxesArray, equals, legend, new_axes, one_axes

_SHOWN = 4  # preloads in a title


@picture.register
def _design(design: Design, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip, below the profile where the faces were free.

    In space, at the corner with the least reserve, with the slip as arrows.
    """
    amounts = [f"{name} {amount:+.4g}" for name, amount in design.preload.items()]
    title = equals(r"best design, $\lambda$", design.load_factor) + "".join(f", {amount}" for amount in amounts[:_SHOWN])
    title += ", ..." if len(amounts) > _SHOWN else ""
    if design.system.tangents == 2:
        return safe_slip_face(one_axes(ax, 2), design, title)
    shaped = design.profile is not None
    *above, axes = panels = new_axes(ax, 1 + shaped, (ALONG[0], (1 + shaped) * ALONG[1]))
    panels[0].set_title(title)
    q, p = design.reactions
    friction_ratio(axes, design.system, design.friction, q, p, design.cycle.corner_names, list(range(len(q))))
    legend(axes)
    if design.profile is None:
        return axes
    above[0].axhline(0, color=GREY, lw=0.6, zorder=0)
    lines(above[0], design.system, design.profile, color=BLACK, marker=".", markersize=3)
    above[0].set_ylabel("material taken off (length)")
    label_contacts(above[0], design.system)
    above[0].set_xlabel("")
    return np.array(panels)
