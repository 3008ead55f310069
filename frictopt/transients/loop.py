"""The loop of a load case: its amplitude against its displacement."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..contact import Array, Integers, Plotted, Shown, Table, frame


@dataclass(frozen=True, eq=False, repr=False)
class LoadLoop(Shown, Plotted):
    """Amplitude and displacement of one load case at T states: after each event of the exact path, after each increment.

    On the exact path both are linear between the states, and the loop is exact.

    Attributes
    ----------
    case
        Name of the load case.
    amplitude, displacement
        (T,) its amplitude, and its displacement, whose product with the amplitude is work, see `ContactSystem.displacements`.
    slipping
        (T,) number of nodes that slip: until the next event (path), or over the increment that ends here.
    area
        Area of the loop, force times length (per depth): the work that the load case does over these states. Over a steady cycle the areas of all
        load cases add up to the work of friction; where one load case alone varies, its area is that work. In increments they fall short of it, by
        nodes that slip in a part of an increment only, and the work is the better of the two; with more `steps` both come together.
    stiffness
        Secant stiffness: range of the amplitude over that of the displacement; inf where nothing moves.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0), compliance=[[0, 0], [0, 0]])
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> loop = steady.loop("force")
    >>> round(loop.area, 9), round(steady.dissipation, 9), round(loop.stiffness, 9)  # the force moves its node by 0.5 either way
    (1.0, 1.0, 2.0)
    """

    case: str
    amplitude: Array
    displacement: Array
    slipping: Integers

    @property
    def area(self) -> float:
        """Area of the loop, see `LoadLoop`."""
        mean = (self.amplitude[1:] + self.amplitude[:-1]) / 2
        return float(mean @ np.diff(self.displacement))

    @property
    def stiffness(self) -> float:
        """Secant stiffness, see `LoadLoop`."""
        way = np.ptp(self.displacement)
        return float(np.ptp(self.amplitude) / way) if way > 0 else np.inf

    def to_frame(self) -> Table:
        """The DataFrame of the states: columns amplitude, displacement, slipping."""
        return frame({name: getattr(self, name) for name in ("amplitude", "displacement", "slipping")})

    def _answer(self) -> Mapping[str, object]:
        return {"case": self.case, "states": len(self.amplitude), "area": self.area, "stiffness": self.stiffness}
