from .margin import SafeSlip3D
from .shakedown import ShakedownLimit3D

__all__ = [
    "SafeSlip3D",
    "ShakedownLimit3D",
]
