"""Programs beside each other on the torque ramps of a cycloidal joint: what they predict at another torque, and what they name.

    python head_to_head.py PROGRAM FOLDER [--out NAME] [--only TEXT] [--row TEXT]

PROGRAM is stiffbench, FOLDER holds the recordings. README.md states the protocol. All settings stand in this file and were committed before
the results. Split A trains on runs 100 and 101 (40 N m), split B on run 0 (4 N m) as well; judged are run 102, and runs 1 to 4.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import tempfile
import time
import warnings

import numpy as np
import scipy.optimize

import laws
import lisdd

FOLDER = "cycloidal-actuator-torque-ramps"
SPLITS = {"A": [100, 101], "B": [100, 101, 0]}
SMALL = [0, 1, 2, 3, 4]
LARGEST = 40.0
FRICTION = {"joint-friction", "load-dependent-friction", "maxwell-slip"}
PLAY = {"joint-backlash", "preloaded-backlash"}
NEVER = {"creep", "thermal-drift", "slip", "gauge-periodic"}


# --- data ---------------------------------------------------------------------------------------------------------------------------


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in ("run", "t_s", "position_mrad", "commanded_Nm")}


def runs_of(data, names):
    """(torque, position) of each run."""
    return [(data["commanded_Nm"][data["run"] == name], data["position_mrad"][data["run"] == name]) for name in names]


def errors(data, predict):
    """Root mean squares at 40 and 4 N m; the mean of each run's residual is taken off."""
    run = data["run"]
    residual = laws.demean(data["position_mrad"] - predict(data), run)
    at = lambda names: float(np.sqrt(np.mean(residual[np.isin(run, names)] ** 2)))
    return [at([102]), at([1, 2, 3, 4])]


def over_runs(function):
    """A prediction for a whole file from one for the torque of a run."""
    return lambda data: laws.by_run(function, data["run"], data["commanded_Nm"])


def centred(runs, columns_of):
    """Stacked columns and positions less their means in each run, each run weighted equally."""
    columns, answers = [], []
    for torque, position in runs:
        block = columns_of(torque)
        weight = 1.0 / np.sqrt(len(torque))
        columns.append((block - block.mean(axis=0)) * weight)
        answers.append((position - position.mean()) * weight)
    return np.vstack(columns), np.concatenate(answers)


# --- peers --------------------------------------------------------------------------------------------------------------------------


def constant(runs):
    return lambda torque: np.zeros(len(torque)), 0


RADII = np.r_[0.0, np.geomspace(0.5, 25.0, 15)]
DEAD_ZONES = np.geomspace(0.5, 25.0, 7)
RIDGE = 0.003


def prandtl_ishlinskii(runs):
    """Modified Prandtl-Ishlinskii: plays with weights that are not negative, dead zones of either sign (Kuhnen, European J. Control 9 (2003) 407)."""

    def columns_of(torque):
        plays = [laws.play(torque, radius) for radius in RADII]
        return np.array(plays + [laws.dead_zone(torque, width) for width in DEAD_ZONES]).T

    columns, answer = centred(runs, columns_of)
    count = columns.shape[1]
    lower = np.r_[np.zeros(len(RADII)), np.full(len(DEAD_ZONES), -np.inf)]
    columns = np.vstack([columns, np.sqrt(RIDGE) * np.eye(count)])
    weights = scipy.optimize.lsq_linear(columns, np.r_[answer, np.zeros(count)], (lower, np.inf)).x
    return lambda torque: columns_of(torque) @ weights, count


def features(torque, with_turn):
    """Torque and direction of travel; with_turn adds the torque of the last reversal."""
    direction = np.sign(np.diff(torque, prepend=torque[0]))
    branch, turn, now, last = np.zeros(len(torque)), np.zeros(len(torque)), 1.0, 0.0
    for i in range(len(torque)):
        if direction[i] not in (0.0, now):
            now, last = direction[i], torque[i - 1]
        branch[i], turn[i] = now, last
    columns = [torque / LARGEST, branch] + ([turn / LARGEST] if with_turn else [])
    return np.array(columns).T


