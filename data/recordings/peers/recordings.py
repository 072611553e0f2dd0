"""Reads ../recordings.toml, the tables it names, and what stiffbench says of them."""

import csv
import json
import pathlib
import subprocess
import tempfile
import time
import tomllib

LIST = pathlib.Path(__file__).resolve().parent.parent / "recordings.toml"
VERDICTS = {"explained", "ambiguous", "unknown", "nothing-missing", "insufficient-data"}
GRADES = ["is", "mostly", "weak", "unknown", "nothing", "undecided"]


def known(part=""):
    """The recordings with a table, whose name contains `part`."""
    with open(LIST, "rb") as file:
        found = tomllib.load(file)["recording"]
    return [one for one in found if "specimen" in one and part in one["name"]]


def table(recording, folder):
    """Header and rows of a recording's files, joined; None if a file is not there."""
    header, rows = None, []
    for number, file in enumerate(recording["files"], 1):
        path = pathlib.Path(folder) / file["path"]
        if not path.is_file():
            return None
        with open(path, newline="") as text:
            reader = csv.reader(text)
            names = next(reader)
            chosen = recording.get("rows")
            computed = recording.get("computed")
            for row in reader:
                if chosen and row[names.index(chosen["column"])] not in chosen["values"]:
                    continue
                added = []
                if computed:
                    dividend, divisor = (float(row[names.index(name)]) for name in computed["quotient"])
                    added.append(repr(dividend / divisor))
                if "file-column" in recording:
                    added.append(str(number))
                rows.append(row + added)
        header = names + ([computed["column"]] if computed else []) + ([recording["file-column"]] if "file-column" in recording else [])
    return header, rows


def options(specimen):
    """Options of the command line for the keys of [recording.specimen]."""
    return [word for key, values in specimen.items() for value in (values if isinstance(values, list) else [values]) for word in (f"--{key}", value)]


def diagnose(program, header, rows, specimen, limit_s=300.0, folder=None):
    """(JSON of the diagnosis, seconds); the JSON has ok = false if there is none."""
    with tempfile.TemporaryDirectory() as temporary:
        path = pathlib.Path(folder or temporary) / "table.csv"
        with open(path, "w", newline="") as file:
            csv.writer(file).writerows([header, *rows])
        command = [program, "diagnose", str(path), "--specimen", *options(specimen), "--json", "--no-figures", "-q"]
        if folder:
            command += ["--out", str(pathlib.Path(folder) / "out")]
        began = time.perf_counter()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s)
            found = json.loads(done.stdout)
        except subprocess.TimeoutExpired:
            found = {"ok": False, "error": {"message": f"no answer within {limit_s:.0f} s"}}
        except json.JSONDecodeError:
            found = {"ok": False, "error": {"message": done.stderr.strip()[-300:]}}
        return found, time.perf_counter() - began


def summary(found):
    """Verdict, grade, and names with their places, sets and shares."""
    if not found.get("ok"):
        return {"verdict": "error", "grade": "undecided", "findings": [], "error": found["error"]["message"]}
    data = found["data"]
    keys = {"physics": "physics", "group": "alternative_group", "place": "place", "share": "share_of_misfit", "share_unseen": "share_unseen"}
    findings = [{name: finding.get(key) for name, key in keys.items()} for finding in data["findings"]]
    return {"verdict": data["verdict"], "grade": data["grade"], "findings": findings}


def leading(said):
    """Names of the leading finding: the one with the largest share, or all members of its set; empty without a headline."""
    findings = said["findings"]
    if said["verdict"] not in ("explained", "ambiguous") or not findings:
        return []
    share = lambda finding: -1.0 if finding["share"] is None else finding["share"]
    first = max(findings, key=share)
    if first["group"] is None:
        return [first["physics"]]
    return sorted({f["physics"] for f in findings if f["group"] == first["group"]})
