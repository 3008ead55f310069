"""Three hundred answers with their times: a change of structure must change neither.

`python studies/benchmarks/answers.py write FILE` computes all answers and writes answers and times as JSON.
`python studies/benchmarks/answers.py compare FILE` computes them again and compares. Words after FILE
restrict the questions to families whose names contain one of the words. A number may differ by 1e-9
of its size in the plane and by 1e-7 in space, the time of a family by a tenth. Larger differences
are printed. The exit status is the number of answers that differ. Each time is the least processor
time of three runs; set OPENBLAS_NUM_THREADS=1.
"""

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import process_time

import numpy as np

import frictopt as fo

REPEATS = 3
TOLERANCE = {"plane": 1e-9, "space": 1e-7}
SLOWER = 1.1
Numbers = list[float]
Question = tuple[str, Callable[[], Numbers]]


def plane_contact(seed: int) -> tuple[fo.ContactSystem, fo.LoadCycle, np.ndarray]:
    """A coupled contact of 1 to 8 nodes, its load cycle of 2 to 4 corners, and friction."""
    rng = np.random.default_rng([1, seed])
    nodes, corners = int(rng.integers(1, 9)), int(rng.integers(2, 5))
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = G @ G.T / (2 * nodes) + 0.3 * np.eye(2 * nodes)
    coupling = rng.choice([0.0, 0.3, 0.8])
    bonded = {
        f"corner{k}": (rng.normal(size=nodes), 0.2 * rng.normal(size=nodes)) for k in range(corners)
    }
    bonded["mean"] = (0.1 * rng.normal(size=nodes), rng.uniform(0.5, 1.5, size=nodes))
    system = fo.ContactSystem.from_blocks(
        S[:nodes, :nodes], coupling * S[nodes:, :nodes], S[nodes:, nodes:], np.arange(nodes), bonded
    )
    return (
        system,
        fo.LoadCycle({"mean": 1.0}, [{f"corner{k}": 1.0} for k in range(corners)]),
        rng.uniform(0.3, 0.8, size=nodes),
    )


def space_contact(seed: int) -> tuple[fo.ContactSystem, fo.LoadCycle, np.ndarray]:
    """A coupled contact of 1 to 6 nodes in space, its load cycle of 2 to 4 corners, and friction."""
    rng = np.random.default_rng([2, seed])
    nodes, corners = int(rng.integers(1, 7)), int(rng.integers(2, 5))
    G = rng.normal(size=(3 * nodes, 3 * nodes))
    S = G @ G.T / (3 * nodes) + 0.3 * np.eye(3 * nodes)
    coupling = rng.choice([0.0, 0.3, 0.8])
    S[: 2 * nodes, 2 * nodes :] *= coupling
    S[2 * nodes :, : 2 * nodes] *= coupling
    bonded = {
        f"corner{k}": np.r_[rng.normal(size=2 * nodes), 0.2 * rng.normal(size=nodes)]
        for k in range(corners)
    }
    bonded["mean"] = np.r_[0.1 * rng.normal(size=2 * nodes), rng.uniform(0.5, 1.5, size=nodes)]
    system = fo.ContactSystem(S, rng.normal(size=(nodes, 3)), bonded)
    return (
        system,
        fo.LoadCycle({"mean": 1.0}, [{f"corner{k}": 1.0} for k in range(corners)]),
        rng.uniform(0.3, 0.8, size=nodes),
    )


def sums(system: fo.ContactSystem | fo.ContactSystem) -> Numbers:
    """A few numbers of a condensed system that do not depend on the order of its nodes."""
    loads = [
        np.linalg.norm(np.concatenate([np.ravel(part) for part in system.reaction({name: 1.0})]))
        for name in sorted(system.bonded)
    ]
    return [
        np.linalg.norm(system.S),
        np.trace(system.A),
        np.trace(system.C),
        *loads,
        system.gap.sum(),
    ]


