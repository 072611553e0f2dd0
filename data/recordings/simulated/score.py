#!/usr/bin/env python3
"""Diagnoses the recordings of generate.py and counts right headlines: score.py --program target/release/stiffbench --set FOLDER"""
import argparse, collections, json, os, subprocess, tempfile
from concurrent.futures import ThreadPoolExecutor

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("--program", required=True)
arguments.add_argument("--set", required=True)
arguments.add_argument("--jobs", type=int, default=2)
options = arguments.parse_args()
with open(os.path.join(options.set, "answers.json"), encoding="utf-8") as file:
    answers = json.load(file)


def said(answer):
    """The verdict and the names of the page, the leading one first."""
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(options.set, answer["file"])
        command = [options.program, "part", "diagnose", table, "--json", "--out", folder]
        data = json.loads(subprocess.run(command, capture_output=True, text=True).stdout).get("data", {})
    names = [finding["physics"] for finding in data.get("findings", [])]
    return data.get("verdict", "error"), names


with ThreadPoolExecutor(options.jobs) as pool:
    pages = list(pool.map(said, answers))
right, kinds = collections.Counter(), collections.Counter()
for answer, (verdict, names) in zip(answers, pages):
    kinds[answer["kind"]] += 1
    accepted = set(answer["right"]) | set(answer["also_right"]) | set(answer["physically"] or [])
    named = {"unknown": ["something-unknown"], "nothing-missing": ["nothing-missing"], "ambiguous": names}.get(verdict, names[:1])
    # Of a set that the page cannot distinguish every member must be right.
    if named and all(name in accepted for name in named):
        right[answer["kind"]] += 1
    else:
        print(answer["file"], answer["kind"], "| accepted:", *sorted(accepted), "| said:", verdict, *names)
for kind, count in sorted(kinds.items()):
    print(f"{kind}: {right[kind]} of {count}")
print(f"all: {sum(right.values())} of {len(answers)}")
