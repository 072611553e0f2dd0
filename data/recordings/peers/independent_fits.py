"""Least-squares fits of the expected laws by SciPy, judged on readings that they have not seen.

    python independent_fits.py FOLDER [--program PROGRAM] [--out NAME] [--only TEXT]

Each recording is fitted with the sets of laws that may be right for it. Unseen are whole runs, left out in turn; of a recording with one run,
every second of twenty blocks of neighbouring readings. Every run has a zero of its own, every configuration a fit of its own. The quantity
that is set is known throughout, so that friction and relaxation keep their memory. With --program, stiffbench is asked for the same laws on the
same rows: its model predicts the unseen ones (command `part predict`). README.md states the figures that are wanted.
"""

import argparse
import csv
import itertools
import json
import pathlib
import subprocess
import tempfile

import numpy as np
import scipy.optimize
import scipy.special

import laws
import recordings

BLOCKS = 20
# Nothing that derives from these is written: their licence forbids it.
UNWRITTEN = "column-"


# --- laws ---------------------------------------------------------------------------------------------------------------------------
# Each has the starts of its nonlinear parameters (u and t in units of the largest of a run) and a function of these to columns.


def friction(data, radius):
    return [history(data, lambda _, u: laws.play(u, radius))]


def load_dependent_friction(data, radius, growth):
    return [history(data, lambda _, u: laws.load_dependent_play(u, radius, min(growth, 0.95)))]


def maxwell_slip(data):
    return [column for radius in (0.02, 0.05, 0.1, 0.2, 0.4, 0.8) for column in friction(data, radius)]


def backlash(data, width):
    # Set force: the play is there beyond the seat. Set displacement: no force within the play.
    return [laws.dead_zone(data.u, width) if data.displacement_set else np.sign(data.u) * (np.abs(data.u) > width)]


def preloaded_backlash(data, middle, width):
    return [np.tanh((data.u - middle) / max(width, 1e-3))]


def contact(data, onset, power):
    return [np.maximum(data.u - onset, 0.0) ** min(max(power, 1.0), 2.0)]


def odd_polynomial(data):
    return [data.u**3, data.u**5]


def nonlinearity(data):
    return [data.u * np.abs(data.u)]


def relaxation(data, tau):
    return [history(data, lambda t, u: laws.maxwell_arm(t, u, max(tau, 1e-4)))]


def logarithmic(data, t0):
    return [history(data, lambda t, u: laws.log_memory(t, u, max(t0, 1e-6)))]


def history(data, function):
    """A law with memory: it goes on through runs if the clock does, and starts anew with each run if the clock restarts."""
    if data.goes_on:
        return function(data.t, data.u)
    return laws.by_run(function, data.run, data.t, data.u)


def setting_in(data, decay):
    return [data.u * np.exp(-data.number / max(decay, 0.1))]


def softening(data, reach):
    # Pseudo-elastic: softer where the largest deformation so far lies above the present one (Ogden and Roxburgh, Proc. R. Soc. A 455 (1999) 2861).
    above = np.maximum.accumulate(np.abs(data.u)) - np.abs(data.u)
    return [data.u * scipy.special.erf(above / max(reach, 1e-3))]


def constant_force(data):
    return [np.ones(len(data.u))]


