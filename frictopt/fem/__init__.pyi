from .bodies import Body, split_bodies
from .bolts import BoltPreload
from .contacts import Contact, Interference, Tie
from .couplings import DistributingCoupling, RigidCoupling
from .elasticity import Material
from .loads import BodyForce, Centrifugal, Displacement, Expansion, Pressure, Traction
from .model import ContactModel
from .node_forces import PointForce, RemoteForce
from .sector import Cyclic
from .supports import Support

__all__ = [
    "Body",
    "BodyForce",
    "BoltPreload",
    "Centrifugal",
    "Contact",
    "ContactModel",
    "Cyclic",
    "Displacement",
    "DistributingCoupling",
    "Expansion",
    "Interference",
    "Material",
    "PointForce",
    "Pressure",
    "RemoteForce",
    "RigidCoupling",
    "Support",
    "Tie",
    "Traction",
    "split_bodies",
]
