#!/usr/bin/env python3
"""Run a program over benches of `generate/generate.py`, compare with the answers, and print the counts.

    python data/reality/score.py --program target/release/stiffbench --benches FOLDER --jobs 2 --out results.json

README.md defines what is counted.  Intervals are Clopper-Pearson, 95 %.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from scipy.stats import beta

from judge import Judged, judge

SIX = 6.0  # standard errors of its deleted residual, from which a bad reading has to be named


def interval(k: int, n: int) -> tuple[float, float]:
    """Clopper-Pearson, 95 %, in percent."""
    low = 0.0 if k == 0 else float(beta.ppf(0.025, k, n - k + 1))
    high = 1.0 if k == n else float(beta.ppf(0.975, k + 1, n - k))
    return 100.0 * low, 100.0 * high


class Program:
    """The program under test, one process a session."""

    def __init__(self, path: Path, timeout_s: float, keep: Path | None) -> None:
        self.path, self.timeout_s, self.keep = path.resolve(), timeout_s, keep
        run = subprocess.run([self.path, "diagnose", "--help"], capture_output=True, text=True)
        self.options = ["--no-figures"] if "--no-figures" in run.stdout else []
        self.version = subprocess.run([self.path, "--version"], capture_output=True, text=True).stdout.strip()

    def diagnose(self, session: Path, robot: Path) -> tuple[dict | None, str | None, float]:
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as out:
            command = [self.path, "diagnose", session, "--robot", robot, "--json", "--out", Path(out) / "diagnosis", *self.options]
            try:
                run = subprocess.run(command, capture_output=True, text=True, timeout=self.timeout_s)
                text, error = run.stdout, None
            except subprocess.TimeoutExpired:
                text, error = "", f"no answer in {self.timeout_s:g} s"
        seconds = time.perf_counter() - began
        try:
            envelope = json.loads(text) if text else {}
        except json.JSONDecodeError as problem:
            envelope, error = {}, f"no JSON: {problem}"
        if self.keep and text:
            (self.keep / f"{session.name}.json").write_text(text)
        if not envelope.get("ok"):
            error = error or (envelope.get("error") or {}).get("message") or run.stderr.strip().splitlines()[-1:] or "no answer"
            return None, str(error), seconds
        return envelope["data"], None, seconds


# What a row reports: title, which sessions count, which of them are hits, what is wanted.
Quantity = tuple[str, Callable[[Judged], bool], Callable[[Judged], bool], str]


def quantities(row: str, answers: dict, judged: dict[str, Judged]) -> list[Quantity]:
    everyone = lambda one: True
    bad = lambda one: "bad" in answers[one.id]
    if row.startswith("noise-"):
        return [("alarms", everyone, lambda one: one.alarm, "<= 6 %"), ("flat statements", everyone, lambda one: one.flat, "<= 1 %"),
                ("good readings named bad", everyone, lambda one: one.good_named_bad, "<= 2 %")]
    if row.startswith("bad-"):
        clean_right = lambda one: bad(one) and judged[answers[one.id]["without"]].right
        large = lambda one: bad(one) and answers[one.id]["bad"]["standard_errors"] >= SIX
        wanted_named = ">= 95 %" if "300" in row else ">= 85 %"
        named: list[Quantity] = [
            ("the reading named", bad, lambda one: one.bad_named, wanted_named),
            ("the same, its deleted residual 6 standard errors or more", large, lambda one: one.bad_named, ">= 95 %"),
            ("good readings named bad", bad, lambda one: one.good_named_bad, ""),
            ("good readings named bad, without the bad one", lambda one: not bad(one), lambda one: one.good_named_bad, "<= 3 %"),
        ]
        if row.endswith("nothing"):
            return [("nothing missing, and said so", bad, lambda one: one.right, ">= 90 %"), *named,
                    ("flat statements", bad, lambda one: one.flat, "<= 1 %")]
        return [("right without the bad reading", lambda one: not bad(one), lambda one: one.right, ""),
                ("right with it, of those right without", clean_right, lambda one: one.right, ">= 95 %"), *named]
    if row == "setup":
        return [("right, or unknown with the place", everyone, lambda one: one.right or one.unknown_with_place, ">= 80 %"),
                ("right", everyone, lambda one: one.right, ""), ("right, the observer", everyone, lambda one: bool(one.observer_right), ""),
                ("unknown with the place", everyone, lambda one: one.unknown_with_place, "<= 30 %"),
                ("one inseparable name", everyone, lambda one: one.inseparable, ""),
                ("nothing missing said", everyone, lambda one: one.verdict == "nothing-missing", "")]
    if row == "mishap":
        apart = lambda one: not one.inseparable
        return [("misled", apart, lambda one: one.misled, "<= 8 %"),
                ("misled, the observer", apart, lambda one: bool(one.observer_misled), ""),
                ("named, and would not mislead", everyone, lambda one: bool(one.named) and one.right, ""),
                ("unknown", everyone, lambda one: one.verdict == "unknown", ""),
                ("nothing missing said", everyone, lambda one: one.verdict == "nothing-missing", ""),
                ("inseparable from the name given, counted apart", everyone, lambda one: one.inseparable, "")]
    if row == "clean-effect":
        return [("good readings named bad", everyone, lambda one: one.good_named_bad, "<= 3 %"), ("right", everyone, lambda one: one.right, "")]
    return [("right", everyone, lambda one: one.right, "within 9 points of the observer, slip 3"),
            ("right, the observer", everyone, lambda one: bool(one.observer_right), ""), ("true names alone", everyone, lambda one: one.exact, ""),
            ("one inseparable name", everyone, lambda one: one.inseparable, "")]


UNSAID: list[Quantity] = [
    ("unsaid: contradicted by the page", lambda one: True, lambda one: one.unsaid_page, "0"),
    ("unsaid: 10 standard errors or more left in truth", lambda one: one.standard_errors > 0.0, lambda one: one.unsaid_truth, "<= 5 %"),
]


def counted(sessions: list[Judged], items: list[Quantity]) -> list[dict]:
    table = []
    for title, counts, hits, wanted in items:
        those = [one for one in sessions if one.error is None and counts(one)]
        k, n = sum(hits(one) for one in those), len(those)
        if n:
            low, high = interval(k, n)
            table.append({"what": title, "hits": k, "of": n, "percent": round(100.0 * k / n, 2), "ci95": [round(low, 2), round(high, 2)], "wanted": wanted})
    return table


def by_kind(row: str, sessions: list[Judged], items: list[Quantity]) -> dict[str, list[dict]]:
    """First two quantities again for each size and kind of a row (in power rows for each law, with the observer)."""
    if row.startswith(("noise-", "bad-")):
        return {}
    sizes = sorted({one.size for one in sessions if one.size is not None})
    by_size = {f"{size:g} standard errors": counted([one for one in sessions if one.size == size], items[:2]) for size in sizes}
    kinds = list(dict.fromkeys(one.kind.split(" on ")[-1] if row == "clean-effect" else one.kind for one in sessions))
    of = lambda one, kind: one.kind == kind or row == "clean-effect" and one.kind.endswith(" on " + kind)
    return by_size | {kind: counted([one for one in sessions if of(one, kind)], items[:2]) for kind in kinds}


def text_of(row: str, table: list[dict], kinds: dict[str, list[dict]], failed: int, seconds: list[float]) -> str:
    ordered = sorted(seconds)
    lines = ["", f"{row}: {len(seconds)} sessions, {failed} without an answer, median {ordered[len(ordered) // 2]:.1f} s, longest {ordered[-1]:.1f} s"]
    width = max(len(item["what"]) for item in table)
    for item in table:
        low, high = item["ci95"]
        lines.append(f"  {item['what']:{width}s} {item['hits']:5d} of {item['of']:5d}  {item['percent']:6.1f} %  ({low:.1f} to {high:.1f})   {item['wanted']}".rstrip())
    for kind, items in kinds.items():
        lines.append(f"    {kind:42s} " + "   ".join(f"{item['what']} {item['hits']} of {item['of']}" for item in items))
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True, help="the binary; an older one gives the column `before`")
    parser.add_argument("--benches", type=Path, required=True, help="folder that generate.py wrote")
    parser.add_argument("--answers", type=Path, help="[default: answers.json of the benches]")
    parser.add_argument("--row", nargs="*", help="these rows only")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=300.0, help="seconds for one session")
    parser.add_argument("--keep", type=Path, help="folder for what the program printed")
    parser.add_argument("--out", type=Path, help="results as JSON; the table goes beside it as .txt [default: printed only]")
    arguments = parser.parse_args()
    file = json.loads((arguments.answers or arguments.benches / "answers.json").read_text())
    if file["schema"] != "stiffbench/reality-answers/1":
        sys.exit(f"{file['schema']} is not stiffbench/reality-answers/1")
    answers = {name: one for name, one in file["benches"].items() if not arguments.row or one["row"] in arguments.row}
    if not answers:
        sys.exit("no bench of these rows in the answers")
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    program = Program(arguments.program, arguments.timeout, arguments.keep)

    def run(item: tuple[str, dict]) -> Judged:
        name, answer = item
        data, error, seconds = program.diagnose(arguments.benches / name, arguments.benches / answer["robot_file"])
        return judge(name, answer, data, error, seconds)

    ordered = sorted(answers.items(), key=lambda item: (item[1]["row"], item[1]["index"], "bad" not in item[1]))
    with ThreadPoolExecutor(arguments.jobs) as pool:
        judged = {one.id: one for one in pool.map(run, ordered)}
    seeds = dict.fromkeys(f"{m['seed']} ({m['list']})" for m in file["made"])
    results, texts = {}, [f"{program.version}; seeds {', '.join(seeds)}"]
    for row in dict.fromkeys(one.row for one in judged.values()):
        sessions = [one for one in judged.values() if one.row == row]
        items = quantities(row, answers, judged)
        table, kinds = counted(sessions, items + UNSAID), by_kind(row, sessions, items)
        failed = [one for one in sessions if one.error]
        results[row] = {"table": table, "kinds": kinds, "failed": {one.id: one.error for one in failed}}
        texts.append(text_of(row, table, kinds, len(failed), [one.seconds for one in sessions]))
    print("\n".join(texts))
    if arguments.out:
        records = [one.record() for one in judged.values()]
        whole = {"schema": "stiffbench/reality-results/1", "program": program.version, "made": file["made"], "rows": results, "sessions": records}
        arguments.out.write_text(json.dumps(whole, indent=1) + "\n")
        arguments.out.with_suffix(".txt").write_text("\n".join(texts) + "\n")


if __name__ == "__main__":
    main()
