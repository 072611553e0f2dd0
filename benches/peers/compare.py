#!/usr/bin/env python3
"""The Rust benchmarks and their Python peers in one run, side by side, with the ratios.

    python compare.py [--sweeps] [--rounds N] [--core N] [--json]

Each round runs the peers and the Rust benchmarks one after the other on the same core; a ratio is formed
inside its round, and the median over the rounds is given with the extremes.  `cargo bench --no-run` is
called first, so that nothing is compiled between the measurements.  `--sweeps` leaves out refits and
readings: poses per second of mechanism F by every program, one and all cores, and the share of the peak.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BENCHES = ("pose_solve", "sweep", "refit", "read_readings")
# Prints its own figures; the others are criterion's.
OWN_FIGURES = "sweep"
SWEEPS = (
    "solve", "solve, all cores", "solve in space", "solve in space, all cores", "place",
    "both, one core", "both, all cores", "both in space, one core", "both in space, all cores",
)
# What pose_solve.py calls its peers, and what they are: every operation over poses, LAPACK's banded Cholesky, the same algorithm over poses.
PEERS = {"dense": "numpy batched", "band": "scipy banded", "fronts": "numpy fronts"}
# Names of benchmarks, as their files give them; poses solved together as in pose_solve.rs.
POSES = 64
POSE_SOLVES = ("together/given", "together/placed", "single/given", "single/placed")
REFITS = "1000 refits"
ONE_REFIT = "one, set-up included"
READERS = ("csv", "pandas", "numpy")


def build(benches: tuple[str, ...]) -> dict[str, str]:
    """Paths of the benchmark programs."""
    command = ["cargo", "bench", "--no-run", "--message-format=json"]
    for bench in benches:
        command += ["--bench", bench]
    output = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    messages = [json.loads(line) for line in output.splitlines() if line.startswith("{")]
    return {
        message["target"]["name"]: message["executable"]
        for message in messages
        if message.get("executable") and message["target"]["name"] in benches
    }


def peer(script: str, *arguments: str) -> dict:
    command = [sys.executable, str(HERE / script), "--json", *arguments]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    # OpenSees takes leave on standard output.
    return json.JSONDecoder().raw_decode(output)[0]


def criterion(program: str, seconds: float) -> None:
    # Criterion writes its estimates below the working directory's target/criterion.
    command = [program, "--bench", "--noplot", "--warm-up-time", "0.5", "--measurement-time", str(seconds)]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def sweep(program: str, seconds: float, cores: set[int]) -> dict:
    """Figures of the sweep, which may use all cores."""
    command = [program, "--bench", "--seconds", str(seconds / 2)]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True,
                            preexec_fn=lambda: os.sched_setaffinity(0, cores))
    return json.loads(output.stdout)


def median_us(group: str, name: str) -> float:
    folder = ROOT / "target" / "criterion" / group / name.replace("/", "_")
    with open(folder / "new" / "estimates.json", encoding="utf-8") as file:
        return json.load(file)["median"]["point_estimate"] / 1e3


def sweeps_round(programs: dict[str, str], core: int, cores: set[int], seconds: float) -> tuple[dict[str, float], dict]:
    """Microseconds of a pose by every program, and all of the sweep."""
    pinned = ("--core", str(core))
    poses = peer("pose_solve.py", "--rounds", "1", "--seconds", str(seconds), *pinned)
    compiled = peer("pose_compiled.py", "--rounds", "1", "--seconds", str(seconds), *pinned)
    swept = sweep(programs[OWN_FIGURES], seconds, cores)
    figures = {PEERS[name]: row["us_per_pose"]["median"] for name, row in poses["peers"].items()}
    figures |= {name: row["us_per_pose"]["median"] for name, row in compiled["peers"].items()}
    figures |= {f"sweep {name}": swept["us_per_pose"][name] for name in SWEEPS}
    return figures, swept


def rest_of_round(programs: dict[str, str], core: int, seconds: float) -> dict[str, float]:
    """Microseconds: of a pose for the solves, of a refit for the refits, of a million rows for the reads."""
    pinned = ("--core", str(core))
    refits = peer("refit.py", "--rounds", "1", *pinned)
    reads = peer("read_csv.py", "--rounds", "1", *pinned)
    for name, program in programs.items():
        if name != OWN_FIGURES:
            criterion(program, seconds)
    figures = {f"rust {name}": median_us("pose_solve", name) / POSES for name in POSE_SOLVES}
    figures["scipy refit"] = 1e3 * refits["ms_per_refit"]["median"]
    figures["scipy refit, cold"] = 1e3 * refits["cold_single_refit_ms"]
    figures |= {f"python read {name}": 1e6 * row["seconds"]["median"] for name, row in reads["readers"].items()}
    figures["rust read"] = median_us("read_readings", "one_million_rows")
    figures["rust refit"] = median_us("refit", REFITS) / 1000
    figures["rust refit, cold"] = median_us("refit", ONE_REFIT)
    figures["rust evaluation"] = median_us("refit", "one evaluation")
    figures["rust evaluation, pose by pose"] = median_us("refit", "one evaluation, pose by pose")
    return figures


def spread(values: list[float]) -> dict[str, float]:
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sweeps", action="store_true", help="only what solves poses")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=1.0, help="work per measurement")
    parser.add_argument("--core", type=int, help="core to stay on (default: the first allowed)")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    programs = build((OWN_FIGURES,) if arguments.sweeps else BENCHES)
    cores = os.sched_getaffinity(0)
    core = min(cores) if arguments.core is None else arguments.core
    os.sched_setaffinity(0, {core})
    rounds, sweeps = [], []
    for _ in range(arguments.rounds):
        figures, swept = sweeps_round(programs, core, cores, arguments.seconds)
        if not arguments.sweeps:
            figures |= rest_of_round(programs, core, arguments.seconds)
        rounds.append(figures)
        sweeps.append(swept)
    figures = {name: spread([figure[name] for figure in rounds]) for name in rounds[0]}
    pairs = [
        (PEERS["dense"], "sweep solve"),
        (PEERS["dense"], "sweep solve in space"),
        (PEERS["dense"], "sweep both, one core"),
        (PEERS["dense"], "sweep both in space, one core"),
        (PEERS["band"], "sweep solve"),
        (PEERS["fronts"], "sweep solve"),
        (PEERS["fronts"], "sweep solve in space"),
        ("numba plane", "sweep solve"),
        ("numba space", "sweep solve in space"),
        ("opensees", "sweep solve"),
        ("sweep solve", "sweep solve, all cores"),
        ("sweep solve in space", "sweep solve in space, all cores"),
        ("sweep both, one core", "sweep both, all cores"),
        ("sweep both in space, one core", "sweep both in space, all cores"),
    ]
    if not arguments.sweeps:
        pairs += [(peer, f"rust {ours}") for peer in PEERS.values() for ours in ("together/given", "together/placed", "single/given")]
        pairs += [("scipy refit", "rust refit"), ("scipy refit, cold", "rust refit, cold")]
        pairs += [("rust evaluation, pose by pose", "rust evaluation")]
        pairs += [(f"python read {reader}", "rust read") for reader in READERS]
    ratios = {
        f"{theirs} / {ours}": spread([figure[theirs] / figure[ours] for figure in rounds])
        for theirs, ours in pairs
    }
    load = os.getloadavg()
    if arguments.json:
        print(json.dumps({"rounds": arguments.rounds, "core": core, "load": load,
                          "microseconds": figures, "ratios": ratios, "sweeps": sweeps}, indent=2))
        return
    print(f"median of {arguments.rounds} rounds (extremes), core {core}, load average {load[0]:.1f}\n")
    for name, row in figures.items():
        # Of whatever a figure counts: poses, refits, reads.
        print(f"{name:32} {row['median']:10.3f} us  ({row['min']:.3f} to {row['max']:.3f}), {1e6 / row['median']:,.0f} a second")
    print()
    for name, row in ratios.items():
        print(f"{name:60} {row['median']:8.1f}  ({row['min']:.1f} to {row['max']:.1f})")
    print()
    last = sweeps[-1]
    for how in last["how"]:
        print(how)
    print(f"{last['instructions']}, {last['lanes']} poses at once; {last['peak_gflops']:.0f} GFLOP/s is the peak of a core, share reached: "
          + ", ".join(f"{name} {100 * share:.0f} %" for name, share in last["share of peak"].items()))
    print("study of six mechanisms: " + ", ".join(f"{name[:-3]} {value:.3f} s" for name, value in last["study"].items()))
    print("exponents of cost: " + ", ".join(f"{name} {value:.2f}" for name, value in last["exponents"].items()))


if __name__ == "__main__":
    main()
