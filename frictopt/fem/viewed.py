"""Models that can be turned around."""

from importlib import import_module
from typing import Any

from ..contact.result import Plotted


class Viewed(Plotted):
    """Base of models that PyVista shows."""

    def view(self, result: object = None, show: str = "von_mises", *, scale: float = 0.0, plotter: Any = None) -> Any:
        """The bodies, the faces of the contacts and a field on them as a scene of PyVista (extra `view`).

        `.show()` of what is returned opens a window, or in a notebook a view to turn with the mouse. `.screenshot("joint.png")` writes a picture;
        with `pyvista.OFF_SCREEN = True` it needs no screen.

        Parameters
        ----------
        result
            Fields that `recover` gave, or a steady state of the condensed model, at its last corner; None: the meshes, with the contacts in black.
        show
            Of the bodies "von_mises" or "displacement"; of the contacts, seen through the bodies, "pressure", "shear", "slip", "gap", and of a steady
            state "work_density", the work of friction per cycle and area. Of vectors the length.
        scale
            The bodies are drawn under so many times their displacements.
        plotter
            A pyvista.Plotter to draw in; None: a new one.

        Returns
        -------
        pyvista.Plotter

        Raises
        ------
        ImportError
            pyvista is not installed.
        ModelError
            A result of another kind or of another model, a field that it does not have, or no plotter.

        Examples
        --------
        >>> import frictopt as fo
        >>> model = fo.scenes.SquarePunch(elements=2, growth=3.0).model()
        >>> fields = model.recover({"P": 1.0, "Qx": 0.3}, slip=[[0.0, 0.0]] * 9)
        >>> view = model.view(fields, "pressure", scale=0.1)
        >>> list(view.scalar_bars.keys())
        ['pressure (force per area)']
        >>> view.close()
        """
        return import_module("frictopt.plots.views").view(self, result, show, scale, plotter)
