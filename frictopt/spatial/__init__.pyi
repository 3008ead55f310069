from .bodies import Body3D, BodyForce3D, Support3D, Traction3D
from .margin import SafeSlip3D
from .model import ContactModel3D
from .shakedown import ShakedownLimit3D

__all__ = [
    "Body3D",
    "BodyForce3D",
    "ContactModel3D",
    "SafeSlip3D",
    "ShakedownLimit3D",
    "Support3D",
    "Traction3D",
]
