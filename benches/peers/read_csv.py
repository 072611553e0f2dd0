#!/usr/bin/env python3
"""Reading a session's readings.csv with a million rows: time and peak memory of three Python readers.

    python read_csv.py [--file FILE] [--rows N] [--json]
    python read_csv.py --generate FILE [--rows N]        write the file and stop

  csv     the standard library's csv module, columns as lists, numbers converted
  pandas  read_csv with its C parser
  numpy   loadtxt into a structured array

Each reader runs in a process of its own on one core; the time is that of the reading alone, the file
being in the page cache; the peak is that of the whole process.  All must agree on the number of
accepted rows and on the sums of force and displacement over them.
"""

import argparse
import csv
import datetime
import itertools
import json
import os
import random
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

COLUMNS = (
    "session seq utc t_s pose direction branch step target_N repeat attempt force_N force_raw "
    "displacement_um displacement_raw hold_s temp_degC status flag note"
).split()
INTEGERS = {"seq", "step", "repeat", "attempt"}
NUMBERS = {"t_s", "target_N", "force_N", "displacement_um", "hold_s", "temp_degC"}
READERS = ("csv", "pandas", "numpy")


def generate(path: Path, rows: int) -> None:
    """A very long session: five repeats per pose and direction, again and again.

    One reading in fifty is rejected and taken again as the next attempt.
    """
    source = random.Random(3)
    start = datetime.datetime(2025, 10, 12, 9, 40, tzinfo=datetime.timezone.utc)
    stiffness = {"x": 0.0105, "y": 0.027, "z": 0.21}
    clock, temperature = 0.0, 21.0
    points = plan()
    attempt = 1
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for seq in range(1, rows + 1):
            if attempt == 1:
                pose, direction, repeat, branch, step, target = next(points)
            clock += source.uniform(8.0, 14.0)
            temperature += source.gauss(0.0, 0.002)
            force = round(target + source.uniform(-0.4, 0.4), 1) if target else 0.0
            displacement = round(force / stiffness[direction] + source.gauss(0.0, 2.0))
            rejected = attempt == 1 and source.random() < 0.02
            stamp = (start + datetime.timedelta(seconds=clock)).isoformat(timespec="milliseconds")
            writer.writerow(
                [
                    "6b9c77df", seq, stamp.replace("+00:00", "Z"), f"{clock:.2f}", pose, direction, branch, step,
                    target, repeat, attempt, f"{force:.1f}", f"{force:.1f}", displacement, displacement,
                    f"{source.uniform(3.0, 7.0):.1f}", f"{temperature:.2f}",
                    "rejected" if rejected else "accepted", "operator" if rejected else "",
                    "gauge touched, taken again" if rejected else "",
                ]
            )
            attempt = 2 if rejected else 1


def plan():
    """Test points in order, for ever; steps count on through unloading, repeats from round to round."""
    for cycle in itertools.count():
        for pose, direction in itertools.product(("P1", "P2", "P3", "P4"), "xyz"):
            for repeat in range(5 * cycle + 1, 5 * cycle + 6):
                for step in range(15):
                    branch = "loading" if step < 8 else "unloading"
                    yield pose, direction, repeat, branch, step, -10 * (7 - abs(step - 7))


def read_with_csv(path: str) -> tuple[int, int, float, float]:
    convert = [int if name in INTEGERS else float if name in NUMBERS else str for name in COLUMNS]
    columns: list[list] = [[] for _ in COLUMNS]
    with open(path, newline="") as file:
        reader = csv.reader(file)
        if next(reader) != COLUMNS:
            raise ValueError("unexpected columns")
        appends = [(column.append, kind) for column, kind in zip(columns, convert)]
        for row in reader:
            for (append, kind), text in zip(appends, row, strict=True):
                append(text if kind is str else kind(text))
    table = dict(zip(COLUMNS, columns))
    accepted = [status == "accepted" for status in table["status"]]
    force = sum(value for value, keep in zip(table["force_N"], accepted) if keep)
    displacement = sum(value for value, keep in zip(table["displacement_um"], accepted) if keep)
    return len(accepted), sum(accepted), force, displacement


def read_with_pandas(path: str) -> tuple[int, int, float, float]:
    import pandas

    types = {name: "int64" if name in INTEGERS else "float64" for name in INTEGERS | NUMBERS}
    table = pandas.read_csv(path, dtype=types, engine="c", keep_default_na=False)
    accepted = table[table["status"] == "accepted"]
    sums = accepted[["force_N", "displacement_um"]].sum()
    return len(table), len(accepted), float(sums["force_N"]), float(sums["displacement_um"])


