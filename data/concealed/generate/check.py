#!/usr/bin/env python3
"""Hold the condensed joint laws against OpenSees' own materials, Newton's method and load steps.

    python data/concealed/generate/check.py

`laws.py` solves each law with the structure condensed to its joints.  Here the same runs are followed
by OpenSees alone: a zero-length element with a material that has the law, load after load.
"""

import sys

import numpy as np
import openseespy.opensees as ops

import laws
from laws import solve_twists
from plan import LOADS
from structures import ROOT, Model, Robot, joint_action, joints_of

PARTS = 16  # of each load step
RIGID = 1e9  # N m/rad, stands for a joint that does not turn
ALGORITHMS = (("Newton",), ("NewtonLineSearch", "-type", "Bisection"), ("KrylovNewton",), ("Newton", "-initial"))
HISTORY = np.array([*LOADS[1:], *reversed(LOADS[:-1])], dtype=float)


def compliance(law):
    return lambda tag: ops.uniaxialMaterial("Elastic", tag, 1.0 / law.c)


def friction(law):
    def make(tag: int) -> None:
        ops.uniaxialMaterial("Elastic", 5000 + tag, 1.0 / law.c)
        ops.uniaxialMaterial("ElasticPP", 6000 + tag, RIGID, law.friction_moment / RIGID)
        ops.uniaxialMaterial("Parallel", tag, 5000 + tag, 6000 + tag)

    return make


def table(twists: list[float], moments: list[float]):
    return lambda tag: ops.uniaxialMaterial("ElasticMultiLinear", tag, "-strain", *twists, "-stress", *moments)


def backlash(law):
    """Newton's method wants a little slope where play is taken up, and less than RIGID where it is not."""
    rigid, slope = 1e7, 10.0
    seated, top = law.seat_moment / rigid, law.seat_moment + slope * law.play
    twists = [0.0, seated, seated + law.play, seated + law.play + 1.0]
    moments = [0.0, law.seat_moment, top, top + rigid]
    return table([-t for t in twists[:0:-1]] + twists, [-m for m in moments[:0:-1]] + moments)


def nonlinearity(law):
    moments = np.linspace(-60.0, 60.0, 4001)
    twists = law.c * moments + law.q * moments * np.abs(moments)
    return table(list(map(float, twists)), list(map(float, moments)))


MATERIAL = {laws.Compliance: compliance, laws.Friction: friction, laws.Backlash: backlash, laws.Nonlinearity: nonlinearity}


def attempt(*algorithm: str) -> bool:
    """One load step; at a reversal the slider sticks again, where plain Newton may swing to and fro."""
    ops.algorithm(*algorithm)
    return ops.analyze(1) == 0


def followed(robot, mechanism, pose, multipliers, joints: dict, direction: int) -> np.ndarray:
    """Displacement of the end along the load, OpenSees alone."""
    there = [joint for joint in joints_of(robot, mechanism) if joint["id"] in joints]
    materials = {name: MATERIAL[type(law)](law) for name, law in joints.items()}
    model = Model(robot, mechanism, pose, multipliers, there, materials)
    (point, load), = model.force(np.eye(3)[direction])
    ops.timeSeries("Path", 1, "-time", *map(float, range(len(HISTORY) + 1)), "-values", 0.0, *HISTORY)
    ops.pattern("Plain", 1, 1)
    ops.load(model.tag[point], *map(float, load))
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("UmfPack")
    ops.test("NormDispIncr", 1e-12, 100)
    ops.integrator("LoadControl", 1.0 / PARTS)
    ops.analysis("Static", "-noWarnings")
    moved = []
    for _ in HISTORY:
        for _ in range(PARTS):
            if not any(attempt(*algorithm) for algorithm in ALGORITHMS):
                raise RuntimeError("OpenSees did not find an equilibrium")
        moved.append(model.end_displacement()[direction])
    return np.array(moved)


def condensed(robot, mechanism, pose, multipliers, joints: dict, direction: int) -> np.ndarray:
    action = joint_action(robot, mechanism, pose, multipliers, tuple(joints))
    order = [action.ids.index(name) for name in joints]
    lever, stiffness = action.lever[order, direction], action.stiffness[np.ix_(order, order)]
    twists = solve_twists(list(joints.values()), (HISTORY[:, None] * lever)[None], stiffness[None])[0]
    return twists @ lever


def main() -> None:
    hp = Robot(str(ROOT / "data/robots/hp-robot.toml"))
    stacker = Robot(str(ROOT / "data/concealed/robots/stacker-arm.toml"))
    cases = [
        (hp, "F", "P1", 1, {"A5B": laws.Compliance(2e-4)}),
        (hp, "F", "P3", 2, {"A4B": laws.Friction(1.9e-4, 0.4)}),
        (hp, "B", "P2", 1, {"B1": laws.Backlash(1.3e-4, 0.2)}),
        (hp, "B", "P4", 1, {"B3": laws.Nonlinearity(2e-4, 3e-5)}),
        (hp, "F", "P2", 1, {"B3": laws.Backlash(1.2e-4, 0.14), "A5F": laws.Friction(1e-4, 0.3)}),
        (stacker, "full", "turned", 1, {"wrist": laws.Friction(1e-4, 0.5), "plate": laws.Compliance(1e-5)}),
        (stacker, "bare", "far", 1, {"shoulder": laws.Friction(1e-6, 20.0)}),
    ]
    worst = 0.0
    for robot, mechanism, pose, direction, joints in cases:
        multipliers, angles = robot.data["factors"]["m_fsd"], robot.data["poses"][pose]
        straight = {name: laws.Compliance(1.0 / RIGID) for name in joints}
        extra = followed(robot, mechanism, angles, multipliers, joints, direction)
        extra = extra - followed(robot, mechanism, angles, multipliers, straight, direction)
        ours = condensed(robot, mechanism, angles, multipliers, joints, direction)
        gap = float(np.max(np.abs(extra - ours)) / np.max(np.abs(ours)))
        worst = max(worst, gap)
        names = ", ".join(f"{type(law).__name__} at {name}" for name, law in joints.items())
        print(f"{robot.data['name']}, {mechanism}, {pose}: {names}: up to {1e6 * np.max(np.abs(ours)):.3f} um, apart by {gap:.1e} of it")
    if worst > 3e-3:
        sys.exit(f"the condensed laws and OpenSees' own differ by {worst:.1e}")


if __name__ == "__main__":
    main()