RADII = [[0.01], [0.03], [0.08], [0.15], [0.3], [0.5]]
LAWS = {
    "joint-friction": (friction, RADII),
    "load-dependent-friction": (load_dependent_friction, [[r, g] for r in (0.01, 0.05, 0.1, 0.2) for g in (0.05, 0.2, 0.4)]),
    "maxwell-slip": (maxwell_slip, [[]]),
    "joint-backlash": (backlash, [[0.02], [0.05], [0.1], [0.2], [0.4], [0.6], [0.8]]),
    "preloaded-backlash": (preloaded_backlash, [[m, w] for m in (-0.1, 0.0, 0.1) for w in (0.02, 0.1)]),
    "contact": (contact, [[o, p] for o in (0.1, 0.3, 0.5, 0.7, 0.9) for p in (1.0, 1.5, 2.0)]),
    "odd-polynomial": (odd_polynomial, [[]]),
    "joint-nonlinearity": (nonlinearity, [[]]),
    "relaxation": (relaxation, [[0.003], [0.01], [0.03], [0.1], [0.3], [1.0]]),
    "creep": (logarithmic, [[1e-4], [1e-3], [1e-2], [0.1]]),
    "setting-in": (setting_in, [[0.5], [1.0], [3.0]]),
    "softening": (softening, [[0.02], [0.1], [0.3], [1.0]]),
    "constant-force": (constant_force, [[]]),
}
F, L, M, B, P, O, N, R, C = (
    "joint-friction", "load-dependent-friction", "maxwell-slip", "joint-backlash", "preloaded-backlash", "odd-polynomial",
    "joint-nonlinearity", "relaxation", "creep",
)  # fmt: skip
# Sets of laws by the beginning of a recording's name.
SETS = {
    "nist-load-cell": [[N]],
    "afm-": [["contact"], [B]],
    "cable-": [[R], [C], [F], [R, F], [C, F], [R, F, N], ["setting-in", F], ["setting-in", F, N]],
    "cycloidal-base": [[F], [L], [B], [N], [F, N], [L, N], [L, O], [L, B]],
    "cycloidal-": [[F], [L], [M], [N], [F, N], [L, N], [L, O]],
    "elastomer-": [[O]],
    "damper-": [[F], [M], [F, B]],
    "laminate-": [[F], [M], [F, O], [F, N], [F, "contact"]],
    "column-pitch": [[P], [O], [N]],
    "rubber-": [["softening"], ["setting-in"], ["softening", O], ["setting-in", F, O], ["softening", "setting-in", F, O]],
    "tendon-": [[F], [L], [M]],
    "stormer-": [["constant-force"]],
    "vhb-": [[R], [C], [F]],
}


# --- data ---------------------------------------------------------------------------------------------------------------------------


class Data:
    """Rows of one configuration: what is set (u) and what answers (y), in units of the largest |u|, with clock and runs."""

    def __init__(self, u, y, t, run, displacement_set):
        self.size = np.abs(u).max()
        self.u, self.y, self.run, self.displacement_set = u / self.size, y, run, displacement_set
        self.t = t / max(np.ptp(t[run == run[0]]), 1e-9)
        self.goes_on = bool(np.all(np.diff(t) > 0.0))
        names = list(dict.fromkeys(run))
        self.number = np.array([names.index(name) for name in run], dtype=float)

    def unseen(self):
        """Rows left out, part by part."""
        names = list(dict.fromkeys(self.run))
        if len(names) > 1:
            return [self.run == name for name in names]
        block = np.arange(len(self.u)) * BLOCKS // len(self.u)
        return [block % 2 == odd for odd in (0, 1)]


def configurations(recording, header, rows):
    """Data of each configuration, with its name."""
    specimen = recording["specimen"]
    column = lambda key: np.array([row[header.index(specimen[key])] for row in rows]).astype(float) if key in specimen else None
    joined = lambda key: np.array(["/".join(row[header.index(name)] for name in specimen.get(key, [])) for row in rows])
    displacement_set = specimen.get("response") == "force"
    u, y = column("force-column"), column("displacement-column")
    if displacement_set:
        u, y = y, u
    t = column("time-column")
    t = np.arange(len(u), dtype=float) if t is None else t
    run, configuration = joined("run-column"), joined("configuration-column")
    for name in dict.fromkeys(configuration):
        of_it = configuration == name
        yield name, of_it, Data(u[of_it], y[of_it], t[of_it], run[of_it], displacement_set)


# --- fits ---------------------------------------------------------------------------------------------------------------------------


def columns_of(data, names, values):
    columns, values = [data.u], list(values)
    for name in names:
        function, starts = LAWS[name]
        count = len(starts[0])
        columns += function(data, *np.abs(values[:count]) if name != "preloaded-backlash" else values[:count])
        values = values[count:]
    return np.array(columns).T


