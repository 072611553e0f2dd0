"""Whether stiffbench answers alike however a recording is put to it.

    python variations.py PROGRAM FOLDER [--out NAME] [--only TEXT] [--limit SECONDS]

Asks of each recording: as listed; without declared runs, or with runs declared by cycles where none are; every second row; rows reversed where
their order means nothing; in other units. README.md states how they are counted.
"""

import argparse
import json
import pathlib

import recordings

LADDER = ["is", "mostly", "weak", "unknown"]
# The order of rows means nothing where the physics has no memory and nothing was timed.
WITHOUT_ORDER = ("afm-", "column-", "stormer-", "nist-load-cell-", "nist-linewidth", "elastomer-")
OTHER_UNITS = {"N": ("kN", 1e-3), "kN": ("N", 1e3), "nN": ("uN", 1e-3), "gf": ("kgf", 1e-3), "mm": ("um", 1e3), "nm": ("um", 1e-3), "in": ("mm", 25.4), "1": ("1", 1e3)}


def without_runs(recording, header, rows):
    specimen = recording["specimen"]
    if "run-column" in specimen and specimen.get("configuration-column") != specimen["run-column"]:
        return header, rows, {key: value for key, value in specimen.items() if key != "run-column"}
    return None


def with_cycles(recording, header, rows):
    """A column that counts cycles: each begins where the set quantity turns up again, after at least half of its range."""
    specimen = recording["specimen"]
    if "run-column" in specimen or "time-column" not in specimen:
        return None
    column = "displacement-column" if specimen.get("response") == "force" else "force-column"
    if column not in specimen:
        return None
    values = [float(row[header.index(specimen[column])]) for row in rows]
    half = (max(values) - min(values)) / 2
    cycle, cycles, falling, extreme = 1, [], False, values[0]
    for value in values:
        extreme = min(extreme, value) if falling else max(extreme, value)
        if not falling and value < extreme - half:
            falling, extreme = True, value
        elif falling and value > extreme + half:
            falling, extreme, cycle = False, value, cycle + 1
        cycles.append(cycle)
    if cycle < 2:
        return None
    rows = [row + [str(number)] for row, number in zip(rows, cycles)]
    return header + ["cycle_"], rows, {**specimen, "run-column": ["cycle_"]}


def every_second_row(recording, header, rows):
    return header, rows[::2], recording["specimen"]


def reversed_rows(recording, header, rows):
    if not recording["name"].startswith(WITHOUT_ORDER):
        return None
    return header, rows[::-1], recording["specimen"]


def other_units(recording, header, rows):
    specimen = dict(recording["specimen"])
    rows = [list(row) for row in rows]
    for kind in ("force", "displacement"):
        name = specimen.get(f"{kind}-column")
        if name is None:
            continue
        unit = specimen.get(f"{kind}-unit", name.rsplit("_", 1)[-1])
        specimen[f"{kind}-unit"], factor = OTHER_UNITS[unit]
        place = header.index(name)
        for row in rows:
            row[place] = repr(float(row[place]) * factor)
    return header, rows, specimen


VARIATIONS = {
    "without runs": without_runs,
    "runs by cycles": with_cycles,
    "every second row": every_second_row,
    "rows reversed": reversed_rows,
    "other units": other_units,
}


def places(said):
    """Places of the leading finding, as texts."""
    lead = set(recordings.leading(said))
    return sorted(json.dumps(f["place"], sort_keys=True) for f in said["findings"] if f["physics"] in lead)


def compared(base, said, variation):
    """Whether name and place were kept, whether another name came, and by how many steps the grade moved (None: off the ladder)."""
    before, after = recordings.leading(base), recordings.leading(said)
    same = before == after and places(base) == places(said) and said["verdict"] != "error"
    lost = bool(before) and not after and variation == "every second row" and said["grade"] in ("weak", "unknown")
    steps = None
    if base["grade"] in LADDER and said["grade"] in LADDER:
        steps = abs(LADDER.index(base["grade"]) - LADDER.index(said["grade"]))
    elif base["grade"] == said["grade"]:
        steps = 0
    return {"kept": same or lost, "another_name": bool(after) and before != after, "grade_steps": steps}


def in_words(said):
    names = ", ".join(finding["physics"] for finding in said["findings"]) or "-"
    return f"{said['grade']}: {names}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--out", default="results/variations", help="results go to NAME.md and NAME.json")
    parser.add_argument("--only", default="", help="only recordings whose name contains this")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds for one answer")
    arguments = parser.parse_args()
    results = []
    for recording in recordings.known(arguments.only):
        table = recordings.table(recording, arguments.folder)
        if table is None:
            print(f"{recording['name']} is not there")
            continue
        ask = lambda header, rows, specimen: recordings.summary(recordings.diagnose(arguments.program, header, rows, specimen, arguments.limit)[0])
        base = ask(*table, recording["specimen"])
        result = {"recording": recording["name"], "as listed": base, "variations": {}}
        for name, change in VARIATIONS.items():
            changed = change(recording, *table)
            if changed is not None:
                said = ask(*changed)
                result["variations"][name] = {**said, **compared(base, said, name)}
        results.append(result)
        print(recording["name"], in_words(base), {k: v["kept"] for k, v in result["variations"].items()}, flush=True)
    if not results:
        parser.error(f"{arguments.folder} holds none of the recordings")
    counts, cells = [], {name: [] for name in VARIATIONS}
    for result in results:
        for name, said in result["variations"].items():
            cells[name].append(said)
    cells["all"] = [said for group in list(cells.values()) for said in group]
    for name, group in cells.items():
        kept = sum(said["kept"] for said in group)
        other = sum(said["another_name"] for said in group)
        one_step = sum(said["grade_steps"] is not None and said["grade_steps"] <= 1 for said in group)
        share = 100 * kept / max(len(group), 1)
        counts.append(f"| {name} | {len(group)} | {kept} ({share:.0f} %) | {other} | {one_step} |")
    lines = ["# How answers change with the question", "", "| variation | asked | name and place kept | another name | grade within one step |", "|---|---|---|---|---|", *counts, ""]
    lines += ["| recording | as listed | " + " | ".join(VARIATIONS) + " |", "|---" * (2 + len(VARIATIONS)) + "|"]
    for result in results:
        row = []
        for name in VARIATIONS:
            said = result["variations"].get(name)
            row.append("" if said is None else in_words(said) + ("" if said["kept"] else " **changed**"))
        lines.append(f"| {result['recording']} | {in_words(result['as listed'])} | " + " | ".join(row) + " |")
    out = pathlib.Path(arguments.out)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.with_suffix(".md").write_text("\n".join(lines) + "\n")
    out.with_suffix(".json").write_text(json.dumps(results, indent=1) + "\n")
    print("\n".join(lines[:10]))


if __name__ == "__main__":
    main()
