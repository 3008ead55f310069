from .bodies import Body3D, BodyForce3D, Support3D, Traction3D
from .increment import Increment3D, Increments3D
from .margin import SafeSlip3D
from .model import ContactModel3D
from .shakedown import ShakedownLimit3D
from .steady import SteadyState3D
from .trajectory import Trajectory3D

__all__ = [
    "Body3D",
    "BodyForce3D",
    "ContactModel3D",
    "Increment3D",
    "Increments3D",
    "SafeSlip3D",
    "ShakedownLimit3D",
    "SteadyState3D",
    "Support3D",
    "Traction3D",
    "Trajectory3D",
]
