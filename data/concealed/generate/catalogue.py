"""Which benches there are: modes of concealment, robots, plans, noise and wanted sizes."""

from dataclasses import dataclass, field
from typing import Callable

import recipes
from noise import Noise
from plan import Plan

# An effect is found in 80 % of the benches at 3.5 standard errors and named at 4.5: "the 80 % size".
UNIT = 4.5
LADDER = (0.0, 0.5, 1.0, 2.0, 4.0)

SHIPPED, OWN = "../../../robots/", "../../robots/"
ROBOTS = {
    "hp": SHIPPED + "hp-robot.toml", "serial": SHIPPED + "serial-arm.toml",
    "hp+": OWN + "hp-robot-more-poses.toml", "serial+": OWN + "serial-arm-more-poses.toml",
    "stacker": OWN + "stacker-arm.toml",
}
FOUR = ("P1", "P2", "P3", "P4")
POSES = {
    "hp": FOUR, "serial": FOUR, "hp+": (*FOUR, "N1", "N2"), "serial+": (*FOUR, "N1"),
    "stacker": ("near", "far", "high", "low", "middle"),
}


@dataclass
class Entry:
    """One bench to make."""

    mode: str
    robot: str
    mechanism: str
    draws: list[Callable] = field(default_factory=list)
    sizes: list[float] = field(default_factory=list)  # standard errors
    step: float | None = None  # on the ladder of sizes, in units of the 80 % size
    poses: tuple[str, ...] = ()
    plan: dict = field(default_factory=dict)
    noise: dict = field(default_factory=dict)


def ladder(mode: str, benches: list[tuple[str, str]], draws: list, plan: dict, steps=LADDER, **more) -> list[Entry]:
    entries = []
    for k, step in enumerate(steps):
        robot, mechanism = benches[k % len(benches)]
        entries.append(Entry(mode, robot, mechanism, draws if step else [], [UNIT * step] * len(draws), step, plan=plan, **more))
    return entries


HELD = {"holds_s": (60.0, 120.0)}
UP = {"unloading": False}


def modes() -> list[Entry]:
    r = recipes
    serials = [("serial+", "A"), ("stacker", "bare")]
    loops = [("hp+", "F"), ("stacker", "full"), ("hp", "B"), ("stacker", "full"), ("hp", "D")]
    entries = ladder("a", [("hp+", "A"), ("stacker", "full"), ("hp+", "A"), ("serial+", "A"), ("hp+", "F")],
                     [r.joint("joint-compliance", absorbed_from=0.7)], {})
    entries += ladder("b", loops, [r.simple("setting-in", decay=0.3)], {})
    entries += ladder("b", [("serial", "A"), ("hp", "A"), ("stacker", "driven")],
                      [r.simple("thermal-drift", per_kelvin=True)], {"temperature": "tent"}, steps=(0.5, 2.0, 4.0))
    entries += ladder("c", [("hp+", "A"), ("stacker", "full"), ("hp+", "B"), ("stacker", "full"), ("hp+", "F")],
                      [r.only_elsewhere()], {})
    entries += ladder("d", [*serials, ("hp", "B"), ("hp", "A"), ("stacker", "full")], [r.simple("gauge-periodic")], {},
                      noise={"sigma": 6.0, "res_um": 10.0})
    entries += ladder("e", [("hp+", "A")], [r.joint("joint-compliance", only=("A4",)), r.simple("thermal-drift")], {})
    entries += ladder("f", [("stacker", "full"), ("serial+", "A"), ("stacker", "bare"), ("hp+", "B"), ("hp+", "A")],
                      [r.outside("joint-plasticity")], {})
    for physics, benches in (
        ("quadratic-drift", [("hp", "A"), ("serial", "A")]), ("load-dependent-creep", [("stacker", "full"), ("hp", "F")]),
        ("joint-asymmetric-cubic", [("stacker", "bare"), ("serial+", "A")]),
        ("gauge-two-harmonics", [("hp", "D"), ("stacker", "driven")]),
    ):
        entries += ladder("f", benches, [r.outside(physics)], HELD if "creep" in physics else {},
                          steps=(1.0, 2.0) if "cubic" in physics else (2.0, 4.0))
    entries += ladder("h", [("serial+", "A"), ("stacker", "driven"), ("hp", "D"), ("stacker", "full"), ("hp+", "B")],
                      [r.outside("brace")], {})
    return entries + pairs() + wrong_noise() + nothing()