def zeroed(columns, data, names, seen):
    """Columns less their means over the seen rows of each run; a line through the origin where a constant force is sought."""
    if "constant-force" in names or names == ["through the origin"]:
        return columns
    out = np.array(columns, dtype=float)
    for name in dict.fromkeys(data.run):
        rows = data.run == name
        known = rows & seen
        out[rows] -= out[known if known.any() else rows].mean(axis=0)
    return out


def fit(data, names, seen):
    """Nonlinear parameters and coefficients that fit the seen rows best."""
    answer = zeroed(data.y, data, names, seen)[seen]

    def solved(values):
        columns = zeroed(columns_of(data, names, values), data, names, seen)[seen]
        weights = laws.least_squares(columns, answer)
        return weights, float(np.sum((answer - columns @ weights) ** 2))

    cost = lambda values: solved(values)[1]
    starts = [list(itertools.chain(*combination)) for combination in itertools.product(*(LAWS[name][1] for name in names))]
    costs = [cost(start) for start in starts]
    best = np.array(starts[int(np.argmin(costs))])
    if len(best):
        found = scipy.optimize.minimize(cost, best, method="Nelder-Mead", options={"maxfev": 60 * len(best), "xatol": 1e-4, "fatol": 1e-6 * min(costs)})
        best = found.x if found.fun < min(costs) else best
    return best, solved(best)[0]


def residuals(data, names, seen, values, weights, left_out):
    columns = zeroed(columns_of(data, names, values), data, names, seen)[left_out]
    answer = zeroed(data.y, data, names, seen)[left_out]
    return answer - columns @ weights


def line(data, names, seen, left_out):
    """Residuals of the line alone on unseen rows."""
    kept = ["through the origin"] if "constant-force" in names else []
    u, y = (zeroed(values, data, kept, seen) for values in (data.u, data.y))
    return y[left_out] - u[left_out] * (u[seen] @ y[seen]) / (u[seen] @ u[seen])


def judged(parts, names):
    """Root mean squares on unseen rows over all configurations: of the line, and of the set of laws."""
    before, after = [], []
    for _, _, data in parts:
        for left_out in data.unseen():
            # Without the first run nothing shows how much the first loading changes, nor where a memory that goes on began.
            first_counts = {"setting-in", "softening"} & set(names) or data.goes_on
            if first_counts and left_out[0] and len(set(data.run)) > 1:
                continue
            seen = ~left_out
            values, weights = fit(data, names, seen)
            before.append(line(data, names, seen, left_out))
            after.append(residuals(data, names, seen, values, weights, left_out))
    rms = lambda pieces: float(np.sqrt(np.mean(np.concatenate(pieces) ** 2)))
    return rms(before), rms(after)


def bend_left_out(parts):
    """Play operators of configurations with numbers for names: each predicted from a parabola through the others' three parameters."""
    numbers = np.array([float(name) for name, _, _ in parts])
    fits = []
    for _, _, data in parts:
        values, weights = fit(data, [F], np.full(len(data.u), True))
        fits.append(np.r_[np.abs(values), weights])
    fits, before, after = np.array(fits), [], []
    for i, (_, _, data) in enumerate(parts):
        others = np.arange(len(parts)) != i
        predicted = np.array([np.polyval(np.polyfit(numbers[others], column[others], 2), numbers[i]) for column in fits.T])
        columns = zeroed(columns_of(data, [F], predicted[:1]), data, [F], np.full(len(data.u), True))
        answer = data.y - data.y.mean()
        after.append(answer - columns @ predicted[1:])
        gains = np.array([other.u @ (other.y - other.y.mean()) / (other.u @ other.u) for j, (_, _, other) in enumerate(parts) if j != i])
        before.append(answer - (data.u - data.u.mean()) * gains.mean())
    rms = lambda pieces: float(np.sqrt(np.mean(np.concatenate(pieces) ** 2)))
    return rms(before), rms(after)


# --- stiffbench ---------------------------------------------------------------------------------------------------------------------


