"""The rows: which bench stands at which place of a row, its readings and its answer."""

from dataclasses import dataclass, replace

import numpy as np

import shared  # noqa: F401
import bad_reading
import judge
import mishaps
import real_noise
import recipes
import robot_text
import setups
from candidates import Session, WideLibrary, left_after, near, title
from effects import Effect, unit_of
from information import Information, orthonormal
from observer import Observer
from plan import Plan, take
from real_bench import RealBench
from real_noise import RealNoise
from recipes import NotReachable, beside
from structures import PROPERTIES

BENCHES = (("hp", "F"), ("hp", "A"), ("serial", "A"), ("stacker", "full"), ("hp", "B"), ("stacker", "driven"), ("hp", "D"), ("stacker", "bare"))
POSES = {"hp": ("P1", "P2", "P3", "P4"), "serial": ("P1", "P2", "P3", "P4"), "stacker": ("near", "far", "high", "low")}
NOISES = tuple(real_noise.KINDS)
LAWS = ("joint-compliance", "joint-backlash", "joint-friction", "joint-nonlinearity", "base-compliance", "gauge-stand-compliance",
        "load-misalignment", "force-gauge-nonlinearity", "creep", "thermal-drift", "thermal-drift-per-kelvin", "setting-in", "slip",
        "gauge-periodic", "constant-force")
SIZES = (4.5, 6.0, 8.0)
PAIRS = (
    ("joint-compliance", "thermal-drift"), ("creep", "gauge-periodic"), ("joint-backlash", "joint-friction"),
    ("base-compliance", "gauge-stand-compliance"), ("joint-backlash", "setting-in"), ("force-gauge-nonlinearity", "joint-friction"),
    ("joint-friction", "creep"), ("slip", "thermal-drift"), ("constant-force", "joint-compliance"), ("load-misalignment", "setting-in"),
)
INSEPARABLE = ("joint-friction", "joint-compliance", "joint-backlash", "joint-nonlinearity", "load-misalignment", "gauge-stand-compliance")
HOLDS = (60.0, 120.0)
ATTEMPTS = 60


@dataclass
class Made:
    """One session: what is written, and what the answer says."""

    table: object
    plan: Plan
    noise: RealNoise
    readings: np.ndarray
    text: str
    mechanism: str
    answer: dict


@dataclass
class World:
    """A bench with nothing wrong, before anything is put into it."""

    robot: str
    noise_kind: str
    bench: RealBench
    plan: Plan
    noise: RealNoise
    text: str

    def information(self) -> Information:
        return Information(self.bench, self.noise)

    def library(self, information: Information, effects: tuple[Effect, ...] = ()) -> WideLibrary:
        library = WideLibrary(information, Session(self.robot, self.text, self.plan.poses))
        for effect in effects:
            library.add_shape_of(effect)
        return library

    def made(self, displacement: np.ndarray, rng, answer: dict, text: str | None = None, mechanism: str | None = None) -> Made:
        readings = self.noise.readings_um(displacement, rng)
        head = {
            "robot": self.robot, "mechanism": self.bench.mechanism, "noise_kind": self.noise_kind, "noise": self.noise.answer(),
            "beam_factors": self.bench.multipliers["beam"], "poses": len(self.plan.poses), "repeats": self.plan.repeats,
            "readings": int(readings.size), "truth": [], "also_right": [],
        }
        return Made(self.bench.table, self.plan, self.noise, readings, text or self.text, mechanism or self.bench.mechanism, {**head, **answer})


