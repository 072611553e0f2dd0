"""A wrong robot file or a wrong set-up: the session is given the wrong one, the readings follow the right one."""

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

import robot_text
import shared  # noqa: F401
from candidates import sections_used
from effects import Effect
from information import Information
from real_bench import RealBench
from structures import PROPERTIES

BOUND = np.log(10.0)  # of the free factors about their start, as the diagnosis has it


@dataclass
class WrongSetup:
    """What is wrong, in the words of the contract, and how to get there from what is right."""

    kind: str
    right: list[str]  # names and places that are true, as in `candidates.title`
    size: float
    unit: str
    text: str  # robot file that the session is given
    mechanism: str  # that the session states
    link: dict  # link factors of the truth
    effects: list[Effect] = field(default_factory=list)  # of the truth
    scale: str = ""  # which parameter of the effect may be sized
    limits: tuple[float, float] = (0.0, np.inf)


def draw(kind: str, name: str, mechanism: str, rng: np.random.Generator) -> WrongSetup | None:
    """One wrong set-up on a robot; None where the robot has nothing of the kind."""
    text = robot_text.shipped(name)
    robot = robot_text.parsed(text)
    link = robot.data["factors"]["m_fsd"]["link"]
    sign = float(rng.choice([-1.0, 1.0]))
    plain = dict(text=text, mechanism=mechanism, link=link)
    match kind:
        case "link-length":
            parameter, body = _pick(rng, list(robot_text.LENGTHS[name].items()))
            change = sign * float(rng.choice([0.015, 0.015, 0.015, 0.008, 0.025]))
            value = robot.data["parameters"][parameter] + change
            wrong = robot_text.with_number(text, "parameters", parameter, value)
            return WrongSetup(kind, [f"link-length@{body}"], change, "m", **{**plain, "text": wrong})
        case "joint-offset" | "joint-offset-one-pose":
            variable, (joint, _) = _pick(rng, list(robot_text.ANGLES[name].items()))
            if kind == "joint-offset-one-pose" and not any(variable in pose for pose in robot.data["poses"].values()):
                return None  # the same in every pose, since no pose states it
            change = sign * (1.0 if kind == "joint-offset" else float(rng.choice([1.0, 2.0, 3.0])))
            return WrongSetup(kind, [f"joint-offset@{joint}"], np.radians(change), "rad",
                              **{**plain, "text": _turned(text, name, variable, change, kind, rng)})
        case "section-error":
            section, elements = _pick(rng, list(sections_used(robot, mechanism).items()))
            factor, names = 1.0 + 0.3 * sign, PROPERTIES if rng.random() < 0.75 else (str(rng.choice(["Iy", "Iz"])),)
            wrong = text
            for p in names:
                wrong = robot_text.with_number(wrong, f"sections.{section}", p, factor * robot.data["sections"][section][p])
            return WrongSetup(kind, [f"section-error@{e}" for e in elements], factor - 1.0, "1", **{**plain, "text": wrong})
        case "link-factors":
            if not any(element["class"] == "link" for element in robot.elements(mechanism)):
                return None
            names = PROPERTIES if rng.random() < 0.5 else (str(rng.choice(PROPERTIES)),)
            factor = float(rng.choice([0.4, 0.6, 1.6, 2.5]))
            wrong = robot_text.with_factor(text, "link", {p: v * (factor if p in names else 1.0) for p, v in link.items()})
            return WrongSetup(kind, ["factor-group@link"], factor - 1.0, "1", **{**plain, "text": wrong})
        case "beam-factors":
            beam, p = robot.data["factors"]["m_fsd"]["beam"], str(rng.choice(["Iy", "Iz", "J", "A"]))
            factor = float(rng.choice([0.01, 100.0]))  # cm for mm in a second moment or an area, once
            wrong = robot_text.with_factor(text, "beam", {**beam, p: beam[p] * factor})
            return WrongSetup(kind, ["factor-group@beam"], factor - 1.0, "1", **{**plain, "text": wrong})
        case "wrong-mechanism":
            others = [m for m in robot.data["mechanisms"] if m != mechanism]
            if not others:
                return None
            return WrongSetup(kind, ["wrong-mechanism@*"], 1.0, "1", **{**plain, "mechanism": str(rng.choice(others))})
    return _bench_effect(kind, name, mechanism, rng, plain, sign)


