"""A call of every public function with valid arguments.

A new function has a line here, and entries in the lists that the `__init__` of this folder names.
"""

import signal
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.transients.exact import ExactPath
from helpers.systems import CYCLE, FIRST_PAIR, of_mode, stresses_of, system

# Largest time of a call with an odd value, on a busy machine.
SECONDS = 10

CONTACT, UNCOUPLED_CONTACT = (
    system(*FIRST_PAIR),
    system(np.eye(2), np.zeros((2, 2)), 0.0, 1.0, 0.5, 0.0),
)
FRICTION, BONDED, SLIP = 0.6, (np.array([0.1, 0.1]), np.array([1.0, 1.0])), np.array([0.1, -0.1])
WORN = replace(CONTACT, width=[1.0, 2.0])
STRESSES = stresses_of(CONTACT)
TWO_LOADS = CONTACT.with_bonded({"other": BONDED})
REGION = fo.safe_region(TWO_LOADS, {"mean": 1.0}, ["cyclic", "other"], FRICTION)
DESIGN = fo.DesignModel(TWO_LOADS, CYCLE, preloads=["other"])
ASKED = {"system": CONTACT, "cycle": CYCLE, "friction": FRICTION}
STEADY = {**ASKED, "load_factor": 0.5}
SCENE = fo.scenes.PunchOnHalfPlane(elements=2, growth=3.0, block_half_width=3.0, block_depth=3.0)
MODEL = SCENE.model()
WEIGHTY = dict.fromkeys(("punch_material", "block_material"), fo.fem.Material(density=1.0))
HEAVY = fo.scenes.PunchOnHalfPlane(
    elements=2, growth=3.0, block_half_width=3.0, block_depth=3.0, **WEIGHTY
).model()
MODEL_3D = fo.scenes.SquarePunch(elements=2, growth=3.0).model()
NODE_3D = fo.ContactSystem(
    np.eye(3), [[0.0, 0.0, 0.0]], {"P": [0, 0, 1], "X": [1, 0, 0], "Y": [0, 1, 0]}
)
ASKED_3D = {
    "system": NODE_3D,
    "cycle": fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"Y": 1.0}]),
    "friction": 0.6,
}
SPLIT = MODEL.bodies["punch"].mesh.with_subdomains({"all": lambda x: x[1] > -1})
# These values may be nan. The error of the state is then infinite.
CLAIMED = dict.fromkeys(("v", "w", "q", "p", "previous_slip"), SLIP)
MODE = of_mode(CONTACT, CYCLE, 1.0)
CURVE = fo.joints.backbone_curve(MODE, CYCLE, FRICTION, [0.1, 0.2, 0.3], natural_frequency=1.0)
REPORT = fo.report(CONTACT, CYCLE, FRICTION, pages=1, progress=False)
STEP = fo.starts.LoadStep({"mean": 0.5})


BLOCKS, PLACED = (
    {"A": np.eye(2), "B": np.zeros((2, 2)), "C": np.eye(2)},
    {"gap": [0.1, 0.0], "contact": ["one", "two"]},
)
SPRINGS = {
    "pairs": [[0, 2], [1, 3]],
    "normals": [0.0, 1.0],
    "unknowns": [[0, 1], [2, 3], [-1, -1], [-1, -1]],
    "points": 2 * [[0.0, 0.0], [1.0, 0.0]],
}
FLAT = Path(__file__).parents[2] / "data" / "flat"
JOB = fo.readers.read_calculix(FLAT)


def condensed(scene):
    """Make the scene and condense it."""

    @wraps(scene)
    def made(**options):
        return scene(**options).condense()

    return made


BOLTED = fo.ContactSystem.from_blocks(
    [[1.0]],
    [[0.0]],
    [[40.0]],
    [0.0],
    {"bolt": ([0.0], [2.0]), "pull": ([0.0], [-1.0])},
    compliance=[[-0.2, 0], [0, 0]],
    bolts={"bolt": (2.0, 0.1)},
)


def call(function: Callable[..., Any], **good: Any) -> tuple[Callable[..., Any], dict[str, Any]]:
    """A public function, and good values of its arguments."""
    return function, good