def world(rng, noise_kind: str = "assumed", few: bool = False, choice=None, unloading=None, **plan) -> World:
    """`choice` fixes robot and mechanism; a coarse gauge stands at the stiffer arms, where its step is seen."""
    benches = [bench for bench in BENCHES if noise_kind != "coarse" or bench[0] != "hp"]
    robot, mechanism = choice or benches[rng.integers(len(benches))]
    text = robot_text.shipped(robot)
    parsed = robot_text.parsed(text)
    names = POSES[robot]
    if few:
        names = tuple(names[k] for k in sorted(rng.choice(4, 2, replace=False)))
    both = bool(rng.random() < 0.5) if unloading is None else unloading
    plan = Plan(poses=names, unloading=both, repeats=3 if few else 5, **plan)
    start = parsed.data["factors"]["m_fsd"]
    beam = {p: float(f"{start['beam'][p] * np.exp(rng.uniform(np.log(0.55), np.log(1.8))):.5g}") for p in PROPERTIES}
    noise = real_noise.draw(noise_kind, robot, rng)
    bench = RealBench(parsed, mechanism, robot_text.poses_of(parsed, names), beam, start["link"], take(plan, rng))
    return World(robot, noise_kind, bench, plan, noise, text)


def whitened_rest(readings_um: np.ndarray, information: Information, force: np.ndarray | None = None) -> np.ndarray:
    """Readings less the model at the true factors and the recorded forces, whitened, factors projected out."""
    bench: RealBench = information.bench
    recorded = bench.at_forces(bench.table.rounded if force is None else force)
    return information.unabsorbed(information.whitened(1e-6 * readings_um - recorded.displacement([])))


def observed(made: Made, information: Information, library: WideLibrary, rng) -> None:
    observer, rest = Observer(library, rng), whitened_rest(made.readings, information)
    made.answer["observer"] = observer.decide(rest)
    made.answer["observer_left_p"] = observer.left_p(rest)


# Nothing missing, and bad readings


def nothing(kind: str, few: bool):
    def make(index: int, rng) -> list[Made]:
        one = world(rng, kind, few)
        return [one.made(one.bench.displacement([]), rng, {"kind": kind, "expected": "nothing"})]

    return make


def bad(off_um: float, with_effect: bool):
    def make(index: int, rng) -> list[Made]:
        law = LAWS[index % len(LAWS)] if with_effect else None
        one, truths, displacement = _with_effect(law, rng, (6.0, 25.0))
        answer = {"kind": law or "nothing", "expected": "named" if law else "nothing", "truth": truths}
        without = one.made(displacement, rng, answer)
        spoiled, said = bad_reading.spoil(one.bench, one.noise, without.readings, off_um, rng)
        return [replace(without, readings=spoiled, answer={**without.answer, "bad": said}), without]

    return make


def _with_effect(law: str | None, rng, sizes: tuple[float, float], noise_kind: str = "assumed"):
    """A world, its truth, its displacement with one effect of a size between two (evenly in the logarithm)."""
    if law is None:
        one = world(rng, noise_kind)
        return one, [], one.bench.displacement([])
    one = world(rng, noise_kind, **plan_for(law))
    information = one.information()
    size = float(np.exp(rng.uniform(*np.log(sizes))))
    effect = effect_of(law, information, rng, size)
    truths = truths_of(one.library(information, (effect,)), information, [effect])
    return one, truths, one.bench.displacement([effect])


# Effects of the library


def plan_for(law: str) -> dict:
    if law == "creep":
        return {"holds_s": HOLDS}
    return {"temperature": "swing"} if law == "thermal-drift-per-kelvin" else {}


def effect_of(law: str, information: Information, rng, size: float) -> Effect:
    """One effect of the library of a size in standard errors, at a place drawn by chance."""
    if law == "constant-force":
        effect = Effect(law, {"direction": str(rng.choice(list("xyz")))}, {"w": 1.0}, "w")
        found = information.sized(effect, size, float(rng.choice([-1.0, 1.0])) * 1e-4, 20.0)
        if found is None:
            raise NotReachable(law)
        return found
    if law.startswith("joint-"):
        return recipes.joint(law)(information, rng, size)
    if law == "thermal-drift-per-kelvin":
        return recipes.simple("thermal-drift", per_kelvin=True)(information, rng, size)
    return recipes.simple(law)(information, rng, size)


