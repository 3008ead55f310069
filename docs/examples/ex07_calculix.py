"""
Matrices of CalculiX
====================

CalculiX has run a job without contact, and has written its stiffness matrix. Node sets of the deck
say where the contact is.
"""

from pathlib import Path

import frictopt as fo

root = (
    Path() if Path("docs").is_dir() else Path("../..")
)  # of the repository: you are there, or in `docs/examples`
job = fo.readers.read_calculix(root / "tests/data/flat")
system = fo.condense(
    job.K,
    loads={
        "P": job.force("N_TOP", traction=[0.0, -1.0]),
        "Q": job.force("N_TOP", traction=[1.0, 0.0]),
    },
    pairs=job.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK"),
    normals=[0.0, 1.0],
    unknowns=job.unknowns,
    points=job.points,
)
print(system)

# %%
# From here on, the calls are the same for matrices of every code.

cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"Q": -1.0}, {"Q": 1.0}])
fo.onset(system, cycle, friction=0.5).plot()

# %%

limit = fo.shakedown_limit(system, cycle, friction=0.5)
print(limit)
limit.plot()
