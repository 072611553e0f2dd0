#!/usr/bin/env python3
"""Check the generator: noise as stated, sizes as stated, mechanics of the mishaps, same seed same files.

    python data/reality/generate/check.py

Prints one line a check; ends with an error if one is outside its bound.
"""

import filecmp
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import openseespy.opensees as ops
from scipy.stats import t

import shared  # noqa: F401
import bad_reading
import mishaps
import real_noise
import setups
from effects import Effect
from information import Information
from real_bench import RealBench, cross_matrix
from rows import LAWS, ROWS, effect_of, plan_for, whitened_rest, world
from structures import Model

FAILED = []


def report(what: str, value: float, low: float, high: float) -> None:
    fine = low <= value <= high
    print(f"{'ok  ' if fine else 'FAIL'} {what}: {value:.4g} ({low:.4g} to {high:.4g})")
    if not fine:
        FAILED.append(what)


def noises() -> None:
    """Scatter of 18,000 runs on a bench of the serial arm: correlation, growth, tails; then the covariance as a whole."""
    for kind in real_noise.KINDS:
        rng = np.random.default_rng(11)
        one = world(rng, kind, choice=("serial", "A"), unloading=True)
        clean = one.bench.displacement([])[:12]
        scatter = np.array([one.noise.scatter_um(clean, rng) for _ in range(1500)])
        unit = scatter / np.sqrt(one.noise.scatter_variances(1e6 * clean))
        report(f"{kind}: standard deviation over the stated one", float(unit.std()), 0.985, 1.015)
        lag = np.mean(unit[..., 1:] * unit[..., :-1]) / np.mean(unit**2)
        report(f"{kind}: correlation of neighbours", float(lag), one.noise.ar1 - 0.01, one.noise.ar1 + 0.01)
        squares, travel = (scatter**2).mean(axis=0).ravel(), 1e6 * np.abs(clean).ravel()
        growth = np.polyfit(travel**2, squares, 1)[0]
        report(f"{kind}: growth with travel, percent", 100.0 * np.sqrt(max(growth, 0.0)), 97.0 * one.noise.growth, 103.0 * one.noise.growth + 0.015)
        beyond = float(np.mean(np.abs(unit) > 4.0))
        low, high = 0.0, 2e-4
        if one.noise.tails:
            exact = 2.0 * t.sf(4.0 * np.sqrt(one.noise.tails / (one.noise.tails - 2.0)), one.noise.tails)
            low, high = 0.9 * exact, 1.1 * exact
        report(f"{kind}: share beyond four standard deviations", beyond, low, high)
        white, squares = Information(one.bench, one.noise).whiten, []
        for _ in range(60):
            readings = one.noise.readings_um(one.bench.displacement([]), rng)
            rest = 1e-6 * readings - one.bench.at_forces(recorded(one.bench, rng)).displacement([])
            squares.append(np.mean(white(rest) ** 2))
        # rounding to 10 um is no uniform error where the loads repeat within micrometres
        report(f"{kind}: mean square of whitened readings", float(np.mean(squares)), 0.7 if kind == "coarse" else 0.97, 1.03)


def recorded(bench: RealBench, rng) -> np.ndarray:
    """Forces as recorded, the remainder of the rounding drawn anew (the loads of one bench are fixed, and with them their rounding)."""
    table = bench.table
    return np.where(table.target == 0.0, 0.0, table.force + rng.uniform(-0.05, 0.05, table.force.shape))


def sizes() -> None:
    """The statistic of the true shape has the stated size as its mean and a deviation of one, over draws of noise and loads."""
    for index, law in enumerate(LAWS):
        rng = np.random.default_rng([12, index])
        one = world(rng, choice=("hp", "A") if index % 2 else ("stacker", "driven"), **plan_for(law))
        information = one.information()
        effect = effect_of(law, information, rng, 8.0)
        _statistic(law, one, one.bench.displacement([effect]), rng)
    for index, kind in enumerate(mishaps.KINDS):
        rng = np.random.default_rng([13, index])
        found = None
        while found is None:
            one = world(rng, choice=("hp", "A") if index % 2 else ("stacker", "driven"), unloading=True,
                        **({"holds_s": (60.0, 120.0)} if kind in mishaps.HOLDS else {}))
            found = mishaps.sized(kind, one.information(), rng, 12.0)
        _statistic(kind, one, one.bench.displacement([]) + found[0].change(found[1]), rng, wanted=12.0)


def _statistic(what: str, one, displacement: np.ndarray, rng, wanted: float = 8.0) -> None:
    information = one.information()
    shape = information.unabsorbed(information.whitened(displacement - information.clean))
    length = float(np.linalg.norm(shape))
    draws = []
    for _ in range(150):
        made = one.made(displacement, rng, {})
        draws.append(float(whitened_rest(made.readings, information, recorded(one.bench, rng)) @ shape) / length)
    report(f"{what}: length", length, 0.98 * wanted, 1.02 * wanted)
    report(f"{what}: mean of the statistic", float(np.mean(draws)), wanted - 0.6, wanted + 0.6)
    report(f"{what}: its deviation", float(np.std(draws)), 0.7, 1.3)


