#!/usr/bin/env bash
# By slippy's Hertz solution equal cylinders that cross at a right angle touch in an ellipse.
#
# Guess: `hertz_full` gives these cylinders the contact of a sphere of the same radius on a plane,
# and two equal barrels that of one barrel with half the radii on a plane.
# Seen: the cylinders touch in an ellipse with one axis twice as long as the other, and the peak
# pressure is wrong. The barrels are off by a few per cent. One barrel on a plane is right to all
# digits. The formula has the mixed term of both curvatures once instead of twice, so it errs where
# each body has two different radii. The mean pressure is wrong for each ellipse: it is the peak
# pressure over the area. No warning is given. Reduce a pair to one body on a plane by hand, and
# divide the load by the area.
# Versions: slippy 0.5.2, numpy 1.26.4, scipy 1.11.4, Python 3.11; 2026-11-28. slippy asks for numpy
# below 1.21, which has no wheel for Python 3.11, so it is installed without its dependencies.
# Output: half axes, peak pressure, and mean pressure times area over the load: "by hand: 0.1897,
# 0.1897, 1327, 1.0" and "crossed cylinders: 0.2818, 0.1360, 1245, 12.5"; then "by hand: 0.2114,
# 0.1333, 1694, 1.0", the same axes and peak for "barrel on a plane", and "two barrels: 0.2039,
# 0.1373, 1706, 17.1"; then "as described".
. "$(dirname "$0")/common.sh"
packages numpy==1.26.4 scipy==1.11.4 sympy==1.14.0 numba==0.60.0 \
  matplotlib==3.9.4 pyfftw==0.14.0 tinydb==4.8.2 scikit-image==0.24.0
"$folder/venv/bin/pip" install --quiet --no-deps slippy==0.5.2

cat > "$folder/touch.py" <<'PYTHON'
import numpy as np
import slippy.contact
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

YOUNG, POISSON, LOAD, FLAT = 200e3, 0.3, 100.0, float("inf")
MODULUS = YOUNG / (1 - POISSON**2) / 2  # of both bodies together


def sphere(radius):
    """Half axes and peak pressure of a sphere on a plane, and the factor of the mean pressure."""
    half = (3 * LOAD * radius / (4 * MODULUS)) ** (1 / 3)
    return half, half, 1.5 * LOAD / (np.pi * half**2), 1.0


def barrel(longer, shorter):
    """The same of a body with two radii on a plane (Johnson, Contact Mechanics, 4.2)."""

    def ratio(square):
        """Ratio of the radii for the square of the ellipse's eccentricity."""
        first, second = ellipk(square), ellipe(square)
        return (second / (1 - square) - first) / (first - second)

    square = brentq(lambda guess: ratio(guess) - longer / shorter, 1e-9, 1 - 1e-9)
    part = (ellipk(square) - ellipe(square)) / square
    half = (3 * LOAD * part * longer / (np.pi * MODULUS)) ** (1 / 3)
    other = half * np.sqrt(1 - square)
    return half, other, 1.5 * LOAD / (np.pi * half * other), 1.0


def by_slippy(first, second, angle=0.0):
    """The same of two bodies; the last is the mean pressure times the area over the load."""
    seen = slippy.contact.hertz_full(first, second, [YOUNG] * 2, [POISSON] * 2, LOAD, angle)
    area = seen["contact_area"]
    return *seen["contact_radii"], seen["max_pressure"], seen["mean_pressure"] * area / LOAD


for name, (half, other, peak, mean) in (
    ("by hand", sphere(10)),
    ("crossed cylinders", by_slippy([10, FLAT], [10, FLAT], np.pi / 2)),
    ("by hand", barrel(10, 5)),
    ("barrel on a plane", by_slippy([5, 10], [FLAT, FLAT])),
    ("two barrels", by_slippy([10, 20], [10, 20])),
):
    print(f"{name}: {half:.4f}, {other:.4f}, {peak:.0f}, {mean:.1f}")
PYTHON

"$folder/venv/bin/python" -W ignore "$folder/touch.py" 2> /dev/null | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
by hand: 0.1897, 0.1897, 1327, 1.0
crossed cylinders: 0.2818, 0.1360, 1245, 12.5
by hand: 0.2114, 0.1333, 1694, 1.0
barrel on a plane: 0.2114, 0.1333, 1694, 16.9
two barrels: 0.2039, 0.1373, 1706, 17.1
OUTPUT
echo "as described"
