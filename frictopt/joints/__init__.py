"""Joints: what an engineer takes home. No other room needs these files.

`report.py` collects answers of all questions, `backbone.py` gives stiffness and damping over the
amplitude, `tightening.py` tightens bolts, `wear.py` and `worn_in.py` wear profiles down. Each file
has its result.
"""
