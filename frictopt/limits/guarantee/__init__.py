"""The critical nodes of the guaranteed limit.

`critical_state.py` has the states in which a node is critical, `critical_search.py` their bounds
and programs.
"""