def _bench_effect(kind: str, name: str, mechanism: str, rng, plain: dict, sign: float) -> WrongSetup:
    """Gauges and loads: a right file, and an effect that is sized to what can be seen."""
    directions = [str(d) for d in rng.permutation(list("xyz"))]
    match kind:
        case "gauge-scale-force" | "gauge-scale-displacement":
            gauge = kind.removeprefix("gauge-scale-")
            effect = Effect("gauge-scale", {"gauge": gauge}, {"scale": sign}, "scale")
            return WrongSetup(kind, [f"gauge-scale@{gauge}"], 0.0, "1", **plain, effects=[effect], scale="scale", limits=(0.01, 0.3))
        case "lean-of-force" | "lean-of-gauge":
            physics = "load-misalignment" if kind == "lean-of-force" else "gauge-misalignment"
            a, b = [("y", "z"), ("z", "y")][rng.integers(2)]
            effect = Effect(physics, {"direction": a, "toward": b}, {"angle": sign}, "angle")
            return WrongSetup(kind, [f"{physics}@{a}>{b}"], 0.0, "rad", **plain, effects=[effect], scale="angle", limits=(0.003, 0.052))
        case "hook-weight":
            effect = Effect("constant-force", {"direction": "y"}, {"w": -1.0}, "w")
            return WrongSetup(kind, ["constant-force@y"], 0.0, "N", **plain, effects=[effect], scale="w", limits=(0.02, 20.0))
        case "preload":
            effect = Effect("constant-force", {"direction": directions[0]}, {"w": sign}, "w")
            return WrongSetup(kind, [f"constant-force@{directions[0]}"], 0.0, "N", **plain, effects=[effect], scale="w", limits=(0.02, 20.0))
    raise ValueError(kind)


KINDS = ("link-length", "joint-offset", "section-error", "link-factors", "gauge-scale-force", "lean-of-force", "hook-weight",
         "link-length", "joint-offset-one-pose", "section-error", "beam-factors", "gauge-scale-displacement", "lean-of-gauge",
         "preload", "wrong-mechanism")


def _pick(rng, items: list):
    return items[rng.integers(len(items))]


def _turned(text: str, name: str, variable: str, degrees: float, kind: str, rng) -> str:
    """The file with a variable turned in every pose, or in one."""
    robot = robot_text.parsed(text)
    poses = [pose for pose, values in robot.data["poses"].items() if variable in values]
    if not poses:
        nominal = robot.data["variables"][variable]["nominal"]
        if isinstance(nominal, str):
            return robot_text.with_number(text, "parameters", nominal, robot.data["parameters"][nominal] + degrees)
        return robot_text.with_number(text, f"variables.{variable}", "nominal", nominal + degrees)
    if kind == "joint-offset-one-pose":
        poses = [_pick(rng, poses[:4])]
    for pose in poses:
        text = robot_text.with_number(text, f"poses.{pose}", variable, robot.data["poses"][pose][variable] + degrees)
    return text


@dataclass
class Misfit:
    """What the best model with the wrong set-up leaves of the readings that the right one gives."""

    information: Information  # at the best factors of the wrong model
    target: np.ndarray  # whitened difference, free factors projected out
    standard_errors: float
    cells: list[dict]  # standard errors per pose and direction


def misfit(truth: RealBench, clean: np.ndarray, wrong: RealBench, start: dict, noise) -> Misfit:
    """Fit the wrong model to the right displacements, factors within their bounds, by Gauss-Newton with the true weights."""
    whiten = Information(truth, noise).whiten

    def at(logs: np.ndarray) -> RealBench:
        return wrong.with_beam({p: float(start[p] * np.exp(v)) for p, v in zip(PROPERTIES, logs)})

    def rest(logs: np.ndarray) -> np.ndarray:
        return whiten((at(logs).mechanics([]) - clean).ravel())

    def slopes(logs: np.ndarray) -> np.ndarray:
        return whiten(at(logs).factor_columns)

    inside = np.clip([np.log(truth.multipliers["beam"][p] / start[p]) for p in PROPERTIES], -0.999 * BOUND, 0.999 * BOUND)
    found = least_squares(rest, inside, slopes, bounds=(-BOUND, BOUND), max_nfev=8, x_scale=0.1)
    best = at(found.x)
    information = Information(best, noise)
    target = information.unabsorbed(information.whitened(clean - information.clean))
    held = rest(found.x)  # factors at a bound take nothing more: what is left is all there
    at_bound = np.any(np.abs(found.x) > 0.998 * BOUND)
    left = -held if at_bound else target
    return Misfit(information, left, float(np.linalg.norm(left)), cells_of(truth, left))


def cells_of(bench: RealBench, vector: np.ndarray) -> list[dict]:
    """Length of a whitened vector in each cell, largest first."""
    table, squares = bench.table, np.sum(vector.reshape(bench.shape) ** 2, axis=1)
    cells = []
    for pose in range(len(bench.poses)):
        for direction in range(3):
            here = (table.pose[:, 0] == pose) & (table.direction[:, 0] == direction)
            if here.any():
                size = float(np.sqrt(squares[here].sum()))
                cells.append({"pose": table.names[pose], "direction": "xyz"[direction], "standard_errors": round(size, 2)})
    return sorted(cells, key=lambda cell: -cell["standard_errors"])
