"""A call of each question of the page of questions, for a small contact.

A new question has a line here, and entries in the lists that the `__init__` of this folder names.
"""

import numpy as np

import frictopt as fo
from helpers.systems import CYCLE, of_mode, stresses_of

F = 0.6


def _deep_profile(contact):
    model = fo.DesignModel(contact, CYCLE, profile=True)
    return model.solve(F, [model.profile >= 0, model.profile <= 1])


def _curve(contact, lam, steps):
    """The backbone curve of a load, as if it were the load of a mode."""
    frequency = 0.5 / np.pi / np.sqrt(10.0)
    if contact.compliance is None:
        contact = of_mode(contact, CYCLE, frequency)
    factors = lam * np.array([0.3, 0.5, 0.7])
    return fo.joints.backbone_curve(
        contact, CYCLE, F, factors, natural_frequency=frequency, **steps
    )


ASKED = {
    "onset": lambda s, lam, steps: fo.onset(s, CYCLE, F),
    "shakedown_limit": lambda s, lam, steps: fo.shakedown_limit(s, CYCLE, F),
    "ShakedownLimit.least_slip": lambda s, lam, steps: fo.shakedown_limit(s, CYCLE, F).least_slip(
        1.2 * lam
    ),
    "guaranteed_limit": lambda s, lam, steps: fo.guaranteed_limit(s, CYCLE, F),
    "after_overload": lambda s, lam, steps: fo.after_overload(fo.guaranteed_limit(s, CYCLE, F)),
    "gross_slip": lambda s, lam, steps: fo.gross_slip(s, CYCLE, F),
    "safe_slip": lambda s, lam, steps: fo.safe_slip(s, CYCLE, F, 0.5 * lam),
    "required_friction": lambda s, lam, steps: fo.required_friction(s, CYCLE, 0.5 * lam),
    "safe_region": lambda s, lam, steps: fo.safe_region(
        s, {"mean": 1.0}, ["cyclic", [{"mean": 0.1}]], F
    ),
    "fatigue_band": lambda s, lam, steps: fo.fatigue_band(stresses_of(s), CYCLE, F, 0.5 * lam),
    "fatigue_limit": lambda s, lam, steps: fo.fatigue_limit(stresses_of(s), CYCLE, F, 0.1),
    "DesignModel.solve": lambda s, lam, steps: _deep_profile(s),
    "march": lambda s, lam, steps: fo.march(s, CYCLE, F, 1.2 * lam, cycles=1, **steps),
    "steady_state": lambda s, lam, steps: fo.steady_state(s, CYCLE, F, 1.2 * lam, **steps),
    "SteadyState.loop": lambda s, lam, steps: fo.steady_state(s, CYCLE, F, 1.2 * lam, **steps).loop(
        "cyclic"
    ),
    "SteadyState.by_contact": lambda s, lam, steps: fo.steady_state(
        s, CYCLE, F, 1.2 * lam, **steps
    ).by_contact(),
    "SteadyState.fretting_table": lambda s, lam, steps: fo.steady_state(
        s, CYCLE, F, 1.2 * lam, **steps
    ).fretting_table(),
    "dissipation_study": lambda s, lam, steps: fo.dissipation_study(
        s, CYCLE, F, [0.5 * lam], fo.starts.random_slips(s, [0.01], 1), progress=False
    ),
    "dissipation_range": lambda s, lam, steps: fo.dissipation_range(
        s, CYCLE, F, 0.5 * lam, **steps
    ),
    "backbone_curve": lambda s, lam, steps: fo.joints.backbone_curve(
        s, CYCLE, F, [0.5 * lam], **steps
    ),
    "BackboneCurve.response": lambda s, lam, steps: _curve(s, lam, steps).response(
        [0.1], damping=0.01
    ),
    "BackboneCurve.largest_force": lambda s, lam, steps: _curve(s, lam, steps).largest_force(
        amplitude=1e-6, damping=0.01
    ),
    "report": lambda s, lam, steps: fo.report(s, CYCLE, F, [0.5 * lam], **steps),
    "limit_after_protocol": lambda s, lam, steps: fo.limit_after_protocol(
        fo.shakedown_limit(s, CYCLE, F), scan=1, tolerance=0.5, **steps
    ),
    "friction_after_protocol": lambda s, lam, steps: fo.friction_after_protocol(
        fo.required_friction(s, CYCLE, 0.5 * lam), scan=1, tolerance=0.5, **steps
    ),
    "wear": lambda s, lam, steps: fo.joints.wear(
        s, CYCLE, F, 1.2 * lam, coefficient=1e-3, cycles=1, progress=False, **steps
    ),
    "starts.assembled_slip": lambda s, lam, steps: fo.starts.assembled_slip(s, CYCLE, F, **steps),
    "starts.random_slips": lambda s, lam, steps: fo.starts.random_slips(s, [0.01], 1),
}
