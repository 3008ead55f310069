from . import exact as exact
from . import increments as increments
from .fretting import fretting_table, steady_cycle
from .increments import ComplementarityProblem, ExactIncrement, FrozenBoundIncrement, Increment, complementarity_problem
from .increments.increments import Increment3D, Increments3D
from .march import march
from .outcome import SteadyState
from .steady import steady_state
from .stepped.steady import SteadyState3D
from .stepped.trajectory import Trajectory3D
from .trajectory import Trajectory

__all__ = [
    "ComplementarityProblem",
    "ExactIncrement",
    "FrozenBoundIncrement",
    "Increment",
    "Increment3D",
    "Increments3D",
    "SteadyState",
    "SteadyState3D",
    "Trajectory",
    "Trajectory3D",
    "complementarity_problem",
    "exact",
    "fretting_table",
    "increments",
    "march",
    "steady_cycle",
    "steady_state",
]