def read_with_numpy(path: str) -> tuple[int, int, float, float]:
    import numpy as np

    kinds = [
        (name, "i8" if name in INTEGERS else "f8" if name in NUMBERS else "U32") for name in COLUMNS
    ]
    table = np.loadtxt(path, dtype=kinds, delimiter=",", skiprows=1, quotechar='"', comments=None)
    accepted = table["status"] == "accepted"
    force, displacement = table["force_N"][accepted].sum(), table["displacement_um"][accepted].sum()
    return len(table), int(accepted.sum()), float(force), float(displacement)


def peak_mib() -> float:
    """Peak resident memory of this process.

    VmHWM where there is one: ru_maxrss may begin with the peak of the process that started this one.
    """
    try:
        with open("/proc/self/status") as status:
            kib = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return kib / 1024


def one(reader: str, path: str, core: int | None) -> None:
    """Read once in this process and print what was found, as JSON."""
    if core is not None:
        os.sched_setaffinity(0, {core})
    if reader != "csv":
        __import__(reader)
    before = peak_mib()
    read = {"csv": read_with_csv, "pandas": read_with_pandas, "numpy": read_with_numpy}[reader]
    start = time.perf_counter()
    rows, accepted, force, displacement = read(path)
    seconds = time.perf_counter() - start
    peak = peak_mib()
    print(
        json.dumps(
            {
                "seconds": seconds, "peak_mib": peak, "imports_mib": before, "rows": rows,
                "accepted": accepted, "force_N": round(force, 3), "displacement_um": round(displacement),
            }
        )
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--file", type=Path, help="an existing file (default: a generated temporary one)")
    parser.add_argument("--generate", type=Path, metavar="FILE", help="write FILE and stop")
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--core", type=int, help="core to stay on (default: the first allowed)")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--one", choices=READERS, help=argparse.SUPPRESS)
    arguments = parser.parse_args()

    if arguments.generate:
        generate(arguments.generate, arguments.rows)
        return
    core = arguments.core
    if core is None and hasattr(os, "sched_getaffinity"):
        core = min(os.sched_getaffinity(0))
    if arguments.one:
        one(arguments.one, str(arguments.file), core)
        return

    with tempfile.TemporaryDirectory() as folder:
        path = arguments.file
        if path is None:
            path = Path(folder) / "readings.csv"
            generate(path, arguments.rows)
        with open(path, "rb") as file:
            while file.read(1 << 20):
                pass
        runs: dict[str, list[dict]] = {reader: [] for reader in READERS}
        for _ in range(arguments.rounds):
            for reader in READERS:
                command = [sys.executable, __file__, "--one", reader, "--file", str(path)]
                if core is not None:
                    command += ["--core", str(core)]
                answer = subprocess.run(command, check=True, capture_output=True, text=True)
                runs[reader].append(json.loads(answer.stdout))
        size = path.stat().st_size
    found = {tuple(run[key] for key in ("rows", "accepted", "force_N", "displacement_um"))
             for several in runs.values() for run in several}
    if len(found) != 1:
        raise SystemExit(f"the readers disagree: {sorted(found)}")
    rows, accepted, *_ = found.pop()
    result = {
        "benchmark": "read_csv", "rows": rows, "accepted": accepted, "bytes": size, "core": core,
        "rounds": arguments.rounds, "readers": {},
    }
    text = []
    for reader, several in runs.items():
        seconds = [run["seconds"] for run in several]
        peak = max(run["peak_mib"] for run in several)
        result["readers"][reader] = {
            "seconds": {"median": statistics.median(seconds), "min": min(seconds), "max": max(seconds)},
            "peak_mib": peak,
            "imports_mib": max(run["imports_mib"] for run in several),
        }
        text.append(
            f"read_csv {reader}: {statistics.median(seconds):.2f} s for {rows} rows, {size / 1e6:.0f} MB "
            f"(median of {arguments.rounds} rounds, {min(seconds):.2f} to {max(seconds):.2f}), "
            f"peak {peak:.0f} MiB, one core"
        )
    print(json.dumps(result, indent=2) if arguments.json else "\n".join(text))


if __name__ == "__main__":
    main()
