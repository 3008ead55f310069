"""Transients and steady states, and what can be said of loads without them.

In come a system, a load cycle, friction and a load factor; out go a `Trajectory` (`march.py`), a
`SteadyState` (`steady.py`, its class in `outcome.py`) and an `Onset` (`onset.py`). All transients
have the base class of `transient.py`. `exact/` has the exact path of the plane, `stepped.py` and
`increments/` have increments, `increment_doubts.py` what these leave in doubt. `cycles.py` and
`classify.py` find the steady state, `fretting.py` what frets in it, `statics.py` what rigid motions
allow.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
