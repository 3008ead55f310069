from . import reference as reference
from . import results as results
from . import scenes as scenes
from .base import LimitKind, Outcome
from .contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
)
from .errors import FrictoptError, ModelError, ModelWarning, NoContinuation, SolverError, StoreError
from .fem.bodies import Body, split_bodies
from .fem.bolts import BoltPreload
from .fem.condense import condense
from .fem.contacts import Contact, Interference
from .fem.couplings import DistributingCoupling, RigidCoupling
from .fem.cyclic import Cyclic
from .fem.elasticity import Material
from .fem.loads import BodyForce, Centrifugal, Displacement, Expansion, Pressure, Traction
from .fem.model import ContactModel
from .fem.node_forces import PointForce, RemoteForce
from .fem.paraview import write_paraview
from .fem.supports import Support
from .fem.ties import Tie
from .joint_files.read_joint import read_joint
from .joints.backbone import backbone_curve
from .joints.report import report
from .joints.tightening import tightened
from .joints.wear import wear
from .joints.worn_in import worn_in
from .limits import (
    DesignModel,
    GuaranteedModel,
    SafeSlipModel,
    ShakedownModel,
    fatigue_band,
    fatigue_limit,
    gross_slip,
    guaranteed_limit,
    required_friction,
    safe_region,
    safe_slip,
    shakedown_limit,
)
from .readers.ansys_nastran import read_ansys, read_nastran
from .readers.calculix_abaqus import read_abaqus, read_calculix
from .readers.job import MatrixJob
from .readers.labelled import modal_load
from .readers.meshes import read_mesh
from .study import starts
from .study.after_overload import after_overload
from .study.dissipation import dissipation_study
from .study.dissipation_range import dissipation_range
from .study.plot_study import plot_study
from .study.protocols import friction_after_protocol, limit_after_protocol
from .transients import (
    increments,
    march,
    onset,
    steady_state,
)

__version__: str

__all__ = [
    "Body",
    "BodyForce",
    "BoltPreload",
    "Centrifugal",
    "Contact",
    "ContactModel",
    "ContactState",
    "ContactSystem",
    "Cyclic",
    "DesignModel",
    "Displacement",
    "DistributingCoupling",
    "Expansion",
    "FrictoptError",
    "GuaranteedModel",
    "Interference",
    "LimitKind",
    "LoadCycle",
    "Material",
    "MatrixJob",
    "ModelError",
    "ModelWarning",
    "NoContinuation",
    "Outcome",
    "PointForce",
    "Pressure",
    "RemoteForce",
    "RigidCoupling",
    "SafeSlipModel",
    "ShakedownModel",
    "SolverError",
    "StoreError",
    "Support",
    "Tie",
    "Traction",
    "after_overload",
    "backbone_curve",
    "condense",
    "dissipation_range",
    "dissipation_study",
    "fatigue_band",
    "fatigue_limit",
    "friction_after_protocol",
    "gross_slip",
    "guaranteed_limit",
    "increments",
    "limit_after_protocol",
    "march",
    "modal_load",
    "onset",
    "plot_study",
    "read_abaqus",
    "read_ansys",
    "read_calculix",
    "read_joint",
    "read_mesh",
    "read_nastran",
    "reference",
    "report",
    "required_friction",
    "results",
    "safe_region",
    "safe_slip",
    "scenes",
    "shakedown_limit",
    "split_bodies",
    "starts",
    "steady_state",
    "tightened",
    "wear",
    "worn_in",
    "write_paraview",
]