def onset(found: fo.results.Onset) -> Numbers:
    """Load factors and nodes of all events."""
    return [
        number
        for event in (*found.slips, *found.separations)
        for number in (event.load_factor, -1.0 if event.node is None else event.node)
    ]


def range_of(found: fo.results.DissipationRange) -> Numbers:
    """Both ends of a range."""
    return [found.least, found.most]


def questions_of(kind: str, seed: int) -> Iterator[Question]:
    """The questions about one random contact."""
    system, cycle, f = plane_contact(seed) if kind == "plane" else space_contact(seed)
    limit = fo.shakedown_limit(system, cycle, f).load_factor
    load = 1.0 if not np.isfinite(limit) else limit
    rng = np.random.default_rng([3, seed])
    start = rng.normal(size=system.slip_shape) * 0.3
    yield f"{kind} shakedown", lambda: [fo.shakedown_limit(system, cycle, f).load_factor]
    yield f"{kind} safe slip", lambda: [fo.safe_slip(system, cycle, f, 0.7 * load).margin]
    yield f"{kind} onset", lambda: onset(fo.onset(system, cycle, f))
    for share in (0.8, 1.3):
        yield (
            f"{kind} steady state",
            lambda share=share: [
                fo.steady_state(system, cycle, f, share * load, initial_slip=start).dissipation
            ],
        )
    if seed % 3 == 0:
        yield (
            f"{kind} march",
            lambda: [
                float(
                    np.abs(
                        fo.march(system, cycle, f, load, initial_slip=start, cycles=2).slip
                    ).max()
                )
            ],
        )
    if kind == "plane":
        yield f"{kind} guaranteed", lambda: [fo.guaranteed_limit(system, cycle, f).load_factor]
        if seed % 2 == 0:
            yield (
                f"{kind} required friction",
                lambda: [fo.required_friction(system, cycle, 0.5 * load).required],
            )
        if seed % 4 == 0:
            yield (
                f"{kind} range",
                lambda: range_of(fo.dissipation_range(system, cycle, f, 0.9 * load)),
            )


def engines(seed: int) -> Iterator[Question]:
    """One increment in the plane and in space."""
    system, _, f = plane_contact(seed)
    slip = np.zeros(system.nodes)
    load = system.reaction({"mean": 1.0, "corner0": 0.7})
    increment = fo.increments.NewtonIncrement(system, f)
    yield "plane increments", lambda: [float(np.abs(increment.solve(slip, load).slip).max())]
    space, _, g = space_contact(seed)
    pushed = space.reaction({"mean": 1.0, "corner0": 0.7})
    engine = fo.increments.NewtonIncrement(space, g)
    yield (
        "space increments",
        lambda: [float(np.abs(engine.solve(np.zeros((space.nodes, 2)), pushed).slip).max())],
    )


