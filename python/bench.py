"""50,000 poses from Python against the same poses from Rust, by turns on this machine: python bench.py [--rounds N] [--most RATIO]

Both sides begin with one contiguous array of poses and end with one of matrices; imports and models are made before. The Rust side is
`cargo bench --bench sweep -- --batch`. The least time of all rounds counts; with --most the exit code is 1 above that ratio.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import stiffbench

ROOT = Path(__file__).resolve().parents[1]
POSES = 50_000
SECONDS = 0.5


def rust_program():
    """The benchmark, built as `cargo bench` builds it."""
    words = ["cargo", "bench", "--locked", "--bench", "sweep", "--no-run", "--message-format", "json"]
    built = subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    messages = [json.loads(line) for line in built.stdout.splitlines() if line.startswith("{")]
    return next(m["executable"] for m in reversed(messages) if m.get("executable") and m["target"]["name"] == "sweep")


def least(work):
    """Least time of a call, s."""
    work()
    end = time.perf_counter() + SECONDS
    found = float("inf")
    while time.perf_counter() < end:
        start = time.perf_counter()
        work()
        found = min(found, time.perf_counter() - start)
    return found


def compare(program, name, rounds):
    robot = stiffbench.Robot(name)
    low, high = robot.limits.T
    poses = np.random.default_rng(0).uniform(low, high, (4 * POSES, len(low)))
    poses = np.ascontiguousarray(poses[robot.within_limits(poses)][:POSES])
    if len(poses) < POSES:
        sys.exit(f"{name}: only {len(poses)} poses are within the limits")
    times = {}
    with tempfile.NamedTemporaryFile(suffix=".f64") as file:
        poses.tofile(file.name)
        for _ in range(rounds):
            words = [program, "--batch", file.name, name, "--seconds", str(SECONDS)]
            rust = json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout)
            python = {kind: least(lambda: getattr(robot, kind)(poses)) for kind in ("compliance", "stiffness")}
            for side, found in [("rust", rust), ("python", python)]:
                for kind, seconds in found.items():
                    times[side, kind] = min(seconds, times.get((side, kind), float("inf")))
    ratios = []
    for kind in ("compliance", "stiffness"):
        ratios.append(times["python", kind] / times["rust", kind])
        python_ms, rust_ms = 1e3 * times["python", kind], 1e3 * times["rust", kind]
        print(f"{name}, {POSES} poses, {kind}: Python {python_ms:.3f} ms, Rust {rust_ms:.3f} ms, ratio {ratios[-1]:.3f}")
    print(f"{name}, {POSES} poses, PoseSweep::run: Rust {1e3 * times['rust', 'PoseSweep::run']:.3f} ms")
    return max(ratios)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--most", type=float, default=float("inf"))
    parser.add_argument("--program", help="the benchmark, if it is built already")
    options = parser.parse_args()
    program = options.program or rust_program()
    largest = max(compare(program, name, options.rounds) for name in ("hp-robot", "fanuc-r2000ic"))
    print(f"largest ratio {largest:.3f}")
    sys.exit(largest > options.most)


if __name__ == "__main__":
    main()
