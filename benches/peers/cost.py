#!/usr/bin/env python3
"""How the time of a sweep grows with the number of poses and with the number of elements: a figure and the fitted exponents.

    python cost.py [--out cost.png] [--seconds N] [--json FILE]

Runs `cargo bench --bench sweep`, which measures and fits; `--json` draws what it printed before instead.  The ladder of the second panel
has no two elements in series or side by side, so that every node must be eliminated.
"""

import argparse
import json
import math
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

ROOT = Path(__file__).resolve().parents[2]


def measured(seconds: float) -> dict:
    command = ["cargo", "bench", "--bench", "sweep", "--", "--seconds", str(seconds)]
    output = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    return json.loads(output[output.index("{") :])


def panel(axes, points, exponent, unit, factor, label) -> None:
    sizes = [size for size, _ in points]
    times = [time * factor for _, time in points]
    # The line of the fitted slope through the mean of the logarithms.
    centre = [math.exp(sum(map(math.log, values)) / len(values)) for values in (sizes, times)]
    line = [centre[1] * (size / centre[0]) ** exponent for size in sizes]
    axes.loglog(sizes, line, color="0.6", linewidth=1.2, zorder=1)
    axes.loglog(sizes, times, "o", color="#0072b2", zorder=2)
    axes.annotate(f"exponent {exponent:.2f}", (0.06, 0.9), xycoords="axes fraction")
    axes.set_xlabel(label)
    axes.set_ylabel(f"time, {unit}")
    axes.grid(which="major", color="0.9")
    axes.set_axisbelow(True)
    # Sizes as plain numbers, not as powers of ten with few of them.
    axes.set_xticks(sizes, [f"{size:,.0f}".replace(",", "\u202f") for size in sizes], rotation=30)
    axes.minorticks_off()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("cost.png"))
    parser.add_argument("--seconds", type=float, default=0.5)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    found = json.loads(arguments.json.read_text()) if arguments.json else measured(arguments.seconds)
    exponents, points = found["exponents"], found["points"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    panel(left, points["poses, s"], exponents["poses"], "ms", 1e3, "poses of mechanism F, one core")
    panel(right, points["elements, s per pose"], exponents["elements"], "us a pose", 1e6, "elements of a ladder, one core")
    figure.savefig(arguments.out, dpi=150)
    for name, value in exponents.items():
        print(f"time grows with the number of {name} to the power {value:.3f}")
    print(f"{arguments.out} written")


if __name__ == "__main__":
    main()
