"""
Wear, and the worn-in profile
=============================

A cylinder that is sheared to and fro slips at the edges of its contact, and wears there. After how
many cycles does it stop slipping, and how deep is the wear then?
"""

import frictopt as fo

arrays = fo.reference.half_plane_contact(nodes=64, half_length=1.0, E_star=1e5, R=100.0)  # N and mm
cylinder = fo.ContactSystem.from_blocks(**arrays, width=[2 / 64] * 64)
cycle = fo.LoadCycle(mean={"P": 400.0}, corners=[{"Q": 1.0}, {"Q": -1.0}])

history = fo.joints.wear(cylinder, cycle, friction=0.5, load_factor=100.0, coefficient=1e-8)
print(history)
history.plot()

# %%
# If both bodies are of the same material, the final profile is known without following the wear.

end = fo.joints.worn_in(cylinder, cycle, friction=0.5, load_factor=100.0)
print(end)
end.plot()
