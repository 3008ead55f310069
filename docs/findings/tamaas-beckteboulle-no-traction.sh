#!/usr/bin/env bash
# tamaas' solver BeckTeboulle returns no traction and the error 0 for a sphere under a given load.
#
# Guess: the tractions of the other solvers of frictional contact, Condat and PolonskyKeerTan.
# Seen: all tractions are zero, although the load is not. The returned error is 0.0, and nothing is
# printed at the level of warnings.
# Versions: tamaas 2.9.0, numpy 2.4.6, Python 3.11; 2026-11-27.
# Output: mean tractions over the load, "Condat 0.25 1.00", "PolonskyKeerTan 0.25 1.00",
# "BeckTeboulle 0.00 0.00, error 0.0", then "as described".
. "$(dirname "$0")/common.sh"
packages tamaas==2.9.0 numpy==2.4.6

cat > "$folder/press.py" <<'PYTHON'
import numpy as np
import tamaas as tm

tm.set_log_level(tm.LogLevel.warning)
cells, radius, friction = 32, 4.0, 0.5
place = (np.arange(cells) - cells // 2) / cells
x, y = np.meshgrid(place, place, indexing="ij")
sphere = -(x**2 + y**2) / (2 * radius)
load = 4 * 0.15**3 / (3 * radius)  # a contact of radius 0.15 in a box of side 1
for method in (tm.Condat, tm.PolonskyKeerTan, tm.BeckTeboulle):
    model = tm.Model(tm.model_type.surface_2d, [1.0, 1.0], [cells, cells])
    model.E, model.nu = 0.75, 0.5
    solver = method(model, sphere, 1e-9, friction)
    solver.max_iter = 2000
    error = solver.solve([0.25 * load, 0.0, load])
    shear, _, pressure = np.array(model.traction).reshape(-1, 3).mean(axis=0) / load
    told = f", error {error}" if method is tm.BeckTeboulle else ""
    print(f"{method.__name__} {shear:.2f} {pressure:.2f}{told}")
PYTHON

OMP_NUM_THREADS=1 "$folder/venv/bin/python" "$folder/press.py" | grep --extended-regexp '^(Condat|Polon.* 0|Beck)' | tee "$folder/seen"
[ "$(sed --quiet 1p "$folder/seen")" = "Condat 0.25 1.00" ]
[ "$(sed --quiet 2p "$folder/seen")" = "PolonskyKeerTan 0.25 1.00" ]
[ "$(sed --quiet 3p "$folder/seen")" = "BeckTeboulle 0.00 0.00, error 0.0" ]
echo "as described"
