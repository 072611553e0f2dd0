"""Writes readings.csv: the 43 load cases of the FANUC R-2000iC as one table.

Usage: python3 convert.py FOLDER, with joint_angles.csv (rad, teach pendant), forces.csv (N) and deflections.csv (m) of the source.
Row n of the three files belongs together: one application of a force in one pose.
"""

import csv
import math
import pathlib
import sys


def rows(path):
    with open(path, newline="") as file:
        return [[float(field) for field in row] for row in list(csv.reader(file))[1:] if row and row[0]]


def main():
    source = pathlib.Path(sys.argv[1])
    angles, forces, deflections = (rows(source / f"{name}.csv") for name in ("joint_angles", "forces", "deflections"))
    assert len(angles) == len(forces) == len(deflections) == 43
    header = ["pose"] + [f"joint_J{i}_deg" for i in range(1, 7)] + ["axes"]
    header += [f"force_{axis}_N" for axis in "xyz"] + [f"displacement_{axis}_um" for axis in "xyz"]
    here = pathlib.Path(__file__).parent
    with open(here / "readings.csv", "w", newline="") as file:
        file.write("# Liu, Feng, Jin (Shanghai Jiao Tong University), MIT licence: see LICENSE and README.md\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(header)
        for number, (angle, force, deflection) in enumerate(zip(angles, forces, deflections), 1):
            table.writerow(
                [number]
                + [f"{math.degrees(value):.9f}" for value in angle]
                + ["base"]
                + [f"{value:.9g}" for value in force]
                + [f"{value * 1e6:.9g}" for value in deflection]
            )


main()