def pairs() -> list[Entry]:
    r, twelve = recipes, [12.0, 12.0]
    return [
        Entry("e", "stacker", "full", [r.joint("joint-compliance"), r.simple("thermal-drift")], twelve),
        Entry("e", "serial+", "A", [r.simple("creep"), r.simple("gauge-periodic")], twelve, plan=HELD),
        Entry("e", "hp+", "A", [r.joint("joint-backlash", only=("A4",)), r.joint("joint-friction", only=("A3",))], twelve),
        Entry("e", "stacker", "full", [r.simple("base-compliance"), r.simple("gauge-stand-compliance")], twelve),
        Entry("e", "hp+", "B", [r.joint("joint-backlash", inner=True), r.simple("setting-in", sign=-1.0)], twelve),
        Entry("e", "serial", "A", [r.simple("force-gauge-nonlinearity", sign=1.0), r.joint("joint-friction")], twelve),
        Entry("e", "hp+", "F", [r.joint("joint-friction", inner=True), r.simple("creep")], twelve, plan=HELD),
        Entry("e", "hp", "D", [r.simple("slip"), r.simple("thermal-drift", sign=-1.0)], twelve),
    ]


def wrong_noise() -> list[Entry]:
    strong = [(5.0, 0.005), (10.0, 0.01), (20.0, 0.02), (40.0, 0.04), (60.0, 0.002)]
    benches = [("hp", "F"), ("serial", "A"), ("stacker", "full"), ("hp+", "A"), ("hp", "B")]
    plans = [{}, UP, {}, HELD, UP]
    return [
        Entry("i", robot, mechanism, plan=plan, noise={"sigma0": zero, "slope": slope})
        for (robot, mechanism), plan, (zero, slope) in zip(benches, plans, strong)
    ]


def nothing() -> list[Entry]:
    coarse, gamma, lognormal = {"res_um": 10.0}, {"shape": "gamma"}, {"shape": "lognormal"}
    few, strong = {"repeats": 3}, {"sigma": 6.0, "sigma0": 5.0, "slope": 0.005}
    one = ("P2",)
    return [
        Entry("g", "hp", "F"), Entry("g", "hp+", "A", noise=gamma), Entry("g", "serial", "A", plan=UP),
        Entry("g", "stacker", "full"), Entry("g", "stacker", "driven", plan=HELD, noise=lognormal),
        Entry("g", "hp", "B", plan=few), Entry("g", "hp", "D", plan=HELD), Entry("g", "hp", "F", plan=UP, noise=coarse),
        Entry("g", "serial+", "A", noise={**gamma, **strong}), Entry("g", "hp", "A", poses=one),
        Entry("g", "serial", "A", poses=one, plan=HELD), Entry("g", "stacker", "bare", plan=few, noise=coarse),
        Entry("g", "stacker", "full", poses=("far",), noise=gamma), Entry("g", "hp+", "E", noise=strong),
        Entry("g", "hp+", "F", poses=("P1", "P3", "N3", "N4"), noise=lognormal),
        Entry("g", "serial+", "A", poses=("P1", "P2", "P3", "P4", "N2", "N3"), plan=UP),
    ]


