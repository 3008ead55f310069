"""Draw a result: its picture in the look of a screen, with the units of the result."""

from collections.abc import Callable
from contextlib import nullcontext
from io import BytesIO
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from .style import AnyAxes, name_units, picture, screen


def draw(
    result: object,
    ax: AnyAxes = None,
    drawn_by: Callable[..., AnyAxes] = picture,
    **options: object,
) -> AnyAxes:
    """Draw a result in the given axes, which keep their style, or in a new figure.

    Returns the axes. `drawn_by` draws it: by default the picture that is registered for its class.

    Raises
    ------
    ModelError
        `ax` is not as many axes as the picture has panels.
    """
    with nullcontext() if ax is not None else screen():
        axes = drawn_by(result, ax, **options)
    name_units(np.ravel(np.asarray(axes, dtype=object))[0], _units(result))
    return axes


def png(result: Any) -> bytes:
    """The picture of a result as a PNG file; its figure is closed."""
    axes = np.ravel(np.asarray(result.plot(), dtype=object))
    figure = axes[0].figure
    file = BytesIO()
    figure.savefig(file, format="png")
    plt.close(figure)
    return file.getvalue()


def _units(result: object) -> str | None:
    """The units of a result, of its system or of a state in it; None if they are not known."""
    if hasattr(result, "attrs"):  # a table
        units: str | None = result.attrs.get("units")
        return units
    for name in ("units", "system", "least_state"):
        part = getattr(result, name, None)
        if part is not None:
            return part if isinstance(part, str) else _units(part)
    return None