def tuned(candidates, runs):
    """The candidate with the smallest error on training runs left out in turn, each in units of its own spread."""

    def score(fit):
        total = 0.0
        for left_out in range(len(runs)):
            predict, _ = fit(runs[:left_out] + runs[left_out + 1 :])
            torque, position = runs[left_out]
            residual = position - predict(torque)
            total += np.std(residual) / np.std(position)
        return total

    best = min(candidates, key=score)
    return best(runs)


POINTS = 360
LENGTHS = [0.1, 0.2, 0.4, 0.8]


def gaussian_process(with_turn):
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    def candidate(length):
        def fit(runs):
            inputs, answers = [], []
            for torque, position in runs:
                kept = np.unique(np.linspace(0, len(torque) - 1, POINTS // len(runs)).astype(int))
                inputs.append(features(torque, with_turn)[kept])
                answers.append((position - position.mean())[kept])
            inputs, answers = np.vstack(inputs), np.concatenate(answers)
            scale = answers.std()
            lengths = np.full(inputs.shape[1], length)
            kernel = ConstantKernel(1.0) * RBF(lengths, (1e-2, 1e2)) + WhiteKernel(1e-2, (1e-5, 1.0))
            process = GaussianProcessRegressor(kernel, random_state=0).fit(inputs, answers / scale)
            return lambda torque: scale * process.predict(features(torque, with_turn)), len(answers) + len(lengths) + 2

        return fit

    return lambda runs: tuned([candidate(length) for length in LENGTHS], runs)


DEGREES = {False: [1, 2, 3, 4, 5], True: [1, 2, 3]}
THRESHOLDS = [0.003, 0.01, 0.03, 0.1, 0.3]


def sparse_regression(with_turn):
    import pysindy
    from sklearn.preprocessing import PolynomialFeatures

    def candidate(degree, threshold):
        def fit(runs):
            columns_of = lambda torque: PolynomialFeatures(degree).fit_transform(features(torque, with_turn))
            columns, answer = centred(runs, columns_of)
            scale = np.sqrt((columns**2).sum(axis=0))
            scale[scale == 0.0] = 1.0
            optimizer = pysindy.STLSQ(threshold=threshold * np.linalg.norm(answer), alpha=1e-6)
            optimizer.fit(columns / scale, answer[:, None])
            weights = optimizer.coef_.ravel() / scale
            return lambda torque: columns_of(torque) @ weights, int(np.count_nonzero(weights))

        return fit

    return lambda runs: tuned([candidate(d, t) for d in DEGREES[with_turn] for t in THRESHOLDS], runs)


def same_laws(runs):
    """Friction f0 + mu |torque| before a spring that hardens, with play taken up smoothly, beside a line; least squares by SciPy.

    Each run is weighted by its size to the power -1/2 beside its length, between absolute and relative errors.
    """

    def columns_of(torque, friction, growth, seat):
        carried = laws.load_dependent_play(torque, friction, growth)
        return np.array([torque, carried, (carried / LARGEST) ** 3, carried / (np.abs(carried) + seat)]).T

    def parts(shape):
        columns, answers = [], []
        for torque, position in runs:
            block = columns_of(torque, *shape)
            weight = 1.0 / np.sqrt(len(torque) * position.std())
            columns.append((block - block.mean(axis=0)) * weight)
            answers.append((position - position.mean()) * weight)
        return np.vstack(columns), np.concatenate(answers)

    def residual(shape):
        columns, answer = parts(shape)
        return answer - columns @ laws.least_squares(columns, answer)

    starts = [[f, g, s] for f in (0.5, 2.0, 4.0) for g in (0.05, 0.3) for s in (0.5, 3.0)]
    bounds = ([0.0, 0.0, 0.01], [10.0, 0.9, 20.0])
    fits = [scipy.optimize.least_squares(residual, s, bounds=bounds, x_scale=[1.0, 0.1, 1.0], diff_step=1e-3) for s in starts]
    shape = min(fits, key=lambda fit: fit.cost).x
    weights = laws.least_squares(*parts(shape))
    return lambda torque: columns_of(torque, *shape) @ weights, 7


def peers():
    return {
        "constant": constant,
        "PySINDy STLSQ": sparse_regression(False),
        "PySINDy STLSQ, told the last reversal": sparse_regression(True),
        "Gaussian process": gaussian_process(False),
        "Gaussian process, told the last reversal": gaussian_process(True),
        "LISDD": lambda runs: lisdd.fit(runs, LARGEST),
        "LISDD, told the last reversal": lambda runs: lisdd.fit(runs, LARGEST, with_turn=True),
        "modified Prandtl-Ishlinskii": prandtl_ishlinskii,
        "friction, play, hardening by SciPy": same_laws,
    }


# --- stiffbench ---------------------------------------------------------------------------------------------------------------------

COLUMNS = [
    "--specimen", "--force-column", "commanded_Nm", "--force-unit", "1", "--displacement-column", "position_mrad",
    "--displacement-unit", "1", "--time-column", "t_s", "--run-column", "run",
]  # fmt: skip


def call(command):
    done = subprocess.run(command, capture_output=True, text=True)
    try:
        return json.loads(done.stdout)
    except json.JSONDecodeError:
        return {"ok": False, "error": {"message": done.stderr.strip()[-300:]}}


def can_predict(program):
    return subprocess.run([program, "part", "predict", "--help"], capture_output=True).returncode == 0


def write(path, data, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        names = ["run", "t_s", "position_mrad", "commanded_Nm"]
        writer.writerow(names)
        writer.writerows(zip(*(data[name][rows] for name in names)))


def diagnosis(program, data, names, folder):
    """Verdict, names and number of parameters of a diagnosis of some runs; its model lies in `folder`."""
    table = pathlib.Path(folder) / "train.csv"
    write(table, data, np.isin(data["run"], names))
    began = time.perf_counter()
    told = call([program, "diagnose", str(table), *COLUMNS, "--out", f"{folder}/out", "--json", "--no-figures", "-q"])
    seconds = time.perf_counter() - began
    if not told.get("ok"):
        return {"verdict": "error", "names": [], "parameters": None, "seconds": seconds, "error": told["error"]["message"]}
    found = told["data"]
    findings = found["findings"]
    return {
        "verdict": found["verdict"],
        "grade": found.get("grade"),
        "names": [finding["physics"] for finding in findings],
        "groups": [finding.get("alternative_group") for finding in findings],
        # The slope of the line, and what acts in the model: of a set its first. Zeros of runs are not counted for any program.
        "parameters": 1 + sum(len(finding["parameters"]) for finding in acting(findings)),
        "seconds": seconds,
    }


def acting(findings):
    """Findings that act in the model: of each set that cannot be distinguished the first."""
    groups = [finding.get("alternative_group") for finding in findings]
    return [finding for place, finding in enumerate(findings) if groups[place] is None or groups[place] not in groups[:place]]


def predicted(program, data, folder):
    """Positions that the model of the last diagnosis predicts for all rows."""
    table = pathlib.Path(folder) / "all.csv"
    write(table, data, np.full(len(data["run"]), True))
    told = call([program, "part", "predict", f"{folder}/out/model.toml", str(table), "--json", "-q"])
    if not told.get("ok"):
        raise RuntimeError(told["error"]["message"])
    rows = next(value for value in told["data"].values() if isinstance(value, list) and len(value) == len(data["run"]))
    value = lambda row: row.get("predicted", row.get("response", row.get("value"))) if isinstance(row, dict) else row
    return np.array([float(value(row)) for row in rows])


def judged_names(name, told):
    """Whether the names are as they should be: friction alone or in a set, no dustbin, play at 4 N m in a set only."""
    named = told["verdict"] in ("explained", "ambiguous")
    play_alone = any(n in PLAY and g is None for n, g in zip(told["names"], told.get("groups", [])))
    return {
        "friction": named and bool(FRICTION & set(told["names"])),
        "never": sorted(NEVER & set(told["names"])),
        "play_alone": play_alone and name.startswith(("conic", "split")),
    }


# --- comparison ---------------------------------------------------------------------------------------------------------------------


def repeat_scatter(files):
    """Standard deviation of one run about the mean of its equals at the same place of the ramp, medians over the files."""
    scatter = []
    for data in files.values():
        row = []
        for names in ([100, 101, 102], SMALL):
            place = np.linspace(0.0, 1.0, 400)
            runs = [np.interp(place, np.linspace(0.0, 1.0, len(p)), p) for _, p in runs_of(data, names)]
            row.append(np.sqrt(np.var(runs, axis=0, ddof=1).mean()))
        scatter.append(row)
    return np.median(scatter, axis=0)


def compare_peer(peer, fit, files):
    """Row of a peer, and its errors on each file."""
    row, per_file = {"program": peer}, {}
    for split, training in SPLITS.items():
        began = time.perf_counter()
        found = {}
        for name, data in files.items():
            predict, count = fit(runs_of(data, training))
            found[name] = errors(data, over_runs(predict)) + [count]
        row[split] = medians(found)
        row[f"seconds_{split}"] = (time.perf_counter() - began) / len(files)
        per_file[f"{peer}, {split}"] = found
    print(f"{peer}: {row['A']} {row['B']}", flush=True)
    return row, per_file


def renewed(result, only, files):
    """An earlier result with the rows of some peers made anew."""
    rows = {row["program"]: row for row in result["rows"]}
    for peer, fit in peers().items():
        if only in peer:
            rows[peer], per_file = compare_peer(peer, fit, files)
            result["files"].update(per_file)
    result["rows"] = [rows[name] for name in [*peers(), "stiffbench"] if name in rows]
    return result


def compare(program, files, ours_predicts):
    rows, per_file, names = [], {}, {}
    for peer, fit in peers().items():
        row, found = compare_peer(peer, fit, files)
        rows.append(row)
        per_file.update(found)
    row = {"program": "stiffbench"}
    for split, training in {**SPLITS, "4 N m alone": SMALL, "all runs": SMALL + [100, 101, 102]}.items():
        found, told = {}, {}
        for name, data in files.items():
            with tempfile.TemporaryDirectory() as folder:
                told[name] = diagnosis(program, data, training, folder)
                told[name].update(judged_names(name, told[name]))
                if ours_predicts and split in SPLITS:
                    try:
                        position = predicted(program, data, folder)
                        found[name] = errors(data, lambda _: position) + [told[name]["parameters"]]
                    except (RuntimeError, StopIteration, OSError) as problem:
                        told[name]["no_prediction"] = str(problem)
        names[split] = told
        if split in SPLITS:
            row[split] = medians(found) if len(found) == len(files) else None
            row[f"seconds_{split}"] = float(np.mean([one["seconds"] for one in told.values()]))
            per_file[f"stiffbench, {split}"] = found
    rows.append(row)
    return {"rows": rows, "names": names, "files": per_file, "repeat_scatter": repeat_scatter(files).tolist()}


def medians(found):
    values = np.array(list(found.values()), dtype=float)
    large, small, count = np.median(values, axis=0)
    return {"at_40": float(large), "at_4": float(small), "parameters": float(count), "most_parameters": int(values[:, 2].max())}


def criteria(result):
    """The figures that are wanted, beside what came out."""
    by = {row["program"]: row for row in result["rows"]}
    ours = by["stiffbench"]
    lines = []
    if ours.get("A") and ours.get("B"):
        for key, torque in (("at_40", "40"), ("at_4", "4")):
            black = min(by[name]["B"][key] for name in ("PySINDy STLSQ", "Gaussian process"))
            told = min(by[f"{name}, told the last reversal"]["B"][key] for name in ("PySINDy STLSQ", "Gaussian process"))
            hysteresis = by["modified Prandtl-Ishlinskii"]["B"][key]
            value = ours["B"][key]
            lines.append(f"B, {torque} N m: {value / black:.2f} times the better black box (wanted: 0.85)")
            lines.append(f"B, {torque} N m: {value / told:.2f} times the better black box that is told the last reversal")
            lines.append(f"B, {torque} N m: {value / hysteresis:.2f} times modified Prandtl-Ishlinskii (wanted: 1.1)")
        lines.append(f"B: {ours['B']['most_parameters']} parameters at most (wanted: 10)")
        lines.append(f"A, 4 N m: {ours['A']['at_4']:.2f} mrad, a constant {by['constant']['A']['at_4']:.2f} (wanted: not more)")
    for split, told in result["names"].items():
        friction = sum(one["friction"] for one in told.values())
        never = sum(bool(one["never"]) for one in told.values())
        alone = sum(one["play_alone"] for one in told.values())
        lines.append(
            f"names, {split}: friction in {friction} of {len(told)}, creep, drift, slip or gauge period in {never}, play alone in conic or split in {alone}"
        )
    return lines


def table(result):
    lines = ["| program | parameters (B) | A, 40 N m | A, 4 N m | B, 40 N m | B, 4 N m | seconds a file (B) |", "|---|---|---|---|---|---|---|"]
    for row in result["rows"]:
        cells = [f"{row[s][k]:.2f}" if row.get(s) else "-" for s in SPLITS for k in ("at_40", "at_4")]
        count = f"{row['B']['parameters']:.0f}" if row.get("B") else "-"
        lines.append(f"| {row['program']} | {count} | " + " | ".join(cells) + f" | {row['seconds_B']:.2f} |")
    large, small = result["repeat_scatter"]
    lines.append(f"| repeat scatter | | {large:.2f} | {small:.2f} | {large:.2f} | {small:.2f} | |")
    return "\n".join(lines)


def names_table(result):
    lines = ["| file | " + " | ".join(result["names"]) + " |", "|---" * (1 + len(result["names"])) + "|"]
    for name in next(iter(result["names"].values())):
        cells = []
        for told in result["names"].values():
            one = told[name]
            cells.append(f"{one['verdict']} {one.get('grade') or ''}: {', '.join(one['names']) or '-'}")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def figure(result, path):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "stiffbench"
    import matplotlib.pyplot as plt

    rows = [row for row in result["rows"] if row.get("B")]
    chart, axes = plt.subplots(1, 2, figsize=(10, 0.45 * len(rows) + 1.6), sharey=True)
    for axis, split in zip(axes, SPLITS):
        for place, row in enumerate(reversed(rows)):
            axis.plot(row[split]["at_40"], place, "o", color="#1f4e79", label="40 N m" if place == 0 else None)
            axis.plot(row[split]["at_4"], place, "s", color="#c55a11", label="4 N m" if place == 0 else None)
        for value, colour in zip(result["repeat_scatter"], ("#1f4e79", "#c55a11")):
            axis.axvline(value, color=colour, linestyle=":", linewidth=1)
        axis.set_xscale("log")
        axis.set_title({"A": "trained at 40 N m", "B": "trained at 40 and 4 N m"}[split])
        axis.grid(axis="x", which="both", alpha=0.3)
    axes[0].set_yticks(range(len(rows)), [row["program"] for row in reversed(rows)])
    axes[0].legend(loc="lower right", frameon=False)
    chart.supxlabel("root mean square of the error in mrad, median of the files; dotted: scatter from repeat to repeat", fontsize=9)
    chart.tight_layout()
    chart.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--out", default="results/head_to_head", help="results go to NAME.md, NAME.json, NAME.svg")
    parser.add_argument("--only", default="", help="only files whose name contains this")
    parser.add_argument("--row", help="make only the peers anew whose name contains this; the other rows stay as they are in NAME.json")
    arguments = parser.parse_args()
    warnings.filterwarnings("ignore")
    paths = sorted(path for path in (arguments.folder / FOLDER).glob("*.csv") if arguments.only in path.stem)
    if not paths:
        parser.error(f"{arguments.folder / FOLDER} holds no recordings")
    files = {path.stem: read(path) for path in paths}
    out = pathlib.Path(arguments.out)
    if arguments.row is not None:
        result = renewed(json.loads(out.with_suffix(".json").read_text()), arguments.row, files)
    else:
        ours_predicts = can_predict(arguments.program)
        if not ours_predicts:
            print(f"{arguments.program} has no command `part predict`: its errors are left out, its names are not")
        result = compare(arguments.program, files, ours_predicts)
    result["wanted"] = criteria(result)
    out.parent.mkdir(parents=True, exist_ok=True)
    text = "\n\n".join(
        [f"# Head to head on {len(files)} torque ramps", "Root mean squares in mrad, medians of the files.", table(result),
         "\n".join(f"- {line}" for line in result["wanted"]), "## Names that stiffbench gives", names_table(result)]
    )  # fmt: skip
    out.with_suffix(".md").write_text(text + "\n")
    out.with_suffix(".json").write_text(json.dumps(result, indent=1) + "\n")
    figure(result, out.with_suffix(".svg"))
    print(text)


if __name__ == "__main__":
    main()
