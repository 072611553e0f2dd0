#!/usr/bin/env python3
"""Sessions with a displacement gauge along each base axis: x, y and z are read at every load.

    python data/concealed/generate/three_gauges.py OUT [--seeds N] [--sizes 10 25] [--kinds K ...] [--exact]

Structures, laws, clock and noise are those of the benches with one gauge.  Loads also act along oblique
directions; the end's displacement along all three axes comes out of the OpenSees solution.  Scatter,
zero and step are each gauge's own; what the force gauge rounds off and the slope of a run move all three
gauges of a reading together.  Writes OUT/<kind>-<size>-<seed>/ (session.toml, readings.csv) and
OUT/answers.json.  Same seed, same files.
"""

import argparse
import dataclasses
import json
import os
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import recipes
from bench import Bench
from effects import Effect, joint_law, unit_of
from information import Information
from laws import solve_twists
from noise import Noise
from plan import LOADS, Plan, Table, take
from recipes import LIMITS, NotReachable
from structures import PROPERTIES, ROOT, Changes, Robot

SEED = 20261127
AXES = "xyz"
OBLIQUE = ((1.0, 1.0, 0.0), (0.0, 1.0, 1.0), (0.0, -0.6, 0.8), (1.0, -1.0, 1.0))
COLUMNS = ("seq,pose,direction,branch,step,target_N,repeat,attempt,run,zero_id,axes,force_x_N,force_y_N,force_z_N,force_raw,"
           "displacement_x_um,displacement_y_um,displacement_z_um,hold_s,t_s,temp_degC")


@dataclass(frozen=True)
class Direction:
    """Of a load: its name in the readings, and a unit vector along the base axes."""

    name: str
    vector: tuple[float, float, float]

    @staticmethod
    def along(vector) -> "Direction":
        unit = np.array(vector, dtype=float) / np.linalg.norm(vector)
        for axis, own in zip(AXES, np.eye(3)):
            if np.array_equal(unit, own):
                return Direction(axis, tuple(unit))
        return Direction("(" + ",".join(f"{round(v, 4) + 0.0:g}" for v in unit) + ")", tuple(map(float, unit)))

    def toml(self) -> str:
        return f'"{self.name}"' if self.name in AXES else "[" + ", ".join(map(repr, self.vector)) + "]"


def take_along(plan: Plan, directions: list[Direction], rng: np.random.Generator) -> Table:
    """As `plan.take`; the directions of the table are numbers of the list."""
    count = len(directions)
    # Only the first direction of a pose matters to the clock: the others do not wait for a new pose.
    table = take(dataclasses.replace(plan, directions=("x", *("y",) * (count - 1))), rng)
    numbers = np.arange(len(table.pose)) // plan.repeats % count
    return dataclasses.replace(table, direction=np.broadcast_to(numbers[:, None], table.pose.shape))


def stacked(table: Table) -> Table:
    """A table whose arrays have a third axis, of length one, for the gauges."""
    arrays = {f.name: getattr(table, f.name)[..., None] for f in dataclasses.fields(table) if f.name != "names"}
    return Table(**arrays, names=table.names)


