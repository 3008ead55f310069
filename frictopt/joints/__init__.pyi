from .archard import wear
from .backbone import backbone_curve
from .end_of_wear import worn_in
from .tightening import tightened

__all__ = [
    "backbone_curve",
    "tightened",
    "wear",
    "worn_in",
]
