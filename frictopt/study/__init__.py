"""Studies of many transients.

In come ranges of friction, load factors and starts (`starts.py`); out goes a table of steady states
(`dissipation.py`, its runs in `runs.py`, kept by `store.py`, described in files by `plans.py`).
`dissipation_range.py` and `range_search.py` search the range of the work, `protocols.py` and
`excursion.py` vary the loads before, `verify.py` and `after_overload.py` test guaranteed limits. A
new column of a study stands in `runs.py`.
"""

from . import starts as starts
