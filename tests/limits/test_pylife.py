"""pyLife reads the table of a fatigue band, as the page of questions says."""

from pathlib import Path

import numpy as np
import pytest

import frictopt as fo

QUESTIONS = Path(__file__).parents[2] / "docs" / "faq.md"


def test_the_code_of_the_page_has_the_lives_of_both_ends_by_goodman_and_basquin():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    stresses = model.stress_map(depth=0.3, side=2)
    band = fo.fatigue_band(stresses, cycle, 0.7, load_factor=0.8)
    (code,) = (
        part.partition("```")[0]
        for part in QUESTIONS.read_text(encoding="utf-8").split("```python\n")
        if "pylife" in part.partition("```")[0]
    )
    page = {"band": band}
    exec(code, page)
    table = band.to_frame()
    for end in ("least", "most"):
        low, high = table[f"from_{end}"], table[f"to_{end}"]
        # The Haigh diagram falls by 0.3 between R = -inf and 0, by 0.1 up to R = 0.5, and is level
        # below R = -inf.
        amplitude, mean = (high - low) / 2, (high + low) / 2
        alike = amplitude + 0.3 * np.clip(mean, -amplitude, amplitude)
        above = np.clip(mean, amplitude, 3 * amplitude)
        alike = np.where(mean > amplitude, 1.3 * (amplitude + 0.1 * above) / 1.1, alike)
        lives = np.where(alike >= 0.4, 2e6 * (alike / 0.4) ** -5.0, np.inf)
        assert np.asarray(page["cycles"][end]) == pytest.approx(lives, rel=1e-9)
    assert np.isfinite(page["cycles"]["most"]).any()
    assert (page["cycles"]["most"] <= page["cycles"]["least"]).all()
