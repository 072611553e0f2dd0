#!/usr/bin/env python3
"""Make benches of one row: session folders and robot files, and answers.json beside them.

    python data/reality/generate/generate.py --row setup --count 105 --seed 30001 --out /path/of/your/choice

../README.md describes rows and answers.  Same row, seed and count: same files, for any number of jobs.
"""

import argparse
import hashlib
import json
import os
import sys
import time
import tomllib
import zlib
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy comes in: same bytes whatever the machine

import numpy as np

import shared
from recipes import NotReachable
from rows import ATTEMPTS, ROWS, Made
from session_folder import write_session

LISTS = tomllib.loads((shared.HERE / "seeds.toml").read_text())


def list_of(seed: int) -> str:
    """The list that a seed belongs to."""
    return next((name for name in ("tuning", "reporting") if LISTS[name][0] <= seed <= LISTS[name][1]), "none")


def identity(*parts) -> str:
    return hashlib.sha256(" ".join(map(str, parts)).encode()).hexdigest()[:10]


def made_at(row: str, seed: int, index: int) -> list[Made]:
    """The benches at one place of a row (two where they are a pair); drawn again until the wanted size is reached."""
    reason = None
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, zlib.crc32(row.encode()), index, attempt])
        try:
            return ROWS[row](index, rng)
        except NotReachable as error:
            reason = error
    raise NotReachable(f"{row} {index}: no bench in {ATTEMPTS} draws ({reason})")


def write(row: str, seed: int, index: int, out: Path) -> dict:
    """Write the sessions of one place; their answers by id."""
    began = time.perf_counter()
    try:
        benches = made_at(row, seed, index)
    except NotReachable as error:
        print(error, file=sys.stderr)
        return {}
    ids = [identity(row, seed, index, k) for k in range(len(benches))]
    answers = {}
    for k, (name, made) in enumerate(zip(ids, benches)):
        robot = f"robot-{identity(made.text)}.toml"
        (out / "robots").mkdir(parents=True, exist_ok=True)
        (out / "robots" / robot).write_text(made.text)
        write_session(out / name, f"../robots/{robot}", made.mechanism, made.plan, made.noise, made.table, made.readings)
        answers[name] = {"row": row, "index": index, "robot_file": f"robots/{robot}", "session_mechanism": made.mechanism, **made.answer}
        if len(ids) > 1:
            answers[name]["without" if k == 0 else "with"] = ids[1 - k]
    took = time.perf_counter() - began
    first = answers[ids[0]]
    names = ", ".join(f"{t['name']} {t['standard_errors']}" for t in first["truth"])
    print(f"{row} {index} {first['robot']} {first['mechanism']}: {first['kind']} {names} {took:.1f} s", file=sys.stderr)
    return answers


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--row", choices=ROWS, required=True)
    parser.add_argument("--count", type=int, required=True, help="places of the row; a pair is one place")
    parser.add_argument("--first", type=int, default=0, help="first place [default: 0]")
    parser.add_argument("--every", type=int, default=1, help="each N-th place only: 15 keeps power and bad rows to one law [default: 1]")
    parser.add_argument("--seed", type=int, required=True, help="../seeds.toml states which are for tuning and which for reporting")
    parser.add_argument("--out", type=Path, required=True, help="folder, new or with other rows in it")
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    file = arguments.out / "answers.json"
    old = json.loads(file.read_text()) if file.exists() else {"schema": "stiffbench/reality-answers/1", "made": [], "benches": {}}
    places = range(arguments.first, arguments.first + arguments.count * arguments.every, arguments.every)
    clash = {identity(arguments.row, arguments.seed, index, 0) for index in places} & set(old["benches"])
    if clash:
        sys.exit(f"{file} holds benches of row {arguments.row}, seed {arguments.seed} already: choose another folder or --first")
    jobs = [(arguments.row, arguments.seed, index, arguments.out) for index in places]
    if arguments.jobs > 1:
        with ProcessPoolExecutor(arguments.jobs) as pool:
            answers = list(pool.map(write, *zip(*jobs)))
    else:
        answers = [write(*job) for job in jobs]
    for one in answers:
        old["benches"].update(one)
    made = {name: getattr(arguments, name) for name in ("row", "first", "count", "every", "seed")}
    old["made"].append({**made, "list": list_of(arguments.seed)})
    file.write_text(json.dumps(old, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
