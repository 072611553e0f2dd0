"""Builds robots in OpenSees from their robot files and compares compliance and sag of the tool with `robot compliance` and `robot map --sag`.

    python3 -m venv venv && venv/bin/pip install openseespy numpy example-robot-data pybullet
    venv/bin/python tests/opensees/check.py target/release/stiffbench            compare
    venv/bin/python tests/opensees/check.py target/release/stiffbench --write    write fixtures/opensees/random_robots.csv again, for a test in Rust

Robots: the shipped ones of the format `stiffbench/robot/2` (`fixtures/opensees/generate.py` has the others), every template, 60 random robots and
14 public URDFs as `robot new` writes them. The 6 x 6 compliance, of Euler-Bernoulli and of Timoshenko beams, is compared in every pose of
the file and in a random one, there the sag and the mass too. `robot_file.py` reads the file and places what it describes, `by_opensees.py`
solves it. From stiffbench come only the values of the variables in the random pose, and the numbers that are compared.
"""

import argparse
import csv
import os
import pathlib
import sys
import tempfile

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
HERE = pathlib.Path(__file__).resolve()
ROOT = HERE.parents[2]
sys.path.insert(0, str(HERE.parents[1] / "robots"))

import numpy as np

import by_opensees
from compared_robots import apart, printed, robots, sag_of, set_to
from random_robots import random_robot
from robot_file import RobotFile, structure

# Both solutions are linear. OpenSees' rigid joints are springs, 1e4 to 1e6 times as stiff as the others: extrapolated they leave the square of that
# ratio and the rounding of stiffnesses that far apart, 3e-8 here.
TOLERANCE = 1e-6
# An entry is compared with the root of the product of its diagonal entries; where a direction is rigid, with this share of the largest, a
# metre for a radian.
RIGID_SHARE = 1e-3
FIXTURE = ROOT / "fixtures" / "opensees" / "random_robots.csv"
KEPT = [1, 45, 53]
ROWS, LOADS = ("ux", "uy", "uz", "rx", "ry", "rz"), ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def distance(found, expected):
    """Largest difference of two compliances as a share of the root of the product of the diagonal entries."""
    size = np.sqrt(np.abs(np.diag(expected)))
    size = np.maximum(size, RIGID_SHARE * size.max())
    return float(np.abs((found - expected) / np.outer(size, size)).max())


def text_of(robot):
    file = pathlib.Path(robot)
    return (file if file.suffix == ".toml" else ROOT / "data" / "robots" / f"{robot}.toml").read_text()


def compare(program, robot, file):
    """Poses compared, the largest distance of their compliances, and those of mass and sag."""
    sagging = sag_of(program, robot)
    poses = [(["--pose", name], values) for name, values in file.poses().items()]
    if sagging:
        poses.append((set_to(sagging[0]), sagging[0]))
    worst = 0.0
    for options, values in poses:
        made, loaded = structure(file, values)
        for theory in ([], ["--timoshenko"]):
            ours = printed(program, "robot", "compliance", robot, *options, *theory)["compliance"]
            worst = max(worst, distance(by_opensees.compliance(made, loaded, bool(theory)), np.array(ours)))
    if not sagging:
        return len(poses), worst, None
    _, mass_kg, sag_m = sagging
    # The last structure stands in the pose of the sag.
    of_sag = apart(by_opensees.sag(made, loaded, file.up)[:3], sag_m)
    return len(poses), worst, max(of_sag, abs(by_opensees.mass(made) / mass_kg - 1.0))


def write():
    """The fixture: compliance and sag of some random robots in their pose, and their files."""
    with open(FIXTURE, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["robot", "pose", "theory", *(f"c_{row}_{load}" for row in ROWS for load in LOADS), *(f"sag_{row}" for row in ROWS), "mass_kg"])
        for seed in KEPT:
            text = random_robot(seed)
            (ROOT / "fixtures" / "cases" / "random-robots" / f"robot-{seed}.toml").write_text(text)
            robot = RobotFile(text)
            made, loaded = structure(robot, robot.poses()["P1"])
            sag, mass_kg = by_opensees.sag(made, loaded, robot.up), by_opensees.mass(made)
            for theory in ("euler-bernoulli", "timoshenko"):
                found = by_opensees.compliance(made, loaded, theory == "timoshenko")
                writer.writerow([f"robot-{seed}", "P1", theory, *(f"{float(value):.16e}" for value in (*found.ravel(), *sag, mass_kg))])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--write", action="store_true", help="write fixtures/opensees/random_robots.csv")
    options = parser.parse_args()
    if options.write:
        write()
        return 0
    program = str(pathlib.Path(options.program).resolve())
    failed, largest, counted = 0, [0.0, 0.0], [0, 0, 0]
    with tempfile.TemporaryDirectory() as folder:
        for robot in robots(program, folder):
            name, text = pathlib.Path(robot).stem, text_of(robot)
            if 'schema = "stiffbench/robot/2"' not in text:
                print(f"{name}: of the older format, see fixtures/opensees")
                continue
            poses, of_compliance, of_sag = compare(program, robot, RobotFile(text))
            ok = max(of_compliance, of_sag or 0.0) <= TOLERANCE
            failed += not ok
            largest = [max(largest[0], of_compliance), max(largest[1], of_sag or 0.0)]
            counted = [counted[0] + 1, counted[1] + poses, counted[2] + (of_sag is not None)]
            line = f"{name}: {poses} poses, compliance differs by {of_compliance:.1e}"
            print(f"{line}{'' if of_sag is None else f', sag by {of_sag:.1e}'}{'' if ok else '  FAILED'}", flush=True)
    print(f"{counted[0]} robots in {counted[1]} poses: compliance differs by {largest[0]:.1e} at most, of {counted[2]} with masses the sag by {largest[1]:.1e}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
