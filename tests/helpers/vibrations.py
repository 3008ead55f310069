"""Small structures on Coulomb contacts behind springs, for forced responses: their contact systems,
and a time integration that shares no code with the package."""

from dataclasses import dataclass

import numba
import numpy as np
from scipy.linalg import eigh

import frictopt as fo


@dataclass(frozen=True)
class Structure:
    """n masses with a stiffness (n, n) of the bodies; m contacts with rows (m, n) of the motions
    along and against them, and their springs. `static` are the forces (n,) at rest."""

    mass: np.ndarray
    bodies: np.ndarray
    along: np.ndarray
    against: np.ndarray
    tangential: float
    normal: float
    friction: float
    static: np.ndarray

    @property
    def glued(self):
        springs = self.tangential * self.along.T @ self.along
        return self.bodies + springs + self.normal * self.against.T @ self.against

    def modes(self):
        """Angular frequencies (n,) and modes of unit modal mass, in columns."""
        squares, shapes = eigh(self.glued, np.diag(self.mass))
        return np.sqrt(squares), shapes

    def damping(self, ratio):
        """Damping matrix of the same ratio in each glued mode."""
        omega, shapes = self.modes()
        inertia = self.mass[:, None] * shapes
        return inertia @ np.diag(2 * ratio * omega) @ inertia.T

    def contact(self):
        """The contact system with the load cases "static", "mode 0", "mode 1", .."""
        kt, kn = self.tangential, self.normal
        flexible = np.linalg.inv(self.glued)
        rows = np.vstack([kt * self.along, -kn * self.against])
        springs = np.diag(np.repeat([kt, kn], len(self.along)))
        _, shapes = self.modes()
        forces = {"static": self.static}
        forces |= {f"mode {k}": self.mass * shape for k, shape in enumerate(shapes.T)}
        F = np.column_stack(list(forces.values()))
        return fo.ContactSystem(
            springs - rows @ flexible @ rows.T,
            [[float(k), 0.0] for k in range(len(self.along))],
            dict(zip(forces, (-rows @ flexible @ F).T, strict=True)),
            compliance=F.T @ flexible @ F,
        )

    def curve(self, k, load_factors, **options):
        """The backbone curve of mode k."""
        cycle = fo.LoadCycle({"static": 1.0}, [{f"mode {k}": 1.0}, {f"mode {k}": -1.0}])
        frequency = self.modes()[0][k] / (2 * np.pi)
        return fo.backbone_curve(
            self.contact(),
            cycle,
            self.friction,
            load_factors,
            natural_frequency=frequency,
            progress=False,
            **options,
        )


def slider(k=1e4, kt=6e3, limit=20.0):
    """A mass on a spring, and on a spring that slides at a force `limit`."""
    one, two = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
    static = np.array([0.0, 2 * limit / 0.5])
    return Structure(np.array([1.0, 0.2]), np.diag([k, 1e5]), one, two, kt, 1e5, 0.5, static)


def wedges():
    """Two masses and a wedge between them on two faces of 40 degrees (Balaji and Ferhatoglu)."""
    J = np.array([[1.0, -1.0], [-1.0, 1.0]])
    bodies = np.diag([1e5] * 4 + [0.0] * 2)
    for part, stiffness in enumerate((9e5, 3e5, 1e6)):
        bodies[2 * part : 2 * part + 2, 2 * part : 2 * part + 2] += stiffness * J
    c, s = np.cos(np.radians(40)), np.sin(np.radians(40))
    along = np.array([[-c, -s, 0, 0, c, s], [0, 0, -c, s, c, -s]])
    against = np.array([[s, -c, 0, 0, -s, c], [0, 0, -s, -c, s, c]])
    mass = np.array([10.0] * 4 + [0.1] * 2)
    return Structure(mass, bodies, along, against, 3e5, 3e5, 0.9, 240.0 * np.eye(6)[5])


def rocking(mass=0.4, top=6.0):
    """A block on four springs with friction, pressed beside its middle, with a mass on top of it:
    edges lift off as it rocks. A light block has its other modes far away."""
    x = np.array([-0.1, -0.1 / 3, 0.1 / 3, 0.1])
    along = np.array([[1.0, 0.0, 0.125, 0.0]] * 4)
    against = np.array([[0.0, -1.0, -place, 0.0] for place in x])
    arm = np.array([-1.0, 0.0, 0.225, 1.0])
    bodies = np.diag([1e5, 2e5, 2e3, 0.0]) + 2.5e5 * np.outer(arm, arm)
    inertia = mass * (0.2**2 + 0.25**2) / 12
    static = np.array([0.0, -400.0, 6.0, 0.0])
    masses = np.array([mass, mass, inertia, top])
    return Structure(masses, bodies, along, against, 4e5, 6e5, 0.4, static)


@numba.njit(cache=True)
def _steps(u, v, s, dt, inverse_mass, matrices, contacts, static, force, phase, out, weights):
    """Central differences: velocities stand half a step after the displacements."""
    K, C = matrices
    along, against, kt, kn, friction = contacts
    for step in range(len(out)):
        total = static + force * np.cos(phase + 2 * np.pi * step / len(out)) - K @ u - C @ v
        for k in range(len(s)):
            pressed = max(kn * (against[k] @ u), 0.0)
            shear = kt * (along[k] @ u - s[k])
            if abs(shear) > friction * pressed:
                shear = friction * pressed * np.sign(shear)
                s[k] = along[k] @ u - shear / kt
            total -= along[k] * shear + against[k] * pressed
        out[step] = weights @ u
        v += dt * total * inverse_mass
        u += dt * v


class Vibration:
    """A structure from rest under its static forces, shaken in mode k at one frequency after the
    other."""

    def __init__(self, structure, k, ratio, steps):
        self.structure, self.steps = structure, steps
        omega, shapes = structure.modes()
        self.inertia = structure.mass * shapes[:, k]
        self.C = structure.damping(ratio)
        self.u, self.v = np.zeros(len(omega)), np.zeros(len(omega))
        self.s = np.zeros(len(structure.along))
        strong = structure.damping(0.7)
        for level in np.linspace(0.02, 1.0, 50):
            self._follow(0.0, omega[0], 10, level * structure.static, strong)

    def _follow(self, force, omega, periods, static, C):
        b = self.structure
        contacts = b.along, b.against, b.tangential, b.normal, b.friction
        out = np.empty(self.steps)
        dt = 2 * np.pi / omega / self.steps
        for _ in range(periods):
            _steps(
                self.u,
                self.v,
                self.s,
                dt,
                1 / b.mass,
                (b.bodies, C),
                contacts,
                static,
                force * self.inertia,
                0.0,
                out,
                self.inertia,
            )
        return out

    def amplitude(self, force, frequency, periods):
        """First harmonic of the modal coordinate in the last of some periods."""
        omega = 2 * np.pi * frequency
        out = self._follow(force, omega, periods, self.structure.static, self.C)
        turn = np.exp(-2j * np.pi * np.arange(self.steps) / self.steps)
        return 2 * abs(out @ turn) / self.steps

    def sweep(self, force, frequencies, first=300, periods=80):
        """Largest amplitude of a stepped sweep, and its frequency."""
        seen = []
        for number, frequency in enumerate(frequencies):
            seen.append(self.amplitude(force, frequency, periods if number else first))
        best = int(np.argmax(seen))
        return seen[best], frequencies[best]