def scenes() -> Iterator[Question]:
    """Models with meshes, from the condensation to the steady state."""
    pull = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    flank = fo.LoadCycle({"pull": 1.0}, [{"pull": 0.3, "sway": 0.1}, {"pull": -0.3, "sway": -0.1}])
    for elements in (16, 40, 64):
        punch = fo.scenes.PunchOnHalfPlane(elements=elements).condense()
        yield (
            "plane door",
            lambda elements=elements: sums(
                fo.scenes.PunchOnHalfPlane(elements=elements).condense()
            ),
        )
        for f in (0.3, 0.5, 0.7, 1.0):
            yield (
                "plane scene limits",
                lambda punch=punch, f=f: [fo.shakedown_limit(punch, pull, f).load_factor],
            )
            yield (
                "plane scene limits",
                lambda punch=punch, f=f: [fo.guaranteed_limit(punch, pull, f).load_factor],
            )
        for share in (1.5, 1.9):
            yield (
                "plane scene transients",
                lambda punch=punch, share=share: [
                    fo.steady_state(punch, pull, 0.7, share).dissipation
                ],
            )
    dovetail = fo.scenes.Dovetail(angle=50, elements=24, edge_radius=5.0)
    root = dovetail.condense()
    yield "plane door", lambda: sums(dovetail.condense())
    yield "plane door", lambda: sums(fo.scenes.PressFit().condense())
    yield "plane door", lambda: sums(fo.scenes.PinInPlate().condense())
    yield "plane door", lambda: sums(fo.scenes.RoundedPunch().condense())
    yield "plane scene limits", lambda: [fo.shakedown_limit(root, flank, 0.4).load_factor]
    turning = fo.LoadCycle({"P": 1.0}, [{"Qx": 0.1}, {"Qy": 0.1}, {"Qx": -0.1}, {"Qy": -0.1}])
    for elements in (3, 5):
        square = fo.scenes.SquarePunch(elements=elements).condense()
        yield (
            "space door",
            lambda elements=elements: sums(fo.scenes.SquarePunch(elements=elements).condense()),
        )
        for f in (0.3, 0.5, 0.7):
            yield (
                "space scene limits",
                lambda square=square, f=f: [fo.shakedown_limit(square, turning, f).load_factor],
            )
        yield (
            "space scene transients",
            lambda square=square: [fo.steady_state(square, turning, 0.3, 1.5).dissipation],
        )


def questions() -> Iterator[Question]:
    """The questions of all families."""
    for seed in range(24):
        yield from questions_of("plane", seed)
    for seed in range(12):
        yield from questions_of("space", seed)
        yield from engines(seed)
    yield from scenes()


def asked(words: Sequence[str] = ()) -> tuple[list[tuple[str, Numbers | str]], dict[str, float]]:
    """Answers, and processor times of the families whose names contain a word, or of all.

    If a question raises an error, the name of the error is its answer.
    """
    answers, times = [], dict[str, float]()
    for family, question in questions():
        if words and not any(word in family for word in words):
            continue
        least = np.inf
        for _ in range(REPEATS):
            start = process_time()
            try:
                answer: Numbers | str = question()
            except fo.FrictoptError as error:
                answer = type(error).__name__
            least = min(least, process_time() - start)
        answers.append((family, answer))
        times[family] = times.get(family, 0.0) + least
    return answers, times


def apart(one: Numbers | str, other: Numbers | str) -> float:
    """Largest difference between the numbers of two answers, relative to the larger number of each pair."""
    if isinstance(one, str) or isinstance(other, str):
        return 0.0 if one == other else np.inf
    if len(one) != len(other):
        return np.inf
    a, b = np.array(one), np.array(other)
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    a, b = np.where(same, 0.0, a), np.where(same, 0.0, b)
    size = np.maximum(np.maximum(np.abs(a), np.abs(b)), 1e-6)
    return float(np.where(same, 0.0, np.abs(a - b) / size).max(initial=0.0))


def main(action: str, file: Path, *words: str) -> int:
    """Write the answers, or compare them with the answers in a file."""
    answers, times = asked(words)
    if action == "write":
        file.write_text(json.dumps({"answers": answers, "times": times}, indent=1))
        print(f"{len(answers)} answers, {sum(times.values()):.1f} s")
        return 0
    before = json.loads(file.read_text())
    earlier = [
        (family, answer)
        for family, answer in before["answers"]
        if not words or any(word in family for word in words)
    ]
    differ = 0
    for number, ((family, now), (name, then)) in enumerate(zip(answers, earlier, strict=True)):
        distance = apart(now, then)
        if family != name or distance > TOLERANCE[family.split()[0]]:
            differ += 1
            print(f"{number:4} {family}: {then} -> {now} (apart {distance:.1e})")
    print(f"{len(answers)} answers, {differ} differ")
    for family, seconds in times.items():
        ratio = seconds / before["times"][family]
        print(
            f"{family:24} {seconds:8.3f} s, {ratio:5.2f} of before{'  SLOWER' if ratio > SLOWER else ''}"
        )
    return differ


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1], Path(sys.argv[2]), *sys.argv[3:]))
