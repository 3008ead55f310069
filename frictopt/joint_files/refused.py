"""Keywords of decks that are refused, each with a remedy, and keywords without effect."""

from ..errors import ModelError
from ..readers.deck import SLENDER
from ..readers.deck_text import Block
from ..readers.keywords import way_out, ways_out

_PLASTIC = "PLASTIC CYCLICHARDENING CREEP HYPERELASTIC HYPERFOAM USERMATERIAL MOHRCOULOMB "
_PLASTIC += "DEFORMATIONPLASTICITY"

# Keywords that are not needed for bodies and loads. If one is the procedure of a step, `left_out`
# lists the step.
WITHOUT_EFFECT = set(
    "HEADING PREPRINT RESTART MONITOR PHYSICALCONSTANTS ORIENTATION TIMEPOINTS CONTROLS DAMPING "
    "CONDUCTIVITY SPECIFICHEAT ASSEMBLY ENDSTEP ENDASSEMBLY SECTIONCONTROLS FREQUENCY DYNAMIC "
    "HEATTRANSFER".split()
)
OUTPUT = ("FILE", "PRINT", "OUTPUT")

_BY_HAND = "make the model in Python, with read_mesh and ContactModel"
FIT = "write ADJUST=0 in *CONTACT PAIR, and the overlap as *CLEARANCE, VALUE=-overlap"
"""How to write in a deck that meshes overlap by a fit."""

_REFUSED = ways_out(
    {
        "general contact names no pairs; write *CONTACT PAIR": "CONTACT CONTACTINCLUSIONS",
        FIT: "CONTACTINTERFERENCE CONTACTCLEARANCE",
        f"{_BY_HAND} and RigidCoupling": "EQUATION MPC",
        "write *COUPLING with *DISTRIBUTING": "DISTRIBUTINGCOUPLING",
        "write *COUPLING with *KINEMATIC": "KINEMATICCOUPLING",
        "mesh the parts as one body": "EMBEDDEDELEMENT",
        f"directions are global; {_BY_HAND}": "SOLIDSECTION,ORIENTATION",
        f"{_BY_HAND}, with solids in its place": "SPRING",
        "contacts have one type; take it out": "CHANGECONTACTTYPE",
        "give the loads themselves": "SUBMODEL",
        "write *TIE": "CONTACTPAIR,TIED",
        "contacts open; take it out": "SURFACEBEHAVIOR,NOSEPARATION",
        "give the coefficient alone": (
            "FRICTION,TAUMAX FRICTION,ANISOTROPIC FRICTION,EXPONENTIALDECAY FRICTION,USER"
        ),
        "give all bodies sectors of the same angle": "TIE,MULTISTAGE",
        "a bolt consists of solids; give its SURFACE": "PRE-TENSIONSECTION,ELEMENT",
        "give an isotropic material": (
            "ELASTIC,TYPE=ORTHO ELASTIC,TYPE=ANISO ELASTIC,TYPE=ENGINEERINGCONSTANTS "
            "EXPANSION,TYPE=ORTHO EXPANSION,TYPE=ANISO"
        ),
        "take it out": (
            "INITIALCONDITIONS,TYPE=STRESS INITIALCONDITIONS,TYPE=DISPLACEMENT "
            "INITIALCONDITIONS,TYPE=PLASTICSTRAIN"
        ),
        "list nodes and temperatures": "TEMPERATURE,FILE",
        "list nodes and forces": "CLOAD,USER CLOAD,SECTOR",
        "give displacements": "BOUNDARY,TYPE=VELOCITY BOUNDARY,TYPE=ACCELERATION",
        "give a table": (
            "AMPLITUDE,DEFINITION=PERIODIC AMPLITUDE,DEFINITION=SMOOTHSTEP "
            "AMPLITUDE,DEFINITION=MODULATED AMPLITUDE,DEFINITION=DECAY "
            "AMPLITUDE,DEFINITION=EQUALLYSPACED AMPLITUDE,DEFINITION=USER"
        ),
        "give multiples of the load": "AMPLITUDE,VALUE=ABSOLUTE",
        "shift the table itself": "AMPLITUDE,SHIFTX AMPLITUDE,SHIFTY",
        "bodies are elastic; take it out, or read with elastic=True": _PLASTIC,
    }
)
# Keywords of constants. With several lines they would vary, for example with the temperature.
_ONE_LINE = ("ELASTIC", "EXPANSION", "FRICTION", "DENSITY")


def check_not_refused(block: Block, *, elastic: bool) -> None:
    """Raise ModelError if a block is refused; with `elastic`, plasticity is allowed."""
    reason = way_out(block, _REFUSED)
    if elastic and block.keyword in _PLASTIC.split():
        reason = ""
    if block.keyword in _ONE_LINE and len(block.lines) != 1:
        reason = "give one line of constants"
    kind = block.parameters.get("TYPE", "")
    if block.keyword == "ELEMENT" and kind.startswith((*SLENDER, "SPRING", "DASHPOT", "GAP", "U")):
        reason = "bodies are solids, C3D, or plane, CPS, CPE, CAX; mesh it with those"
    if reason:
        raise ModelError(f"{block.title}: {reason}")
