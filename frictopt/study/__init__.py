"""Studies of many transients.

The steady state of a contact depends on its start. A study follows transients from many residual
slips v to their steady cycles, each with its work of friction W >= 0.

A contact, load cycles, frictions, load factors and starts come in. Tables of steady states, the
range of W over the starts, and the loads up to which a contact comes to rest (W = 0) go out.

A table of many runs (`dissipation_study`):

- `starts.py`: starts, such as residual slips, overloads and load steps
- `case.py`: one run, its key (a digest of its content), and the list of the columns of the table
- `runs.py`: follows the runs in this process, by an executor, or by processes of this machine,
  which are replaced if they end early
- `store.py`: the file that keeps the rows
- `dissipation.py`: the question, its checks, the table and its picture
- `plans.py`: studies described in files
- `pictures.py`: pictures

Searches:

- `dissipation_range.py`: the range of W, by `range_starts.py` (where the search starts),
  `range_search.py` (transients) and `ascent.py` (linear programs for the next start)
- `protocols.py`: loads before the cycle that bring a contact to rest
- `after_overload.py`: the guaranteed limit for slips up to the largest that one overload leaves
"""

from . import starts as starts
