"""An answer of each kind to questions about a coupled pair of nodes, made once for all tests that
look at answers as such."""

from dataclasses import replace

import numpy as np

import frictopt as fo
from helpers.systems import CYCLE, FIRST_PAIR, system

PAIR = system(*FIRST_PAIR)
ASKED = PAIR, CYCLE, 0.6
TWO = PAIR.with_bonded({"other": (np.array([0.1, 0.1]), np.ones(2))})
FIRST = fo.onset(*ASKED)
LIMIT, LOWER, SAFE = (
    fo.shakedown_limit(*ASKED),
    fo.guaranteed_limit(*ASKED),
    fo.safe_slip(*ASKED, 0.3),
)
LEAST, CHECK, NEEDED = (
    LIMIT.least_slip(1.0),
    fo.verify(LOWER, starts=3, moved=1),
    fo.required_friction(PAIR, CYCLE, 0.3),
)
REGION = fo.safe_region(TWO, {"mean": 1.0}, ["cyclic", "other"], 0.6)
DESIGNS = fo.DesignModel(TWO, CYCLE, preloads=["other"], profile=True)
DRAWN = DESIGNS.solve(0.6, [DESIGNS.preload == 0.2, DESIGNS.profile == 0.1])
STEADY, PATH = fo.steady_state(*ASKED, 1.5), fo.march(*ASKED, 1.5, cycles=2)
SPAN = fo.dissipation_range(*ASKED, 0.8)
REST = fo.limit_after_protocol(
    *ASKED, scan=3, protocol=[fo.starts.LoadStep({"mean": 2.0}, {"cyclic": 1.0})]
)
CURED = fo.least_excursion(*ASKED, 0.6, excursion={"mean": -0.95})
WORN = fo.wear(replace(PAIR, width=[1.0, 1.0]), *ASKED[1:], 1.5, coefficient=0.01, cycles=1)
MOVED = fo.increments.ExactIncrement(PAIR, 0.6).solve(
    np.zeros(2), PAIR.reaction({"mean": 1.0, "cyclic": 1.0})
)
ANSWERS = [FIRST, FIRST.slip, LIMIT, LEAST, SAFE, LOWER, CHECK, DRAWN, NEEDED, REGION, MOVED]
ANSWERS += [STEADY, STEADY.state, PATH, PATH.verdict, SPAN, REST, CURED, WORN]
