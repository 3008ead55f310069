"""An answer of each kind to questions about a coupled pair of nodes.

The answers are for all tests of properties that answers share. An answer is computed when a test
first requests it, and is then kept.
"""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.stats import lognorm

import frictopt as fo
from helpers.systems import CYCLE, FIRST_PAIR, stresses_of, system

PAIR = system(*FIRST_PAIR)
ASKED = PAIR, CYCLE, 0.6
TWO = PAIR.with_bonded({"other": (np.array([0.1, 0.1]), np.ones(2))})


def design():
    """The limit of a preload and a profile that constraints prescribe."""
    model = fo.DesignModel(TWO, CYCLE, preloads=["other"], profile=True)
    return model.solve(0.6, [model.preload == 0.2, model.profile == 0.1])


QUESTIONS = {
    "Onset": lambda: fo.onset(*ASKED),
    "OnsetEvent": lambda: answer("Onset").slip,
    "ShakedownLimit": lambda: fo.shakedown_limit(*ASKED),
    "ShakedownProbability": lambda: answer("ShakedownLimit").probability(
        friction=lognorm(0.1, scale=0.6), draws=10
    ),
    "Comparison": lambda: fo.compare(
        {str(f): fo.report(PAIR, CYCLE, f, pages=1) for f in (0.5, 0.6)}
    ),
    "LeastSlip": lambda: answer("ShakedownLimit").least_slip(1.0),
    "SafeSlip": lambda: fo.safe_slip(*ASKED, 0.3),
    "GuaranteedLimit": lambda: fo.guaranteed_limit(*ASKED),
    "Design": design,
    "RequiredFriction": lambda: fo.required_friction(PAIR, CYCLE, 0.3),
    "SafeRegion": lambda: fo.safe_region(TWO, {"mean": 1.0}, ["cyclic", "other"], 0.6),
    "FatigueBand": lambda: fo.fatigue_band(stresses_of(PAIR), CYCLE, 0.6, 0.3, planes=6),
    "FatigueLimit": lambda: fo.fatigue_limit(stresses_of(PAIR), CYCLE, 0.6, 0.1, planes=6),
    "Increment": lambda: fo.increments.NewtonIncrement(PAIR, 0.6).solve(
        np.zeros(2), PAIR.reaction({"mean": 1.0, "cyclic": 1.0}), form="milp"
    ),
    "SteadyState": lambda: fo.steady_state(*ASKED, 1.5),
    "ContactState": lambda: answer("SteadyState").state,
    "Trajectory": lambda: fo.march(*ASKED, 1.5, cycles=2),
    "Verdict": lambda: answer("Trajectory").verdict,
    "DissipationRange": lambda: fo.dissipation_range(*ASKED, 0.8),
    "LimitAfterProtocol": lambda: fo.limit_after_protocol(
        answer("ShakedownLimit"),
        scan=3,
        protocol=[fo.starts.LoadStep({"mean": 2.0}, {"cyclic": 1.0})],
    ),
    "FrictionAfterProtocol": lambda: fo.friction_after_protocol(
        fo.required_friction(PAIR, CYCLE, 0.3), scan=3
    ),
    "WearHistory": lambda: fo.joints.wear(
        replace(PAIR, width=[1.0, 1.0]), *ASKED[1:], 1.5, coefficient=0.01, cycles=1
    ),
}


@cache
def answer(kind):
    """The answer of this kind."""
    return QUESTIONS[kind]()