class ThreeGaugeBench(Bench):
    """Displacements are runs x steps x 3.  The place of an effect of one gauge has the key `direction`, as in the JSON of a diagnosis."""

    def __init__(self, robot, mechanism, poses, beam, link, table: Table, directions: list[Direction]) -> None:
        super().__init__(robot, mechanism, poses, beam, link, stacked(table))
        self.plain, self.directions = table, directions
        self.vectors = np.array([direction.vector for direction in directions])[table.direction]

    def with_beam(self, beam: dict) -> "ThreeGaugeBench":
        return ThreeGaugeBench(self.robot, self.mechanism, self.poses, beam, self.multipliers["link"], self.plain, self.directions)

    def forces(self, effects: list[Effect]) -> np.ndarray:
        force = self.plain.force
        for effect in effects:
            if effect.physics == "force-gauge-nonlinearity":
                force = force * (1.0 + effect.parameters["q"] * np.abs(force))
        return force[..., None] * self.vectors

    def mechanics(self, effects: list[Effect]) -> np.ndarray:
        force = self.forces(effects)
        total = np.einsum("rskl,rsl->rsk", self.compliances()[self.plain.pose], force)
        jointed = [effect for effect in effects if joint_law(effect)]
        return total + self._joints(jointed, force, Changes()) if jointed else total

    def _joints(self, effects: list[Effect], force: np.ndarray, changes: Changes) -> np.ndarray:
        index = [self.actions[0].ids.index(effect.place["joint"]) for effect in effects]
        pose = self.plain.pose[:, 0]
        lever = np.array([action.lever[index] for action in self.actions])[pose]
        stiffness = np.array([action.stiffness[np.ix_(index, index)] for action in self.actions])[pose]
        twists = solve_twists([joint_law(effect) for effect in effects], np.einsum("rjk,rsk->rsj", lever, force), stiffness)
        return np.einsum("rjk,rsj->rsk", lever, twists)

    def applied_moments(self, joint: str) -> np.ndarray:
        index = self.actions[0].ids.index(joint)
        lever = np.array([action.lever[index] for action in self.actions])[self.plain.pose]
        return np.einsum("rsk,rsk->rs", lever, self.forces([]))[..., None]

    def _beside(self, effect: Effect) -> np.ndarray | float:
        if effect.physics != "slip":
            return super()._beside(effect) * shown_by(effect)
        run, table = effect.place["run"], self.table
        number = [direction.name for direction in self.directions].index(run["direction"])
        there = (table.pose == table.names.index(run["pose"])) & (table.direction == number) & (table.repeat == run["repeat"])
        return np.where(there & (table.step >= effect.place["step"]), effect.parameters["jump"], 0.0) * shown_by(effect)

    def _gauge(self, effect: Effect, total: np.ndarray) -> np.ndarray | float:
        return super()._gauge(effect, total) * shown_by(effect)


def shown_by(effect: Effect) -> np.ndarray:
    """One for each gauge that shows an effect, else zero."""
    return np.ones(3) if "direction" not in effect.place else np.eye(3)[AXES.index(effect.place["direction"])]


