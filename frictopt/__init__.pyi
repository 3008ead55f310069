from . import reference as reference
from . import scenes as scenes
from .contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
)
from .contact.result import Outcome
from .errors import FrictoptError, ModelError, ModelWarning, NoContinuation, SolverError, StoreError
from .fem.bodies import Body, split_bodies
from .fem.bolts import BoltPreload
from .fem.condense import condense
from .fem.contacts import Contact, Interference
from .fem.cyclic import Cyclic
from .fem.elasticity import Material
from .fem.loads import BodyForce, Centrifugal, Displacement, Expansion, Pressure, Traction
from .fem.matrices.ansys_nastran import read_ansys, read_nastran
from .fem.matrices.calculix_abaqus import read_abaqus, read_calculix
from .fem.matrices.job import MatrixJob
from .fem.matrices.labelled import modal_load
from .fem.matrices.meshes import read_mesh
from .fem.model import ContactModel
from .fem.paraview import write_paraview
from .fem.supports import Support
from .histories import results, starts
from .histories.backbone import backbone_curve
from .histories.dissipation import dissipation_study
from .histories.dissipation_range import dissipation_range
from .histories.excursion import least_excursion
from .histories.protocols import limit_after_protocol
from .histories.report import report
from .histories.tightening import tightened
from .histories.wear import wear
from .histories.worn_in import worn_in
from .limits import (
    DesignModel,
    GuaranteedModel,
    LimitKind,
    SafeSlipModel,
    ShakedownModel,
    gross_slip,
    guaranteed_limit,
    required_friction,
    safe_region,
    safe_slip,
    shakedown_limit,
)
from .plots import plot_study
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
    "Pressure",
    "SafeSlipModel",
    "ShakedownModel",
    "SolverError",
    "StoreError",
    "Support",
    "Traction",
    "backbone_curve",
    "condense",
    "dissipation_range",
    "dissipation_study",
    "gross_slip",
    "guaranteed_limit",
    "increments",
    "least_excursion",
    "limit_after_protocol",
    "march",
    "modal_load",
    "onset",
    "plot_study",
    "read_abaqus",
    "read_ansys",
    "read_calculix",
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
