#!/usr/bin/env python3
"""How the time and memory of `stiffbench diagnose` grow with the readings.

    python3 benches/growth.py target/release/stiffbench            # up to 9000 readings
    python3 benches/growth.py --most 27000 OLD NEW                 # two programs by turns, the same sessions

Sessions of the shipped robot with a springy joint, all made by the first program: more repeats, more poses, more loads; the same with other noise
added to the readings: correlated within runs, long tails, bad readings. A row holds wall seconds, CPU seconds and peak memory of the whole command,
figures included. Needs Python 3.9 or later on Linux, and nothing else.
"""

import argparse
import csv
import io
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EFFECT = "joint-compliance@A3:c=2e-6rad/(N*m)"


def run(arguments):
    """Wall seconds, CPU seconds and peak memory (MB) of a command that must succeed."""
    start = time.monotonic()
    child = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    message = child.stderr.read().decode()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(f"{' '.join(map(str, arguments))}: {message}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def simulate(program, folder, procedure, repeats, robot=None):
    arguments = [program, "simulate", folder, "--procedure", procedure, "--repeats", str(repeats), "--seed", "7"]
    run(arguments + ["--effect", EFFECT] + (["--robot", robot] if robot else []))
    return folder


def many_poses(folder, example, count):
    """The robot of a session with this many poses, drawn between its first and its fourth."""
    text = (example / "robot.toml").read_text()
    corners = [(397.322, 341.757), (352.567, 290.418), (397.303, 290.158)]
    draw = random.Random(1)
    head, tail = text.split("[poses.P1]", 1)
    poses = []
    for number in range(count):
        a, b = sorted((draw.random(), draw.random()))
        shares = (a, b - a, 1 - b)
        angles = [sum(s * corner[i] for s, corner in zip(shares, corners)) for i in (0, 1)]
        poses.append(f"[poses.Q{number}]\ntheta2 = {angles[0]:.3f}\ntheta3 = {angles[1]:.3f}\n")
    path = folder / "poses.toml"
    path.write_text(head + "".join(poses) + "[poses.P1]" + tail)
    return path, [f"Q{number}" for number in range(count)]


def add_noise(source, target, kind):
    """The same session with further errors in its readings."""
    shutil.copytree(source, target, ignore=shutil.ignore_patterns("diagnosis", "simulation.toml"))
    lines = list(csv.DictReader(io.StringIO((source / "readings.csv").read_text())))
    draw = random.Random(2)
    bad = set(draw.sample(range(len(lines)), 8))
    last, error = None, 0.0
    for place, line in enumerate(lines):
        run_of_line = (line["pose"], line["direction"], line["repeat"])
        if kind == "correlated":
            fresh = draw.gauss(0.0, 6.0)
            error = fresh if run_of_line != last else 0.8 * error + 0.6 * fresh
        elif kind == "long tails":
            error = 4.0 * draw.gauss(0.0, 1.0) / (sum(draw.gauss(0.0, 1.0) ** 2 for _ in range(4)) / 4.0) ** 0.5
        else:
            error = draw.choice([-1, 1]) * draw.uniform(40.0, 300.0) if place in bad else 0.0
        last = run_of_line
        line["displacement_um"] = str(round(float(line["displacement_um"]) + error))
        line["displacement_raw"] = line["displacement_um"]
    with (target / "readings.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, lines[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)
    return target


def sessions(program, folder, most):
    """Name and folder of each session."""
    plain = {}
    for repeats in (5, 15, 50, 150, 500):
        if 180 * repeats <= most:
            plain[repeats] = simulate(program, folder / f"repeats-{repeats}", "load-unload", repeats)
            yield "repeats", plain[repeats]
    for kind in ("correlated", "long tails", "bad readings"):
        for repeats, source in plain.items():
            yield kind, add_noise(source, folder / f"{kind.replace(' ', '-')}-{repeats}", kind)
    procedure = (plain[5] / "session.toml").read_text().split("[procedure]", 1)[1].split("[instruments", 1)[0]
    procedure = procedure.replace("[procedure.", "[")
    for count in (40, 120):
        if 225 * count <= most:
            robot, names = many_poses(folder, plain[5], count)
            path = folder / f"poses-{count}.toml"
            path.write_text(replaced(procedure, "poses", f"{names}".replace("'", '"')))
            yield f"{count} poses", simulate(program, folder / f"poses-{count}", path, 5, robot)
    loads = [round(-70.0 * step / 75, 2) for step in range(76)]
    path = folder / "loads-76.toml"
    path.write_text(replaced(procedure, "loads_N", f"{loads}"))
    yield "76 loads", simulate(program, folder / "loads-76", path, 5)


def replaced(text, key, value):
    lines = text.splitlines()
    return "\n".join(f"{key} = {value}" if line.startswith(f"{key} =") else line for line in lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+", type=Path, metavar="PROGRAM")
    parser.add_argument("--most", type=int, default=9000, help="most readings of a session by repeats or poses (default: 9000)")
    parser.add_argument("--only", help="sessions whose name begins so")
    options = parser.parse_args()
    programs = [program.resolve() for program in options.programs]
    print("| session | readings | " + " | ".join(f"{program.name}: wall, CPU, memory" for program in programs) + " |")
    print("| --- | --- |" + " --- |" * len(programs))
    with tempfile.TemporaryDirectory() as scratch:
        for name, session in sessions(programs[0], Path(scratch), options.most):
            if options.only and not name.startswith(options.only):
                continue
            readings = len((session / "readings.csv").read_text().splitlines()) - 1
            cells = []
            for program in programs:
                wall_s, cpu_s, memory_mb = run([program, "diagnose", session, "--quiet"])
                cells.append(f"{wall_s:.2f} s, {cpu_s:.2f} s, {memory_mb:.0f} MB")
            print(f"| {name} | {readings} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
