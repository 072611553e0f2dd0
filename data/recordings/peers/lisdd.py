"""LISDD: sparse regression that says where a trusted law fails, which term is missing there, and whether the evidence is real.

    python lisdd.py --names --from FOLDER [--out NAME] [--only TEXT]
    python lisdd.py --names --sessions FOLDER

The first form runs over ../recordings.toml, the second over the development list of ../../concealed (FOLDER). head_to_head.py takes `fit` from here.

Source: "Where Is My Physics Wrong? Localized and Identifiable Discovery of Model Discrepancy", arXiv 2606.23215. No public code was found, and only
the abstract and summaries of it were read.

What follows that description:

- the trusted physics is fitted on a clean regime, which is found from the readings;
- other regimes are flagged by the energy of their residual, held against its distribution;
- the missing terms of a regime are selected by exhaustive hold-out over a small library;
- an F test on readings that took no part in fit and selection confirms each term.

What was chosen here:

- physics: a line, its slope common to all (or to each configuration), a zero for each run;
- a regime is a declared run, in the head to head the runs with the same largest torque, in a session a pose and direction;
- a common set of terms for all regimes is tried too; it stands unless located terms have the smaller error on the selecting part, each regime
  in units of its own spread. The description has nothing for physics that is wrong everywhere;
- clean: first the quieter half of the regimes, then all whose energy is not above it (F test, 0.01 over the number of regimes);
- each run is cut into 24 blocks of neighbouring readings, which go to fit, selection and confirmation in turn; final weights come from all;
- none to 3 terms in a regime, whichever set has the least error; p < 0.01 over the number of candidates and of regimes searched (Bonferroni, where
  the source controls the false discovery rate);
- the library: powers of the quantity that is set, the sign of its rate, time, the logarithm of the time since the run began, temperature, products.
  The quantity that answers is not in it, nor anything with memory but the sign of the rate; a slope of its own for a flagged regime is;
- which law a term is taken for (LAWS), and that a sign turns once 2 % of the range have been travelled back;
- readings weigh alike, as the F test needs. It takes their errors to be independent; in recordings they are not.
"""

import argparse
import csv
import itertools
import json
import pathlib
import time

import numpy as np
import scipy.stats

import recordings

LIMIT = 0.01
BLOCKS = 24
TERMS = 3
TURN = 0.02
ALIKE = 0.999

# --- library ------------------------------------------------------------------------------------------------------------------------
# u is the quantity that is set, over its largest size; d the sign of its rate; t time; s the logarithm of the time since the start of the run; c
# temperature; r the value of u at the last reversal, for the head to head alone. Of two terms that are the same in a recording the first is kept.

LIBRARY = {
    "u^3": lambda x: x["u"] ** 3,
    "u|u|": lambda x: x["u"] * np.abs(x["u"]),
    "u^2": lambda x: x["u"] ** 2,
    "u^5": lambda x: x["u"] ** 5,
    "d": lambda x: x["d"],
    "d|u|": lambda x: x["d"] * np.abs(x["u"]),
    "d u": lambda x: x["d"] * x["u"],
    "d u^2": lambda x: x["d"] * x["u"] ** 2,
    "t": lambda x: x["t"],
    "log t": lambda x: x["s"],
    "u t": lambda x: x["u"] * x["t"],
    "u log t": lambda x: x["u"] * x["s"],
    "c": lambda x: x["c"],
    "r": lambda x: x["r"],
    "r^3": lambda x: x["r"] ** 3,
    "d (u-r)^2": lambda x: x["d"] * (x["u"] - x["r"]) ** 2,
    "(u-r)^3": lambda x: (x["u"] - x["r"]) ** 3,
}
SLOPE = "u"

# Laws that a term may stand for; a term without any gets no name.
LAWS = {
    "u^3": {"odd-polynomial", "joint-nonlinearity"},
    "u^5": {"odd-polynomial", "joint-nonlinearity"},
    "u|u|": {"joint-nonlinearity"},
    "d": {"joint-friction"},
    "d|u|": {"load-dependent-friction"},
    "d u^2": {"load-dependent-friction"},
    "t": {"thermal-drift"},
    "c": {"thermal-drift"},
    "log t": {"creep"},
    "u log t": {"creep"},
}


