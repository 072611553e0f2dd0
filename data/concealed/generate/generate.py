#!/usr/bin/env python3
"""Make the concealed benches anew: sessions, sealed answers, development answers, list of both sets.

    python data/concealed/generate/generate.py [--second] [--only K ...] [--out FOLDER]

README.md describes what comes out.  Same seed, same files.
"""

import argparse
import dataclasses
import hashlib
import json
import os
import shutil
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy comes in: same bytes whatever the machine

import numpy as np

import catalogue
import more_poses
import sets
import validation
from bench import Bench
from catalogue import Entry
from effects import unit_of
from information import Information, parameter_errors
from noise import Noise
from plan import Plan, Table, take
from recipes import NotReachable, absorbed, beside, impossible_rival, share
from rivals import Library, left_by_library, rivals_of
from session_folder import ARCHIVE, pack, write_session
from structures import PROPERTIES, ROOT, Robot

SEED = 20260611
SECOND_SEED = 20261120
HERE = ROOT / "data" / "concealed"
OUTSIDE = ("joint-plasticity", "joint-asymmetric-cubic", "quadratic-drift", "load-dependent-creep", "gauge-two-harmonics", "brace")


def identity(index: int, seed: int = SEED) -> str:
    return hashlib.sha256(f"bench {seed} {index}".encode()).hexdigest()[:8]


def make(entry: Entry, index: int, seed: int = SEED) -> tuple[Bench, Noise, Plan, list, Information, np.ndarray, Robot]:
    """One bench with its effects sized, and its readings in µm; other factors are drawn until sizes can be reached."""
    robot = Robot(str((HERE / "sessions" / "any" / catalogue.ROBOTS[entry.robot]).resolve()))
    for attempt in range(8):
        rng = np.random.default_rng([seed, index, attempt])
        plan, noise = catalogue.plan_of(entry), catalogue.noise_of(entry, rng)
        start = robot.data["factors"]["m_fsd"]
        beam = {name: float(f"{start['beam'][name] * np.exp(rng.uniform(np.log(0.55), np.log(1.8))):.5g}") for name in PROPERTIES}
        poses = [{k: v for k, v in robot.data["poses"][name].items() if k in robot.variables} for name in plan.poses]
        bench = Bench(robot, entry.mechanism, poses, beam, start["link"], take(plan, rng))
        information = Information(bench, noise)
        try:
            effects = [draw(information, rng, size) for draw, size in zip(entry.draws, entry.sizes)]
        except NotReachable:
            continue
        readings = noise.readings_um(bench.displacement(effects), rng)
        return bench, noise, plan, effects, information, readings, robot
    raise NotReachable(f"bench {index} ({entry.mode}, {entry.robot} {entry.mechanism}): no place reaches {entry.sizes}")


def truth_of(information: Information, library: Library, effects: list) -> list[dict]:
    errors = parameter_errors(information, effects)
    truths = []
    for k, effect in enumerate(effects):
        others = effects[:k] + effects[k + 1 :]
        change = information.bench.displacement(effects) - information.bench.displacement(others)
        truths.append({
            "physics": effect.physics,
            "place": effect.place,
            "parameters": {
                name: {"value": value, "unit": unit_of(effect, name), "expected_relative_standard_error": errors[k][name]}
                for name, value in effect.parameters.items()
                if name != "per_kelvin"
            },
            "standard_errors": round(information.length(effect), 2),
            "standard_errors_beside_the_others": round(beside(information, effect, others), 2),
            "end_effect_um": round(1e6 * float(np.abs(change).max()), 2),
            "largest_share_of_a_reading": round(share(information, effect, tuple(others)), 4),
            "absorbed_share": round(absorbed(information, effect), 3),
            "rivals": [] if effect.physics in OUTSIDE else rivals_of(library, effect, others),
        })
    return truths


def expected_of(truths: list[dict]) -> str:
    """As in the labelled examples: what cannot be told apart has to be named together."""
    if not truths:
        return "nothing-missing"
    if any(truth["physics"] in OUTSIDE for truth in truths):
        return "unknown"
    verdict = "named"
    for truth in truths:
        nearest = min((rival["standard_errors_between"] for rival in truth["rivals"]), default=np.inf)
        if nearest < 2.0:
            return "ambiguous"
        if nearest < max(4.25, 0.62 * truth["standard_errors_beside_the_others"]):
            verdict = "named-or-ambiguous"
    return verdict


