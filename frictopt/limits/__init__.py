"""Limits of a load cycle as linear and cone programs: shakedown, safe slip, guaranteed limit, required friction, region, design, gross slip."""

from ..contact import LimitKind
from .design import DesignModel
from .design_result import Design
from .gross_slip import gross_slip
from .gross_slip_result import GrossSlip
from .guaranteed import GuaranteedModel, guaranteed_limit
from .guaranteed_result import GuaranteedLimit
from .least_slip import LeastSlip
from .required_friction import RequiredFriction, required_friction
from .safe_region import safe_region
from .safe_region_result import SafeRegion
from .safe_slip import SafeSlip, SafeSlipModel, safe_slip
from .safe_vertices import safe_vertices
from .shakedown import ShakedownModel, shakedown_limit
from .shakedown_result import ShakedownLimit
