"""Joints: results for engineers. No other room needs these files.

In come a contact, its load cycle and its friction. Out go:

- `report.py`: all answers about a joint, asked page by page in `report_pages.py`, from
  `report_tables.py` (the answers, and numbers with units) and `advice.py` (sentences);
  `report_text.py` prints and saves them; reports on variants of a joint in one table
- `safety.py`: the faces of a joint, safety factors and verdicts, from `scatter.py` (ranges of
  friction and preload), `thresholds.py` (what is judged) and `load_search.py` (the load that
  reaches a threshold)
- `backbone.py`: work W, stiffness k and damping W / (2 pi k u^2) over the amplitude u of the load,
  from `curve_question.py` (one load factor, and the displacement of the load)
- `forced_response.py`: amplitude over the frequency of a harmonic force, asked of a curve in
  `resonant.py`, from `modal_oscillator.py` (one mode, and what it leaves out)
- `tightening.py`: shortenings of locked bolts that give them their forces
- `wear.py`: wear by Archard's law, in jumps of load cycles
- `worn_in.py`: the end of wear by a theorem
- `pictures.py`: pictures of all these
"""