def answer_of(entry: Entry, index: int, made: tuple) -> dict:
    bench, noise, plan, effects, information, readings, robot = made
    library = Library(information)
    truths = truth_of(information, library, effects)
    lengths = [truth["standard_errors_beside_the_others"] for truth in truths]
    answer = {
        "mode": entry.mode,
        "times_80_percent_size": entry.step,
        "expected": expected_of(truths),
        "may_be_missed": any(length < catalogue.UNIT for length in lengths),
        "truth": truths,
    }
    outside = [effect for effect in effects if effect.physics in OUTSIDE]
    if outside:
        fits = left_by_library(library, information.effect(outside[0]))
        answer["library_fits"] = fits
        answer["left_by_library"] = fits[-1]["standard_errors_left"]
        answer["may_be_missed"] = answer["left_by_library"] < catalogue.UNIT
        answer["impossible_rival"] = impossible_rival(information, outside[0])
    training = (0, 2) if len(plan.poses) > 2 else (0,)
    passed, worst = validation.passes(bench, robot.data["factors"]["m_fsd"]["beam"], readings, training)
    recorded = dataclasses.replace(bench.table, force=bench.table.rounded)
    model = Bench(robot, bench.mechanism, bench.poses, bench.multipliers["beam"], bench.multipliers["link"], recorded)
    rest = readings - 1e6 * model.displacement(effects)
    rest = rest - rest.mean(axis=1, keepdims=True)
    answer |= {
        "robot": catalogue.ROBOTS[entry.robot].rsplit("/", 1)[1],
        "mechanism": entry.mechanism,
        "beam_factors": bench.multipliers["beam"],
        "noise": noise.answer(),
        "published_validation_passes": passed,
        "published_validation_worst_percent": None if passed is None or not np.isfinite(worst) else round(worst, 3),
        "floor_rms_um": round(float(np.sqrt(np.mean(rest**2))), 3),
    }
    return answer


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--second", action="store_true", help="make the second proof list beside the others: a third of the benches, from another seed")
    parser.add_argument("--only", type=int, nargs="*", help="make these benches only, and print their answers")
    parser.add_argument("--out", type=Path, default=HERE, help="folder to write to")
    arguments = parser.parse_args()
    more_poses.write()
    entries = catalogue.all_entries()
    seed = SECOND_SEED if arguments.second else SEED
    third = sets.every_third([entry.mode for entry in entries])
    if arguments.only is None and not arguments.second:
        shutil.rmtree(arguments.out / "sessions", ignore_errors=True)
        (arguments.out / ARCHIVE).unlink(missing_ok=True)
    answers = {}
    for index, entry in enumerate(entries):
        if arguments.only is not None and index not in arguments.only or arguments.second and index not in third:
            continue
        began = time.perf_counter()
        try:
            made = make(entry, index, seed)
        except NotReachable as error:
            print(error, file=sys.stderr)
            continue
        name = identity(index, seed)
        answers[name] = answer_of(entry, index, made)
        progress(index, entry, answers[name], time.perf_counter() - began)
        if arguments.only is None:
            bench, noise, plan, _, _, readings, _ = made
            write_session(arguments.out / "sessions" / name, catalogue.ROBOTS[entry.robot], entry.mechanism, plan, noise, bench.table, readings)
    if arguments.only is None:
        (sets.write_second if arguments.second else sets.write)(arguments.out, answers)
        pack(arguments.out, list(answers) if arguments.second else sets.split(answers)[1])
    else:
        print(json.dumps(answers, indent=1))


def progress(index: int, entry: Entry, answer: dict, seconds: float) -> None:
    names = " + ".join(f"{t['physics']} {'/'.join(map(str, t['place'].values()))} {t['standard_errors']}" for t in answer["truth"])
    near = [r["standard_errors_between"] for t in answer["truth"] for r in t["rivals"][:1]]
    print(f"{index:3d} {entry.mode:3s} {entry.robot:8s}{entry.mechanism:7s}{names or '-':60s} {answer['expected']:18s} nearest {near} "
          f"left {answer.get('left_by_library')} passes {answer['published_validation_worst_percent']} {seconds:.1f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