def laws_of(name, place, force_set):
    """Laws of a term. Where a displacement is set, creep is relaxation; where a force is set, its gauge may be what is curved."""
    if name == SLOPE:
        return {"setting-in"} if place == "first" else set()
    found = set(LAWS.get(name, ()))
    if not force_set and "creep" in found:
        return {"relaxation"}
    if force_set and name == "u|u|":
        found.add("force-gauge-nonlinearity")
    return found


def directions(u, span):
    """Sign of the rate, and the value at the last reversal; a reversal counts once the way back is TURN of the span."""
    sign, turn = np.zeros(len(u)), np.zeros(len(u))
    now, extreme, last = 0.0, u[0], u[0]
    for i, value in enumerate(u):
        if now == 0.0:
            if abs(value - u[0]) > TURN * span:
                now, extreme = np.sign(value - u[0]), value
                sign[:i] = now
        elif (value - extreme) * now > 0.0:
            extreme = value
        elif (extreme - value) * now > TURN * span:
            now, last, extreme = -now, extreme, value
        sign[i], turn[i] = now, last
    return sign, turn


def inputs(u, run, scale, seconds=None, temperature=None, with_turn=False):
    """What the terms of the library are made of."""
    x = {"u": u / scale, "d": np.zeros(len(u)), "r": np.zeros(len(u))}
    span = np.ptp(u) or 1.0
    timed = seconds is not None and np.ptp(seconds) > 0.0
    if timed:
        x["t"], x["s"] = (seconds - seconds[0]) / np.ptp(seconds), np.zeros(len(u))
    for name in dict.fromkeys(run):
        rows = run == name
        x["d"][rows], turn = directions(u[rows], span)
        x["r"][rows] = turn / scale
        if timed:
            age = seconds[rows] - seconds[rows][0]
            steps = np.diff(age)
            step = np.median(steps[steps > 0.0]) if np.any(steps > 0.0) else 1.0
            x["s"][rows] = np.log(1.0 + np.maximum(age, 0.0) / step)
    if temperature is not None:
        x["c"] = temperature - temperature.mean()
    if not with_turn:
        del x["r"]
    return x


def terms_of(x):
    """Columns of the library for which the inputs are there."""
    found = {}
    for name, function in LIBRARY.items():
        try:
            found[name] = function(x)
        except KeyError:
            continue
    return found


# --- search -------------------------------------------------------------------------------------------------------------------------


def solve(columns, answer):
    """Weights of least squares."""
    return np.linalg.lstsq(columns, answer, rcond=None)[0] if columns.shape[1] else np.zeros(0)


def rest(columns, answer):
    """Residual sum of squares, and how many readings are left free."""
    if not columns.shape[1]:
        return float(answer @ answer), len(answer)
    weights, _, rank, _ = np.linalg.lstsq(columns, answer, rcond=None)
    residual = answer - columns @ weights
    return float(residual @ residual), len(answer) - int(rank)


