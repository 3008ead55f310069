"""Small structures on Coulomb contacts behind springs, and their time integration.

The structures have contact systems for their forced responses. The integration shares no code with
the package.
"""

from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh

import frictopt as fo


@dataclass(frozen=True)
class Structure:
    """n masses on springs, with m contacts behind springs.

    Attributes
    ----------
    mass, bodies
        (n,) masses, and the stiffness (n, n) of the bodies without the contacts.
    along, against
        (m, n) motion of each contact along its face and against its face, per motion of the masses.
    tangential, normal, friction
        Stiffness of the springs of each contact, and its coefficient of friction.
    static
        (n,) forces at rest.
    """

    mass: np.ndarray
    bodies: np.ndarray
    along: np.ndarray
    against: np.ndarray
    tangential: float
    normal: float
    friction: float
    static: np.ndarray

    @property
    def glued(self) -> np.ndarray:
        """Stiffness (n, n) if no contact slips or opens."""
        springs = self.tangential * self.along.T @ self.along
        glued = self.bodies + springs + self.normal * self.against.T @ self.against
        return np.asarray(glued)

    def modes(self) -> tuple[np.ndarray, np.ndarray]:
        """Angular frequencies (n,) and modes of unit modal mass, in columns."""
        squares, shapes = eigh(self.glued, np.diag(self.mass))
        return np.sqrt(squares), shapes

    def damping(self, ratio: float) -> np.ndarray:
        """Damping matrix of the same ratio in each glued mode."""
        omega, shapes = self.modes()
        inertia = self.mass[:, None] * shapes
        return np.asarray(inertia @ np.diag(2 * ratio * omega) @ inertia.T)

    def contact(self) -> fo.ContactSystem:
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
            np.array([[float(k), 0.0] for k in range(len(self.along))]),
            dict(zip(forces, (-rows @ flexible @ F).T, strict=True)),
            compliance=F.T @ flexible @ F,
        )

    def curve(self, k: int, load_factors: ArrayLike, **options: Any) -> fo.results.BackboneCurve:
        """The backbone curve of mode k."""
        cycle = fo.LoadCycle({"static": 1.0}, [{f"mode {k}": 1.0}, {f"mode {k}": -1.0}])
        frequency = self.modes()[0][k] / (2 * np.pi)
        return fo.joints.backbone_curve(
            self.contact(),
            cycle,
            self.friction,
            load_factors,
            natural_frequency=frequency,
            progress=False,
            **options,
        )


def slider(k: float = 1e4, kt: float = 6e3, limit: float = 20.0) -> Structure:
    """A mass on a spring, and on a spring that slides at a force `limit`."""
    one, two = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
    static = np.array([0.0, 2 * limit / 0.5])
    return Structure(np.array([1.0, 0.2]), np.diag([k, 1e5]), one, two, kt, 1e5, 0.5, static)


def wedges() -> Structure:
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


def rocking(mass: float = 0.4, top: float = 6.0) -> Structure:
    """A block on four springs with friction, with a mass on top of it.

    The block is pressed beside its middle, so that edges lift off as it rocks. The other modes of a
    light block have much higher frequencies.
    """
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
def _steps(u, v, s, dt, mass, K, C, contacts, static, force, out, weights):  # type: ignore[no-untyped-def]
    """One period by central differences: velocities are half a step later than displacements.

    Changes u, v and the slips s; `out` becomes the weighted sum of the displacements at each step.
    """
    along, against, kt, kn, friction = contacts
    n, m = len(u), len(s)
    total = np.empty(n)
    for step in range(len(out)):
        cosine = np.cos(2 * np.pi * step / len(out))
        for i in range(n):
            total[i] = static[i] + cosine * force[i]
            for j in range(n):
                total[i] -= K[i, j] * u[j] + C[i, j] * v[j]
        for k in range(m):
            moved, closed = 0.0, 0.0
            for i in range(n):
                moved += along[k, i] * u[i]
                closed += against[k, i] * u[i]
            pressed = max(kn * closed, 0.0)
            shear = kt * (moved - s[k])
            if abs(shear) > friction * pressed:
                shear = friction * pressed * np.sign(shear)
                s[k] = moved - shear / kt
            for i in range(n):
                total[i] -= along[k, i] * shear + against[k, i] * pressed
        out[step] = 0.0
        for i in range(n):
            out[step] += weights[i] * u[i]
            v[i] += dt * total[i] / mass[i]
            u[i] += dt * v[i]


@dataclass(frozen=True)
class Answer:
    """The modal coordinate in the last period: its first harmonic, and half of its range."""

    harmonic: float
    half_range: float


class Vibration:
    """A structure from rest under its static forces, shaken at one frequency after another.

    The force acts on mode k alone. If `point` is the number of a mass coordinate, the force acts
    there, with the same modal force. Residual slips (m,) are added to the slips of the state of
    rest. Friction then removes the part of these slips that it does not hold.
    """

    def __init__(
        self,
        structure: Structure,
        k: int,
        ratio: float,
        steps: int,
        *,
        point: int | None = None,
        residual_slip: np.ndarray | None = None,
    ) -> None:
        self.structure, self.steps = structure, steps
        omega, shapes = structure.modes()
        self.inertia = structure.mass * shapes[:, k]
        self.force = self.inertia
        if point is not None:
            self.force = np.eye(len(omega))[point] / shapes[point, k]
        self.C = structure.damping(ratio)
        self.u, self.v = np.zeros(len(omega)), np.zeros(len(omega))
        self.s = np.zeros(len(structure.along))
        strong = structure.damping(0.7)
        for level in np.linspace(0.02, 1.0, 50):
            self._follow(0.0, omega[0], 10, level * structure.static, strong)
        if residual_slip is not None:
            self.s += residual_slip
            self._follow(0.0, omega[0], 100, structure.static, strong)

    def _follow(
        self, force: float, omega: float, periods: int, static: np.ndarray, C: np.ndarray
    ) -> np.ndarray:
        """The modal coordinate in the last of some periods."""
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
                b.mass,
                b.bodies,
                C,
                contacts,
                static,
                force * self.force,
                out,
                self.inertia,
            )
        return out

    def shaken(self, force: float, frequency: float, periods: int) -> Answer:
        """The answer after some periods at one frequency, from the state that is reached."""
        omega = 2 * np.pi * frequency
        out = self._follow(force, omega, periods, self.structure.static, self.C)
        turn = np.exp(-2j * np.pi * np.arange(self.steps) / self.steps)
        return Answer(2 * abs(out @ turn) / self.steps, float(np.ptp(out)) / 2)

    def sweep(
        self, force: float, frequencies: np.ndarray, first: int = 300, periods: int = 80
    ) -> tuple[float, float]:
        """Largest first harmonic of a stepped sweep, and its frequency."""
        seen = []
        for number, frequency in enumerate(frequencies):
            answer = self.shaken(force, frequency, periods if number else first)
            seen.append(answer.harmonic)
        best = int(np.argmax(seen))
        return seen[best], float(frequencies[best])