@dataclass(frozen=True)
class ThreeGaugeNoise(Noise):
    """Readings are runs x steps x 3; `slopes` tells whether a run has one slope, or each gauge its own."""

    slopes: str = "run"  # or "gauge"

    def readings_um(self, clean_m: np.ndarray, rng: np.random.Generator, gauge_error_m=lambda stood_m: 0.0) -> np.ndarray:
        """`gauge_error_m`: of where a gauge stands, which is with the slope of the run."""
        runs = clean_m.shape[0]
        zero = self.sigma0 * rng.standard_normal((runs, 1, 3))
        slope = self.slope * rng.standard_normal((runs, 1, 1 if self.slopes == "run" else 3))
        stood_m = clean_m * (1.0 + slope)
        total = 1e6 * (stood_m + gauge_error_m(stood_m)) + zero + self.sigma * self._unit(clean_m.shape, rng)
        return np.round(total / self.res_um) * self.res_um

    def covariances(self, baseline: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Covariance of all readings of each run, um^2; those of the three gauges stand side by side at each step."""
        runs, steps, gauges = baseline.shape
        own = np.kron(np.eye(steps * gauges), self.sigma**2 + self.res_um**2 / 12.0)
        zero = self.sigma0**2 * np.kron(np.ones((steps, steps)), np.eye(gauges))
        same_reading = np.kron(np.eye(steps), np.ones((gauges, gauges)))
        same_gauge = np.kron(np.ones((steps, steps)), np.eye(gauges))
        force = force.reshape(runs, steps, 1)
        per_newton = np.where(force != 0.0, baseline / np.where(force != 0.0, force, 1.0), 0.0).reshape(runs, -1)
        moved, lines = per_newton * self.force_resolution_N / np.sqrt(12.0), self.slope * baseline.reshape(runs, -1)
        tilt = 1.0 if self.slopes == "run" else same_gauge
        return np.array([
            own + zero + same_reading * np.outer(moved[run], moved[run]) + tilt * np.outer(lines[run], lines[run])
            for run in range(runs)
        ])


def jointed(physics: str):
    """A joint law at a joint drawn by chance."""

    def draw(information: Information, rng: np.random.Generator, standard_errors: float) -> Effect:
        for name in rng.permutation(information.bench.actions[0].ids):
            effect = recipes._shaped(information.bench, physics, str(name), rng)
            sized = effect and information.sized(effect, standard_errors, 1e-10, LIMITS[physics])
            if sized:
                return sized
        raise NotReachable(physics)

    return draw


def simple(physics: str, one_gauge: bool = False):
    """Any other law; of one gauge drawn by chance, or of all."""

    def draw(information: Information, rng: np.random.Generator, standard_errors: float) -> Effect:
        for _ in range(24):
            effect, start = _slip(information, rng) if physics == "slip" else recipes._simple(physics, {}, information, rng)
            if one_gauge:
                effect.place["direction"] = str(rng.choice(list(AXES)))
            sized = information.sized(effect, standard_errors, start, LIMITS[physics])
            if sized:
                return sized
        raise NotReachable(physics)

    return draw


def _slip(information: Information, rng: np.random.Generator) -> tuple[Effect, float]:
    bench, table = information.bench, information.bench.plain
    run = int(rng.integers(len(table.pose)))
    place = {
        "run": {"pose": table.names[table.pose[run, 0]], "direction": bench.directions[table.direction[run, 0]].name,
                "repeat": int(table.repeat[run, 0])},
        "step": int(rng.integers(2, int(table.step[run].max()) - 1)),
    }
    return Effect("slip", place, {"jump": 1.0}, "jump"), float(rng.choice([-1.0, 1.0])) * 1e-8


KINDS = {
    "clean": None,
    "joint-compliance": jointed("joint-compliance"),
    "joint-backlash": jointed("joint-backlash"),
    "joint-friction": jointed("joint-friction"),
    "creep": simple("creep"),
    "thermal-drift": simple("thermal-drift", one_gauge=True),
    "slip": simple("slip", one_gauge=True),
    "force-gauge-nonlinearity": simple("force-gauge-nonlinearity"),
    "gauge-periodic": simple("gauge-periodic", one_gauge=True),
}


def make(kind: str, standard_errors: float, seed: int, noise: ThreeGaugeNoise, mechanism: str | None = None):
    """One session: bench, plan, effects, information, and readings in um."""
    robot = Robot(str(ROOT / "data" / "robots" / "hp-robot.toml"))
    for attempt in range(8):
        rng = np.random.default_rng([SEED, list(KINDS).index(kind), int(10 * standard_errors), seed, attempt])
        plan = Plan(poses=tuple(sorted(rng.permutation(["P1", "P2", "P3", "P4"])[:3].tolist())),
                    holds_s=(60.0, 120.0) if kind == "creep" else ())
        directions = [Direction.along(v) for v in (*np.eye(3), OBLIQUE[rng.integers(len(OBLIQUE))])]
        start = robot.data["factors"]["m_fsd"]
        beam = {name: float(f"{start['beam'][name] * np.exp(rng.uniform(np.log(0.55), np.log(1.8))):.5g}") for name in PROPERTIES}
        poses = [{k: v for k, v in robot.data["poses"][name].items() if k in robot.variables} for name in plan.poses]
        bench = ThreeGaugeBench(robot, mechanism or "AF"[seed % 2], poses, beam, start["link"],
                                take_along(plan, directions, rng), directions)
        if KINDS[kind] is None:
            return bench, plan, [], None, noise.readings_um(bench.displacement([]), rng)
        information = Information(bench, noise)
        try:
            effects = [KINDS[kind](information, rng, standard_errors)]
        except NotReachable:
            continue
        before = bench.displacement([effect for effect in effects if effect.physics != "gauge-periodic"])
        readings = noise.readings_um(before, rng, lambda stood_m: sum(bench._gauge(effect, stood_m) for effect in effects))
        return bench, plan, effects, information, readings
    raise NotReachable(f"{kind}, {standard_errors} standard errors, seed {seed}")


def write_session(folder: Path, robot: str, bench: ThreeGaugeBench, plan: Plan, noise: Noise, readings: np.ndarray) -> None:
    """`robot`: path of the robot file from the folder, or a shipped name; the folder's name is the id."""
    folder.mkdir(parents=True)
    table, digits = bench.plain, max(0, int(np.ceil(-np.log10(noise.res_um))))
    lines = [COLUMNS]
    for run, step in np.ndindex(table.pose.shape):
        direction = bench.directions[table.direction[run, step]]
        name = direction.name if direction.name in AXES else f'"{direction.name}"'
        lines.append(",".join([
            str(len(lines)), table.names[table.pose[run, step]], name, "loading" if table.step[run, step] < len(LOADS) else "unloading",
            str(table.step[run, step]), f"{table.target[run, step]:.0f}", str(table.repeat[run, step]),
            "1", str(run + 1), str(run + 1), "base",
            *(repr(float(round(table.rounded[run, step] * v, 12)) + 0.0) for v in direction.vector),
            f"{table.rounded[run, step] + 0.0:.1f}", *(f"{value + 0.0:.{digits}f}" for value in readings[run, step]),
            f"{table.hold[run, step]:.1f}", f"{table.time[run, step]:.2f}", f"{table.temperature[run, step]:.2f}",
        ]))
    (folder / "readings.csv").write_text("\n".join(lines) + "\n")
    quoted = lambda items: "[" + ", ".join(f'"{item}"' for item in items) + "]"
    records = "".join(f"[instruments.displacement_{axis}]\nresolution_um = {noise.res_um}\n" for axis in AXES)
    (folder / "session.toml").write_text(f'''schema = "stiffbench/session/2"
id = "{folder.name}"
robot = "{robot}"
mechanism = "{bench.mechanism}"
factors = "m_fsd"            # link factors are those of this set; beam factors are to be fitted

[procedure]
text = "{plan.text().replace("the gauge is", "the gauges are")}"
poses = {quoted(plan.poses)}
directions = [{", ".join(direction.toml() for direction in bench.directions)}]
displacement_axes = {quoted(AXES)}
loads_N = [{", ".join(map(str, LOADS))}]
branches = {quoted(["loading", "unloading"] if plan.unloading else ["loading"])}
repeats = {plan.repeats}
repeat_order = "sweep"
zero = "run"
holds_s = [{", ".join(f"{hold:g}" for hold in plan.holds_s)}]

[procedure.settle]
force_tolerance_N = 0.5

[instruments.force]
resolution_N = {noise.force_resolution_N}
{records}''')


def exact(folder: Path, robot: str, mechanism: str, seed: int) -> dict:
    """A session without noise and steps, its loads exactly the targets; the compliances in um/N."""
    noise = ThreeGaugeNoise(res_um=1e-6)
    made, plan, *_ = make("clean", 0.0, seed, noise, mechanism)
    table = dataclasses.replace(made.plain, force=made.plain.target)
    bench = ThreeGaugeBench(made.robot, made.mechanism, made.poses, *made.multipliers.values(), table, made.directions)
    write_session(folder, robot, bench, plan, noise, 1e6 * bench.displacement([]))
    return {"mechanism": mechanism, "beam_factors": bench.multipliers["beam"],
            "compliances_um_per_N": dict(zip(plan.poses, (1e6 * bench.compliances()).tolist()))}


def answer_of(bench: ThreeGaugeBench, plan: Plan, effects: list[Effect], information: Information | None) -> dict:
    truths = []
    for effect in effects:
        change = 1e6 * np.abs(bench.displacement(effects) - bench.displacement([]))
        truths.append({
            "physics": effect.physics, "place": effect.place, "size": effect.size,
            "parameters": {k: {"value": v, "unit": unit_of(effect, k)} for k, v in effect.parameters.items() if k != "per_kelvin"},
            "standard_errors": round(information.length(effect), 2),
            "end_effect_um": [round(float(v), 2) for v in change.max(axis=(0, 1))],
        })
    return {"mechanism": bench.mechanism, "poses": plan.poses, "directions": [d.name for d in bench.directions],
            "beam_factors": bench.multipliers["beam"], "truth": truths}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="folder to write to")
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--sizes", nargs="*", type=float, default=[10.0, 25.0], help="of effects, in standard errors")
    parser.add_argument("--seeds", type=int, default=3, help="how many; even ones are of mechanism A, odd ones of F")
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--mechanism", help="the same for all")
    parser.add_argument("--slopes", default="run", choices=["run", "gauge"], help="whether gauges of a run share its slope")
    parser.add_argument("--robot", default="hp-robot", help="shipped name, or path of the robot file from a session folder")
    parser.add_argument("--exact", action="store_true", help="instead: a session without noise, of each mechanism")
    arguments = parser.parse_args()
    answers = {}
    if arguments.exact:
        for seed, mechanism in enumerate("AF"):
            name = f"exact-{mechanism}"
            answers[name] = exact(arguments.out / name, arguments.robot, mechanism, seed)
    else:
        noise = ThreeGaugeNoise(slopes=arguments.slopes)
        seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
        jobs = [(kind, size, seed) for seed in seeds for kind in arguments.kinds
                for size in ([0.0] if KINDS[kind] is None else arguments.sizes)]
        for kind, size, seed in jobs:
            name = f"{kind}-{size:g}-{seed}"
            bench, plan, effects, information, readings = make(kind, size, seed, noise, arguments.mechanism)
            write_session(arguments.out / name, arguments.robot, bench, plan, noise, readings)
            answers[name] = answer_of(bench, plan, effects, information)
    (arguments.out / "answers.json").write_text(json.dumps(answers, indent=1) + "\n")


if __name__ == "__main__":
    main()