def of_program(program, recording, header, rows, parts):
    """Root mean square of what stiffbench predicts for the unseen rows, and the names it gave, part by part."""
    after, names = [], []
    for _, of_it, data in parts:
        places = np.flatnonzero(of_it)
        for left_out in data.unseen():
            with tempfile.TemporaryDirectory() as folder:
                kept = [rows[i] for i in places[~left_out]]
                found, _ = recordings.diagnose(program, header, kept, recording["specimen"], folder=folder)
                if not found.get("ok"):
                    return None, found["error"]["message"]
                names.append(sorted({finding["physics"] for finding in found["data"]["findings"]}))
                table = pathlib.Path(folder) / "all.csv"
                with open(table, "w", newline="") as file:
                    csv.writer(file).writerows([header, *(rows[i] for i in places)])
                done = subprocess.run([program, "part", "predict", f"{folder}/out/model.toml", str(table), "--json", "-q"], capture_output=True, text=True)
                try:
                    told = json.loads(done.stdout)
                    listed = next(value for value in told["data"].values() if isinstance(value, list) and len(value) == len(places))
                except (json.JSONDecodeError, KeyError, StopIteration):
                    return None, done.stderr.strip()[-200:] or "no predictions"
                value = lambda row: row.get("predicted", row.get("response", row.get("value"))) if isinstance(row, dict) else row
                residual = data.y - np.array([float(value(row)) for row in listed])
                after.append(zeroed(residual, data, [], ~left_out)[left_out])
    return float(np.sqrt(np.mean(np.concatenate(after) ** 2))), names


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", help="stiffbench with the command predict, to be judged beside")
    parser.add_argument("--out", default="results/independent_fits", help="results go to NAME.json and NAME.md")
    parser.add_argument("--only", default="", help="only recordings whose name contains this")
    arguments = parser.parse_args()
    if arguments.program and subprocess.run([arguments.program, "part", "predict", "--help"], capture_output=True).returncode:
        print(f"{arguments.program} has no command `part predict`: only the fits are made")
        arguments.program = None
    results = []
    for recording in recordings.known(arguments.only):
        sets = next((sets for start, sets in SETS.items() if recording["name"].startswith(start)), None)
        table = recordings.table(recording, arguments.folder)
        if sets is None or table is None or not recording["physics"]:
            continue
        parts = list(configurations(recording, *table))
        result = {"recording": recording["name"], "unseen": "runs left out in turn" if len(set(parts[0][2].run)) > 1 else "every second of 20 blocks", "sets": []}
        for names in sets:
            before, after = judged(parts, names)
            result["sets"].append({"laws": names, "line_rms": before, "rms": after, "share_unseen": 1.0 - (after / before) ** 2})
        if recording["name"].startswith("tendon-"):
            before, after = bend_left_out(parts)
            result["bend_left_out"] = {"one_gain_rms": before, "friction_rms": after}
        if arguments.program:
            ours, told = of_program(arguments.program, recording, *table, parts)
            result["stiffbench"] = {"rms": ours, "told": told}
            same = [one["rms"] for one in result["sets"] if ours and sorted(one["laws"]) == told[0]]
            result["ratio"] = ours / same[0] if same else None
        results.append(result)
        best = min(result["sets"], key=lambda one: one["rms"])
        print(f"{recording['name']}: line {best['line_rms']:.4g}, best {best['rms']:.4g} {best['laws']}", result.get("ratio", ""), flush=True)
    if not results:
        parser.error(f"{arguments.folder} holds none of the recordings")
    kept = [result for result in results if not result["recording"].startswith(UNWRITTEN)]
    lines = ["| recording | unseen | laws | line | error on unseen rows | share |", "|---|---|---|---|---|---|"]
    for result in kept:
        for one in result["sets"]:
            cells = [result["recording"], result["unseen"], ", ".join(one["laws"]), f"{one['line_rms']:.4g}", f"{one['rms']:.4g}", f"{one['share_unseen']:.2f}"]
            lines.append("| " + " | ".join(cells) + " |")
    out = pathlib.Path(arguments.out)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.with_suffix(".json").write_text(json.dumps(kept, indent=1) + "\n")
    out.with_suffix(".md").write_text("# Fits by SciPy on readings that they have not seen\n\n" + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