CALLS = {
    "Body": call(fo.fem.Body, mesh=MODEL.bodies["punch"].mesh),
    "Contact": call(fo.fem.Contact, body_1="punch", body_2="block"),
    "BoltPreload": call(fo.fem.BoltPreload, body="punch", section="top", force=1.0),
    "BodyForce": call(fo.fem.BodyForce, body="punch", y=-1.0),
    "Centrifugal": call(fo.fem.Centrifugal, body="punch", density=1.0),
    "ContactModel.recover": call(
        MODEL.recover, loads={"P": 1.0}, slip=np.zeros(3), gap=np.zeros(3)
    ),
    "ContactModel.modes": call(HEAVY.modes, n=1, open_nodes=[True, False, False]),
    "ContactModel.with_loads": call(
        MODEL.with_loads, loads={"P": [fo.fem.Pressure("punch", "top")]}
    ),
    "Cyclic": call(
        fo.fem.Cyclic,
        body="punch",
        low="left",
        high="right",
        axis=(0.0, 0.0, 1.0),
        centre=(0.0, 0.0),
    ),
    "Displacement": call(fo.fem.Displacement, body="block", where="bottom", x=0.1, y=0.1),
    "DistributingCoupling": call(
        fo.fem.DistributingCoupling,
        body="punch",
        where="top",
        directions="xy",
        rotations="z",
        point=(0.0, 1.0),
    ),
    "Expansion": call(fo.fem.Expansion, body="punch"),
    "PointForce": call(fo.fem.PointForce, body="punch", where="top", x=1.0, y=1.0),
    "RemoteForce": call(
        fo.fem.RemoteForce,
        body="punch",
        where="top",
        x=1.0,
        y=1.0,
        z=0.0,
        moment=1.0,
        point=(0.0, 1.0),
    ),
    "RigidCoupling": call(
        fo.fem.RigidCoupling,
        body="punch",
        where="top",
        directions="xy",
        rotations="z",
        point=(0.0, 1.0),
    ),
    "PressFit": call(condensed(fo.scenes.PressFit), elements=2, growth=3.0),
    "Pressure": call(fo.fem.Pressure, body="punch", boundary="top"),
    "ContactModel": call(
        fo.fem.ContactModel,
        **{name: getattr(MODEL, name) for name in ("bodies", "supports", "loads", "contacts")},
    ),
    "ContactState": call(
        fo.ContactState, slip=[0.0, 0.0], gap=[0.0, 0.1], bonded_q=[0.0, 0.0], bonded_p=[1.0, 1.0]
    ),
    "Body in space": call(fo.fem.Body, mesh=MODEL_3D.bodies["punch"].mesh),
    "Support in space": call(fo.fem.Support, body="punch", where=(0.0, 0.0, 1.0)),
    "ContactModel in space": call(
        fo.fem.ContactModel,
        **{name: getattr(MODEL_3D, name) for name in ("bodies", "supports", "loads", "contacts")},
    ),
    "ContactSystem": call(
        fo.ContactSystem, S=np.eye(6), points=np.eye(3)[:2], bonded={"P": np.ones(6)}, **PLACED
    ),
    "NewtonIncrement": call(fo.increments.NewtonIncrement, system=NODE_3D, friction=FRICTION),
    "NewtonIncrement.solve": call(
        fo.increments.NewtonIncrement(NODE_3D, FRICTION).solve,
        slip=[[0.0, 0.0]],
        bonded=([[0.1, 0.1]], [1.0]),
    ),
    "SquarePunch": call(
        condensed(fo.scenes.SquarePunch),
        elements=2,
        growth=3.0,
        block_half_width=3.0,
        block_depth=3.0,
    ),
    "march 3D": call(
        fo.march, **ASKED_3D, load_factor=0.5, initial_slip=[[0.0, 0.1]], cycles=1, steps=2
    ),
    "ContactSystem.from_blocks": call(
        fo.ContactSystem.from_blocks,
        **BLOCKS,
        x=[0.0, 1.0],
        bonded={"mean": BONDED},
        **PLACED,
        E_star=1.0,
    ),
    "ContactSystem.reaction": call(CONTACT.reaction, loads={"mean": 1.0}),
    "ContactSystem.with_bonded": call(CONTACT.with_bonded, cases={"other": BONDED}),
    "ContactSystem.with_interference": call(CONTACT.with_interference, cases={"fit": [0.1, 0.0]}),
    "ContactSystem.with_gap": call(CONTACT.with_gap, gap=[0.0, 0.1]),
    "ContactProducts": call(
        fo.ContactProducts,
        points=CONTACT.points,
        bonded={"mean": BONDED, "cyclic": BONDED},
        pressing=CONTACT.B @ np.linalg.inv(CONTACT.A),
        slipping=np.linalg.inv(CONTACT.A),
        slides=np.zeros((2, 0)),
    ),
    "GuaranteedModel": call(fo.GuaranteedModel, system=CONTACT, cycle=CYCLE),
    "LoadStep": call(fo.starts.LoadStep, loads={"mean": 0.5}, cyclic={"cyclic": 1.0}),
    "LoadCycle": call(fo.LoadCycle, mean={"mean": 1.0}, corners=[{"cyclic": 1.0}]),
    "LoadCycle.from_history": call(
        fo.LoadCycle.from_history, history=pd.DataFrame({"cyclic": [0.0, 1.0]})
    ),
    "LoadCycle.vertices": call(
        lambda mean, loads: fo.LoadCycle.vertices(mean, loads),
        mean={"mean": 1.0},
        loads={"cyclic": (0.0, 1.0)},
    ),
    "Material": call(fo.fem.Material, density=1.0),
    "MatrixJob": call(fo.readers.MatrixJob, K=JOB.K, labels=JOB.labels, deck=JOB.deck),
    "MatrixJob.force": call(JOB.force, where="N_TOP", nodal=[1.0, 0.0]),
    "MatrixJob.areas": call(JOB.areas, face="N_TOP"),
    "MatrixJob.pairs": call(JOB.pairs, first="N_CONTACT_PUNCH", second="N_CONTACT_BLOCK"),
    "Dovetail": call(condensed(fo.scenes.Dovetail), elements=2, growth=3.0, grading=2.0),
    "PinInPlate": call(condensed(fo.scenes.PinInPlate), elements=8, growth=3.0),
    "PunchOnHalfPlane": call(
        condensed(fo.scenes.PunchOnHalfPlane),
        elements=2,
        growth=3.0,
        block_half_width=3.0,
        block_depth=3.0,
    ),
    "RoundedPunch": call(condensed(fo.scenes.RoundedPunch), punch=SCENE),
    "ShakedownModel": call(fo.ShakedownModel, system=CONTACT, cycle=CYCLE),
    "DesignModel": call(
        fo.DesignModel,
        system=TWO_LOADS,
        cycle=CYCLE,
        preloads=["other"],
        scenarios=[(CYCLE, FRICTION)],
    ),
    "DesignModel.solve": call(DESIGN.solve, friction=FRICTION, constraints=[DESIGN.preload <= 0.1]),
    "ShakedownModel.solve": call(fo.ShakedownModel(CONTACT, CYCLE).solve, friction=FRICTION),
    "condense": call(
        fo.condense, K=np.diag([2.0, 3.0, 2.0, 3.0]), loads={"P": [0.1, -1.0, 0.1, -1.0]}, **SPRINGS
    ),
    "split_bodies": call(fo.fem.split_bodies, mesh=SPLIT, materials={"all": fo.fem.Material()}),
    "Interference": call(fo.fem.Interference, contact="contact", amount=0.1),
    "Support": call(fo.fem.Support, body="punch", where="top"),
    "Tie": call(fo.fem.Tie, body_1="rib", body_2="plate", boundary_1="foot", boundary_2="top"),
    "Traction": call(fo.fem.Traction, body="punch", boundary="top", y=-1.0),
    "assembled_slip": call(fo.starts.assembled_slip, **ASKED),
    "dissipation_range": call(fo.dissipation_range, **ASKED, load_factor=0.1),
    "dissipation_study": call(
        fo.dissipation_study, **ASKED, load_factors=[0.5], starts=[SLIP], progress=False
    ),
    "guaranteed_limit": call(fo.guaranteed_limit, **ASKED),
    "march": call(fo.march, **ASKED, load_factor=0.5, cycles=1),
    "march in increments": call(fo.march, **ASKED, load_factor=0.5, cycles=1, steps=2),
    "limit_after_protocol": call(
        fo.limit_after_protocol,
        limit=fo.shakedown_limit(**ASKED),
        protocol=[STEP],
        start=SLIP,
        up_to=0.3,
        scan=3,
        tolerance=0.1,
    ),
    "friction_after_protocol": call(
        fo.friction_after_protocol,
        required=fo.required_friction(CONTACT, CYCLE, 0.3),
        protocol=[STEP],
        start=SLIP,
        up_to=1.0,
        scan=2,
        tolerance=0.1,
    ),
    "compare": call(fo.compare, reports={"one": REPORT, "two": REPORT}),
    "onset": call(fo.onset, **ASKED),
    "check_contact_law": call(
        fo.reference.check_contact_law,
        system=CONTACT,
        bonded=BONDED,
        friction=FRICTION,
        **CLAIMED,
        force_scale=1.0,
    ),
    "read_abaqus": call(fo.readers.read_abaqus, path="none"),
    "read_ansys": call(fo.readers.read_ansys, path="none"),
    "read_nastran": call(fo.readers.read_nastran, path="none"),
    "read_calculix": call(fo.readers.read_calculix, job=FLAT, deck=f"{FLAT}.inp"),
    "read_joint": call(fo.read_joint, path=f"{FLAT.parent}/block.inp", elastic=True),
    "read_mesh": call(fo.readers.read_mesh, path="none"),
    "read_store": call(fo.results.read_store, path="none"),
    "merge_stores": call(fo.results.merge_stores, into="all.sqlite", parts=[]),
    "SafeRegion.contains": call(REGION.contains, first=0.1, second=0.1),
    "required_friction": call(
        fo.required_friction, system=CONTACT, cycle=CYCLE, load_factor=0.1, slip_bound=None
    ),
    "safe_region": call(
        fo.safe_region,
        system=TWO_LOADS,
        mean={"mean": 1.0},
        loads=["cyclic", "other"],
        friction=FRICTION,
    ),
    "fatigue_band": call(
        fo.fatigue_band,
        stress_map=STRESSES,
        cycle=CYCLE,
        friction=FRICTION,
        load_factor=0.1,
        parameter="Findley",
        weight=0.2,
        planes=6,
    ),
    "fatigue_limit": call(
        fo.fatigue_limit,
        stress_map=STRESSES,
        cycle=CYCLE,
        friction=FRICTION,
        allowable=0.1,
        parameter="Findley",
        weight=0.2,
        every=True,
        planes=6,
    ),
    "FatigueBand.life": call(
        fo.fatigue_band(STRESSES, CYCLE, FRICTION, 0.1, planes=6).life,
        k_1=5.0,
        ND=1000000.0,
        SD=0.1,
    ),
    "FatigueBand.at": call(
        fo.fatigue_band(STRESSES, CYCLE, FRICTION, 0.1, planes=6).at, slip=[0.0, 0.0]
    ),
    "StressMap": call(
        fo.results.StressMap,
        system=CONTACT,
        points=STRESSES.points,
        loads=STRESSES.loads,
        motions=STRESSES.motions,
        on_face=True,
    ),
    "StressMap.tensors": call(STRESSES.tensors, loads={"mean": 1.0}, slip=SLIP, gap=np.abs(SLIP)),
    "ContactModel.stress_map": call(MODEL.stress_map, depth=0.5, side=2),
    "safe_slip": call(fo.safe_slip, **ASKED, load_factor=0.1),
    "gross_slip": call(fo.gross_slip, **ASKED),
    "tightened": call(
        fo.joints.tightened,
        system=BOLTED,
        cycle=fo.LoadCycle({"bolt": 1.0}, [{"pull": 0.1}]),
        friction=0.5,
    ),
    "report": call(
        fo.report,
        **ASKED,
        load_factors=[0.5],
        preload={"mean": (0.9, 1.1)},
        limits={"work": 1.0},
        life=pd.DataFrame({name: [1000000.0] for name in ("best", "assembled", "worst")}),
        title="A joint",
        pages=2,
        mesh_limits=True,
        notes="nothing",
    ),
    "shakedown_limit": call(fo.shakedown_limit, **ASKED),
    "steady_state": call(fo.steady_state, **ASKED, load_factor=0.5, most_cycles=50),
    "after_overload": call(fo.after_overload, limit=fo.guaranteed_limit(**ASKED), load_factor=0.5),
    "backbone_curve": call(
        fo.joints.backbone_curve,
        **ASKED | {"system": MODE},
        load_factors=[0.5],
        natural_frequency=1.0,
    ),
    "BackboneCurve.response": call(
        CURVE.response, forces=[0.1], damping=0.01, scale=2.0, other_modes=()
    ),
    "BackboneCurve.largest_force": call(
        CURVE.largest_force, amplitude=0.0001, damping=0.01, scale=2.0
    ),
    "Modes.force": call(
        HEAVY.modes(1).force, k=0, loads=[fo.fem.BodyForce("punch", y=1.0)], acceleration=[0.0, 1.0]
    ),
    "wear": call(
        fo.joints.wear, **(ASKED | {"system": WORN}), load_factor=0.9, coefficient=0.01, cycles=5
    ),
    "worn_in": call(fo.joints.worn_in, **(ASKED | {"system": UNCOUPLED_CONTACT}), load_factor=0.1),
    "ExactPath": call(ExactPath, **ASKED, load_factor=0.5),
    "Start": call(fo.starts.Start, family="given", name="one"),
    "SteadyState.fretting_table": call(
        fo.steady_state(**STEADY).fretting_table, stress=np.ones((1, 2)), strain=np.ones((1, 2))
    ),
    "given_slips": call(fo.starts.given_slips, slips=[SLIP]),
    "overloads": call(fo.starts.overloads, load_factors=[2.0]),
    "random_slips": call(fo.starts.random_slips, system=CONTACT, amplitudes=[1.0], count=1),
    "safe_slips": call(fo.starts.safe_slips),
    "plot_study": call(
        fo.plot_study, table=fo.dissipation_study(CONTACT, CYCLE, FRICTION, [0.5], progress=False)
    ),
}


class TooLong(BaseException):
    """A call that does not return."""


@contextmanager
def alarm():
    def ring(*_):
        raise TooLong

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