def laws() -> list[Entry]:
    """Every law at 6 and at 12 standard errors; joint laws again in closed loops."""
    r = recipes
    yaw = ("near", "far", "high", "low", "turned")
    single = [
        (r.joint("joint-compliance"), [("stacker", "bare", {}), ("hp+", "A", {})]),
        (r.joint("joint-backlash"), [("serial+", "A", {}), ("hp+", "A", UP)]),
        (r.joint("joint-friction"), [("hp+", "A", {}), ("serial+", "A", {})]),
        (r.joint("joint-nonlinearity"), [("hp+", "A", {}), ("serial", "A", UP)]),
        (r.simple("base-compliance"), [("stacker", "full", {}), ("serial+", "A", {})]),
        (r.simple("gauge-stand-compliance"), [("hp+", "A", {}), ("stacker", "driven", {})]),
        (r.simple("load-misalignment"), [("serial+", "A", {}), ("stacker", "full", {})]),
        (r.simple("force-gauge-nonlinearity"), [("stacker", "full", UP), ("hp", "A", {})]),
        (r.simple("creep"), [("hp", "B", HELD), ("stacker", "full", HELD)]),
        (r.simple("thermal-drift"), [("hp", "D", UP), ("stacker", "bare", {})]),
        (r.simple("thermal-drift", per_kelvin=True), [("hp", "F", {"temperature": "swing"}), ("stacker", "full", {"temperature": "swing"})]),
        (r.simple("setting-in"), [("hp", "A", UP), ("stacker", "driven", {})]),
        (r.simple("slip"), [("serial", "A", {}), ("hp", "F", UP)]),
        (r.simple("gauge-periodic"), [("hp", "A", UP), ("stacker", "full", {})]),
    ]
    entries = [
        Entry("law", robot, mechanism, [draw], [size], plan=plan)
        for draw, benches in single
        for size, (robot, mechanism, plan) in zip((6.0, 12.0), benches)
    ]
    inner = [
        ("joint-compliance", [("hp+", "B", {}), ("hp", "D", HELD)]), ("joint-backlash", [("stacker", "full", {}), ("hp+", "F", {})]),
        ("joint-friction", [("hp+", "D", {}), ("stacker", "full", {})]), ("joint-nonlinearity", [("hp+", "F", {}), ("hp+", "B", {})]),
    ]
    entries += [
        Entry("law", robot, mechanism, [r.joint(physics, inner=True)], [size], plan=plan)
        for physics, benches in inner
        for size, (robot, mechanism, plan) in zip((6.0, 12.0), benches)
    ]
    # A lost member has no size: quiet benches where its loss is small, and a loud one.
    quiet, loud = {"sigma": 0.6, "sigma0": 1.0, "slope": 0.0008}, {"sigma": 6.0, "sigma0": 6.0, "slope": 0.01}
    entries.append(Entry("law", "hp", "F", [r.loose()], [6.0], noise=quiet))
    entries.append(Entry("law", "hp+", "C", [r.loose()], [12.0], noise=quiet))
    entries.append(Entry("law", "stacker", "full", [r.loose()], [20.0], noise=loud, plan={**UP, "repeats": 3}))
    entries.append(Entry("law", "stacker", "full", [r.joint("joint-compliance", inner=True)], [12.0], poses=yaw))
    entries.append(Entry("law", "serial+", "A", [r.simple("load-misalignment", pairs=(("x", "z"), ("x", "y")))], [12.0],
                         poses=("P1", "P2", "P4", "N1", "N3")))
    return entries


def all_entries() -> list[Entry]:
    return modes() + laws()


def plan_of(entry: Entry) -> Plan:
    return Plan(poses=entry.poses or POSES[entry.robot], **entry.plan)


def noise_of(entry: Entry, rng) -> Noise:
    """Moderate noise by chance, less on the stiffer arms, then what the entry fixes."""
    scale = 1.0 if entry.robot.startswith("hp") else 0.6
    drawn = {
        "sigma": round(scale * float(rng.uniform(0.9, 2.2)), 2), "sigma0": round(scale * float(rng.uniform(1.2, 3.0)), 2),
        "slope": round(float(rng.uniform(0.0012, 0.003)), 4),
    }
    return Noise(**{**drawn, **entry.noise})
