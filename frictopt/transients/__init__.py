"""Transients and steady states of a contact, and statements on its loads that need no transient.

The input is a contact system with stiffness S, a load cycle, friction f and a load factor. The
reactions of a state with slip v and gap w are `r = [q, p] = r^w + S [v, w - g0]`. Every node
sticks, slips against q with `|q| = f p`, or is open. There are three results:

- `march`: the states of a transient over some cycles, a `Trajectory` (`march.py`, `trajectory.py`);
- `steady_state`: what the transient does for ever, a `SteadyState` (`steady.py`, `outcome.py`);
- `onset`: the loads at which the bonded contact first slips or opens, an `Onset` (`onset.py`).

A transient is followed exactly, from event to event, in the plane (`exact/`), and in increments in
space (`stepped.py`, `increments/`); `transient.py` is the base of both. `cycles.py` follows the
cycles until a steady state is proven: `classify.py` checks the last cycles, and `extrapolation.py`
jumps to their limit. `fretting.py` and `critical_plane.py` make the tables of a steady cycle, and
`pictures.py` draws the results. `statics.py` proves that friction cannot hold a load, and describes
the mean load; `balance.py` has the programs of contact forces for these proofs.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
