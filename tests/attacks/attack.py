#!/usr/bin/env python3
"""Attacks a program that guides stiffness measurements: does a false value ever get in unflagged?

usage: attack.py PROGRAM [--only TEXT] [--jobs N] [--quick] [--json FILE] [--logs FOLDER] [--list]
"""

import argparse
import dataclasses
import json
import os
import signal
import sys
import time
import traceback
from concurrent.futures import ThreadPoolExecutor

import attacks
from bench import LIVE, LONGEST_S, Session
from judge import judge

WORDS = {"false accepted": "FALSE", "not knowable": "limit", "hung": "HUNG", "flagged": "flagged", "stopped": "stopped", "recovered": "recovered"}


def one(attack, program, logs, seed, longest_s):
    session = Session(attack, program, seed, longest_s)
    try:
        session.run()
        result = judge(session)
    except Exception:       # a fault of the rig is shown as one
        result = {"name": attack.name, "verdict": "rig failed", "error": traceback.format_exc(), "fired": False, "false": [],
                  "reason": traceback.format_exc().strip().splitlines()[-1], "accepted": 0, "flagged": 0, "seconds": 0.0,
                  "questions": {}, "false_then_superseded": 0, "outcome": "none", "why": attack.why, "codes": []}
    if logs:
        os.makedirs(logs, exist_ok=True)
        name = "".join(c if c.isalnum() else "-" for c in attack.name)
        with open(os.path.join(logs, name + ".log"), "w", encoding="utf-8") as file:
            file.write("\n".join(session.log) + "\n\n" + json.dumps(result, indent=1) + "\n")
            for table in ("readings.csv",):
                path = os.path.join(session.out, table)
                if os.path.exists(path):
                    with open(path, encoding="utf-8") as source:
                        file.write("\n" + source.read())
    session.clean()
    return result


def line(result):
    what = "; ".join(f"{row['reading']}: {', '.join(row['what'])}" for row in result["false"])
    note = what or result["reason"]
    if not result["fired"]:
        note = "(did not come about) " + note
    asked = " ".join(f"{name}x{n}" for name, n in result["questions"].items())
    return (f"{WORDS.get(result['verdict'], result['verdict']):10} {result['name']:72} {result['accepted']:3} ok-looking"
            f" {result['flagged']:2} flagged {result['seconds']:6.1f} s  {asked}{'  ' if asked else ''}{note[:230]}")


def stop_all(*_):
    """No program that was started here is left behind."""
    for proc in list(LIVE):
        proc.kill()
    os._exit(130)


def main():
    signal.signal(signal.SIGINT, stop_all)
    signal.signal(signal.SIGTERM, stop_all)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", nargs="?", help="path of the program")
    parser.add_argument("--only", action="append", default=[], help="attacks whose name contains this")
    parser.add_argument("--jobs", type=int, help="sessions at a time; they mostly wait (default 16, with --quick 40)")
    parser.add_argument("--quick", action="store_true", help="the attacks that tell most, in about a minute")
    parser.add_argument("--json", metavar="FILE", help="results as JSON; - for standard output")
    parser.add_argument("--logs", metavar="FOLDER", help="keep what was said and done in each session")
    parser.add_argument("--list", action="store_true", help="name the attacks and end")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    chosen = [a for a in attacks.ALL if not args.quick or a.quick]
    if args.only:
        chosen = [a for a in attacks.ALL if any(text in a.name for text in args.only)]
    if args.quick:
        # Each load once is enough; somebody who gives up sooner, too.
        shorter = {"short": "once", "stiff": "stiff once"}
        chosen = [dataclasses.replace(a, procedure=shorter.get(a.procedure, a.procedure), patience=12.0) for a in chosen]
    if args.list:
        print("\n".join(a.name for a in chosen))
        return 0
    if not args.program or not chosen:
        parser.error("no program, or no attack of that name")
    program = os.path.abspath(args.program)
    began = time.monotonic()
    results = []
    out = sys.stderr if args.json == "-" else sys.stdout
    with ThreadPoolExecutor(args.jobs or (40 if args.quick else 16)) as pool:
        # Long ones first.
        order = sorted(chosen, key=lambda a: a.procedure != "slow")
        longest_s = 34.0 if args.quick else LONGEST_S
        waiting = [pool.submit(one, attack, program, args.logs, args.seed, longest_s) for attack in order]
        for done in waiting:
            results.append(done.result())
            print(line(results[-1]), file=out, flush=True)
    controls = [r for r in results if r["name"].startswith("control")]
    false = [r for r in results if r["verdict"] == "false accepted"]
    hung = [r for r in results if r["verdict"] == "hung"]
    broken = [r for r in results if r["verdict"] == "rig failed"]
    bad = [r for r in controls if r["verdict"] != "recovered"]
    idle = [r for r in results if not r["fired"]]
    counted = len(results) - len(controls)
    print(f"\n{counted} attacks and {len(controls)} controls, {sum(len(r['false']) for r in false)} false values accepted in {len(false)} "
          f"sessions, {len(hung)} hung; {sum(r['verdict'] == 'flagged' for r in results)} flagged, "
          f"{sum(r['verdict'] == 'stopped' for r in results)} stopped, {sum(r['verdict'] == 'recovered' for r in results)} recovered, "
          f"{sum(r['verdict'] == 'not knowable' for r in results)} false where nobody could know; "
          f"{len(bad)} controls not clean, {len(idle)} attacks did not come about, {len(broken)} faults of the rig; "
          f"{time.monotonic() - began:.0f} s", file=out)
    if args.json:
        text = json.dumps({"schema": "stiffbench/attacks/1", "attacks": counted, "controls": len(controls),
                           "false_values": sum(len(r["false"]) for r in false), "false_sessions": len(false), "hung": len(hung),
                           "controls_not_clean": [r["name"] for r in bad], "results": results}, indent=1)
        if args.json == "-":
            print(text)
        else:
            with open(args.json, "w", encoding="utf-8") as file:
                file.write(text + "\n")
    return 2 if broken or bad else 1 if false or hung else 0


if __name__ == "__main__":
    sys.exit(main())
