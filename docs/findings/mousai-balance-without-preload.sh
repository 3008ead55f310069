#!/usr/bin/env bash
# mousai's `hb_freq` holds the mean displacement at zero, and drops the preload of a contact.
#
# Guess: `hb_time` and `hb_freq` find the same steady vibration of the same equation, one in time
# and the other in frequency.
# Seen: they do so only without a mean force. By default `hb_freq` sets the mean of the displacement
# to zero and leaves out the balance of the mean forces, and the error that it returns leaves them
# out as well. A contact that a preload of three times the excitation keeps closed then opens in
# each cycle, and the amplitude is six times too large, with an error of 1e-11.
# `mask_constant=False` gives the right motion; the documentation mentions this option, and not its
# consequence. The phases differ, too, where both motions agree: `hb_time` refers them to a cosine
# and `hb_freq` to a sine. So give `mask_constant=False` wherever there is preload, weight or
# contact on one side.
# Versions: mousai 0.3.1, numpy 2.3.5, scipy 1.16.3, Python 3.11; 2026-11-28.
# Output: mean, amplitude and phase of a mass on a contact of stiffness 1, with the preload 3 and
# the excitation sin(0.7 t): "by hand: 3.00, 1.94, -0.14", "hb_time: 3.00, 1.94, -1.71", "hb_freq:
# 0.00, 11.59, -1.08", "hb_freq with the mean: 3.00, 1.94, -0.14", then "as described". The script
# fails if an error that mousai returns exceeds 1e-6.
. "$(dirname "$0")/common.sh"
packages mousai==0.3.1 numpy==2.3.5 scipy==1.16.3

cat > "$folder/vibrate.py" <<'PYTHON'
import mousai
import numpy as np

PRELOAD, FORCE, DAMPING, STIFFNESS, OMEGA, HARMONICS = 3.0, 1.0, 0.1, 1.0, 0.7, 5


def acceleration(x, v, params):
    """Of a mass 1 which a preload presses on a spring that cannot pull."""
    load = PRELOAD + FORCE * np.sin(params["omega"] * params["cur_time"])
    return np.reshape(load - DAMPING * v - STIFFNESS * np.maximum(x, 0), (1, 1))


def line(name, mean, amplitude, phase):
    """Result of one method; a mean of zero may have either sign."""
    return f"{name}: {abs(mean):.2f}, {amplitude:.2f}, {phase:.2f}"


closed = FORCE / (STIFFNESS - OMEGA**2 + 1j * DAMPING * OMEGA)
assert abs(closed) < PRELOAD / STIFFNESS  # the contact stays closed, so the motion is linear
print(line("by hand", PRELOAD / STIFFNESS, abs(closed), np.angle(closed)))

number = 2 * HARMONICS + 1
start = PRELOAD / STIFFNESS + np.sin(2 * np.pi * np.arange(number)[None] / number)
for name, balance, options in (
    ("hb_time", mousai.hb_time, {}),
    ("hb_freq", mousai.hb_freq, {}),
    ("hb_freq with the mean", mousai.hb_freq, {"mask_constant": False}),
):
    options |= {"num_harmonics": HARMONICS, "f_tol": 1e-8}
    _, x, error, amplitude, phase = balance(acceleration, start, OMEGA, **options)
    assert np.abs(error).max() < 1e-6
    print(line(name, x.mean(), amplitude[0], phase[0]))
PYTHON

"$folder/venv/bin/python" "$folder/vibrate.py" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
by hand: 3.00, 1.94, -0.14
hb_time: 3.00, 1.94, -1.71
hb_freq: 0.00, 11.59, -1.08
hb_freq with the mean: 3.00, 1.94, -0.14
OUTPUT
echo "as described"
