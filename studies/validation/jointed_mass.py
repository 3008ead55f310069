"""One mass on a joint of several nodes that slip and lift off, and its time integration.

The nodes are coupled, so that they begin to slip one by one. The integration shares no code with
the package: nodes are followed one after another until all of them obey the contact law.
"""

from dataclasses import dataclass

import numba
import numpy as np

import frictopt as fo


@dataclass(frozen=True)
class JointedMass:
    """A unit mass whose glued joint has the stiffness 1, with m nodes.

    If the mass moves by x and nodes slip by v and open by g, the shear forces are
    `shear x + (A + shear shear') v + shear pressing' g` and the pressures are
    `preload + pressing x + pressing shear' v + (diag(opening) + pressing pressing') g`.
    The joint pulls the mass back with `x + shear' v + pressing' g`.

    Attributes
    ----------
    A, opening
        Stiffness (m, m) that resists slip, and stiffnesses (m,) that resist gaps.
    shear, pressing
        (m,) shear force and pressure of each node per motion of the mass.
    preload
        (m,) pressures at rest.
    friction
        Coefficient of friction of all nodes.
    """

    A: np.ndarray
    opening: np.ndarray
    shear: np.ndarray
    pressing: np.ndarray
    preload: np.ndarray
    friction: float = 0.5

    @property
    def first_slip(self) -> float:
        """Static force of either sign at which the first node begins to slip."""
        weakening = np.abs(self.shear) + self.friction * np.abs(self.pressing)
        return float((self.friction * self.preload / weakening).min())

    def curve(self, load_factors: np.ndarray) -> fo.results.BackboneCurve:
        """The backbone curve, with a far mode as the load case "far"."""
        m = len(self.preload)
        still = np.zeros(m)
        # A mode of the frequency 100 that hardly moves the contact.
        small = 1e-4
        loads = {
            "preload": (still, self.preload),
            "mode": (self.shear, self.pressing),
            "far": (small * self.shear, small * self.pressing),
        }
        system = fo.ContactSystem.from_blocks(
            self.A,
            np.zeros((m, m)),
            np.diag(self.opening),
            np.arange(float(m)),
            loads,
            compliance=np.diag([0.0, 1.0, small]),
        )
        cycle = fo.LoadCycle({"preload": 1.0}, [{"mode": 1.0}, {"mode": -1.0}])
        return fo.joints.backbone_curve(
            system,
            cycle,
            self.friction,
            load_factors,
            natural_frequency=0.5 / np.pi,
            progress=False,
        )

    def peak(self, force: float, damping: float) -> tuple[float, float]:
        """Largest amplitude, half of a range, at the resonance from rest, and its frequency."""
        m = len(self.preload)
        loads = np.concatenate([self.shear, self.pressing])
        K = np.outer(loads, loads)
        K[:m, :m] += self.A
        K[m:, m:] += np.diag(self.opening)
        amplitude, omega = _locked(K, loads, self.preload, self.friction, force, damping)
        return amplitude, omega / (2 * np.pi)


@numba.njit(cache=True)
def _obey(K, at_rest, preload, friction, motion):  # type: ignore[no-untyped-def]
    """Change slips and gaps (2 m,) so that all nodes obey the contact law.

    Semi-smooth Newton method: as long as each node keeps its state (stick, slip, open), the forces
    are linear. The states follow from the forces, until no state changes.
    """
    m = len(preload)
    before = motion.copy()
    for _ in range(100):
        force = at_rest + K @ motion
        rows, right, largest = np.eye(2 * m), before - motion, 0.0
        for i in range(m):
            n = m + i
            pressure = preload[i] + force[n]
            trial = force[i] - K[i, i] * (motion[i] - before[i])
            right[n] = -motion[n]
            if K[n, n] * motion[n] > pressure:  # open
                rows[i], rows[n], right[i], right[n] = K[i], K[n], -force[i], -pressure
            elif abs(trial) > friction * pressure:  # slips
                sign = np.sign(trial)
                rows[i] = K[i] - sign * friction * K[n]
                right[i] = sign * friction * pressure - force[i]
            largest = max(largest, abs(right[i]), abs(right[n]))
        if largest < 1e-11:
            return
        motion += np.linalg.solve(rows, right)
    motion[:] = np.nan


@numba.njit(cache=True)
def _locked(K, loads, preload, friction, force, damping):  # type: ignore[no-untyped-def]
    """Amplitude from rest, and angular frequency, at which the motion lags by 90 degrees.

    The motion is integrated by central differences. After each cycle, the error of the lag changes
    the frequency, slowly compared with the damping. At the peak, the damping ratio is `force / (2
    amplitude omega^2)`.
    """
    steps = 200
    slowness = 0.5
    motion = np.zeros(2 * len(preload))
    x, before, omega = 0.0, 0.0, 1.0
    last, passed = 1e-300, 0.0
    for _ in range(400000):
        dt = 2 * np.pi / omega / steps
        cosine, sine, low, high = 0.0, 0.0, np.inf, -np.inf
        for step in range(steps):
            phase = 2 * np.pi * step / steps
            _obey(K, loads * x, preload, friction, motion)
            total = force * np.cos(phase) - x - loads @ motion
            after = (2 * x - before * (1 - damping * dt) + dt * dt * total) / (1 + damping * dt)
            before, x = x, after
            low, high = min(low, x), max(high, x)
            cosine += x * np.cos(phase + 2 * np.pi / steps)
            sine += x * np.sin(phase + 2 * np.pi / steps)
        amplitude = (high - low) / 2
        ratio = min(force / (2 * amplitude * omega**2), 0.2)
        # The sine of the error of the lag is below 0 above the resonance.
        ahead = cosine / np.hypot(cosine, sine)
        change = 1 + slowness * ratio**2 * 2 * np.pi * ahead
        # The new frequency must not change the velocity.
        before = x - (x - before) / change
        omega *= change
        passed += ratio
        if passed > 3.0:
            if abs(amplitude / last - 1) < 3e-5 and abs(ahead) < 3e-3:
                return amplitude, omega
            last, passed = amplitude, 0.0
    return np.nan, np.nan


def random_mass(rng: np.random.Generator) -> JointedMass:
    """A random joint of one to four nodes; pressures of every third joint vary with the motion."""
    m = int(rng.integers(1, 5))
    root = rng.normal(size=(m, m))
    A = (root @ root.T / m + 0.2 * np.eye(m)) * rng.choice([0.3, 1.0, 3.0])
    opposed = rng.choice([-1.0, 1.0], m) if rng.random() < 0.3 else np.ones(m)
    shear = -rng.uniform(0.2, 1.2, m) * opposed
    pressing = np.zeros(m)
    if rng.random() < 1 / 3:
        pressing = rng.uniform(-0.4, 0.4, m)
    preload = rng.uniform(0.3, 2.0, m)
    return JointedMass(A, rng.uniform(0.3, 3.0, m), shear, pressing, preload)