def truths_of(library: WideLibrary, information: Information, effects: list[Effect]) -> list[dict]:
    truths = []
    for k, effect in enumerate(effects):
        others = effects[:k] + effects[k + 1 :]
        change, basis = information.effect(effect, tuple(others)), information.factors
        if others:
            basis = orthonormal(np.hstack([basis, *(information.effect(other)[:, None] for other in others)]))
        target = change - basis @ (basis.T @ change)
        name = title(effect)
        truths.append({
            "name": name, "physics": effect.physics, "place": effect.place,
            "parameters": {p: {"value": v, "unit": _unit(effect, p)} for p, v in effect.parameters.items() if p != "per_kelvin"},
            "standard_errors": round(beside(information, effect, others), 2),
            "near": [other for other in near(library, target, basis) if other["name"] != name],
        })
    return truths


def _unit(effect: Effect, parameter: str) -> str:
    return "N" if parameter == "w" else unit_of(effect, parameter)


def clean_effect(index: int, rng) -> list[Made]:
    law, noise_kind = LAWS[(index // len(NOISES)) % len(LAWS)], NOISES[index % len(NOISES)]
    one, truths, displacement = _with_effect(law, rng, (4.5, 25.0), noise_kind)
    return [one.made(displacement, rng, {"kind": f"{law} on {noise_kind}", "expected": "named", "truth": truths})]


def power(index: int, rng) -> list[Made]:
    law, size = LAWS[index % len(LAWS)], SIZES[(index // len(LAWS)) % len(SIZES)]
    return [_single(law, size, rng)]


def _single(law: str, size: float, rng) -> Made:
    one = world(rng, **plan_for(law))
    information = one.information()
    effect = effect_of(law, information, rng, size)
    library = one.library(information, (effect,))
    made = one.made(one.bench.displacement([effect]), rng,
                    {"kind": law, "size": size, "expected": "named", "truth": truths_of(library, information, [effect])})
    observed(made, information, library, rng)
    return made


def pairs(index: int, rng) -> list[Made]:
    laws = PAIRS[index % len(PAIRS)]
    plan = {key: value for law in laws for key, value in plan_for(law).items()}
    one = world(rng, **plan)
    information = one.information()
    effects = [effect_of(law, information, rng, 12.0) for law in laws]
    if min(beside(information, effects[0], effects[1:]), beside(information, effects[1], effects[:1])) < 8.0:
        raise NotReachable(f"{laws} hide each other")
    library = one.library(information, tuple(effects))
    made = one.made(one.bench.displacement(effects), rng,
                    {"kind": " + ".join(laws), "expected": "named", "truth": truths_of(library, information, effects)})
    observed(made, information, library, rng)
    return [made]


def inseparable(index: int, rng) -> list[Made]:
    """One effect with another name or place within 2 standard errors."""
    law = INSEPARABLE[index % len(INSEPARABLE)]
    one = world(rng)
    information = one.information()
    effect = effect_of(law, information, rng, float(rng.choice([8.0, 12.0, 16.0])))
    library = one.library(information, (effect,))
    truths = truths_of(library, information, [effect])
    rivals = [other for other in truths[0]["near"] if other["standard_errors_left"] < 2.0 and not judge.is_richer(other["name"], truths[0]["name"])]
    if not rivals:
        raise NotReachable(f"{law}: nothing is inseparable from it here")
    made = one.made(one.bench.displacement([effect]), rng, {"kind": law, "expected": "named", "truth": truths})
    observed(made, information, library, rng)
    return [made]


# Set-up


def setup(index: int, rng) -> list[Made]:
    kind = setups.KINDS[index % len(setups.KINDS)]
    one = world(rng)
    wrong = setups.draw(kind, one.robot, one.bench.mechanism, rng)
    if wrong is None:
        raise NotReachable(kind)
    given = robot_text.parsed(wrong.text)
    truth, start = one.bench, given.data["factors"]["m_fsd"]
    model = RealBench(given, wrong.mechanism, robot_text.poses_of(given, one.plan.poses), dict(start["beam"]), start["link"], truth.table)
    wanted = float(np.exp(rng.uniform(np.log(6.5), np.log(25.0))))
    effects, left, size = wrong.effects, None, wrong.size
    if wrong.scale:
        effects, left, size = _sized_setup(wrong, truth, model, start["beam"], one.noise, wanted)
    left = left or setups.misfit(truth, truth.displacement(effects), model, start["beam"], one.noise)
    if left.standard_errors < 6.0:
        raise NotReachable(f"{kind}: {left.standard_errors:.1f} standard errors")
    library = WideLibrary(left.information, Session(one.robot, wrong.text, one.plan.poses))
    others = near(library, left.target, left.information.factors)
    truths = [{"name": wrong.right[0], "names": wrong.right, "size": size, "unit": wrong.unit,
               "standard_errors": round(left.standard_errors, 2), "near": [o for o in others if o["name"] not in wrong.right],
               "left_after": left_after(library, left.target, left.information.factors)}]
    made = one.made(truth.displacement(effects), rng, {"kind": kind, "expected": "setup", "truth": truths, "cells": left.cells},
                    wrong.text, wrong.mechanism)
    observed(made, left.information, library, rng)
    return [made]


def _sized_setup(wrong, truth, model, start: dict, noise, wanted: float):
    """Scale the effect until the refitted model leaves the wanted length; the effect is nearly linear."""
    low, high = wrong.limits
    size = low
    for _ in range(4):
        effects = [effect.scaled(float(np.sign(effect.parameters[wrong.scale])) * float(f"{size:.4g}")) for effect in wrong.effects]
        left = setups.misfit(truth, truth.displacement(effects), model, start, noise)
        if abs(np.log(max(left.standard_errors, 1e-9) / wanted)) < 0.03:
            break
        size = float(np.clip(size * wanted / max(left.standard_errors, 1e-9), low, high))
    return effects, left, effects[0].parameters[wrong.scale]


# Mishaps


def mishap(index: int, rng) -> list[Made]:
    kind = mishaps.KINDS[index % len(mishaps.KINDS)]
    plan = {"holds_s": HOLDS} if kind in mishaps.HOLDS else {}
    one = world(rng, unloading=True if kind in mishaps.UNLOADING else None, **plan)
    information = one.information()
    found = mishaps.sized(kind, information, rng, float(np.exp(rng.uniform(np.log(8.0), np.log(25.0)))))
    if found is None:
        raise NotReachable(kind)
    event, size = found
    change = event.change(size)
    target = information.unabsorbed(information.whitened(change))
    name = mishaps.LIST[kind]["size"]["name"]
    library = one.library(information)
    truths = [{
        "name": kind, "place": event.place, "standard_errors": round(float(np.linalg.norm(target)), 2),
        "parameters": {**event.drawn, name: {"value": size, "unit": mishaps.LIST[kind]["size"]["unit"]}},
        "end_effect_um": round(1e6 * float(np.abs(change).max()), 2),
        "near": near(library, target, information.factors), "left_after": left_after(library, target, information.factors),
    }]
    answer = {"kind": kind, "expected": "mishap", "truth": truths, "also_right": mishaps.also_right(kind, event),
              "cells": setups.cells_of(one.bench, target)}
    made = one.made(one.bench.displacement([]) + change, rng, answer)
    observed(made, information, library, rng)
    return [made]


ROWS = {
    **{f"noise-{kind}": nothing(kind, few=False) for kind in NOISES},
    **{f"noise-{kind}-few": nothing(kind, few=True) for kind in NOISES},
    "bad-300-effect": bad(300.0, True), "bad-60-effect": bad(60.0, True),
    "bad-300-nothing": bad(300.0, False), "bad-60-nothing": bad(60.0, False),
    "clean-effect": clean_effect, "setup": setup, "mishap": mishap, "power": power, "pairs": pairs, "inseparable": inseparable,
}