def deleted_residuals() -> None:
    rng = np.random.default_rng(14)
    for kind in ("assumed", "ar08", "growing"):
        one = world(rng, kind, choice=("serial", "A"))
        clean = one.bench.displacement([])
        found = np.array([
            bad_reading.deleted_residual(one.bench, one.noise, one.noise.readings_um(clean, rng), 7, 4, recorded(one.bench, rng)) for _ in range(400)
        ])
        report(f"{kind}: deviation of a deleted residual over its standard error", float(np.std(found[:, 0] / found[:, 1])), 0.9, 1.1)


def mechanics() -> None:
    rng = np.random.default_rng(15)
    one = world(rng, choice=("serial", "A")).bench
    placed = [Model(one.robot, one.mechanism, pose, one.multipliers).placement for pose in one.poses]
    element = next(e for e in one.robot.elements("A") if e["id"] == "E78")
    length, _, _, z = placed[1].element_axes(element)
    bent = one.bent_by("E78", "y")[1]
    report("curvature of the last link against kappa L^2/2", abs(float(bent @ np.array(z))) / (0.5 * length**2), 1.0 - 1e-6, 1.0 + 1e-6)
    six = one.end_compliances()
    gap = np.abs(six[:, :3, :3] - one.compliances()).max() / np.abs(one.compliances()).max()
    report("translations of the six-freedom compliance", float(gap), 0.0, 1e-9)
    tip = _with_rigid_arm(one, 2, np.array([0.0, 0.03, 0.08]))
    lift = np.vstack([np.eye(3), cross_matrix(np.array([0.0, 0.03, 0.08]))])
    report("a longer tool against a stiff beam in OpenSees", float(np.abs(lift.T @ six[2] @ lift - tip).max() / np.abs(tip).max()), 0.0, 1e-3)
    for choice in (("stacker", "full"), ("hp", "F")):
        bench = world(np.random.default_rng(16), choice=choice).bench
        moment, way, axis = mishaps._rocking(bench, np.random.default_rng(3))
        ours, theirs = moment * way, bench.base_patterns[axis][bench.table.pose, bench.table.direction, bench.table.direction] * bench.table.force
        report(f"rocking base of {choice[0]} against rigidLink in OpenSees", float(np.abs(ours - theirs).max() / np.abs(theirs).max()), 0.0, 1e-3)
    angle = {"angle": 0.02}
    force = Effect("load-misalignment", {"direction": "z", "toward": "y"}, angle, "angle")
    gauge = Effect("gauge-misalignment", {"direction": "z", "toward": "y"}, angle, "angle")
    gap = np.abs(one.displacement([force]) - one.displacement([gauge])).max() / np.abs(one.displacement([force]) - one.displacement([])).max()
    report("lean of gauge and of force by reciprocity", float(gap), 0.0, 1e-6)
    plain = world(np.random.default_rng(17), choice=("hp", "B"))
    kept = setups.misfit(plain.bench, plain.bench.displacement([]), plain.bench, plain.bench.robot.data["factors"]["m_fsd"]["beam"], plain.noise)
    report("misfit of a right set-up", kept.standard_errors, 0.0, 0.01)


def _with_rigid_arm(bench: RealBench, pose: int, arm: np.ndarray) -> np.ndarray:
    """End compliance with a beam a million times stiffer than steel from the end to a new one."""
    columns = []
    for k in range(3):
        model = Model(bench.robot, bench.mechanism, bench.poses[pose], bench.multipliers)
        end = model.split.end
        model.tag["tip"] = len(model.tag) + 1
        ops.node(model.tag["tip"], *(np.array(model.placement.node(end), dtype=float) + arm))
        ops.geomTransf("Linear", 900, 1.0, 0.0, 0.0)
        ops.element("elasticBeamColumn", 900, model.tag[end], model.tag["tip"], 1e2, 2e14, 8e13, 1e-2, 1e-2, 1e-2, 900)
        model.solve([("tip", np.concatenate([np.eye(3)[k], np.zeros(3)]))])
        columns.append([ops.nodeDisp(model.tag["tip"], dof + 1) for dof in range(3)])
        model.clear()
    return np.array(columns).T


def same_files() -> None:
    """Each row made twice by the program itself, with one job and with two."""
    program = Path(__file__).with_name("generate.py")
    with tempfile.TemporaryDirectory() as folder:
        for row in ROWS:
            for jobs in ("1", "2"):
                command = [sys.executable, program, "--row", row, "--count", "2", "--seed", "1", "--out", Path(folder) / jobs, "--jobs", jobs]
                subprocess.run(command, check=True, capture_output=True)
        compared = filecmp.dircmp(Path(folder) / "1", Path(folder) / "2")
        different = [name for sub in (compared, *compared.subdirs.values()) for name in (*sub.diff_files, *sub.left_only, *sub.right_only)]
        report("files that differ between two runs", float(len(different)), 0.0, 0.0)


def main() -> None:
    noises()
    mechanics()
    deleted_residuals()
    sizes()
    same_files()
    if FAILED:
        sys.exit(f"{len(FAILED)} checks failed: {'; '.join(FAILED)}")


if __name__ == "__main__":
    main()