def parts(run):
    """0 for fit, 1 for selection, 2 for confirmation: blocks of neighbouring readings of each run in turn."""
    part = np.zeros(len(run), dtype=int)
    for name in dict.fromkeys(run):
        rows = np.flatnonzero(run == name)
        part[rows] = (np.arange(len(rows)) * min(BLOCKS, len(rows)) // len(rows)) % 3
    return part


def indicators(labels):
    """A column of ones for each label."""
    names = list(dict.fromkeys(labels))
    return np.array([labels == name for name in names], dtype=float).T if names else np.zeros((len(labels), 0))


def slopes(u, group):
    """A column of u for each configuration."""
    return indicators(group) * u[:, None]


def candidates(base, columns):
    """Terms that the physics does not hold, scaled to unit length, without those that another already is."""
    kept, known = {}, []
    for name, column in columns.items():
        size = np.linalg.norm(column)
        if size == 0.0:
            continue
        left = column / size - base @ solve(base, column / size)
        length = np.linalg.norm(left)
        if length < 1e-6 or any(abs(left @ other) > ALIKE * length for other in known):
            continue
        kept[name] = column / size
        known.append(left / length)
    return kept


def stacked(base, columns, names):
    """The physics and some terms beside each other."""
    return np.column_stack([base] + [columns[name] for name in names]) if names else base


def search(base, columns, answer, part, regimes):
    """Names of the terms that are selected by hold-out and confirmed by the F test."""
    pool = candidates(base, columns)
    fit, chosen = part == 0, part == 1
    names = list(pool)
    if not names:
        return []

    def less_physics(column):
        return column - base @ solve(base[fit], column[fit])

    y = less_physics(answer)
    matrix = np.array([less_physics(pool[name]) for name in names]).T
    gram, side = matrix[fit].T @ matrix[fit], matrix[fit].T @ y[fit]
    free = int(fit.sum()) - np.linalg.matrix_rank(base[fit]) if base.shape[1] else int(fit.sum())
    best, least = (), float(y[chosen] @ y[chosen])
    for size in range(1, TERMS + 1):
        if size >= free:
            break
        for some in itertools.combinations(range(len(names)), size):
            square = gram[np.ix_(some, some)]
            if np.linalg.cond(square) > 1e10:
                continue
            residual = y[chosen] - matrix[np.ix_(chosen, some)] @ np.linalg.solve(square, side[list(some)])
            error = float(residual @ residual)
            if error < least:
                best, least = some, error
    return confirmed(base, pool, answer, part == 2, [names[i] for i in best], LIMIT / (len(names) * regimes))


def confirmed(base, columns, answer, rows, names, limit):
    """Terms whose F test on the confirming readings holds; the weakest goes first, and the rest are tested anew."""
    names = list(names)
    while names:
        whole, free = rest(stacked(base, columns, names)[rows], answer[rows])
        if free < 1:
            names.pop()
            continue
        p = {}
        for name in names:
            without, _ = rest(stacked(base, columns, [n for n in names if n != name])[rows], answer[rows])
            p[name] = scipy.stats.f.sf((without - whole) * free / whole, 1, free) if whole > 0.0 else 0.0
        worst = max(names, key=p.get)
        if p[worst] < limit:
            break
        names.remove(worst)
    return names


def clean_regimes(u, y, run, group, regime):
    """Regimes that agree with one fit of the physics, the quieter half first."""
    names = list(dict.fromkeys(regime))

    def energy(name, slope):
        rows = regime == name
        open_rows = np.array([one not in slope for one in group[rows]])
        lines = slopes(u[rows], group[rows]) if open_rows.any() else np.zeros((int(rows.sum()), 0))
        return rest(np.column_stack([indicators(run[rows]), lines]), (y - slope_column(u, group, slope))[rows])

    alone = {name: energy(name, {}) for name in names}
    clean = sorted(names, key=lambda name: alone[name][0] / max(alone[name][1], 1))[: (len(names) + 1) // 2]
    for _ in range(10):
        rows = np.isin(regime, clean)
        slope = slope_from(u, y, run, group, rows)
        square, free = rest(indicators(run[rows]), (y - slope_column(u, group, slope))[rows])
        now = []
        for name in names:
            own, left = energy(name, slope)
            bound = scipy.stats.f.isf(LIMIT / len(names), max(left, 1), max(free, 1))
            if own / max(left, 1) <= bound * square / max(free, 1):
                now.append(name)
        if now == clean or not now:
            break
        clean = now
    return clean


def slope_from(u, y, run, group, rows):
    """Slope of each configuration from some rows."""
    names = list(dict.fromkeys(group[rows]))
    zeros = indicators(run[rows])
    weights = solve(np.column_stack([zeros, slopes(u[rows], group[rows])]), y[rows])
    return dict(zip(names, weights[zeros.shape[1] :]))


def slope_column(u, group, slope):
    """What the known slopes answer to u."""
    return u * np.array([slope.get(name, 0.0) for name in group])


def piece(x, y, run, group, columns, part, rows, known, regimes, own_slope):
    """The model of some rows: a zero for each run, the slopes that are `known` or else fitted, and the terms that are found."""
    here = {name: column[rows] for name, column in columns.items()}
    if own_slope:
        here = {SLOPE: x["u"][rows], **here}
    known = {name: slope for name, slope in known.items() if name in set(group[rows])}
    unknown = [name for name in dict.fromkeys(group[rows]) if name not in known]
    zeros = indicators(run[rows])
    lines = [np.where(group[rows] == name, x["u"][rows], 0.0) for name in unknown]
    base = np.column_stack([zeros, *lines])
    given = slope_column(x["u"], group, known)[rows]
    answer = y[rows] - given
    found = search(base, here, answer, part[rows], regimes)
    matrix = stacked(base, here, found)
    weights = solve(matrix, answer)
    first = part[rows] == 0
    return {
        "rows": rows,
        "slope": {**known, **dict(zip(unknown, weights[zeros.shape[1] :]))},
        "terms": dict(zip(found, weights[base.shape[1] :])),
        "from_first_part": matrix @ solve(matrix[first], answer[first]) + given,
        "base": base,
        "here": here,
        "answer": answer,
    }


def discover(x, y, run, group, regime):
    """The pieces of a model: one for all regimes, or one for the clean regimes and one for each that is flagged."""
    columns = terms_of(x)
    part = parts(run)
    names = list(dict.fromkeys(regime))
    common = [piece(x, y, run, group, columns, part, np.full(len(y), True), {}, 1, False)]
    common[0]["place"] = "all"
    clean = clean_regimes(x["u"], y, run, group, regime)
    flagged = [name for name in names if name not in clean]
    if not flagged:
        return common
    regimes = len(flagged) + 1
    located = [piece(x, y, run, group, columns, part, np.isin(regime, clean), {}, regimes, False)]
    located[0]["place"] = "clean"
    for name in flagged:
        one = piece(x, y, run, group, columns, part, regime == name, located[0]["slope"], regimes, True)
        one["place"], one["regime"] = ("first" if name == names[0] else "one"), name
        located.append(one)
    return min([common, located], key=lambda pieces: selecting_error(pieces, y, run, regime, part))


def selecting_error(pieces, y, run, regime, part):
    """Mean square on the selecting readings, each regime over its variance about the zeros of its runs."""
    predicted = np.empty(len(y))
    for one in pieces:
        predicted[one["rows"]] = one["from_first_part"]
    total = 0.0
    for name in dict.fromkeys(regime):
        rows = regime == name
        spread, _ = rest(indicators(run[rows]), y[rows])
        rows = rows & (part == 1)
        total += np.mean((y[rows] - predicted[rows]) ** 2) / max(spread, 1e-300) if rows.any() else 0.0
    return total


# --- head to head -------------------------------------------------------------------------------------------------------------------


def fit(runs, scale, with_turn=False):
    """A prediction for the torque of a run, and the number of weights; runs whose largest torques are within a tenth are one regime."""
    peaks, cells = [], []
    for torque, _ in runs:
        peak = np.abs(torque).max()
        near = [i for i, other in enumerate(peaks) if abs(np.log(peak / other)) < np.log(1.1)]
        cells.append(near[0] if near else len(peaks))
        if not near:
            peaks.append(peak)
    one_run = lambda torque: inputs(torque, np.zeros(len(torque)), scale, with_turn=with_turn)
    blocks = [one_run(torque) for torque, _ in runs]
    x = {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}
    y = np.concatenate([position for _, position in runs])
    lengths = [len(torque) for torque, _ in runs]
    run, regime = np.repeat(np.arange(len(runs)), lengths), np.repeat(cells, lengths)
    pieces = discover(x, y, run, np.zeros(len(y), dtype=int), regime)

    def predict(torque):
        # The model of the regime whose largest torque is nearest.
        own = int(np.argmin(np.abs(np.log(np.abs(torque).max() / np.array(peaks)))))
        one = next((one for one in pieces if one.get("regime") == own), pieces[0])
        now = one_run(torque)
        columns = {SLOPE: now["u"], **terms_of(now)}
        return one["slope"][0] * now["u"] + sum(weight * columns[name] for name, weight in one["terms"].items())

    return predict, 1 + sum(len(one["terms"]) for one in pieces)


# --- names --------------------------------------------------------------------------------------------------------------------------


def said(pieces, y, base, force_set):
    """The terms with their laws, the one that takes most in all regimes together first, and the share of the misfit that all take."""
    found, left = {}, 0.0
    for one in pieces:
        names = list(one["terms"])
        whole, _ = rest(stacked(one["base"], one["here"], names), one["answer"])
        left += whole
        for name in names:
            without, _ = rest(stacked(one["base"], one["here"], [n for n in names if n != name]), one["answer"])
            laws = laws_of(name, one["place"], force_set)
            term = found.setdefault((name, tuple(sorted(laws))), {"term": name, "laws": laws, "places": [], "gain": 0.0})
            term["places"].append(one["place"])
            term["gain"] += without - whole
    physics, _ = rest(base, y)
    return sorted(found.values(), key=lambda term: -term["gain"]), 1.0 - left / physics if physics > 0.0 else 0.0


def judged(recording, found):
    """Outcome of a recording by the rules of ../README.md, and the foreign terms.

    LISDD is given the benefit of every doubt: a term that may stand for several laws counts for the best of them, alone or in a set as it is right,
    a term without a law is passed over beside one that has one, and no grade is asked for. Terms without any law are the verdict `unknown`.
    """
    verdicts = {recording["verdict"]} | (recordings.VERDICTS & set(recording["also-right"]))
    right = set(recording["physics"])
    beside = set(recording["also-right"]) - recordings.VERDICTS
    named = [term for term in found if term["laws"]]
    if not found:
        return ("right" if "nothing-missing" in verdicts else "mute"), []
    if not named:
        return ("right" if "unknown" in verdicts else "mute"), []
    if verdicts == {"unknown"}:
        foreign = [term for term in named if term["laws"] <= set(recording["not"])]
    else:
        foreign = [term for term in named if not term["laws"] & (right | beside)]
    if named[0] in foreign:
        return "false-dominant", foreign
    if not verdicts & {"explained", "ambiguous"}:
        return "not-right", foreign
    if named[0]["laws"] & right:
        return "right", foreign
    return ("right-behind" if any(term["laws"] & right for term in named) else "not-right"), foreign


def told(found):
    """Terms in words, with the regimes that they are located in where they are not everywhere."""
    words = []
    for term in found:
        count = sum(place != "clean" for place in term["places"])
        clean = ["clean runs"] * ("clean" in term["places"]) + ([f"{count} flagged"] if count else [])
        place = "" if "all" in term["places"] else f" ({', '.join(clean)})"
        words.append(f"{term['term'].replace('|', chr(92) + '|')}{place}: {' or '.join(sorted(term['laws'])) or 'no name'}")
    return "; ".join(words) or "-"


def read(recording, folder):
    """What `discover` takes of a recording; None without its files."""
    table = recordings.table(recording, folder)
    if table is None:
        return None
    header, rows = table
    specimen = recording["specimen"]
    force_set = specimen.get("response") != "force"
    set_key, answer_key = ("force-column", "displacement-column") if force_set else ("displacement-column", "force-column")

    def column(key):
        name = specimen.get(key)
        return None if name is None else np.array([float(row[header.index(name)] or "nan") for row in rows])

    def labels(key):
        names = specimen.get(key, [])
        return np.array(["|".join(row[header.index(name)] for name in names) for row in rows])

    y, u = column(answer_key), column(set_key)
    u = np.zeros(len(y)) if u is None else u
    seconds = column("time-column")
    seconds = column("order-column") if seconds is None else seconds
    temperature = column("temperature-column")
    run, group = labels("run-column"), labels("configuration-column")
    there = np.all([np.isfinite(values) for values in (u, y, seconds, temperature) if values is not None], axis=0)
    take = lambda values: None if values is None else values[there]
    u, y, seconds, temperature, run, group = (take(values) for values in (u, y, seconds, temperature, run, group))
    x = inputs(u, run, np.abs(u).max() or 1.0, seconds, temperature)
    return x, y, run, group, run, force_set


def name_all(x, y, run, group, regime, force_set):
    y = y / (np.std(y) or 1.0)
    pieces = discover(x, y, run, group, regime)
    base = np.column_stack([indicators(run), slopes(x["u"], group)])
    return said(pieces, y, base, force_set)


# Nothing that derives from these is written: their licence forbids it.
UNWRITTEN = "column-"
OUTCOMES = ["right", "right-behind", "not-right", "false-dominant", "mute"]


def names_of_recordings(folder, only, out):
    lines, counts, with_foreign, kept = [], dict.fromkeys(OUTCOMES, 0), 0, []
    for recording in recordings.known(only):
        data = read(recording, folder)
        if data is None:
            print(f"{recording['name']}: no files")
            continue
        began = time.perf_counter()
        found, share = name_all(*data)
        seconds = time.perf_counter() - began
        outcome, foreign = judged(recording, found)
        counts[outcome] += 1
        with_foreign += bool(foreign)
        verdicts = [recording["verdict"]] + sorted(recordings.VERDICTS & set(recording["also-right"]))
        line = f"| {recording['name']} | {' or '.join(verdicts)} | {told(found)} | {share:.2f} | {told(foreign)} | {seconds:.1f} | {outcome} |"
        print(line, flush=True)
        lines.append(line)
        kept.append(not recording["name"].startswith(UNWRITTEN))
    total = sum(counts.values())
    summary = (
        f"Headline right {counts['right'] + counts['right-behind']} of {total} (behind another: {counts['right-behind']}), false dominant name "
        f"{counts['false-dominant']}, recordings with a foreign name {with_foreign}, mute {counts['mute']}, not right {counts['not-right']}."
    )
    print(summary)
    if out and not only:
        head = ["| recording | right | terms, the one that takes most first | share | foreign | s | outcome |", "|---|---|---|---|---|---|---|"]
        hidden = f"The {kept.count(False)} recordings whose licence forbids it are counted and not shown." if False in kept else ""
        text = ["# What LISDD names", "\n".join(part for part in (summary, hidden) if part), "\n".join(head + [l for l, k in zip(lines, kept) if k])]
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text("\n\n".join(text) + "\n")


def names_of_sessions(folder):
    """The development list of the concealed benches: names only, places are not judged."""
    answers = json.loads((folder / "development-answers.json").read_text())["benches"]
    counts, with_foreign = {}, 0
    for name, answer in answers.items():
        with open(folder / "sessions" / name / "readings.csv", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["force_N"] and row["displacement_um"]]
        number = lambda key: np.array([float(row[key]) for row in rows])
        cell = np.array([f"{row['pose']}|{row['direction']}" for row in rows])
        run = np.array([f"{c}|{row['repeat']}" for c, row in zip(cell, rows)])
        u = number("force_N")
        x = inputs(u, run, np.abs(u).max(), number("t_s"), number("temp_degC"))
        found, _ = name_all(x, number("displacement_um"), run, cell, cell, True)
        truth = {effect["physics"] for effect in answer["truth"]}
        named = [term for term in found if term["laws"]]
        foreign = [term for term in named if not term["laws"] & truth]
        with_foreign += bool(foreign)
        if not found:
            outcome = "right" if answer["expected"] == "nothing-missing" else "may be missed" if answer["may_be_missed"] else "mute"
        elif not named:
            outcome = {"unknown": "right", "nothing-missing": "structure claimed"}.get(answer["expected"], "mute")
        elif named[0] in foreign:
            outcome = "false-dominant"
        else:
            outcome = "right" if answer["expected"] != "unknown" else "not-right"
        counts[outcome] = counts.get(outcome, 0) + 1
        print(f"{name} {answer['mode']:4} {answer['expected']:18} {','.join(sorted(truth)) or '-':45} {outcome:17} {told(found)}", flush=True)
    print(f"{dict(sorted(counts.items()))}, sessions with a foreign name: {with_foreign}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--names", action="store_true", required=True, help="print which physics LISDD would name")
    parser.add_argument("--from", dest="folder", type=pathlib.Path, help="folder with the recordings")
    parser.add_argument("--sessions", type=pathlib.Path, help="folder of the concealed benches")
    parser.add_argument("--out", type=pathlib.Path, default="results/lisdd_names.md", help="where the table of the recordings goes; not with --only")
    parser.add_argument("--only", default="", help="only recordings whose name contains this")
    arguments = parser.parse_args()
    if not arguments.folder and not arguments.sessions:
        parser.error("--from or --sessions is wanted")
    if arguments.folder:
        names_of_recordings(arguments.folder, arguments.only, arguments.out)
    if arguments.sessions:
        names_of_sessions(arguments.sessions)


if __name__ == "__main__":
    main()
