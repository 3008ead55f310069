"""Run times of the first call, and of a second call on the same model."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from ...clock import timed
from ...paper import LOADS
from .parameters import Parameters


def first_and_second(parameters: Parameters) -> pd.DataFrame:
    """One row per call on each mesh of the paper's scene, from the mesh to the solved problem."""
    return pd.DataFrame([row for elements in parameters.elements for row in _rows(parameters, elements)])


def _rows(parameters: Parameters, elements: int) -> Iterator[dict[str, Any]]:
    scene = fo.scenes.PunchOnHalfPlane(elements=elements)
    model = scene.model()
    system, friction = model.condense(), parameters.friction
    factor = parameters.overload * fo.shakedown_limit(system, LOADS, friction).load_factor
    corner = system.reaction({"P": LOADS.mean["P"], "sigma": factor * LOADS.corners[0]["sigma"]})

    def row(call: str, first: Callable[[], Any], second: Callable[[], Any] | None = None) -> dict[str, Any]:
        made = timed(first, parameters.repetitions)
        again = timed(second, parameters.repetitions).seconds if second else np.nan
        residual = getattr(made.answer, "residual", np.nan)
        return {"nodes": system.nodes, "call": call, "first": made.seconds, "second": again, "residual": residual}

    def solved(call: str, build: Callable[[], Any], *question: Any) -> dict[str, Any]:
        built = build()
        built.solve(*question)
        return row(call, lambda: build().solve(*question), lambda: built.solve(*question))

    yield row("mesh, supports, load cases", scene.model)
    yield row("assembly and condensation", model.condense)
    yield solved("lambda_2", partial(fo.ShakedownModel, system, LOADS), friction)
    yield solved("lambda_1", partial(fo.GuaranteedModel, system, LOADS), parameters.guaranteed_friction)
    yield solved("increment, frozen bounds (QP)", partial(fo.increments.FrozenBoundIncrement, system, friction), np.zeros(system.nodes), corner)
