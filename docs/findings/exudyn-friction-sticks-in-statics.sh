#!/usr/bin/env bash
# Exudyn's friction of bristles never slips in a static analysis, whatever the load.
#
# Guess: `CoordinateSpringDamperExt` with a sticking stiffness and no proportional zone is a spring
# beside an elastic slider, and `SolveStatic` follows its hysteresis step by step.
# Seen: in statics the slider is a spring: ten times the friction force moves the point by the load
# over both stiffnesses, and no slip is left after unloading. The same element slides in a slow
# motion. The manual recommends this model for implicit solvers, and does not exclude statics.
# Versions: exudyn 1.13.6, numpy 2.4.6, Python 3.11; 2026-11-28.
# Output: displacement, in mm, at the load 10 and after unloading; friction 1, spring 100, sticking
# stiffness 10000. Statics: "0.99 0.00"; by hand, and in motion within 1 mm, "90 10".
. "$(dirname "$0")/common.sh"
packages exudyn==1.13.6 numpy==2.4.6

cat > "$folder/slider.py" <<'PYTHON'
import exudyn as exu
from exudyn.utilities import (
    CoordinateConstraint,
    CoordinateSpringDamperExt,
    LoadCoordinate,
    MarkerNodeCoordinate,
    MassPoint,
    NodeGenericData,
    NodePoint,
    NodePointGround,
)

FORCE, SPRING, STICKING, FRICTION, TIME = 10.0, 100.0, 1e4, 1.0, 20.0


def load(mbs, t, factor):
    """Up to the force in half of the time, and back to zero."""
    return FORCE * (1 - abs(2 * t / TIME - 1))


def contact():
    """A mass point on the x axis, held by a spring and a slider."""
    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddNode(NodePointGround())
    node = mbs.AddNode(NodePoint())
    history = mbs.AddNode(NodeGenericData(initialCoordinates=[0, 0, 0], numberOfDataCoordinates=3))
    mbs.AddObject(MassPoint(nodeNumber=node, mass=1.0))
    fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    x, y, z = (
        mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis)) for axis in range(3)
    )
    for held in (y, z):
        mbs.AddObject(CoordinateConstraint(markerNumbers=[fixed, held]))
    mbs.AddObject(
        CoordinateSpringDamperExt(
            markerNumbers=[fixed, x],
            nodeNumber=history,
            stiffness=SPRING,
            damping=5.0,
            dynamicFrictionForce=FRICTION,
            stickingStiffness=STICKING,
            frictionProportionalZone=0.0,
        )
    )
    mbs.AddLoad(LoadCoordinate(markerNumber=x, load=FORCE, loadUserFunction=load))
    mbs.Assemble()
    return mbs, node


def displacement(static, time):
    """Displacement in mm, followed from the beginning to a time."""
    mbs, node = contact()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    if static:
        settings.staticSolver.numberOfLoadSteps = int(20 * time)
        settings.staticSolver.loadStepDuration = time
        mbs.SolveStatic(settings)
    else:
        settings.timeIntegration.numberOfSteps = int(1000 * time)
        settings.timeIntegration.endTime = time
        mbs.SolveDynamic(settings)
    return 1e3 * mbs.GetNodeOutput(node, exu.OutputVariableType.Displacement)[0]


static = [displacement(True, time) for time in (TIME / 2, TIME)]
print(f"statics: {static[0]:.2f} {abs(static[1]):.2f}")
slow = [displacement(False, time) for time in (TIME / 2, TIME)]
near = abs(slow[0] - 90) < 1 and abs(slow[1] - 10) < 1
print("in motion:", "90 10" if near else slow)
PYTHON

"$folder/venv/bin/python" "$folder/slider.py" 2> /dev/null | grep -E "^(statics|in motion):" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
statics: 0.99 0.00
in motion: 90 10
OUTPUT
echo "as described"
