"""Joints: results for engineers.

The input is a contact with its load cycle and its friction. The results are:

- `report.py`: the report on a joint, and reports on its variants in one table. `report_pages.py`
  computes the answers of each part, `report_tables.py` makes their tables and numbers with units,
  `advice.py` the sentences, and `report_text.py` prints the report and writes the sheet to sign
- `safety.py`: the faces of a joint, safety factors and verdicts, from `scatter.py` (ranges of
  friction and preload) and `thresholds.py` (quantities that have limits, and the load that reaches
  a limit)
- `backbone.py`: work W, stiffness k and damping W / (2 pi k u^2) as functions of the amplitude u.
  `curve_question.py` has the load, its displacement, and the cycle at one load factor
- `forced_response.py`: amplitude as a function of the frequency of a harmonic force. `resonant.py`
  computes it from a backbone curve and a `modal_oscillator.py` (one mode, and what it leaves out)
- `tightening.py`: shortenings that give locked bolts their forces
- `archard.py`: wear by Archard's law, in jumps of many load cycles
- `end_of_wear.py`: the state in which wear ends, by a theorem
- `pictures.py`: pictures of all these
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
