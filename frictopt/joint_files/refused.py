"""Keywords of decks that a joint cannot have, each with a way out, and keywords without effect."""

from ..errors import ModelError
from ..readers.deck_text import Block
from ..readers.element_types import SLENDER

PLASTIC = {"PLASTIC", "CYCLICHARDENING", "CREEP", "HYPERELASTIC", "HYPERFOAM", "USERMATERIAL"}
PLASTIC |= {"MOHRCOULOMB", "DEFORMATIONPLASTICITY"}

# Keywords of output, and others that the loads and the bodies do not need. Their steps are told.
WITHOUT_EFFECT = {"HEADING", "PREPRINT", "RESTART", "MONITOR", "PHYSICALCONSTANTS", "ORIENTATION"}
WITHOUT_EFFECT |= {"TIMEPOINTS", "CONTROLS", "DAMPING", "CONDUCTIVITY", "SPECIFICHEAT", "ASSEMBLY"}
WITHOUT_EFFECT |= {
    "ENDSTEP",
    "ENDASSEMBLY",
    "SECTIONCONTROLS",
    "FREQUENCY",
    "DYNAMIC",
    "HEATTRANSFER",
}
OUTPUT = ("FILE", "PRINT", "OUTPUT")

_BY_HAND = "make the model in Python, with read_mesh and ContactModel"
_NO_AXES = f"directions are global; {_BY_HAND}"
_CHANGES = "contacts are the same in all steps; write a deck for each set of contacts"

ALWAYS = {
    "CONTACT": "general contact names no pairs; write *CONTACT PAIR",
    "CONTACTINCLUSIONS": "general contact names no pairs; write *CONTACT PAIR",
    "EQUATION": f"{_BY_HAND} and RigidCoupling",
    "MPC": f"{_BY_HAND} and RigidCoupling",
    "DISTRIBUTINGCOUPLING": "write *COUPLING with *DISTRIBUTING",
    "KINEMATICCOUPLING": "write *COUPLING with *KINEMATIC",
    "EMBEDDEDELEMENT": "mesh the parts as one body",
    "TRANSFORM": _NO_AXES,
    "SPRING": f"{_BY_HAND}, with solids in its place",
    "CHANGESURFACEBEHAVIOR": _CHANGES,
    "CHANGECONTACTTYPE": _CHANGES,
    "SUBMODEL": "give the loads themselves",
    **dict.fromkeys(PLASTIC, "bodies are elastic; take it out, or read with elastic=True"),
}
"""Keyword -> why it is refused."""
PARAMETERS = (
    ("TIE", "MULTISTAGE", (), "give all bodies sectors of the same angle"),
    ("SOLIDSECTION", "ORIENTATION", (), _NO_AXES),
    ("PRE-TENSIONSECTION", "ELEMENT", (), "a bolt consists of solids; give its SURFACE"),
    ("TEMPERATURE", "FILE", (), "list nodes and temperatures"),
    ("CLOAD", "USER", (), "list nodes and forces"),
    ("CLOAD", "SECTOR", (), "list nodes and forces"),
    ("AMPLITUDE", "DEFINITION", ("PERIODIC", "SMOOTHSTEP", "MODULATED", "DECAY"), "give a table"),
    ("ELASTIC", "TYPE", ("ORTHO", "ANISO", "ENGINEERINGCONSTANTS"), "give an isotropic material"),
    ("EXPANSION", "TYPE", ("ORTHO", "ANISO"), "give an isotropic material"),
    ("INITIALCONDITIONS", "TYPE", ("STRESS", "DISPLACEMENT", "PLASTICSTRAIN"), "take it out"),
)
"""Keyword, parameter, its values that are refused (without any: all), and a way out."""
ONE_LINE = ("ELASTIC", "EXPANSION", "FRICTION")
"""Keywords of constants: several lines make them depend on something."""


def check_not_refused(block: Block, *, elastic: bool) -> None:
    """ModelError if a joint cannot have a block; `elastic` bodies pass over plasticity."""
    reason = ALWAYS.get(block.keyword, "")
    if elastic and block.keyword in PLASTIC:
        reason = ""
    for keyword, parameter, values, remedy in PARAMETERS:
        value = "".join(block.parameters.get(parameter, "").split())
        if keyword == block.keyword and parameter in block.parameters:
            reason = remedy if not values or value in values else reason
    if block.keyword in ONE_LINE and len(block.lines) != 1:
        reason = "give one line of constants"
    kind = block.parameters.get("TYPE", "")
    if block.keyword == "ELEMENT" and kind.startswith((*SLENDER, "SPRING", "DASHPOT", "GAP", "U")):
        reason = "bodies are solids, C3D, or plane, CPS, CPE, CAX; mesh it with those"
    if reason:
        raise ModelError(f"{block.title}: {reason}")
