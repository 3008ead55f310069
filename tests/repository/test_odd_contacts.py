"""Every public question asked of odd contacts: an answer, or an error of the package, and nothing
else.

The contacts are random and odd on purpose: bodies that nothing holds, rigid bodies, no normal
stiffness, no pressure, one node, two contact names.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.public_names.asked import ASKED
from helpers.public_names.called import CALLS

SEEDS = [
    44,
    125,
    *few(range(6)),
]  # the first two are a free body with two names, and one without normal stiffness but for rounding
LOADS = ("mean", "cyclic", "other")
QUESTIONS = [name for name, (_, good) in CALLS.items() if "system" in good]
SHAPED_LIKE_SLIP = {"slip", "initial_slip", "start", "v", "q", "previous_slip"}
SHAPED_LIKE_GAP = {"w", "p"}


def rigid_motions(points):
    """(M, m) the motions of a rigid body: slips along the tangents, and the opening of each
    node."""
    n, axes = points.shape
    shifts = np.kron(np.eye(axes), np.ones((n, 1)))
    if axes == 2:
        return np.column_stack([shifts, np.r_[np.zeros(n), points[:, 0]]])
    x, y, none = points[:, 0], points[:, 1], np.zeros(n)
    return np.column_stack([shifts, np.r_[-y, x, none], np.r_[none, none, x], np.r_[none, none, y]])


def stiffness(rng, points):
    """(M, M) a stiffness of one of several odd kinds."""
    n, axes = points.shape
    size = n * axes
    root = rng.normal(size=(size, size))
    S = root @ root.T / size + 0.1 * np.eye(size)
    basis, sizes, _ = np.linalg.svd(rigid_motions(points), full_matrices=False)
    basis = basis[:, sizes > 1e-9]
    kind = rng.choice(
        ["held", "floating", "slides", "lifts", "rigid", "no normal stiffness", "none", "uncoupled"]
    )
    free = np.eye(size) - basis @ basis.T
    shift = np.r_[np.ones(n), np.zeros(size - n)]
    lift = np.r_[np.zeros(size - n), np.ones(n)]
    if kind == "floating":
        return free @ S @ free
    if kind in ("slides", "lifts"):
        motion = (shift if kind == "slides" else lift) / np.sqrt(n)
        without = np.eye(size) - np.outer(motion, motion)
        return without @ S @ without
    if kind == "rigid":
        return free
    if kind == "no normal stiffness":
        S[-n:] = 0.0
        S[:, -n:] = 0.0
    if kind == "none":
        return np.zeros((size, size))
    if kind == "uncoupled":
        return np.diag(rng.choice([0.0, 1.0], size))
    return S


def odd_contact(seed):
    """A contact with the load cases of LOADS, its load cycle, friction and load factor."""
    rng = np.random.default_rng(seed)
    n, axes = int(rng.integers(1, 5)), int(rng.integers(2, 4))
    points = np.zeros((n, axes))
    points[:, 0] = np.arange(n)
    if axes == 3 and rng.random() < 0.5:
        points[:, 1] = rng.integers(0, 2, n)
    bonded = {}
    for name in LOADS:
        shear = rng.normal(size=n * (axes - 1)) * rng.choice([0.0, 1.0])
        bonded[name] = np.r_[shear, 0.3 * rng.normal(size=n) * rng.choice([0.0, 1.0])]
    pressure = rng.uniform(0.2, 1.5, n) * rng.choice([0.0, 1.0], p=[0.2, 0.8])
    if rng.random() < 0.2:
        pressure[rng.integers(n)] *= -1.0
    bonded["mean"][-n:] = pressure
    gap = rng.choice([0.0, 0.5], n) if rng.random() < 0.4 else np.zeros(n)
    names = [None, ["a"] * n, ["a", *["b"] * (n - 1)]][rng.integers(3)]
    width = np.ones(n) if rng.random() < 0.5 else None
    compliance = 2.0 * np.eye(len(LOADS)) if rng.random() < 0.5 else None
    system = fo.ContactSystem(
        stiffness(rng, points),
        points,
        bonded,
        gap=gap,
        contact=names,
        width=width,
        compliance=compliance,
    )
    corners = [
        [{"cyclic": 1.0}, {"cyclic": -1.0}],
        [{"cyclic": 1.0}],
        [{"cyclic": 1.0, "mean": -0.5}, {"other": 1.0}, {}],
    ][rng.integers(3)]
    fixed = [{"other": float(k)} for k in range(len(corners))] if rng.random() < 0.2 else None
    friction = [0.0, 0.5, 2.0, rng.choice([0.0, 0.6], n)][rng.integers(4)]
    return (
        system,
        fo.LoadCycle({"mean": 1.0}, corners, fixed=fixed),
        friction,
        float(rng.choice([0.0, 0.1, 1.0, 10.0])),
    )


def arguments(name, system, cycle, friction, load_factor):
    """The good arguments of a question, with those of an odd contact in their place."""
    given = dict(CALLS[name][1])
    slip, gap = np.zeros(system.slip_shape), np.zeros(system.nodes)
    odd = {
        "system": system,
        "cycle": cycle,
        "friction": friction,
        "load_factor": load_factor,
        "load_factors": [load_factor + 0.1],
    }
    odd |= dict.fromkeys(SHAPED_LIKE_SLIP, slip) | dict.fromkeys(SHAPED_LIKE_GAP, gap)
    odd |= {
        "starts": [slip],
        "directions": [slip + 1.0],
        "bonded": system.reaction({"mean": 1.0, "cyclic": load_factor}),
    }
    given |= {argument: value for argument, value in odd.items() if argument in given}
    if "steps" in given or (
        system.tangents == 2
        and name in ("steady_state", "backbone_curve", "report", "wear", "dissipation_range")
    ):
        given["steps"] = 2
    return given


def asked(name, seed):
    """The answer of a question, or of a method of an answer, to the odd contact of a seed, with its
    texts and tables."""
    system, cycle, friction, load_factor = odd_contact(seed)
    if name not in QUESTIONS:
        answer = ASKED[name](
            system, load_factor or 1.0, {"steps": 2} if system.tangents == 2 else {}
        )
    else:
        answer = CALLS[name][0](**arguments(name, system, cycle, friction, load_factor))
    for way in ("__repr__", "to_frame", "explain"):
        if callable(getattr(answer, way, None)) and not isinstance(answer, type):
            getattr(answer, way)()


@pytest.mark.filterwarnings("ignore::frictopt.ModelWarning")
@pytest.mark.usefixtures("few_starts")
@pytest.mark.parametrize("name", [*QUESTIONS, *(name for name in ASKED if name not in QUESTIONS)])
def test_an_odd_contact_gives_an_answer_or_an_error_of_ours(name):
    for seed in SEEDS:
        try:
            asked(name, seed)
        except fo.FrictoptError:
            pass
